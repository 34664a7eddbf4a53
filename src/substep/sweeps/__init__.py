"""Many runs in one call: the outer product of any parameters, with its results in one Dataset."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ..core import single
from ..core.arrays import Array, copy_rows, named
from ..core.device import Device, found, on
from ..core.errors import called_as, whole
from ..core.loads import Load
from ..core.memory import require_memory
from ..core.progress import shown
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..core.threads import at_most, cores
from ..marching.run import require_in_order
from ..run.axes import Keep
from ..structures.structure import Modes, Structure
from .cluster import run_on
from .draws import drawn, is_distribution, require_drawable
from .precision import compared
from .scene_plan import ScenePlan, planned
from .store import Store
from .structure_plan import planned_structure
from .sweep_plan import Chunk, Results, SweepPlan, Variable

if TYPE_CHECKING:
    import xarray
    from distributed import Client

    from ..derived.modules import Declaration, SceneDeclaration


@called_as('sweep("duffing", "bathe", dt=0.01, t_end=10.0, u0=[0.5, 1.0])')
def sweep(
    scene: Scene | str | SceneDeclaration | Structure | list[Structure] | tuple[Structure, ...],
    scheme: Scheme | str | Declaration,
    *,
    t_end: float,
    dt: ArrayLike | None = None,
    tol: ArrayLike | None = None,
    keep: Keep = "final",
    samples: int | None = None,
    seed: int = 0,
    energy_bound: float | None = None,
    a0: ArrayLike | str | None = None,
    load: Load | Sequence[Any] | None = None,
    save: str | Path | None = None,
    client: Client | None = None,
    device: Device = "cpu",
    dtype: single.Dtype = "float64",
    workers: int | None = None,
    progress: bool = True,
    **axes: Any,
) -> xarray.Dataset:
    """March every combination of the axes from t = 0 to t_end (s); one Dataset with a dimension for each.

    scene, scheme: a name or declaration, or a handle, which stands for the parameters that it was given. The axes
    override these; parameters that were not given take their default, which may depend on a swept parameter. dt: the
    step in s, a number or an axis, which is the first. tol, in place of dt: a number or an axis too, the tolerance by
    which each run chooses steps of its own, with rtol, atol, dt_first, dt_min, dt_max, rung as in `substep.march`; then
    keep="history" needs grid, the times of its rows.

    A structure, or a list of them, is swept as `substep.sweeps.structure_plan.planned_structure` says.

    axes: any parameter of scheme, scene or load (except of a Record), or a family's argument, by name: a row of values
    becomes a dimension, in the order of the call, a number does not. A name that two of them have needs a prefix, as in
    scheme_gamma, scene_omega, load_omega; any other may have it. overdamped, and for a scene that is not a handle a0,
    load, and strain of elastic_pendulum, are those of `substep.scene`.

    An uncertain parameter is a distribution of `scipy.stats` with its parameters, such as scipy.stats.norm(1.0, 0.1):
    all of a call are drawn together, with samples=N points along one dimension "draw", the last, whose coordinates are
    the values drawn, by the parameters' names. Points are those of Sobol' in `replicate`s, each scrambled by itself
    from the seed, the same in every call; `substep.uncertainty` takes means and their standard errors. Values that you
    draw yourself, correlated ones too, are one-dimensional xarray.DataArrays: those with the same dimension vary
    together along it.

    keep: "final", u, v, a and energy at t_end; "peak", the largest |u|, |v|, |a| of each coordinate from t = 0 on as
    peak_u, peak_v, peak_a, and peak_energy of a scene that is not a linear oscillator; "history", u, v, a and energy at
    every step, or, with samples=N, at the ends of N equal intervals. Several dt need samples, and N has to divide every
    number of steps. energy_bound: as in `substep.march`, in J.

    The Dataset also has status (see its flag_meanings; -1 for a run not yet made), n_done (steps completed) or, where
    steps are chosen, accepted and rejected (steps) and t_failed (s, the end of the step that could not be made),
    newton_iterations (mean over the steps, for each balance, 0 where it is linear) and newton_most (the largest number
    in a step). Where a run failed, what it did not reach is NaN, which is all of "final"; peaks are those of the steps
    completed. attrs hold what all points share.

    save: a folder for a Zarr store (the extra `save`), which is written chunk by chunk and read from when the Dataset
    is used; the same call again goes on where it was stopped, even by a kill. client: a dask.distributed client, whose
    workers take the chunks. device: "cuda" for the threads of a GPU, a run each, "auto" for a GPU if there is one and
    it can take the runs, which it cannot of a structure; with client, the device of each worker. Results
    are those of the CPU up to rounding, or the tolerance of Newton's iteration. dtype: "float32" marches in single
    precision, with twice the lanes at once; up to 64 runs, and as many of those that failed, are made in double
    precision too. Then attrs say how many digits remain of the variable that keeps fewest, float32_digits, how many of
    the runs compared, float32_compared, ended at another step or with another status, float32_differ, and of each
    variable the largest error found, relative to the largest value of the run (of all runs compared, for "final"),
    float32_error. A warning says so where fewer than three digits remain or a run differs. Values are stored as
    float64. workers: the most cores that this process uses, by threads; by default all. progress: a bar on the terminal
    once it has taken a second. Ctrl-C returns what is done, with attrs["interrupted"] = 1.

    Raises ValueError, before anything is run, for names and values that do not fit, for both or neither of dt and tol,
    for a scheme that cannot change its step where steps are chosen, for draws outside of what a parameter allows, for
    t_end that is not a multiple of every dt, for a save that holds another sweep, and for float32 of a structure, with
    tol and of a scene whose energies depend on time; ImportError for save where zarr is not
    installed, and for device="cuda" where numba has no CUDA; RuntimeError where there is no such device. If running
    raises, the exception's `dataset` is what was done.

    >>> ds = ss.sweep("linear_oscillator", "newmark", omega=[1.0, 2.0], dt=[0.1, 0.2, 0.5], t_end=1.0)
    >>> dict(ds.u.sizes)
    {'dt': 3, 'omega': 2, 'coordinate': 1}
    """
    if isinstance(scene, Modes):
        raise ValueError(
            "expected a scene or a structure to sweep, got modes; sweep their structure, or march modes one by one"
        )
    require_in_order("sweep", scene, scheme)
    replicate: xarray.Variable | None = None
    if any(map(is_distribution, axes.values())) or is_distribution(dt) or is_distribution(tol):
        require_drawable(isinstance(scene, Structure | list | tuple), dt=dt, tol=tol, keep=keep)
        axes, replicate = drawn(axes, samples, seed)
        samples = None
    shared: dict[str, Any] = {"dt": dt, "tol": tol, "t_end": t_end, "keep": keep, "samples": samples}
    shared |= {"energy_bound": energy_bound, "a0": a0, "load": load, "device": device}
    most = None if workers is None else whole("workers", workers, 1, "cores", "leave it out for all")
    if client is None:
        found(device)
    if isinstance(scene, Structure | list | tuple):
        single.require_possible(dtype, {"for a structure": True})
        plan = planned_structure(scene, scheme, **shared, save=save, **axes)
    else:
        plan = planned(scene, scheme, **shared, dtype=dtype, values=axes)
    variables = plan.variables
    if save is None:
        _require_room(variables, plan.shape)
    shell, piece = plan.template(), plan.piece(client is not None)
    if replicate is not None:
        shell = shell.assign_attrs(replicate.attrs).assign_coords(replicate=replicate)  # pyright: ignore[reportUnknownMemberType]
    store = None if save is None else Store(Path(save), plan, shell, piece)
    targets = _targets(variables, plan.shape) if store is None else store.targets
    todo = plan.chunks(piece if store is None else store.piece)
    if store is not None:
        todo = [chunk for chunk in todo if not store.is_done(chunk)]
    room = targets if store is None else None
    blocks = _here(plan, todo, room, most) if client is None else run_on(client, plan, todo)
    left = {chunk.first: chunk for chunk in todo}

    def result(interrupted: bool) -> xarray.Dataset:
        if store is not None:
            store.mark(interrupted)
            return with_digits(store.read())
        for chunk in left.values():
            _reset(targets, variables, chunk)
        found = {name: named((*plan.dims, *v.dims), targets[name], v.attrs) for name, v in variables.items()}
        return with_digits(shell.assign(found).assign_attrs(interrupted=int(interrupted)))

    def with_digits(ds: xarray.Dataset) -> xarray.Dataset:
        if dtype == "float64":
            return ds
        assert isinstance(plan, ScenePlan)
        with at_most(most):
            return compared(plan, ds)

    try:
        _fill(targets, variables, blocks, left, math.prod(plan.shape), progress)
    except KeyboardInterrupt:
        return result(interrupted=True)
    except Exception as error:
        error.dataset = result(interrupted=True)  # type: ignore[attr-defined]
        error.add_note("what the sweep had done before is in the attribute `dataset` of this exception")
        raise
    return result(interrupted=False)


NEWTON = "newton_iterations", "newton_most"
ROUNDS = 2  # chunks a core, from which on cores run chunks of their own, with all that is around their kernels
Blocks = Generator[tuple[Chunk, Results]]


def _require_room(variables: Mapping[str, Variable], shape: tuple[int, ...]) -> None:
    """Raises MemoryError where the results do not fit in memory."""
    size = sum(math.prod((*shape, *v.sizes)) * v.fill.dtype.itemsize for v in variables.values())
    cure = "keep fewer dofs or samples, 'peak' or 'final', sweep in parts, or save= to a folder"
    require_memory([-(-size // 8)], cure)


def _targets(variables: Mapping[str, Variable], shape: tuple[int, ...]) -> dict[str, Array]:
    """Where the results of each variable go: whatever is there, since chunks that are left are reset.

    The status begins with its fill value. Counts of Newton's iteration begin as zeros, which take no memory before they
    are written to, and are not where nothing is iterated.
    """

    def target(name: str, v: Variable) -> Array:
        size = *shape, *v.sizes
        if name == "status":
            return np.full(size, v.fill)
        return (np.zeros if name in NEWTON else np.empty)(size, v.fill.dtype)

    return {name: target(name, v) for name, v in variables.items()}


def _here(
    plan: SweepPlan, chunks: Sequence[Chunk], targets: Mapping[str, Array] | None, workers: int | None
) -> Blocks:  # fmt: skip
    """Run the chunks: many each on one core, or few one after another, each on all cores, as on a GPU.

    targets: in which their results may be put at once.
    """
    with at_most(workers):
        together = cores()
    if len(chunks) < ROUNDS * together or found(plan.device) or not plan.in_threads:
        together = 1

    def run(chunk: Chunk) -> Results:
        places = {name: target[chunk.where] for name, target in (targets or {}).items()}  # contiguous, as points are
        room = {name: x.reshape(chunk.last - chunk.first, *x.shape[len(plan.shape) :]) for name, x in places.items()}
        with on(plan.device), single.on(plan.dtype), at_most(workers if together == 1 else 1):
            return plan.run(chunk.first, chunk.last, room)

    if together == 1:
        yield from ((chunk, run(chunk)) for chunk in chunks)
        return
    with ThreadPoolExecutor(together) as pool:
        waiting, running = iter(chunks), deque[tuple[Chunk, Future[Results]]]()
        try:
            while True:
                running.extend(
                    (chunk, pool.submit(run, chunk)) for chunk in islice(waiting, together + 1 - len(running))
                )
                if not running:
                    return
                chunk, results = running.popleft()
                yield chunk, results.result()
        finally:
            for _, results in running:
                results.cancel()


def _fill(
    targets: Mapping[str, Any],
    variables: dict[str, Variable],
    blocks: Blocks,
    left: dict[int, Chunk],
    total: int,
    show: bool,
) -> None:
    """Put results into their place, the status last; a chunk that fails in between is reset to the fill values.

    left: the chunks not yet done by their first point; those that are done are removed from it.
    """
    runs = sum(chunk.last - chunk.first for chunk in left.values())
    with shown(total, total - runs, show) as advance, closing(blocks):
        for chunk, results in blocks:
            shape = tuple(s.stop - s.start for s in chunk.where)
            try:
                for name in variables:
                    found, target = results[name].reshape((*shape, *results[name].shape[1:])), targets[name]
                    if not _is_there(name, found, target, chunk):
                        _put(found, target, chunk)
            except BaseException:
                _reset(targets, variables, chunk)
                raise
            del left[chunk.first]
            advance(chunk.last - chunk.first)
    if left:
        runs = sum(chunk.last - chunk.first for chunk in left.values())
        raise RuntimeError(f"expected results of every run, {runs} did not come; please report this")


def _put(found: Array, target: Any, chunk: Chunk) -> None:
    """Put results of a chunk into the target, a store's array or one of NumPy."""
    rows = found.size > 0 and found.ndim > len(chunk.where) and found.strides[-1] == found.itemsize
    if rows and isinstance(target, np.ndarray):
        there = cast("Array", target)[chunk.where]
        if there.dtype == found.dtype:
            copy_rows(found, there)
            return
    target[chunk.where] = found


def _is_there(name: str, found: Any, target: Any, chunk: Chunk) -> bool:
    """Whether the results of a chunk were put into the target itself, or are one zero where it begins with zeros."""
    if not isinstance(target, np.ndarray):
        return False
    there = cast("Array", target)[chunk.where]
    zeros = name in NEWTON and found.size > 0 and not any(found.strides) and found.flat[0] == 0 == there.flat[0]
    return bool(zeros) or np.may_share_memory(found, there)


def _reset(targets: Mapping[str, Any], variables: dict[str, Variable], chunk: Chunk) -> None:
    """Fill values in place of a chunk's results, the status first."""
    for name, variable in reversed(variables.items()):
        targets[name][chunk.where] = variable.fill
