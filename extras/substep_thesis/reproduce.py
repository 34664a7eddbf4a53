"""`substep reproduce`: the thesis's figures, the ledger and what was found; with `--full` the rest of the studies."""

import csv
import math
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import astuple, dataclass, fields
from fractions import Fraction
from functools import partial
from itertools import groupby
from multiprocessing import active_children, get_context
from operator import call
from pathlib import Path
from typing import Any

import numpy as np

from substep.core.schemes import Array, Scheme, scheme, schemes
from substep.core.threads import cores
from substep.derived import facade
from substep.derived.facade import CatalogueRow, catalogue_row
from substep.figures.charts import ERROR_RATIOS, RADIUS_RATIOS, save, save_csv, stability_figure
from substep.marching.run import march
from substep.studies import failures
from substep.studies.failures import maps
from substep.studies.precision import jobs as precision
from substep.studies.precision.cases import CASES

from . import claims, figures_5, page
from . import found as sentences
from .by_algebra import NEWMARK_SETS, SPLITS, Properties, properties
from .catalogue_charts import CHARTS, EQUAL_COST, stability_region, trade_off
from .claims.chapter_2 import OTHERS
from .claims.judgement import Judgement

GROWS = 5.0  # s, after which the page is written again while figures are drawn


def chapter_4_schemes(split: Fraction) -> dict[str, Scheme]:
    """The curves of one figure: the five sets of Table 4.1, and Bathe's scheme last."""
    drawn = {
        rf"Newmark-BDF2, $\gamma_t$ = {float(split):g}, $\beta$ = {float(beta):g}, $\gamma$ = {float(gamma):g}": scheme(
            "newmark_bdf2", gamma_t=float(split), beta=float(beta), gamma=float(gamma)
        )
        for beta, gamma in NEWMARK_SETS
    }
    return {**drawn, "Bathe": scheme("bathe")}


def figure_4(number: int, split: Fraction, folder: Path) -> None:
    """Figure 4.number: spectral radius, amplitude error and period error, as PNG, SVG and CSV."""
    drawn = chapter_4_schemes(split)
    radius: dict[str, Array] = {label: s.spectral_radius(2 * np.pi * RADIUS_RATIOS) for label, s in drawn.items()}
    amplitude = {label: s.amplitude_error(2 * np.pi * ERROR_RATIOS) for label, s in drawn.items()}
    period = {label: s.period_error(2 * np.pi * ERROR_RATIOS) for label, s in drawn.items()}
    figure = stability_figure(
        rf"Figure 4.{number}: spectral radius, amplitude and period error for $\gamma_t$ = {float(split):g}, $\xi$ = 0",
        (RADIUS_RATIOS, radius),
        (ERROR_RATIOS, amplitude, period),
    )
    save(
        figure, folder / f"figure_4_{number}", "Chapter 4",
        f"""Newmark-BDF2 at γ_t = {float(split):g} with the five sets (β, γ) of Table 4.1, and Bathe's scheme in black,
        on the undamped oscillator over h/T: (a) spectral radius, (b) amplitude error a period, (c) period error. Only
        γ = 1/2 is of second order: above it the amplitude error starts with a slope. Kumar 2015, figure
        4.{number}.""",
    )  # fmt: skip
    names = [f"beta={float(b):g} gamma={float(g):g}" for b, g in NEWMARK_SETS] + ["bathe"]
    panels = (
        ("a_spectral_radius", RADIUS_RATIOS, radius),
        ("b_amplitude_error", ERROR_RATIOS, amplitude),
        ("c_period_error", ERROR_RATIOS, period),
    )
    for panel, ratios, series in panels:
        save_csv(folder / f"figure_4_{number}{panel}.csv", ["h/T", *names], [ratios, *series.values()])


def parameter_sets() -> Iterator[tuple[str, dict[str, Fraction]]]:
    """(scheme, parameters) of every curve in chapter 4."""
    yield "bathe", {}
    for split in SPLITS:
        for beta, gamma in NEWMARK_SETS:
            yield "newmark_bdf2", {"gamma_t": split, "beta": beta, "gamma": gamma}


HEADER = (
    *("scheme", "gamma_t", "beta", "gamma", "rho_inf", "order"),
    *("damping: power of Omega", "damping: coefficient", "period error: power of Omega", "period error: coefficient"),
)


