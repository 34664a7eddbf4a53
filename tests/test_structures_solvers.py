"""Factorizations: solutions of definite, indefinite and unsymmetric matrices, memory that is given back."""

import resource
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, splu

import substep as ss
from substep.core import memory
from substep.structures.examples import bar, solid
from substep.structures.solvers import factorization
from substep.structures.solvers import pardiso as pardiso_module
from substep.structures.solvers.factorization import SingularMatrix, cholmod, factorize, pardiso, superlu
from substep.structures.solvers.fill import factor_entries

N = 200
GPL = pytest.mark.skipif(not find_spec("cvxopt"), reason="cvxopt is not installed; its licence, the GPL, keeps it out")


def matrix(kind: str) -> Any:
    """Tridiagonal and two far couplings, of condition about 1e2 to 1e4."""
    off = np.full(N - 1, -1.0)
    A = sparse.diags_array([off, np.full(N, 2.05), off], offsets=[-1, 0, 1]).tolil()
    A[3, 160] = A[160, 3] = -0.02
    if kind == "indefinite":
        A.setdiag(np.where(np.arange(N) % 3, 2.05, -1.7))
    if kind == "unsymmetric":
        A[5, 100] = 0.7
    return sparse.csr_array(A)


@pytest.mark.parametrize("solver", [pardiso, superlu, pytest.param(cholmod, marks=GPL)], ids=lambda x: x.__name__)
@pytest.mark.parametrize("kind", ["definite", "indefinite", "unsymmetric"])
def test_solutions_are_those_of_lapack(solver: Any, kind: str) -> None:
    A = matrix(kind)
    smallest = np.linalg.eigvals(A.toarray()).real.min()
    assert (smallest > 0) == (kind != "indefinite")
    solve = solver(A)
    B = np.random.default_rng(0).normal(size=(N, 3))
    exact = np.linalg.solve(A.toarray(), B)
    assert np.abs(solve(B[:, 0].copy()) - exact[:, 0]).max() < 1e-11 * np.abs(exact).max()
    assert np.abs(solve(B) - exact).max() < 1e-11 * np.abs(exact).max()
    assert np.abs(solve(B[:, 1]) - exact[:, 1]).max() < 1e-11 * np.abs(exact).max()  # not contiguous


@pytest.mark.parametrize("solver", ["pardiso", "superlu", pytest.param("cholmod", marks=GPL)])
def test_a_singular_matrix_is_refused_with_its_place(solver: str) -> None:
    with pytest.raises(SingularMatrix):
        factorize(bar(N, fixed_ends=(False, False)).K, solver)
    loose = sparse.block_diag([matrix("definite"), bar(20, fixed_ends=(False, False)).K], format="csr")
    with pytest.raises(SingularMatrix) as refused:
        factorize(sparse.csr_array(loose), solver)
    assert refused.value.place >= N


def test_pardiso_keeps_the_half_of_a_symmetric_matrix() -> None:
    """Memory of the factors, kB, and the solution that many right sides at once have."""
    model = solid((6, 6, 6))
    half = pardiso_module.Pardiso(model.K)
    whole = pardiso_module.Pardiso(
        model.K + sparse.csr_array(([1e-3], ([0], [1])), shape=model.K.shape) * model.K.max()
    )
    assert half._parameters[16] < 0.65 * whole._parameters[16]
    B = np.random.default_rng(1).normal(size=(model.size, 5))
    X = half(B)
    assert np.linalg.norm(model.K @ X - B) < 1e-12 * np.linalg.norm(B)
    for b, x in zip(B.T, X.T, strict=True):
        assert np.abs(half(b) - x).max() < 1e-12 * np.abs(x).max()


