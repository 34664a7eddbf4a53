"""Impacts of contacts in a run, from its rows: when each begins and ends, its impulse, velocities, and energy."""

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .arrays import Array

ROUNDING = 64 * np.finfo(np.float64).eps  # of the coordinates that a gap is made of: a smaller gap is not open
AT_REST = 1e-8  # of the velocities that the rate of a gap is made of: what closes no faster does not hit


class _Run(Protocol):
    """A response, as far as it is asked about its steps: see `substep.core.response.Response`."""

    @property
    def t(self) -> Any: ...
    @property
    def step(self) -> float: ...
    @property
    def newton_iterations(self) -> NDArray[np.int64]: ...
    @property
    def statistics(self) -> Any: ...
    @property
    def t_events(self) -> Array | None: ...


class Impact(NamedTuple):
    """An impact on the contact of that name, in the step from `begin` to t, s, or in several up to `end`.

    row: of a contact of several rows, else None. impulse: of the pressure until the contact opens, or the run ends.
    before, after: the rate of the gap at `begin` and at `end`; NaN where it is not known. lost: the mechanical energy
    that is gone meanwhile, of a structure without what its account says of loads and damping; NaN without an account.
    beside: other contacts with an impact meanwhile, whose share is in `lost` too.
    """

    t: float
    name: str
    row: int | None
    begin: float
    end: float
    impulse: float
    before: float
    after: float
    lost: float
    beside: tuple[str, ...] = ()

    def __str__(self) -> str:
        row = "" if self.row is None else f", row {self.row}"
        until = f", to {self.end:.6g} s" if self.end > self.t else ""
        beside = f" together with {', '.join(self.beside)}" if self.beside else ""
        return (
            f"{self.name}{row}: hit within ({self.begin:.6g}, {self.t:.6g}] s{until}, rate of the gap {self.before:.6g}"
            f" to {self.after:.6g}, impulse {self.impulse:.6g}, energy lost {self.lost:.6g}{beside}"
        )


@dataclass(frozen=True)
class Touching:
    """Contacts in the rows of a run; of each its name, and the number of its row where it has several.

    pressures, gaps, rates (n+1, d): of a step the mean, or where they are remembered the last; gaps and their rates at
    its end. u_parts, v_parts (n+1, d): the sizes of what gaps and rates are sums of. lost (n+1,): energy up to then,
    but for a constant. remembered: whether pressures act in the next step too.
    """

    contacts: tuple[tuple[str, int | None], ...]
    pressures: Array
    gaps: Array
    rates: Array
    u_parts: Array
    v_parts: Array
    lost: Array
    remembered: bool


def require_each_step(r: _Run) -> None:
    """Raises ValueError for a response without the row of each step, of which an impulse is the sum."""
    sampled = r.statistics is None and r.step != r.step
    if len(r.newton_iterations) == len(r.t) - 1 and not sampled:
        return
    steps = f"{len(r.newton_iterations)} steps" if len(r.newton_iterations) else "chosen steps"
    cure = "stride=1, without at=" if r.statistics is None else "neither at= nor grid=, or read r.happenings"
    raise ValueError(
        f"expected a row for each step, as the impulse of an impact is a sum over steps, got {len(r.t)} rows of {steps}"
        f"; march with {cure}"
    )


def impacts(r: _Run, of: Touching) -> tuple[Impact, ...]:
    """The impacts in the rows of a run, in the order of time.

    One begins in the step in which a pressure appears where the gap was open, or is closed by the velocity of the
    start, and ends with the last pressure before the gap is open again, by more than the rounding of the coordinates.
    """
    n = len(r.t) if r.t_events is None or np.isnan(r.t_events).all() else len(r.t) - 1  # a row within a step is no end
    found, t = list[Impact](), r.t[:n]
    for k, (name, row) in enumerate(of.contacts):
        p, gap, rate = (x[:n, k] for x in (of.pressures, of.gaps, of.rates))
        closed = gap <= ROUNDING * float(of.u_parts[:n, k].max())
        for first, end in _spells((p > 0.0) | closed):
            pushed = first + np.flatnonzero(p[first:end] > 0.0)
            hits = first > 0 or rate[0] < -AT_REST * of.v_parts[0, k]
            if not len(pushed) or not hits:
                continue
            last = min(
                int(pushed[-1]) + of.remembered, n - 1
            )  # a pressure that is remembered acts in the next step too
            begin = max(int(pushed[0]) - 1, 0)
            (start, stop), (before, after) = (x[[begin, last]].tolist() for x in (t, rate))
            impulse, lost = float((np.diff(t) * p[1:])[begin:last].sum()), float(of.lost[last] - of.lost[begin])
            found.append(Impact(float(t[begin + 1]), name, row, start, stop, impulse, before, after, lost))
    return tuple(one._replace(beside=_beside(one, found)) for one in sorted(found, key=lambda x: (x.t, x.name)))


def _spells(touches: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First rows, and those behind the last, of the spells in which it is true."""
    changes = np.flatnonzero(np.diff(np.concatenate([[False], touches, [False]]).astype(int)))
    return [(int(x), int(y)) for x, y in changes.reshape(-1, 2)]


def _beside(one: Impact, among: list[Impact]) -> tuple[str, ...]:
    """The names of contacts with an impact in a step that this one lasts, too."""
    others = (x for x in among if x.begin < one.end and one.begin < x.end and (x.name, x.row) != (one.name, one.row))
    return tuple(sorted({x.name if x.row is None else f"{x.name}, row {x.row}" for x in others}))
