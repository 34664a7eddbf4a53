"""The plan of a scheme on a structure, with numbers: every vector of a step as a row over the state and the unknowns.

The printed plan (see `substep_derive.motion.plan`) names vectors; here each is a row of coefficients (V,) of the
vectors of the state and of the unknowns of the systems, in the order in which they become known.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from types import ModuleType
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.kernel_modules import committed
from ...core.schemes import Scheme

Row = Mapping[str, float]
AHEAD = 1e-3  # of a step: how far beyond what was last committed an iteration starts


class Force(NamedTuple):
    """w N(u), u a row (V,): from what was remembered after `place` commits of the step, the last `since` before, s."""

    w: float
    u: Array
    place: int
    since: float


class Commit(NamedTuple):
    """The end of a sub-step: what the internal force remembers is committed at rows u, v (V,), `since` after the last
    commit, s."""

    u: Array
    v: Array
    since: float


class Touch(NamedTuple):
    """Where the reaction of a balance acts: rows (4, V) of u and v there, of u where v at t_n leads, and of v at t_n.

    share: of the reaction in the mean of the step. strength: that of one which is 1 in all of the step. later: whether
    the balance is explicit: u is then the next displacement that the reaction moves, v the mean velocity to there, and
    in place of that at t_n is the mean velocity before.
    """

    rows: Array
    share: float
    strength: float
    later: bool = False


@dataclass(frozen=True)
class System:
    """M inertia + C damping + K0 stiffness + sum of w N(u) + .. = sum of w f(t_n + tau h), rows (V,).

    place: of its unknown among the vectors. unknowns: places of those of the systems that are solved together, its own
    alone for most; entries beyond them are 0. balance: whether it is one of the scheme's balances, not a quotient of
    matrices. differences: triples of a discrete gradient between two displacements; loads: pairs (w, tau); commits:
    where sub-steps end with it. begin: the displacement from which it is iterated where something is remembered: that
    of the last commit, and a little beyond where the velocity leads, since a spring that has yielded stands at the
    corner of two branches there, one of which rounding would choose. touch: where a reaction acts that it is solved
    for.
    """

    place: int
    balance: bool
    inertia: Array
    damping: Array
    stiffness: Array
    forces: tuple[Force, ...]
    differences: tuple[tuple[float, Array, Array], ...]
    loads: tuple[tuple[float, float], ...]
    commits: tuple[Commit, ...]
    begin: Array
    unknowns: slice
    touch: Touch | None = None

    @property
    def rows(self) -> tuple[Array, ...]:
        """Of all that it reads."""
        return self.inertia, self.damping, self.stiffness, *self.displacements

    @property
    def displacements(self) -> list[Array]:
        """The rows of the displacements at which it takes the internal force; of a discrete gradient the later one."""
        return [force.u for force in self.forces] + [row for _, _, row in self.differences]

    @cached_property
    def velocity(self) -> Array:
        """The row of the velocity at which it takes the internal force: what C multiplies, over the sum of all w.

        That sum is 1 where the system is a balance as it stands, and -1 where it is the negative of one.
        """
        total = sum(force.w for force in self.forces) + sum(w for w, _, _ in self.differences)
        return self.damping / (round(total, 12) or 1.0)

    def moves_force(self, of_velocity: bool) -> bool:
        """Whether the internal force, of displacements or of velocities too, depends on the unknowns."""
        moved = any(row[self.unknowns].any() for row in self.displacements)
        return moved or (of_velocity and bool(self.displacements) and self.damping[self.unknowns].any())

    @property
    def together(self) -> bool:
        """Whether it is solved together with others."""
        return self.unknowns.stop - self.unknowns.start > 1

    @property
    def implicit(self) -> bool:
        """Whether K multiplies an unknown, where the structure is linear."""
        return bool(self.linear_stiffness[self.unknowns].any())

    @cached_property
    def instant(self) -> float:
        """The mean instant of its loads, in steps after t_n."""
        total = sum(w for w, _ in self.loads)
        return sum(w * tau for w, tau in self.loads) / total if total else 0.0

    @property
    def linear_stiffness(self) -> Array:
        """What K multiplies where the structure is linear; a discrete gradient is then that of the midpoint."""
        total = self.stiffness.copy()
        for force in self.forces:
            total += force.w * force.u
        for w, old, new in self.differences:
            total += 0.5 * w * (old + new)
        return total


@dataclass(frozen=True, eq=False)
class Steps:
    """A plan with numbers. given: how many vectors there are before; out: rows of the new state; report: of u, v, a.

    rows: of every vector by its name in the plan. since: from the last commit in the step to its end, s. accelerations
    (S,): which of the state are such. more: vectors behind the unknowns.
    """

    given: int
    systems: tuple[System, ...]
    out: Array
    report: Array
    rows: Mapping[str, Array]
    since: float
    accelerations: NDArray[np.bool_]
    more: int = 0

    @property
    def vectors(self) -> int:
        """V, the vectors of the state and the unknowns, and those behind them."""
        return self.given + len(self.systems) + self.more

    @property
    def groups(self) -> list[list[System]]:
        """The systems that are solved together, most of them alone, in their order."""
        found = dict[int, list[System]]()
        for s in self.systems:
            found.setdefault(s.unknowns.start, []).append(s)
        return list(found.values())

    @property
    def repeated(self) -> int | None:
        """The place of an unknown that the next step's first one is again: its system is the same of the new state."""
        free = [s for s in self.systems if not (s.forces or s.differences or s.loads)]
        if not free or free[0] is not self.systems[0]:
            return None
        for later in free[1:]:
            unit = np.eye(self.vectors)[later.place]
            first = (
                row[: self.given] @ self.out + row[self.given] * unit
                for row in (free[0].inertia, free[0].damping, free[0].stiffness)
            )
            if all(map(np.array_equal, first, (later.inertia, later.damping, later.stiffness))):
                return later.place
        return None

    def less(self, row: Array) -> "Steps":
        """The same for vectors of which the last unknown is kept less `row` (V - 1,) times the vectors before it."""

        def change(rows: Array) -> Array:
            return np.append(rows[..., :-1] + rows[..., -1:] * row, rows[..., -1:], axis=-1)

        every = {name: change(vector) for name, vector in self.rows.items()}
        *first, last = self.systems
        if last.touch is not None:
            last = replace(last, touch=last.touch._replace(rows=change(last.touch.rows)))
        new = replace(self, out=change(self.out), report=change(self.report), rows=every)
        return replace(new, systems=(*first, last))


