"""Vectors of a scheme's knots on a scene, written out in components."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from sympy import (
    Add,
    Dummy,
    Expr,
    Matrix,
    Mul,
    Piecewise,
    Symbol,
    cancel,
    diag,
    eye,
    fraction,
    sign,
    sympify,
    true,
    zeros,
)

from ..declare.branches import larger, smaller
from ..declare.errors import DeclarationError
from ..declare.law import elapsed
from ..declare.names import entry_name, python_name
from ..declare.scheme import Scheme
from ..declare.symbols import K0, C, K_t, M, N, N_discrete, f, h, knot_of, sampled, t
from ..step.times import instant_of
from .discrete import discrete_directions, discrete_gradient
from .equations import EquationsOfMotion

SINCE = Symbol("since")  # the number of steps before the run, where it goes on from another
STEPS = Symbol("steps"), Symbol("i") + SINCE  # those completed in all
BEGAN = Symbol("u_*began")  # the displacement at the start of the first run, where K0 is taken
TANGENT = Symbol("K_t")  # stands for the tangent stiffness that a scheme's start reads

Assignments = list[tuple[Symbol, Expr]]


def drawn_out(e: Expr, held: Callable[[Expr], bool], name: Callable[[Expr], Expr]) -> Expr:
    """The expression with every part that is held replaced by what `name` makes of it, also in sums and products."""
    if held(e):
        return name(e)
    if isinstance(e, Mul | Add):
        fixed = [a for a in e.args if held(a)]
        moving = [drawn_out(a, held, name) for a in e.args if not held(a)]
        return e.func(name(e.func(*fixed)) if fixed else e.func(), *moving)
    if isinstance(e, larger | smaller):
        return e.func(*(drawn_out(a, held, name) for a in e.args))
    return e.func(*(a if held(a) else drawn_out(a, held, name) for a in e.args)) if e.args else e


def assign(names: Matrix, values: Matrix) -> Assignments:
    """A vector's components, one by one."""
    return list(zip(names, values, strict=True))  # type: ignore[arg-type]


def component_names(symbol: Symbol, motion: EquationsOfMotion) -> list[str]:
    """Names of the vector's components; with a single coordinate, the symbol's own name."""
    suffixes = [f"_{q.name}" for q in motion.coordinates] if len(motion.coordinates) > 1 else [""]
    return [python_name(symbol) + suffix for suffix in suffixes]


