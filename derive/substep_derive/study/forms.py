"""Scheme -> what decides its properties at any parameters: closed forms and conditions as text of Python.

The functions take values that are `Fraction`, at which they are exact, or floats.
"""

from typing import Any

from sympy import Expr, Poly, factor_list, fraction, latex, together
from sympy.core.relational import Relational
from sympy.logic.boolalg import And, Boolean, Not, Or

from ..declare.scheme import Scheme
from ..declare.symbols import lam
from ..emit.printing import Code, literal_tuple
from ..oscillator.evaluation import Evaluation
from ..oscillator.order import order_conditions
from ..oscillator.spectrum import limit_polynomial, live
from ..stability.any_damping import stable_at_any_damping
from ..stability.conditions import conditions
from ..stability.paper import PRINTER, as_in_paper
from .derivation import derive, order_at


def forms(scheme: Scheme) -> dict[str, Any]:
    """limit_text, limit_latex, limit, stable, A_stable, order and second_order of a scheme with parameters.

    limit_text, limit_latex: rho_inf as a paper writes it, empty where it has no closed form. limit: function to the
    factors of the polynomial in lambda of the eigenvalues as Omega -> oo, each its coefficients from the highest; None
    for an explicit scheme. stable: function that tells whether it is stable for every Omega > 0, undamped; None where
    Omega could not be eliminated. A_stable: function that tells whether what suffices for stability at every Omega > 0
    and every damping ratio holds; None where nothing is known to. order: of u, v and a at almost all parameters;
    second_order: function to what vanishes where each is of second order, nothing where it is not of first order only.
    """
    d = derive(scheme)
    at_defaults, almost_always = order_at(Evaluation.at_defaults(scheme)), d.order
    vanish: dict[str, tuple[Expr, ...]] = {}
    if any(own > general == 1 for own, general in zip(at_defaults, almost_always, strict=True)):
        vanish = order_conditions(scheme)
    try:
        rho_inf = as_in_paper(d.rho_inf, scheme)
    except ValueError:
        rho_inf = None
    try:
        found = conditions(scheme)
        stable = And(*found.inequalities) if found.eliminated else None
    except NotImplementedError:
        stable = None
    A_stable, limit = stable_at_any_damping(scheme), _limit(scheme)
    second = literal_tuple(literal_tuple(map(str, vanish.get(name, ()))) for name in "uva")
    return {
        "limit_text": "" if rho_inf is None else PRINTER.doprint(rho_inf),
        "limit_latex": "" if rho_inf is None else latex(rho_inf),
        "limit": None if limit is None else _function(scheme, literal_tuple(map(literal_tuple, limit))),
        "stable": None if stable is None else _function(scheme, _decision(stable)),
        "A_stable": None if A_stable is None else _function(scheme, _decision(A_stable)),
        "order": almost_always,
        "second_order": _function(scheme, second),
    }


def _function(scheme: Scheme, body: str) -> Code:
    return Code(f"lambda {', '.join(p.name for p in scheme.parameters)}: {body}")


def _limit(scheme: Scheme) -> tuple[tuple[str, ...], ...] | None:
    """Coefficients, polynomials in the parameters, of the factors of `limit_polynomial`; None if its degree drops."""
    amplification = derive(scheme).amplification
    leading = limit_polynomial(amplification)
    if leading.degree() < live(amplification.charpoly).degree():
        return None
    factors = [Poly(base, lam) for base, _ in factor_list(leading.as_expr())[1]]
    return tuple(tuple(str(c) for c in p.all_coeffs()) for p in factors)


def _decision(condition: Boolean) -> str:
    """A condition as text of Python whose numbers are whole, so that it is exact at values that are `Fraction`."""
    if isinstance(condition, And | Or):
        word = " and " if isinstance(condition, And) else " or "
        return "(" + word.join(_decision(part) for part in condition.args) + ")"
    if isinstance(condition, Not):
        return f"(not {_decision(condition.args[0])})"
    if not isinstance(condition, Relational):
        return str(bool(condition))
    numerator, denominator = fraction(together(condition.lhs - condition.rhs))
    sign = 1 if denominator > 0 else -1
    return f"{numerator * sign} {condition.rel_op} 0"
