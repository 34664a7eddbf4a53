"""Scene -> EquationsOfMotion: equations of motion, tangent, invariants and discrete gradient, from the energies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from sympy import Dummy, Expr, Integer, Matrix, Symbol, cancel, diag, factor, powdenest, simplify, sqrt, sympify, zeros

from ..declare.errors import DeclarationError
from ..declare.law import Element, e_dot, elapsed, slope
from ..declare.potentials import contact, tidy
from ..declare.scene import POSITIVE, Scene
from ..declare.symbols import rate, sampled, t
from .differences import discrete_slopes

DISSIPATED = Symbol("dissipated")  # the energy that the laws of a scene have dissipated


@dataclass(frozen=True)
class EquationsOfMotion:
    """mass a + damping v + force(u) + rate_force(u, v) = load(t), derived from one scene.

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
    def mass(self) -> Matrix:
        """Mass matrix (d, d), constant."""
        return self._hessian(self.scene.kinetic)

    @cached_property
    def damping(self) -> Matrix:
        """Damping matrix (d, d), constant."""
        return self._hessian(self.scene.dissipation)

    def _hessian(self, energy: Expr) -> Matrix:
        return Matrix([energy]).jacobian(self.scene.rates).jacobian(self.scene.rates)

    @cached_property
    def invariants(self) -> dict[Symbol, Expr]:
        """The declared invariants, and those coordinates on which the potential depends directly."""
        potential = tidy(self.scene.potential)
        own = {q: q for q in self.coordinates if potential.has(q)}
        return {**self.scene.invariants, **own}

    @cached_property
    def potential(self) -> Expr:
        """The potential without its part that depends on time, which is a load; in the invariants.

        Raises DeclarationError if that part is not linear in the coordinates: the tangent stiffness would
        depend on time.
        """
        V = tidy(self.scene.potential)
        driven = (V - V.subs(t, 0)).expand() if V.has(t) else Integer(0)
        if any(driven.diff(q, p).expand() != 0 for q in self.invariants for p in self.invariants):
            raise DeclarationError(
                f"{self.scene.name}: expected time in the potential only in terms linear in the coordinates, "
                f"got {driven}; the tangent must not depend on time"
            )
        return V.subs(t, 0) if V.has(t) else V

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
                total += along * element.expression(element.law.trial, symbols).subs(e_dot, speed)
        return total

    @cached_property
    def rate_force(self) -> Matrix:
        """The force of laws that depend on the rates of the coordinates."""
        return self._of_laws(of_rate=True)

    @cached_property
    def _force(self) -> Matrix:
        """Internal force by the chain rule through the invariants, which keeps it short."""
        gradient = [self.potential.diff(q) for q in self.invariants]
        slopes = [contact(factor(g)) for g in gradient]
        return Matrix(
            [
                sum(
                    (
                        s.subs(self.invariants) * e.diff(x)
                        for s, e in zip(slopes, self.invariants.values(), strict=True)
                    ),
                    Integer(0),
                )
                for x in self.coordinates
            ]
        ) + self._of_laws(of_rate=False)

    def force(self, u: Sequence[Expr]) -> Matrix:
        """Internal force N at the displacement u."""
        return self._force.subs(dict(zip(self.coordinates, u, strict=True)), simultaneous=True)

    @cached_property
    def _tangent(self) -> Matrix:
        return (self._force - self._of_laws(of_rate=False)).jacobian(self.coordinates) + self._tangent_of_laws

    @cached_property
    def _tangent_of_laws(self) -> Matrix:
        """The slope of their force at the coordinates, by branch."""
        return Matrix([[slope(x, q) for q in self.coordinates] for x in self._of_laws(of_rate=False)])

    @cached_property
    def constraints(self) -> Matrix:
        """What constraints keep at 0, (c, 1)."""
        return Matrix([tidy(g).subs(self.scene.invariants) for g in self.scene.constraints.values()])

    @cached_property
    def directions(self) -> Matrix:
        """The derivatives (c, d) of the constraints by the coordinates."""
        return self.constraints.jacobian(self.coordinates)

    def constraints_at(self, u: Sequence[Expr], at: Expr) -> Matrix:
        """What constraints keep at 0, at the displacement u and the time `at`."""
        return self.constraints.subs({t: at, **dict(zip(self.coordinates, u, strict=True))}, simultaneous=True)

    def directions_at(self, u: Sequence[Expr], at: Expr) -> Matrix:
        """Their derivatives (c, d) there; the transposed times the multipliers is a force, as `force` has it."""
        return self.directions.subs({t: at, **dict(zip(self.coordinates, u, strict=True))}, simultaneous=True)

    def discrete_directions(self, u0: Sequence[Symbol], u1: Sequence[Symbol]) -> Matrix:
        """Discrete gradients (c, d) of the constraints between two displacements: see `discrete_gradient`.

        Raises DeclarationError for a constraint that holds the time, which has none.
        """
        rows = []
        for name, g in self.scene.constraints.items():
            if g.has(t):
                raise DeclarationError(
                    f"{self.scene.name}: expected constraint {name} without time, for a scheme that takes forces as "
                    f"discrete gradients, got {g}; take another scheme"
                )
            alone = replace(self.scene, potential=g, constraints={}, laws={})
            rows.append(EquationsOfMotion(alone).discrete_gradient(u0, u1).T)
        return Matrix.vstack(*rows)

    @cached_property
    def drift(self) -> tuple[Matrix, Matrix]:
        """The first time derivative (c, 1) of the constraints, and of the second what holds no acceleration."""
        along = [*zip(self.coordinates, self.scene.rates, strict=True), (t, Integer(1))]

        def rate_of(e: Expr) -> Expr:
            return sum((e.diff(q) * v for q, v in along), Integer(0))

        first = self.constraints.applyfunc(rate_of)
        return first, first.applyfunc(rate_of)

    @cached_property
    def constrained(self) -> tuple[Matrix, Matrix]:
        """The matrix (d + c, d + c) and the right side of the equations for acceleration and multipliers.

        They are the equation of motion, and the second time derivative of the constraints.
        """
        c = self.constraints.rows
        rest = self.load - self.damping * Matrix(self.scene.rates) - self._force - self.rate_force
        matrix = Matrix.vstack(Matrix.hstack(self.mass, self.directions.T), Matrix.hstack(self.directions, zeros(c, c)))
        return matrix, Matrix.vstack(rest, -self.drift[1])

    def tangent_at_start(self, u: Sequence[Expr]) -> Matrix:
        """Tangent stiffness at the displacement u, of laws that of their start, before they are strained."""
        unstrained = {**self.memory, **dict.fromkeys(self.coordinates, 0), elapsed: 0}
        sure = {p.symbol: Dummy(positive=True) for p in self.scene.parameters if p.domain.is_subset(POSITIVE)}
        first = self._tangent_of_laws.subs(unstrained, simultaneous=True).subs(sure)
        first = first.subs({dummy: s for s, dummy in sure.items()})
        return (self.tangent(u) - self._tangent_of_laws.subs(dict(zip(self.coordinates, u, strict=True)))) + first

    def tangent(self, u: Sequence[Expr]) -> Matrix:
        """Tangent stiffness at the displacement u."""
        return self._tangent.subs(dict(zip(self.coordinates, u, strict=True)), simultaneous=True)

    @property
    def linear(self) -> bool:
        """Whether the force is linear in the coordinates, without memory, and in the rates."""
        return not (self.scene.laws or self.scene.constraints) and not self._tangent.free_symbols & set(
            self.coordinates
        )

    @cached_property
    def oscillator(self) -> tuple[Expr, Expr, Expr] | None:
        """(omega, xi, mass) of a linear scene of one coordinate with a stiffness; None of any other."""
        if len(self.coordinates) > 1 or not self.linear or self._tangent[0] == 0 or self.load.has(t):
            return None
        mass, damping, stiffness = self.mass[0], self.damping[0], self._tangent[0]
        omega = powdenest(sqrt(stiffness / mass), force=True)
        return omega, cancel(damping / (2 * mass * omega)), mass

    @cached_property
    def load(self) -> Matrix:
        """The load as a function of t and of `sampled`: the declared one, and that of a prescribed motion."""
        V = tidy(self.scene.potential)
        moving = (V - V.subs(t, 0)).subs(self.invariants).expand() if V.has(t) else Integer(0)
        return Matrix([sympify(self.scene.load.get(q, 0)) - moving.diff(q) for q in self.coordinates])

    @property
    def is_sampled(self) -> bool:
        """Whether the user gives the load as a function of time."""
        return self.load.has(sampled)

    def discrete_gradient(self, u0: Sequence[Symbol], u1: Sequence[Symbol]) -> Matrix:
        """Simo & Tarnow (1992), Gonzalez (1996): N with N.(u1 - u0) = V(u1) - V(u0), formed in the invariants.

        An invariant is at most quadratic, so its own discrete gradient is the gradient at the midpoint;
        angular momentum is conserved because |u|^2 enters as one invariant.
        """
        at = [dict(zip(self.coordinates, u, strict=True)) for u in (u0, u1)]
        old, new = ({q: e.subs(where, simultaneous=True) for q, e in self.invariants.items()} for where in at)
        slopes = discrete_slopes(self.potential, old, new)
        middle = {q: (a + b) / 2 for q, a, b in zip(self.coordinates, u0, u1, strict=True)}
        return Matrix(
            [
                sum(
                    (slopes[q] * e.diff(x).subs(middle, simultaneous=True) for q, e in self.invariants.items()),
                    Integer(0),
                )
                for x in self.coordinates
            ]
        )

    @cached_property
    def energy(self) -> Expr:
        """Kinetic energy, potential, and what laws have stored; in coordinates, rates, t and the memory committed."""
        stored = (element.expression(element.law.stored, symbols) for element, symbols in self._laws)
        return sum(stored, self.scene.kinetic + tidy(self.scene.potential).subs(self.scene.invariants))

    @cached_property
    def angular_momentum(self) -> Expr | None:
        """Noether's invariant of a rotation that leaves both energies as they are; None if there is none.

        For two coordinates the rotation of their plane, for a single one that is an angle its shift.
        """
        q, v = self.coordinates, self.scene.rates
        V = tidy(self.scene.potential).subs(self.scene.invariants)
        momenta = self.mass * Matrix(v)
        if len(q) == 1:
            return momenta[0] if self.scene.coordinates[q[0]] == "rad" and not V.has(q[0]) else None
        if len(q) == 2:
            torque = q[0] * V.diff(q[1]) - q[1] * V.diff(q[0])
            isotropic = self.mass == diag(self.mass[0, 0], self.mass[0, 0])
            if isotropic and simplify(torque) == 0:
                return q[0] * momenta[1] - q[1] * momenta[0]
        return None

    @property
    def outputs(self) -> dict[str, Expr]:
        """The scene's named outputs, and the force of each law, as functions of the coordinates, rates and memory."""
        several = len(self.scene.laws) > 1
        found = {name: e.subs(self.scene.invariants) for name, e in self.scene.outputs.items()}
        for (name, element), (_, speed) in zip(self.scene.laws.items(), self.elongations, strict=True):
            force = element.expression(element.law.trial, self.scene.memory_of[name]).subs(e_dot, speed)
            found[f"{name}_force" if several else "force"] = force
        return found

    @cached_property
    def consistent_acceleration(self) -> Matrix:
        """The acceleration that the equation of motion gives for coordinates, rates and t."""
        rest = self.load - self.damping * Matrix(self.scene.rates) - self._force - self.rate_force
        return (self.mass.inv() * rest).applyfunc(cancel) if self.linear else self.mass.inv() * rest
