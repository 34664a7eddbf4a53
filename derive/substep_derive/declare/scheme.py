"""The declaration of a time integration scheme: frozen, and checked when it is built.

Raises `DeclarationError`, which names the symbol or relation at fault, for a declaration that does
not define exactly one new state.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from sympy import Dummy, Expr, Poly, Pow, Rational, Symbol, cancel, fraction, sympify, together

from ..algebra.constant import Constant, approximated, constants_of, replaced
from ..algebra.exact_number import exact_number
from .checks import check, expression
from .errors import DeclarationError
from .expressions import require_mapping
from .names import printed
from .parameter import Family, Parameter, Root
from .published import Published
from .symbols import Knot, N, f, knot_of, lattice, steps_back, successor

TOLERANCE = Rational(1, 10**8)  # to which a value may be rounded that another one decides


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

    def __post_init__(self) -> None:
        for slot in ("inertia", "damping", "force", "load"):
            object.__setattr__(self, slot, expression("a balance", getattr(self, slot)))

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
    start: how the state at t = 0 follows from u_0, v_0, a_0: expressions for those of its symbols that do
    not just keep their value, or the one-step scheme that marches the first steps.
    report: u_1, v_1 or a_1 where the scheme's own symbol does not stand for the value at t_n + h.
    embedded: u_1 or v_1 -> a second value of it from the same step, of another order: their difference estimates the
    local error (Hairer, Norsett & Wanner I, II.4).
    parent: for a member of a family, the scheme whose parameters `fixed` it fixes.
    published: what the literature states about it, for tests.
    synonyms: other names that people give it, in small letters with words joined by _; one that several schemes have
    stands for none of them, and one such as "symplectic_euler: phi=1" for the scheme at those parameters.
    """

    name: str
    relations: Mapping[Symbol, Expr]
    balances: tuple[Balance, ...]
    parameters: tuple[Parameter, ...] = ()
    families: tuple[Family, ...] = ()
    start: "Mapping[Symbol, Expr] | Scheme" = field(default_factory=dict[Symbol, Expr])
    report: Mapping[Symbol, Expr] = field(default_factory=dict[Symbol, Expr])
    embedded: Mapping[Symbol, Expr] = field(default_factory=dict[Symbol, Expr])
    reference: str = ""
    parent: str | None = None
    fixed: Mapping[str, Rational] = field(default_factory=dict[str, Rational])
    published: Published | None = field(default=None, compare=False)
    synonyms: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        for name in ("relations", "start", "report", "embedded"):
            given: Mapping[Symbol, Any] | Scheme = getattr(self, name)
            if not isinstance(given, Scheme):
                require_mapping(self.name, name, given, Symbol)
                object.__setattr__(self, name, {s: expression(self.name, e) for s, e in given.items()})
        check(self)

    def __hash__(self) -> int:
        return hash((self.name, frozenset(self.relations), self.balances))

    @cached_property
    def start_scheme(self) -> "Scheme | None":
        """The scheme that marches the first steps, its own parameters at their defaults; None without one."""
        if not isinstance(self.start, Scheme):
            return None
        start = self.start
        defaults: dict[Symbol, Expr] = {}
        for p in start.parameters:
            default = p.default if isinstance(p.default, Root | None) else p.default.subs(defaults)
            if not isinstance(default, Rational):
                raise DeclarationError(
                    f"{self.name}: expected the scheme that starts it to have rational parameters, got {start.name} "
                    f"with {p.name} = {default}; write start={start.name}.fix({{'{p.name}': ...}})"
                )
            defaults[p.symbol] = default
        return start.fix({s.name: value for s, value in defaults.items()}) if defaults else start

    @cached_property
    def mentioned(self) -> frozenset[Symbol]:
        """Symbols of relations and balances, including those in the load's instants."""
        symbols = {s for relation in self.relations.items() for e in relation for s in e.free_symbols}
        for balance in self.balances:
            symbols |= balance.symbols | balance.load.free_symbols
        return frozenset(symbols)

    @property
    def _given(self) -> list[Expr]:
        """The expressions of relations, report, embedded and balances."""
        given = [*self.relations.values(), *self.report.values(), *self.embedded.values()]
        return given + [e for b in self.balances for e in (b.inertia, b.damping, b.force, b.load)]

    @cached_property
    def constants(self) -> tuple[Constant, ...]:
        """The algebraic numbers in relations, balances, report and embedded that are no parameters."""
        return constants_of(self._given)

    @cached_property
    def denominators(self) -> tuple[Expr, ...]:
        """Functions of parameters alone by which the declaration divides."""
        start = self.start.values() if isinstance(self.start, Mapping) else ()
        powers = {part for e in (*self._given, *start) for part in e.atoms(Pow) if part.exp.is_negative}
        own = {*self.values, *self.constants}
        return tuple(sorted({p.base for p in powers if p.base.free_symbols and p.base.free_symbols <= own}, key=str))

    @property
    def constant(self) -> Constant | None:
        """The only one of them that there may be; None where there is none."""
        return next(iter(self.constants), None)

    @cached_property
    def in_doubles(self) -> "Scheme":
        """The scheme with rational numbers for those of its constant's field, nearer than a pair of doubles."""
        if self.constant is None:
            return self
        balances = (tuple(map(_near, (b.inertia, b.damping, b.force, b.load))) for b in self.balances)
        return replace(
            self,
            relations=replaced(self.relations),
            report=replaced(self.report),
            embedded=replaced(self.embedded),
            balances=tuple(Balance(*slots) for slots in balances),
        )

    @cached_property
    def in_kernels(self) -> "Scheme":
        """The scheme with its parameters named as kernels print them: see `names.printed`."""
        names: dict[Symbol, Expr] = {s: printed(s) for s in self.values}
        own = (replace(p, symbol=names[p.symbol], default=p.default.subs(names)) for p in self.parameters)
        return replace(
            self,
            parameters=tuple(own),
            families=(),
            relations=_replaced(self.relations, names),
            start=_replaced(self.start, names) if isinstance(self.start, Mapping) else self.start,
            report=_replaced(self.report, names),
            embedded=_replaced(self.embedded, names),
            balances=tuple(balance.replace(names) for balance in self.balances),
        )

    @cached_property
    def unknowns(self) -> tuple[Symbol, ...]:
        """Symbols that a step determines: at knots after t_n, in a relation, or as a balance's acceleration at t_n."""

        def is_new(symbol: Symbol) -> bool:
            at = knot_of(symbol)
            step = lattice(at[1]) if at else None
            return at is not None and (step is None or step > 0 or symbol in self.relations)

        new = {symbol for symbol in self.mentioned if is_new(symbol)}
        for balance in self.balances:
            if not any(symbol in new for symbol in balance.inertia.free_symbols):
                new |= {s for s in balance.inertia.free_symbols if knot_of(s)}
        return tuple(sorted(new, key=_knot_order))

    @cached_property
    def state(self) -> tuple[Symbol, ...]:
        """Old symbols that the step reads, and those between them and t_n: what must be carried from step to step."""
        new = set(self.unknowns)
        found = {s for s in self.mentioned if knot_of(s) and s not in new}
        for s in list(found):
            while (s := successor(s)) not in new and steps_back(s) >= 0:
                found.add(s)
        return tuple(sorted(found, key=_knot_order))

    @property
    def takes_damping(self) -> bool:
        """Whether any balance has a damping force. A scheme without is one for u'' = g(t, u), refused with damping."""
        return any(balance.damping != 0 for balance in self.balances)

    @property
    def values(self) -> tuple[Symbol, ...]:
        """The free parameters' symbols, in the order declared."""
        return tuple(parameter.symbol for parameter in self.parameters)

    @property
    def typical(self) -> dict[Symbol, Expr]:
        """One value for each free parameter: its default, or the middle of its interval if the default is implicit.

        And a rational number near its constant.
        """
        values: dict[Symbol, Expr] = {} if self.constant is None else {self.constant: self.constant.approximation}
        for p in self.parameters:
            implicit = isinstance(p.default, Root)
            values[p.symbol] = p.inside(Rational(1, 2)) if implicit else p.default.subs(values)
        return values

    @cached_property
    def decided(self) -> dict[Symbol, tuple[Symbol, Expr]]:
        """Parameters that only another one's implicit default reads -> that one, and what they are where it is given.

        Such as rho_inf where gamma alone makes the step: a given gamma is the default for one rho_inf. None where that
        default reads a third parameter.
        """
        start: Mapping[Symbol, Expr] = self.start if isinstance(self.start, Mapping) else {}
        given = (start, self.report, self.embedded)
        read = self.mentioned.union(*(e.free_symbols for mapping in given for e in mapping.values()))
        found: dict[Symbol, tuple[Symbol, Expr]] = {}
        for p in self.parameters:
            readers = [q for q in self.parameters if q is not p and p.symbol in q.default_symbols]
            if p.symbol in read or len(readers) != 1 or not isinstance(readers[0].default, Root):
                continue
            condition = Poly(fraction(together(readers[0].default.equation))[0], p.symbol)
            if condition.degree() == 1 and condition.free_symbols <= {p.symbol, readers[0].symbol}:
                slope, rest = condition.all_coeffs()
                found[p.symbol] = readers[0].symbol, cancel(-rest / slope)
        return found

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
                following: dict[Symbol, Any] = {known[key].symbol: number}
            else:
                argument = families[key].argument
                _check_inside(self.name, argument, number)
                following = {s: e.subs(argument.symbol, number) for s, e in families[key].values.items()}
            if twice := [s for s in following if s in found]:
                raise DeclarationError(f"{self.name}: {twice[0]} is given twice, by itself and by a family")
            found |= following
        for symbol, number in found.items():
            _check_inside(self.name, known[symbol.name], number)
        return found

    def fix(
        self,
        values: Mapping[str, Any],
        name: str | None = None,
        reference: str = "",
        published: Published | None = None,
    ) -> "Scheme":
        """A member: this scheme with some parameters fixed at exact values, and what is published about that.

        Raises DeclarationError as `exact` does.
        """
        exact = self.exact(values)
        for symbol, (by, follows) in self.decided.items():
            if by in exact:
                value: Any = follows.subs(exact)
                if symbol in exact and abs(exact[symbol] - value) > TOLERANCE:
                    raise both_given(self.name, symbol, by, exact[symbol], value)
                _check_inside(self.name, next(p for p in self.parameters if p.symbol == symbol), value)
                exact[symbol] = value
        for e in self.denominators:
            if (value := e.subs(exact)) == 0 or value.is_finite is False:
                raise divided_by_zero(self.name, e, exact)
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
            embedded=_replaced(self.embedded, exact),
            balances=tuple(balance.replace(exact) for balance in self.balances),
            published=published,
            synonyms=(),
            parent=self.parent or self.name,
            fixed={**self.fixed, **{key.name: value for key, value in exact.items()}},
        )

    def known_as(self, *synonyms: str) -> "Scheme":
        """The same scheme with these synonyms."""
        return replace(self, synonyms=synonyms)


