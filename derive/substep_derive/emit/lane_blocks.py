"""SceneStep -> text of its march over blocks of lanes: steps outside, lanes inside, which fill vector registers.

The lines are those of the one-lane march with a name `u` replaced by `u[j]` of lane j; a name that is used in only one
loop over lanes stays a number. A lane that has converged, failed or ended keeps its values by selection, not by a
branch, so that the result of each lane is the same as if it were marched alone.
"""

from collections.abc import Iterable, Sequence
from textwrap import indent

from sympy import Expr, Matrix, Symbol

from ..kernels.scene_step import BalanceStep, SceneStep
from ..motion.components import Assignments, assign
from .printing import KernelPrinter, block, fill, lines
from .templates.scene import BLOCK, BLOCK_COUNT, BLOCK_NEWTON

WIDTH = 64  # most lanes of a block: the rows of a step fit a first cache of 32 kB
LOOP = "for j in range(begin, end):"


def march_block(p: SceneStep, arguments: Sequence[str], state: Sequence[tuple[str, str]]) -> str:
    """Text of `march_block`; state: (name, its place in one lane's state)."""
    loops = _loops(p)
    loads = [f"f_{k}" for k in range(len(p.stencil))] if p.motion.is_sampled else []
    near = [str(s) for s, _ in p.near]
    held = {*_shared(p, loops), *(name for name, _ in state), *(str(s) for s, _ in p.constants), *near, *loads}
    scalars = ["h", *(s.name for s in p.parameters(p.expressions)), *(["tolerance"] if p.newton else []), "bound"]
    rows = [*sorted(held), *(f"{name}_" for name in (*scalars, "peak")), "running", "seen"]
    iterated = [k for k, step in enumerate(p.steps) if step.first is not None]
    rows += ["size"] if iterated else []
    rows += [f"{name}_{k}" for k in iterated for name in ("taken", "sum", "most")]
    names = {name: f"{name}[j]" for name in held} | {name: f"{name}_[j]" for name in scalars}
    w = KernelPrinter(names)
    steps = [_given(loads)] if loads else []
    for k, bodies in zip(iterated, loops[:-1], strict=True):
        start = f"\n{LOOP}\n" + _bodies(w, bodies) + f"\n    size[j], taken_{k}[j] = running[j], 0.0"
        steps += [indent(start.strip("\n"), "        "), _newton(w, p.steps[k], k, iterated)]
    after = {str(new): old for old, new in p.shift}
    kept = [[after.get(str(e), e) for e in vector] for vector in p.report]
    stores = [f"row[{kind}, {i}] = {w.doprint(e)}" for kind, vector in enumerate(kept) for i, e in enumerate(vector)]
    read_shift, shift = _shift(w, p.shift)
    constants = lines([*p.constants, *p.near], 2, w)
    counts = [f"newton[lane, {r}, {k}] = {name}_{k}[j]" for k in iterated for r, name in enumerate(("sum", "most"))]
    return fill(
        BLOCK,
        width=WIDTH,
        arguments=", ".join(arguments),
        rows=len(rows),
        allocate=_lines((f"{name} = rows[{k}]" for k, name in enumerate(rows)), 1),
        read=_lines(
            [
                *(f"{name}_[j] = {name}[lane]" for name in scalars),
                *(f"{name}[j] = state[lane, {place}]" for name, place in state),
                "peak_[j] = -np.inf",
            ],
            2,
        ),
        constants=f"    {LOOP}\n{constants}\n" if constants else "",
        not_counted=f"{_not_counted(iterated)}\n" if iterated else "",
        count=_count(iterated) if iterated else "",
        steps="".join(f"{text}\n" for text in steps),
        reported=indent(_bodies(w, loops[-1]), "        "),
        sum=" + ".join(w.doprint(Symbol(name)) for name in p.finite),
        read_shift=read_shift,
        shift=shift,
        store=_lines(stores, 5),
        write_state=_lines([*(f"state[lane, {place}] = {name}[j]" for name, place in state), *counts], 2),
    )


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
    read = (f"{name}[j] = forces[(j - place) % forces.shape[0], i, {k}]" for k, name in enumerate(loads))
    return _lines([LOOP, *(f"    {line}" for line in read)], 2)


def _shift(w: KernelPrinter, shift: Assignments) -> tuple[str, str]:
    """Lines that read what a shift moves, and that select the new values: to read in a selection prevents vectors."""
    rows = dict.fromkeys(str(s) for both in shift for s in both if str(s) in w.names)
    local = KernelPrinter({name: f"{name}_j" for name in rows})
    read = lines([(f"{name}_j", Symbol(name)) for name in rows], 3, w)
    chosen = (f"{w.doprint(old)} = {local.doprint(new)} if good else {local.doprint(old)}" for old, new in shift)
    return read, _lines(chosen, 3)


def _newton(w: KernelPrinter, step: BalanceStep, k: int, iterated: Sequence[int]) -> str:
    entries, solve, change = step.correction()
    # what an iteration assigns is a number, under a name of its own where other loops have the same as a row
    moving = {str(s) for s, _ in step.moving}
    local = KernelPrinter({name: f"{name}_j" if name in moving else text for name, text in w.names.items()})
    body = [lines(step.moving, 4, local), block(entries, 4, local)[0], lines(solve, 4, local)]
    body.append(_lines((f"{c} = {c} if going else 0.0" for c in change), 4))
    body.append(lines([(z, z - c) for z, c in zip(step.z, change, strict=True)], 4, w))
    body.append(_lines(largest_of(change), 4))
    not_counted = _not_counted([j for j in iterated if j <= k])
    return fill(BLOCK_NEWTON, iteration="\n".join(body), balance=k, not_counted=not_counted).strip("\n")


def _not_counted(iterated: Iterable[int]) -> str:
    """Lines that take back the iterations of a step that a lane does not complete."""
    return _lines((f"taken_{k}[j] = 0.0" for k in iterated), 5)


def _count(iterated: Sequence[int]) -> str:
    """Lines that add the iterations of a step to their sum, keep the most, and those of each step if asked for."""
    added = ((f"sum_{k}[j] += taken_{k}[j]", f"most_{k}[j] = max(most_{k}[j], taken_{k}[j])") for k in iterated)
    stored = (f"iterations[lane, i, {k}] = taken_{k}[place + lane]" for k in iterated)
    return fill(BLOCK_COUNT, count=_lines((line for two in added for line in two), 3), store=_lines(stored, 4))


def largest_of(change: Matrix) -> list[str]:
    """Lines that find the largest component of the correction; a comparison is one instruction, max several."""
    first, *more = (f"abs({c})" for c in change)
    return [f"largest = {first}", *(f"largest = {c} if {c} > largest else largest" for c in more)]
