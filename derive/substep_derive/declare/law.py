"""The declaration of a law with memory: a scalar relation between an elongation and a force.

Raises `DeclarationError`, which names the expression at fault, for what defines no force.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, reduce
from typing import Any

from sympy import Dummy, Expr, Function, Integer, Max, Min, Piecewise, S, Symbol, ordered, sympify

from .errors import DeclarationError
from .names import check_law
from .parameter import Parameter
from .symbols import rate

e = Symbol("e")  # the elongation
e_dot = rate(e)  # its rate
elapsed = Symbol("elapsed")  # the time since the memory was last committed, s


def before(memory: Symbol) -> Symbol:
    """The memory as it was last committed, where the symbol itself stands for the new one."""
    return Symbol(f"{memory.name}_before")


class larger(Function):
    """The larger of two arguments: SymPy's Max without its simplification, which takes long."""

    nargs = 2

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative, by branch: where both are equal, that of the first."""
        x, y = self.args
        return where_at_least(x, y, Integer(argindex == 1), Integer(argindex == 2))

    def _latex(self, printer: Any) -> str:
        return rf"\max\left({', '.join(map(printer.doprint, self.args))}\right)"


class smaller(Function):
    """The smaller of two arguments."""

    nargs = 2

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative, by branch: where both are equal, that of the first."""
        x, y = self.args
        return where_at_least(y, x, Integer(argindex == 1), Integer(argindex == 2))

    def _latex(self, printer: Any) -> str:
        return rf"\min\left({', '.join(map(printer.doprint, self.args))}\right)"


class where_at_least(Function):
    """Of arguments a, b, x, y: x where a >= b, else y."""

    nargs = 4

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The derivative, by branch: nothing by what decides."""
        a, b, *_ = self.args
        return where_at_least(a, b, Integer(argindex == 3), Integer(argindex == 4)) if argindex > 2 else Integer(0)

    def _latex(self, printer: Any) -> str:
        a, b, x, y = map(printer.doprint, self.args)
        return rf"\begin{{cases}} {x} & {a} \geq {b} \\ {y} & \text{{else}} \end{{cases}}"


def clip(x: Any, low: Any, high: Any) -> Expr:
    """x where it lies between low and high, else the nearer of the two."""
    return larger(low, smaller(high, x))


@dataclass(frozen=True)
class Law:
    """A force over the elongation `e` and its rate `e_dot`, with memory.

    parameters: symbols with their domains. memory: symbol -> its value before the law was ever strained, an expression
    of the parameters. update: symbol -> the new memory, an expression of e, the parameters, `elapsed` and the memory
    last committed, which the symbols of the memory stand for there. The path from there to e is monotonic.
    force: of e, e_dot, and the new memory, which the symbols stand for there. stored: the energy that the force can
    give back, of e and the new memory. dissipated: what is lost between two commits, of e, the new memory, and that
    last committed, which `before(symbol)` stands for. A law of the rate alone keeps no such account.
    reference: where the law is from.

    An update must commit to itself: with the same e once more it changes nothing. The force must be continuous in e.
    Both are tried at random when the law is declared.
    """

    name: str
    parameters: tuple[Parameter, ...]
    force: Expr
    memory: Mapping[Symbol, Any] = field(default_factory=dict[Symbol, Any])
    update: Mapping[Symbol, Expr] = field(default_factory=dict[Symbol, Expr])
    stored: Expr = S.Zero
    dissipated: Expr = S.Zero
    reference: str = ""

    def __post_init__(self) -> None:
        for name in ("force", "stored", "dissipated"):
            object.__setattr__(self, name, unevaluated(sympify(getattr(self, name))))
        object.__setattr__(self, "update", {s: unevaluated(sympify(x)) for s, x in self.update.items()})
        values = {p.symbol for p in self.parameters}
        memory = set(self.memory)
        check_law(self.name, [p.symbol for p in self.parameters], [*memory, *map(before, memory)])
        if missing := sorted(memory ^ set(self.update), key=str):
            raise DeclarationError(
                f"{self.name}: expected memory and update for the same symbols, got only one of both for "
                f"'{missing[0]}'; give its start in memory={{}} and what it becomes in update={{}}"
            )
        known = values | memory | {e}
        for s in self.memory:
            self._known(f"start of {s}", sympify(self.memory[s]), values)
            self._known(f"update of {s}", self.update[s], known | {elapsed})
        self._known("force", self.force, known | {e_dot})
        self._known("stored energy", self.stored, known)
        self._known("dissipated energy", self.dissipated, known | set(map(before, memory)) | {elapsed})
        if self.force.has(e_dot) and self.dissipated != 0:
            raise DeclarationError(
                f"{self.name}: expected no account of what a force of the rate dissipates, got {self.dissipated}; "
                "leave dissipated out"
            )

    def __hash__(self) -> int:
        return hash((self.name, self.force, self.parameters))

    def _known(self, what: str, expression: Expr, allowed: set[Symbol]) -> None:
        if unknown := sorted(expression.free_symbols - allowed, key=str):
            raise DeclarationError(
                f"{self.name}: the {what} holds '{unknown[0]}', expected only "
                f"{', '.join(sorted(map(str, allowed)))}; declare it or correct the name"
            )

    @property
    def start(self) -> Mapping[Symbol, Expr]:
        """The memory before the law was ever strained."""
        return {s: sympify(x) for s, x in self.memory.items()}

    @cached_property
    def trial(self) -> Expr:
        """The force at e from the memory last committed."""
        return self.force.subs(dict(self.update), simultaneous=True)

    @cached_property
    def lost(self) -> Expr:
        """What a commit at e dissipates, of e and the memory last committed."""
        return self.dissipated.subs({**self.update, **{before(s): s for s in self.memory}}, simultaneous=True)

    def on(self, elongation: Expr, **values: Any) -> "Element":
        """The law over an elongation of a scene; values: of its parameters, in the scene's, by name."""
        return Element(self, sympify(elongation), {name: sympify(x) for name, x in values.items()})

    @property
    def of_rate(self) -> bool:
        """Whether the force depends on the rate of the elongation."""
        return self.force.has(e_dot)


