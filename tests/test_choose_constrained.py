"""Choices with constraints: their references, the model that suffices, and what is left out."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import Scene as Declaration
from substep_derive import prescribed
from substep_derive.declare.scene import optional
from substep_derive.declare.symbols import rate
from sympy import Rational, cos, sin, symbols

import substep as ss
from substep.studies.precision import cases, charts, choose, jobs, measure, peers, scene_choice, stiffness
from substep.studies.precision import reference as references

AMONG = ("average_acceleration", "generalized_alpha", "bathe")
G, L, V0 = 9.81, 3.0443, 7.72


def swing(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x, y and the multiplier of `rod_pendulum` under gravity, from its angle, without the code under test."""
    r = solve_ivp(
        lambda _, y: (y[1], -G / L * np.cos(y[0])), (0, times[-1]), (0.0, V0 / L), "DOP853", times, rtol=1e-13,
        atol=1e-13,
    )  # fmt: skip
    angle, spin = r.y
    tension = 10.0 * (L * spin**2 - G * np.sin(angle))
    return L * np.stack([np.cos(angle), np.sin(angle)], axis=1), tension / L


@pytest.fixture
def rod() -> ss.Scene:
    return ss.scene("rod_pendulum", g=G)


def test_reference_with_constraints(rod: ss.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    found = references.reference(rod, 2.0, 50, 1e-11)
    u, multiplier = swing(found.t)
    np.testing.assert_allclose(found.u, u, rtol=0, atol=1e-10 * L)
    should = rod.multipliers(found.t, found.u, found.v)[:, 0]
    np.testing.assert_allclose(multiplier, should, rtol=0, atol=1e-9 * np.abs(should).max())
    assert found.source.startswith("DOP853")
    with pytest.raises(ValueError, match=r"without contacts, frictions .* got bouncing_ball with floor"):
        references.reference(ss.scene("bouncing_ball"), 1.0, 50, 1e-3)
    monkeypatch.setattr(references, "TOLERANCES", (1e-3, 1e-4))
    with pytest.raises(ValueError, match=r"that two runs of DOP853 over 2 s agree on to 1e-14"):
        references.reference(rod, 2.0, 4, 1e-14)


@pytest.mark.parametrize(
    "case",
    [*cases.CONSTRAINED[:-1], pytest.param(cases.CONSTRAINED[-1], marks=pytest.mark.thorough)],
    ids=lambda case: case.name,
)
def test_charts_with_constraints_have_references(case: cases.Case) -> None:
    found = case.reference()
    energy = found.scene.energy(found.t, found.u, found.v)
    assert np.ptp(energy) < 1e-9 * np.abs(found.scene.E0)
    left, rate, _ = found.scene.drift(found.t, found.u, found.v)
    assert np.abs(left).max() < 1e-10 * found.scene.length
    assert np.abs(rate).max() < 1e-10 * np.abs(found.v).max()
    assert cases.span(found.scene) == case.t_end
    if case.name == "squeezer":  # in arithmetic of 80 bits, of another program
        assert found.u[-1, :2] == pytest.approx([15.810771195153712, -15.756371058411845], abs=1e-9)
        multipliers = found.scene.multipliers(found.t, found.u, found.v)
        assert np.abs(multipliers[-1, :2]) == pytest.approx([199.17534810453844, 29.755309974971893], rel=1e-8)


@pytest.mark.usefixtures("uncompiled")
def test_errors_of_multipliers_have_the_derived_orders() -> None:
    """Those of Bathe's scheme are of first order as it solves for them, and of second from its u and v."""
    case = cases.CONSTRAINED[0]
    exact = case.reference()
    assert not cases.runs(case, exact, ["kr_alpha"], every=9, repeats=0)
    coarse, fine = (measure.measure(exact, ss.scheme("bathe"), n, 0) for n in (400, 800))
    own, found = (np.log2(coarse.errors[x].rms / fine.errors[x].rms) for x in (measure.OWN, "multipliers"))
    derived = prescribed("bathe").multiplier
    assert derived is not None
    assert own == pytest.approx(derived.power, abs=0.1)
    assert found == pytest.approx(2.0, abs=0.1)
    assert measure.failed(exact, exact.scene)[measure.OWN].maximum == np.inf


@pytest.mark.thorough
@pytest.mark.usefixtures("uncompiled")
def test_charts_with_constraints_are_drawn(tmp_path: Path) -> None:
    case = cases.CONSTRAINED[0]
    found = cases.runs(case, case.reference(), ["bathe", "energy_momentum"], every=4, repeats=1)
    assert peers.peers(case.reference()) == ([], {})
    charts.work_precision(case, case.reference(), found, [], [], {}, tmp_path)
    assert (tmp_path / "work_precision_rod_quantities.png").stat().st_size > 10_000
    head = (tmp_path / "work_precision_rod.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "own_multipliers_maximum" in head
    with pytest.raises(ValueError, match="a scene of the work-precision charts.*'rot'.*did you mean"):
        jobs.cases_named(["rot"])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("quantity", ["u", "multipliers"])
def test_what_is_recommended_for_a_constraint_suffices(rod: ss.Scene, quantity: str) -> None:
    found = choose(rod, 3e-4, t_end=1.0, quantity=quantity, among=[*AMONG, "kr_alpha"])
    assert found.best is not None
    assert found.runner_up is not None
    assert [reason[:8] for reason in found.left_out] == ["kr_alpha"]
    assert "left out: kr_alpha takes its coefficients from the structure" in found.text
    for candidate, suffices in ((found.best, True), (found.runner_up, False)):
        steps = candidate.run.steps
        r = ss.march(rod, candidate.scheme, 1.0 / steps, 1.0, stride=steps // 50)
        u, multiplier = swing(r.t)
        exact, mine = (u, r.u) if quantity == "u" else (multiplier[:, None], r.multipliers["rod"][:, None])
        error = np.linalg.norm(mine - exact, axis=1).max() / np.linalg.norm(exact, axis=1).max()
        assert error == pytest.approx(candidate.error, rel=1e-3)
        assert (error <= 3e-4) == suffices
    with pytest.raises(ValueError, match="kr_alpha takes its coefficients"):
        choose(rod, 1e-3, t_end=1.0, among=["kr_alpha"])


@pytest.mark.usefixtures("uncompiled")
def test_a_rod_replaces_a_bar_where_its_strain_does_not_matter() -> None:
    """The rod, a constraint, is off by the lag that it has not, and is left out where that is more than is wished."""
    stiff, t_end = ss.scene("elastic_pendulum", EA=1e7), 1.0
    lag = cases.lag(stiff, t_end)
    coarse, fine = (choose(stiff, x * lag, t_end=t_end, among=["bathe"], chosen=[]) for x in (10.0, 0.5))
    assert coarse.best is not None
    assert fine.best is not None
    assert coarse.best.model.name == "rod_pendulum"
    assert fine.best.model is stiff
    assert not coarse.left_out
    (reason,) = fine.left_out
    assert reason.startswith("rod_pendulum differs from elastic_pendulum by ")
    assert float(reason.split()[-1]) == pytest.approx(lag, rel=0.3)


@pytest.mark.usefixtures("plain_pairs")
def test_fewer_coordinates_replace_a_constraint_in_what_both_have(rod: ss.Scene) -> None:
    phi, length = symbols("phi L")
    angle = ss.scene(
        Declaration(
            "swing", coordinates={phi: "rad"}, kinetic=5 * length**2 * rate(phi) ** 2,
            potential=Rational("98.1") * length * sin(phi), parameters=(optional(length, Rational("3.0443")),),
            start={phi: 0, rate(phi): Rational("7.72") / length}, length=1,
            outputs={"x": length * cos(phi), "y": length * sin(phi)}, reference="here",
        )
    )  # fmt: skip
    assert measure.shared(rod, angle) == ("angle", "x", "y")
    found = choose(rod, 1e-3, t_end=1.0, quantity="y", simpler=[angle], among=AMONG[:1], chosen=[])
    assert found.best is not None
    assert found.best.model is angle
    r = ss.march(angle, AMONG[0], 1.0 / found.best.run.steps, 1.0)
    y = swing(r.t)[0][:, 1]
    assert np.abs(r.outputs["y"] - y).max() <= 1.1e-3 * np.abs(y).max()
    other = choose(rod, 1e-3, t_end=1.0, simpler=[angle], among=AMONG[:1], chosen=[])
    assert other.left_out == ("swing has no u to compare",)


@pytest.mark.usefixtures("uncompiled")
def test_chosen_steps_with_constraints_are_counted(rod: ss.Scene) -> None:
    found = choose(rod, 1e-2, t_end=0.3, among=["bathe"], chosen=["bathe"])
    assert found.best is not None
    one = next(c for c in found.candidates if c.tol is not None)
    r = ss.march(rod, "bathe", t_end=0.3, tol=one.tol, grid=found.reference.t)
    assert r.statistics is not None
    made = 1.5 * (r.statistics.accepted + r.statistics.rejected)  # two halves and a whole step
    each = measure.pair_kernels(rod, ss.scheme("bathe")).OPERATIONS
    mean = np.array(r.statistics.newton_iterations) / r.statistics.accepted
    assert one.run.cost.operations == pytest.approx(made * (each["step"] + mean @ each["iteration"]), rel=1e-2)
    assert one.run.cost.solves == pytest.approx(made * mean.sum(), rel=1e-2)
    with pytest.raises(ValueError, match="whose state is u, v, a at t_n alone"):
        choose(rod, 1e-2, t_end=0.3, among=["bathe"], chosen=["bdf2"])
    assert scene_choice.choice_figure(found) is not None


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("drawn", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_the_chart_of_three_models(drawn: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = (("angle", 1e-2), ("u", 1e-2))
    for name, x in (("T_END", 1.0), ("STEPS", 100), ("WISHED", 1e-2), ("ASKED", asked)):
        monkeypatch.setattr(stiffness, name, x)
    found = stiffness.measured([1e4, 1e6], [ss.scheme("average_acceleration")], repeats=0)
    lags = {EA: 2.0 * 10.0 * V0**2 / (EA * L) * V0 / L for EA in (1e4, 1e6)}  # 0.099 and 0.00099 rad
    assert dict(found.lags) == pytest.approx(lags)
    own = {(x.EA, x.model): x.error for x in found.points}
    assert own[1e4, "rigid_pendulum"] == pytest.approx(lags[1e4], rel=0.2)
    assert own[1e6, "rigid_pendulum"] == pytest.approx(lags[1e6], rel=0.2)
    assert {x.model for x in found.cheapest if x.EA == 1e4} == {"elastic_pendulum"}
    assert {x.model for x in found.cheapest if x.EA == 1e6} == set(stiffness.MODELS)
    chosen = {(q, EA): c.model.name for (q, _), pairs in found.chosen.items() for EA, c in pairs}
    assert chosen == {
        ("angle", 1e4): "elastic_pendulum", ("u", 1e4): "elastic_pendulum",
        ("angle", 1e6): "rigid_pendulum", ("u", 1e6): "rod_pendulum",
    }  # fmt: skip
    if not drawn:
        return
    stiffness.chart(found, tmp_path)
    assert (tmp_path / "models.png").stat().st_size > 10_000
    rows = list(csv.reader((tmp_path / "models.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 1 + len(found.points) + len(found.cheapest) + 4
