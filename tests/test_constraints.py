"""Scenes with constraints: against exact motions, steps by hand, and what is derived of every scheme."""

import os
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import DeclarationError, Scene, prescribed, rate, required
from substep_derive import t as time
from substep_kernels.facts import CATALOGUE
from sympy import Symbol, sin, sympify
from test_prescribed import REFUSED as NOT_PRESCRIBED

import substep as ss
from substep.core.response import Response

Array = np.ndarray
VERIFY = os.environ.get("SUBSTEP_VERIFY")
G = 9.81
EXPLICIT = {name for name in ss.schemes() if ss.scheme(name).rho_inf == float("inf")}
# as test_prescribed.py holds against steps
DRIFTING = {name for name in ss.schemes() if "u at the ends of steps is not held" in CATALOGUE[name]["constrained"]}
# a constraint is an infinitely stiff spring, whose errors a step multiplies by rho_inf
RADII = {name: ss.scheme(name).rho_inf for name in ss.schemes() if name not in NOT_PRESCRIBED}
GROWING = {name: f"{rho:.4g}" for name, rho in RADII.items() if rho is not None and 1 < rho < np.inf}
TOGETHER = {name for name in ss.schemes() if ss.scheme(name).info.together}
REFUSED = EXPLICIT | DRIFTING | GROWING.keys() | NOT_PRESCRIBED.keys()
TAKEN = [name for name in ss.schemes() if name not in REFUSED | TOGETHER]  # with contacts too
HELD_TOGETHER = [name for name in ss.schemes() if name in TOGETHER - REFUSED]
SLIDING = [*TAKEN, *HELD_TOGETHER]  # with friction
# explicit schemes hold constraints a displacement later, and no contacts
UNHELD = {"forward_euler", "central_difference_lagged", "kim_two_stage", "gsse"}
NEXT = [name for name in ss.schemes() if name in EXPLICIT - UNHELD - NOT_PRESCRIBED.keys()]
ONE_OF_EACH = (
    "newmark",
    "bathe",
    "generalized_alpha",
    "hht_alpha_mixed_displacement",
    "bdf2",
    "energy_momentum",
    "radau_iia2",
)
AT_THE_MEAN = ("energy_momentum", "hht_alpha_mixed_displacement", "generalized_alpha_mixed_displacement")
BEFORE = ("chung_lee", "explicit_generalized_alpha")  # their reaction is that at the start of a step
CHOSEN = [name for name in (*TAKEN, *HELD_TOGETHER, *NEXT) if VERIFY or name in ONE_OF_EACH]

# x, y, rates and the tension of a pendulum of unit mass and length from rest at the horizontal: quadrature to 20 digits
PENDULUM = {
    0.3: (0.905342850921633, -0.424681436237906, -1.22587000207992, -2.613329775781903, 12.498374668481569),
    2.0: (0.793566195343322, -0.608483930443792, 2.10243787443613, 2.74193539301051, 17.9076820729608),
}
# angles, rates and tensions of two points on two rods from the horizontal, likewise
DOUBLE = {
    1.0: (-0.62508769980639, -1.03458508568001, -3.92227957288798, -1.3030992486963, 41.63607887259, 19.94585969651),
    3.0: (1.78579552207742, 1.11810746120516, 0.32798061951446, -0.50445510394531, -2.725864614256, -0.943012275821),
}


@cache
def pendulum() -> Any:
    return ss.scene("rod_pendulum", L=1.0, m=1.0, v0=0.0, g=G)


@cache
def marched(name: str, dt: float, t_end: float = 2.0) -> Response:
    return ss.march(pendulum(), name, dt=dt, t_end=t_end)


def errors(r: Response) -> Array:
    """Of u, the larger of two since one may be about to change its sign; then of v, of the multiplier of the equations
    of motion, and of the scheme's own, at 2 s.
    """
    of_u = [np.hypot(*(r.u[np.abs(r.t - t).argmin()] - known[:2])) for t, known in PENDULUM.items()]
    *_, vx, vy, tension = PENDULUM[2.0]
    of_v, multipliers = np.hypot(*(r.v[-1] - (vx, vy))), (r.multipliers["rod"], r.memory["rod"])
    return np.array([max(of_u), of_v, *(abs(x[-1] - tension) for x in multipliers)])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", CHOSEN)
