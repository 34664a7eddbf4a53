"""Structures with an internal force of the user's: against scenes, whose kernels are derived from energies."""

from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from scipy.integrate import solve_ivp
from scipy.sparse.linalg import LinearOperator
from substep_derive.declare.symbols import K0, K_t

import substep as ss
from substep.structures.examples import rotating_bar

SCHEMES = list(BY_NAME)
START = 1e-3  # s, a small first step


def pendulum(**more: Any) -> tuple[ss.Scene, ss.Structure]:
    """The elastic pendulum as a scene and as a structure, its force from the scene's own acceleration."""
    scene = ss.scene("elastic_pendulum", a0="consistent", **more)
    m = scene.parameters["m"]

    def force(u: Any) -> Any:
        return -m * scene.acceleration(np.zeros(()), u, np.zeros(2))

    def tangent(u: Any) -> Any:
        steps = 1e-6 * np.eye(2)
        return np.array([(force(u + e) - force(u - e)) / 2e-6 for e in steps]).T

    def potential(u: Any) -> float:
        return float(scene.energy(np.zeros(()), u, np.zeros(2)))

    frame = ss.structure(
        m * np.eye(2), internal_force=force, tangent=tangent, potential=potential, u0=scene.u0, v0=scene.v0
    )
    return scene, frame


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_marches_the_pendulum_as_its_kernel_does(name: str) -> None:
    scene, frame = pendulum(EA=1e4)
    h, n = 1e-3, 40
    expected, found = ss.march(scene, name, h, n * h), ss.march(frame, name, h, n * h, account=False)
    assert found.status == expected.status == "completed"
    if name == "energy_momentum":  # which forms the discrete gradient in the scene's invariants: it keeps the energy
        energy = ss.march(frame, name, h, n * h).energy
        assert np.ptp(energy) <= 2e-11 * energy.max()
        assert np.abs(found.u - expected.u).max() <= 1e-4 * np.abs(expected.u).max()
        return
    for x, y in ((found.u, expected.u), (h * found.v, h * expected.v)):
        assert np.abs(x - y).max() <= 1e-9 * np.abs(expected.u).max()


@pytest.mark.filterwarnings("ignore:.* has (dissipated|gained)")  # what a scheme gains is its own
@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_marches_duffing_as_its_kernel_does(name: str) -> None:
    """With the tangent of every iteration to 1e-10; with one that is kept to what its last corrections leave, 1e-8."""
    scene = ss.scene("duffing", a0="consistent")
    k, eps = scene.parameters["k"], scene.parameters["eps"]
    frame = ss.structure(
        [[1.0]], internal_force=lambda u: k * u * (1 + eps * u * u), tangent=lambda u: [k * (1 + 3 * eps * u * u)],
        potential=lambda u: k * u[0] ** 2 / 2 + k * eps * u[0] ** 4 / 4, u0=scene.u0, v0=scene.v0,
    )  # fmt: skip
    h, n = 0.01, 40
    expected = ss.march(scene, name, h, n * h)
    for newton, digits in (("full", 1e-10), ("simplified", 1e-8)):
        found = ss.march(frame, name, h, n * h, account=False, newton=newton)
        rows = (
            int((np.abs(expected.u[:, 0]) < 10.0).argmin()) or n + 1
        )  # a run that grows beyond reason is not compared
        for x, y in ((found.u[:rows], expected.u[:rows]), (h * found.v[:rows], h * expected.v[:rows])):
            assert np.abs(x - y).max() <= digits * np.abs(expected.u).max()


@pytest.mark.parametrize(
    "name", ["average_acceleration", "hht_alpha", "generalized_alpha", "bathe", "newmark_bdf2", "rk4"]
)
def test_forces_of_velocity_and_time_keep_the_order(name: str) -> None:
    """Quadratic damping and a stiffness that changes with time, against SciPy at tight tolerance."""

    def force(t: Any, u: Any, v: Any) -> Any:
        return (4.0 + np.sin(t)) * u + 0.5 * v * np.abs(v)

    def tangent(t: Any, u: Any, v: Any) -> Any:
        return np.diag((4.0 + np.sin(t)) * np.ones(2)), np.diag(np.abs(v))

    start = np.array([1.0, -0.5, 0.3, 0.2])
    exact = solve_ivp(lambda t, y: [*y[2:], *-force(t, y[:2], y[2:])], (0, 2), start, rtol=1e-12, atol=1e-13).y[:2, -1]
    frame = ss.structure(np.eye(2), internal_force=force, tangent=tangent, u0=start[:2], v0=start[2:])
    errors = [np.abs(ss.march(frame, name, h, 2.0, account=False).u[-1] - exact).max() for h in (0.02, 0.01)]
    order = {"rk4": 4}.get(name, 2)
    assert np.log2(errors[0] / errors[1]) >= order - 0.15


