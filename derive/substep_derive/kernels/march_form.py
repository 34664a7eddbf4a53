"""Amplification -> MarchForm: the smallest state that a linear march has to carry.

Where the last balance is the equation of motion at the end of a step, it gives the acceleration from u, h*v and the
load, so that the march need not carry it: h^2 a_n = c_n - 2 xi Omega h v_n - Omega^2 u_n with c_n = h^2 f(t_n). The
acceleration given at the start need not satisfy the equation of motion; c_0 is then not h^2 f(0), but the value with
which this formula returns the given acceleration.
"""

from dataclasses import dataclass

from sympy import Expr, Integer, Matrix, Symbol, eye, zeros

from ..algebra import rational
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, knot, xi
from ..oscillator.amplification import Affine, Amplification
from .march_shape import Shape


@dataclass(frozen=True)
class MarchForm:
    """x1 = x0 + D x0 + B h^2 f and outputs y1 = O x0 + P h^2 f; numerators of D, B, and of O, P share a denominator.

    kept: which entries of the scheme's state make up x. carrier: whether the acceleration was eliminated, so that the
    first load is c_n. stencil: instants of the load. in_state: places of u, h*v, h^2*a of the new step in x, -1 for one
    that is not in x but the next of the outputs.
    """

    amplification: Amplification
    kept: tuple[int, ...]
    carrier: bool
    stencil: tuple[Expr, ...]
    step: Affine
    outputs: Affine
    in_state: tuple[int, int, int]

    @classmethod
    def of(cls, amplification: Amplification) -> "MarchForm":
        """The march of the scheme; its acceleration is eliminated where that is possible, and the state is reported."""
        a = amplification
        everything = tuple(range(len(a.scheme.state)))
        if a.scheme.state != knot(0) or a.in_state != (0, 1, 2) or not _balanced_at_the_end(a):
            return cls(a, everything, False, a.stencil, a.step, a.outputs, a.in_state)
        without = Matrix([[1, 0], [0, 1], [-(Omega**2), -2 * _damping(a.scheme) * Omega]])
        at_zero: dict[Symbol, Expr] = a.scheme.typical | {Omega: Integer(0)}
        rows = (a.step.N * without).row_join(a.step.N[:, 2]).row_join(a.step.load_N)
        return cls(
            a,
            (0, 1),
            True,
            (Integer(0), *a.stencil),
            Affine.of(rows[:2, :], 2, at_zero, a.step.den),
            Affine.of(rows[2:, :], 2, at_zero, a.step.den),
            (0, 1, -1),
        )

    @property
    def scheme(self) -> Scheme:
        """The scheme that is marched."""
        return self.amplification.scheme

    @property
    def shape(self) -> Shape:
        """Size of x and `in_state`, which is all that the march's kernels depend on."""
        return len(self.kept), self.in_state

    @property
    def increment(self) -> Matrix:
        """Numerators of D, over the denominator of `step`."""
        return self.step.N - self.step.den * eye(self.step.N.rows)


def _damping(scheme: Scheme) -> Expr:
    return xi if scheme.takes_damping else Integer(0)


def _balanced_at_the_end(a: Amplification) -> bool:
    """Whether h^2 a_1 + 2 xi Omega h v_1 + Omega^2 u_1 = h^2 f(1) for every state at the start of the step."""
    weights = Matrix([[Omega**2, 2 * _damping(a.scheme) * Omega, 1]])
    at_end = zeros(1, len(a.stencil))
    if 1 not in a.stencil:
        return False
    at_end[a.stencil.index(Integer(1))] = a.step.den
    left = (weights * a.step.N).row_join(weights * a.step.load_N - at_end)
    return rational.same(left, zeros(*left.shape))
