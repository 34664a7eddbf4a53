"""Many runs of one scheme on one scene at once: lanes of the kernel generated for the two, spread over threads."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..core import constraints, device, single
from ..core.arrays import Array, copy_rows
from ..core.kernel_modules import committed, printed
from ..core.loads import LoadLanes
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..core.state import State
from ..core.threads import spread
from ..derived import modules
from ..run.clock import AT_ZERO, Begin
from ..run.schemes import carried, require_acceleration

FEW = 16  # fewer lanes march one by one: in a block all lanes wait for the one whose Newton iteration takes longest
LEAST = 64  # lanes of a thread's part, a block: with fewer the processor waits for the results of an iteration
TOLERANCE = 1e-12  # Newton's iteration ends at a correction of u smaller than this times the scene's length
NEAR = 1 << 17  # numbers of histories that are read as soon as they are written, from the second cache
ON_DEVICE = 1 << 27  # the same for those that a GPU writes, from the memory of the CPU

# takes of some lanes the rows (lanes, steps // stride + 1, 2 or 3, d) and what laws remember (lanes, the same, k), both
# NaN after the last step completed
Reader = Callable[[slice, Array, Array], None]


@dataclass(frozen=True, eq=False)
class Lanes:
    """Results of P runs.

    out (P, rows, 2 or 3, d): u, v (and a, if the scheme has its own) every stride steps, no rows without a history;
    memory (P, rows, k): what laws remember there; state (P, m, d): last good state, rows as the kernel's STATE;
    remembered (P, k): what laws remember there; newton (P, 2, balances): Newton iterations of the
    steps completed, their sum and the most in one step; iterations (P, steps, balances): those of each step, no steps
    unless asked for; extremes (P, 0, 1 or all kinds, d): the largest moduli of u, v (and a), of those asked for, at
    every stride-th step, the start among them; first, peak (P,): the energy at the start and the largest from there on,
    J; n_done (P,): steps completed; status (P,): index in response.STATUSES.
    """

    out: Array
    memory: Array
    state: Array
    remembered: Array
    newton: NDArray[np.int64]
    iterations: NDArray[np.int64]
    extremes: Array
    first: Array
    peak: Array
    n_done: NDArray[np.int64]
    status: NDArray[np.int64]


def pair_kernels(scene: Scene, scheme: Scheme) -> ModuleType:
    """The kernels of the scheme on the scene: committed, or printed to the user's cache on first use."""
    if scheme.info.declaration is None and scene.info.declaration is None:
        return _from_catalogue(scheme.name, scene.name)
    return _own(scheme.info.source, scene.info.source)


_own = cache(modules.uncommitted_pair)


@cache
def _from_catalogue(scheme: str, scene: str) -> ModuleType:
    return committed(f"pairs.{scheme}__{scene}") or modules.uncommitted_pair(scheme, scene)


