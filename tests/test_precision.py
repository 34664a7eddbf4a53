"""Speed against accuracy: exact motions, references, counts, errors, charts."""

import csv
import pickle
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from plain_kernels import SCENE_BY_NAME
from scipy.integrate import solve_ivp
from substep_kernels.facts import CATALOGUE
from substep_thesis.derive.printed import undamped_order

import substep as ss
from substep.exact import motions
from substep.studies.precision import cases, charts, crossover, jobs, measure, peers
from substep.studies.precision import reference as references
from substep.studies.precision.measure import Cost, Errors, Run
from substep.studies.step_counts import SAMPLES

KNOWN = {
    "damped": ss.scene("linear_oscillator", omega=6.28, xi=0.1, u0=0.7, v0=-2.0),
    "elastic": ss.scene("elastic_pendulum", EA=1e4),
    "soft": ss.scene("elastic_pendulum", EA=300.0, L=2.0, m=3.0, v0=5.0),
    "rigid": ss.scene("rigid_pendulum"),
    "duffing": ss.scene("duffing"),
    "swing": ss.scene("simple_pendulum", g_over_L=9.81, v0=-6.0),
    "bounce": ss.scene("penalty_bounce", k=100.0, u0=0.3, v0=-0.7),
    "chain": ss.scene("bathe_noh", k1=1000.0, k2=3.0),
}


def integrated(scene: ss.Scene, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    d = len(scene.u0)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[d:], scene.acceleration(np.array(t), y[:d], y[d:]).ravel()])

    start = np.concatenate([scene.u0, scene.v0])
    r = solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13)
    return r.y[:d].T, r.y[d:].T


@pytest.mark.parametrize("scene", KNOWN.values(), ids=KNOWN)
def test_exact_motions(scene: ss.Scene) -> None:
    times = np.linspace(0, 2, 9)
    motion = motions.motion(scene)
    assert motion is not None
    for found, should in zip(motion(times), integrated(scene, times), strict=True):
        np.testing.assert_allclose(found, should, rtol=0, atol=1e-10 * np.abs(should).max())


def test_motions_without_closed_form_are_not_made_up() -> None:
    assert motions.motion(ss.scene("linear_oscillator", omega=1.0, xi=1.0)) is None
    assert motions.motion(ss.scene("linear_oscillator", omega=1.0, load=ss.Step(1.0))) is None
    assert motions.motion(ss.scene("elastic_pendulum", EA=1e4, v0=0.0)) is None
    assert motions.motion(ss.scene("softening")) is None


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["elastic", "duffing"])
def test_converged_reference_is_as_close_as_it_says(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, t_end = KNOWN[name], {"elastic": 0.5, "duffing": 0.1}[name]
    true = references.reference(scene, t_end, 10, 1e-7)
    monkeypatch.setattr(motions, "motion", lambda _: None)
    found = references.reference(scene, t_end, 10, 1e-7)
    assert found.error <= 1e-7
    for x, should in ((found.u, true.u), (found.v, true.v), (found.a, true.a)):
        np.testing.assert_allclose(x, should, rtol=0, atol=1e-6 * np.abs(should).max())
    monkeypatch.setattr(references, "MOST_STEPS", 40)
    with pytest.raises(ValueError, match="shorter span or less accuracy"):
        references.reference(scene, t_end, 10, 1e-14)


def agrees(found: references.Reference, quantity: str, wished: float) -> None:
    """Assert that the reference's quantity differs from that of DOP853 by less than `wished`, relative to its size."""
    u, v = integrated(found.scene, found.t)
    should = {"u": u, "a": found.scene.acceleration(found.t, u, v)}[quantity]
    off = np.abs({"u": found.u, "a": found.a}[quantity] - should).max()
    assert off <= wished * np.abs(should).max()


def test_reference_resolves_what_is_asked_for() -> None:
    """Axial vibration is 1e-6 of u and most of a."""
    stiff = ss.scene("elastic_pendulum", EA=1e7, strain="engineering")
    agrees(references.reference(stiff, 0.2, SAMPLES, 1e-4, "a"), "a", 1e-4)


@pytest.mark.thorough
def test_reference_is_not_deceived_by_vibration_that_coarse_steps_damp() -> None:
    agrees(references.reference(ss.scene("bathe_noh"), 1.0, SAMPLES, 1e-5), "u", 1e-5)


def test_reference_sees_a_short_pulse() -> None:
    at_rest = ss.scene("linear_oscillator", omega=5.0, u0=0.0, load=ss.HalfSine(1000.0, 0.001))
    found = references.reference(at_rest, 10.0, SAMPLES, 1e-3)
    impulse = 1000.0 * 0.001 * 2 / np.pi
    np.testing.assert_allclose(found.u[1:, 0], impulse / 5 * np.sin(5 * (found.t[1:] - 0.0005)), rtol=0, atol=1e-4)


@pytest.fixture
def duffing() -> references.Reference:
    return references.reference(KNOWN["duffing"], 0.15, SAMPLES, 1e-12)


BETTER_UNDAMPED = ("fox_goodwin", "central_difference_lagged", "kim_two_stage")  # derived orders hold with damping too


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ss.schemes())
def test_every_scheme_reaches_its_derived_order(name: str, duffing: references.Reference) -> None:
    times = (1, 2) if charts.order(name) > 5 else (8, 16)  # before the error is the reference's own
    coarse, fine = (measure.measure(duffing, ss.scheme(name), n * SAMPLES, 0) for n in times)
    assert np.isnan(fine.seconds)
    slope = np.log2(coarse.errors["u"].maximum / fine.errors["u"].maximum)
    linear = charts.order(name)
    nonlinear = CATALOGUE[name]["nonlinear_order"][0] or linear  # 0 for a scheme that takes no damping
    order = undamped_order(name)[0] if name in BETTER_UNDAMPED else min(linear, nonlinear)
    assert slope == pytest.approx(order, abs=0.35)
    assert (order > charts.order(name)) == (name in BETTER_UNDAMPED)


