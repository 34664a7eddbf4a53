"""Functions of real arguments that have branches, and derivatives by branch: for Max, Min, Abs, sign and Piecewise."""

from functools import reduce
from typing import Any

from sympy import Abs, Expr, Function, Integer, Max, Min, S, ordered, sign


class larger(Function):
    """The larger of two arguments: SymPy's Max without its simplification, which takes long."""

    nargs = 2

    def _eval_derivative(self, s: Any) -> Expr:
        """By branch: where both are equal, the derivative of the first."""
        x, y = self.args
        return where_at_least(x, y, x.diff(s), y.diff(s))

    def _latex(self, printer: Any) -> str:
        return rf"\max\left({', '.join(map(printer.doprint, self.args))}\right)"


class smaller(Function):
    """The smaller of two arguments."""

    nargs = 2

    def _eval_derivative(self, s: Any) -> Expr:
        """By branch: where both are equal, the derivative of the first."""
        x, y = self.args
        return where_at_least(y, x, x.diff(s), y.diff(s))

    def _latex(self, printer: Any) -> str:
        return rf"\min\left({', '.join(map(printer.doprint, self.args))}\right)"


class where_at_least(Function):
    """Of arguments a, b, x, y: x where a >= b, else y."""

    nargs = 4

    def _eval_derivative(self, s: Any) -> Expr:
        """By branch: what decides adds nothing."""
        a, b, x, y = self.args
        return where_at_least(a, b, x.diff(s), y.diff(s))

    def _latex(self, printer: Any) -> str:
        a, b, x, y = map(printer.doprint, self.args)
        return rf"\begin{{cases}} {x} & {a} \geq {b} \\ {y} & \text{{else}} \end{{cases}}"


def clip(x: Any, low: Any, high: Any) -> Expr:
    """x where it lies between low and high, else the nearer of the two."""
    return larger(low, smaller(high, x))


class absolute(Function):
    """|x| of a real x: SymPy's Abs, whose derivatives are those of complex numbers."""

    nargs = 1

    @classmethod
    def eval(cls, x: Any) -> Expr | None:
        """Of a number."""
        return Abs(x) if x.is_number else None

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative, the sign of x."""
        return sign_of(self.args[0])

    def _eval_power(self, expt: Expr) -> Expr | None:
        return self.args[0] ** expt if expt.is_even else None

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        text = rf"\left|{printer.doprint(self.args[0])}\right|"
        return text if exp is None else rf"{text}^{{{exp}}}"


class sign_of(Function):
    """The sign of a real x, 0 at 0: SymPy's sign, of which a derivative has an impulse."""

    nargs = 1

    @classmethod
    def eval(cls, x: Any) -> Expr | None:
        """Of a number."""
        return sign(x) if x.is_number else None

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative, taken as 0: Newton's iteration copes with the jump at x = 0."""
        return S.Zero

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        text = rf"\operatorname{{sign}}\left({printer.doprint(self.args[0])}\right)"
        return text if exp is None else rf"{text}^{{{exp}}}"


def by_branch(expression: Expr) -> Expr:
    """The expression with functions of real arguments whose derivatives are by branch, for Abs, sign, Max and Min."""
    if not expression.has(Abs, sign, Max, Min):
        return expression
    return unevaluated(expression.replace(Abs, absolute).replace(sign, sign_of))


def unevaluated(expression: Expr) -> Expr:
    """The expression with `larger` and `smaller` in place of Max and Min."""
    if not expression.has(Max, Min):
        return expression
    args = [unevaluated(x) for x in expression.args]
    if isinstance(expression, Max | Min):
        return reduce(larger if isinstance(expression, Max) else smaller, ordered(args))
    return expression.func(*args)


def slope(expression: Expr, symbol: Expr) -> Expr:
    """The derivative by a symbol; 0 by a number, which stands where a vector has no component to move."""
    return expression.diff(symbol) if symbol in expression.free_symbols else Integer(0)
