"""Step x Scene -> Body: what a step computes, component by component, and nothing the scene does not need.

A body says nothing of how time goes on or of where the numbers of a lane lie: any kernel's step is printed from it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from sympy import Abs, Expr, Integer, Matrix, Ne, Piecewise, Symbol, oo, true

from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import N, knot, knot_of, steps_back, successor, t
from ..motion.components import BEGAN, SINCE, STEPS, Assignments, Writer, assign, component_names
from ..motion.differences import Difference, DifferenceSlope
from ..motion.equations import EquationsOfMotion
from ..step.step import Stage, Step, instants
from ..step.times import passed, sub_step_ends
from .balance_step import BalanceStep, Part, Phase, balance_step, written
from .general_step import general_step, refuse
from .near_series import NearSeries
from .projection import projected
from .reactions import begin, held_first
from .remembering import at_start, kept, loads_of, remembered


@dataclass(frozen=True)
class Start:
    """The state at t = 0 from u_0, v_0, a_0 and the loads at the stencil; a column for each symbol of the state."""

    constants: Assignments
    state: Matrix
    stencil: tuple[Expr, ...]


@dataclass(frozen=True)
class Body:
    """A step of the scheme on the scene.

    constants: assignments made once a run, in order. prior: assignments before the first balance. shift: component
    of the state -> its successor, oldest first. report: components of u, v and, where the scheme has its own, a at
    t_n + h; reported: the assignments that compute them. memory: what laws remember at t_n -> the same at t_n + h, of
    which last_commit has the assignments. energy: that of the reported u, v. stencil: instants of the load, in steps
    after t_n. start: None where another scheme marches first. errors: components of the estimated local errors, where
    they were asked for. held_first: see `reactions.held_first`. projection: assignments after the last balance, and
    filters: those before the errors; each may read those before it.
    """

    scheme: Scheme
    motion: EquationsOfMotion
    constants: Assignments
    prior: Assignments
    steps: tuple[BalanceStep, ...]
    shift: Assignments
    reported: Assignments
    report: tuple[Matrix, ...]
    memory: Assignments
    last_commit: Assignments
    energy: Expr
    stencil: tuple[Expr, ...]
    start: Start | None
    errors: tuple[Matrix, ...] = ()
    held_first: tuple[tuple[Expr, Expr, Expr], Expr] | None = None
    projection: Assignments = field(default_factory=Assignments)
    filters: Assignments = field(default_factory=Assignments)

    @classmethod
    def of(
        cls,
        scheme: Scheme,
        motion: EquationsOfMotion,
        *,
        now: Expr | None = None,
        errors: Sequence[Expr] = (),
        weights: Iterable[Symbol] = (),
        read: Iterable[Symbol] = (),
    ) -> "Body":
        """now: the time t_n; by default that of the steps completed, and K0 is then that at the start of the first run.

        errors: linear in knots' symbols; weights: numbers that they contain. read: further symbols of the step that
        have to be computed.

        Raises DeclarationError for coefficients that are no matrices of the scene, or a scene with damping that the
        scheme does not take.
        """
        if motion.damped and not scheme.takes_damping:
            others, cure = (
                (" or other forces of rates", "")
                if motion.moves
                else ("", ", or declare the scene without dissipation")
            )
            raise DeclarationError(
                f"{scheme.name} is a scheme for u'' = g(t, u): expected a scene without damping{others}, got "
                f"{motion.scene.name}; take another scheme{cure}"
            )
        if motion.moves:
            refuse(scheme, motion)
        near = scheme.in_doubles
        lowered, exact = Step.of(near), Step.of(scheme)
        prior, found, outputs = lowered.prior, lowered.stages, lowered.outputs
        loads = [*(b.load for b in near.balances), *loads_of(lowered, motion.scene)]
        stencil = instants([*loads, *outputs], near.typical)
        w = Writer(near, motion, stencil, now=now, began=BEGAN if now is None else knot(0).u)
        w.fixed.update(weights)
        ends = sub_step_ends(exact) if motion.scene.laws else ()  # which refuses a discrete gradient of any law
        if motion.memory or motion.general:
            w.instants |= passed(lowered)
        if motion.memory:
            w.committed[knot(0).u] = Integer(0)
        begin(w, scheme, lowered)
        reads = [*outputs, *errors, *read, *(end.u for end in ends if motion.memory)]
        wanted = _wanted(near, prior, found, reads, damped=motion.damped)
        known = written(w, {s: e for s, e in prior.items() if s in wanted})
        last, steps = knot(0).u, list[BalanceStep]()
        for stage in found:
            make = general_step if motion.general else balance_step
            step = make(w, len(steps), stage, last, wanted)
            moves = {s for b in stage.balances for a in b.force.atoms(N) for s in a.free_symbols}
            for end in (x for x in ends if motion.memory and x.u in moves and x.u not in w.committed):
                at = w.instants[end.u]
                inside = true if end.always else (list(w.committed.values())[-1] < at) & (at < 1)
                step = replace(step, commits=[*step.commits, *w.commit(end.u, at, inside)])
            steps.append(step)
            last = (stage.moved_by(-1) or [last])[-1]
        free, more, reactions = kept(w, lowered)
        carried, shown, projection = projected(w, lowered)
        steps[-1] = replace(steps[-1], settled=(*steps[-1].settled, Part(more)))
        shift = _shifted(w, near.state, {**free, **carried})
        report, assigned = _reported(w, [*(e.subs(shown) for e in outputs[:2]), *(e.subs(free) for e in outputs[2:])])
        last_commit = w.commit(report[0], Integer(1))
        committed = w.memory(len(w.committed) - 1)
        memory: Assignments = list(zip(w.memory(0).values(), committed.values(), strict=True))
        memory += assign(at_start(motion.scene), reactions)
        at = dict(zip((*motion.coordinates, *motion.scene.rates), (*report[0], *report[1]), strict=True))
        energy = w.hoist(motion.energy.xreplace({**at, **committed, t: w.instant(Integer(1))}))
        estimates, filters = _filtered(w, errors, list(zip(found, steps, strict=True)))
        start = _start(scheme, motion) if scheme.start_scheme is None else None
        made = cls(
            scheme, motion, w.constants, known, tuple(steps), [*shift, *memory], assigned, tuple(report), memory,
            last_commit, energy, stencil, start, estimates, held_first(w, lowered), projection, filters,
        )  # fmt: skip
        counted = any(e.has(STEPS[0]) for e in made.expressions)
        return replace(made, prior=[STEPS, *known]) if counted else made

    @property
    def expressions(self) -> list[Expr]:
        """Every expression that a run computes, except those of its start."""
        lists = [self.constants, self.prior, self.projection, self.filters, self.reported, self.last_commit]
        lists += [a for s in self.steps for a in (s.before, s.moving, s.solved, s.after, s.commits)]
        lists += [part.assignments for s in self.steps for part in (*s.prepared, *s.settled)]
        matrices = [m for s in self.steps for m in (s.residual, s.jacobian, s.inverse, s.first) if m is not None]
        matrices += self.errors
        return [e for pairs in lists for _, e in pairs] + [e for m in matrices for e in m] + [self.energy]

    def parameters(self, expressions: Iterable[Expr]) -> tuple[Symbol, ...]:
        """Parameters of the scheme and the scene that the expressions contain, in the order declared."""
        used = {s for e in expressions for s in e.free_symbols}
        declared = (*self.scheme.values, *(p.symbol for p in self.motion.scene.parameters))
        return tuple(s for s in declared if s in used)

    @property
    def near(self) -> Assignments:
        """How small the last correction of z has to be for that of the displacement to be within the tolerance."""
        within = Symbol("tolerance")
        return [
            (Symbol(f"near_{k}"), Piecewise((within / Abs(step.reach), Ne(step.reach, 0)), (oo, True)))
            for k, step in enumerate(self.steps)
            if step.first is not None
        ]

    @property
    def finite(self) -> list[str]:
        """Names of the numbers that have to be finite for a step to count as completed, the energy last.

        Those of which the energy is a polynomial are left out: if one is not finite, neither is the energy.
        """
        names = {str(e) for vector in self.report for e in vector} | {str(new) for _, new in self.shift}
        seen = {str(s) for s in self.energy.free_symbols if self.energy.is_polynomial(s)}
        return [*sorted(names - seen), "energy"]

    @property
    def near_series(self) -> list[NearSeries]:
        """The Taylor series of each function whose divided differences a run computes."""
        found = {a for e in self.expressions for a in e.atoms(Difference, DifferenceSlope)}
        return [NearSeries.of(name) for name in sorted({str(a.args[0]) for a in found})]

    @property
    def phases(self) -> tuple[Phase, ...]:
        """A step up to what it reports, in order; the last phase iterates nothing."""
        found: list[Phase] = []
        parts = [Part(self.prior)]
        for step in self.steps:
            parts += [*step.prepared, Part(step.before)]
            if step.solved:
                # of an elimination, which assigns more than z, each on its own
                parts.append(Part(step.solved, named=len(step.solved) == len(step.z)))
            elif step.first is None:
                R = step.residual_names
                parts += [Part(assign(R, step.residual)), Part(assign(step.z, -step.inverse * R), named=False)]
            else:
                start = [*assign(step.z, step.first), *step.bounds]
                found += [(*parts, Part(start, named=False)), step]
                parts = []
            parts += [Part(step.after), *step.settled, Part(step.commits)]
        parts.append(Part(self.projection, named=False))
        if self.last_commit:
            parts += [Part(self.reported), Part(self.last_commit)]
        return (*found, tuple(parts))

    @property
    def results(self) -> tuple[Part, Part]:
        """What is computed after the phases: what is reported, and the energy of that, apart since it reads these."""
        return Part(self.closing), Part([(Symbol("energy"), self.energy)])

    @property
    def iterated(self) -> list[int]:
        """Places of the balances that iterate."""
        return [step.k for step in self.steps if step.first is not None]

    @property
    def scalars(self) -> list[str]:
        """Names of the numbers that a lane is given: h, parameters, steps before, and the tolerance of iterations."""
        tolerance = ["tolerance"] if self.iterated else []
        since = [SINCE.name] if any(e.has(SINCE) for e in self.expressions) else []
        return ["h", *(s.name for s in self.parameters(self.expressions)), *since, *tolerance]

    @property
    def loads(self) -> list[Symbol]:
        """Names of the loads at the stencil; none where the scene takes no load from the user."""
        return [Symbol(f"f_{k}") for k in range(len(self.stencil))] if self.motion.is_sampled else []

    def components(self, s: Symbol | str) -> list[str]:
        """Names of a vector's components."""
        return component_names(Symbol(s) if isinstance(s, str) else s, self.motion)

    @property
    def carried(self) -> tuple[Symbol, ...]:
        """The state, and where its tangent at the start is a matrix of the scheme, the displacement there."""
        names = set(self.components(BEGAN))
        began = any(s.name in names for e in self.expressions for s in e.free_symbols)
        return (*self.scheme.state, BEGAN) if began else self.scheme.state

    @property
    def places(self) -> list[tuple[str, str]]:
        """Name of every component of what is carried, and its row and column; what laws remember in rows of its own."""
        return [*self.places_of(self.carried), *self.laid([s.name for s, _ in self.memory], len(self.carried))]

    @property
    def stored(self) -> list[tuple[str, Expr]]:
        """Row and column of every number that is reported, and the number."""
        found = [(f"{k}, {i}", e) for k, vector in enumerate(self.report) for i, e in enumerate(vector)]
        return [*found, *((place, e) for e, place in self.laid([e for _, e in self.memory], len(self.report)))]

    @property
    def reported_numbers(self) -> int:
        """How many numbers of u, v and, where the scheme has its own, a are reported: the first that are stored."""
        return len(self.report) * len(self.motion.coordinates)

    @property
    def rows(self) -> int:
        """The number of rows of what is carried from step to step."""
        return len(self.carried) + self.rows_of_memory

    @property
    def rows_of_memory(self) -> int:
        """The number of rows of what laws remember."""
        return -(-len(self.memory) // len(self.motion.coordinates))

    @property
    def closing(self) -> Assignments:
        """What is reported, where the phases have not assigned it."""
        return [] if self.last_commit else self.reported

    def laid(self, numbers: Sequence[Any], first: int) -> list[tuple[Any, str]]:
        """Numbers, and the place of each in rows of as many columns as there are coordinates, from the first on."""
        d = len(self.motion.coordinates)
        return [(e, f"{first + k // d}, {k % d}") for k, e in enumerate(numbers)]

    def places_of(self, vectors: Iterable[Symbol], first: int = 0) -> list[tuple[str, str]]:
        """Name of every component of vectors that are rows from the first on, and its row and column."""
        rows = enumerate(vectors, start=first)
        return [(name, f"{j}, {i}") for j, s in rows for i, name in enumerate(self.components(s))]


def _filtered(
    w: Writer, errors: Sequence[Expr], steps: Sequence[tuple[Stage, BalanceStep]]
) -> tuple[tuple[Matrix, ...], Assignments]:
    """Components of estimated errors, and the assignments before them.

    They are filtered by the effective mass of the last implicit balance, if it has one of its own.
    """
    found = [(Assignments(), w.vector(e)) for e in errors]
    last = next(((stage, step) for stage, step in reversed(steps) if stage.moved), None)
    if last and last[0].alone:
        found = [last[1].filtered(e, f"_{k}") for k, (_, e) in enumerate(found)]
    before = [(s, w.hoist(e)) for assigned, _ in found for s, e in assigned]
    return tuple(w.hoisted(e) for _, e in found), before


def _shifted(w: Writer, state: Iterable[Symbol], free: Mapping[Symbol, Symbol]) -> Assignments:
    """Component of the state -> its successor, or what is kept in place of that, oldest first."""
    oldest_first = sorted(state, key=steps_back, reverse=True)
    new = [(s, successor(s)) for s in oldest_first]
    return [both for s, after in new for both in assign(w.components(s), w.components(free.get(after, after)))]


def _reported(w: Writer, outputs: Iterable[Expr]) -> tuple[list[Matrix], Assignments]:
    """Components of what a step reports, and the assignments that compute them."""
    report, assigned = list[Matrix](), Assignments()
    for e, kind in zip(outputs, "uva", strict=False):
        vector = w.hoisted(w.vector(e))
        names = vector if e.is_Symbol else w.components(Symbol(f"{kind}_*reported"))
        assigned += [] if e.is_Symbol else assign(names, vector)
        report.append(names)
    return report, assigned


def _start(scheme: Scheme, motion: EquationsOfMotion) -> Start:
    scheme = scheme.in_doubles
    expressions = Step.of(scheme).start
    assert expressions is not None
    stencil = instants(expressions, scheme.typical)
    w = Writer(
        scheme, motion, stencil, began=knot(0).u, instants={knot(0).u: Integer(0)}, committed={knot(0).u: Integer(0)},
        reactions={knot(0).u: remembered(motion.scene)},
    )  # fmt: skip
    state = Matrix.hstack(*(w.hoisted(w.vector(e).subs(STEPS[0], SINCE)) for e in expressions))
    return Start(w.constants, state, stencil)


def _wanted(
    scheme: Scheme, prior: Mapping[Symbol, Expr], found: Sequence[Stage], outputs: Iterable[Expr], *, damped: bool
) -> set[Symbol]:
    """Symbols of the new step that a balance, the next step or the report reads; damped: the scene has damping."""
    wanted = {s for e in outputs for s in e.free_symbols} | {successor(s) for s in scheme.state}
    for stage in found:
        own = {*stage.in_z, *stage.z}
        taken = [e for b in stage.balances for e in (b.inertia, b.force, *([b.damping] if damped else []))]
        read = {s for e in (*stage.in_z.values(), *taken) for s in e.free_symbols}
        wanted |= {s for s in read - own if knot_of(s)}
    for e in prior.values():
        wanted |= {s for s in e.free_symbols if knot_of(s)}
    return wanted
