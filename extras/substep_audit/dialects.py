"""Arguments of other programs' integrators as parameters of declared schemes, as audits found them."""

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations_with_replacement
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from substep.core.arrays import Array
from substep.core.errors import called_as, real_number, unknown_name
from substep.core.schemes import Scheme
from substep.core.schemes import scheme as make_scheme

from .fit import family_of, free_parameters, rational, recognise
from .identify import agreement, identify
from .probes import given_runs, own_runs
from .program import Program
from .stepper import Stepper

TABLE = Path(__file__).parent / "dialects.json"
LARGEST = 1e6  # a larger argument stands for none, such as a yield force that is never reached
DEGREE = 3  # largest, of the polynomials by which parameters follow from arguments
MOST = 17  # points at which an integrator is identified
Term = tuple[tuple[str, ...], str]  # names of the arguments that are multiplied, and the coefficient, an exact number


@dataclass(frozen=True)
class Dialect:
    """An integrator of a program: scheme, a name of the catalogue; values: of its parameters, each a sum of terms."""

    scheme: str
    arguments: tuple[str, ...]
    values: Mapping[str, tuple[Term, ...]]

    def of(self, **arguments: float) -> Scheme:
        """The scheme that the program runs with these arguments. Raises ValueError for others, or missing ones."""
        for name in arguments:
            if name not in self.arguments:
                raise unknown_name("an argument of the integrator", name, self.arguments)
        if missing := [name for name in self.arguments if name not in arguments]:
            raise ValueError(f"expected the arguments {', '.join(self.arguments)}, got none for {', '.join(missing)}")
        given = {name: real_number(name, value) for name, value in arguments.items()}
        return make_scheme(self.scheme, **{name: _sum(terms, given) for name, terms in self.values.items()})

    @classmethod
    def from_plain(cls, entry: Mapping[str, Any]) -> "Dialect":
        """From what `to_plain` writes."""
        values = {key: tuple((tuple(names), text) for names, text in terms) for key, terms in entry["values"].items()}
        return cls(entry["scheme"], tuple(entry["arguments"]), values)

    @property
    def text(self) -> str:
        """Such as 'hht_alpha: alpha = alpha - 1', the declared parameter first, then the program's arguments."""
        values = ", ".join(f"{name} = {_written(terms)}" for name, terms in self.values.items())
        return f"{self.scheme}: {values}" if values else self.scheme


@called_as('dialect("opensees.HHT", alpha=0.9)')
def dialect(name: str, **arguments: float) -> Scheme:
    """The declared scheme that a program's integrator runs: dialect("opensees.HHT", alpha=0.9).

    name: a program and its integrator, as in the table of the conventions. arguments: those of the program's manual.
    Raises ValueError for an unknown name, and for arguments that the integrator does not take.

    >>> float(ss.dialect("opensees.HHT", alpha=0.75).parameters["alpha"])  # whose alpha is 1 + ours
    -0.25
    """
    known = dialects()
    if name not in known:
        raise unknown_name("an integrator of a program", name, known, "docs/conventions.md lists all")
    return known[name].of(**arguments)


@cache
def dialects() -> Mapping[str, Dialect]:
    """All that were found, by the name of program and integrator."""
    read: dict[str, Any] = json.loads(TABLE.read_text(encoding="utf-8")) if TABLE.exists() else {}
    return {name: Dialect.from_plain(entry) for name, entry in read.items()}


def find_dialect(program: Program, integrator: str) -> Dialect | None:
    """How the parameters follow from the numeric arguments, from identifications at several of their values.

    None where no declared scheme is found, damping and all, where the program refuses values near its own, or where
    they do not follow by polynomials of low degree with simple coefficients, which a last identification at other
    values has to confirm.
    """
    given = program.integrators[integrator].arguments
    numbers = {name: value for name, value in given.items() if isinstance(value, float) and name.isidentifier()}
    names = [name for name, value in numbers.items() if abs(value) < LARGEST]
    base = np.array([given[name] for name in names])
    change = np.round(np.random.default_rng(2).uniform(-0.12, 0.12, (MOST, len(names))), 2)
    near = np.where(base == 0.0, np.abs(change), base * (1.0 + change))
    below = np.where(base == 0.0, -np.abs(change), base * (1.0 - np.abs(change)))  # where no larger values are taken

    def stepper(point: Array) -> Stepper:
        return program.stepper(integrator, dict(zip(names, map(float, point), strict=True)))

    tried = (_through(points, stepper, names) for points in (near, below))
    return next((found for found in tried if found is not None), None)


