"""The declaration of a scene by its energies: frozen, and checked when it is built.

Raises `DeclarationError`, which names the expression at fault, for energies that do not define a motion.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from sympy import Expr, Interval, Matrix, S, Symbol, oo, sympify

from .errors import DeclarationError
from .law import Element
from .names import check_scene, printed
from .parameter import Parameter
from .symbols import acceleration, rate, sampled, t

POSITIVE, REAL = Interval.open(0, oo), Interval(-oo, oo)


def required(symbol: Symbol, domain: Interval = POSITIVE) -> Parameter:
    """A parameter that has no default."""
    return Parameter(symbol, domain, None)


def optional(symbol: Symbol, default: Any, domain: Interval = POSITIVE) -> Parameter:
    """A parameter with its default."""
    return Parameter(symbol, domain, sympify(default))


@dataclass(frozen=True)
class Scene:
    """A benchmark problem of one or more coordinates, from its energies.

    coordinates: symbol -> unit. kinetic: in rate(coordinate), quadratic, with a constant mass.
    potential: in coordinates, invariants, parameters and the time t (a prescribed motion enters here).
    invariants: symbol -> expression at most quadratic in the coordinates, such as |u|^2; energy-momentum
    schemes form the discrete gradient in them, or in the coordinates where none are declared.
    dissipation: Rayleigh's function, half the power lost, quadratic in the rates. load: coordinate ->
    force as a function of t, or of `sampled`, which stands for a load that the user gives.
    start: coordinate and rate -> value at t = 0; acceleration(coordinate) -> value where it is given
    rather than consistent with the equation of motion. length: the length to which Newton's tolerance is
    relative. laws: name -> a force with memory over an elongation. constraints: name -> an expression in coordinates,
    invariants, parameters and t that is kept at 0 by a reaction; its multiplier has the name. outputs: name ->
    expression in coordinates and invariants. energy_scale: the energy to which errors are relative in a scene that
    starts without energy. reference: where the scene is from.
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
    load: Mapping[Symbol, Expr] = field(default_factory=dict[Symbol, Expr])
    laws: Mapping[str, Element] = field(default_factory=dict[str, Element])
    constraints: Mapping[str, Expr] = field(default_factory=dict[str, Expr])
    outputs: Mapping[str, Expr] = field(default_factory=dict[str, Expr])
    energy_scale: Expr | None = None
    reference: str = ""

    def __post_init__(self) -> None:
        q, v = tuple(self.coordinates), self.rates
        derived = (
            *v,
            *self.accelerations,
            *self.invariants,
            *(s for names in self.memory_of.values() for s in names.values()),
            *self.multipliers,
        )
        check_scene(self.name, [p.symbol for p in self.parameters], q, derived, self.outputs)
        values = {p.symbol for p in self.parameters}
        self._known("kinetic energy", self.kinetic, values | set(v))
        self._known("potential", self.potential, values | set(q) | set(self.invariants) | {t})
        self._known("dissipation", self.dissipation, values | set(v))
        for name, element in self.laws.items():
            self._known(f"elongation of {name}", element.elongation, values | set(q))
            for what, value in element.values.items():
                self._known(f"{what} of {name}", value, values)
        for name, g in self.constraints.items():
            self._known(f"constraint {name}", g, values | set(q) | set(self.invariants) | {t})
            if not g.subs(self.invariants).free_symbols & set(q):
                raise DeclarationError(
                    f"{self.name}: expected constraint {name} to depend on coordinates, got {g}; write what is to be 0"
                )
        for symbol, force in self.load.items():
            self._known(f"load on {symbol}", force, values | {t, sampled})
        for symbol, e in (*self.start.items(), ("length", self.length)):
            self._known(f"start of {symbol}" if symbol != "length" else "length", sympify(e), values)
        for name, energy in (("kinetic energy", self.kinetic), ("dissipation", self.dissipation)):
            hessian = Matrix([energy]).jacobian(v).jacobian(v)
            half = (Matrix([v]) * hessian * Matrix(v))[0] / 2
            if hessian.free_symbols & set(v) or (energy - half).expand() != 0:
                raise DeclarationError(
                    f"{self.name}: expected a {name} quadratic in {', '.join(map(str, v))} with constant "
                    f"coefficients, got {energy}; choose coordinates in which it is"
                )
        for symbol, e in self.invariants.items():
            third = [e.diff(a, b, c) for a in q for b in q for c in q]
            if any(d != 0 for d in third):
                raise DeclarationError(
                    f"{self.name}: expected invariant {symbol} at most quadratic in the coordinates, got {e}"
                )
        if missing := [s for s in (*q, *v) if s not in self.start]:
            raise DeclarationError(f"{self.name}: start says nothing of {missing[0]}; give start={{{missing[0]}: ...}}")

    def __hash__(self) -> int:
        return hash((self.name, self.kinetic, self.potential, self.parameters))

    def _known(self, what: str, expression: Expr, allowed: set[Symbol]) -> None:
        if unknown := sorted(expression.free_symbols - allowed, key=str):
            raise DeclarationError(
                f"{self.name}: the {what} holds '{unknown[0]}', expected only "
                f"{', '.join(sorted(map(str, allowed)))}; declare it or correct the name"
            )

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
            load=all_renamed(self.load),
            laws={name: element.renamed(names) for name, element in self.laws.items()},
            constraints=all_renamed(self.constraints),
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
    def multipliers(self) -> tuple[Symbol, ...]:
        """Symbols of the constraints' multipliers, each with its constraint's name."""
        return tuple(map(Symbol, self.constraints))

    @property
    def rates(self) -> tuple[Symbol, ...]:
        """Symbols of the coordinates' velocities."""
        return tuple(rate(q) for q in self.coordinates)

    @property
    def accelerations(self) -> tuple[Symbol, ...]:
        """Symbols of the coordinates' accelerations."""
        return tuple(acceleration(q) for q in self.coordinates)