def test_a_tangent_known_by_its_products_only() -> None:
    scene, frame = pendulum(EA=1e4)
    assert frame.internal is not None
    given = frame.internal

    def products(u: Any) -> Any:
        assert given.tangent is not None
        K = given.tangent(u)
        return LinearOperator((2, 2), matvec=lambda x: K @ x, rmatvec=lambda x: K.T @ x, dtype=float)

    m = scene.parameters["m"]
    free = ss.structure(m * np.eye(2), internal_force=given.force, tangent=products, u0=scene.u0, v0=scene.v0)
    found, expected = (ss.march(s, "bathe", 1e-3, 0.02, account=False) for s in (free, frame))
    assert np.abs(found.u - expected.u).max() <= 1e-11 * np.abs(expected.u).max()


def test_modified_newton_spares_factorizations_and_line_search_saves_a_run() -> None:
    def spring(u: Any) -> Any:
        return 1e4 * np.arctan(5.0 * u)

    made: list[Any] = []

    def solver(matrix: Any) -> Any:
        made.append(matrix)
        return lambda b: np.linalg.solve(matrix, b)

    def march(**more: Any) -> Any:
        made.clear()
        soft = ss.structure(
            np.diag([1.0, 2.0]), internal_force=spring, tangent=lambda u: [[5e4 / (1 + 25 * u[0] ** 2), 1e-9],
            [1e-9, 5e4 / (1 + 25 * u[1] ** 2)]], v0=[30.0, 10.0], solver=solver,
        )  # fmt: skip
        return ss.march(soft, "average_acceleration", 0.004, 0.4, account=False, **more), len(made)

    (kept, few), (full, many), (searched, _) = march(), march(newton="full"), march(newton="full", line_search=True)
    assert few < many
    assert np.abs(kept.u - full.u).max() <= 1e-9 * np.abs(full.u).max()
    assert np.abs(searched.u - full.u).max() <= 1e-9 * np.abs(full.u).max()


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("scheme", ["average_acceleration", "newmark_bdf2", "generalized_alpha", "rk4"])
def test_a_rotating_bar_of_one_element_is_the_elastic_pendulum(scheme: str) -> None:
    model, scene = rotating_bar(1, mass=0.0), ss.scene("elastic_pendulum", EA=1e4)
    found, expected = ss.march(model, scheme, 0.01, 1.0, account=False), ss.march(scene, scheme, 0.01, 1.0)
    tip = found.u[:, 2:] + [3.0443, 0.0]
    assert np.abs(tip - expected.u).max() <= 1e-9 * np.abs(expected.u).max()


def test_a_rotating_bar_tends_to_the_elastic_pendulum_with_its_mass() -> None:
    """In proportion to it, in four elements; the energy-momentum scheme keeps its energy."""
    expected = ss.march(ss.scene("elastic_pendulum", EA=1e4), "average_acceleration", 0.005, 1.0).u[-1]
    off = []
    for mass in (0.4, 0.2, 0.1):
        r = ss.march(rotating_bar(4, mass=mass), "average_acceleration", 0.005, 1.0, account=False)
        off.append(float(np.abs(r.u[-1, -2:] + [3.0443, 0.0] - expected).max()))
    assert off[0] < 0.05
    assert off[0] / off[1] == pytest.approx(2.0, rel=0.1)
    assert off[1] / off[2] == pytest.approx(2.0, rel=0.1)
    r = ss.march(rotating_bar(4, mass=0.4), "energy_momentum", 0.02, 2.0)
    assert np.ptp(r.energy) <= 1e-10 * r.energy.max()


def test_a_massless_bar_of_several_elements_is_refused() -> None:
    with pytest.raises(ValueError, match="mass > 0"):
        rotating_bar(2, mass=0.0)


