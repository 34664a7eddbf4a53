"""A unit mass bounces on a penalty spring: the speed after contact depends on where in a step contact begins."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ...core.outcome import STATUSES
from ...core.scene_by_name import scene
from ...core.schemes import Array, scheme, schemes
from ...core.style import COLOURS, styled
from ...figures.charts import save
from ...marching.scene_lanes import march_lanes
from .outcomes import QUICK, SECTION, write_rows

FREQUENCIES = np.geomspace(1, 100, 41)  # omega_c h
PHASES = np.arange(50) / 50  # where within a step contact begins, as a part of it
STEPS = 200  # enough for the mass to leave the spring at omega_c h = 1


@dataclass(frozen=True)
class BounceRow:
    """Restitution |v_out/v_in|, 1 in the exact motion, over the contact phases with which the mass left the spring.

    newton_failed, stayed: the shares of phases with which Newton failed, or the mass had not left by the end.
    """

    scheme: str
    omega_c_h: float
    mean: float
    least: float
    largest: float
    newton_failed: float
    stayed: float


def restitution(name: str, frequencies: Array, phases: Array) -> tuple[Array, Array]:
    """Restitution (F, P), NaN of a mass that did not leave, and place in STATUSES (F, P).

    frequencies: omega_c h (F,); phases (P,). v0 = -1, k = 1e6, m = 1, u0 = (1 + phase) h |v0|: contact begins in the
    second step.
    """
    bounce = scene("penalty_bounce")
    omega_c, v0 = bounce.parameters["k"] ** 0.5, bounce.parameters["v0"]
    h, phase = (x.ravel() for x in np.meshgrid(frequencies / omega_c, phases, indexing="ij"))
    u = ((1 + phase) * h * abs(v0))[:, None]
    start = u, np.full_like(u, v0), np.zeros_like(u)
    steps = np.full(len(h), STEPS)
    lanes = march_lanes(bounce, scheme(name), h, steps, start=start, stride=STEPS, history=True)
    u_end, v_end = lanes.out[:, -1, 0, 0], lanes.out[:, -1, 1, 0]
    left = (lanes.status == 0) & (u_end > 0) & (v_end > 0)
    shape = len(frequencies), len(phases)
    return np.where(left, v_end / abs(v0), np.nan).reshape(shape), lanes.status.reshape(shape)


def bounce(folder: Path, full: bool = False) -> list[BounceRow]:
    """Restitution over omega_c h and all phases, as CSV and, for the schemes of QUICK, as a chart."""
    rows = []
    for name in schemes() if full else QUICK:
        found, status = restitution(name, FREQUENCIES, PHASES)
        failed = status == STATUSES.index("newton_failed")
        for frequency, e, bad in zip(FREQUENCIES, found, failed, strict=True):
            left = e[np.isfinite(e)]
            extremes = (float(x) for x in (left.mean(), left.min(), left.max())) if left.size else (np.nan,) * 3
            stayed = 1 - left.size / e.size - bad.mean()
            rows.append(BounceRow(name, float(frequency), *extremes, float(bad.mean()), float(stayed)))
    write_rows(folder / "penalty_bounce.csv", rows)
    _draw(folder, rows)
    return rows


@styled
def _draw(folder: Path, rows: list[BounceRow]) -> None:
    figure = Figure(figsize=(11, 6.5))
    grid = figure.subplots(2, 3, sharex=True, sharey=True)
    for axes, name in zip(grid.flat, QUICK, strict=True):
        mine = [row for row in rows if row.scheme == name]
        x = [row.omega_c_h for row in mine]
        extremes = [row.least for row in mine], [row.largest for row in mine]
        axes.fill_between(x, *extremes, color=COLOURS[0], alpha=0.3, linewidth=0, label="all contact phases")
        axes.plot(x, [row.mean for row in mine], color=COLOURS[0], label="mean over the phases")
        axes.axhline(1.0, color="0.3", linewidth=0.8, linestyle="--", label="exact")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_ylim(1e-2, 1e2)
        axes.set_title(name, loc="left")
    for axes in grid[1]:
        axes.set_xlabel(r"step, $\omega_c h$")
    for axes in grid[:, 0]:
        axes.set_ylabel(r"restitution $|v_{out}/v_{in}|$")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.suptitle(r"Unit mass against a penalty spring, $\omega_c = \sqrt{k/m}$")
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    save(
        figure, folder / "penalty_bounce", SECTION,
        """A unit mass bounces on a penalty spring (k = 10⁶ N/m, v0 = -1 m/s): speed after over speed before contact,
        1 in the exact motion, over the step ω_c h, ω_c = √(k/m). Line: the mean over 50 places within a step at which
        contact begins; band: their extremes, of runs that left the spring. Once ω_c h exceeds about 2, where contact
        begins decides how much energy is gained or lost; only the energy-momentum method keeps it.""",
    )  # fmt: skip
