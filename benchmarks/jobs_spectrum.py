"""Response spectrum: many oscillators under one record, with their peaks only, and with their whole history."""

import numpy as np

import substep as ss

from . import limits, ours, peers, reference
from .job import BESIDE_C, Job, Table
from .linear import SCHEMES, TwoLoads, exact_peaks, record, scheme
from .timing import Alternative, cores, measure

NAME = "spectrum"
LANES, DT, XI = 480, 0.01, 0.05
OMEGAS = 2 * np.pi * np.geomspace(0.1, 10.0, LANES)


def job(quick: bool) -> Job:
    """480 oscillators, 4096 steps."""
    n, rounds = 4096, 5 if quick else 11
    found = Job(NAME, f"Response spectrum and history, {LANES} lanes x {n} steps under one record, one core")
    with cores(1):
        for name in list(SCHEMES)[: 1 if quick else None]:
            table = _peaks(found, name, n, rounds)
            found.tables.append(table)
            best = "C, companion" if table.row("C, companion") else "C, 3x3 map"
            found.compare(table, f"response spectrum, {name}: substep / {best}", "substep", best, "<=", BESIDE_C)
            for peer, bound in (("scipy lfilter", 50), ("pyyeti srs", 50), ("eqsig", 200)):
                if name == "newmark_bdf2":
                    found.compare(table, f"response spectrum, {name}: {peer} / substep", peer, "substep", ">=", bound)
        _whole_spectrum(found, n, rounds)
        _history(found, "newmark_bdf2", n, rounds)
    found.notes.append(
        "'exact' holds the peak against the exact response to the record, linear between its samples: of a scheme it "
        "is the discretisation, of peers that solve exactly their rounding. 'scheme' holds three lanes against the "
        "same scheme in 50 digits. C gets its coefficients ready made; substep computes them within the time."
    )
    return found


