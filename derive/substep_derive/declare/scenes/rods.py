"""Points on any number of rigid rods in a plane, in Cartesian coordinates, with the rods as constraints."""

from collections.abc import Sequence
from itertools import pairwise

from sympy import Add, Expr, Integer, Rational, Symbol

from ..errors import DeclarationError
from ..parameter import NOT_NEGATIVE, REAL
from ..scene import Scene, optional
from ..symbols import rate

L, m, v0, g = (Symbol(name) for name in ("L", "m", "v0", "g"))
_ORIGIN = (Integer(0), Integer(0))


def _square(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    """The square of the distance of two points."""
    return Add(*((p - q) ** 2 for p, q in zip(a, b, strict=True)))


def rod_chain(n: int, name: str = "") -> Scene:
    """A chain of n equal points on equal rods in a plane, straight, horizontal and at rest.

    coordinates: x1, y1, ... xn, yn, m, from the support on; constraints: rod1 ... rodn, whose multipliers times L are
    the tensions. Parameters L, m, g as of `rod_double_pendulum`, which is the chain of two. Raises DeclarationError for
    n below 1.
    """
    if n < 1:
        raise DeclarationError(f"expected a chain of one rod or more, got {n}; give n of at least 1")
    points = [(Symbol(f"x{i}"), Symbol(f"y{i}")) for i in range(1, n + 1)]
    squares = [_square(a, b) for a, b in zip(points, [_ORIGIN, *points], strict=False)]
    lengths = [Symbol(f"s{i}") for i in range(1, n + 1)]
    return Scene(
        name or f"rod_chain_{n}",
        coordinates={q: "m" for point in points for q in point},
        kinetic=m * Add(*(rate(q) ** 2 for point in points for q in point)) / 2,
        invariants=dict(zip(lengths, squares, strict=True)),
        potential=m * g * Add(*(y for _, y in points)),
        constraints={f"rod{i}": (s - L**2) / 2 for i, s in enumerate(lengths, start=1)},
        parameters=(optional(L, 1), optional(m, 1), optional(g, Rational("9.81"), NOT_NEGATIVE)),
        start={
            **{q: value for i, point in enumerate(points, start=1) for q, value in zip(point, (i * L, 0), strict=True)},
            **{rate(q): 0 for point in points for q in point},
        },
        length=L,
        energy_scale=m * g * L,
        reference=f"{n} equal points on equal rods, all horizontal and at rest",
    )


rod_double_pendulum = rod_chain(2, "rod_double_pendulum")


def four_bars(n: int) -> Scene:
    """A row of n four-bar linkages, of 2n + 1 uniform bars, whose cranks start upright with the velocity v0 at the top.

    The N-four-bar mechanism, A02 of IFToMM's library of benchmarks of multibody dynamics. coordinates: x0, y0, ... xn,
    yn, m, of the upper ends of the cranks; constraints: crank0 ... crankn and coupler1 ... couplern. Where all bars are
    in line the constraints are dependent, and there are n + 1 ways to move on. Parameters: L and m of a bar, v0 and g.
    Raises DeclarationError for n below 1.
    """
    if n < 1:
        raise DeclarationError(f"expected a row of one linkage or more, got {n}; give n of at least 1")
    tops = [(Symbol(f"x{i}"), Symbol(f"y{i}")) for i in range(n + 1)]
    ends: list[tuple[Sequence[Expr], Sequence[Expr]]] = [((i * L, Integer(0)), top) for i, top in enumerate(tops)]
    ends += pairwise(tops)
    bars = dict(
        zip([*(f"crank{i}" for i in range(n + 1)), *(f"coupler{i}" for i in range(1, n + 1))], ends, strict=True)
    )
    squares = {name: Symbol(f"s_{name}") for name in bars}
    speeds: dict[Expr, Expr] = {q: rate(q) for top in tops for q in top}
    along = [(speeds.get(p, Integer(0)), speeds[q]) for a, b in ends for p, q in zip(a, b, strict=True)]
    return Scene(
        f"four_bars_{n}",
        coordinates={q: "m" for top in tops for q in top},
        kinetic=m * Add(*((v**2 + v * w + w**2) / 6 for v, w in along)),
        invariants={squares[name]: _square(b, a) for name, (a, b) in bars.items()},
        potential=m * g * Add(*(a[1] + b[1] for a, b in ends)) / 2,
        constraints={name: (s - L**2) / 2 for name, s in squares.items()},
        parameters=(
            optional(L, 1),
            optional(m, 1),
            optional(v0, 1, REAL),
            optional(g, Rational("9.81"), NOT_NEGATIVE),
        ),
        start={
            **{q: value for i, top in enumerate(tops) for q, value in zip(top, (i * L, L), strict=True)},
            **{rate(q): value for top in tops for q, value in zip(top, (v0, 0), strict=True)},
        },
        length=L,
        energy_scale=m * g * L,
        reference="IFToMM, Library of Computational Benchmark Problems, A02: N-four-bar mechanism",
    )
