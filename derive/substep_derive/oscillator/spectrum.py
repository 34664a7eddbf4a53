"""Amplification -> its eigenvalues that are not always 0, and their limit as Omega -> oo."""

from sympy import Abs, Expr, Integer, Max, Piecewise, Poly, factor_list, oo, sqrt

from ..declare.symbols import Omega, lam, mu
from .amplification import Amplification


def live(charpoly: Poly) -> Poly:
    """The characteristic polynomial in lambda without its roots at 0."""
    p = Poly(charpoly.as_expr().subs(mu, lam - 1), lam)
    while p.eval(0) == 0:
        p = p.quo(Poly(lam, lam))
    return p


def limit_polynomial(amplification: Amplification) -> Poly:
    """The polynomial in lambda whose roots are the live eigenvalues as Omega -> oo."""
    p = live(amplification.charpoly)
    return Poly(Poly(p.as_expr(), Omega).LC(), lam)


def rho_infinity(amplification: Amplification) -> Expr:
    """The spectral radius as Omega -> oo, in closed form; oo for an explicit scheme.

    Raises NotImplementedError if a factor of degree above two in lambda is left with free parameters.
    """
    p = live(amplification.charpoly)
    leading = limit_polynomial(amplification)
    if leading.degree() < p.degree():
        return oo
    moduli: list[Expr] = []
    for base, _ in factor_list(leading.as_expr(), lam)[1]:
        part = Poly(base, lam)
        if part.degree() == 1:
            a, b = part.all_coeffs()
            moduli.append(Abs(b / a))
        elif part.degree() == 2:
            a, b, c = part.all_coeffs()
            disc = b**2 - 4 * a * c
            moduli.append(Piecewise((sqrt(c / a), disc < 0), ((Abs(b) + sqrt(disc)) / Abs(2 * a), True)))
        elif part.degree() > 2:
            if leading.free_symbols != {lam}:
                raise NotImplementedError(f"rho_inf of a factor of degree {part.degree()}: give the parameters values")
            moduli += [Abs(root) for root in part.all_roots()]
    return Max(*moduli) if moduli else Integer(0)
