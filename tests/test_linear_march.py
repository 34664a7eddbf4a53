"""The linear march over lanes: coefficients are rounded once, and a lane is as it would be alone, whatever happens."""

import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from declared import COMMITTED, OWN, UNDAMPED, near
from plain_kernels import GENERATED
from plain_kernels import committed as module_of
from plain_kernels import uncompiled as plain
from substep_derive import Balance, Scheme, knot
from substep_derive.declare.symbols import Omega, h, xi
from substep_derive.emit.filter_module import filter_module
from substep_derive.emit.march_module import WIDTH, march_module
from substep_derive.kernels.march_form import MarchForm
from substep_derive.kernels.march_shape import shape_name, shape_of
from substep_derive.oscillator.amplification import Amplification
from sympy import Rational

import substep as ss
from substep.core import threads
from substep.marching import digital_filter, linear
from substep.marching.linear import LinearLanes, march_linear
from substep.marching.oscillators import Oscillators

Array = np.ndarray
P, N, DT = WIDTH + 5, 11, 0.02  # a full block and a part of one
# none; of a record and of a function of time; as many columns as there are lanes
LOADED = {"free": None, "record": ss.Record(DT, np.sin(np.arange(9.0))), "function": ss.Harmonic(2.0, 7.0, 0.3)}


@cache
def kernels_of(name: str, K: int, in_single: bool) -> tuple[object, object, int]:
    assert not in_single
    module = plain(march_module(shape_of(name), (K,)))
    return getattr(module, f"march_{K}"), getattr(module, f"run_{K}"), WIDTH


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The linear march's functions as plain Python."""
    monkeypatch.setattr(sys.modules["substep.core.kernel_modules"], "committed", module_of)
    monkeypatch.setattr(linear, "_kernels", kernels_of)
    with np.errstate(all="ignore"):  # a block's unused lanes divide by what they find
        yield


def oscillators(seed: int, *, dt: float | None = None, consistent: bool = True, damped: bool = True) -> Oscillators:
    """P oscillators, whose time steps differ unless dt is given."""
    rng = np.random.default_rng(seed)
    omega, damping, u, v = rng.uniform(1, 30, P), rng.uniform(0, 0.3, P), rng.normal(size=P), rng.normal(size=P)
    damping = damping if damped else 0 * damping
    a = -(omega**2) * u - 2 * damping * omega * v if consistent else rng.normal(size=P)
    step = np.full(P, dt) if dt else rng.uniform(0.5 * DT, DT, P)
    return Oscillators(omega, damping, rng.uniform(0.5, 2, P), step, np.stack([u, v, a]))


def test_every_shape_is_committed_and_named() -> None:
    own = {name: ss.scheme(name).kernels for name in COMMITTED}
    names = {one.MARCH for one in own.values()}
    assert all(shape_name(shape_of(name)) == name for name in names)
    assert names == {path.stem for path in GENERATED.glob("marches/linear_march_*.py")}
    assert all(hasattr(module_of(f"marches.{one.MARCH}"), f"march_{one.LOADS}") for one in own.values())


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", OWN)
def test_coefficients_are_rounded_once(name: str) -> None:
    derived, s = MarchForm.of(Amplification.of(OWN[name])), ss.scheme(name)
    rng = np.random.default_rng(7)
    Omegas, xis = 10.0 ** rng.uniform(-4, 2, 6), rng.uniform(0, 0.5, 6) * np.array([0, 1, 1, 1, 1, 1])
    xis = 0 * xis if name in UNDAMPED else xis
    found = s.coefficients(Omegas, xis)
    values = {p.symbol: Rational(float(s.parameters[p.name])) for p in OWN[name].parameters}
    values |= near(OWN[name])
    matrices = (
        (derived.increment, derived.step.den), (derived.step.load_N, derived.step.den),
        (derived.outputs.N, derived.outputs.den), (derived.outputs.load_N, derived.outputs.den),
    )  # fmt: skip
    for k, (x, damping) in enumerate(zip(Omegas, xis, strict=True)):
        at = values | {Omega: Rational(float(x)), xi: Rational(float(damping))}
        for kind, ((numerators, den), mine) in enumerate(zip(matrices, found, strict=True)):
            exact = [e.subs(at) / den.subs(at) for e in numerators]
            size = max((abs(float(e)) for e in exact), default=0.0)
            for e, y in zip(exact, mine[k].reshape(-1), strict=True):
                off = abs(float(Rational(float(y)) - e))
                assert off <= (0.51 * np.spacing(abs(float(e))) if kind == 0 else 1e-13 * size)


