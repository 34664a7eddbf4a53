"""Stage x Scene -> BalanceStep: how a kernel solves a balance for its new acceleration z, or several for theirs.

A balance's displacement is p + c_u z with p the predictor. So a linear scene or an explicit balance needs only the
constant matrix c_a M + c_v C + c_u K, inverted once a run; Newton's iteration is needed for a nonlinear force that
depends on z. Of balances that are solved together z is the vector of all their accelerations.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from sympy import (
    Add,
    Dummy,
    Expr,
    Integer,
    Matrix,
    Mul,
    Piecewise,
    Rational,
    S,
    Symbol,
    diag,
    oo,
    symbols,
    zeros,
)

from ..declare.names import entry_name
from ..declare.parameter import POSITIVE
from ..declare.scheme import Balance
from ..declare.symbols import N, N_discrete, h
from ..motion.components import Assignments, Writer, assign
from ..motion.equations import EquationsOfMotion, inverted
from ..step.step import Stage
from ..step.times import instant_of
from .branches import root
from .linear_system import eliminated, entries_of, written_out
from .together import Reach, begun_together, predicted, reached, split, unknowns


@dataclass(frozen=True)
class Part:
    """Assignments, and whether their common subexpressions get names."""

    assignments: Assignments
    named: bool = True


@dataclass(frozen=True)
class BalanceStep:
    """The balances of the k-th stage as the kernel computes them, with a row for each coordinate of each balance.

    z: the unknown acceleration. before: assignments made once a step. moving: those that depend on z and are repeated
    in every Newton iteration. residual: of the balances, a function of what before and moving assign. jacobian: its
    derivative with respect to z. first: the z from which the iteration starts. reach: c_u, the derivative of the
    displacement with respect to z. after: assignments once z is known. A balance without iteration has first = None,
    and z = -inverse * residual with a constant inverse, or z as `solved` assigns it where the residual is piecewise
    linear, and inverse is what would be inverted before any law yields. free: the residual's derivative by z without
    internal force. bounds: names of two values of z between which the root is kept, and their values before the first
    iteration; where laws make the residual bend. prepared: what is computed of known accelerations, before all else.
    settled: what is computed of reactions after that. commits: of what laws remember, once the balance is solved.
    multipliers: how many of the last unknowns are reactions, of which the last rows of the residual are; bounded: how
    many of the last of these are pressures and frictions.
    """

    k: int
    z: Matrix
    before: Assignments
    moving: Assignments
    residual: Matrix
    jacobian: Matrix
    inverse: Matrix
    first: Matrix | None
    reach: Expr
    after: Assignments
    free: Matrix
    solved: Assignments = field(default_factory=Assignments)
    bounds: Assignments = field(default_factory=Assignments)
    prepared: tuple[Part, ...] = ()
    settled: tuple[Part, ...] = ()
    commits: Assignments = field(default_factory=Assignments)
    multipliers: int = 0
    bounded: int = 0

    @cached_property
    def _system(self) -> Matrix | None:
        """The entries of the array that Newton's iteration solves; None where it is written out, or there is none."""
        alone = self.first is None or written_out(self.jacobian, pivoting=self._pivoting)
        return None if alone else entries_of(f"_{self.k}", len(self.z))

    @property
    def _pivoting(self) -> bool:
        """Whether a coordinate may have no mass but that by a constraint."""
        return self.multipliers > 0 and any(e == 0 for e in self.free.diagonal())

    @property
    def residual_names(self) -> Matrix:
        """The names that the residual's components have in the kernel."""
        return Matrix(symbols(f"residual_:{len(self.z)}")) if self._system is None else self._system[:, -1]

    @property
    def jacobian_names(self) -> Matrix:
        """The names that the Jacobian's entries have in the kernel; 0 for an entry that is 0."""
        size, system = len(self.z), self._system
        names = Matrix(size, size, lambda i, j: Symbol(entry_name("jacobian_", i, j))) if system is None else system
        return names[:, :size].multiply_elementwise(self.jacobian.applyfunc(lambda e: Integer(int(e != 0))))

    def filtered(self, error: Matrix, mark: str) -> tuple[Assignments, Matrix]:
        """The error times free over the effective mass: bounded where a component is stiff, and equal for small steps.

        And what is computed for it, each on its own; mark: the end of the names that this assigns. Shampine & Baca,
        Appl. Numer. Math. 1 (1985) 495-506; with the Jacobian of the last iteration, if there is one.
        """
        right, size = self.free * error, len(self.z)
        if self.first is None and not self.solved:
            return [], self.inverse * right
        J = self.inverse if self.first is None else self.jacobian_names
        if size == 1:
            return [], right / J[0]
        if size == 2:
            return [], J.adjugate() * right * Symbol("one_over_det")
        given, names = (Matrix(symbols(f"{name}{mark}_:{size}")) for name in ("unfiltered", "filtered"))
        own = f"_{self.k}" if self._system is not None else mark
        return [*assign(given, right), *eliminated(J, given, names, S.One, own)], names

    def correction(self, factor: Expr = S.One) -> tuple[Assignments, Assignments, Matrix]:
        """Assignments of residual and Jacobian; the solve, written out; Newton's correction, times factor, by name."""
        size, R, J = len(self.z), self.residual_names, self.jacobian_names
        entries = [*assign(R, self.residual), *((s, e) for s, e in assign(J, self.jacobian) if e != 0)]
        change, one_over = Matrix(symbols(f"change_:{size}")), Symbol("one_over_det")
        if size == 1 and self.bounds:
            return entries, self._bounded(factor), change
        if size == 1:
            return entries, assign(change, factor * R / J[0]), change
        if size > 2:
            mark = "" if self._system is None else f"_{self.k}"
            return entries, eliminated(J, R, change, factor, mark, pivoting=self._pivoting), change
        solve = assign(Matrix([one_over, *change]), Matrix([factor / J.det(), *(J.adjugate() * R * one_over)]))
        return entries, solve, change

    def _bounded(self, factor: Expr) -> Assignments:
        """Newton's correction where it stays between the bounds, which it narrows; else one to near their middle."""
        (z,), (R,), (J,), ((low, _), (high, _)) = self.z, self.residual_names, self.jacobian_names, self.bounds
        newton, change = Symbol("newton_z"), Symbol("change_0")
        return [
            (low, Piecewise((z, R < 0), (low, True))),
            (high, Piecewise((z, R > 0), (high, True))),
            (newton, z - R / J),
            (
                change,
                factor
                * Piecewise(
                    (z - newton, (low <= newton) & (newton <= high)), (z - (low + Rational(9, 20) * (high - low)), True)
                ),
            ),
        ]


