"""What is declared about a scheme: frozen, checked when built, and never typed a second time.

Raises `DeclarationError`, which names the symbol or relation at fault, for a declaration that does
not define exactly one new state.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from sympy import Expr, Interval, Rational, Symbol, sympify

from .symbols import K0, C, Knot, M, N, f, h, knot_of, lattice


class DeclarationError(ValueError):
    """A scheme's declaration does not define the new state; the message names what is wrong."""


@dataclass(frozen=True)
class Parameter:
    """A free parameter, the interval it may lie in, and the value taken when none is given."""

    symbol: Symbol
    domain: Interval
    default: Rational

    @property
    def name(self) -> str:
        """The symbol's name."""
        return self.symbol.name


@dataclass(frozen=True)
class Balance:
    """Where and how the equation of motion is collocated: M·inertia + C·damping + force = load.

    inertia, damping: linear combinations of knots' accelerations and velocities (or of differences
    of velocities over h). force: a combination of N(displacement). load: a combination of f(tau),
    the load at t_n + tau*h.
    """

    inertia: Expr
    damping: Expr
    force: Expr
    load: Expr

    @classmethod
    def at(cls, k: Knot, tau: Any) -> "Balance":
        """The equation of motion at knot k, with the load at t_n + tau*h."""
        return cls(k.a, k.v, N(k.u), f(sympify(tau)))

    def replace(self, values: Mapping[Symbol, Expr]) -> "Balance":
        """The balance with parameters replaced."""
        slots = (self.inertia, self.damping, self.force, self.load)
        return Balance(*(slot.subs(values) for slot in slots))

    @property
    def symbols(self) -> set[Symbol]:
        """Symbols the balance reads, the load's instants left aside."""
        return self.inertia.free_symbols | self.damping.free_symbols | self.force.free_symbols


@dataclass(frozen=True)
class Scheme:
    """A time integration scheme as its textbook writes it.

    relations: new symbol -> expression in old and new symbols, any parameters and h.
    balances: in the order in which they are solved, each for its own new acceleration.
    parent: for a member of a family, the scheme whose parameters `fixed` it fixes.
    """

    name: str
    relations: Mapping[Symbol, Expr]
    balances: tuple[Balance, ...]
    parameters: tuple[Parameter, ...] = ()
    reference: str = ""
    parent: str | None = None
    fixed: Mapping[str, Rational] = field(default_factory=dict)

    def __post_init__(self) -> None:
        declared = {parameter.symbol for parameter in self.parameters} | {h, M, C, K0}
        for symbol in sorted(self._mentioned, key=str):
            if knot_of(symbol) is None and symbol not in declared:
                raise DeclarationError(
                    f"{self.name}: '{symbol}' is neither a knot's u, v, a nor a declared parameter; "
                    f"declare Parameter({symbol}, ...) or correct the name"
                )
        for symbol in self.relations:
            if knot_of(symbol) is None:
                raise DeclarationError(f"{self.name}: a relation defines '{symbol}', not a knot's u, v or a")
        count, unknowns = len(self.relations) + len(self.balances), self.unknowns
        if len(unknowns) != count:
            defined = ", ".join(str(s) for s in unknowns if s not in self.relations)
            raise DeclarationError(
                f"{self.name}: {len(self.relations)} relations and {len(self.balances)} balances "
                f"for {len(unknowns)} unknowns; without a relation of their own: {defined}. "
                f"{'A relation is missing' if len(unknowns) > count else 'There is a relation too many'}"
            )

    @property
    def _mentioned(self) -> set[Symbol]:
        symbols = {s for relation in self.relations.items() for e in relation for s in e.free_symbols}
        for balance in self.balances:
            symbols |= balance.symbols | balance.load.free_symbols
        return symbols

    @property
    def unknowns(self) -> tuple[Symbol, ...]:
        """Symbols of the new step: of knots after t_n, defined by a relation, or balanced at t_n."""

        def is_new(symbol: Symbol) -> bool:
            at = knot_of(symbol)
            step = lattice(at[1]) if at else None
            return at is not None and (step is None or step > 0 or symbol in self.relations)

        new = {symbol for symbol in self._mentioned if is_new(symbol)}
        for balance in self.balances:
            if not any(symbol in new for symbol in balance.inertia.free_symbols):
                new |= {s for s in balance.inertia.free_symbols if knot_of(s)}
        return tuple(sorted(new, key=_knot_order))

    @property
    def state(self) -> tuple[Symbol, ...]:
        """Old symbols that the step reads: what must be carried from step to step."""
        new = set(self.unknowns)
        return tuple(sorted((s for s in self._mentioned if knot_of(s) and s not in new), key=_knot_order))

    @property
    def values(self) -> tuple[Symbol, ...]:
        """The free parameters' symbols, in the order declared."""
        return tuple(parameter.symbol for parameter in self.parameters)

    def fix(self, values: Mapping[str, Any], name: str | None = None, reference: str = "") -> "Scheme":
        """A member: this scheme with some parameters fixed at exact values.

        Raises DeclarationError for an unknown parameter or a value outside its interval.
        """
        known = {parameter.name: parameter for parameter in self.parameters}
        for key in values:
            if key not in known:
                names = ", ".join(known) or "none"
                raise DeclarationError(f"{self.name} has no parameter '{key}'; its parameters: {names}")
        exact = {known[key].symbol: exact_number(value) for key, value in values.items()}
        for key, value in exact.items():
            if known[key.name].domain.contains(value) == False:  # noqa: E712 (a SymPy boolean)
                raise DeclarationError(
                    f"{self.name}: {key} = {value} lies outside {known[key.name].domain}; choose a value inside"
                )
        return replace(
            self,
            name=name or self.name,
            reference=reference or self.reference,
            parameters=tuple(p for p in self.parameters if p.symbol not in exact),
            relations={symbol: e.subs(exact) for symbol, e in self.relations.items()},
            balances=tuple(balance.replace(exact) for balance in self.balances),
            parent=self.parent or self.name,
            fixed={**self.fixed, **{key.name: value for key, value in exact.items()}},
        )


def exact_number(value: Any) -> Rational:
    """An int, Fraction, SymPy Rational or text such as '1/5' as an exact rational.

    Text is parsed by `Fraction`, never evaluated. Raises TypeError for a float, ValueError for text
    that is no rational number.
    """
    if isinstance(value, float):
        raise TypeError(f"expected an exact number, got the float {value!r}; write it as text, '{value}'")
    if isinstance(value, Rational):
        return value
    try:
        exact = Fraction(value)
    except (ValueError, TypeError, ZeroDivisionError) as error:
        raise ValueError(f"expected a rational number such as '1/5' or '0.2', got {value!r}") from error
    return Rational(exact.numerator, exact.denominator)


def _knot_order(symbol: Symbol) -> tuple[Any, ...]:
    """Whole steps from the newest to the oldest, then stages by label; u, v, a at each."""
    at = knot_of(symbol)
    assert at is not None
    kind, label = at
    step = lattice(label)
    return (step is None, -step if step is not None else 0, label, "uva".index(kind))
