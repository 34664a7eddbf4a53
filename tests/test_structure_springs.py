"""Structures with springs of declared laws."""

import json
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import sparse

import substep as ss
from substep.structures.march import branches

Array = np.ndarray
DT, STEPS = 0.01, 300
RECORD = ss.Record(0.05, 3.0 * np.random.default_rng(0).normal(size=60))  # m/s^2
M, K, Q_Y, ALPHA = (np.array(x) for x in ([2.0, 1.5, 1.0], [300.0, 250.0, 200.0], [4.0, 3.0, 2.0], 0.03))
B = np.eye(3) - np.eye(3, k=-1)

# Each scheme and law on one story beside the scene of one degree of freedom, whose kernels are printed and so another
# program; in a process without numba, which would take a second or two for each of these kernels.
BESIDE_SCENE = """
import json, sys
import numpy as np
import substep as ss

record, omega, xi, found = ss.Record(0.05, 3 * np.random.default_rng(0).normal(size=40)), 5.0, 0.05, {}
for law, parameters, scheme in json.loads(sys.argv[1]):
    spring = "q_y" in parameters
    words = {{"q_y": "strength", "alpha": "hardening"}.get(name, name): x for name, x in parameters.items()}
    start = {"u0": 0.1, "v0": 0.5}
    scene = ss.scene("hysteretic_oscillator", law=law, omega=omega, xi=xi, load=record, **words, **start)
    handle = ss.law(law, **parameters, **({"k": omega**2} if spring else {}))
    story = ss.structure(
        [[1.0]], None if spring else [[omega**2]], springs=[([1.0], handle)], C=[[2 * xi * omega]],
        load=([1.0], record), **start,
    )
    one, other = (ss.march(model, scheme, dt=0.04, t_end=2.0) for model in (scene, story))
    pairs = [(one.u, other.u), (one.v, other.v), (one.a, other.a)]
    pairs += [(one.force, other.springs.forces[:, 0])]
    pairs += [(x, other.memory[name][:, 0]) for name, x in one.memory.items()]
    found[f"{law} {scheme}"] = max(float(np.abs(x - y).max()) / float(np.abs(x).max()) for x, y in pairs)
print(json.dumps(found))
"""
STEEL: dict[str, float] = {"q_y": 1.0, "alpha": 0.05}
CASES = [
    *(("bilinear", STEEL, scheme) for scheme in (
        "bathe", "hht_alpha", "hht_alpha_mixed_displacement", "wilson_theta", "rk4", "houbolt", "kr_alpha", "noh_bathe",
        "radau_iia3", "discontinuous_galerkin_p1",
    )),
    ("clough", STEEL, "newmark"),
    ("bouc_wen", {"q_y": 1.0, "n": 2.0}, "hht_alpha"),
    ("bouc_wen", {"q_y": 1.0, "n": 2.0}, "gauss2"),
    ("maxwell", {"stiffness": 20.0, "c": 3.0}, "rk4"),
    ("maxwell", {"stiffness": 20.0, "c": 3.0}, "bathe"),
    ("power_damper", {"c": 0.5, "exponent": 0.5}, "newmark"),
]  # fmt: skip


@pytest.mark.thorough
def test_one_story_is_the_scene_of_an_oscillator() -> None:
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-c", BESIDE_SCENE, json.dumps(CASES)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert len(found) == len(CASES)
    assert {name: x for name, x in found.items() if not x <= 1e-12} == {}


def building(**options: Any) -> ss.Structure:
    law = ss.law("bilinear", k=K, q_y=Q_Y, alpha=ALPHA)
    return ss.shear_building(M, law, damping=0.05, **options).ground_motion(RECORD, 1.0)