def test_errors_fall_with_the_orders_that_are_derived(name: str) -> None:
    """v and the multiplier that follows with it: the scheme's order or that of `prescribed`, whichever is less.

    u at least so; the scheme's own multiplier the same with that of its reaction, where this is at the end of a step.
    """
    of = prescribed(name)
    assert of.velocity is not None
    assert of.multiplier is not None
    order = ss.scheme(name).facts.order
    assert order is not None
    expected = min(*order[:2], of.velocity.power)
    orders = np.log2(errors(marched(name, 0.005)) / errors(marched(name, 0.0025)))
    assert orders[0] > expected - 0.2, orders
    assert orders[1] == pytest.approx(expected, abs=0.2), orders
    assert orders[2] > expected - 0.35, orders
    if name not in (*AT_THE_MEAN, *BEFORE):
        assert orders[3] == pytest.approx(min(expected, of.multiplier.power), abs=0.2), orders


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", CHOSEN)
def test_constraints_hold_to_rounding_at_every_step(name: str) -> None:
    r = marched(name, 0.005)
    assert r.status == "completed"
    assert np.abs((r.u**2).sum(axis=1) - 1.0).max() / 2 <= 1e-12


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("t", [1.0, pytest.param(3.0, marks=pytest.mark.thorough)])
def test_the_double_pendulum_at_a_fine_step(t: float) -> None:
    """Angles from below, their rates, and both tensions, to the error of the scheme, which is of second order."""

    def off(dt: float) -> Array:
        r = ss.march("rod_double_pendulum", "bathe", dt=dt, t_end=t)
        (x1, y1, x2, y2), (a1, b1, a2, b2) = r.u[-1], r.v[-1]
        x, y, a, b = np.array([x1, x2 - x1]), np.array([y1, y2 - y1]), np.array([a1, a2 - a1]), np.array([b1, b2 - b1])
        tension = [r.multipliers[name][-1] for name in ("rod1", "rod2")]
        return np.array([*np.arctan2(x, -y), *(x * b - y * a), *tension]) - DOUBLE[t]

    coarse, fine = off(0.002), off(0.001)
    assert np.abs(4 * fine - coarse).max() / 3 < 2e-5
    assert np.abs(fine).max() < 0.01


@pytest.mark.usefixtures("uncompiled")
def test_energy_momentum_keeps_the_energy() -> None:
    r = marched("energy_momentum", 0.01)
    assert np.abs(r.energy).max() < 1e-11 * G


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.filterwarnings("ignore:average_acceleration has gained energy on rod_pendulum")
def test_the_trapezoidal_rule_gains_energy_from_a_start_in_motion() -> None:
    """Its multipliers have a double root at -1: it gains 1 % after 1 to 4 s, at any step, and goes on."""
    x, y, vx, vy, _ = PENDULUM[0.3]
    for dt in (0.02, 0.005):
        r = ss.march(pendulum(), "average_acceleration", dt=dt, t_end=6.0, start={"u": [x, y], "v": [vx, vy]})
        gained = np.abs(r.energy) > 0.01 * G
        assert 1.0 < r.t[np.argmax(gained)] < 4.0
        assert np.abs(r.energy).max() > 10 * G


def test_a_prescribed_motion_follows_what_is_derived() -> None:
    """A point driven along sin t: errors of its velocity and of the drive's force are those that `prescribed` gives."""
    x, y = Symbol("x"), Symbol("y")
    driven = Scene(
        "driven_point", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2, potential=y**2 / 2,
        constraints={"drive": x - sin(time)}, parameters=(), start={x: 0, y: 1, rate(x): 1, rate(y): 0}, length=1,
    )  # fmt: skip
    dt = 0.01
    r, found = ss.march(ss.scene(driven), "bathe", dt=dt, t_end=1.0), prescribed("bathe")
    assert found.velocity is not None
    assert found.multiplier is not None
    assert np.allclose(r.u[:, 0], np.sin(r.t), rtol=0.0, atol=1e-14)
    t = r.t[-1]
    assert r.v[-1, 0] - np.cos(t) == pytest.approx(float(found.velocity.coefficient) * dt**2 * -np.cos(t), rel=0.05)
    own = -(r.memory["drive"][-1]) + np.sin(t)  # the acceleration is minus the multiplier, per unit mass
    assert own == pytest.approx(float(found.multiplier.coefficient) * dt * -np.cos(t), rel=0.05)
    assert r.multipliers["drive"][-1] == pytest.approx(np.sin(t), abs=1e-14)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["bathe", "generalized_alpha", "bdf2"])
