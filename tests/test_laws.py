"""Laws with memory on every scheme: published numbers, plain stepping, lanes, going on, energy, bad input."""

import os
from dataclasses import replace
from itertools import pairwise
from typing import Any

import committed_steps
import law_paths
import numpy as np
import pytest
from declared import BY_NAME
from hysteresis import Oscillator, half_sine, integrated
from law_scenes import BACK_IN_TIME, MARCHED, OMEGA, declared, fitting, kernels, scene
from substep_derive import DeclarationError
from substep_derive.declare.parameter import Root

import substep as ss
from substep.marching import scene_lanes

VERIFY = bool(os.environ.get("SUBSTEP_VERIFY"))


# -- published numbers


def chopra() -> ss.Scene:
    m, k, c = 0.2533, 10.0, 0.1592
    omega = float(np.sqrt(k / m))
    return ss.scene(
        "hysteretic_oscillator", omega=omega, xi=c / (2 * m * omega), strength=7.5 / m, load=ss.HalfSine(10 / m, 0.6)
    )


@pytest.mark.every_scheme
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", ["average_acceleration"])
def test_examples_5_5_and_5_6_of_chopra(scheme: str) -> None:
    """Chopra, Dynamics of Structures, tables E5.5 and E5.6: displacements to the last digit."""
    r = ss.march(chopra(), scheme, dt=0.1, t_end=0.9)
    published = ["0.0437", "0.2326", "0.6121", "1.1143", "1.6214", "1.9891", "2.0951", "1.9240", "1.5602"]
    assert [f"{u:.4f}" for u in r.u[1:, 0]] == published
    assert np.abs(r.force * 0.2533).max() == pytest.approx(7.5, rel=1e-14)


# -- the rule of committing

GUST = np.random.default_rng(3).normal(size=40) * 12.0


def compare(scheme: str, of: Oscillator, u: float, v: float, h: float = 0.05, n: int = 40, **values: float) -> float:
    """The largest difference between the kernels and plain stepping of the declaration, in u, v, a and memory."""
    load = ss.Record(0.1, GUST)
    r = ss.march(scene(of, scheme, load, u, v), ss.scheme(scheme, **values), dt=h, t_end=n * h)
    rows, kept = committed_steps.history(*declared(scheme, of, load, values), h, n, u, v)
    p = np.array(kept)
    assert np.ptp(p) > 0.5 * of.at_yield  # it has yielded
    return max(difference(r, rows, of.omega), np.abs(r.memory["p"] - p).max())


def difference(r: ss.Response, rows: Any, omega: float) -> float:
    """The largest in u, v over omega, and a over its square, where the scheme has an own a."""
    found = np.stack([r.u[:, 0], r.v[:, 0] / omega, r.a[:, 0] / omega**2]).T
    different = np.abs(found - rows / [1, omega, omega**2])
    return max(different[:, :2].max(), np.nanmax(different[:, 2]))


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", MARCHED)
def test_a_step_is_that_of_the_declaration_with_memory_committed_by_the_rule(scheme: str) -> None:
    assert compare(scheme, fitting(scheme, 5.0, 0.04, 4.0, 0.1), 0.1, 1.5) < 1e-11
    assert compare(scheme, fitting(scheme, 8.0, 0.0, 3.0, 0.0), 0.0, 0.0) < 1e-11
    of = fitting(scheme, 5.0, 0.04, 4.0, 0.1)
    instants = committed_steps.Remembering(*declared(scheme, of, ss.Step(0.0), {}), 0.05).instants_of_force
    assert (min(instants) < -1e-12) == (scheme in BACK_IN_TIME)


@pytest.mark.every_scheme
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize(("u", "v"), [(0.6, 2.0), (-0.6, 2.0), (0.6, -2.0)])
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "kr_alpha", "houbolt", "rk4"])
def test_the_start_commits_the_spring_that_is_strained_at_once(scheme: str, u: float, v: float) -> None:
    """It has yielded at t = 0, and goes on to yield, or turns."""
    assert compare(scheme, fitting(scheme, 5.0, 0.04, 4.0, 0.1), u, v) < 1e-11


