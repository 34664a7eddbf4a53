"""Derived objects -> Kernel list: what the printer is asked to print about a scheme."""

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Expr, Matrix, Symbol, eye

from .algebra import horner
from .amplification import Amplification
from .symbols import Omega, xi


@dataclass(frozen=True)
class Kernel:
    """A scalar function with named outputs: the only thing the printer accepts."""

    name: str
    arguments: tuple[Symbol, ...]
    outputs: tuple[tuple[str, Expr], ...]
    docstring: str
    first: tuple[tuple[str, Expr], ...] | None = None  # sums to form before all else, in a kernel inlined in its loop


def entries(name: str, matrix: Matrix) -> list[tuple[str, Expr]]:
    """The entries row by row, named name_00, name_01, ..."""
    return [(f"{name}_{i}{j}", matrix[i, j]) for i in range(matrix.rows) for j in range(matrix.cols)]


def polynomial_kernel(name: str, arguments: Sequence[Symbol], outputs: list[tuple[str, Expr]], doc: str) -> Kernel:
    """Outputs nested in Omega with factored coefficients."""
    return Kernel(name, tuple(arguments), tuple((key, horner(e, Omega)) for key, e in outputs), doc)


def scheme_kernels(amplification: Amplification) -> list[Kernel]:
    """Polynomials from which a scheme's module computes its matrices."""
    arguments = (Omega, xi, *amplification.scheme.values)
    step, start = amplification.step, amplification.start
    increment = [("den", step.den), *entries("D", step.N - step.den * eye(step.N.rows))]
    kernels = [
        polynomial_kernel(
            "_increment",
            arguments,
            increment,
            "Denominator and numerators of A - I.",
        ),
    ]
    if start is not None:
        kernels.append(
            polynomial_kernel(
                "_start",
                arguments,
                [("den", start.den), *entries("S", start.N), *entries("T", start.load_N)],
                "Denominator and numerators of the state at t = 0 from u, h*v, h^2*a and the load.",
            )
        )
    return kernels
