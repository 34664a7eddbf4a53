"""Divided differences of potentials, from which discrete gradients are formed.

A divided difference (g(x1) - g(x0))/(x1 - x0) is derived so that x1 - x0 cancels: for polynomials, powers, roots, sin,
cos, and by branch for Max, Min and Abs. For any other function of one argument the result is a `Difference`, whose
printed form uses the quotient for distant arguments and a Taylor series for near ones.
"""

from itertools import permutations
from typing import Any

from sympy import Add, Dummy, Expr, Function, Integer, Mul, Pow, Rational, Symbol, cos, sin

from ..declare.branches import absolute, larger, smaller, where_at_least
from ..declare.errors import DeclarationError
from ..declare.potentials import sinc


class Difference(Function):
    """(g(x1) - g(x0))/(x1 - x0) for a function class g: Difference(Symbol(g's name), x0, x1)."""

    nargs = 3

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative by x1, or by x0; the quotient is symmetric in both."""
        g, x0, x1 = self.args
        return DifferenceSlope(g, x0, x1) if argindex == 3 else DifferenceSlope(g, x1, x0)


class DifferenceSlope(Function):
    """Derivative of `Difference` by x1."""

    nargs = 3


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
    if isinstance(g, larger | smaller):
        a, b = g.args
        above = a - b if isinstance(g, larger) else b - a
        first, second = divided_difference(a, x, x0, x1), divided_difference(b, x, x0, x1)
        return second + (1 + _of_absolute(*at(above))) / 2 * (first - second)
    inner = g.args[0]
    outer = _of_function(g, x, *at(inner))
    return divided_difference(inner, x, x0, x1) * outer


def _of_function(g: Expr, x: Symbol, i0: Expr, i1: Expr) -> Expr:
    """(g1 - g0)/(i1 - i0) of a function of one argument i, or of a rational power of it."""
    if isinstance(g, absolute):
        return _of_absolute(i0, i1)
    if isinstance(g, Pow) and isinstance(g.exp, Rational):
        return _of_power(g.exp, i0, i1)
    if not isinstance(g, Function) or len(g.args) != 1:
        raise DeclarationError(
            "expected a potential of sums, products, rational powers, Max, Min and functions of one argument, of which "
            f"discrete gradients are formed, got {g.subs(x, Symbol(x.name))}; write it with those, or take another "
            "scheme"
        )
    mean, change = (i0 + i1) / 2, (i1 - i0) / 2
    if isinstance(g, sin | cos):
        return (cos(mean) if isinstance(g, sin) else -sin(mean)) * sinc(change)
    return Difference(Symbol(type(g).__name__), i0, i1)


def _of_absolute(d0: Expr, d1: Expr) -> Expr:
    """(|d1| - |d0|)/(d1 - d0), which is 1 where both are positive, -1 where both are negative, and else between."""
    alike = where_at_least(d0 + d1, Integer(0), Integer(1), Integer(-1))
    return where_at_least(d0 * d1, Integer(0), alike, (d0 + d1) / (absolute(d0) + absolute(d1)))


def _of_power(exponent: Rational, b0: Expr, b1: Expr) -> Expr:
    """For b^(p/q), with r = b^(1/q): (r1^p - r0^p)/(r1 - r0) over (r1^q - r0^q)/(r1 - r0)."""
    p, q = exponent.p, exponent.q
    r0, r1 = b0 ** Rational(1, q), b1 ** Rational(1, q)

    def ratio(n: int) -> Expr:
        return Add(*(r1**i * r0 ** (n - 1 - i) for i in range(n)))

    found = ratio(abs(p)) / ratio(q)
    return found if p > 0 else -found / (r0 ** abs(p) * r1 ** abs(p))


def discrete_slopes(potential: Expr, old: dict[Symbol, Expr], new: dict[Symbol, Expr]) -> dict[Symbol, Expr]:
    """For each invariant q the factor D_q of V(new) - V(old) = sum of D_q (q_new - q_old).

    The invariants change one after another, each with the others at their old or new value; the result is the mean
    over all orders in which they can change.
    """
    total = dict.fromkeys(old, Integer(0))
    orders = list(permutations(old))
    for order in orders:
        values = dict(old)
        for q in order:
            mark = Dummy(q.name)
            others = {k: value for k, value in values.items() if k != q}
            g = potential.subs(q, mark).subs(others, simultaneous=True)
            total[q] += divided_difference(g, mark, old[q], new[q])
            values[q] = new[q]
    return {q: e / len(orders) for q, e in total.items()}