def returned(e: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Force, its slope and the new plastic elongation of bilinear springs: the return mapping by hand."""
    trial = K * (e - p)
    plastic = np.abs(trial) > Q_Y
    held = np.where(plastic, np.sign(trial) * Q_Y, trial)
    return ALPHA * K * e + (1 - ALPHA) * held, np.where(plastic, ALPHA, 1.0) * K, e - held / K


def by_hand(C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and forces of the building by average acceleration, with Newton's iteration written out."""
    u, v, p, a = np.zeros(3), np.zeros(3), np.zeros(3), np.full(3, -float(RECORD(np.zeros(1))[0]))
    rows, forces = [u], [np.zeros(3)]
    for n in range(1, STEPS + 1):
        u, v, a = step_by_hand(C, -M * float(RECORD(np.array([n * DT]))[0]), u, v, a, p)
        q, _, p = returned(B @ u, p)
        rows.append(u)
        forces.append(q)
    return np.array(rows), np.array(forces)


def step_by_hand(C: Array, load: Array, u: Array, v: Array, a: Array, p: Array) -> tuple[Array, Array, Array]:
    """Displacement, velocity and acceleration after a step."""

    def motion(new: Array) -> tuple[Array, Array]:
        acceleration = 4 / DT**2 * (new - u - DT * v) - a
        return v + 0.5 * DT * (a + acceleration), acceleration

    new = u
    for _ in range(50):
        q, k, _ = returned(B @ new, p)
        velocity, acceleration = motion(new)
        residual = M * acceleration + C @ velocity + B.T @ q - load
        change: Array = np.linalg.solve(4 / DT**2 * np.diag(M) + 2 / DT * C + B.T @ np.diag(k) @ B, -residual)
        new = new + change
        if np.abs(change).max() < 1e-15:
            break
    return new, *motion(new)


def test_three_stories_by_hand() -> None:
    s = building(heights=[4.0, 3.0, 3.0])
    r = ss.march(s, "average_acceleration", dt=DT, t_end=STEPS * DT)
    u, q = by_hand(np.asarray(s.damping))
    assert np.abs(r.memory["p"]).max() > 0.01  # it has yielded
    assert np.allclose(r.u, u, rtol=0, atol=1e-12)
    assert np.allclose(r.springs.forces, q, rtol=0, atol=1e-11)
    assert np.allclose(r.springs.elongations, u @ B.T, rtol=0, atol=1e-12)
    assert np.array_equal(r.springs.ratios, r.springs.elongations / [4.0, 3.0, 3.0])
    assert r.newton_iterations.max() <= 4  # a solution for each branch, and one that finds it right


def test_the_energy_closes_and_the_base_bears_the_inertia() -> None:
    s = building()
    r = ss.march(s, "average_acceleration", dt=DT, t_end=STEPS * DT)
    account = r.account
    left = account.work - account.damped - (account.kinetic + account.strain)
    assert np.abs(left).max() < 1e-13 * account.work.max()
    assert r.springs.dissipated.min() >= 0.0
    assert np.array_equal(r.energy_dissipated, r.memory["dissipated"].sum(axis=1))
    by_dampers = account.damped[-1] - r.energy_dissipated[-1]
    assert 0.0 < by_dampers < account.damped[-1]
    inertia = -(r.absolute_a @ M) - (r.v @ np.asarray(s.damping)).sum(axis=1)
    assert np.allclose(r.base_shear[1:], inertia[1:], rtol=0, atol=1e-12)
    assert np.allclose(r.base_shear, r.springs.forces[:, 0], rtol=0, atol=1e-13)
    e, q = r.springs.loop(0)
    area = np.sum(0.5 * (q[1:] + q[:-1]) * np.diff(e))
    assert area == pytest.approx(r.springs.dissipated[-1, 0] + r.springs.stored[-1, 0], rel=1e-2)


def test_springs_beside_K_of_several_laws_and_a_linear_one() -> None:
    stories = np.diag([2.0, 1.0])
    names = ["floor", "roof"]
    k = ss.law("linear", k=50.0)
    K0 = 50.0 * np.array([[2.0, -1.0], [-1.0, 1.0]])
    rows = [({"floor": 1.0}, k), ({"roof": 1.0, "floor": -1.0}, k)]
    damper = ({"roof": 1.0}, ss.law("power_damper", c=0.5, exponent=1.0))
    C = np.diag([0.0, 0.5])
    options: dict[str, Any] = {"names": names, "load": ({"roof": 1.0}, ss.HalfSine(3.0, 0.5)), "v0": [1.0, 0.0]}
    plain = ss.march(ss.structure(stories, K0, C=C, **options), "bathe", dt=0.02, t_end=2.0)
    for model in (
        ss.structure(stories, springs=[*rows, damper], **options),
        ss.structure(stories, K0, springs=[damper], **options),
        ss.structure(stories, K0 - K0, springs=[(B[:2, :2], ss.law("linear", k=[50.0, 50.0])), damper], **options),
    ):
        r = ss.march(model, "bathe", dt=0.02, t_end=2.0)
        assert np.allclose(r.u, plain.u, rtol=0, atol=1e-12)
        assert np.allclose(r.springs.forces[:, -1], 0.5 * plain.v[:, 1], rtol=0, atol=1e-11)
        assert np.isnan(r.memory.get("p", np.full(1, np.nan))).all()


@pytest.mark.parametrize("few", [-1, 2, 100])
def test_sparse_matrices_are_corrected_where_few_springs_differ(few: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """By Woodbury's formula from the factors before anything yields; with dense ones each branch has its own."""
    monkeypatch.setattr(branches, "FEW", few)
    law, made, s = ss.law("bilinear", k=K, q_y=Q_Y, alpha=ALPHA), [], building()
    damper = ({0: 1.0, 2: -1.0}, ss.law("power_damper", c=0.2, exponent=0.5))
    for form in (np.asarray, sparse.csr_array):
        model = ss.structure(form(np.diag(M)), form(0.1 * np.eye(3)), springs=[(B, law), damper], C=form(s.damping))
        made.append(model.ground_motion(RECORD, 1.0))
    one, other = (ss.march(model, "bathe", dt=DT, t_end=2.0, account=False) for model in made)
    assert np.allclose(one.u, other.u, rtol=0, atol=1e-12)
    half = ss.march(made[1], "bathe", dt=DT, t_end=1.0, account=False)
    rest = ss.march(made[1], "bathe", dt=DT, t_end=2.0, start=half, account=False)
    assert np.array_equal(rest.u, other.u[100:])


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "houbolt", "kr_alpha", "rk4"])
def test_a_march_goes_on_to_the_bit(scheme: str) -> None:
    s = building()
    whole = ss.march(s, scheme, dt=DT, t_end=1.0, account=False)
    half = ss.march(s, scheme, dt=DT, t_end=0.5, account=False)
    rest = ss.march(s, scheme, dt=DT, t_end=1.0, start=half, account=False)
    assert np.array_equal(rest.u, whole.u[50:])
    assert np.array_equal(rest.v, whole.v[50:])
    assert np.array_equal(rest.springs.forces, whole.springs.forces[50:])
    assert np.array_equal(rest.memory["p"], whole.memory["p"][50:])