def alone(
    scheme: ss.Scheme, o: Oscillators, j: int, load: Callable[[Array], Array] | None, **keep: object
) -> LinearLanes:
    return march_linear(scheme.lane(j), o.lane(j), N, load, **keep)  # type: ignore[arg-type]


def close(a: Array, b: Array) -> bool:
    scale = np.nanmax(np.abs(b), axis=0) if b.size else 1.0
    return np.allclose(a / scale, b / scale, rtol=0, atol=1e-12, equal_nan=True)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("kind", LOADED)
@pytest.mark.parametrize("name", OWN)
def test_lanes_are_the_lane_alone(name: str, kind: str) -> None:
    s, load = ss.scheme(name), LOADED[kind]
    o = oscillators(3, dt=DT if kind == "record" else None, consistent=kind != "function", damped=name not in UNDAMPED)
    for keep in ({"stride": 1}, {"stride": 3}, {"stride": N}, {"keep": "peak"}):
        abreast = march_linear(s, o, N, load, **keep)
        for j in (0, 17, WIDTH - 1, WIDTH, P - 1):
            one = alone(s, o, j, load, **keep)
            assert close(abreast.out[..., j : j + 1], one.out), (keep, j)
            assert close(abreast.peak[:, j : j + 1].T, one.peak.T), (keep, j)
        assert (abreast.n_done == N).all()
        assert (abreast.status == linear.COMPLETED).all()