def property_row(case: tuple[str, dict[str, Fraction]]) -> list[str]:
    """A row under HEADER for (scheme, parameters), undamped and exact."""
    name, parameters = case
    found: Properties = properties(name, parameters)
    shown = [str(parameters[key]) if key in parameters else "" for key in ("gamma_t", "beta", "gamma")]
    terms = [("", "0") if term is None else (str(term[0]), term[1]) for term in (found.damping, found.period)]
    return [name, *shown, found.rho_inf, str(found.order), *terms[0], *terms[1]]


def certificates(folder: Path) -> None:
    """Prove for which Omega each curve of chapter 4 is stable, undamped: chapter_4_certificates.csv."""
    lines = [("scheme", "gamma_t", "beta", "gamma", "certificate", "its proof")]
    for name, parameters in parameter_sets():
        text = facade.certificate(name, **parameters).text
        result = next(line for line in text.splitlines() if line.startswith("Result: "))
        shown = (str(parameters.get(key, "")) for key in ("gamma_t", "beta", "gamma"))
        options = "".join(f" --{key.replace('_', '-')} {value}" for key, value in parameters.items())
        lines.append((name, *shown, result.removeprefix("Result: "), f"substep certify {name}{options}"))
    _write(folder / "chapter_4_certificates.csv", lines)


def tables(folder: Path, catalogue: list[CatalogueRow], rows: list[list[str]]) -> None:
    """Write the tables of every scheme at its default parameters and of chapter 4's parameter sets, as CSV."""
    _write(folder / "catalogue.csv", [[f.name for f in fields(CatalogueRow)], *(astuple(row) for row in catalogue)])
    _write(folder / "chapter_4_properties.csv", [HEADER, *rows])