def test_a_run_that_goes_on_is_the_one_that_was_not_broken(name: str) -> None:
    first = marched(name, 0.01, 1.0)
    whole, rest = marched(name, 0.01, 2.0), ss.march(pendulum(), name, dt=0.01, t_end=2.0, start=first)
    assert np.array_equal(rest.u, whole.u[100:])
    assert np.array_equal(rest.memory["rod"], whole.memory["rod"][100:])


def test_lanes_are_single_runs() -> None:
    speeds = np.linspace(5.0, 8.0, 20)
    ds = ss.sweep("rod_pendulum", "generalized_alpha", dt=0.02, t_end=1.0, keep="final", v0=speeds, g=G)
    for v0, u, kept in zip(speeds[::7], ds.u.values[::7], ds.memory.values[::7], strict=True):
        one = ss.march(ss.scene("rod_pendulum", v0=v0, g=G), "generalized_alpha", dt=0.02, t_end=1.0)
        assert np.allclose(u, one.u[-1], rtol=0.0, atol=1e-12)
        assert kept[0] == pytest.approx(one.memory["rod"][-1], rel=1e-9)


@pytest.mark.usefixtures("uncompiled")
def test_angles_give_the_same_motion() -> None:
    """The rigid pendulum without constraint, by SciPy, and the rod's."""
    r = marched("bathe", 0.0025)
    s = solve_ivp(lambda t, y: [y[1], -G * np.cos(y[0])], (0, 2), [0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-12)
    angle = s.y[0, -1]
    assert np.allclose(r.u[-1], [np.cos(angle), np.sin(angle)], rtol=0.0, atol=2e-4)


def test_a_start_in_a_singular_position_is_refused() -> None:
    """The rhombus flattened exactly: both ways on are open there, and its constraints repeat each other."""
    x1, y1, x2, y2 = (Symbol(s) for s in ("x1", "y1", "x2", "y2"))
    from substep_derive.declare.scenes.constrained import four_bar

    own = Scene(
        **{f: getattr(four_bar, f) for f in four_bar.__dataclass_fields__ if f not in ("name", "start", "reference")},
        name="flat_four_bar",
        start={x1: 1, y1: 0, x2: 2, y2: 0, **{rate(q): 0 for q in (x1, y1, x2, y2)}},
    )
    with pytest.raises(ValueError, match=r"independent constraints.*got 2 independent of 3 at the start"):
        ss.scene(own)


def test_a_constraint_that_is_given_twice_is_named() -> None:
    x, y = Symbol("x"), Symbol("y")
    twice = Scene(
        "twice_held", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2, potential=y,
        constraints={"one": x - 1, "other": 2 * x - 2, "floor": y}, parameters=(),
        start={x: 1, y: 0, rate(x): 0, rate(y): 0}, length=1,
    )  # fmt: skip
    with pytest.raises(ValueError, match="2 independent of 3 at the start: one, other repeat each other"):
        ss.scene(twice)


@pytest.mark.usefixtures("uncompiled")
def test_a_start_that_constraints_do_not_allow_is_refused_with_the_amount_and_the_nearest_one_is_at_hand() -> None:
    scene = pendulum()
    with pytest.raises(ValueError, match=r"got u off by -0.0202.*across 'rod'"):
        ss.march(scene, "bathe", dt=0.01, t_end=0.1, start={"u": [0.98, 0.0], "v": [0.0, 0.0]})
    with pytest.raises(ValueError, match="got v off by 0.5 across 'rod'"):
        ss.march(scene, "bathe", dt=0.01, t_end=0.1, start={"u": [1.0, 0.0], "v": [0.5, 0.0]})
    start = scene.allowed([0.98, 0.1], [0.5, 2.0])
    assert np.hypot(*start.u) == pytest.approx(1.0, abs=1e-15)
    assert start.u @ start.v == pytest.approx(0.0, abs=1e-14)
    assert ss.march(scene, "bathe", dt=0.01, t_end=0.1, start=start).status == "completed"
    with pytest.raises(ValueError, match="numbers for rod_pendulum, got shapes"):
        scene.allowed([1.0], [0.0, 0.0])
    with pytest.raises(
        ValueError, match=r"got v off by 0.5 across 'rod' at t = 3 s; .* start=scene.allowed\(u, v, 3\)"
    ):
        ss.march(scene, "bathe", dt=0.01, t_end=3.1, start={"t": 3.0, "u": [1.0, 0.0], "v": [0.5, 0.0]})


def test_the_nearest_start_keeps_the_constraints_or_is_none() -> None:
    """From the pivot of a rod no direction leads to its circle; a heavy point goes there as a light one does."""
    with pytest.raises(ValueError, match="corrections do not reach 'rod'; give a nearer one"):
        pendulum().allowed([0.0, 0.0], [0.0, 0.0])
    with pytest.raises(ValueError, match="corrections do not reach 'rod' at t = 2 s"):
        pendulum().allowed([0.0, 0.0], [0.0, 0.0], 2.0)
    start = ss.scene("rod_pendulum", L=1.0, m=1e8, v0=0.0, g=G).allowed([1.5, 2.0], [5.0, 0.0])
    assert np.allclose(start.u, [0.6, 0.8], rtol=0.0, atol=1e-14)
    assert np.allclose(start.v, [3.2, -2.4], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("forward_euler", "moves its first displacement by the velocity of the start alone"),
        ("central_difference_lagged", r"reports a velocity with the force N\(u_1\), whose reaction only the next step"),
        ("kim_two_stage", "multiplies errors along constraints by 3.732"),
        ("gsse", "multiplies errors along constraints by 24.96"),
        ("stoermer_extrapolation", "expected the reaction of each balance to move a displacement"),
        ("wilson_theta", "takes no force at the end of its steps"),
        ("crouzeix3", "takes no force at the end of its steps"),
        ("kr_alpha", "coefficients from the structure"),
        ("gauss3", "takes no force at the end of its steps"),
        ("lobatto_iiia3", "expected a state that a smooth motion determines"),
        *((name, f"multiplies them by {factor}") for name, factor in GROWING.items()),
    ],
)
def test_what_cannot_hold_a_constraint_is_refused_by_name(name: str, reason: str) -> None:
    with pytest.raises(ValueError, match=reason) as found:
        ss.march(pendulum(), name, dt=0.01, t_end=0.1)
    assert name in str(found.value)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(
    ("potential", "link", "start", "exact"),
    [
        ("x**2/2 + y**2", "y - x", (1, 1), np.cos(np.sqrt(3.0))),  # u'' = -3 u of both
        ("2*x**2", "y - x", (1, 1), np.cos(2.0)),
        ("x**2/2 + y**2", "(x**2 + y**2 - 1)/2", (0.6, -0.8), 0.6 * np.cosh(1.0)),  # y^2 = 1 - x^2
        ("0*x", "(x**2 + y**2 - 1)/2", (0.6, -0.8), 0.6),
    ],
)
def test_a_mass_that_constraints_alone_give_is_taken_where_no_acceleration_is_mixed(
    potential: str, link: str, start: tuple[float, float], exact: float
) -> None:
    """A point without mass on a link, with a stiffness of its own or without, and on a circle."""
    x, y = Symbol("x"), Symbol("y")
    given = Scene(
        "massless_link", coordinates={x: "m", y: "m"}, kinetic=rate(x) ** 2 / 2, potential=sympify(potential),
        constraints={"link": sympify(link)}, parameters=(), length=1,
        start={x: start[0], y: start[1], rate(x): 0, rate(y): 0},
    )  # fmt: skip
    for name in ("average_acceleration", "bathe", "bdf2"):
        r = ss.march(ss.scene(given), name, dt=0.01, t_end=1.0)
        assert r.u[-1, 0] == pytest.approx(exact, abs=3e-4)
    r = ss.march(ss.scene(given), "bathe", tol=1e-6, t_end=1.0)
    assert r.u[-1, 0] == pytest.approx(exact, abs=3e-4)
    with pytest.raises(
        ValueError, match=r"^generalized_alpha: expected a mass matrix .* regular.* got no mass of y; take"
    ):
        ss.march(ss.scene(given), "generalized_alpha", dt=0.01, t_end=1.0)


