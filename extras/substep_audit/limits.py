"""How far a stepper is stable, and its spectral radius as the step grows: as measured, and of the scheme that it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from substep.core.schemes import Scheme

from .free_motion import Roots, measured_roots, scheme_roots
from .measured_stability import confirmed_radius, critical_Omega, long_radius, measured_radius, same_limit
from .noise import Noise
from .stepper import Stepper

LARGE = 1e4  # Omega for which the spectral radius is its limit, but for 1/Omega
EXACT, LONGER = 1e-12, 0.02  # by how much a computed spectral radius of 1, or one from long runs, may exceed 1


@dataclass(frozen=True)
class Limits:
    """The largest stable Omega: None where it is stable up to LARGE, NaN where runs fail that would tell.

    critical: the best that is known of it, with rho_inf and the eigenvalues `roots`: of the scheme that was identified
    for sure, whose kernels are right for multiple eigenvalues too; else what was measured. measured: found by bisection
    of runs; by_scheme: of the scheme, to as few digits. measured_rho_inf: the spectral radius at LARGE.
    """

    rho_inf: float
    critical: float | None
    roots: Roots
    measured_rho_inf: float
    measured: float | None
    by_scheme: float | None

    @classmethod
    def of(cls, stepper: Stepper, scheme: Scheme | None, sure: bool, noise: Noise) -> Limits:
        """Those of a stepper. scheme: the one identified, None where there is none; sure: whether it is that one."""
        radius = measured_radius(stepper, noise)
        growing, margin = (long_radius(stepper), LONGER) if noise.loud else (radius, noise.margin)
        measured = critical_Omega(growing, margin)
        by_scheme = critical_Omega(scheme.spectral_radius, margin) if scheme else None
        if not noise.loud and not same_limit(measured, by_scheme, noise):
            measured = critical_Omega(confirmed_radius(radius, long_radius(stepper)), margin)
        at_large = float(radius(np.array([LARGE]))[0])
        if scheme is None or not sure:
            return cls(at_large, measured, measured_roots(stepper, noise), at_large, measured, by_scheme)
        exact = scheme.rho_inf  # None or NaN where it has no closed form at these parameters
        return cls(
            at_large if exact is None or np.isnan(exact) else float(exact),
            critical_Omega(scheme.spectral_radius, EXACT),
            scheme_roots(scheme.amplification),
            at_large, measured, by_scheme,
        )  # fmt: skip
