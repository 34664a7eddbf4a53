"""The load at the instants of a scheme's steps, as the kernels of the linear march take it."""

from dataclasses import dataclass, replace

import numpy as np

from ..core.arrays import Array, alike, read_only
from ..core.loads import Load, LoadLanes, Record, is_known, values_at
from ..run.clock import AT_ZERO, Begin


@dataclass(frozen=True, eq=False)
class StepLoads:
    """The load at K instants of each step, for lanes that share it or for each lane.

    load: None for no load. stencil: the scheme's own instants in steps after t_n, (k,) or (P, k), k <= K; at the others
    the load is 0. dt (P,): steps in s. excess (P,): what is added to the load at the first instant of the first step.
    begin: where the steps begin. values: the load at the scheme's instants of all steps, (n, 1 or P) each, if it was
    evaluated beforehand.
    """

    load: Load | None
    stencil: Array
    dt: Array
    K: int
    excess: Array
    begin: Begin = AT_ZERO
    values: tuple[Array, ...] | None = None

    @property
    def at_hand(self) -> bool:
        """Whether the loads of all steps are in memory."""
        return self.values is not None

    @property
    def shared(self) -> bool:
        """Whether all lanes have the same loads."""
        return self._same_instants and alike(self.excess)

    @property
    def _same_instants(self) -> bool:
        """Whether all lanes have the same load at the same instants, so that they differ by the excess at most."""
        return self.stencil.ndim == 1 and not isinstance(self.load, LoadLanes) and alike(self.dt)

    def of_all(self, begin: int, end: int) -> tuple[Array, ...]:
        """The loads (end - begin,) at each of the K instants of steps begin to end - 1, where lanes share them."""
        if self.values is None:
            values = [read_only(x) for x in _at_stencil(self.load, self.stencil, self.dt[:1], self.begin, begin, end)]
        else:
            values = [read_only(x[begin:end, 0]) for x in self.values]
        if self.excess[0] and begin == 0 < end:
            first = values[0].copy()
            first[0] += self.excess[0]
            values[0] = read_only(first)
        if len(values) == self.K:
            return tuple(values)
        return (*values, *[read_only(np.zeros(end - begin))] * (self.K - len(values)))

    def beforehand(self, n: int) -> "StepLoads":
        """The same, where `of_each` only reads what one thread evaluates here: a load of the user's own, or of all."""
        if is_known(self.load) and not self._same_instants:
            return self
        dt = self.dt[:1] if self._same_instants else self.dt
        return replace(self, values=tuple(_at_stencil(self.load, self.stencil.T, dt, self.begin, 0, n)))

    def of_each(self, begin: int, end: int, lanes: slice, room: Array) -> None:
        """Put the loads of p lanes in steps begin to end - 1 into room (K, end - begin or more, p), zeros before."""
        if self.values is not None:
            values = [x[begin:end, lanes if x.shape[1] > 1 else slice(None)] for x in self.values]
        else:
            load = self.load.lanes(lanes) if isinstance(self.load, LoadLanes) else self.load
            stencil = self.stencil if self.stencil.ndim == 1 else self.stencil[lanes].T
            dt = self.dt[:1] if alike(self.dt) else self.dt[lanes]
            values = _at_stencil(load, stencil, dt, self.begin, begin, end)
        for k, value in enumerate(values):
            room[k, : end - begin] = value
        if begin == 0:
            room[0, 0] += self.excess[lanes]


def _at_stencil(load: Load | None, stencil: Array, dt: Array, from_: Begin, begin: int, end: int) -> list[Array]:
    """The load (end - begin, 1 or P) at each instant of the stencil (k,) or (k, P); dt (1,) or (P,).

    The end of a step is the start of the next one, so that the load is evaluated there once.
    """
    if load is None:
        return [np.zeros((end - begin, 1))] * len(stencil)
    first, origin, _ = from_
    begin, end = first + begin, first + end

    def at(tau: Array | float, last: int) -> Array:
        """The load tau steps after the start of the steps begin to last - 1."""
        if isinstance(load, Record) and dt.size == 1 and np.ndim(tau) == 0 and not origin:
            return load.at_steps(range(begin, last), float(tau), float(dt[0]))[:, None]
        return values_at(load, origin + (np.arange(begin, last, dtype=np.float64)[:, None] + tau) * dt)

    if stencil.ndim > 1 or not {0.0, 1.0} <= set(stencil.tolist()):
        return [at(tau, end) for tau in stencil]
    at_ends = at(0.0, end + 1)
    ends = {0.0: at_ends[:-1], 1.0: at_ends[1:]}
    return [ends[tau] if tau in ends else at(tau, end) for tau in stencil.tolist()]
