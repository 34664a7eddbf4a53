"""The audit: probe a stepper, identify it, judge what is claimed of it."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from substep.core.errors import called_as
from substep.core.schemes import Scheme

from .causes import Evidence, deviations
from .claims import Claims, judged
from .control import controlled_runs
from .curve import Curve
from .damping import identify_damped
from .declared import declared
from .defaults import written_out
from .exactness import exactness
from .free_motion import (
    AVERAGED,
    BEFORE,
    ENERGY_AT,
    GROWTH_STEPS,
    energies,
    growths,
    measured_roots,
    scheme_roots,
)
from .identify import Identification, Match, is_claimed
from .loads import LoadTaking, calls_of, load_taking
from .measured_stability import (
    confirmed_radius,
    critical_Omega,
    eigenvalues,
    long_radius,
    measured_radius,
    overshoot,
    same_limit,
    tolerance_of,
)
from .members import with_all_members
from .noise import MARGIN, Noise, measured_noise
from .nonlinear import split
from .orders import Order, compared, observed_orders
from .outputs import declared_instants, elsewhere, output_instants, with_late_outputs
from .probes import Measured, driven_runs, given_runs, own_runs
from .program import Program
from .programs.adapter import Integrator
from .report import Report
from .stepper import Run, Stepper, as_stepper

LARGE = 1e4  # Omega for which the spectral radius is its limit, but for 1/Omega
EXACT, LONGER = 1e-12, 0.02  # by how much a computed spectral radius of 1, or one from long runs, may exceed 1
GUESSED = 1e-9  # what an iteration leaves of the acceleration that it starts from
LONG_STEPS = len(ENERGY_AT) * (BEFORE + 2 * AVERAGED) + 6 * GROWTH_STEPS  # of long free motion
PATIENCE = 60.0  # s that it may take


@called_as('audit(run, Claims("newmark", order=2))')
def audit(stepper: Stepper | Run, claims: Claims | None = None) -> Report:
    """Which scheme a program's integrator is, what it can do, and where it departs from what it claims.

    stepper: a function run(omega, xi, dt, n, u0, v0, load) -> u, v, a of histories with n + 1 numbers each, for
    u'' + 2 xi omega u' + omega**2 u = load(t); with an argument a0 it is taken to start from that acceleration. A
    `Stepper` says more of what it can do. claims: what its manual states.

    Raises ValueError for a stepper that raises on every oscillator or returns something else, that returns no finite u
    after t = 0 or does not move, and for claims that no scheme can have. Where it raises on some oscillators, the audit
    rests on the others, and the report lists these.

    >>> def run(omega, xi, dt, n, u0, v0, load):
    ...     r = ss.march(ss.scene("linear_oscillator", omega=omega, xi=xi, u0=u0, v0=v0), "bathe", dt, n * dt)
    ...     return r.u[:, 0], r.v[:, 0], r.a[:, 0]
    >>> ss.audit(run, ss.Claims("bathe")).identified.partition(" = ")[0]
    'bathe'
    """
    stepper = as_stepper(stepper)
    claimed = claims.claimed_scheme() if claims else None
    own = own_runs(stepper)
    _check_motion(stepper, own)
    noise = measured_noise(stepper, own)
    own = noise.over(own)
    driven = {name: noise.over([run])[0] for name, run in driven_runs(stepper).items()}
    given = given_runs(stepper) if "a" in stepper.can.sets else []
    ignored = bool(given) and ignores_a0(given[-1], noise)
    exact = exactness(own, driven, noise)
    found = Identification(())
    if exact is None:
        free = noise.over(given) if given and not ignored else own
        found = with_late_outputs(identify_damped(free, own, claimed, noise), own, noise)
        found = split(with_all_members(found, free, own, noise), stepper, free, noise)
    best = found.matches[0] if found.matches else None
    sought = LoadTaking("not sought" if driven else "none", called=calls_of(list(driven.values())) if driven else ())
    load = load_taking(best, driven, noise) if best else sought
    radius, roots = measured_radius(stepper, noise), measured_roots(stepper, noise)
    growing, margin = (long_radius(stepper), LONGER) if noise.loud else (radius, noise.margin)
    measured = critical_Omega(growing, margin)
    by_scheme = critical_Omega(best.scheme.spectral_radius, margin) if best else None
    if not noise.loud and not same_limit(measured, by_scheme, noise):
        measured = critical_Omega(confirmed_radius(radius, long_radius(stepper)), margin)
    critical, measured_rho = measured, float(radius(np.array([LARGE]))[0])
    sure = not noise.loud or (claimed is not None and best is not None and is_claimed(best.scheme, claimed))
    if best is not None and sure:  # its kernel is right for multiple eigenvalues too
        radius, critical = best.scheme.spectral_radius, critical_Omega(best.scheme.spectral_radius, EXACT)
        roots = scheme_roots(best.scheme.amplification)
    rho_inf = _limit(best.scheme) if best is not None and sure else None
    rho_inf = measured_rho if rho_inf is None else rho_inf
    orders = observed_orders(stepper, noise)
    judgements = judged(claims, found, orders, rho_inf, critical, noise.of_radius) if claims else ()
    unknown: Mapping[str, Order] = {}
    both = expected_orders(best, load, orders, noise) if best else (orders, unknown)
    instants = elsewhere(output_instants(best, own, noise)) if best else {}
    late = declared_instants(best, stepper, noise) if best else {}
    if noise.hides:
        judgements = tuple(replace(j, verdict="not judged") if j.verdict != "not stated" else j for j in judgements)
    known = exact is None and not noise.hides
    departures = deviations(Evidence(stepper, claimed, found, load, judgements, *both, instants)) if known else ()
    defaults = written_out(stepper, best, noise)
    affordable = stepper.can.seconds * stepper.can.calls * LONG_STEPS <= PATIENCE
    return Report(
        stepper, found, exact, orders, rho_inf, critical, overshoot(stepper), load, judgements,
        (*departures, *(defaults.deviations if defaults else ())), measured_curves(own, tolerance_of(stepper, noise)),
        growths(stepper, roots, critical, LARGE) if affordable else (),
        energies(stepper, max(noise.size, best.error if best else 0.0)) if affordable and "v" not in instants else (),
        controlled_runs(stepper), failures(own, driven), noise, defaults, left_out(stepper.can, affordable, late),
        measured, by_scheme, ignored, instants | late, measured_rho_inf=measured_rho,
    )  # fmt: skip


def _check_motion(stepper: Stepper, own: Sequence[Measured]) -> None:
    """Raise ValueError for free motion of which no u is known after t = 0, or in which no u changes after it."""
    u = np.concatenate([run.rows[:, 1:, 0] for run in own])
    if np.isnan(u).all():
        raise ValueError(
            f"expected finite displacements u from {stepper.name} after t = 0, got none in any run of free motion; "
            "return u, the first of the three histories, and name it in the outputs of its Integrator"
        )
    if (np.isnan(u) | (u == u[:, :1])).all():
        raise ValueError(
            f"expected displacements u from {stepper.name} that move from u0 = 1 or v0, got the same number at every "
            "step of every run; return the histories of the run, and pass omega, u0 and v0 on to the program"
        )


def ignores_a0(from_a0: Measured, noise: Noise) -> bool:
    """Whether a unit start of h^2*a, from rest, leaves all steps at zero but for the noise, or an iteration's end.

    A program that solves for its own acceleration may take the given one as a first guess.
    """
    after = np.nan_to_num(from_a0.rows[:, 1:]) / from_a0.at.scale[:, None]
    return bool(np.abs(after).max() <= max(GUESSED, MARGIN * noise.size))


def left_out(can: Integrator, affordable: bool, agreeing: Mapping[str, float]) -> tuple[str, ...]:
    """What was not compared or not run, and why, in words. agreeing: late outputs that are the scheme's where said."""
    parts = {name: x for name, x in can.late.items() if name not in agreeing and not float(x * can.calls).is_integer()}
    found = [
        f"{name}: stands {x:+g} steps from the end of its step, where it is not found to be the scheme's"
        for name, x in parts.items()
    ]
    if not affordable:
        found.append(f"long free motion, {LONG_STEPS} steps: a call takes {can.seconds:g} s")
    return tuple(found)