@dataclass
class Writer:
    """Writes vectors in components, and collects as constants what does not change in a run."""

    scheme: Scheme
    motion: EquationsOfMotion
    stencil: tuple[Expr, ...]
    constants: Assignments = field(default_factory=list)
    fixed: set[Symbol] = field(default_factory=set)
    named: dict[Expr, Symbol] = field(default_factory=dict)
    K0: Matrix = field(default_factory=Matrix)
    now: Expr | None = None  # the time t_n, by default that of so many steps
    instants: dict[Symbol, Expr] = field(default_factory=dict)  # what symbols are in a motion u = t with h = 1
    committed: dict[Symbol, Expr] = field(default_factory=dict)  # displacements where memory was, and their instants
    began: Symbol = BEGAN  # the displacement at which K0 is taken
    reactions: dict[Expr, Matrix] = field(default_factory=dict)  # multipliers by the displacement of their force
    unknown: Matrix = field(default_factory=Matrix)  # those of the balance that is written
    acting: Matrix = field(default_factory=Matrix)  # the same, times what its force is for each
    latest: Matrix = field(default_factory=Matrix)  # those last solved for
    strengths: tuple[Expr, ...] = ()  # of each balance: see `step.times.impulses`
    holding: tuple[Symbol, ...] = ()  # of each balance the displacement at which its reactions hold: see `prescribed`

    def __post_init__(self) -> None:
        self.fixed |= set(self.scheme.values) | {p.symbol for p in self.motion.scene.parameters} | {h}
        if any(e.has(K0) for e in (*self.scheme.relations.values(), *(b.inertia for b in self.scheme.balances))):
            tangent = self.motion.tangent_at_start(list(self.components(self.began)))
            names = Matrix(self.size, self.size, lambda i, j: Symbol(entry_name("K0_", i, j)))
            entries = [(names[k], tangent[k]) for k in range(len(names)) if tangent[k] != 0]
            self.constants += entries
            self.fixed.update(name for name, _ in entries)
            self.K0 = Matrix(self.size, self.size, lambda i, j: names[i, j] if tangent[i, j] != 0 else 0)

    def instant(self, tau: Expr) -> Expr:
        """The time t_n + tau*h."""
        return h * (STEPS[0] + tau) if self.now is None else self.now + tau * h

    def when(self, argument: Expr) -> Expr:
        """The time of a displacement, or of a mixture of some."""
        return self.instant(instant_of(argument, self.instants))

    def reaction(self, force: Expr, u: Sequence[Expr], at: Expr | None = None) -> Matrix:
        """The reaction beside an internal force, at u and a time, from the multipliers there; 0 without constraints."""
        if not self.motion.scene.multipliers:
            return zeros(self.size, 1)
        where = self.when(force.args[0]) if at is None else at
        return self.motion.held.directions_at(u, where).T * self.reactions.get(force.args[0], self.acting)

    def discrete_reaction(self, old: Sequence[Expr], new: Sequence[Expr]) -> Matrix:
        """The reaction beside a discrete gradient between two displacements; 0 without constraints."""
        if not self.motion.scene.multipliers:
            return zeros(self.size, 1)
        return discrete_directions(self.motion, old, new).T * self.acting

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.motion.coordinates)

    def components(self, symbol: Symbol) -> Matrix:
        """Symbols of the vector's components."""
        return Matrix([Symbol(name) for name in component_names(symbol, self.motion)])

    def constant(self, e: Expr) -> Expr:
        """A name for an expression that does not change in a run."""
        if e.is_number or e.is_Symbol:
            return e
        if e.could_extract_minus_sign():
            return -self.constant(-e)
        if e not in self.named:
            self.named[e] = Symbol(f"c{len(self.named)}")
            self.constants.append((self.named[e], e))
            self.fixed.add(self.named[e])
        return self.named[e]

    def remembered(self, argument: Expr) -> dict[Symbol, Expr]:
        """The memory that the force at a displacement is taken from, and the time since it was committed.

        That of the displacement itself, where memory was committed at it, else the last one committed.
        """
        if not self.motion.memory:
            return {}
        place = list(self.committed).index(argument) if argument in self.committed else len(self.committed) - 1
        return self.memory(place) | {elapsed: self._since(argument, place)}

    def _since(self, argument: Expr, place: int) -> Expr:
        return self.constant(h * (instant_of(argument, self.instants) - list(self.committed.values())[place]))

    def memory(self, place: int) -> dict[Symbol, Symbol]:
        """The names of the memory after so many commits of a step."""
        return {s: Symbol(f"memory{place or ''}_{s.name}") for s in self.motion.memory}

    def commit(self, u: Symbol | Matrix, instant: Expr, condition: Expr = true) -> Assignments:
        """Assignments of the memory as it is committed at a displacement, which is then the last; nothing without laws.

        condition: where it is committed, depending on parameters.
        """
        if not self.motion.memory:
            return []
        at = self.components(u) if isinstance(u, Symbol) else u
        place = len(self.committed)
        old = self.memory(place - 1)
        since = self.constant(h * (instant - list(self.committed.values())[-1]))
        where = {**old, elapsed: since, **dict(zip(self.motion.coordinates, at, strict=True))}
        before = list(self.committed.values())[-1]
        reached = instant if condition == true else Piecewise((instant, condition), (before, True))
        self.committed[u if isinstance(u, Symbol) else Symbol(f"u_*commit{place}")] = reached
        new = self.memory(place)
        found = Assignments()
        for s, e in self.motion.commit.items():
            value = self.hoist(e.xreplace(where))
            found.append((new[s], value if condition == true else Piecewise((value, condition), (old[s], True))))
        return found

    def reciprocal(self, e: Expr, name: Expr) -> Expr:
        """A constant for 1/e, where name stands for e; 0 at parameters for which e is 0."""
        safe = e.free_symbols <= {h}
        return self.constant(1 / name if safe else Piecewise((1 / name, name > 0), (0, True)))

    def hoist(self, e: Expr) -> Expr:
        """The expression with every part that does not change in a run replaced by a constant."""
        return drawn_out(sympify(e), lambda part: part.free_symbols <= self.fixed, self.constant)

    def hoisted(self, vector: Matrix) -> Matrix:
        """The vector with `hoist` applied to each entry."""
        return vector.applyfunc(self.hoist)

    def inverse(self, matrix: Matrix) -> Matrix:
        """The inverse of a constant matrix, written out; its entries are constants."""
        if matrix == diag(*matrix.diagonal()):
            return diag(*(self.constant(1 / cancel(e)) for e in matrix.diagonal()))
        entries = self.hoisted(matrix)
        determinant = self.constant(entries.det())
        return entries.adjugate().applyfunc(lambda e: self.constant(e / determinant))

    def matrix(self, coefficient: Expr, tangent: Matrix) -> Matrix:
        """The matrix den^-1 num of a coefficient num/den, where num and den are linear in M, C, K0 and the tangent."""
        values = {M: self.motion.mass, C: self.motion.damping, K0: self.K0, TANGENT: tangent}
        if not coefficient.free_symbols & set(values):
            return coefficient * eye(self.size)

        def linear(e: Expr) -> Matrix:
            total = e.subs(dict.fromkeys(values, 0)) * eye(self.size)
            for symbol, value in values.items():
                slope = e.diff(symbol).expand()
                if slope.free_symbols & set(values):
                    raise DeclarationError(
                        f"{self.scheme.name}: expected coefficients num/den, each linear in M, C, K0, got {coefficient}"
                    )
                if slope != 0:
                    total += slope.factor() * value
            return total

        numerator, denominator = (linear(e) for e in fraction(cancel(coefficient)))
        if denominator == diag(*denominator.diagonal()):
            return (denominator.inv() * numerator).applyfunc(cancel)
        return self.inverse(denominator) * numerator

    def vector(self, e: Expr) -> Matrix:
        """Components of an expression linear in knots' symbols, forces N and loads f."""
        tangent, e = Matrix(), sympify(e)
        for where in e.atoms(K_t):
            at = self.vector(where.args[0])
            # where the force of laws bends: the tangent is that of the way on
            if self.motion.memory and where.args[0] in self.committed:
                moving = self.components(Symbol(f"v_{(knot_of(where.args[0]) or ('', '0'))[1]}"))
                at += moving.applyfunc(sign) * self.motion.scene.length / 10**9
            tangent = self.motion.tangent(list(at)).xreplace(self.remembered(where.args[0]))
            e = e.subs(where, TANGENT)
        marks: dict[Expr, Dummy] = {atom: Dummy() for atom in sorted(e.atoms(N, N_discrete, f), key=str)}
        e = e.subs(marks)
        knots = {s: Dummy() for s in sorted(e.free_symbols, key=str) if knot_of(s)}
        e = e.subs(knots, simultaneous=True)
        total = zeros(self.size, 1)
        for atom, mark in (marks | knots).items():
            coefficient = e.diff(mark)
            if coefficient != 0:
                total += self.matrix(coefficient, tangent) * self._value(atom)
        return total

    def _value(self, atom: Expr) -> Matrix:
        if isinstance(atom, N):
            at = list(self.vector(atom.args[0]))
            force = self.motion.force(at) + self.reaction(atom, at)
            return force.xreplace(self.remembered(atom.args[0]))
        if isinstance(atom, N_discrete):
            old, new = (list(self.vector(argument)) for argument in atom.args)
            return discrete_gradient(self.motion, old, new) + self.discrete_reaction(old, new)
        if isinstance(atom, f):
            given = Symbol(f"f_{self.stencil.index(atom.args[0])}")
            return self.motion.load.subs({sampled: given, t: self.instant(atom.args[0])})
        return self.components(atom)
