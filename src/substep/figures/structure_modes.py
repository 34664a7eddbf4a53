"""The spectrum of a structure on the spectrum of a scheme: what a step does to each mode."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from ..core.arrays import Array
from ..core.coefficients import refuse_damping
from ..core.errors import real_number
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..core.style import COLOURS, REFERENCE, styled
from ..structures.model.rayleigh import Rayleigh
from ..structures.structure import Modes
from .charts import save

SECTION = "Structures"
RESOLVED, INACCURATE = 0.01, 0.1  # period error and numerical damping up to which a mode is so
DAMPED = 0.9  # spectral radius up to which a mode is damped out: to 1 % within 44 steps
UNSTABLE = 1.0 + 1e-6
KINDS: Mapping[str, tuple[str, str]] = MappingProxyType({  # colour and marker
    "resolved": (COLOURS[2], "o"),
    "inaccurate": (COLOURS[1], "D"),
    "spurious": (COLOURS[4], "^"),
    "damped": (COLOURS[0], "s"),
    "unstable": (COLOURS[3], "X"),
})  # fmt: skip


def kinds_of_modes(modes: Modes, scheme: Scheme, dt: float) -> list[str]:
    """What a step of dt does to each elastic mode.

    "resolved": period error and numerical damping are at most 1 %; "damped": not resolved, but the spectral radius is
    at most 0.9; "unstable": it is beyond 1; "inaccurate": both errors are at most 10 %; "spurious": what is left, a
    motion that is wrong and stays.

    Raises ValueError for a scheme that takes no damping and modes that are damped.
    """
    omega, xi = modes.omega[modes.rigid :], modes.xi[modes.rigid :]
    refuse_damping(scheme, xi)
    radius, damping, period = scheme.stability(omega * dt, xi)
    found = np.full(len(omega), "spurious", dtype=object)
    errors = np.maximum(np.abs(period), np.abs(damping))
    found[errors <= INACCURATE] = "inaccurate"
    found[radius <= DAMPED] = "damped"
    found[errors <= RESOLVED] = "resolved"
    found[~(radius <= UNSTABLE)] = "unstable"
    return found.tolist()


@styled
def modes_figure(
    modes: Modes, scheme: Scheme | str, dt: float, *, direction: ArrayLike | None = None, largest: float | None = None
) -> Figure:
    """Spectral radius, numerical damping and period error of a scheme over omega dt, with the modes as marks.

    direction: of a motion of the base (see `Structure.ground_motion`): the area of a mark is then the mode's share of
    the effective mass. largest: the largest circular frequency of the structure, rad/s, drawn as a line, where the
    modes are only the lowest ones; `Structure.critical_step` finds it. Between the modes the damping ratio is that of
    Rayleigh damping, or interpolated.

    Raises ValueError for dt <= 0, for modes that are all rigid or have no ratio of damping (`Modes.xi`) >= 0, and for a
    scheme that takes no damping and modes that are damped.
    """
    s = make_scheme(scheme)
    dt = real_number("dt", dt, positive=True)
    omega, xi = modes.omega[modes.rigid :], modes.xi[modes.rigid :]
    if not len(omega):
        raise ValueError(f"expected elastic modes, got {modes.rigid} rigid ones; ask for more modes")
    kinds = np.array(kinds_of_modes(modes, s, dt))
    ends = np.log(np.array([omega[0] * dt / 3.0, 3.0 * max(omega[-1], largest or 0.0) * dt]))
    Omega = np.exp(np.linspace(*ends, 700))
    C = modes.structure.C
    own = C.ratio(Omega / dt) if isinstance(C, Rayleigh) else np.interp(np.log(Omega / dt), np.log(omega), xi)
    curves = s.stability(Omega, np.maximum(own, 0.0))
    marks = s.stability(omega * dt, np.maximum(xi, 0.0))
    share = np.full(len(omega), 0.1) if direction is None else modes.participation(direction).share[modes.rigid :]
    figure = Figure(figsize=(13, 4.8))
    panels = figure.subplots(1, 3, sharex=True)
    names = (r"spectral radius $\rho$", "numerical damping (%)", "period error (%)")
    for axes, curve, mark, name, factor in zip(panels, curves, marks, names, (1, 100, 100), strict=True):
        axes.semilogx(Omega, factor * curve, color="0.35", linewidth=1.2, zorder=1)
        _marks(axes, omega * dt, factor * mark, share, kinds)
        if largest is not None:
            axes.axvline(largest * dt, color=REFERENCE, linewidth=1.0, linestyle="--", label="largest $\\omega h$")
        axes.set_xlabel(r"$\Omega = \omega h$")
        axes.set_ylabel(name)
    panels[0].axhline(1.0, color="0.5", linewidth=0.6)
    panels[0].set_ylim(-0.03, max(1.1, min(2.0, 1.1 * float(np.nanmax(marks[0])))))
    for axes, mark in zip(panels[1:], marks[1:], strict=True):
        _limit(axes, 100 * mark[kinds != "unstable"])
    size = "; area of a mark: share of the effective mass" if direction is not None else ""
    figure.suptitle(f"{len(omega)} modes under {s.name} at h = {dt:g}{size}")
    handles, labels = panels[0].get_legend_handles_labels()
    legend = figure.legend(handles, labels, loc="outside lower center", ncols=6)
    for handle in legend.legend_handles:
        if isinstance(handle, PathCollection):
            handle.set_sizes([36.0])
    return figure


def chart(
    modes: Modes,
    scheme: Scheme | str,
    dt: float,
    path: Path,
    *,
    direction: ArrayLike | None = None,
    largest: float | None = None,
) -> None:
    """Save `modes_figure` as path.png and path.svg, with a caption that counts the modes of each kind."""
    s = make_scheme(scheme)
    figure = modes_figure(modes, s, dt, direction=direction, largest=largest)
    kinds = kinds_of_modes(modes, s, dt)
    counted = ", ".join(f"{kinds.count(kind)} {kind}" for kind in KINDS if kind in kinds)
    save(
        figure, path, SECTION,
        f"""The spectrum of a structure on the spectrum of {s.name} at h = {dt:g}: {counted}. Resolved: period error
        and numerical damping of at most 1 %; inaccurate: at most 10 %; damped: not resolved, but with a spectral
        radius of at most 0.9, gone within 44 steps; spurious: wrong, and it stays; unstable: it grows.""",
    )  # fmt: skip


def _marks(axes: Axes, Omega: Array, y: Array, share: Array, kinds: Array) -> None:
    """The modes of each kind, those of the largest share at the back."""
    for kind, (colour, marker) in KINDS.items():
        own = np.flatnonzero(kinds == kind)
        if not len(own):
            continue
        own = own[np.argsort(-share[own])]
        area = 16.0 + 500.0 * np.clip(share[own], 0.0, 1.0)
        axes.scatter(
            Omega[own], y[own], s=area, color=colour, marker=marker, alpha=0.75, linewidths=0.4, edgecolors="white",
            zorder=3, label=f"{kind} ({len(own)})",
        )  # fmt: skip


def _limit(axes: Axes, values: Array) -> None:
    """Show all marks, and of a curve that goes far beyond them what is near."""
    finite = values[np.isfinite(values)]
    low, high = (min(0.0, finite.min()), max(0.0, finite.max())) if len(finite) else (0.0, 0.0)
    room = 0.12 * max(high - low, 0.5)
    axes.set_ylim(low - room, high + room)
