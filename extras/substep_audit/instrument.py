"""The audit: probe a stepper, identify it, judge what is claimed of it."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from substep.core.errors import called_as
from substep.core.schemes import Scheme

from .causes import Evidence, deviations
from .claims import Claims, judged
from .control import controlled_runs
from .damping import identify_damped
from .declared import declared
from .defaults import written_out
from .exactness import exactness
from .free_motion import AVERAGED, BEFORE, ENERGY_AT, GROWTH_STEPS, energies, growths
from .identify import Identification, Match, is_claimed
from .limits import LARGE, Limits
from .loads import LoadTaking, calls_of, load_taking
from .measured_stability import overshoot, tolerance_of
from .members import with_all_members
from .noise import Noise
from .nonlinear import split
from .orders import Order, compared, observed_orders
from .outputs import declared_instants, elsewhere, output_instants, with_late_outputs
from .program import Program
from .programs.adapter import Integrator
from .report import Report
from .runs import Runs
from .stepper import Run, Stepper, as_stepper

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
    runs = Runs.of(stepper)
    noise = runs.noise
    exact = exactness(runs.own, runs.driven, noise)
    found = identified(stepper, runs, claimed) if exact is None else Identification(())
    best = found.matches[0] if found.matches else None
    load = load_taking(best, runs.driven, noise) if best else not_sought(runs)
    sure = best is not None and (not noise.loud or (claimed is not None and is_claimed(best.scheme, claimed)))
    limits = Limits.of(stepper, best.scheme if best else None, sure, noise)

    orders = observed_orders(stepper, noise)
    unknown: Mapping[str, Order] = {}
    both = expected_orders(best, load, orders, noise) if best else (orders, unknown)
    instants = elsewhere(output_instants(best, runs.own, noise)) if best else {}
    late = declared_instants(best, stepper, noise) if best else {}

    judgements = judged(claims, found, orders, limits.rho_inf, limits.critical, noise.of_radius) if claims else ()
    if noise.hides:
        judgements = tuple(replace(j, verdict="not judged") if j.verdict != "not stated" else j for j in judgements)
    known = exact is None and not noise.hides
    departures = deviations(Evidence(stepper, claimed, found, load, judgements, *both, instants)) if known else ()
    defaults = written_out(stepper, best, noise)
    affordable = stepper.can.seconds * stepper.can.calls * LONG_STEPS <= PATIENCE
    error = max(noise.size, best.error if best else 0.0)
    return Report(
        stepper=stepper,
        found=found,
        exact=exact,
        orders=orders,
        rho_inf=limits.rho_inf,
        critical_Omega=limits.critical,
        overshoot=overshoot(stepper),
        loads=load,
        judgements=judgements,
        deviations=(*departures, *(defaults.deviations if defaults else ())),
        curves=runs.curves(tolerance_of(stepper, noise)),
        growth=growths(stepper, limits.roots, limits.critical, LARGE) if affordable else (),
        energy=energies(stepper, error) if affordable and "v" not in instants else (),
        control=controlled_runs(stepper),
        failed=runs.failed,
        noise=noise,
        defaults=defaults,
        left_out=left_out(stepper.can, affordable, late),
        measured_critical=limits.measured,
        scheme_critical=limits.by_scheme,
        ignores_a0=runs.ignores_a0,
        instants=instants | late,
        measured_rho_inf=limits.measured_rho_inf,
    )


def identified(stepper: Stepper, runs: Runs, claimed: Scheme | None) -> Identification:
    """Which schemes the stepper does the same as, members and late outputs among them, and under which springs."""
    found = with_late_outputs(identify_damped(runs.free, runs.own, claimed, runs.noise), runs.own, runs.noise)
    return split(with_all_members(found, runs.free, runs.own, runs.noise), stepper, runs.free, runs.noise)


def not_sought(runs: Runs) -> LoadTaking:
    """What is known of how the load is taken where there is no scheme to compare with: when it was asked for."""
    if not runs.driven:
        return LoadTaking("none")
    return LoadTaking("not sought", called=calls_of(list(runs.driven.values())))


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
