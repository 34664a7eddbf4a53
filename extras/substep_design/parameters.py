"""Exact parameters of a declared scheme from requirements: order, high-frequency dissipation, least period error.

The requirements are equations and inequalities that other modules derive; here they are only solved.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from substep_derive.algebra.exact_number import exact_number
from substep_derive.declare.errors import DeclarationError
from substep_derive.declare.scheme import Scheme
from substep_derive.declare.symbols import Omega, lam, xi
from substep_derive.oscillator.spectrum import live
from substep_derive.study.derivation import derive
from substep_derive.study.equivalence import solutions
from sympy import (
    Expr,
    Integer,
    Poly,
    Rational,
    Symbol,
    cancel,
    factor,
    fraction,
    radsimp,
    real_roots,
    simplify,
    sqrt,
    together,
)

# a required spectral radius as Omega -> oo that is left open; "real" keeps it distinct from a parameter named rho
rho = Symbol("rho", real=True)
SAMPLES = (Rational(1, 3), Rational(2, 3), Rational(9, 10))  # numbers at which results for an open rho are checked


@dataclass(frozen=True)
class Design:
    """One set of parameters. values: name -> exact expression; wish: the requirements that they meet, in words."""

    scheme: str
    values: Mapping[str, Expr]
    wish: str

    @property
    def text(self) -> str:
        """The scheme, the requirements and the values in one line."""
        found = ", ".join(f"{name} = {value}" for name, value in self.values.items())
        return f"{self.scheme} with {self.wish}: {found}"


def limit(scheme: str | Scheme) -> Poly:
    """The characteristic polynomial in lambda as Omega -> oo.

    Raises DeclarationError for a scheme with an eigenvalue that goes to oo.
    """
    derivation = derive(scheme)
    p = live(derivation.charpoly)
    leading = Poly(Poly(p.as_expr(), Omega).LC(), lam)
    if leading.degree() < p.degree():
        raise DeclarationError(f"{derivation.scheme.name}: an eigenvalue goes to infinity with Omega")
    return leading


def order_equations(scheme: Scheme, order: int) -> list[Expr]:
    """Polynomials in the parameters, all zero for free vibration of that order (up to 3), at every damping ratio."""
    series = derive(scheme).series
    terms = [cancel(e * sqrt(1 - xi**2)) for k, e in series.numerical_damping.items() if k < order]
    terms += [e for k, e in series.period_error.items() if k < order]
    return [c for e in terms for c in Poly(fraction(together(e))[0], xi).coeffs()]


def parameters(scheme: str | Scheme, rho_inf: Any = None, order: int = 2) -> tuple[Design, ...]:
    """Parameters that give this order and this spectral radius as Omega -> oo, a number or left open as rho.

    Solutions with all eigenvalues equal to -rho there come first: they have the least low-frequency dissipation for
    that at high frequency (Chung & Hulbert 1993). Where there are none, one eigenvalue is rho or -rho and none is
    larger. Each solution is checked against the closed form of rho_inf, an open rho at some numbers. Empty if none.

    Raises DeclarationError for an unknown scheme or one with an eigenvalue that goes to oo, TypeError for a float.
    """
    declared = derive(scheme).scheme
    wished = rho if rho_inf is None else exact_number(rho_inf)
    p = limit(declared)
    given = order_equations(declared, order)
    all_equal = (p - Poly(p.LC() * (lam + wished) ** p.degree(), lam)).all_coeffs()
    wishes = [("all eigenvalues", all_equal), ("an eigenvalue", [p.eval(-wished) * p.eval(wished)])]
    for words, equations in wishes:
        found = []
        for values in solutions([*given, *equations], declared.values):
            kept = {s: factor(values.get(s, s)) for s in declared.values}
            if _has_radius(declared, kept, wished):
                text = f"order {order}, rho_inf = {wished} ({words} of that modulus)"
                one = Design(declared.name, {s.name: e for s, e in kept.items()}, text)
                found += [one] if one not in found else []
        if found:
            return tuple(found)
    return ()


def _has_radius(scheme: Scheme, values: Mapping[Symbol, Expr], wished: Expr) -> bool:
    """Whether rho_inf is the required one, at some number at least for each symbol that is left free."""
    radii = SAMPLES if wished == rho else (wished,)
    for number in radii:
        middle = {p.symbol: p.inside(Rational(1, 2)) for p in scheme.parameters}
        typical = {s: e if e.is_Rational else middle[s] for s, e in scheme.typical.items()}
        free = {s: e for s, e in typical.items() if values[s] == s}
        exact = {s: e.subs({rho: number, **free}) for s, e in values.items()}
        inside = all(e.is_Rational and e in p.domain for p, e in zip(scheme.parameters, exact.values(), strict=True))
        if inside and derive(scheme.fix({s.name: e for s, e in exact.items()})).rho_inf == number:
            return True
    return False


@dataclass(frozen=True)
class Least:
    """Where the constant of the period error, (T - T_exact)/T_exact = constant*Omega^2 + ..., is least in size."""

    scheme: str
    parameter: str
    value: Expr
    constant: Expr


def least_period_error(scheme: str | Scheme, **parameters: Any) -> Least:
    """The value of the only free parameter for which the undamped constant is least, in radicals or as a CRootOf.

    Raises ValueError unless exactly one parameter is left free, or if the least is not taken inside its interval.
    """
    declared = derive(scheme, **parameters).scheme
    if len(declared.parameters) != 1:
        raise ValueError(f"{declared.name}: leave one parameter free, not {[p.name for p in declared.parameters]}")
    (parameter,) = declared.parameters
    x = parameter.symbol
    constant = factor(derive(declared).series.period_error.get(2, Integer(0)).subs(xi, 0))
    candidates: list[Any] = []
    for e in (constant, constant.diff(x)):  # zeros first, then where it is stationary
        candidates += [r for r in real_roots(Poly(fraction(together(e))[0], x)) if r in parameter.domain] if e else []
    finite = [r for r in candidates if fraction(constant)[1].subs(x, r) != 0]
    if not finite:
        raise ValueError(f"{declared.name}: |{constant}| has no least value in {parameter.domain}")
    best = min(finite, key=lambda r: abs(constant.subs(x, r)).n(30))
    return Least(declared.name, x.name, best, radsimp(simplify(constant.subs(x, best))))
