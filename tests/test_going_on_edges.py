"""Where a run that goes on, or one with rows or an end between its steps, could go wrong without a word."""

import pickle
from typing import Any

import numpy as np
import pytest

import substep as ss

K = np.array([[6.0, -2.0, 0.0], [-2.0, 4.0, -1.0], [0.0, -1.0, 2.0]])
M = np.diag([2.0, 1.0, 1.0])


def frame(**options: Any) -> Any:
    return ss.structure(M, K, **({"u0": [0.1, 0.2, -0.1], "v0": [0.0, 1.0, 0.0]} | options))


PUSH = ([1.0, 0.0, 2.0], ss.Step(3.0))


@pytest.mark.parametrize("dt", [0.1, 0.001])
def test_an_acceleration_that_a_new_load_does_not_match_is_carried(dt: float) -> None:
    """By Newmark's textbook formulas on one oscillator, whose load jumps where the second run begins."""
    still, pushed = (ss.scene("linear_oscillator", omega=2.0, load=load) for load in (None, ss.Step(3.0)))
    first = ss.march(still, "newmark", dt=dt, t_end=10 * dt)
    then = ss.march(pushed, "newmark", dt=dt, t_end=20 * dt, start=first)
    u, v, a = (float(x[-1, 0]) for x in (first.u, first.v, first.a))
    for k in range(1, 11):
        ahead = u + dt * v + 0.25 * dt**2 * a
        new = (3.0 - 4.0 * ahead) / (1.0 + dt**2)
        u, v, a = ahead + 0.25 * dt**2 * new, v + 0.5 * dt * (a + new), new
        assert then.u[k, 0] == pytest.approx(u, rel=1e-12)
        assert then.v[k, 0] == pytest.approx(v, rel=1e-12)


@pytest.mark.parametrize("scheme", ["newmark", "bathe", "generalized_alpha", "bdf3"])
@pytest.mark.parametrize(
    "loads", [[([1.0, 0.0, 2.0], ss.Harmonic(1.0, 2.0))], [], [PUSH, ([0.0, 1.0, 0.0], ss.Step(1.0))]]
)
def test_modes_under_another_load_move_as_their_structure(scheme: str, loads: list[Any]) -> None:
    before, after = frame(load=PUSH), frame(load=loads)
    by_modes, whole = (
        ss.march(to, scheme, dt=0.05, t_end=2.0, start=ss.march(model, scheme, dt=0.05, t_end=1.0), account=False)
        for model, to in ((before.modes(3), after.modes(3)), (before, after))
    )
    assert np.abs(by_modes.u - whole.u).max() < 1e-12


def start_of(model: Any, scheme: str = "bdf3", **options: Any) -> ss.Response:
    return ss.march(model, scheme, dt=0.05, t_end=1.0, account=False, **options)


def going_on(model: Any, start: Any, scheme: str = "bdf3") -> ss.Response:
    return ss.march(model, scheme, dt=0.05, t_end=2.0, account=False, start=start)


@pytest.mark.parametrize("scheme", ["newmark", "bdf3"])
def test_modes_of_another_structure_begin_where_the_first_ones_ended(scheme: str) -> None:
    """Modal coordinates belong to their shapes: of other ones the motion is what goes on."""
    heavier = ss.structure(M + np.diag([0.0, 1.0, 0.0]), 1.1 * K)
    first = start_of(frame().modes(3), scheme)
    then = going_on(heavier.modes(3), first, scheme)
    assert np.abs(then.u[0] - first.u[-1]).max() < 1e-14
    anew = going_on(heavier, {"t": 1.0, "u": first.u[-1], "v": first.v[-1], "a": first.a[-1]}, scheme)
    assert np.abs(then.u - anew.u).max() < 1e-12