def _peaks(found: Job, name: str, n: int, rounds: int) -> Table:
    f, work = record(n, DT), LANES * n
    load = ss.Record(DT, f)
    exact = exact_peaks(tuple(OMEGAS), XI, n, DT)[0]
    loads = TwoLoads.of(scheme(name), OMEGAS * DT, XI)
    forces = f * DT**2
    some = (0, LANES // 2, LANES - 1)
    same = [np.abs(reference.march(name, float(OMEGAS[i] * DT), XI, forces, n)).max() for i in some]

    def against_exact(peak: np.ndarray) -> dict[str, float]:
        return {"exact": float(np.abs(peak / exact - 1.0).max())}

    def against_both(peak: np.ndarray) -> dict[str, float]:
        return {**against_exact(peak), "scheme": float(np.abs(peak[list(some)] / same - 1.0).max())}

    def add(label: str, kind, run, errors=against_both) -> None:
        try:
            run()
        except (peers.MissingPeerError, limits.MissingCompilerError) as error:
            found.skipped[label] = str(error)
        else:
            rows.append(Alternative(label, kind, run, work, errors))

    rows: list[Alternative] = []
    add("substep", "substep", lambda: ours.spectrum_peaks(name, OMEGAS, XI, load))
    peak, peaks = np.empty(LANES), np.empty((3, LANES))
    if len(loads.D) == 2:
        companion, (numerator, denominator) = loads.companion(), loads.filter()
        damping, stiffness = 2 * XI * OMEGAS * DT, (OMEGAS * DT) ** 2
        add("C, companion", "limit", lambda: limits.companion_peaks(companion, forces, peak).copy())
        add("C, 2x2 map", "limit", lambda: limits.map_peaks(loads.D, loads.B0, loads.B1, forces, peak).copy())
        more = (loads.D, loads.B0, loads.B1, damping, stiffness, forces, peaks)
        add("C, 2x2 map, peaks of u, v, a", "limit", lambda: np.array(limits.all_peaks(*more)[0]))
        add("scipy lfilter", "peer", lambda: peers.lfilter_peaks(numerator, denominator, forces))
    else:
        add("C, 3x3 map", "limit", lambda: limits.map_peaks(loads.D, loads.B0, loads.B1, forces, peak).copy())
    if name == "newmark_bdf2":
        add("pyyeti srs", "peer", lambda: peers.pyyeti_peaks(OMEGAS, XI, f, DT), against_exact)
        add("eqsig", "peer", lambda: peers.eqsig_peaks(OMEGAS, XI, f, DT), against_exact)
        add(
            "NumPy across lanes", "peer",
            lambda: peers.numpy_across_lanes(loads.D, loads.B0, loads.B1, forces),
        )  # fmt: skip
    errors = {"exact": "peak against the exact response", "scheme": "peak against the scheme in 50 digits"}
    return Table(f"{name}: peak |u|", "lane-step", measure(rows, rounds), errors)


def _whole_spectrum(found: Job, n: int, rounds: int) -> None:
    """SD, SV and SA, three peaks a lane: the march alone, and as a user asks for them."""
    f, work, exact, rows = record(n, DT), LANES * n, exact_peaks(tuple(OMEGAS), XI, n, DT), []
    load, march, call = ss.Record(DT, f), "substep, the march in it", "substep, average_acceleration"
    ways = {
        march: lambda: ours.three_peaks("average_acceleration", OMEGAS, XI, load),
        call: lambda: ours.spectrum("average_acceleration", OMEGAS, XI, f, DT),
        "substep, the same with its error": lambda: ours.spectrum("average_acceleration", OMEGAS, XI, f, DT, True),
        "substep, the exact reference": lambda: ours.exact_spectrum(OMEGAS, XI, f, DT),
        "pyyeti srs, three times": lambda: peers.pyyeti_spectrum(OMEGAS, XI, f, DT),
        "eqsig response_series": lambda: peers.eqsig_spectrum(OMEGAS, XI, f, DT),
    }
    for label, run in ways.items():
        try:
            run()
        except peers.MissingPeerError as error:
            found.skipped[label] = str(error)
        else:
            kind = "substep" if label.startswith("substep") else "peer"
            rows.append(Alternative(label, kind, run, work, lambda peaks: _three(peaks, exact)))
    own = scheme("average_acceleration")
    loads, peaks = TwoLoads.of(own, OMEGAS * DT, XI), np.empty((3, LANES))
    numbers = (loads.D, loads.B0, loads.B1, 2 * XI * OMEGAS * DT, (OMEGAS * DT) ** 2, f * DT**2, peaks)
    label = "C, 2x2 map, peaks of u, v, a"
    try:
        limits.all_peaks(*numbers)
    except limits.MissingCompilerError as error:
        found.skipped[label] = str(error)
    else:
        rows.append(Alternative(label, "limit", lambda: limits.all_peaks(*numbers), work))
    against = {name: f"{name} against the exact response" for name in ("SD", "SV", "SA")}
    table = Table("SD, SV, SA", "lane-step", measure(rows, rounds), against)
    found.tables.append(table)
    found.compare(table, "SD, SV, SA: substep, the march / C", march, label, "<=", BESIDE_C)
    found.compare(table, "SD, SV, SA: response_spectrum / the march in it", call, march, "<=", 1.5)


def _three(peaks: np.ndarray, exact: np.ndarray) -> dict[str, float]:
    return dict(zip(("SD", "SV", "SA"), np.abs(peaks / exact - 1.0).max(axis=1), strict=True))


def _history(found: Job, name: str, n: int, rounds: int) -> None:
    """u, v and a of every step and lane."""
    f = record(n, DT)
    load = ss.Record(DT, f)
    loads = TwoLoads.of(scheme(name), OMEGAS * DT, XI)
    forces, size = f * DT**2, 3 * LANES * (n + 1)
    damping, stiffness = 2 * XI * OMEGAS * DT, (OMEGAS * DT) ** 2
    try:
        out = limits.aligned((n + 1, 3, LANES))
        limits.write(out, stream=True)
    except limits.MissingCompilerError as error:
        found.skipped["C, history"] = str(error)
        return
    out[0] = 0.0
    C = limits.history(loads.D, loads.B0, loads.B1, damping, stiffness, forces, out)[::512, 0].copy()

    def fresh() -> None:
        limits.write(limits.aligned((n + 1, 3, LANES)), stream=False)

    def errors(u: np.ndarray) -> dict[str, float]:
        """Largest difference from C of u (steps, lanes) at every 512th step, relative to the largest u."""
        return {"C": float(np.abs(u - C).max() / np.abs(C).max())}

    def by_c() -> np.ndarray:
        out[0] = 0.0
        return limits.history(loads.D, loads.B0, loads.B1, damping, stiffness, forces, out)

    rows = [
        Alternative(
            "substep", "substep", lambda: ours.history(name, OMEGAS, XI, load, out), size,
            lambda found: errors(found[::512, 0]),
        ),
        Alternative("C, 2x2 map, history", "limit", by_c, size, lambda found: errors(found[::512, 0])),
        Alternative("stores past the caches", "limit", lambda: limits.write(out, stream=True), size),
        Alternative("stores through the caches", "limit", lambda: limits.write(out, stream=False), size),
        Alternative("fresh pages, zeroed, stored", "limit", fresh, size),
    ]  # fmt: skip
    table = Table(
        f"{name}: history of u, v, a", "double", measure(rows, rounds), {"C": "u against C's, of the largest"}
    )
    found.tables.append(table)
    found.compare(table, "history into memory: substep / C", "substep", "C, 2x2 map, history", "<=", BESIDE_C)
