"""Laws with memory: oscillators with a bilinear spring in lanes, and spectra of constant ductility."""

from functools import partial
from typing import Any

import numpy as np

import substep as ss

from . import limits, ours, peers
from .job import BESIDE_C, Goal, Job, Table
from .jobs_startup import compiling
from .linear import record
from .peers_march import OpenSees, OpenSeesBuilding
from .timing import Alternative, Measured, cores, measure

NAME = "laws"
LANES = (48, 480, 4800)
N, DT, XI, HARDENING, REDUCED = (
    1560,
    0.02,
    0.05,
    0.05,
    4.0,
)  # strengths: those with which they just stay elastic, over 4
DUCTILITIES, PERIODS = (1.0, 1.5, 2.0, 4.0, 8.0), np.geomspace(0.05, 5.0, 100)
STORIES, STEPS, SINGLY, FINE = 10, 10_000, 500, 0.01  # of a building: its steps, s, and how many are taken one by one
BUILDINGS, SHORT = 480, 1000  # in a sweep, and the steps of each in a short one
SCHEME, PEAKS = "average_acceleration", "substep, peaks of |u|, as inelastic spectra take them"
BEFORE = "import numpy as np, substep as ss; given = dict(omega=6.0, load=ss.HalfSine(9.0, 0.6))"
ONE = f"ss.march(ss.scene('hysteretic_oscillator', strength=2.0, **given), '{SCHEME}', 0.1, 1.0)"
MANY = (
    "given |= dict(dt=0.1, t_end=1.0, keep='final', strength=np.linspace(1, 2, 64))\n"
    f"ss.sweep('hysteretic_oscillator', '{SCHEME}', **given)"
)
COMPILED = {"one oscillator": ONE, "lanes": MANY}


def job(quick: bool) -> Job:
    """48, 480 and 4800 oscillators under one record; 5 ductilities of 100 periods; one oscillator of OpenSees."""
    found = Job(NAME, f"Bilinear oscillators, {N} steps under one record, {SCHEME}, one core")
    rounds = 5 if quick else 11
    with cores(1):
        for lanes in LANES:
            found.tables.append(_lanes(found, lanes, rounds))
        _spectrum(found, rounds)
        _building(found, rounds)
    rows = [Measured(x, "substep", np.array([compiling(BEFORE, call)]), {}) for x, call in COMPILED.items()]
    found.tables.append(Table("derived, printed and compiled in a new process, nothing cached: CPU time", "pair", rows))
    found.notes.append(
        "C takes its coefficients ready made. Its own step adds the balances of both ends of a step, and corrects an "
        "elastic trial where the spring yields; 'the printed step' is that of substep's kernel, without its look for "
        f"lanes that stop. Strengths are those of the elastic spectrum over {REDUCED:g}, hardening {HARDENING:g}."
    )
    return found


