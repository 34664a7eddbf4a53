"""Scenes whose mass depends on the position, or whose forces depend on rates and time: every scheme on Lagrange's
equations."""

import os
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, OF_MATRICES, UNDAMPED, mixes_otherwise
from lagrange_oracle import BY_HAND, equations, generalized_alpha, generalized_alpha_of_forces, marched
from plain_kernels import text_of, uncompiled
from scipy.integrate import solve_ivp
from substep_derive import Scene, optional, rate, sampled, t
from substep_derive.declare.catalogue import find_law, find_scene
from substep_derive.declare.scenes import lagrange
from substep_derive.motion.equations import EquationsOfMotion
from substep_kernels.facts import CATALOGUE
from sympy import Abs, Rational, Symbol, cos, exp, sin, sqrt, symbols
from test_lagrange_declarations import declared

import substep as ss
from substep.derived.modules import adaptive_pair, uncommitted_pair

VERIFY = bool(os.environ.get("SUBSTEP_VERIFY"))
GENERAL = {s.name for s in lagrange.ALL if EquationsOfMotion(s).general}
DISCRETE = {"energy_momentum"}
INTERPOLATED = {"discontinuous_galerkin_p1"}  # takes the force at two knots that its balances move
MIXED = {name for name, s in BY_NAME.items() if mixes_otherwise(s)} - {*OF_MATRICES, *UNDAMPED} - INTERPOLATED
REFUSED = {*OF_MATRICES} | DISCRETE | INTERPOLATED | MIXED | set(UNDAMPED)  # on a mass that moves
u, w, k, c, m = symbols("u w k c m")
q1, q2, q3 = coordinates = symbols("q1:4")


@cache
def kernels(scheme: str, scene: Any) -> ModuleType:
    return uncompiled(text_of(uncommitted_pair(scheme, scene)))


