"""The declaration of a law with memory: a scalar relation between an elongation and a force.

Raises `DeclarationError`, which names the expression at fault, for what defines no force.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from sympy import Expr, S, Symbol

from .branches import by_branch
from .errors import DeclarationError
from .expressions import alike, expression, require_known, require_mapping
from .joined import joined
from .names import check_law
from .parameter import Parameter, require_parameters
from .symbols import rate

e = Symbol("e")  # the elongation
e_dot = rate(e)  # its rate
elapsed = Symbol("elapsed")  # the time since the memory was last committed, s


def before(memory: Symbol) -> Symbol:
    """The memory as it was last committed, where the symbol itself stands for the new one."""
    return Symbol(f"{memory.name}_before")


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
        if not isinstance(self.name, str):  # pyright: ignore[reportUnnecessaryIsInstance] (a user gives it)
            raise DeclarationError(f"expected the name of a law as a text, got {self.name!r}; name it")
        require_parameters(self.name, self.parameters)
        for name in ("force", "stored", "dissipated"):
            object.__setattr__(self, name, by_branch(expression(self.name, f"{name} of a law", getattr(self, name))))
        object.__setattr__(self, "force", joined(self.force, e, self.parameters))
        for name in ("memory", "update"):
            require_mapping(self.name, name, getattr(self, name), Symbol)
            given = {s: expression(self.name, f"{name} of {s}", x) for s, x in getattr(self, name).items()}
            object.__setattr__(self, name, {s: joined(by_branch(x), e, self.parameters) for s, x in given.items()})
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
            require_known(self.name, f"start of {s}", self.memory[s], values)
            require_known(self.name, f"update of {s}", self.update[s], known | {elapsed})
        require_known(self.name, "force", self.force, known | {e_dot})
        require_known(self.name, "stored energy", self.stored, known)
        require_known(self.name, "dissipated energy", self.dissipated, known | set(map(before, memory)) | {elapsed})
        if self.force.has(e_dot) and self.dissipated != 0:
            raise DeclarationError(
                f"{self.name}: expected no account of what a force of the rate dissipates, got {self.dissipated}; "
                "leave dissipated out"
            )

    def __eq__(self, other: object) -> bool:
        return alike(self, other)

    def __hash__(self) -> int:
        return hash((self.name, self.force, self.parameters))

    @property
    def start(self) -> Mapping[Symbol, Expr]:
        """The memory before the law was ever strained."""
        return self.memory

    @cached_property
    def trial(self) -> Expr:
        """The force at e from the memory last committed."""
        return self.force.xreplace(dict(self.update))

    @cached_property
    def lost(self) -> Expr:
        """What a commit at e dissipates, of e and the memory last committed."""
        return self.dissipated.xreplace({**self.update, **{before(s): s for s in self.memory}})

    def on(self, elongation: Expr, **values: Any) -> "Element":
        """The law over an elongation of a scene; values: of its parameters, in the scene's, by name."""
        return Element(self, elongation, values)

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
        given = {name: expression(self.law.name, f"a {name}", x) for name, x in self.values.items()}
        object.__setattr__(self, "values", given)
        elongation = by_branch(expression(self.law.name, "an elongation", self.elongation))
        object.__setattr__(self, "elongation", elongation)
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
        # xreplace and not subs, which compares the branches of a Piecewise with each other and takes seconds
        return of_law.xreplace({**found, **memory, e: self.elongation})

    def renamed(self, names: Mapping[Symbol, Expr]) -> "Element":
        """The same with other symbols of the scene."""
        changed = {name: x.subs(names, simultaneous=True) for name, x in self.values.items()}
        return Element(self.law, self.elongation.subs(names, simultaneous=True), changed)