def test_a_state_keeps_its_memory_in_a_file_and_for_another_scheme(tmp_path: Any) -> None:
    s = building()
    half = ss.march(s, "average_acceleration", dt=DT, t_end=0.5)
    half.state.save(tmp_path / "state.nc")
    loaded = ss.load(tmp_path / "state.nc")
    rests = [ss.march(s, "bathe", dt=DT, t_end=1.0, start=start) for start in (half, loaded)]
    assert np.array_equal(rests[0].u, rests[1].u)
    assert np.array_equal(rests[0].memory["p"][0], half.memory["p"][-1])
    bare = {"t": 0.5, "u": half.u[-1], "v": half.v[-1]}
    with pytest.raises(ValueError, match="expected memory of start with p, dissipated"):
        ss.march(s, "bathe", dt=DT, t_end=1.0, start=bare)
    given = ss.march(s, "bathe", dt=DT, t_end=1.0, start=bare | {"memory": half.state.memory})
    assert np.allclose(given.u, rests[0].u, rtol=0, atol=1e-3)
    with pytest.raises(ValueError, match="remembers nothing"):
        ss.march(ss.structure(np.diag(M), B.T @ np.diag(K) @ B), "bathe", dt=DT, t_end=1.0, start=half)


@pytest.mark.parametrize("scheme", ["average_acceleration", "houbolt", "rk4"])
@pytest.mark.parametrize("stride", [1, 3])
def test_a_store_holds_what_is_remembered(scheme: str, stride: int, tmp_path: Any) -> None:
    """Resumed to a later end, and asked for once more: springs in a kernel and one by one, and a material."""
    mass = np.diag(M)
    damper = (B[:1], ss.law("power_damper", c=0.1, exponent=0.5))  # which remembers nothing
    models = {
        "kernel": ss.structure(mass, springs=[(B, ss.law("bilinear", k=K, q_y=Q_Y)), damper]),
        "one by one": ss.structure(
            mass, springs=[(B, ss.law("bilinear", k=K, q_y=Q_Y))], solver=lambda A: lambda b: np.linalg.solve(A, b)
        ),
        "material": ss.structure(mass, internal_force=own, state=np.zeros(3)),
    }
    for name, model in models.items():
        s, options = model.ground_motion(RECORD, 1.0), {"dt": DT, "stride": stride}
        whole = ss.march(s, scheme, t_end=1.5, **options)
        halves = [ss.march(s, scheme, t_end=t, **options, save=tmp_path / name) for t in (0.75, 1.5, 1.5)]
        for r in halves[1:]:
            assert np.array_equal(r.u, whole.u)
            assert all(np.array_equal(x, whole.memory[name], equal_nan=True) for name, x in r.memory.items())
            assert all(
                np.array_equal(x, whole.state.memory[name], equal_nan=True) for name, x in r.state.memory.items()
            )
            assert np.array_equal(r.account.damped, whole.account.damped)
            if whole.springs is not None:
                assert np.array_equal(r.springs.dissipated, whole.springs.dissipated)
                assert np.array_equal(r.springs.forces, whole.springs.forces)
        if name == "kernel":
            other = ss.structure(mass, springs=[(B, ss.law("bilinear", k=K, q_y=0.9 * Q_Y)), damper])
            with pytest.raises(ValueError, match="springs; give save"):
                ss.march(other.ground_motion(RECORD, 1.0), scheme, t_end=1.5, **options, save=tmp_path / name)


