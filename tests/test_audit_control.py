"""Audits of steps that a program chooses: its error against the tolerance, its estimates against the true error."""

from typing import Any

import numpy as np
import pytest
from audited_steppers import trapezoidal_load
from substep_audit.control import TOLERANCES, Control, controlled_runs

import substep as ss
from substep.studies.estimator_charts import effectivity

pytestmark = pytest.mark.usefixtures("few_members")


def not_run(*_: Any, **__: Any) -> Any:
    raise AssertionError("only steps of its own choice are looked at")


def by_march(scheme: str) -> ss.Stepper:
    """This package's own chosen steps, on a structure of one degree of freedom."""

    def controlled(omega: float, xi: float, tol: float, t_end: float, u0: float, v0: float) -> Any:
        oscillator = ss.structure(np.eye(1), np.array([[omega**2]]), u0=u0, v0=v0)
        r = ss.march(oscillator, scheme, tol=tol, t_end=t_end, account=False, progress=False)
        return r.t, r.u[:, 0], r.v[:, 0], None

    return ss.Stepper(not_run, controlled=controlled)


def average_acceleration(factor: float = 1.0, of_order: int = 2) -> ss.Stepper:
    """Equal steps of the average acceleration method, their length proportional to tol^(1/3), with estimated errors.

    Zienkiewicz and Xie's of u, (beta - 1/6) h^2 (a_1 - a_0), and h/12 (a_1 - 2 a_0 + a_-1) of v; `factor` times as
    large, or divided by h^(2 - of_order), where they are to be wrong.
    """
    steps = trapezoidal_load(0, 0, 1)

    def controlled(omega: float, xi: float, tol: float, t_end: float, u0: float, v0: float) -> Any:
        n = round(t_end / (3.0 * tol ** (1 / 3)))
        h = t_end / n
        u, v, a = steps(omega, xi, h, n, u0, v0, lambda t: 0.0)
        errors = np.zeros((2, n))
        errors[0] = h**2 / 12 * np.diff(a)
        errors[1, 1:] = h / 12 * np.diff(a, 2)
        return h * np.arange(n + 1), u, v, factor * errors * h ** (of_order - 2)

    return ss.Stepper(not_run, controlled=controlled)


def control_of(stepper: ss.Stepper) -> Control:
    found = controlled_runs(stepper)
    assert found is not None and [run.tol for run in found.runs] == list(TOLERANCES)
    return found


@pytest.mark.parametrize(
    ("scheme", "order", "power"),
    [("bathe", 2, 2 / 3), ("average_acceleration", 2, 2 / 3), ("noh_bathe", 2, 2 / 3), ("dormand_prince", 5, 1.0)],
)
def test_the_error_of_chosen_steps_follows_the_tolerance(scheme, order, power):
    """Of order p, held to its own error: tol^(p/(p+1)); where it goes on with the better of two values: tol."""
    found = control_of(by_march(scheme))
    assert found.power == pytest.approx(power, abs=0.07)
    assert found.orders == pytest.approx((order, order), abs=0.5)
    assert all(run.estimated == (None, None) and not run.failed for run in found.runs)
    assert found.runs[-1].error < 1e-4 and len(found.text) == 1


def test_effectivity_is_that_of_the_derived_estimator():
    found = control_of(average_acceleration())
    for run in found.runs[1:]:
        expected = effectivity(ss.scheme("average_acceleration"), np.array([run.Omega])).plain[:, 0]
        assert run.effectivity == pytest.approx(tuple(expected), rel=0.01), run
    assert found.orders == pytest.approx((2.0, 2.0), abs=0.02)
    assert found.estimated_orders == pytest.approx((2.0, 2.0), abs=0.02)
    assert found.power == pytest.approx(2 / 3, abs=0.01)


def test_wrong_estimates_are_seen():
    right, twice = control_of(average_acceleration()), control_of(average_acceleration(2.0))
    for one, other in zip(right.runs, twice.runs, strict=True):
        assert other.effectivity == pytest.approx(tuple(2 * x for x in one.effectivity if x is not None), rel=1e-12)
    lower = control_of(average_acceleration(of_order=1))
    assert lower.estimated_orders == pytest.approx((1.0, 1.0), abs=0.02)
    assert lower.orders == right.orders
    assert "orders 1 against 2" in lower.text[1]


def test_a_run_that_fails_is_told_and_the_others_count():
    run = average_acceleration().controlled
    assert run is not None

    def controlled(omega, xi, tol, t_end, u0, v0):
        if tol < 1e-6:
            raise ArithmeticError("step too small")
        t, u, v, errors = run(omega, xi, tol, t_end, u0, v0)
        return (t[:-9], u[:-9], v[:-9], None) if tol == 1e-3 else (t, u, v, errors[:, 1:] if tol == 1e-4 else errors)

    found = control_of(ss.Stepper(not_run, controlled=controlled))
    first, second, *_, last = found.runs
    assert "it ends at t =" in first.failed and "step too small" in last.failed and "errors" in second.failed
    assert [run.tol for run in found.done] == [1e-5, 1e-6]
    assert found.text[0].startswith("fails at tol = 1e-03: it ends")
    assert controlled_runs(ss.Stepper(not_run)) is None


def test_a_report_says_it():
    own = average_acceleration()
    report = ss.audit(ss.Stepper(trapezoidal_load(0, 0, 1), controlled=own.controlled))
    assert "own steps  error" in report.text and "estimate of u over true local error" in report.text
    read = report.to_dict()["control"]
    assert len(read["runs"]) == len(TOLERANCES) and read["power"] == pytest.approx(2 / 3, abs=0.01)
    assert "orders 2 against 2" in read["text"][1]
