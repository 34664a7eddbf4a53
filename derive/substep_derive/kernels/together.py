"""The unknowns of a stage, the accelerations of one balance or of several that are solved together, in components."""

from collections.abc import Callable, Iterable, Mapping

from sympy import Abs, Add, Expr, Integer, Matrix, Symbol, cancel, zeros

from ..declare.symbols import h
from ..motion.components import Assignments, Writer, assign
from ..step.step import Stage

Reach = Mapping[Symbol, list[Expr]]  # of each displacement that moves, its derivatives by the accelerations


def reached(
    w: Writer, stage: Stage, z: Matrix, solved: Callable[[Expr], Matrix]
) -> tuple[Reach, Assignments, Assignments]:
    """What moves with z, assignments of its predictors, and those of it from these.

    solved: components of an expression in z and what is known.
    """
    parts, at_zero = split(w, z), dict.fromkeys(z, Integer(0))
    reach, before, after = dict[Symbol, list[Expr]](), Assignments(), Assignments()
    for number, s in enumerate(sorted(stage.moved, key=str)):
        whole, predictor = solved(s), w.components(predicted(number))
        w.instants |= {predicted(number): w.instants[s]} if s in w.instants else {}
        reach[s] = [whole[0].diff(part[0]) for part in parts]
        before += assign(predictor, whole.subs(at_zero))
        after += assign(w.components(s), combined(predictor, reach[s], parts))
    return reach, before, after


def unknowns(w: Writer, stage: Stage) -> Matrix:
    """The components of all accelerations of a stage, one after the other."""
    return Matrix([s for z in stage.z for s in w.components(z)])


def split(w: Writer, z: Matrix) -> list[Matrix]:
    """The components of each acceleration."""
    return [z[k : k + w.size, :] for k in range(0, len(z), w.size)]


def combined(start: Matrix, by: Iterable[Expr], parts: Iterable[Matrix]) -> Matrix:
    """start plus vectors times numbers."""
    return sum((c * part for c, part in zip(by, parts, strict=True)), start)


def begun_together(
    w: Writer, stage: Stage, reach: Reach, last: Symbol, solved: Callable[[Expr], Matrix]
) -> tuple[Matrix, Expr]:
    """Where the iteration of balances that are solved together starts, and how far it moves a displacement.

    It starts from accelerations at which displacements that move are where the last one was.
    """
    parts, typical = split(w, unknowns(w, stage)), {**w.scheme.typical, h: Integer(1)}

    def farthest(rows: Iterable[Iterable[Expr]]) -> Expr:
        sums = [Add(*map(Abs, row)) for row in rows]
        sizes = [e.subs(dict(w.constants)).subs(typical) for e in sums]
        return sums[sizes.index(max(sizes))] if sums else Integer(0)

    far = farthest(reach.values())
    if w.motion.of_rates or not reach:
        far += farthest([h * solved(b.damping)[0].diff(part[0]) for part in parts] for b in stage.balances)
    by_z = Matrix([*reach.values()]).subs(dict(w.constants))
    if by_z.rows != by_z.cols or cancel(by_z.det()) == 0:
        return zeros(w.size * len(stage.z), 1), far
    away = [w.components(last) - w.components(predicted(number)) for number in range(by_z.rows)]
    rows = [[w.constant(cancel(e)) for e in row] for row in by_z.inv().tolist()]
    return Matrix([e for row in rows for e in combined(zeros(w.size, 1), row, away)]), far


def predicted(k: int) -> Symbol:
    """Symbol of a balance's predictor, a displacement at z = 0; k counts them where a force takes two displacements."""
    return Symbol(f"u_*star{k or ''}")
