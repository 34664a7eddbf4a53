"""Functions that potentials and laws are written with."""

from collections.abc import Iterable
from typing import Any

from sympy import Expr, Function, Matrix, Mul, Piecewise, S, Symbol, cosh, log, tanh

from .branches import sign_of, where_at_least


class negative_part(Function):
    """min(x, 0): the penetration of a unilateral contact."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative: 1 where x < 0, in contact, and 0 elsewhere."""
        return is_negative(self.args[0])


class is_negative(Function):
    """1 for x < 0, else 0."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative, taken as 0: Newton's iteration copes with the jump at x = 0."""
        return S.Zero

    def _eval_power(self, expt: Expr) -> Expr | None:
        return self if expt.is_positive else None


class log_cosh(Function):
    """log(cosh(x)) as one function, finite where cosh(x) overflows."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative, tanh(x)."""
        return tanh(self.args[0])


class sinc(Function):
    """sin(x)/x."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative, (cos(x) - sinc(x))/x."""
        return sinc_slope(self.args[0])


class sinc_slope(Function):
    """The derivative of sin(x)/x."""

    nargs = 1


class signed_power(Function):
    """|x|**a with the sign of x: a force of a damper."""

    nargs = 2

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative by x."""
        return self.args[1] * abs_power(self.args[0], self.args[1] - 1)


class abs_power(Function):
    """|x|**a, finite at 0."""

    nargs = 2


JUMPS = sign_of, where_at_least, is_negative, Piecewise  # whose derivatives say nothing of how they jump


def may_jump(e: Expr | Matrix, symbols: Iterable[Symbol]) -> bool:
    """Whether it may jump where any of the symbols changes, which its derivatives by them do not say."""
    return any(jump.free_symbols & {*symbols} for jump in e.atoms(*JUMPS))


def tidy(potential: Expr) -> Expr:
    """The potential with log(cosh(x)) as one function, which neither overflows nor loses digits."""
    return potential.replace(
        lambda e: isinstance(e, log) and isinstance(e.args[0], cosh), lambda e: log_cosh(e.args[0].args[0])
    )


def contact(expression: Expr) -> Expr:
    """The expression with each product of min(x, 0) and is_negative(x) replaced by min(x, 0), which it equals."""
    products = {e * is_negative(e.args[0]): e for e in expression.atoms(negative_part)}
    return expression.replace(
        lambda e: e.is_Mul and any(set(p.args) <= set(e.args) for p in products),
        lambda e: Mul(*(x for x in e.args if not (isinstance(x, is_negative) and negative_part(x.args[0]) in e.args))),
    )
