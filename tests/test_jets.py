"""Power series in several variables against SymPy's derivatives."""

import numpy as np
import pytest
from sympy import Expr, Matrix, cosh, exp, lambdify, sin, symbols

from substep.core.jets import Jet, Space, solved

DEGREE = 4
x = symbols("x:3")
POINTS = np.array([[0.3, -0.7], [0.0, 1.1], [0.9, 0.4]])


def expected(e: Expr, along: np.ndarray) -> np.ndarray:
    """The derivative along vectors (k, 3, P) at the points, (P,)."""
    steps = symbols(f"s:{len(along)}")
    found = []
    for point, vectors in zip(POINTS.T, np.moveaxis(along, 2, 0), strict=True):
        moved = [p + sum(s * v for s, v in zip(steps, vectors[:, k], strict=True)) for k, p in enumerate(point)]
        value = e.subs(dict(zip(x, moved, strict=True)), simultaneous=True)
        for s in steps:
            value = value.diff(s).subs(s, 0)
        found.append(float(value))
    return np.array(found)


def derivative(space: Space, series: np.ndarray, along: np.ndarray) -> np.ndarray:
    for v in along:
        series = space.along(series, v)
    return series[..., 0, :]


@pytest.mark.parametrize(
    "e",
    [
        x[0] * x[1] ** 2 - 3 * x[2] ** 5 / 7 + 2,
        (1 + x[0] ** 2) ** 1.5 / (2 - x[1]),
        1 / (3 + x[0] * x[2]) - x[1] ** 3,
        5 - (x[0] - x[1]) / 4 + x[2] ** 6,
    ],
)
@pytest.mark.parametrize("times", range(DEGREE + 1))
def test_derivatives_along_vectors(e: Expr, times: int) -> None:
    space = Space(3, DEGREE)
    along = np.random.default_rng(times).normal(size=(times, 3, 2))
    jet = lambdify(x, e, modules=[{}])(*space.variables_at(POINTS))
    assert isinstance(jet, Jet)
    assert derivative(space, jet.coefficients, along) == pytest.approx(expected(e, along), rel=1e-12, abs=1e-12)


def test_functions_and_linear_systems() -> None:
    space, along = Space(3, 2), np.random.default_rng(1).normal(size=(2, 3, 2))
    matrix = Matrix([[3 + sin(x[0]), x[1] * x[2]], [exp(x[2]) / 4, 2 + x[0] ** 2]])
    right = Matrix([cosh(x[1]), x[0]])
    terms = {
        "sin": lambda c: [np.sin(c), np.cos(c), -np.sin(c) / 2],
        "exp": lambda c: [np.exp(c), np.exp(c), np.exp(c) / 2],
        "cosh": lambda c: [np.cosh(c), np.sinh(c), np.cosh(c) / 2],
    }
    functions = {name: lambda jet, of=of: jet.composed(of(jet.value)) for name, of in terms.items()}
    A, b = lambdify(x, [matrix.tolist(), list(right)], modules=[functions])(*space.variables_at(POINTS))
    found = derivative(space, solved(A, b, space, 2), along)
    for part, e in zip(found, matrix.inv() * right, strict=True):
        assert part == pytest.approx(expected(e, along), rel=1e-10)
