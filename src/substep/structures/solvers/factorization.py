"""Factorizations of effective matrices, by a well-kept library behind one small protocol.

A factorization is a function b -> x of the right-hand side, (n,) or (n, k). `solver` of a structure is the name of one
of these, or a function of the user's own from the matrix to such a function, for PETSc or MUMPS.
"""

from collections.abc import Callable
from contextlib import suppress
from importlib.util import find_spec
from typing import Any

import numpy as np

from ...core.arrays import Array, dot
from ...core.errors import unknown_name
from ...core.memory import available_memory, require_factors
from .low_rank import LowRank, Updated, solved_with
from .matrices import Matrix, Products, asymmetry, diagonal_of, is_operator

Solve = Callable[[Array], Array]
Solver = str | Callable[[Matrix], Solve]
SINGULAR = 0.05  # residual of a right side that a singular matrix does not attain; 0.006 for beams of condition 1e17
ROUNDS, RESTARTS = 4, 10  # of GMRES, and of each round the restarts, after 60 products each
SOLVED, UNSOLVED = 1e-14, 1e-9  # of a right side: what a solution of GMRES leaves, and what only rounding can leave
NEAR = 0.01  # of the largest entry of a column: pivots of SuperLU on the diagonal, which keep the order; 1 fills more
DENSE = 300  # unknowns up to which a sparse matrix is factorized as a dense one


class SingularMatrix(ValueError):
    """An effective matrix without an inverse; place: the degree of freedom that it leaves undetermined."""

    def __init__(self, place: int) -> None:
        super().__init__(f"expected a regular matrix, got one that leaves degree of freedom {place} undetermined")
        self.place = place


def factorize(matrix: Matrix, solver: Solver = "auto") -> Solve:
    """The factorization. Raises SingularMatrix, and ValueError for an unknown solver or one that is not installed."""
    if isinstance(matrix, Updated):
        return solved_with(factorize(matrix.base, solver), matrix.low)
    if isinstance(matrix, LowRank):
        raise SingularMatrix(int(np.argmin(np.abs(matrix.B).sum(axis=1))))
    if isinstance(matrix, Products) or is_operator(matrix):
        return _by_products(matrix, solver)
    if (diagonal := diagonal_of(matrix)) is not None:
        if not diagonal.all():
            raise SingularMatrix(int(np.argmin(np.abs(diagonal))))
        return lambda b: (b.T / diagonal).T
    try:
        solve = _chosen(matrix, solver)
    except (RuntimeError, np.linalg.LinAlgError) as error:  # what the libraries raise for an exact zero pivot
        if callable(solver):
            factorize(matrix)  # raises for a singular matrix
            raise
        raise SingularMatrix(_loose(matrix)) from error
    n = matrix.shape[0]
    attained, other = matrix @ np.cos(np.arange(n)), np.random.default_rng(0).normal(size=n)
    if not _residual(matrix, solve, attained) <= 1e-6 or not _residual(matrix, solve, other) <= SINGULAR:
        if callable(solver):
            factorize(matrix)  # raises for a singular matrix
            raise ValueError(
                "expected the solver to return x with matrix @ x = b, got another one for a regular matrix of "
                f"{n} unknowns; compare it with numpy.linalg.solve"
            )
        raise SingularMatrix(_loose(matrix))
    return solve


def _by_products(matrix: Any, solver: Solver) -> Solve:
    whole, base = (matrix.whole, matrix.base) if isinstance(matrix, Products) else (matrix, None)
    if callable(solver):
        return solver(whole)
    try:
        return krylov(whole, None if base is None else factorize(base, solver))
    except SingularMatrix:  # such as a mass matrix with rows of zeros, without the tangent
        return krylov(whole)


def _residual(matrix: Matrix, solve: Solve, b: Array) -> float:
    """Relative to b; NaN where the solution is not finite."""
    with np.errstate(all="ignore"):
        left, b = np.abs(matrix @ solve(b) - b), np.abs(b)
        return float(np.sqrt(np.divide(dot(left, left), dot(b, b))))


def _chosen(matrix: Matrix, solver: Solver) -> Solve:
    if callable(solver):
        solve = _in_real_numbers(matrix, solver) if np.iscomplexobj(matrix) else solver(matrix)
        if not callable(solve):
            raise ValueError(f"expected the solver to return a function b -> x, got {type(solve).__name__}; return one")
        return solve
    if solver not in ("auto", *SOLVERS):
        raise unknown_name("a solver", str(solver), ("auto", *SOLVERS))
    if solver == "dense" or (solver == "auto" and (isinstance(matrix, np.ndarray) or matrix.shape[0] <= DENSE)):
        return dense(matrix)
    if solver == "pardiso" or (solver == "auto" and find_spec("pypardiso")):
        return pardiso(matrix)
    return cholmod(matrix) if solver == "cholmod" else superlu(matrix)


