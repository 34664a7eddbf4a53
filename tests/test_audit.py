"""Audits: which scheme a stepper is, found blind, how it takes the load, and what a report says."""

import json
import re
from dataclasses import replace
from html import unescape
from typing import Any

import numpy as np
import pytest
from audited_steppers import TRAPEZOIDAL, generalized_alpha, trapezoidal_load
from declared import BY_NAME, ONE_BY_ONE, random_parameters
from dense_steps import march
from nonlinear_oracle import System, history
from substep_audit import instrument
from substep_audit.claims import judged
from substep_audit.declared import declared
from substep_audit.exactness import exactness
from substep_audit.identify import Identification, identify
from substep_audit.loads import load_taking
from substep_audit.measured_stability import critical_Omega, long_radius, measured_radius, overshoot
from substep_audit.members import with_all_members
from substep_audit.nonlinear import split
from substep_audit.orders import observed_orders, written
from substep_audit.probes import OMEGAS, RATIOS, driven_runs, own_runs
from substep_audit.programs.adapter import Integrator, Spring
from substep_audit.stepper import as_stepper
from substep_derive.declare.symbols import Symbol

import substep as ss

pytestmark = pytest.mark.usefixtures("few_members")


def densely_stepped(name: str, values: dict[str, Any]) -> ss.Stepper:
    """A scheme stepped from the equations of its declaration, which shares nothing with the plans.

    Under a spring the steps are those written by hand.
    """
    declaration = BY_NAME[name]
    symbols: dict[Symbol, Any] = {p.symbol: float(values[p.name]) for p in declaration.parameters}

    def run(
        omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any, force: Spring | None = None
    ) -> Any:
        if force is not None:
            return under_spring(name, {key: float(x) for key, x in values.items()}, force, dt, n, u0, v0)
        C, K = np.array([[2 * xi * omega]]), np.array([[omega**2]])
        f = lambda t: np.array([load(t)])  # noqa: E731
        rows = march(declaration, symbols, np.eye(1), C, K, f, dt, n, np.array([u0]), np.array([v0]))
        return np.array(rows)[..., 0].T if len(rows[-1]) == 3 else [*np.array([r[:2] for r in rows])[..., 0].T, None]

    return ss.Stepper(run, ss.Integrator(damping=declaration.takes_damping, nonlinear=True), name)


def under_spring(
    name: str, values: dict[str, float], force: Spring, dt: float, n: int, u0: float, v0: float
) -> list[np.ndarray]:
    """u, v, a of a unit mass on a spring, undamped, from its own acceleration."""
    system = System(
        np.eye(1), np.zeros((1, 1)), force, lambda u: np.diag(force.slope(u)),
        discrete_gradient=lambda u, w: (u + w) * (force.stiffness / 2 + force.cubic / 4 * (u * u + w * w)),
    )  # fmt: skip
    start = system.acceleration(np.array([u0]), np.array([v0]), 0.0)
    return [x[:, 0] for x in history(name, values, system, dt, n, [u0], [v0], start)]


@pytest.mark.parametrize("name", [s.name for s in ONE_BY_ONE])
def test_every_scheme_is_found_blind(name):
    """With random parameters; whatever is named does the same from starts and at frequencies that were not probed.

    Under a cubic spring what stays named does the same with one that was not probed, and what does not, does not.
    """
    values = random_parameters(BY_NAME[name], np.random.default_rng(5))
    stepper = densely_stepped(name, values)
    own = own_runs(stepper)
    matches = identify(own, own).matches
    assert name in {match.scheme.name for match in matches}
    for match in matches:
        assert match.what == "matrix" and match.error < 1e-10
        same = densely_stepped(match.scheme.name, {k: float(x) for k, x in match.scheme.parameters.items()})
        for omega, xi in ((0.7, 0.0), (5.3, 0.2 if stepper.can.damping else 0.0)):
            theirs, ours = (s.run(omega, xi, 0.5, 8, 1.0, 0.3, lambda t: 0.0)[0] for s in (stepper, same))
            np.testing.assert_allclose(ours, theirs, rtol=1e-7, atol=1e-8 * np.abs(theirs).max())
    found = split(Identification(matches), stepper, own)
    assert found.nonlinear is not None and found.nonlinear < 1e-9
    assert name in {match.scheme.name for match in found.matches}
    assert {match.scheme.name for match in matches} <= {match.scheme.name for match in found.on_linear}
    if len(found.on_linear) > 1:
        given = (Spring(1.3, 0.8), 0.4, 10, 0.9, -0.6)
        theirs = under_spring(name, {k: float(x) for k, x in values.items()}, *given)[0]
        for match in found.on_linear:
            ours = under_spring(match.scheme.name, {k: float(x) for k, x in match.scheme.parameters.items()}, *given)[0]
            off = np.abs(ours - theirs).max()
            assert off < 1e-8 if match in found.matches else off > 1e-6


