"""The declarations under test, and random exact parameters for them."""

from fractions import Fraction

import numpy as np
from substep_derive import Scheme
from substep_derive.schemes import ALL, alpha, explicit, multi_step, one_step
from sympy import Rational

# declared, and run through the pencil here; their emission comes with the catalogue
PENCIL_ONLY = (
    one_step.wilson_theta,
    one_step.energy_momentum,
    multi_step.houbolt,
    multi_step.park,
    explicit.rk4,
    explicit.noh_bathe,
    alpha.generalized_alpha,
    alpha.kr_alpha_plain_start,
)
EVERY = (*ALL, *PENCIL_ONLY)
BY_NAME = {scheme.name: scheme for scheme in EVERY}


def random_parameters(scheme: Scheme, rng: np.random.Generator) -> dict[str, Rational]:
    """Exact values inside each parameter's interval, at most 2 from its finite end."""
    values = {}
    for parameter in scheme.parameters:
        low = Fraction(str(parameter.domain.start))
        high = Fraction(str(parameter.domain.end)) if parameter.domain.end.is_finite else low + 2
        share = Fraction(int(rng.integers(1, 100)), 100)
        value = low + share * (high - low)
        values[parameter.name] = Rational(value.numerator, value.denominator)
    return values