def _lanes(found: Job, lanes: int, rounds: int) -> Table:
    omegas = 2 * np.pi * np.geomspace(0.2, 10.0, lanes)
    load, work = ss.Record(DT, record(N, DT)), lanes * N
    strengths = omegas**2 * ours.spectrum_peaks(SCHEME, omegas, XI, load) / REDUCED
    given = omegas, XI, strengths, HARDENING, load
    out = np.empty((6, lanes))
    own, kernel = ours.bilinear(*given), ours.bilinear_kernel(*given)
    u, lost = own.state[:, 0, 0], own.remembered[:, -1]

    def apart(last: np.ndarray) -> float:
        return float(np.abs(last - u).max() / np.abs(u).max())

    rows = [
        Alternative("substep", "substep", lambda: ours.bilinear(*given), work),
        Alternative("substep, the kernel in it", "substep", kernel, work, lambda found: {"u": apart(found)}),
        Alternative(PEAKS, "substep", lambda: ours.yielding_peaks(*given), work),
        Alternative(
            "substep, elastic, peaks of |u|", "substep", lambda: ours.spectrum_peaks(SCHEME, omegas, XI, load), work
        ),
        Alternative(
            "substep, elastic, peaks of u, v, a", "substep", lambda: ours.three_peaks(SCHEME, omegas, XI, load), work
        ),
    ]  # fmt: skip

    try:
        for label, (way, numbers, loads, scale) in _in_c(*given[:4]).items():

            def march(way: str = way, numbers: np.ndarray = numbers, loads: np.ndarray = loads) -> np.ndarray:
                return limits.bilinear(way, numbers, loads, out)

            def errors(found: np.ndarray, scale: np.ndarray = scale) -> dict[str, float]:
                energy = np.abs(found[4] * scale / lost - 1).max()
                return {"u": apart(found[0])} | ({"energy": float(energy)} if scale.any() else {})

            march()
            rows.append(Alternative(label, "limit", march, work, errors))
    except limits.MissingCompilerError as error:
        found.skipped["C"] = str(error)
    if lanes == LANES[1]:
        rows += _opensees(found, omegas[lanes // 2], strengths[lanes // 2], load, float(u[lanes // 2]))
    of = {"u": "last u against substep's, of the largest", "energy": "dissipated energy against substep's"}
    table = Table(f"{lanes} lanes", "lane-step", measure(rows, rounds), of)
    text = f"bilinear, {lanes} lanes: "
    fused, elastic = "substep, the kernel in it", "substep, elastic, peaks of u, v, a"
    for row in ("C, the printed step", "C, with energies"):
        found.compare(table, text + f"the kernel / {row}", fused, row, "<=", BESIDE_C)
    found.compare(table, text + "substep / the kernel in it", "substep", fused, "<=", 1.5)
    found.compare(table, text + "substep / elastic spectrum", "substep", elastic, "<=", 3.0)
    found.compare(table, text + "peaks of |u| / elastic spectrum", PEAKS, elastic, "<=", 3.0)
    if lanes == LANES[1]:
        found.compare(table, "bilinear: openseespy Steel01 / substep", "openseespy Steel01", "substep", ">=", 300)
    return table


def _in_c(
    omegas: np.ndarray, xi: float, strengths: np.ndarray, alpha: float
) -> dict[str, tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Ways of C: function, numbers and loads as laws.c takes them, and the factor of the energy dissipated (or 0)."""
    quarter, f, k, one = DT**2 / 4, record(N, DT), omegas**2, np.ones_like(omegas)
    hard, soft, damping = alpha * k, (1 - alpha) * k, 2 * xi * omegas
    A, B, mass = quarter * hard, quarter * soft, 1 + damping * DT / 2
    few = np.stack([1 / (mass + A + B), 1 / (mass + A), 2 * A, B, quarter * (1 - alpha) * strengths])
    yields, sticks = 1 / (mass + A), 1 / (mass + quarter * k)
    branches = [yields, yields * hard, yields * (1 - alpha) * strengths, sticks, sticks * soft, sticks * k]
    printed = np.stack([DT * one, quarter * one, damping, *branches, strengths / k, soft, hard / 2, soft / 2])
    sums, ends = quarter * (f[:-1] + f[1:]), f[1:].copy()
    return {
        "C": ("bilinear", few, sums, 0 * one),
        "C, with energies": ("bilinear_energy", few, sums, 4 / (B * DT**2)),
        "C, the printed step": ("bilinear_printed", printed, ends, one),
    }


def _opensees(found: Job, omega: float, strength: float, load: ss.Record, u: float) -> list[Alternative]:
    """One of the oscillators, all steps in one call of analyze."""
    try:
        material = "Steel01", float(strength), float(omega) ** 2, HARDENING
        program = OpenSees("Newmark", float(omega), XI, load.samples, DT, material)
    except peers.MissingPeerError as error:
        found.skipped["openseespy Steel01"] = str(error)
        return []
    return [
        Alternative(
            "openseespy Steel01", "peer", program.run, N, lambda last: {"u": float(abs(last[0] - u) / abs(u))}
        )
    ]  # fmt: skip


def _building(found: Job, rounds: int) -> None:
    """Ten stories, about half of them yielding: many steps in a kernel, or each of them in Python."""
    f = record(STEPS, FINE)
    k = 2.0e7 * np.linspace(1.5, 0.7, STORIES)
    strengths = 0.35 * 2e4 * np.abs(f).max() * np.cumsum(np.ones(STORIES))[::-1] * np.linspace(1.0, 2.0, STORIES)
    stories = [(2e4, float(x), float(y), float(2e-3 * x)) for x, y in zip(k, strengths, strict=True)]
    given = stories, HARDENING, f, FINE
    ours_, singly = ours.building(*given), ours.building(*given, singly=True)
    whole = ours_(STEPS)
    first, u = np.asarray(singly(SINGLY).u), np.asarray(whole.u)

    def apart(last: np.ndarray) -> dict[str, float]:
        return {"u": float(np.abs(last - u[-1]).max() / np.abs(u).max())}

    rows = [
        Alternative("substep", "substep", lambda: ours_(STEPS), STEPS),
        Alternative("substep, with energies", "substep", lambda: ours_(STEPS, account=True), STEPS),
        Alternative(
            f"substep, {SINGLY} steps one by one", "substep", lambda: singly(SINGLY), SINGLY,
            lambda _: {"u": float(np.abs(first - u[: SINGLY + 1]).max() / np.abs(u).max())},
        ),
    ]  # fmt: skip
    many, swept = ours.buildings(*given, np.linspace(1.0, 1.5, BUILDINGS)), dict[int, str]()
    for steps in (STEPS, SHORT):
        largest = np.abs(u[: steps + 1]).max(axis=0)
        swept[steps] = f"substep, {BUILDINGS} buildings in a sweep, {steps} steps"

        def of_peaks(ds: Any, largest: np.ndarray = largest) -> dict[str, float]:
            return {"u": float(np.abs(ds.peak_u[0, 0] - largest).max() / largest.max())}

        march = partial(many, steps)
        rows.append(Alternative(swept[steps], "substep", march, BUILDINGS * steps, of_peaks))
    try:
        program = OpenSeesBuilding(*given)
        rows.append(Alternative("openseespy", "peer", program.run, STEPS, apart))
    except peers.MissingPeerError as error:
        found.skipped["openseespy, building"] = str(error)
    of = {"u": "u against substep's, of the largest"}
    table = Table(f"a building of {STORIES} bilinear stories, {STEPS} steps", "step", measure(rows, rounds), of)
    found.tables.append(table)
    yielding = int((np.ptp(whole.memory["p"], axis=0) > 0).sum())
    found.notes.append(
        f"{yielding} of the building's {STORIES} stories yield; histories of u, v, a, drifts and shears."
    )
    found.compare(table, "building: openseespy / substep", "openseespy", "substep", ">=", 50)
    found.compare(table, "building in a sweep of many: openseespy / substep", "openseespy", swept[STEPS], ">=", 300)
    found.compare(table, "building: one by one / substep", f"substep, {SINGLY} steps one by one", "substep", ">=", 100)


def _spectrum(found: Job, rounds: int) -> None:
    """Constant ductility: all strengths that are looked for within the time."""
    f = record(N, DT)

    def spectrum(errors: bool, tolerance: float = 0.01):
        return ss.inelastic_spectrum(f, DT, PERIODS, XI, ductility=DUCTILITIES, tolerance=tolerance, errors=errors)

    near, asked = spectrum(False, 1e-6), np.array(DUCTILITIES)[:, None]

    def errors(s) -> dict[str, float]:
        values = {"ductility": float(np.abs(s.ductility_demand.values / asked - 1).max())}
        values["strength"] = float(np.abs(s.A_y.values / near.A_y.values - 1).max())
        if "displacement_error" in s:
            values["scheme"] = float(np.median(s.displacement_error.values))
        return values

    plain, whole = "substep", "substep, with errors"
    rows = [
        Alternative(plain, "substep", lambda: spectrum(False), 1, errors),
        Alternative(whole, "substep", lambda: spectrum(True), 1, errors),
        Alternative(
            "substep, the elastic spectrum", "substep",
            lambda: ours.spectrum(SCHEME, 2 * np.pi / PERIODS, XI, f, DT), 1,
        ),
    ]  # fmt: skip
    of = {
        "ductility": "the largest miss of what was asked, 1 % allowed",
        "strength": "A_y against that of a tolerance of 1e-6",
        "scheme": "median displacement_error, from half the step",
    }
    table = Table(f"{len(DUCTILITIES)} ductilities x {len(PERIODS)} periods", "spectrum", measure(rows, rounds), of)
    found.tables.append(table)
    for name in (plain, whole):
        row = table.row(name)
        assert row is not None
        found.goals.append(Goal(f"{table.title}: {name}", "<=", 0.1, row.seconds, unit="s"))
    row = table.row(plain)
    assert row is not None
    found.goals.append(Goal("ductility of the strengths found", "<=", 0.01, row.errors["ductility"], unit=""))
