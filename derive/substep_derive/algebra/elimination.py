"""Linear systems of polynomials over a field: numbers first, since a step's equations have few other pivots.

Matrices are rows of elements of a domain of polynomials, such as QQ[x, y].
"""

from collections.abc import Iterable, Sequence
from typing import Any

from sympy.polys.matrices.exceptions import DMNonInvertibleMatrixError as SingularMatrix

Rows = list[list[Any]]


def eliminated(rows: Sequence[Sequence[Any]], columns: int, field: Any) -> tuple[dict[int, int], Rows, list[Any]]:
    """Gauss's elimination with pivots that are numbers, as long as there are any, in the first columns.

    (column -> its row, the rows, the pivots). A row with a pivot is divided by it, and its column is 0 elsewhere.
    """
    found, taken, pivots = [list(row) for row in rows], {}, []
    while True:
        best: tuple[int, int, int] | None = None
        open_rows = [i for i in range(len(found)) if i not in taken.values()]
        counts = {j: sum(bool(found[i][j]) for i in open_rows) for j in range(columns) if j not in taken}
        for i in open_rows:
            entries = sum(map(bool, found[i])) - 1
            for j, count in counts.items():
                if found[i][j] and found[i][j].is_ground and (best is None or entries * (count - 1) < best[0]):
                    best = entries * (count - 1), i, j
        if best is None:
            return taken, found, pivots
        _, i, j = best
        pivots.append(found[i][j].coeff(1))
        inverse = field.one / pivots[-1]
        found[i] = [e.mul_ground(inverse) for e in found[i]]
        for k, row in enumerate(found):
            if k != i and row[j]:
                factor = row[j]
                found[k] = [e - factor * own if own else e for e, own in zip(row, found[i], strict=True)]
        taken[j] = i


def solution(rows: Sequence[Sequence[Any]], n: int, domain: Any) -> tuple[Rows, Any]:
    """(numerators, den) with matrix * numerators/den = right, where a row is n entries of the matrix, then the right's.

    Raises SingularMatrix for a singular matrix.
    """
    taken, found, _ = eliminated(rows, n, domain.domain)
    left = [j for j in range(n) if j not in taken]
    open_rows = [i for i in range(len(found)) if i not in taken.values()]
    if len(open_rows) != len(left):
        raise SingularMatrix("the matrix is singular")
    solved: dict[int, list[Any]] = {}
    den, width = domain.one, len(found[0]) - n
    if left:
        den, numerators = _by_minors([[found[i][j] for j in (*left, *range(n, n + width))] for i in open_rows], domain)
        if not den:
            raise SingularMatrix("the matrix is singular")
        solved = dict(zip(left, numerators, strict=True))
    for j, i in taken.items():
        solved[j] = [
            own * den - sum((found[i][k] * solved[k][c] for k in left), domain.zero)
            for c, own in enumerate(found[i][n:])
        ]
    return [solved[j] for j in range(n)], den


def determinant(rows: Sequence[Sequence[Any]], domain: Any) -> Any:
    """The determinant of a square matrix."""
    n = len(rows)
    taken, found, pivots = eliminated(rows, n, domain.domain)
    left = [j for j in range(n) if j not in taken]
    open_rows = [i for i in range(n) if i not in taken.values()]
    permutation = [taken.get(j, -1) for j in range(n)]
    for i, j in zip(open_rows, left, strict=True):
        permutation[j] = i
    sign = (-1) ** sum(a > b for k, a in enumerate(permutation) for b in permutation[k + 1 :])
    total = domain.one
    if left:
        total, _ = _by_minors([[found[i][j] for j in left] for i in open_rows], domain)
    for pivot in pivots:
        total = total.mul_ground(pivot)
    return total * sign


def _by_minors(rows: Rows, domain: Any) -> tuple[Any, Rows]:
    """(determinant, numerators by Cramer's rule) of a square matrix with right sides beside it, without a division.

    The minors of the first rows, by their columns, give those of one row more by Laplace's expansion; few of them are
    not 0 where balances are solved one after the other.
    """
    n = len(rows)
    sides = range(n, len(rows[0]))
    own: dict[int, Any] = {0: domain.one}  # columns as bits -> minor
    with_side: list[dict[int, Any]] = [{} for _ in sides]  # the same with a right side as the last column
    order = sorted(range(n), key=lambda i: sum(map(bool, rows[i][:n])))
    for i in order:
        row = rows[i]
        with_side = [
            _expanded([(minors, row[:n], -1), (own, [domain.zero] * n + [row[c]], 1)], n)
            for minors, c in zip(with_side, sides, strict=True)
        ]
        own = _expanded([(own, row[:n], 1)], n)
    sign = (-1) ** sum(a > b for k, a in enumerate(order) for b in order[k + 1 :])
    full = 2**n - 1
    numerators = [
        [minors.get(full - 2**j, domain.zero) * (sign * (-1) ** (n - 1 - j)) for minors in with_side] for j in range(n)
    ]
    return own.get(full, domain.zero) * sign, numerators


def _expanded(parts: Iterable[tuple[dict[int, Any], Sequence[Any], int]], n: int) -> dict[int, Any]:
    """Minors with one row more, from (minors, the row's entries, sign); the n-th entry belongs to the side's column."""
    found: dict[int, Any] = {}
    for minors, row, sign in parts:
        for columns, minor in minors.items():
            for j, entry in enumerate(row):
                if not entry or (j < n and columns >> j & 1):
                    continue
                key = columns | 1 << j if j < n else columns
                passed = (columns >> j).bit_count() if j < n else 0
                share = minor * entry
                if (sign < 0) != bool(passed % 2):
                    share = -share
                found[key] = found[key] + share if key in found else share
    return {key: value for key, value in found.items() if value}
