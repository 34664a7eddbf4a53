"""The integrators that programs name, as schemes of the catalogue: from their manuals and sources, a file a program.

What was found by running a program stands in `dialects`; tests hold the two against each other.
"""

import ast
import operator
import tomllib
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from substep.core.errors import called_as, real_number, unknown_name
from substep.core.schemes import Scheme
from substep.core.schemes import scheme as make_scheme

Number = Fraction | float
LISTS = "docs/catalogue_of_programs.md lists all"
FOLDER = Path(__file__).parent / "named"
OPERATIONS: Mapping[type, Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow, ast.USub: operator.neg,
}  # fmt: skip


@dataclass(frozen=True)
class NamedIntegrator:
    """An integrator of a program, as its user names it.

    read: the file or page in which it was read. arguments: those of the program, with the text of a default, an
    expression in earlier ones, "" for none. scheme: of the catalogue, with parameters as expressions in the arguments;
    "" where it is none of them, and then `why_not` says why. when: the condition without which it is another scheme, ""
    for none. example: values of the arguments that have no default. note: what else its user must know.
    """

    program: str
    name: str
    read: str
    scheme: str = ""
    arguments: Mapping[str, str] = field(default_factory=dict[str, str])
    parameters: Mapping[str, str] = field(default_factory=dict[str, str])
    example: Mapping[str, float] = field(default_factory=dict[str, float])
    when: str = ""
    why_not: str = ""
    note: str = ""

    def __post_init__(self) -> None:
        if bool(self.scheme) == bool(self.why_not):
            raise ValueError(
                f"expected a scheme of {self.program}'s {self.name} or why there is none, got both or none"
            )

    def of(self, **given: float) -> Scheme:
        """The scheme that it is at these arguments, its own defaults for the others.

        Raises ValueError for an argument that it does not take, for one that is missing, and where it is no scheme of
        the catalogue; warns where it is this scheme under a condition only.
        """
        if self.why_not:
            raise ValueError(
                f"expected an integrator that is a scheme of the catalogue, got {self.program}'s {self.name}: "
                f"{self.why_not}"
            )
        values: dict[str, Number] = {}
        for name in given:
            if name not in self.arguments:
                raise unknown_name(f"an argument of {self.program}'s {self.name}", name, self.arguments)
        for name in sorted(given.keys() & self._read(()) - self._read(given)):
            raise ValueError(
                f"expected {name}, or all that {self.program}'s {self.name} takes from it, got both, so that nothing "
                f"is left of {name} = {given[name]}; leave one out"
            )
        for name, default in self.arguments.items():
            if name in given:
                values[name] = as_written(real_number(name, given[name]))
            elif default:
                values[name] = value_of(default, values)
            else:
                raise ValueError(f"expected {name}, which {self.program}'s {self.name} has no default for, got none")
        parameters = {name: float(value_of(text, values)) for name, text in self.parameters.items()}
        found = make_scheme(self.scheme, **parameters)
        if self.when:
            warnings.warn(f"{self.program}'s {self.name} is {found.name} {self.when} only", stacklevel=4)
        return found

    def _read(self, given: Iterable[str]) -> set[str]:
        """The arguments from which parameters follow, where defaults stand for those that are not given."""
        texts, found = [*self.parameters.values()], set[str]()
        for text in texts:
            new = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)} - found
            texts += [self.arguments[name] for name in new if name in self.arguments and name not in given]
            found |= new
        return found


def as_written(x: float) -> Fraction:
    """The number that a user writes, 9/10 for 0.9."""
    return Fraction(repr(float(x)))


def value_of(text: str, values: Mapping[str, Number]) -> Number:
    """The value of an expression in named numbers, + - * / ** and parentheses: exact but for roots.

    Raises ValueError for any other text, and where it has no real value.
    """

    def of(node: ast.AST) -> Number:
        match node:
            case ast.Expression(body):
                return of(body)
            case ast.Constant(int() | float() as number):
                return as_written(number)
            case ast.Name(name) if name in values:
                return values[name]
            case ast.UnaryOp(operation, x) if type(operation) in OPERATIONS:
                return OPERATIONS[type(operation)](of(x))
            case ast.BinOp(left, operation, right) if type(operation) in OPERATIONS:
                return OPERATIONS[type(operation)](of(left), of(right))
            case _:
                raise ValueError(f"expected an expression in {', '.join(values) or 'numbers'}, got '{text}'")

    try:
        found = of(ast.parse(text, mode="eval"))
        float(found)  # a root of a negative number is complex
        return found
    except (ArithmeticError, TypeError):
        given = ", ".join(f"{name} = {float(value):g}" for name, value in values.items())
        raise ValueError(f"expected arguments at which '{text}' has a value, got {given}; give others") from None


@cache
def named_integrators() -> Mapping[str, Mapping[str, NamedIntegrator]]:
    """By program, as it writes itself, and by the integrator's name."""
    found: dict[str, dict[str, NamedIntegrator]] = {}
    for path in sorted(FOLDER.glob("*.toml")):
        read: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        program = read["program"]
        entries = [NamedIntegrator(program, **entry) for entry in read["integrator"]]
        found[program] = {entry.name: entry for entry in entries}
        if len(found[program]) < len(entries):
            raise ValueError(f"expected each integrator once in {path.name}")
    return found


@called_as('scheme_of("OpenSees", "HHT", alpha=0.9)')
def scheme_of(program: str, integrator: str, **arguments: float) -> Scheme:
    """The scheme that a program's integrator is, by the names and arguments of its manual.

    Arguments that are not given take the program's defaults. The list of programs and integrators, with what was read
    of each, is docs/catalogue_of_programs.md. Raises ValueError for an unknown program, integrator or argument, and,
    with the reason, for an integrator that is none of the catalogue's schemes; warns where it is one under a condition
    only. `dialect` has what audits found by running the program.

    >>> s = ss.scheme_of("OpenSees", "HHT", alpha=0.9)
    >>> s.name, float(s.parameters["alpha_f"])
    ('generalized_alpha_mixed_displacement', 0.1)
    """
    programs = {name.lower(): of for name, of in named_integrators().items()}
    if program.lower() not in programs:
        raise unknown_name("a program", program, named_integrators())
    known = programs[program.lower()]
    if integrator not in known:
        raise unknown_name(f"an integrator of {program}", integrator, known, LISTS)
    return known[integrator].of(**arguments)
