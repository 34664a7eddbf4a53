"""Audits of noisy programs: nothing within the noise is held against them, and what is beyond it is still found."""

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from audited_steppers import BETA, CHUNG, GAMMA, OPTIMAL, TRAPEZOIDAL, generalized_alpha
from substep_audit.declared import declared
from substep_audit.identify import Identification, agreement, identify
from substep_audit.loads import load_taking
from substep_audit.members import with_all_members
from substep_audit.noise import measured_noise
from substep_audit.probes import driven_runs, own_runs
from substep_audit.report import Report

import substep as ss

pytestmark = pytest.mark.usefixtures("few_members")

SCHEMES = ("newmark", "generalized_alpha", "bathe", "central_difference", "houbolt", "rk4")


def printed(stepper: ss.Stepper, write: Callable[[float], str], digits: float = 15.0) -> ss.Stepper:
    """What a program returns, read from what it prints."""

    def run(*args: Any, load: Any) -> Any:
        return [None if x is None else [float(write(y)) for y in x] for x in stepper.run(*args, load=load)]

    return ss.Stepper(run, replace(stepper.can, sets="uv", digits=digits))


def loose(parameters: tuple[float, ...], relative: float, seed: int) -> ss.Stepper:
    """Generalized-alpha that goes on from a state of which each entry is off by a random relative error."""
    rng, step = np.random.default_rng(seed), generalized_alpha(*parameters, sets_a0=True)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        rows = [np.array([u0, v0, load(0.0) - 2 * xi * omega * v0 - omega**2 * u0])]
        for i in range(n):
            u, v, a = rows[-1]
            after = step(omega, xi, dt, 1, u, v, lambda t, i=i: load(i * dt + t), a)[:, 1]
            rows.append(after * (1 + relative * rng.uniform(-1, 1, 3)))
        return np.array(rows).T

    return ss.Stepper(run)


def nothing_false(report: Report) -> None:
    assert {deviation.kind for deviation in report.deviations} <= {"precision"}, report.text
    assert not {"false", "partly"} & {judgement.verdict for judgement in report.judgements}, report.text


@pytest.mark.matrix(13)
@pytest.mark.parametrize("digits", [7, 5, 4, 3])
@pytest.mark.parametrize("name", SCHEMES)
def test_printed_digits_are_counted_and_not_held_against_the_scheme(name, digits):
    scheme = ss.scheme(name)
    limited = scheme.critical_Omega is not None and np.isfinite(scheme.critical_Omega)
    claims = ss.Claims(name, order=4 if name == "rk4" else 2, unconditional=not limited)
    report = ss.audit(printed(declared(scheme), f"{{:.{digits - 1}e}}".format), claims)
    nothing_false(report)
    assert report.matches[0].scheme.name == name and report.judgements[0].verdict == "true"
    assert report.noise.digits in (digits - 1, digits) and not report.noise.absolute
    assert f"digits     results repeat to {report.noise.digits} digits of the state" in report.text


def test_decimals_that_do_not_shrink_with_the_state_are_told_from_digits():
    stepper = printed(declared(ss.scheme("bathe")), "{:.6f}".format)
    report = ss.audit(stepper, ss.Claims("bathe", order=2, unconditional=True))
    nothing_false(report)
    assert report.noise.absolute and report.noise.digits == 6 and report.matches[0].scheme.name == "bathe"


def test_declared_digits_are_no_deviation():
    assert not ss.audit(printed(declared(ss.scheme("bathe")), "{:.3e}".format, 3.0), ss.Claims("bathe")).deviations


@pytest.mark.thorough
@pytest.mark.matrix
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("relative", [1e-6, 1e-4, 1e-3])
def test_an_error_in_each_step_is_not_held_against_the_scheme(relative, seed):
    for parameters, claims in (((*OPTIMAL, BETA, GAMMA), CHUNG), ((0, 0, 0.25, 0.5), TRAPEZOIDAL)):
        stepper = loose(parameters, relative, seed)
        report = ss.audit(stepper, claims)
        nothing_false(report)
        assert report.judgements[0].verdict == "true" and report.noise.size > relative
        nothing_false(ss.audit(stepper, ss.Claims(order=2, rho_inf=claims.rho_inf, unconditional=True)))


PLANTED = {
    "beta 1 % off": ((0, 0, 0.2525, 0.5), {}, TRAPEZOIDAL, 5, "parameter", "beta is 101/400, not 1/4"),
    "beta 10 % off": ((0, 0, 0.275, 0.5), {}, TRAPEZOIDAL, 3, "parameter", "beta is 11/40, not 1/4"),
    "swapped": ((*OPTIMAL[::-1], BETA, GAMMA), {}, CHUNG, 4, "parameter", "alpha_f and alpha_m are exchanged"),
    "sign": ((-OPTIMAL[0], OPTIMAL[1], BETA, GAMMA), {}, CHUNG, 3, "parameter", "alpha_m has the other sign"),
    "late": ((*OPTIMAL, BETA, GAMMA), {"late": 0.5}, CHUNG, 4, "load", "the load is that of 1/2 step before"),
    "a0 is 0": ((*OPTIMAL, BETA, GAMMA), {"start": "zero"}, CHUNG, 4, "start", "is taken as 0"),
}


