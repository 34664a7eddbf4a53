"""SceneStep -> text of its march over blocks of lanes: steps outside, lanes inside, which fill vector registers.

The lines are those of the one-lane march with a name `u` replaced by `u[j]` of lane j; a name that is used in only one
loop over lanes stays a number. The result of each lane is the same as if it were marched alone: one that has converged
gets corrections of 0; one that fails keeps its state by selection, and then gives its place to a copy of another, as
one that has ended does. So no loop asks which lanes are at work, and iterations are counted once for all lanes as long
as all take the same number.
"""

from collections.abc import Iterable, Sequence
from textwrap import indent

from sympy import Expr, Matrix, Symbol

from ..kernels.scene_step import BalanceStep, SceneStep
from ..motion.components import Assignments, assign
from .printing import KernelPrinter, block, fill, lines
from .templates.scene import BLOCK, BLOCK_COUNT, BLOCK_COUNTS, BLOCK_NEWTON

WIDTH = 64  # most lanes of a block: the rows of a step fit a first cache of 32 kB
LOOP = "for j in range(begin, end):"
# arguments of the function that lanes leave by, those of Newton's counts not among them
_LEAVING = "rows", "leaves", "of_lane", "runs", "begin", "end", "place", "state", "peak"


def march_block(p: SceneStep, arguments: Sequence[str], state: Sequence[tuple[str, str]]) -> str:
    """Text of `march_block`; state: (name, its place in one lane's state)."""
    loops = _loops(p)
    loads = [f"f_{k}" for k in range(len(p.stencil))] if p.motion.is_sampled else []
    near = [str(s) for s, _ in p.near]
    held = {*_shared(p, loops), *(name for name, _ in state), *(str(s) for s, _ in p.constants), *near, *loads}
    scalars = ["h", *(s.name for s in p.parameters(p.expressions)), *(["tolerance"] if p.newton else []), "bound"]
    iterated = [k for k, step in enumerate(p.steps) if step.first is not None]
    row_of = {name: f"row_{name[:-1]}" if name.endswith("_") else f"{name}_row" for name in (*scalars, "peak")}
    rows = [*sorted(held), *row_of.values(), "seen", "leaves"]
    rows += ["size", *(f"{name}_{k}" for k in iterated for name in ("go", "idle", "sum", "most"))] if iterated else []
    names = {name: f"{name}[j]" for name in held} | {name: f"{row_of[name]}[j]" for name in scalars}
    w = KernelPrinter(names)
    leaving = [*_LEAVING, *(["newton", "common"] if iterated else [])]
    leave = f"_leave({', '.join(leaving)})"
    steps = [_given(loads)] if loads else []
    for k, bodies in zip(iterated, loops[:-1], strict=True):
        steps += [indent(f"{LOOP}\n{_bodies(w, bodies)}", "        "), _newton(w, p.steps[k], k, iterated)]
    after = {str(new): old for old, new in p.shift}
    kept = [[after.get(str(e), e) for e in vector] for vector in p.report]
    stores = [f"row[{kind}, {i}] = {w.doprint(e)}" for kind, vector in enumerate(kept) for i, e in enumerate(vector)]
    read_shift, shift = _shift(w, p.shift)
    constants = lines([*p.constants, *p.near], 2, w)
    return fill(
        BLOCK,
        width=WIDTH,
        arguments=", ".join(arguments),
        leaving=", ".join(leaving),
        results=_results(rows, iterated, state),
        rows=len(rows),
        counts=fill(BLOCK_COUNTS, balances=len(p.steps)) if iterated else "",
        allocate=_lines((f"{name} = rows[{k}]" for k, name in enumerate(rows)), 1),
        read=_lines(
            [
                *(f"{row_of[name]}[j] = {name}[lane]" for name in scalars),
                *(f"{name}[j] = state[lane, {place}]" for name, place in state),
                *(f"go_{k}[j] = 1.0" for k in iterated),
                "peak_row[j] = -np.inf",
            ],
            2,
        ),
        constants=f"    {LOOP}\n{constants}\n" if constants else "",
        leave=leave,
        waiting="        waited = False\n" if iterated else "",
        steps="".join(f"{text}\n" for text in steps),
        reported=indent(_bodies(w, loops[-1]), "        "),
        sum=" + ".join(w.doprint(Symbol(name)) for name in p.finite),
        read_shift=read_shift,
        shift=shift,
        count=_count(iterated) if iterated else "",
        store=_lines(stores, 5),
    )


def _results(rows: Sequence[str], iterated: Sequence[int], state: Sequence[tuple[str, str]]) -> str:
    """Lines that hand over what a lane's column of the rows holds."""
    at = {name: f"rows[{k}, j]" for k, name in enumerate(rows)}
    found = [f"peak[lane] = {at['peak_row']}", *(f"state[lane, {place}] = {at[name]}" for name, place in state)]
    for k in iterated:
        found += [f"newton[lane, 0, {k}] = common[0, {k}] + {at[f'sum_{k}']}"]
        found += [f"newton[lane, 1, {k}] = max(common[1, {k}], {at[f'most_{k}']})"]
    return _lines(found, 3)


# What one loop over lanes computes: lists of assignments, each with whether to name its common subexpressions.
_Loop = list[tuple[Assignments, bool]]