def spring(**more: Any) -> dict[str, Any]:
    """Arguments of a hardening spring without a tangent."""
    return {"M": [[1.0]], "internal_force": lambda u: u + u**3, "u0": 0.5, "load": ([1.0], ss.Step(1.0)), **more}


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scheme", BY_NAME.values(), ids=lambda s: s.name)
def test_a_tangent_is_asked_for_by_schemes_that_take_it(scheme: Any) -> None:
    """Those whose kernel of a scene iterates, or whose declaration says so; the others give the same to the bit."""
    iterates = ss.march(ss.scene("duffing"), scheme.name, 0.01, 0.05).newton_iterations.any()
    potential = {"potential": lambda u: float(u[0] ** 2 / 2 + u[0] ** 4 / 4)}
    texts = [
        *scheme.relations.values(),
        *(b.inertia for b in scheme.balances),
        *(scheme.start.values() if isinstance(scheme.start, dict) else ()),
    ]
    bare, given = (ss.structure(**spring(**potential, **t)) for t in ({}, {"tangent": lambda u: [1.0 + 3.0 * u**2]}))
    expected = ss.march(given, scheme.name, 0.1, 0.8, account=False)
    if iterates or any(e.has(K0) or e.has(K_t) for e in texts):
        with pytest.raises(ValueError, match=r"takes the tangent of the internal force: expected tangent= .*explicit"):
            ss.march(bare, scheme.name, 0.1, 0.8)
        return
    found = ss.march(bare, scheme.name, 0.1, 0.8, account=False)
    for name in ("u", "v", "a"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name


def test_what_a_structure_without_a_tangent_takes() -> None:
    """Damping and loads, steps that are chosen, disk; what needs the tangent is refused."""
    explicit = ss.structure(**spring(C=ss.Rayleigh(0.1, 0.0)))
    assert ss.march(explicit, "central_difference", 0.1, 0.8, account=False).status == "completed"
    assert ss.march(explicit, "rk4", tol=1e-4, t_end=0.8, account=False).status == "completed"
    drag = ss.structure(**spring(internal_force=lambda u, v: u + v * np.abs(v)))
    assert ss.march(drag, "rk4", 0.1, 0.8, account=False).status == "completed"
    for ask in (
        lambda: explicit.modes(1),
        lambda: ss.structure(**spring(C=ss.modal_damping(0.1, 1))),
        lambda: ss.structure(**spring(C=ss.Rayleigh(0.1, 0.01))),
        lambda: ss.march(drag, "central_difference", 0.1, 0.8),
        lambda: ss.sweep(explicit, "bathe", dt=0.1, t_end=0.8),
    ):
        with pytest.raises(ValueError, match=r"expected (the tangent|tangent=)"):
            ask()


def test_a_discrete_gradient_asks_for_a_potential() -> None:
    bent = ss.structure(**spring(tangent=lambda u: [1.0 + 3.0 * u**2]))
    message = "energy_momentum takes a discrete gradient: expected potential= for this structure, got none"
    for ask in (
        lambda: ss.march(bent, "energy_momentum", 0.1, 0.8),
        lambda: ss.march(bent, "energy_momentum", tol=1e-3, t_end=0.8),
        lambda: ss.sweep(bent, "energy_momentum", dt=0.1, t_end=0.8),
    ):
        with pytest.raises(ValueError, match=message):
            ask()


@pytest.mark.parametrize("newton", ["simplified", "full"])
def test_an_iteration_that_leaves_where_the_force_is_defined_fails_or_is_halved(newton: Any) -> None:
    """A stop at u = 1 whose force grows without bound before it: beyond it neither force nor tangent is a number."""

    def force(u: Any) -> Any:
        return 1e-3 * u / np.where(u < 1.0, 1.0 - u, np.nan) ** 2

    def tangent(u: Any) -> Any:
        return [1e-3 * (1.0 + u) / np.where(u < 1.0, 1.0 - u, np.nan) ** 3]

    stop = ss.structure([[1.0]], internal_force=force, tangent=tangent, v0=4.0)
    plain, halved = (
        ss.march(stop, "average_acceleration", 0.2, 4.0, account=False, newton=newton, line_search=searched)
        for searched in (False, True)
    )
    assert (plain.status, plain.t_failed, len(plain.u)) == ("newton_failed", 0.4, 2)
    assert halved.status == "completed"
    assert 0.9 < halved.u.max() < 1.0


def test_a_tangent_that_is_singular_fails_an_iteration_and_names_what_is_loose_at_a_good_state() -> None:
    """A second degree of freedom without mass, whose stiffness goes where the first has moved far."""

    def march(reach: float) -> Any:
        pair = ss.structure(
            np.diag([1.0, 0.0]), internal_force=lambda u: np.array([u[0] - u[1], max(reach - u[0], 0.0) * u[1]]),
            tangent=lambda u: np.array([[1.0, -1.0], [-u[1] if u[0] < reach else 0.0, max(reach - u[0], 0.0)]]),
            v0=[1.0, 0.0], a0=0.0,
        )  # fmt: skip
        return ss.march(pair, "average_acceleration", 0.5, 10.0, account=False, newton="full")

    with pytest.raises(ValueError, match="a Newton iteration, got one that leaves degree of freedom 1 undetermined"):
        march(0.0)
    lost = march(0.3)
    assert (lost.status, lost.t_failed, len(lost.u)) == ("newton_failed", 0.5, 1)