# what a step computes between iterations, or the balance that is iterated
Phase = tuple[Part, ...] | BalanceStep


def written(w: Writer, expressions: dict[Symbol, Expr]) -> Assignments:
    """Assignments of the components of symbols, each from its expression."""
    return [both for s, e in expressions.items() for both in assign(w.components(s), w.hoisted(w.vector(e)))]


def balance_step(w: Writer, k: int, stage: Stage, last: Symbol, wanted: set[Symbol]) -> BalanceStep:
    """The balances of one stage; they are iterated if a force depends on z and is nonlinear."""
    z = unknowns(w, stage)
    at_zero, parts = dict.fromkeys(z, Integer(0)), split(w, z)

    def solved(e: Expr) -> Matrix:
        return w.vector(e.subs(stage.in_z, simultaneous=True))

    def each(of: Callable[[Balance], Matrix]) -> Matrix:
        return Matrix.vstack(*map(of, stage.balances))

    inertia = each(lambda b: w.motion.mass * solved(b.inertia) + w.motion.damping * solved(b.damping))
    still = inertia.subs(at_zero) - each(lambda b: w.vector(b.load))  # the residual at z = 0, without internal force
    slope = free = inertia.jacobian(z)  # the residual's derivative by z, without that of the internal force
    reach, before, after = reached(w, stage, z, lambda e: w.hoisted(solved(e)))
    others = {s: w.vector(e) for s, e in stage.in_z.items() if s in wanted and s not in reach}
    begun, still, later = _named(w, still, others, at_zero)
    before, moves, after = before + begun, after, after + later
    by_rate, rate_slope = (each(lambda b, n=n: _rate_force(w, solved(b.damping), z)[n]) for n in (0, 1))
    if (not stage.moved or w.motion.linear) and rate_slope.is_zero_matrix:
        names = {s: predicted(number) for number, s in enumerate(reach)}
        tangent = w.motion.tangent([Integer(0)] * w.size) if w.motion.linear else Matrix()
        for s, by_z in reach.items():
            slope = slope + each(
                lambda b, s=s, by_z=by_z: Matrix.hstack(*(_displacement(b).diff(s) * c * tangent for c in by_z))
            )
        residual = w.hoisted(still + by_rate + each(lambda b: w.vector(b.force.subs(names))))
        if stage.alone and inverted(slope):
            return BalanceStep(k, z, before, [], residual, slope, w.inverse(slope), None, Integer(0), after, free)
        found = BalanceStep(k, z, before, [], residual, slope, w.hoisted(slope), None, Integer(0), after, free)
        right = found.residual_names
        solve = eliminated(found.inverse, right, z, -S.One, "" if written_out(found.inverse) else f"_{k}")
        return replace(found, solved=[*assign(right, residual), *solve])
    mixed, forces, known, by_z = _moving_force(w, stage, reach)
    per_mass, of_rate = _per_mass(w.motion) * len(stage.z), not rate_slope.is_zero_matrix
    slope, plain, forces, by_z, still = (
        _scaled(w, per_mass, matrix) for matrix in (slope, forces, forces + by_rate, by_z + rate_slope, still + known)
    )
    rest = w.hoisted(still)
    residual, begun = slope * z + forces, plain
    if any(e != 0 for e in rest):
        r = Matrix([s for number in range(len(parts)) for s in w.components(Symbol(f"r{number or ''}"))])
        before += assign(r, rest)
        residual, begun = residual + r, begun + r
    if w.motion.scene.laws and len(z) == 1:
        at = residual.subs(dict(mixed)).subs(dict(moves))[0]
        if (found := root(at, z[0], w)) is not None:
            elastic = slope + _scaled(w, per_mass, _elastic(w, stage, reach))
            return BalanceStep(
                k, z, before, [], residual, slope, elastic, None, Integer(0), after, free, solved=[(z[0], found)]
            )
    if not stage.alone:
        first, far = begun_together(w, stage, reach, last, solved)
        if of_rate:  # as if there were no such force, nor what couples accelerations: see below
            begun = w.hoisted(begun.subs(dict(mixed)).subs(dict(moves)).subs(at_zero))
            first = Matrix([-e / slope[i, i] for i, e in enumerate(begun)])
        matrices = w.hoisted(residual), w.hoisted(slope + by_z), Matrix()
        return BalanceStep(k, z, before, moves + mixed, *matrices, first, far, after, slope)
    (c_u,) = next(iter(reach.values()), [h * stage.c_v()])  # where only the velocity moves, what it would do to u
    if of_rate:  # as if there were no such force, since its slope at rest may have no bound
        begun = w.hoisted(begun.subs(dict(mixed)).subs(dict(moves)).subs(at_zero))
        by = slope if inverted(slope) else diag(*slope.diagonal())
        first = -w.inverse(by) * begun
    else:
        one_over = w.reciprocal(solved(next(iter(reach)))[0].diff(z[0]), c_u)
        first = (w.components(last) - w.components(predicted(0))) * one_over
    bends = bool(w.motion.scene.laws) and w.size == 1
    return BalanceStep(
        k, z, before, moves + mixed, w.hoisted(residual), w.hoisted(slope + by_z), Matrix(), first, c_u, after, slope,
        bounds=[(Symbol(f"low_{k}"), -oo), (Symbol(f"high_{k}"), oo)] if bends else [],
    )  # fmt: skip


