"""Points of a sweep whose runs choose their steps: the march of a group of them."""

from typing import Any

import numpy as np

from ..core.response import STATUSES
from ..core.scenes import Scene
from ..core.schemes import Array, Scheme
from ..marching.adaptive import march_lanes_adaptive
from ..run.clock import Control
from .sweep_plan import Plan


def march_chosen(plan: Plan, scene: Scene, scheme: Scheme, tol: Any, P: int) -> dict[str, Any]:
    """Results of P points that share the scheme and the load, by name; scene: its swept parameters are (P,).

    tol: a number or (P,).
    """
    grid = {"final": np.array([plan.t_end]), "peak": None, "history": plan.chosen.get("grid")}[plan.keep]
    more = {name: value for name, value in plan.chosen.items() if name != "grid"}
    one = Control.of(1.0, float(np.max(tol)), plan.t_end, **more, grid=grid)
    asked = one.over(scene.length, tol, {*more})
    starts = np.stack([np.broadcast_to(x, (P, x.shape[-1])) for x in (scene.u0, scene.v0, scene.a0)], axis=1)
    peaks = np.abs(starts)

    def largest(lane: int, rows: Array) -> None:
        if len(rows):
            peaks[lane] = np.fmax(peaks[lane], np.abs(rows).max(axis=0))

    reader = largest if plan.keep == "peak" else None
    module, x = march_lanes_adaptive(scene, scheme, asked, P, bound=plan.bound, reader=reader)
    counts, control, status = x["counts"], x["control"], x["status"]
    if plan.keep == "peak":
        start = scene.energy(np.zeros(P), *(np.ascontiguousarray(starts[:, k]) for k in (0, 1)))
        found = {f"peak_{name}": peaks[:, k] for k, name in enumerate("uva")}
        found["peak_energy"] = np.fmax(control[:, module.PEAK], start)
    else:
        out = x["out"]
        assert asked.grid is not None
        rows = {name: np.ascontiguousarray(out[:, :, k]) for k, name in enumerate("uva")}
        rows["energy"] = scene.energy(asked.grid, rows["u"], rows["v"])
        found = {name: value[:, 0] if plan.keep == "final" else value for name, value in rows.items()}
    accepted = counts[:, module.ACCEPTED]
    with np.errstate(invalid="ignore"):
        mean = x["newton"][:, 0] / accepted[:, None]  # NaN if no step was accepted
    failed = np.where(
        status == STATUSES.index("completed"), np.nan, control[:, module.TIME] + control[:, module.PROPOSED]
    )
    return {
        **found,
        "newton_iterations": mean,
        "newton_most": x["newton"][:, 1],
        "accepted": accepted,
        "rejected": counts[:, module.REJECTED],
        "t_failed": failed,
        "status": status.astype(np.int8),
    }
