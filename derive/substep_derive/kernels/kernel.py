"""What the printer accepts: scalar functions with named outputs."""

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Expr, Matrix, Symbol, horner

from ..algebra import rational
from ..algebra.constant import approximated, constant_of
from ..declare.names import entry_name
from ..declare.symbols import Omega


@dataclass(frozen=True)
class Kernel:
    """A scalar function with named outputs: the only thing the printer accepts."""

    name: str
    arguments: tuple[Symbol, ...]
    outputs: tuple[tuple[str, Expr], ...]
    docstring: str
    first: tuple[tuple[str, Expr], ...] = ()  # named sums that come first


def entries(name: str, matrix: Matrix) -> list[tuple[str, Expr]]:
    """The matrix's entries row by row, each with its name from `entry_name`."""
    return [(entry_name(name, i, j), matrix[i, j]) for i in range(matrix.rows) for j in range(matrix.cols)]


def nested(e: Expr, variable: Symbol) -> Expr:
    """A polynomial as it is printed: Horner's form, with rational numbers near those of a constant's field."""
    if constant_of([e]) is None:
        return rational.horner(e, variable)
    return horner(approximated(e), variable, *sorted(e.free_symbols - {variable, constant_of([e])}, key=str))


def polynomial_kernel(name: str, arguments: Sequence[Symbol], outputs: list[tuple[str, Expr]], doc: str) -> Kernel:
    """A kernel whose outputs are in Horner's form in Omega, with factored coefficients."""
    return Kernel(name, tuple(arguments), tuple((key, nested(e, Omega)) for key, e in outputs), doc)