def failures(own: Sequence[Measured], driven: Mapping[str, Measured]) -> tuple[tuple[float, float, str], ...]:
    """Of each oscillator that the program raised on, the first error."""
    found = {(Omega, xi): error for run in [*driven.values(), *own][::-1] for Omega, xi, error in run.failed}
    return tuple((Omega, xi, found[Omega, xi]) for Omega, xi in sorted(found))


def audit_program(
    program: Program, integrators: Sequence[str] | None = None, arguments: Mapping[str, Any] | None = None
) -> Iterator[Report]:
    """The reports of a program's integrators, all by default, each when it is done, with the CPU seconds it took.

    With other arguments than those of the adapter, what its manual claims of the adapter's is not judged.
    """
    for name in integrators or program.integrators:
        stepper = program.stepper(name, arguments)
        here, there = time.process_time(), program.seconds
        report = audit(stepper, None if arguments else program.claims(name))
        yield replace(report, seconds=(time.process_time() - here, program.seconds - there))


def expected_orders(
    best: Match, load: LoadTaking, orders: Mapping[str, Order], noise: Noise
) -> tuple[Mapping[str, Order], Mapping[str, Order]]:
    """The observed orders and those of the identified scheme, by the same runs.

    In place of those that noise hides, those that the scheme has with the load and the start that were found.
    """
    expected = observed_orders(declared(best.scheme), noise)
    if not noise.loud:
        return orders, expected
    model = observed_orders(declared(best.scheme, load.loads or None, best.start == "zero"))
    return compared(orders, expected, model, observed_orders(declared(best.scheme)))


def _limit(scheme: Scheme) -> float | None:
    """The spectral radius as Omega -> oo, None where it has no closed form at these parameters."""
    found = scheme.rho_inf
    return None if found is None or np.isnan(found) else float(found)


def measured_curves(own: Sequence[Measured], tolerance: float) -> tuple[Curve, ...]:
    """Spectral radius, numerical damping and period error from the eigenvalues that the histories show.

    Without the oscillators that the program raised on, of which none is known.
    """
    at = own[0].at
    pairs = list(zip(at.Omega.tolist(), at.xi.tolist(), strict=True))
    stopped = {(Omega, xi) for run in own for Omega, xi, _ in run.failed}
    found: list[Curve] = []
    for xi in dict.fromkeys(at.xi.tolist()):
        places = [p for p, (Omega, ratio) in enumerate(pairs) if ratio == xi and (Omega, ratio) not in stopped]
        values = [eigenvalues(own, p, tolerance) for p in places]
        errors = np.array([x.damping_and_period(float(at.Omega[p]), xi) for x, p in zip(values, places, strict=True)])
        errors = errors.reshape(-1, 2)
        radius = np.array([x.radius for x in values])
        found.append(Curve(xi, at.Omega[places], radius, errors[:, 0], errors[:, 1]))
    return tuple(found)
