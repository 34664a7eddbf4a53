"""Mode superposition: modes are marched as oscillators, or together where damping couples them, and added up.

An oscillator is a lane of the linear march. Each load has lanes of its own, from rest under the load alone, and so has
the start; what belongs to a mode is a factor of its lanes, and goes into the matrix that adds the modes up.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import ALONE, Array
from ...core.memory import require_memory
from ...core.outcome import Status
from ...core.schemes import Scheme
from ...core.state import State, whose
from ...marching.histories import histories
from ...marching.linear import march_linear
from ...run.clock import ConstantSteps
from ...run.schemes import numbers_only, under_way
from ..march.going_on import kind_of as structure_kind
from ..march.histories import accounted
from ..march.march_structure import march_structure
from ..march.refusals import require_linear, unknown_in_march
from ..march.response import Account, StructureResponse
from ..march.velocity import needs_no_damping
from ..model.constraints import transformation
from ..model.given import Dof
from ..model.model import Model
from ..solvers.matrices import checked, reduced
from .modal_energies import ModalEnergies
from .modal_lanes import going_on, kind_of, modal_start, room_for
from .modes import ModalBasis


def superpose(
    modes: ModalBasis,
    scheme: Scheme | str,
    dt: float | None,
    t_end: float | None,
    *,
    dofs: Iterable[Dof] | None = None,
    stride: int = 1,
    static_correction: bool = False,
    account: bool = True,
    start: Any = None,
    **others: Any,
) -> StructureResponse:
    """The response of a structure from t = 0 to t_end in steps of dt by the superposition of its modes.

    With classical damping every mode is a lane of the linear march; else the modes are marched together, as a small
    structure. dofs: names or numbers of the degrees of freedom wanted, all by default. stride: keep every stride-th
    step. static_correction: add to u what the other modes contribute to the static response under the load at each
    time, their residual flexibility; u alone is corrected, and it is that of the load already at t = 0. The part of the
    start and of loads that the modes do not have is left out otherwise. account: whether to add up the energies of the
    modes at each step, without the correction; a warning is given as in a march of the structure. start: as for the
    structure; of another start than that of these modes, the part that they have.

    Raises ValueError for what `march` does, for a structure with an internal force, for unknown degrees of freedom, for
    damping with a scheme that takes none, and for static_correction of a free body not all of whose rigid modes are
    given; MemoryError for histories that do not fit in memory.
    """
    if others:
        known = ("dofs", "stride", "static_correction", "account", "start")
        raise unknown_in_march("an argument of march for modes", next(iter(others)), known, scheme)
    state = None if start is None else State.given(start, numbers_only(scheme, "march once for each"))
    if state is not None and state.history and not state.of:
        raise ValueError(
            "expected start of modes without a history, since a scheme carries modal coordinates, got one; leave it "
            "out for the scheme to start anew from u, v, a, or give the response of these modes"
        )
    s, steps = _checked(modes, scheme, dt, t_end, stride, state)
    whole, n = modes.structure, steps.n
    kept = whole.kept(dofs)
    places = [whole.place(dof) for dof in kept]
    part = whole.T[places]
    columns = np.unique(part.indices)  # of all that there are, few are needed
    shapes = np.ascontiguousarray((part[:, columns] @ modes.free_shapes[columns]).T)
    require_memory((n // stride + 1, 3, len(places)), "keep fewer dofs, or a longer stride")
    rows = np.empty((n // stride + 1, 3, len(places)))
    status, done, energies, last = _added_up(modes, s, steps, shapes, rows, account, state)
    rows = rows[: done // stride + 1]
    u, times = rows[:, 0], steps.times(len(rows))
    if static_correction and whole.loads:
        loads = whole.load_values(np.arange(len(rows)) * (stride * steps.dt) if times is None else times)
        u += loads @ (whole.T[places] @ residual_flexibility(modes)).T
    failed = None if status == "completed" else steps.time(done + 1)
    iterations = np.zeros((done, s.balances), np.int64)
    return StructureResponse(
        u, rows[:, 1], iterations, status, failed, whole, s, stride * steps.dt, rows[:, 2], times, started=state,
        last=last, dofs=tuple(kept), account=energies,
    )  # fmt: skip


def coordinates(modes: ModalBasis, scheme: Scheme | str, dt: float | None, t_end: float, *, stride: int = 1) -> Array:
    """Modal coordinates (rows, 3, m): q, q', q'' of every stride-th step; displacements are shapes @ q.

    Rows end at the last that is finite. Raises ValueError as `superpose`.
    """
    s, steps = _checked(modes, scheme, dt, t_end, stride)
    rows = np.empty((steps.n // stride + 1, 3, len(modes)))
    done = _added_up(modes, s, steps, np.eye(len(modes)), rows, account=False).done
    return rows[: done // stride + 1]


def residual_flexibility(modes: ModalBasis) -> Array:
    """Displacements (n, J) of the free degrees of freedom under each load vector, less those of these modes.

    Raises ValueError as `Modes.statics` does.
    """
    elastic = slice(modes.rigid, None)
    own = modes.load_factors[elastic] / modes.omega[elastic, None] ** 2
    return modes.statics - modes.free_shapes[:, elastic] @ own


def _checked(
    modes: ModalBasis,
    scheme: Scheme | str,
    dt: float | None,
    t_end: float | None,
    stride: int,
    state: State | None = None,
) -> tuple[Scheme, ConstantSteps]:
    require_linear(modes.structure, "superposition of modes")
    s = numbers_only(scheme, "march once for each")
    if dt is None:
        raise ValueError("expected dt, a constant step, for modes, got none; give dt, or march the structure with tol")
    if not s.info.damping and modes.damping.any():
        raise needs_no_damping(s.name, "modes without damping, got some that are damped")
    return s, ConstantSteps.of(dt, t_end, stride=stride, start=state)


class _Ended(NamedTuple):
    """How a superposition ended, steps done, the account of energy if one is wanted, and where it stands, if known."""

    status: Status
    done: int
    account: Account | None
    last: Callable[[], State] | None


def _added_up(
    modes: ModalBasis,
    scheme: Scheme,
    steps: ConstantSteps,
    shapes: Array,
    rows: Array,
    account: bool,
    state: State | None = None,
) -> _Ended:
    """Put the sums shapes (m, k) of modal coordinates into rows (n // stride + 1, 3, k)."""
    if not modes.lanes:
        return _together(modes, scheme, steps, shapes, rows, account, state)
    lanes, n, stride = going_on(modes, scheme, steps, state), steps.n, steps.stride
    factors = [lane.factor for lane in lanes]
    summed = [shapes * factor[:, None] for factor in factors]
    energies = ModalEnergies(modes, steps) if account else None
    pace = 1 if account else stride  # steps between the rows of a block, of which every `every`-th is kept
    every, x, ends = stride // pace, room_for(scheme, lanes), np.empty((len(lanes), 3, len(modes)))
    parts = [
        histories(scheme, lane.oscillators, n, lane.load, stride=pace, begin=lane.begin, last=to)
        for lane, to in zip(lanes, x, strict=True)
    ]
    status, done = "completed", 0
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # an overflow is a status
            for at, blocks in _abreast(parts):
                if energies is not None:
                    energies.add(at, blocks, factors)
                kept, first = [q[-at % every :: every] for q in blocks], -(-at // every)
                to = rows[first : first + len(kept[0])]
                _sum(kept, summed, to.reshape(3 * len(to), shapes.shape[1]))
                if not np.isfinite(to[-1:]).all():  # what overflows does not come back
                    good = first + int(np.argmin(np.isfinite(to).all(axis=(1, 2))))
                    last = min(
                        march_linear(scheme, lane.oscillators, n, lane.load, stride=n, begin=lane.begin).n_done.min()
                        for lane in lanes
                    )
                    status, done = "non_finite", min(int(last), good * stride - 1)
                    break
                done = min(n, (first + len(to) - 1) * stride)
                if len(kept[0]):
                    ends[:] = [q[-1] for q in kept]
            else:
                done = n
    except KeyboardInterrupt:
        status = "interrupted"
    with np.errstate(over="ignore", invalid="ignore"):
        energy = () if energies is None else energies.rows(done)[::stride]
    found = accounted(scheme, energy, status, f"dt = {steps.dt:g}")
    if status != "completed":
        return _Ended(status, done, found, None)
    at_end = n - n % stride
    carries = at_end == n and under_way(scheme, lanes[0].begin, n)
    own = {"lanes": x, "rows": ends, "factors": np.array(factors)} if carries else {}
    total = sum((factor * end for factor, end in zip(factors, ends, strict=True)), np.zeros_like(ends[0]))
    return _Ended(status, done, found, partial(_stands, modes, scheme, steps, at_end, total, {}, own))


def _stands(
    modes: ModalBasis,
    scheme: Scheme,
    steps: ConstantSteps,
    done: int,
    coordinates: Array,
    history: Mapping[str, Array],
    more: Mapping[str, Array],
) -> State:
    """Where a superposition stands with modal coordinates q, q', q'' (3, m)."""
    of = whose(scheme, kind_of(modes)) if history or more else ""
    return steps.state(done, *(modes.shapes @ q for q in coordinates), history=history, of=of, more=more)


def _sum(blocks: list[Array], summed: list[Array], to: Array) -> None:
    """Put the sum of blocks (rows, 3, m) times matrices (m, k) into `to` (3 rows, k)."""
    m, k = summed[0].shape
    flat, some = [block.reshape(len(to), m) for block in blocks], max(ALONE // max(m * k, 1), 64)
    for first in range(0, len(to), some):
        part = slice(first, first + some)
        np.matmul(flat[0][part], summed[0], out=to[part])
        for block, matrix in zip(flat[1:], summed[1:], strict=True):
            to[part] += block[part] @ matrix


def _abreast(parts: list[Iterator[tuple[int, Array]]]) -> Iterator[tuple[int, list[Array]]]:
    """Blocks of the same rows of all of them."""
    for blocks in zip(*parts, strict=True):
        yield blocks[0][0], [block for _, block in blocks]


def _together(
    modes: ModalBasis,
    scheme: Scheme,
    steps: ConstantSteps,
    shapes: Array,
    rows: Array,
    account: bool,
    state: State | None,
) -> _Ended:
    """As `_added_up`, for modes that are coupled by damping: marched as a structure with a dense damping matrix."""
    whole = modes.structure
    start = modal_start(modes, state)
    unit = transformation(len(modes), [], None)
    given = {"M": np.eye(len(modes)), "C": modes.damping, "K": np.diag(modes.omega**2)}
    matrices = {name: reduced(checked(name, x), unit) for name, x in given.items()}
    loads = tuple((factor, g) for factor, (_, g) in zip(modes.load_factors.T, whole.loads, strict=True))
    small = Model(
        **matrices, T=unit, loads=loads, u0=start[0], v0=start[1], names=(), solver="dense", a0_given=start[2],
        full_mass=matrices["M"],
    )  # fmt: skip
    inner = None
    if state is not None:
        mine = whose(scheme, structure_kind(small)) if state.of == whose(scheme, kind_of(modes)) else ""
        inner = replace(state, u=start[0], v=start[1], a=start[2], of=mine)
    t_end = steps.time(steps.n)
    r = march_structure(small, scheme, steps.dt, t_end, stride=steps.stride, account=account, start=inner)
    rows[: len(r.u)] = np.stack([r.u, r.v, r.a], axis=1) @ shapes
    done = steps.n if r.t_failed is None else len(r.newton_iterations)
    if r.status != "completed":
        return _Ended(r.status, done, r.account, None)
    ended = r.state
    motion, at_end = np.array([ended.u, ended.v, r.a[-1] if ended.a is None else ended.a]), ended.steps
    last = partial(_stands, modes, scheme, steps, at_end - steps.begin.first, motion, ended.history, ended.more)
    return _Ended(r.status, done, r.account, last)
