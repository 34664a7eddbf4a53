"""Modified equation x scene -> its terms in coordinates and rates, and how functions of these change."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import Any, Protocol

from sympy import (
    Abs,
    Dummy,
    Expr,
    Function,
    Heaviside,
    Matrix,
    Max,
    Min,
    Piecewise,
    Symbol,
    exp,
    factorial,
    lambdify,
    log,
    sign,
    zeros,
)  # fmt: skip

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
from .trees import Level, V, tree_of

DIGITS = 40  # of an irrational parameter, whose powers may cancel, before it is a float


@dataclass(frozen=True)
class ModifiedMotion:
    """The motion of a scene that a scheme computes, as the exact motion of another equation.

    Raises DeclarationError for a scene with loads, laws, reactions or forces that depend on time, and for a scheme of
    discrete gradients on several coordinates.
    """

    equation: ModifiedEquation
    scene: Scene
    place: "Place | None" = None  # where trees are evaluated; in symbols if not given

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
        in_time = any(e.has(t) for e in self.system) or not found.load.subs(sampled, 0).is_zero_matrix
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
    def given(self) -> tuple[Symbol, ...]:
        """The scene's parameters, coordinates and rates, which all expressions are of."""
        return *(p.symbol for p in self.scene.parameters), *self.equations.coordinates, *self.scene.rates

    @cached_property
    def system(self) -> tuple[Matrix, Matrix]:
        """(matrix, right): N = matrix^-1 right, of the coordinates, and of the rates where it depends on these."""
        q = self.equations.coordinates
        if not self.equation.of.rates:
            return self.equations.mass, self.equations.force(q)
        return self.equations.equation(q, self.scene.rates, t)

    def decimal(self, number: Any) -> float:
        """A number of the field as a float."""
        field = self.equation.evaluation.field
        found, root = field.expression(number), getattr(field, "root", None)
        return float((found if root is None else found.subs(generator, closed_form(root, generator))).evalf(DIGITS))

    def in_numbers(self, e: Matrix) -> Callable[..., Any]:
        """The rows of a matrix as a function of `given`, in numbers or in power series up to the degree `equation.top`.

        A series x is asked for x.value and for x.composed(terms), a function of it with these Taylor coefficients at
        the value. Raises DeclarationError for an expression that bends or jumps.
        """
        moving = {*self.equations.coordinates, *self.scene.rates}
        e = e.replace(lambda x: x.is_Pow and x.exp.free_symbols & moving, lambda x: exp(x.exp * log(x.base)))
        functions = e.atoms(Function)
        bent = any(isinstance(f, Abs | Heaviside | Max | Min | Piecewise | sign) for f in functions)
        if bent or not all(type(f).__module__.startswith("sympy.") for f in functions):
            raise DeclarationError(
                f"{self.scene.name}: expected forces with all derivatives, for the modified equation, got one that "
                "bends or jumps"
            )
        names = {f.func.__name__: _composed(f.func, self.equation.top) for f in functions}
        return lambdify(self.given, e.tolist(), modules=[{"sqrt": lambda x: x**0.5, **names}], cse=True)

    @cached_property
    def _values(self) -> dict[int, Any]:
        return {}

    @cached_property
    def _place(self) -> "Place":
        return self.place or Written(self)

    def value(self, tree: int) -> Any:
        """A tree at the coordinates and their rates (d, 1), for h = 1."""
        if tree not in self._values:
            kind, branches = self.equation.of.keys[tree]
            if kind == "N":
                self._values[tree] = self._place.along(branches, self.value)
            elif kind in "uv":
                self._values[tree] = self._place.state[int(kind == "v")]
            else:
                self._values[tree] = self._place.operator(kind, self.value(branches[0]))
        return self._values[tree]

    def terms(self) -> dict[int, Any]:
        """Power of h -> what stands beside it in u'' (d, 1), in coordinates and rates."""
        return {power: self._sum(level) for power, level in self.equation.terms.items()}

    def _sum(self, level: Level) -> Any:
        return sum((self._place.number(c) * self.value(tree) for tree, c in sorted(level.items())), 0 * self.value(V))

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
    def kept(self) -> dict[int, Any]:
        """Power of h -> what stands beside it in the modified energy, besides the scene's.

        None are known where forces have rates.
        """
        if self.equation.of.rates:
            return {}
        return {power: self._scalars(scalars) for power, scalars in self.energy.terms.items()}

    @property
    def energy_rates(self) -> dict[int, Any]:
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

    def _scalars(self, scalars: Scalars) -> Any:
        return sum(self._place.number(c) * self._scalar(s) for s, c in sorted(scalars.items()))

    def _scalar(self, s: Scalar) -> Any:
        *others, last = s
        return self._place.dot(self._place.along(tuple(others), self.value), self._place.weighed(self.value(last)))

    @property
    def _no_energy(self) -> DeclarationError:
        return DeclarationError(
            f"{self.scene.name}: expected forces with a potential, and no others, for a modified energy"
        )

    def rates(self, quantity: Expr, powers: Iterable[int] | None = None) -> dict[int, Any]:
        """Power of h -> what stands beside it in d/dt of a function of the reported coordinates and rates.

        powers: if not given, all that are known. The power 0 is the exact rate, 0 where the quantity is conserved.
        """
        by_u, by_v = (
            self._place.of(Matrix([quantity]).jacobian(x).T) for x in (self.equations.coordinates, self.scene.rates)
        )
        (X_u, X_v), dot = self.equation.field, self._place.dot
        every = range(self.equation.top + 1) if powers is None else powers
        return {k: dot(by_u, self._sum(X_u[k + 1])) + dot(by_v, self._sum(X_v[k + 2])) for k in every}


