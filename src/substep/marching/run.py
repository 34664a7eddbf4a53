"""March a scene with a scheme."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array
from ..core.errors import called_as, real_number, require_numbers, unknown_name
from ..core.memory import require_histories
from ..core.response import STATUSES, Response, Status
from ..core.scenes import Scene, scene_info, scenes
from ..core.scenes import scene as make_scene
from ..core.schemes import Scheme, schemes
from ..core.schemes import scheme as make_scheme
from ..run.clock import CHOSEN, ConstantSteps, Control, steps_of
from .adaptive import march_adaptive
from .linear import LinearLanes, march_linear
from .oscillators import Oscillators
from .scene_lanes import march_lanes

if TYPE_CHECKING:
    from ..derived.modules import Declaration


def _require_known(scene: Any, others: Iterable[str]) -> None:
    """Raises ValueError for an argument that the march of a scene does not have, before any other is looked at."""
    for name in others:
        known = ["dt", "t_end", "tol", "energy_bound", "stride", *CHOSEN]
        of_scene = isinstance(scene, str) and scene in scenes() and name in scene_info(scene, {}).parameters
        cure = f"; it is a parameter of the scene: ss.scene({scene!r}, {name}=...)" if of_scene else ""
        raise ValueError(f"{unknown_name('an argument of march', name, known)}{cure}")


def require_in_order(function: str, scene: Any, scheme: Any) -> None:
    """Raises ValueError for the names of a scheme and a scene that a function of that name was given exchanged."""
    if isinstance(scheme, str) and isinstance(scene, str) and scheme in scenes() and scene in schemes():
        raise ValueError(
            f"expected the scene, then the scheme, got them exchanged; call {function}({scheme!r}, {scene!r}, ...)"
        )


@called_as('march("duffing", "bathe", dt=0.01, t_end=10.0)')
def march(
    scene: Any,
    scheme: Scheme | str | Declaration,
    dt: float | None = None,
    t_end: float | None = None,
    *,
    stride: int = 1,
    energy_bound: float | None = None,
    tol: float | None = None,
    rtol: float | None = None,
    atol: float | Sequence[float] | None = None,
    dt_first: float | None = None,
    dt_min: float | None = None,
    dt_max: float | None = None,
    grid: ArrayLike | None = None,
    rung: float | None = None,
    **of_structure: Any,
) -> Response:
    """The response of the scene from t = 0 to t_end in steps of dt (s), or in steps chosen so that errors keep to tol.

    scene, scheme: handles, declarations, or names, which stand for their defaults. dt: the constant step; the load is
    sampled at the scheme's own instants t_n + tau*dt; stride: keep every stride-th step. energy_bound: stop before the
    first state whose energy exceeds it, in J.

    A structure, or its modes, may stand in place of a scene: `march_structure` and `superpose` of
    `substep.structures.march` and `substep.structures.modes` say what they take besides, of_structure.

    tol: the estimated local error of each step relative to the motion; with it alone rtol = tol, atol of u is
    tol * the scene's length and that of v is tol * the largest |v| so far. More about chosen steps: rtol; atol, of u or
    of u and v, in their units; dt_first, dt_min, dt_max, s; grid, ascending times at which rows are wanted in place of
    the steps' ends; rung, the ratio of the lengths between which steps move, 0 for any length. Steps end on t_end and
    where the load jumps or has a kink. See docs/adaptive.md.

    Raises ValueError for dt <= 0, for t_end that is not a multiple of dt, for tol <= 0, for both or neither of dt and
    tol, for a scheme whose parameters are arrays or that cannot change its step, and for a load that is not finite. A
    run that fails does not raise: see Response.status.

    >>> r = ss.march(ss.scene("linear_oscillator", omega=2 * np.pi), "bathe", dt=0.05, t_end=1.0)
    >>> r.status, r.u.shape
    ('completed', (21, 1))
    >>> print(f"{r.u[-1, 0]:.4f}")  # after a period, from 1
    0.9990
    """
    require_in_order("march", scene, scheme)
    asked = {"rtol": rtol, "atol": atol, "dt_first": dt_first, "dt_min": dt_min, "dt_max": dt_max}
    asked |= {"grid": grid, "rung": rung}
    chosen = {name: x for name, x in asked.items() if x is not None}
    marched_by: Callable[..., Response] | None = getattr(scene, "march", None)  # of a structure or its modes
    if marched_by is not None:
        options = {"tol": tol, "energy_bound": energy_bound, **of_structure}
        given = {name: x for name, x in options.items() if x is not None}
        return marched_by(scheme, dt=dt, t_end=t_end, stride=stride, **given, **chosen)
    _require_known(scene, of_structure)
    scheme = make_scheme(scheme)
    require_numbers(scheme.name, scheme.parameters, "substep.sweep takes arrays")
    scene = make_scene(scene)
    steps = steps_of(dt, tol, t_end, stride=stride, length=scene.length, chosen=chosen)
    bound = math.inf if energy_bound is None else real_number("energy_bound", energy_bound)
    if isinstance(steps, Control):
        return march_adaptive(scene, scheme, steps, bound=bound)
    n, stride = steps.n, steps.stride
    if scene.info.oscillator:
        require_histories(n, stride, 3, 0 if bound == math.inf else 3)
        return _oscillator_response(scene, scheme, steps, bound)
    require_histories(n, stride, 3 * scene.u0.shape[-1], scheme.balances + scheme.info.loads * scene.info.sampled)
    lanes = march_lanes(
        scene, scheme, np.array([steps.dt]), np.array([n]), bound=bound, stride=stride, history=True, counts=True
    )
    n_done = int(lanes.n_done[0])
    rows = lanes.out[0, : n_done // stride + 1]
    iterations = lanes.iterations[0, :n_done]
    return _response(scene, scheme, steps, rows, n_done, STATUSES[int(lanes.status[0])], iterations)


def _response(
    scene: Scene, scheme: Scheme, steps: ConstantSteps, rows: Array, n_done: int, status: Status, iterations: Any
) -> Response:
    """The response from rows (steps, 3, d) of u, v, a, or (steps, 2, d) of u, v for a scheme without its own a."""
    failed = None if status == "completed" else (n_done + 1) * steps.dt
    a = rows[:, 2] if rows.shape[1] > 2 else None
    return Response(rows[:, 0], rows[:, 1], iterations, status, failed, scene, scheme, steps.stride * steps.dt, a)


def _oscillator_response(scene: Scene, scheme: Scheme, steps: ConstantSteps, bound: float) -> Response:
    lanes = march_oscillators(scene, scheme, steps.dt, steps.n, 1, bound=bound, stride=steps.stride)
    n_done = int(lanes.n_done[0])
    iterations = np.ndarray((n_done, scheme.balances), np.int64, bytes(8), strides=(0, 0))  # read-only zeros, as one 0
    rows = lanes.out[: n_done // steps.stride + 1]
    return _response(scene, scheme, steps, rows, n_done, STATUSES[int(lanes.status[0])], iterations)


def march_oscillators(
    scene: Scene,
    scheme: Scheme,
    dt: float,
    n: int,
    P: int,
    *,
    bound: float = math.inf,
    stride: int = 1,
    keep: Literal["history", "peak"] = "history",
) -> LinearLanes:
    """P runs of n steps of a linear oscillator's scene; parameters of scene, load and scheme may be arrays (P,).

    bound, J: a lane ends before the first state whose energy exceeds it; with a bound all histories are in memory at
    once.
    """
    assert scene.info.oscillator is not None
    values, start = np.empty((4, P)), np.empty((3, P))
    for row, x in zip(values, (*scene.info.oscillator(*scene.parameters.values()), dt), strict=True):
        row[:] = x
    for row, x in zip(start, (scene.u0, scene.v0, scene.a0), strict=True):
        row[:] = x[..., 0]
    omega, xi, mass, steps = values
    o = Oscillators(omega, xi, mass, steps, start)
    if bound == math.inf:
        return march_linear(scheme, o, n, scene.load, stride=stride, keep=keep)
    lanes = march_linear(scheme, o, n, scene.load)
    u, v = (lanes.out[:, kind].T[..., None] for kind in (0, 1))
    beyond = scene.energy(dt * np.arange(n + 1.0), u, v) > bound  # False after n_done, where it is NaN
    ended = beyond.any(axis=1)
    n_done = np.where(ended, np.maximum(np.argmax(beyond, axis=1) - 1, 0), lanes.n_done)
    status = np.where(ended, STATUSES.index("energy_bound"), lanes.status)
    for j in np.flatnonzero(ended):
        lanes.out[n_done[j] + 1 :, :, j] = np.nan
    if keep == "peak":
        return LinearLanes(lanes.out[:0], np.nanmax(np.abs(lanes.out), axis=0), n_done, status)
    return LinearLanes(lanes.out[::stride], lanes.peak, n_done, status)
