"""Runs in chosen steps beside constant ones: how they are measured, which schemes make them, where they are drawn."""

import csv
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import substep as ss
from substep.core.error_estimate import LocalError
from substep.core.outcome import Statistics
from substep.core.response import Response
from substep.marching import adaptive
from substep.studies.precision import cases, charts, choose, measure, tolerance_runs
from substep.studies.precision import reference as references
from substep.studies.precision.measure import Cost, Errors, Run
from substep.studies.precision.scene_choice import SAMPLES

pytestmark = pytest.mark.usefixtures("uncompiled")


@pytest.fixture(scope="module")
def duffing() -> references.Reference:
    return references.reference(ss.scene("duffing"), 0.6, SAMPLES, 1e-12)


def integrated(scene: ss.Scene, times: np.ndarray) -> np.ndarray:
    d = len(scene.u0)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[d:], scene.acceleration(np.array(t), y[:d], y[d:]).ravel()])

    start = np.concatenate([scene.u0, scene.v0])
    return solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13).y[:d].T


def run_of(method: str, operations: int, error: float) -> tuple[ss.Scheme, Run]:
    cost, errors = Cost(operations, operations, operations), {"u": Errors(error, error, error)}
    return ss.scheme(method), Run(method, 0.1, 1, "completed", cost, 1.0, errors)


def test_a_run_is_measured_by_its_own_statistics(duffing: references.Reference) -> None:
    """Against the march itself, SciPy's motion and, for the counts, the rows of the steps."""
    for name in ("bathe", "noh_bathe"):
        s = ss.scheme(name)
        run = tolerance_runs.measure_chosen(duffing, s, 1e-5, 0)
        r = ss.march(duffing.scene, s, t_end=0.6, tol=1e-5)
        assert r.statistics is not None
        assert run.steps == r.statistics.accepted + r.statistics.rejected
        assert len(r.t) == r.statistics.accepted + 1
        assert (run.tol, run.status) == (1e-5, "completed")
        assert np.isnan(run.dt) and np.isnan(run.seconds)
        assert charts.order(name) == 2
        u = integrated(duffing.scene, duffing.t)
        rows = ss.march(duffing.scene, s, t_end=0.6, tol=1e-5, grid=duffing.t)
        assert run.errors["u"].maximum == pytest.approx(np.abs(rows.u - u).max() / np.abs(u).max(), rel=1e-6)
        share = run.steps / r.statistics.accepted
        newton = r.newton_iterations.sum() * share
        expected = round(np.maximum(r.newton_iterations, 1).sum() * share)
        assert run.cost.solves == pytest.approx(expected, abs=1)
        assert run.cost.evaluations == pytest.approx(expected + newton, abs=1)
        each = adaptive.adaptive_kernels(duffing.scene, s).OPERATIONS
        inside = (r.newton_iterations.sum(axis=0)[: len(each["iteration"])] * each["iteration"]).sum() * share
        assert run.cost.operations == pytest.approx(each["step"] * run.steps + inside, abs=1)


@pytest.mark.parametrize(
    ("needed", "marched", "besides"), [((), 1, 0), (("a_*end", "a_*start"), 1, 1), (("u_*halved", "v_*halved"), 3, 0)]
)
def test_what_an_estimate_needs_besides_the_step_is_counted(
    monkeypatch: pytest.MonkeyPatch, needed: tuple[str, ...], marched: int, besides: int
) -> None:
    scene, s = ss.scene("duffing"), ss.scheme("bathe")
    kernels = SimpleNamespace(OPERATIONS={"step": 7, "iteration": (11, 13)})
    terms = tuple(((name, 2),) for name in (*needed, "a_1"))
    monkeypatch.setattr(tolerance_runs, "adaptive_kernels", lambda *_: kernels)
    monkeypatch.setattr(ss.Scheme, "local_error", lambda *_: LocalError(terms, (1.0,), 2, {}, None))
    made = Statistics(8, 2, 0, (16, 24), (3, 3), 0.1, 0.2)
    r = Response(*[np.zeros((9, 1))] * 2, np.zeros((0, 2), int), "completed", None, scene, s, np.nan, None, None, made)
    newton = marched * np.array([20, 30])  # of ten steps
    solves = newton.sum()
    assert tolerance_runs.cost(scene, s, r) == (
        solves, 2 * solves + 10 * besides, 7 * 10 * marched + newton @ (11, 13),
    )  # fmt: skip


def test_finer_tolerances_are_more_accurate_and_timed(duffing: references.Reference) -> None:
    found = list(tolerance_runs.runs(duffing, ss.scheme("noh_bathe"), every=6, repeats=1))
    assert [run.tol for run in found] == [10.0**-k for k in (1, 4, 7, 10)][: len(found)]
    errors = [run.errors["u"].maximum for run in found]
    assert len(found) >= 3
    assert errors == sorted(errors, reverse=True)
    assert all(run.seconds > 0 for run in found)


