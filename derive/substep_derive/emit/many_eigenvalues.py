"""EigenvalueKind -> text of the module that finds the roots of a polynomial, for more than three live eigenvalues.

The polynomial is that of the live eigenvalues or, where there is one, the stability polynomial: then each root stands
for itself and its conjugate. The text has four parts: a guess of all roots at once; Aberth's iteration of all roots, at
many points side by side; which eigenvalues the roots stand for, the largest complex pair first; and the call of these.
"""

import math
from collections.abc import Callable, Iterable, Sequence

from ..kernels.eigenvalue_kind import EigenvalueKind
from .printing import fill, placed
from .templates.many_eigenvalues import (
    EIGENVALUE_OF_ROOT,
    FIND_BOTH_ROOTS,
    FIND_ROOTS,
    FIRST_GUESS,
    MORE_EIGENVALUES,
    PLACED,
    ROOTS_OF_A_BLOCK,
)

WIDTH = 32  # points side by side: their coefficients and roots stay in the first cache


def coefficient_names(kind: EigenvalueKind) -> list[str]:
    """Names of the coefficients of the polynomial in a root, highest first; real and imaginary part where complex."""
    return [f"c{k}{part}" for k in range(kind.roots, -1, -1) for part in (("", "i") if kind.twice else ("",))]


def more_eigenvalues(
    kind: EigenvalueKind, small_Omega: float, sizes: Callable[[int, int, int, bool], str], **shared: str
) -> str:
    """Text of the module for more than three live eigenvalues; sizes: text of the constant that says how many rows and
    other eigenvalues there are; shared: parts that other modules have too.
    """
    roots = [f"{part}{k}" for k in range(kind.roots) for part in "xy"]
    prepared = [*roots, "square"] if kind.twice else roots  # what is known of the roots at each point, row by row
    others = [name for k in range(1 if kind.twice else 2, kind.roots) for name in (f"h{k}", f"y{k}")]
    known = max(len(prepared), 4 + len(others))
    rows = sizes(1 + len(coefficient_names(kind)), known, len(others) // 2, kind.twice)
    conjugates = ", at most pairs of conjugates, from the roots of the stability polynomial" if kind.twice else ""
    parts = [
        fill(MORE_EIGENVALUES, live=kind.live, of=conjugates, sizes=rows, **shared),
        _first_guess(kind.roots),
        fill(EIGENVALUE_OF_ROOT, small_Omega=small_Omega),
        _roots(kind, roots),
        _placed(kind, prepared, others),
        fill(FIND_BOTH_ROOTS, root_rows=len(roots)) if kind.twice else fill(FIND_ROOTS),
    ]
    return "".join(parts)


def _first_guess(n: int) -> str:
    """Roots of the Chebyshev polynomial that is close to a polynomial of degree n."""
    return fill(
        FIRST_GUESS,
        n=n,
        exponent=2**31 // n,
        low=2 * n - 1,
        high=2 * n + 1,
        low_of_square=f"{n - 1}.0 / {2 * n}.0",
        middle=2.0 - 2.0 * (n % 4),
    )


def _roots(kind: EigenvalueKind, roots: Sequence[str]) -> str:
    """The iteration; in its scratch, each root and each coefficient has a row of all points."""
    n, coefficients = kind.roots, coefficient_names(kind)
    row = {name: k for k, name in enumerate([*roots, *coefficients])}

    def at(*names: str) -> str:
        return ", ".join(f"s[{row[name]} * {WIDTH} + j]" for name in names)

    pairs = (f"({at(f'c{k}')}, {at(f'c{k}i') if kind.twice else '0.0'})" for k in range(n, -1, -1))
    return fill(
        ROOTS_OF_A_BLOCK,
        width=WIDTH,
        c_j=", ".join(pairs),
        z=", ".join(roots),
        z_j=at(*roots),
        uv=", ".join(f"{part}{k}" for k in range(n) for part in "uv"),
        starts=placed((_start(k, n, at(f"x{k}", f"y{k}")) for k in range(n)), 2),
        steps=placed((_step(k, n) for k in range(n)), 2),
        ends=placed((f"{at(f'y{k}')} = _surely_complex(x{k}, y{k}, c)" for k in range(n)), 2),
        scratch_rows=len(row),
        coefficients=len(coefficients),
        first_coefficient=len(roots),
        root_rows=len(roots),
    )


def _start(k: int, n: int, target: str) -> str:
    """The line of the k-th guess; no two are equal."""
    size, angle = 1.0 + 0.004 * k, 2.0 * math.pi * k / n
    c, s = f"{size * math.cos(angle):.6f}", f"{size * math.sin(angle):.6f}"
    return f"{target} = z.real + {c} * p.real - {s} * q.imag, z.imag + {s} * q.real + {c} * p.imag"


def _step(k: int, n: int) -> str:
    """The lines of a step of the k-th root, which the others repel."""
    beside = "".join(f"(x{j}, y{j}), " for j in range(n) if j != k)
    return f"u{k}, v{k}, moved = _closer(x{k}, y{k}, ({beside.rstrip()}), c)\ncount += moved"


def _placed(kind: EigenvalueKind, prepared: Sequence[str], others: Sequence[str]) -> str:
    """The largest complex pair becomes the first eigenvalue and, if pairs are two roots, the second."""
    n, twice = kind.roots, kind.twice
    rows = [f"h{k}, l{k}, m{k} = _eigenvalue(x{k}, y{k}, near)" for k in range(n)]
    rows += [f"square = max({', '.join(f'm{k}' for k in range(n))}{', square' if twice else ''})"]
    for k in range(1, n):
        paired, single = (f"y{k} != 0.0", "y0 == 0.0") if twice else (f"y{k} > 0.0", "y0 <= 0.0")
        rows += [f"swap = {paired} and ({single} or m{k} > 1.000000000002 * m0)", _swapped(0, k, "hlmy")]
    for k in range(2, 0 if twice else n):
        rows += [f"swap = abs(h{k} - h0) + abs(y{k} + y0) < abs(h1 - h0) + abs(y1 + y0)", _swapped(1, k, "hy")]
    return fill(
        PLACED,
        prepared=", ".join(prepared),
        prepared_i=", ".join(_found(range(len(prepared)))),
        placed=placed(rows, 1),
        is_complex="y0 != 0.0" if twice else "y0 > 0.0",
        others=", ".join(others),
        found_i=", ".join(_found(range(4 + len(others)))),
    )


def _found(rows: Iterable[int]) -> Iterable[str]:
    """Texts of rows of `found` at the i-th point."""
    return (f"found[{k} * BLOCK + i]" if k > 1 else ("found[i]", "found[BLOCK + i]")[k] for k in rows)


def _swapped(a: int, b: int, names: str) -> str:
    here = ", ".join(f"{name}{k}" for k in (a, b) for name in names)
    there = ", ".join(f"{name}{k}" for k in (b, a) for name in names)
    return f"{here} = ({there}) if swap else ({here})"
