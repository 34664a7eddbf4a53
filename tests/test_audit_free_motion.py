"""Audits of free motion over many steps: energy and double eigenvalues, against what is known exactly."""

import math
from typing import Any

import numpy as np
import pytest
from audited_steppers import generalized_alpha, trapezoidal_load
from declared import ONE_BY_ONE
from substep_audit.declared import declared
from substep_audit.free_motion import energies, growths, measured_roots, meetings, scheme_roots
from substep_audit.limits import LARGE
from substep_audit.measured_stability import critical_Omega, measured_radius
from substep_audit.noise import measured_noise
from substep_audit.probes import own_runs

import substep as ss

pytestmark = pytest.mark.usefixtures("few_members")

UV = ss.Integrator(outputs="uv", damping=False, load="none")


def two_halves(share: float) -> ss.Stepper:
    """Two of Verlet's steps, of `share` and the rest of dt."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        rows = [(u0, v0)]
        for _ in range(n):
            u, v = rows[-1]
            for h in (share * dt, (1 - share) * dt):
                v -= h / 2 * omega**2 * u
                u += h * v
                v -= h / 2 * omega**2 * u
            rows.append((u, v))
        return *zip(*rows, strict=True), None

    return ss.Stepper(run, UV)


def first_limit(share: float) -> float:
    """The smallest Omega at which its trace 2 - Omega^2 + a (1 - a) Omega^4/4, with a = share, is -2."""
    return math.sqrt(2 * (1 - abs(1 - 2 * share)) / (share * (1 - share)))


@pytest.mark.parametrize("name", [s.name for s in ONE_BY_ONE])
def test_energy_follows_the_eigenvalues_of_the_derived_matrix(name):
    """Its trend is the principal pair's modulus; a loss or gain is told wherever that is beyond the resolution."""
    scheme = ss.scheme(name)
    found = energies(declared(scheme), 1e-15)
    assert [one.Omega for one in found] == [0.1, 0.5, 1.0]
    for one in found:
        values = np.linalg.eigvals(scheme.amplification(one.Omega))
        values = values[np.abs(values) > np.abs(values).max() * (1 - 1e-9)]  # what is left after many steps
        expected = math.expm1(2 * math.log(np.abs(values).max()) * 2 * np.pi / one.Omega)
        assert one.per_period == pytest.approx(expected, rel=1e-6, abs=one.resolution * (1 + abs(expected))), one
        if abs(expected) > 3 * one.resolution:
            assert one.verdict == ("lost" if expected < 0 else "gained")
        if abs(expected) < one.resolution / 3:
            assert one.verdict.startswith("conserved")


@pytest.mark.parametrize("name", ["average_acceleration", "energy_momentum", "central_difference", "forest_ruth"])
def test_what_conserves_energy_is_told_from_what_conserves_it_on_average(name):
    """Central differences conserve v^2 + low omega^2 u^2 with low = 1 - Omega^2/4: the energy's range is 1 : low."""
    found = energies(declared(ss.scheme(name)), 1e-15)
    exact = name in ("average_acceleration", "energy_momentum")
    assert {one.verdict for one in found} == {"conserved" if exact else "conserved on average"}
    if name == "central_difference":
        for one in found:
            low = 1 - one.Omega**2 / 4
            seen = 0.75 if one.Omega == 1.0 else 1.0  # a sixth of a turn a step from the largest u: cos^2 is 1 or 1/4
            assert one.oscillation == pytest.approx(seen * (1 - low) / (1 + low), rel=1e-3)


def test_an_absolute_tolerance_does_not_hide_a_loss():
    """Backward Euler, of which nothing below 1e-12 changes any more, loses a half of the energy a step at Omega = 1."""
    backward = declared(ss.scheme("backward_euler"))

    def run(*args: Any, load: Any) -> Any:
        u, v, a = backward.run(*args, load=load)
        return [np.where(np.abs(x) > 1e-12, x, 1e-12) for x in (u, v)] + [a]

    one = energies(ss.Stepper(run, ss.Integrator(digits=12)), 1e-12)[2]
    assert one.per_period == pytest.approx(0.5 ** (2 * np.pi) - 1, rel=1e-3) and one.verdict == "lost"


