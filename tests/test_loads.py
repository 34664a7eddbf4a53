"""Loads: their digits, and lanes each of which has its own, which are as each run alone."""

import threading
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from mpmath import mp, mpf
from plain_kernels import uncompiled
from substep_derive import Scene
from substep_derive.declare.scene import optional, required
from substep_derive.declare.symbols import rate, sampled
from substep_derive.emit.first_use import catalogue_pair
from substep_derive.motion.equations import EquationsOfMotion
from sympy import symbols

import substep as ss
from substep.core import threads
from substep.core.loads import LoadLanes, values_at
from substep.marching import linear, run, scene_lanes
from substep.marching.linear import march_linear
from substep.marching.oscillators import Oscillators
from substep.sweeps import lanes as sweep_lanes

Array = np.ndarray
EPS = np.finfo(float).eps
RNG = np.random.default_rng(5)
LOADS = Path(__file__).parents[1] / "generated" / "substep_kernels" / "shared" / "loads.py"
PLAIN = uncompiled(LOADS.read_text(encoding="utf-8"))


def ulps(found: Array, exact: list[Any]) -> float:
    """The largest distance in units of the last place."""
    return max(float(abs(mpf(float(x)) - e)) / np.spacing(abs(float(e))) for x, e in zip(found, exact, strict=True))


@pytest.mark.parametrize("compiled", [True, False])
def test_the_sine_keeps_its_digits(compiled: bool) -> None:
    """Also close to multiples of pi, where it is small; bounds as the kernel states them."""
    near = np.arange(1, 600, 7) * np.pi
    x = np.concatenate([RNG.uniform(-2, 2, 2000), RNG.uniform(-1e6, 1e6, 1000), near, near / 2, [0.0, 1e-300, 1e6]])
    with mp.workdps(60):
        exact = [mp.sin(mpf(float(v))) for v in x]
        found = x.copy()
        if compiled:
            found = ss.Harmonic(1.0, 1.0)(x)
        else:
            assert PLAIN.sine(found)
        some = x != 0.0
        assert ulps(found[some], [e for e, here in zip(exact, some, strict=True) if here]) < 2.0
        assert (found[~some] == 0.0).all()
        beyond = np.array([1.0, -2e6, 1e17])
        assert not PLAIN.sine(beyond)
        assert beyond.tolist() == [1.0, -2e6, 1e17]
        assert ulps(ss.Harmonic(1.0, 1.0)(beyond), [mp.sin(mpf(float(v))) for v in beyond]) < 1.0


@pytest.mark.parametrize("largest", [1.0, 1e9])
@pytest.mark.parametrize("lanes", [1, 5])
def test_harmonic_loads_of_lanes_are_those_of_each_alone(lanes: int, largest: float) -> None:
    """To the last bit, along the last axis or the first; also with angles so large that NumPy's sine is taken."""
    t = RNG.uniform(0, largest, (40, 1))
    amplitude, omega, phase = RNG.uniform(1, 9, (3, lanes))
    load = LoadLanes(ss.Harmonic, {"amplitude": amplitude, "omega": omega, "phase": phase})
    alone = np.stack([load.lane(j)(t[:, 0]) for j in range(lanes)])
    assert np.array_equal(load(t), alone.T)
    assert np.array_equal(load(np.repeat(t, lanes, axis=1)), alone.T)
    assert np.array_equal(load.along_first_axis(2)(t.T), alone)
    x, parameters = t.T.repeat(lanes, axis=0), np.stack([amplitude, omega, phase])[..., None]
    near = PLAIN.harmonic(x, parameters)
    assert near == (largest == 1.0)
    assert np.abs(x - (alone if near else t.T)).max() <= 9 * EPS * 20
    if lanes > 1:
        y = t.repeat(lanes, axis=1)
        assert PLAIN.harmonic(y, parameters[:, :, 0][:, None]) == near
        assert np.abs(y - (alone.T if near else t)).max() <= 9 * EPS * 20


