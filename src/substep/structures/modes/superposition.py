"""Mode superposition: modes are marched as oscillators, or together where damping couples them, and added up.

An oscillator is a lane of the linear march. Each load has lanes of its own, from rest under the load alone, and so has
the start; what belongs to a mode is a factor of its lanes, and goes into the matrix that adds the modes up.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.errors import require_numbers, unknown_name
from ...core.loads import Load, values_at
from ...core.memory import require_memory
from ...core.response import Status
from ...core.schemes import Scheme
from ...core.schemes import scheme as make_scheme
from ...marching.histories import histories
from ...marching.linear import march_linear
from ...marching.oscillators import Oscillators
from ...run.clock import ConstantSteps
from ..march.histories import accounted
from ..march.march_structure import march_structure
from ..march.refusals import require_linear
from ..march.response import Account, StructureResponse
from ..march.velocity import needs_no_damping
from ..model.constraints import transformation
from ..model.given import Dof
from ..model.model import Model
from ..solvers.matrices import checked, reduced
from .modal_energies import ModalEnergies
from .modes import ModalBasis

ALONE = 1 << 18  # multiplications of a product that OpenBLAS does not share out among threads; see `combine`
Lanes = tuple[Load | None, Oscillators, Array]  # a load, the lanes under it, and the factor (m,) of each


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
    **others: Any,
) -> StructureResponse:
    """The response of a structure from t = 0 to t_end in steps of dt by the superposition of its modes.

    With classical damping every mode is a lane of the linear march; else the modes are marched together, as a small
    structure. dofs: names or numbers of the degrees of freedom wanted, all by default. stride: keep every stride-th
    step. static_correction: add to u what the other modes contribute to the static response under the load at each
    time, their residual flexibility; u alone is corrected, and it is that of the load already at t = 0. The part of the
    start and of loads that the modes do not have is left out otherwise. account: whether to add up the energies of the
    modes at each step, without the correction; a warning is given as in a march of the structure.

    Raises ValueError for what `march` does, for a structure with an internal force, for unknown degrees of freedom, for
    damping with a scheme that takes none, and for static_correction of a free body not all of whose rigid modes are
    given; MemoryError for histories that do not fit in memory.
    """
    if others:
        known = ("dofs", "stride", "static_correction", "account")
        raise unknown_name("an argument of march for modes", next(iter(others)), known)
    s, steps = _checked(modes, scheme, dt, t_end, stride)
    whole, h, n = modes.structure, steps.dt, steps.n
    kept = whole.kept(dofs)
    places = [whole.place(dof) for dof in kept]
    part = whole.T[places]
    columns = np.unique(part.indices)  # of all that there are, few are needed
    shapes = np.ascontiguousarray((part[:, columns] @ modes.free_shapes[columns]).T)
    require_memory((n // stride + 1, 3, len(places)), "keep fewer dofs, or a longer stride")
    rows = np.empty((n // stride + 1, 3, len(places)))
    status, done, energies = _added_up(modes, s, h, n, stride, shapes, rows, account)
    rows = rows[: done // stride + 1]
    u = rows[:, 0]
    if static_correction and whole.loads:
        loads = whole.load_values(np.arange(len(rows)) * (stride * h))
        u += loads @ (whole.T[places] @ residual_flexibility(modes)).T
    failed = None if status == "completed" else (done + 1) * h
    iterations = np.zeros((done, s.balances), np.int64)
    return StructureResponse(
        u, rows[:, 1], iterations, status, failed, whole, s, stride * h, rows[:, 2], dofs=tuple(kept), account=energies
    )  # fmt: skip


def coordinates(modes: ModalBasis, scheme: Scheme | str, dt: float | None, t_end: float, *, stride: int = 1) -> Array:
    """Modal coordinates (rows, 3, m): q, q', q'' of every stride-th step; displacements are shapes @ q.

    Rows end at the last that is finite. Raises ValueError as `superpose`.
    """
    s, steps = _checked(modes, scheme, dt, t_end, stride)
    rows = np.empty((steps.n // stride + 1, 3, len(modes)))
    _, done, _ = _added_up(modes, s, steps.dt, steps.n, stride, np.eye(len(modes)), rows, account=False)
    return rows[: done // stride + 1]


def residual_flexibility(modes: ModalBasis) -> Array:
    """Displacements (n, J) of the free degrees of freedom under each load vector, less those of these modes.

    Raises ValueError as `Modes.statics` does.
    """
    elastic = slice(modes.rigid, None)
    own = modes.load_factors[elastic] / modes.omega[elastic, None] ** 2
    return modes.statics - modes.free_shapes[:, elastic] @ own


def modal_lanes(modes: ModalBasis, dt: float) -> list[Lanes]:
    """What is marched where every mode is an oscillator: lanes for each load, and for a start that is not rest."""
    whole, omega, xi = modes.structure, modes.omega, modes.xi
    one, steps = np.ones(len(modes)), np.full(len(modes), dt)
    own, found = modes.start.copy(), []
    for (_, g), factor in zip(whole.loads, modes.load_factors.T, strict=True):
        at_rest = np.zeros((3, len(modes)))
        at_rest[2] = values_at(g, np.zeros(1))[0]
        own[2] -= factor * at_rest[2]
        found.append((g, Oscillators(omega, xi, one, steps, at_rest), factor))
    if whole.a0_given is None:
        own[2] = -2.0 * xi * omega * own[1] - omega**2 * own[0]
    return [*found, (None, Oscillators(omega, xi, one, steps, own), one)] if own.any() or not found else found


def _checked(
    modes: ModalBasis, scheme: Scheme | str, dt: float | None, t_end: float | None, stride: int
) -> tuple[Scheme, ConstantSteps]:
    require_linear(modes.structure, "superposition of modes")
    s = make_scheme(scheme)
    require_numbers(s.name, s.parameters, "march once for each")
    if dt is None:
        raise ValueError("expected dt, a constant step, for modes, got none; give dt, or march the structure with tol")
    if not s.info.damping and modes.damping.any():
        raise needs_no_damping(s.name, "modes without damping, got some that are damped")
    return s, ConstantSteps.of(dt, t_end, stride=stride)


def _added_up(
    modes: ModalBasis, scheme: Scheme, h: float, n: int, stride: int, shapes: Array, rows: Array, account: bool
) -> tuple[Status, int, Account | None]:
    """Put the sums shapes (m, k) of modal coordinates into rows (n // stride + 1, 3, k).

    Returns how it ended, the steps done, and the account of energy if one is wanted.
    """
    if not modes.lanes:
        return _together(modes, scheme, h, n, stride, shapes, rows, account)
    lanes, status, done = modal_lanes(modes, h), "completed", 0
    factors = [factor for _, _, factor in lanes]
    summed = [shapes * factor[:, None] for factor in factors]
    energies = ModalEnergies(modes, h, n) if account else None
    pace = 1 if account else stride  # steps between the rows of a block, of which every `every`-th is kept
    every = stride // pace
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # an overflow is a status
            for at, blocks in _abreast([histories(scheme, o, n, load, stride=pace) for load, o, _ in lanes]):
                if energies is not None:
                    energies.add(at, blocks, factors)
                kept, first = [q[-at % every :: every] for q in blocks], -(-at // every)
                to = rows[first : first + len(kept[0])]
                _sum(kept, summed, to.reshape(3 * len(to), shapes.shape[1]))
                if not np.isfinite(to[-1:]).all():  # what overflows does not come back
                    good = first + int(np.argmin(np.isfinite(to).all(axis=(1, 2))))
                    last = min(march_linear(scheme, o, n, load, stride=n).n_done.min() for load, o, _ in lanes)
                    status, done = "non_finite", min(int(last), good * stride - 1)
                    break
                done = min(n, (first + len(to) - 1) * stride)
            else:
                done = n
    except KeyboardInterrupt:
        status = "interrupted"
    with np.errstate(over="ignore", invalid="ignore"):
        energy = () if energies is None else energies.rows(done)[::stride]
    return status, done, accounted(scheme, energy, status, f"dt = {h:g}")


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
    modes: ModalBasis, scheme: Scheme, h: float, n: int, stride: int, shapes: Array, rows: Array, account: bool
) -> tuple[Status, int, Account | None]:
    """As `_added_up`, for modes that are coupled by damping: marched as a structure with a dense damping matrix."""
    whole = modes.structure
    start = modes.start
    unit = transformation(len(modes), [], None)
    given = {"M": np.eye(len(modes)), "C": modes.damping, "K": np.diag(modes.omega**2)}
    matrices = {name: reduced(checked(name, x), unit) for name, x in given.items()}
    loads = tuple((factor, g) for factor, (_, g) in zip(modes.load_factors.T, whole.loads, strict=True))
    small = Model(
        **matrices, T=unit, loads=loads, u0=start[0], v0=start[1], names=(), solver="dense", a0_given=start[2],
        full_mass=matrices["M"],
    )  # fmt: skip
    r = march_structure(small, scheme, h, n * h, stride=stride, account=account)
    rows[: len(r.u)] = np.stack([r.u, r.v, r.a], axis=1) @ shapes
    done = n if r.t_failed is None else round(r.t_failed / h) - 1
    return r.status, done, r.account
