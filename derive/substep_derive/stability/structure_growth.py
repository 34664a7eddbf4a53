"""Structures that make a scheme grow: the exact step of rational matrices, and a search among small structures.

A growth is claimed only where the characteristic polynomial of the step, over the field of the parameters, has a root
outside the unit circle by Routh's array.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import reduce
from itertools import count, islice
from typing import Any

from sympy import QQ, Symbol

from ..algebra.field_matrices import FieldMatrix, field_matrix, identity
from ..algebra.points import RationalPoint, ring_over
from ..declare.symbols import Omega
from .hurwitz import Verdict, bilinear, verdict
from .structure_form import Rows

Matrix = tuple[tuple[Fraction, ...], ...]
Structure = tuple[Matrix, Matrix, Matrix]  # h-scaled: M, h C, h^2 K
TRIED = 400
TRIED_IRRATIONAL = 40  # over a field of algebraic numbers, where a step takes longer


def solved(rows: Rows, structure: Sequence[FieldMatrix]) -> dict[Symbol, FieldMatrix]:
    """Each symbol of the step (n, n states) in terms of its old state, for M, h C, h^2 K (n, n) over one domain.

    All relations and balances of the step are one system, solved exactly. The domain is that of the parameters, or
    rational functions over it.
    """
    domain, n = structure[0].domain, structure[0].shape[0]
    matrices, lift = [part.to_list() for part in structure], lifted(rows, domain)
    place = {s: i * n for i, s in enumerate(rows.symbols)}
    unknown, width = len(rows.step.unknowns) * n, len(rows.symbols) * n
    system = [[domain.zero] * width for _ in range(unknown)]
    top = 0
    for relation in rows.relations:
        for s, c in relation.items():
            for i in range(n):
                system[top + i][place[s] + i] = lift(c)
        top += n
    for balance in rows.balances:
        for part, row in zip(matrices, balance, strict=True):
            for s, c in row.items():
                for i in range(n):
                    for j in range(n):
                        system[top + i][place[s] + j] += lift(c) * part[i][j]
        top += n
    both = field_matrix(system, domain)
    found = (-both[:, :unknown].lu_solve(both[:, unknown:])).to_dense()
    whole = found.vstack(identity(width - unknown, domain))
    return {s: whole[i : i + n, :] for s, i in place.items()}


def lifted(rows: Rows, domain: Any) -> Callable[[Any], Any]:
    """How a number of the parameters' field becomes one of the domain."""
    return (lambda c: c) if domain == rows.field.domain else domain.field.ground_new


def exact(rows: Rows, structure: Structure) -> list[FieldMatrix]:
    """M, h C, h^2 K over the parameters' field."""
    domain = rows.field.domain
    return [
        field_matrix([[domain.convert(QQ(e.numerator, e.denominator)) for e in row] for row in part], domain)
        for part in structure
    ]


def step_matrix(rows: Rows, structure: Structure) -> FieldMatrix:
    """A with x_1 = A x_0 for M, h C, h^2 K."""
    found = solved(rows, exact(rows, structure))
    return stacked(found[s] for s in rows.step.after)


def stacked(parts: Iterable[FieldMatrix]) -> FieldMatrix:
    """The matrices below each other."""
    return reduce(lambda above, below: above.vstack(below), parts)


def where(rows: Rows, structure: Structure) -> Verdict:
    """Where the eigenvalues of the exact step lie; a multiple one on the circle may be semisimple."""
    ring = ring_over(rows.field, Omega)
    descending = step_matrix(rows, structure).charpoly()
    p = [ring.ground_new(c) for c in reversed(descending)]
    while not p[0]:
        p = p[1:]
    return verdict(bilinear(p), RationalPoint(rows.field, QQ(0)))


def oscillator(stiffness: Any, damping: Any = 0) -> Structure:
    """One degree of freedom with M = 1: h^2 K and h C."""
    return tuple(
        ((Fraction(int(QQ.convert(x).numerator), int(QQ.convert(x).denominator)),),) for x in (1, damping, stiffness)
    )  # type: ignore[return-value]


def candidates(bound: tuple[Fraction, Fraction | None] | None) -> Iterator[Structure]:
    """Two modes of rational frequencies with one damper across them, by Halton's points.

    bound: (W, D), for only those with h^2 K/W + h C/D < M, where D None leaves damping free.
    """
    for k in count(1):
        a, b, c, d = (_halton(k, base) for base in (2, 3, 5, 7))
        low, high, damper = (Fraction(2 ** (x * 14 - 5)).limit_denominator(64) for x in (a, b, c))
        p, q = Fraction(round(16 * d), 16), 1 - Fraction(round(16 * d), 16)
        if bound is not None:
            W, D = bound
            share = Fraction(1) if D is None else 1 - Fraction(round(30 * c) + 1, 33)
            low, high = (W * share * Fraction(round(62 * x) + 1, 64) for x in (a, b))
            damper = damper if D is None else D * (1 - share) * Fraction(31, 32) / (p * p + q * q)
        yield (
            ((Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))),
            ((damper * p * p, damper * p * q), (damper * p * q, damper * q * q)),
            ((low, Fraction(0)), (Fraction(0), high)),
        )


def growing(rows: Rows, structures: Iterator[Structure]) -> tuple[Structure | None, int]:
    """The first structure whose step has an eigenvalue outside the circle, exactly, and how many were tried."""
    tried = 0
    most = TRIED_IRRATIONAL if rows.field.algebraic else TRIED
    for tried, structure in enumerate(islice(structures, most), 1):
        if where(rows, structure) is Verdict.OUTSIDE:
            return structure, tried
    return None, tried


def _halton(k: int, base: int) -> float:
    found, share = 0.0, 1.0
    while k:
        share /= base
        found += share * (k % base)
        k //= base
    return found


def as_text(matrix: Sequence[Sequence[Fraction]]) -> str:
    """A matrix in one line."""
    return "[" + ", ".join("[" + ", ".join(map(str, row)) + "]" for row in matrix) + "]"