@pytest.mark.parametrize("scheme", ["newmark", "bdf3"])
def test_modes_go_on_where_damping_begins_to_couple_them_or_ends_to(scheme: str) -> None:
    free, coupled = frame(), frame(C=np.diag([0.5, 0.0, 0.0]))
    for model, to in ((free, coupled), (coupled, free)):
        first = start_of(model.modes(3), scheme)
        anew = {"t": 1.0, "u": first.u[-1], "v": first.v[-1], "a": first.a[-1]}
        assert np.abs(going_on(to.modes(3), first, scheme).u - going_on(to, anew, scheme).u).max() < 1e-12


def test_modes_go_on_from_the_last_row_where_the_stride_does_not_divide_the_steps() -> None:
    modes = frame().modes(2)
    first = start_of(modes, "newmark", stride=3)
    then = going_on(modes, first, "newmark")
    assert then.t[0] == pytest.approx(first.t[-1], rel=1e-15)
    assert np.abs(then.u[0] - first.u[-1]).max() < 1e-15


def test_a_scheme_starts_anew_where_other_degrees_of_freedom_are_fixed() -> None:
    """Its history is of the free ones, also where there are as many of them."""
    held, other, none = (ss.structure(M, K, v0=0.0, fixed=fixed) for fixed in ([1], [0], []))
    first = start_of(held)
    zero = {"t": 1.0, "u": np.zeros(3), "v": np.zeros(3)}
    assert np.array_equal(going_on(other, first).u, going_on(other, zero).u)
    moved = start_of(ss.structure(M, K, v0=[1.0, 0.0, 0.0], fixed=[1]))
    known = {"t": 1.0, "u": moved.u[-1], "v": moved.v[-1], "a": moved.a[-1]}
    assert np.array_equal(going_on(none, moved).u, going_on(none, known).u)


def test_a_history_of_all_degrees_of_freedom_is_that_of_the_free_ones() -> None:
    held = ss.structure(M, K, v0=[1.0, 0.0, 1.0], fixed=[1])
    whole = ss.march(held, "houbolt", dt=0.05, t_end=2.0, account=False)
    u, v = whole.u, whole.v
    own = {"t": 1.0, "u": u[20], "v": v[20], "history": {"u": u[20], "u[-1]": u[19], "u[-2]": u[18]}}
    assert np.allclose(going_on(held, own, "houbolt").u, u[20:], rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"history": 3.0}, "expected history of start as rows"),
        ({"history": {"u": [5.0, 0, 0], "u[-1]": np.zeros(3), "u[-2]": np.zeros(3)}}, "to be what u of start says"),
        ({"history": {"u": np.zeros(3), "u[-1]": 0.0, "u[-2]": np.zeros(3)}}, "3 components"),
        (
            {"history": {"u": np.zeros(3), "u[-1]": np.zeros(3), "u[-2]": np.zeros(3), "u[-3]": np.ones(3)}},
            r"no u\[-3\] in the history of start, for a scheme that carries u, u\[-1\], u\[-2\]; leave it out",
        ),
    ],
)
def test_a_history_that_cannot_be_is_refused(change: dict[str, Any], match: str) -> None:
    start = {"t": 1.0, "u": np.zeros(3), "v": np.zeros(3), **change}
    with pytest.raises(ValueError, match=match):
        going_on(frame(), start, "houbolt")


def test_a_history_for_modes_is_refused() -> None:
    rows = {"u": np.zeros(3), "u[-1]": np.zeros(3), "u[-2]": np.zeros(3)}
    with pytest.raises(ValueError, match="modes without a history"):
        going_on(frame().modes(3), {"t": 1.0, "u": np.zeros(3), "v": np.zeros(3), "history": rows}, "houbolt")


def test_an_acceleration_of_none_is_that_of_the_equation_of_motion() -> None:
    spring = ss.scene("linear_oscillator", omega=2.0)
    r = ss.march(spring, "newmark", dt=0.1, t_end=1.0, start={"u": 1.0, "v": 0.0, "a": None})
    assert r.a[0, 0] == -4.0


SPRING = ss.scene("linear_oscillator", omega=2 * np.pi, u0=1.0)


