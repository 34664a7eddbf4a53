"""What is declared about a scheme: frozen, checked when built, and never typed a second time.

Raises `DeclarationError`, which names the symbol or relation at fault, for a declaration that does
not define exactly one new state.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from sympy import Add, Expr, Mul, Pow, Rational, Symbol, preorder_traversal, sympify

from ..algebra.exact_number import exact_number
from .errors import DeclarationError
from .names import check_scheme
from .parameter import Family, Parameter, Root
from .symbols import K0, C, K_t, Knot, M, N, N_discrete, f, h, knot, knot_of, lattice


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
    families: other names for sets of parameters, such as generalized-alpha's by rho_inf.
    start: how the state is had from u_0, v_0, a_0 at t = 0: expressions for what is not just that, or
    the one-step scheme that marches the first steps.
    report: u_1, v_1 or a_1 where the scheme's own symbol does not stand for the value at t_n + h.
    parent: for a member of a family, the scheme whose parameters `fixed` it fixes.
    """

    name: str
    relations: Mapping[Symbol, Expr]
    balances: tuple[Balance, ...]
    parameters: tuple[Parameter, ...] = ()
    families: tuple[Family, ...] = ()
    start: "Mapping[Symbol, Expr] | Scheme" = field(default_factory=dict)
    report: Mapping[Symbol, Expr] = field(default_factory=dict)
    reference: str = ""
    parent: str | None = None
    fixed: Mapping[str, Rational] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_scheme(self.name, self.values, [f.argument.symbol for f in self.families], self._mentioned)
        declared = {parameter.symbol for parameter in self.parameters} | {h, M, C, K0}
        for symbol in sorted(self._mentioned, key=str):
            if knot_of(symbol) is None and symbol not in declared:
                raise DeclarationError(
                    f"{self.name}: '{symbol}' is neither a knot's u, v, a nor a declared parameter; "
                    f"declare Parameter({symbol}, ...) or correct the name"
                )
        for part in (part for e in self._coefficients for part in preorder_traversal(e)):
            if not _is_rational(part):
                raise DeclarationError(
                    f"{self.name}: '{part}' is neither rational nor a whole power, but all that is derived is "
                    "exact; write a fraction as Rational(1, 4), anything else as the default of a Parameter"
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

        given = set(knot(0)) | set(self.start if isinstance(self.start, Mapping) else self.state)
        if missing := [s for s in self.state if s not in given]:
            raise DeclarationError(
                f"{self.name}: the step reads {missing[0]}, for which start says nothing; "
                f"give start={{{missing[0]}: ...}} or start=<a one-step scheme>"
            )

    @property
    def _coefficients(self) -> list[Expr]:
        """All expressions that have to be rational functions."""
        start = self.start if isinstance(self.start, Mapping) else {}
        found = [*self.relations.values(), *start.values(), *self.report.values()]
        return found + [e for b in self.balances for e in (b.inertia, b.damping, b.force)]

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

    @property
    def typical(self) -> dict[Symbol, Expr]:
        """One value for each free parameter: its default, for an implicit one the middle of its interval."""
        values: dict[Symbol, Expr] = {}
        for p in self.parameters:
            implicit = isinstance(p.default, Root)
            values[p.symbol] = (p.domain.start + p.domain.end) / 2 if implicit else p.default.subs(values)
        return values

    def exact(self, values: Mapping[str, Any]) -> dict[Symbol, Rational]:
        """Exact values of parameters, a family's argument replaced by what it stands for.

        Raises DeclarationError for an unknown parameter, one given twice, or a value outside its interval.
        """
        known = {parameter.name: parameter for parameter in self.parameters}
        families = {family.argument.name: family for family in self.families}
        found: dict[Symbol, Rational] = {}
        for key, value in values.items():
            if key not in known and key not in families:
                names = ", ".join([*known, *families]) or "none"
                raise DeclarationError(f"{self.name} has no parameter '{key}'; its parameters: {names}")
            number = exact_number(value)
            if key in known:
                mine: dict[Symbol, Any] = {known[key].symbol: number}
            else:
                argument = families[key].argument
                _check_inside(self.name, argument, number)
                mine = {s: e.subs(argument.symbol, number) for s, e in families[key].values.items()}
            if twice := [s for s in mine if s in found]:
                raise DeclarationError(f"{self.name}: {twice[0]} is given twice, by itself and by a family")
            found |= mine
        for symbol, number in found.items():
            _check_inside(self.name, known[symbol.name], number)
        return found

    def fix(self, values: Mapping[str, Any], name: str | None = None, reference: str = "") -> "Scheme":
        """A member: this scheme with some parameters fixed at exact values.

        Raises DeclarationError as `exact` does.
        """
        exact = self.exact(values)
        kept = [p for p in self.parameters if p.symbol not in exact]
        return replace(
            self,
            name=name or self.name,
            reference=reference or self.reference,
            parameters=tuple(replace(p, default=p.default.subs(exact)) for p in kept),
            families=tuple(f for f in self.families if not exact.keys() & f.values.keys()),
            relations=_replaced(self.relations, exact),
            start=_replaced(self.start, exact) if isinstance(self.start, Mapping) else self.start,
            report=_replaced(self.report, exact),
            balances=tuple(balance.replace(exact) for balance in self.balances),
            parent=self.parent or self.name,
            fixed={**self.fixed, **{key.name: value for key, value in exact.items()}},
        )


def _is_rational(part: Expr) -> bool:
    """Whether it is, if the parts it is made of are."""
    declared = (Rational, Symbol, Add, Mul, f, N, N_discrete, K_t)
    return isinstance(part, declared) or (isinstance(part, Pow) and part.exp.is_Integer)


def _replaced(expressions: Mapping[Symbol, Expr], values: Mapping[Symbol, Expr]) -> dict[Symbol, Expr]:
    return {symbol: e.subs(values, simultaneous=True) for symbol, e in expressions.items()}


def _check_inside(scheme: str, parameter: Parameter, value: Rational) -> None:
    if parameter.domain.contains(value) == False:  # noqa: E712 (a SymPy boolean)
        raise DeclarationError(
            f"{scheme}: {parameter.name} = {value} lies outside {parameter.domain}; choose a value inside"
        )


def _knot_order(symbol: Symbol) -> tuple[Any, ...]:
    """Whole steps from the newest to the oldest, then stages by label; u, v, a at each."""
    at = knot_of(symbol)
    assert at is not None
    kind, label = at
    step = lattice(label)
    return (step is None, -step if step is not None else 0, label, "uva".index(kind))