def _loops(p: SceneStep) -> list[_Loop]:
    """What is computed before, between and after the iterations, each in one loop over lanes."""
    found: list[_Loop] = [[(p.prior, True)]]
    for step in p.steps:
        if step.first is None:
            R = step.residual_names
            solved = assign(step.z, -step.inverse * R)
            found[-1] += [(step.before, True), (assign(R, step.residual), True), (solved, False), (step.after, True)]
        else:
            found[-1] += [(step.before, True), (assign(step.z, step.first), False)]
            found.append([(step.after, True)])
    found[-1].append(([*p.reported, (Symbol("energy"), p.energy)], True))
    return [[body for body in loop if body[0]] for loop in found]


def _shared(p: SceneStep, loops: Sequence[_Loop]) -> set[str]:
    """Names that one loop over lanes assigns and another reads."""
    groups: list[tuple[set[str], set[str]]] = []  # names that a loop assigns, and that it reads

    def group(assigned: Iterable[Symbol], read: Iterable[Expr]) -> None:
        groups.append(({str(s) for s in assigned}, {str(s) for e in read for s in e.free_symbols}))

    for loop in loops:
        group((s for body, _ in loop for s, _ in body), (e for body, _ in loop for _, e in body))
    groups[-1][1].update(p.finite, (str(new) for _, new in p.shift))
    for step in p.steps:
        if step.first is not None:
            group(step.z, [*(e for _, e in step.moving), *step.residual, *step.jacobian, *step.z])
            groups[-1][1].difference_update(str(s) for s, _ in step.moving)
    after = {str(new) for _, new in p.shift}
    group([], [e for vector in p.report for e in vector if str(e) not in after])
    return {
        name
        for k, (assigned, _) in enumerate(groups)
        for name in assigned
        if any(name in read for j, (_, read) in enumerate(groups) if j != k)
    }


def _lines(texts: Iterable[str], depth: int) -> str:
    return indent("\n".join(texts), "    " * depth)


def _bodies(w: KernelPrinter, loop: _Loop) -> str:
    return "\n".join(block(body, 1, w)[0] if named else lines(body, 1, w) for body, named in loop)


def _given(loads: Sequence[str]) -> str:
    """Lines that read the loads of a step; one row of forces may serve all lanes."""
    read = (f"{name}[j] = forces[of_lane[j] % forces.shape[0], i, {k}]" for k, name in enumerate(loads))
    return _lines([LOOP, *(f"    {line}" for line in read)], 2)


def _shift(w: KernelPrinter, shift: Assignments) -> tuple[str, str]:
    """Lines that read what a shift moves, and that select the new values: to read in a selection prevents vectors."""
    rows = dict.fromkeys(str(s) for both in shift for s in both if str(s) in w.names)
    local = KernelPrinter({name: f"j_{name}" for name in rows})
    read = lines([(f"j_{name}", Symbol(name)) for name in rows], 3, w)
    chosen = (f"{w.doprint(old)} = {local.doprint(new)} if good else {local.doprint(old)}" for old, new in shift)
    return read, _lines(chosen, 3)


def _newton(w: KernelPrinter, step: BalanceStep, k: int, iterated: Sequence[int]) -> str:
    going = Symbol(f"go_{k}")
    entries, solve, change = step.correction(going)
    # what an iteration assigns is a number, under a name of its own where other loops have the same as a row
    moving = {str(s) for s, _ in step.moving}
    names = {name: f"j_{name}" if name in moving else text for name, text in w.names.items()}
    local = KernelPrinter(names | {str(going): f"{going}[j]"})
    body = [lines(step.moving, 4, local), block(entries, 4, local)[0], lines(solve, 4, local)]
    body.append(lines([(z, z - c) for z, c in zip(step.z, change, strict=True)], 4, w))
    body.append(_lines(largest_of(change), 4))
    again = _lines((_all_go(j) for j in iterated if j <= k), 4)
    return fill(BLOCK_NEWTON, iteration="\n".join(body), balance=k, again=again).strip("\n")


def _all_go(k: int) -> str:
    """The line after which no lane waits in an iteration of balance k."""
    return f"go_{k}[j], idle_{k}[j] = 1.0, 0.0"


def _count(iterated: Sequence[int]) -> str:
    """Lines that count the iterations of a step: their sum, the most, and those of each step if asked for."""
    own, common = [], []
    for k in iterated:
        own += [f"taken = passes_{k} - idle_{k}[j]", f"sum_{k}[j] += taken", f"most_{k}[j] = max(most_{k}[j], taken)"]
        own += [_all_go(k)]
        common += [f"common[0, {k}] += passes_{k}", f"common[1, {k}] = max(common[1, {k}], passes_{k})"]
    stored = (f"iterations[j - place, i, {k}] = passes_{k} - idle_{k}[j]" for k in iterated)
    return fill(BLOCK_COUNT, own=_lines(own, 4), common=_lines(common, 3), store=_lines(stored, 5))


def largest_of(change: Matrix) -> list[str]:
    """Lines that find the largest component of the correction; a comparison is one instruction, max several."""
    first, *more = (f"abs({c})" for c in change)
    return [f"largest = {first}", *(f"largest = {c} if {c} > largest else largest" for c in more)]
