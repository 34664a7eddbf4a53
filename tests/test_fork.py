"""A run in chosen steps that goes on has, after its start, the rows of the run that was not broken, to the bit."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_adaptive import cost

import substep as ss

pytestmark = pytest.mark.usefixtures("plain_adaptive")

TOL, T_END = 1e-4, 1.2
RECORD = ss.Record(0.05, np.sin(np.arange(200.0) ** 1.5))
SCENES: dict[str, Any] = {
    "from rest": ss.scene("linear_oscillator", omega=3.0, u0=0.0, load=ss.Harmonic(2.0, 3.0)),
    "record": ss.scene("linear_oscillator", omega=3.0, u0=0.0, load=RECORD),
    "jump": ss.scene("linear_oscillator", omega=3.0, u0=1.0, load=ss.Step(2.0, start=0.5)),
    "duffing": ss.scene("duffing", eps=0.5),
    "pendulum": ss.scene("elastic_pendulum", EA=1e3),
    "bounce": ss.scene("penalty_bounce"),
    "law": ss.scene(
        "hysteretic_oscillator", omega=5.0, xi=0.05, strength=4.0, hardening=0.1, load=ss.HalfSine(12.0, 0.6)
    ),
}
K = np.array([[6.0, -2.0, 0.0], [-2.0, 4.0, -1.0], [0.0, -1.0, 2.0]])
MASS, MOVING = np.diag([2.0, 1.0, 1.0]), {"u0": [0.5, 0.2, -0.1], "v0": [0.0, 1.0, 0.0]}
BEAM = {
    "internal_force": lambda u: K @ u + np.array([u[0] ** 3, 0.0, 0.0]),
    "tangent": lambda u: K + np.diag([3.0 * u[0] ** 2, 0.0, 0.0]),
}
STRUCTURES: dict[str, Any] = {
    "linear": ss.structure(MASS, K, load=([1.0, 0.0, 2.0], ss.Harmonic(2.0, 3.0, 0.4)), **MOVING),
    "quake": ss.structure(MASS, K, C=ss.Rayleigh(0.1, 0.01)).ground_motion(RECORD, [1.0, 1.0, 1.0]),
    "nonlinear": ss.structure(MASS, **BEAM, **MOVING),
    "springs": ss.structure(
        [[1.0]], springs=[([1.0], ss.law("bilinear", k=25.0, q_y=4.0, alpha=0.1))], C=[[0.5]],
        load=([1.0], ss.HalfSine(12.0, 0.6)),
    ),
}  # fmt: skip
KINDS = ["newmark", "bathe", "generalized_alpha", "noh_bathe", "rk4", "dormand_prince", "kr_alpha_plain_start"]


def march(model: Any, scheme: str, t_end: float, **options: Any) -> ss.Response:
    still = {"account": False} if isinstance(model, ss.Structure) else {}
    return ss.march(model, scheme, **{"tol": TOL, "t_end": t_end} | still | options)


@cache
def whole(kind: str, model: str, scheme: str) -> ss.Response:
    return march({"scene": SCENES, "structure": STRUCTURES}[kind][model], scheme, T_END)


def require_rest_of(whole: ss.Response, then: ss.Response, t: float) -> None:
    """That all rows after t are those of the whole run."""
    later = whole.t > t * (1.0 + 1e-12)
    assert then.t[0] == t
    assert then.status == whole.status == "completed"
    for name in ("t", "u", "v", "a"):
        assert np.array_equal(np.asarray(getattr(then, name))[1:], np.asarray(getattr(whole, name))[later]), name
    for name in whole.memory:
        assert np.array_equal(then.memory[name][1:], whole.memory[name][later]), name
    assert np.array_equal(then.newton_iterations, whole.newton_iterations[later[1:]])


@pytest.mark.matrix
@pytest.mark.parametrize("t", [0.0123, 0.5])
@pytest.mark.parametrize("model", SCENES)
@pytest.mark.parametrize("scheme", KINDS)
def test_a_scene_goes_on_to_the_bit(scheme: str, model: str, t: float) -> None:
    """Also where a load jumps at the start, from complete rest, and where yielding is remembered."""
    first = march(SCENES[model], scheme, t)
    assert first.t[-1] == t
    require_rest_of(whole("scene", model, scheme), march(SCENES[model], scheme, T_END, start=first), t)


@pytest.mark.matrix
@pytest.mark.parametrize("t", [0.0123, 0.55])
@pytest.mark.parametrize("model", STRUCTURES)
@pytest.mark.parametrize("scheme", KINDS[:-1])
def test_a_structure_goes_on_to_the_bit(scheme: str, model: str, t: float, tmp_path: Path) -> None:
    """From the response that was saved, with the tangents that Newton's iterations keep."""
    march(STRUCTURES[model], scheme, t).save(tmp_path / "r.nc")
    then = march(STRUCTURES[model], scheme, T_END, start=ss.load(tmp_path / "r.nc"))
    require_rest_of(whole("structure", model, scheme), then, t)


@pytest.mark.thorough
@settings(max_examples=12)
@given(st.data())
def test_it_may_be_broken_anywhere_and_often(data: Any) -> None:
    kind, models = data.draw(st.sampled_from([("scene", SCENES), ("structure", STRUCTURES)]))
    model, scheme = data.draw(st.sampled_from(sorted(models))), data.draw(st.sampled_from(["bathe", "newmark", "rk4"]))
    at = st.floats(1e-4, T_END - 1e-4) | st.sampled_from([0.05, 0.6, 1.15])
    r = None
    for t in sorted(set(data.draw(st.lists(at, min_size=1, max_size=3)))):
        r = march(models[model], scheme, t, start=r)
    require_rest_of(whole(kind, model, scheme), march(models[model], scheme, T_END, start=r), r.t[-1])  # type: ignore