def test_a_run_that_goes_wrong_ends(monkeypatch: pytest.MonkeyPatch, duffing: references.Reference) -> None:
    """The energy of an unloaded scene cannot rise; here the limit lies below what it has from the start."""
    scene = duffing.scene
    largest = 0.5 * float((duffing.v**2).max())
    assert tolerance_runs.most_energy(duffing, scene) == pytest.approx(scene.E0 + 100 * largest)
    good = tolerance_runs.measure_chosen(duffing, ss.scheme("fox_goodwin"), 1e-3, 0)
    assert good.status == "completed"
    monkeypatch.setattr(tolerance_runs, "BEYOND", -0.5)
    run = tolerance_runs.measure_chosen(duffing, ss.scheme("fox_goodwin"), 1e-3, 0)
    assert run.status == "energy_bound"
    assert run.errors["u"].maximum == np.inf
    assert 0 < run.cost.operations < good.cost.operations
    pushed = ss.scene("linear_oscillator", omega=6.28, load=ss.Step(1.0))
    assert tolerance_runs.most_energy(references.reference(pushed, 1.0, SAMPLES, 1e-3), pushed) is None


@pytest.mark.parametrize("name", ["bathe", "central_difference", "houbolt", "oalts"])
def test_which_schemes_can_choose_their_steps(name: str) -> None:
    """Those with an estimate of their local error: `march` takes tol for these and refuses the others."""
    scene, s = ss.scene("duffing"), ss.scheme(name)
    if tolerance_runs.can_choose(s, scene):
        assert ss.march(scene, s, tol=1e-2, t_end=1e-3).statistics is not None
    else:
        with pytest.raises(ValueError):
            ss.march(scene, s, tol=1e-2, t_end=1e-3)


def test_the_least_work() -> None:
    """Multi-step schemes are passed over; of the others that which needs the least work for the accuracy."""
    tried = [
        run_of("houbolt", 10, 1e-5),  # cannot change its step
        run_of("noh_bathe", 90, 1e-5),
        run_of("noh_bathe", 30, 1e-3),
        run_of("bathe", 60, 1e-5),
        run_of("bathe", 50, 1e-3),
        run_of("backward_euler", 5, 1e-1),
        run_of("tchamwa_wielgosz", 5, 1e-2),
        run_of("dormand_prince", 70, 1e-5),
    ]
    scene = ss.scene("duffing")
    assert [s.name for s in tolerance_runs.ranked(tried, "u", 1e-4)] == [
        *("houbolt", "bathe", "dormand_prince", "noh_bathe", "tchamwa_wielgosz", "backward_euler"),
    ]
    assert [s.name for s in tolerance_runs.least(tried, scene, "u", 1e-2)] == ["tchamwa_wielgosz"]
    assert [s.name for s in tolerance_runs.least(tried, scene, "u", 1e-4)] == ["bathe"]
    assert not tolerance_runs.least(tried[:1], scene, "u", 1e-4)


@pytest.mark.thorough
def test_charts_show_chosen_steps_beside_constant_ones(tmp_path: Path) -> None:
    case = cases.FURTHER[0]
    exact = case.reference()
    constant = [measure.measure(exact, ss.scheme("bathe"), n, 0) for n in (800, 1600)]
    uneven = [tolerance_runs.measure_chosen(exact, ss.scheme("bathe"), tol, 0) for tol in (1e-2, 1e-3)]
    rows = charts._rows(charts.by_method(constant), charts.by_method(uneven))
    assert [row.label for row in rows] == ["sub-steps, order 2", "steps that choose themselves"]
    assert [label for label, *_ in rows[1].curves] == ["bathe, constant steps", "bathe, chosen steps"]
    assert [style["linestyle"] for *_, style in rows[1].curves] == ["-", "--"]
    assert [found for _, found, _ in rows[1].curves] == [constant, uneven]
    charts.work_precision(case, exact, constant, uneven, [], {}, tmp_path)
    with (tmp_path / f"work_precision_{case.name}.csv").open(encoding="utf-8") as file:
        written = list(csv.DictReader(file))
    assert [float(row["tol"]) for row in written[2:]] == [1e-2, 1e-3]
    assert [row["tol"] for row in written[:2]] == ["nan", "nan"]


def test_what_is_recommended_in_chosen_steps_suffices() -> None:
    """A mass that falls for most of the time, and whose contact is short: steps of one length are all as short."""
    scene, t_end, accuracy = ss.scene("penalty_bounce", v0=-1.0), 0.5, 1e-3
    found = choose(scene, accuracy, t_end=t_end, among=["noh_bathe"])
    best = found.best
    assert best is not None
    assert best.dt is None
    assert f"tol = {best.tol:.3g}" in found.text
    grid = np.linspace(0.0, t_end, len(found.reference.t))
    r = ss.march(scene, best.scheme, t_end=t_end, tol=best.tol, grid=grid)
    u = integrated(scene, grid)
    assert np.abs(r.u - u).max() <= 1.05 * accuracy * np.abs(u).max()
    constant = found.otherwise
    assert constant is None or constant.run.cost.operations > best.run.cost.operations


def test_constant_steps_are_recommended_where_they_cost_less(duffing: references.Reference) -> None:
    scene = ss.scene("linear_oscillator", omega=6.28)
    found = choose(scene, 1e-2, t_end=1.0, among=["average_acceleration"])
    assert found.best is not None
    assert found.best.tol is None
    assert found.best.dt == found.best.run.dt
    assert {c.scheme.name for c in found.candidates if c.tol is not None} == {"average_acceleration"}
    assert "in chosen steps (average_acceleration) nothing is as accurate for less" in found.text
    without = choose(scene, 1e-2, t_end=1.0, among=["average_acceleration"], chosen=[])
    assert all(c.tol is None for c in without.candidates)
    with pytest.raises(ValueError, match="houbolt"):
        choose(scene, 1e-2, t_end=1.0, among=["average_acceleration"], chosen=["houbolt"])