@pytest.mark.parametrize("solver", ["pardiso", "superlu", pytest.param("cholmod", marks=GPL)])
def test_what_does_not_fit_in_memory_is_refused_before_it_is_tried(
    solver: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (memory, factorization):
        monkeypatch.setattr(module, "available_memory", lambda: 10_000)
    with pytest.raises(MemoryError, match=r"factors of 882 unknowns .* GB needed of 0.0 GB free"):
        factorize(solid((6, 6, 6)).K, solver)


@pytest.mark.parametrize("kind", ["dense", "dense array", "superlu, unsymmetric", "superlu, its own order"])
def test_factors_of_all_entries_and_unsymmetric_ones_are_refused_too(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    A = sparse.csr_array(solid((6, 6, 6)).K)
    if "order" in kind:
        monkeypatch.setattr(factorization, "find_spec", lambda _: None)
    if kind == "dense array":
        A = A.toarray()
    elif "unsymmetric" in kind:
        A = A + sparse.csr_array(([A.max()], ([3], [700])), shape=A.shape)
    for module in (memory, factorization):
        monkeypatch.setattr(module, "available_memory", lambda: 10_000)
    with pytest.raises(MemoryError, match=r"factors of 882 unknowns .* GB needed of 0.0 GB free"):
        factorize(A, kind.split(",", maxsplit=1)[0].split(maxsplit=1)[0])


def test_superlus_own_order_is_known_before_it_factorizes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The entries that are counted are those that its factor has, but for some that cancel."""
    counted: list[float] = []
    monkeypatch.setattr(factorization, "find_spec", lambda _: None)
    monkeypatch.setattr(factorization, "available_memory", lambda: 10_000)
    monkeypatch.setattr(factorization, "require_factors", lambda _, need: counted.append(need / 16))
    K = sparse.csc_array(solid((8, 8, 8)).K)
    superlu(K)
    known = splu(K, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).L.nnz
    assert counted == [pytest.approx(known, rel=1e-3)]


@pytest.mark.parametrize("wrong", [np.zeros_like, lambda b: b * np.nan, lambda b: b])
def test_a_solver_that_solves_something_else_is_told_from_a_singular_matrix(wrong: Any) -> None:
    with pytest.raises(
        ValueError, match="expected the solver to return x with matrix @ x = b, got another one"
    ) as found:
        factorize(matrix("definite"), lambda _: wrong)
    assert not isinstance(found.value, SingularMatrix)

    def broken(_: Any) -> Any:
        raise RuntimeError("licence server not found")

    with pytest.raises(RuntimeError, match="licence server not found"):
        factorize(matrix("definite"), broken)
    loose = matrix("definite").tolil()
    loose[7] = loose[:, 7] = 0.0
    with pytest.raises(SingularMatrix, match="degree of freedom 7 undetermined"):
        factorize(sparse.csr_array(loose), lambda _: wrong)
    with pytest.raises(SingularMatrix, match="degree of freedom 7 undetermined"):
        factorize(sparse.csr_array(loose), broken)


@pytest.mark.parametrize("shape", [(3, 4, 5), (6, 6, 6)])
def test_entries_of_the_factor_are_counted_before_it_is_computed(shape: tuple[int, int, int]) -> None:
    """As many as a dense factorization of a matrix of the pattern leaves, in any order."""
    given: Any = solid(shape).K
    K: Any = sparse.csr_array(abs(given) + abs(given.T))  # rounding leaves some entries on one side alone
    order = np.random.default_rng(0).permutation(K.shape[0])
    for places in (np.arange(K.shape[0]), order):
        A = sparse.csc_array(K[places][:, places])
        heavy = sparse.diags_array(2.0 * np.asarray(A.sum(axis=0))) - A  # of which no sum in the factor cancels
        expected = np.count_nonzero(np.linalg.cholesky(heavy.toarray()))
        assert factor_entries(A.indptr, A.indices) == expected


@GPL
def test_a_march_with_cholmod_is_that_with_pardiso() -> None:
    """Of a solid, whose effective matrices CHOLMOD factorizes itself, with load cases as several right sides."""
    made = []

    def counted(matrix: Any) -> Any:
        made.append(cholmod(matrix))
        return made[-1]

    load = [({"uz at 1 1 1": 1e6}, ss.HalfSine(1.0, 5e-4))]
    own, other = (
        ss.sweep(solid((4, 4, 4), solver=x), "bathe", dt=1e-4, t_end=1e-3, load=[load, 2 * load], progress=False)
        for x in (counted, "pardiso")
    )
    assert {solve.__qualname__ for solve in made} == {"cholmod.<locals>.solve"}
    assert np.abs(own.u - other.u).max() < 1e-10 * np.abs(other.u).max()


def test_a_solver_that_is_not_installed_is_refused_with_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(factorization, "find_spec", lambda name: None)
    for name, package in (("cholmod", "cvxopt"), ("pardiso", "pypardiso")):
        with pytest.raises(ValueError, match=f"expected {package} for solver='{name}', got none installed"):
            factorize(matrix("definite"), name)


def test_memory_is_given_back() -> None:
    """Sixty factorizations of 11 MB each leave no more behind than a few."""
    K = solid((8, 8, 8)).K

    def resident() -> float:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
        return pages * resource.getpagesize()

    pardiso(K)
    before = resident()
    for _ in range(60):
        pardiso(K)
    assert resident() - before < 60e6


def known_by_products(A: Any) -> LinearOperator:
    return LinearOperator(A.shape, matvec=lambda x: A @ x, rmatvec=lambda x: A.T @ x, dtype=float)


@pytest.mark.parametrize("scale", [1.0, 1e6])
def test_damping_known_by_its_products_is_that_matrix(scale: float) -> None:
    """Also where one part of the structure is stiffer than the rest by twelve orders of magnitude.

    There LAPACK's exchanges of rows cost up to two digits, on some processors, which SuperLU's order does not lose.
    """
    size = np.where(np.arange(N) < N // 2, 1.0, scale)
    K = sparse.csr_array(matrix("definite") * size * size[:, None])
    C = sparse.csr_array(matrix("unsymmetric") * np.sqrt(size) * np.sqrt(size)[:, None] * 0.2)
    start = {"u0": np.cos(np.arange(N)) / size}
    models = (
        ss.structure(sparse.eye_array(N), K, C=c, solver=way, **start)
        for c, way in ((known_by_products(C), "auto"), (C, "superlu"))
    )
    found, exact = (ss.march(model, "bathe", 0.1, 1.0, account=False).u * size for model in models)
    assert np.abs(found - exact).max() < 1e-12 * np.abs(exact).max()


def test_a_system_that_gmres_does_not_solve_is_refused() -> None:
    turn = sparse.csr_array(np.roll(np.eye(1500), 1, axis=0))  # whose Krylov spaces have no solution before the last
    with pytest.raises(ValueError, match=r"expected GMRES to solve .* got 1.0e\+00 of the right side .* as a matrix"):
        factorize(known_by_products(turn))(np.eye(1500)[0])
