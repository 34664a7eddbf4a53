"""Random exact parameters for the declarations under test, and the oracle's name and numbers for them."""

from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from oracle import entry, sample_parameters
from substep_derive import Derivation, Scheme, derive
from substep_derive.declare.parameter import Root
from substep_derive.declare.schemes import declared
from substep_derive.declare.symbols import K0, C, M, N, N_discrete, knot, knot_of
from substep_derive.package import SCHEMES_ON_FIRST_USE
from substep_kernels.index import SCHEMES as INDEX
from sympy import Integer, Poly, Rational, Symbol, real_roots


def _reads(scheme: Scheme, *matrices: Symbol) -> bool:
    """Whether a relation or a balance has one of these in it."""
    balances = (e for b in scheme.balances for e in (b.inertia, b.damping, b.force))
    return any(e.has(*matrices) for e in (*scheme.relations.values(), *balances))


def _starts_with(scheme: Scheme, *matrices: Symbol) -> bool:
    """Whether the state at t = 0 is found with one of these."""
    return isinstance(scheme.start, dict) and any(e.has(*matrices) for e in scheme.start.values())


def explicit(scheme: Scheme) -> bool:
    """Whether the force of each balance is at displacements that are known before its acceleration is.

    They become known by relations in what is known, and by the new acceleration of each balance in turn.
    """
    unknown = set(scheme.unknowns)

    def known(e: Any) -> bool:
        return not e.free_symbols & unknown

    for b in scheme.balances:
        for _ in scheme.relations:  # as one may need another
            unknown -= {s for s, e in scheme.relations.items() if known(e)}
        if not all(map(known, b.force.atoms(N, N_discrete))):
            return False
        unknown -= b.inertia.free_symbols
    return True


def mixes_otherwise(scheme: Scheme) -> bool:
    """Whether a balance takes the force at several knots, and the velocities of these with other weights."""
    for b in scheme.balances:
        weights = {force.args[0]: b.force.coeff(force) for force in b.force.expand().atoms(N)}
        velocities = {knot((knot_of(u) or ("", ""))[1]).v: w for u, w in weights.items() if u.is_Symbol}
        if len(weights) > 1 and (sum((w * v for v, w in velocities.items()), Integer(0)) - b.damping).expand() != 0:
            return True
    return False


ALL = tuple(declared())
BY_NAME = {scheme.name: scheme for scheme in ALL}
NAMES = tuple(BY_NAME)
OWN = {name: s for name, s in BY_NAME.items() if s.parent is None}  # schemes with a module of their own
TOGETHER = tuple(name for name in NAMES if INDEX[name].get("together"))  # deriving it takes 10 s
ONE_BY_ONE = tuple(s for name, s in BY_NAME.items() if name not in TOGETHER)
COMMITTED = tuple(name for name in OWN if name not in SCHEMES_ON_FIRST_USE)
# whose step takes the stiffness at its start, and which takes that, M or C as matrices, there or in the first step
OF_STIFFNESS = tuple(name for name, s in BY_NAME.items() if _reads(s, K0))
OF_MATRICES = tuple(name for name, s in BY_NAME.items() if _reads(s, K0, M, C) or _starts_with(s, M, C))
UNDAMPED = tuple(name for name, s in BY_NAME.items() if not s.takes_damping)  # schemes for u'' = g(t, u)

# schemes that share another's linear step
_SAME = {
    "kr_alpha_plain_start": "kr_alpha",
    "hht_alpha_mixed_displacement": "hht_alpha",
    "generalized_alpha_mixed_displacement": "generalized_alpha",
}


@cache
def derived(name: str) -> Derivation:
    """The derivation of a scheme, made once per session."""
    return derive(name)


def near(scheme: Scheme) -> dict[Symbol, Rational]:
    """The value of the scheme's constant, if it has one, to 40 digits: the root of its equation in its interval."""
    if scheme.constant is None:
        return {}
    number = scheme.constant.number
    (root,) = [r for r in real_roots(number.polynomial) if number.interval[0] <= r <= number.interval[1]]
    return {scheme.constant: Rational(str(root.n(40)))}


def random_parameters(scheme: Scheme, rng: np.random.Generator) -> dict[str, Rational]:
    """Exact values inside each parameter's interval, at most 2 from its finite end.

    A parameter that is given implicitly takes its default for the others, to 30 digits.
    """
    values: dict[str, Rational] = {}
    for parameter in scheme.parameters:
        if isinstance(parameter.default, Root):
            known = {p.symbol: values[p.name] for p in scheme.parameters if p.name in values}
            equation = Poly(parameter.default.equation.subs(known), parameter.symbol)
            inside = [r for r in real_roots(equation) if parameter.domain.contains(r)]
            values[parameter.name] = Rational(str(inside[0].n(30)))
            continue
        low = Fraction(str(parameter.domain.start))
        high = Fraction(str(parameter.domain.end)) if parameter.domain.end.is_finite else low + 2
        value = low + Fraction(int(rng.integers(1, 100)), 100) * (high - low)
        values[parameter.name] = Rational(value.numerator, value.denominator)
    return values


def for_oracle(scheme: Scheme, values: dict[str, Rational]) -> tuple[str, dict[str, Rational]]:
    """The oracle's name for the scheme, and the parameters it wants."""
    name = _SAME.get(scheme.name, scheme.name)
    everything = {**scheme.fixed, **values}
    members = {"average_acceleration", "linear_acceleration", "fox_goodwin"}
    if name in members:
        return "newmark", everything
    if name == "central_difference":
        return name, {}
    if name == "generalized_alpha":
        return "generalized_alpha", everything
    wanted = entry(name).parameters  # it solves for the others itself
    return name, {key: value for key, value in values.items() if key in wanted}


def parameter_sets(name: str, count: int) -> Iterator[tuple[dict[str, Fraction], Fraction]]:
    """Exact parameters, unstable ones among them, each with a damping ratio."""
    scheme, rng = BY_NAME[name], np.random.default_rng(sorted(BY_NAME).index(name))
    domains = {p.name: p.domain for p in scheme.parameters}
    dampings = [Fraction(0), Fraction(0), Fraction(1, 50), Fraction(3, 10), Fraction(1), Fraction(7, 4)]
    other = for_oracle(scheme, {p.name: scheme.typical[p.symbol] for p in scheme.parameters})[0]
    for k in range(count if scheme.parameters else len(dampings) - 1):
        drawn = sample_parameters(other, rng).items() if scheme.parameters else ()
        values = {key: Fraction(value).limit_denominator(100) for key, value in drawn}
        if all(domains[key].contains(Rational(value)) for key, value in values.items()):
            damping = dampings[k % len(dampings) if values else k + 1]
            yield values, damping if scheme.takes_damping else Fraction(0)
