"""Contacts of structures: against the same model as a scene, steps by enumeration in NumPy, and a bar that falls."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from substep_derive import Contact, Scene, rate
from sympy import Symbol
from test_constraints import TAKEN, VERIFY
from test_contact import SOME, remembered

import substep as ss
from substep.core.kernel_modules import committed
from substep.structures.march.refusals import require_suited
from substep.structures.solvers.complementarity import complementary

Array = np.ndarray
BOUNCING = ("average_acceleration", "generalized_alpha", "central_difference")  # with restitution
x, y = Symbol("x"), Symbol("y")
G, K, B = 10.0, 1000.0, 0.5
PAIR = np.array([[1.0, -1.0], [-1.0, 1.0]])


def falling(**more: Any) -> ss.Structure:
    """The scene two_masses_on_floor as a structure; its load was there before t = 0, where some schemes take it."""
    load = () if "fixed" in more else ([-G - K * B, -G + K * B], np.ones_like)
    more = {"u0": [0.5, 0.5 + B], "v0": -1.0, "contacts": {"floor": ({0: 1.0}, 0.0)}} | more
    return ss.structure(np.eye(2), more.pop("K", K * PAIR), load=load, **more)


def same(
    scene: Any, structure: Any, name: str, names: tuple[str, ...], dt: float, t_end: float, within: float = 1e-10
) -> None:
    """Both marches: u, v, a, gaps and reactions, to rounding, which impacts multiply."""
    r = ss.march(scene, name, dt=dt, t_end=t_end)
    s = ss.march(structure, name, dt=dt, t_end=t_end, account=False)
    assert r.status == s.status == "completed"
    pairs = [(r.u, s.u), (r.v, s.v), (r.a, s.a)]
    pairs += [(of[one], by[one]) for of, by in ((r.memory, s.memory), (r.gaps, s.gaps)) for one in names]
    for mine, other in pairs:
        assert np.allclose(mine, other, rtol=0.0, atol=within * max(1.0, float(np.abs(mine).max())))
    met = [s.gaps[one].min() < 0.02 or (s.memory[one] > 0.0).any() for one in names]  # perhaps within a step
    assert sum(met) >= min(2, len(names))


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", TAKEN if VERIFY else SOME)
def test_a_structure_is_the_scene(name: str) -> None:
    same(ss.scene("two_masses_on_floor", g=G), falling(), name, ("floor",), 0.01, 0.26)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", TAKEN if VERIFY else SOME)
def test_a_structure_is_the_scene_where_reactions_are_remembered(name: str) -> None:
    """In flight, and from rest on the floor, where the reaction at the start bears the weight."""
    scene = remembered("two_masses_on_floor")
    same(ss.scene(scene, g=G), falling(remembered=True), name, ("floor",), 0.01, 0.26)
    at_rest = falling(remembered=True, u0=[0.0, B], v0=0.0)
    same(ss.scene(scene, g=G, u0=0, v0=0), at_rest, name, ("floor",), 0.01, 0.1)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", BOUNCING if VERIFY else BOUNCING[1:])
def test_a_structure_is_the_scene_with_restitution_too(name: str) -> None:
    """Two stops, and one body against the other, whose gap is held where the scheme takes that."""
    shares = {"floor": 0.6, "roof": 0.3}
    gaps = {"floor": x, "roof": 2 - y, "bodies": y - x - B / 2}
    contacts = {key: Contact(gap, shares.get(key)) for key, gap in gaps.items()}
    scene = Scene(
        "between", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + 3 * rate(y) ** 2) / 2,
        potential=20 * (y - x - B) ** 2, contacts=contacts, parameters=(),
        start={x: 0.5, y: 1.2, rate(x): -3, rate(y): 4}, length=1,
    )  # fmt: skip
    rows = {"floor": ({0: 1.0}, 0.0), "roof": ({1: -1.0}, 2.0), "bodies": ({0: -1.0, 1: 1.0}, -B / 2)}
    structure = ss.structure(
        np.diag([1.0, 3.0]), 40 * PAIR, load=([-40 * B, 40 * B], np.ones_like), u0=[0.5, 1.2], v0=[-3.0, 4.0],
        contacts=rows, restitution=shares,
    )  # fmt: skip
    same(ss.scene(scene), structure, name, tuple(rows), 0.01, 1.5)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["generalized_alpha", "average_acceleration"] if VERIFY else ["generalized_alpha"])
def test_an_internal_force_with_contacts_is_the_scene(name: str) -> None:
    scene = Scene(
        "hardening", coordinates={x: "m", y: "m"}, kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2,
        potential=G * x + 50 * (y - x) ** 4 + y**2, contacts={"floor": x, "bodies": y - x + 0.1}, parameters=(),
        start={x: 0.1, y: 0.1, rate(x): -1, rate(y): -3}, length=1,
    )  # fmt: skip
    given: dict[str, Any] = {
        "internal_force": lambda u: np.array([G, 2 * u[1]]) + 200 * (u[1] - u[0]) ** 3 * np.array([-1.0, 1.0]),
        "tangent": lambda u: np.diag([0.0, 2.0]) + 600 * (u[1] - u[0]) ** 2 * PAIR,
        "contacts": {"floor": ([1.0, 0.0], 0.0), "bodies": ([-1.0, 1.0], 0.1)},
    }
    structure = ss.structure(np.eye(2), u0=0.1, v0=[-1.0, -3.0], **given)
    # iterations end at 1e-12 of u, which is 4e-8 of a
    same(ss.scene(scene), structure, name, ("floor", "bodies"), 0.01, 0.3, within=1e-8)


def test_springs_beside_a_contact_are_the_stiffness_before_they_yield() -> None:
    law = ss.law("bilinear", k=0.75 * K, q_y=1e9)
    sprung = falling(K=0.25 * K * PAIR, springs=[({0: -1.0, 1: 1.0}, law)])
    linear, bent = (ss.march(s, "average_acceleration", dt=0.01, t_end=0.5) for s in (falling(), sprung))
    assert np.allclose(linear.u, bent.u, rtol=0.0, atol=1e-10)
    assert np.allclose(linear.memory["floor"], bent.memory["floor"], rtol=0.0, atol=1e-7)


def cantilever(n: int, length: float) -> tuple[Array, Array]:
    """M and K of a beam of n Hermitian elements of EI = rho A = 1, clamped at its left end."""
    a, size = length / n, 2 * n + 2
    m = a / 420 * np.array([
        [156, 22 * a, 54, -13 * a], [22 * a, 4 * a * a, 13 * a, -3 * a * a],
        [54, 13 * a, 156, -22 * a], [-13 * a, -3 * a * a, -22 * a, 4 * a * a],
    ])  # fmt: skip
    k = np.array([
        [12, 6 * a, -12, 6 * a], [6 * a, 4 * a * a, -6 * a, 2 * a * a],
        [-12, -6 * a, 12, -6 * a], [6 * a, 2 * a * a, -6 * a, 4 * a * a],
    ]) / a**3  # fmt: skip
    M, S = np.zeros((size, size)), np.zeros((size, size))
    for at in range(0, 2 * n, 2):
        M[at : at + 4, at : at + 4] += m
        S[at : at + 4, at : at + 4] += k
    return M[2:, 2:], S[2:, 2:]


def by_enumeration(q: Array, W: Array) -> Array:
    """The reactions of a linear complementarity problem, by trying which gaps are closed."""
    for count in range(len(q) + 1):
        for chosen in map(list, combinations(range(len(q)), count)):
            p = np.zeros(len(q))
            p[chosen] = np.linalg.solve(W[np.ix_(chosen, chosen)], -q[chosen]) if count else 0.0
            if (p >= 0.0).all() and (q + W @ p >= -1e-12 * (1.0 + np.abs(q).max())).all():
                return p
    raise AssertionError(q)


def test_two_cantilevers_that_touch() -> None:
    """One beam above another, with a gap at each of three nodes, one of them loaded; the trapezoidal rule by hand."""
    (M1, K1), (M2, K2) = cantilever(3, 1.0), cantilever(3, 1.2)
    n = len(M1)
    zero = np.zeros((n, n))
    M, S = np.block([[M1, zero], [zero, M2]]), np.block([[K1, zero], [zero, K2]])
    rows = np.zeros((3, 2 * n))
    for k, node in enumerate((0, 2, 4)):
        rows[k, node], rows[k, n + node] = 1.0, -1.0  # the first is the upper one
    gaps, P, h, steps = np.array([0.01, 0.02, 0.02]), np.zeros(2 * n), 0.004, 500
    P[4] = -1.0
    s = ss.structure(M, S, load=(P, np.ones_like), contacts={"bodies": (rows, gaps)})
    r = ss.march(s, "average_acceleration", dt=h, t_end=steps * h)
    A, push, touching = np.linalg.inv(M + h**2 / 4 * S), np.linalg.solve(M, rows.T), 0
    for k in range(steps):  # each from where the march is, since impacts multiply rounding
        u, v, a = r.u[k], r.v[k], r.a[k]
        z = A @ (P - S @ (u + h * v + h**2 / 4 * a))
        p = by_enumeration((gaps + rows @ (u + h * v + h**2 / 4 * (a + z))) / (h**2 / 4), rows @ A @ rows.T)
        z = z + A @ rows.T @ p
        new = u + h * v + h**2 / 4 * (a + z), v + h / 2 * (a + z), z - push @ p, p / 2
        for mine, other in zip((r.u, r.v, r.a, r.memory["bodies"]), new, strict=True):
            assert np.allclose(mine[k + 1], other, rtol=1e-10, atol=1e-10 * max(1.0, np.abs(other).max()))
        touching = max(touching, int((p > 0.0).sum()))
    assert touching >= 2
    assert r.gaps["bodies"].min() > -1e-12


@settings(max_examples=200 if VERIFY else 40, deadline=None)
@given(st.integers(1, 6), st.integers(0, 10**6))
def test_reactions_are_those_by_enumeration(d: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(d, d + 1))
    W, q = x @ x.T + 1e-3 * np.eye(d), rng.normal(size=d)
    found = complementary(q, W, rng.normal(size=d))
    assert np.allclose(found, by_enumeration(q, W), rtol=1e-9, atol=1e-9)


def bar(n: int, gap: float, **more: Any) -> ss.Structure:
    """A bar of E = 900, rho = 1 and the length 10 that falls with the velocity 10: Doyen, Ern & Piperno (2011)."""
    k = 90.0 * n
    stiffness = np.r_[k, np.full(n - 1, 2 * k), k], np.full(n, -k), np.full(n, -k)
    M = sparse.diags_array(np.r_[0.5, np.ones(n - 1), 0.5] * 10.0 / n).tocsr()
    floor = {"floor": ({0: 1.0}, gap)}
    K = sparse.diags_array(stiffness, offsets=(0, 1, -1)).tocsr()
    return ss.structure(M, K, contacts=floor, **{"v0": -10.0, **more})


@pytest.mark.parametrize("n", [100, 200] if VERIFY else [100])
def test_a_bar_meets_a_floor(n: int) -> None:
    """The impact is at 0.5 s, in contact until 7/6 s with the pressure 300; the bar leaves as it came.

    It never gains energy, whatever the phase of the impact in the step.
    """
    h, phases = 1 / (3 * n), 32 if VERIFY else 3
    for phase in (np.arange(phases) + 0.4) / phases:
        gap, t_end = 5.0 + 10 * h * phase, np.ceil(1.25 / h) * h
        r = ss.march(bar(n, gap), "average_acceleration", dt=h, t_end=t_end, dofs=[0, n])
        since, p = r.t - gap / 10, r.memory["floor"]
        assert r.energy.max() <= 500.0 * (1.0 + 1e-9)
        assert r.energy[-1] > 500.0 * (1 - 1 / n)
        assert p[(since > 0.05) & (since < 0.6)].mean() == pytest.approx(300.0, rel=0.02)
        assert p.sum() * h == pytest.approx(200.0, rel=0.01)  # its impulse turns the bar around
        pressed = since[p > 0.0]
        assert pressed[0] < 1.5 * h
        assert pressed[-1] == pytest.approx(2 / 3, abs=0.02)
        assert r.account is not None
        assert r.account.numerical[-1] == pytest.approx(500.0 - r.energy[-1], abs=1e-6)
        assert np.allclose(r.gaps["floor"], gap + r.u[:, 0], rtol=0.0, atol=1e-12)


def test_schemes_take_contacts_as_they_do_on_scenes() -> None:
    """Those that scenes take; with restitution those that keep the velocity that an impact leaves."""
    known = [name for name in ss.schemes() if not ss.scheme(name).info.together]
    known = [name for name in known if VERIFY or committed(f"plans.{ss.scheme(name).kernels.NAME}")]

    def takes(name: str, **more: Any) -> bool:
        try:
            require_suited(falling(**more), ss.scheme(name), 0.01)
        except ValueError as error:
            assert "expected" in str(error)
            return False
        return True

    assert {name for name in known if takes(name)} == {*TAKEN, "central_difference"} & set(known)
    with_restitution = {name for name in known if takes(name, restitution=0.5)}
    assert {"newmark", "generalized_alpha", "energy_momentum", "central_difference"} & set(known) <= with_restitution
    assert not {"bathe", "houbolt", "bdf2", "rk4", "noh_bathe", "wilson_theta"} & with_restitution
    with pytest.raises(ValueError, match="rk4 is explicit and does not move on with the velocity"):
        ss.march(falling(), "rk4", dt=0.01, t_end=0.1)
    with pytest.raises(ValueError, match="newmark does not move the displacement at which it takes the force"):
        ss.march(falling(), ss.scheme("newmark", beta=0.0), dt=0.01, t_end=0.1)


@pytest.mark.parametrize("name", ["generalized_alpha", "average_acceleration"])
def test_a_run_goes_on_exactly(name: str) -> None:
    on_floor = {"u0": [0.0, B], "v0": 0.0, "remembered": True}
    for kept, until in (({}, 0.4), (on_floor, 0.1)):
        s = falling(**kept)
        whole, first = (ss.march(s, name, dt=0.01, t_end=t, account=False) for t in (0.8, until))
        on = ss.march(s, name, dt=0.01, t_end=0.8, start=first, account=False)
        assert np.array_equal(on.u, whole.u[len(first.t) - 1 :])
        assert np.array_equal(on.memory["floor"][1:], whole.memory["floor"][len(first.t) :])
        assert not kept or first.memory["floor"][-1] > 0.0


def test_rows_that_are_kept_and_those_between() -> None:
    s = falling()
    whole = ss.march(s, "average_acceleration", dt=0.01, t_end=1.0)
    some = ss.march(s, "average_acceleration", dt=0.01, t_end=1.0, stride=4, dofs=[1])
    assert np.array_equal(some.gaps["floor"], whole.gaps["floor"][::4])
    between = ss.march(s, "average_acceleration", dt=0.01, t_end=1.0, at=[0.005, 0.25])
    assert between.gaps["floor"][0] == pytest.approx(0.5 * (whole.gaps["floor"][0] + whole.gaps["floor"][1]))
    assert "floor_reaction" in whole.to_xarray()


def test_stops_on_both_sides() -> None:
    s = ss.structure([[1.0]], [[1.0]], v0=2.0, contacts={"left": ([1.0], 1.0), "right": ([-1.0], 1.0)}, restitution=1.0)
    r = ss.march(s, "average_acceleration", dt=0.01, t_end=8.0)
    assert np.abs(r.u).max() < 1.03
    assert r.energy == pytest.approx(2.0, rel=0.02)
    assert min(r.memory[name].max() for name in ("left", "right")) > 0.0


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"contacts": {"floor": ({0: 1.0}, -0.6)}}, "gaps of 0 or more, got -0.1 of contact 'floor'"),
        ({"contacts": {"a": ({0: 1.0}, 1.0), "b": ({0: 2.0}, 2.0)}}, "independent gaps, got one of contact 'b'"),
        ({"contacts": {"floor": ({1: 1.0}, 1.0)}, "fixed": [1], "u0": 0.0}, "got one of the fixed degree of freedom 1"),
        ({"contacts": {"floor": ([0.0, 0.0], 1.0)}}, "a row of contact 'floor' that is 0"),
        ({"contacts": {"floor": ({0: 1.0}, 1.0, 0.5)}}, "a name with a pair"),
        ({"contacts": [({0: 1.0}, 1.0)]}, "a mapping of names to pairs"),
        ({"contacts": {"floor": (np.eye(2), [1.0, 2.0, 3.0])}}, "one gap of contact 'floor' or 2"),
        ({"restitution": 2.0}, "restitution from 0 to 1 of contact 'floor', got 2"),
        ({"restitution": {"flor": 0.5}}, "did you mean|floor"),
        ({"contacts": None, "restitution": 0.5}, "restitution with contacts only"),
        ({"remembered": True, "restitution": 0.5}, "remembered=True without restitution"),
    ],
)
def test_what_is_no_contact_is_refused(given: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        falling(**given)


def test_what_does_not_know_contacts_refuses_them() -> None:
    s = falling()
    with pytest.raises(ValueError, match="without contacts for a critical step"):
        s.critical_step("central_difference")
    with pytest.raises(ValueError, match="gaps of 0 or more"):
        ss.march(s, "average_acceleration", dt=0.01, t_end=0.1, start={"u": [-0.1, 0.4], "v": [0.0, 0.0]})


@pytest.mark.parametrize("keep", ["final", "peak", "history"])
def test_points_of_a_sweep_are_marches(keep: Any) -> None:
    """Over the step and the restitution; with a friction, beside springs that yield; and a rod."""

    def towed(share: float) -> ss.Structure:
        return ss.structure(
            np.eye(2), K * PAIR, v0=[-1.0, -1.0], load=([-G, -G], np.ones_like), contacts={"floor": (np.eye(2), 0.2)},
            restitution=share, springs=[([1.0, 0.0], ss.law("bilinear", k=10.0, q_y=0.01, alpha=0.1))],
        )  # fmt: skip

    bodies = [towed(0.2), towed(0.6)]
    steps, given = [0.005] if keep == "history" else [0.01, 0.005], {"t_end": 0.3, "keep": keep, "progress": False}
    d = ss.sweep(bodies, "average_acceleration", dt=steps if len(steps) > 1 else steps[0], **given)
    assert d.contact.values.tolist() == ["floor[0]", "floor[1]"]
    for body, dt in ((j, h) for j in range(2) for h in steps):
        r, x = (
            ss.march(bodies[body], "average_acceleration", dt=dt, t_end=0.3),
            (d.sel(dt=dt) if len(steps) > 1 else d).isel(structure=body),
        )
        assert (r.memory["floor"] > 0.0).any()
        for name, rows in (("u", r.u), ("reaction", r.memory["floor"]), ("gap", r.gaps["floor"])):
            wanted = {"final": rows[-1], "peak": np.abs(rows).max(axis=0), "history": rows}[keep]
            assert np.array_equal(x["peak_" * (keep == "peak") + name], wanted)


def test_the_sweep_of_a_rod_and_of_a_friction() -> None:
    def rod(u: Array) -> tuple[float, Array]:
        return (u @ u - 1.0) / 2.0, u.copy()

    def held(load: Any) -> ss.Structure:
        return ss.structure(
            np.eye(2), np.zeros((2, 2)), u0=[0.0, -1.0], v0=[2.0, 0.0], load=load, constraints={"rod": rod}
        )

    def rubbed(load: Any) -> ss.Structure:
        return ss.structure(np.eye(2), np.eye(2), v0=[1.0, 0.0], load=load, friction={"pad": ([1.0, 0.0], 0.1)})

    loads = [([0.0, -k], np.ones_like) for k in (0.5, 1.0)]
    for made, name, dim in ((held, "rod", "constraint"), (rubbed, "pad", "contact")):
        given: dict[str, Any] = {"dt": 0.01, "t_end": 0.3}
        d = ss.sweep(made(()), "generalized_alpha", keep="history", load=loads, progress=False, **given)
        assert d[dim].values.tolist() == [name]
        for case, load in enumerate(loads):
            r = ss.march(made(load), "generalized_alpha", **given)
            assert np.array_equal(d.u[case], r.u)
            assert np.array_equal(d.reaction[case, :, 0], r.memory[name])
