"""Histories of the linear oscillator against published and exact ones."""

from fractions import Fraction

import numpy as np
import pytest
from declared import BY_NAME, UNDAMPED, for_oracle
from oracle import entry
from published import CHOPRA
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.oscillator.evaluation import Evaluation
from substep_derive.oscillator.order import order_of
from sympy import Rational

import substep as ss
from substep.core.loads import Load

PARAMETERS = {
    "newmark": {"beta": 0.3025, "gamma": 0.6},
    "silva_bezerra": {"gamma_t": 0.3},
    "newmark_bdf2": {"gamma_t": 0.4, "beta": 0.25, "gamma": 0.5},
    "generalized_alpha": {"rho_inf": 0.25},
}
RUNS = {name: PARAMETERS.get(name, {}) for name in ss.schemes()}


def piecewise_linear_exact(omega: float, xi: float, record: ss.Record, t: np.ndarray) -> np.ndarray:
    """u at times t, from u = 0.3, v = 0.5, knot by knot in closed form (Nigam & Jennings 1969)."""
    values = np.asarray(record.values)
    wd = omega * np.sqrt(1 - xi**2)
    u, v, found = 0.3, 0.5, np.empty(t.size)

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


@pytest.mark.parametrize("example", CHOPRA)
def test_chopra(example: str) -> None:
    (beta, gamma), expected = CHOPRA[example]
    m, k = 0.2533, 10.0
    scene = ss.scene("linear_oscillator", omega=np.sqrt(k / m), xi=0.05, u0=0, load=ss.HalfSine(10 / m, 0.6))
    r = ss.march(scene, ss.scheme("newmark", beta=beta, gamma=gamma), dt=0.1, t_end=1.0)
    assert np.abs(r.u[1:, 0] - expected).max() <= 1.0e-4


# with which scheme each multi-step scheme starts: by average acceleration, most of them
STARTERS = dict.fromkeys(("houbolt", "park", "oalts", "bdf2", "bdf3", "adams_moulton3", "bdf_alpha"), "newmark")
STARTERS |= {"bdf4": "esdirk43", "adams_moulton4": "dormand_prince"}


def oracle_history(name: str, s: ss.Scheme, scene: ss.Scene, dt: float, n: int) -> np.ndarray:
    """(n + 1, 3) of u, v, a by the oracle's steps, with each scheme's start written out from its paper."""
    other, numbers = for_oracle(BY_NAME[name], {key: float(value) for key, value in s.parameters.items()})
    Omega, xi, load = scene.parameters["omega"] * dt, scene.parameters["xi"], scene.load

    def force(t: float) -> float:
        return 0.0 if load is None else dt**2 * float(load(np.array([t]))[0])

    x0 = np.array([scene.u0[0], scene.v0[0], scene.a0[0]]) * dt ** np.arange(3)
    u, v, a = x0
    rows, x, first = [x0], x0, 0
    if name in STARTERS:
        first, starter = max(lag for _, lag in s.history), STARTERS[name]
        known = {"beta": 0.25, "gamma": 0.5} if starter == "newmark" else {}
        for i in range(first):
            x = np.array(entry(starter).step(x, Omega, xi, known, lambda tau, i=i: force((i + tau) * dt))[0])
            rows.append(x)
        x = np.array([rows[first - lag][kind] for kind, lag in s.history])
    elif name == "gholampour":
        x = np.array([u, v, a, a - (force(dt) - force(0.0) - 2 * xi * Omega * a - Omega**2 * v)])
    elif name == "central_difference_lagged":
        x = np.array([u, v - (force(0.0) - 2 * xi * Omega * v - Omega**2 * u) / 2])
    elif name == "kr_alpha":
        rho = numbers["rho_inf"]
        g, b = (3 - rho) / (2 * (1 + rho)), 1 / (1 + rho) ** 2
        x = np.array([u, v - g * a / (1 + 2 * g * xi * Omega + b * Omega**2), a])
    else:
        x = x0[[kind for kind, _ in s.history]]  # earlier values and auxiliary states begin as those at t = 0
    for i in range(first, n):
        x, reported = entry(other).step(x, Omega, xi, numbers, lambda tau, i=i: force((i + tau) * dt))
        rows.append(np.array(x if name == "kr_alpha_plain_start" else reported, dtype=float))
    return np.array(rows) / dt ** np.arange(3)


