"""Structures in steps that are chosen: against scenes, constant steps and SciPy; jumps, factors, failures, refusals."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from plane_elements import shear_building
from scipy.integrate import solve_ivp
from test_adaptive import cost

import substep as ss

pytestmark = pytest.mark.usefixtures("plain_adaptive")

LOADS = {
    "none": None,
    "harmonic": ss.Harmonic(2.0, 5.0, 0.3),
    "step": ss.Step(3.0, 0.7),
    "half sine": ss.HalfSine(5.0, 0.55),
    "record": ss.Record(0.25, [0.0, 1.0, -2.0, 0.5, 1.5]),
}
PUSHES = [({2: 40.0}, ss.HalfSine(1.0, 0.37)), ({0: 25.0, 3: 10.0}, ss.Step(1.0, 0.61)), ({1: 9.0}, ss.Harmonic(1, 7))]
T_END = 1.5


@cache
def building(damping: str = "rayleigh", **more: Any) -> ss.Structure:
    """Four storeys with frequencies from 6 to 40 rad/s."""
    M, K = shear_building([2.0, 1.5, 1.5, 1.0], [900.0, 700.0, 600.0, 400.0])
    C = {"none": None, "rayleigh": ss.Rayleigh(0.3, 0.002), "modal": ss.modal_damping(0.05, 4)}[damping]
    return ss.structure(M, K, C=C, load=PUSHES, u0=[0.0, 0.01, 0.01, 0.0], v0=0.1, **more)


def exact(s: ss.Structure, t: Any, breaks: tuple[float, ...] = (0.37, 0.61)) -> Any:
    """Displacements by DOP853 from break to break."""
    inverse, n = np.linalg.inv(s.M), s.size
    C = s.damping if isinstance(s.damping, np.ndarray) else s.damping.toarray()
    rows, y, ends = [], np.concatenate([s.u0, s.v0]), [0.0, *breaks, T_END]
    for begin, end in pairwise(ends):
        inside = t[(t >= begin) & (t < end)]

        def rate(x: float, y: Any, at: float = 0.5 * (begin + end)) -> Any:
            load = sum(P * (g(np.array([at if isinstance(g, ss.Step) else x]))[0]) for P, g in s.loads)
            return np.concatenate([y[n:], inverse @ (load - C @ y[n:] - s.K @ y[:n])])

        found = solve_ivp(rate, (begin, end), y, "DOP853", np.append(inside, end), rtol=1e-11, atol=1e-12).y
        rows.append(found[:n, :-1])
        y = found[:, -1]
    return np.vstack([np.hstack(rows).T, y[:n]])


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "hht_alpha", "noh_bathe", "dormand_prince", "rk2"])
def test_one_oscillator_takes_the_steps_of_the_scene(scheme: str, load: str) -> None:
    """The same lengths from the first on; counts differ by what a factorization costs, and by the scales of u."""
    g, tol = LOADS[load], 1e-5
    given = {} if g is None else {"load": g}
    scene = ss.scene("linear_oscillator", omega=3.0, xi=0.1, u0=1.0, v0=0.3, **given)
    frame = ss.structure([[1.0]], [[9.0]], C=[[0.6]], u0=1.0, v0=0.3, load=() if g is None else ([1.0], g))
    expected, found = (ss.march(x, scheme, tol=tol, t_end=3.0) for x in (scene, frame))
    assert found.status == "completed"
    assert np.allclose(found.t[:4], expected.t[:4], rtol=1e-3)
    assert abs(cost(found).accepted - cost(expected).accepted) <= 0.2 * cost(expected).accepted
    assert cost(found).rejected <= cost(expected).rejected + 3
    assert np.abs(found.u[-1] - expected.u[-1]) < 20 * tol
    if scheme in ("average_acceleration", "bathe") and cost(found).accepted == cost(expected).accepted:
        assert np.abs(found.u - expected.u).max() < 1e-10
        assert np.abs(found.a - expected.a).max() < 1e-9


@pytest.mark.parametrize("scheme", BY_NAME.values(), ids=lambda s: s.name)
def test_steps_of_one_length_are_those_of_a_constant_step_or_the_scheme_is_refused(scheme: Any) -> None:
    h, n, damping = 2e-3, 12, "rayleigh" if scheme.takes_damping else "none"
    frame = replace(building(damping), loads=building(damping).loads[2:])  # others jump where some schemes take them
    try:
        ss.scheme(scheme.name).local_error(damped=scheme.takes_damping)
    except ValueError as refused:
        with pytest.raises(ValueError) as also:
            ss.march(frame, scheme.name, tol=1e-3, t_end=0.1)
        assert str(also.value) == str(refused)
        assert scheme.name in str(also.value)
        return
    r = ss.march(frame, scheme.name, tol=1e6, t_end=n * h, dt_first=h, dt_max=h, account=False)
    expected = ss.march(frame, scheme.name, h, n * h, account=False)
    assert (r.status, cost(r).accepted, cost(r).rejected) == ("completed", n, 0)
    for name in "uva":
        found, wanted = getattr(r, name), getattr(expected, name)
        assert np.abs(found - wanted).max() <= 1e-11 * np.abs(wanted).max(), name


@pytest.mark.parametrize("damping", ["rayleigh", "modal"])
@pytest.mark.parametrize("scheme", ["bathe", "average_acceleration", "generalized_alpha", "noh_bathe", "esdirk43"])
def test_the_error_follows_the_tolerance(scheme: str, damping: str) -> None:
    frame, found = building(damping), []
    error = ss.scheme(scheme).local_error(damped=True)
    for tol in (1e-4, 1e-6):
        r = ss.march(frame, scheme, tol=tol, t_end=T_END, account=False)
        assert r.status == "completed"
        assert {0.37, 0.61, T_END} <= set(r.t)
        true = exact(frame, r.t[:-1])
        found.append(float(np.abs(r.u - true).max() / np.abs(true).max()))
    power = 1.0 if scheme == "esdirk43" else error.order / (error.order + 1)
    assert found[0] < 0.1
    assert 1 / 3 < (found[0] / found[1]) / 100.0**power < 3


def test_a_load_that_jumps_is_taken_from_its_side_of_the_jump() -> None:
    """The average acceleration scheme keeps the balance of energy; the row at the jump holds what follows."""
    frame = building()
    r = ss.march(frame, "average_acceleration", tol=1e-4, t_end=T_END)
    assert r.account is not None
    assert r.account.share < 1e-12
    k = int(np.flatnonzero(r.t == 0.61)[0])
    after = frame.acceleration(0.61, r.u[k], r.v[k])
    before = after - frame.solve_mass(frame.loads[1][0])
    assert np.abs(r.a[k] - after).max() < 1e-6 * np.abs(after).max()
    assert np.abs(before - after).max() > 0.1 * np.abs(after).max()
    assert len(r.energy) == len(r.t) == cost(r).accepted + 1


@pytest.mark.parametrize("scheme", ["bathe", "average_acceleration"])
def test_lengths_share_their_factorizations(scheme: str) -> None:
    made: list[Any] = []

    def solver(matrix: Any) -> Any:
        made.append(matrix)
        return lambda b: np.linalg.solve(matrix, b)

    M, K = shear_building([2.0, 1.5, 1.5, 1.0], [900.0, 700.0, 600.0, 400.0])
    record = ss.Record(0.02, np.sin(np.arange(300) ** 1.1))
    frame = ss.structure(M, K, C=ss.Rayleigh(0.3, 0.002), solver=solver, load=({3: 1.0}, record))
    r = ss.march(frame, scheme, tol=1e-5, t_end=5.0, account=False)
    assert cost(r).accepted > 400
    assert len(made) < 60


def test_no_length_is_kept_where_nothing_is_factorized() -> None:
    r = ss.march(building("none"), "dormand_prince", tol=1e-6, t_end=T_END, account=False)
    steps = np.diff(r.t)
    assert len(np.unique(np.round(np.log(steps / steps[0]) / np.log(2**0.5), 6) % 1.0)) > 3
    assert np.abs(r.u - exact(building("none"), r.t[:-1])).max() < 1e-4 * np.abs(r.u).max()


@pytest.mark.parametrize("scheme", ["bathe", "average_acceleration", "energy_momentum", "generalized_alpha", "rk2"])
def test_a_nonlinear_structure_takes_the_steps_of_its_scene(scheme: str) -> None:
    scene = ss.scene("duffing", a0="consistent")
    k, eps = scene.parameters["k"], scene.parameters["eps"]
    frame = ss.structure(
        [[1.0]], internal_force=lambda u: k * u * (1 + eps * u * u), tangent=lambda u: [k * (1 + 3 * eps * u * u)],
        potential=lambda u: k * u[0] ** 2 / 2 + k * eps * u[0] ** 4 / 4, u0=scene.u0, v0=scene.v0,
    )  # fmt: skip
    expected, found = (ss.march(x, scheme, tol=1e-5, t_end=0.4, rung=0.0) for x in (scene, frame))
    assert found.status == "completed"
    assert abs(cost(found).accepted - cost(expected).accepted) <= 0.1 * cost(expected).accepted + 2
    assert np.abs(found.u[-1] - expected.u[-1]) < 2e-3 * np.abs(expected.u).max()


def test_an_iteration_that_fails_makes_the_step_shorter() -> None:
    """A tangent that is much too soft lets the iteration diverge where the stiffness matters, in long steps."""
    soft = ss.structure(
        np.eye(2), internal_force=lambda u: 1e4 * u, tangent=lambda u: 200.0 * np.eye(2), v0=[300.0, 100.0]
    )
    r = ss.march(soft, "average_acceleration", tol=1e-3, t_end=0.2, dt_first=0.1, account=False)
    assert r.status == "completed"
    assert 0 < cost(r).newton_failures <= cost(r).rejected
    assert cost(r).newton_iterations == tuple(r.newton_iterations.sum(axis=0))
    assert np.abs(r.u[:, 0] - 3.0 * np.sin(100.0 * r.t)).max() < 0.15


@pytest.mark.parametrize("scheme", ["average_acceleration", "generalized_alpha"])
def test_a_stiff_part_that_follows_statically_does_not_dictate_the_steps(scheme: str) -> None:
    """The estimate is bounded there: without that, 9494 and 790 steps."""
    frame = ss.structure(
        np.eye(2), [[1e8 + 1.0, -1.0], [-1.0, 1.0]], load=({0: 1e4}, ss.Harmonic(1.0, 1.0)), u0=[0.0, 1.0]
    )
    r = ss.march(frame, scheme, tol=1e-4, t_end=3.0, atol=(1e-4, 1e-4), rtol=0.0, account=False)
    assert cost(r).accepted < 150


def test_units_and_places_do_not_change_the_steps() -> None:
    """Scales are the motion's own: another unit of length or mass, fixed degrees of freedom and chosen rows."""
    M, K = shear_building([2.0, 1.5, 1.5, 1.0], [900.0, 700.0, 600.0, 400.0])
    plain = ss.march(building(), "bathe", tol=1e-4, t_end=T_END, account=False)
    scaled = ss.structure(
        1e3 * M, 1e3 * K, C=ss.Rayleigh(0.3, 0.002), load=[({k: 1e6 * x for k, x in P.items()}, g) for P, g in PUSHES],
        u0=[0.0, 10.0, 10.0, 0.0], v0=100.0,
    )  # fmt: skip
    r = ss.march(scaled, "bathe", tol=1e-4, t_end=T_END, account=False)
    assert np.allclose(r.t, plain.t, rtol=1e-9)
    held = np.zeros((5, 5))
    held[:4, :4] = K
    wide = ss.structure(
        np.diag([*np.diag(M), 1.0]), held + np.diag([0, 0, 0, 0, 1.0]), C=ss.Rayleigh(0.3, 0.002), load=PUSHES,
        u0=[0.0, 0.01, 0.01, 0.0, 0.0], v0=[0.1, 0.1, 0.1, 0.1, 0.0], fixed=[4],
    )  # fmt: skip
    r = ss.march(wide, "bathe", tol=1e-4, t_end=T_END, account=False, dofs=[4, 3])
    assert np.array_equal(r.t, plain.t)
    assert np.array_equal(r.u[:, 1], plain.u[:, 3])