@pytest.mark.parametrize("place", [0, 3], ids=["from a cache line on", "between"])
@pytest.mark.parametrize("lanes", [10 * WIDTH + 13, WIDTH])
def test_a_history_too_large_for_the_caches_is_the_same(lanes: int, place: int) -> None:
    """Its numbers are stored past the caches, from the first of a cache line on; those before and after it are not."""
    s, rng = ss.scheme("newmark_bdf2"), np.random.default_rng(7)
    n = 2 + (1 << 20) // (3 * lanes)
    o = Oscillators(
        rng.uniform(1, 30, lanes), rng.uniform(0, 0.3, lanes), np.ones(lanes), np.full(lanes, DT),
        rng.normal(size=(3, lanes)),
    )  # fmt: skip
    record = ss.Record(DT, rng.normal(size=n + 1))
    room = np.full(3 * lanes * (n + 1) + 16, np.nan)
    first = -(room.ctypes.data // 8) % 8 + place
    out = room[first:][: 3 * lanes * (n + 1)].reshape(n + 1, 3, lanes)
    march_linear(s, o, n, record, out=out)
    for j in (0, 7, lanes // 2, lanes - 1):
        assert np.allclose(out[..., j], march_linear(s, o.lane(j), n, record).out[..., 0], rtol=0, atol=1e-9), j
    assert np.isnan(room[:first]).all()
    assert np.isnan(room[first + out.size :]).all()


def within(s: ss.Scheme) -> bool:
    """Whether a step takes its loads between its ends only."""
    return bool((s.stencil() >= 0).all() and (s.stencil() <= 1).all())


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", OWN)
def test_the_filter_finds_the_same_peaks(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """From rest under a record the filter is used, for u alone and for u, v, a; its kernels run as plain Python."""
    s, n = ss.scheme(name), 27
    record = ss.Record(DT, np.sin(1.3 * np.arange(n + 1.0)))
    o = oscillators(6, dt=DT, damped=name not in UNDAMPED)._replace(start=np.zeros((3, P)))
    kernels = plain(filter_module())
    monkeypatch.setattr(digital_filter, "_kernel", lambda d, k: (getattr(kernels, f"peaks_{d}_{k}"), kernels.WIDTH))
    found = [digital_filter.peaks_from_rest(s, o, n, record, followed) for followed in (1, 3)]
    histories = march_linear(s, o, n, record).out
    expected = np.abs(histories).max(axis=0)
    if found[0] is None or found[1] is None:
        # a multi-step scheme, or one with an auxiliary state
        larger = len(s.state) > 3 or max(lag for _, lag in s.history) >= 1
        assert name in ("chang", "gsse") or larger or not within(s)
        return
    assert np.allclose(found[1] / expected, 1.0, rtol=0, atol=1e-12)
    assert np.array_equal(found[0], found[1][:1])


@pytest.mark.filterwarnings("ignore:hht_alpha is not A-stable")
@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("alpha", [0.3, np.where(np.arange(P) == 3, 0.3, -0.2)], ids=["all lanes", "one lane"])
def test_a_load_that_a_parameter_takes_outside_the_step_is_not_left_to_the_filter(alpha: float | Array) -> None:
    """hht_alpha takes it at 1 + alpha, where the filter would extrapolate."""
    s, o = ss.scheme("hht_alpha", alpha=alpha), oscillators(6, dt=DT)._replace(start=np.zeros((3, P)))
    record = ss.Record(DT, np.sin(1.3 * np.arange(N + 2.0)))
    expected = np.abs(march_linear(s, o, N, record).out).max(axis=0)
    assert close(march_linear(s, o, N, record, keep="peak").peak.T, expected.T)
    assert s.stencil() is s.stencil()
    assert not s.stencil().flags.writeable


def test_only_from_rest_under_a_record_at_the_steps_is_there_a_filter() -> None:
    s, o = ss.scheme("newmark"), oscillators(6, dt=DT)
    rest, record = o._replace(start=np.zeros((3, P))), ss.Record(DT, np.sin(np.arange(30.0)))
    assert digital_filter.peaks_from_rest(s, rest, N, record, 1) is not None
    others = (
        (o, record), (rest, ss.Harmonic(1.0, 2.0)), (rest, None), (rest, ss.Record(2 * DT, np.sin(np.arange(30.0)))),
        (rest, ss.Record(DT, np.cos(np.arange(30.0)))), (rest, ss.Record(DT, np.sin(np.arange(N + 0.0)))),
        (rest._replace(dt=np.where(np.arange(P) == 3, 0.5 * DT, DT)), record),
    )  # fmt: skip
    for lanes, load in others:
        assert digital_filter.peaks_from_rest(s, lanes, N, load, 1) is None


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["newmark", "generalized_alpha", "houbolt", "rk4"])
def test_a_load_of_each_lanes_own_and_of_all(name: str) -> None:
    """One load, taken from the record itself, from a row for all lanes, and from a row for each lane."""
    s, record = ss.scheme(name), LOADED["record"]
    o = oscillators(5, dt=DT, consistent=False)
    off = march_linear(s, o, N, record)
    read = march_linear(s, o, N, record.__call__)
    own = march_linear(s, o._replace(dt=o.dt * np.where(np.arange(P) == 3, 1 - 1e-15, 1.0)), N, record)
    assert close(read.out, off.out)
    assert close(own.out, off.out)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["rk4", "central_difference", "houbolt"])
def test_a_lane_that_overflows_ends_alone(name: str) -> None:
    s, o = ss.scheme(name), oscillators(9)
    start, omega = o.start.copy(), o.omega.copy()
    start[:, [2, WIDTH + 1]] *= 1e300
    omega[[2, WIDTH + 1]] = 4e3 if name != "houbolt" else 1e160
    o = o._replace(start=start, omega=omega)
    with np.errstate(all="ignore"):
        found = march_linear(s, o, N)
        peaks = march_linear(s, o, N, keep="peak")
        for j in (0, 2, 3, WIDTH, WIDTH + 1, P - 1):
            one = alone(s, o, j, None)
            assert found.n_done[j] == one.n_done[0] == peaks.n_done[j]
            assert found.status[j] == one.status[0] == (linear.NON_FINITE if j in (2, WIDTH + 1) else linear.COMPLETED)
            done = int(one.n_done[0])
            assert np.isnan(found.out[done + 1 :, :, j]).all()
            assert np.isfinite(found.out[: done + 1, :, j]).all()
            assert np.allclose(peaks.peak[:, j], np.abs(one.out[: done + 1, :, 0]).max(axis=0), rtol=1e-12)
    assert found.n_done.min() < N


def test_threads_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither histories nor the filter's peaks, whose blocks are larger."""
    s, o = ss.scheme("bathe"), oscillators(1, dt=DT)
    many = Oscillators(*(np.tile(x, 4) for x in o))._replace(start=np.zeros((3, 4 * P)))
    record = ss.Record(DT, np.sin(np.arange(N + 1.0)))

    def found() -> tuple[Array, Array]:
        return march_linear(s, o, N, record).out, march_linear(s, many, N, record, keep="peak").peak

    serial = found()
    monkeypatch.setattr(threads, "WORTH_THREADS", 0)
    monkeypatch.setattr(threads, "cores", lambda: 2)
    assert all(map(np.array_equal, found(), serial))


def test_parameters_of_each_lanes_own() -> None:
    beta = np.linspace(0.25, 0.4, P)
    s, o = ss.scheme("newmark", beta=beta, gamma=0.5), oscillators(2)
    found = march_linear(s, o, N, LOADED["function"])
    one = alone(s, o, 7, LOADED["function"])
    assert close(found.out[..., 7:8], one.out)
    assert not close(found.out[..., 7:8], march_linear(s.lane(8), o.lane(7), N, LOADED["function"]).out)


def test_room_for_the_history() -> None:
    s, o = ss.scheme("newmark"), oscillators(4)
    room = np.full((N + 1, 3, P), np.nan)
    found = march_linear(s, o, N, out=room)
    assert found.out is room
    assert np.array_equal(room, march_linear(s, o, N).out)
    for bad in (
        np.empty((N + 1, 3, P - 1)), np.empty((N + 1, 3, P), dtype=np.float32), np.empty((P, 3, N + 1)).T,
        np.empty((N + 1, 3, 2 * P))[:, :, ::2],
    ):  # fmt: skip
        with pytest.raises(ValueError, match="expected out to be writeable, C-contiguous"):
            march_linear(s, o, N, out=bad)


def test_no_lanes_and_no_steps() -> None:
    s, o = ss.scheme("bathe"), oscillators(4)
    nobody = Oscillators(*(x[..., :0] for x in o))
    assert march_linear(s, nobody, N).out.shape == (N + 1, 3, 0)
    assert np.array_equal(march_linear(s, o, 0).out, o.start[None])
    assert np.array_equal(march_linear(s, o.lane(3), 0).out, np.array(o.lane(3).start)[None])
    assert np.array_equal(march_linear(s, o, 0, keep="peak").peak, np.abs(o.start))


@pytest.mark.parametrize(("name", "K"), [("linear_march_2_01y", 12), ("linear_march_3_01y", 2)])
def test_a_shape_that_no_scheme_of_the_catalogue_has_is_printed_on_first_use(
    name: str, K: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path))
    march, run, width = linear._kernels.__wrapped__(name, K, False)
    assert width == WIDTH
    assert march.__name__ == f"march_{K}"
    assert run.__name__ == f"run_{K}"
    assert len(list(tmp_path.glob("*.py"))) == 1
    assert linear._kernels.__wrapped__(name, K, False)[0] is march
    assert linear._kernels.__wrapped__(name, K, True)[2] == 2 * WIDTH  # as many registers


