"""EigenvalueKind -> text of the module that finds the roots of a polynomial, for more than three live eigenvalues.

The polynomial is that of the live eigenvalues or, where there is one, the stability polynomial: then each root stands
for itself and its conjugate.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from textwrap import indent
from typing import Any

from ..kernels.eigenvalue_kind import EigenvalueKind
from .printing import fill
from .templates.many_eigenvalues import FIND_BOTH_ROOTS, FIND_ROOTS, MORE_EIGENVALUES

WIDTH = 32  # points side by side: their coefficients and roots stay in the first cache


def coefficient_names(kind: EigenvalueKind) -> list[str]:
    """Names of the coefficients of the polynomial in a root, highest first; real and imaginary part where complex."""
    return [f"c{k}{part}" for k in range(kind.roots, -1, -1) for part in (("", "i") if kind.twice else ("",))]


def more_eigenvalues(
    kind: EigenvalueKind, small_Omega: float, sizes: Callable[[int, int, int, bool], str], **shared: Any
) -> str:
    """Text of the module for more than three live eigenvalues; sizes: text of the constant that says how many rows and
    other eigenvalues there are; shared: parts that other modules have too.
    """
    n, twice = kind.roots, kind.twice
    roots = [f"{part}{k}" for k in range(n) for part in "xy"]
    prepared = [*roots, "square"] if twice else roots  # what is known of the roots at each point, row by row
    others = [name for k in range(1 if twice else 2, n) for name in (f"h{k}", f"y{k}")]
    coefficients = coefficient_names(kind)
    scratch = [*roots, *coefficients]

    def at(wanted: Iterable[str]) -> str:
        return ", ".join(f"s[{scratch.index(name)} * {WIDTH} + j]" for name in wanted)

    return fill(
        MORE_EIGENVALUES,
        **shared,
        live=kind.live,
        of=", at most pairs of conjugates, from the roots of the stability polynomial" if twice else "",
        small_Omega=small_Omega,
        n=n,
        exponent=2**31 // n,
        low=2 * n - 1,
        high=2 * n + 1,
        low_of_square=f"{n - 1}.0 / {2 * n}.0",
        middle=2.0 - 2.0 * (n % 4),
        width=WIDTH,
        c_j=", ".join(f"({at([f'c{k}'])}, {at([f'c{k}i']) if twice else '0.0'})" for k in range(n, -1, -1)),
        z=", ".join(roots),
        z_j=at(roots),
        uv=", ".join(f"{part}{k}" for k in range(n) for part in "uv"),
        starts=_lines(_start(k, n, at([f"x{k}", f"y{k}"])) for k in range(n)),
        steps=_lines(_step(k, n) for k in range(n)),
        ends=_lines(f"{at([f'y{k}'])} = _surely_complex(x{k}, y{k}, c)" for k in range(n)),
        scratch_rows=len(scratch),
        coefficients=len(coefficients),
        first_coefficient=2 * n,
        root_rows=2 * n,
        prepared=", ".join(prepared),
        prepared_i=", ".join(_found(range(len(prepared)))),
        placed=indent("\n".join(_placed(n, twice)), "    "),
        is_complex="y0 != 0.0" if twice else "y0 > 0.0",
        others=", ".join(others),
        found_i=", ".join(_found(range(4 + len(others)))),
        find=fill(FIND_BOTH_ROOTS, root_rows=2 * n) if twice else fill(FIND_ROOTS),
        sizes=sizes(1 + len(coefficients), max(len(prepared), 4 + len(others)), len(others) // 2, twice),
    )


def _found(rows: Iterable[int]) -> Iterator[str]:
    return (f"found[{k} * BLOCK + i]" if k > 1 else ("found[i]", "found[BLOCK + i]")[k] for k in rows)


def _placed(n: int, twice: bool) -> Iterator[str]:
    """Lines that make the largest complex pair the first eigenvalue and, if pairs are two roots, the second."""
    beside = ", square" if twice else ""
    yield from (f"h{k}, l{k}, m{k} = _eigenvalue(x{k}, y{k}, near)" for k in range(n))
    yield f"square = max({', '.join(f'm{k}' for k in range(n))}{beside})"
    for k in range(1, n):
        paired, single = (f"y{k} != 0.0", "y0 == 0.0") if twice else (f"y{k} > 0.0", "y0 <= 0.0")
        yield f"swap = {paired} and ({single} or m{k} > 1.000000000002 * m0)"
        yield _swapped(0, k, "hlmy")
    for k in range(2, 0 if twice else n):
        yield f"swap = abs(h{k} - h0) + abs(y{k} + y0) < abs(h1 - h0) + abs(y1 + y0)"
        yield _swapped(1, k, "hy")


def _lines(lines: Iterable[str]) -> str:
    return indent("\n".join(lines), " " * 8)


def _start(k: int, n: int, target: str) -> str:
    size, angle = 1.0 + 0.004 * k, 2.0 * math.pi * k / n  # no two starts are equal
    c, s = f"{size * math.cos(angle):.6f}", f"{size * math.sin(angle):.6f}"
    return f"{target} = z.real + {c} * p.real - {s} * q.imag, z.imag + {s} * q.real + {c} * p.imag"


def _step(k: int, n: int) -> str:
    beside = "".join(f"(x{j}, y{j}), " for j in range(n) if j != k)
    return f"u{k}, v{k}, moved = _closer(x{k}, y{k}, ({beside.rstrip()}), c)\ncount += moved"


def _swapped(a: int, b: int, names: str) -> str:
    here = ", ".join(f"{name}{k}" for k in (a, b) for name in names)
    there = ", ".join(f"{name}{k}" for k in (b, a) for name in names)
    return f"{here} = ({there}) if swap else ({here})"
