"""One linear run with its history of u, v and a: a chain of dependent steps."""

from functools import partial

import numpy as np

import substep as ss

from . import limits, ours, peers, reference
from .job import BESIDE_C, Job, Table
from .linear import SCHEMES, TwoLoads, record, scheme
from .peers_march import OPENSEES, OpenSees
from .timing import Alternative, cores, measure

NAME = "single"
OMEGA, XI, DT = 6.28, 0.02, 0.01
# times as many steps for what compiles: the set-up of a call takes 0.05 ms, but 0.4 after a run that emptied the caches
LONGER = 4


def job(quick: bool) -> Job:
    """One oscillator under the record."""
    n, rounds = (100_000, 5) if quick else (400_000, 11)
    found = Job(NAME, f"One linear run of {LONGER * n} steps under a record, history of u, v, a, one core")
    with cores(1):
        for name in list(SCHEMES)[: 1 if quick else None]:
            table = _run(found, name, n, rounds)
            found.tables.append(table)
            kernel = "substep, the kernel in it"
            found.compare(table, f"single run, {name}: the kernel / C", kernel, "C", "<=", BESIDE_C)
            found.compare(table, f"single run, {name}: substep / C", "substep", "C", "<=", BESIDE_C)
            if name == "newmark_bdf2":
                found.compare(
                    table, f"single run, {name}: openseespy Newmark / substep, a step", "openseespy Newmark", "substep",
                    ">=", 300,
                )  # fmt: skip
    found.notes.append(
        "'exact' holds u against the exact response to the record, 'scheme' against the scheme in 50 digits, both over "
        f"the first {n} steps and of the largest u. openseespy's rows are one call of analyze for all steps, without a "
        "history; "
        "'a call a step' keeps one, as Python does it."
    )
    return found


def _run(found: Job, name: str, n: int, rounds: int) -> Table:
    long = LONGER * n
    whole = record(long, DT)
    f, all_forces = whole[: n + 1], whole * DT**2
    forces = all_forces[: n + 1]
    exact = _exact(f, n)
    same = reference.march(name, OMEGA * DT, XI, forces, n)
    scale = np.abs(exact).max()
    loads = TwoLoads.of(scheme(name), np.array([OMEGA * DT]), XI)
    D, B0, B1 = (np.ascontiguousarray(x[..., 0]) for x in (loads.D, loads.B0, loads.B1))

    def against_exact(u: np.ndarray) -> dict[str, float]:
        return {"exact": float(np.abs(u[: n + 1] - exact).max() / scale)}

    def against_both(u: np.ndarray) -> dict[str, float]:
        return {**against_exact(u), "scheme": float(np.abs(u[: n + 1] - same).max() / scale)}

    load = ss.Record(DT, whole)
    scene = ours.oscillator(OMEGA, XI, load)
    rows: list[Alternative] = []

    def add(label: str, kind, run, errors=against_both, units: int = n) -> None:
        try:
            run()
        except (peers.MissingPeerError, limits.MissingCompilerError) as error:
            found.skipped[label] = str(error)
        else:
            rows.append(Alternative(label, kind, run, units, errors))

    room = np.zeros((long + 1, 3, 1))
    add("substep", "substep", lambda: ours.single_lane(name, OMEGA, XI, load, room), units=long)
    add("substep, the kernel in it", "substep", ours.single_kernel(name, OMEGA, XI, load, room), units=long)
    add("substep, ss.march", "substep", lambda: ours.single_run(name, scene, DT, long)[0], units=long)
    out = np.zeros((long + 1, 3))
    if len(loads.D) == 3:
        add("C", "limit", lambda: limits.single_run_of_three(D, B0, B1, all_forces, out)[:, 0], units=long)
    else:
        numbers = (2 * XI * OMEGA * DT, (OMEGA * DT) ** 2, all_forces, out)
        add("C", "limit", lambda: limits.single_run(D, B0, B1, *numbers)[:, 0], units=long)
        numerator, denominator = (x[0] for x in loads.filter())
        run = partial(limits.single_run, D, B0, B1, *numbers, increment=True)
        add("C, increments", "limit", lambda: run()[:, 0], units=long)
        add("scipy lfilter", "peer", lambda: peers.lfilter_run(numerator, denominator, forces))
        if name == "newmark_bdf2":
            add("Python loop", "peer", lambda: peers.python_loop(D, B0, B1, forces))
    if name == "newmark_bdf2":
        add("scipy lsim", "peer", lambda: peers.lsim_run(OMEGA, XI, f, DT), against_exact)
        add("pyyeti SolveUnc", "peer", lambda: peers.solve_unc_run(OMEGA, XI, f, DT), against_exact)
        for integrator in OPENSEES:
            try:
                program = OpenSees(integrator, OMEGA, XI, f, DT)
            except peers.MissingPeerError as error:
                found.skipped["openseespy"] = str(error)
                break
            found_errors = against_exact(program.steps())  # one call of analyze keeps no history
            add(f"openseespy {integrator}", "peer", program.run, lambda _, known=found_errors: known)
            if integrator == "Newmark":
                add("openseespy Newmark, a call a step", "peer", program.steps, against_exact)
    errors = {"exact": "u against the exact response", "scheme": "u against the scheme in 50 digits"}
    return Table(f"{name}: one run", "step", measure(rows, rounds), errors)


def _exact(f: np.ndarray, n: int) -> np.ndarray:
    """The exact response at the steps' ends, the load linear between them."""
    w = complex(-XI * OMEGA, np.sqrt(1 - XI**2) * OMEGA)
    one = np.expm1(w * DT) / (w * DT)
    two = (one - 1) / (w * DT)
    growth, now, then = np.exp(w * DT), DT * (one - two), DT * two
    z, out = 0j, np.zeros(n + 1)
    for i, (f0, f1) in enumerate(zip(f[:-1].tolist(), f[1:].tolist(), strict=True)):
        z = growth * z + now * f0 + then * f1
        out[i + 1] = z.imag
    return out / w.imag