def krylov(matrix: Any, near: Solve | None = None) -> Solve:
    """GMRES for a matrix that is known by its products only; near: the solution with a matrix not far from it.

    Each of a few rounds solves for what the last has left, so that the error does not depend on how well GMRES tells
    when it is done. Raises ValueError, when it solves, for a system that does not come within UNSOLVED.
    """
    from scipy.sparse.linalg import LinearOperator, gmres  # noqa: PLC0415

    def prepared(b: Array) -> Array:
        return b if near is None else near(b)

    closer = LinearOperator(matrix.shape, matvec=lambda x: prepared(matrix @ x.ravel()), dtype=matrix.dtype)  # type: ignore[call-arg]

    def solve(b: Array) -> Array:
        if b.ndim == 2:
            return np.stack([solve(column) for column in b.T], axis=-1)
        x, left = np.zeros(len(b), matrix.dtype), prepared(b)
        size = smallest = float(np.linalg.norm(left))
        for _ in range(ROUNDS):
            if not smallest > SOLVED * size:
                break
            nearer = x + gmres(closer, left, rtol=1e-8, restart=60, maxiter=RESTARTS)[0]
            left = prepared(b - matrix @ nearer)
            if not float(np.linalg.norm(left)) < 0.5 * smallest:
                break
            x, smallest = nearer, float(np.linalg.norm(left))
        if smallest > UNSOLVED * size:
            raise ValueError(
                f"expected GMRES to solve with a matrix that is known by its products only, got {smallest / size:.1e} "
                f"of the right side left after {60 * RESTARTS} products a round; give the damping or the tangent as "
                "a matrix, or solver= as a function from the LinearOperator to one b -> x"
            )
        return x

    return solve


def dense(matrix: Matrix) -> Solve:
    """LU factorization of LAPACK, for small or dense matrices."""
    from scipy import linalg  # noqa: PLC0415

    n, full = matrix.shape[0], matrix
    if n > DENSE:
        require_factors(n, float(matrix.dtype.itemsize) * n * n * (1 if isinstance(matrix, np.ndarray) else 2))
    if not isinstance(matrix, np.ndarray):
        full = matrix.toarray()
    factorized, solved = linalg.lapack.get_lapack_funcs(("getrf", "getrs"), (full,))
    with np.errstate(all="ignore"):
        lu, pivots, info = factorized(full)
    if info > 0:
        raise np.linalg.LinAlgError(f"pivot {info} is 0")
    return lambda b: solved(lu, pivots, b)[0]


def _in_real_numbers(matrix: Matrix, solver: Callable[[Matrix], Solve]) -> Solve:
    """The solution with a complex matrix by a solver of the user's, of a real matrix, symmetric if it is.

    Each complex equation is two real ones, the second one with the other sign.
    """
    from scipy import sparse  # noqa: PLC0415

    product: Any = np.kron if isinstance(matrix, np.ndarray) else sparse.kron
    solve = solver(product(matrix.real, [[1.0, 0.0], [0.0, -1.0]]) - product(matrix.imag, [[0.0, 1.0], [1.0, 0.0]]))
    if not callable(solve):
        return solve

    def solved(b: Array) -> Array:
        right = np.ascontiguousarray(b.conj().T, dtype=complex).view(np.float64).T
        return np.ascontiguousarray(solve(right).T).view(complex).T

    return solved


def superlu(matrix: Matrix) -> Solve:
    """SuperLU of SciPy, in the order of METIS where pymetis is installed: a quarter of the work on solids."""
    from scipy import sparse  # noqa: PLC0415
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    A = sparse.csc_array(matrix)
    symmetric = asymmetry(A) < 1e-12
    options: dict[str, Any] = {"diag_pivot_thresh": NEAR}
    if symmetric:
        options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    if not find_spec("pymetis"):
        options["permc_spec"] = "MMD_AT_PLUS_A"
        if not _would_fit(matrix.shape[0], 2 * A.dtype.itemsize):
            with suppress(RuntimeError):  # of a pivot that is 0, of which the factorization itself tells
                order = _own_order(A, options)
                _require_fill(sparse.csc_array(A[order][:, order]), 2 * A.dtype.itemsize)
        return splu(A, **options).solve
    import pymetis  # noqa: PLC0415

    order = _graph_order(pymetis, A)
    ordered = sparse.csc_array(A[order][:, order])
    _require_fill(ordered, 2 * A.dtype.itemsize)  # the numbers of both factors, without their indices
    lu = splu(ordered, permc_spec="NATURAL", **options)

    def solve(b: Array) -> Array:
        x = np.empty(b.shape, A.dtype)
        x[order] = lu.solve(b[order])
        return x

    return solve


