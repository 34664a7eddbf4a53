"""Mass and directions of constraints side by side, [M G^T; G 0]: a linear system for a vector and multipliers."""

from collections.abc import Sequence

from sympy import Integer, Matrix, S, Symbol, zeros

from ..motion.components import Assignments, Writer, assign
from ..motion.equations import inverted, solved
from .balance_step import Part
from .linear_system import eliminated


def held_block(
    w: Writer, places: Sequence[int], mass: Matrix, directions: Matrix, mark: str
) -> tuple[Matrix, Assignments]:
    """Names of the system's entries for some constraints, and what they are; 0 where they are 0."""
    along = directions.extract(list(places), list(range(w.size)))
    below = Matrix.hstack(along, zeros(len(places)))
    whole = w.hoisted(Matrix.vstack(Matrix.hstack(mass, along.T), below))
    names = Matrix(*whole.shape, lambda i, j: Symbol(f"entry_{mark}_{i}_{j}") if whole[i, j] != 0 else Integer(0))
    return names, [(s, e) for s, e in assign(names, whole) if e != 0]


def held_solution(w: Writer, block: Matrix, right: Matrix, mark: str) -> tuple[Matrix, Assignments, Assignments]:
    """Names of the vector and the multipliers; assignments of the right side, and what is computed from these."""
    names = Matrix([Symbol(f"off_{mark}_{j}") if e != 0 else Integer(0) for j, e in enumerate(right)])
    solution = Matrix([Symbol(f"move_{mark}_{j}") for j in range(len(right))])
    given = [(s, e) for s, e in assign(names, w.hoisted(right)) if s != 0]
    return solution, given, eliminated(block, names, solution, S.One, f"_{mark}")


def accelerated(w: Writer, mass: Matrix, force: Matrix, mark: str) -> tuple[Matrix, tuple[Part, ...]]:
    """The acceleration that a force gives, and what is computed for it where the inverse is not written out."""
    if inverted(mass):
        return solved(mass, force), ()
    block, entries = held_block(w, (), mass, zeros(0, w.size), mark)
    found, given, solve = held_solution(w, block, force, mark)
    return found, (Part([*entries, *given]), Part(solve, named=False))
