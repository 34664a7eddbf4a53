"""Live eigenvalues -> the stability polynomial of a scheme that integrates the first-order system of u and v.

A linear multistep or Runge-Kutta method for y' = s y, of step length 1, has the polynomial pi(lambda; s), which for a
multistep method is rho(lambda) - s sigma(lambda) (Hairer & Wanner, Solving Ordinary Differential Equations II, V.1).
Used on u' = v, v' = a, it gives the oscillator the eigenvalues of pi at s_1 and of pi at s_2, the roots of s^2 + 2 xi
Omega s + Omega^2. So the polynomial of the live eigenvalues is a product of two of half its degree, which below
critical damping are each other's conjugate.
"""

from sympy import Dummy, Expr, Integer, Poly, Symbol, cancel, factor_list, prod

from ..declare.symbols import Omega, lam, xi

rate = Symbol("s")  # eigenvalue of the oscillator times the step length
_other = Dummy("other_s")


def stability_polynomial(live: Poly) -> Poly | None:
    """pi in lambda, its coefficients polynomials in `rate`, with live = pi(rate) pi(other) but for a constant factor.

    The constant is free of lambda. None if live is no such product over the rational numbers.
    """
    symmetric = _in_rates(live)
    if symmetric is None:
        return None
    half: list[Expr] = []
    for factor, power in factor_list(symmetric)[1]:
        if factor.has(lam) and not factor.has(rate) and not factor.has(_other):
            half.append(factor ** (power // 2))
        elif factor.has(rate) and not factor.has(_other):
            half.append(factor**power)
    found = prod(half, start=Integer(1))
    rest = cancel(symmetric / (found * found.subs(rate, _other)))
    return None if rest.has(lam) else Poly(found, lam)


def _in_rates(live: Poly) -> Expr | None:
    """The polynomial with Omega^2 = rate*other and 2*xi*Omega = -(rate + other); None if it has other powers."""
    total: Expr = Integer(0)
    for (j, a, b), coefficient in Poly(live.as_expr(), lam, Omega, xi).terms():
        if a < b or (a - b) % 2:
            return None
        total += coefficient * lam**j * (rate * _other) ** ((a - b) // 2) * (-(rate + _other) / 2) ** b
    return total.expand()
