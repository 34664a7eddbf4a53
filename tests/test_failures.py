"""The battery of failures: the word for each kind of run, outcomes known from theory or print, maps against marches."""

import math
from pathlib import Path

import mpmath
import numpy as np
import pytest

import substep as ss
from substep.core.outcome import STATUSES
from substep.derived.facade import rigid_energy
from substep.exact.periods import period as exact_period
from substep.marching.scene_lanes import Lanes, march_lanes
from substep.studies import failures
from substep.studies.failures import contact, linear, maps, outcomes, rounding, stiff_bars, table

NEWTON = STATUSES.index("newton_failed")


def lanes_of(status: str, peak: float, n_done: int = 7) -> Lanes:
    empty, counts = np.empty((1, 0, 0, 0)), np.zeros((1, 0, 0), dtype=np.int64)
    ended = np.array([n_done]), np.array([STATUSES.index(status)])
    none = np.empty((1, 0))
    return Lanes(empty, empty, empty, none, counts, counts, none, np.array([1.0]), np.array([peak]), *ended)


@pytest.mark.parametrize(
    ("status", "ratio", "word", "failed"),
    [
        ("completed", 1.0, "survived", False),
        ("completed", 1.01, "survived", False),
        ("completed", 1.0101, "gains energy", False),
        ("completed", 1000.0, "gains energy", False),
        ("energy_bound", 1.0, "blew up", True),  # from E0 beyond 1e3 E0 in one step
        ("non_finite", 1.0, "blew up", True),
        ("newton_failed", 1.0, "Newton failed", True),
        ("newton_failed", 500.0, "Newton failed", True),  # whatever was gained before
    ],
)
def test_words(status: str, ratio: float, word: str, failed: bool) -> None:
    outcome = outcomes.judge(lanes_of(status, 4.0 * ratio), np.array([0.25]), E0=4.0)
    assert outcomes.WORDS[outcome.word[0]] == word
    assert outcome.t[0] == 2.0 if failed else np.isnan(outcome.t[0])
    assert outcome.max_ratio[0] == ratio


def outcome_of(where: ss.Scene, name: str, h: float, span: float) -> tuple[str, float, float]:
    steps = np.array([h, h])  # two lanes, for which kernels are compiled
    _, outcome = outcomes.run(where, ss.scheme(name), steps, outcomes.whole_steps(span, steps))
    return outcomes.WORDS[outcome.word[0]], float(outcome.t[0]), float(outcome.max_ratio[0])


@pytest.mark.parametrize("name", ["central_difference", "linear_acceleration", "fox_goodwin"])
def test_duffing_blows_up_under_conditional_stability(name: str) -> None:
    period = exact_period(ss.scene("duffing"))
    word, t, _ = outcome_of(ss.scene("duffing"), name, period / 4, 100 * period)
    assert word == "blew up"
    assert t < 5 * period


@pytest.mark.usefixtures("plain_in_gate")
def test_softening_gains_energy_under_unconditional_stability() -> None:
    period = exact_period(ss.scene("softening"))
    assert "average_acceleration" in linear.without_limit()
    word, _, ratio = outcome_of(ss.scene("softening"), "average_acceleration", period / 4, 100 * period)
    assert word == "gains energy"
    assert ratio > 2


def test_energy_momentum_survives() -> None:
    for case in table.CASES[:3]:
        found = outcome_of(case.make(), "energy_momentum", case.steps[0], case.span * case.time)
        assert found[0] == "survived", case.label
        assert found[2] == pytest.approx(1, abs=1e-6)


def test_trapezoidal_rule_on_the_stiff_pendulum() -> None:
    assert maps.first_rise(table.stiff(), np.array([0.1, 0.05]))[0] == pytest.approx(3.5)  # published
    word, t, _ = outcome_of(table.stiff(), "average_acceleration", 0.1, 50.0)
    assert word == "Newton failed"
    assert 3.5 < t < 5