def march_lanes(
    scene: Scene,
    scheme: Scheme,
    dt: Array,
    n: NDArray[np.int64],
    *,
    start: tuple[Array, Array, Array] | None = None,
    memory: Array | None = None,
    begin: Begin = AT_ZERO,
    bound: Any = np.inf,
    stride: int = 1,
    history: bool = False,
    counts: bool = False,
    extremes: str = "",
    reader: Reader | None = None,
) -> Lanes:
    """P runs with steps dt (P,) of n (P,) steps each; the scheme's parameters may be arrays (P,).

    start: u, v, a at the start, (P, d) each, where they differ from the scene's; memory: what laws remember there,
    (k,) or (P, k). begin: when that is, for all lanes of
    one dt, with rows (P, m, d) of the state where the scheme does not start anew. bound: energy in J beyond which a
    lane stops, a number or (P,). history: keep every stride-th step in `out`; counts: keep `iterations`.
    extremes: "u" or "uva": keep the largest moduli of these, as far as the scheme reports them. reader: called, by
    several threads at once, for ranges of lanes that together are all, with every stride-th step of theirs; it may
    change these rows, which are written over after it returns.
    """
    module = pair_kernels(scene, scheme)
    P, steps = len(dt), int(n.max(initial=0))
    rows = _rows_kept(scheme, module, steps, stride, history, reader)
    u, v, a = (_of_lanes(x, (P, scene.u0.shape[-1])) for x in start or (scene.u0, scene.v0, scene.a0))
    kept, reported = len(module.STATE), len(module.REPORTED)
    followed = min(len(extremes), reported)
    if scene.info.memory:
        memory = _of_lanes(scene.memory0 if memory is None else memory, (P, len(scene.info.memory)))
        a, memory = _held_first(scene, scheme, module, dt, begin, (u, v, a), memory)
    more = 0 if memory is None else -(-memory.shape[1] // u.shape[1])  # rows of as many numbers as coordinates
    scalars = {"h": dt, "since": begin.first + begin.origin / dt, "bound": bound}
    scalars["tolerance"] = (single.TOLERANCE if single.is_on() else TOLERANCE) * scene.length
    scalars |= printed({**scene.parameters, **scheme.parameters})
    arrays: dict[str, Any] = {
        **{name: _of_lanes(x, (P,)) for name, x in scalars.items()},
        **{"u": u, "v": v, "a": a, "n": np.array(n, dtype=np.int64), "first": 0, "stride": stride},
        "state": np.zeros((P, kept + more, u.shape[1])),
        "out": np.zeros((P, rows, reported + more, u.shape[1])),
        "extremes": _moduli((u, v, a)[:followed], u.shape),
        "newton": np.zeros((P, 2, scheme.balances), dtype=np.int64),
        "iterations": np.zeros((P, steps if counts else 0, scheme.balances), dtype=np.int64),
        **{name: np.empty(P, dtype=np.int64) for name in ("n_done", "status")},
        "peak": np.empty(P),
    }
    if memory is not None:
        put_memory(arrays["state"], kept, memory)
    if arrays["out"].shape[1]:
        _put_start(arrays, module, slice(None), arrays["out"])
    if scene.info.sampled:
        values = [np.broadcast_to(x, P) for x in scheme.parameters.values()]
        stencil, at_start = (_columns(f(*values), P) for f in (module.stencil, module.start_stencil))
        every = np.arange(begin.first, begin.first + steps)[:, None]
        own = slice(1 if _share_loads(scene, scheme, dt) else None)
        at = begin.origin + (every + stencil[own, None]) * dt[own, None, None]
        arrays["forces"] = single.rounded(scene.forces(at))
        arrays["start_forces"] = scene.forces(begin.origin + (begin.first + at_start) * dt[:, None])
    head = None
    if begin.rows is not None:
        arrays["state"][:, :kept] = begin.rows
    elif scheme.starter is not None:
        head = _head(scene, scheme, module, arrays, (u, v, a), memory, begin)
    elif module.START_ARGUMENTS:
        module.start(*(arrays[name] for name in module.START_ARGUMENTS))
        arrays["state"][:, len(scheme.state) : kept] = u[:, None]  # where a scheme takes the tangent at the start
    else:
        for k, (kind, _) in enumerate(module.STATE):
            copy_rows(arrays[kind], arrays["state"][:, k])
    _run(module, arrays, P, steps // stride + 1, reader, len(scene.info.memory), _threads(scene, scheme, module))
    energy = scene.energy(begin.origin + begin.first * dt, u, v, memory)
    peak = np.maximum(arrays["peak"], energy)
    if head is not None:
        early = head.n_done < np.minimum(n, arrays["first"])
        for name in ("n_done", "status"):
            arrays[name][early] = getattr(head, name)[early]
        peak = np.maximum(peak, head.peak)
        of_head = head.iterations.sum(axis=2)  # the starter's balances are other ones: they count as the first
        arrays["newton"][:, 0, 0] += of_head.sum(axis=1)
        arrays["newton"][:, 1, 0] = np.maximum(arrays["newton"][:, 1, 0], of_head.max(axis=1, initial=0))
        arrays["iterations"][:, : arrays["first"], 0] = of_head[:, : arrays["iterations"].shape[1]]
    k, out, state = len(scene.info.memory), arrays["out"], arrays["state"]
    names = "newton", "iterations", "n_done", "status"
    return Lanes(
        out=out[:, :, :reported], memory=memory_in(out, reported, k), state=state[:, :kept],
        remembered=memory_in(state, kept, k), extremes=arrays["extremes"].reshape(P, followed, u.shape[1]),
        first=energy, peak=peak, **{name: arrays[name] for name in names},
    )  # fmt: skip


def memory_of(scene: Scene, state: State) -> Array:
    """What laws remember (k,) at a state."""
    return np.array([state.memory[name] for name in scene.info.memory])


def put_memory(rows: Array, first: int, memory: Array) -> None:
    """Put what laws remember (..., k) into the rows (..., m, d) from the first on."""
    d = rows.shape[-1]
    for i in range(memory.shape[-1]):
        rows[..., first + i // d, i % d] = memory[..., i]


def memory_in(rows: Array, first: int, k: int) -> Array:
    """What laws remember, k numbers (..., k), from rows (..., m, d), from the first on."""
    m, d = rows.shape[-2:]
    return rows[..., first:, :].reshape(*rows.shape[:-2], (m - first) * d)[..., :k]


def _held_first(
    scene: Scene,
    scheme: Scheme,
    module: ModuleType,
    dt: Array,
    begin: Begin,
    start: tuple[Array, Array, Array],
    memory: Array,
) -> tuple[Array, Array]:
    """a (P, d) and what is remembered (P, k) where runs begin, with the reactions that hold their first step."""
    u, v, a = start
    if begin.rows is not None or not hasattr(module, "held_first"):
        return a, memory
    first = module.held_first(dt, *scheme.parameters.values())
    change, reactions = constraints.held_first(scene, begin.origin + begin.first * dt, u, v, a, *first)
    return a + change, memory + np.pad(reactions, ((0, 0), (scene.info.laws, 0)))


def _of_lanes(x: Any, shape: tuple[int, ...]) -> Array:
    """The numbers of P lanes (P, ...), in the form for which kernels are compiled: as they are if they have it."""
    if isinstance(x, np.ndarray):
        given = cast("Array", x)
        right = given.shape == shape and given.dtype == np.float64
        if right and given.flags.c_contiguous and given.flags.writeable:  # kernels only read it
            return given
    found, given = np.empty(shape), np.ascontiguousarray(x, dtype=np.float64)
    if len(shape) > 1 and given.shape[-1] == shape[-1]:
        copy_rows(given, found)
    else:
        found[...] = given
    return found


def _moduli(rows: Sequence[Array], shape: tuple[int, int]) -> Array:
    """The moduli of k arrays of that shape (P, d), side by side (P, k d)."""
    P, d = shape
    found = np.empty((P, len(rows), d))
    for k, x in enumerate(rows):
        copy_rows(x, found[:, k])
    return np.abs(found, out=found).reshape(P, len(rows) * d)


def _share_loads(scene: Scene, scheme: Scheme, dt: Array) -> bool:
    """Whether the load is the same in every lane, at the same instants: one row of it serves them all."""
    alike = len(dt) > 0 and bool((dt == dt[0]).all()) and not isinstance(scene.load, LoadLanes)
    return alike and all(np.ndim(x) == 0 for x in scheme.parameters.values())


def _rows_kept(
    scheme: Scheme, module: ModuleType, steps: int, stride: int, history: bool, reader: Reader | None
) -> int:
    """Rows of all lanes that are in memory at once: none, all, or for a reader those that the starter gives."""
    if history:
        return steps // stride + 1
    if reader is None or scheme.starter is None:
        return 0
    return min(steps, scheme.starting_steps) // stride + 1


def _put_start(arrays: Mapping[str, Any], module: ModuleType, lanes: slice, out: Array) -> None:
    """Put u, v, a, and what laws remember, at the start of some lanes into the first row of out, their histories."""
    reported = len(module.REPORTED)
    for k, name in enumerate("uva"[:reported]):
        copy_rows(arrays[name][lanes], out[:, 0, k])
    out[:, 0, reported:] = arrays["state"][lanes, len(module.STATE) :]


def _columns(numbers: Sequence[Any], P: int) -> Array:
    """K numbers or arrays (P,) as the columns of an array (P, K)."""
    return np.array([np.full(P, x) for x in numbers]).reshape(len(numbers), P).T


def _head(
    scene: Scene,
    scheme: Scheme,
    module: ModuleType,
    arrays: dict[str, Any],
    start: tuple[Array, Array, Array],
    memory: Array | None,
    begin: Begin,
) -> Lanes:
    """March the first steps with the scheme's starter; fill the state and the rows of these steps.

    Sets `first`, the step from which the scheme itself goes on, and lowers n of the lanes that have failed by then.
    """
    assert scheme.starter is not None
    require_acceleration(scheme, len(module.REPORTED), len(pair_kernels(scene, scheme.starter).REPORTED))
    n, every = arrays["n"], np.arange(len(arrays["n"]))
    steps = np.minimum(n, scheme.starting_steps)
    head = march_lanes(
        scene, scheme.starter, arrays["h"], steps,
        start=start, memory=memory, begin=begin, bound=arrays["bound"], history=True, counts=True,
    )  # fmt: skip
    history = [("uva".index(kind), lag) for kind, lag in module.STATE]
    rows, reported = carried(history, steps, lambda k, kind: head.out[every, k, kind]), len(module.REPORTED)
    arrays["state"][:, : len(history)] = rows.swapaxes(0, 1)
    if memory is not None:
        put_memory(arrays["state"], len(history), head.remembered)
    so_far = arrays["extremes"]
    # a step that was not reached is 0
    passed = np.abs(head.out[:, :: arrays["stride"], :reported]).max(axis=1).reshape(len(so_far), -1)
    np.maximum(so_far, passed[:, : so_far.shape[1]], out=so_far)
    out = arrays["out"]
    for row in range(min(out.shape[1], int(steps.max(initial=0)) // arrays["stride"] + 1)):
        out[:, row, :reported] = head.out[:, row * arrays["stride"], :reported]
        if memory is not None:
            put_memory(out[:, row], reported, head.memory[:, row * arrays["stride"]])
    arrays["n"] = np.where(head.n_done < steps, head.n_done, n)
    arrays["first"] = scheme.starting_steps
    return head


def _threads(scene: Scene, scheme: Scheme, module: ModuleType) -> Callable[..., None] | None:
    """The march in the threads of a GPU where that is asked for."""
    return device.march_of_pair(scheme.info.source, scene.info.source, module.ARGUMENTS) if device.is_on() else None


def _run(
    module: ModuleType,
    arrays: Mapping[str, Any],
    lanes: int,
    rows: int,
    reader: Reader | None,
    remembered: int,
    threads: Callable[..., None] | None,
) -> None:
    """March all lanes: a few one by one, many in blocks. Parts are small, since slow lanes are often neighbours.

    threads: the march in the threads of a GPU, which takes all of them.
    """
    few = lanes < FEW and not single.is_on()
    if threads is not None:
        march, least, cost = threads, max(lanes, 1), 0
    else:  # cost: ns a step of a lane
        march, least, cost = (module.march, 1, 100) if few else (single.here(module).march_block, LEAST, 4)
    given = [arrays[name] for name in module.ARGUMENTS]

    shared = arrays["forces"] if "forces" in arrays and len(arrays["forces"]) == 1 else None

    def of(chosen: slice) -> list[Any]:
        """The arguments of some lanes; one row of loads serves them all."""
        return [x[chosen] if isinstance(x, np.ndarray) and x is not shared else x for x in given]

    def part(first: int, last: int) -> None:
        march(*of(slice(first, last)))

    def part_read(first: int, last: int) -> None:
        assert reader is not None
        early, place = arrays["out"], module.ARGUMENTS.index("out")
        block, near = (least, NEAR) if threads is None else (1, ON_DEVICE)
        together = min(last - first, block * max(1, near // (block * rows * math.prod(early.shape[2:]))))
        room = np.empty((together, rows, *early.shape[2:]))
        for begin in range(first, last, together):
            chosen = slice(begin, min(begin + together, last))
            own = of(chosen)
            own[place] = out = room[: chosen.stop - begin]
            if early.shape[1]:
                out[:, : early.shape[1]] = early[chosen]
            else:
                _put_start(arrays, module, chosen, out)
            march(*own)
            kept = arrays["n_done"][chosen] // arrays["stride"] + 1
            if kept.min() < rows:
                out[np.arange(rows) >= kept[:, None]] = np.nan
            reported = len(module.REPORTED)
            reader(chosen, out[:, :, :reported], memory_in(out, reported, remembered))

    spread(part if reader is None else part_read, lanes, least, nanoseconds=cost * int(arrays["n"].sum()))
