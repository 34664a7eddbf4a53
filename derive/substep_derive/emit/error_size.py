"""The size of the estimated errors of a step, by which it is accepted or not: the lines that compute it.

At 1 or below a step is accepted: the mean square of the errors, each relative to what is allowed of it.
"""

from sympy import Symbol

from ..declare.symbols import knot
from .lane_names import LaneNames
from .printing import KernelPrinter, block, placed


def size_of_errors(to: LaneNames) -> tuple[str, int]:
    """Lines that sum the squares of the weighted errors, and their operations."""
    p, d = to.p, len(to.d)
    end, first = _end_rows(to) if p.error_end else [], list[str]()
    if end and not p.always:
        first += [to.acceleration_at_end(to.end_a)] if p.takes_end(p.error_end) else []
        first += [*block(p.error_end, 0, to.w)[0].splitlines(), *end]
        end = []
    fast = f"{'max(' * d}speed{''.join(f', abs({e}))' for e in to.ends[1])}"
    rows, late = [f"fast = {fast}", "floor = atol_v + share_v * fast + 1e-300"], list[str]()
    for kind, (errors, base) in enumerate(((p.error_u, "atol_u"), (p.error_v, "floor"))):
        into = late if p.by_before[kind] else rows
        for i, (name, _) in enumerate(errors):
            scale = f"{base} + rtol * max(abs({to.old[kind][i]}), abs({to.ends[kind][i]}))"
            into += [f"part = {name} / ({scale})", "size += part * part"]
    if late:
        rows += ["if last == last:", *(f"    {row}" for row in late), f"    size *= {0.5 / d!r}"]
        alone = [f"size *= {1.0 / d!r}"] if not all(p.by_before) else []
        rows += ["else:", *(f"    {row}" for row in (*alone, *first))] if alone or first else []
    else:
        rows += [f"size *= {0.5 / d!r}"]
    return placed([*rows, *end, *_defect(to)], 2), 15 * d + (8 * d if end else 0)


def _end_rows(to: LaneNames) -> list[str]:
    """Lines that put the error by the acceleration at the end in the others' place where it is too large.

    Where it is not, the lengths of steps do not depend on it.
    """
    rows = ["late = 0.0"]
    for (name, _), old, new in zip(to.p.error_end, to.old[1], to.ends[1], strict=True):
        rows += [f"part = {name} / (floor + rtol * max(abs({old}), abs({new})))", "late += part * part"]
    return [*rows, f"late *= {1.0 / len(to.d)!r}", "size = size if late <= 1.0 else late"]


def _defect(to: LaneNames) -> list[str]:
    """Lines that see what a law does within a step, where a scene has laws with a memory; none where it has none.

    Yielding bends the acceleration between the ends of a step, where no estimate of higher order looks. So the
    motion between them is put into the equation of motion in the middle of the step, or where an elongation turns
    back; what is left over, acting for a quarter of the step, counts as an error of v where it is too large. How
    far an elongation goes beyond where it is committed counts as an error of u, if the force would be another one.
    """
    p = to.p
    if not to.memory[0]:
        return []
    begin, end, again = ([f"{name}_{i}" for i in to.d] for name in ("then", "now", "again"))
    middle, left = [[f"mid_{k}_{i}" for i in to.d] for k in range(3)], [f"left_{i}" for i in to.d]
    at_mid, at_end = ([f"{when}_{name}" for name in to.memory[0]] for when in ("mid", "end"))
    rows = [to.acceleration(begin, "t", *to.old[:2]), to.acceleration_at_end(end)]
    rows += ["share, turns, late = 0.5, False, 0.0"]
    for _, rate in p.elongations:
        rows += [f"rate_{k} = {to.at([rate], *x[:2])[0]}" for k, x in enumerate((to.old, to.ends))]
        rows += ["if rate_0 * rate_1 < 0.0:", "    share, turns = rate_0 / (rate_0 - rate_1), True"]
    moved = Symbol("moved")  # of which the acceleration has it over h^2: a difference of products would lose digits
    of_middle = [p.between.u, p.between.v, p.between.a.subs(knot(1).u, knot(0).u + moved).expand()]
    for i in to.d:
        both = zip((*knot(0), *knot(1)), (*to.old[:2], begin, *to.ends[:2], end), strict=True)
        difference = {moved.name: f"({to.ends[0][i]} - {to.old[0][i]})"}
        w = KernelPrinter({s.name: row[i] for s, row in both} | difference)
        motion = zip(middle, of_middle, strict=True)
        rows += block([(names[i], e) for names, e in motion], 0, w)[0].splitlines()
    rows += ["elapsed = share * h", *to.committed(at_mid, middle[0], to.memory[0])]
    rows += ["elapsed = (1.0 - share) * h", *to.committed(at_end, to.ends[0], at_mid)]
    rows += [to.acceleration(left, "t + share * h", *middle[:2], at_mid)]
    rows += [to.acceleration(again, "end", *to.ends[:2], at_end)]
    for i in to.d:
        scale = f"floor + rtol * max(abs({to.old[1][i]}), abs({to.ends[1][i]}))"
        rows += [f"part = 0.25 * h * ({left[i]} - {middle[2][i]}) / ({scale})", "late += part * part"]
    rows += [f"late *= {1.0 / len(to.d)!r}", "size = size if late <= 1.0 else late"]
    differ = " or ".join(f"abs({x} - {y}) > 1e-9 * abs({y})" for x, y in zip(again, end, strict=True))
    rows += [f"if turns and ({differ}):"]
    for elongation, _ in p.elongations:
        old, new, mid = (to.at([elongation], *x)[0] for x in (to.old[:2], to.ends[:2], middle[:2]))
        rows += [f"    old, new, mid = {old}, {new}, {mid}", "    part = min(abs(mid - old), abs(mid - new))"]
        rows += [
            "    part /= atol_u + rtol * max(abs(old), abs(new)) + 1e-300",
            "    size = max(size, part * part)",
        ]
    return rows
