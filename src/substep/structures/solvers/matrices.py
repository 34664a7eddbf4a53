"""Matrices of a structure, dense or sparse: checked once, reduced to the free degrees of freedom, combined."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array
from ...core.errors import complex_numbers, real_array
from .low_rank import LowRank, Updated

SMALL = 300  # unknowns up to which all eigenvalues take less time than the least by Lanczos's method
Matrix = Any  # a dense array (n, n), a sparse one of SciPy's in rows, or one of low rank


@dataclass(frozen=True, eq=False)
class Products:
    """A sum that is known by its products only, `whole`; base: the sum of those of its parts that are matrices."""

    whole: Any
    base: Matrix


def finite(name: str, value: Any) -> Matrix:
    """The value as an array, or a matrix in compressed rows, of finite real numbers. Raises ValueError for others."""
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    if not sparse.issparse(value):
        return real_array(name, value)
    if np.iscomplexobj(value):
        raise complex_numbers(name)
    matrix = sparse.csr_array(value.astype(np.float64, copy=False))  # before entries that stand twice are added up
    if not matrix.has_canonical_format:  # whose arrays may be the caller's
        matrix = matrix.copy()
        matrix.sum_duplicates()
    bad = np.flatnonzero(~np.isfinite(matrix.data))
    if len(bad):
        row = int(np.searchsorted(matrix.indptr, bad[0], side="right")) - 1
        at = (row, int(matrix.indices[bad[0]]))
        raise ValueError(f"expected {name} to be finite, got {matrix.data[bad[0]]} at {at}; remove or replace it")
    return matrix


def checked(name: str, value: Any, size: int | None = None) -> Matrix:
    """The value as a square matrix of finite real numbers, dense or in compressed rows.

    Raises ValueError for another shape, complex numbers, NaN or infinity; the message names the entry.
    """
    if is_operator(value):
        if np.iscomplexobj(value):
            raise complex_numbers(name)
        if size is not None and value.shape != (size, size):
            raise ValueError(f"expected {name} to be {size} x {size} as the mass matrix, got shape {value.shape}")
        return value
    matrix = finite(name, value)
    shape: tuple[int, ...] = np.shape(matrix)
    if len(shape) != 2 or shape[0] != shape[1]:
        cures = {
            0: f"; of one degree of freedom give [[{value}]], or march ss.scene('linear_oscillator', omega=...)",
            1: "; of a diagonal give np.diag(...)",
        }
        raise ValueError(f"expected {name} to be a square matrix, got shape {shape}{cures.get(len(shape), '')}")
    if size is not None and shape[0] != size:
        raise ValueError(f"expected {name} to be {size} x {size} as the mass matrix, got shape {shape}")
    return matrix


def is_operator(matrix: Any) -> bool:
    """Whether it is known by its products only: SciPy's LinearOperator."""
    return hasattr(matrix, "matvec") and hasattr(matrix, "rmatvec")


def reduced(matrix: Matrix, T: Matrix) -> Matrix:
    """T^T matrix T; sparse stays sparse, and what is known by its products only stays so."""
    from scipy import sparse  # noqa: PLC0415
    from scipy.sparse.linalg import aslinearoperator  # noqa: PLC0415

    if is_operator(matrix):
        return aslinearoperator(T.T) @ matrix @ aslinearoperator(T)
    found = T.T @ matrix @ T
    if not sparse.issparse(found):
        return np.asarray(found)
    rows = sparse.csr_array(found)
    if rows.nnz < np.iinfo(np.int32).max:  # half the memory that a product has to read for the columns
        rows.indices, rows.indptr = rows.indices.astype(np.int32), rows.indptr.astype(np.int32)
    return rows


def kept(matrix: Matrix, T: Matrix, free: Matrix) -> Matrix:
    """The matrix (N, N) as it is now, whatever becomes of the caller's; free: T^T matrix T, which it is if T is one."""
    if is_operator(matrix):
        return matrix
    return free if is_identity(T) else matrix.copy()