def test_from_rest_the_first_steps_are_not_tiny() -> None:
    """Displacements are measured by the static ones under the largest load, as long as there are none."""
    ramp = ss.Record(1.0, [0.0, 1.0, 1.0])
    M, K = shear_building([2.0, 1.0], [90.0, 40.0])
    r = ss.march(ss.structure(M, K, load=({1: 5.0}, ramp)), "bathe", tol=1e-4, t_end=2.0, account=False)
    assert cost(r).accepted < 150
    assert r.t[1] > 0.99e-4
    free = ss.structure(M, np.zeros((2, 2)), load=({1: 5.0}, ramp))
    drift = ss.march(free, "bathe", tol=1e-4, t_end=2.0, account=False)
    assert drift.status == "completed"
    assert drift.u[-1, 1] == pytest.approx(5.0 * (1 / 6 + 1 / 2 + 1 / 2), rel=1e-3)


def test_what_ends_a_run_keeps_what_it_has() -> None:
    r = ss.march(building(), "bathe", tol=1e-9, t_end=T_END, dt_min=1e-2, account=False)
    assert r.status == "step_too_small"
    assert r.t_failed is not None
    assert len(r.t) == len(r.u) == cost(r).accepted + 1

    def load(error: type[BaseException]) -> Any:
        def g(t: Any) -> Any:
            if np.size(t) == 1 and np.max(t) > 0.5:
                raise error
            return np.sin(t)

        return g

    M, K = shear_building([2.0, 1.0], [90.0, 40.0])
    stopped = ss.march(ss.structure(M, K, load=({1: 5.0}, load(KeyboardInterrupt))), "bathe", tol=1e-4, t_end=2.0)
    assert stopped.status == "interrupted"
    assert 0.3 < stopped.t[-1] <= 0.5
    assert stopped.account is not None
    assert len(stopped.account.work) == len(stopped.t)
    with pytest.raises(RuntimeError) as caught:
        ss.march(ss.structure(M, K, load=({1: 5.0}, load(RuntimeError))), "bathe", tol=1e-4, t_end=2.0)
    done = caught.value.response  # type: ignore[attr-defined]
    assert np.array_equal(done.u, stopped.u)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tol": 0.0}, "tol > 0"),
        ({"stride": 2}, "stride and save with dt only"),
        ({"save": "run"}, "stride and save with dt only"),
        ({"grid": [0.1]}, "an argument of march for a structure"),
        ({"tol": None, "dt": 0.1, "rtol": 1e-3}, "rtol with tol only"),
        ({"dt_min": 1.0, "dt_max": 0.1}, "dt_min <= dt_max"),
        ({"atol": [1.0, 2.0, 3.0]}, "one or two numbers"),
        ({"scheme": "houbolt"}, "one-step or composite scheme.*houbolt"),
        ({"scheme": "central_difference_lagged"}, "central_difference_lagged"),
    ],
)
def test_what_does_not_fit_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ss.march(building(), **{"scheme": "bathe", "tol": 1e-3, "t_end": 1.0, **arguments})


