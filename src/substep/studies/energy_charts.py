"""Energy under steps that change with the motion: what symplectic schemes lose by them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ..core.scene_by_name import scene
from ..core.scenes import Scene
from ..core.schemes import Array, scheme
from ..core.style import COLOURS, styled
from ..derived import facade
from ..figures.charts import save, save_csv
from ..marching.run import marched

SCHEMES = ("central_difference", "rkn64")  # symplectic; a pair of high order, which is not
TOL, T_END = 1e-5, 100.0  # s
MARKS = np.geomspace(0.5, T_END, 200)  # s


@dataclass(frozen=True)
class Drift:
    """Largest |E/E0 - 1| up to times t (n,): with chosen steps, and with as many constant ones; arrays (n,)."""

    scheme: str
    nature: str
    steps: int
    t: Array
    chosen: Array
    constant: Array


def nature(name: str) -> str:
    """What is derived of a scheme's map at its default parameters: symplectic, conjugate to such a map, or neither."""
    row = facade.catalogue_row(name)
    if row.symplectic == "yes":
        return "symplectic"
    return "conjugate symplectic" if row.conjugate_symplectic == "yes" else "not symplectic"


def drift(model: Scene, name: str, tol: float, times: Array) -> Drift:
    """Energy errors of a scheme on an undamped scene without load; times (n,): ascending, s, the last is the span."""
    t_end = float(times[-1])
    chosen = marched(model, scheme(name), t_end=t_end, tol=tol)
    steps = len(chosen.t) - 1
    constant = marched(model, scheme(name), t_end / steps, t_end)
    largest = (np.maximum.accumulate(np.abs(r.energy / model.E0 - 1.0)) for r in (chosen, constant))
    places = (np.searchsorted(r.t, times * (1 + 1e-12), side="right") - 1 for r in (chosen, constant))
    return Drift(name, nature(name), steps, times, *(e[k] for e, k in zip(largest, places, strict=True)))


@styled
def energy_under_changing_steps(folder: Path) -> None:
    """The largest error of the energy over time, in chosen steps (dashed) and in as many constant ones."""
    flexible = scene("elastic_pendulum", EA=1e4)
    found = [drift(flexible, name, TOL, MARKS) for name in SCHEMES]
    figure = Figure(figsize=(8.5, 5.4))
    axes = figure.subplots()
    for colour, one in zip(COLOURS, found, strict=False):
        label = f"{one.scheme} ({one.nature})"
        axes.loglog(one.t, one.chosen, "--", color=colour, linewidth=1.6, label=f"{label}, chosen steps")
        axes.loglog(one.t, one.constant, "-", color=colour, linewidth=1.6, label=f"{label}, {one.steps} constant steps")
    axes.set(xlabel="$t$ (s)", ylabel="largest $|E/E_0 - 1|$ up to $t$")
    axes.set_title(f"Flexible pendulum, EA = 10⁴ N, tol = {TOL:g}")
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    lost = "; ".join(f"{one.scheme} {one.chosen[-1]:.1e} against {one.constant[-1]:.1e}" for one in found)
    save(
        figure, folder / "energy_under_changing_steps", "Where methods fail",
        f"""The largest relative error of the energy up to a time, on the flexible pendulum (EA = 10⁴ N) over {T_END:g}
        s: dashed in steps that choose themselves with tol = {TOL:g}, solid in as many constant ones. With constant
        steps a symplectic scheme, or one conjugate to it, conserves a modified energy, so that the error stays; where
        steps follow the motion it grows as that of any other scheme. At the end: {lost}.""",
    )  # fmt: skip
    columns = {f"{one.scheme} {kind}": getattr(one, kind) for one in found for kind in ("chosen", "constant")}
    save_csv(folder / "energy_under_changing_steps.csv", ["t (s)", *columns], [MARKS, *columns.values()])