def combination(terms: Sequence[tuple[complex, Matrix]]) -> Matrix:
    """The sum of factor * matrix; terms with the factor 0 are left out. One of low rank stays beside the others."""
    from scipy.sparse.linalg import aslinearoperator  # noqa: PLC0415

    used = [(factor, matrix) for factor, matrix in terms if factor != 0.0]
    if any(is_operator(matrix) for _, matrix in used):
        whole = reduce(add, (factor * aslinearoperator(_operand(matrix)) for factor, matrix in used))
        matrices = [(factor, A) for factor, A in used if not (is_operator(A) or isinstance(A, LowRank))]
        return Products(whole, combination(matrices)) if matrices else whole
    found, low = None, None
    for factor, matrix in used:
        if isinstance(matrix, LowRank):
            assert low is None  # a structure has one
            low = factor * matrix
        else:
            found = factor * matrix if found is None else found + factor * matrix
    if low is None or found is None:
        return low if found is None else found
    return Updated(found, low)


def added(A: Matrix, B: Matrix) -> Matrix:
    """A + B, known by its products only where one of them is so, or of low rank."""
    from scipy.sparse.linalg import aslinearoperator  # noqa: PLC0415

    if any(is_operator(x) or isinstance(x, LowRank) for x in (A, B)):
        return aslinearoperator(_operand(A)) + aslinearoperator(_operand(B))
    return A + B


def _operand(matrix: Matrix) -> Any:
    return matrix.operator() if isinstance(matrix, LowRank) else matrix


def arrays_of(matrix: Matrix) -> tuple[Array, ...]:
    """The arrays that make it up."""
    if isinstance(matrix, LowRank):
        return matrix.B, matrix.d
    return (matrix.data, matrix.indices, matrix.indptr) if hasattr(matrix, "indptr") else (matrix,)


def diagonal_of(matrix: Matrix) -> Array | None:
    """The diagonal (n,) of a matrix that has no other entries; None of any other."""
    diagonal = matrix.diagonal()
    rest = matrix.count_nonzero() if hasattr(matrix, "count_nonzero") else np.count_nonzero(matrix)
    return diagonal if rest == np.count_nonzero(diagonal) else None


def is_identity(matrix: Matrix) -> bool:
    """Whether a sparse matrix is the identity."""
    n, m = matrix.shape
    return n == m == matrix.nnz and bool((matrix.diagonal() == 1.0).all())


def asymmetry(matrix: Matrix) -> float:
    """The largest difference between the matrix and its transpose, relative to its largest entry."""
    largest = abs(matrix).max()
    return float(abs(matrix - matrix.T).max() / largest) if largest > 0.0 else 0.0


def indefinite(matrix: Matrix) -> int | None:
    """Where the eigenvector of a negative eigenvalue of a symmetric matrix shows most; None where there is none.

    Scaled to a unit diagonal, a mass matrix of finite elements has its eigenvalues within a few orders of magnitude of
    one (Wathen, IMA J. Num. Anal. 7, 449-457, 1987), so that Lanczos's method finds the least in a few dozen products.
    """
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh  # noqa: PLC0415

    diagonal, n = matrix.diagonal(), matrix.shape[0]
    if diagonal_of(matrix) is not None:
        return int(np.argmin(diagonal)) if n and diagonal.min() < 0.0 else None
    size = np.sqrt(np.maximum(np.abs(diagonal), 1e-30 * np.abs(diagonal).max() or 1.0))  # beside a 0 nothing is small
    if n <= SMALL:
        full = matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
        values, vectors = np.linalg.eigh(full / size / size[:, None])
    else:
        scaled = LinearOperator((n, n), matvec=lambda x: (matrix @ (x.ravel() / size)) / size, dtype=np.float64)
        first = np.random.default_rng(0).normal(size=n)
        try:
            values, vectors = eigsh(scaled, 1, which="SA", tol=1e-3, maxiter=20, v0=first)
        except ArpackNoConvergence:  # of many that lie close together, none far below the others
            return None
    return int(np.argmax(np.abs(vectors[:, 0]))) if values[0] < -1e-9 else None


def require_symmetric(name: str, matrix: Matrix, why: str) -> None:
    """Raises ValueError for a matrix that is not symmetric to 1e-10."""
    if (found := asymmetry(matrix)) > 1e-10:
        raise ValueError(
            f"expected a symmetric {name} {why}, got a difference to its transpose of {found:.1e} (relative); "
            f"give 0.5 * ({name} + {name}.T), if it is rounding"
        )


def vector(name: str, value: ArrayLike, size: int) -> Array:
    """The value as a vector (size,) of finite numbers; one number stands for all. Raises ValueError for others."""
    array = real_array(name, value)
    if array.shape not in ((), (size,)):
        raise ValueError(
            f"expected {name} with {size} components, one for each degree of freedom, got shape {array.shape}"
        )
    return np.broadcast_to(array, (size,)).astype(np.float64)
