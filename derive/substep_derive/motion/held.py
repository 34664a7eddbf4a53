"""Scene -> Held: what its reactions hold, in its coordinates and their rates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from sympy import Expr, Integer, Matrix

from ..declare.potentials import tidy
from ..declare.scene import Scene
from ..declare.symbols import t


@dataclass(frozen=True)
class Held:
    """Expressions of a scene whose derivatives by the coordinates, times the multipliers, are its reactions.

    They are what constraints keep at 0, minus the gaps of contacts, and what slides under friction: pressures then act
    against closing, and frictions against sliding. All are on the side of the forces of the motion's equations. Of a
    constraint that holds rates, the derivatives by these take the place of those by the coordinates.
    """

    scene: Scene

    @cached_property
    def by_name(self) -> Mapping[str, Expr]:
        """The expressions as they are declared, but for the sign of gaps."""
        gaps = {name: -contact.gap for name, contact in self.scene.contacts.items()}
        constraints = {name: constraint.expression for name, constraint in self.scene.constraints.items()}
        return {**constraints, **gaps, **{name: x.along for name, x in self.scene.frictions.items()}}

    @cached_property
    def of_rates(self) -> tuple[bool, ...]:
        """For each of them whether it holds rates."""
        return tuple(bool(g.free_symbols & set(self.scene.rates)) for g in self.by_name.values())

    @cached_property
    def at_velocities(self) -> tuple[bool, ...]:
        """For each of them whether it is held as a velocity: it holds rates, or its derivative is what is held."""
        asked = {name for name, constraint in self.scene.constraints.items() if constraint.level == "velocity"}
        return tuple(rates or name in asked for name, rates in zip(self.by_name, self.of_rates, strict=True))

    @cached_property
    def at_both(self) -> tuple[int, ...]:
        """The places of those that are held at displacements and at velocities."""
        given = enumerate(self.scene.constraints.values())
        return tuple(k for k, constraint in given if constraint.level == "both" and not self.of_rates[k])

    @cached_property
    def _written(self) -> Matrix:
        return Matrix(len(self.by_name), 1, [tidy(g).subs(self.scene.invariants) for g in self.by_name.values()])

    @cached_property
    def expressions(self) -> Matrix:
        """The same (c, 1), in coordinates and time; 0 for one that holds rates."""
        pairs = zip(self._written, self.of_rates, strict=True)
        return Matrix(len(self.by_name), 1, [Integer(0) if of_rates else e for e, of_rates in pairs])

    @cached_property
    def directions(self) -> Matrix:
        """Their derivatives (c, d) by the coordinates, or by the rates."""
        by_rates = self._written.jacobian(list(self.scene.rates))
        return self.expressions.jacobian(list(self.scene.coordinates)) + by_rates

    @cached_property
    def drift(self) -> tuple[Matrix, Matrix]:
        """Their first time derivatives (c, 1), or they themselves, and of the next what holds no acceleration."""
        along = [*zip(self.scene.coordinates, self.scene.rates, strict=True), (t, Integer(1))]

        def rate_of(e: Expr) -> Expr:
            return sum((e.diff(q) * v for q, v in along), Integer(0))

        pairs = zip(self._written, self.of_rates, strict=True)
        first = Matrix(len(self.by_name), 1, [e if of_rates else rate_of(e) for e, of_rates in pairs])
        return first, first.applyfunc(rate_of)

    def at(self, matrix: Matrix, u: Sequence[Expr], v: Sequence[Expr], at: Expr) -> Matrix:
        """A matrix of expressions in coordinates, rates and time, at a displacement, a velocity and a time."""
        given = dict(zip((*self.scene.coordinates, *self.scene.rates, t), (*u, *v, at), strict=True))
        return matrix.xreplace(given)

    def directions_at(self, u: Sequence[Expr], at: Expr) -> Matrix:
        """The derivatives (c, d) there; the transposed times the multipliers is a force on the side of all others."""
        return self.at(self.directions, u, [Integer(0)] * len(u), at)
