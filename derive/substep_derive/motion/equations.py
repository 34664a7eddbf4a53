"""Scene -> EquationsOfMotion: equations of motion, tangent, invariants and discrete gradient, from the energies."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from sympy import Expr, Integer, Matrix, Symbol, cancel, diag, factor, powdenest, simplify, sqrt, sympify

from ..declare.errors import DeclarationError
from ..declare.potentials import contact, tidy
from ..declare.scene import Scene
from ..declare.symbols import sampled, t
from .differences import discrete_slopes


@dataclass(frozen=True)
class EquationsOfMotion:
    """mass a + damping v + force(u) = load(t), derived from one scene."""

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
        )

    def force(self, u: Sequence[Expr]) -> Matrix:
        """Internal force N at the displacement u."""
        return self._force.subs(dict(zip(self.coordinates, u, strict=True)), simultaneous=True)

    @cached_property
    def _tangent(self) -> Matrix:
        return self._force.jacobian(self.coordinates)

    def tangent(self, u: Sequence[Expr]) -> Matrix:
        """Tangent stiffness at the displacement u."""
        return self._tangent.subs(dict(zip(self.coordinates, u, strict=True)), simultaneous=True)

    @property
    def linear(self) -> bool:
        """Whether the tangent stiffness is constant."""
        return not self._tangent.free_symbols & set(self.coordinates)

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
        """Kinetic energy and potential, in coordinates, rates and t."""
        return self.scene.kinetic + tidy(self.scene.potential).subs(self.scene.invariants)

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
        """The scene's named outputs as functions of the coordinates."""
        return {name: e.subs(self.scene.invariants) for name, e in self.scene.outputs.items()}

    @cached_property
    def consistent_acceleration(self) -> Matrix:
        """The acceleration that the equation of motion gives for coordinates, rates and t."""
        rest = self.load - self.damping * Matrix(self.scene.rates) - self._force
        return (self.mass.inv() * rest).applyfunc(cancel) if self.linear else self.mass.inv() * rest