@pytest.mark.parametrize("EA", [1e8, 1e10])
@pytest.mark.parametrize("v0", [7.72, 15.0])
def test_trapezoidal_rule_rises_above_its_critical_step_only(EA: float, v0: float) -> None:
    where = table.stiff(0.0, EA=EA, v0=v0)
    omega = math.sqrt(EA / (10 * 3.0443))
    h = maps.critical_step(where)
    assert h**2 * omega * v0 / 3.0443 == pytest.approx(4)
    below, above = maps.first_rise(where, h * np.array([0.99, 1.01]), span=5000 * h)
    assert np.isnan(below)
    assert above > 0


def test_limits_crossed_by_one_per_cent(tmp_path: Path) -> None:
    rows = linear.limits_crossed(tmp_path)
    without = {s for s in ss.schemes() if ss.scheme(s).critical_Omega == 0}
    assert {"forward_euler", "rk2"} <= without  # whose radius exceeds 1 at every Omega > 0
    conditional = {s for s in ss.schemes() if s not in linear.without_limit()} - without
    assert {row.scheme for row in rows} == conditional
    for row in rows:
        # near its limit gui_lambda overshoots ninefold, which passes for growth
        assert row.grows == (row.scheme == "gui_lambda", True), row
        assert row.rho_below <= 1 + 1e-12
        assert row.rho_above > 1


def test_overshoot(tmp_path: Path) -> None:
    rows = {row.scheme: row for row in linear.overshoot(tmp_path)}
    assert rows["wilson_theta"].u > 2
    # the trapezoidal rule keeps u^2 + (v/omega)^2 exactly, so neither can exceed 1
    assert rows["average_acceleration"].u <= 1 + 1e-12
    assert rows["average_acceleration"].v <= 1 + 1e-12
    # HHT-alpha by hand: Newmark's u and v, balance a1 + omega^2 ((1 + alpha) u1 - alpha u0) = 0
    alpha, Omega = -0.1, 20 * math.pi
    beta, gamma = (1 - alpha) ** 2 / 4, 0.5 - alpha
    u, v, a, largest = 1.0, 0.0, -(Omega**2), 0.0  # u, h v, h^2 a
    for _ in range(linear.OVERSHOOT_STEPS):
        predicted = u + v + (0.5 - beta) * a
        new = Omega**2 * (alpha * u - (1 + alpha) * predicted) / (1 + Omega**2 * (1 + alpha) * beta)
        u, v, a = predicted + beta * new, v + (1 - gamma) * a + gamma * new, new
        largest = max(largest, abs(v) / Omega)
    assert rows["hht_alpha"].v == pytest.approx(largest, rel=1e-9)
    assert largest > 1.2


def test_alternating_steps() -> None:
    Omega = linear.OMEGAS[::20]
    for name in ("houbolt", "park", "bathe", "wilson_theta"):
        s = ss.scheme(name)
        assert linear.alternating_radius(s, Omega, 1.0) == pytest.approx(s.spectral_radius(Omega), rel=1e-6)
    # a one-step scheme of (u, v, a): steps h and 2h, each matrix in physical units
    s, omega, product = ss.scheme("wilson_theta"), 1.7, np.eye(3)
    for h in (0.9, 1.8):
        scale = h ** np.arange(3.0)
        product = (s.amplification(omega * h) * scale / scale[:, None]) @ product
    expected = np.abs(np.linalg.eigvals(product)).max() ** 0.5
    assert linear.alternating_radius(s, np.array([omega * 0.9, 0.1]), 2.0)[0] == pytest.approx(expected)
    assert linear.alternating_radius(s, Omega, 2.0).max() > 1.05  # certified stable for a constant step
    assert linear.alternating_radius(ss.scheme("bathe"), Omega, 2.0).max() < 1 + 1e-9
    # Houbolt takes uneven history as even: its frequency no longer converges
    errors = [linear.alternating_period_error(ss.scheme("houbolt"), 2.0, Omega) for Omega in (0.04, 0.02)]
    assert errors == pytest.approx([-0.05, -0.05], abs=0.003)
    errors = [linear.alternating_period_error(ss.scheme("bathe"), 2.0, Omega) for Omega in (0.04, 0.02)]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.02)


