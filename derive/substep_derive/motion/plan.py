"""Scheme -> Plan: a step of a scheme on matrices M, C, K, as combinations of vectors and linear systems in between.

Every vector that a step computes is either a combination of vectors known before, or the solution of one system
M x_a + C x_v + K0 x_k + sum of w N(x_u) = load, where x_a, x_v, x_k and x_u combine the unknown and known vectors.
A balance is such a system, solved for its new acceleration; balances that are solved together are several, one after
another, which read each other's. So is a coefficient that is a quotient of matrices, such
as alpha_1 = (M + gamma h C + beta h^2 K0)^-1 M of Kolay & Ricles (2014), whose denominator is never inverted.

Where the internal force has a memory, it is committed after a system that ends a sub-step, and at the end of the step,
by the rule of `step.times`.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import cast

from sympy import Dummy, Expr, Integer, Symbol, cancel, factor, fraction, sympify

from ..constrained.explicit import explicit, held_next, mean_velocity, require_held
from ..constrained.prescribed import prescribed
from ..declare.errors import DeclarationError
from ..declare.scheme import Balance, Scheme
from ..declare.symbols import K0, C, K_t, M, N, N_discrete, f, h, knot, knot_of
from ..step.step import Stage, Step
from ..step.times import SubStepEnd, impulses, instant_of, instants_of, moved, passed, sub_step_ends

MATRICES = (M, C, K0)
Row = Mapping[Symbol, Expr]  # vector -> its coefficient, a number once h and the parameters are given
Parts = tuple[Expr, Expr, Expr, Expr]  # factors of 1, M, C, K0 in an expression linear in the matrices


@dataclass(frozen=True)
class Combination:
    """A vector as a combination of others, and of the unknown of the next system."""

    vector: Symbol
    row: Row


@dataclass(frozen=True)
class System:
    """M inertia + C damping + K0 stiffness + sum of w N(row) + sum of w N(row, row) = sum of w f(tau), linear or not.

    vector: the unknown it is solved for, which the rows contain, directly or through a combination before it.
    forces: triples (w, row, tau) of a force at a displacement, which a motion of constant velocity passes tau steps
    after t_n; differences: triples (w, row, row) of a discrete gradient; loads: pairs (w, tau). commits: triples
    (u, v, tau) of rows where a sub-step ends with this system and what the internal force remembers is committed.
    joined: whether it is solved together with the system after it, whose unknown it reads too.
    contact: where a reaction that the balance is solved for acts, the newest displacement that moves with its force and
    the velocity there, and the instant; and of that reaction the share in the mean of the step, and the strength: see
    `step.times.impulses`. None for what is no balance, and of a scheme whose balances do not move both.
    held: of an explicit balance, in place of these, the displacement that its reaction holds and the mean velocity to
    there, where the mean velocity before would have led, and that one: see `constrained.explicit`; of balances that are
    all solved together the displacement at which each takes the force.
    """

    vector: Symbol
    inertia: Row = field(default_factory=dict)
    damping: Row = field(default_factory=dict)
    stiffness: Row = field(default_factory=dict)
    forces: tuple[tuple[Expr, Row, Expr], ...] = ()
    differences: tuple[tuple[Expr, Row, Row], ...] = ()
    loads: tuple[tuple[Expr, Expr], ...] = ()
    commits: tuple[tuple[Row, Row, Expr], ...] = ()
    joined: bool = False
    contact: tuple[Row, Row, Expr, Expr, Expr] | None = None
    held: tuple[Row, ...] | None = None

    @property
    def rows(self) -> dict[str, Row]:
        """The rows that matrices multiply, by the names of these."""
        return {"M": self.inertia, "C": self.damping, "K0": self.stiffness}

    @property
    def vectors(self) -> set[Symbol]:
        """The vectors that it reads, the unknown included."""
        rows = [*self.rows.values(), *(row for _, row, _ in self.forces)]
        rows += [row for *pair, _ in self.commits for row in pair]
        rows += [row for _, *pair in self.differences for row in pair]
        rows += [*(self.contact or ())[:2], *(self.held or ())]
        return {s for row in rows for s in row} | {self.vector}


Operation = Combination | System


@dataclass(frozen=True)
class Plan:
    """What a step computes, in order; then each vector of `out` as a combination of what there is.

    given: the vectors that are there before. out: the new state under the names of the state, in a step; the state at
    t = 0, in a start. report: u, v and, where the scheme has its own, a at t_n + h under these names; empty in a start.
    no_memory: why the scheme takes no internal force with a memory, empty where it takes one.
    """

    scheme: Scheme
    given: tuple[Symbol, ...]
    operations: tuple[Operation, ...]
    out: Mapping[Symbol, Row]
    report: Mapping[str, Row]
    no_memory: str = ""

    @classmethod
    def of(cls, scheme: Scheme) -> "Plan":
        """The plan of a step. Raises DeclarationError for coefficients that a plan has no systems for."""
        return _plan(scheme)

    @classmethod
    def of_start(cls, scheme: Scheme) -> "Plan | None":
        """The plan of the state at t = 0 from u_0, v_0, a_0; None where it is these or another scheme marches."""
        step = Step.of(scheme.in_doubles)
        if step.start is None or not scheme.start:
            return None
        w = _Writer(step.scheme, passed(step))
        # K0 is the tangent at u_0, and so is the only K_t that a start can read
        out = {s: w.row(e.replace(K_t, lambda where: K0)) for s, e in zip(step.state, step.start, strict=True)}
        return w.plan(knot(0), out, {})


@cache
def _plan(scheme: Scheme) -> Plan:
    near = scheme.in_doubles
    step = Step.of(near)
    w = _Writer(near, passed(step))
    ends, no_memory = list[SubStepEnd](), ""
    try:
        ends += sub_step_ends(Step.of(scheme))
    except DeclarationError as error:
        no_memory = str(error)
    for s, e in step.prior.items():
        w.combine(s, e)
    for stage in step.stages:
        w.stage(stage)
        w.commit(stage, ends)
        w.press(step, stage)
    out = {s: w.row(after) for s, after in zip(step.state, step.after, strict=True)}
    report = {kind: w.row(e) for kind, e in zip("uva", step.outputs, strict=False)}
    return replace(w.plan(step.state, out, report), no_memory=no_memory)


class _Writer:
    """Collects the operations of a plan. instants: of each displacement, in steps after t_n: see `step.times`."""

    def __init__(self, scheme: Scheme, instants: Mapping[Symbol, Expr]) -> None:
        self.scheme, self.instants = scheme, instants
        self.operations: list[Operation] = []
        self.quotients: dict[object, Symbol] = {}

    def plan(self, given: tuple[Symbol, ...], out: Mapping[Symbol, Row], report: Mapping[str, Row]) -> Plan:
        """The operations that something reads, in their order."""
        reads = {o.vector: set(o.row) if isinstance(o, Combination) else o.vectors for o in self.operations}
        wanted: set[Symbol] = set()
        new = {s for row in (*out.values(), *report.values()) for s in row}
        while new:
            wanted |= new
            new = {s for vector in new for s in reads.get(vector, ())} - wanted
        kept = (o for o in self.operations if o.vector in wanted)
        return Plan(self.scheme, given, tuple(kept), out, report)

    def combine(self, vector: Symbol, e: Expr) -> None:
        """The vector from now on stands for the expression."""
        self.operations.append(Combination(vector, self.row(e)))

    def row(self, e: Expr) -> Row:
        """An expression linear in vectors; quotients of matrices become systems, one a denominator, before it."""
        found: dict[Symbol, Expr] = {}
        groups: dict[Parts, list[tuple[Expr, Parts]]] = {}
        for atom, coefficient in self._terms(e):
            if not coefficient.free_symbols & set(MATRICES):
                found[self._vector(atom)] = coefficient
                continue
            numerator, den = self._quotient(coefficient)
            if den is None:
                raise self._refused(f"a coefficient of {atom} without units of a matrix", coefficient)
            whole = [k for k, part in enumerate(den) if part != 0]
            if len(whole) == 1 and numerator[whole[0]] != 0:  # (q M + r)/M = q + r/M
                found[self._vector(atom)] = numerator[whole[0]]
                numerator = cast(Parts, tuple(Integer(0) if k == whole[0] else p for k, p in enumerate(numerator)))
            if any(part != 0 for part in numerator):
                groups.setdefault(den, []).append((atom, numerator))
        for den, members in groups.items():
            scale = next(part for part in members[0][1] if part != 0)
            scaled = tuple((atom, tuple(factor(cancel(p / scale)) for p in parts)) for atom, parts in members)
            if (den, scaled) not in self.quotients:
                self.quotients[den, scaled] = self._solved(den, scaled)
            found[self.quotients[den, scaled]] = scale
        return found

    def stage(self, stage: Stage) -> None:
        """What moves with the stage's z, then its balances, each as a system for its z."""
        for s, e in stage.in_z.items():
            for z in stage.z:
                if e.diff(z).free_symbols & set(MATRICES):
                    raise self._refused(f"{s} to depend on {z} by a number", e.diff(z))
            self.combine(s, e)
        for balance, z in zip(stage.balances, stage.z, strict=True):
            self._balance(stage, balance, z)
            if z != stage.z[-1]:
                self.operations[-1] = replace(cast(System, self.operations[-1]), joined=True)

    def _balance(self, stage: Stage, balance: Balance, z: Symbol) -> None:
        """The balance as a system for its z; one whose inertia has matrices in it as two, see the module."""
        if not stage.alone and (found := balance.symbols & set(MATRICES)):
            raise self._refused("no matrix in balances that are solved together", ", ".join(sorted(map(str, found))))
        forces, differences = self._forces(balance.force)
        loads = tuple((w, cast(Expr, atom.args[0])) for atom, w in self._terms(balance.load))
        system = System(z, {}, self.row(balance.damping), {}, forces, differences, loads)
        terms = [(self._vector(s), coefficient) for s, coefficient in self._terms(balance.inertia)]
        if not any(coefficient.free_symbols & set(MATRICES) for _, coefficient in terms):
            self.operations.append(replace(system, inertia=dict(terms)))
            return
        if stage.c_u() != 0 or balance.damping.subs(stage.in_z).has(z):
            raise self._refused("an explicit balance where its inertia contains matrices", balance.inertia)
        quotients = [(s, self._quotient(coefficient)) for s, coefficient in terms]
        denominators = {den for _, (_, den) in quotients if den is not None}
        if len(denominators) != 1:
            raise self._refused("one denominator in an inertia that contains matrices", balance.inertia)
        (den,) = denominators
        right = Symbol(f"w_{len(self.operations)}")  # M right = load - C damping - forces
        self.operations.append(replace(system, vector=right, inertia={right: Integer(1)}))
        rows: tuple[dict[Symbol, Expr], ...] = ({}, {}, {})
        for s, (numerator, own) in quotients:
            parts = numerator if own is not None else tuple(cancel(numerator[0] * part) for part in den)
            if parts[0] != 0:
                raise self._refused("numerators made of M, C and K0 only", balance.inertia)
            for row, part in zip(rows, parts[1:], strict=True):
                if part != 0:
                    row[s] = part
        for row, part in zip(rows, den[1:], strict=True):
            if part != 0:
                row[right] = -part
        self.operations.append(System(z, *rows))

    def commit(self, stage: Stage, ends: Iterable[SubStepEnd]) -> None:
        """Add to the last system, that of the stage, the commits of the sub-steps that end with it.

        The velocity there is that of the knot, or where the step has none that at which the stage takes the force.
        """
        if not stage.alone:  # none ends with it
            return
        (balance,) = stage.balances
        moves = {s for atom in balance.force.atoms(N) for s in atom.free_symbols}
        system, found = self.operations[-1], []
        for end in (end for end in ends if end.u in moves):
            v = knot((knot_of(end.u) or "")[1]).v
            row = {v: Integer(1)} if v in self.instants else self.row(balance.damping)
            found.append(({end.u: Integer(1)}, row, self.instants[end.u]))
        if found:
            self.operations[-1] = replace(cast(System, system), commits=tuple(found))

    def press(self, step: Step, stage: Stage) -> None:
        """Say of the last system, that of the stage, where its reaction acts, if all balances have such."""
        if not stage.alone and len(step.stages) == 1:
            self._press_together(len(stage.balances))
        if not stage.alone or not isinstance(system := self.operations[-1], System):
            return
        k = step.accelerations.index(stage.z[0])
        if explicit(step):
            self.operations[-1] = replace(system, held=self._held_next(step, k))
            return
        try:
            of_reactions = impulses(step)
        except DeclarationError:
            return
        u, v = moved(step, k)
        if u in step.unknowns:
            rows = {u: Integer(1)}, {v: Integer(1)}
            numbers = factor(self.instants[u]), of_reactions.weights[k], of_reactions.strengths[k]
            self.operations[-1] = replace(system, contact=(*rows, *numbers))

    def _press_together(self, count: int) -> None:
        """Say of the last systems that each holds the displacement at which it takes the force, if all take one."""
        systems = cast("list[System]", self.operations[-count:])
        if all(len(x.forces) == 1 and not x.differences for x in systems):
            self.operations[-count:] = [replace(x, held=(x.forces[0][1],)) for x in systems]

    def _held_next(self, step: Step, k: int) -> tuple[Row, ...] | None:
        """What the reaction of the k-th balance of an explicit step holds; None of a scheme that takes none."""
        try:
            found = prescribed(step.scheme)
            require_held(step, found, bounded=False, gaps=False)
        except DeclarationError:
            return None
        held, _ = found.held[k]
        (u, _), (u0, _, _), at = moved(step, k), knot(0), instants_of(step)
        if u0 not in step.state or u not in step.prior or u == u0:
            before, ahead = Integer(0), Integer(0)
        else:
            before = (u - u0) / (h * at[u])
            ahead = u + h * (at[held] + int(held in step.prior) - at[u]) * before
        rows = held_next(step, held), mean_velocity(step, k, held), ahead, before
        return tuple(map(self.row, rows))

    def _forces(self, e: Expr) -> tuple[tuple[tuple[Expr, Row, Expr], ...], tuple[tuple[Expr, Row, Row], ...]]:
        """The terms w N(row), with their instants, and the terms w N(row, row), of an internal force."""
        forces, differences = [], []
        for atom, w in self._terms(e):
            rows = [self.row(cast(Expr, argument)) for argument in atom.args]
            if isinstance(atom, N):
                forces.append((w, rows[0], instant_of(cast(Expr, atom.args[0]), self.instants)))
            else:
                differences.append((w, rows[0], rows[1]))
        return tuple(forces), tuple(differences)

    def _terms(self, e: Expr) -> list[tuple[Expr, Expr]]:
        """(symbol of a knot, force or load; its coefficient) of each term of an expression linear in them."""
        e = sympify(e)
        marks: dict[Expr, Dummy] = {atom: Dummy() for atom in sorted(e.atoms(N, N_discrete, f), key=str)}
        e = e.subs(marks)
        symbols = [s for s in sorted(e.free_symbols, key=str) if knot_of(s)]
        return [(a, c) for a, s in [*((s, s) for s in symbols), *marks.items()] if (c := factor(e.diff(s))) != 0]

    def _solved(self, den: Parts, members: Iterable[tuple[Expr, tuple[Expr, ...]]]) -> Symbol:
        """The solution x of den x = sum of numerator * vector, with forces and loads by numbers."""
        x = Symbol(f"w_{len(self.operations)}")
        rows: tuple[dict[Symbol, Expr], ...] = tuple({x: part} if part != 0 else {} for part in den[1:])  # type: ignore[assignment]
        forces, loads = list[tuple[Expr, Row, Expr]](), list[tuple[Expr, Expr]]()
        for atom, (number, *parts) in members:
            if isinstance(atom, N | f) and not any(parts):
                argument = cast(Expr, atom.args[0])
                if isinstance(atom, N):
                    forces.append((-number, self.row(argument), instant_of(argument, self.instants)))
                else:
                    loads.append((number, argument))
                continue
            if number != 0 or isinstance(atom, N | f | N_discrete):
                raise self._refused(f"{atom} over matrices to have the units of a vector", number)
            for row, part in zip(rows, parts, strict=True):
                if part != 0:
                    row[self._vector(atom)] = -part
        self.operations.append(System(x, *rows, forces=tuple(forces), loads=tuple(loads)))
        return x

    def _quotient(self, coefficient: Expr) -> tuple[Parts, Parts | None]:
        """Numerator and denominator, both linear in the matrices, the latter's first part 1; None for a number."""
        numerator, den = (self._parts(e, coefficient) for e in fraction(cancel(coefficient)))
        if not any(den[1:]):
            return cast(Parts, tuple(cancel(p / den[0]) for p in numerator)), None
        if den[0] != 0:
            raise self._refused("a denominator made of M, C and K0 only", coefficient)
        first = next(p for p in den if p != 0)
        numerator, den = (tuple(factor(cancel(p / first)) for p in parts) for parts in (numerator, den))
        return cast(Parts, numerator), cast(Parts, den)

    def _parts(self, e: Expr, coefficient: Expr) -> Parts:
        slopes = [e.diff(matrix) for matrix in MATRICES]
        if any(slope.free_symbols & set(MATRICES) for slope in map(cancel, slopes)):
            raise self._refused("coefficients num/den, each linear in M, C, K0", coefficient)
        return cast(Parts, (cancel(e.subs(dict.fromkeys(MATRICES, 0))), *map(cancel, slopes)))

    def _vector(self, atom: Expr) -> Symbol:
        if not isinstance(atom, Symbol):
            raise self._refused("forces and loads in a relation divided by a matrix", atom)
        return atom

    def _refused(self, expected: str, got: object) -> DeclarationError:
        return DeclarationError(f"{self.scheme.name} on a structure: expected {expected}, got {got}")
