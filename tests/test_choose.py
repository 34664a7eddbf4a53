"""Recommendations: they suffice, nothing cheaper does, and requests that cannot be met are reported."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from substep_derive import Scene as Declaration
from substep_derive.declare.scene import optional
from substep_derive.declare.symbols import rate
from sympy import Rational, symbols
from test_precision import KNOWN, integrated
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.exact import motions
from substep.studies.precision import cases, choose, measure, scene_choice
from substep.studies.step_counts import SAMPLES, ladder

AMONG = ("newmark_bdf2", "average_acceleration", "energy_momentum", "rk4")


def largest_error(scene: ss.Scene, run: measure.Run, t_end: float) -> float:
    """The largest error of u over the span, measured without the code under test: against DOP853."""
    times = np.linspace(0, t_end, SAMPLES + 1)
    if np.isfinite(run.tol):
        r = ss.march(scene, run.method, t_end=t_end, tol=run.tol, grid=times)
    else:
        r = ss.march(scene, run.method, t_end / run.steps, t_end, stride=run.steps // SAMPLES)
    if r.status != "completed":
        return np.inf
    u, _ = integrated(scene, times)
    return float(np.linalg.norm(r.u - u, axis=1).max() / np.linalg.norm(u, axis=1).max())


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("name", "t_end", "accuracy"), [("duffing", 0.3, 3e-3), ("elastic", 1.0, 1e-5)])
def test_what_is_recommended_suffices_and_nothing_cheaper_does(name: str, t_end: float, accuracy: float) -> None:
    scene, among = KNOWN[name], [ss.scheme(n) for n in AMONG]
    found = choose(scene, accuracy, t_end=t_end, among=among)
    best, next_ = found.best, found.runner_up
    assert best is not None
    assert next_ is not None
    assert largest_error(scene, best.run, t_end) <= accuracy
    assert largest_error(scene, next_.run, t_end) > accuracy
    assert next_.run.cost.operations < best.run.cost.operations
    for s in among:  # every step of the ladder that is cheaper was tried, and fails
        for steps in ladder():
            run = measure.measure(found.reference, s, steps, 0)
            if run.cost.operations >= best.run.cost.operations:
                break
            assert run.errors["u"].maximum > accuracy
            assert (s.name, steps) in {(c.run.method, c.run.steps) for c in found.candidates}


@pytest.mark.usefixtures("uncompiled")
def test_no_more_model_than_the_scene_needs(tmp_path: Path) -> None:
    """A rigid bar is off by twice the strain m v0^2/(EA L) that it leaves out, in any scheme and at any step."""
    stiff, among, t_end = ss.scene("elastic_pendulum", EA=1e7), [ss.scheme("energy_momentum")], 1.0
    lag = cases.lag(stiff, t_end)
    coarse, fine = (choose(stiff, x, t_end=t_end, quantity="angle", among=among) for x in (2 * lag, 0.5 * lag))
    assert coarse.best is not None
    assert fine.best is not None
    assert coarse.best.model.name == "rigid_pendulum"
    assert coarse.best.error == pytest.approx(lag, rel=0.3)
    assert fine.best.model is stiff
    assert "next cheaper" in fine.text
    charts_path = tmp_path / "why.1"
    scene_choice.chart(fine, charts_path)
    assert (tmp_path / "why.1.png").stat().st_size > 10_000
    own = Figure()
    assert scene_choice.choice_figure(fine, own.subplots()) is own
    assert own.axes[0].get_legend() is not None
    only_bar = choose(stiff, 2 * lag, t_end=t_end, quantity="angle", among=among, simpler=())
    assert only_bar.best is not None
    assert only_bar.best.model is stiff


@pytest.mark.usefixtures("uncompiled")
def test_steps_that_are_predicted_to_fail_are_not_run_and_do_fail() -> None:
    stiff, among = ss.scene("elastic_pendulum", EA=1e10), ["average_acceleration", "central_difference", "park"]
    found = choose(stiff, 2e-2, t_end=10.0, quantity="angle", among=among, simpler=(), chosen=[])
    trapezoidal = [u.steps for u in found.unmade if u.scheme.name == "average_acceleration"]
    assert trapezoidal
    assert {u.scheme.name for u in found.unmade} == {"average_acceleration", "central_difference"}
    assert not {c.run.method for c in found.candidates} & {"central_difference"}
    for steps in (trapezoidal[0], trapezoidal[-1]):
        run = measure.measure(found.reference, ss.scheme("average_acceleration"), steps, 0)
        assert run.errors["angle"].maximum > 1.0
        assert 10.0 / steps > 0.00933  # h^2 omega v0/L > 4
    assert "not run:" in found.text
    stiffest = ss.scene("elastic_pendulum", EA=1e14)  # with which no step of it is long enough to be affordable
    none = choose(stiffest, 2e-2, t_end=10.0, quantity="angle", among=["central_difference"], simpler=())
    assert (none.best, none.candidates) == (None, ())
    assert none.text.startswith("no candidate was run; not run: ")


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("after", "accuracy"), [(0, "1e-9"), (3, "1e-9"), (1, "1")])
def test_an_interrupted_search_says_what_was_tried(after: int, accuracy: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopping(*arguments: Any) -> measure.Run:
        nonlocal after
        after -= 1
        if after < 0:
            raise KeyboardInterrupt
        return measure.measure(*arguments)

    monkeypatch.setattr(scene_choice, "measure", stopping)
    command = ["choose", "duffing", "--accuracy", accuracy, "--t-end", "0.3", "--among", "bathe,rk4"]
    command += ["--chosen", "bathe"]
    tried, stopped = after, CliRunner().invoke(app, command)
    said = " ".join(stopped.output.split())
    assert stopped.exit_code == 130
    assert said.endswith("substep choose: interrupted; what was printed or written before is complete and kept")
    assert (f"interrupted after {tried} runs, of which these say:" in said) == (tried > 0)
    assert ("reference: " in said or "no candidate" in said) == (tried > 0)
    assert ("<= 1 over" in said) == (accuracy == "1")
    assert "nan" not in said  # no time was measured


@pytest.mark.usefixtures("uncompiled")
def test_requests_beyond_reach_and_wrong_requests(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_choice, "MOST_OPERATIONS", 2e3)
    found = choose(KNOWN["damped"], 1e-9, t_end=1.0, among=[ss.scheme("bathe")])
    assert found.best is None
    assert found.runner_up is None
    assert "no candidate" in found.text
    with pytest.raises(ValueError, match="quantity of duffing"):
        choose(KNOWN["duffing"], 1e-3, t_end=1.0, quantity="angle")
    with pytest.raises(ValueError, match="expected a scene by name, handle or declaration, got 3"):
        choose(3, 1e-3, t_end=1.0)  # pyright: ignore
    with pytest.raises(ValueError, match="expected a scheme by name, handle or declaration, got 3"):
        choose(KNOWN["duffing"], 1e-3, t_end=1.0, among=[3])  # pyright: ignore
    with pytest.raises(ValueError, match="accuracy > 0"):
        choose(KNOWN["duffing"], 0.0, t_end=1.0)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("start", [{"u0": 1.0}, {"u0": 0.0, "v0": 1.0}])
def test_an_error_of_phase_is_seen_at_whole_periods_too(start: dict[str, float]) -> None:
    scene, t_end = ss.scene("linear_oscillator", omega=2 * np.pi, **start), 1.0 * SAMPLES
    found = choose(scene, 1e-2, t_end=t_end, among=["average_acceleration"])
    assert found.best is not None
    r = ss.march(scene, found.best.scheme, found.best.run.dt, t_end)
    known = motions.motion(scene)
    assert known is not None
    should = known(r.t)[0]
    assert np.abs(r.u - should).max() <= 1.1e-2 * np.abs(should).max()


@pytest.mark.usefixtures("uncompiled")
def test_schemes_of_one_name_are_distinguished() -> None:
    among = [ss.scheme("newmark_bdf2", gamma_t=x) for x in (0.9, 0.5)]
    for order in (among, among[::-1]):
        found = choose(KNOWN["duffing"], 3e-3, t_end=0.3, among=order)
        assert found.best is not None
        again = measure.measure(found.reference, found.best.scheme, found.best.run.steps, 0)
        assert again.errors == found.best.run.errors
        assert again.errors["u"].maximum == found.best.error
        assert f"newmark_bdf2(gamma_t={found.best.scheme.parameters['gamma_t']}) on duffing" in found.text


@pytest.mark.usefixtures("uncompiled")
def test_among_takes_names_and_at_least_one() -> None:
    found = choose(KNOWN["duffing"], 3e-2, t_end=0.1, among=["rk4"])
    assert found.best is not None
    assert found.best.method == "rk4"
    with pytest.raises(ValueError, match="expected schemes to choose among, got none"):
        choose(KNOWN["duffing"], 3e-2, t_end=0.1, among=[])


@pytest.mark.usefixtures("plain_pairs", "plain_adaptive")
def test_a_scene_of_ones_own() -> None:
    x, k = symbols("x k")
    mine = Declaration(
        name="quartic_well", coordinates={x: "m"}, kinetic=rate(x) ** 2 / 2, potential=k * x**4 / 4,
        parameters=(optional(k, 3),), start={x: 1, rate(x): Rational(1, 2)}, length=1, reference="here",
    )  # fmt: skip
    scene, among = ss.scene(mine), [ss.scheme(n) for n in ("average_acceleration", "rk4")]
    found = choose(scene, 1e-4, t_end=4.0, among=among)
    assert found.best is not None
    assert "rk4" in found.reference.source
    assert any(c.tol is not None for c in found.candidates)
    assert largest_error(scene, found.best.run, 4.0) <= 1e-4