@pytest.mark.parametrize("scheme", ["newmark", "bathe", "rk4", "bdf3", "generalized_alpha"])
def test_one_event_after_another_is_found(scheme: str) -> None:
    """The run from an event begins at it, with a rounded 0 of either sign, and ends at the next one."""
    turned, times = None, []
    for k in range(6):
        turned = ss.march(SPRING, scheme, dt=0.01, t_end=2.0 + 0.5 * k if turned is None else turned.t[-1] + 2.0,
                          start=turned, until=lambda t, u, v: v[0])  # fmt: skip
        times.append(turned.t[-1])
    assert np.allclose(times, 0.5 * np.arange(1, 7), rtol=1e-3)


def test_the_state_of_a_run_to_an_event_is_the_event_whatever_rows_are_asked_for() -> None:
    r = ss.march(SPRING, "newmark", dt=0.01, t_end=2.0, at=[0.0, 0.1], until=lambda t, u, v: u[0])
    assert r.t_events is not None
    assert r.state.t == r.t_events[0]
    assert abs(r.state.u[0]) < 1e-14
    assert "rows a period" not in repr(r)


@pytest.mark.parametrize("at", [[0.0, 3.0], [3.0]])
@pytest.mark.parametrize("steps", [{"dt": 0.1}, {"tol": 1e-4}])
def test_rows_beyond_the_end_are_refused(at: list[float], steps: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="expected at up to t_end = 2"):
        ss.march(SPRING, "newmark", t_end=2.0, at=at, **steps)


def test_rows_of_which_the_run_reaches_none_are_refused() -> None:
    with pytest.raises(ValueError, match="expected a time in at that the run has reached"):
        ss.march(SPRING, "newmark", dt=0.1, t_end=2.0, at=[1.5], until=lambda t, u, v: u[0])


@pytest.mark.parametrize(
    "until",
    ["v == 0", ["v == 0"], 3, [], [None], *(lambda t, u, v, x=x: x for x in (None, "x", 1j)), lambda t, u, v: u[0] < 0],
)
def test_what_is_no_event_is_refused(until: Any) -> None:
    """A comparison changes from false to true, which is no change of sign: it would end the first step."""
    with pytest.raises(ValueError, match="expected until as a function of t, u, v"):
        ss.march(SPRING, "newmark", dt=0.1, t_end=2.0, until=until)


@pytest.mark.parametrize("scheme", ["rk4", "newmark"])
def test_a_run_with_fixed_degrees_of_freedom_goes_on_from_an_event(scheme: str) -> None:
    held = ss.structure(M, K, v0=[1.0, 0.0, 1.0], fixed=[1])
    r = ss.march(held, scheme, dt=0.05, t_end=3.0, until=lambda t, u, v: v[0])
    on = ss.march(held, scheme, dt=0.05, t_end=r.t[-1] + 1.0, start=r)
    whole = ss.march(held, scheme, dt=0.001, t_end=3.0)
    assert on.u[-1] == pytest.approx(np.array([np.interp(on.t[-1], whole.t, x) for x in whole.u.T]), abs=2e-3)


@pytest.mark.parametrize("model", [SPRING, ss.structure([[1.0]], [[4 * np.pi**2]], u0=1.0)])
@pytest.mark.parametrize("end", [0.0, -0.5])
def test_time_may_begin_and_end_before_0(model: Any, end: float) -> None:
    start = {"t": -2.0, "u": 1.0, "v": 0.0}
    r = ss.march(model, "bathe", dt=0.01, t_end=end, start=start, at=[-2.0, -1.75, end])
    assert r.u[:, 0] == pytest.approx(np.cos(2 * np.pi * (r.t + 2.0)), abs=5e-3)


