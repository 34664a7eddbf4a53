"""Audits: planted defects, each found once, as its root cause and as nothing else."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from audited_steppers import BETA, CHUNG, GAMMA, OPTIMAL, TRAPEZOIDAL, damped_by, generalized_alpha, trapezoidal_load
from substep_audit.claims import judged
from substep_audit.damping import identify_damped
from substep_audit.declared import declared
from substep_audit.exactness import exactness
from substep_audit.identify import Match, agreement, differing
from substep_audit.loads import LoadTaking, load_taking
from substep_audit.noise import QUIET
from substep_audit.orders import MOTIONS, observed_orders, written
from substep_audit.outputs import elsewhere, output_instants
from substep_audit.probes import driven_runs, given_runs, own_runs
from substep_audit.programs.adapter import Integrator

import substep as ss

pytestmark = pytest.mark.usefixtures("few_members")

CENTRAL = ss.Claims("newmark", order=2, parameters={"beta": 0.0, "gamma": 0.5})
HILBER = ss.Claims("generalized_alpha", parameters={"alpha_m": 0.0, "alpha_f": 0.1, "beta": 0.3025, "gamma": 0.6})


DEFECTS: dict[str, tuple[Callable[..., Any], ss.Claims, list[str], str]] = {
    "none": (generalized_alpha(*OPTIMAL, BETA, GAMMA), CHUNG, [], ""),
    "none, a0 given": (generalized_alpha(*OPTIMAL, BETA, GAMMA, sets_a0=True), CHUNG, [], ""),
    "beta 1 % off": (generalized_alpha(0, 0, 0.2525, 0.5), TRAPEZOIDAL, ["parameter"], "beta is 101/400, not 1/4"),
    "beta of a family 1 % off": (
        generalized_alpha(*OPTIMAL, 1.01 * BETA, GAMMA), CHUNG, ["parameter"], "beta is 101/324, not 25/81"
    ),
    "gamma of a family 1 % off": (
        generalized_alpha(*OPTIMAL, BETA, 1.01 * GAMMA), CHUNG, ["parameter"], "gamma is "
    ),
    "beta and gamma of a family swapped": (
        generalized_alpha(*OPTIMAL, GAMMA, BETA), CHUNG, ["parameter"], "beta and gamma are exchanged"
    ),
    "sign beside a whole number": (
        generalized_alpha(0, -0.1, 0.3025, 0.6), HILBER, ["parameter"], "alpha_f has the other sign"
    ),
    "load a quarter of a step late": (
        generalized_alpha(0, 0, 0.25, 0.5, late=0.25), TRAPEZOIDAL, ["load"], "f(t_n + 3/4 h)"
    ),
    "load half a step late": (
        generalized_alpha(*OPTIMAL, BETA, GAMMA, late=0.5), CHUNG, ["load"], "the load is that of 1/2 step before"
    ),
    "a0 is 0": (generalized_alpha(*OPTIMAL, BETA, GAMMA, start="zero"), CHUNG, ["start"], "is taken as 0"),
    "a0 without load": (
        generalized_alpha(*OPTIMAL, BETA, GAMMA, start="unloaded"), CHUNG, ["start"], "leaves out the load"
    ),
    "swapped": (generalized_alpha(*OPTIMAL[::-1], BETA, GAMMA), CHUNG, ["parameter"], "are exchanged"),
    "sign": (
        generalized_alpha(-OPTIMAL[0], OPTIMAL[1], BETA, GAMMA), CHUNG, ["parameter"], "alpha_m has the other sign"
    ),
    "other end": (
        generalized_alpha(OPTIMAL[0], 1 - OPTIMAL[1], BETA, GAMMA), CHUNG, ["parameter"], "weighs the other end"
    ),
    "rho_inf of a family": (
        generalized_alpha(4 / 17, 7 / 17, 100 / 289, 23 / 34), CHUNG, ["parameter"], "rho_inf is 7/10, not 4/5"
    ),
    "single precision": (
        generalized_alpha(*OPTIMAL, BETA, GAMMA, dtype=np.float32), CHUNG, ["precision"], "results hold 7 digits"
    ),
    "damping of the velocity before": (
        damped_by("start", 0, 0, 0.5), CENTRAL, ["damping"], "the damping force is that of the velocity at t_n"
    ),
    "damping of the predicted velocity": (
        damped_by("predicted", 0, 0, 0.5), CENTRAL, ["damping"], "the damping force is that of the predicted velocity"
    ),
    "damping of the velocity at the end": (
        damped_by("end", 0.1, 0.3025, 0.6), HILBER, ["damping"], "is that of the velocity at t_n + h"
    ),
    "mean load": (trapezoidal_load(0.5, 0, 0.5), TRAPEZOIDAL, ["load"], "1/2 f(t_n) + 1/2 f(t_n + h)"),
    "old load": (trapezoidal_load(1, 0, 0), TRAPEZOIDAL, ["load"], "the load is that of 1 step before: f(t_n)"),
    "three loads": (trapezoidal_load(0.25, 0.5, 0.25), TRAPEZOIDAL, ["load"], "1/2 f(t_n + 1/2 h)"),
}  # fmt: skip


@pytest.mark.members
@pytest.mark.matrix
@pytest.mark.parametrize("defect", DEFECTS)
def test_a_planted_defect_is_the_one_cause(defect):
    run, claims, kinds, text = DEFECTS[defect]
    report = ss.audit(run, claims)
    assert [deviation.kind for deviation in report.deviations] == kinds, report.text
    assert text in (report.deviations[0].text if kinds else "")


@pytest.mark.thorough
def test_a_scheme_that_is_one_without_damping_alone_is_named():
    stepper = ss.Stepper(damped_by("ahead", 0, 0, 0.5))
    own = own_runs(stepper, omegas=(0.3, 1.0, 3.0))
    found = identify_damped(own, own, CENTRAL.claimed_scheme())
    assert not found.matches and found.undamped[0].text == "newmark(beta = 0, gamma = 1/2)"
    (judgement,) = judged(CENTRAL, found, {}, np.inf, 2.0)[:1]
    assert judgement.verdict == "partly"


@pytest.mark.parametrize(
    ("alpha_f", "old", "taken"),
    [(0.0, 0.05, "1/20 f(t_n) + 19/20 f(t_n + h)"), (0.0, 0.0, "f(t_n + h)"), (1 / 3, 0.0, "f(t_n + 2/3 h)")],
)
def test_a_start_of_its_own_hides_neither_scheme_nor_load(alpha_f, old, taken):
    """Of a program that returns displacements only, whose first acceleration is neither that of balance nor zero."""
    beta, gamma = (1 + alpha_f) ** 2 / 4, 0.5 + alpha_f
    inner = generalized_alpha(0.0, alpha_f, beta, gamma, start="heavier", sets_a0=True)

    def run(omega, xi, dt, n, u0, v0, load, a0=None):
        def weighted(t):
            return old * load(t - dt) + (1 - old) * load(t) if t else load(0.0)

        u, _, _ = inner(omega, xi, dt, n, u0, v0, weighted, a0)
        return u, None, None

    stepper = ss.Stepper(run, Integrator(sets="uva", outputs="u"))
    scheme = ss.scheme("generalized_alpha", alpha_m=0.0, alpha_f=alpha_f, beta=beta, gamma=gamma)
    match = agreement(scheme, given_runs(stepper), own_runs(stepper))
    assert match is not None and (match.what, match.start, match.solved) == ("matrix", "own", 0)
    found = load_taking(match, driven_runs(stepper))
    assert (found.text, found.start) == (taken, "own") and found.error < 1e-10


@pytest.mark.thorough
@pytest.mark.parametrize("late", [0.3, -0.15])
def test_an_instant_of_the_load_that_is_not_asked_for_is_told_by_a_ramp(late):
    """Of a program that is handed the load otherwise than as a function."""
    steps = generalized_alpha(*OPTIMAL, BETA, GAMMA, late=late)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        return steps(omega, xi, dt, n, u0, v0, load.at)

    found = ss.audit(run, CHUNG).loads
    assert (found.kind, found.called) == ("shifted", ()) and found.shift == pytest.approx(-late, abs=1e-12)


def test_weights_at_many_instants_of_a_step_are_told_apart():
    """By fast sines: a constant, a ramp and two slow ones leave them undetermined, and other weights do the same."""
    steps, instants, weights = trapezoidal_load(0, 0, 1), (0, 1 / 3, 1 / 2, 2 / 3, 3 / 4, 1), (1, 2, -3, 4, 2, 4)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        def mean(t: float) -> float:
            return sum(w / 10 * load(t + (tau - 1) * dt) for w, tau in zip(weights, instants, strict=True))

        return steps(omega, xi, dt, n, u0, v0, lambda t: mean(t) if t else load(0.0))

    stepper = ss.Stepper(run)
    match = agreement(ss.scheme("average_acceleration"), own_runs(stepper), own_runs(stepper))
    assert match is not None and load_taking(match, driven_runs(stepper)).text == (
        "1/10 f(t_n) + 1/5 f(t_n + 1/3 h) + -3/10 f(t_n + 1/2 h) + 2/5 f(t_n + 2/3 h) + 1/5 f(t_n + 3/4 h) + "
        "2/5 f(t_n + h)"
    )


@pytest.mark.thorough
@pytest.mark.parametrize(("outputs", "sets"), [("uva", ""), ("u", "u")])
def test_a_late_load_of_a_program_that_starts_from_rest_is_not_blamed_on_the_scheme(outputs, sets):
    """Where v cannot be set, motion from it is superposed under a ramp, which a late load distorts."""
    steps = generalized_alpha(*OPTIMAL, BETA, GAMMA, late=0.5)
    report = ss.audit(ss.Stepper(steps, Integrator(sets=sets, outputs=outputs)), CHUNG)
    verdicts = {judgement.claim: judgement.verdict for judgement in report.judgements}
    assert verdicts == {"scheme": "true", "order": "false", "rho_inf": "true", "unconditional": "true"}, report.text
    (cause,) = report.deviations
    assert cause.text == "the load is that of 1/2 step before: f(t_n + 1/18 h)" and len(cause.consequences) == 2


@pytest.mark.thorough
def test_a_late_load_is_found_where_another_velocity_damps():
    """Of a program that is not asked for the load, and damps by the velocity at t_n."""
    steps, late = damped_by("start", 0, 0, 0.5), 0.3

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        return steps(omega, xi, dt, n, u0, v0, lambda t: load.at(t - late * dt if t else 0.0))

    report = ss.audit(run)
    assert report.matches[0].damping == "start"
    assert report.loads.kind == "shifted" and report.loads.shift == pytest.approx(-late, abs=1e-12)


def test_nothing_is_said_to_differ_where_all_steps_agree():
    newmark, trapezoidal = ss.scheme("newmark", beta=0.3), declared(ss.scheme("newmark"))
    own = own_runs(trapezoidal, omegas=(0.3, 1.0))
    assert differing(Match(ss.scheme("newmark"), "matrix", 0.0, "computed", 0), own, QUIET) == ""
    other = differing(Match(newmark, "matrix", 0.1, "computed", 0), own, QUIET)
    assert other == ", differs in u and v and a from Omega = 0.3 on; its eigenvalues too"


@pytest.mark.thorough
def test_consequences_stand_under_their_cause():
    report = ss.audit(generalized_alpha(*OPTIMAL[::-1], BETA, GAMMA), CHUNG)
    (cause,) = report.deviations
    found = ", ".join(f"{before}{motion}: 1" for before in ("", "undamped ") for motion in MOTIONS)
    assert cause.consequences == (f"order: claimed 2, found {found}",)
    verdicts = {judgement.claim: judgement.verdict for judgement in report.judgements}
    assert verdicts["scheme"] == verdicts["order"] == "false"


@pytest.mark.thorough
def test_one_changed_parameter_of_a_scheme_that_has_no_such_parameter_is_the_one_cause():
    """HHT decides beta by alpha; as a case of generalized-alpha it has one."""
    report = ss.audit(generalized_alpha(0, 0.1, 0.275, 0.6), ss.Claims("hht_alpha", parameters={"alpha": -0.1}))
    (cause,) = report.deviations
    assert cause.kind == "parameter" and cause.text.startswith("beta is 11/40, not 121/400 as hht_alpha("), cause


@pytest.mark.thorough
def test_orders_are_observed_damped_and_undamped_beside_the_claim():
    """Central differences with the damping force of the step before lose an order where there is damping."""
    report = ss.audit(declared(ss.scheme("central_difference_lagged")), ss.Claims(order=2))
    assert [report.orders[before + "free"][0] for before in ("", "undamped ")] == [1, 2]
    assert (
        report.judgements[0].verdict == "partly" and "free: u 1, v 1, a -; claimed 2, not that of u, v" in report.text
    )


@pytest.mark.thorough
def test_the_critical_Omega_is_measured_beside_that_of_the_scheme():
    """The average acceleration method, unstable at 15 < Omega < 90, where it is not probed otherwise."""
    steps = trapezoidal_load(0, 0, 1)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        growth = 1.5 if 15.0 < omega * dt < 90.0 else 1.0
        return steps(omega, xi, dt, n, u0, v0, load) * growth ** np.arange(n + 1)

    report = ss.audit(run)
    assert report.matches[0].scheme.name == "newmark" and report.critical_Omega is None
    assert report.measured_critical == pytest.approx(15.0, rel=1e-9)
    assert "stable up to Omega = 10^4 by the scheme, measured: unstable beyond 15" in report.text
    assert "(measured the same)" in ss.audit(generalized_alpha(0, 0, 0.0, 0.5)).text


@pytest.mark.parametrize("ignores", [True, False])
def test_a_given_acceleration_that_is_ignored_is_reported(ignores):
    steps = generalized_alpha(*OPTIMAL, BETA, GAMMA, sets_a0=True)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any, a0: Any = None) -> Any:
        return steps(omega, xi, dt, n, u0, v0, load, None if ignores else a0)

    report = ss.audit(run, CHUNG)
    assert report.ignores_a0 == ignores and not report.deviations
    assert ("start      acceleration at t = 0: computed; one that is given is ignored" in report.text) == ignores


@pytest.mark.parametrize(("noise", "guess"), [(1e-14, 0.0), (0.0, 1e-10)])
def test_a_given_acceleration_that_is_a_guess_at_most_is_ignored(noise, guess):
    """Of a program with additive noise, and of one that solves for the acceleration from it, to 10 digits."""
    steps, rng = generalized_alpha(0, 0, 0.25, 0.5, sets_a0=True), np.random.default_rng(0)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any, a0: Any = None) -> Any:
        first = load(0.0) - 2 * xi * omega * v0 - omega**2 * u0
        found = steps(omega, xi, dt, n, u0, v0, load, first + guess * ((a0 or 0.0) - first))
        return found + noise * rng.uniform(-1, 1, found.shape)

    report = ss.audit(run, ss.Claims("newmark", parameters={"beta": 0.25, "gamma": 0.5}))
    assert report.ignores_a0 and report.judgements[0].verdict == "true" and not report.deviations, report.text


def late_outputs(kind: str) -> ss.Stepper:
    """Central differences with velocities at half steps, or with the acceleration of the step before."""
    steps = generalized_alpha(0, 0, 0.0, 0.5)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        u, v, a = steps(omega, xi, dt, n, u0, v0, load)
        if kind == "a":
            return u, v, np.concatenate([a[:1], a[:-1]])
        return u, np.concatenate([v[:1], v[:-1] + dt / 2 * a[:-1]]), a

    return ss.Stepper(run)


LATE = [("v", -0.5), ("a", -1.0)]


@pytest.mark.parametrize(("kind", "instant"), LATE)
def test_outputs_that_stand_elsewhere_are_found(kind, instant):
    own = own_runs(late_outputs(kind), omegas=(0.3, 1.0))
    match = agreement(CENTRAL.claimed_scheme(), own, own)
    assert match is not None and match.what == "displacements"
    assert elsewhere(output_instants(match, own)) == {kind: instant}


@pytest.mark.thorough
@pytest.mark.parametrize(("kind", "instant"), LATE)
def test_outputs_that_stand_elsewhere_are_told_and_the_scheme_is_not_accused(kind, instant):
    report = ss.audit(late_outputs(kind), ss.Claims("newmark", parameters={"beta": 0.0, "gamma": 0.5}))
    assert report.judgements[0].verdict == "true" and report.instants == {kind: instant}
    (cause,) = report.deviations
    part = "1/2 step" if kind == "v" else "1 step"
    assert (cause.kind, cause.text) == ("output", f"{kind} stands {part} before the end of its step"), report.text


@pytest.mark.thorough
@pytest.mark.parametrize("claims", [ss.Claims("central_difference", order=2), None])
def test_a_leapfrog_with_the_acceleration_at_the_ends_is_no_other_scheme(claims):
    """But for the start, symplectic Euler takes the same steps of u, v and a; the late velocities explain the start."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        u, v, a = [u0], [v0 - dt / 2 * (load(0.0) - omega**2 * u0)], [load(0.0) - omega**2 * u0]
        for i in range(n):
            v.append(v[-1] + dt * a[-1])
            u.append(u[-1] + dt * v[-1])
            a.append(load((i + 1) * dt) - omega**2 * u[-1])
        return u, v, a

    report = ss.audit(ss.Stepper(run, Integrator(damping=False)), claims)
    assert "central_difference" in {match.scheme.name for match in report.matches}, report.text
    assert {judgement.verdict for judgement in report.judgements} <= {"true", "not stated"}
    assert report.instants == {"v": -0.5} and [cause.kind for cause in report.deviations] == ["output"], report.text


