"""Scheme -> Estimator: estimated local errors of a step from its second value, or from its accelerations.

Without a second value: the scheme is of second order, its balances stand at instants of their own, and a force that
depends on time alone drives it. Its local errors of u and v are then c h^3 times the third and the fourth derivative,
which differences of the accelerations at those instants give.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from sympy import Expr, Integer, Matrix, Rational, Symbol, factorial, linsolve, symbols

from ..declare.catalogue import find
from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import f, h, knot


class NoEstimator(DeclarationError):
    """A scheme, or values of its parameters, without an estimate of the local error; the message says why."""


@dataclass(frozen=True)
class Estimator:
    """u, v: estimated local errors (numerical - exact) of a step; order: p of u and v, the errors are O(h^(p+1))."""

    scheme: Scheme
    u: Expr
    v: Expr
    order: tuple[int, int]
    extra: Mapping[Symbol, str] | None = None


def estimator(scheme: str | Scheme, **parameters: object) -> Estimator:
    """The estimator of a scheme, with the parameters given fixed. Raises NoEstimator."""
    declared = find(scheme)
    declared = declared.fix(parameters) if parameters else declared
    u1, v1, _ = knot(1)
    if declared.embedded:
        u, v = (declared.report.get(s, s) - declared.embedded.get(s, s) for s in (u1, v1))
        p = _embedded_order(declared)
        return Estimator(declared, u, v if v1 in declared.embedded else Integer(0), (p, p))
    at = _instants(declared)
    known = {k: tau for k, tau in at.items() if tau is not None}
    zero = dict.fromkeys(range(3), Integer(0))
    found = []
    for own in (0, 1):
        error = _motion(declared, at, 3 + own)[own]
        weights = _weights(list(known.values()), 1 + own, error) if error != 0 else None
        found.append(
            sum((w * s for w, s in zip(weights, known, strict=True)), zero[0]) * h ** (2 - own) if weights else zero[0]
        )
    if found[0] == 0 or any(e.expand() != 0 for n in (1, 2) for e in _motion(declared, at, n)):
        raise NoEstimator(
            f"{declared.name}: no combination of the accelerations that a step holds equals its local error of u"
        )
    return Estimator(declared, *found, (2, 2))


def _embedded_order(scheme: Scheme) -> int:
    """The lower order of the two values: the first power of t whose motion they tell apart, less one."""
    at = _instants(scheme)
    u1, v1, _ = knot(1)
    for n in range(1, 12):
        values = _solved(scheme, at, n)
        for s in (u1, v1):
            e = scheme.embedded.get(s)
            if e is not None and (e - scheme.report.get(s, s)).subs(values).expand() != 0:
                return n - 1 - (0 if s == u1 else 1)
    raise NoEstimator(f"{scheme.name}: its second value is the first one; expected one of another order")


def _instants(scheme: Scheme) -> dict[Symbol, Expr]:
    found: dict[Symbol, Expr] = {}
    if knot(0).a in scheme.state:
        found[knot(0).a] = Integer(0)
    for b in scheme.balances:
        loads = b.load.atoms(f)
        if not b.inertia.is_Symbol or len(loads) != 1 or b.load not in loads:
            raise NoEstimator(f"{scheme.name}: expected balances at one instant each, got {b.inertia} = {b.load}")
        found[b.inertia] = next(iter(loads)).args[0]
    return found


def _solved(scheme: Scheme, at: Mapping[Symbol, Expr], n: int) -> dict[Symbol, Expr]:
    """Values of all symbols for the motion t^n/n!, whose force depends on time."""
    known = {s: (tau * h) ** (n - 2) / factorial(n - 2) if n > 1 else Integer(0) for s, tau in at.items()}
    known = {s: e.subs({h: h}) if n > 2 else (Integer(1) if n == 2 else Integer(0)) for s, e in known.items()}
    known |= {knot(0).u: Integer(0), knot(0).v: Integer(1 if n == 1 else 0)}
    unknown = [s for s in scheme.unknowns if s not in known]
    equations = [(s - e).subs(known) for s, e in scheme.relations.items()]
    (solution,) = linsolve(equations, unknown)
    return {**known, **dict(zip(unknown, solution, strict=True))}


def _motion(scheme: Scheme, at: Mapping[Symbol, Expr], n: int) -> tuple[Expr, Expr]:
    """Local errors of u and v for the motion t^n/n!, over the power of h that each has."""
    values = _solved(scheme, at, n)
    u1, v1, _ = knot(1)
    u, v = (scheme.report.get(s, s).subs(values) for s in (u1, v1))
    return (
        ((u - h**n / factorial(n)) / h**n).factor(),
        ((v - h ** (n - 1) / factorial(n - 1)) / h ** (n - 1)).factor(),
    )


def _weights(taus: list[Expr], degree: int, error: Expr) -> list[Expr] | None:
    """Weights of values at taus whose sum is error times the derivative of that degree, exact for lower degrees."""
    names = symbols(f"w:{len(taus)}")
    rows = [
        sum((w * (tau**j if j else 1) for w, tau in zip(names, taus, strict=True)), Integer(0))
        - (error * factorial(degree) * Rational(1) if j == degree else 0)
        for j in range(degree + 1)
    ]
    solutions = list(linsolve([Matrix([r])[0] for r in rows], names))
    if not solutions:
        return None
    return [e.subs(dict.fromkeys(names, 0)).factor() for e in solutions[0]]
