"""Checks of a scheme's declaration, made when it is built, so that nothing wrong is derived from it later.

Every check raises `DeclarationError`, which names the scheme, the symbol or relation at fault, and the cure.
"""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, Protocol

from sympy import (
    Add,
    Expr,
    Mul,
    Poly,
    Pow,
    Rational,
    Symbol,
    SympifyError,
    fraction,
    preorder_traversal,
    sympify,
    together,
)

from ..algebra.constant import Constant, constants_of
from .errors import DeclarationError
from .names import check_scheme
from .parameter import Family, Parameter, Root
from .symbols import K0, NAMED, C, K_t, M, N, N_discrete, auxiliary, f, h, knot, knot_of, lattice, successor
from .units import check_units

START_KNOT = frozenset(knot(0))


class _Declared(Protocol):
    """A scheme's declaration, as far as it is checked."""

    @property
    def name(self) -> str: ...
    @property
    def relations(self) -> Mapping[Symbol, Expr]: ...
    @property
    def balances(self) -> tuple[Any, ...]: ...
    @property
    def parameters(self) -> tuple[Parameter, ...]: ...
    @property
    def families(self) -> tuple[Family, ...]: ...
    @property
    def start(self) -> "Mapping[Symbol, Expr] | _Declared": ...
    @property
    def report(self) -> Mapping[Symbol, Expr]: ...
    @property
    def embedded(self) -> Mapping[Symbol, Expr]: ...
    @cached_property
    def constants(self) -> tuple[Constant, ...]: ...
    @property
    def parent(self) -> str | None: ...
    @property
    def values(self) -> tuple[Symbol, ...]: ...
    @cached_property
    def mentioned(self) -> frozenset[Symbol]: ...
    @cached_property
    def unknowns(self) -> tuple[Symbol, ...]: ...
    @cached_property
    def state(self) -> tuple[Symbol, ...]: ...
    @cached_property
    def denominators(self) -> tuple[Expr, ...]: ...
    @property
    def start_scheme(self) -> Any: ...


def check(scheme: _Declared) -> None:
    """All checks, in the order in which their messages help most."""
    named = (*scheme.values, *scheme.constants)
    check_scheme(scheme.name, named, [family.argument.symbol for family in scheme.families], scheme.mentioned)
    _parameters(scheme)
    _families(scheme)
    _symbols(scheme)
    _constant(scheme)
    _exact(scheme)
    if scheme.parent is None:  # in a member, an interval may reach further than the values that are left
        _divisions(scheme)
    _balances(scheme)
    check_units(scheme)
    _count(scheme)
    _start(scheme)
    _carried(scheme)
    _results(scheme, "report", scheme.report, knot(1))
    _results(scheme, "embedded", scheme.embedded, knot(1)[:2])


def expression(owner: str, value: Any) -> Expr:
    """What is declared as an expression of SymPy; plain numbers are taken too."""
    try:
        return sympify(value, strict=True)
    except SympifyError as error:
        raise DeclarationError(
            f"{owner}: expected an expression in symbols, got {value!r}; write it with knots' symbols and numbers"
        ) from error


def _parameters(scheme: _Declared) -> None:
    seen: set[Symbol] = set()
    for p in scheme.parameters:
        default = p.default.equation if isinstance(p.default, Root) else p.default
        known = seen | {p.symbol} if isinstance(p.default, Root) else seen
        if default is None or not default.free_symbols <= known:
            raise DeclarationError(
                f"{scheme.name}: expected a default of {p.name}, in parameters declared before it if any, got {default}"
            )
        seen.add(p.symbol)
        if scheme.parent is None:  # in a member, fixed values may have moved an unused default outside
            p.check_default()


def _families(scheme: _Declared) -> None:
    for family in scheme.families:
        argument = family.argument
        for symbol, value in family.values.items():
            if symbol not in scheme.values:
                raise DeclarationError(
                    f"{scheme.name}: the family of {argument.name} sets '{symbol}', which is no parameter of the "
                    f"scheme; its parameters: {', '.join(map(str, scheme.values)) or 'none'}"
                )
            if unknown := value.free_symbols - {argument.symbol}:
                raise DeclarationError(
                    f"{scheme.name}: the family of {argument.name} gives {symbol} = {value}; expected a function of "
                    f"{argument.name} alone, got {', '.join(sorted(map(str, unknown)))} in it"
                )


