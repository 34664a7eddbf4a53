"""Functions that potentials are written with, and their divided differences.

A divided difference (g(x1) - g(x0))/(x1 - x0) is derived so that x1 - x0 cancels: for polynomials,
powers, roots, sin, cos. For any other function of one argument it becomes a `Difference`, whose
printed form uses the quotient for distant arguments and a Taylor series for near ones.
"""

from itertools import permutations
from math import factorial
from typing import Any

from sympy import Add, Dummy, Expr, Function, Integer, Mul, Pow, Rational, S, Symbol, cos, cosh, factor, log, sin, tanh

NEAR = Rational(1, 8)  # arguments no further apart take the Taylor series
TAYLOR_TERMS = 6  # its remainder there is below 1e-16 for log cosh: (NEAR/pi)^12


class negative_part(Function):
    """min(x, 0): the penetration of a unilateral contact."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """1 in contact, 0 outside."""
        return is_negative(self.args[0])


class is_negative(Function):
    """1 for x < 0, else 0."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """0: the jump at x = 0 is left to Newton's iteration."""
        return S.Zero

    def _eval_power(self, expt: Expr) -> Expr | None:
        return self if expt.is_positive else None


class log_cosh(Function):
    """log(cosh(x)), which does not overflow with cosh."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """Its derivative."""
        return tanh(self.args[0])


class sinc(Function):
    """sin(x)/x."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """Its derivative, (cos(x) - sinc(x))/x."""
        return sinc_slope(self.args[0])


class sinc_slope(Function):
    """The derivative of sin(x)/x."""

    nargs = 1


class Difference(Function):
    """(g(x1) - g(x0))/(x1 - x0) for a function class g: Difference(Symbol(g's name), x0, x1)."""

    nargs = 3

    def fdiff(self, argindex: Any = 1) -> Expr:
        """By x1, or by x0, in which it is symmetric."""
        g, x0, x1 = self.args
        return DifferenceSlope(g, x0, x1) if argindex == 3 else DifferenceSlope(g, x1, x0)


class DifferenceSlope(Function):
    """Derivative of `Difference` by x1."""

    nargs = 3


def tidy(potential: Expr) -> Expr:
    """log(cosh(x)) as one function, so that it neither overflows nor loses digits."""
    return potential.replace(
        lambda e: isinstance(e, log) and isinstance(e.args[0], cosh), lambda e: log_cosh(e.args[0].args[0])
    )


def contact(expression: Expr) -> Expr:
    """min(x, 0) * [x < 0] is min(x, 0)."""
    products = {e * is_negative(e.args[0]): e for e in expression.atoms(negative_part)}
    return expression.replace(
        lambda e: e.is_Mul and any(set(p.args) <= set(e.args) for p in products),
        lambda e: Mul(*(x for x in e.args if not (isinstance(x, is_negative) and negative_part(x.args[0]) in e.args))),
    )


def divided_difference(g: Expr, x: Symbol, x0: Expr, x1: Expr) -> Expr:
    """(g(x1) - g(x0))/(x1 - x0) with x1 - x0 cancelled where g's form allows it."""

    def at(e: Expr) -> tuple[Expr, Expr]:
        return e.subs(x, x0), e.subs(x, x1)

    if not g.has(x) or g == x:
        return Integer(int(g == x))
    if isinstance(g, Add):
        return Add(*(divided_difference(e, x, x0, x1) for e in g.args))
    if isinstance(g, Mul):
        head, tail = g.args[0], Mul(*g.args[1:])
        (h0, h1), (t0, t1) = at(head), at(tail)
        first, second = divided_difference(head, x, x0, x1), divided_difference(tail, x, x0, x1)
        return first * (t0 + t1) / 2 + second * (h0 + h1) / 2
    inner = g.args[0]
    slope = divided_difference(inner, x, x0, x1)
    if isinstance(g, Pow) and isinstance(g.exp, Rational):
        return _of_power(g.exp, slope, *at(inner))
    if not isinstance(g, Function) or len(g.args) != 1:
        raise ValueError(
            f"expected a potential of sums, products, rational powers and functions of one argument, got {g}; "
            "write it with those"
        )
    i0, i1 = at(inner)
    mean, change = (i0 + i1) / 2, (i1 - i0) / 2
    if isinstance(g, sin | cos):
        return slope * (cos(mean) if isinstance(g, sin) else -sin(mean)) * sinc(change)
    return slope * Difference(Symbol(type(g).__name__), i0, i1)


def _of_power(exponent: Rational, slope: Expr, b0: Expr, b1: Expr) -> Expr:
    """b^(p/q): with r = b^(1/q), (r1^p - r0^p)/(r1 - r0) over (r1^q - r0^q)/(r1 - r0)."""
    p, q = exponent.p, exponent.q
    r0, r1 = b0 ** Rational(1, q), b1 ** Rational(1, q)

    def ratio(n: int) -> Expr:
        return Add(*(r1**i * r0 ** (n - 1 - i) for i in range(n)))

    found = slope * ratio(abs(p)) / ratio(q)
    return found if p > 0 else -found / (r0 ** abs(p) * r1 ** abs(p))


def discrete_slopes(potential: Expr, old: dict[Symbol, Expr], new: dict[Symbol, Expr]) -> dict[Symbol, Expr]:
    """For each invariant q the factor D_q of V(new) - V(old) = sum of D_q (q_new - q_old).

    Each q is moved alone, the others at their old or new value; the mean over all orders of moving.
    """
    total = dict.fromkeys(old, Integer(0))
    orders = list(permutations(old))
    for order in orders:
        values = dict(old)
        for q in order:
            mark = Dummy()
            others = {k: value for k, value in values.items() if k != q}
            g = potential.subs(q, mark).subs(others, simultaneous=True)
            total[q] += divided_difference(g, mark, old[q], new[q])
            values[q] = new[q]
    return {q: e / len(orders) for q, e in total.items()}


def near_series(g: type[Function]) -> tuple[Expr, Expr, Expr, Symbol]:
    """Taylor series of g's divided difference, of its slope by x1, and the former's last term; the mean m.

    In m and the difference d. The last term tells whether the series has converged: near a singularity of g
    arguments no further apart than NEAR may still be too far.
    """
    m, d = Symbol("m"), Symbol("d")
    derivatives = [g(m)]
    for _ in range(2 * TAYLOR_TERMS):
        derivatives.append(factor(derivatives[-1].diff(m)))
    # Difference(m, d) = sum of g^(2k+1)(m) (d/2)^(2k)/(2k+1)!; by x1, half of d/dm plus d/dd
    series = Add(*(derivatives[2 * k + 1] * (d / 2) ** (2 * k) / factorial(2 * k + 1) for k in range(TAYLOR_TERMS)))
    slope = Add(
        *(
            derivatives[2 * k + 2] * (d / 2) ** (2 * k) / (2 * factorial(2 * k + 1))
            + k * derivatives[2 * k + 1] * (d / 2) ** (2 * k - 1) / factorial(2 * k + 1)
            for k in range(TAYLOR_TERMS)
        )
    )
    last = derivatives[2 * TAYLOR_TERMS - 1] * (d / 2) ** (2 * TAYLOR_TERMS - 2) / factorial(2 * TAYLOR_TERMS - 1)
    return series, slope, last, m