@pytest.mark.thorough
@pytest.mark.matrix
@pytest.mark.parametrize("defect", PLANTED)
def test_a_planted_defect_beyond_the_noise_is_the_one_cause(defect):
    parameters, options, claims, digits, kind, text = PLANTED[defect]
    stepper = printed(ss.Stepper(generalized_alpha(*parameters, **options)), f"{{:.{digits - 1}e}}".format)
    report = ss.audit(stepper, claims)
    assert [deviation.kind for deviation in report.deviations] == [kind, "precision"], report.text
    assert text in report.deviations[0].text


def test_additive_noise_is_no_instability():
    """Short runs alone show a spectral radius above 1 where little but noise is left of the state."""
    steps, rng = generalized_alpha(*OPTIMAL, BETA, GAMMA), np.random.default_rng(0)

    def run(*args: Any, load: Any) -> Any:
        found = steps(*args, load)
        return found + 1e-12 * rng.uniform(-1, 1, found.shape)

    report = ss.audit(run)
    assert report.measured_critical is None and "10^4 (measured the same)" in report.text, report.text


def test_noise_that_hides_the_scheme_is_said():
    report = ss.audit(loose((0, 0, 0.25, 0.5), 0.3, 0), TRAPEZOIDAL)
    assert report.noise.hides and not report.matches and report.identified == "not found: results repeat to 0 digits"
    assert not report.deviations and {judgement.verdict for judgement in report.judgements} == {"not judged"}


def identified(stepper: ss.Stepper) -> Identification:
    own = own_runs(stepper)
    noise = measured_noise(stepper, own)
    own = noise.over(own)
    return with_all_members(identify(own, own, noise=noise), own, own, noise)


@pytest.mark.thorough
def test_under_noise_all_members_of_the_class_are_named_with_the_values_that_they_have_without_it():
    """And a scheme that agrees within the noise alone, here Silva and Bezerra's, is none of them."""
    hht, trapezoidal = generalized_alpha(0, 0.1, 0.3025, 0.6), generalized_alpha(0, 0, 0.25, 0.5)
    for steps, digits, least in ((hht, 6, 4), (trapezoidal, 4, 10)):
        quiet = identified(ss.Stepper(steps)).matches
        loud = identified(printed(ss.Stepper(steps), f"{{:.{digits - 1}e}}".format)).matches
        texts = {match.text for match in loud if not match.doubtful}
        assert texts == {match.text for match in quiet} and len(texts) >= least
        assert not {match.text for match in loud if match.doubtful} & texts
        assert not any(match.doubtful for match in quiet)


@pytest.mark.thorough
def test_values_are_written_to_the_digits_that_noise_leaves():
    """Newmark's method, and the schemes of which it is a case."""
    report = ss.audit(printed(ss.Stepper(generalized_alpha(0, 0, 0.2532171828, 0.5)), "{:.6e}".format))
    assert report.identified.startswith("newmark(beta = 0.2532"), report.identified
    assert " = generalized_alpha(" in report.identified and "within the noise" not in report.identified
    assert max(map(len, re.findall(r"\d+\.\d+", report.identified))) <= 9, report.identified
    assert all(match.unsure > 1e-8 for match in report.matches if match.solved), report.identified


def test_schemes_that_agree_within_the_noise_alone_are_not_written_as_equal():
    report = ss.audit(printed(declared(ss.scheme("newmark")), "{:.6e}".format))
    first, *others = report.matches
    doubtful = replace(report, found=replace(report.found, matches=(first, replace(others[0], doubtful=True))))
    assert doubtful.identified.startswith(f"{first.text} or, within the noise: {others[0].text}, all entries")


@pytest.mark.parametrize("late", [0.0, 0.5])
@pytest.mark.parametrize("decimals", [3, 6])
def test_fixed_decimals_hide_no_instant_of_the_load(decimals, late):
    """Of a motion from rest, whose first numbers are smaller than the last decimal."""
    steps = ss.Stepper(generalized_alpha(0.0, 0.0, 0.25, 0.5, late=late))
    stepper = printed(steps, f"{{:.{decimals}f}}".format)
    own = own_runs(stepper)
    noise = measured_noise(stepper, own)
    own, driven = noise.over(own), {name: noise.over([run])[0] for name, run in driven_runs(stepper).items()}
    match = agreement(ss.scheme("average_acceleration"), own, own, noise)
    assert noise.absolute and match is not None
    assert load_taking(match, driven, noise).text == ("f(t_n + 1/2 h)" if late else "f(t_n + h)")
