"""Functions that laws are written with, beside those of potentials."""

from typing import Any

from sympy import Expr, Function, S


class phi_1(Function):
    """(1 - exp(-x))/x, 1 at 0: the mean of exp(-s) for s from 0 to x."""

    nargs = 1

    @classmethod
    def eval(cls, x: Any) -> Expr | None:
        """Its value at 0."""
        return S.One if x == 0 else None


class phi_2(Function):
    """(1 - phi_1(x))/x, 1/2 at 0."""

    nargs = 1

    @classmethod
    def eval(cls, x: Any) -> Expr | None:
        """Its value at 0."""
        return S.Half if x == 0 else None


class bouc_wen(Function):
    """z after the change x of the elongation from z, both over the yield elongation: the law's integral along the path.

    Arguments x, z, A, beta, gamma, n: dz/dx = A - (beta sign(z dx) + gamma) |z|^n.
    """

    nargs = 6

    @classmethod
    def eval(cls, *args: Any) -> Expr | None:
        """Without a change it is z."""
        return args[1] if args[0] == 0 else None

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative by the change of the elongation."""
        return bouc_wen_slope(self, *self.args[:1], *self.args[2:])


class bouc_wen_slope(Function):
    """dz/dx at z in the direction of the change x; arguments z, x, A, beta, gamma, n."""

    nargs = 6


class bouc_wen_work(Function):
    """The integral of z over the change x of the elongation, with the arguments of `bouc_wen`."""

    nargs = 6
