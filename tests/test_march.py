"""Histories of the linear oscillator against published and exact ones."""

import numpy as np
import pytest
from oracle import SCHEMES as ORACLE
from published import CHOPRA

import substep as ss

RNG = np.random.default_rng(7)
RUNS = {
    "newmark": {"beta": 0.3025, "gamma": 0.6},
    "bathe": {},
    "silva_bezerra": {"gamma_t": 0.3},
    "newmark_bdf2": {"gamma_t": 0.4, "beta": 0.25, "gamma": 0.5},
}


def piecewise_linear_exact(omega: float, xi: float, record: ss.Record, t: np.ndarray) -> np.ndarray:
    """u at times t, from rest, knot by knot with the closed form for a linear load (Nigam & Jennings 1969)."""
    values = np.asarray(record.values)
    wd = omega * np.sqrt(1 - xi**2)
    u, v, found = 0.0, 0.0, np.empty(t.size)

    def advance(u: float, v: float, f0: float, slope: float, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        # particular solution a + b s
        b = slope / omega**2
        a = (f0 - 2 * xi * omega * b) / omega**2
        c, d = u - a, (v - b + xi * omega * (u - a)) / wd
        decay = np.exp(-xi * omega * s)
        us = decay * (c * np.cos(wd * s) + d * np.sin(wd * s)) + a + b * s
        vs = decay * ((d * wd - xi * omega * c) * np.cos(wd * s) - (c * wd + xi * omega * d) * np.sin(wd * s)) + b
        return us, vs

    for k in range(values.size - 1):
        inside = (t >= k * record.dt) & (t <= (k + 1) * record.dt)
        slope = (values[k + 1] - values[k]) / record.dt
        found[inside] = advance(u, v, values[k], slope, t[inside] - k * record.dt)[0]
        u, v = advance(u, v, values[k], slope, np.array(record.dt))
    after = t > (values.size - 1) * record.dt
    found[after] = advance(u, v, 0.0, 0.0, t[after] - (values.size - 1) * record.dt)[0]
    return found


def test_every_scheme_runs() -> None:
    assert set(RUNS) == set(ss.schemes())


@pytest.mark.parametrize("example", CHOPRA)
def test_chopra(example: str) -> None:
    (beta, gamma), expected = CHOPRA[example]
    m, k = 0.2533, 10.0
    scene = ss.scene("linear_oscillator", omega=np.sqrt(k / m), xi=0.05, u0=0, load=ss.HalfSine(10 / m, 0.6))
    r = ss.march(scene, ss.scheme("newmark", beta=beta, gamma=gamma), dt=0.1, t_end=1.0)
    assert np.abs(r.u[1:, 0] - expected).max() <= 1.0e-4


@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize(
    "load", [None, ss.Harmonic(2.0, 3.0, 0.4), ss.Step(1.5, 0.35), ss.HalfSine(3.0, 0.8)], ids=repr
)
def test_history_equals_the_stepped_one(name: str, load: ss.loads.Load | None) -> None:
    omega, xi, dt, n = 5.0, 0.03, 0.1, 40
    scene = ss.scene("linear_oscillator", omega=omega, xi=xi, u0=0.7, v0=-0.2, a0=1.3, load=load)
    r = ss.march(scene, ss.scheme(name, **RUNS[name]), dt=dt, t_end=n * dt)
    x = np.array([0.7, -0.2 * dt, 1.3 * dt**2])
    expected = [x]
    for i in range(n):

        def force(tau: float, i: int = i) -> float:
            return 0.0 if load is None else dt**2 * float(load(np.array([(i + tau) * dt]))[0])

        x, _ = ORACLE[name].step(x, omega * dt, xi, RUNS[name], force)
        expected.append(np.array(x, dtype=float))
    expected = np.array(expected) / dt ** np.arange(3)
    for i, history in enumerate((r.u, r.v, r.a)):
        assert history.shape == (n + 1, 1)
        assert np.abs(history[:, 0] - expected[:, i]).max() <= 1e-12 * np.abs(expected[:, i]).max()
    assert r.status == "completed"
    assert r.t_failed is None
    assert r.newton_iterations.shape == (n, ss.scheme(name).balances)
    assert np.allclose(r.energy, 0.5 * r.v[:, 0] ** 2 + 0.5 * omega**2 * r.u[:, 0] ** 2, rtol=1e-14)


@pytest.mark.parametrize("name", RUNS)
def test_a_record_whose_knots_fall_between_steps_converges_at_the_derived_order(name: str) -> None:
    from substep_derive import derive

    parameters = RUNS[name]
    order = derive(name, **{key: str(value) for key, value in parameters.items()}).series.order
    record = ss.Record(0.0617, np.concatenate([[0.0], RNG.normal(size=48), [0.0]]))
    omega, xi, t_end = 4.0, 0.05, 3.2
    scene = ss.scene("linear_oscillator", omega=omega, xi=xi, u0=0, load=record)
    errors = []
    steps = (1600, 3200, 6400, 12800)
    for n in steps:
        r = ss.march(scene, ss.scheme(name, **parameters), dt=t_end / n, t_end=t_end)
        errors.append(np.abs(r.u[:, 0] - piecewise_linear_exact(omega, xi, record, r.t)).max())
    observed = np.log2(errors[0] / errors[-1]) / (len(steps) - 1)
    assert abs(observed - order) < 0.25, (observed, order, errors)


def test_a_record_is_linear_between_knots_and_zero_after_its_end() -> None:
    record = ss.Record(0.1, [0.0, 2.0, -1.0])
    assert np.allclose(record(np.array([0.0, 0.05, 0.1, 0.15, 0.2, 0.2000001, 5.0])), [0, 1, 2, 0.5, -1, 0, 0])
    assert record(np.array([3 * 0.1 - 0.1]))[0] == -1.0  # a knot but for rounding


def test_consistent_start() -> None:
    scene = ss.scene("linear_oscillator", omega=2.0, xi=0.1, u0=0.5, v0=1.5, load=ss.Step(3.0))
    r = ss.march(scene, ss.scheme("bathe"), dt=0.1, t_end=0.1)
    assert r.a[0, 0] == pytest.approx(3.0 - 2 * 0.1 * 2 * 1.5 - 4 * 0.5)


def test_a_run_that_leaves_the_numbers_stops_with_its_last_good_state() -> None:
    scene = ss.scene("linear_oscillator", omega=1.0, u0=1.0)
    r = ss.march(scene, ss.scheme("newmark", beta=0.0, gamma=0.5), dt=50.0, t_end=50.0 * 400)
    assert r.status == "non_finite"
    assert r.t_failed == pytest.approx(r.t[-1] + 50.0)
    assert all(np.isfinite(x).all() for x in (r.u, r.v, r.a, r.t))
    assert len(r.t) == len(r.u) == len(r.v) == len(r.a) == len(r.energy) == len(r.newton_iterations) + 1


def test_energy_bound_stops_before_it_is_passed() -> None:
    scene = ss.scene("linear_oscillator", omega=1.0, u0=1.0)
    r = ss.march(scene, ss.scheme("newmark", beta=0.0, gamma=0.5), dt=2.02, t_end=2.02 * 400, energy_bound=1e3)
    assert r.status == "energy_bound"
    assert (r.energy <= 1e3).all()
    assert r.t_failed == pytest.approx(r.t[-1] + 2.02)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ss.scheme("newmarc"), "one of: .*did you mean 'newmark'"),
        (lambda: ss.scheme("newmark", betta=1), "did you mean 'beta'"),
        (lambda: ss.scheme("newmark_bdf2", gamma_t=1.0), r"in \(0\.0, 1\.0\), got 1\.0; choose"),
        (lambda: ss.scheme("newmark", beta=-0.1), r"in \[0\.0, inf\), got -0\.1"),
        (lambda: ss.scheme("newmark", beta=float("nan")), "finite, got nan"),
        (lambda: ss.scheme("newmark", beta="much"), "real number"),
        (lambda: ss.scheme("newmark").spectral_radius([1.0, np.nan]), r"finite, got nan at index \(1,\)"),
        (lambda: ss.scheme("newmark").spectral_radius(-1.0), "Omega >= 0, got -1"),
        (lambda: ss.scheme("newmark").spectral_radius(1.0, -0.1), "xi >= 0"),
        (
            lambda: ss.scheme("newmark", beta=[0.2, 0.3]).spectral_radius([1, 2, 3]),
            r"broadcast.*Omega \(3,\).*beta \(2,\)",
        ),
        (lambda: ss.scene("pendulum"), "expected a scene"),
        (lambda: ss.scene("linear_oscillator", omega=1, zeta=2), "a parameter of linear_oscillator"),
        (lambda: ss.scene("linear_oscillator"), "omega"),
        (lambda: ss.scene("linear_oscillator", omega=0), "omega > 0, got 0"),
        (lambda: ss.scene("linear_oscillator", omega=1, xi=-1), "xi >= 0"),
        (lambda: ss.scene("linear_oscillator", omega=1, a0="zero"), "consistent"),
        (lambda: ss.scene("linear_oscillator", omega=1, load=[1, 2]), "wrap samples"),
        (lambda: ss.Record(0.1, [1.0, float("nan"), 2.0]), r"nan at index \(1,\)"),
        (lambda: ss.Record(0.0, [1.0, 2.0]), "> 0"),
        (lambda: ss.Record(0.1, [1.0]), "two samples"),
        (lambda: ss.Record(0.1, [[1.0, 2.0]]), "one row"),
        (lambda: ss.march(OSCILLATOR, ss.scheme("bathe"), dt=0.0, t_end=1), "dt > 0, got 0.0"),
        (lambda: ss.march(OSCILLATOR, ss.scheme("bathe"), dt=-0.1, t_end=1), "dt > 0"),
        (lambda: ss.march(OSCILLATOR, ss.scheme("bathe"), dt=0.3, t_end=1.0), "nearest are 0.9 and 1.2"),
        (lambda: ss.march(OSCILLATOR, ss.scheme("bathe"), dt=0.3, t_end=0.1), "nearest is 0.3"),
        (lambda: ss.march(OSCILLATOR, ss.scheme("newmark", beta=[0.2, 0.3]), dt=0.1, t_end=1), "one value for beta"),
        (lambda: ss.march(BAD_LOAD, ss.scheme("bathe"), dt=0.1, t_end=1), "finite load"),
    ],
)
def test_wrong_input_says_what_was_expected_and_the_cure(call, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()


OSCILLATOR = ss.scene("linear_oscillator", omega=1.0)
BAD_LOAD = ss.scene("linear_oscillator", omega=1.0, a0=0.0, load=lambda t: t * np.nan)