def step_of(scheme: Scheme, h: float) -> Steps:
    """What a step of length h computes. The scheme's parameters are numbers."""
    module = _module(scheme)
    return _step(module, h, *_values(scheme, module))


def start_of(scheme: Scheme, h: float) -> Steps:
    """What the state at t = 0 is, from u_0, v_0, a_0; for a scheme whose start is a function."""
    module = _module(scheme)
    return _steps(h, ("u_0", "v_0", "a_0"), *module.start(h, *_values(scheme, module)))


def why_no_memory(scheme: Scheme) -> str:
    """Why the scheme takes no internal force with a memory; empty where it takes one."""
    return _module(scheme).NO_MEMORY


def why_no_contact(scheme: Scheme, kind: Literal["gap", "restitution", "friction"]) -> str:
    """Why the scheme takes no contacts of a kind; empty where it takes them."""
    return getattr(_module(scheme), {"gap": "NO_CONTACT"}.get(kind, f"NO_{kind.upper()}"))


def _values(scheme: Scheme, module: ModuleType) -> list[float]:
    values = {**scheme.parameters, **scheme.info.fixed}
    return [float(values[name]) for name in module.PARAMETERS]


def _module(scheme: Scheme) -> ModuleType:
    """The generated plan; one that is not committed is printed on first use.

    A member of a family has that of the family, but for an explicit member: what its reactions hold is another thing.
    """
    if scheme.info.declaration is None:
        return _in_catalogue(scheme.name, scheme.kernels.NAME)
    from ...derived.modules import own_plan_module  # noqa: PLC0415 (the one door to SymPy)

    return own_plan_module(scheme.info.declaration)


