"""`substep reproduce`: the thesis's figures, the other charts, tables and the ledger, with all numbers behind them."""

import csv
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import astuple, dataclass, fields
from fractions import Fraction
from functools import partial
from multiprocessing import active_children, get_context
from operator import call
from pathlib import Path
from typing import Any

import numpy as np

from ..core.schemes import Array, Scheme, scheme, schemes
from ..core.threads import cores
from ..derived.facade import CatalogueRow, Properties, catalogue_row, properties
from ..figures import page
from ..figures.charts import save, save_csv, stability_figure
from ..marching.run import march
from ..studies import failures
from ..studies.catalogue_charts import CHARTS
from ..studies.precision import jobs as precision
from ..studies.precision.cases import CASES
from . import claims, figures_5
from .claims.judgement import Judgement
from .parameter_sets import NEWMARK_SETS, SPLITS

RADIUS_RATIOS = np.logspace(-2, 3, 501)
ERROR_RATIOS = np.linspace(0.0, 0.2, 201)


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


def tables(folder: Path, catalogue: list[CatalogueRow], rows: list[list[str]]) -> None:
    """Write the tables of every scheme at its default parameters and of chapter 4's parameter sets, as CSV."""
    header = [f.name for f in fields(CatalogueRow)]
    for name, lines in (
        ("catalogue", [header, *(astuple(row) for row in catalogue)]), ("chapter_4_properties", [HEADER, *rows]),
    ):  # fmt: skip
        with (folder / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows(lines)


@dataclass(frozen=True)
class Results:
    """What `reproduce` found: rows of the tables of the catalogue, of chapter 4 and of failures, and the ledger."""

    catalogue: list[CatalogueRow]
    properties: list[list[str]]
    failures: list[failures.Row]
    claims: list[Judgement]


def jobs(full: bool) -> tuple[Callable[[Path], object], ...]:
    """The jobs that measure no time, one for each figure, chart or table; full: the long runs too."""
    chapter_4 = (partial(figure_4, number, split) for number, split in enumerate(SPLITS, start=1))
    return (*chapter_4, *CHARTS, *figures_5.JOBS, precision.operations, *(figures_5.LONG_JOBS if full else ()))


def _draw(folder: Path, full: bool, i: int) -> None:
    """Run the job at place i of `jobs(full)`, in a process of its own."""
    jobs(full)[i](folder)


def _compile(names: Sequence[str]) -> None:
    """Compile kernels of schemes into numba's cache, in a process of its own, since numba compiles on one core."""
    for name in names:
        s = scheme(name)
        s.stability(1.0)
        models = [case.make() for case in CASES]
        if name in failures.outcomes.QUICK:
            models += [case.make() for case in failures.table.CASES]
        for model in models:
            march(model, s, 1e-4, 2e-4)


def sharing() -> list[list[str]]:
    """Names of schemes, those that share a module together, so that no two processes compile it; the most first."""
    found: dict[object, list[str]] = {}
    for name in schemes():
        found.setdefault(scheme(name).info.module, []).append(name)
    return sorted(found.values(), key=len, reverse=True)


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
    """A part of `reproduce`: its name, how many jobs it has, and about how many seconds each of them takes."""

    name: str
    jobs: int
    seconds: float


def stages(full: bool = False) -> tuple[Stage, ...]:
    """What `reproduce` does, in the order in which it begins; the seconds are those of a first run on two cores."""
    ahead = len(sharing()) if cores() > 1 else 0
    return (
        Stage("compiling", ahead, 3.5),
        Stage("drawing", len(jobs(full)), 1.3),
        Stage("where methods fail", failures.count(), 1.5),
        Stage("judging", len(claims.CLAIMS), 0.5),
        Stage("timing", len(precision.jobs(full)), 10.0),
        Stage("drawing times", len(precision.jobs(full)), 2.5),
    )


def reproduce(folder: Path, step: Callable[[str], object], *, full: bool = False) -> Results:
    """Write everything into the folder. full: long runs and fine maps as well.

    step(name): called after each job of each of the `stages(full)`, with the stage's name.
    """
    folder.mkdir(parents=True, exist_ok=True)
    page.pictures(folder)  # raises for a figure that the page would refuse, before the work

    def waited(stage: str, found: Iterator[Any]) -> list[Any]:
        return [(one, step(stage))[0] for one in found]

    numbers = range(len(jobs(full)))
    with _workers() as each:
        first = each(partial(_draw, folder, full), numbers[:1])  # a figure to look at while the others wait
        compiled = each(_compile, sharing() if each is not map else [])
        waited("drawing", first)
        waited("compiling", compiled)
        drawn = each(partial(_draw, folder, full), numbers[1:])
        parts = each(partial(failures.part, folder, full), range(failures.count()))
        judged = each(claims.judged, claims.CLAIMS)
        waited("drawing", drawn)
        outcomes = failures.joined(folder, waited("where methods fail", parts))
        judgements = waited("judging", judged)
        catalogue = [catalogue_row(name) for name in schemes()]
        of_chapter_4 = [property_row(case) for case in parameter_sets()]
        tables(folder, catalogue, of_chapter_4)
        claims.write(folder, judgements)
        page.write(folder)  # to be read while the rest is timed, and kept if that is interrupted
        timed = waited("timing", (job(folder) for job in precision.jobs(full)))  # nothing else runs beside these
        waited("drawing times", each(call, timed))
    page.write(folder)
    return Results(catalogue, of_chapter_4, outcomes, judgements)
