"""Sums and products of long vectors against NumPy's, over the borders of the blocks in which they are computed."""

from typing import Any

import numpy as np
import pytest
from numba import float64, int64, njit, types
from scipy import sparse
from substep_kernels.marches import linear_filter, linear_march_2_01y
from substep_kernels.shared import combinations

from substep.structures.solvers.combine import add_product, combined, inner_products, products
from substep.structures.solvers.low_rank import LowRank

SIZES = (1, 511, 512, 513, 1100)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("vectors", [1, 4, 5, 9])
def test_combinations_and_inner_products(n: int, vectors: int) -> None:
    random = np.random.default_rng(n)
    X, rows = random.normal(size=(vectors, n)), random.normal(size=(3, vectors))
    rows[1] = 0.0
    rows[2, : vectors // 2] = 0.0
    assert np.allclose(combined(rows, X), rows @ X, rtol=0, atol=1e-13)
    out = np.full((3, n), np.nan)
    assert combined(rows, X, out) is out
    assert np.allclose(out, rows @ X, rtol=0, atol=1e-13)
    then = random.normal(size=(2, 3))
    both = combined(rows, X, then=then)
    assert np.array_equal(both, np.concatenate([out, combined(then, out)]))
    assert np.allclose(inner_products(X, X[::-1]), X @ X[::-1].T, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("r", "m", "J"), [(1, 1, 0), (3, 7, 1), (5, 600, 2)])
def test_sums_over_modes(r: int, m: int, J: int) -> None:
    random = np.random.default_rng(m)
    X, before, weights = random.normal(size=(r, 3, m)), random.normal(size=(2, m)), random.random((3, m))
    forces, h, out = random.normal(size=(J, m)), 0.1, np.full((r, 5 + 2 * J), np.nan)
    combinations.sums_over_modes(X, before, weights, forces, h, out)
    q, v = (np.concatenate([before[kind : kind + 1], X[:, kind]]) for kind in range(2))
    d, faster, rest = q[1:] - q[:-1], v[1:] - v[:-1], h * (v[1:] + v[:-1]) - 2.0 * (q[1:] - q[:-1])
    squares = [v[1:] ** 2 @ weights[0], q[1:] ** 2 @ weights[1], *(x**2 @ weights[2] for x in (d, faster, rest))]
    expected = np.column_stack([*squares, d @ forces.T, v[1:] @ forces.T])
    assert np.allclose(out, expected, rtol=0, atol=1e-13 * m)


def test_vectors_with_zeros_in_a_row_are_not_read() -> None:
    X = np.array([[1.0, 2.0], [np.nan, np.inf]])
    assert combined(np.array([[3.0, 0.0]]), X).tolist() == [[3.0, 6.0]]


def matrices(n: int, random: np.random.Generator) -> dict[str, Any]:
    """Of five entries a row, kept in each way that a structure's matrices are."""
    full = random.normal(size=(n, n)) * (random.random((n, n)) < 5.0 / n)
    rows = sparse.csr_array(full)
    wide = rows.copy()
    wide.indices, wide.indptr = wide.indices.astype(np.int64), wide.indptr.astype(np.int64)
    low = LowRank(np.asfortranarray(random.normal(size=(n, 2))), np.array([1.0, -2.0]))
    return {"csr": rows, "csr, long indices": wide, "csc": rows.tocsc(), "dense": full, "low rank": low}


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("count", [1, 2, 3])
def test_products(n: int, count: int) -> None:
    random = np.random.default_rng(n)
    X, before = random.normal(size=(count, n)), random.normal(size=n)
    for name, matrix in matrices(n, random).items():
        full = matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
        assert np.allclose(products(matrix, X), X @ full.T, rtol=1e-12, atol=1e-11), name
        to = before.copy()
        add_product(matrix, X[0], to)
        assert np.allclose(to, before + full @ X[0], rtol=1e-12, atol=1e-11), name
        cases = np.zeros((n, count))
        add_product(matrix, np.ascontiguousarray(X.T), cases)
        assert np.allclose(cases, full @ X.T, rtol=1e-12, atol=1e-11), name


def test_loops_over_lanes_ask_for_the_widest_registers() -> None:
    """The function that holds the loop itself, since it is for that function that LLVM chooses."""
    loads = types.Array(float64, 1, "C", readonly=True)
    kernels: list[tuple[Any, Any]] = [
        (linear_march_2_01y._final_2, (float64[::1], loads, loads, int64, int64)),
        (linear_filter._filter_2_1, (float64[::1], loads)),
    ]
    for kernel, arguments in kernels:
        options = {name: value for name, value in kernel.targetoptions.items() if name not in ("cache", "nopython")}
        compiled: Any = njit(**options)(kernel.py_func)
        compiled.compile(arguments)
        (text,) = compiled.inspect_llvm().values()
        assert '"prefer-vector-width"="512"' in text