def _symbols(scheme: _Declared) -> None:
    declared = set(scheme.values) | {h, M, C, K0}
    start: Mapping[Symbol, Expr] = scheme.start if isinstance(scheme.start, Mapping) else {}
    added = (
        *(x for both in (*start.items(), *scheme.report.items(), *scheme.embedded.items()) for x in both),
        *(b.load for b in scheme.balances),
    )
    for symbol in sorted(scheme.mentioned | {s for e in added for s in e.free_symbols}, key=str):
        at = knot_of(symbol)
        if at is None and symbol not in declared and not isinstance(symbol, Constant):
            raise DeclarationError(
                f"{scheme.name}: '{symbol}' is neither a knot's u, v, a nor a declared parameter; "
                f"declare Parameter({symbol}, ...) or correct the name"
            )
        if at is not None and not _canonical(at[1]):
            raise DeclarationError(
                f"{scheme.name}: expected a knot's label to be text such as 'g' or a whole or fractional number of "
                f"steps such as 0, -1 or '1/2', got '{at[1]}'; rename the knot"
            )
        name = auxiliary(symbol)
        if at is not None and NAMED in at[1] and (lattice(at[1]) is None or not name.isidentifier() or name in "uva"):
            raise DeclarationError(
                f"{scheme.name}: expected an auxiliary state at a number of steps from t_n, and its name an identifier "
                f"other than u, v and a, got '{at[1]}'; write it as knot(0, 'rate').v and knot(1, 'rate').v"
            )


def _canonical(label: str) -> bool:
    """Whether a label that is a number is written in lowest terms, as Fraction prints it; true for any other label."""
    step = lattice(label)
    return step is None or str(step) == label.partition(NAMED)[0]


def _constant(scheme: _Declared) -> None:
    found = scheme.constants
    start = scheme.start.values() if isinstance(scheme.start, Mapping) else ()
    if other := constants_of(start):
        raise DeclarationError(
            f"{scheme.name}: expected a start from rational numbers and parameters, got the constant {other[0]} in it; "
            "let that number be a parameter with a Root as default"
        )
    if len(found) > 1:
        raise DeclarationError(
            f"{scheme.name}: expected one algebraic constant, got {_listed(found)}; write all numbers as rational "
            "functions of a single one"
        )
    if found and any(isinstance(p.default, Root) for p in scheme.parameters):
        raise DeclarationError(
            f"{scheme.name}: expected one irrational number, got the constant {found[0]} and a parameter whose default "
            "is a root; write one as a rational function of the other"
        )


def _exact(scheme: _Declared) -> None:
    start: Mapping[Symbol, Expr] = scheme.start if isinstance(scheme.start, Mapping) else {}
    given = (scheme.relations, start, scheme.report, scheme.embedded)
    expressions = [e for mapping in given for e in mapping.values()]
    expressions += [e for b in scheme.balances for e in (b.inertia, b.damping, b.force, b.load)]
    for part in (part for e in expressions for part in preorder_traversal(e)):
        if not is_rational(part):
            raise DeclarationError(
                f"{scheme.name}: '{part}' is neither rational nor a whole power, but all that is derived is "
                "exact; write a fraction as Rational(1, 4), anything else as the default of a Parameter"
            )


def _divisions(scheme: _Declared) -> None:
    """A declaration divides by no function of one parameter, or of a family's argument, that vanishes in its range."""
    ranges = {p.symbol: p for p in (*scheme.parameters, *(family.argument for family in scheme.families))}
    powers = (part for family in scheme.families for e in family.values.values() for part in e.atoms(Pow))
    for e in (*scheme.denominators, *(part.base for part in powers if part.exp.is_negative)):
        if len(e.free_symbols) != 1 or (p := ranges.get(*e.free_symbols)) is None:
            continue
        roots = Poly(fraction(together(e))[0], p.symbol).real_roots()
        if inside := [root for root in roots if p.domain.contains(root) == True]:  # noqa: E712 (a SymPy boolean)
            raise DeclarationError(
                f"{scheme.name} divides by {e}: expected an interval of {p.name} without {inside[0]}, where that is 0, "
                f"got {p.written}; declare one that leaves it out"
            )


def is_rational(part: Expr) -> bool:
    """Whether an expression is rational in its arguments, which are checked on their own."""
    declared = (Rational, Symbol, Add, Mul, f, N, N_discrete, K_t)
    return isinstance(part, declared) or (isinstance(part, Pow) and part.exp.is_Integer)