@pytest.mark.parametrize("duration", [0.31, 7.0])
def test_harmonic_and_half_sine_are_what_their_formulas_say(duration: float) -> None:
    """Beyond the sine's own two units, they have the rounding of its argument."""
    t = np.concatenate([(np.arange(700) + 2 - np.sqrt(2)) * 0.01, [-1.0, 0.0, duration]])
    amplitude, omega, phase = 3.7, 41.3, 0.4
    with mp.workdps(40):
        for x, f, g in zip(
            t, ss.Harmonic(amplitude, omega, phase)(t), ss.HalfSine(amplitude, duration)(t), strict=True
        ):
            angle = mpf(omega) * mpf(float(x)) + mpf(phase)
            assert abs(mpf(float(f)) - amplitude * mp.sin(angle)) <= amplitude * EPS * (2.5 + abs(angle))
            inside = 0 <= x <= duration
            half = amplitude * mp.sin(mp.pi * mpf(float(x)) / mpf(duration)) if inside else mpf(0)
            assert abs(mpf(float(g)) - half) <= amplitude * EPS * (2.5 + 2 * np.pi)
            assert inside or g == 0.0


def at_fraction(record: ss.Record, t: float) -> Fraction:
    """The record at a time, exactly; a time that differs from a sample's by 1e-9 dt counts as the sample's."""
    position = Fraction(t) / Fraction(record.dt)
    nearest = Fraction(round(position))
    position = nearest if abs(position - nearest) <= Fraction(1e-9) else position
    before = int(position // 1)
    samples = [Fraction(float(x)) for x in record.samples]
    if not 0 <= position <= len(samples) - 1:
        return Fraction(0)
    after = min(before + 1, len(samples) - 1)
    return samples[before] + (position - before) * (samples[after] - samples[before])


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("dt", [0.01, 0.005, 0.004, 0.02, 0.0031, np.sqrt(2) / 100])
def test_a_record_between_its_samples(dt: float, compiled: bool) -> None:
    """At steps of any length, beyond its ends and at samples but for rounding; more times than are taken at once."""
    record = ss.Record(0.01, RNG.normal(size=90))
    t = np.concatenate([(np.arange(300) + c) * dt for c in (0.0, 1.0, 2 - np.sqrt(2))])
    t = np.concatenate([t, [-0.001, -1e-13, 0.89, 0.89 + 1e-13, 0.8901, 1e300, np.inf, -np.inf]])
    found = record(t)
    if not compiled:
        with np.errstate(invalid="ignore"):
            PLAIN.interpolate(record.samples, record.dt, t, found)
    size = np.abs(record.samples).max()
    for x, f in zip(t[:-2], found, strict=False):
        # the position k + s has an error of EPS (k + s), and the slope is at most twice the largest sample
        assert abs(Fraction(float(f)) - at_fraction(record, float(x))) <= size * EPS * (2 + 2 * abs(x) / record.dt)
    assert (found[-3:] == 0.0).all()
    assert record(np.array([np.nan])).tolist() == [0.0]


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("tau", [0.0, 1.0, 0.2, 2 - np.sqrt(2), -1.0])
@pytest.mark.parametrize("dt", [0.01, 0.005, 0.004, 0.02, 0.0031, np.sqrt(2) / 100, 0.5])
def test_a_record_at_steps_is_what_it_is_at_their_times(dt: float, tau: float, compiled: bool) -> None:
    """To the last bit, for blocks of steps within the record, over its ends and beyond them."""
    record = ss.Record(0.01, RNG.normal(size=900))
    for steps in (range(2000), range(300, 301), range(70, 700), range(10**9, 10**9 + 3), range(5, 5)):
        found = record.at_steps(steps, tau, dt)
        if not compiled:
            PLAIN.interpolate_steps(record.samples, record.dt, dt, tau, steps.start, found)
        assert np.array_equal(found, record((np.array(steps, dtype=float) + tau) * dt))


@pytest.mark.parametrize(
    "load", [ss.Record(0.1, [1.0, 2.0, 0.5]), ss.Harmonic(1.0, 2.0), ss.Step(2.0, 0.1), ss.HalfSine(1.0, 0.4)], ids=repr
)
def test_times_of_any_shape_are_left_as_they_were(load: Any) -> None:
    t = RNG.uniform(0, 0.5, (4, 6))
    before = t.copy()
    expected = np.array([[load(np.array([x]))[0] for x in row] for row in t])
    for shaped, values in (
        (t, expected),
        (t.T, expected.T),
        (t[::2, ::3], expected[::2, ::3]),
        (t[1, 2], expected[1, 2]),
    ):
        found = load(shaped)
        assert np.shape(found) == np.shape(values)
        assert np.array_equal(found, values)
    assert np.array_equal(t, before)


def test_an_argument_that_overflows_is_an_error() -> None:
    with pytest.raises(ValueError, match="expected a finite load"), np.errstate(all="ignore"):
        values_at(ss.Harmonic(1.0, 1e300), np.array([0.0, 1e10]))


P, N, DT = 101, 23, 0.02
PARAMETERS = {
    ss.Harmonic(2.0, 7.0, 0.3): {"amplitude": (0.5, 3.0), "omega": (0.1, 40.0), "phase": (-3.0, 3.0)},
    ss.Step(1.5, 0.1): {"amplitude": (-2.0, 2.0), "start": (-0.1, 0.5)},
    ss.HalfSine(3.0, 0.2): {"amplitude": (0.5, 3.0), "duration": (0.01, 0.6)},
}
CASES = [(load, (name,)) for load, ranges in PARAMETERS.items() for name in ranges]
CASES += [(load, tuple(ranges)) for load, ranges in PARAMETERS.items()]


def lanes(load: Any, names: tuple[str, ...]) -> LoadLanes:
    values = {name: getattr(load, name) for name in PARAMETERS[load]}
    return LoadLanes(type(load), values | {name: RNG.uniform(*PARAMETERS[load][name], P) for name in names})


def oscillators(seed: int, *, consistent: bool) -> Oscillators:
    rng = np.random.default_rng(seed)
    omega, xi, mass, u, v = (rng.uniform(*ends, P) for ends in ((1, 30), (0, 0.3), (0.5, 2), (-1, 1), (-1, 1)))
    a = -(omega**2) * u - 2 * xi * omega * v if consistent else rng.normal(size=P)
    return Oscillators(omega, xi, mass, np.full(P, DT), np.stack([u, v, a]))


def agree(found: Array, expected: Array) -> bool:
    """As in the tests of the linear march: to rounding, in terms of the largest value of the lane."""
    scale = np.abs(expected).max(axis=0)
    return np.allclose(found / scale, expected / scale, rtol=0, atol=1e-12)


@pytest.mark.usefixtures("plain_marches")
@pytest.mark.parametrize(("load", "names"), CASES, ids=repr)
@pytest.mark.parametrize("scheme", ["newmark", "bathe", "houbolt", "kr_alpha"])
def test_lanes_with_loads_of_their_own_are_each_as_alone(
    scheme: str, load: Any, names: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is kept, and however many lanes and steps are marched at a time."""
    s, of_lanes, o = ss.scheme(scheme), lanes(load, names), oscillators(3, consistent=scheme != "newmark")
    monkeypatch.setattr(linear, "BLOCKS", 1)
    for keep, steps in (
        ({"stride": 1}, 64),
        ({"stride": 1}, 5),
        ({"stride": 3}, 5),
        ({"stride": 9}, 4),
        ({"keep": "peak"}, 4),
    ):
        monkeypatch.setattr(linear, "LOADED", steps)
        found = march_linear(s, o, N, of_lanes, **keep)  # type: ignore[arg-type]
        for j in (0, 47, 48, P - 1):
            own = replace(load, **{name: float(of_lanes.parameters[name][j]) for name in names})
            one = march_linear(s, o.lane(j), N, own, **keep)  # type: ignore[arg-type]
            assert (
                agree(found.out[..., j : j + 1], one.out) if found.out.size else agree(found.peak[:, j], one.peak[:, 0])
            )
    one = march_linear(
        s, o.lane(0), N, LoadLanes(type(load), {k: np.reshape(x, -1)[:1] for k, x in of_lanes.parameters.items()})
    )
    assert agree(march_linear(s, o, N, of_lanes).out[..., :1], one.out)


def test_ranges_of_steps_end_where_a_row_is_or_have_none() -> None:
    for first, n, stride, most in (
        (0, 10, 1, 4),
        (2, 10, 3, 4),
        (0, 10, 4, 4),
        (1, 23, 9, 4),
        (0, 7, 100, 3),
        (2, 2, 1, 5),
    ):
        at, rows = first, []
        for begin, end, base, pace in linear.pieces(first, n, stride, most):
            assert begin == at < end <= begin + most
            assert end - base <= most
            stored = [k for k in range(begin + 1, end + 1) if (k - base) % pace == 0]
            assert [begin // stride + (k - base) // pace for k in stored] == [k // stride for k in stored]
            rows += stored
            at = end
        assert at == max(first, n)
        assert rows == [k for k in range(first + 1, n + 1) if k % stride == 0]


def test_a_load_of_ones_own_is_evaluated_once_and_by_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where lanes take it at different instants."""
    monkeypatch.setattr(threads, "WORTH_THREADS", 0)
    monkeypatch.setattr(threads, "cores", lambda: 2)
    seen: list[tuple[int, int]] = []

    def load(t: Array) -> Array:
        seen.append((threading.get_ident(), len(t)))
        return np.cos(3.0 * t)

    o, s, n = oscillators(4, consistent=True), ss.scheme("newmark_bdf2", gamma_t=np.linspace(0.2, 0.6, P)), 300
    found = march_linear(s, o, n, load)
    assert agree(found.out, march_linear(s, o, n, ss.Harmonic(1.0, 3.0, np.pi / 2)).out)
    assert {thread for thread, _ in seen} == {threading.get_ident()}
    assert [times for _, times in seen if times > 1] == [n] * s.info.loads


@pytest.mark.parametrize("whole", [2, 3, 7])
@pytest.mark.parametrize("scheme", ["newmark", "bathe", "generalized_alpha"])
def test_several_steps_from_sample_to_sample(scheme: str, whole: int) -> None:
    """Then the load is linear within each step; to take it at the scheme's own instants is the other way."""
    record, s, o = ss.Record(whole * DT, RNG.normal(size=8)), ss.scheme(scheme), oscillators(6, consistent=False)
    for n in (5, 7 * whole - 3, 7 * whole, 7 * whole + 4):  # the record has more samples than steps, or fewer, or ends
        assert agree(march_linear(s, o, n, record).out, march_linear(s, o, n, record.__call__).out)


@pytest.mark.filterwarnings("ignore:dt = 0.02 s is longer than the whole pulse")  # some are of 0.01 s
@pytest.mark.parametrize(("load", "names"), CASES, ids=repr)
@pytest.mark.parametrize("keep", [{"keep": "final"}, {"keep": "peak"}, {"keep": "history", "samples": 5}], ids=str)
def test_a_sweep_over_parameters_of_a_load_is_one_march(
    load: Any, names: tuple[str, ...], keep: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    marches: list[int] = []

    def counted(*args: Any, **more: Any) -> Any:
        marches.append(args[4])
        return run.march_oscillators(*args, **more)

    monkeypatch.setattr(sweep_lanes, "march_oscillators", counted)
    swept = {f"load_{name}": np.linspace(*PARAMETERS[load][name], 3) for name in names}
    fixed: dict[str, Any] = {"xi": 0.05, "u0": 0.3}
    found = ss.sweep(
        "linear_oscillator", "bathe", dt=0.02, t_end=0.8, scene_omega=[3.0, 9.0], load=load, **swept, **fixed, **keep
    )
    assert marches == [2 * 3 ** len(names)]
    for k in RNG.choice(found["status"].size, 4):
        at = np.unravel_index(k, found["status"].shape)
        point = found.isel(dict(zip(found["status"].dims, at, strict=True)))
        own = replace(load, **{name: float(point[f"load_{name}"]) for name in names})
        scene = ss.scene("linear_oscillator", omega=float(point["scene_omega"]), load=own, **fixed)
        r = ss.march(scene, ss.scheme("bathe"), 0.02, 0.8)
        for name, rows in {"u": r.u, "v": r.v, "a": r.a}.items():
            size = np.abs(rows).max()
            if keep["keep"] == "peak":
                assert abs(float(point[f"peak_{name}"].item()) - size) <= 1e-12 * size
            else:
                expected = rows[-1] if keep["keep"] == "final" else rows[::8]
                assert np.allclose(point[name], expected, rtol=0, atol=1e-12 * size)


u, k, m = symbols("u k m")


def own_scene(power: int) -> Scene:
    return Scene(
        name="loaded", coordinates={u: "m"}, kinetic=m * rate(u) ** 2 / 2, potential=k * u**power / power,
        load={u: sampled}, parameters=(optional(m, 2), required(k)), start={u: 1, rate(u): 0}, length=1,
    )  # fmt: skip


def alone(scene: Callable[..., ss.Scene], found: Any, keep: str) -> None:
    """Assert that points of a sweep equal runs of their own."""
    for k in range(found["status"].size):
        at = np.unravel_index(k, found["status"].shape)
        point = found.isel(dict(zip(found["status"].dims, at, strict=True)))
        r = ss.march(
            scene(**{str(name): float(point[name]) for name in found["status"].dims}), ss.scheme("newmark"), 0.05, 1.0
        )
        expected = {"final": r.u[-1], "history": r.u}[keep]
        assert np.allclose(point["u"], expected, rtol=0, atol=1e-11 * np.abs(r.u).max())


@pytest.mark.usefixtures("plain_marches")
@pytest.mark.parametrize(
    "load", [ss.Record(0.05, RNG.normal(size=40)), ss.Record(0.03, RNG.normal(size=40)), ss.Step(3.0, 0.2)], ids=repr
)
def test_masses_of_oscillators_under_one_load_are_lanes(
    load: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    declaration = own_scene(2)
    found = ss.sweep(declaration, "newmark", dt=0.05, t_end=1.0, load=load, k=[10.0, 40.0], m=[0.5, 2.0, 3.0])
    alone(lambda **at: ss.scene(declaration, load=load, **at), found, "final")


@pytest.mark.parametrize("keep", ["final", "history"])
def test_lanes_of_other_scenes_have_loads_of_their_own_too(
    keep: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    declaration, calls = own_scene(4), []
    module = uncompiled(catalogue_pair(BY_NAME["newmark"], EquationsOfMotion(declaration)))
    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda *_: calls.append(1) or module)
    load = ss.Harmonic(4.0, 3.0)
    swept = {"load_omega": [1.0, 3.0], "load_amplitude": [2.0, 4.0, 5.0], "load_phase": [0.0, 0.5, 1.0]}
    with np.errstate(all="ignore"):
        found = ss.sweep(declaration, "newmark", dt=0.05, t_end=1.0, load=load, k=30.0, keep=keep, **swept)
        assert len(calls) == 1

        def scene(load_amplitude: float, load_omega: float, load_phase: float) -> ss.Scene:
            return ss.scene(declaration, k=30.0, load=ss.Harmonic(load_amplitude, load_omega, load_phase))

        alone(scene, found, keep)


def test_a_load_of_ones_own_with_parameters_is_a_march_each() -> None:
    """A subclass may do anything."""

    class Mine(ss.Harmonic):
        def __call__(self, t: Array) -> Array:
            assert np.ndim(self.omega) == 0
            return np.abs(super().__call__(t))

    found = ss.sweep(
        "linear_oscillator",
        "newmark",
        dt=0.05,
        t_end=1.0,
        load=Mine(1.0, 3.0),
        load_omega=[1.0, 2.0],
        scene_omega=[3.0, 4.0],
    )
    for at in ((0, 1), (1, 0)):
        point = found.isel(load_omega=at[0], scene_omega=at[1])
        own = Mine(1.0, float(point["load_omega"]))
        r = ss.march(
            ss.scene("linear_oscillator", omega=float(point["scene_omega"]), load=own), ss.scheme("newmark"), 0.05, 1.0
        )
        assert np.allclose(point["u"], r.u[-1], rtol=0, atol=1e-12 * np.abs(r.u).max())


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "rk4"])
def test_a_load_that_sets_in_at_the_end_of_a_step_does_so_however_that_is_rounded(scheme: str) -> None:
    """3 * 0.15 is less than 0.45 in doubles; 3 * 0.125 is exact, and displacements are those of the same omega h."""

    def displaced(dt: float, start: float) -> Array:
        omega = 0.5 / dt
        pushed = ss.Step(omega**2, start)
        one = ss.structure([[1.0]], [[omega**2]], load=([1.0], pushed))
        scene = ss.scene("linear_oscillator", omega=omega, u0=0.0, load=pushed)
        return np.array([ss.march(x, scheme, dt=dt, t_end=10 * dt).u[:, 0] for x in (one, scene)])

    assert 3 * 0.15 < 0.45
    assert displaced(0.125, 0.375)[:, 4].all()
    assert np.allclose(displaced(0.15, 0.45), displaced(0.125, 0.375), rtol=0.0, atol=1e-13)