def test_a_pickled_building_is_the_same() -> None:
    s = building()
    one, other = (ss.march(x, "bathe", dt=DT, t_end=0.5) for x in (s, pickle.loads(pickle.dumps(s))))
    assert np.array_equal(one.u, other.u)


def own(t: float, u: np.ndarray, v: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The springs of `building` as a material of one's own."""
    q, k, new = returned(B @ u, p)
    return B.T @ q, B.T @ np.diag(k) @ B, new


@pytest.mark.parametrize("scheme", ["average_acceleration", "backward_euler", "bathe"])
def test_changes_that_go_too_far_are_shortened(scheme: str) -> None:
    """Stiff elastic-plastic stories in long steps, in which full changes go from branch to branch for ever."""
    law = ss.law("bilinear", k=100.0 * K, q_y=Q_Y)
    s = ss.shear_building(M, law).ground_motion(RECORD, 1.0)
    for dt in (0.05, 0.25, 0.5):
        r = ss.march(s, scheme, dt=dt, t_end=3.0, account=False)
        assert r.status == "completed"
        assert r.springs.shortened > 0
        assert r.newton_iterations.max() < 12


@pytest.mark.parametrize("exponent", [0.1, 0.3, 0.5, 1.5])
@pytest.mark.parametrize("dense", [True, False])
def test_a_damper_that_starts_at_rest(exponent: float, dense: bool) -> None:
    """Its slope is infinite there, so that a correction by it is nothing, which does not say that forces balance."""
    form = np.asarray if dense else sparse.csr_array
    stiffness = B.T @ np.diag(K) @ B
    damper = ss.law("power_damper", c=0.8, exponent=exponent)
    s = ss.structure(form(np.diag(M)), form(stiffness), springs=[(B[:2], damper)]).ground_motion(RECORD, 1.0)
    r = ss.march(s, "average_acceleration", dt=DT, t_end=2.0)
    assert r.status == "completed"
    rates = r.v @ B[:2].T
    forces = 0.8 * np.sign(rates) * np.abs(rates) ** exponent
    assert np.allclose(r.springs.forces, forces, rtol=0, atol=1e-12)
    left = r.absolute_a * M + r.u @ stiffness + forces @ B[:2]
    assert np.abs(left[1:]).max() < 1e-7 * np.abs(r.absolute_a * M).max()
    work = np.cumsum(np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(r.u @ B[:2].T, axis=0), axis=1))
    assert np.allclose(r.energy_dissipated[1:], work, rtol=1e-12)