@pytest.mark.thorough
def test_a_first_step_that_is_wrong_is_the_cause_where_u_alone_is_returned():
    """A leapfrog that takes the velocity at t = 0 for that half a step before, as OpenSees does: symplectic Euler."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        u, v = [u0], v0
        for i in range(n):
            v += dt * (load(i * dt) - omega**2 * u[-1])
            u.append(u[-1] + dt * v)
        return u, None, None

    report = ss.audit(ss.Stepper(run, Integrator(outputs="u", damping=False)), ss.Claims("central_difference"))
    (cause,) = report.deviations
    assert cause.kind == "start" and report.judgements[0].verdict == "partly"
    assert cause.text.startswith("u obeys the recursion of central_difference; with the first steps it is tchamwa")


@pytest.mark.parametrize(
    ("histories", "text"),
    [
        (lambda n, u0: [np.full(n + 1, np.nan)] * 3, "expected finite displacements u from run after t = 0"),
        (lambda n, u0: (None, None, None), "expected finite displacements u from run after t = 0"),
        (lambda n, u0: (None, np.arange(n + 1), None), "return u, the first of the three histories"),
        (lambda n, u0: np.zeros((3, n + 1)), "got the same number at every step"),
        (lambda n, u0: np.full((3, n + 1), u0), "got the same number at every step"),
    ],
    ids=["not a number", "nothing", "velocities", "zeros", "constant"],
)
def test_histories_that_show_no_motion_are_refused_with_the_cure(histories, text):
    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        return histories(n, u0)

    with pytest.raises(ValueError, match=text):
        ss.audit(run, ss.Claims("newmark", order=2))


def test_nothing_that_is_finite_is_neither_exact_nor_of_an_order():
    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        return [np.full(n + 1, np.nan)] * 3

    stepper = ss.Stepper(run)
    assert exactness(own_runs(stepper), {}) is None
    assert all(written(order[0]) == "not measured" for order in observed_orders(stepper).values())


def test_no_load_is_found_where_the_load_moves_nothing():
    steps = generalized_alpha(0.0, 0.0, 0.25, 0.5)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        return steps(omega, xi, dt, n, u0, v0, lambda t: 0.0)

    stepper = ss.Stepper(run)
    match = agreement(ss.scheme("average_acceleration"), own_runs(stepper), own_runs(stepper))
    assert match is not None and load_taking(match, driven_runs(stepper)).kind == "unknown"


@pytest.mark.parametrize(
    ("kind", "called", "text"),
    [
        ("not sought", (), "not looked for without a scheme"),
        ("not sought", (0.0,), "not looked for without a scheme; asked for at the ends of steps"),
        ("unknown", (0.5,), "at no fixed instants that were found; asked for at 0.5 of a step"),
        ("unknown", (0.0, 0.25, 0.5), "were found; asked for at the ends of steps and 0.25, 0.5 of a step"),
        ("none", (), "takes no load"),
    ],
)
def test_what_is_said_of_a_load_tells_whether_it_was_looked_for(kind, called, text):
    assert LoadTaking(kind, called=called).text.endswith(text)