@pytest.mark.parametrize(("t", "dt"), [(1e7 + 0.01, 0.1), (1e4 + 5e-6, 1e-4), (1e6 + 0.0003, 1e-3), (1e9, 1e-4)])
def test_a_late_start_is_kept(t: float, dt: float) -> None:
    for steps in (1, 5):
        r = ss.march(SPRING, "newmark", dt=dt, t_end=t + steps * dt, start={"t": t, "u": 1.0, "v": 0.0})
        assert r.t[0] == t
        assert len(r.t) == steps + 1


def test_an_end_within_rounding_of_the_start_is_refused() -> None:
    first = ss.march(SPRING, "newmark", dt=0.1, t_end=0.3)
    for end in (0.3, 0.3 + 1e-12, 0.3 + 1e-11):
        with pytest.raises(ValueError, match="t_end after the start"):
            ss.march(SPRING, "newmark", dt=0.1, t_end=end, start=first)


@pytest.mark.filterwarnings("ignore:kr_alpha takes the damping at the start")
@pytest.mark.parametrize("scheme", ["kr_alpha", "bathe", "noh_bathe"])
def test_instants_within_a_step_round_as_those_of_the_run_that_is_not_broken(scheme: str) -> None:
    model = ss.structure(
        M, internal_force=lambda t, u, v: K @ u + 0.1 * np.abs(v) * v + np.sin(t), u0=[0.1, 0.2, 0.3],
        tangent=lambda t, u, v: (K, np.diag(0.2 * np.abs(v))),
    )  # fmt: skip
    whole = ss.march(model, scheme, dt=0.07, t_end=4.2, account=False)
    first = ss.march(model, scheme, dt=0.07, t_end=0.56, account=False)
    then = ss.march(model, scheme, dt=0.07, t_end=4.2, account=False, start=first)
    assert np.array_equal(then.u, whole.u[8:])
    assert np.array_equal(then.v, whole.v[8:])


def test_a_velocity_of_supports_is_not_dropped_silently() -> None:
    with pytest.raises(ValueError, match="velocity with displacement only"):
        ss.structure(M, K, fixed=[0]).support_motion(
            [0], acceleration=ss.Record(0.1, [0.0, 1.0]), velocity=lambda t: 0.0 * t
        )


@pytest.mark.parametrize("omega", [1e-4, 1.0, 1e6])
def test_a_scene_rests_at_any_size_of_displacement(omega: float) -> None:
    scene = ss.scene("linear_oscillator", omega=omega, u0="static", load=ss.Step(1e6))
    assert scene.parameters["u0"] == pytest.approx(1e6 / omega**2, rel=1e-12)


def test_a_saved_march_that_goes_on_knows_its_loads_where_it_is(tmp_path: Any) -> None:
    """Loads that differ only within the march, from 1 s to 2 s, not within its length after 0."""
    pytest.importorskip("zarr")
    one, other = (frame(load=([1.0, 0, 0], lambda t, x=x: np.where(t > 1.2, x, 0.0))) for x in (1.0, 2.0))
    first = start_of(one)
    ss.march(one, "bdf3", dt=0.05, t_end=2.0, start=first, save=tmp_path / "march")
    with pytest.raises(ValueError, match="another loads"):
        ss.march(other, "bdf3", dt=0.05, t_end=2.0, start=first, save=tmp_path / "march")


@pytest.mark.usefixtures("plain_adaptive")
@pytest.mark.parametrize("scheme", ["dormand_prince", "rk4", "newmark"])
@pytest.mark.parametrize("kind", ["structure", "scene"])
@pytest.mark.parametrize("steps", [{"tol": 1e-6}, {"dt": 0.01}])
def test_rows_in_the_step_before_a_load_jumps_do_not_feel_it(kind: str, scheme: str, steps: dict[str, float]) -> None:
    load = ss.Step(5.0, start=0.5)
    if kind == "structure":
        model: Any = ss.structure([[1.0]], [[9.0]], u0=1.0, load=([1.0], load))
    else:
        model = ss.scene("linear_oscillator", omega=3.0, u0=1.0, load=load)
    until = {"until": lambda t, u, v: t - 1.4}  # so that rows are taken between steps in any case
    r = ss.march(model, scheme, **steps, t_end=1.5, at=np.linspace(0.0, 1.5, 301), **until)
    t = r.t
    exact = np.cos(3.0 * t) + 5.0 / 9.0 * np.where(t > 0.5, 1.0 - np.cos(3.0 * (t - 0.5)), 0.0)
    ends = ss.march(model, scheme, **steps, t_end=1.5)
    at_ends = np.cos(3.0 * ends.t) + 5.0 / 9.0 * np.where(ends.t > 0.5, 1.0 - np.cos(3.0 * (ends.t - 0.5)), 0.0)
    longest = float(np.diff(ends.t).max())
    assert (
        np.abs(r.u[:, 0] - exact).max() < 1.2 * np.abs(ends.u[:, 0] - at_ends).max() + 81.0 / 384.0 * longest**4 * 2.0
    )