@pytest.mark.parametrize(
    ("name", "members"),
    [
        ("average_acceleration", ["newmark", "theta_method", "hht_alpha", "wbz_alpha", "oalts", "generalized_alpha"]),
        ("central_difference", ["newmark", "collocation"]),
        ("backward_euler", ["theta_method"]),
    ],
)
def test_all_members_of_a_class_are_named(name, members):
    """Also those with more parameters than the first match; each steps as the scheme does, by its declaration."""
    stepper = densely_stepped(name, random_parameters(BY_NAME[name], np.random.default_rng(5)))
    own = own_runs(stepper)
    first = identify(own, own)
    found = with_all_members(first, own, own)
    assert found.matches[: len(first.matches)] == first.matches
    assert set(members) <= {match.scheme.name for match in found.matches}
    theirs = stepper.run(5.3, 0.2, 0.5, 8, 1.0, 0.3, lambda t: 0.0)[0]
    for match in found.matches:
        same = densely_stepped(match.scheme.name, {k: float(x) for k, x in match.scheme.parameters.items()})
        ours = same.run(5.3, 0.2, 0.5, 8, 1.0, 0.3, lambda t: 0.0)[0]
        np.testing.assert_allclose(ours, theirs, rtol=1e-7, atol=1e-8 * np.abs(theirs).max())


@pytest.mark.members
def test_another_nonlinear_form_of_the_claimed_scheme_is_named_and_not_accused():
    """A manual that says HHT does not say whether the force is that of the mixed displacement."""
    values = {"alpha": -0.1}
    report = ss.audit(
        densely_stepped("hht_alpha_mixed_displacement", values), ss.Claims("hht_alpha", parameters=values)
    )
    mixed = ["hht_alpha_mixed_displacement", "gssss_u0", "generalized_alpha_mixed_displacement"]  # one and its families
    assert [match.scheme.name for match in report.matches] == mixed
    assert [match.scheme.name for match, _ in report.found.apart] == ["hht_alpha", "alpha_os", "generalized_alpha"]
    assert report.judgements[0].verdict == "true" and not report.deviations
    assert "nonlinear  not hht_alpha(" in report.text


@pytest.mark.thorough
def test_a_force_that_is_taken_in_no_declared_way_is_told_and_all_names_are_kept():
    """The average acceleration method with one iteration of Newton's from the tangent at t_n."""
    steps = trapezoidal_load(0, 0, 1)

    def run(omega, xi, dt, n, u0, v0, load, force=None):
        if force is None:
            return steps(omega, xi, dt, n, u0, v0, load)
        x = np.zeros((n + 1, 3))
        x[0] = u0, v0, -force(u0)
        for i, (u, v, a) in enumerate(x[:-1]):
            p, q = u + dt * v + dt**2 / 4 * a, v + dt / 2 * a
            z = -(force(u) + force.slope(u) * (p - u)) / (1 + dt**2 / 4 * force.slope(u))
            x[i + 1] = p + dt**2 / 4 * z, q + dt / 2 * z, z
        return x.T

    report = ss.audit(ss.Stepper(run, ss.Integrator(nonlinear=True)), TRAPEZOIDAL)
    assert {match.scheme.name for match in report.matches} >= {"newmark", "energy_momentum"}
    assert report.found.nonlinear is not None and report.found.nonlinear > 1e-3
    assert "nonlinear  none of these under a cubic spring: off by" in report.text
    assert not report.deviations


@pytest.mark.parametrize("name", [s.name for s in ONE_BY_ONE])
def test_every_scheme_takes_the_load_as_declared(name):
    values = random_parameters(BY_NAME[name], np.random.default_rng(6))
    stepper = densely_stepped(name, values)
    own = own_runs(stepper, omegas=(0.3, 1.0, 3.0))
    scheme = ss.scheme(name, **{k: float(x) for k, x in values.items() if k not in ss.scheme(name).info.decided})
    (match,) = identify(own, own, scheme).matches[:1]
    found = load_taking(match, driven_runs(stepper))
    assert match.scheme.name == name
    assert (found.kind, found.start) == ("declared", "computed") and found.error < 1e-10


