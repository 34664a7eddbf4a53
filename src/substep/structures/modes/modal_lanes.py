"""What is marched where every mode is an oscillator: lanes for each load, and for a start that is not rest."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core import coefficients
from ...core.arrays import Array, digest
from ...core.loads import Load, values_at
from ...core.schemes import Scheme
from ...core.state import State, whose
from ...marching.oscillators import Oscillators
from ...run.clock import AT_ZERO, Begin, ConstantSteps
from ..model.state_vectors import vectors
from .modes import ModalBasis


@dataclass(frozen=True, eq=False)
class ModalLane:
    """The modes as oscillators under one load, or under none, and the factor (m,) of each in their sum.

    begin: where their steps begin; oscillators.start is the first row in any case.
    """

    load: Load | None
    oscillators: Oscillators
    factor: Array
    begin: Begin = AT_ZERO


def modal_start(modes: ModalBasis, state: State | None) -> Array:
    """q, q', q'' (3, m) where a march begins: of the structure, or of a state."""
    return modes.start if state is None else vectors(modes.structure, state) @ modes.inertia


def modal_lanes(modes: ModalBasis, steps: ConstantSteps, state: State | None = None) -> list[ModalLane]:
    """Lanes for each load from rest, and for a start that is not rest: of the structure, or of a state."""
    whole, omega, xi = modes.structure, modes.omega, modes.xi
    one, dt = np.ones(len(modes)), np.full(len(modes), steps.dt)
    own, found = modal_start(modes, state).copy(), []
    for (_, g), factor in zip(whole.loads, modes.load_factors.T, strict=True):
        at_rest = np.zeros((3, len(modes)))
        at_rest[2] = values_at(g, np.array([steps.time(0)]))[0]
        own[2] -= factor * at_rest[2]
        found.append(ModalLane(g, Oscillators(omega, xi, one, dt, at_rest), factor, steps.begin))
    if whole.a0_given is None if state is None else state.a is None:
        own[2] = -2.0 * xi * omega * own[1] - omega**2 * own[0]
    if own.any() or not found:
        found.append(ModalLane(None, Oscillators(omega, xi, one, dt, own), one, steps.begin))
    return found


def going_on(modes: ModalBasis, scheme: Scheme, steps: ConstantSteps, state: State | None) -> list[ModalLane]:
    """The same where the scheme goes on with what it carries, if the state is one of these modes, scheme and dt.

    Lanes of loads that act as before go on as they were; else all lanes so far become one without a load.
    """
    if state is None or not state.goes_on(whose(scheme, kind_of(modes)), steps.dt):
        return modal_lanes(modes, steps, state)
    rows, ends, factors = (state.more[name] for name in ("lanes", "rows", "factors"))
    none, J = np.zeros((3, len(modes))), len(modes.structure.loads)
    like = modal_lanes(modes, steps, replace(state, u=0.0 * state.u, v=0.0 * state.v, a=None))[:J]
    given = [lane.factor for lane in like]
    same = len(factors) in (J, J + 1) and np.array_equal(factors[:J], np.reshape(given, (J, len(modes))))
    if not same:
        rows, ends = (np.concatenate([np.zeros((J, *x.shape[1:])), (factors[:, None] * x).sum(axis=0)[None]])
                      for x in (rows, ends))  # fmt: skip
    o = like[0].oscillators if like else modal_lanes(modes, steps)[0].oscillators
    own = ModalLane(None, o._replace(start=none), np.ones(len(modes)), steps.begin)
    lanes = [*like, own][: len(rows)]
    return [
        replace(lane, oscillators=lane.oscillators._replace(start=end), begin=steps.begin._replace(rows=x))
        for lane, x, end in zip(lanes, rows, ends, strict=True)
    ]


def kind_of(modes: ModalBasis) -> str:
    """Of run, as states name it: what the scheme carries is of coordinates of these shapes, one by one or coupled."""
    return f"{len(modes)} {'modes' if modes.lanes else 'coupled modes'} {digest(modes.shapes)[:12]}"


def room_for(scheme: Scheme, lanes: Sequence[ModalLane]) -> Array:
    """Memory (lanes, k, m) for what is marched of each lane."""
    m = len(lanes[0].factor)
    return np.empty((len(lanes), len(coefficients.marched(scheme)), m))
