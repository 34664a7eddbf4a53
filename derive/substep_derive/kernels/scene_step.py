"""Scheme x Scene -> SceneStep: what a step computes, component by component, and nothing the scene does not need.

Every balance is solved for its new acceleration z. Its displacement is p + c_u z with p the predictor. So
a linear scene or an explicit balance needs only the constant matrix c_a M + c_v C + c_u K, inverted once a run;
Newton's iteration is needed for a nonlinear force that depends on z.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from sympy import Abs, Add, Dummy, Expr, Integer, Matrix, Mul, Ne, Piecewise, S, Symbol, diag, oo, symbols, zeros

from ..declare.errors import DeclarationError
from ..declare.names import entry_name
from ..declare.scene import POSITIVE
from ..declare.scheme import Scheme
from ..declare.symbols import N, N_discrete, knot, knot_of, lattice, successor, t
from ..motion.components import STEP, Assignments, Writer, assign
from ..motion.differences import Difference, DifferenceSlope
from ..motion.equations import EquationsOfMotion
from ..step.step import Stage, Step, instants
from .near_series import NearSeries


@dataclass(frozen=True)
class BalanceStep:
    """One balance as the kernel computes it; vectors and matrices have a row for each coordinate.

    z: the unknown acceleration. before: assignments made once a step. moving: those that depend on z and are repeated
    in every Newton iteration. residual: of the balance, a function of what before and moving assign. jacobian: its
    derivative with respect to z. first: the z from which the iteration starts. reach: c_u, the derivative of the
    displacement with respect to z. after: assignments once z is known. A balance without iteration has first = None,
    and z = -inverse * residual with a constant inverse. free: the residual's derivative by z without internal force.
    """

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

    @property
    def residual_names(self) -> Matrix:
        """The names that the residual's components have in the kernel."""
        return Matrix(symbols(f"residual_:{len(self.z)}"))

    @property
    def jacobian_names(self) -> Matrix:
        """The names that the Jacobian's entries have in the kernel; 0 for an entry that is 0."""
        names = [[Symbol(entry_name("jacobian_", i, j)) for j in range(len(self.z))] for i in range(len(self.z))]
        return Matrix(names).multiply_elementwise(self.jacobian.applyfunc(lambda e: Integer(int(e != 0))))

    def filtered(self, error: Matrix) -> Matrix:
        """The error times free over the effective mass: bounded where a component is stiff, and equal for small steps.

        Shampine & Baca, Appl. Numer. Math. 1 (1985) 495-506; with the Jacobian of the last iteration, if there is one.
        """
        if self.first is None:
            return self.inverse * self.free * error
        J = self.jacobian_names
        if len(self.z) == 1:
            return self.free * error / J[0]
        return J.adjugate() * (self.free * error) * Symbol("one_over_det")

    def correction(self, factor: Expr = S.One) -> tuple[Assignments, Assignments, Matrix]:
        """Assignments of residual and Jacobian; the solve, written out; Newton's correction, times factor, by name."""
        size, R, J = len(self.z), self.residual_names, self.jacobian_names
        entries = assign(R, self.residual) + [(s, e) for s, e in zip(J, self.jacobian, strict=True) if e != 0]
        change, one_over = Matrix(symbols(f"change_:{size}")), Symbol("one_over_det")
        if size == 1:
            return entries, assign(change, factor * R / J[0]), change
        solve = assign(Matrix([one_over, *change]), Matrix([factor / J.det(), *(J.adjugate() * R * one_over)]))
        return entries, solve, change


@dataclass(frozen=True)
class Start:
    """The state at t = 0 from u_0, v_0, a_0 and the loads at the stencil; a column for each symbol of the state."""

    constants: Assignments
    state: Matrix
    stencil: tuple[Expr, ...]