@pytest.mark.thorough
def test_what_is_no_scheme_is_not_given_a_name(monkeypatch):
    """A step of the trapezoidal rule with a stiffness that grows with the step is in no family."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        u, v = [u0], [v0]
        k, c = omega**2 * (1 + 0.1 * np.tanh(omega * dt)), 2 * xi * omega
        for i in range(n):
            force = load((i + 0.5) * dt)
            new = (v[-1] + dt * (force - k * (u[-1] + dt / 4 * v[-1]) - c * v[-1] / 2)) / (
                1 + c * dt / 2 + k * dt**2 / 4
            )
            u.append(u[-1] + dt / 2 * (v[-1] + new))
            v.append(new)
        return u, v, None

    report = ss.audit(ss.Stepper(run, ss.Integrator(outputs="uv"), "stiffening"))
    assert not report.matches and report.identified.startswith("none of the catalogue; nearest: ")
    assert "differs in u and v from Omega = 0.1 on; its eigenvalues too" in report.identified
    assert not report.deviations  # nothing is claimed
    # which takes long where there is no scheme
    monkeypatch.setattr(instrument, "identify_damped", lambda *_: report.found)
    (deviation,) = ss.audit(report.stepper, ss.Claims("newmark", order=2, rho_inf=1.0)).deviations
    assert deviation.text.startswith("it is not newmark, nor any scheme of the catalogue")


def test_what_overflows_diverges_and_what_has_few_digits_is_not_measured():
    """Neither is exact, and no claim is judged by it."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        return [u0, *[np.inf] * n], None, None

    overflowing = observed_orders(ss.Stepper(run, Integrator(outputs="u")))
    assert {written(order[0]) for order in overflowing.values()} == {"diverges"}
    coarse = replace(as_stepper(trapezoidal_load(0, 0, 1)), can=Integrator(digits=4.0))
    orders = observed_orders(coarse)
    assert {written(order[0]) for order in orders.values()} == {"not measured"}
    found = judged(ss.Claims(order=2, critical_Omega=2.0), Identification(()), orders, 1.0, None)
    assert [(judgement.claim, judgement.verdict) for judgement in found] == [
        ("order", "not judged"), ("critical_Omega", "false"), ("scheme", "not stated"), ("damping", "not stated"),
    ]  # fmt: skip
    assert found[-1].text == "damping: not stated (rho_inf = 1)"


@pytest.mark.parametrize(
    ("name", "values", "silent"),
    [("bathe", {}, ("damping", "stability")), ("generalized_alpha", {"rho_inf": 0.7}, ("stability",))],
)
def test_the_march_itself_is_found(name, values, silent):
    """The claims are those of the scheme, its parameters and its order; the rest is not stated."""
    scheme = ss.scheme(name, **values)

    def run(omega, xi, dt, n, u0, v0, load):
        scene = ss.scene("linear_oscillator", omega=omega, xi=xi, u0=u0, v0=v0, load=np.vectorize(load))
        r = ss.march(scene, scheme, dt, n * dt)
        return r.u, r.v, r.a

    report = ss.audit(run, ss.Claims(name, parameters=values, order=2))
    assert report.matches[0].scheme == scheme and not report.deviations
    verdicts = {judgement.claim: judgement.verdict for judgement in report.judgements}
    assert verdicts == dict.fromkeys(("scheme", "order"), "true") | dict.fromkeys(silent, "not stated")


def test_an_exact_stepper_is_called_so():
    from scipy.signal import lsim

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any, linear: bool = True) -> Any:
        t = dt * np.arange(n + 1)
        f = np.array([load(x) for x in t])
        system = ([[0.0, 1.0], [-(omega**2), -2 * xi * omega]], [[0.0], [1.0]], np.eye(2), np.zeros((2, 1)))
        rows = lsim(system, f, t, [u0, v0], interp=linear)[1]
        return *rows.T, f - 2 * xi * omega * rows[:, 1] - omega**2 * rows[:, 0]

    for linear, load in ((True, "linear over a step"), (False, "constant over a step")):
        stepper = ss.Stepper(lambda *args, linear=linear, **named: run(*args, linear=linear, **named))
        assert exactness(own_runs(stepper), driven_runs(stepper)) == load
    late = ss.Stepper(lambda *args, load: run(*args, load=lambda t: load.at(t - 0.1)))
    assert exactness(own_runs(late), driven_runs(late)) == "otherwise"
    assert exactness(own_runs(ss.Stepper(trapezoidal_load(0, 0, 1))), {}) is None


def test_a_program_that_stops_at_some_frequencies_is_audited_on_the_others():
    steps = generalized_alpha(0.0, 0.0, 0.25, 0.5)

    def brittle(omega, xi, dt, n, u0, v0, load):
        if omega * dt > 2.0 and xi > 0:
            raise ArithmeticError("no convergence")
        return steps(omega, xi, dt, n, u0, v0, load)

    report = ss.audit(brittle, TRAPEZOIDAL)
    assert report.matches[0].text == "newmark(beta = 1/4, gamma = 1/2)"
    assert not report.deviations
    stopped = {(Omega, xi) for Omega, xi, _ in report.failed}
    assert stopped == {(Omega, xi) for Omega in OMEGAS if Omega > 2.0 for xi in RATIOS if xi > 0}
    assert all("no convergence" in error for *_, error in report.failed)
    assert "not run    at Omega = 3, xi = 0.05: expected histories from brittle" in report.text
    assert len(report.to_dict()["not_run"]) == len(stopped)


