"""Linear systems of a step: solved by an elimination that is written out or, of many unknowns, by one in loops.

A system of many unknowns is an array of two matrices, row by row, each with a right side as its last column. Entries
that are not 0 are written into the first, which keeps them; the second is where `first_of` solves, and its last column
holds the unknowns. Arrays have one axis, since numba compiles a place of several some times more slowly.
"""

from sympy import Abs, Add, Expr, Function, IndexedBase, Integer, Matrix, Piecewise, Symbol

from ..motion.components import Assignments, assign

MOST = 2000  # assignments of an elimination that is written out: with more a kernel takes too long to compile


class first_of(Function):
    """The first unknown of a system, by its name and the number of its unknowns; it solves the system."""

    nargs = 2


def written_out(matrix: Matrix, *, pivoting: bool = False) -> bool:
    """Whether the elimination of a matrix is written out, as far as its entries that are 0 tell."""
    size, count = matrix.rows, 0
    rows = [{j for j in range(size) if matrix[i, j] != 0} | {size} for i in range(size)]
    for k in range(size):
        for i in (i for i in range(k + 1, size) if k in rows[i]):
            if pivoting:
                rows[k] = rows[i] = rows[k] | rows[i]
                count += 2 * len(rows[k])
            rows[i] = (rows[i] | rows[k]) - {k}
            count += len(rows[k])
        rows[k] = rows[k] - set(range(k + 1))
    return count <= MOST


def entries_of(mark: str, size: int, half: int = 0) -> Matrix:
    """The entries of a system's first matrix or, of the other half, its second, with the right side as last column."""
    array, width = IndexedBase(f"system{mark}"), size + 1
    return Matrix(size, width, lambda i, j: array[(half * size + i) * width + j])


def eliminated(
    matrix: Matrix, right: Matrix, solution: Matrix, factor: Expr, mark: str = "", *, pivoting: bool = False
) -> Assignments:
    """Gauss's elimination for the solution times factor.

    Written out it takes the order of the rows: coordinates come before multipliers, whose rows have no diagonal until
    the coordinates are eliminated. mark: the end of the names that it assigns, where a step holds several. pivoting:
    whether rows change their places, so that each pivot is the largest of its column, as where a coordinate has no mass
    but that by a constraint; in loops they always do.
    """
    if not written_out(matrix, pivoting=pivoting):
        return _in_loops(matrix, right, solution, factor, mark)
    size, found = len(solution), Assignments()
    rows = [[*matrix.row(i), right[i]] for i in range(size)]
    over = [Symbol(f"over_{k}{mark}") for k in range(size)]
    for k in range(size):
        for i in range(k + 1, size) if pivoting else ():
            found += _larger_first(rows, k, i, mark)
        found.append((over[k], 1 / rows[k][k]))
        for i in range(k + 1, size):
            if rows[i][k] == 0:
                continue
            times = Symbol(f"times_{i}_{k}{mark}")
            found.append((times, rows[i][k] * over[k]))
            for j in range(k + 1, size + 1):
                if rows[k][j] != 0:
                    left = Symbol(f"left_{k}_{i}_{j}{mark}")
                    found.append((left, rows[i][j] - times * rows[k][j]))
                    rows[i][j] = left
    for k in reversed(range(size)):
        known = Add(*(rows[k][j] * solution[j] for j in range(k + 1, size)))
        found.append((solution[k], (factor * rows[k][size] - known) * over[k]))
    return found


def _larger_first(rows: list[list[Expr]], k: int, i: int, mark: str) -> Assignments:
    """Names for the k-th row and one below it from the k-th column on, exchanged where the latter begins larger."""
    above, below, found = rows[k], rows[i], Assignments()
    if below[k] == 0:
        return found
    exchanged = Abs(below[k]) > Abs(above[k])
    for j in range(k, len(above)):
        a, b = above[j], below[j]
        if a == b == 0:
            continue
        names = [Symbol(f"{row}_{k}_{i}_{j}{mark}") for row in ("above", "below")]
        above[j], below[j] = names
        found += zip(names, (Piecewise((b, exchanged), (a, True)), Piecewise((a, exchanged), (b, True))), strict=True)
    return found


def _in_loops(matrix: Matrix, right: Matrix, solution: Matrix, factor: Expr, mark: str) -> Assignments:
    """The entries that are not 0 and not in the array yet, and the solution from it."""
    size = len(solution)
    own, whole = entries_of(mark, size), Matrix.hstack(matrix, right)
    given = [(place, e) for place, e in assign(own, whole) if e not in (0, place)]
    unknowns = entries_of(mark, size, half=1)[:, size]
    unknowns[0] = first_of(Symbol(f"system{mark}"), Integer(size))
    return [*given, *assign(solution, factor * unknowns)]
