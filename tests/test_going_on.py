"""A run that goes on from another is the run that was not broken."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from declared import TOGETHER, UNDAMPED
from plain_kernels import SCENE_BY_NAME

import substep as ss

SCHEMES = ss.schemes()
LOADS: dict[str, Any] = {
    "none": None,
    "harmonic": ss.Harmonic(2.0, 3.0, 0.4),
    "record": ss.Record(0.05, np.sin(np.arange(200.0) ** 1.5)),
    "own": lambda t: np.cos(2.0 * t) + 0.1 * t,
}


def same(whole: ss.Response, *parts: ss.Response) -> None:
    for name in ("t", "u", "v", "a"):
        together = [getattr(parts[0], name), *(getattr(part, name)[1:] for part in parts[1:])]
        assert np.array_equal(np.concatenate(together), getattr(whole, name)), name
    assert whole.status == parts[-1].status
    # Newton may fail on stages of a hard contact that are solved together
    assert whole.status == "completed" or str(whole.scheme.name) in TOGETHER


def broken(model: Any, scheme: Any, dt: float, ends: tuple[float, float, float], **options: Any) -> None:
    whole = ss.march(model, scheme, dt=dt, t_end=ends[-1], **options)
    parts = [ss.march(model, scheme, dt=dt, t_end=ends[0], **options)]
    for end in ends[1:]:
        parts.append(ss.march(model, scheme, dt=dt, t_end=end, start=parts[-1], **options))
    same(whole, *parts)


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_an_oscillator_goes_on_to_the_bit(scheme: str, load: str) -> None:
    xi = 0.0 if scheme in UNDAMPED else 0.05
    scene = ss.scene("linear_oscillator", omega=3.0, xi=xi, u0=0.3, v0=-1.0, load=LOADS[load])
    broken(scene, scheme, 0.05, (1.5, 1.55, 4.0))


@pytest.mark.filterwarnings("ignore:.*has gained energy on penalty_bounce")  # at this step many schemes do
@pytest.mark.pairs
@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scene", sorted({*SCENE_BY_NAME} - {"linear_oscillator", "elastic_pendulum_engineering"}))
@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_scene_goes_on_to_the_bit(scheme: str, scene: str) -> None:
    parameters = {"elastic_pendulum": {"EA": 1e4}, "duffing": {"eps": 0.5}}.get(scene, {})
    dt = 1e-4 if scene == "bathe_noh" else 0.01  # explicit schemes are unstable there beyond 6e-4
    broken(ss.scene(scene, **parameters), scheme, dt, (5 * dt, 6 * dt, 20 * dt))


@pytest.mark.parametrize("scene", ["linear_oscillator", "bathe_noh"])
def test_time_goes_on_where_steps_of_another_length_follow(scene: str) -> None:
    """The start at 0.007 is no multiple of the next step; the reference is the same scheme at a fine step."""
    given = {"omega": 3.0, "load": LOADS["harmonic"]} if scene == "linear_oscillator" else {"k1": 100.0}
    model, load = ss.scene(scene, **given), ("dormand_prince", 0.0005)
    whole = ss.march(model, load[0], dt=load[1], t_end=0.357)
    first = ss.march(model, load[0], dt=load[1], t_end=0.007)
    then = ss.march(model, load[0], dt=0.002, t_end=0.357, start=first)
    assert then.t[0] == pytest.approx(0.007, rel=1e-15)
    assert np.abs(then.u[-1] - whole.u[-1]).max() < 1e-9 * np.abs(whole.u).max()


@pytest.mark.usefixtures("plain_adaptive")
@pytest.mark.parametrize("scene", ["linear_oscillator", "duffing", "bathe_noh", "elastic_pendulum"])
def test_a_scene_goes_on_in_chosen_steps(scene: str) -> None:
    given = {
        "linear_oscillator": {"omega": 3.0, "load": LOADS["record"]}, "bathe_noh": {"k1": 100.0},
        "elastic_pendulum": {"EA": 1e3}, "duffing": {"eps": 0.5},
    }[scene]  # fmt: skip
    model = ss.scene(scene, **given)
    exact = ss.march(model, "dormand_prince", dt=0.0005, t_end=1.2).u[-1]
    first = ss.march(model, "bathe", tol=1e-6, t_end=0.53)
    then = ss.march(model, "bathe", tol=1e-6, t_end=1.2, start=first)
    assert (then.t[0], then.t[-1]) == (0.53, 1.2)
    assert then.statistics is not None
    assert then.statistics.accepted > 10
    assert np.abs(then.u[-1] - exact).max() < 1e-3 * np.abs(then.u).max()
    rows = ss.march(model, "bathe", tol=1e-6, t_end=1.2, start=first, at=[0.53, 0.7, 1.2])
    assert np.array_equal(rows.u[[0, -1]], then.u[[0, -1]])


def frame(**options: Any) -> Any:
    K = np.array([[6.0, -2.0, 0.0], [-2.0, 4.0, -1.0], [0.0, -1.0, 2.0]])
    given = {"load": ([1.0, 0.0, 2.0], LOADS["harmonic"]), "u0": [0.1, 0.2, -0.1], "v0": [0.0, 1.0, 0.0]}
    return ss.structure(np.diag([2.0, 1.0, 1.0]), **({"K": K} | given | options))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_structure_goes_on_to_the_bit(scheme: str) -> None:
    C = None if scheme in UNDAMPED else 0.05 * np.diag([3.0, 1.0, 1.0])
    broken(frame(C=C), scheme, 0.05, (1.0, 1.05, 2.0), account=False)


def hardening(u: np.ndarray) -> np.ndarray:
    return np.array([6.0 * u[0] - 2.0 * u[1] + u[0] ** 3, -2.0 * u[0] + 4.0 * u[1] - u[2], 2.0 * u[2] - u[1]])


def slope(u: np.ndarray) -> np.ndarray:
    return np.array([[6.0 + 3.0 * u[0] ** 2, -2.0, 0.0], [-2.0, 4.0, -1.0], [0.0, -1.0, 2.0]])


@pytest.mark.parametrize("scheme", [name for name in SCHEMES if name != "energy_momentum"])
def test_a_nonlinear_structure_goes_on_to_the_bit(scheme: str) -> None:
    broken(frame(K=None, internal_force=hardening, tangent=slope), scheme, 0.05, (0.5, 0.55, 1.0), account=False)


@pytest.mark.usefixtures("plain_marches")
@pytest.mark.parametrize("start", ["moving", "rest"])
@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_modes_go_on_to_the_bit(scheme: str, coupled: bool, start: str) -> None:
    if coupled and scheme in UNDAMPED:
        return
    still = {"u0": 0.0, "v0": 0.0} if start == "rest" else {}
    modes = frame(C=0.05 * np.diag([3.0, 1.0, 1.0]) if coupled else None, **still).modes(3)
    whole = ss.march(modes, scheme, dt=0.05, t_end=2.0, account=False)
    first = ss.march(modes, scheme, dt=0.05, t_end=1.0, account=False)
    then = ss.march(modes, scheme, dt=0.05, t_end=2.0, start=first, account=False)
    last, expected = then.state, whole.state
    assert last.history.keys() == expected.history.keys()
    assert last.more.keys() == expected.more.keys()
    for kind in ("history", "more"):
        for name, x in getattr(last, kind).items():
            assert np.array_equal(x, getattr(expected, kind)[name]), name
    assert np.allclose(then.u, whole.u[20:], rtol=0.0, atol=1e-15)  # the sum over modes rounds as their number of rows


OSCILLATOR = ss.scene("linear_oscillator", omega=3.0, xi=0.02, u0=0.3, v0=-1.0, load=LOADS["record"])
EXACT_ALIKE = ("bathe", "generalized_alpha", "bdf3", "park", "rk4")


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_state_that_was_saved_goes_on_as_the_one_in_memory(scheme: str, tmp_path: Path) -> None:
    scene = OSCILLATOR if scheme not in UNDAMPED else ss.scene("linear_oscillator", omega=3.0, u0=0.3)
    first = ss.march(scene, scheme, dt=0.05, t_end=1.5)
    first.state.save(tmp_path / "state.nc")
    first.save(tmp_path / "response.nc")
    kept = [ss.load(tmp_path / name) for name in ("state.nc", "response.nc")]
    one, *others = (ss.march(scene, scheme, dt=0.05, t_end=3.0, start=start) for start in (first, *kept))
    assert all(np.array_equal(one.u, other.u) and np.array_equal(one.a, other.a) for other in others)


@pytest.mark.parametrize("model", [frame(), frame().modes(2), frame(K=None, internal_force=hardening, tangent=slope)])
def test_the_state_of_a_structure_is_saved_with_what_its_march_keeps(model: Any, tmp_path: Path) -> None:
    first = ss.march(model, "generalized_alpha", dt=0.05, t_end=0.5, account=False)
    first.state.save(tmp_path / "state.nc")
    one, other = (
        ss.march(model, "generalized_alpha", dt=0.05, t_end=1.0, start=start, account=False)
        for start in (first.state, ss.load(tmp_path / "state.nc"))
    )
    assert np.array_equal(one.u, other.u)


def exact(scene: ss.Scene, t: np.ndarray) -> np.ndarray:
    """u of the undamped oscillator of unit frequency from (1, 0) at t = 0."""
    return np.cos(scene.parameters["omega"] * t)


@pytest.mark.parametrize("to", ["newmark", "bathe", "bdf3", "generalized_alpha", "rk4", "houbolt"])
@pytest.mark.parametrize("dt", [0.01, 0.003, 1 / 128])
def test_another_scheme_and_step_start_from_the_motion(to: str, dt: float) -> None:
    scene = ss.scene("linear_oscillator", omega=1.0)
    first = ss.march(scene, "rk4", dt=0.01, t_end=1.0)
    r = ss.march(scene, to, dt=dt, t_end=1.0 + 300 * dt, start=first)
    assert r.t[0] == 1.0
    assert r.t[-1] == pytest.approx(1.0 + 300 * dt, rel=1e-12)
    error = np.abs(r.u[:, 0] - exact(scene, r.t)).max()
    assert error < 60.0 * dt**2, error


def test_the_load_goes_on_where_it_was() -> None:
    load = ss.Harmonic(1.0, 2.0)
    scene = ss.scene("linear_oscillator", omega=3.0, load=load, u0=0.0)
    whole = ss.march(scene, "rkn64", dt=0.01, t_end=3.0)
    first = ss.march(scene, "rkn64", dt=0.01, t_end=1.0)
    finer = ss.march(scene, "rkn64", dt=0.007, t_end=1.0 + 0.007 * 200, start=first)
    assert np.abs(finer.u[-1, 0] - np.interp(finer.t[-1], whole.t, whole.u[:, 0])) < 1e-4
    assert finer.u[100, 0] == pytest.approx(whole.u[170, 0], abs=1e-9)


def test_stages_of_load_one_after_another() -> None:
    """Dead load at rest, a push, free vibration: the last stage is that of the same start by hand."""
    dead, push = ([0.0, 1.0, 0.0], ss.Step(1.0)), ([0.0, 0.0, 1.0], ss.Step(0.5))
    model = frame(load=[dead], u0="static", v0=0.0)
    still = ss.march(model, "generalized_alpha", dt=0.05, t_end=1.0)
    assert np.abs(still.u - still.u[0]).max() < 1e-14
    pushed = ss.march(frame(load=[dead, push], u0=0.0, v0=0.0), "generalized_alpha", dt=0.05, t_end=2.0, start=still)
    free = ss.march(model, "generalized_alpha", dt=0.05, t_end=4.0, start=pushed)
    by_hand = frame(load=[dead], u0=pushed.u[-1], v0=pushed.v[-1], a0=pushed.a[-1])
    expected = ss.march(by_hand, "generalized_alpha", dt=0.05, t_end=2.0)
    assert np.allclose(free.u, expected.u, rtol=0.0, atol=1e-13)
    assert free.t[0] == 2.0
    assert free.t[-1] == 4.0


def test_modes_take_what_another_load_leaves() -> None:
    model = frame(C=None)
    shaken = ss.march(model.modes(3), "generalized_alpha", dt=0.05, t_end=1.0)
    other = frame(load=([0.0, 1.0, 1.0], LOADS["own"]))
    by_modes = ss.march(other.modes(3), "generalized_alpha", dt=0.05, t_end=2.0, start=shaken)
    whole = ss.march(other, "generalized_alpha", dt=0.05, t_end=2.0, start=ss.march(
        model, "generalized_alpha", dt=0.05, t_end=1.0))  # fmt: skip
    assert np.allclose(by_modes.u, whole.u, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("scheme", ["bathe", "newmark", "generalized_alpha"])
def test_chosen_steps_go_on(scheme: str) -> None:
    model = frame(C=0.02 * np.diag([3.0, 1.0, 1.0]))
    whole = ss.march(model, scheme, tol=1e-6, t_end=4.0, account=False)
    first = ss.march(model, scheme, tol=1e-6, t_end=1.7, account=False)
    then = ss.march(model, scheme, tol=1e-6, t_end=4.0, start=first, account=False)
    assert then.t[0] == 1.7
    assert then.t[-1] == 4.0
    assert then.statistics is not None
    assert first.statistics is not None
    assert then.statistics.shortest > 0.2 * first.statistics.shortest
    assert np.abs(then.u[-1] - whole.u[-1]).max() < 1e-4


def test_what_was_lost_in_a_failure_starts_anew() -> None:
    first = ss.march("duffing", "central_difference", dt=0.1, t_end=2.0, energy_bound=1e9)
    assert first.state.history
    broken = ss.march(ss.scene("linear_oscillator", omega=100.0), "central_difference", dt=0.1, t_end=100.0)
    assert broken.status == "non_finite"
    assert not broken.state.history
    assert broken.state.t == broken.t[-1]


@pytest.mark.parametrize("model", [OSCILLATOR, frame(), frame().modes(2)], ids=["scene", "structure", "modes"])
def test_an_acceleration_that_is_left_out_is_missed_where_the_scheme_has_its_own(model: Any) -> None:
    """That of HHT differs from the equation of motion's; those of Newmark and Bathe do not."""
    call: dict[str, Any] = {"dt": 0.05, "t_end": 2.0}
    whole = ss.march(model, "hht_alpha", **call)
    known: dict[str, Any] = {"t": whole.t[20], "u": whole.u[20], "v": whole.v[20]}
    with pytest.warns(UserWarning, match=r"no acceleration at t = 1, and hht_alpha carries .* 'a': r.a\[-1\], or"):
        anew = ss.march(model, "hht_alpha", start=known, **call)
    assert np.abs(anew.u - whole.u[20:]).max() > 1e-8
    assert np.array_equal(ss.march(model, "hht_alpha", start={**known, "a": "consistent"}, **call).u, anew.u)
    on = ss.march(model, "hht_alpha", start={**known, "a": whole.a[20]}, **call)
    assert np.allclose(on.u, whole.u[20:], rtol=0.0, atol=1e-13)
    for scheme in ("newmark", "bathe", "bdf3"):
        ss.march(model, scheme, start=known, **call)
    ss.march(model, "hht_alpha", start={**known, "t": 0.0}, **call)


