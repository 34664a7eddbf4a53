"""Where schemes fail on the linear oscillator: beyond their limits, in the first steps, in uneven steps."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...core.scene_by_name import scene
from ...core.schemes import Array, Scheme, scheme, schemes
from ...core.style import COLOURS, styled
from ...derived import facade
from ...figures.charts import curves, save, save_csv
from ...marching.run import marched
from .outcomes import SECTION, write_rows

CROSSING = (0.99, 1.01)  # times the critical Omega
CROSSING_STEPS = (500, 1_000_000)  # at least, and at most: as many as make what grows CROSSING_GROWTH times as large
CROSSING_GROWTH = 4.0


@cache
def certified() -> dict[str, tuple[str, float] | None]:
    """Exact critical Omega of each scheme at its default parameters, as text and number; None if it has none."""
    found: dict[str, tuple[str, float] | None] = {}
    for name in schemes():
        text = facade.catalogue_row(name).critical_Omega
        found[name] = None if text == "none" else (text, float(facade.certificate(name).critical_Omega))
    return found


def without_limit() -> tuple[str, ...]:
    """Schemes stable for every Omega."""
    return tuple(name for name, limit in certified().items() if limit is None)


@dataclass(frozen=True)
class LimitRow:
    """Largest |u| from u0 = 1 m in the second half of the steps, and spectral radius, at CROSSING critical Omega."""

    scheme: str
    critical_Omega: str
    steps: int
    u_below: float
    u_above: float
    rho_below: float
    rho_above: float

    @property
    def grows(self) -> tuple[bool, bool]:
        """Whether the amplitude grew, below and above the limit."""
        return self.u_below > 1.1, self.u_above > 1.1


def limits_crossed(folder: Path, full: bool = False) -> list[LimitRow]:
    """Every conditionally stable scheme: its exact critical Omega, and runs 1 % below and above it."""
    oscillator, rows = scene("linear_oscillator", omega=1.0), []
    for name, (text, limit) in ((name, limit) for name, limit in certified().items() if limit and limit[1] > 0):
        s, Omegas = scheme(name), limit * np.array(CROSSING)
        radii = s.spectral_radius(Omegas)
        needed = np.log(CROSSING_GROWTH) / max(np.log(radii[1]), 1e-9)
        n = int(np.clip(np.ceil(needed), *CROSSING_STEPS))
        runs = (marched(oscillator, s, float(x), float(x) * n) for x in Omegas)
        u = (float(np.abs(r.u[n // 2 :]).max()) for r in runs)
        rows.append(LimitRow(name, text, n, *u, *radii.tolist()))
    write_rows(folder / "limits_crossed.csv", rows)
    return rows


OVERSHOOT_STEPS, OVERSHOOT_RATIO = 20, 10.0  # h/T


@dataclass(frozen=True)
class OvershootRow:
    """Largest |u|/u0 and |v|/(omega u0) of the first steps, both 1 in the exact motion."""

    scheme: str
    u: float
    v: float


@styled
def overshoot(folder: Path, full: bool = False) -> list[OvershootRow]:
    """First 20 steps of h = 10 T from u0 = 1, v0 = 0, for every scheme; a chart of the unconditionally stable ones."""
    oscillator = scene("linear_oscillator", omega=2 * np.pi)
    rows = []
    for name in schemes():
        r = marched(oscillator, scheme(name), OVERSHOOT_RATIO, OVERSHOOT_RATIO * OVERSHOOT_STEPS)
        rows.append(OvershootRow(name, float(np.abs(r.u).max()), float(np.abs(r.v).max() / (2 * np.pi))))
    write_rows(folder / "overshoot.csv", rows)
    free = without_limit()
    drawn = [row for row in rows if row.scheme in free]
    figure = Figure(figsize=(8, 6.5))
    axes = figure.subplots()
    at = np.arange(len(drawn))
    axes.plot([row.u for row in drawn], at - 0.15, "o", color=COLOURS[0], label="displacement $|u|/u_0$")
    axes.plot([row.v for row in drawn], at + 0.15, "s", color=COLOURS[3], label=r"velocity $|v|/(\omega u_0)$")
    axes.axvline(1.0, color="0.4", linewidth=0.8)
    axes.set_xscale("log")
    axes.set_yticks(at, [row.scheme for row in drawn], fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel(f"largest in the first {OVERSHOOT_STEPS} steps, $h/T$ = {OVERSHOOT_RATIO:g}")
    figure.legend(loc="outside lower center", ncols=2)
    save(
        figure, folder / "overshoot", SECTION,
        f"""Schemes without a limit on the step, undamped oscillator from u0 = 1, v0 = 0: largest |u|/u0 and |v|/(ω
        u0), 1 in the exact motion, of the first {OVERSHOOT_STEPS} steps of h = {OVERSHOOT_RATIO:g} T. Marks
        right of the line overshoot: stability bounds the powers of the amplification matrix, but not by 1.""",
    )  # fmt: skip
    return rows


RATIOS = (0.5, 0.8, 0.9, 1.0, 1.1, 1.25, 2.0)
OMEGAS = 2 * np.pi * np.logspace(-3, 3, 601)
ROUNDING = 1e-6  # error of a computed spectral radius for small Omega, where eigenvalues meet at 1
DRAWN = ("houbolt", "park", "oalts", "gholampour", "wilson_theta", "kr_alpha")


def alternating_radius(s: Scheme, Omega: Array, ratio: float) -> Array:
    """Spectral radius per step for steps h and ratio*h in turn, both by the scheme's formulas for one constant step.

    The state holds h v and h^2 a, which are rescaled when the step changes. A multi-step scheme takes the states of
    earlier instants as if these were equally spaced.
    """
    return np.abs(_two_steps(s, Omega, ratio)).max(axis=-1) ** 0.5


def alternating_period_error(s: Scheme, ratio: float, Omega: float) -> float:
    """Relative period error for steps h and ratio*h in turn; it tends to 0 with Omega if the scheme is consistent."""
    eigenvalues = _two_steps(s, Omega, ratio)
    oscillating = eigenvalues[eigenvalues.imag > ROUNDING]
    return float((1 + ratio) * Omega / np.angle(oscillating[np.argmax(np.abs(oscillating))]) - 1)


def _two_steps(s: Scheme, Omega: Array | float, ratio: float) -> NDArray[np.complex128]:
    """Eigenvalues of the amplification matrix of a step h and a step ratio*h together."""
    scale = ratio ** np.array([float(kind) for kind, _ in s.history])
    second = s.amplification(ratio * Omega) * scale / scale[:, None]
    return np.linalg.eigvals(second @ s.amplification(Omega)).astype(complex)


SMALL_RATIO = 0.005  # h/T at which the period error is reported


@dataclass(frozen=True)
class AlternatingRow:
    """Steps h and ratio*h in turn.

    largest: the largest spectral radius per step over h/T; first: the h/T at which it first exceeds 1, None if it never
    does; period_error: relative, at h/T = 0.005, where it is less than 1e-3 with a constant step.
    """

    scheme: str
    ratio: float
    largest: float
    first: float | None
    period_error: float


def alternating_steps(folder: Path, full: bool = False) -> list[AlternatingRow]:
    """Steps h and kappa h in turn: the multi-step schemes, two that fail and two one-step schemes that do not.

    full: all unconditionally stable schemes.
    """
    rows = []
    for name in without_limit() if full else (*DRAWN, "bathe", "average_acceleration"):
        s = scheme(name)
        for ratio in RATIOS:
            radius = alternating_radius(s, OMEGAS, ratio)
            grows = radius > 1 + ROUNDING
            first = float(OMEGAS[np.argmax(grows)] / (2 * np.pi)) if grows.any() else None
            error = alternating_period_error(s, ratio, 2 * np.pi * SMALL_RATIO)
            rows.append(AlternatingRow(name, ratio, float(radius.max()), first, error))
    write_rows(folder / "alternating_steps.csv", rows)
    _draw_alternating(folder)
    return rows


@styled
def _draw_alternating(folder: Path) -> None:
    columns: dict[str, Array] = {"h/T": OMEGAS / (2 * np.pi)}
    figure = Figure(figsize=(12, 7))
    grid = figure.subplots(2, 3, sharex=True)
    order = [ratio for ratio in RATIOS if ratio != 1.0] + [1.0]  # the last is drawn in black
    for axes, name in zip(grid.flat, DRAWN, strict=True):
        radii = {rf"$\kappa$ = {ratio:g}": alternating_radius(scheme(name), OMEGAS, ratio) for ratio in order}
        columns |= {f"{name} kappa = {ratio:g}": y for ratio, y in zip(order, radii.values(), strict=True)}
        curves(axes, OMEGAS / (2 * np.pi), radii, x_label="time ratio $h/T$", y_label=r"spectral radius $\rho$ a step")
        axes.axhline(1.0, color="0.5", linewidth=0.6)
        axes.set_xscale("log")
        axes.set_title(name, loc="left")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.suptitle(r"Steps $h$ and $\kappa h$ in turn, $\xi$ = 0")
    figure.legend(handles, labels, loc="outside lower center", ncols=7)
    save(
        figure, folder / "alternating_steps", SECTION,
        """Steps h and κh in turn on the undamped oscillator, each by the scheme's formulas for a constant step:
        spectral radius a step over h/T; κ = 1 is black. Above 1 the response grows: Wilson-θ and KR-α do, though each
        constant step is stable; multi-step schemes, which take their uneven history as if it were even, do not.""",
    )  # fmt: skip
    save_csv(folder / "alternating_steps_radius.csv", list(columns), list(columns.values()))
