"""The declaration of a scene by its energies: frozen, and checked when it is built.

Raises `DeclarationError`, which names the expression at fault, for energies that do not define a motion.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from sympy import Expr, Interval, S, Symbol, sympify

from .branches import by_branch
from .errors import DeclarationError
from .expressions import alike, expression
from .law import Element
from .names import printed
from .parameter import POSITIVE, Parameter
from .reactions import Constraint, Contact, Friction
from .scene_checks import check
from .scene_given import require_types
from .symbols import acceleration, rate


def required(symbol: Symbol, domain: Interval = POSITIVE) -> Parameter:
    """A parameter that has no default."""
    return Parameter(symbol, domain, None)


def optional(symbol: Symbol, default: Any, domain: Interval = POSITIVE) -> Parameter:
    """A parameter with its default."""
    return Parameter(symbol, domain, default)


@dataclass(frozen=True)
class Scene:
    """A benchmark problem of one or more coordinates, from its energies: Lagrange's equations follow.

    coordinates: symbol -> unit. kinetic: of second degree in rate(coordinate), with coefficients in coordinates,
    parameters and the time t.
    potential: in coordinates, invariants, parameters and t (a prescribed motion enters here).
    invariants: symbol -> expression at most quadratic in the coordinates, such as |u|^2; energy-momentum
    schemes form the discrete gradient in them, or in the coordinates where none are declared.
    dissipation: a convex function of the rates, and of coordinates, whose derivatives by the rates are the forces
    lost to; of a linear damper, half the power lost. forces: coordinate -> a force on it that none of these gives, in
    coordinates, rates, parameters and t. load: coordinate -> force as a function of t, or of `sampled`, which stands
    for a load that the user gives.
    start: coordinate and rate -> value at t = 0; acceleration(coordinate) -> value where it is given
    rather than consistent with the equation of motion. length: the length to which Newton's tolerance is
    relative. laws: name -> a force with memory over an elongation. constraints: name -> an expression in coordinates,
    invariants, parameters and t that is kept at 0 by a reaction; its multiplier has the name. One that holds rates, in
    which it is linear, is kept at 0 at velocities; so is the derivative of a `Constraint` of level "velocity".
    contacts: name -> a gap, likewise, that a pressure of the name keeps from closing beyond 0, or a `Contact`.
    frictions: name -> a force of the name against what slides. outputs: name -> expression in coordinates, their
    rates, invariants, parameters and t. energy_scale: the energy to which errors are relative in a scene that starts
    without energy. reference: where the scene is from.
    """

    name: str
    coordinates: Mapping[Symbol, str]
    kinetic: Expr
    potential: Expr
    parameters: tuple[Parameter, ...]
    start: Mapping[Symbol, Any]
    length: Any
    invariants: Mapping[Symbol, Expr] = field(default_factory=dict[Symbol, Expr])
    dissipation: Expr = S.Zero
    forces: Mapping[Symbol, Expr] = field(default_factory=dict[Symbol, Expr])
    load: Mapping[Symbol, Expr] = field(default_factory=dict[Symbol, Expr])
    laws: Mapping[str, Element] = field(default_factory=dict[str, Element])
    constraints: Mapping[str, Any] = field(default_factory=dict[str, Any])
    contacts: Mapping[str, Any] = field(default_factory=dict[str, Any])
    frictions: Mapping[str, Friction] = field(default_factory=dict[str, Friction])
    outputs: Mapping[str, Expr] = field(default_factory=dict[str, Expr])
    energy_scale: Expr | None = None
    reference: str = ""

    def __post_init__(self) -> None:
        require_types(self)
        for name in ("kinetic", "potential", "dissipation"):
            object.__setattr__(self, name, by_branch(expression(self.name, f"a {name}", getattr(self, name))))
        for name in ("forces", "load", "start", "invariants", "outputs"):
            given = {key: expression(self.name, f"{name} of {key}", e) for key, e in getattr(self, name).items()}
            branches = name in ("forces", "load")
            object.__setattr__(self, name, {q: by_branch(e) for q, e in given.items()} if branches else given)
        for name in ("length", "energy_scale"):
            if (given := getattr(self, name)) is not None or name == "length":
                object.__setattr__(self, name, expression(self.name, f"a {name}", given))
        for of, name in ((Constraint, "constraints"), (Contact, "contacts")):
            given = {key: x if isinstance(x, of) else of(x) for key, x in getattr(self, name).items()}
            object.__setattr__(self, name, given)
        self._make_elastic()
        check(self)

    def _make_elastic(self) -> None:
        """Take contacts with a penalty as what they are, parts of the potential, with their pressures as outputs."""
        elastic = {name: x.elastic for name, x in self.contacts.items() if x.penalty is not None}
        if not elastic:
            return
        if twice := [name for name in elastic if name in self.outputs]:
            raise DeclarationError(
                f"{self.name}: expected names of outputs that no contact with a penalty has, whose pressure is one, "
                f"got '{twice[0]}' twice; rename one"
            )
        pressures = {name: pressure for name, (_, pressure) in elastic.items()}
        by_symbol = {Symbol(name): pressure for name, pressure in pressures.items()}
        made = {
            "potential": self.potential + sum(potential for potential, _ in elastic.values()),
            "outputs": {**self.outputs, **pressures},
            "contacts": {name: x for name, x in self.contacts.items() if name not in elastic},
            "frictions": {name: x.renamed(by_symbol) for name, x in self.frictions.items()},
        }
        for name, value in made.items():
            object.__setattr__(self, name, value)

    def __eq__(self, other: object) -> bool:
        return alike(self, other)

    def __hash__(self) -> int:
        return hash((self.name, self.kinetic, self.potential, self.parameters))

    @cached_property
    def in_kernels(self) -> "Scene":
        """The scene with its parameters named as kernels print them: see `names.printed`."""
        names: dict[Symbol, Expr] = {p.symbol: printed(p.symbol) for p in self.parameters}

        def renamed(e: Any) -> Any:
            return None if e is None else sympify(e).subs(names, simultaneous=True)

        def all_renamed(expressions: Mapping[Any, Any]) -> dict[Any, Any]:
            return {key: renamed(e) for key, e in expressions.items()}

        return replace(
            self,
            kinetic=renamed(self.kinetic),
            potential=renamed(self.potential),
            parameters=tuple(replace(p, symbol=names[p.symbol], default=renamed(p.default)) for p in self.parameters),
            start=all_renamed(self.start),
            length=renamed(self.length),
            invariants=all_renamed(self.invariants),
            dissipation=renamed(self.dissipation),
            forces=all_renamed(self.forces),
            load=all_renamed(self.load),
            laws={name: element.renamed(names) for name, element in self.laws.items()},
            constraints={name: constraint.renamed(names) for name, constraint in self.constraints.items()},
            contacts={name: contact.renamed(names) for name, contact in self.contacts.items()},
            frictions={name: friction.renamed(names) for name, friction in self.frictions.items()},
            outputs=all_renamed(self.outputs),
            energy_scale=renamed(self.energy_scale),
        )

    @property
    def memory_of(self) -> Mapping[str, Mapping[Symbol, Symbol]]:
        """For each law the symbols of its memory -> those of the scene: after the law's name if there are more."""
        several = len(self.laws) > 1
        return {
            name: {s: Symbol(f"{name}_{s.name}") if several else s for s in element.law.memory}
            for name, element in self.laws.items()
        }

    @property
    def output_of(self) -> Mapping[str, str]:
        """For each law the name of the output that is its force: after the law's name if there are more."""
        return {name: f"{name}_force" if len(self.laws) > 1 else "force" for name in self.laws}

    @property
    def multipliers(self) -> tuple[Symbol, ...]:
        """Symbols of the constraints' multipliers, the pressures and the frictions, each with the name of its own."""
        return tuple(map(Symbol, (*self.constraints, *self.contacts, *self.frictions)))

    @property
    def impulsive(self) -> bool:
        """Whether the acceleration that a scheme keeps for its next step is without that of contacts and frictions.

        Of constraints it is then that of their multipliers by the equations of motion, which impacts are not in.
        """
        return bool(self.frictions) or any(not contact.remembered for contact in self.contacts.values())

    @property
    def rates(self) -> tuple[Symbol, ...]:
        """Symbols of the coordinates' velocities."""
        return tuple(rate(q) for q in self.coordinates)

    @property
    def accelerations(self) -> tuple[Symbol, ...]:
        """Symbols of the coordinates' accelerations."""
        return tuple(acceleration(q) for q in self.coordinates)