@pytest.fixture
def plainly(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Kernels of catalogue schemes on any scene as plain Python."""
    from substep.core import threads
    from substep.marching import adaptive, scene_lanes

    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: kernels(scheme.name, scene.info.source))
    monkeypatch.setattr(adaptive, "_kernels", cache(lambda *of: uncompiled(text_of(adaptive_pair(*of)))))
    monkeypatch.setattr(threads, "cores", lambda: 1)
    with np.errstate(all="ignore"):
        yield


# end values, from the independent computation: u and v
VALUES = [
    ("double_pendulum", {}, 2.0, 200, [-0.48297153, -1.32404871], [3.06528819, 2.94927155]),
    ("kapitza", {"omega_d": 20.0}, 20.0, 4000, [2.73488477], [-0.04026225]),
    ("kapitza", {"omega_d": 40.0}, 20.0, 8000, [3.0990535], [0.16319069]),
    ("van_der_pol", {}, 20.0, 1000, [2.00814976], [-0.04250888]),
    ("quadratic_drag", {}, 10.0, 500, [-0.60385168], [0.3788996]),
]


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize(("scene", "given", "t_end", "n", "expected_u", "expected_v"), VALUES)
def test_end_values_are_those_computed_independently(
    scene: str, given: Mapping[str, float], t_end: float, n: int, expected_u: Any, expected_v: Any
) -> None:
    r = ss.march(ss.scene(scene, **given), "butcher6", t_end / n, t_end)
    assert r.status == "completed"
    np.testing.assert_allclose(r.u[-1], expected_u, rtol=0, atol=1e-8)
    np.testing.assert_allclose(r.v[-1], expected_v, rtol=0, atol=1e-8)


@cache
def exact(scene: str, t_end: float) -> tuple[Any, Any]:
    """u, v at t_end by SciPy's DOP853, from equations that SymPy's mechanics module has derived."""
    handle = ss.scene(scene)
    d = len(handle.u0)
    e = equations(next(s for s in lagrange.ALL if s.name == scene), handle.parameters)
    y = solve_ivp(
        lambda t, y: [*y[d:], *e.at(y[:d], y[d:], t)], (0.0, t_end), [*handle.u0, *handle.v0], method="DOP853",
        rtol=1e-13, atol=1e-13,
    ).y[:, -1]  # fmt: skip
    return y[:d], y[d:]


@pytest.mark.matrix
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", sorted(set(BY_NAME) - REFUSED))
def test_every_scheme_keeps_its_order_where_the_mass_moves(scheme: str) -> None:
    """On the double pendulum in angles, u and v in the order of the scheme on u'' = g(u) - C u', against DOP853."""
    expected = min(CATALOGUE[scheme]["nonlinear_order"][:2])
    steps = (25, 50) if expected > 4 else (50, 100) if expected > 2 else (200, 400)
    u, v = exact("double_pendulum", 0.5)
    errors = []
    for n in steps:
        r = ss.march("double_pendulum", scheme, 0.5 / n, 0.5)
        assert r.status == "completed"
        errors.append(max(np.abs(r.u[-1] - u).max(), np.abs(r.v[-1] - v).max()))
    assert errors[1] < 0.05
    assert errors[1] <= 1e-11 or np.log2(errors[0] / errors[1]) >= expected - 0.35, errors


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", sorted(REFUSED))
def test_what_cannot_take_a_moving_mass_is_refused_by_name(scheme: str) -> None:
    reason = (
        "coefficients from matrices" if scheme in OF_MATRICES
        else "discrete gradient" if scheme in DISCRETE
        else "mixes the velocities of the knots of its force" if scheme in MIXED
        else "at one knot that depends" if scheme in INTERPOLATED else r"scheme for u'' = g\(t, u\)"
    )  # fmt: skip
    chosen = [{"tol": 1e-6}] if scheme in {*DISCRETE, "kr_alpha_plain_start", "rkn43"} else []  # which could take it
    for step in ({"dt": 0.01}, *chosen):
        with pytest.raises(ValueError, match=f"^{scheme}:? .*{reason}.*double_pendulum"):
            ss.march("double_pendulum", scheme, t_end=1.0, **step)


def test_the_other_reading_loses_an_order() -> None:
    """Forces of inertia M(u_k) a_k mixed at the knots, as written by hand: why accelerations are mixed instead."""
    e = equations(lagrange.double_pendulum, ss.scene("double_pendulum").parameters)
    u, _ = exact("double_pendulum", 0.5)
    start = np.array([np.pi / 2, np.pi / 2]), np.zeros(2)
    errors = {}
    for step in (generalized_alpha, generalized_alpha_of_forces):
        *_, coarse = marched(step, e, 0.5 / 150, 150, *start)
        *_, fine = marched(step, e, 0.5 / 300, 300, *start)
        errors[step.__name__] = np.log2(np.abs(coarse[0] - u).max() / np.abs(fine[0] - u).max())
    assert errors["generalized_alpha"] > 1.9
    assert errors["generalized_alpha_of_forces"] < 1.25


def row(k: int, rng: np.random.Generator, n: int) -> Any:
    """A generalised velocity: mostly the k-th rate, with the others' shares depending on coordinates and time."""
    share = [Rational(int(rng.integers(-4, 5)), 12) for _ in range(4)]
    other, here = coordinates[int(rng.integers(n))], coordinates[k]
    mixed = sum((s * rate(x) for s, x in zip(share, coordinates[:n], strict=False)), 0)
    return rate(here) + mixed * cos(other) / 2 + share[3] * sin(other + t) + share[0] * other * rate(here) / 3


def drawn(seed: int) -> Scene:
    """A random scene of one to three coordinates."""
    rng = np.random.default_rng(seed)
    n = 1 + seed % 3
    q = coordinates[:n]
    a, b, d = (Rational(int(x), 7) for x in rng.integers(1, 9, 3))
    kinetic = sum((row(i, rng, n) ** 2 for i in range(n)), 0) / 2
    potential = sum((a * x**2 / 2 - b * cos(x + i) + d * x * q[i - 1] * sin(2 * t) / 4 for i, x in enumerate(q)), 0)
    last, first = q[-1], q[0]
    return Scene(
        f"drawn_{seed}",
        coordinates=dict.fromkeys(q, "m"),
        kinetic=kinetic,
        potential=potential,
        dissipation=c * Abs(rate(first)) ** 3 / 3 + d * rate(last) ** 2 / 9 * exp(first / 5),
        forces={last: (1 - last**2) * rate(last) / 3 + b * first * cos(t), first: -Abs(last) * last / 5},
        load={first: sin(3 * t)},
        parameters=(optional(c, Rational(1, 5)),),
        start={x: Rational(int(rng.integers(-6, 7)), 10) for x in (*q, *map(rate, q))},
        length=1,
    )


@pytest.mark.matrix
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", BY_HAND)
@pytest.mark.parametrize("seed", range(24 if VERIFY else 2))
def test_random_scenes_step_as_written_by_hand(seed: int, scheme: str) -> None:
    scene, (step, given) = drawn(seed), BY_HAND[scheme]
    handle, h, n = ss.scene(scene), 0.01, 12
    e = equations(scene, handle.parameters)
    expected = list(marched(step, e, h, n, handle.u0, handle.v0))
    np.testing.assert_allclose(handle.a0, expected[0][2], rtol=1e-12, atol=1e-12)
    r = ss.march(handle, ss.scheme(scheme, **given), h, n * h)
    for kind, found in enumerate((r.u, r.v, r.a)):
        np.testing.assert_allclose(found, [x[kind] for x in expected], rtol=0, atol=3e-11)


@pytest.mark.matrix
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", ["average_acceleration", "generalized_alpha", "bathe", "dormand_prince", "esdirk43"])
@pytest.mark.parametrize("scene", ["double_pendulum", "van_der_pol", "kapitza"])
def test_chosen_steps_keep_to_the_tolerance(scene: str, scheme: str) -> None:
    t_end = 1.0
    u, _ = exact(scene, t_end)
    errors, steps = [], []
    for tol in (1e-4, 1e-6):
        r = ss.march(scene, scheme, tol=tol, t_end=t_end)
        assert r.status == "completed"
        errors.append(np.abs(r.u[-1] - u).max())
        steps.append(len(r.t))
    assert errors[0] < 100 * 1e-4
    assert errors[1] < 100 * 1e-6
    assert steps[0] < steps[1]


@pytest.mark.matrix
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", ["generalized_alpha", "newmark_bdf2", "houbolt", "rk4"])
@pytest.mark.parametrize("scene", ["cart_pole", "kapitza"])
def test_a_run_goes_on_to_the_bit(scene: str, scheme: str) -> None:
    whole = ss.march(scene, scheme, 0.01, 0.4)
    first = ss.march(scene, scheme, 0.01, 0.1)
    then = ss.march(scene, scheme, 0.01, 0.4, start=first)
    for kind in "uva":
        assert np.array_equal(getattr(whole, kind)[10:], getattr(then, kind))
    chosen = ss.march(scene, "rk4", tol=1e-8, t_end=0.4, start=first)
    assert np.abs(chosen.u[-1] - whole.u[-1]).max() < 0.01


@pytest.mark.thorough
@pytest.mark.parametrize("scheme", ["generalized_alpha", *(["bathe", "rk4"] if VERIFY else [])])
def test_lanes_side_by_side_are_the_runs_one_by_one(scheme: str) -> None:
    """Compiled, in blocks of lanes whose iterations wait for each other: a sweep has the results of single runs."""
    angles = np.linspace(0.2, 3.0, 24)
    found = ss.sweep("double_pendulum", scheme, dt=0.02, t_end=1.0, keep="final", theta1_0=angles)
    for k in (0, 11, 23):
        r = ss.march(ss.scene("double_pendulum", theta1_0=angles[k]), scheme, 0.02, 1.0)
        np.testing.assert_allclose(found.u.to_numpy()[k], r.u[-1], rtol=0, atol=1e-11)


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scene", ["double_pendulum", "spring_pendulum", "rotating_hoop", "cart_pole", "heavy_top"])
def test_the_energy_of_lagranges_equations_is_kept(scene: str) -> None:
    """T_2 - T_0 + V, also on a hoop that is turned."""
    r = ss.march(scene, "dormand_prince", 0.005, 1.0)
    np.testing.assert_allclose(r.energy, r.energy[0], rtol=0, atol=2e-8 * max(abs(r.energy[0]), 1.0))
    if scene == "rotating_hoop":
        p = r.scene.parameters
        T0 = p["m"] * (p["R"] * p["spin"] * np.sin(r.u[:, 0])) ** 2 / 2
        T2, V = p["m"] * (p["R"] * r.v[:, 0]) ** 2 / 2, p["m"] * p["g"] * p["R"] * (1 - np.cos(r.u[:, 0]))
        np.testing.assert_allclose(r.energy, T2 - T0 + V, rtol=0, atol=1e-13)
        assert np.ptp(T2 + V) > 0.1
        kept = ss.march(scene, "energy_momentum", 0.05, 5.0)
        np.testing.assert_allclose(kept.energy, kept.energy[0], rtol=0, atol=1e-11)


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scene", ["van_der_pol", "kapitza", "quadratic_drag"])
def test_a_discrete_gradient_stands_beside_other_forces(scene: str) -> None:
    u, v = exact(scene, 1.0)
    errors = []
    for n in (100, 200):
        r = ss.march(scene, "energy_momentum", 1.0 / n, 1.0)
        errors.append(max(np.abs(r.u[-1] - u).max(), np.abs(r.v[-1] - v).max()))
    assert np.log2(errors[0] / errors[1]) > 1.8


@pytest.mark.usefixtures("plainly")
def test_what_a_feedback_holds_stays_up_and_what_is_shaken_too() -> None:
    falls = ss.march("cart_pole", "bathe", 0.01, 3.0)
    held = ss.march(ss.scene("cart_pole", gain_x=1.0, gain_v=2.0, gain_angle=30.0, gain_spin=6.0), "bathe", 0.01, 3.0)
    assert np.abs(falls.u[:, 1]).max() > 3.0
    assert np.abs(held.u[200:, 1]).max() < 0.1
    slow, fast = (ss.march(ss.scene("kapitza", omega_d=x), "rk4", 0.002, 20.0).u[:, 0] - np.pi for x in (20.0, 40.0))
    assert np.abs(slow).max() > 0.3
    assert np.abs(fast).max() < 0.25


@pytest.mark.usefixtures("plainly")
def test_a_law_acts_where_the_mass_moves() -> None:
    """A hinge with dry friction in a swinging spring: it loses what the law says, and the rest is kept."""
    friction = replace(
        lagrange.spring_pendulum, name="rusty",
        laws={"hinge": find_law("coulomb").on(Symbol("theta"), stiffness=400, q_y=Rational(1, 2))},
    )  # fmt: skip
    r = ss.march(friction, "average_acceleration", 0.001, 2.0)
    lost = r.energy_dissipated
    assert lost[-1] > 0.2
    np.testing.assert_allclose(r.energy + lost, r.energy[0] + lost[0], rtol=0, atol=1e-5)


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", ["average_acceleration", "generalized_alpha", "backward_euler", "bathe"])
def test_a_force_that_is_steep_at_rest_is_not_passed_over(scheme: str) -> None:
    """Of sqrt(|v|), whose slope has no bound where a run from rest begins: each step fulfils its balance."""
    steep = declared(
        coordinates={u: "m"}, kinetic=rate(u) ** 2 / 2, parameters=(), start={u: 1, rate(u): 0},
        potential=u**2 / 2, dissipation=Abs(rate(u)) ** Rational(3, 2) / 5,
    )  # fmt: skip
    r = ss.march(steep, scheme, 0.01, 0.5)
    assert r.status == "completed"
    if scheme == "generalized_alpha":
        force = -(r.u + 0.3 * np.sqrt(np.abs(r.v)) * np.sign(r.v))[:, 0]
        a, am, af = r.a[:, 0], 1 / 3, 4 / 9
        left = (1 - am) * a[1:] + am * a[:-1] - (1 - af) * force[1:] - af * force[:-1]
    else:
        left = (r.a + r.u + 0.3 * np.sqrt(np.abs(r.v)) * np.sign(r.v))[1:, 0]
    assert np.abs(left).max() < 1e-9


@pytest.mark.usefixtures("plainly")
def test_a_damper_acts_along_a_bar_that_turns() -> None:
    """A law of the rate over an elongation that is not linear in the coordinates, against SciPy."""
    x, y = symbols("x y")
    along = find_law("power_damper").on(sqrt(x**2 + y**2), c=50, exponent=1)
    damped = ss.scene(replace(find_scene("elastic_pendulum"), name="damped_bar", laws={"damper": along}), EA=1e4)
    EA, L, mass, _ = damped.parameters.values()

    def rates(_: float, z: Any) -> Any:
        r2, moved = z[0] ** 2 + z[1] ** 2, z[:2] @ z[2:]
        force = EA * (r2 - L**2) / (2 * L**3) + 50.0 * moved / r2
        return [*z[2:], *(-force / mass * z[:2])]

    z = solve_ivp(rates, (0, 1), [*damped.u0, *damped.v0], rtol=1e-12, atol=1e-12, method="DOP853").y[:, -1]
    r = ss.march(damped, "dormand_prince", 0.005, 1.0)
    np.testing.assert_allclose(np.r_[r.u[-1], r.v[-1]], z, rtol=0, atol=1e-6)
    errors = [np.abs(ss.march(damped, "bathe", 1.0 / n, 1.0).u[-1] - z[:2]).max() for n in (200, 400)]
    assert np.log2(errors[0] / errors[1]) > 1.9


@pytest.mark.usefixtures("plainly")
def test_a_gain_of_energy_is_said_of_a_scene_that_keeps_it() -> None:
    """Also where its inertia has forces of rates, but not where forces give energy."""
    assert ss.scene("double_pendulum").info.conserves
    assert not any(ss.scene(name).info.conserves for name in ("cart_pole", "van_der_pol", "quadratic_drag"))
    with pytest.warns(UserWarning, match="^forward_euler has gained energy on double_pendulum, which conserves it"):
        ss.march("double_pendulum", "forward_euler", 0.05, 10.0)
    r = ss.march(ss.scene("van_der_pol", q0=0.001), "rk4", 0.05, 20.0)
    assert r.energy[-1] > 1000 * r.energy[0]


@pytest.mark.usefixtures("plainly")
def test_chosen_steps_go_over_a_jump_of_the_load_where_the_mass_moves() -> None:
    """The acceleration jumps with the load, by the inverse of the mass where the motion is."""
    pushed = replace(lagrange.cart_pole, name="pushed", load={Symbol("x"): sampled})
    scene = ss.scene(pushed, load=ss.Step(3.0, start=0.3))
    before = ss.march(ss.scene(pushed), "rk4", 0.005, 0.3)
    fine = ss.march(ss.scene(pushed, load=ss.Step(3.0)), "rk4", 0.005, 0.6, start=before)
    for scheme in ("bathe", "generalized_alpha"):
        chosen = ss.march(scene, scheme, tol=1e-6, t_end=0.6)
        assert np.abs(fine.u[-1] - chosen.u[-1]).max() < 1e-4
        at = int(np.searchsorted(chosen.t, 0.3))
        assert chosen.t[at] == 0.3