def test_what_fails_keeps_what_was_done() -> None:
    """A force that no displacement gives: the march ends where it is."""

    def torn(t: float, u: np.ndarray, v: np.ndarray, state: np.ndarray) -> Any:
        return (u * np.nan if t > 0.1 else u), np.eye(1), state

    r = ss.march(ss.structure([[1.0]], internal_force=torn, state=0.0, v0=1.0), "newmark", dt=0.02, t_end=1.0)
    assert r.status == "newton_failed"
    assert r.t_failed is not None
    assert 0.1 < r.t_failed <= 0.14
    assert len(r.t) == len(r.memory["state"])


def _refusal(**options: Any) -> Callable[[], object]:
    return lambda: ss.structure(np.eye(3), **options)


STEEL_LAW = ss.law("bilinear", k=1.0, q_y=1.0)
REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: ss.march(building(), "energy_momentum", dt=DT, t_end=1.0), "energy_momentum takes.*discrete gradient"),
    (
        lambda: ss.march(
            ss.structure(np.eye(1), springs=[([1.0], ss.law("power_damper", c=1.0, exponent=0.5))], v0=1.0),
            "rkn43", dt=DT, t_end=1.0,
        ),
        "takes damping",
    ),
    (_refusal(), "expected K, or internal_force"),
    (_refusal(springs=[([1.0, 0.0], STEEL_LAW)]), "a row of B with 3 components"),
    (_refusal(springs=[([0.0, 0.0, 0.0], STEEL_LAW)]), "free degrees of freedom strain.* spring 0"),
    (_refusal(springs=[([1.0, 0.0, 0.0], "bilinear")]), r"pairs \(row of B, law\)"),
    (_refusal(springs=[(np.eye(3), ss.law("bilinear", k=[1.0, 2.0], q_y=1.0))]), "k of bilinear as one number or 3"),
    (_refusal(springs=[({"roof": 1.0}, STEEL_LAW)]), "to ask by name"),
    (_refusal(K=np.eye(3), state=np.zeros(3)), "expected state with internal_force only"),
    (_refusal(internal_force=own, state=np.zeros(3), tangent=own), "no tangent and potential beside state"),
    (_refusal(internal_force=lambda u: u, springs=[([1.0, 0.0, 0.0], STEEL_LAW)]), "beside one without"),
    (_refusal(internal_force=lambda t, u, v, state: u, state=0.0), "return three things"),
    (_refusal(internal_force=lambda t, u, v, state: (u, None, state), state=0.0), "return its tangent"),
    (_refusal(internal_force=lambda t, u, v, state: (u, np.eye(3), 1.0), state=[0.0]), "names and shapes"),
    (_refusal(internal_force=lambda t, u, v, s: (u, np.eye(3), s.__iadd__(1.0)), state=[0.0]), "leave the state"),
    (lambda: ss.shear_building([1.0, 0.0], [STEEL_LAW] * 2), "masses"),
    (lambda: ss.shear_building([1.0, 1.0], [STEEL_LAW]), "expected 2 laws"),
    (lambda: ss.shear_building([1.0], [STEEL_LAW], heights=-3.0), "heights"),
    (lambda: ss.shear_building([1.0], [STEEL_LAW], modes_damped=1), "modes_damped"),
]  # fmt: skip