# beside the bilinear one; parameters of the law, and its stiffness before it is strained
OTHERS = {
    "isotropic_bilinear": ({"q_y": 3.0, "alpha": 0.1}, 25.0),
    "clough": ({"q_y": 3.0, "alpha": 0.1}, 25.0),
    "coulomb": ({"q_y": 2.0, "stiffness": 100.0}, 125.0),
    "slip": ({"q_y": 2.0, "stiffness": 30.0, "gap": 0.05}, 25.0),
    "maxwell": ({"stiffness": 30.0, "c": 2.0}, 55.0),
    "bouc_wen": ({"q_y": 3.0, "alpha": 0.1, "A": 1.0, "beta": 0.5, "gamma": 0.5, "n": 2}, 25.0),
}
NAMED = {"q_y": "strength", "alpha": "hardening", "beta": "beta_bw", "gamma": "gamma_bw"}  # by the scene


# every law with another scheme first, which the gate runs; then each with the others
ON = ["bathe", "rk4", "wilson_theta", "bdf3", "hht_alpha_mixed_displacement"]
BOTH = [(ON[(i + shift) % len(ON)], law) for shift in range(len(ON)) for i, law in enumerate(OTHERS)]


@pytest.mark.usefixtures("plainly")
@pytest.mark.every_scheme
@pytest.mark.parametrize(("scheme", "law"), BOTH if VERIFY else BOTH[: len(OTHERS)])
def test_a_step_with_another_law(scheme: str, law: str) -> None:
    """Which remembers more, or fades in time, from each commit on."""
    omega, xi, h, n, load = 5.0, 0.04, 0.05, 25, ss.Record(0.1, GUST)
    values, k = OTHERS[law]
    beside = "alpha" not in values
    unstrained, follow = getattr(law_paths, law)(**values, **({} if beside else {"k": omega**2}))

    def with_spring(e: float, memory: Any, elapsed: float) -> tuple[float, Any]:
        q, memory = follow(e, memory, elapsed)
        return q + omega**2 * e * beside, memory

    spring = committed_steps.Spring(k, unstrained, with_spring)
    bilinear_one = declared(scheme, Oscillator(omega, xi, 1.0), load, {})
    rows, _ = committed_steps.history(*bilinear_one[:2], spring, *bilinear_one[3:], h, n, 0.0, 1.5)
    given = {NAMED.get(name, name): x for name, x in values.items()}
    one = ss.scene("hysteretic_oscillator", law=law, omega=omega, xi=xi, v0=1.5, load=load, **given)
    r = ss.march(one, scheme, dt=h, t_end=n * h)
    assert difference(r, rows, omega) < 1e-9


FREE = {name: [p for p in BY_NAME[name].parameters if not isinstance(p.default, Root)] for name in MARCHED}


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", [name for name in MARCHED if FREE[name]])
def test_a_step_with_other_parameters(scheme: str) -> None:
    """Sub-steps that end elsewhere, or beyond the step, where nothing is committed."""
    of, rng, tried = fitting(scheme, 5.0, 0.04, 4.0, 0.1), np.random.default_rng(len(scheme)), 0
    for _ in range(12 if VERIFY else 4):
        values = dict[str, float]()
        for p in FREE[scheme]:
            low, high = float(p.domain.inf), min(float(p.domain.sup), float(p.domain.inf) + 2.0)
            default = float(ss.scheme(scheme).parameters[p.name])
            values[p.name] = default + 0.3 * (float(rng.uniform(low, high)) - default)
        try:
            ss.scheme(scheme, **values)
        except ValueError:  # parameters that do not fit each other
            continue
        with np.errstate(all="ignore"):
            r = ss.march(scene(of, scheme, None, 0.1, 1.5), ss.scheme(scheme, **values), dt=0.05, t_end=2.0)
        if r.status != "completed" or np.abs(r.u).max() > 1e3:  # unstable: rounding is magnified
            continue
        tried += 1
        assert compare(scheme, of, 0.1, 1.5, **values) < 1e-9, values
    assert tried


