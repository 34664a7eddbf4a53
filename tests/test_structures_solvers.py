"""Factorizations: solutions of definite, indefinite and unsymmetric matrices, memory that is given back."""

import resource
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import sparse

from substep.structures import pardiso as pardiso_module
from substep.structures.examples import bar, solid
from substep.structures.solvers import SingularMatrix, factorize, pardiso, superlu

N = 200


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


@pytest.mark.parametrize("solver", [pardiso, superlu], ids=["pardiso", "superlu"])
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


@pytest.mark.parametrize("solver", ["pardiso", "superlu"])
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


def test_what_does_not_fit_in_memory_is_refused_before_it_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pardiso_module, "available_memory", lambda: 10_000)
    with pytest.raises(MemoryError, match=r"factors of 882 unknowns .* GB needed of 0.0 GB free"):
        factorize(solid((6, 6, 6)).K, "pardiso")


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
