"""Errors along a stiff bar that turns: exact results, steps written from the textbooks, and runs of the pendulum."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from declared import BY_NAME, OF_STIFFNESS
from substep_derive import DeclarationError, turning
from substep_derive.declare.schemes.multi_step import backward_differences
from sympy import Rational, sqrt

import substep as ss
from substep.studies.failures.stiff_bars import cells
from substep.studies.turning import FARTHEST, FRACTIONS, _of_errors, bar_of, early_energy, first_growth, growth

Array = np.ndarray
Stiffness = Callable[[float], Array]  # K (2, 2) per unit mass at an instant in steps
REFUSED = ("energy_momentum", *OF_STIFFNESS)
STATIC = [s for s in BY_NAME if s not in REFUSED]


def stiffness(Omega: float, tau: float) -> Stiffness:
    def K(t: float) -> Array:
        along, across = np.array([np.cos(tau * t), np.sin(tau * t)]), np.array([-np.sin(tau * t), np.cos(tau * t)])
        return Omega**2 * np.outer(along, along) + tau**2 * np.outer(across, across)

    return K


def newmark(x: Array, K: Stiffness, t: float, h: float, beta: float, gamma: float) -> Array:
    """Newmark's step of length h from u, v, a (3, 2) at t; a at the end from the force there."""
    u, v, a = x
    u, v = u + h * v + h**2 * (0.5 - beta) * a, v + h * (1 - gamma) * a
    a = np.linalg.solve(np.eye(2) + beta * h**2 * K(t + h), -K(t + h) @ u)
    return np.array([u + beta * h**2 * a, v + gamma * h * a, a])


def average(x: Array, K: Stiffness) -> Array:
    return newmark(x, K, 0.0, 1.0, 0.25, 0.5)


def bathe(x: Array, K: Stiffness) -> Array:
    """Trapezoidal rule over half of the step, then v_1 = u_0 - 4 u_g + 3 u_1 with h = 1, and a_1 likewise."""
    (u0, v0, _), (ug, vg, _) = x, newmark(x, K, 0.0, 0.5, 0.25, 0.5)
    known = u0 - 4 * ug
    u1 = np.linalg.solve(9 * np.eye(2) + K(1.0), -(v0 - 4 * vg + 3 * known))
    v1 = known + 3 * u1
    return np.array([u1, v1, v0 - 4 * vg + 3 * v1])


def generalized(x: Array, K: Stiffness, rho: float = 0.8) -> Array:
    """Chung and Hulbert, the forces of both ends mixed."""
    m, f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    beta, gamma = (1 - m + f) ** 2 / 4, 0.5 - m + f
    u, v, a = x
    to_u, to_v = u + v + (0.5 - beta) * a, v + (1 - gamma) * a
    force = (1 - f) * K(1.0) @ to_u + f * K(0.0) @ u
    a1 = np.linalg.solve((1 - m) * np.eye(2) + (1 - f) * beta * K(1.0), -force - m * a)
    return np.array([to_u + beta * a1, to_v + gamma * a1, a1])


def hht(x: Array, K: Stiffness) -> Array:
    alpha = -0.1
    beta, gamma = (1 - alpha) ** 2 / 4, 0.5 - alpha
    u, v, a = x
    to_u = u + v + (0.5 - beta) * a
    force = (1 + alpha) * K(1.0) @ to_u - alpha * K(0.0) @ u
    a1 = np.linalg.solve(np.eye(2) + (1 + alpha) * beta * K(1.0), -force)
    return np.array([to_u + beta * a1, v + (1 - gamma) * a + gamma * a1, a1])


def houbolt(x: Array, K: Stiffness) -> Array:
    """u_1, u_0 and u_-1 from u_0, u_-1 and u_-2."""
    u0, before, earlier = x
    u1 = np.linalg.solve(2 * np.eye(2) + K(1.0), 5 * u0 - 4 * before + earlier)
    return np.array([u1, u0, before])


STEPS: dict[str, Callable[[Array, Stiffness], Array]] = {
    "average_acceleration": average,
    "bathe": bathe,
    "generalized_alpha": generalized,
    "hht_alpha": hht,
    "houbolt": houbolt,
}


def of_unit_states(step: Callable[[Array, Stiffness], Array], Omega: float, tau: float) -> Array:
    """The same factor, of the matrix of a step from unit states, turned back by tau; the two nearest to 1 left out."""
    back = np.array([[np.cos(tau), np.sin(tau)], [-np.sin(tau), np.cos(tau)]])
    columns = [step(x.reshape(3, 2), stiffness(Omega, tau)) @ back.T for x in np.eye(6)]
    found = np.linalg.eigvals(np.array([x.ravel() for x in columns]).T)
    return np.abs(sorted(found, key=lambda x: abs(x - 1))[2:]).max()


@pytest.mark.parametrize("name", STEPS)
@pytest.mark.parametrize(("Omega", "tau"), [(2.0, 0.3), (40.0, 0.05), (40.0, 0.2), (1e3, 0.1), (3e4, 0.4)])
def test_the_factor_is_that_of_steps_from_the_textbooks(name: str, Omega: float, tau: float) -> None:
    expected = of_unit_states(STEPS[name], Omega, tau)
    assert growth(ss.scheme(name), Omega, tau) == pytest.approx(expected, rel=1e-7, abs=1e-7)


