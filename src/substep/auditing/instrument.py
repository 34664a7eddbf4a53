"""The audit: probe a stepper, identify it, judge what is claimed of it."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..core.arrays import Array
from ..core.errors import called_as
from ..core.schemes import Scheme
from .causes import Evidence, deviations
from .claims import Claims, judged
from .control import controlled_runs
from .damping import identify_damped
from .exactness import exactness
from .free_motion import energies, growths, measured_roots, observed_noise, scheme_roots
from .identify import Identification
from .linear_step import Candidate, Oscillators
from .loads import LoadTaking, calls_of, load_taking
from .nonlinear import split
from .orders import observed_orders
from .probes import Measured, driven_runs, given_runs, own_runs
from .program import Program
from .programs.adapter import Integrator, Load
from .report import Curve, Report
from .stability import critical_Omega, eigenvalues, measured_radius, overshoot, tolerance_of
from .stepper import Run, Stepper, as_stepper

LARGE = 1e4  # Omega for which the spectral radius is its limit, but for 1/Omega
EXACT, MEASURED = 1e-12, 1e-7  # by how much a computed and a measured spectral radius of 1 may exceed 1, at Omega <= 1


@called_as('audit(run, Claims("newmark", order=2))')
def audit(stepper: Stepper | Run, claims: Claims | None = None) -> Report:
    """Which scheme a program's integrator is, what it can do, and where it departs from what it claims.

    stepper: a function run(omega, xi, dt, n, u0, v0, load) -> u, v, a of histories with n + 1 numbers each, for
    u'' + 2 xi omega u' + omega**2 u = load(t); with an argument a0 it is taken to start from that acceleration. A
    `Stepper` says more of what it can do. claims: what its manual states.

    Raises ValueError for a stepper that raises on every oscillator or returns something else, and for claims that no
    scheme can have. Where it raises on some of them, the audit rests on the others, and the report lists these.
    """
    stepper, claims = as_stepper(stepper), claims or Claims()
    claimed = claims.claimed_scheme()
    own, driven = own_runs(stepper), driven_runs(stepper)
    exact = exactness(own, driven)
    found = Identification(())
    if exact is None:
        free = given_runs(stepper) if stepper.can.sets_a0 else own
        found = split(identify_damped(free, own, claimed), stepper, free, own)
    best = found.matches[0] if found.matches else None
    load = load_taking(best, driven) if best else LoadTaking("unknown", called=calls_of(list(driven.values())))
    radius, margin, roots = measured_radius(stepper), MEASURED, measured_roots(stepper)
    if best is not None:  # its kernel is right for multiple eigenvalues too
        radius, margin, roots = best.scheme.spectral_radius, EXACT, scheme_roots(best.scheme.amplification)
    rho_inf, critical = float(radius(np.array([LARGE]))[0]), critical_Omega(radius, margin)
    orders = observed_orders(stepper)
    judgements = judged(claims, found, orders, rho_inf, critical)
    expected = observed_orders(declared(best.scheme)) if best else {}
    departures = (
        deviations(Evidence(stepper, claimed, found, load, judgements, orders, expected)) if exact is None else ()
    )
    return Report(
        stepper, found, exact, orders, rho_inf, critical, overshoot(stepper), load, judgements, departures,
        measured_curves(stepper, own), growths(stepper, roots, critical, LARGE),
        energies(stepper, observed_noise(stepper, best.error if best else None)), controlled_runs(stepper),
        failures(own, driven),
    )  # fmt: skip


def failures(own: Sequence[Measured], driven: Mapping[str, Measured]) -> tuple[tuple[float, float, str], ...]:
    """Of each oscillator that the program raised on, the first error."""
    found = {(Omega, xi): error for run in [*driven.values(), *own][::-1] for Omega, xi, error in run.failed}
    return tuple((Omega, xi, found[Omega, xi]) for Omega, xi in sorted(found))


def audit_program(
    program: Program, integrators: Sequence[str] | None = None, arguments: Mapping[str, Any] | None = None
) -> Iterator[Report]:
    """The reports of a program's integrators, all by default, each when it is done.

    With other arguments than those of the adapter, what its manual claims of the adapter's is not judged.
    """
    for name in integrators or program.integrators:
        stepper = program.stepper(name, arguments)
        yield audit(stepper, None if arguments else program.claims(name))


def declared(scheme: Scheme) -> Stepper:
    """A scheme as its declaration says, as a stepper, to be observed as others are."""

    def run(
        omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load, a0: float | None = None
    ) -> Array:
        at = Oscillators(np.array([omega * dt]), np.array([xi]), dt)
        start = None if a0 is None else np.array([a0])

        def force(t: Array) -> Array:
            return np.array([load(x) for x in t])

        return Candidate(scheme, at).histories(np.array([u0, v0]), start, n, force)[0].T

    outputs = "uva" if any(kind == 2 for kind, _ in scheme.history) else "uv"
    return Stepper(run, Integrator(sets_a0=True, damping=scheme.info.damping, outputs=outputs), scheme.name)


def measured_curves(stepper: Stepper, own: list[Measured]) -> tuple[Curve, ...]:
    """Spectral radius, numerical damping and period error from the eigenvalues that the histories show."""
    at, tolerance = own[0].at, tolerance_of(stepper)
    found = []
    for xi in dict.fromkeys(at.xi.tolist()):
        places = np.flatnonzero(at.xi == xi)
        values = [eigenvalues(own, int(p), tolerance) for p in places]
        errors = np.array([x.damping_and_period(at.Omega[p], xi) for x, p in zip(values, places, strict=True)])
        radius = np.array([x.radius for x in values])
        found.append(Curve(xi, at.Omega[places], radius, errors[:, 0], errors[:, 1]))
    return tuple(found)
