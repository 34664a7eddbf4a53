"""A structure with contacts, friction or nonlinear constraints in chosen steps, which end where what acts changes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.outcome import Status
from ...core.schemes import Scheme
from ...core.state import State
from ...marching.events import Mode, Reacting, Stand, Steps
from ...marching.to_events import ToEvents, needs_restitution, require_changing
from ...run.clock import Control
from ..model.contacts import Contacts
from ..model.held import Held
from ..model.memory import Memory, RememberingForce
from ..model.model import Model
from ..solvers.combine import combined
from ..solvers.complementarity import NotFound
from .going_on import named_reactions
from .scheme_plan import step_of
from .sided_loads import Forces
from .step_lengths import Lengths, Scales, reach, rms
from .steps import Run

PARTS = 1000  # of the span, for the bar


class Kept(NamedTuple):
    """What is remembered at a stand: by an internal force, and (2, d) the reactions of the step before, and gaps."""

    memory: Memory | None
    touched: Array


class Passed(NamedTuple):
    """Steps of a march that count: a stand after each, the iterations (m, balances), and see `Reacting.middle`."""

    stands: tuple[Stand, ...]
    iterations: NDArray[np.int64]
    middle: float


@dataclass(kw_only=True)
class OfStructure(Reacting):
    """See `Reacting`; lengths: steps of the last few lengths, ready to be solved."""

    run: Run
    forces: Forces
    lengths: Lengths

    @classmethod
    def of(cls, run: Run, asked: Control, at: Stand) -> "OfStructure":
        """Of a run that begins at a stand.

        The motion is measured by the widest gap at the start, or by the static displacement, if that is less.
        """
        s, contacts, names = run.structure, run.structure.contacts, list[str]()
        sizes = [reach(s, asked.t_end, at.u, at.v)]
        if isinstance(contacts, Contacts):
            names = [contacts.name_of(k) for k in range(contacts.size)]
            gaps = contacts.gaps(at.u)[~contacts.sliding] / np.linalg.norm(contacts.rows[~contacts.sliding], axis=1)
            sizes.append(float(gaps.max(initial=0.0)))
        length, d = min((x for x in sizes if x > 0.0), default=1.0), len(names)
        if isinstance(contacts, Contacts):
            d = int((~contacts.sliding).sum())
        assert at.a is not None
        speed = max(float(np.abs(at.v).max()), math.sqrt(length * float(np.abs(at.a).max())))
        speed = speed or length / (asked.t_end - at.t)
        return cls(
            run.scheme, max(asked.rtol, asked.atol_u / length or asked.share_v), speed, names[:d], names[d:],
            isinstance(contacts, Held), length, run=run, forces=Forces(s, at.t, asked.t_end), lengths=Lengths(run),
        )  # fmt: skip

    def steps(self, at: Stand, h: float, n: int, mode: Mode = ()) -> Steps | str:
        """See `Reacting.steps`."""
        march, stands, iterations, origin = self.lengths.of(h), list[Stand](), list[list[int]](), at.t
        X = march.run.room(march.steps)
        for k in range(n):
            t = origin + (k + 1) * h
            march.begin(X, at.rows, at.memory.memory, at.memory.touched[0])
            loads, times = self.forces.over(march, at.t, self.middle)
            try:
                march.complete(X, loads, times)
            except NotFound:
                return "newton_failed"
            if not math.isfinite(float(X[march.steps.systems[-1].place].sum())):
                return "non_finite"
            march.commit(X, t)
            march.look(X, times)
            u, v, *a = combined(march.steps.report, X)
            kept = Kept(march.memory, march.touched(X))
            at = self.held(Stand(t, u, v, a[0] if a else None, combined(march.steps.out, X), kept), mode)
            stands.append(at)
            iterations.append(march.counts)
        return Steps(tuple(stands), np.array(iterations, np.int64))

    def pressing(self, stands: Sequence[Stand]) -> Array:
        """See `Reacting.pressing`."""
        return np.array([x.memory.touched[0] for x in stands])

    def drift(self, stands: Sequence[Stand]) -> tuple[Array, Array, Array]:
        """See `Reacting.drift`."""
        contacts = self.run.structure.contacts
        assert isinstance(contacts, Contacts)
        sign = np.where(contacts.sliding, 1.0, -1.0)
        x, rate = (np.array(rows) for rows in zip(*(
            (sign * contacts.gaps(at.u), sign * (contacts.rows @ at.v[contacts.columns])) for at in stands
        ), strict=True))  # fmt: skip
        return x, rate, np.broadcast_to(np.linalg.norm(contacts.rows, axis=1), x.shape)

    def acceleration(self, at: Stand) -> Array:
        """See `Reacting.acceleration`."""
        s = self.run.structure
        a = self.forces.acceleration(at.t, self.middle, at.u, at.v, at.memory.memory)
        if isinstance(s.contacts, Held):
            a = a + s.pushed_by(s.contacts.multipliers(at.u, at.v, a, s.solve_mass), at.u)
        return a

    def pushed(self, at: Stand, reactions: Array) -> Array:
        """See `Reacting.pushed`."""
        contacts, force = self.run.structure.contacts, np.zeros(len(at.u))
        assert isinstance(contacts, Contacts)
        force[contacts.columns] = contacts.rows.T @ reactions
        return self.run.structure.solve_mass(force)

    def changes_to(self, at: Stand, closed: NDArray[np.intp], wanted: Array) -> Array:
        """See `Reacting.changes_to`."""
        contacts, found = self.run.structure.contacts, np.zeros((len(at.u), 2))
        assert isinstance(contacts, Contacts)
        found[contacts.columns] = np.linalg.pinv(-contacts.rows[closed]) @ wanted
        return found

    def onto_constraints(self, at: Stand) -> Array:
        """See `Reacting.onto_constraints`."""
        contacts = self.run.structure.contacts
        assert isinstance(contacts, Held)
        G = contacts.at(at.u)[1]
        moved = self.run.structure.solve_mass(G.T)
        return np.asarray(-moved @ np.linalg.solve(G @ moved, G @ at.v), dtype=np.float64)


@dataclass
class _Run(ToEvents[OfStructure]):
    """sizes: by which errors are divided."""

    sizes: Scales = None  # type: ignore[assignment]

    def scales(self, end: Stand) -> Array:
        """See `ToEvents.scales`."""
        pairs = (self.at.u, end.u), (self.at.v, end.v)
        return np.array([np.broadcast_to(self.sizes.of(k, *pair), end.u.shape) for k, pair in enumerate(pairs)])


class EventSteps:
    """The clock of such steps: each that it gives is complete, and counts."""

    unit, total = "parts", PARTS

    def __init__(self, run: Run, asked: Control, shares: tuple[float, float]) -> None:
        """shares: of the largest u and v so far in their scales.

        Raises ValueError as `require_changing`, for contacts without a restitution, and for degrees of freedom without
        mass.
        """
        require_events(run.structure, run.scheme, asked)
        u, v, a = run.given
        rows = run.given[[kind for kind, _ in run.scheme.history]]
        at = Stand(run.time(0), u, v, a, rows, Kept(run.memory, run.touched))
        reacting = OfStructure.of(run, asked, at)
        scales = Scales(asked.rtol, (asked.atol_u, asked.atol_v), shares, [reacting.length, rms(v) or reacting.speed])
        breaks = frozenset(reacting.forces.targets[:-1].tolist())
        self.run, self.asked = run, asked
        self.first = at if len(step_of(run.scheme, asked.t_end).report) == 3 else at._replace(a=None)
        self.march = _Run(reacting, asked, at, breaks, sizes=scales)
        self.done = 0

    @property
    def status(self) -> Status:
        """How the march ended."""
        return self.march.status

    def trials(self) -> Iterator[Passed]:
        """The steps that count. Raises ValueError for a singular effective matrix."""
        begin, span = self.asked.t_begin, self.asked.t_end - self.asked.t_begin
        for made in self.march.march():
            for x in made.stands:
                self.march.sizes.saw(np.array([x.u, x.v]))
            self.done = max(self.done, int(PARTS * (self.march.at.t - begin) / span))
            yield Passed(*made, self.march.reacting.middle)

    def accepted(self, step: Passed) -> bool:
        """Each is."""
        del step
        return True

    def failed(self, step: object) -> None:
        """None does."""

    @property
    def stands(self) -> State:
        """What a later march goes on from."""
        s, at = self.run.structure, self.march.at
        u, v, *a = (s.T @ x for x in (at.u, at.v, at.a) if x is not None)
        found = State(at.t, u, v, a[0] if a else None, dt_next=self.march.wanted)
        memory = named_reactions(s, at.memory.touched[0])
        if at.memory.memory is not None and isinstance(s.internal, RememberingForce):
            memory |= s.internal.named(at.memory.memory)
        return replace(found, memory=memory)


def require_events(s: Model, scheme: Scheme, asked: Control) -> None:
    """Raises ValueError where steps of a structure that end at events cannot be made."""
    if len(s.massless):
        raise ValueError(
            f"expected mass at each degree of freedom where steps are chosen, got none at "
            f"{s.named(int(s.massless[0]))}; condense such degrees of freedom, or give dt"
        )
    steps = step_of(scheme, asked.t_end)
    carries = any(lag for _, lag in scheme.history) or scheme.info.start != "given"
    carries |= any(x.stiffness.any() for x in steps.systems)
    later = any(x.touch is not None and x.touch.later for x in steps.systems)
    what = f"a structure with {'' if s.contacts is None else s.contacts.kind}"
    require_changing(what, scheme, asked, carries=carries, later=later)
    if isinstance(s.contacts, Contacts) and (held := np.flatnonzero(~s.contacts.bouncing)).size:
        raise needs_restitution("the structure", s.contacts.name_of(int(held[0])), "give restitution=0")