def test_the_state_of_rows_up_to_an_event_survives_a_copy() -> None:
    scene = ss.scene("linear_oscillator", omega=2.0, u0=1.0)
    r = ss.march(scene, "newmark", dt=0.01, t_end=2.0, at=[0.1, 0.2], until=lambda t, u, v: u[0])
    copied = pickle.loads(pickle.dumps(r))
    assert r.t_events is not None
    assert copied.state.t == r.state.t == r.t_events[0]


@pytest.mark.parametrize("scheme", ["newmark", "park", "bathe"])
@pytest.mark.parametrize("failure", ["raises", "newton_failed", "non_finite"])
def test_a_structure_goes_on_after_a_failure_as_if_there_had_been_none(failure: str, scheme: str) -> None:
    """What fails is a function of the user's, mended then; an iteration that failed leaves no tangent behind."""
    M, K, broken = np.diag([2.0, 1.0]), np.array([[60.0, -20.0], [-20.0, 40.0]]), [True]

    def force(t: float, u: Any, v: Any) -> Any:
        if broken[0] and t > 0.5 and failure == "raises":
            raise RuntimeError("mend me")
        return np.full(2, np.nan) if broken[0] and t > 0.5 and failure == "newton_failed" else K @ u + 40.0 * u**3

    def load(t: Any) -> Any:
        return np.where(broken[0] & (t > 0.5) & (failure == "non_finite"), 1e308, 0.1 * np.cos(t))

    given: dict[str, Any] = {"load": [([10.0, 0.0], load)], "u0": [0.5, 0.0], "v0": [0.0, 1.0]}
    if failure == "non_finite":
        frame = ss.structure(M, K, **given)
    else:
        slope = {"tangent": lambda t, u, v: (K + np.diag(120.0 * u**2), 0.0 * M)}
        frame = ss.structure(M, internal_force=force, **slope, **given)
    options: dict[str, Any] = {"dt": 0.04, "t_end": 1.2, "account": False}
    try:
        part = ss.march(frame, scheme, **options, dofs=[0])
    except RuntimeError as error:
        part = error.response  # type: ignore[attr-defined]
    assert part.status == ("interrupted" if failure == "raises" else failure)
    assert 0.4 < part.t[-1] <= 0.5
    broken[0] = False
    rest, whole = ss.march(frame, scheme, **options, start=part), ss.march(frame, scheme, **options)
    assert np.array_equal(rest.u[1:], whole.u[len(part.u) :])
    assert np.array_equal(rest.v[1:], whole.v[len(part.u) :])


def test_a_history_of_a_scene_has_no_rows_that_its_scheme_does_not_carry() -> None:
    rows = {"u": 1.0, "h*v": 0.0, "h^2*a": 0.0}
    with pytest.raises(ValueError, match=r"no h\^2\*a in the history of start, for a scheme that carries u, h\*v; "):
        ss.march(SPRING, "rk4", dt=0.1, t_end=1.0, start={"u": 1.0, "v": 0.0, "history": rows})
    del rows["h^2*a"]
    ss.march(SPRING, "rk4", dt=0.1, t_end=1.0, start={"u": 1.0, "v": 0.0, "history": rows})