@pytest.mark.usefixtures("plainly")
def test_gholampour_starts_with_the_tangent_of_the_way_on() -> None:
    """Its start takes the tangent at u_0, which is alpha k on the way on from a yielded u_0 and k on the way back."""
    of, load, h, n = Oscillator(5.0, 0.04, 4.0, 0.1), ss.Record(0.1, GUST), 0.05, 5
    for u in (0.3, 0.9, 1.4):
        for v in (1.5, -1.5):
            tangent = of.omega**2 * (of.alpha if u * v > 0 else 1.0)
            rows, _ = committed_steps.history(*declared("gholampour", of, load, {}), h, n, u, v, tangent)
            r = ss.march(scene(of, "gholampour", load, u, v), "gholampour", dt=h, t_end=n * h)
            assert r.u[:, 0] == pytest.approx(rows[:, 0], abs=1e-11)


def test_what_cannot_take_a_law_is_refused_by_name() -> None:
    yielding = ss.scene("hysteretic_oscillator", omega=5.0, strength=4.0)
    with pytest.raises(DeclarationError, match="energy_momentum takes the internal force as a discrete gradient"):
        ss.march(yielding, "energy_momentum", dt=0.01, t_end=0.1)
    undamped = [name for name in ss.schemes() if not BY_NAME[name].takes_damping]
    assert undamped == ["rkn43", "rkn64", "stoermer_extrapolation", "suzuki", "yoshida6"]
    for name in undamped:
        with pytest.raises(DeclarationError, match=rf"{name} is a scheme for u'' = g\(t, u\): expected a scene with"):
            ss.march(yielding, name, dt=0.01, t_end=0.1)


# -- lanes

SEVERAL = ["bathe", "theta_method", "rk4", "bdf3", "wilson_theta"]  # sub-steps, iterated, stages, a starter, beyond


@pytest.mark.every_scheme
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", SEVERAL)
def test_lanes_of_a_block_are_runs_alone(scheme: str) -> None:
    """Oscillators that differ in all parameters, in a block and one by one."""
    rng, P, n, load = np.random.default_rng(5), 20, 30, ss.Record(0.1, GUST)
    ranges = {"omega": (3.0, 9.0), "xi": (0.0, 0.1), "strength": (2.0, 4.0), "hardening": (0.0, 0.5)}
    given = {name: rng.uniform(*ends, P) for name, ends in ranges.items()}
    alone = [
        ss.scene("hysteretic_oscillator", load=load, **{k: float(x[j]) for k, x in given.items()}) for j in range(P)
    ]
    parameters = {name: given.get(name, np.zeros(P)) for name in alone[0].parameters}
    together = replace(alone[0], parameters=parameters, a0=np.array([one.a0 for one in alone]))
    lanes = scene_lanes.march_lanes(
        together, ss.scheme(scheme), np.full(P, 0.05), np.full(P, n), history=True, memory=np.zeros((P, 2))
    )
    for j, one in enumerate(alone):
        r = ss.march(one, scheme, dt=0.05, t_end=n * 0.05)
        assert np.ptp(r.memory["p"]) > 0
        assert lanes.out[j, :, 0] == pytest.approx(r.u, abs=1e-13)
        assert lanes.out[j, :, 1] == pytest.approx(r.v, abs=1e-13)
        assert lanes.memory[j, :, 0] == pytest.approx(r.memory["p"], abs=1e-13)
        assert lanes.memory[j, :, 1] == pytest.approx(r.energy_dissipated, abs=1e-12)
        assert lanes.remembered[j] == pytest.approx([x[-1] for x in r.memory.values()], abs=1e-12)


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("keep", ["history", "final", "peak"])
def test_a_sweep_over_strengths_and_frequencies(keep: str) -> None:
    load, scheme, axes = (
        ss.Record(0.1, GUST),
        "bathe",
        {"omega": [4.0, 5.0, 6.0, 7.0], "strength": [2.0, 3.0, 4.0, 5.0]},
    )
    found = ss.sweep("hysteretic_oscillator", scheme, dt=0.05, t_end=1.5, keep=keep, xi=0.03, load=load, **axes)
    for omega in axes["omega"]:
        for strength in axes["strength"]:
            one = ss.scene("hysteretic_oscillator", omega=omega, strength=strength, xi=0.03, load=load)
            r = ss.march(one, scheme, dt=0.05, t_end=1.5)
            at = found.sel(omega=omega, strength=strength)
            expected = {
                "history": {"u": r.u, "energy": r.energy},
                "final": {"u": r.u[-1], "energy": r.energy[-1]},
                "peak": {"peak_u": np.abs(r.u).max(axis=0), "peak_a": np.abs(r.a).max(axis=0)},
            }[keep]
            for name, x in expected.items():
                assert at[name].values.ravel() == pytest.approx(np.ravel(x), abs=1e-12)


