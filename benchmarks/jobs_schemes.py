"""Every scheme of the catalogue on the same work: the speed of its kernels."""

from functools import partial

import numpy as np
from substep_derive.emit.stability_module import SMALL_OMEGA

import substep as ss
from substep.marching.linear import march_linear

from . import jobs_pendulum, jobs_spectrum, ours, peers
from .job import Job, Table
from .linear import record, scheme
from .timing import Alternative, cores, measure

NAME = "schemes"


def job(quick: bool) -> Job:
    """A table for each kind of work, a row a scheme with kernels of its own that takes damping; quick: every sixth."""
    found = Job(NAME, "All schemes, one core")
    random, rounds = np.random.default_rng(2015), 3 if quick else 7
    every = [(name, ss.scheme(name).info) for name in ss.schemes()]
    names = [name for name, info in every if info.damping and not info.fixed][:: 6 if quick else 1]
    points = 1 << 16
    Omega, xi = 10.0 ** random.uniform(-2, 1, points), random.uniform(0.0, 0.2, points)
    order, few = np.argsort(Omega), slice(None, None, 32)
    sweep, larger = (Omega[order], xi[order]), (np.maximum(Omega, 2 * SMALL_OMEGA), xi)
    matrices = {name: scheme(name).amplification(Omega[few], xi[few]) for name in names}
    n, dt = 1024, jobs_spectrum.DT
    load = ss.Record(dt, record(n, dt))
    lanes = ours.at_rest(jobs_spectrum.OMEGAS, jobs_spectrum.XI, load)
    long = 1 << 15
    long_load = ss.Record(dt, record(long, dt))
    one, steps, h = lanes.lane(240), 500, 1e-3
    EA, a0 = jobs_pendulum.CASES["flexible"]
    works = {
        "stability: rho, damping, period error": (lambda s: s.stability(Omega, xi), points, "point"),
        "stability, Omega increasing": (lambda s: s.stability(*sweep), points, "point"),
        "stability, no Omega small": (lambda s: s.stability(*larger), points, "point"),
        "stability: rho alone": (lambda s: s.spectral_radius(Omega, xi), points, "point"),
        "response spectrum: peak |u|": (lambda s: march_linear(s, lanes, n, load, keep="peak_u"), n * 480, "lane-step"),
        "history of one oscillator": (lambda s: march_linear(s, one, long, long_load), long, "step"),
        "flexible pendulum, 480 lanes": (
            lambda s: ours.pendulum_batch(s.name, EA, a0, jobs_pendulum.V0, h, steps), steps * 480, "lane-step",
        ),
        "flexible pendulum, one lane": (
            lambda s: ours.pendulum_batch(s.name, EA, a0, jobs_pendulum.V0[:1], h, steps), steps, "step",
        ),
    }  # fmt: skip
    by_eigvals = {
        "np.linalg.eigvals of the amplification matrix: rho, damping, period error": (
            lambda s: peers.eigenvalues(matrices[s.name], Omega[few], xi[few]), points // 32, "point",
        ),
        "np.linalg.eigvals: rho alone": (lambda s: peers.radius(matrices[s.name]), points // 32, "point"),
    }  # fmt: skip
    with cores(1):
        for kind, what, (run, units, unit) in (
            *(("substep", *item) for item in works.items()),
            *(("peer", *item) for item in by_eigvals.items()),
        ):
            rows = [Alternative(name, kind, partial(run, scheme(name)), units) for name in names]
            found.tables.append(Table(what, unit, measure(rows, rounds), {}))
    found.notes.append(
        "houbolt, park, gholampour and oalts begin with steps of another scheme, so that no "
        "filter gives their peaks; oalts and park have more than three live eigenvalues, found by iteration."
    )
    return found