@pytest.mark.parametrize("growing", [False, True])
def test_stability_is_not_known_where_undamped_runs_stop(growing):
    """The average acceleration method, which stops above Omega = 50; growing: unstable from Omega = 15 on before."""
    steps = generalized_alpha(0.0, 0.0, 0.25, 0.5)

    def brittle(omega, xi, dt, n, u0, v0, load):
        if omega * dt > 50.0:
            raise ArithmeticError("no convergence")
        growth = 1.5 if growing and omega * dt > 15.0 else 1.0
        return np.array(steps(omega, xi, dt, n, u0, v0, load)) * growth ** np.arange(n + 1)

    stepper = ss.Stepper(brittle)
    for radius, margin in ((measured_radius(stepper), 1e-6), (long_radius(stepper), 0.02)):
        critical = critical_Omega(radius, margin)
        assert critical == pytest.approx(15.0, rel=1e-9) if growing else np.isnan(critical)
    assert np.isnan(measured_radius(stepper)(np.array([1.0, 60.0]))).tolist() == [False, True]
    assert overshoot(stepper) == "U?-V?"
    if not growing:
        verdicts = judged(ss.Claims(rho_inf=1.0, unconditional=True), Identification(()), {}, np.nan, np.nan)
        assert {j.verdict for j in verdicts if j.claimed} == {"not judged"}
        report = ss.audit(stepper, TRAPEZOIDAL)
        assert not report.deviations and report.matches[0].scheme.name == "newmark"
        assert "not known, as runs fail" in report.stable and {Omega for Omega, *_ in report.failed} == {100.0, 1e4}
        assert all(np.isfinite(curve.radius).all() for curve in report.curves)


@pytest.mark.members
def test_a_report_is_text_json_and_a_page(tmp_path):
    report = ss.audit(trapezoidal_load(1, 0, 0), TRAPEZOIDAL)
    assert report.identified.startswith("newmark(beta = 1/4, gamma = 1/2) = average_acceleration = energy_momentum = ")
    assert report.identified.endswith(f", all entries to {report.matches[0].error:.0e}")
    assert "departs    load: the load is that of 1 step before: f(t_n)" in report.text
    read = json.loads(report.to_json())
    assert read["deviations"][0]["kind"] == "load" and read["matches"][0]["scheme"] == "newmark"
    page = report.to_html(tmp_path / "report.html").read_text()
    assert "<svg" in page and "the load is that of 1 step before" in page
    shown = unescape(re.sub(r"<[^>]+>", "", page))
    assert all(label in shown and text in shown for label, text in report.facts)
    assert all(text in report.text for _, text in report.facts)
    assert all(j.found in shown and j.verdict in shown and j.text in report.text for j in report.judgements)
    assert len(read["curves"]) == len(report.curves) and read["curves"][0]["radius"] == report.curves[0].radius.tolist()


def test_wrong_steppers_are_refused_with_the_cure():
    with pytest.raises(ValueError, match="expected a function run"):
        ss.audit(3)
    with pytest.raises(ValueError, match="got ZeroDivisionError.*cure the adapter"):
        ss.audit(lambda omega, xi, dt, n, u0, v0, load: 1 / 0)
    with pytest.raises(ValueError, match=r"expected u, v and a with 13 numbers.*got \[12, 12, 12\]"):
        ss.audit(lambda omega, xi, dt, n, u0, v0, load: (np.ones(n), np.ones(n), np.ones(n)))
    with pytest.raises(ValueError, match="expected a parameter of newmark"):
        ss.audit(trapezoidal_load(0, 0, 1), ss.Claims("newmark", parameters={"alpha": 1.0}))
    with pytest.raises(ValueError, match="expected a program with an adapter"):
        ss.Program("none")


@pytest.mark.parametrize(("name", "given"), [("generalized_alpha", {"rho_inf": 0.8}), ("bathe", {}), ("rk4", {})])
def test_rho_inf_is_that_of_the_scheme_and_the_measured_one_is_beside_it(name: str, given: dict[str, float]) -> None:
    s = ss.scheme(name, **given)
    report = ss.audit(declared(s))
    assert report.rho_inf == {"generalized_alpha": 0.8, "bathe": 0.0, "rk4": np.inf}[name]
    near = float(s.spectral_radius(1e4))
    assert report.measured_rho_inf == (pytest.approx(near, rel=1e-6) if near <= 1 else np.inf)  # whose runs overflow
    assert f"rho_inf = {report.rho_inf:.4g} ({report.measured_rho_inf:.4g} measured at Omega = 10^4)" in report.text
    found = report.to_dict()
    assert float(found["measured_rho_inf"]) == report.measured_rho_inf