@dataclass(frozen=True)
class SceneStep:
    """A step of the scheme on the scene.

    constants: assignments made once a run, in order. prior: assignments before the first balance. shift: component
    of the state -> its successor, oldest first. report: components of u, v and, where the scheme has its own, a at
    t_n + h; reported: the assignments that compute them. energy: that of the reported u, v. stencil: instants of the
    load, in steps after t_n. start: None where another scheme marches first. errors: components of the estimated local
    errors, where they were asked for.
    """

    scheme: Scheme
    motion: EquationsOfMotion
    constants: Assignments
    prior: Assignments
    steps: tuple[BalanceStep, ...]
    shift: Assignments
    reported: Assignments
    report: tuple[Matrix, ...]
    energy: Expr
    stencil: tuple[Expr, ...]
    start: Start | None
    errors: tuple[Matrix, ...] = ()

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
    ) -> "SceneStep":
        """now: the time t_n, by default i*h. errors: linear in knots' symbols; weights: numbers that they contain.

        read: further symbols of the step that have to be computed.

        Raises DeclarationError for coefficients that are no matrices of the scene, or a scene with damping that the
        scheme does not take.
        """
        damped = not motion.damping.is_zero_matrix
        if damped and not scheme.takes_damping:
            raise DeclarationError(
                f"{scheme.name} is a scheme for u'' = g(t, u): expected a scene without damping, got "
                f"{motion.scene.name}; take another scheme, or declare the scene without dissipation"
            )
        near = scheme.in_doubles
        lowered = Step.of(near)
        prior, found, outputs = lowered.prior, lowered.stages, lowered.outputs
        stencil = instants([*(b.load for b in near.balances), *outputs], near.typical)
        w = Writer(near, motion, stencil, now=now)
        w.fixed.update(weights)
        wanted = _wanted(near, prior, found, [*outputs, *errors, *read], damped=damped)
        known = _assigned(w, {s: e for s, e in prior.items() if s in wanted})
        last, steps = knot(0).u, []
        for stage in found:
            steps.append(_step(w, stage, last, wanted))
            last = next(iter(stage.moved), last)
        oldest_first = sorted(near.state, key=lambda s: lattice((knot_of(s) or ("", "0"))[1]) or 0)
        shift = [both for s in oldest_first for both in assign(w.components(s), w.components(successor(s)))]
        report, assigned = [], []
        for e, kind in zip(outputs, "uva", strict=False):
            vector = w.hoisted(w.vector(e))
            names = vector if e.is_Symbol else w.components(Symbol(f"{kind}_*reported"))
            assigned += [] if e.is_Symbol else assign(names, vector)
            report.append(names)
        at = dict(zip((*motion.coordinates, *motion.scene.rates), (*report[0], *report[1]), strict=True))
        energy = w.hoist(motion.energy.subs({**at, t: w.instant(Integer(1))}, simultaneous=True))
        estimates = [w.vector(e) for e in errors]
        for stage, step in list(zip(found, steps, strict=True))[::-1]:
            if stage.c_u != 0:  # the last implicit balance
                estimates = [step.filtered(e) for e in estimates]
                break
        estimates = tuple(w.hoisted(e) for e in estimates)
        return cls(
            scheme, motion, w.constants, known, tuple(steps), shift, assigned, tuple(report), energy, stencil,
            _start(scheme, motion) if scheme.start_scheme is None else None, estimates,
        )  # fmt: skip

    @property
    def expressions(self) -> list[Expr]:
        """Every expression that a run computes, except those of its start."""
        lists = [self.constants, self.prior, self.reported]
        lists += [a for s in self.steps for a in (s.before, s.moving, s.after)]
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
    def newton(self) -> bool:
        """Whether any balance iterates."""
        return any(step.first is not None for step in self.steps)


def _start(scheme: Scheme, motion: EquationsOfMotion) -> Start:
    scheme = scheme.in_doubles
    expressions = Step.of(scheme).start
    assert expressions is not None
    stencil = instants(expressions, scheme.typical)
    w = Writer(scheme, motion, stencil)
    state = Matrix.hstack(*(w.hoisted(w.vector(e).subs(STEP, 0)) for e in expressions))
    return Start(w.constants, state, stencil)


def _wanted(
    scheme: Scheme, prior: Mapping[Symbol, Expr], found: Sequence[Stage], outputs: Iterable[Expr], *, damped: bool
) -> set[Symbol]:
    """Symbols of the new step that a balance, the next step or the report reads; damped: the scene has damping."""
    wanted = {s for e in outputs for s in e.free_symbols} | {successor(s) for s in scheme.state}
    for stage in found:
        own, balance = {*stage.in_z, stage.z}, stage.balance
        read = {s for e in (*stage.in_z.values(), balance.inertia, balance.force) for s in e.free_symbols}
        read |= balance.damping.free_symbols if damped else set()
        wanted |= {s for s in read - own if knot_of(s)}
    for e in prior.values():
        wanted |= {s for s in e.free_symbols if knot_of(s)}
    return wanted


