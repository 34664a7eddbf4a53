"""Dense matrices of numbers of a field; their sums, products, inverse, characteristic polynomial and rank are SymPy's.

The inverse of a singular one raises `rational.SingularMatrix`.
"""

from collections.abc import Sequence
from typing import Any

from sympy.polys.matrices import DomainMatrix as FieldMatrix


def field_matrix(rows: Sequence[Sequence[Any]], domain: Any) -> FieldMatrix:
    """A matrix of its rows; at least one."""
    return FieldMatrix([list(row) for row in rows], (len(rows), len(rows[0])), domain)


def identity(n: int, domain: Any) -> FieldMatrix:
    """The identity (n, n)."""
    return FieldMatrix.eye(n, domain).to_dense()
