"""The main job: the thesis's figures, drawn anew, with the numbers behind them."""

import csv
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import astuple, dataclass, fields
from fractions import Fraction
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from . import chapter_5, claims, failures, page
from .build import CatalogueRow, Properties, catalogue_row, properties
from .catalogue_charts import CHARTS
from .chapter_4 import NEWMARK_SETS, SPLITS
from .charts import save, save_csv, stability_figure
from .claims.judging import Judgement
from .marching import march
from .precision import jobs as precision
from .precision.cases import CASES
from .schemes import Array, Scheme, scheme, schemes
from .threads import cores

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


def property_row(name: str, parameters: dict[str, Fraction], found: Properties) -> list[str]:
    """One row of the table, exact: parameters, rho_inf, order, leading terms of both errors."""
    shown = [str(parameters[key]) if key in parameters else "" for key in ("gamma_t", "beta", "gamma")]
    terms = [("", "0") if term is None else (str(term[0]), str(term[1])) for term in (found.damping, found.period)]
    return [name, *shown, str(found.rho_inf), str(found.order), *terms[0], *terms[1]]


def property_table(folder: Path, step: Callable[[], object]) -> list[list[str]]:
    """The table of rho_inf, order and error constants, undamped; also written as CSV."""
    rows = []
    for name, parameters in parameter_sets():
        rows.append(property_row(name, parameters, properties(name, parameters)))
        step()
    with (folder / "chapter_4_properties.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([HEADER, *rows])
    return rows


def catalogue_table(folder: Path, step: Callable[[], object]) -> list[CatalogueRow]:
    """Every scheme at its default parameters; also written as CSV."""
    rows = []
    for name in schemes():
        rows.append(catalogue_row(name))
        step()
    with (folder / "catalogue.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([[f.name for f in fields(CatalogueRow)], *(astuple(row) for row in rows)])
    return rows


@dataclass(frozen=True)
class Results:
    """What `reproduce` found: rows of the tables of the catalogue, of chapter 4 and of failures, and the ledger."""

    catalogue: list[CatalogueRow]
    properties: list[list[str]]
    failures: list[failures.Row]
    claims: list[Judgement]


def jobs(full: bool) -> tuple[Callable[[Path], object], ...]:
    """What only draws or tabulates, one job a piece; full: the long runs too."""
    return (*CHARTS, *chapter_5.JOBS, *(chapter_5.LONG_JOBS if full else ()), *precision.jobs(full))


def compile_ahead(step: Callable[[], object]) -> None:
    """Kernels of every scheme into numba's cache, on all cores: numba compiles on one core of a process."""
    if cores() > 1:
        with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
            for _ in pool.map(_compile, schemes()):
                step()


def _compile(name: str) -> None:
    s = scheme(name)
    s.stability(1.0)
    for where in (case.make() for case in CASES):
        march(where, s, 1e-3, 2e-3)


def reproduce(folder: Path, step: Callable[[], object], *, full: bool = False) -> Results:
    """Everything into the folder; calls step() `steps(full)` times. full: the long runs and fine maps as well."""
    folder.mkdir(parents=True, exist_ok=True)
    page.pictures(folder)  # one that the page refuses is told before the work, not after
    compile_ahead(step)
    for number, split in enumerate(SPLITS, start=1):
        figure_4(number, split, folder)
        step()
    for job in jobs(full):
        job(folder)
        step()
    outcomes = failures.battery(folder, step, full)
    catalogue = catalogue_table(folder, step)
    rows = property_table(folder, step)
    judgements = claims.judge(step)
    claims.write(folder, judgements)
    page.write(folder)
    return Results(catalogue, rows, outcomes, judgements)


def steps(full: bool = False) -> int:
    """How often `reproduce` calls its step."""
    tables = len(schemes()) + sum(1 for _ in parameter_sets())
    ahead = len(schemes()) if cores() > 1 else 0
    return ahead + len(SPLITS) + len(jobs(full)) + failures.count() + tables + len(claims.JUDGES)