def _through(points: Array, stepper: Callable[[Array], Stepper], names: Sequence[str]) -> Dialect | None:
    """The polynomials of least degree through what is found at the points (MOST, len(names)), as many as that needs."""
    found: list[Scheme] = []
    for degree in range(DEGREE + 1):
        terms = [term for d in range(degree + 1) for term in combinations_with_replacement(range(len(names)), d)]
        if len(terms) + 2 > MOST:
            return None
        for point in points[len(found) : len(terms) + 2]:
            scheme = _scheme_of(stepper(point), found[0] if found else None)
            if scheme is None:
                return None
            found.append(scheme)
        matrix = np.array([[prod(point[i] for i in term) for term in terms] for point in points[: len(found)]])
        factors = [tuple(names[i] for i in term) for term in terms]
        for parameters in (_parameters, family_of):
            rows = [parameters(scheme) for scheme in found]
            values = {key: _polynomial(matrix, np.array([row.get(key, np.nan) for row in rows])) for key in rows[0]}
            if all(fit is not None for fit in values.values()) and (values or not free_parameters(found[0])):
                written = {key: _terms(factors, fit) for key, fit in values.items() if fit is not None}
                return Dialect(found[0].name, tuple(names), written)
    return None


def _scheme_of(stepper: Stepper, like: Scheme | None) -> Scheme | None:
    """The scheme that does the same, of the same name as another if one is given.

    None if there is none, or the program refuses its arguments.
    """
    omegas, ratios = (0.3, 1.0, 3.0, 10.0), (0.0, 0.5)
    try:
        own = own_runs(stepper, omegas, ratios)
    except ValueError:
        return None
    free = given_runs(stepper, omegas, ratios) if "a" in stepper.can.sets else own
    if like is None:
        matches = identify(free, own).matches
        return matches[0].scheme if matches and matches[0].what != "spectrum" else None
    match = agreement(like, free, own)
    return match.scheme if match is not None and match.what != "spectrum" else None


def _parameters(scheme: Scheme) -> dict[str, float]:
    return {name: float(scheme.parameters[name]) for name in free_parameters(scheme)}


def _polynomial(matrix: Array, right: Array) -> list[tuple[float, str]] | None:
    """Simple coefficients from all points but the last, if they are right at the last one too."""
    if np.isnan(right).any():
        return None
    found = [recognise(x, 1e-6) for x in np.linalg.lstsq(matrix[:-1], right[:-1], rcond=None)[0].tolist()]
    off = np.abs(matrix @ np.array([value for value, _ in found]) - right).max()
    return found if off <= 1e-8 and all(rational(text) for _, text in found) else None


def _terms(factors: Sequence[tuple[str, ...]], fit: Sequence[tuple[float, str]]) -> tuple[Term, ...]:
    return tuple((names, text) for names, (value, text) in zip(factors, fit, strict=True) if value)


def _sum(terms: Sequence[Term], given: Mapping[str, float]) -> float:
    return sum(float(Fraction(text)) * prod(given[name] for name in factors) for factors, text in terms)


def _written(terms: Sequence[Term]) -> str:
    texts: list[str] = []
    for factors, text in sorted(terms, key=lambda term: -len(term[0])):
        powers = Counter(factors)
        product = " ".join(name if power == 1 else f"{name}^{power}" for name, power in powers.items())
        number = text.lstrip("-")
        texts.append(
            ("- " if text.startswith("-") else "+ ") + (product if number == "1" and product else f"{number} {product}")
        )
    joined = " ".join(texts).strip() or "0"
    return joined.removeprefix("+ ")


def to_plain(found: Mapping[str, Dialect]) -> dict[str, Any]:
    """What `dialects` reads."""
    return {
        name: {"scheme": d.scheme, "arguments": list(d.arguments), "values": {k: list(v) for k, v in d.values.items()}}
        for name, d in sorted(found.items())
    }