def test_rounding_in_single_precision_is_no_loss():
    stepper = ss.Stepper(generalized_alpha(0, 0, 0.25, 0.5, dtype=np.float32))
    found = energies(stepper, measured_noise(stepper, own_runs(stepper)).size)
    assert len(found) == 3 and all(one.verdict.startswith("conserved") for one in found)
    assert all(1e-6 < one.resolution < 1e-2 for one in found)


@pytest.mark.parametrize("name", [s.name for s in ONE_BY_ONE])
def test_growth_at_the_critical_Omega_is_that_of_a_defective_matrix(name):
    """Where the derived matrix at its limit has a Jordan block on the unit circle, and nowhere else.

    Of chen_ricles u overshoots by Omega, undamped, which the steps looked at do not tell from growth at the largest.
    """
    scheme = ss.scheme(name)
    limit = scheme.critical_Omega
    critical = None if limit is None or np.isinf(limit) else float(limit)
    found = growths(declared(scheme), scheme_roots(scheme.amplification), critical, LARGE)
    if not critical:
        assert bool(found) == (name == "chen_ricles")
        return
    A = scheme.amplification(critical)
    values = np.linalg.eigvals(A)
    near = values[np.abs(np.abs(values) - 1) < 1e-5]
    powers = np.linalg.matrix_power(A, 1000)
    grows = len(near) > 1 and np.abs(powers).max() > 100
    assert bool(found) == grows
    assert all(one.power == 1 and one.Omega == critical for one in found)


@pytest.mark.parametrize("share", [0.5, 0.45, 0.3])
def test_eigenvalues_that_meet_without_a_block_are_not_accused(share):
    """Equal halves meet at -1 at 2 sqrt(2), where the step is -1 times the identity; other shares grow there."""
    stepper = two_halves(share)
    roots, critical = measured_roots(stepper), critical_Omega(measured_radius(stepper), 1e-7)
    expected = 4.0 if share == 0.5 else first_limit(share)  # of equal halves twice that of one
    assert critical == pytest.approx(expected, rel=1e-7)
    (one,) = growths(stepper, roots, critical, LARGE)
    assert one.power == 1 and one.Omega == critical and one.factor > 3
    met = meetings(roots, critical)
    assert met == ([pytest.approx(first_limit(0.5), abs=1e-6)] if share == 0.5 else [])


def test_a_planted_spurious_double_root_is_found_at_large_Omega():
    """The average acceleration method, which has none, with c n (-1)^n in its displacements."""
    steps = trapezoidal_load(0, 0, 1)

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any, c: float) -> Any:
        k = np.arange(n + 1)
        u, v, a = steps(omega, xi, dt, n, u0, v0, load)
        return u + c * (abs(u0) + abs(v0) * dt) * k * (-1.0) ** k, v, a

    for c, outputs, expected in ((0.0, "uva", []), (0.0, "u", []), (0.02, "uva", [1])):
        stepper = ss.Stepper(lambda *args, load, c=c: run(*args, load, c), ss.Integrator(outputs=outputs))
        found = growths(stepper, measured_roots(stepper), None, LARGE)
        assert [one.power for one in found if one.Omega == LARGE] == expected
        assert len(found) == 2 * len(expected)  # and at the first Omega at which the eigenvalues are seen to meet


@pytest.mark.parametrize(("size", "powers"), [(lambda n: 1 + n**3, [3]), (lambda n: 255.504 ** (n / 64), [])])
def test_exponential_growth_is_no_power_of_n(size, powers):
    """Of a program that is unstable there: over 256 steps such growth can look like n^16, which no step has."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any) -> Any:
        sizes = size(np.arange(n + 1.0))
        return (u0 + v0 * dt) * sizes * (-1.0) ** np.arange(n + 1), None, None

    stepper = ss.Stepper(run, ss.Integrator(outputs="u"))
    assert [one.power for one in growths(stepper, lambda Omega: np.zeros(0), 2.0, LARGE)] == powers


def test_a_report_says_it():
    report = ss.audit(ss.Stepper(generalized_alpha(0, 0, 0.0, 0.5)))
    assert [one.power for one in report.growth] == [1] and report.growth[0].Omega == pytest.approx(2.0, rel=1e-9)
    assert "growth     grows like n at Omega = 2, 4 times from step 64 on" in report.text
    assert "energy     at Omega = 1: conserved on average (bounded oscillation of 1" in report.text
    found = report.to_dict()
    assert found["energy"][2]["verdict"] == "conserved on average" and found["growth"][0]["power"] == 1