def test_degrees_of_freedom_without_mass_are_refused() -> None:
    loose = ss.structure(np.diag([1.0, 0.0]), [[2.0, -1.0], [-1.0, 1.0]], names=("held", "loose"), v0=[1.0, 0.0])
    with pytest.raises(ValueError, match="where steps are chosen, got none at 'loose'"):
        ss.march(loose, "bathe", tol=1e-3, t_end=1.0)


def test_absolute_tolerances_bound_the_error_by_themselves() -> None:
    loose, tight = (
        ss.march(building(), "bathe", tol=1e-6, t_end=T_END, atol=(x, 100 * x), rtol=0.0, account=False)
        for x in (1e-4, 1e-6)
    )  # fmt: skip
    assert 10 < cost(tight).accepted / cost(loose).accepted * 4 < 40


@pytest.mark.parametrize("held", [True, False])
def test_a_structure_that_has_nothing_but_velocity_at_the_start_is_marched(held: bool) -> None:
    K = np.array([[6.0, -2.0], [-2.0, 4.0]]) if held else np.zeros((2, 2))
    model = ss.structure(np.eye(2), K, v0=[3.0, 0.0])
    r = ss.march(model, "bathe", tol=1e-6, t_end=2.0, account=False)
    assert r.status == "completed"
    omega2, shapes = np.linalg.eigh(K)
    q = shapes.T @ [3.0, 0.0]
    exact = shapes @ (q * np.sin(2.0 * omega2**0.5) / omega2**0.5 if held else 2.0 * q)
    assert np.abs(r.u[-1] - exact).max() < 1e-4