@pytest.mark.usefixtures("uncompiled")
def test_costs_are_counted(duffing: references.Reference) -> None:
    scene = duffing.scene
    for name, solves in (("central_difference", 1), ("noh_bathe", 2), ("rk4", 4)):  # explicit: no tangent
        run = measure.measure(duffing, ss.scheme(name), SAMPLES * 4, 0)
        assert run.cost[:2] == (solves * run.steps, solves * run.steps)
    s = ss.scheme("bathe")
    run = measure.measure(duffing, s, SAMPLES * 2, 0)
    r = ss.march(scene, s, run.dt, 0.15)
    newton = int(r.newton_iterations.sum())
    assert run.cost[:2] == (newton, 2 * newton)
    each = measure.pair_kernels(scene, s).OPERATIONS
    assert run.cost.operations == each["step"] * run.steps + sum(r.newton_iterations.sum(axis=0) * each["iteration"])
    longer = references.reference(scene, 1.5, SAMPLES, 1e-12)  # with steps that the explicit scheme does not survive
    failed = measure.measure(longer, ss.scheme("central_difference"), SAMPLES, 0)
    assert failed.status == "non_finite"
    assert failed.cost[:2] == (SAMPLES, SAMPLES)
    assert failed.errors["u"].maximum == np.inf


def test_costs_of_a_linear_scene() -> None:
    found = references.reference(KNOWN["damped"], 1.0, SAMPLES, 1e-12)
    run = measure.measure(found, ss.scheme("newmark_bdf2"), SAMPLES, 2)
    assert run.cost[:2] == (2 * SAMPLES, 2 * SAMPLES)
    assert run.cost.operations % (2 * SAMPLES) == 0
    assert run.seconds > 0


def test_errors_are_reported_in_three_ways() -> None:
    scene = KNOWN["damped"]
    t, one = np.arange(4.0), np.ones((4, 1))
    should = references.Reference(scene, t, np.array([[1.0], [-4.0], [2.0], [0.0]]), one, 0 * one, 0.0, "by hand")
    off = np.array([[0.0], [0.4], [-0.8], [0.2]])
    found = measure.against(should, scene, should.u + off, one, 0 * one + 3.0)
    assert found["u"] == pytest.approx(Errors(0.05, 0.2, np.sqrt((0.1**2 + 0.2**2 + 0.05**2) / 4)))
    assert found["v"] == Errors(0, 0, 0)
    assert found["a"].maximum == 3.0  # of a reference that is 0, the error itself
    assert measure.failed(should, scene)["u"].maximum == np.inf