def test_restitution(uncompiled: None) -> None:
    frequencies, phases = np.array([1.0, 10.0, 100.0]), np.arange(10) / 10
    found, status = contact.restitution("energy_momentum", frequencies, phases)
    assert np.isfinite(found[status != NEWTON]).all()
    assert found[np.isfinite(found)] == pytest.approx(1, abs=1e-9)
    assert np.isfinite(found).any(axis=1).all()
    found, _ = contact.restitution("average_acceleration", frequencies, phases)
    assert found.min() < 0.6
    assert found.max() > 2
    # of many steps in contact any scheme makes a bounce
    found, _ = contact.restitution("average_acceleration", np.array([0.05, 0.06]), phases)
    assert found == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("scheme", ss.schemes())
def test_round_off(scheme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, uncompiled: None) -> None:
    monkeypatch.setattr(rounding, "schemes", lambda: (scheme,))
    for row in rounding.round_off(tmp_path):
        if row.scheme == "trbdf3":  # it begins a difference of second order anew in each step, over a third of it
            assert row.u < 1e-22 / row.h**2
            continue
        assert row.u < 1e-12
        assert abs(row.energy) < 1e-11
        if row.a is not None and row.h == 1e-7:
            assert row.a < 1e-5 * row.displacement_unknown


def test_fall_time() -> None:
    with mpmath.workdps(60):
        # a swing of amplitude fl(pi): from there to the angle pi - 0.1, by elliptic integrals
        k = mpmath.sin(mpmath.mpf(math.pi) / 2)
        t = mpmath.ellipk(k**2) - mpmath.ellipf(mpmath.asin(mpmath.cos(mpmath.mpf("0.05")) / k), k**2)
    assert rounding.fall_time() == pytest.approx(float(t), rel=1e-12)
    assert rounding.fall_time() == pytest.approx(math.log(2 * 0.1 / 1.2246e-16), abs=1e-3)


@pytest.mark.usefixtures("plain_in_gate")
def test_small_steps_hold_the_pendulum_at_the_top(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rounding, "QUICK", ("average_acceleration", "energy_momentum"))
    falls, swings = rounding.separatrix(tmp_path)
    times = {row.h: row.t for row in falls if row.scheme == "average_acceleration"}
    coarse, middle, fine = (times[h] or math.inf for h in sorted(times, reverse=True))
    assert coarse < rounding.fall_time() < middle < fine  # u + h v leaves u as it is while h v < ulp(pi)/2
    rotating = {row.scheme for row in swings if row.rotates_at is not None}
    assert "average_acceleration" in rotating
    assert "energy_momentum" not in rotating


def test_map_equals_single_marches() -> None:
    where, points = table.stiff(), 6
    h, y = (x.ravel() for x in np.meshgrid(np.geomspace(0.02, 0.8, points), np.linspace(0.05, 0.95, points)))
    outcome, end = maps.lattice(where, maps.MAPS[0].make, h, y)
    assert set(outcome.word.tolist()) >= {outcomes.SURVIVED, outcomes.GAINS, outcomes.NEWTON}
    for k in range(points**2):
        n = min(math.floor(10 / h[k] + 1e-9), 500)
        s = ss.scheme("newmark_bdf2", gamma_t=y[k], beta=0.25, gamma=0.5)
        r = ss.march(where, s, h[k], float(n * h[k]), energy_bound=1e3 * where.E0)
        ratio = r.energy.max() / where.E0
        failures_of = {"newton_failed": "Newton failed", "non_finite": "blew up", "energy_bound": "blew up"}
        word = failures_of.get(r.status, "gains energy" if ratio > 1.01 else "survived")
        assert outcomes.WORDS[outcome.word[k]] == word
        assert np.isnan(outcome.t[k]) == (r.status == "completed")
        if r.status == "completed":  # how a run fails is chaos: the last bit decides when
            assert outcome.max_ratio[k] == pytest.approx(ratio, rel=1e-9)
            assert end[k] == pytest.approx(r.energy[-1] / where.E0, rel=1e-9)


