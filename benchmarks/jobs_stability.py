"""Stability functions at many points, every input an array."""

from functools import partial

import numpy as np

from . import limits, ours, peers, reference
from .job import BESIDE_C, Job, Table
from .linear import SCHEMES, scheme
from .timing import Alternative, cores, measure

NAME = "stability"
SAME, FAR = "C, same digits", "C, far formula alone"
COLUMNS = {
    "rho": "largest difference from 50 digits",
    "damping": "largest difference from 50 digits",
    "period": "largest difference from 50 digits",
    "period, relative": "the difference relative to the period error itself, which is small with Omega",
}


def random_points(name: str, n: int) -> tuple[np.ndarray, ...]:
    """Random Omega, xi and parameters of the scheme, these within 2 % above its usual values."""
    random = np.random.default_rng(2015)
    Omega, xi = 10.0 ** random.uniform(-2, 1, n), random.uniform(0.0, 0.2, n)
    own = scheme(name).parameters
    return Omega, xi, *(float(value) * random.uniform(1.0, 1.02, n) for value in own.values())


def _errors(name: str, points: tuple[np.ndarray, ...], both: bool):
    """Largest errors against 50 digits at a few points, the first 24 of them the smallest Omega."""
    few = [*np.argsort(points[0])[:24], *range(0, len(points[0]), max(1, len(points[0]) // 24))]
    exact = np.array([reference.spectrum(name, *(float(x[i]) for x in points)) for i in few])

    def errors(found) -> dict[str, float]:
        rows = [x[: len(points[0])] for x in (found if both else (found,))]
        difference = [np.abs(row[np.array(few)] - exact[:, k]) for k, row in enumerate(rows)]
        if both:
            difference.append(difference[2] / np.abs(exact[:, 2]))
        return {key: float(np.nanmax(d)) for key, d in zip(COLUMNS, difference, strict=False)}

    return errors


def job(quick: bool) -> Job:
    """All three functions, points at random and as a sweep has them, and the spectral radius alone."""
    found = Job(NAME, "Stability functions, random Omega, xi and parameters, one core")
    n, rounds = (1 << 16, 7) if quick else (1 << 17, 15)
    with cores(1):
        for name in list(SCHEMES)[: 1 if quick else None]:
            points = random_points(name, n)
            order = np.argsort(points[0])
            _three(found, name, "at random", points, rounds)
            sweep = _three(found, name, "in a sweep, Omega increasing", tuple(x[order] for x in points), rounds)
            radius = _radius(found, name, random_points(name, 2 * n), rounds)  # the 7 us of a call hardly count
            for table, what in ((sweep, "sweep, all three"), (radius, "rho alone")):
                text = f"stability, {name}, {what}: substep / {SAME}"
                found.compare(table, text, "substep", SAME, "<=", BESIDE_C)
    found.notes.append(
        f"'{FAR}' keeps no more digits than the formula with P and Q; '{SAME}' computes, as substep does, the points "
        "near Omega = 0 from the defect of the exact eigenvalue, which buys the digits there. C packs such points "
        "where they stand among others; substep computes both formulas for a block that has some."
    )
    return found


def _limit(found: Job, name: str) -> "limits.Stability | None":
    try:
        return limits.Stability(name)
    except limits.MissingCompilerError as error:
        found.skipped["C"] = str(error)
        return None


def _short(name: str, points: tuple[np.ndarray, ...]) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """About 4096 of the points, and their amplification matrices."""
    few = tuple(np.ascontiguousarray(x[:: len(x) // 4096]) for x in points)
    return few, ours.handle(name, few[2:]).amplification(*few[:2])


def _three(found: Job, name: str, how: str, points: tuple[np.ndarray, ...], rounds: int) -> Table:
    (Omega, xi, *parameters), n = points, len(points[0])
    handle, errors, out = ours.handle(name, tuple(parameters)), _errors(name, points, True), np.empty((3, n))
    rows = [Alternative("substep", "substep", lambda: ours.stability(handle, Omega, xi), n, errors)]
    if C := _limit(found, name):
        rows.append(Alternative(SAME, "limit", lambda: C.all(points, out), n, errors))
        rows.append(Alternative(FAR, "limit", lambda: C.all_far(points, out), n, errors))
    few, matrices = _short(name, points)
    errors = _errors(name, few, True)
    try:
        closed = peers.closed_form(name)
        rows.append(Alternative("NumPy, closed form", "peer", lambda: closed(*few), len(few[0]), errors))
    except ValueError as error:
        found.skipped[f"closed form of {name}"] = str(error)
    by_eigenvalues = partial(peers.eigenvalues, matrices, *few[:2])
    rows.append(Alternative("np.linalg.eigvals", "peer", by_eigenvalues, len(matrices), errors))
    title = f"{name}, {how}: rho, numerical damping, period error"
    found.tables.append(Table(title, "point", measure(rows, rounds), COLUMNS))
    return found.tables[-1]


def _radius(found: Job, name: str, points: tuple[np.ndarray, ...], rounds: int) -> Table:
    (Omega, xi, *parameters), n = points, len(points[0])
    handle, errors, out = ours.handle(name, tuple(parameters)), _errors(name, points, False), np.empty(n)
    rows = [Alternative("substep", "substep", lambda: ours.radius(handle, Omega, xi), n, errors)]
    if C := _limit(found, name):
        rows.append(Alternative("C", "limit", lambda: C.radius(points, out), n, errors))
        rows.append(Alternative(SAME, "limit", lambda: C.radius_same(points, out), n, errors))
    few, matrices = _short(name, points)
    largest = partial(peers.radius, matrices)
    rows.append(Alternative("np.linalg.eigvals", "peer", largest, len(matrices), _errors(name, few, False)))
    found.tables.append(Table(f"{name}: rho alone", "point", measure(rows, rounds), {"rho": COLUMNS["rho"]}))
    return found.tables[-1]