def _write(path: Path, lines: Iterable[Iterable[object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows(lines)


@dataclass(frozen=True)
class Results:
    """What `reproduce` found: the ledger, the sentences with which the page opens, and outcomes where methods fail."""

    claims: list[Judgement]
    found: list[sentences.Found]
    failures: list[failures.Row]


def failure_map(folder: Path) -> None:
    """The map of failures of the thesis's scheme over the step and gamma_t."""
    maps.draw(folder, maps.MAPS[0], failures.QUICK_POINTS)


def jobs(full: bool) -> tuple[Callable[[Path], object], ...]:
    """The jobs that measure no time, one for each figure, chart or table; full: those of the catalogue too.

    The first two, a figure of each chapter of the thesis, compile the kernels of all its figures. The map of failures
    is among those of the battery, which only the full form runs.
    """
    chapter_4 = [partial(figure_4, number, split) for number, split in enumerate(SPLITS, start=1)]
    thesis = (chapter_4[0], figures_5.JOBS[0], *chapter_4[1:], *figures_5.JOBS[1:])
    light = (stability_region, trade_off, certificates)
    rest = (*(chart for chart in CHARTS if chart not in light), precision.operations, *figures_5.LONG_JOBS)
    return (*thesis, *light, *(rest if full else (failure_map,)))


def _draw(folder: Path, full: bool, i: int) -> None:
    """Run the job at place i of `jobs(full)`, in a process of its own."""
    jobs(full)[i](folder)


def chapters() -> list[list[claims.Claim]]:
    """The claims by chapter: those of one share runs, so that one process judges them."""
    return [list(own) for _, own in groupby(claims.CLAIMS, key=lambda claim: claim.id[:2])]


def _judged(own: list[claims.Claim]) -> list[Judgement]:
    return [claims.judged(claim) for claim in own]


def _compile(full: bool, names: Sequence[str]) -> None:
    """Compile kernels of schemes into numba's cache, in a process of its own, since numba compiles on one core."""
    for name in names:
        s = scheme(name)
        s.stability(1.0)
        models = [case.make() for case in CASES] if full else []
        if full and name in failures.outcomes.QUICK:
            models += [case.make() for case in failures.table.CASES]
        for model in models:
            march(model, s, 1e-4, 2e-4)


def compiled_ahead(full: bool) -> list[list[str]]:
    """Names of schemes whose kernels jobs and judges need besides those of the first figures, as `sharing` has them."""
    return sharing(schemes() if full else {*OTHERS, *EQUAL_COST})


def sharing(names: Iterable[str]) -> list[list[str]]:
    """Names of schemes, those that share a module together, so that no two processes compile it; the most first.

    Before them come one for each module that finds eigenvalues, so that each is compiled by one process, as soon as
    there is one: all others then read it from numba's cache. Those for many eigenvalues take longest, and begin.
    """
    found: dict[object, list[str]] = {}
    for name in sorted(names, key=schemes().index):
        found.setdefault(scheme(name).info.module, []).append(name)
    groups = sorted(found.values(), key=len, reverse=True)
    kinds = [scheme(group[0]).kernels.EIGENVALUES for group in groups]
    first = sorted({kinds.index(kind) for kind in kinds}, key=lambda i: (not kinds[i].endswith("_twice"), i))
    return [groups[i] for i in (*first, *(i for i in range(len(groups)) if i not in first))]


@contextmanager
def _workers() -> Iterator[Callable[..., Iterator[Any]]]:
    """A `map` over one process for each core, which begins at once, or the built-in one if there is only one core.

    Ctrl-C, or an error, ends the processes in the middle of their jobs; they leave Ctrl-C to the one that waits here.
    """
    if cores() == 1:
        yield map
        return
    others, spawn = active_children(), get_context("spawn")
    pool = ProcessPoolExecutor(cores(), spawn, signal.signal, (signal.SIGINT, signal.SIG_IGN))
    try:
        yield pool.map
    except BaseException:
        for process in active_children():
            if process not in others:
                process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@dataclass(frozen=True)
class Stage:
    """A part of `reproduce`: its name, how many jobs it has, and about how many CPU seconds each of them takes.

    alone: nothing runs beside these jobs, since they measure times.
    """

    name: str
    jobs: int
    seconds: float
    alone: bool = False


def stages(full: bool = False) -> tuple[Stage, ...]:
    """What `reproduce` does, in the order in which it begins; the seconds are those of a first run."""
    ahead = len(compiled_ahead(full)) if cores() > 1 else 0
    light = (
        Stage("drawing", len(jobs(full)), 2.5),
        Stage("compiling", ahead, 8.0 if full else 3.5),
        Stage("judging", len(chapters()) + len(sentences.SENTENCES), 4.0),
    )
    battery, timed = failures.count(), len(precision.jobs(False))
    rest = (
        Stage("where methods fail", battery, 3.0),
        Stage("timing", timed, 20.0, alone=True),
        Stage("drawing times", timed, 5.0),
    )
    return (*light, *(rest if full else ()))


def reproduce(folder: Path, step: Callable[[str], object], *, full: bool = False) -> Results:
    """Write everything into the folder; full: the studies of the catalogue, timings and long runs as well.

    The page grows as figures come, and is complete for what there is when this ends, also by an error or Ctrl-C.
    step(name): called after each job of each of the `stages(full)`, with the stage's name.
    """
    folder.mkdir(parents=True, exist_ok=True)
    page.pictures(folder)  # raises for a figure that the page would refuse, before the work
    try:
        return _reproduce(folder, step, full)
    finally:
        page.write(folder)


def _reproduce(folder: Path, step: Callable[[str], object], full: bool) -> Results:
    draw, numbers = partial(_draw, folder, full), range(len(jobs(full)))
    drawn, written = 0, -math.inf

    def waited(stage: str, results: Iterator[Any]) -> list[Any]:
        return [(one, step(stage))[0] for one in results]

    def grown(stage: str, results: Iterator[Any]) -> None:
        nonlocal drawn, written
        for _ in results:
            step(stage)
            drawn += 1
            if time.monotonic() > written + GROWS:
                page.write(folder, f"{drawn} of {len(numbers)} figures and tables are drawn")
                written = time.monotonic()

    with _workers() as each:
        grown("drawing", each(draw, numbers[:2]))
        compiled = each(partial(_compile, full), compiled_ahead(full) if each is not map else [])
        figures = each(draw, numbers[2:])
        parts = each(partial(failures.part, folder, False), range(failures.count()) if full else ())
        judged, found = each(_judged, chapters()), each(call, sentences.SENTENCES)
        waited("compiling", compiled)
        grown("drawing", figures)
        outcomes = failures.joined(folder, waited("where methods fail", parts)) if full else []
        ledger = [judgement for own in waited("judging", judged) for judgement in own]
        results = Results(ledger, waited("judging", found), outcomes)
        tables(folder, [catalogue_row(name) for name in schemes()], [property_row(case) for case in parameter_sets()])
        claims.write(folder, results.claims)
        sentences.write(folder, results.found)
        if full:
            page.write(folder, "times are being measured")
            timed = waited("timing", (job(folder) for job in precision.jobs(False)))  # nothing else runs beside these
            waited("drawing times", each(call, timed))
    return results