@pytest.mark.filterwarnings("ignore:.*has gained energy:UserWarning")
def test_stiff_bars_are_predicted_by_the_closed_form_and_observed_by_marches() -> None:
    """Of the trapezoidal rule exp(sqrt(tau^2 - 16/Omega^2)) a step where h^2 omega theta' > 4; 1 below."""
    EA, h = 1e9, np.geomspace(5e-3, 0.1, 8)
    found = stiff_bars.cells(ss.scheme("average_acceleration"), EA, h)
    where, rate, omega = ss.scene("elastic_pendulum", EA=EA, a0="consistent"), 7.72 / 3.0443, (EA / 30.443) ** 0.5
    n = [min(math.floor(10 / x + 1e-9), 500) for x in h]
    logarithm = np.sqrt(np.maximum((rate * h) ** 2 - 16 / (omega * h) ** 2, 0))
    assert [cell.predicted for cell in found] == (n * logarithm > np.log(0.1 * omega / rate)).tolist()
    assert {cell.predicted for cell in found} == {True, False}
    for k, cell in enumerate(found):
        r = ss.march(where, "average_acceleration", h[k], n[k] * h[k], energy_bound=1e3 * where.E0)
        failed = r.status != "completed" or r.energy.max() > 1.01 * where.E0
        assert failed == (cell.word != "survived") == (cell.predicted != (not cell.agrees))


@pytest.mark.thorough
def test_stiff_bars_are_drawn(tmp_path: Path) -> None:
    found = stiff_bars.over_stiffness(tmp_path)
    assert {cell.scheme for cell in found} == {*outcomes.QUICK} - {"energy_momentum"}
    assert np.mean([cell.agrees for cell in found]) > 0.95
    lines = (tmp_path / "stiff_bars.csv").read_text().splitlines()
    assert lines[0] == "scheme,EA,h,predicted,word" and len(lines) == 1 + len(found)
    assert all((tmp_path / f"stiff_bars.{kind}").stat().st_size > 0 for kind in ("png", "svg"))


def test_settled_energy_change_turns_at_the_derived_split() -> None:
    (turn,) = rigid_energy("newmark_bdf2", beta="1/4", gamma="1/2").sign_changes
    where, h, early, late = table.stiff(), 0.03, 500, 4000
    splits = turn + np.repeat([-0.02, -0.01, 0.01, 0.02], 2)
    n = np.tile([early, late], 4)
    s = ss.scheme("newmark_bdf2", gamma_t=splits, beta=0.25, gamma=0.5)
    lanes = march_lanes(where, s, np.full(8, h), n)
    energy = where.energy(np.zeros(8), lanes.state[:, 0], lanes.state[:, 1])
    change = np.log(energy[1::2] / energy[::2])
    assert np.sign(change).tolist() == [1, 1, -1, -1]
    assert change[0] / change[1] == pytest.approx(2, rel=0.1)  # it passes zero linearly, at the turn
    assert change[3] / change[2] == pytest.approx(2, rel=0.1)


@pytest.mark.thorough
def test_battery(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(failures, "CASES", table.CASES[1:2])
    monkeypatch.setattr(failures, "ITEMS", (maps.trapezoidal_rule,))
    monkeypatch.setattr(failures, "MAPS", maps.MAPS[:1])
    monkeypatch.setattr(failures, "BARS", (("impulse", 2.0, 0.0), ("impulse", 2.0, 10.0)))
    monkeypatch.setattr(failures, "QUICK_POINTS", 10)
    calls: list[list[failures.Row] | list[failures.BarRow]] = []
    rows = failures.battery(tmp_path, calls.append)
    assert len(calls) == failures.count() == 5
    assert [row for part in calls for row in part if isinstance(row, failures.Row)] == rows
    assert {row.scheme for row in calls[1]} == set(outcomes.QUICK)
    assert {row.scheme for row in rows} == set(outcomes.QUICK)
    assert all(row.word in failures.WORDS for row in rows)
    for name in ("failures", "map_newmark_bdf2_gamma_t", "trapezoidal_rule", "contact_map"):
        for kind in ("png", "svg", "csv"):
            assert (tmp_path / f"{name}.{kind}").stat().st_size > 0
    assert (tmp_path / "contact_map_under_gravity.png").stat().st_size > 0
    lines = (tmp_path / "failures.csv").read_text().splitlines()
    assert lines[0] == "scheme,scene,h,word,t,max_ratio"
    assert len(lines) == 1 + len(rows)
