"""Derived objects -> Kernel list: what the printer is asked to print about a scheme."""

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Expr, Matrix, Symbol, eye

from .accuracy import defect_series, quadratic
from .algebra import horner
from .amplification import Amplification
from .symbols import Omega, xi

DEFECT_TERMS = 11  # enough for 1e-13 at Omega = 1/8, where the direct formulas take over


@dataclass(frozen=True)
class Kernel:
    """A scalar function with named outputs: the only thing the printer accepts."""

    name: str
    arguments: tuple[Symbol, ...]
    outputs: tuple[tuple[str, Expr], ...]
    docstring: str


def entries(name: str, matrix: Matrix) -> list[tuple[str, Expr]]:
    """The entries row by row, named name_00, name_01, ..."""
    return [(f"{name}_{i}{j}", matrix[i, j]) for i in range(matrix.rows) for j in range(matrix.cols)]


def polynomial_kernel(name: str, arguments: Sequence[Symbol], outputs: list[tuple[str, Expr]], doc: str) -> Kernel:
    """Outputs nested in Omega with factored coefficients."""
    return Kernel(name, tuple(arguments), tuple((key, horner(e, Omega)) for key, e in outputs), doc)


def scheme_kernels(amplification: Amplification) -> list[Kernel]:
    """Polynomials from which a scheme's module computes all its functions."""
    arguments = (Omega, xi, *amplification.scheme.values)
    den = [("den", amplification.den)]
    N, size = amplification.N, amplification.N.rows
    det, trace, c2 = quadratic(amplification)
    return [
        polynomial_kernel(
            "_amplification",
            arguments,
            den + entries("N", N),
            "Common denominator and numerators of the amplification matrix.",
        ),
        polynomial_kernel(
            "_increment",
            arguments,
            den
            + entries("D", N - amplification.den * eye(size))
            + entries("B", amplification.load_N)
            + entries("O", amplification.outputs_N)
            + entries("P", amplification.outputs_load_N),
            "Denominator; numerators of A - I, of the load vectors, and of the rows of (u, h*v, h^2*a).",
        ),
        polynomial_kernel(
            "_quadratic",
            arguments,
            [("c2", c2), ("c1", 2 * c2 - trace), ("trace", trace), ("det", det), ("q", c2 - det)],
            "Live eigenvalues: c2*lambda^2 - trace*lambda + det = 0; c1 = 2*c2 - trace, q = c2 - det.",
        ),
        polynomial_kernel(
            "_defect",
            arguments,
            list(defect_series(amplification, DEFECT_TERMS).items()),
            "Residual of the exact eigenvalue, r_0 + r_1*zeta, and of its modulus, g, at small Omega.",
        ),
    ]