def test_angles_do_not_mind_revolutions() -> None:
    bar, rigid = KNOWN["elastic"], KNOWN["rigid"]
    assert "angle" in measure.quantities(bar)
    assert "angle" in measure.quantities(rigid)
    assert "angle" not in measure.quantities(KNOWN["duffing"])
    assert measure.shared(bar, rigid) == ("angle",)
    other = ss.scene("softening")
    assert measure.shared(KNOWN["duffing"], other) == ("u", "v", "a")
    t = np.linspace(0, 20, 41)
    turned = 7.72 / 3.0443 * t
    u = 3.0443 * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    should = references.Reference(bar, t, u, 0 * u, 0 * u, 0.0, "by hand")
    found = measure.against(should, rigid, turned[:, None] + 1e-6, turned[:, None], turned[:, None])
    assert found["angle"].maximum == pytest.approx(1e-6, rel=1e-6)


def test_every_scheme_is_of_one_kind() -> None:
    found = charts.kinds()
    assert sorted(name for names in found.values() for name in names) == sorted(ss.schemes())
    for kind, name in (("explicit", "rk4"), ("one solve a step", "newmark"), ("several steps", "houbolt")):
        assert name in found[kind]
    assert "newmark_bdf2" in found["sub-steps"]


@pytest.mark.thorough
def test_charts_show_failures_and_write_every_number(tmp_path: Path) -> None:
    case = cases.CASES[0]
    found = case.reference()
    fine = [measure.measure(found, ss.scheme(name), n, 1) for name in ("bathe", "rk4") for n in case.steps(5)]
    ok = fine[0]
    broken = [
        Run("bathe", 1.0, 1, "newton_failed", Cost(10**6, 1, 1), 1.0, dict.fromkeys(ok.errors, Errors(*[np.inf] * 3)))
    ]
    charts.work_precision(case, found, [*fine, *broken], [], [], {"numbalsoda": "not here"}, tmp_path)
    for name in ("linear", "linear_quantities"):
        assert (tmp_path / f"work_precision_{name}.png").stat().st_size > 10_000
    with (tmp_path / "work_precision_linear.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(fine) + 1
    assert rows[-1]["status"] == "newton_failed"
    assert float(rows[0]["u_maximum"]) == pytest.approx(ok.errors["u"].maximum, rel=1e-5)


def test_failures_are_open_marks_at_the_edge() -> None:
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    runs = [Run("m", 1.0, 1, "completed", Cost(n, n, n), 1.0, {"u": Errors(e, e, e)}) for n, e in ((1, 5.0), (2, 0.1))]
    charts.curve(axes, runs, lambda run: run.cost.solves, lambda run: run.errors["u"].maximum, color="k")
    line, marks = axes.lines
    assert line.get_xydata().tolist() == [[2, 0.1]]
    assert marks.get_xydata().tolist() == [[1, charts.TOP]]
    assert marks.get_markerfacecolor() == "none"


def test_every_scene_has_a_chart() -> None:
    """But uniform rotation, which every scheme follows exactly."""
    drawn = {case.make().name for case in (*cases.CASES, *cases.FURTHER)}
    assert drawn | {"rigid_pendulum"} == set(SCENE_BY_NAME)  # those with laws are not smooth


@pytest.mark.parametrize("case", (*cases.CASES, *cases.FURTHER), ids=lambda case: case.name)
def test_cases_have_references_and_peers(case: cases.Case, monkeypatch: pytest.MonkeyPatch) -> None:
    found = case.reference()
    assert found.u.shape == found.v.shape == found.a.shape == (SAMPLES + 1, len(found.scene.u0))
    if case.name == "chain":  # whose energy changes; it starts at rest, and only loose tolerances follow it in a second
        monkeypatch.setattr(peers, "TOLERANCES", (1e-2,))
        (found_by,), _ = peers.peers(found, ("scipy DOP853",))
        (loose,) = peers.runs(found, found_by, every=1, repeats=1)
        assert loose.errors["u"].maximum < 0.02
        return
    np.testing.assert_allclose(found.scene.energy(found.t, found.u, found.v), found.scene.E0, rtol=1e-9)
    assert cases.span(found.scene) == case.t_end
    if case.name == "stiff":
        true = references.reference(found.scene, case.t_end, SAMPLES, 1e-12)
        off = measure.against(true, found.scene, found.u, found.v, found.a)
        assert off["angle"].maximum == pytest.approx(found.error, rel=0.02)
    monkeypatch.setattr(peers, "TOLERANCES", (1e-4, 1e-9))
    general, _ = peers.peers(found, ("scipy DOP853",))
    if case.name != "stiff":
        (loose, tight) = peers.runs(found, general[0], every=1, repeats=1)
        bound = 1e-2 if case.name == "swing" else 1e-6  # near the top an error grows a thousand times
        assert tight.errors["u"].maximum < bound
        assert loose.errors["u"].maximum > 1e-6
        assert tight.cost.evaluations > loose.cost.evaluations > 0


def test_missing_peers_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> Any:
        raise ModuleNotFoundError(f"No module named '{name}'")

    monkeypatch.setattr(peers, "import_module", absent)
    found, missing = peers.peers(cases.CASES[0].reference())
    assert not found
    assert list(missing) == ["scipy", "numbalsoda"]
    assert "No module named" in missing["scipy"]


def test_other_errors_of_peers_are_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    """A package that is there but not used as it should be is not "not installed"."""
    monkeypatch.setattr(peers, "import_module", lambda name: SimpleNamespace(__name__=name))
    with pytest.raises(AttributeError, match="lsoda_sig"):
        peers.peers(cases.CASES[0].reference(), ("numbalsoda lsoda",))


def test_the_fastest_of_a_kind() -> None:
    def point(kind: str, error: float, alone: float, together: float) -> crossover.Point:
        return crossover.Point(1e4, f"{kind}{error}", kind, 1, error, alone, together)

    found = [point("a", 1e-2, 1.0, 0.5), point("a", 1e-4, 2.0, 0.2), point("b", 1e-6, 0.1, 0.1)]
    assert crossover.least(found, 1e4, "a", 1e-2, together=False) == found[0]
    assert crossover.least(found, 1e4, "a", 1e-2, together=True) == found[1]
    assert crossover.least(found, 1e4, "a", 1e-5, together=True) is None
    assert crossover.least(found, 1e6, "a", 1e-2, together=True) is None


def test_where_solvers_overtake() -> None:
    def point(kind: str, error: float, alone: float, together: float) -> crossover.Point:
        return crossover.Point(1e4, kind, kind, 1, error, alone, together)

    mine = [point("second order", e, 1e-3 / e**0.5, 1e-4 / e**0.5) for e in crossover.ERRORS]
    theirs = [point("general solver", e, 0.05, 0.05) for e in crossover.ERRORS]
    assert crossover.overtaken([*mine, *theirs], 1e4, together=False) == pytest.approx(10**-3.5)  # 1e-3/sqrt(e) > 0.05
    assert crossover.overtaken([*mine, *theirs], 1e4, together=True) == pytest.approx(10**-5.5)
    assert crossover.overtaken(mine, 1e4, together=False) is None
    assert crossover.overtaken(theirs, 1e4, together=False) == pytest.approx(0.1)


def test_turning_points_are_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crossover, "STIFFNESSES", (1e4,))
    monkeypatch.setattr(crossover, "FINEST", 4)
    monkeypatch.setattr(crossover, "PEERS", ("scipy DOP853",))
    found, missing = crossover.points(("newmark_bdf2",), every=4, repeats=1)
    crossover.chart(found, missing, tmp_path)
    assert (tmp_path / "turning.png").stat().st_size > 10_000
    mine = [p for p in found if p.kind == "second order"]
    assert [p.steps for p in mine] == [SAMPLES, 16 * SAMPLES]
    assert all(0 < seconds < np.inf for p in mine for seconds in (p.alone, p.together))
    assert {p.method for p in found if p.kind == "general solver"} == {"scipy DOP853"}