def test_values_broadcast_and_a_rigid_bar_is_the_limit() -> None:
    s = ss.scheme("generalized_alpha", rho_inf=np.array([[0.5], [0.9]]))
    found = growth(s, [1e9, np.inf, 1e9], [0.1, 0.1, 0.2])
    assert found.shape == (2, 3)
    assert found[:, 0] == pytest.approx(found[:, 1], rel=1e-6)
    assert found[1, 2] == growth(ss.scheme("generalized_alpha", rho_inf=0.9), 1e9, 0.2)
    assert growth(ss.scheme("central_difference"), np.inf, 0.1) == np.inf
    for Omega, tau in ((0.0, 0.1), (np.nan, 0.1), (1e3, np.inf)):
        with pytest.raises(ValueError, match="expected Omega > 0, inf for a rigid bar, and a finite tau"):
            growth(ss.scheme("bathe"), Omega, tau)


@pytest.mark.parametrize("name", STATIC)
def test_an_eigenvalue_that_is_multiple_is_split_at_the_derived_rate(name: str) -> None:
    """|lambda| (1 + cot(pi/(2 m)) tau), of every scheme of the catalogue that takes the force once a step."""
    found, tau = turning(name), 1e-3
    if not found.at_infinity:
        assert (found.growth, found.product) == (None, None)
        assert growth(ss.scheme(name), np.inf, tau) == np.inf
    elif found.growth:
        c0, c1 = (float(c) for c in found.growth)
        assert growth(ss.scheme(name), np.inf, tau) == pytest.approx(c0 + c1 * tau, abs=1e-5)


@pytest.mark.parametrize(
    ("name", "given", "turn"),
    [
        ("hht_alpha", {"alpha": -0.1}, 0.195),
        ("generalized_alpha", {"rho_inf": 0.8}, 0.151),
        ("generalized_alpha", {"rho_inf": 0.95}, 0.035),
        *(
            (name, {}, None)
            for name in ("bathe", "newmark_bdf2", "houbolt", "park", "bdf2", "radau_iia2", "radau_iia3")
        ),
    ],
)
def test_turns_that_the_findings_name(name: str, given: dict[str, float], turn: float | None) -> None:
    beyond = growth(ss.scheme(name, **given), np.inf, np.linspace(0.001, FARTHEST, 750)) > 1.0
    assert (0.001 * (1 + beyond.argmax()) == pytest.approx(turn, abs=0.0015)) if turn else not beyond.any()


def test_what_is_known_in_closed_form() -> None:
    assert turning("newmark").at_infinity == ((1, 2),)
    assert turning("generalized_alpha", rho_inf="9/10").at_infinity == ((Rational(9, 10), 3),)
    assert turning("oalts").at_infinity == ((Rational(1, 2), 4),)
    assert turning("average_acceleration").product == turning("hht_alpha", alpha=0).product == 4
    assert turning("bathe").product is turning("gauss2").product is turning("houbolt").growth is None
    assert turning("fox_goodwin").at_infinity == ((2 * sqrt(6) + 5, 1),)
    for name in REFUSED:
        with pytest.raises(DeclarationError, match=f"{name}: expected forces at displacements"):
            turning(name)


@pytest.mark.parametrize(("name", "c"), [("average_acceleration", 4.0), ("gauss2", 12.0), ("lobatto_iiia3", 12.0)])
def test_a_pair_that_is_not_damped_grows_from_a_product_on(name: str, c: float) -> None:
    """By exp(sqrt(tau^2 - c^2/Omega^2)) a step, iff Omega tau > c; with several stages it is known by numbers alone."""
    Omega, s = 1e4, ss.scheme(name)
    below, above = growth(s, Omega, [0.98 * c / Omega, 1.1 * c / Omega])
    assert below < 1 + 1e-8
    assert above == pytest.approx(np.exp(c / Omega * np.sqrt(1.1**2 - 1)), abs=1e-6)


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("average_acceleration", {}),
        pytest.param("generalized_alpha", {"rho_inf": 0.8}, marks=pytest.mark.thorough),
        pytest.param("hht_alpha", {"alpha": -0.1}, marks=pytest.mark.thorough),
        pytest.param("wbz_alpha", {}, marks=pytest.mark.thorough),
        pytest.param("oalts", {}, marks=pytest.mark.thorough),
    ],
)
def test_the_stiff_pendulum_fails_where_it_is_predicted(name: str, given: dict[str, float]) -> None:
    """At 1.15 times the step that is derived, and not at 0.95: what dissipates turns slower, and grows later."""
    scene, s = ss.scene("elastic_pendulum", EA=1e10, a0="consistent"), ss.scheme(name, **given)
    h = first_growth(s, bar_of(scene), np.geomspace(1e-3, 1.0, 2000))
    below, above = (ss.march(scene, s, x * h, 3000 * x * h, energy_bound=10 * scene.E0) for x in (0.95, 1.15))
    assert below.status == "completed"
    assert below.energy.max() < 1.01 * scene.E0
    assert above.status != "completed"


