"""Stability functions at many points, every input an array."""

import numpy as np

from . import limits, ours, peers, reference
from .job import Job, Table
from .linear import SCHEMES, scheme
from .timing import Alternative, cores, measure

NAME = "stability"
SAME, FAR = "C, same digits", "C, far formula alone"
COLUMNS = {
    "rho": "largest difference from 50 digits",
    "damping": "largest difference from 50 digits",
    "period": "largest difference from 50 digits",
    "period, relative": "the same over the period error itself, where small Omega loses its digits",
}


def random_points(name: str, n: int) -> tuple[np.ndarray, ...]:
    """Omega, xi and the scheme's parameters, drawn beside its usual values."""
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
    """All three functions, and the spectral radius alone."""
    found = Job(NAME, "Stability functions, random Omega, xi and parameters, one core")
    n, rounds = (1 << 16, 7) if quick else (1 << 17, 15)
    with cores(1):
        for name in list(SCHEMES)[: 1 if quick else None]:
            _scheme(found, name, n, rounds)
    found.notes.append(
        "C is bound by the divider (four divisions and three square roots a vector, four more divisions for a third "
        f"eigenvalue). '{FAR}' keeps no more digits than the formula with P and Q; '{SAME}' computes, as substep does, "
        "the points below Omega = 0.125 from the defect of the exact eigenvalue, which buys the digits of small Omega."
    )
    return found


def _scheme(found: Job, name: str, n: int, rounds: int) -> None:
    points, (Omega, xi, *parameters) = random_points(name, n), random_points(name, n)
    handle = ours.handle(name, tuple(parameters))
    few = slice(0, 4096)
    matrices = ours.handle(name, tuple(p[few] for p in parameters)).amplification(Omega[few], xi[few])
    short = tuple(x[few] for x in points)
    three = [
        Alternative("substep", "substep", lambda: ours.stability(handle, Omega, xi), n, _errors(name, points, True))
    ]
    one = [Alternative("substep", "substep", lambda: ours.radius(handle, Omega, xi), n, _errors(name, points, False))]
    try:
        C, out = limits.Stability(name), np.empty((3, n))
        three.append(Alternative(SAME, "limit", lambda: C.all(points, out), n, _errors(name, points, True)))
        three.append(Alternative(FAR, "limit", lambda: C.all_far(points, out), n, _errors(name, points, True)))
        one.append(Alternative("C", "limit", lambda: C.radius(points, out[0]), n, _errors(name, points, False)))
    except limits.MissingCompilerError as error:
        found.skipped["C"] = str(error)
    try:
        closed = peers.closed_form(name)
        three.append(
            Alternative("NumPy, closed form", "peer", lambda: closed(*short), len(short[0]), _errors(name, short, True))
        )
    except ValueError as error:
        found.skipped[f"closed form of {name}"] = str(error)
    three.append(
        Alternative(
            "np.linalg.eigvals", "peer", lambda: peers.eigenvalues(matrices, Omega[few], xi[few]), len(matrices),
            _errors(name, short, True),
        )
    )  # fmt: skip
    tables = [
        Table(f"{name}: rho, numerical damping, period error", "point", measure(three, rounds), COLUMNS),
        Table(f"{name}: rho alone", "point", measure(one, rounds), {"rho": COLUMNS["rho"]}),
    ]
    found.tables += tables
    for limit in (SAME, FAR):
        found.compare(tables[0], f"stability, {name}, all three: substep / {limit}", "substep", limit, "<=", 1.1)
    found.compare(tables[1], f"stability, {name}, rho alone: substep / C", "substep", "C", "<=", 1.1)
    found.compare(tables[0], f"stability, {name}: eigvals / substep", "np.linalg.eigvals", "substep", ">=", 500)
