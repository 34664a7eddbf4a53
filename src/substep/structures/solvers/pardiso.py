"""PARDISO of Intel's MKL, in the library that pypardiso finds.

Calls go to the library itself: pypardiso's own take every matrix as unsymmetric, which doubles memory and the time of a
factorization, and convert its indices anew in each solve. Phases, matrix types and parameters are those of the oneMKL
reference, "pardiso iparm Parameter".
"""

import ctypes
from functools import cache
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.memory import require_factors
from .matrices import Matrix, asymmetry

POSITIVE_DEFINITE, SYMMETRIC, UNSYMMETRIC = 2, -2, 11  # types of a real matrix
COMPLEX_SYMMETRIC, COMPLEX = 6, 13
ANALYSE, FACTORIZE, SOLVE, RELEASE = 11, 22, 33, -1  # phases
NOT_POSITIVE_DEFINITE = -4  # or singular
ERRORS = {
    -2: "there is not enough memory", -3: "reordering failed", -4: "it is singular", -7: "it is singular",
    -8: "it has too many entries for 32-bit indices",
}  # fmt: skip


class PardisoError(RuntimeError):
    """What PARDISO reports about a matrix; code: its own number."""

    def __init__(self, code: int) -> None:
        super().__init__(f"PARDISO cannot factorize the matrix: {ERRORS.get(code, f'error {code}')}")
        self.code = code


class Pardiso:
    """A factorization, b (n,) or (n, k) -> x; its memory is given back with this object."""

    def __init__(self, matrix: Matrix, *, definite: bool = True) -> None:
        """Factorize; definite: try whether a symmetric matrix is positive definite first.

        Raises PardisoError for a singular matrix, MemoryError for factors that do not fit in memory.
        """
        from scipy import sparse  # noqa: PLC0415 (slow to import)

        self._library = _library()
        A = sparse.csr_matrix(matrix)
        complex_numbers = np.iscomplexobj(A)
        if asymmetry(A) > 1e-14:
            self._factorize(A, COMPLEX if complex_numbers else UNSYMMETRIC)
            return
        upper = sparse.csr_matrix(sparse.triu(A))
        if definite and not complex_numbers:
            try:
                self._factorize(upper, POSITIVE_DEFINITE)
                return
            except PardisoError as error:
                if error.code != NOT_POSITIVE_DEFINITE:
                    raise
                self._release()
        self._factorize(upper, COMPLEX_SYMMETRIC if complex_numbers else SYMMETRIC)

    @property
    def negative(self) -> int:
        """How many eigenvalues of a symmetric matrix are negative: as many as its pivots (Sylvester)."""
        return int(self._parameters[22]) if self._kind.value == SYMMETRIC else 0

    def _factorize(self, A: Any, kind: int) -> None:
        A.sort_indices()
        self._values = A.data
        self._rows, self._columns = ((x + 1).astype(np.int32) for x in (A.indptr, A.indices))
        self._kind = ctypes.c_int32(kind)
        self._handle = np.zeros(64, np.int64)
        self._parameters = np.zeros(64, np.int32)
        unsymmetric = kind in (UNSYMMETRIC, COMPLEX)
        pivots = 13 if unsymmetric else 8
        for place, value in {1: 1, 2: 2, 10: pivots, 11: unsymmetric, 13: unsymmetric, 21: 1}.items():
            self._parameters[place - 1] = value  # METIS's order; no refinement unless a pivot was perturbed
        kept = (self._handle, self._values, self._rows, self._columns, self._parameters)
        self._kept = [_at(array) for array in kept]  # pointers, whose making takes a tenth of a small solve
        none = np.zeros(1)
        self._call(ANALYSE, none, none, 1)
        peak, permanent, factors = (int(x) * 1024 for x in self._parameters[14:17])
        require_factors(len(self._rows) - 1, max(peak, permanent + factors))
        self._call(FACTORIZE, none, none, 1)

    def _call(self, phase: int, b: Array, x: Array, sides: int) -> None:
        error, number = ctypes.c_int32(0), ctypes.c_int32
        handle, values, rows, columns, parameters = self._kept
        self._library(
            handle, number(1), number(1), self._kind, number(phase), number(len(self._rows) - 1), values, rows, columns,
            None, number(sides), parameters, number(0), _at(b), _at(x), ctypes.byref(error),
        )  # fmt: skip
        if error.value:
            raise PardisoError(error.value)

    def __call__(self, b: Array) -> Array:
        """The solution for the right side b (n,), or for each column of b (n, k)."""
        right = np.asfortranarray(b, dtype=self._values.dtype)
        x = np.empty_like(right, order="F")
        self._call(SOLVE, right, x, 1 if b.ndim == 1 else b.shape[1])
        return x

    def _release(self) -> None:
        if hasattr(self, "_handle") and self._handle.any():
            none = np.zeros(1)
            self._call(RELEASE, none, none, 1)

    def __del__(self) -> None:
        try:  # noqa: SIM105 (while Python shuts down, modules such as contextlib are gone)
            self._release()
        except Exception:
            pass  # the memory goes with the process


def _at(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


@cache
def _library() -> Any:
    """The function pardiso of MKL; finding the file takes pypardiso a third of a second."""
    from pypardiso import PyPardisoSolver  # noqa: PLC0415

    found: Any = PyPardisoSolver().libmkl
    function = found["pardiso"]  # a new function object, with argument types of its own
    pointer, number = ctypes.c_void_p, ctypes.POINTER(ctypes.c_int32)
    function.argtypes = [
        pointer, number, number, number, number, number, pointer, pointer, pointer, pointer, number, pointer, number,
        pointer, pointer, number,
    ]  # fmt: skip
    function.restype = None
    return function