@pytest.mark.thorough
def test_what_was_measured_can_be_drawn_by_another_process(tmp_path: Path) -> None:
    for case in (*cases.CASES, *cases.FURTHER):
        assert pickle.loads(pickle.dumps(case)).make().parameters == case.make().parameters
    case = replace(cases.CASES[0], finest=0)
    found = cases.runs(case, case.reference(), ["newmark", "bathe"], every=1, repeats=1)
    drawing = partial(charts.work_precision, case, case.reference(), found, [], [], {}, tmp_path)
    pickle.loads(pickle.dumps(drawing))()
    assert (tmp_path / "work_precision_linear.csv").read_text(encoding="utf-8").count("\n") == 3


def test_jobs_cover_every_case() -> None:
    names = [job.args[0].name for job in jobs.jobs(False) if isinstance(job, partial) and job.args]
    assert names == [case.name for case in cases.CASES]


@pytest.mark.parametrize("scheme", ss.schemes())
def test_operations_of_the_two_models(scheme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "schemes", lambda: (scheme,))
    rows = jobs.operations(tmp_path)
    assert [row[0] for row in rows] == [scheme]
    assert all(rigid < elastic for _, elastic, _, rigid in rows)
    assert len((tmp_path / "operations.csv").read_text().splitlines()) == 1 + len(rows)