@pytest.mark.parametrize("name", GROWING)
def test_a_sweep_refuses_them_before_any_run(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where only some values of a parameter multiply errors."""
    monkeypatch.setattr("substep.sweeps.scene_plan.march_group", None)
    with pytest.raises(ValueError, match=rf"rod_pendulum .* got {name}, which multiplies them by {GROWING[name]}"):
        ss.sweep("rod_pendulum", name, dt=0.01, t_end=0.1, L=[1.0, 2.0])
    with pytest.raises(ValueError, match="got newmark, which multiplies them by"):
        ss.sweep("rod_pendulum", "newmark", beta=[0.25, 0.2], gamma=0.5, dt=0.01, t_end=0.1)


def test_every_scheme_is_taken_or_refused() -> None:
    assert REFUSED | {*TAKEN, *HELD_TOGETHER} == set(ss.schemes())
    assert {"central_difference", "rk4", "yoshida6"} < set(NEXT)


def test_wrong_declarations_are_refused() -> None:
    x = Symbol("x")
    given: dict[str, Any] = {
        "coordinates": {x: "m"}, "kinetic": rate(x) ** 2 / 2, "potential": x**2, "parameters": (required(Symbol("k")),),
        "start": {x: 0, rate(x): 0}, "length": 1,
    }  # fmt: skip
    with pytest.raises(DeclarationError, match="constraint wall to depend on coordinates"):
        Scene("still", **given, constraints={"wall": Symbol("k") - time})
    with pytest.raises(DeclarationError, match="constraint wall holds 'z'"):
        Scene("unknown", **given, constraints={"wall": x - Symbol("z")})
    with pytest.raises(DeclarationError):
        Scene("collides", **given, constraints={"x": x - 1})


# Simeon's slider-crank at 0.1 s, and Andrews' mechanism at 0.03 s: coordinates, rates, multipliers, computed in 80 bits
MECHANISMS = {
    "slider_crank": (
        0.1, 10000, [0.0, 382.482],
        [12.1511500069238, 0.203089099262018, 0.431088560743116],
        [130.207233389032, -60.8215833730691, 11.558918795572],
        [-129.753930176011, 184.622084408943],
    ),
    "squeezer": (
        0.03, 10000, [98.566870396241, -6.122688344255, 0.0, 0.0, 0.0, 0.0],
        [15.810771195153712, -15.756371058411845, 0.040822240119645341, -0.53473011634208029,
         0.52440996587995393, 0.53473011634208024, 1.0480807410419376],
        [1139.9203022591059, -1424.3792951775398, 11.03291191061981, 19.293374105034177,
         0.57356991482956574, -19.293374105034184, 0.3231791492491493],
        [199.17534810453844, -29.755309974971893, 23.06654361162216, 31.452725275771308,
         22.642494786394358, 11.61739235261104],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ["slider_crank", pytest.param("squeezer", marks=pytest.mark.thorough)])
def test_mechanisms_with_a_mass_that_moves(name: str) -> None:
    """A scheme of third order at two steps, extrapolated: ten digits; at the coarser one about six."""
    t_end, steps, at_start, *expected = MECHANISMS[name]
    found = []
    for n in (steps, 2 * steps):
        r = ss.march(name, "bdf3", dt=t_end / n, t_end=t_end)
        assert r.status == "completed"
        found.append([r.u[-1], r.v[-1], np.array([x[-1] for x in r.multipliers.values()])])
    assert np.allclose([x[0] for x in r.multipliers.values()], at_start, rtol=1e-10, atol=1e-10)
    for coarse, fine, exact in zip(*found, map(np.array, expected), strict=True):
        size = np.abs(exact).max()
        assert np.abs(coarse - exact).max() < 3e-6 * size
        assert np.abs((8 * fine - coarse) / 7 - exact).max() < 1e-9 * size