def test_an_acceleration_that_was_given_to_a_structure_is_named_where_it_does_not_fit() -> None:
    """As on a scene; without one nothing is computed for a print, nor where a was not kept."""
    given = {"u": np.zeros(3), "v": np.zeros(3), "a": [1.0, 0.0, 0.0]}
    said = [
        repr(ss.march(model, "newmark", dt=0.05, t_end=1.0, start=start, account=False))
        for model, start in ((frame(), None), (frame(a0=5.0), None), (frame(), given))
    ]
    assert [" from the equation of motion)" in text for text in said] == [False, True, True]
    assert repr(ss.march(frame(a0=5.0), "rk4", dt=0.05, t_end=1.0, dofs=[0])).endswith("completed)")


@pytest.mark.parametrize(
    ("start", "match"),
    [
        (3.0, "expected start as a response"),
        ({"u": 1.0}, "a dictionary with u and v"),
        ({"u": 1.0, "v": 0.0, "w": 2.0}, "a part of start"),
        ({"u": [1.0, 2.0], "v": 0.0}, "with 1 numbers"),
        ({"u": np.nan, "v": 0.0}, "u"),
        ({"u": 1.0, "v": 0.0, "a": 0.0, "history": {"u[-1]": 1.0}}, r"expected u\b.* in the history"),
        ({"t": 4.0, "u": 1.0, "v": 0.0}, "t_end after the start"),
    ],
)
def test_what_no_run_can_go_on_from_is_refused(start: Any, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        ss.march(ss.scene("linear_oscillator", omega=1.0), "houbolt", dt=0.1, t_end=3.0, start=start)


def test_a_history_of_the_users_own_is_taken() -> None:
    scene, dt = ss.scene("linear_oscillator", omega=2.0), 0.05
    whole = ss.march(scene, "houbolt", dt=dt, t_end=2.0)
    u = whole.u[:, 0]
    start = {"t": 1.0, "u": u[20], "v": whole.v[20, 0], "history": {"u": u[20], "u[-1]": u[19], "u[-2]": u[18]}}
    r = ss.march(scene, "houbolt", dt=dt, t_end=2.0, start=start)
    assert np.allclose(r.u[:, 0], u[20:], rtol=1e-13, atol=1e-14)


def test_a_scene_starts_at_rest_under_its_load() -> None:
    scene = ss.scene("linear_oscillator", omega=3.0, u0="static", load=lambda t: 2.0 + 0.0 * t)
    assert scene.parameters["u0"] == pytest.approx(2.0 / 9.0, rel=1e-14)
    r = ss.march(scene, "generalized_alpha", dt=0.1, t_end=5.0)
    assert np.abs(r.u - 2.0 / 9.0).max() < 1e-13
    assert ss.scene("duffing", u0="static").parameters["u0"] == 0.0
    with pytest.raises(ValueError, match="'static'"):
        ss.scene("duffing", u0="rest")


def test_a_start_that_is_inconsistent_is_named_with_its_jump() -> None:
    scene = ss.scene("linear_oscillator", omega=2.0, a0=1.0)
    r = ss.march(scene, "newmark", dt=0.1, t_end=1.0)
    assert r.jump == pytest.approx([5.0])  # 1 - (-omega^2 u0)
    assert "a starts 5 from the equation of motion" in repr(r)
    assert "starts" not in repr(ss.march(ss.scene("linear_oscillator", omega=2.0), "newmark", dt=0.1, t_end=1.0))
    loaded = frame(load=[([1.0, 0.0, 0.0], ss.Step(3.0))])
    first = ss.march(frame(load=[]), "generalized_alpha", dt=0.05, t_end=1.0)
    added = ss.march(loaded, "generalized_alpha", dt=0.05, t_end=2.0, start=first)
    anew = ss.march(loaded, "generalized_alpha", dt=0.05, t_end=2.0, start=first.state.consistent())
    assert np.abs(added.jump).max() > 1.0
    assert np.abs(anew.jump).max() < 1e-12


# at, until


@pytest.mark.parametrize("scheme", SCHEMES)
def test_rows_at_any_time_keep_the_order_of_the_scheme(scheme: str) -> None:
    """Between the steps the error is at most a few times that at their ends."""
    scene = ss.scene("linear_oscillator", omega=3.0, u0=1.0, v0=-2.0)
    steps = ss.march(scene, scheme, dt=0.01, t_end=2.0)
    times = np.linspace(0.0, 2.0, 777)
    r = ss.march(scene, scheme, dt=0.01, t_end=2.0, at=times)
    assert np.array_equal(r.t, times)

    def error(at: ss.Response) -> float:
        return float(np.abs(at.u[:, 0] - np.cos(3.0 * at.t) + 2.0 / 3.0 * np.sin(3.0 * at.t)).max())

    order = (ss.scheme(scheme).order or (2,))[0]
    assert error(r) <= 1.1 * error(steps) + (1e-12 if order <= 4 else 1e-9)
    ends = ss.march(scene, scheme, dt=0.01, t_end=2.0, at=steps.t)
    assert np.array_equal(ends.u, steps.u)
    assert np.array_equal(ends.v, steps.v)


@pytest.mark.usefixtures("plain_adaptive")
@pytest.mark.parametrize("model", ["oscillator", "structure", "modes"])
@pytest.mark.parametrize("steps", [{"dt": 0.01}, {"tol": 1e-8}])
def test_a_run_ends_at_the_first_of_its_events(model: str, steps: dict[str, float]) -> None:
    if model == "modes" and "tol" in steps:
        return
    made = {
        "oscillator": lambda: ss.scene("linear_oscillator", omega=2.0, u0=1.0),
        "structure": lambda: ss.structure([[1.0]], [[4.0]], u0=1.0),
        "modes": lambda: ss.structure([[1.0]], [[4.0]], u0=1.0).modes(1),
    }[model]()
    events = [lambda t, u, v: u[0] + 0.5, lambda t, u, v: u[0], lambda t, u, v: t - 10.0]
    r = ss.march(made, "newmark", **steps, t_end=4.0, until=events)
    assert r.t_events is not None
    assert np.isnan(r.t_events[[0, 2]]).all()
    assert r.t_events[1] == pytest.approx(np.pi / 4, abs=1e-4)
    assert r.t[-1] == r.t_events[1]
    assert abs(r.u[-1, 0]) < 1e-14
    assert r.status == "completed"
    assert np.isfinite(r.energy).all()
    assert len(r.energy) == len(r.t)
    on = ss.march(made, "newmark", dt=0.01, t_end=r.t[-1] + 0.5, start=r)
    assert on.v[0, 0] == pytest.approx(-2.0, abs=1e-3)


def test_an_event_at_the_start_is_not_one() -> None:
    r = ss.march(ss.scene("linear_oscillator", omega=2.0, u0=0.0, v0=1.0), "rk4", dt=0.01, t_end=9.0,
                 until=lambda t, u, v: u[0])  # fmt: skip
    assert r.t[-1] == pytest.approx(np.pi / 2, abs=1e-7)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"at": [0.0, 2.0, 1.0]}, "ascending"),
        ({"at": [-1.0, 0.0]}, "within the run"),
        ({"at": [0.5], "stride": 2}, "without stride"),
        ({"until": lambda t, u, v: u}, "one number"),
        ({"until": lambda t, u, v: np.nan}, "one number"),
    ],
)
def test_times_and_events_that_cannot_be_are_refused(options: dict[str, Any], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        ss.march(ss.scene("linear_oscillator", omega=1.0), "newmark", dt=0.1, t_end=1.0, **options)


def test_rows_of_a_structure_at_any_time_keep_their_account_in_balance() -> None:
    model = frame(C=0.05 * np.diag([3.0, 1.0, 1.0]))
    r = ss.march(model, "newmark", dt=0.05, t_end=2.0, at=np.linspace(0.0, 2.0, 33), dofs=[0, 2])
    assert r.u.shape == (33, 2)
    account = r.account
    assert account is not None
    mechanical = account.kinetic + account.strain
    left = account.work - account.damped - (mechanical - mechanical[0]) - account.numerical - account.residual
    assert np.abs(left).max() < 1e-14