@pytest.mark.filterwarnings("ignore:forward_euler is unstable")  # which has to step the same all the same
@pytest.mark.parametrize("name", RUNS)
@pytest.mark.parametrize(
    "load", [None, ss.Harmonic(2.0, 3.0, 0.4), ss.Step(1.5, 0.35), ss.HalfSine(3.0, 0.8)], ids=repr
)
def test_history_equals_the_stepped_one(name: str, load: Load | None) -> None:
    dt, n = 0.1, 40
    xi = 0.0 if name in UNDAMPED else 0.03
    scene = ss.scene("linear_oscillator", omega=5.0, xi=xi, u0=0.7, v0=-0.2, a0=1.3, load=load)
    s = ss.scheme(name, **RUNS[name])
    r = ss.march(scene, s, dt=dt, t_end=n * dt)
    expected = oracle_history(name, s, scene, dt, n)
    for i, history in enumerate((r.u, r.v, r.a)):
        assert history.shape == (n + 1, 1)
        assert np.abs(history[:, 0] - expected[:, i]).max() <= 1e-12 * np.abs(expected[:, i]).max()
    assert r.status == "completed"
    assert r.t_failed is None
    assert r.newton_iterations.shape == (n, s.balances)
    assert np.allclose(r.energy, 0.5 * r.v[:, 0] ** 2 + 0.5 * 5.0**2 * r.u[:, 0] ** 2, rtol=1e-14)


@pytest.mark.usefixtures("plain_marches")
@pytest.mark.parametrize("name", RUNS)
def test_a_record_whose_knots_fall_between_steps_converges_at_the_derived_order(name: str) -> None:
    s = ss.scheme(name, **RUNS[name])
    exact = {key: Fraction(value).limit_denominator(10**6) for key, value in RUNS[name].items()}
    evaluation = Evaluation.at(ParameterSet.of(BY_NAME[name], None, exact))
    dampings = (Rational(0),) if name in UNDAMPED else (Rational(0), Rational(1, 5))
    derived = [min(orders) for orders in zip(*(order_of(evaluation, xi).uva for xi in dampings), strict=True)]
    order = min(2, derived[0])  # of the record's kinks no scheme knows more
    samples = np.random.default_rng(7).normal(size=48)  # the same for every scheme
    record = ss.Record(3.2 / 48, np.concatenate([[0.0], samples, [0.0]]))
    # a knot falls a third or two into a step, whatever the step
    omega, xi, t_end = 4.0, 0.0 if name in UNDAMPED else 0.2, 3.2
    scene = ss.scene("linear_oscillator", omega=omega, xi=xi, u0=0.3, v0=0.5, load=record)
    errors = []
    steps = (1600, 3200, 6400)  # two halvings: at every other one the knots fall into the steps alike
    for n in steps:
        r = ss.march(scene, s, dt=t_end / n, t_end=t_end)
        errors.append(np.abs(r.u[:, 0] - piecewise_linear_exact(omega, xi, record, r.t)).max())
    observed = np.log2(errors[0] / errors[-1]) / (len(steps) - 1)
    assert order - 0.25 < observed < order + (0.35 if derived[0] < 3 else 1.25), (observed, order, errors)


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
        (lambda: ss.scheme("newmarc"), "did you mean 'newmark'.*near are"),
        (lambda: ss.scheme("newmark", betta=1), "did you mean 'beta'"),
        (lambda: ss.scheme("hht_alfa"), "did you mean 'hht_alpha'"),
        (lambda: ss.scheme("newmark", beta="0.25"), "expected parameter beta of newmark to be a real number.*'0.25'"),
        (lambda: ss.scheme("newmark", beta=1j), "expected parameter beta of newmark to be real"),
        (lambda: ss.march("duffing", "bathe", dt=True, t_end=1), "expected dt to be a real number.*True"),
        (lambda: ss.march("bathe", "duffing", dt=0.1, t_end=1), "the scene, then the scheme, got them exchanged"),
        (lambda: ss.sweep("bathe", "duffing", dt=0.1, t_end=1), r"exchanged; call sweep\('duffing', 'bathe', ...\)"),
        (lambda: ss.march("linear_oscillator", "bathe", 0.1, 1), r"by ss.scene\('linear_oscillator', omega=...\)"),
        (lambda: ss.march(np.eye(2), "bathe", 0.1, 1), r"substep.structure\(M, K\) makes of matrices"),
        (lambda: ss.scheme("bathe", gamma=0.4), "bathe has no parameters: expected none, got 'gamma'; leave it out"),
        (lambda: ss.march("duffing", "bathe", dT=0.1, t_end=1), "got 'dT'; did you mean 'dt'"),
        (lambda: ss.march("linear_oscillator", "bathe", omega=1.0), r"ss.scene\('linear_oscillator', omega="),
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
        (lambda: ss.scene("linear_oscillator", omega=0), r"omega of linear_oscillator in \(0\.0, inf\), got 0"),
        (lambda: ss.scene("linear_oscillator", omega=1, xi=-1), r"xi of linear_oscillator in \[0\.0, inf\), got -1"),
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


@pytest.mark.usefixtures("uncompiled")
def test_iterations_of_the_starting_scheme_are_counted() -> None:
    scene = ss.scene("duffing")
    mine = ss.march(scene, ss.scheme("houbolt"), 0.001, 0.02).newton_iterations
    first = ss.march(scene, ss.scheme("average_acceleration"), 0.001, 0.002).newton_iterations
    assert (mine[:2] == first).all()
    assert (mine > 0).all()
