"""Amplification -> MarchForm: the fewest numbers a march has to carry.

Where the last balance of a step stands at its end, it gives the acceleration from u, h*v and the load, so that the
march need not carry it: h^2 a_n = c_n - 2 xi Omega h v_n - Omega^2 u_n. c_n is h^2 f(t_n), and at the start, whose
acceleration is given, whatever makes this true.
"""

from dataclasses import dataclass

from sympy import Expr, Integer, Matrix, Symbol, cancel, eye, zeros

from ..declare.scheme import Scheme
from ..declare.symbols import Omega, knot, xi
from ..oscillator.amplification import Affine, Amplification
from .march_shape import Shape


@dataclass(frozen=True)
class MarchForm:
    """x1 = x0 + D x0 + B h^2 f, and outputs y1 = O x0 + P h^2 f: numerators over a denominator each.

    kept: which entries of the scheme's state are carried. stencil: instants of the load, the first of them c_n if
    `carrier`. in_state: where u, h*v, h^2*a of the new step stand in x, -1 for the next output.
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
        """Of the scheme, without its acceleration if that is possible."""
        a = amplification
        everything = tuple(range(len(a.scheme.state)))
        if a.scheme.state != knot(0) or not _balanced_at_the_end(a):
            return cls(a, everything, False, a.stencil, a.step, a.outputs, a.in_state)
        without = Matrix([[1, 0], [0, 1], [-(Omega**2), -2 * xi * Omega]])
        at_zero: dict[Symbol, Expr] = a.scheme.typical | {Omega: Integer(0)}
        rows = (a.step.N * without).row_join(a.step.N[:, 2]).row_join(a.step.load_N) / a.step.den
        return cls(
            a,
            (0, 1),
            True,
            (Integer(0), *a.stencil),
            Affine.of(rows[:2, :], 2, at_zero),
            Affine.of(rows[2:, :], 2, at_zero),
            (0, 1, -1),
        )

    @property
    def scheme(self) -> Scheme:
        """Whose march it is."""
        return self.amplification.scheme

    @property
    def shape(self) -> Shape:
        """What the kernels of the march depend on."""
        return len(self.kept), self.in_state

    @property
    def increment(self) -> Matrix:
        """Numerators of D."""
        return self.step.N - self.step.den * eye(self.step.N.rows)


def _balanced_at_the_end(a: Amplification) -> bool:
    """Whether h^2 a_1 + 2 xi Omega h v_1 + Omega^2 u_1 = h^2 f(1) for every state before."""
    weights = Matrix([[Omega**2, 2 * xi * Omega, 1]])
    at_end = zeros(1, len(a.stencil))
    if 1 not in a.stencil:
        return False
    at_end[a.stencil.index(Integer(1))] = a.step.den
    left = [*(weights * a.step.N), *(weights * a.step.load_N - at_end)]
    return all(cancel(e) == 0 for e in left)