@pytest.mark.parametrize("stride", [1, 3])
@pytest.mark.parametrize(
    "load", [ss.Record(0.03, np.sin(np.arange(50.0))), ss.Harmonic(1.0, 3.0)], ids=["record", "sine"]
)
def test_a_lane_marched_piece_by_piece_is_the_lane_marched_at_once(
    load: ss.Record | ss.Harmonic, stride: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = ss.scene("linear_oscillator", omega=2.0, xi=0.1, load=load)
    whole = ss.march(scene, "newmark_bdf2", dt=0.1, t_end=30.0, stride=stride)
    monkeypatch.setattr(linear, "CHUNK", 7)
    pieces = ss.march(scene, "newmark_bdf2", dt=0.1, t_end=30.0, stride=stride)
    for name in ("t", "u", "v", "a"):
        assert np.array_equal(getattr(pieces, name), getattr(whole, name))


@pytest.mark.parametrize("reported", ["u", "v", "a"])
def test_what_a_scheme_reports_is_what_its_declaration_says(reported: str) -> None:
    """Of a scheme that is balanced at the end of its steps: its state goes on as if it reported nothing else."""
    (u0, v0, a0), (u1, v1, a1) = knot(0), knot(1)
    relations = {u1: u0 + h * v0 + h**2 / 4 * (a0 + a1), v1: v0 + h / 2 * (a0 + a1)}
    report = {"u": {u1: u1 + h**2 / 11 * (a1 - a0)}, "v": {v1: v1 + h / 7 * (a1 - a0)}, "a": {a1: (a0 + a1) / 2}}
    own = Scheme("reporting", relations, (Balance.at(knot(1), 1),), report=report[reported])
    scene = ss.scene("linear_oscillator", omega=2.5, xi=0.07, u0=1.0, v0=-1.0, load=ss.Harmonic(2.0, 3.0))
    plain, r = (ss.march(scene, scheme, dt=0.125, t_end=2.0) for scheme in ("average_acceleration", own))
    u, v, a = (x.copy() for x in (plain.u, plain.v, plain.a))
    change = plain.a[1:] - plain.a[:-1]
    u[1:] += 0.125**2 / 11 * change if reported == "u" else 0.0
    v[1:] += 0.125 / 7 * change if reported == "v" else 0.0
    a[1:] -= change / 2 if reported == "a" else 0.0
    for found, expected in ((r.u, u), (r.v, v), (r.a, a)):
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)
