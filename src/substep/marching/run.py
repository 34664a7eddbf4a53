"""March a scene with a scheme."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..core import coefficients
from ..core.arrays import Array, repeated
from ..core.between_steps import Event, ascending, ended, require_reached, sampled
from ..core.constraints import pressures
from ..core.errors import called_as, real_number, warn
from ..core.loads import behind_jump, is_known
from ..core.memory import require_histories
from ..core.outcome import STATUSES, Status
from ..core.response import Response
from ..core.scene_by_name import scene as make_scene
from ..core.scene_catalogue import arguments_of, scene_info, scenes
from ..core.scenes import Scene, require_made
from ..core.scheme_names import unknown_argument
from ..core.schemes import Scheme, schemes
from ..core.state import State, bare, require_coordinates, whose
from ..core.unkept import staying
from ..run.clock import AT_ZERO, CHOSEN, Begin, ConstantSteps, Control, steps_of
from ..run.schemes import numbers_only, under_way
from .adaptive import march_adaptive
from .decay import require_decay
from .gained import gained
from .linear import LinearLanes, march_linear
from .oscillators import Oscillators
from .passed_over import passed_over
from .scene_events import march_to_events
from .scene_lanes import march_lanes, memory_of, pair_kernels

if TYPE_CHECKING:
    from ..derived.modules import Declaration


def _require_known(scene: Any, scheme: Any, others: Iterable[str]) -> None:
    """Raises ValueError for an argument that the march of a scene does not have, before any other is looked at."""
    for name in others:
        known = ["dt", "t_end", "tol", "energy_bound", "stride", "start", "at", "until", *CHOSEN]
        info = scene_info(scene, {}) if isinstance(scene, str) and scene in scenes() else getattr(scene, "info", None)
        of_scene = {} if info is None else {f"ss.scene('{info.name}', {{}}=...)": (*arguments_of(info), "a0", "load")}
        raise unknown_argument("an argument of march", name, known, scheme, of_scene)


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
    start: Response | State | Mapping[str, Any] | None = None,
    at: ArrayLike | None = None,
    until: Event | Sequence[Event] | None = None,
    **of_structure: Any,
) -> Response:
    """The response of the scene from t = 0 to t_end in steps of dt (s), or in steps chosen so that errors keep to tol.

    scene, scheme: handles, declarations, or names, which stand for their defaults. dt: the constant step; the load is
    sampled at the scheme's own instants t_n + tau*dt; stride: keep every stride-th step. energy_bound: stop before the
    first state whose energy exceeds it, in J.

    start: a response, its `state`, or a dictionary of t, u, v and, where known, a and history, from which the run goes
    on: t_end is then of the same time, and the load and the scene may be other ones. With the same scheme and dt it is
    the run that was not broken, to the bit, and so it is in the rows after the start where steps were chosen and are so
    by the same rules; another scheme, dt or tol starts from u, v, a. See docs/going_on.md.

    at: ascending times at which rows are wanted in place of those of the steps: by Hermite's polynomial in u, v and a
    at both ends of a step, whose error is of higher order than the scheme's up to order four. until: a function of
    t, u (d,) and v (d,), or several; the run ends at the first root of one, found within its step, t_end at the latest,
    and `t_events` of the response says when.

    A structure, or its modes, may stand in place of a scene. They take besides, of_structure: dofs, account, and of a
    structure save, progress, newton, line_search, of modes static_correction; see `march_structure` and `superpose` of
    `substep.structures.march` and `substep.structures.modes`.

    tol: the estimated local error of each step relative to the motion; with it alone rtol = tol, atol of u is
    tol * the scene's length and that of v is tol * the largest |v| so far. More about chosen steps: rtol; atol, of u or
    of u and v, in their units; dt_first, dt_min, dt_max, s; grid, ascending times at which rows are wanted in place of
    the steps' ends; rung, the ratio of the lengths between which steps move, 0 for any length. Steps end on t_end and
    where the load jumps or has a kink. See docs/adaptive.md.

    Raises ValueError for dt <= 0, for t_end that is not a multiple of dt, for tol <= 0, for both or neither of dt and
    tol, for a scheme whose parameters are arrays or that cannot change its step, and for a load that is not finite. A
    run that fails does not raise: see Response.status. Warns where a completed run of a scene has gained energy that
    nothing gave it, tenfold or more: on a linear oscillator at an unstable step, on others where they conserve it,
    but for friction; where it stays where constraints repeat each other; and where dt, as one in ms, passes over a
    whole record or pulse, or over half a period of the load or a loaded oscillator.

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
    given = scene, scheme, dt, t_end, stride, energy_bound, tol, start
    if at is None and until is None:
        return _warned(marched(*given, chosen, of_structure), dt)
    if at is not None and t_end is not None:
        require_reached(ascending("at", at), real_number("t_end", t_end))
    if stride != 1 or grid is not None:
        raise ValueError("expected at or until without stride and grid, got them together; give the times as at=")
    if at is not None and tol is not None and until is None and getattr(scene, "march", None) is None:
        chosen["grid"] = ascending("at", at)
        return _warned(marched(*given, chosen, of_structure), dt)
    r = marched(*given, chosen, of_structure)
    r = _warned(r if until is None else ended(r, until), dt)
    return r if at is None else sampled(r, at)


