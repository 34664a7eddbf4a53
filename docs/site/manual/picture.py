"""The picture at the head of README.md: `python -m manual.picture` in docs/site draws it again.

Its ground is transparent and its text grey, so that it can be read on white and on black.
"""

import json
from hashlib import sha256
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from substep_derive import impact
from substep_derive.constrained.impact import phi

import substep as ss
from substep.core.style import COLOURS, styled

from . import ROOT

PATH = ROOT / "docs" / "picture.svg"
GREY = "#768390"
RATIOS = np.geomspace(0.02, 50.0, 161)  # h/T
SHOWN = {
    "average_acceleration": {},
    "newmark_bdf2": {"gamma_t": 0.4},
    "bathe": {},
    "generalized_alpha": {"rho_inf": 0.5},
}
TOP = 2.6  # of the energy that is shown: what goes beyond fails soon
HIT = 9.3
STEP, END = 0.1, 10.0  # s, on the stiff pendulum

Curves = dict[str, tuple[np.ndarray, np.ndarray]]


def curves() -> tuple[Curves, Curves, Curves]:
    """By scheme: h/T and spectral radius; t (s) and energy over its first value, on the stiff pendulum; and an impact.

    Of this the phase within the step, and the energy after it over that before, where the acceleration that the scheme
    keeps for its next step is with the pressure's.
    """
    schemes = {name: ss.scheme(name, **parameters) for name, parameters in SHOWN.items()}
    radius = {name: (RATIOS, s.spectral_radius(2 * np.pi * RATIOS)) for name, s in schemes.items()}
    scene = ss.scene("elastic_pendulum", EA=1e10, a0=(-19.6, 0.0))
    energy = {}
    for name, s in schemes.items():
        r = ss.march(scene, s, dt=STEP, t_end=END)
        energy[name] = (r.t, r.energy / r.energy[0])
    impacts = {}
    for name, parameters in SHOWN.items():
        exact = {key: str(value) for key, value in parameters.items()}
        pieces = impact(name, remembered=True, **exact).pieces
        phases = [np.linspace(float(piece.low), float(piece.high), 24) for piece in pieces]
        left = [[float(piece.velocity.subs(phi, x)) ** 2 for x in at] for piece, at in zip(pieces, phases, strict=True)]
        impacts[name] = np.concatenate(phases), np.concatenate(left)
    return radius, energy, impacts


def digest(found: tuple[Curves, Curves, Curves]) -> str:
    """Of the numbers that are drawn, to four digits: other fonts and versions of Matplotlib do not change it."""
    parts = zip(found, (TOP, TOP, HIT), strict=True)
    shown = [[name, [f"{v:.3e}" for v in np.minimum(y, top)]] for part, top in parts for name, (_, y) in part.items()]
    return sha256(json.dumps(shown).encode()).hexdigest()[:16]


@styled
def draw(found: tuple[Curves, Curves, Curves]) -> Figure:
    """Where a scheme stands: what it does to stiff vibrations, to the energy of a nonlinear one, and to an impact."""
    grey = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color", "grid.color")
    with mpl.rc_context(dict.fromkeys(grey, GREY)):
        figure = Figure(figsize=(11.5, 3.3))
        left, middle, right = figure.subplots(1, 3)
        for axes, part in zip((left, middle, right), found, strict=True):
            for (name, (x, y)), colour in zip(part.items(), [COLOURS[k] for k in (3, 0, 2, 1)], strict=True):
                axes.plot(x, y, color=colour, linewidth=1.8, label=name)
            axes.patch.set_alpha(0.0)
            axes.spines[["top", "right"]].set_visible(False)
        left.set(xscale="log", xlabel="step over period, $h/T$", ylabel=r"spectral radius $\rho$", ylim=(0.0, 1.05))
        left.set_title("what is left of a vibration after a step")
        middle.set(xlabel="time $t$ (s)", ylabel="energy $E/E_0$", ylim=(0.0, TOP))
        middle.set_title(f"a stiff pendulum, $h$ = {STEP:g} s")
        right.set(xlabel="phase of an impact in the step", ylabel="energy $E/E_0$", xlim=(0.0, 1.0), ylim=(0.0, HIT))
        right.set_title("a mass point leaves a stop")
        handles, labels = left.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


@styled
def write(path: Path) -> None:
    """Draw the picture into the file; its description is the digest of its numbers."""
    found = curves()
    draw(found).savefig(path, transparent=True, metadata={"Date": None, "Description": digest(found)})


if __name__ == "__main__":
    write(PATH)
