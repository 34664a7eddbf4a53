"""Natural modes of a structure: the eigenvalue problem K phi = omega^2 M phi, dense or by shift-invert Lanczos.

Dense problems go to LAPACK, degrees of freedom without mass condensed. Sparse ones go to ARPACK with a factorization of
K (B. Nour-Omid, B. N. Parlett, T. Ericsson, P. S. Jensen, How to implement the spectral transformation, Math. Comp. 48,
663-673, 1987), which allows a singular M; for a free body, whose K is singular, with one of K + s M.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ..march.refusals import require_tangent
from ..model.model import Model
from ..solvers.factorization import SingularMatrix, factorize, negative_eigenvalues
from ..solvers.matrices import Matrix, combination, require_symmetric

DENSE = 400  # unknowns up to which all modes together take less time than a few by Lanczos's method
SHARE = 3  # and so do more than a third of all modes
ROUNDING = 2e-14  # of |phi|^T |K| |phi|: a smaller strain energy is rounding, and the mode a rigid one
SHIFT = 1e-8  # of the largest K_ii / M_ii, for a free body
BELOW = 1e-6  # of the largest eigenvalue found: modes are counted up to so far below it
ATTEMPTS = 3  # at finding a mode that was missed


def eigenmodes(structure: Model, n: int) -> tuple[Array, Array, Array | None]:
    """The n lowest circular frequencies (n,), rad/s, 0 for rigid modes, mass-normalised shapes (size, n), and statics.

    The last are displacements (size, J) under the structure's load vectors, constant in time, where K was factorized to
    find the modes, else None. The largest component of a shape is positive, of equal ones the first. Raises ValueError
    for n that is not from 1 to the number of degrees of freedom with mass, for an M or K that is not symmetric, for an
    indefinite one, and where no tangent of the internal force was given.
    """
    require_tangent(structure, "modes")
    require_symmetric("M", structure.M, "for modes")
    require_symmetric("K", structure.K, "for modes")
    most = structure.size - len(structure.massless)
    if isinstance(n, bool) or not isinstance(n, int | np.integer) or not 1 <= n <= most:
        raise ValueError(f"expected from 1 to {most} modes, as many as degrees of freedom with mass, got {n!r}")
    whole = isinstance(structure.K, np.ndarray) or structure.size <= DENSE or SHARE * n > most
    values, shapes, statics = (*_dense(structure, int(n)), None) if whole else _lanczos(structure, int(n))
    rigid = _strainless(structure.K, shapes)
    if (values[~rigid] <= 0.0).any():
        raise ValueError(
            f"expected a positive semidefinite K, got a mode with omega^2 = {values[~rigid].min():.3g}; correct the "
            "stiffness matrix, or march the structure without modes"
        )
    order = np.argsort(np.where(rigid, 0.0, values), kind="stable")
    sizes = np.abs(shapes)
    first = np.argmax(sizes >= (1.0 - 1e-6) * sizes.max(axis=0), axis=0)  # of equal ones, whatever their rounding
    signs = np.sign(shapes[first, np.arange(n)])
    return np.sqrt(np.where(rigid, 0.0, values))[order], (shapes * signs)[:, order], statics


def static_response(structure: Model, loads: Array, rigid: Array) -> Array:
    """Displacements (size, J) under constant loads (size, J), rigid (size, r) the shapes of all rigid modes.

    Of a free body: of its deformation alone, under the loads less the inertia of its rigid motion. Raises ValueError
    for a free body with other rigid modes.
    """
    if not rigid.shape[1]:
        return structure.factorized(structure.K, "K, the stiffness matrix")(loads)
    from scipy import linalg  # noqa: PLC0415

    inertia = structure.M @ rigid
    loads = loads - inertia @ (rigid.T @ loads)
    # supports that carry nothing, since the loads are in equilibrium: as many as rigid modes, where these differ most
    held = linalg.qr(rigid.T, mode="r", pivoting=True)[-1][: rigid.shape[1]]
    free = np.setdiff1d(np.arange(structure.size), held)
    u = np.zeros_like(loads)
    try:
        u[free] = factorize(structure.K[free][:, free], structure.solver)(loads[free])
        singular = bool((_strainless(structure.K, u) & loads.any(axis=0)).any())
    except SingularMatrix:
        singular = True
    if singular:
        raise ValueError(
            f"expected all rigid modes among those computed, got {rigid.shape[1]} of more; ask for more modes"
        )
    return u - rigid @ (inertia.T @ u)


def _strainless(K: Matrix, X: Array) -> NDArray[np.bool_]:
    """Which columns of X (n, m) have no more strain energy than rounding."""
    strain = np.einsum("ij,ij->j", X, K @ X)
    return np.abs(strain) <= ROUNDING * np.einsum("ij,ij->j", abs(X), abs(K) @ abs(X))


def _dense(structure: Model, n: int) -> tuple[Array, Array]:
    from scipy import linalg  # noqa: PLC0415

    M, K = (A if isinstance(A, np.ndarray) else A.toarray() for A in (structure.M, structure.K))
    s = structure.massless
    m = np.setdiff1d(np.arange(structure.size), s)
    K_mm, follow = K[np.ix_(m, m)], np.zeros((len(s), len(m)))
    if len(s):
        follow = -structure.factorized(K[np.ix_(s, s)], "K of degrees of freedom without mass", s)(K[np.ix_(s, m)])
        K_mm = K_mm + K[np.ix_(m, s)] @ follow
    try:
        values, vectors = linalg.eigh(0.5 * (K_mm + K_mm.T), M[np.ix_(m, m)], subset_by_index=[0, n - 1])
    except np.linalg.LinAlgError as error:
        raise ValueError(
            "expected a positive definite M but for degrees of freedom whose rows of M are zero, got one that is not; "
            "correct the mass matrix, or give such motions mass"
        ) from error
    shapes = np.empty((structure.size, n))
    shapes[m], shapes[s] = vectors, follow @ vectors
    return values, shapes


def _lanczos(structure: Model, n: int) -> tuple[Array, Array, Array | None]:
    """Counted, where the solver tells its pivots: of modes with one frequency Lanczos's method may miss one."""
    solve, shift = _inverse(structure)
    statics = solve(structure.load_vectors) if structure.loads and not shift else None
    most, wanted, attempt = structure.size - len(structure.massless), n, 0
    while True:
        values, shapes = _some(structure, min(wanted, most - 1), solve, shift, attempt)
        missed = _missed(structure, values, shapes)
        if not missed:
            lowest = np.argsort(values, kind="stable")[:n]
            return values[lowest], shapes[:, lowest], statics
        wanted, attempt = wanted + missed, attempt + 1
        if attempt == ATTEMPTS:
            raise ValueError(
                f"expected all modes up to omega = {np.sqrt(values.max()):.4g}, got {missed} fewer than the factors of "
                "K - omega^2 M count; ask for another number of modes"
            )


