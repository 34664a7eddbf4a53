"""Constraints that cannot be kept later in a run: named with the time, with all rows before; and where runs stay."""

import warnings
from typing import Any

import numpy as np
import pytest
from substep_derive import Constraint, Scene, rate, t
from sympy import Rational, Symbol

import substep as ss

x, y, z = (Symbol(name) for name in "xyz")


def points(name: str, constraints: Any, start: dict[Any, tuple[Any, Any]], potential: Any = 0 * x) -> Scene:
    """Unit masses along coordinates with these displacements and velocities at the start."""
    begin = {c: u for c, (u, _) in start.items()} | {rate(c): v for c, (_, v) in start.items()}
    return Scene(
        name, coordinates=dict.fromkeys(start, "m"), kinetic=sum(rate(c) ** 2 for c in start) / 2, potential=potential,
        constraints=constraints, parameters=(), start=begin, length=1,
    )  # fmt: skip


def drawn_away(**reading: Any) -> Scene:
    """A point on a wall and on a rod of length 1, whose pivot leaves the wall: beyond t = 1 s there is none."""
    held = {"rod": ((x - t) ** 2 + y**2 - 1) / 2, "wall": x}
    constraints = {name: Constraint(g, **reading) for name, g in held.items()} if reading else held
    return points("drawn_away" + "".join(reading), constraints, {x: (0, 0), y: (1, 0)})


# z is held but at x = 1, where it is free under its weight
SLOT = points("slot", {"line": y, "slot": z * (1 - x)}, {x: (0, 1), y: (0, 0), z: (0, 0)}, 9.81 * z)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["average_acceleration", "generalized_alpha", "bathe", "central_difference"])
def test_constraints_that_contradict_each_other_are_named_with_the_time(name: str) -> None:
    r = ss.march(ss.scene(drawn_away()), name, dt=0.013, t_end=1.3)
    assert r.status == "newton_failed"
    assert r.t_failed is not None
    assert 1.0 - 0.013 <= r.t_failed <= 1.0 + 0.013
    assert np.allclose(r.u[:, 1] ** 2, 1 - r.t**2)  # what was computed before is there
    assert "constraint 'rod' and constraint 'wall' are not both kept after t = 1 s" in r.failure
    assert r.failure in repr(r)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("reading", [{"level": "velocity"}, {"level": "both"}, {"projected": True}])
def test_so_are_they_in_other_readings(reading: dict[str, Any]) -> None:
    r = ss.march(ss.scene(drawn_away(**reading)), "generalized_alpha", dt=0.013, t_end=1.3)
    assert "constraint 'rod' and constraint 'wall' are not both kept after t = 1 s" in r.failure


@pytest.mark.usefixtures("uncompiled")
def test_constraints_are_named_where_a_step_ends_on_them_repeating_each_other_and_in_chosen_steps() -> None:
    for run in ({"dt": 0.01}, {"tol": 1e-4}):
        r = ss.march(ss.scene(drawn_away()), "average_acceleration", t_end=1.5, **run)
        assert "constraint 'rod' and constraint 'wall' repeat each other at t = 1 s" in r.failure


@pytest.mark.usefixtures("uncompiled")
def test_a_constraint_alone_is_named() -> None:
    closing = points("closing", {"ring": (x**2 - 1 + t) / 2}, {x: (1, Rational(-1, 2)), y: (0, 0)})
    r = ss.march(ss.scene(closing), "bathe", dt=0.0123, t_end=1.23)
    assert "constraint 'ring' is not kept after t = 1 s by any displacement near the last row" in r.failure


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("name", "dt"), [("average_acceleration", 0.1), ("bathe", 0.1), ("houbolt", 0.1)])
def test_a_constraint_that_holds_no_direction_is_named(name: str, dt: float) -> None:
    r = ss.march(ss.scene(SLOT), name, dt=dt, t_end=2.0)
    assert r.status == "newton_failed"
    assert "constraint 'slot' holds no direction at t = 1 s" in r.failure


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("name", "dt"), [("bdf2", 0.25), ("backward_euler", 0.05)])
def test_a_completed_run_that_stays_where_a_constraint_holds_no_direction_is_warned_of(name: str, dt: float) -> None:
    with pytest.warns(UserWarning, match="slot: constraint 'slot' holds no direction from t = 1"):
        r = ss.march(ss.scene(SLOT), name, dt=dt, t_end=2.0)
    assert r.status == "completed"
    assert r.u[-1, 0] == pytest.approx(1.0, abs=1e-4)  # where it would be at 2


@pytest.mark.usefixtures("uncompiled")
def test_a_run_that_passes_over_the_position_is_not() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        r = ss.march(ss.scene(SLOT), "bathe", dt=0.01, t_end=2.0)
        ss.march("four_bar", "bathe", dt=0.01, t_end=3.0)  # in line at 0.74, 1.3 and 2.8 s
    assert r.u[-1, 0] == pytest.approx(2.0)


@pytest.mark.usefixtures("uncompiled")
def test_constraints_that_can_be_kept_are_not_blamed() -> None:
    r = ss.march("rod_pendulum", "bathe", dt=0.01, t_end=0.1)
    object.__setattr__(r, "status", "newton_failed")
    object.__setattr__(r, "t_failed", 0.11)
    assert r.failure == "the step to t = 0.11 s was not solved: take a smaller step"