@pytest.mark.thorough
@pytest.mark.every_scheme
@pytest.mark.parametrize("scheme", ["bathe"])
def test_compiled_kernels_are_the_plain_ones(scheme: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a block of lanes and alone, to what contraction of products and sums changes."""
    load, strengths = ss.Record(0.1, GUST), np.linspace(2.0, 6.0, 16)
    compiled = ss.sweep(
        "hysteretic_oscillator", scheme, dt=0.05, t_end=2.0, keep="history", omega=5.0, load=load, strength=strengths
    )
    alone = ss.march(ss.scene("hysteretic_oscillator", omega=5.0, strength=2.0, load=load), scheme, dt=0.05, t_end=2.0)
    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: kernels(scheme.name, scene.info.source))
    for strength in strengths[::5]:
        one = ss.scene("hysteretic_oscillator", omega=5.0, strength=float(strength), load=load)
        r = ss.march(one, scheme, dt=0.05, t_end=2.0)
        assert compiled.u.sel(strength=strength).values.ravel() == pytest.approx(r.u[:, 0], abs=1e-12)
        if strength == strengths[0]:
            assert alone.u == pytest.approx(r.u, abs=1e-12)
            assert alone.memory["p"] == pytest.approx(r.memory["p"], abs=1e-12)


# -- going on


@pytest.mark.every_scheme
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize(
    "scheme", [*SEVERAL, "kr_alpha", "central_difference_lagged", "gholampour", "generalized_alpha"]
)
@pytest.mark.parametrize("at", [0.85, 0.3])
def test_a_run_that_goes_on_is_the_unbroken_one(scheme: str, at: float, tmp_path: Any) -> None:
    """To the bit, with what the spring remembers, from the state and from its file."""
    one = scene(Oscillator(5.0, 0.04, 3.0, 0.1), scheme, ss.Record(0.1, GUST), 0.1, 1.5)
    whole = ss.march(one, scheme, dt=0.05, t_end=2.0)
    first = ss.march(one, scheme, dt=0.05, t_end=at)
    assert first.memory["p"][-1] != 0
    first.save(tmp_path / "first.nc")
    n = len(first.t) - 1
    for start in (first, first.state, ss.load(tmp_path / "first.nc")):
        r = ss.march(one, scheme, dt=0.05, t_end=2.0, start=start)
        assert np.array_equal(r.u, whole.u[n:])
        assert np.array_equal(r.v, whole.v[n:])
        assert all(np.array_equal(r.memory[name], whole.memory[name][n:]) for name in whole.memory)
        assert r.state.memory == whole.state.memory


@pytest.mark.usefixtures("plainly")
def test_another_scheme_goes_on_from_what_the_spring_remembers() -> None:
    """Anew from u, v and memory: as one that was given them."""
    one = scene(Oscillator(5.0, 0.04, 3.0, 0.1), "bathe", ss.Record(0.1, GUST))
    first = ss.march(one, "bathe", dt=0.05, t_end=1.0)
    given = {"t": 1.0, "u": first.u[-1], "v": first.v[-1], "memory": first.state.memory}
    r = ss.march(one, "rk4", dt=0.01, t_end=2.0, start=given)
    other = ss.march(one, "rk4", dt=0.01, t_end=2.0, start=first)
    assert np.array_equal(r.u, other.u)
    assert r.memory["p"][0] == first.memory["p"][-1] != 0


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("memory", [None, {}, {"p": 0.1}, {"p": 0.1, "dissipated": 0.0, "q": 0.0}])
def test_a_start_without_all_that_the_spring_remembers_is_refused(memory: Any) -> None:
    one = scene(Oscillator(5.0, 0.04, 3.0, 0.1), "bathe")
    start = {"u": 0.1, "v": 0.0} | ({} if memory is None else {"memory": memory})
    with pytest.raises(ValueError, match="expected memory of start with p, dissipated, what the laws of hysteretic"):
        ss.march(one, "bathe", dt=0.05, t_end=1.0, start=start)


# -- energy


@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.7])
def test_the_work_of_the_force_is_stored_or_dissipated(alpha: float) -> None:
    """On a random path of the elongation: the sum of force times way, piece by piece, to rounding."""
    of, one = Oscillator(5.0, 0.04, 4.0, alpha), scene(Oscillator(5.0, 0.04, 4.0, alpha), "bathe")
    path = np.concatenate([[0.0], np.random.default_rng(8).normal(size=60).cumsum() * of.at_yield])
    memory, p, work = np.zeros(2), 0.0, 0.0
    for a, b in pairwise(path):
        work, p = work + of.work(a, b, p), of.committed(b, p)
        memory = one.committed(np.array([b]), memory)
        assert memory[0] == pytest.approx(p, abs=1e-13)
        stored = float(one.energy(np.zeros(()), np.array([b]), np.zeros(1), memory))
        assert stored == pytest.approx(of.stored(b, p), rel=1e-12, abs=1e-14)
        assert float(one.outputs(np.zeros(()), np.array([b]), np.zeros(1), memory)["force"]) == pytest.approx(
            of.force(b, p)
        )
        assert stored + memory[1] == pytest.approx(work, rel=1e-12)
    assert memory[1] > 10 * (1 - alpha) * of.strength * of.at_yield


@pytest.mark.every_scheme
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "rk4", "central_difference"])
def test_the_account_of_energy_closes(scheme: str) -> None:
    """Kinetic, stored, dissipated by the spring and by the damper, against the work of the load: to order 2."""
    of, load, rest = Oscillator(OMEGA, 0.05, 12.0, 0.1), ss.HalfSine(40.0, 0.8), []
    _, _, _, damper, spring, work = integrated(of, half_sine(40.0, 0.8), 2.0)
    for n in (200, 400, 800):
        r = ss.march(scene(of, scheme, load), scheme, dt=2.0 / n, t_end=2.0)
        lost = 2 * of.xi * of.omega * np.trapezoid(r.v[:, 0] ** 2, r.t)
        given = np.trapezoid(load(r.t) * r.v[:, 0], r.t)
        rest.append(abs(r.energy[-1] + r.energy_dissipated[-1] + lost - given))
        assert r.energy_dissipated[-1] == pytest.approx(spring, rel=200 / n**1.7)
    assert r.energy_dissipated[-1] > 0.3 * work > damper
    assert rest[-1] < 1e-4 * work
    assert rest[-1] < rest[0] / 8  # by 16, but for where the events lie
    along = sum(of.work(a, b, p) for a, b, p in zip(r.u[:, 0], r.u[1:, 0], r.memory["p"], strict=False))
    if scheme != "bathe":  # which commits within its steps
        stored = r.energy[-1] - r.v[-1, 0] ** 2 / 2
        assert stored + r.energy_dissipated[-1] == pytest.approx(along, rel=1e-12)


@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("law", ["bilinear", "isotropic_bilinear"])
@pytest.mark.parametrize("h", [0.1, 1.0, 7.0])
@pytest.mark.parametrize("alpha", [0.0, 0.3])
def test_steps_of_any_length_balance(law: str, h: float, alpha: float) -> None:
    """The law followed by itself along the displacements, and Newmark's relations: omega h up to 44, with yielding."""
    load = ss.Harmonic(9.0, 0.4 / h)
    given = {"omega": OMEGA, "xi": 0.05, "law": law, "strength": 2.0, "hardening": alpha, "load": load}
    r = ss.march(ss.scene("hysteretic_oscillator", **given), "average_acceleration", h, 60 * h)
    assert r.status == "completed"
    spring = ss.law(law, k=OMEGA**2, q_y=2.0, alpha=alpha)
    forces, memory = spring.loop(r.u[:, 0])
    assert np.count_nonzero(np.diff(memory[:, 0])) > 3
    u, v, a = r.u[:, 0], r.v[:, 0], r.a[:, 0]
    assert np.abs(a + 2 * 0.05 * OMEGA * v + forces - load(r.t)).max() <= 1e-12 * max(np.abs(forces).max(), 9.0)
    assert np.abs(np.diff(v) - h / 2 * (a[1:] + a[:-1])).max() <= 1e-13 * (np.abs(v).max() + h * np.abs(a).max())
    assert np.abs(np.diff(u) - h / 2 * (v[1:] + v[:-1])).max() <= 1e-13 * (np.abs(u).max() + h * np.abs(v).max())


# -- bad input


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("strength", x) for x in (0.0, -1.0, np.nan, np.inf, "much")),
        *(("hardening", x) for x in (1.0, 1.5, -0.1, np.nan)),
        *(("omega", x) for x in (0.0, -1.0, np.nan)),
        *(("xi", x) for x in (-0.1, np.nan)),
        ("u0", np.nan),
        ("v0", np.inf),
    ],
)
def test_a_wrong_parameter_is_refused_by_name(name: str, value: Any) -> None:
    given: dict[str, Any] = {"omega": 5.0, "strength": 4.0, name: value}
    with pytest.raises(ValueError, match=name):
        ss.scene("hysteretic_oscillator", **given)


@pytest.mark.parametrize("missing", ["omega", "strength"])
def test_a_missing_parameter_is_named(missing: str) -> None:
    given = {"omega": 5.0, "strength": 4.0}
    del given[missing]
    with pytest.raises(ValueError, match=missing):
        ss.scene("hysteretic_oscillator", **given)


@pytest.mark.usefixtures("plainly")
def test_a_load_that_is_not_finite_is_refused() -> None:
    one = ss.scene("hysteretic_oscillator", omega=5.0, strength=4.0, load=lambda t: np.where(t > 0.5, np.nan, 0.0))
    with pytest.raises(ValueError, match="expected a finite load"):
        ss.march(one, "bathe", dt=0.05, t_end=1.0)


@pytest.mark.usefixtures("plainly")
def test_scenes_without_laws_have_no_memory() -> None:
    r = ss.march(ss.scene("duffing", k=1.0, eps=0.1, u0=1.0), "bathe", dt=0.05, t_end=0.1)
    assert r.memory == {}
    with pytest.raises(AttributeError, match="hysteretic_oscillator"):
        _ = r.energy_dissipated
    with pytest.raises(AttributeError, match="hysteretic_oscillator"):
        _ = r.force