def both_given(scheme: str, symbol: Symbol, by: Symbol, given: Expr, follows: Expr) -> DeclarationError:
    """That a parameter is given with another one that decides it, and differs from what follows."""
    return DeclarationError(
        f"{scheme}: {by} decides {symbol}: expected one of the two, got {symbol} = {given} and a {by} for which it is "
        f"{follows}; leave out one"
    )


def divided_by_zero(scheme: str, e: Expr, values: Mapping[Symbol, Expr]) -> DeclarationError:
    """That a declaration divides by what is 0 at values of its parameters."""
    at = ", ".join(f"{s} = {values[s]}" for s in sorted(e.free_symbols & values.keys(), key=str))
    return DeclarationError(
        f"{scheme} divides by {e}: expected parameters at which that is not 0, got {at}; choose other values"
    )


def _near(e: Expr) -> Expr:
    """The expression linear in knots' symbols, N and f with rational numbers near those of a constant's field."""
    marks = {part: Dummy() for part in e.atoms(N, f)}
    instants = {part: part.func(*map(approximated, part.args)) for part in marks}
    return approximated(e.subs(marks)).subs({mark: instants[part] for part, mark in marks.items()})


def _replaced(expressions: Mapping[Symbol, Expr], values: Mapping[Symbol, Expr]) -> dict[Symbol, Expr]:
    return {symbol: e.subs(values, simultaneous=True) for symbol, e in expressions.items()}


def _check_inside(scheme: str, parameter: Parameter, value: Rational) -> None:
    if parameter.domain.contains(value) == False:  # noqa: E712 (a SymPy boolean)
        raise DeclarationError(
            f"{scheme}: {parameter.name} = {value} lies outside {parameter.written}; choose a value inside"
        )


def _knot_order(symbol: Symbol) -> tuple[Any, ...]:
    """Sort key: whole steps from the newest to the oldest, then sub-steps by label, and u, v, a at each knot."""
    at = knot_of(symbol)
    assert at is not None
    kind, label = at
    step = lattice(label)
    return (step is None, -step if step is not None else 0, label, "uva".index(kind))