def _balances(scheme: _Declared) -> None:
    for k, b in enumerate(scheme.balances, start=1):
        where = f"{scheme.name}: balance {k}"
        for slot in ("inertia", "damping"):
            if getattr(b, slot).atoms(N, N_discrete, K_t, f):
                raise DeclarationError(
                    f"{where}: expected the {slot} as a linear combination of knots' symbols, got {getattr(b, slot)}; "
                    "write forces into force and loads into load"
                )
        if b.force.atoms(f, K_t):
            raise DeclarationError(f"{where}: expected the force to hold N of displacements, got {b.force}")
        within = {s for part in b.force.atoms(N, N_discrete) for s in part.free_symbols}
        if moving := [s for s in scheme.unknowns if s in within and s.name[0] != "u"]:
            raise DeclarationError(
                f"{where}: expected the internal force at displacements, got the unknown {moving[0]} in {b.force}; "
                "give that displacement a knot of its own: a relation for it, and N of its symbol"
            )
        load: Expr = b.load
        bare = load.replace(f, lambda tau: Symbol("f"))
        if knots := sorted(s for s in map(str, bare.free_symbols) if knot_of(Symbol(s))):
            raise DeclarationError(f"{where}: expected a load of f(tau) alone, got {knots[0]}; write it into force")
        for load in b.load.atoms(f):
            if moving := {s for s in load.free_symbols if not isinstance(s, Constant)} - set(scheme.values):
                raise DeclarationError(
                    f"{where}: expected f of an instant in steps after t_n, got {load} with {_listed(moving)} in it; "
                    "f(1) is the load at t_n + h"
                )
    for symbol in scheme.relations:
        if knot_of(symbol) is None:
            raise DeclarationError(f"{scheme.name}: a relation defines '{symbol}', not a knot's u, v or a")
        if held := scheme.relations[symbol].atoms(N, N_discrete, K_t, f):
            raise DeclarationError(
                f"{scheme.name}: the relation of {symbol} holds {_listed(held)}; forces and loads belong into balances"
            )


def _count(scheme: _Declared) -> None:
    count, unknowns = len(scheme.relations) + len(scheme.balances), scheme.unknowns
    if len(unknowns) != count:
        defined = ", ".join(str(s) for s in unknowns if s not in scheme.relations)
        raise DeclarationError(
            f"{scheme.name}: {len(scheme.relations)} relations and {len(scheme.balances)} balances "
            f"for {len(unknowns)} unknowns; without a relation of their own: {defined}. "
            f"{'A relation is missing' if len(unknowns) > count else 'There is a relation too many'}"
        )


def _carried(scheme: _Declared) -> None:
    """A step gives what the next one reads, and u_1 and v_1 unless something else is reported."""
    needed = (*map(successor, scheme.state), *(s for s in knot(1)[:2] if s not in scheme.report))
    if missing := [s for s in needed if s not in (*scheme.unknowns, *scheme.state)]:
        raise DeclarationError(
            f"{scheme.name}: the step reads {_listed(scheme.state)} but no relation defines {missing[0]} at its end; "
            "give one, or for u_1 and v_1 a report"
        )


def _start(scheme: _Declared) -> None:
    start = scheme.start_scheme
    if start is not None:
        if start.constants:
            raise DeclarationError(
                f"{scheme.name}: expected a scheme of rational numbers to start it, got {start.name} with the constant "
                f"{start.constants[0]}; start with another one"
            )
        if not set(start.state) <= START_KNOT or start.start_scheme is not None:
            raise DeclarationError(
                f"{scheme.name}: expected a one-step scheme to start it, got {start.name} with the state "
                f"{_listed(start.state)}; start with one that reads u_0, v_0 and a_0 alone"
            )
        labels = {s: (knot_of(s) or ("", ""))[1] for s in scheme.state}
        if off := [s for s, label in labels.items() if (lattice(label) or Fraction(0)).denominator > 1]:
            raise DeclarationError(
                f"{scheme.name}: the step reads {off[0]}, which {start.name}, marching whole steps, does not pass; "
                f"give start={{{off[0]}: ...}}"
            )
        return
    assert isinstance(scheme.start, Mapping)
    if missing := [s for s in scheme.state if s not in START_KNOT and s not in scheme.start]:
        raise DeclarationError(
            f"{scheme.name}: the step reads {missing[0]}, for which start says nothing; "
            f"give start={{{missing[0]}: ...}} or start=<a one-step scheme>"
        )
    for symbol, e in scheme.start.items():
        if symbol not in scheme.state:
            raise DeclarationError(
                f"{scheme.name}: start gives {symbol}, which no step reads; the state is {_listed(scheme.state)}"
            )
        if other := [s for s in e.free_symbols if knot_of(s) and s not in START_KNOT]:
            raise DeclarationError(
                f"{scheme.name}: the start of {symbol} holds {_listed(other)}; expected u_0, v_0 and a_0 alone"
            )


def _results(scheme: _Declared, what: str, given: Mapping[Symbol, Expr], expected: Sequence[Symbol]) -> None:
    """Values at t_n + h that are given beside the relations: of which symbols, and in terms of which."""
    for symbol, e in given.items():
        if symbol not in expected:
            names = " or ".join(map(str, expected))
            raise DeclarationError(f"{scheme.name}: {what} gives '{symbol}'; expected {names}")
        knots = [s for s in e.free_symbols if knot_of(s)]
        if unknown := [s for s in knots if s not in (*scheme.unknowns, *scheme.state)]:
            raise DeclarationError(
                f"{scheme.name}: {what} of {symbol} holds {_listed(unknown)}, which the step does not define"
            )


def _listed(symbols: Iterable[Expr]) -> str:
    return ", ".join(sorted(map(str, symbols)))
