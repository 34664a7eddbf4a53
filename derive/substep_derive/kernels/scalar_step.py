"""Plan -> what a step computes on one degree of freedom: scalars, and one equation for each system of the plan.

With one degree of freedom the matrices are numbers. Every system of a plan, also one that stands for a quotient of
matrices, is then one equation residual(z) = 0, whose derivative by z is called its effective mass. It is solved by
Newton's iteration, which ends after the first correction where no internal force depends on z.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from sympy import Expr, Integer, Symbol

from ..declare.errors import DeclarationError
from ..declare.names import python_name
from ..motion.plan import Combination, Plan, Row, System
from ..step.step import Step

MASS, DAMPING, STIFFNESS = Symbol("mass"), Symbol("damping"), Symbol("stiffness")
Assignment = tuple[Symbol, Expr]


@dataclass(frozen=True)
class Force:
    """An internal force: its value, and where it depends on the unknown its slope, at a displacement, in symbols.

    before: of a discrete gradient, the earlier displacement; None for the force at one displacement.
    """

    value: Symbol
    slope: Symbol | None
    displacement: Expr
    before: Expr | None


@dataclass(frozen=True)
class ScalarBalance:
    """One system of a plan as residual(unknown) = 0.

    system: as the plan has it. known: the vectors it reads. lines: vectors that depend on the unknown. loads: symbol ->
    instant in steps after t_n. residual, effective_mass: in all of these symbols; the latter is the derivative.
    displacement: the one that the internal force moves to, or None; reach: its derivative by the unknown.
    """

    system: System
    unknown: Symbol
    known: tuple[Symbol, ...]
    lines: tuple[Assignment, ...]
    forces: tuple[Force, ...]
    loads: tuple[tuple[Symbol, Expr], ...]
    residual: Expr
    effective_mass: Expr
    displacement: Symbol | None
    reach: Expr

    @property
    def expressions(self) -> list[Expr]:
        """Everything that it computes."""
        inside = [e for force in self.forces for e in (force.displacement, force.before) if e is not None]
        loads = [tau for _, tau in self.loads]
        return [e for _, e in self.lines] + inside + loads + [self.residual, self.effective_mass, self.reach]


@dataclass(frozen=True)
class ScalarStep:
    """A step, or a start: assignments and balances in the order in which they are computed.

    given: what is there before. out: the new state. report: u, v and, where the scheme has its own, a.
    """

    given: tuple[Symbol, ...]
    operations: tuple[Assignment | ScalarBalance, ...]
    out: tuple[Expr, ...]
    report: tuple[Expr, ...]

    @classmethod
    def of(cls, plan: Plan) -> "ScalarStep":
        """The plan's step, with names that a program can have.

        Raises DeclarationError for a scheme that solves balances together.
        """
        if any(not stage.alone for stage in Step.of(plan.scheme).stages):
            raise DeclarationError(
                f"{plan.scheme.name} solves balances together: expected balances that are solved one after the other "
                "in a file of one language, got several; take a composite scheme"
            )
        w = _Scalars(plan)
        for o in plan.operations:
            w.add(o)
        out, report = (tuple(_sum(row) for row in rows.values()) for rows in (plan.out, plan.report))
        read = {s for e in (*out, *report) for s in e.free_symbols}
        operations: list[Assignment | ScalarBalance] = []
        for o in reversed(w.operations):  # an assignment that only its balance reads is made there
            if isinstance(o, ScalarBalance):
                read |= set(o.known)
            elif o[0] in read:
                read |= o[1].free_symbols
            else:
                continue
            operations.append(o)
        return cls(tuple(map(named, plan.given)), tuple(reversed(operations)), out, report)

    @property
    def balances(self) -> tuple[ScalarBalance, ...]:
        """The equations that are solved, in their order."""
        return tuple(o for o in self.operations if isinstance(o, ScalarBalance))

    @property
    def assigned(self) -> list[Expr]:
        """The expressions outside of balances."""
        return [o[1] for o in self.operations if isinstance(o, tuple)] + [*self.out, *self.report]


def named(vector: Symbol) -> Symbol:
    """The symbol that stands for a vector of a plan."""
    return Symbol(python_name(vector))


def _sum(row: Row) -> Expr:
    return sum((e * named(s) for s, e in row.items()), Integer(0))


class _Scalars:
    """Puts the combinations that read an unknown after its balance; the balance itself computes those it needs."""

    def __init__(self, plan: Plan) -> None:
        self.known = set(plan.given)
        self.waiting: list[Combination] = []
        self.operations: list[Assignment | ScalarBalance] = []

    def add(self, operation: Combination | System) -> None:
        """The next operation of the plan."""
        if isinstance(operation, Combination):
            self.waiting.append(operation)
        else:
            self.operations.append(_balance(replace(operation, contact=None), self.waiting))
            self.known.add(operation.vector)
        for c in list(self.waiting):
            if self.known.issuperset(c.row):
                self.waiting.remove(c)
                self.known.add(c.vector)
                self.operations.append((named(c.vector), _sum(c.row)))


def _balance(system: System, waiting: Iterable[Combination]) -> ScalarBalance:
    z = named(system.vector)
    read = replace(system, commits=(), held=None).vectors  # a file of one language has no laws and no reactions
    moving = [c for c in waiting if c.vector in read]
    lines = tuple((named(c.vector), _sum(c.row)) for c in moving)
    by_z: Mapping[Symbol, Expr] = {s: e.diff(z) for s, e in lines} | {z: Integer(1)}

    def slope(e: Expr) -> Expr:
        return sum((e.diff(s) * c for s, c in by_z.items()), Integer(0))

    rows = {MASS: system.inertia, DAMPING: system.damping, STIFFNESS: system.stiffness}
    residual = sum((matrix * _sum(row) for matrix, row in rows.items()), Integer(0))
    effective_mass = sum((matrix * slope(_sum(row)) for matrix, row in rows.items()), Integer(0))
    places = [(w, None, _sum(row)) for w, row, _ in system.forces]
    places += [(w, _sum(before), _sum(row)) for w, before, row in system.differences]
    forces: list[Force] = []
    for k, (w, before, displacement) in enumerate(places, start=1):
        moves = slope(displacement)
        force = Force(Symbol(f"force_{k}"), Symbol(f"slope_{k}") if moves != 0 else None, displacement, before)
        forces.append(force)
        residual += w * force.value
        effective_mass += w * moves * (force.slope or 0)
    loads = tuple((Symbol(f"load_{k}"), tau) for k, (_, tau) in enumerate(system.loads, start=1))
    residual -= sum((w * symbol for (w, _), (symbol, _) in zip(system.loads, loads, strict=True)), Integer(0))
    moved = [s for f in forces if f.slope for s in (*f.displacement.free_symbols & by_z.keys(),)]
    displacement = min(moved, key=str, default=None)
    known = {s for _, e in lines for s in e.free_symbols} | {named(s) for s in read}
    known &= {named(s) for s in read.union(*(c.row for c in moving))}
    return ScalarBalance(
        system, z, tuple(sorted(known - by_z.keys(), key=str)), lines, tuple(forces), loads,
        residual, effective_mass, displacement, by_z[displacement] if displacement else Integer(0),
    )  # fmt: skip