@dataclass(frozen=True)
class Element:
    """A law over an elongation, an expression of a scene's coordinates; values: of the law's parameters, by name."""

    law: Law
    elongation: Expr
    values: Mapping[str, Expr]

    def __post_init__(self) -> None:
        names = [p.name for p in self.law.parameters]
        missing = [p.name for p in self.law.parameters if p.name not in self.values and p.default is None]
        if wrong := sorted(set(self.values) - set(names)) or missing:
            raise DeclarationError(
                f"{self.law.name}: expected values for {', '.join(names)}, got "
                f"{', '.join(sorted(self.values)) or 'none'}; correct {wrong[0]!r}"
            )

    def expression(self, of_law: Expr, memory: Mapping[Symbol, Symbol]) -> Expr:
        """An expression of the law in the symbols of the scene; memory: the law's symbols -> the scene's."""
        found = dict[Symbol, Expr]()
        for p in self.law.parameters:
            found[p.symbol] = self.values[p.name] if p.name in self.values else p.default.subs(found)
        found |= dict(memory) | {e: self.elongation}
        return of_law.subs(found, simultaneous=True)

    def renamed(self, names: Mapping[Symbol, Expr]) -> "Element":
        """The same with other symbols of the scene."""
        changed = {name: x.subs(names, simultaneous=True) for name, x in self.values.items()}
        return Element(self.law, self.elongation.subs(names, simultaneous=True), changed)


def unevaluated(expression: Expr) -> Expr:
    """The expression with `larger` and `smaller` in place of Max and Min."""
    if not expression.has(Max, Min):
        return expression
    args = [unevaluated(x) for x in expression.args]
    if isinstance(expression, Max | Min):
        return reduce(larger if isinstance(expression, Max) else smaller, ordered(args))
    return expression.func(*args)


def slope(expression: Expr, symbol: Expr) -> Expr:
    """The derivative, by branch: where arguments of Min or Max are equal, that of one of them."""
    if symbol not in expression.free_symbols:
        return Integer(0)
    if not expression.has(larger, smaller, where_at_least, Piecewise):
        return expression.diff(symbol)
    if isinstance(expression, larger | smaller):
        x, y = expression.args
        low, high = (y, x) if isinstance(expression, larger) else (x, y)
        return where_at_least(high, low, slope(x, symbol), slope(y, symbol))
    if isinstance(expression, where_at_least):
        a, b, x, y = expression.args
        return where_at_least(a, b, slope(x, symbol), slope(y, symbol))
    if isinstance(expression, Piecewise):
        return Piecewise(*((slope(x, symbol), condition) for x, condition in expression.args))
    parts = [Dummy() if x.has(symbol) else x for x in expression.args]
    outer = expression.func(*parts)
    moving = {part: x for part, x in zip(parts, expression.args, strict=True) if isinstance(part, Dummy)}
    total = sum((outer.diff(part) * slope(x, symbol) for part, x in moving.items()), Integer(0))
    return total.subs(moving, simultaneous=True)
