"""Accuracy: the march and the period error against the same scheme in 50 digits."""

import numpy as np

import substep as ss

from . import ours, reference
from .job import Goal, Job
from .linear import SCHEMES, record, scheme

NAME = "accuracy"
DT = 2.0**-7  # a power of 2, so that Omega = omega*dt and h^2 f are not rounded


def job(quick: bool) -> Job:
    """1e5 steps, free and under the record; period errors from Omega = 1e-6 on."""
    found = Job(NAME, "Digits of the march and of the period error")
    n = 20_000 if quick else 100_000
    for name in SCHEMES:
        worst, floor, where = 0.0, 0.0, ""
        for Omega, xi, loaded in ((6e-4, 0.0, False), (0.1, 0.0, False), (0.1, 0.05, True), (1.0, 0.02, True)):
            error, coefficients = _march_error(name, Omega, xi, loaded, n)
            if error > worst:
                worst, floor, where = (
                    error,
                    coefficients,
                    f"at Omega = {Omega:g}, xi = {xi:g}{', record' if loaded else ''}",
                )
        text = f"march, {name}: error against 50 digits over {n} steps, largest {where}"
        found.goals.append(Goal(text, "<", 1e-12, worst, unit=""))
        found.notes.append(f"{name}, there: rounding the coefficients to doubles, and nothing else, gives {floor:.1e}.")
    for name in SCHEMES:
        for xis, bound, label in (((0.0,), 1e-12, "xi = 0"), ((0.01, 0.05, 0.2), 1e-9, "xi > 0")):
            errors = _period_errors(name, xis, 24 if quick else 96)
            found.below(f"period error, {name}: relative error, Omega >= 1e-6, {label}", bound, errors)
    found.notes.append("The march's error is of the largest u of the run, over all its steps; the goal is for 1e5.")
    return found


def _march_error(name: str, Omega: float, xi: float, loaded: bool, n: int) -> tuple[float, float]:
    """Error of substep, and of the exact march with coefficients rounded to doubles."""
    f = record(n, DT) if loaded else None
    u0 = 0.0 if loaded else 1.0
    omega = Omega / DT
    scene = ours.oscillator(omega, xi, None if f is None else ss.Record(DT, f), u0)
    u = ours.single_run(name, scene, DT, n)[0]
    forces = None if f is None else f * DT**2
    exact, rounded = (reference.march(name, omega * DT, xi, forces, n, u0, rounded=yes) for yes in (False, True))
    scale = np.abs(exact).max()
    return float(np.abs(u - exact).max() / scale), float(np.abs(rounded - exact).max() / scale)


def _period_errors(name: str, xis: tuple[float, ...], count: int) -> list[float]:
    Omegas = 10.0 ** np.random.default_rng(6).uniform(-6, 0.5, count)
    errors = []
    for xi in xis:
        found = ours.stability(scheme(name), Omegas, np.full(count, xi))[2]
        exact = np.array([reference.spectrum(name, float(x), xi)[2] for x in Omegas])
        errors.append(float(np.nanmax(np.abs(found / exact - 1.0))))
    return errors
