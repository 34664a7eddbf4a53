"""Modified equation x scene -> its terms in coordinates and rates, and how functions of these change."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import Any

from sympy import Expr, Integer, Matrix, eye, lambdify, zeros

from ..algebra.algebraic import closed_form, generator
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.scene import Scene
from ..declare.scheme import Scheme
from ..declare.symbols import N_discrete, sampled, t
from ..motion.equations import EquationsOfMotion, solved
from ..oscillator.evaluation import Evaluation
from ..step.step import Step
from .modified import ModifiedEquation, modified_equation
from .modified_energy import ModifiedEnergy, Scalar, Scalars, leading_loss, modified_energy
from .trees import Level, tree_of

DIGITS = 40  # of an irrational parameter, whose powers may cancel, before a function of floats is made


@dataclass(frozen=True)
class ModifiedMotion:
    """The motion of a scene that a scheme computes, as the exact motion of another equation.

    Raises DeclarationError for a scene with loads, laws, reactions or forces that depend on time, and for a scheme of
    discrete gradients on several coordinates.
    """

    equation: ModifiedEquation
    scene: Scene

    @classmethod
    def of(cls, scheme: Scheme, scene: Scene, top: int | None = None, **parameters: Any) -> "ModifiedMotion":
        """At exact parameters, those not given at their defaults; top: as of `modified_equation`."""
        motion = EquationsOfMotion(scene)
        at, damped = Evaluation.at(ParameterSet.of(scheme, None, parameters)), not motion.damping.is_zero_matrix
        return cls(modified_equation(at, top, damped, motion.moves or motion.of_rates), scene)

    @classmethod
    def to_its_loss(cls, scheme: Scheme, scene: Scene, **parameters: Any) -> "ModifiedMotion":
        """Up to the lowest power at which energy is lost or gained, and at least the two terms of `of`."""
        found = cls.of(scheme, scene, **parameters)
        of_potential = found.equations.conserves and not found.equation.of.rates
        further = leading_loss(found.equation.evaluation) if of_potential else None
        return found if further is None else cls(further.equation, scene)

    def __post_init__(self) -> None:
        found, scheme = self.equations, self.equation.evaluation.scheme
        in_time = self._force.has(t) or not found.load.subs(sampled, 0).is_zero_matrix
        if self.scene.multipliers or self.scene.laws or in_time:
            raise DeclarationError(
                f"{self.scene.name}: expected masses and forces without time, and no load, law, constraint or contact, "
                "for the modified equation"
            )
        if (found.moves or found.of_rates) and not self.equation.of.rates:
            raise DeclarationError(
                f"{self.scene.name}: expected a constant mass and damping, or the modified equation with rates=True"
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
        """The inverse of the mass, by which the force is multiplied where it is not that per unit mass already."""
        return eye(len(self.equations.coordinates)) if self.equation.of.rates else self.equations.mass.inv()

    @cached_property
    def _force(self) -> Matrix:
        """The force (d, 1) of the coordinates; minus the acceleration, of these and the rates, where it is of both."""
        q = self.equations.coordinates
        if not self.equation.of.rates:
            return self.equations.force(q)
        return solved(*self.equations.equation(q, self.scene.rates, t))

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
        d = len(self.equations.coordinates)
        along = [self.value(tree_of(branch)) for branch in branches]
        places = [range(d) if branch >= 0 else range(d, 2 * d) for branch in branches]
        total = zeros(d, 1)
        for chosen in product(*places):
            total += self._slope(tuple(sorted(chosen))) * prod(x[k % d] for k, x in zip(chosen, along, strict=True))
        return total

    def _slope(self, places: tuple[int, ...]) -> Matrix:
        """The force's derivative by the coordinates and rates at these places, in ascending order."""
        if places not in self._slopes:
            by = (*self.equations.coordinates, *self.scene.rates)
            self._slopes[places] = self._slope(places[:-1]).diff(by[places[-1]]) if places else self._force
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
            raise self._no_energy
        if self.equation.of.rates:
            raise DeclarationError(
                f"{self.scene.name}: expected a constant mass and forces of the coordinates, for a modified energy; "
                "`energy_rates` has the rate of the scene's own"
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
        """Power of h -> what stands beside it in the modified energy, besides the scene's.

        None are known where forces have rates.
        """
        if self.equation.of.rates:
            return {}
        return {power: self._scalars(scalars) for power, scalars in self.energy.terms.items()}

    @property
    def energy_rates(self) -> dict[int, Expr]:
        """Power of h -> what stands beside it in the rate of the modified energy.

        Where forces have rates it is that of the scene's energy, at the powers that are right along the exact
        motion: from the first one, p, up to 2 p - 1, since the computed motion differs from it by h^p.
        """
        if not self.equation.of.rates:
            return {power: self._scalars(scalars) for power, scalars in self.energy.rates.items()}
        if not self.equations.conserves:
            raise self._no_energy
        X_u, X_v = self.equation.field
        wrong = [power for power in range(1, self.equation.top + 1) if X_u[power + 1] or X_v[power + 2]]
        return self.rates(self.equations.energy, [power for power in wrong if power < 2 * wrong[0]])

    @property
    def loss(self) -> int | None:
        """The lowest power at which energy is lost or gained for good, where that is known."""
        return None if self.equation.of.rates else self.energy.loss

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

    @property
    def _no_energy(self) -> DeclarationError:
        return DeclarationError(
            f"{self.scene.name}: expected forces with a potential, and no others, for a modified energy"
        )

    def rates(self, quantity: Expr, powers: Iterable[int] | None = None) -> dict[int, Expr]:
        """Power of h -> what stands beside it in d/dt of a function of the reported coordinates and rates.

        powers: if not given, all that are known. The power 0 is the exact rate, 0 where the quantity is conserved.
        """
        by_u, by_v = (Matrix([quantity]).jacobian(x) for x in (self.equations.coordinates, self.scene.rates))
        X_u, X_v = self.equation.field
        found: dict[int, Expr] = {}
        for power in range(self.equation.top + 1) if powers is None else powers:
            total = by_u * self._sum(X_u[power + 1]) + by_v * self._sum(X_v[power + 2])
            found[power] = total[0]
        return found