@pytest.mark.parametrize(("asked", "why"), REFUSED)
def test_refusals(asked: Callable[[], object], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        asked()


def test_every_scheme_takes_springs_or_says_why_not() -> None:
    """To the end of a short march: with the same displacements as a structure without a memory, while none yields."""
    s = ss.shear_building(M, ss.law("bilinear", k=K, q_y=1e9), v0=1.0)
    linear = ss.structure(np.diag(M), B.T @ np.diag(K) @ B, v0=1.0)
    refused = []
    for scheme in ss.schemes():
        try:
            r = ss.march(s, scheme, dt=0.005, t_end=0.05, account=False)
        except ValueError as error:
            refused.append(scheme)
            assert scheme in str(error)
            continue
        assert np.allclose(r.u, ss.march(linear, scheme, dt=0.005, t_end=0.05).u, rtol=0, atol=1e-12), scheme
    assert refused == ["energy_momentum"]


@pytest.mark.parametrize("as_numbers", [False, True], ids=["r", "r.state.memory"])
def test_what_springs_have_dissipated_goes_on_whether_their_laws_keep_account_or_not(as_numbers: bool) -> None:
    """Of the damper by its power, c times the square of the rate, which is integrated by hand."""
    s = ss.structure(
        np.eye(2),
        9.0 * np.eye(2),
        springs=[([1.0, 0.0], ss.law("bilinear", k=4.0, q_y=0.1)), ([0.0, 1.0], ss.law("power_damper", c=0.4))],
        v0=[1.0, 1.0],
    )
    whole = ss.march(s, "average_acceleration", dt=0.005, t_end=3.0)
    first = ss.march(s, "average_acceleration", dt=0.005, t_end=1.2)
    known = {"t": first.t[-1], "u": first.u[-1], "v": first.v[-1], "a": first.a[-1], "memory": first.state.memory}
    then = ss.march(s, "average_acceleration", dt=0.005, t_end=3.0, start=known if as_numbers else first)
    power = 0.4 * whole.v[:, 1] ** 2
    lost = np.append(0.0, np.cumsum(0.005 * 0.5 * (power[1:] + power[:-1])))[240:]
    assert np.allclose(then.springs.dissipated[:, 1], lost, rtol=1e-4, atol=0.0)
    assert np.allclose(then.energy_dissipated, whole.energy_dissipated[240:], rtol=1e-12, atol=0.0)


def test_a_memory_that_is_no_number_where_it_is_remembered_is_refused() -> None:
    springs = [([1.0], ss.law("bilinear", k=4.0, q_y=0.1)), ([1.0], ss.law("power_damper", c=0.4))]
    s = ss.structure([[1.0]], springs=springs, v0=1.0)
    memory = dict(ss.march(s, "newmark", dt=0.01, t_end=0.1).state.memory)
    with pytest.raises(ValueError, match=r"p in the memory of start to be finite where it is remembered, got nan at"):
        start = {"u": [0.0], "v": [0.0], "memory": {**memory, "p": [np.nan, np.nan]}}
        ss.march(s, "newmark", dt=0.01, t_end=1.0, start=start)
