"""Constraints that repeat others: the rank, what is left out, and what contradicts."""

from typing import Any

import numpy as np
import pytest
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


def bricard() -> Scene:
    """Five rods of 1 m along the edges of a cube and the ground, joined by six hinges; masses of the rods alone.

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
    held |= {f"axis{k}": (A[k].dot(A[k]) - 1) / 2 for k in range(1, 5)}
    return Scene(
        "bricard", coordinates=dict.fromkeys(start, "m"), kinetic=kinetic.expand(), potential=sum(p[1] for p in P),
        constraints=held, parameters=(), start=start | {rate(s): 0 for s in start}, length=1,
    )  # fmt: skip


@pytest.mark.thorough
def test_bricards_mechanism_has_one_constraint_too_many() -> None:
    found = ss.independent(bricard())
    assert (found.rank, len(found.left_out)) == (23, 1)  # 24 coordinates and one degree of freedom
