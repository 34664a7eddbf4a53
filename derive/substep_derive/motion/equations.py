"""Scene -> EquationsOfMotion: Lagrange's equations, tangent and invariants, from the energies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from sympy import (
    Add,
    Dummy,
    Expr,
    Integer,
    Matrix,
    Symbol,
    cancel,
    diag,
    factor,
    factor_terms,
    nan,
    oo,
    powdenest,
    sqrt,
    sympify,
    trigsimp,
    zeros,
    zoo,
)

from ..declare.law import Element, e_dot, elapsed
from ..declare.parameter import POSITIVE, signed
from ..declare.potentials import abs_power, contact, may_jump, tidy
from ..declare.scene import Scene
from ..declare.symbols import rate, sampled, t
from .held import Held
from .momenta import Momentum, momenta
from .rate_terms import parts

INVERTED = 4  # coordinates of a mass whose inverse is written out; of more, its system is solved
DISSIPATED = Symbol("dissipated")  # the energy that the laws of a scene have dissipated


@dataclass(frozen=True)
class EquationsOfMotion:
    """mass a + damping v + force(u) + rate_force(u, v) = load(t), derived from one scene.

    Where it is `general`, mass may depend on u and t, force and rate_force on t, and there is no constant damping if
    forces depend on the rates in any other way.

    Where the scene has laws with memory, the force is that at u from the memory last committed, whose symbols are those
    of `memory`; `commit` is what the memory becomes when it is committed at u.
    """

    scene: Scene

    @cached_property
    def in_kernels(self) -> "EquationsOfMotion":
        """The same with parameters named as kernels print them."""
        return EquationsOfMotion(self.scene.in_kernels)

    @property
    def coordinates(self) -> tuple[Symbol, ...]:
        """The coordinates' symbols."""
        return tuple(self.scene.coordinates)

    @cached_property
    def kinetic(self) -> Expr:
        """The declared kinetic energy, its squares of sines and cosines joined where that makes the mass constant."""
        T = self.scene.kinetic
        if not self._hessian(T).free_symbols & set(self.coordinates):
            return T
        factors = dict[Expr, Expr]()  # of each product of rates; joining all of them at once takes much longer
        for term in Add.make_args(T.expand()):
            e, rates = term.as_independent(*self.scene.rates, as_Add=False)
            factors[rates] = factors.get(rates, Integer(0)) + e
        return Add(*((trigsimp(e) * rates).expand() for rates, e in factors.items()))

    @cached_property
    def mass(self) -> Matrix:
        """Mass matrix (d, d)."""
        return self._hessian(self.kinetic)

    @cached_property
    def mass_moves(self) -> bool:
        """Whether the mass matrix depends on coordinates or time."""
        return bool(self.mass.free_symbols & {*self.coordinates, t})

    @cached_property
    def general(self) -> bool:
        """Whether the equations of motion are taken at knots: they move, or have reactions."""
        return self.moves or bool(self.scene.multipliers)

    @cached_property
    def moves(self) -> bool:
        """Whether more than a constant mass, a constant damping, a force of the coordinates and a load of t is needed.

        Forces of laws that depend on rates alone apart, which are taken at the velocity that the damping is taken at.
        """
        moving = self.rate_force.free_symbols & set(self.coordinates) or not self._of_rates.is_zero_matrix
        return self.mass_moves or bool(moving) or self._force.has(t)

    @cached_property
    def of_rates(self) -> bool:
        """Whether any force but that of a constant damping depends on the rates of the coordinates."""
        return not self.rate_force.is_zero_matrix

    @cached_property
    def damped(self) -> bool:
        """Whether any force depends on the rates of the coordinates, but for friction."""
        return self.of_rates or not self.damping.is_zero_matrix

    @cached_property
    def bends_at_rest(self) -> bool:
        """Whether the slope of those forces by the rates has no bound where all rates are 0, as that of sqrt(|v|)."""
        v = self.scene.rates
        at_rest = [e.diff(r).subs(dict.fromkeys(v, 0)) for e in self.rate_force for r in v]
        powers = (power.args for e in at_rest for power in e.atoms(abs_power))
        return any(e.has(zoo, nan, oo) for e in at_rest) or any(x == 0 and not p.is_nonnegative for x, p in powers)

    def _hessian(self, energy: Expr) -> Matrix:
        return Matrix([energy]).jacobian(self.scene.rates).jacobian(self.scene.rates)

    @cached_property
    def _split(self) -> tuple[Expr, Expr]:
        """The parts of the kinetic energy that are linear in the rates, and without them."""
        T, v = self.kinetic, self.scene.rates
        at_rest = dict.fromkeys(v, Integer(0))
        linear = sum((T.diff(r).subs(at_rest) * r for r in v), Integer(0))
        return linear, T.subs(at_rest)

    @cached_property
    def _others(self) -> list[list[Expr]]:
        """For each coordinate the terms of all forces but those of the potential and of laws, on the left-hand side.

        That is d/dt of the momentum without mass * acceleration, minus the slope of the kinetic energy, that part of it
        aside which has no rates and acts as a potential; the slope of the dissipation; and minus the declared forces.
        """
        T = self.kinetic - self._split[1]
        found = list[list[Expr]]()
        for q, v in zip(self.coordinates, self.scene.rates, strict=True):
            momentum = T.diff(v)
            change = sum((momentum.diff(p) * r for p, r in zip(self.coordinates, self.scene.rates, strict=True)), 0 * v)
            inertial = factor_terms((change + momentum.diff(t) - T.diff(q)).expand())
            given = inertial, self.scene.dissipation.diff(v), -self.scene.forces.get(q, Integer(0))
            found.append([part for e in given for term in Add.make_args(e) for part in parts(term, self.scene.rates)])
        return found

    def of_terms(self, rates: bool, coordinates: bool) -> Matrix:
        """The sum of those terms that hold rates or, of the others, those that hold coordinates, or of the rest."""
        q, v = set(self.coordinates), set(self.scene.rates)
        rows = [
            [x for x in row if bool(x.free_symbols & v) == rates and (rates or bool(x.free_symbols & q) == coordinates)]
            for row in self._others
        ]
        return Matrix([sum(row, Integer(0)) for row in rows])

    @cached_property
    def damping(self) -> Matrix:
        """Damping matrix (d, d), constant; zeros where forces depend on the rates in any other way."""
        v, others = self.scene.rates, self.of_terms(True, False)
        found = Matrix([[e.diff(r) for r in v] for e in others])
        if found.free_symbols & {*self.coordinates, *v, t} or may_jump(others, v):
            return zeros(len(v))
        return found

    @cached_property
    def _of_rates(self) -> Matrix:
        """The forces that depend on the rates, laws aside, where no constant damping gives them."""
        found = self.of_terms(True, False)
        return zeros(*found.shape) if not self.damping.is_zero_matrix else found

    @cached_property
    def invariants(self) -> dict[Symbol, Expr]:
        """The declared invariants, and those coordinates on which the potential depends directly."""
        own = {q: q for q in self.coordinates if self._whole_potential.has(q)}
        return {**self.scene.invariants, **own}

    @cached_property
    def potential_energy(self) -> Expr:
        """The declared potential, in the coordinates."""
        return tidy(self.scene.potential).subs(self.scene.invariants)

    @cached_property
    def _whole_potential(self) -> Expr:
        """The potential, and minus the kinetic energy without rates, in the invariants."""
        return tidy(self.scene.potential) - self._split[1]

    @cached_property
    def _driven(self) -> Expr:
        """The potential's part that depends on time where that is linear in the coordinates, and so a load; else 0."""
        V, q = self._whole_potential, self.coordinates
        driven = (V - V.subs(t, 0)).subs(self.scene.invariants).expand() if V.has(t) else Integer(0)
        bends = any(may_jump(driven.diff(a), q) or driven.diff(a, b).expand() != 0 for a in q for b in q)
        return Integer(0) if bends or driven.has(nan, zoo, oo) else driven

    @cached_property
    def potential(self) -> Expr:
        """The potential in the invariants, without its part that is a load because it is linear in the coordinates."""
        V = self._whole_potential
        return V.subs(t, 0) if self._driven != 0 else V

    @cached_property
    def memory(self) -> dict[Symbol, Expr]:
        """What laws remember -> its value before they are strained; the energy that they have dissipated, last."""
        found = {
            own: element.expression(sympify(element.law.memory[s]), {})
            for element, symbols in self._laws
            for s, own in symbols.items()
        }
        return found | (
            {DISSIPATED: Integer(0)} if any(element.law.dissipated != 0 for element, _ in self._laws) else {}
        )

    @cached_property
    def commit(self) -> dict[Symbol, Expr]:
        """The memory committed at the coordinates, from that last committed, `elapsed` before."""
        found = {
            own: element.expression(element.law.update[s], symbols)
            for element, symbols in self._laws
            for s, own in symbols.items()
        }
        if DISSIPATED in self.memory:
            lost = (element.expression(element.law.lost, symbols) for element, symbols in self._laws)
            found[DISSIPATED] = sum(lost, DISSIPATED)
        return found

    @cached_property
    def _laws(self) -> list[tuple[Element, Mapping[Symbol, Symbol]]]:
        return [(element, self.scene.memory_of[name]) for name, element in self.scene.laws.items()]

    @property
    def elongations(self) -> list[tuple[Expr, Expr]]:
        """The elongation of each law, in the coordinates, and its rate, in these and their rates."""
        found = [element.elongation for element in self.scene.laws.values()]
        return [(x, sum((x.diff(q) * rate(q) for q in self.coordinates), Integer(0))) for x in found]

    def _of_laws(self, *, of_rate: bool) -> Matrix:
        """The force of the laws that depend on the rate of their elongation, or of the others."""
        total = zeros(len(self.coordinates), 1)
        for (element, symbols), (elongation, speed) in zip(self._laws, self.elongations, strict=True):
            if element.law.of_rate == of_rate:
                along = Matrix([elongation.diff(q) for q in self.coordinates])
                total += along * element.expression(element.law.trial, symbols).xreplace({e_dot: speed})
        return total

    @cached_property
    def rate_force(self) -> Matrix:
        """The force that depends on the rates of the coordinates, and of no constant damping: of laws, and others."""
        return self._of_laws(of_rate=True) + self._of_rates

    @cached_property
    def _force(self) -> Matrix:
        """Internal force: that of the potential, other forces of the coordinates, and laws, but none of rates."""
        return self._of_potential + self.of_terms(False, True) + self._of_laws(of_rate=False)

    @cached_property
    def _of_potential(self) -> Matrix:
        """By the chain rule through the invariants, which keeps it short."""
        slopes = [(contact(factor(self.potential.diff(q))), e) for q, e in self.invariants.items()]
        pairs = [(slope.subs(self.invariants), e) for slope, e in slopes]
        return Matrix([sum((slope * e.diff(x) for slope, e in pairs), Integer(0)) for x in self.coordinates])

    def force(self, u: Sequence[Expr]) -> Matrix:
        """Internal force N at the displacement u."""
        return self._force.xreplace(dict(zip(self.coordinates, u, strict=True)))

    def equation(self, u: Sequence[Expr], v: Sequence[Expr], at: Expr) -> tuple[Matrix, Matrix]:
        """Mass and all forces but the load at u, v and a time, of laws from the memory last committed."""
        given = dict(zip((*self.coordinates, *self.scene.rates, t), (*u, *v, at), strict=True))
        whole = self._force + self.damping * Matrix(self.scene.rates) + self.rate_force
        return self.mass.xreplace(given), whole.xreplace(given)

    @cached_property
    def _tangent(self) -> Matrix:
        of_forces = Matrix([[e.diff(q) for q in self.coordinates] for e in self.of_terms(False, True)])
        return self._of_potential.jacobian(self.coordinates) + of_forces + self._tangent_of_laws

    @cached_property
    def _tangent_of_laws(self) -> Matrix:
        """The slope of their force at the coordinates, by branch."""
        return Matrix([[x.diff(q) for q in self.coordinates] for x in self._of_laws(of_rate=False)])

    @cached_property
    def held(self) -> Held:
        """What reactions hold."""
        return Held(self.scene)

    @cached_property
    def constrained(self) -> tuple[Matrix, Matrix]:
        """The matrix (d + c, d + c) and the right side of the equations for acceleration and multipliers.

        They are the equation of motion, under the pressures of contacts that are remembered, and the second derivative
        of the constraints.
        """
        c = len(self.scene.constraints)
        along = self.held.directions[:c, :]
        matrix = Matrix.vstack(Matrix.hstack(self.mass, along.T), Matrix.hstack(along, zeros(c, c)))
        return matrix, Matrix.vstack(self._rest, -self.held.drift[1][:c, :])

    @property
    def _rest(self) -> Matrix:
        """All forces but those of constraints, on the right-hand side; remembered pressures by their symbols.

        Without what is not remembered, the acceleration is that between impacts, with nothing that slides.
        """
        rest = self.load - self.damping * Matrix(self.scene.rates) - self._force - self.rate_force
        c = len(self.scene.constraints)
        pressures = Matrix(list(self.scene.multipliers[c:]))
        return (
            rest
            if self.scene.impulsive or not self.scene.contacts
            else rest - self.held.directions[c:, :].T * pressures
        )

    def tangent_at_start(self, u: Sequence[Expr]) -> Matrix:
        """Tangent stiffness at the displacement u, of laws that of their start, before they are strained."""
        unstrained = {**self.memory, **dict.fromkeys(self.coordinates, 0), elapsed: 0}
        sure = {p.symbol: Dummy(positive=True) for p in self.scene.parameters if p.domain.is_subset(POSITIVE)}
        first = self._tangent_of_laws.subs(unstrained, simultaneous=True).subs(sure)
        first = first.subs({dummy: s for s, dummy in sure.items()})
        return (self.tangent(u) - self._tangent_of_laws.subs(dict(zip(self.coordinates, u, strict=True)))) + first

    def tangent(self, u: Sequence[Expr]) -> Matrix:
        """Tangent stiffness at the displacement u."""
        return self._tangent.xreplace(dict(zip(self.coordinates, u, strict=True)))

    @property
    def linear(self) -> bool:
        """Whether the force is linear in coordinates and rates, without memory, and the mass constant."""
        bends = self.scene.laws or self.general or may_jump(self._force, self.coordinates)
        return not (bends or self._tangent.free_symbols & set(self.coordinates))

    @cached_property
    def oscillator(self) -> tuple[Expr, Expr, Expr] | None:
        """(omega, xi, mass) of a linear scene of one coordinate, if it has a stiffness and at most a sampled load."""
        if len(self.coordinates) > 1 or not self.linear or self.load[0] not in (0, sampled):
            return None
        mass, damping, stiffness = self.mass[0], self.damping[0], self._tangent[0]
        at_rest = self._force.subs(dict.fromkeys(self.coordinates, 0))[0].expand()
        if at_rest != 0 or not signed(stiffness / mass, self.scene.parameters).is_nonnegative or stiffness == 0:
            return None
        omega = powdenest(sqrt(stiffness / mass), force=True)
        return omega, cancel(damping / (2 * mass * omega)), mass

    @cached_property
    def load(self) -> Matrix:
        """The load as a function of t and of `sampled`: declared, other forces of t alone, a prescribed motion's."""
        declared = Matrix([sympify(self.scene.load.get(q, 0)) - self._driven.diff(q) for q in self.coordinates])
        return declared - self.of_terms(False, False)

    @property
    def is_sampled(self) -> bool:
        """Whether the user gives the load as a function of time."""
        return self.load.has(sampled)

    @cached_property
    def energy(self) -> Expr:
        """Kinetic energy, potential, and what laws have stored; in coordinates, rates, t and the memory committed.

        Where neither holds time, that is the invariant of Lagrange's equations, T_2 - T_0 + V with T_k of degree k in
        the rates, which is T + V unless coordinates are relative to something that is moved.
        """
        T = self.kinetic
        if not self.of_time:
            T -= self._split[0] + 2 * self._split[1]
        stored = (element.expression(element.law.stored, symbols) for element, symbols in self._laws)
        return sum(stored, T + self.potential_energy)

    @property
    def of_time(self) -> bool:
        """Whether the kinetic energy or the potential holds the time, also in an invariant."""
        return self.kinetic.has(t) or self.potential_energy.has(t)

    @property
    def conserves(self) -> bool:
        """Whether the energy is constant on every motion, for forces that depend on rates those of inertia alone."""
        given = self.scene
        others = given.dissipation != 0 or given.forces or given.load or given.laws or given.frictions
        return not (others or self.of_time)

    @cached_property
    def momenta(self) -> list[Momentum]:
        """Noether's, of what leaves energies, laws, constraints and contacts as they are; none with one of rates."""
        if any(self.held.of_rates):
            return []
        others = [*self.held.expressions, *(x for x, _ in self.elongations)]
        return momenta(self.scene.coordinates, self.kinetic - self.potential_energy, others)

    @property
    def angular_momentum(self) -> Expr | None:
        """The first of `momenta` whose motion turns; None if there is none."""
        return next((p.expression for p in self.momenta if p.angular), None)

    @property
    def outputs(self) -> dict[str, Expr]:
        """The scene's named outputs, and the force of each law, as functions of the coordinates, rates and memory."""
        found = {name: e.subs(self.scene.invariants) for name, e in self.scene.outputs.items()}
        for (name, element), (_, speed) in zip(self.scene.laws.items(), self.elongations, strict=True):
            force = element.expression(element.law.trial, self.scene.memory_of[name]).xreplace({e_dot: speed})
            found[self.scene.output_of[name]] = force
        return found

    @cached_property
    def consistent_acceleration(self) -> Matrix:
        """The acceleration that the equation of motion gives for coordinates, rates and t."""
        if not self.mass_moves:
            return (self.mass.inv() * self._rest).applyfunc(cancel) if self.linear else self.mass.inv() * self._rest
        return solved(self.mass, self._rest)


def inverted(mass: Matrix) -> bool:
    """Whether what a mass matrix is inverted for is written out."""
    return mass.rows <= INVERTED or mass == diag(*mass.diagonal())


def solved(matrix: Matrix, right: Matrix) -> Matrix:
    """The solution of a linear system, written out."""
    if matrix == diag(*matrix.diagonal()):
        return Matrix([e / m for e, m in zip(right, matrix.diagonal(), strict=True)])
    return matrix.adjugate() * right / matrix.det()
