"""Constraints that repeat others: the rank, what is left out, and what contradicts."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import Scene, rate
from substep_derive import t as time
from sympy import Expr, Matrix, Rational, Symbol, sin, symbols

import substep as ss

x, y = symbols("x y")


def sliding(start: tuple[float, float] = (1, 1), **held: Expr) -> Scene:
    """A point on the line x = y, held in several ways."""
    return Scene(
        "sliding",
        coordinates={x: "m", y: "m"},
        kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2,
        potential=y,
        constraints=held,
        parameters=(),
        start={x: start[0], y: start[1], rate(x): 0, rate(y): 0},
        length=1,
    )


@pytest.mark.usefixtures("uncompiled")
def test_the_motion_is_that_with_the_constraint_once() -> None:
    once = ss.scene(sliding(plane=x - y))
    found = ss.independent(sliding(plane=x - y, again=2 * x - 2 * y, bent=sin(x - y), squared=(x - y) ** 2))
    assert (found.rank, found.left_out) == (1, ("again", "bent", "squared"))
    assert str(found) == "sliding: 1 of 4 constraints are independent; left out: again, bent, squared"
    r, expected = (ss.march(scene, "bathe", dt=0.01, t_end=0.5) for scene in (found.scene, once))
    assert np.array_equal(r.u, expected.u)
    assert all(np.abs(off).max() < 1e-15 for off in found.off(r).values())


@pytest.mark.usefixtures("uncompiled")
def test_what_is_left_out_is_watched() -> None:
    """A constraint that holds at the start with its rate, and repeats the first there and nowhere else."""
    found = ss.independent(sliding(plane=x - y, other=x - y + (x - 1) ** 5))
    assert found.left_out == ("other",)
    r = ss.march(found.scene, "bathe", dt=0.01, t_end=1.0)
    drop = r.u[:, 0] - 1.0
    size = np.hypot(1.0 + 5.0 * drop**4, 1.0)
    assert found.off(r)["other"] == pytest.approx(drop**5 / size, abs=1e-14)


def test_nothing_is_left_out_of_independent_constraints() -> None:
    found = ss.independent(sliding(plane=x - y))
    assert (found.rank, found.left_out) == (1, ())
    assert str(found).endswith("none is left out")


@pytest.mark.parametrize(
    ("held", "start", "expected"),
    [
        ({"plane": x - y, "again": x - y - 1}, (1, 1), "can hold together, got 'again'"),
        ({"one": x - y, "other": x - y + (x - 1) ** 2}, (1, 1), "as nearby"),
    ],
)
def test_what_contradicts_or_is_singular_is_refused(held: Any, start: Any, expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        ss.independent(sliding(start, **held))


def test_dependent_constraints_name_the_cure() -> None:
    with pytest.raises(ValueError, match="1 independent of 2 .* or march the scene of ss.independent"):
        ss.scene(sliding(plane=x - y, again=2 * x - 2 * y))


@pytest.mark.parametrize(
    ("held", "expected"),
    [
        ({"a": x, "b": x - 1}, "1 independent of 2 at the start: a, b contradict each other there, by 1 in u; correct"),
        ({"a": x, "b": 5 * x - 10}, "a, b contradict each other there, by 2 in u"),
        ({"a": y - 1, "b": y - 1, "c": x, "d": x - 1}, "2 independent of 4 at the start: c, d contradict each other"),
        ({"a": x - 1 - time, "b": x - 1 - 4 * time}, "a, b contradict each other there, by 3 in v"),
        ({"a": (x**2 + y**2 - 1) / 2, "b": (x**2 + y**2 - 4) / 2}, "a, b contradict each other there, by 1.06 in u"),
        ({"a": x, "b": 2 * x}, "a, b repeat each other there"),
        ({"a": (x - 1) ** 2 + (y - 1) ** 2}, "0 independent of 1 at the start: a has no direction there"),
    ],
)
def test_constraints_that_cannot_hold_together_are_told_from_those_that_repeat_each_other(
    held: Any, expected: str
) -> None:
    """By how far apart what they ask of x is, or of its rate; of circles, of the first correction, 3/2 over sqrt(2)."""
    with pytest.raises(ValueError, match=expected):
        ss.scene(sliding(**held))


def bricard(pins: Expr | int = 0) -> Scene:
    """Five rods of 1 m along the edges of a cube and the ground, joined by six hinges; masses of the rods, and of pins.

    Rods are given by their ends, hinges by unit vectors at right angles to both rods and to the next hinge's.
    """
    ends = [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)]
    axes = [(0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0)]
    start: dict[Symbol, Any] = {}

    def vectors(name: str, values: list[tuple[int, ...]]) -> list[Matrix]:
        found = [Matrix(symbols(f"{name}{k}x {name}{k}y {name}{k}z")) for k in range(1, 5)]
        start.update({s: n for v, value in zip(found, values[1:5], strict=True) for s, n in zip(v, value, strict=True)})
        return [Matrix(values[0]), *found, Matrix(values[5])]

    P, A = vectors("p", ends), vectors("a", axes)
    kinetic, held = Rational(0), dict[str, Expr]()
    for k in range(5):
        first, last = (p.applyfunc(lambda s: rate(s) if s.is_Symbol else 0) for p in P[k : k + 2])
        rod = P[k + 1] - P[k]
        kinetic += (first.dot(first) + first.dot(last) + last.dot(last)) / 6
        held |= {f"rod{k}": (rod.dot(rod) - 1) / 2, f"twist{k}": A[k].dot(A[k + 1])}
        held |= {f"hinge{k}": rod.dot(A[k]), f"next{k}": rod.dot(A[k + 1])}
    for k in range(1, 5):
        turning = A[k].applyfunc(rate)
        kinetic += pins * turning.dot(turning) / 2
        held[f"axis{k}"] = (A[k].dot(A[k]) - 1) / 2
    return Scene(
        "bricard", coordinates=dict.fromkeys(start, "m"), kinetic=kinetic.expand(), potential=sum(p[1] for p in P),
        constraints=held, parameters=(), start=start | {rate(s): 0 for s in start}, length=1,
    )  # fmt: skip


def of_bricard(scene: ss.Scene, pins: float, t_end: float) -> np.ndarray:
    """The coordinates at the end, by equations for accelerations and reactions of least size, in NumPy.

    All constraints are kept, also the one that repeats others: of quadratic functions, whose second derivatives
    differences of their values give.
    """
    P = np.array([(0, 0, 0), (0, 0, 1)], float)
    A = np.array([(0, 1, 0), (1, 0, 0)], float)

    def constraints(x: np.ndarray) -> np.ndarray:
        points = np.vstack([P[:1], x[:12].reshape(4, 3), P[1:]])
        axes = np.vstack([A[:1], x[12:].reshape(4, 3), A[1:]])
        rods = np.diff(points, axis=0)
        both = [rods * rods, axes[:-1] * axes[1:], rods * axes[:-1], rods * axes[1:]]
        return np.concatenate([*(x.sum(axis=1) for x in both), (axes[1:5] ** 2).sum(axis=1)])

    names = [str(q) for q, _ in scene.coordinates]
    assert names[:3] == ["p1x", "p1y", "p1z"]
    assert names[12:15] == ["a1x", "a1y", "a1z"]
    unit, nothing = np.eye(24), constraints(np.zeros(24))
    single = np.array([constraints(e) for e in unit])
    second = np.array([[constraints(a + b) - x - y + nothing for b, y in zip(unit, single, strict=True)]
                       for a, x in zip(unit, single, strict=True)])  # fmt: skip
    first = single - nothing - second[np.arange(24), np.arange(24)] / 2
    M = np.zeros((24, 24))
    for k in range(5):
        for a, b, weight in ((k - 1, k - 1, 2), (k, k, 2), (k - 1, k, 1), (k, k - 1, 1)):
            if min(a, b) >= 0 and max(a, b) < 4:
                M[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += weight * np.eye(3) / 6
    M[12:, 12:] = pins * np.eye(12)
    force = np.zeros(24)
    force[1:12:3] = -1.0

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        x, v = y[:24], y[24:]
        G = (first + np.einsum("abc,b->ac", second, x)).T
        matrix = np.block([[M, G.T], [G, np.zeros((len(G), len(G)))]])
        right = np.concatenate([force, -np.einsum("abc,a,b->c", second, v, v)])
        return np.concatenate([v, np.linalg.lstsq(matrix, right, rcond=1e-10)[0][:24]])

    begin = np.concatenate([scene.u0, scene.v0])
    return solve_ivp(rates, (0.0, t_end), begin, method="DOP853", rtol=1e-11, atol=1e-12).y[:24, -1]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("scheme", "pins"), [("newmark", 0), ("generalized_alpha_mixed_displacement", 0), ("generalized_alpha", "1/100")]
)
def test_bricards_mechanism_is_marched_without_one_constraint_too_many(scheme: str, pins: Any) -> None:
    """Of 24 coordinates and one degree of freedom, 47 unknowns: what is left out is kept all the same.

    A scheme that takes accelerations at two knots needs a mass of the pins, too.
    """
    found = ss.independent(bricard(Rational(pins)))
    assert (found.rank, len(found.left_out)) == (23, 1)
    at_end, errors = of_bricard(found.scene, float(Rational(pins)), 1.0), []
    for n in (100, 200):
        r = ss.march(found.scene, scheme, 1.0 / n, 1.0)
        assert r.status == "completed"
        assert max(np.abs(x).max() for x in found.off(r).values()) < 1e-13
        np.testing.assert_allclose(r.energy, r.energy[0], rtol=0, atol=1e-5)
        errors.append(np.abs(r.u[-1] - at_end).max())
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