def _named(
    w: Writer, still: Matrix, moved: Mapping[Symbol, Matrix], at_zero: Mapping[Expr, Integer]
) -> tuple[Assignments, Matrix, Assignments]:
    """Names for what vectors are at z = 0, where a residual reads it: assigned, and put into it.

    Then the assignments of the components of these vectors, from the names.
    """
    names, found, later = dict[Expr, Symbol](), Assignments(), Assignments()
    for s, e in moved.items():
        known = e.subs(at_zero)
        stars = w.components(Symbol(f"{s.name[0]}_*star{len(names) or ''}"))
        read = [k for k, x in enumerate(known) if x.is_Add and still.has(x)]
        names |= {known[k]: stars[k] for k in read}
        found += [(stars[k], w.hoist(known[k])) for k in read]
        named = Matrix([x - known[k] + stars[k] if k in read else x for k, x in enumerate(e)])
        later += assign(w.components(s), w.hoisted(named))
    return found, still.xreplace(names), later


def _rate_force(w: Writer, speed: Matrix, z: Matrix) -> tuple[Matrix, Matrix]:
    """The force of laws of the rate at the velocity of the damping force, and its derivative by z."""
    rates = dict(zip(w.motion.scene.rates, w.hoisted(speed), strict=True))
    force = w.motion.rate_force.xreplace(rates)
    return force, force.jacobian(z)