def _some(structure: Model, n: int, solve: Callable[[Array], Array], shift: float, attempt: int) -> tuple[Array, Array]:
    """n modes by Lanczos's method; each attempt begins with another vector."""
    from scipy import linalg  # noqa: PLC0415
    from scipy.sparse.linalg import LinearOperator, eigsh  # noqa: PLC0415

    M, K, size = structure.M, structure.K, structure.size
    operator = LinearOperator((size, size), matvec=lambda b: solve(b.ravel()), dtype=np.float64)
    first = solve(M @ np.random.default_rng(attempt).normal(size=size))
    values, shapes = eigsh(K, n, M=M, sigma=-shift, OPinv=operator, v0=first, which="LM")
    # one step of inverse iteration and the best combinations of its results: the error of the frequencies is squared
    X = solve(M @ shapes) * (values + shift)
    A = X.T @ (M @ shapes) * (values + shift)
    shifted, Y = linalg.eigh(0.5 * (A + A.T), X.T @ (M @ X))
    return shifted - shift, X @ Y


def _missed(structure: Model, values: Array, shapes: Array) -> int:
    """How many eigenvalues below the largest found one were not found; 0 where the solver does not tell.

    Sturm's count: K - s M has as many negative pivots as there are eigenvalues below s (Bathe, Finite Element
    Procedures, 11.6.4). Others that equal the largest are not missed, which is one of the n lowest in any case.
    """
    if _strainless(structure.K, shapes).all():  # rigid modes alone
        return 0
    s = float(values.max()) * (1.0 - BELOW)
    counted = negative_eigenvalues(combination([(1.0, structure.K), (-s, structure.M)]), structure.solver)
    return 0 if counted is None else max(0, counted - int(np.count_nonzero(values < s)))


def _inverse(structure: Model) -> tuple[Callable[[Array], Array], float]:
    """b -> (K + s M)^-1 b, and s: 0 unless K is singular, to rounding."""
    M, K = structure.M, structure.K
    m = np.setdiff1d(np.arange(structure.size), structure.massless)
    largest = float((K.diagonal()[m] / M.diagonal()[m]).max())
    try:
        solve = factorize(K, structure.solver)
        x = solve(M @ np.cos(np.arange(structure.size)))
        y = solve(M @ x)
        if x @ (M @ x) > 100.0 * np.finfo(np.float64).eps * largest * abs(x @ (M @ y)):
            return solve, 0.0
    except SingularMatrix:
        pass
    shift = SHIFT * largest
    shifted: Matrix = K + shift * M
    return structure.factorized(shifted, "K + s M, for the modes of a free body"), shift
