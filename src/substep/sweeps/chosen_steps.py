"""Points of a sweep whose runs choose their steps: what can be asked of them, and the march of a group of them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.loads import as_numbers
from ..core.response import STATUSES
from ..core.scenes import Scene
from ..core.schemes import Array, Scheme
from ..core.schemes import scheme as make_scheme
from ..marching.adaptive import Control, adaptive_kernels, march_lanes_adaptive
from ..marching.run import CHOSEN, require_tol

if TYPE_CHECKING:
    from .plan import Plan


def step_of(
    dt: ArrayLike | None, tol: ArrayLike | None, values: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """{"dt": ...} or {"tol": ...}; what is asked of chosen steps; the other values. Raises ValueError for both."""
    if (dt is None) == (tol is None):
        raise ValueError(
            f"expected either dt, a constant step, or tol, for chosen steps; got {'none' if dt is None else 'both'}"
        )
    chosen = {name: value for name, value in values.items() if name in CHOSEN}
    if dt is not None:
        require_tol(chosen)
    step = {"tol": tol} if dt is None else {"dt": dt}
    return step, chosen, {name: value for name, value in values.items() if name not in CHOSEN}


def check_chosen(plan: "Plan") -> None:
    """Raise ValueError for what runs that choose their steps cannot be asked for, or a scheme that cannot change it."""
    if plan.samples is not None:
        raise ValueError(
            f"expected samples with dt only, got samples = {plan.samples}; give the times you want as grid="
        )
    if (plan.keep == "history") != ("grid" in plan.chosen):
        got = "none" if plan.keep == "history" else f"it with keep='{plan.keep}'"
        raise ValueError(
            f"expected grid=, the times of the rows, with keep='history' where runs choose their steps, got {got}; "
            "each has steps of its own: " + ("give grid=np.linspace(0, t_end, 101)" if got == "none" else "drop it")
        )
    tolerances = [axis.values for axis in plan.axes if axis.owner == "step"]
    tol = tolerances[0][:1] if tolerances else [plan.given["step"]["tol"]]
    Control.of(1.0, float(tol[0]) if len(tol) else 1.0, plan.t_end, **plan.chosen)
    as_numbers(plan.load)
    swept = {axis.key: axis.values for axis in plan.axes if axis.owner == "scheme"}
    if all(map(len, swept.values())):
        first = {key: float(values[0]) for key, values in swept.items()}
        adaptive_kernels(plan.scene_of_one, make_scheme(plan.scheme, **plan.given["scheme"], **first))


def march_chosen(plan: "Plan", scene: Scene, scheme: Scheme, tol: Any, P: int) -> dict[str, Any]:
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
    module, x = march_lanes_adaptive(scene, scheme, asked, plan.t_end, P, bound=plan.bound, reader=reader)
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