def _displacement(balance: Balance) -> Expr:
    """The displacement that the balance takes the internal force at, of a linear one."""
    return balance.force.replace(N, lambda u: u).replace(N_discrete, lambda u0, u1: (u0 + u1) / 2)


def _elastic(w: Writer, stage: Stage, reach: Reach) -> Matrix:
    """The derivative by z of the internal force before any law is strained."""
    displacement = _displacement(stage.balances[0])
    tangent = w.motion.tangent_at_start([Integer(0)] * w.size)
    total = zeros(w.size)
    for s, (c_u,) in reach.items():
        total += displacement.diff(s) * c_u * tangent
    return total


def _per_mass(motion: EquationsOfMotion) -> list[Expr]:
    """1/mass for each row of a balance, which spares a product in every iteration; 1 if a mass may be zero."""
    sure = {p.symbol: Dummy(positive=True) for p in motion.scene.parameters if p.domain.is_subset(POSITIVE)}
    masses = [e.subs(sure) for e in motion.mass.diagonal()]
    if motion.mass != diag(*motion.mass.diagonal()) or not all(e.is_positive for e in masses):
        return [Integer(1)] * len(masses)
    return [1 / e for e in motion.mass.diagonal()]


def _scaled(w: Writer, factors: list[Expr], matrix: Matrix) -> Matrix:
    """The matrix with each row multiplied by its factor."""
    return Matrix(matrix.rows, matrix.cols, lambda i, j: _distributed(w, factors[i], matrix[i, j]))


def _distributed(w: Writer, factor: Expr, e: Expr) -> Expr:
    """factor*e; multiplied into a sum if each term has a constant, with which the factor is combined once a run."""
    terms = Add.make_args(e)
    known = [any(not a.is_number and a.free_symbols <= w.fixed for a in Mul.make_args(term)) for term in terms]
    return Add(*(factor * term for term in terms)) if all(known) else factor * e


def _moving_force(w: Writer, stage: Stage, reach: Reach) -> tuple[Assignments, Matrix, Matrix, Matrix]:
    """Mixed displacements that depend on z; forces that depend on z and that do not; the former's derivative by z."""
    given = [balance.force for balance in stage.balances]
    arguments = sorted(
        {a for e in given for atom in e.atoms(N, N_discrete) for a in atom.args if not a.is_Symbol}, key=str
    )
    names = {a: Symbol(f"u_*mix{k}") for k, a in enumerate(a for a in arguments if a.free_symbols & stage.moved)}
    w.instants |= {name: instant_of(a, w.instants) for a, name in names.items()}
    given = [e.subs(names) for e in given]
    follows = {*stage.moved, *names.values()}
    known = [e.subs({a: 0 for a in e.atoms(N, N_discrete) if a.free_symbols & follows}) for e in given]
    forces = Matrix.vstack(*(w.vector(e - rest) for e, rest in zip(given, known, strict=True)))
    by_z = zeros(len(forces))
    for s, by_own in reach.items():
        by_s = forces.jacobian(w.components(s))
        for a, name in names.items():
            by_s += forces.jacobian(w.components(name)) * w.vector(a).jacobian(w.components(s))
        by_z += Matrix.hstack(*(by_s.applyfunc(lambda e, c=c: _distributed(w, c, e)) for c in by_own))
    mixed = [both for a, name in names.items() for both in assign(w.components(name), w.hoisted(w.vector(a)))]
    return mixed, forces, Matrix.vstack(*map(w.vector, known)), by_z