def _would_fit(n: int, each: int) -> bool:
    """Whether full factors would fit in memory, `each` bytes an entry of L, so that no entries have to be counted."""
    have = available_memory()
    return have is None or each * n * (n + 1) / 2 <= have


def _require_fill(ordered: Any, each: int) -> None:
    """Raises MemoryError where the factors of a matrix, `each` bytes an entry of L, do not fit in memory.

    Pivots are taken to be those of the order; others, of a matrix that is not symmetric, fill more.
    """
    n = ordered.shape[0]
    if _would_fit(n, each):
        return
    from .fill import factor_entries  # noqa: PLC0415 (loads numba, and compiles)

    pattern = abs(ordered) + abs(ordered).T
    require_factors(n, each * factor_entries(pattern.indptr, pattern.indices))


def _own_order(A: Any, options: dict[str, Any]) -> Any:
    """The order of SuperLU itself: place -> unknown, from an incomplete factorization that drops all it may."""
    from scipy.sparse.linalg import spilu  # noqa: PLC0415

    dropped = spilu(A, drop_tol=1.0, fill_factor=1.0, drop_rule="basic", **options)
    return np.argsort(dropped.perm_c)


def _graph_order(pymetis: Any, A: Any) -> Any:
    """The nested dissection order of METIS: place -> unknown."""
    pattern = (A + A.T).tocsr()
    pattern.setdiag(0.0)
    pattern.eliminate_zeros()
    order, _ = pymetis.nested_dissection(pymetis.CSRAdjacency(pattern.indptr, pattern.indices))
    return np.asarray(order)


def pardiso(matrix: Matrix) -> Solve:
    """PARDISO of MKL, in the library that pypardiso finds."""
    if not find_spec("pypardiso"):
        raise ValueError(
            "expected pypardiso for solver='pardiso', got none installed; pip install 'substep[structures]'"
        )
    from .pardiso import Pardiso  # noqa: PLC0415 (loads SciPy)

    return Pardiso(matrix)


def cholmod(matrix: Matrix) -> Solve:
    """CHOLMOD in cvxopt, in METIS's order where pymetis is installed; SuperLU for what is not positive definite."""
    if not find_spec("cvxopt"):
        raise ValueError("expected cvxopt for solver='cholmod', got none installed; pip install cvxopt, under the GPL")
    import cvxopt  # noqa: PLC0415 # pyright: ignore[reportMissingImports]
    import cvxopt.cholmod  # noqa: PLC0415 # pyright: ignore[reportMissingImports]
    from scipy import sparse  # noqa: PLC0415

    A = sparse.csc_array(matrix)
    if asymmetry(A) > 1e-14 or np.iscomplexobj(A):
        return superlu(matrix)
    lower = sparse.coo_array(sparse.tril(A))
    given = cvxopt.spmatrix(lower.data, *(i.astype(np.int64) for i in lower.coords), A.shape)
    order = None
    if find_spec("pymetis"):
        import pymetis  # noqa: PLC0415

        places = _graph_order(pymetis, A)
        _require_fill(sparse.csc_array(A[places][:, places]), 8)
        order = cvxopt.matrix(places.astype(np.int64))
    factors = cvxopt.cholmod.symbolic(given, p=order)
    try:
        cvxopt.cholmod.numeric(given, factors)
    except ArithmeticError:
        return superlu(matrix)

    def solve(b: Array) -> Array:
        x = cvxopt.matrix(b)
        cvxopt.cholmod.solve(factors, x)
        return np.array(x).reshape(b.shape)

    return solve


def negative_eigenvalues(matrix: Matrix, solver: Solver) -> int | None:
    """How many eigenvalues of a symmetric matrix are negative; None with a solver that does not tell its pivots."""
    if solver not in ("auto", "pardiso") or not find_spec("pypardiso"):
        return None
    from .pardiso import Pardiso, PardisoError  # noqa: PLC0415 (loads SciPy)

    try:
        return Pardiso(matrix, definite=False).negative
    except PardisoError:
        return None


def _loose(matrix: Matrix) -> int:
    """The degree of freedom that moves most in the nullspace of a singular matrix."""
    n = matrix.shape[0]
    if n <= 2000:
        full = matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
        return int(np.argmax(np.abs(np.linalg.svd(full)[2][-1])))
    from scipy import sparse  # noqa: PLC0415

    near = superlu(matrix + 1e-10 * abs(matrix).max() * sparse.eye_array(n, format="csr"))
    x = near(np.cos(np.arange(n)))
    return int(np.argmax(np.abs(near(x / np.linalg.norm(x)))))


SOLVERS = ("dense", "superlu", "pardiso", "cholmod")
