"""Modified equation x scene -> its terms in coordinates and rates, and how functions of these change."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import Any

from sympy import Expr, Integer, Matrix, lambdify, zeros

from ..algebra.algebraic import closed_form, generator
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.scene import Scene
from ..declare.scheme import Scheme
from ..declare.symbols import N_discrete, sampled
from ..motion.equations import EquationsOfMotion
from ..oscillator.evaluation import Evaluation
from ..step.step import Step
from .modified import ModifiedEquation, modified_equation
from .modified_energy import ModifiedEnergy, Scalar, Scalars, leading_loss, modified_energy
from .trees import Level

DIGITS = 40  # of an irrational parameter, whose powers may cancel, before a function of floats is made


@dataclass(frozen=True)
class ModifiedMotion:
    """The motion of a scene that a scheme computes, as the exact motion of another equation.

    Raises DeclarationError for a scene that has more than a constant mass, a constant damping and a force of the
    coordinates, and for a scheme of discrete gradients on several coordinates.
    """

    equation: ModifiedEquation
    scene: Scene

    @classmethod
    def of(cls, scheme: Scheme, scene: Scene, top: int | None = None, **parameters: Any) -> "ModifiedMotion":
        """At exact parameters, those not given at their defaults; top: as of `modified_equation`."""
        damped = not EquationsOfMotion(scene).damping.is_zero_matrix
        return cls(modified_equation(Evaluation.at(ParameterSet.of(scheme, None, parameters)), top, damped), scene)

    @classmethod
    def to_its_loss(cls, scheme: Scheme, scene: Scene, **parameters: Any) -> "ModifiedMotion":
        """Up to the lowest power at which energy is lost or gained, and at least the two terms of `of`."""
        found = cls.of(scheme, scene, **parameters)
        further = leading_loss(found.equation.evaluation) if found.equations.conserves else None
        return found if further is None else cls(further.equation, scene)

    def __post_init__(self) -> None:
        found, scheme = self.equations, self.equation.evaluation.scheme
        more = found.general or self.scene.laws or found.of_rates or not found.load.subs(sampled, 0).is_zero_matrix
        if more:
            raise DeclarationError(
                f"{self.scene.name}: expected a constant mass and damping, forces of the coordinates, and no load, "
                "law, constraint or contact, for the modified equation"
            )
        if not found.damping.is_zero_matrix and not self.equation.of.damping:
            raise DeclarationError(
                f"{self.scene.name}: expected no damping, or the modified equation with damping=True"
            )
        if len(found.coordinates) > 1 and any(e.has(N_discrete) for e in Step.of(scheme).equations):
            raise DeclarationError(
                f"{self.scene.name}: expected one coordinate for {scheme.name}, whose discrete gradient on several is "
                "not the mean force that the modified equation takes it for"
            )

    @cached_property
    def equations(self) -> EquationsOfMotion:
        """The scene's equations of motion."""
        return EquationsOfMotion(self.scene)

    @cached_property
    def _unit(self) -> Matrix:
        """The inverse of the mass."""
        return self.equations.mass.inv()

    @cached_property
    def _values(self) -> dict[int, Matrix]:
        return {}

    @cached_property
    def _slopes(self) -> dict[tuple[int, ...], Matrix]:
        return {}

    def value(self, tree: int) -> Matrix:
        """A tree at the coordinates and their rates (d, 1), for h = 1."""
        if tree not in self._values:
            self._values[tree] = self._value(*self.equation.of.keys[tree])
        return self._values[tree]

    def _value(self, kind: str, branches: tuple[int, ...]) -> Matrix:
        found = self.equations
        if kind == "u":
            return Matrix(found.coordinates)
        if kind == "v":
            return Matrix(self.scene.rates)
        if kind in "CK":
            start = [self.scene.start.get(q, 0) for q in found.coordinates]
            operator = found.damping if kind == "C" else found.tangent_at_start(start)
            return self._unit * operator * self.value(branches[0])
        return self._unit * self._contracted(branches)

    def _contracted(self, branches: tuple[int, ...]) -> Matrix:
        """The force's derivative along these trees (d, 1)."""
        d = range(len(self.equations.coordinates))
        along = [self.value(branch) for branch in branches]
        total = zeros(len(d), 1)
        for chosen in product(d, repeat=len(along)):
            total += self._slope(tuple(sorted(chosen))) * prod(x[k] for k, x in zip(chosen, along, strict=True))
        return total

    def _slope(self, places: tuple[int, ...]) -> Matrix:
        """The force's derivative by the coordinates at these places, in ascending order."""
        if places not in self._slopes:
            q = self.equations.coordinates
            whole = self._slope(places[:-1]).diff(q[places[-1]]) if places else self.equations.force(q)
            self._slopes[places] = whole
        return self._slopes[places]

    def terms(self) -> dict[int, Matrix]:
        """Power of h -> what stands beside it in u'' (d, 1), in coordinates and rates."""
        return {power: self._sum(level) for power, level in self.equation.terms.items()}

    def _sum(self, level: Level) -> Matrix:
        number = self.equation.evaluation.field.expression
        start = zeros(len(self.equations.coordinates), 1)
        return sum((number(c) * self.value(tree) for tree, c in sorted(level.items())), start)

    @cached_property
    def energy(self) -> ModifiedEnergy:
        """The modified energy on every potential. Raises DeclarationError for a scheme or a scene that has none."""
        if not self.equations.conserves:
            raise DeclarationError(
                f"{self.scene.name}: expected forces with a potential, and no others, for a modified energy"
            )
        found = modified_energy(self.equation)
        if found is None:
            scheme = self.equation.evaluation.scheme.name
            raise DeclarationError(
                f"{scheme}: expected a scheme without the tangent stiffness at the start, for a modified energy on "
                "every potential"
            )
        return found

    @property
    def kept(self) -> dict[int, Expr]:
        """Power of h -> what stands beside it in the modified energy, besides the scene's."""
        return {power: self._scalars(scalars) for power, scalars in self.energy.terms.items()}

    @property
    def energy_rates(self) -> dict[int, Expr]:
        """Power of h -> what stands beside it in the rate of the modified energy."""
        return {power: self._scalars(scalars) for power, scalars in self.energy.rates.items()}

    def function(self, e: Expr) -> Callable[..., float]:
        """An expression as a function of floats: the scene's parameters, coordinates and rates, one after another."""
        given = [*(p.symbol for p in self.scene.parameters), *self.equations.coordinates, *self.scene.rates]
        root = getattr(self.equation.evaluation.field, "root", None)
        if root is not None:
            e = e.subs(generator, closed_form(root, generator).evalf(DIGITS))
        return lambdify(given, e, modules="math", cse=True)

    def _scalars(self, scalars: Scalars) -> Expr:
        number = self.equation.evaluation.field.expression
        return sum((number(c) * self._scalar(s) for s, c in sorted(scalars.items())), Integer(0))

    def _scalar(self, s: Scalar) -> Expr:
        *others, last = s
        return self._contracted(tuple(others)).dot(self.value(last))

    def rates(self, quantity: Expr) -> dict[int, Expr]:
        """Power of h -> what stands beside it in d/dt of a function of the reported coordinates and rates.

        The power 0 is the exact rate, which is 0 where the quantity is conserved.
        """
        by_u, by_v = (Matrix([quantity]).jacobian(x) for x in (self.equations.coordinates, self.scene.rates))
        X_u, X_v = self.equation.field
        found: dict[int, Expr] = {}
        for power in range(self.equation.top + 1):
            total = by_u * self._sum(X_u[power + 1]) + by_v * self._sum(X_v[power + 2])
            found[power] = total[0]
        return found