@pytest.mark.thorough
@pytest.mark.parametrize(("h", "kept"), [(0.01, True), (0.02, False)])
def test_a_rod_is_an_infinitely_stiff_bar(h: float, kept: bool) -> None:
    """Generalized-alpha with rho_inf = 0.95 on a rod of 1 m that falls from the horizontal, at changing rates."""
    s = ss.scheme("generalized_alpha", rho_inf=0.95)
    r = ss.march(ss.scene("rod_pendulum", L=1.0, m=1.0, g=9.81, v0=0.0), s, h, 60.0)
    angle = np.linspace(0.0, np.pi, 401)[1:-1]  # below the horizontal; at each the time is as long as it turns slowly
    rate = np.sqrt(2 * 9.81 * np.sin(angle))
    assert (np.sum(np.log(growth(s, np.inf, rate * h)) / rate) < 0) == kept
    assert (np.ptp(r.energy) < 0.01 * 9.81) == kept


def test_the_eigenvalues_of_the_motion_are_followed_where_others_come_nearer_to_one() -> None:
    """An error's eigenvalue passes through 1 while one of the motion goes far away; sorting would exchange them."""
    turn = np.arange(1, FRACTIONS + 1) / FRACTIONS
    motion, errors = [1 + 0.8 * turn, 1 - 0.05j * turn], [0.5 + 0.45 * turn, -0.3 + 0 * turn]
    path = np.stack([*errors, *motion], axis=1).astype(complex)[None]
    assert _of_errors(path) == pytest.approx(0.95)
    assert np.abs(path[0, -1])[np.abs(path[0, -1] - 1).argsort()[2:]].max() > 1.7


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize(
    ("name", "turn", "steps", "off"), [("rho_inf_bathe", 0.7, 5, 0.05), ("rho_inf_bathe", 0.4, 4, 0.09)]
)
def test_errors_along_a_bar_change_by_the_predicted_factor(name: str, turn: float, steps: int, off: float) -> None:
    """Of two runs that differ by the acceleration along the bar at the start; at 0.7 sorted eigenvalues say 1.22."""
    EA, s = 1e9, ss.scheme(name)
    runs = []
    for a0 in (0.0, 1.0):
        scene = ss.scene("elastic_pendulum", EA=EA, a0=(a0, 0.0))
        h = turn / bar_of(scene).rate
        runs.append(ss.march(scene, s, h, (steps + 1) * h))
    apart = np.abs(np.asarray(runs[1].strain) - np.asarray(runs[0].strain))
    u, v = runs[0].u, runs[0].v
    turns = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / (u * u).sum(axis=1) * h
    predicted = growth(s, bar_of(scene).omega * h, turns[1:-1])
    assert (apart[-1] / apart[1]) ** (1 / steps) == pytest.approx(float(np.exp(np.log(predicted).mean())), rel=off)


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.filterwarnings("ignore:.*has gained energy:UserWarning")
@pytest.mark.parametrize(
    ("name", "turn", "rel"),
    [
        ("generalized_alpha_mixed_displacement", 0.02, 0.02),
        ("wilson_theta", 0.03, 0.02),
        pytest.param("discontinuous_galerkin_p1", 0.1, 0.02, marks=pytest.mark.thorough),
        pytest.param("gssss_u0", 0.02, 0.02, marks=pytest.mark.thorough),
    ],
)
def test_the_energy_of_the_first_steps_is_that_of_a_run(name: str, turn: float, rel: float) -> None:
    """Of schemes that take the force where the bar is shorter than its length, and so stretch it at once."""
    scene, s = ss.scene("elastic_pendulum", EA=1e9, a0="consistent"), ss.scheme(name)
    bar = bar_of(scene)
    h = turn / bar.rate
    run = ss.march(scene, s, h, 4 * h)
    found = early_energy(s, np.array([bar.omega * h]), np.array([turn]), np.array([4]))[0]
    assert found > 1.01
    assert found == pytest.approx(run.energy[1:].max() / scene.E0, rel=rel)


@pytest.mark.usefixtures("plain_in_gate")
def test_a_start_by_an_explicit_scheme_is_predicted_to_fail() -> None:
    """By Dormand and Prince's steps, from Omega of some units on, where the errors of bdf4 fade."""
    own = BY_NAME["bdf4"]
    by_explicit = backward_differences(4, BY_NAME["dormand_prince"], own.published)
    found = cells(ss.scheme(replace(by_explicit, name="bdf4_explicit_start")), 1e10, np.array([1e-3]))[0]
    assert found.predicted and found.agrees
    bar = bar_of(ss.scene("elastic_pendulum", EA=1e10))
    assert growth(ss.scheme("bdf4"), bar.omega * 1e-3, bar.rate * 1e-3) < 1.0
    found = cells(ss.scheme("bdf4"), 1e10, np.array([1e-3]))[0]
    assert not found.predicted and found.agrees
