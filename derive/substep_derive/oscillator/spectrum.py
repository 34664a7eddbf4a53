"""Amplification -> its live eigenvalues, those that are not 0 at every Omega, and their limits as Omega -> oo."""

from collections.abc import Sequence
from functools import cache
from typing import Any

from sympy import Abs, Expr, Integer, Max, Piecewise, Poly, Rational, Symbol, expand, factor_list, oo, radsimp, sqrt

from ..algebra.algebraic import Field, closed_form, generator
from ..algebra.expanded import coefficients
from ..declare.errors import InconsistentScheme
from ..declare.symbols import Omega, lam
from .amplification import Amplification, in_lambda
from .evaluation import Evaluation

CLOSE = Rational(1, 10**25)  # how near to 1 the modulus of a root is, with 40 digits, where it is 1


@cache
def live(charpoly: Poly) -> Poly:
    """The characteristic polynomial in lambda without the roots that are 0 at every Omega."""
    return in_lambda(charpoly).terms_gcd()[1]


def live_at(evaluation: Evaluation, damping: Any) -> list[dict[int, Any]]:
    """The polynomial of `live` with numbers for parameters and xi: a row, power of Omega -> number, for each lambda^j.

    Rows run from the lowest to the highest power of lambda whose row is not empty; there are none where all vanish.
    """
    p = in_lambda(evaluation.amplification.charpoly)
    rows = [
        {power: c for (power, _), c in evaluation.coefficients(e, damping).items()} for e in reversed(p.all_coeffs())
    ]
    kept = [j for j, row in enumerate(rows) if row]
    return rows[kept[0] : kept[-1] + 1] if kept else []


def limit_polynomial(amplification: Amplification) -> Poly:
    """The polynomial in lambda whose roots are the live eigenvalues as Omega -> oo."""
    p = live(amplification.charpoly)
    return Poly(coefficients(p.as_expr().expand(), Omega)[0], lam)


def rho_infinity(amplification: Amplification) -> Expr:
    """The spectral radius as Omega -> oo, in closed form; oo for an explicit scheme.

    Raises ValueError if a factor of degree above two in lambda is left with free parameters.
    """
    leading = limit_polynomial(amplification)
    if leading.degree() < live(amplification.charpoly).degree():
        return oo
    moduli: list[Expr] = []
    for base, _ in factor_list(leading.as_expr(), lam)[1]:
        part = Poly(base, lam)
        if part.degree() > 2 and leading.free_symbols != {lam}:
            free = sorted(str(symbol) for symbol in leading.free_symbols - {lam})
            raise ValueError(
                f"expected rho_inf in closed form, got the largest modulus of the {part.degree()} roots of "
                f"{part.as_expr()} = 0 with {', '.join(free)} free; give values as in derive(..., {free[0]}=...), or "
                "take the number from substep.scheme(...).rho_inf"
            )
        moduli += _moduli(part.all_coeffs()) if part.degree() < 3 else [Abs(root) for root in part.all_roots()]
    return Max(*moduli) if moduli else Integer(0)


def _moduli(coefficients: Sequence[Expr]) -> list[Expr]:
    """The largest modulus of the roots of a polynomial up to degree two (highest power first); none for a constant."""
    if len(coefficients) == 1:
        return []
    if len(coefficients) == 2:
        a, b = coefficients
        return [Abs(b / a)]
    a, b, c = coefficients
    disc = expand(b**2 - 4 * a * c)
    return [Piecewise((sqrt(c / a), disc < 0), ((Abs(b) + sqrt(disc)) / Abs(2 * a), True))]


def rho_infinity_at(evaluation: Evaluation) -> Expr:
    """The exact spectral radius as Omega -> oo at a parameter set, undamped; oo for an explicit scheme."""
    field, rows = evaluation.field, live_at(evaluation, evaluation.field.domain.zero)
    assert isinstance(field, Field)
    highest = max(power for row in rows for power in row)
    leading = [row.get(highest, field.domain.zero) for row in rows]
    if not leading[-1]:
        return oo
    while not leading[0]:
        leading = leading[1:]
    found = moduli(Poly.from_list(leading[::-1], Symbol("x"), domain=field.domain), field)
    return Max(*(modulus for *_, modulus in found)) if found else Integer(0)


def require_convergent(evaluation: Evaluation) -> None:
    """Raises InconsistentScheme where an eigenvalue tends to one beyond the unit circle as the step tends to 0.

    All that is wrong with a state then grows by that factor in each step, the more the more steps there are.
    """
    field, rows = evaluation.field, live_at(evaluation, evaluation.field.domain.zero)
    assert isinstance(field, Field)
    lowest = min(power for row in rows for power in row)
    at_zero = Poly.from_list([row.get(lowest, field.domain.zero) for row in rows[::-1]], lam, domain=field.domain)
    beyond = [modulus for *_, modulus in moduli(at_zero, field) if modulus.n(40) - 1 > CLOSE]
    if at_zero.degree() < len(rows) - 1 or beyond:
        size = f"one of modulus {float(max(beyond)):.6g}" if beyond else "one without bound"
        raise InconsistentScheme(
            f"{evaluation.scheme.name} does not converge: expected eigenvalues that tend to the unit circle or into it "
            f"as the step tends to 0, got {size}, by which errors grow in each step; take other coefficients"
        )


def on_circle(polynomial: Poly) -> Poly:
    """The factor with the roots on the unit circle, of a polynomial without roots beyond it.

    These are the roots that it shares with the polynomial of their reciprocals.
    """
    return polynomial.gcd(Poly.from_list(polynomial.rep.to_list()[::-1], polynomial.gen, domain=polynomial.domain))


def moduli(polynomial: Poly, field: Field) -> list[tuple[Poly, int, Expr]]:
    """Each factor of a polynomial over the field, its multiplicity, and the largest modulus of its roots, exact."""
    number = closed_form(field.root, Omega) if field.root is not None else Integer(0)
    found = list[tuple[Poly, int, Expr]]()
    for part, times in polynomial.factor_list()[1]:
        if part.degree() < 3:
            coefficients = [field.expression(field.domain.convert(c)) for c in part.rep.to_list()]
            own = _moduli([radsimp(c.subs(generator, number)) for c in coefficients])
        else:
            own = [Abs(root) for root in _roots(part, field)]
        found.append((part, times, Max(*own)))
    return found


def _roots(polynomial: Poly, field: Field) -> list[Expr]:
    """Exact roots of a polynomial over K: the roots of its norm over Q that are nearest to its numerical roots."""
    if not field.algebraic:
        return polynomial.all_roots()
    candidates = polynomial.norm().all_roots()
    number = closed_form(field.root, Omega).n(60)
    exact = [field.expression(field.domain.convert(c)).subs(generator, number).n(60) for c in polynomial.rep.to_list()]
    found = Poly(exact, polynomial.gen).nroots(n=40, maxsteps=200)
    return [min(candidates, key=lambda candidate, z=z: abs(candidate.n(40) - z)) for z in found]