def _assigned(w: Writer, expressions: dict[Symbol, Expr]) -> Assignments:
    """Assignments of the components of symbols, each from its expression."""
    return [both for s, e in expressions.items() for both in assign(w.components(s), w.hoisted(w.vector(e)))]


def predicted(k: int) -> Symbol:
    """Symbol of a balance's predictor, a displacement at z = 0; k counts them where a force takes two displacements."""
    return Symbol(f"u_*star{k or ''}")


def _step(w: Writer, stage: Stage, last: Symbol, wanted: set[Symbol]) -> BalanceStep:
    """One balance; it is iterated if its force depends on z and is nonlinear."""
    z = w.components(stage.z)
    at_zero = dict.fromkeys(z, Integer(0))

    def solved(e: Expr) -> Matrix:
        return w.vector(e.subs(stage.in_z, simultaneous=True))

    inertia = w.motion.mass * solved(stage.balance.inertia) + w.motion.damping * solved(stage.balance.damping)
    still = inertia.subs(at_zero) - w.vector(stage.balance.load)  # the residual at z = 0, without the internal force
    slope = free = inertia.jacobian(z)  # the residual's derivative by z, without that of the internal force
    moved = sorted(stage.moved, key=str)
    reach: dict[Symbol, Expr] = {}
    before: Assignments = []
    after: Assignments = []
    for k, s in enumerate(moved):
        whole, predictor = w.hoisted(solved(s)), w.components(predicted(k))
        reach[s] = whole[0].diff(z[0])
        before += assign(predictor, whole.subs(at_zero))
        after += assign(w.components(s), predictor + reach[s] * z)
    reached = list(after)
    after += _assigned(w, {s: e for s, e in stage.in_z.items() if s in wanted and s not in reach})
    if stage.c_u == 0 or w.motion.linear:
        force = stage.balance.force.subs({s: predicted(k) for k, s in enumerate(moved)})
        displacement = stage.balance.force.replace(N, lambda u: u).replace(N_discrete, lambda u0, u1: (u0 + u1) / 2)
        for s, c_u in reach.items():
            slope = slope + displacement.diff(s) * c_u * w.motion.tangent([Integer(0)] * w.size)
        residual = w.hoisted(still + w.vector(force))
        return BalanceStep(z, before, [], residual, slope, w.inverse(slope), None, Integer(0), after, free)
    mixed, forces, known, by_z = _moving_force(w, stage, reach)
    per_mass = _per_mass(w.motion)
    slope, forces, by_z, still = (_scaled(w, per_mass, matrix) for matrix in (slope, forces, by_z, still + known))
    rest = w.hoisted(still)
    residual = slope * z + forces
    if any(e != 0 for e in rest):
        before += assign(w.components(Symbol("r")), rest)
        residual += w.components(Symbol("r"))
    unknown, c_u = next(iter(reach.items()))
    one_over = w.reciprocal(solved(unknown)[0].diff(z[0]), c_u)
    first = (w.components(last) - w.components(predicted(0))) * one_over
    return BalanceStep(
        z, before, reached + mixed, w.hoisted(residual), w.hoisted(slope + by_z), Matrix(), first, c_u, after, slope
    )


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


def _moving_force(w: Writer, stage: Stage, reach: dict[Symbol, Expr]) -> tuple[Assignments, Matrix, Matrix, Matrix]:
    """Mixed displacements that depend on z; forces that depend on z and that do not; the former's derivative by z."""
    force = stage.balance.force
    arguments = sorted({a for atom in force.atoms(N, N_discrete) for a in atom.args if not a.is_Symbol}, key=str)
    names = {a: Symbol(f"u_*mix{k}") for k, a in enumerate(a for a in arguments if a.free_symbols & stage.moved)}
    force = force.subs(names)
    follows = {*stage.moved, *names.values()}
    known = force.subs({a: 0 for a in force.atoms(N, N_discrete) if a.free_symbols & follows})
    forces = w.vector(force - known)
    by_z = zeros(w.size)
    for s, c_u in reach.items():
        by_s = forces.jacobian(w.components(s))
        for a, name in names.items():
            by_s += forces.jacobian(w.components(name)) * w.vector(a).jacobian(w.components(s))
        by_z += by_s.applyfunc(lambda e, c_u=c_u: _distributed(w, c_u, e))
    mixed = [both for a, name in names.items() for both in assign(w.components(name), w.hoisted(w.vector(a)))]
    return mixed, forces, w.vector(known), by_z
