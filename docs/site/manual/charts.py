"""The charts of the generated pages."""

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure
from sympy import Symbol, latex

import substep as ss
from substep.core.scene_catalogue import scene_info
from substep.core.style import COLOURS, styled
from substep.figures.charts import stability_figure
from substep.studies.precision.cases import CASES, FURTHER
from substep.studies.precision.reference import Reference, reference

RATIOS, SMALL = np.geomspace(1e-2, 1e2, 241), np.linspace(0.0, 0.3, 121)  # h/T
DAMPING = (0.0, 0.05, 0.2)
COMPARED = "average_acceleration"
CAPTION = (
    "Over the time ratio h/T, at default parameters and three damping ratios ξ: (a) spectral radius, (b) amplitude "
    "error a period, which is about 2π times the numerical damping, (c) period error. Black: the average acceleration "
    "method at ξ = 0. [How to read it](../../charts.md)."
)
SAMPLES = 400
TURNS = 2
# of scenes with constraints or contacts: the scheme, steps for each that is drawn, and s where SHOWN is too long
HOLDS, FINE, SPANS = "generalized_alpha", 50, {"squeezer": 0.03, "slider_crank": 0.1, "two_masses_on_floor": 1.5}
SHOWN = 5.0  # s of a scene that starts at rest and has no chart of work over precision


def stability(name: str) -> Figure:
    """Spectral radius, amplitude and period error of a scheme, beside the average acceleration method."""
    s, other = ss.scheme(name), ss.scheme(COMPARED)
    ratios = DAMPING if s.info.damping else DAMPING[:1]
    wide, narrow = 2 * np.pi * RATIOS, 2 * np.pi * SMALL
    labels = {f"$\\xi$ = {xi:g}": xi for xi in ratios}
    black = f"{COMPARED}, $\\xi$ = 0"
    return stability_figure(
        name,
        (RATIOS, {k: s.spectral_radius(wide, xi) for k, xi in labels.items()} | {black: other.spectral_radius(wide)}),
        (
            SMALL,
            {k: s.amplitude_error(narrow, xi) for k, xi in labels.items()} | {black: other.amplitude_error(narrow)},
            {k: s.period_error(narrow, xi) for k, xi in labels.items()} | {black: other.period_error(narrow)},
        ),
    )


@styled
def motion(name: str) -> tuple[Figure, Reference, str]:
    """Coordinates and energy of a scene over time, the motion that is drawn, and a remark on it."""
    case = next((case for case in (*CASES, *FURTHER) if case.make().name == name), None)
    info = scene_info(name, {})
    if info.laws:
        found, title = yielding(name), "Half a sine of 40 m/s² and 0.8 s, which makes it yield"
    elif info.memory:
        found, title = held(name), "As it starts at its defaults"
    else:
        scene = case.make() if case else ss.scene(name)
        turns = name == "rigid_pendulum"
        t_end = case.t_end if case else TURNS * 2 * np.pi / float(abs(scene.v0[0])) if turns else SHOWN
        said = case.title if case else f"{TURNS} turns" if turns else f"{SHOWN:g} s"
        found, title = reference(scene, t_end, SAMPLES, 1e-9), said
    scene = found.scene
    figure = Figure(figsize=(9, 3.4))
    unit = ", ".join(dict.fromkeys(unit for _, unit in scene.coordinates))
    only = f" ${latex(Symbol(scene.coordinates[0][0]))}$" if len(scene.coordinates) == 1 else "s"
    panels = ((found.u, f"coordinate{only} ({unit})"), (found.v, f"rate of the coordinate{only} ({unit}/s)"))
    for axes, (values, what) in zip(figure.subplots(1, 2), panels, strict=True):
        for (q, _), column, colour in zip(scene.coordinates, values.T, cycle(COLOURS), strict=False):
            axes.plot(found.t, column, color=colour, linewidth=1.2, label=f"${latex(Symbol(q))}$")
        axes.set(xlabel="time $t$ (s)", ylabel=what)
    if len(scene.coordinates) > 1:
        figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure, found, title


def yielding(name: str) -> Reference:
    """An oscillator with a law under a pulse, in steps that are fine for what is drawn."""
    scene = ss.scene(name, omega=2 * np.pi, xi=0.05, strength=15.0, hardening=0.1, load=ss.HalfSine(40.0, 0.8))
    r = ss.march(scene, COMPARED, dt=4.0 / SAMPLES, t_end=4.0)
    return Reference(scene, r.t, r.u, r.v, r.a, np.nan, f"{COMPARED} in {SAMPLES} steps")


def held(name: str) -> Reference:
    """A scene with constraints or contacts, which no reference of its own scheme solves, in fine steps."""
    scene, t_end = ss.scene(name), SPANS.get(name, SHOWN)
    r = ss.march(scene, HOLDS, dt=t_end / (FINE * SAMPLES), t_end=t_end, stride=FINE)
    return Reference(scene, r.t, r.u, r.v, r.a, np.nan, f"{HOLDS} in {FINE * SAMPLES} steps")