@lru_cache(64)  # many structures take the same steps
def _step(module: ModuleType, h: float, *values: float) -> Steps:
    return _steps(h, module.STATE, *module.step(h, *values))


@cache
def _in_catalogue(name: str, family: str) -> ModuleType:
    from ...derived.modules import plan_module  # noqa: PLC0415 (the one door to SymPy)

    return committed(f"plans.{name}") or committed(f"plans.{family}") or plan_module(family)


def _steps(
    h: float, given: Sequence[str], operations: Sequence[Any], out: Mapping[str, Row], report: Mapping[str, Row]
) -> Steps:
    unknowns = [name for kind, name, _ in operations if kind == "solve"]
    places = {name: place for place, name in enumerate([*given, *unknowns])}
    rows = dict(zip(places, np.eye(len(places)), strict=True))
    committed = [(rows["u_0"], 0.0)]  # displacements of a step at which what is remembered was committed, and when
    begin = rows["u_0"] + AHEAD * h * rows.get("v_0", np.zeros(len(places)))

    def row(terms: Row) -> Array:
        total = np.zeros(len(places))
        for name, coefficient in terms.items():
            if (place := places.get(name)) is None:
                total += coefficient * rows[name]
            else:
                total[place] += coefficient
        return total

    def force(w: float, terms: Row, instant: float) -> Force:
        u = row(terms)
        last = len(committed) - 1
        place = next((k for k, (at, _) in enumerate(committed) if np.array_equal(at, u)), last)
        return Force(float(w), u, place, h * (instant - committed[place][1]) if place == last else 0.0)

    def commits(ends: Sequence[tuple[Row, Row, float]]) -> Iterator[Commit]:
        for u, v, instant in ends:
            last = committed[-1][1]
            if last < instant < 1.0:
                committed.append((row(u), float(instant)))
                yield Commit(row(u), row(v), h * (instant - last))

    def touch(u: Row, v: Row, instant: float, *of_reaction: float) -> Touch:
        at_start = ({"u_0": 1.0, "v_0": h * instant}, {"v_0": 1.0}) if "v_0" in places else ({}, {})
        return Touch(np.array([row(x) for x in (u, v, *at_start)]), *map(float, of_reaction))

    def held(found: Sequence[Row] | None) -> Touch | None:
        return None if found is None else Touch(np.array([row(x) for x in found]), 1.0, 1.0, later=True)

    systems = list[System]()
    for kind, name, body in operations:
        if kind == "combine":
            rows[name] = row(body)
            continue
        forces = tuple(force(*term) for term in body.get("N", ()))
        ended = tuple(commits(body.get("commit", ())))
        systems.append(
            System(
                len(given) + len(systems),
                not name.startswith("w_"),
                *(row(body.get(matrix, {})) for matrix in ("M", "C", "K0")),
                forces,
                tuple((float(w), row(old), row(new)) for w, old, new in body.get("N_discrete", ())),
                tuple((float(w), float(tau)) for w, tau in body.get("f", ())),
                ended,
                begin,
                slice(0),
                touch(*body["contact"]) if "contact" in body else held(body.get("held")),
            )
        )
        if ended:
            begin = ended[-1].u + AHEAD * h * ended[-1].v
    made, reported = (np.reshape([row(r) for r in x.values()], (-1, len(places))) for x in (out, report))
    kinds = np.array([name.startswith("a_") for name in out])
    return Steps(len(given), _grouped(systems), made, reported, rows, h * (1.0 - committed[-1][1]), kinds)


def _grouped(systems: Sequence[System]) -> tuple[System, ...]:
    """With the places of the unknowns of systems that read each other's; these stand one after another.

    Reactions of such hold the displacements at which they act.
    """
    found = list[System]()
    while len(found) < len(systems):
        group = [systems[len(found)]]
        while any(row[group[-1].place + 1 :].any() for s in group for row in s.rows):
            group.append(systems[len(found) + len(group)])
        unknowns = slice(group[0].place, group[-1].place + 1)
        for s in group:
            own = s.touch if len(group) == 1 or s.touch is None else s.touch._replace(later=False)
            found.append(replace(s, unknowns=unknowns, touch=own))
    return tuple(found)