@pytest.mark.parametrize("scheme", ["bathe", "dormand_prince"])
@pytest.mark.parametrize(
    "options", [{"atol": (1e-5, 1e-4)}, {"rung": 0.0}, {"rung": 2.0}, {"dt_max": 0.02}, {"dt_min": 1e-5, "rtol": 1e-3}]
)
@pytest.mark.parametrize("model", [SCENES["record"], STRUCTURES["linear"]])
def test_so_it_does_with_what_else_is_asked(model: Any, options: dict[str, Any], scheme: str) -> None:
    first = march(model, scheme, 0.53, **options)
    require_rest_of(march(model, scheme, T_END, **options), march(model, scheme, T_END, start=first, **options), 0.53)


@pytest.mark.parametrize("model", [SCENES["record"], SCENES["bounce"], STRUCTURES["nonlinear"]])
@pytest.mark.parametrize("scheme", ["bathe", "noh_bathe", "butcher6"])
def test_rows_between_steps_are_those_of_the_whole_run(scheme: str, model: Any) -> None:
    """In the step that passes the start, too; the schemes of high order end steps on these times."""
    t, times = 0.53, np.linspace(0.0, T_END, 49)
    expected = march(model, scheme, T_END, at=times)
    first = march(model, scheme, t, at=times[times < t])
    then = march(model, scheme, T_END, start=first, at=[t, *times[times > t]])
    assert np.array_equal(then.u[0], first.state.u)
    assert np.array_equal(then.u[1:], expected.u[times > t])
    assert np.array_equal(then.v[1:], expected.v[times > t])


@pytest.mark.parametrize("model", [SCENES["pendulum"], STRUCTURES["linear"]])
def test_an_event_in_the_step_that_passes_the_start_is_found_where_it_is(model: Any) -> None:
    """The start is so near to a row that the polynomial from it would be none of the motion's."""
    rows = march(model, "bathe", T_END)
    k = len(rows.t) // 2
    t, event = float(rows.t[k] - 1e-9), float(0.5 * rows.t[k] + 0.5 * rows.t[k + 1])
    first = march(model, "bathe", t)
    for end in (rows.t[k] - 5e-10, event):
        then = march(model, "bathe", T_END, start=first, until=lambda t, u, v, end=end: t - end)
        expected = march(model, "bathe", T_END, until=lambda t, u, v, end=end: t - end)
        assert then.t_events == expected.t_events
        assert np.array_equal(then.v[-1], expected.v[-1])


@pytest.mark.parametrize("kind", ["scene", "structure"])
@pytest.mark.parametrize("change", ["tol", "scheme", "load", "dt_first", "dt_max", "copied", "consistent"])
def test_where_something_has_changed_it_starts_at_the_end(kind: str, change: str) -> None:
    """As from the same state without a fork, in fewer steps than from the fork at worst."""
    model: Any = SCENES["from rest"] if kind == "scene" else STRUCTURES["linear"]
    first = march(model, "bathe", 0.53)
    options: dict[str, Any] = {
        "tol": {"tol": 2e-4}, "dt_first": {"dt_first": 1e-3}, "dt_max": {"dt_max": 0.04}
    }.get(change, {})  # fmt: skip
    scheme = "newmark" if change == "scheme" else "bathe"
    if change == "load":
        load = ss.Harmonic(2.0, 3.1)
        other = {"scene": lambda: ss.scene("linear_oscillator", omega=3.0, u0=0.0, load=load)}
        other["structure"] = lambda: ss.structure(MASS, K, load=([1.0, 0.0, 2.0], load), **MOVING)
        model = other[kind]()
    s = first.state
    start: Any = {"t": s.t, "u": s.u, "v": s.v, "a": s.a} if change == "copied" else s
    start = s.consistent() if change == "consistent" else start
    then = march(model, scheme, T_END, start=start, **options)
    anew = start if isinstance(start, dict) else replace(start, more={}, of="")
    expected = march(model, scheme, T_END, start=anew, **options)
    assert np.array_equal(then.t, expected.t)
    assert np.array_equal(then.u, expected.u)
    assert cost(then).accepted == len(then.t) - 1


def test_the_account_of_energy_begins_at_the_start() -> None:
    model = STRUCTURES["linear"]
    first, expected = (march(model, "bathe", t, account=True) for t in (0.53, T_END))
    then = march(model, "bathe", T_END, account=True, start=first)
    later = expected.t > 0.53
    assert then.account is not None
    assert expected.account is not None
    assert first.account is not None
    assert np.allclose(then.account.kinetic[1:], expected.account.kinetic[later], rtol=1e-14)
    assert then.account.work[0] == 0.0
    parts = [account.work[-1] + account.quadrature[-1] for account in (first.account, then.account, expected.account)]
    assert parts[0] + parts[1] == pytest.approx(parts[2], rel=1e-3)


def test_a_run_that_fails_before_it_comes_to_its_start_stands_there() -> None:
    """Steps from the fork may be longer than those that ended at t_end, and so fail where they did not."""
    model = SCENES["duffing"]
    first = march(model, "bathe", 0.53)
    state = first.state
    control = state.more["fork control"].copy()
    control[1] = np.nan  # the length that is tried next
    then = march(model, "bathe", T_END, start=replace(state, more={**state.more, "fork control": control}))
    assert then.status == "step_too_small"
    assert then.t.tolist() == [0.53]
    assert np.array_equal(then.state.u, first.u[-1])