def _composed(function: type[Function], degree: int) -> Callable[[Any], Any]:
    """A function of a number, an array or a power series."""
    x = Dummy()
    terms = lambdify(x, [function(x).diff(x, k) / factorial(k) for k in range(degree + 1)], "numpy", cse=True)
    return lambda at: at.composed(terms(at.value)) if hasattr(at, "composed") else terms(at)[0]


class Place(Protocol):
    """Where trees are evaluated: at the coordinates and rates themselves, in symbols, or at numbers."""

    state: tuple[Any, Any]  # u and v

    def along(self, branches: tuple[int, ...], value: Callable[[int], Any]) -> Any:
        """The force's derivative along these trees, whose values are asked for."""
        ...

    def operator(self, kind: str, x: Any) -> Any:
        """C x or K0 x, per unit mass."""
        ...

    def weighed(self, x: Any) -> Any:
        """A constant mass times a vector."""
        ...

    def of(self, e: Matrix) -> Any:
        """A vector of expressions."""
        ...

    def number(self, c: Any) -> Any:
        """A number of the field."""
        ...

    def dot(self, x: Any, y: Any) -> Any:
        """The scalar product."""
        ...


class Written:
    """Trees in symbols."""

    def __init__(self, motion: ModifiedMotion) -> None:
        self.equations, self.rates, self.start = motion.equations, motion.scene.rates, motion.scene.start
        self.state = Matrix(motion.equations.coordinates), Matrix(motion.scene.rates)
        self.number = motion.equation.evaluation.field.expression
        self._slopes: dict[tuple[int, ...], Matrix] = {(): solved(*motion.system)}

    def along(self, branches: tuple[int, ...], value: Callable[[int], Matrix]) -> Matrix:
        """The force's derivative along these trees (d, 1)."""
        d = len(self.rates)
        along = [value(tree_of(branch)) for branch in branches]
        places = [range(d) if branch >= 0 else range(d, 2 * d) for branch in branches]
        total = zeros(d, 1)
        for chosen in product(*places):
            total += self._slope(tuple(sorted(chosen))) * prod(x[k % d] for k, x in zip(chosen, along, strict=True))
        return total

    def _slope(self, places: tuple[int, ...]) -> Matrix:
        """The force's derivative by the coordinates and rates at these places, in ascending order."""
        if places not in self._slopes:
            by = (*self.equations.coordinates, *self.rates)
            self._slopes[places] = self._slope(places[:-1]).diff(by[places[-1]])
        return self._slopes[places]

    def operator(self, kind: str, x: Matrix) -> Matrix:
        """C x or K0 x, per unit mass."""
        found = self.equations
        start = [self.start.get(q, 0) for q in found.coordinates]
        return found.mass.inv() * (found.damping if kind == "C" else found.tangent_at_start(start)) * x

    def weighed(self, x: Matrix) -> Matrix:
        """A constant mass times a vector."""
        return self.equations.mass * x

    def of(self, e: Matrix) -> Matrix:
        """The vector itself."""
        return e

    def dot(self, x: Matrix, y: Matrix) -> Expr:
        """The scalar product."""
        return x.dot(y)