def _warned(r: Response, dt: float | None) -> Response:
    """The response, with a warning where steps pass over what they are to follow, or have gained energy on a scene.

    So it has where a run stays where constraints of a scene repeat each other. A structure's march has its own of
    energy.
    """
    said = "" if hasattr(r.scene, "march") or r.status != "completed" else staying(r) or gained(r, dt)
    if said := said or (passed_over(r, dt) if dt else ""):
        warn(said)
    return r


def marched(
    scene: Any,
    scheme: Any,
    dt: float | None = None,
    t_end: float | None = None,
    stride: int = 1,
    energy_bound: float | None = None,
    tol: float | None = None,
    start: Any = None,
    chosen: Mapping[str, Any] = MappingProxyType({}),
    of_structure: Mapping[str, Any] = MappingProxyType({}),
) -> Response:
    """`march`, with a row for each stride-th step, each chosen step, or each time of the grid, and without a warning.

    Studies call it, which judge what a run has gained themselves.
    """
    marched_by: Callable[..., Response] | None = getattr(scene, "march", None)  # of a structure or its modes
    if marched_by is not None:
        options = {"tol": tol, "energy_bound": energy_bound, "start": start, **of_structure}
        given = {name: x for name, x in options.items() if x is not None}
        return marched_by(scheme, dt=dt, t_end=t_end, stride=stride, **given, **chosen)
    _require_known(scene, scheme, of_structure)
    scheme = numbers_only(scheme, "substep.sweep takes arrays")
    scene = make_scene(scene)
    require_coordinates(start, scene.coordinates, scene.name)
    if start is None and not is_known(scene.load):
        require_made(scene)
    state = None if start is None else _on_scene(scene, State.given(start, scheme))
    steps = steps_of(dt, tol, t_end, stride=stride, length=scene.length, start=state, chosen=chosen)
    bound = math.inf if energy_bound is None else real_number("energy_bound", energy_bound)
    if scene.info.multipliers or scene.info.contacts:
        require_decay(scene.name, scheme)
    if isinstance(steps, Control) and scene.info.reactions:
        behind = state and _behind_jump(scene, state)
        return march_to_events(scene, scheme, steps, _vectors(scene, behind), behind, bound)
    if isinstance(steps, Control):
        return march_adaptive(scene, scheme, steps, bound=bound, start=state and _behind_jump(scene, state))
    n, stride = steps.n, steps.stride
    if scene.info.oscillator:
        require_histories(n, stride, 3, 0 if bound == math.inf else 3)
        return _oscillator_response(scene, scheme, steps, bound, state)
    require_histories(n, stride, 3 * scene.u0.shape[-1], scheme.balances + scheme.info.loads * scene.info.sampled)
    more = len(pair_kernels(scene, scheme).STATE) - len(scheme.state)
    labels = [*bare(scheme.state), *["u of the tangent"] * more]
    begin = _begun(steps, state, labels, "scene", scheme)
    lanes = march_lanes(
        scene, scheme, np.array([steps.dt]), np.array([n]), start=_vectors(scene, state), memory=_memory(scene, state),
        begin=begin, bound=bound, stride=stride, history=True, counts=True,
    )  # fmt: skip
    n_done = int(lanes.n_done[0])
    rows = lanes.out[0, : n_done // stride + 1]
    status, iterations = STATUSES[int(lanes.status[0])], lanes.iterations[0, :n_done]
    known = ("scene", labels, lanes.state[0]) if under_way(scheme, begin, n_done) else None
    memory = lanes.memory[0, : len(rows)] if scene.info.memory else None
    first, largest = abs(float(lanes.first[0])), float(lanes.peak[0])
    growth = largest / first if first else math.inf
    return _response(scene, scheme, steps, rows, n_done, status, iterations, state, known, growth, memory)


def _on_scene(scene: Scene, state: State) -> State:
    """The state where a run of the scene begins, with its acceleration. Raises ValueError for other coordinates."""
    for name, x in (("u", state.u), ("v", state.v), ("a", state.a), *state.history.items()):
        if x is not None and x.shape != scene.u0.shape:
            coordinates = ", ".join(name for name, _ in scene.coordinates)
            raise ValueError(
                f"expected {name} of start with {len(scene.u0)} numbers, for the coordinates {coordinates} of "
                f"{scene.name}, got shape {x.shape}; give one for each"
            )
    held = scene.info.reactions
    if held and not state.of:  # a run's own velocities leave constraints by the scheme's error
        scene.require_allowed(state.u, state.v, state.t)
    if held and not state.memory.keys() & set(held):
        state = _with_reactions(scene, state)
    if missing := set(scene.info.memory) ^ set(state.memory):
        raise ValueError(
            f"expected memory of start with {', '.join(scene.info.memory) or 'nothing'}, what the laws of {scene.name} "
            f"remember, got {', '.join(state.memory) or 'none'}: see {', '.join(sorted(missing))}; give r.state, or "
            "memory={...} beside u and v"
        )
    if state.a is not None:
        return state
    at = np.array([state.t]), state.u[None], state.v[None]
    memory = _memory(scene, state)
    return replace(state, a=scene.acceleration(*at, None if memory is None else memory[None])[0])


def _with_reactions(scene: Scene, state: State) -> State:
    """A state that does not say what multipliers and pressures are, with those of the equations of motion."""
    at = np.array([state.t]), state.u[None], state.v[None]
    memory = np.array([[state.memory.get(name, 0.0) for name in scene.info.memory]])
    laws, c = scene.info.laws, len(scene.info.multipliers)
    if scene.info.contacts and not scene.info.impulsive:
        memory[:, laws + c :] = pressures(scene, *at, memory)
    if c:
        memory[:, laws : laws + c] = scene.multipliers(*at, memory)
    names = scene.info.memory[laws:]
    return replace(state, memory={**state.memory, **dict(zip(names, memory[0, laws:].tolist(), strict=True))})


def _memory(scene: Scene, state: State | None) -> Array | None:
    """What laws remember (k,) where a run begins, None where there is none or the scene's own start."""
    return memory_of(scene, state) if state is not None and scene.info.memory else None


def _behind_jump(scene: Scene, state: State) -> State:
    """The state with the acceleration under the load just after its time, where the load jumps there.

    A run that has ended at the jump has the one before it, and chosen steps begin anew.
    """
    force = behind_jump(scene.load, state.t)
    if force is None:
        return state
    memory = _memory(scene, state)
    rows = np.array([state.t]), state.u[None], state.v[None], None if memory is None else memory[None]
    return replace(state, a=scene.acceleration(*rows, force=force)[0])


def _vectors(scene: Scene, state: State | None) -> tuple[Array, Array, Array]:
    """u, v, a where a run begins, (1, d) each."""
    if state is None:
        return scene.u0, scene.v0, scene.a0
    assert state.a is not None
    return state.u, state.v, state.a


def _begun(steps: ConstantSteps, state: State | None, labels: Sequence[str], kind: str, scheme: Scheme) -> Begin:
    """Where steps begin, with what the scheme carries there if that is known."""
    if state is None:
        return steps.begin
    return steps.begin._replace(rows=state.rows(labels, whose(scheme, kind), steps.dt))


def _response(
    scene: Scene,
    scheme: Scheme,
    steps: ConstantSteps,
    rows: Array,
    n_done: int,
    status: Status,
    iterations: Any,
    started: State | None,
    known: tuple[str, Sequence[str], Array] | None,
    growth: float = math.inf,
    memory: Array | None = None,
) -> Response:
    """The response from rows (steps, 3, d) of u, v, a, or (steps, 2, d) of u, v for a scheme without its own a.

    known: what the scheme carries after the last step, as the kind of run, labels and rows; it belongs to the last row,
    if that is not an earlier one.
    """
    failed = None if status == "completed" else steps.time(n_done + 1)
    own_a = rows[:, 2] if rows.shape[1] > 2 else None
    remembered = {} if memory is None else dict(zip(scene.info.memory, memory[-1].tolist(), strict=True))
    at_end, row = (len(rows) - 1) * steps.stride, rows[-1].copy()  # whatever becomes of histories in a user's hands
    last = partial(_stands, scheme, steps, at_end, n_done, row, known, remembered)
    return Response(
        rows[:, 0], rows[:, 1], iterations, status, failed, scene, scheme, steps.stride * steps.dt, own_a,
        steps.times(len(rows)), started=started, last=last, growth=growth, memories=memory,
    )  # fmt: skip


def _stands(
    scheme: Scheme,
    steps: ConstantSteps,
    at_end: int,
    n_done: int,
    row: Array,
    known: tuple[str, Sequence[str], Array] | None,
    memory: Mapping[str, float],
) -> State:
    """The state in the last row, after at_end of the n_done steps."""
    u, v, *a = row
    here = replace(steps.state(at_end, u, v, a[0] if a else None), memory=memory)
    if known is None or at_end != n_done:
        return here
    kind, labels, x = known
    return replace(here, history=dict(zip(labels, x.copy(), strict=True)), of=whose(scheme, kind))


def _oscillator_response(
    scene: Scene, scheme: Scheme, steps: ConstantSteps, bound: float, state: State | None
) -> Response:
    labels = [scheme.state[k] for k in coefficients.marched(scheme)]
    begin = _begun(steps, state, labels, "oscillator", scheme)
    lanes = march_oscillators(
        scene, scheme, steps.dt, steps.n, 1, start=_vectors(scene, state), begin=begin, bound=bound, stride=steps.stride
    )
    n_done = int(lanes.n_done[0])
    iterations = np.ndarray((n_done, scheme.balances), np.int64, bytes(8), strides=(0, 0))  # read-only zeros, as one 0
    rows = lanes.out[: n_done // steps.stride + 1]
    status = STATUSES[int(lanes.status[0])]
    carries = status == "completed" and under_way(scheme, begin, n_done)
    known = ("oscillator", labels, lanes.x) if carries else None
    return _response(scene, scheme, steps, rows, n_done, status, iterations, state, known)


def march_oscillators(
    scene: Scene,
    scheme: Scheme,
    dt: float,
    n: int,
    P: int,
    *,
    start: tuple[Array, Array, Array] | None = None,
    begin: Begin = AT_ZERO,
    bound: float = math.inf,
    stride: int = 1,
    keep: Literal["history", "peak"] = "history",
    peaks: Sequence[Array] | None = None,
) -> LinearLanes:
    """P runs of n steps of a linear oscillator's scene; parameters of scene, load and scheme may be arrays (P,).

    start, begin: as for `march_lanes` of scenes. peaks: as for `march_linear`, if there is no bound. bound, J: a lane
    ends before the first state whose energy exceeds it; with a bound all histories are in memory at once.
    """
    assert scene.info.oscillator is not None
    values = scene.info.oscillator(*scene.parameters.values())
    omega, xi, mass, steps = (repeated(x, P) for x in (*values, dt))
    consistent = start is None and (scene.a0_asked is None or isinstance(scene.a0_asked, str))
    vectors = [repeated(x[..., 0], P) for x in start or (scene.u0, scene.v0, scene.a0)]
    o = Oscillators(omega, xi, mass, steps, vectors)
    more: dict[str, Any] = {"begin": begin, "consistent": consistent}
    if bound == math.inf:
        return march_linear(scheme, o, n, scene.load, stride=stride, keep=keep, peaks=peaks, **more)
    lanes = march_linear(scheme, o, n, scene.load, **more)
    u, v = (lanes.out[:, kind].T[..., None] for kind in (0, 1))
    beyond = scene.energy(dt * np.arange(n + 1.0), u, v) > bound  # False after n_done, where it is NaN
    ended = beyond.any(axis=1)
    n_done = np.where(ended, np.maximum(np.argmax(beyond, axis=1) - 1, 0), lanes.n_done)
    status = np.where(ended, STATUSES.index("energy_bound"), lanes.status)
    for j in np.flatnonzero(ended):
        lanes.out[n_done[j] + 1 :, :, j] = np.nan
    if keep == "peak":
        peak = np.nanmax(np.abs(lanes.out), axis=0)
        return replace(lanes, out=lanes.out[:0], peak=peak, n_done=n_done, status=status)
    return replace(lanes, out=lanes.out[::stride], n_done=n_done, status=status)