@pytest.mark.thorough
@pytest.mark.parametrize("scheme", ["newmark", "bathe", "generalized_alpha"])
@pytest.mark.parametrize(
    ("load", "t"), [(ss.Step(2.0, start=0.5), 0.5), (ss.Record(0.1, [3.0] * 4), 0.3), (ss.Record(0.1, [3.0] * 4), None)]
)
def test_chosen_steps_that_begin_where_a_load_jumps_feel_it_from_there_on(scheme: str, load: Any, t: float) -> None:
    """The last is one unit in the last place later: 3*0.1 is not 0.3. Two stages are as good as the run in one."""
    t = 0.1 * 3 if t is None else t
    pushed = ss.scene("linear_oscillator", omega=3.0, u0=0.0, load=load)
    first = ss.march(pushed, scheme, tol=1e-6, t_end=t)
    then = ss.march(pushed, scheme, tol=1e-6, t_end=2.0, start=first)
    before, behind = (0.0, 2.0) if isinstance(load, ss.Step) else (3.0, 0.0)
    assert first.a[-1, 0] == pytest.approx(before - 9.0 * first.u[-1, 0], abs=0.03)
    assert then.a[0, 0] == pytest.approx(behind - 9.0 * first.u[-1, 0], abs=1e-12)
    u, v, rest = (
        before / 9 * (1 - np.cos(3 * t)),
        before / 3 * np.sin(3 * t),
        behind / 9,
    )  # at t, and about which it is then
    exact = rest + (u - rest) * np.cos(3 * (2 - t)) + v / 3 * np.sin(3 * (2 - t))
    assert then.u[-1, 0] == pytest.approx(exact, abs=7e-5)


@pytest.mark.parametrize("scheme", ["newmark", "bathe"])
@pytest.mark.parametrize(
    ("load", "t", "behind"), [(ss.Step(2.0, start=0.5), 0.5, 2.0), (ss.Record(0.1, [3.0] * 6), 0.5, 0.0)]
)
def test_so_they_do_on_a_structure(scheme: str, load: Any, t: float, behind: float) -> None:
    """Beside a load that does not jump, with damping; the masses differ."""
    M, C, K = np.diag([2.0, 1.0]), np.diag([0.1, 0.2]), np.array([[18.0, -4.0], [-4.0, 9.0]])
    loads = [([0.5, 1.0], load), ([1.0, 0.0], ss.Harmonic(1.0, 2.0))]
    pushed = ss.structure(M, K, C=C, load=loads)
    first = ss.march(pushed, scheme, tol=1e-6, t_end=t, account=False)
    then = ss.march(pushed, scheme, tol=1e-6, t_end=2.0, start=first, account=False)
    force = behind * np.array([0.5, 1.0]) + np.array([np.sin(2.0 * t), 0.0])
    expected = np.linalg.solve(M, force - C @ first.v[-1] - K @ first.u[-1])
    assert then.a[0] == pytest.approx(expected, abs=1e-12)
    whole = ss.march(pushed, scheme, tol=1e-9, t_end=2.0, account=False)
    assert then.u[-1] == pytest.approx(whole.u[-1], abs=1e-4)


@pytest.mark.parametrize("model", [SPRING, frame(), "duffing"])
@pytest.mark.parametrize("end", [-1.0, 1.0])
def test_chosen_steps_do_not_begin_before_0(model: Any, end: float) -> None:
    """Where they would pass jumps of a load at 0 without ending there."""
    size = 3 if isinstance(model, ss.Structure) else 1
    start = {"t": -2.0, "u": np.ones(size), "v": np.zeros(size)}
    with pytest.raises(ValueError, match="a start at t >= 0 where steps are chosen, got t = -2, .*give dt"):
        ss.march(model, "bathe", tol=1e-4, t_end=end, start=start)
    assert ss.march(model, "bathe", dt=0.1, t_end=end, start=start).t[0] == -2.0
