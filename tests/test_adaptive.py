"""Steps that the march chooses, against constant steps, exact motions and SciPy; break points, rows, failures."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from exact_motions import exact as exact_motion

import substep as ss
from substep.core.outcome import Statistics
from substep.exact.pendulum import ElasticPendulum
from substep.marching import adaptive
from substep.marching.adaptive import march_adaptive
from substep.run.clock import Control

# second values of another order; and the order of the value that is marched
PAIRS = {"bogacki_shampine": 3, "dormand_prince": 5, "rkn64": 6, "stoermer_extrapolation": 8}

pytestmark = pytest.mark.usefixtures("plain_adaptive")


def handle(scheme: Any, **parameters: Any) -> ss.Scheme:
    return ss.scheme(scheme, **parameters)


def cost(r: ss.Response) -> Statistics:
    assert r.statistics is not None
    return r.statistics


flexible = ss.scene("elastic_pendulum", EA=1e4)
SCENES = {
    "elastic_pendulum": flexible,
    "duffing": ss.scene("duffing"),
    "linear_oscillator": ss.scene("linear_oscillator", omega=3.0, xi=0.1, load=ss.Harmonic(2.0, 5.0, 0.3)),
    "bathe_noh": ss.scene("bathe_noh", k1=1e3),
}
CHOSEN = {  # scheme and parameters, order of the march, power of h of the estimate
    "average_acceleration": ({}, 2),
    "newmark": ({"beta": 0.3025, "gamma": 0.5}, 2),
    "bathe": ({}, 2),
    "newmark_bdf2": ({"gamma_t": 0.4}, 2),
    "noh_bathe": ({}, 2),
}


def exact(scene: ss.Scene, t: np.ndarray) -> np.ndarray:
    """u (n, d)."""
    return exact_motion(scene, t)[:, 0]


@pytest.mark.parametrize(
    ("scheme", "scene"),
    [(name, scene) for name in BY_NAME for scene in ("elastic_pendulum", "linear_oscillator")]
    + [("bathe", "bathe_noh"), ("noh_bathe", "bathe_noh"), ("newmark_bdf2", "duffing")],
)
def test_steps_of_one_length_are_those_of_a_constant_step(
    scheme: str, scene: str, request: pytest.FixtureRequest
) -> None:
    s, model, dt, n = ss.scheme(scheme), SCENES[scene], 1e-3, 12
    asked = Control.of(model.length, 1e6, n * dt, dt_first=dt, dt_max=dt)
    try:
        r = march_adaptive(model, s, asked)
    except ValueError as error:  # no estimate, a start of its own, or damping where the scheme takes none
        assert s.name in str(error)
        return
    request.getfixturevalue("uncompiled")
    expected = ss.march(model, s, dt, n * dt) if not model.info.oscillator else _by_pair(model, s, dt, n)
    assert (r.status, cost(r).accepted, cost(r).rejected) == ("completed", n, 0)
    assert np.allclose(r.t, np.arange(n + 1) * dt, rtol=1e-14)
    for name in "uva":
        found, wanted = getattr(r, name), getattr(expected, name)
        assert np.abs(found - wanted).max() <= 1e-9 * np.abs(wanted).max() * (1 + (name == "a") * 100), name
    assert np.array_equal(r.newton_iterations, expected.newton_iterations)


def _by_pair(model: ss.Scene, s: ss.Scheme, dt: float, n: int) -> Any:
    from substep.marching.scene_lanes import march_lanes

    lanes = march_lanes(model, s, np.array([dt]), np.array([n]), history=True, counts=True)
    rows = lanes.out[0]
    a = rows[:, 2] if rows.shape[1] > 2 else model.acceleration(np.arange(n + 1) * dt, rows[:, 0], rows[:, 1])
    return SimpleNamespace(u=rows[:, 0], v=rows[:, 1], a=a, newton_iterations=lanes.iterations[0])


def _errors(s: ss.Scheme, scene: ss.Scene, t_end: float, tolerances: tuple[float, ...]) -> list[float]:
    found = []
    for tol in tolerances:
        r = ss.march(scene, s, tol=tol, t_end=t_end)
        assert r.status == "completed"
        assert r.t[-1] == t_end
        reference = exact(scene, r.t)
        found.append(float(np.abs(r.u - reference).max() / np.abs(reference).max()))
    return found


@pytest.mark.parametrize("scene", ["elastic_pendulum", "duffing", "linear_oscillator"])
@pytest.mark.parametrize("scheme", CHOSEN)
def test_the_error_follows_the_tolerance(scheme: str, scene: str) -> None:
    """An estimate of O(h^3) gives steps in proportion to tol^(1/3), and so a second-order error to tol^(2/3)."""
    parameters, p = CHOSEN[scheme]
    s = ss.scheme(scheme, **parameters)
    power = p / (s.local_error(damped=True).order + 1)
    coarse, fine = _errors(s, SCENES[scene], 0.6, (1e-5, 1e-7))
    assert coarse < 0.2
    assert 1 / 2.5 < (coarse / fine) / 100.0**power < 2.5


@pytest.mark.parametrize("pair", PAIRS)
def test_pairs_are_as_accurate_as_their_higher_order(pair: Any) -> None:
    s, p = handle(pair), PAIRS[pair]
    power = p / (s.local_error(damped=True).order + 1)
    coarse, fine = _errors(s, flexible, 0.5, (1e-5, 1e-8))
    assert 1 / 4 < (coarse / fine) / 1000.0**power < 4


def test_the_exact_pendulum_to_ten_digits() -> None:
    r = ss.march(flexible, handle("stoermer_extrapolation"), tol=1e-11, t_end=5.0)
    L, m, v0 = (flexible.parameters[name] for name in ("L", "m", "v0"))
    position = ElasticPendulum(1e4, L, m, v0).position(5.0)
    assert np.abs(r.u[-1] - position).max() < 1e-10 * L
    assert cost(r).accepted < 500


LOADS = {
    "step": (ss.Step(3.0, 0.7), [0.7]),
    "half sine": (ss.HalfSine(3.0, 0.55), [0.55]),
    "record": (ss.Record(0.25, [0.0, 1.0, -2.0, 0.5, 1.5]), [0.25, 0.5, 0.75, 1.0]),
}


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("scheme", ["bathe", "dormand_prince"])
def test_steps_end_where_the_load_jumps(load: str, scheme: Any) -> None:
    given, breaks = LOADS[load]
    scene = ss.scene("linear_oscillator", omega=4.0, xi=0.05, u0=0.2, v0=0.1, load=given)
    s = handle(scheme)
    r = ss.march(scene, s, tol=1e-8 if scheme == "dormand_prince" else 1e-5, t_end=1.6)
    assert set(breaks) <= set(r.t)
    assert r.t[-1] == 1.6
    assert (np.diff(r.t) > 0).all()
    error = np.abs(r.u - exact(scene, r.t)).max() / np.abs(r.u).max()
    assert error < (3e-8 if scheme == "dormand_prince" else 2e-3)
    if load == "step":  # the acceleration after the jump
        k = int(np.flatnonzero(r.t == 0.7)[0])
        assert r.a[k] == pytest.approx(scene.acceleration(r.t[k], r.u[k], r.v[k]), rel=1e-9)


def test_a_load_across_a_jump_costs_rejections_without_its_break_points(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = ss.scene("linear_oscillator", omega=4.0, u0=0.2, load=ss.Step(30.0, 0.7))
    s = handle("dormand_prince")
    good = ss.march(scene, s, tol=1e-7, t_end=1.6)
    monkeypatch.setattr(adaptive, "break_points", lambda load, t_end: np.empty(0))
    blind = ss.march(scene, s, tol=1e-7, t_end=1.6)
    bad = np.abs(blind.u[-1] - exact_end(scene)).max()
    assert 0.7 in good.t
    assert 0.7 not in blind.t
    assert bad > 100 * np.abs(good.u[-1] - exact_end(scene)).max()


def exact_end(scene: ss.Scene) -> np.ndarray:
    """At rest about 0.2 until t = 0.7, then about the static displacement: closed form."""
    w, static = 4.0, 30.0 / 16.0
    u, v, s = 0.2 * np.cos(w * 0.7), -0.2 * w * np.sin(w * 0.7), 0.9
    return np.array([static + (u - static) * np.cos(w * s) + v / w * np.sin(w * s)])


@pytest.mark.parametrize("scheme", ["bathe", "noh_bathe", "stoermer_extrapolation"])
def test_statistics_count_what_the_rows_show(scheme: Any) -> None:
    s = handle(scheme)
    r = ss.march(flexible, s, tol=1e-5, t_end=1.0)
    steps = np.diff(r.t)
    assert cost(r).accepted == len(steps) == len(r.newton_iterations)
    assert cost(r).newton_iterations == tuple(r.newton_iterations.sum(axis=0))
    assert cost(r).newton_most == tuple(r.newton_iterations.max(axis=0))
    assert cost(r).shortest == pytest.approx(steps.min(), rel=1e-9)
    assert cost(r).longest == pytest.approx(steps.max(), rel=1e-9)
    assert cost(r).rejected <= 0.1 * cost(r).accepted + 3
    assert np.array_equal(r.u[0], flexible.u0)


@pytest.mark.parametrize("rows", [2, 7, 64])
def test_full_rows_are_gone_on_from_without_a_trace(rows: int) -> None:
    scene = SCENES["linear_oscillator"]
    s, asked = ss.scheme("bathe"), Control.of(scene.length, 1e-4, 3.0)
    once, often = (march_adaptive(scene, s, asked, rows=n) for n in (10_000, rows))
    assert len(once.t) > 64
    assert once.statistics == often.statistics
    for name in ("t", "u", "v", "a", "newton_iterations"):
        assert np.array_equal(getattr(once, name), getattr(often, name)), name


@pytest.mark.parametrize("scheme", ["bathe", "dormand_prince"])
def test_rows_on_a_grid_lie_on_the_motion_between_the_steps(scheme: Any) -> None:
    s, tol = handle(scheme), 1e-7
    grid = np.concatenate([[0.0], np.sort(np.random.default_rng(3).uniform(0, 2, 60)), [2.0]])
    steps, rows = ss.march(flexible, s, tol=tol, t_end=2.0), ss.march(flexible, s, tol=tol, t_end=2.0, grid=grid)
    assert np.array_equal(rows.t, grid)
    assert rows.statistics == steps.statistics
    assert np.array_equal(rows.u[-1], steps.u[-1])
    assert np.array_equal(rows.u[0], flexible.u0)
    at_steps = np.abs(steps.u - exact(flexible, steps.t)).max()
    assert np.abs(rows.u - exact(flexible, grid)).max() < 1.1 * at_steps
    scale = np.abs(steps.a).max()
    own = np.abs(steps.a - flexible.acceleration(steps.t, exact(flexible, steps.t), steps.v)).max() / scale
    there = exact(flexible, grid)
    assert np.abs(rows.a - flexible.acceleration(grid, there, rows.v)).max() / scale < 1.5 * own + 2e-5


def test_a_grid_for_a_higher_order_than_the_interpolant_is_stepped_on() -> None:
    s, grid = handle("stoermer_extrapolation"), np.linspace(0.1, 1.0, 7)
    r = ss.march(flexible, s, tol=1e-10, t_end=1.0, grid=grid)
    assert np.array_equal(r.t, grid)
    assert np.abs(r.u - exact(flexible, np.concatenate([[0.0], grid]))[1:]).max() < 2e-9


def test_a_step_that_overflows_is_made_shorter() -> None:
    r = ss.march(ss.scene("duffing"), handle("dormand_prince"), tol=1e-4, t_end=0.5, dt_first=0.5)
    assert r.status == "completed"
    assert cost(r).rejected > 1
    assert cost(r).longest < 0.1


def test_newton_failures_are_counted_and_survived() -> None:
    scene = ss.scene("softening")
    r = ss.march(scene, ss.scheme("bathe"), tol=1e-2, t_end=4.0, dt_first=2.0)
    assert r.status == "completed"
    assert 0 < cost(r).newton_failures < cost(r).rejected
    with_dt = np.abs(r.energy - scene.E0).max() / scene.E0
    assert with_dt < 0.2


def test_a_step_below_the_shortest_ends_the_run_with_what_it_has() -> None:
    r = ss.march(flexible, ss.scheme("bathe"), tol=1e-8, t_end=1.0, dt_min=5e-3, dt_first=5e-3)
    assert r.status == "step_too_small"
    assert r.t_failed is not None
    assert len(r.t) == cost(r).accepted + 1 == len(r.u)
    assert r.t[-1] < r.t_failed < 1.0
    r = ss.march(flexible, ss.scheme("bathe"), tol=1e-4, t_end=1.0, energy_bound=0.5 * flexible.E0)
    assert (r.status, len(r.t)) == ("energy_bound", 1)
    assert r.t_failed == pytest.approx(np.nan_to_num(r.t_failed))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"tol": 0.0}, "tol > 0"),
        ({"tol": -1e-6}, "tol > 0"),
        ({"tol": np.nan}, "finite"),
        ({}, "either dt"),
        ({"tol": 1e-6, "dt": 0.1}, "either dt"),
        ({"tol": 1e-6, "t_end": None}, "expected t_end"),
        ({"tol": 1e-6, "dt_min": 0.1, "dt_max": 0.01}, "dt_min <= dt_max"),
        ({"tol": 1e-6, "dt_first": 0.1, "dt_max": 0.01}, "dt_first between"),
        ({"tol": 1e-6, "dt_max": -1.0}, "dt_max > 0"),
        ({"tol": 1e-6, "atol": [1.0, 2.0, 3.0]}, "one or two"),
        ({"tol": 1e-6, "rtol": 0.0, "atol": 0.0}, "not both 0"),
        ({"tol": 1e-6, "grid": [0.5, 0.2]}, "ascending"),
        ({"tol": 1e-6, "grid": [0.5, 2.0]}, "within 0 and t_end"),
        ({"tol": 1e-6, "stride": 2}, "grid="),
        ({"dt": 0.1, "grid": [0.5]}, "with tol only"),
        ({"tol": 1e-6, "dtmax": 0.1}, "did you mean 'dt_max'"),
    ],
)
def test_wrong_arguments_are_named_with_the_cure(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ss.march(flexible, "bathe", **{"t_end": 1.0, **arguments})


@pytest.mark.parametrize("scheme", ["houbolt", "park", "gholampour", "oalts", "central_difference_lagged", "kr_alpha"])
def test_schemes_whose_step_cannot_change_are_refused_by_name(scheme: str) -> None:
    with pytest.raises(ValueError, match=rf"{scheme}.*give dt"):
        ss.march(flexible, scheme, tol=1e-6, t_end=1.0)


def test_a_load_that_kernels_cannot_call_is_refused() -> None:
    scene = ss.scene("linear_oscillator", omega=1.0, load=np.sin)
    with pytest.raises(ValueError, match="Record"):
        ss.march(scene, "bathe", tol=1e-6, t_end=1.0)


def test_names_stand_for_their_defaults() -> None:
    by_name, by_handle = ss.march("duffing", "bathe", tol=1e-4, t_end=0.2), ss.march(
        ss.scene("duffing"), ss.scheme("bathe"), tol=1e-4, t_end=0.2
    )  # fmt: skip
    assert np.array_equal(by_name.u, by_handle.u)


@pytest.mark.parametrize("order", [2, 5])
def test_interpolant_reproduces_polynomials_up_to_its_degree(order: int) -> None:
    """On 1 <= t <= 3, a third into it; the acceleration of a scheme of second order from velocities alone."""
    from substep_derive import h, knot
    from substep_derive.kernels.interpolant import Interpolant, share
    from sympy import Rational

    found, middle = Interpolant.of(knot(0), knot(1), order), Rational(5, 3)
    degrees = {"u": found.degree, "v": found.degree, "a": 5 if order == 5 else 4}
    for k in range(9):
        values: dict[Any, Any] = {h: 2, share: Rational(1, 3)}
        for one, t in ((knot(0), Rational(1)), (knot(1), Rational(3))):
            values |= {one.u: t**k, one.v: k * t ** (k - 1), one.a: k * (k - 1) * t ** (k - 2)}
        right = {"u": middle**k, "v": k * middle ** (k - 1), "a": k * (k - 1) * middle ** (k - 2)}
        for name, degree in degrees.items():
            assert (getattr(found, name).subs(values) == right[name]) == (k <= degree), (name, k)


@pytest.mark.usefixtures("uncompiled")
def test_a_scene_at_complete_rest_starts() -> None:
    """No displacement, no velocity and no load at t = 0, so that nothing there says how fast the motion will be."""
    resting = ss.scene("linear_oscillator", omega=6.28, u0=0.0, load=ss.Harmonic(1.0, 2.0))
    r = ss.march(resting, "bathe", tol=1e-6, t_end=3.0)
    fine = ss.march(resting, "rk4", dt=1e-3, t_end=3.0)
    assert r.status == "completed"
    assert r.statistics is not None
    assert np.abs(r.u[-1] - fine.u[-1]).max() <= 1e-6 * r.statistics.accepted  # the sum of local errors
