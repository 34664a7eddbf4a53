"""Pair -> text of its march over blocks of lanes: time outside, lanes inside, so that lanes fill vector registers.

The lines are those of the one-lane march with a name `u` read as `u[j]` of lane j; what is used in one loop over
lanes only stays a number. A lane that has converged, failed or ended keeps its values by selection, not by a
branch, so that every lane comes out as if it were alone.
"""

from collections.abc import Iterable, Sequence
from textwrap import indent

from sympy import Expr, Symbol

from . import templates_scene
from .components import Assignments, assign
from .pair import Pair, Step
from .printing import KERNEL_PRINTER, block, fill

WIDTH = 32


def march_block(p: Pair, arguments: Sequence[str], state: Sequence[tuple[str, str]]) -> str:
    """Text of `march_block`; state: (name, its place in one lane's state)."""
    scalars = [*(s.name for s in p.parameters(p.expressions)), *(["tolerance"] if p.newton else []), "bound"]
    shared = _shared(p) | {name for name, _ in state} | {str(s) for s, _ in p.constants} | {"energy", "total"}
    shared |= {str(s) for s, _ in p.told}
    w = _Names(shared, {"h", *scalars}, len(p.stencil))
    numbers = [*sorted(shared), *(f"{name}_" for name in ("h", *scalars, "peak"))]
    flags = ["alive", "went", *(("busy", "failed", "count") if p.newton else ())]
    allocate = [f"{name} = numbers[{k}]" for k, name in enumerate(numbers)]
    allocate += [f"{name} = flags[{k}]" for k, name in enumerate(flags)]
    read = [f"{name}_[j] = {name}[j]" for name in ("h", *scalars)] + ["peak_[j] = -np.inf"]
    read += [f"{name}[j] = state[j, {place}]" for name, place in state]
    loops = [w.loop(p.prior, 2)] if p.prior else []
    loops += [_step(w, step, k) for k, step in enumerate(p.steps)]
    new = [after for _, after in p.shift]
    total = sorted({str(w.at(e)) for vector in (*p.report, new) for e in vector} | {"energy[j]"})
    stores = [f"row[{kind}, {i}] = {w.at(e)}" for kind, vector in enumerate(p.report) for i, e in enumerate(vector)]
    constants = _lines((f"{w.at(name)} = {w.text(e)}" for name, e in p.constants), 2)
    return fill(
        templates_scene.BLOCK,
        width=WIDTH,
        arguments=", ".join(arguments),
        rows=len(numbers),
        flag_rows=len(flags),
        allocate=_lines(allocate, 1),
        read=_lines(read, 2),
        constants=f"    for j in range(WIDTH):\n{constants}\n" if constants else "",
        loops="\n".join(loops),
        told=w.body([*p.told, (Symbol("energy"), p.energy)], 3),
        sum=" + ".join(total),
        unfailed="~failed[j] & " if p.newton else "",
        shift=_lines((f"{w.at(old)} = {w.at(after)} if went[j] else {w.at(old)}" for old, after in p.shift), 3),
        why=("NEWTON_FAILED if failed[j] else " if p.newton else "")
        + "ENERGY_BOUND if total[j] - total[j] == 0.0 else NON_FINITE",
        store=_lines(stores, 5),
        write_state=_lines((f"state[j, {place}] = {name}[j]" for name, place in state), 2),
    )


def _lines(texts: Iterable[str], depth: int) -> str:
    return indent("\n".join(texts), "    " * depth)


def _shared(p: Pair) -> set[str]:
    """Names that one loop over lanes assigns and another reads."""
    groups: list[tuple[set[str], set[str]]] = []  # assigned, read

    def group(assigned: Iterable[Symbol], read: Iterable[Expr]) -> None:
        groups.append(({str(s) for s in assigned}, {str(s) for e in read for s in e.free_symbols}))

    group((s for s, _ in p.prior), (e for _, e in p.prior))
    for step in p.steps:
        group((s for s, _ in step.before), (e for _, e in step.before))
        group(step.z, [*(step.first or step.inverse)])
        group((s for s, _ in step.moving), [*(e for _, e in step.moving), *step.residual, *step.jacobian, *step.z])
        group((s for s, _ in step.after), (e for _, e in step.after))
    group(
        (s for s, _ in p.told),
        [*(e for _, e in p.told), p.energy, *(e for v in p.report for e in v), *(e for _, e in p.shift)],
    )
    found: set[str] = set()
    for k, (assigned, _) in enumerate(groups):
        found |= {name for name in assigned if any(name in read for j, (_, read) in enumerate(groups) if j != k)}
    return found


class _Names:
    """Prints a lane's variables: numbers inside a loop, entries of arrays where loops share them."""

    def __init__(self, arrays: set[str], scalars: set[str], loads: int, local: frozenset[str] = frozenset()) -> None:
        self.arrays, self.scalars, self.local = arrays, scalars, local
        self.loads = {f"f_{k}": f"forces[j % forces.shape[0], i, {k}]" for k in range(loads)}

    def at(self, name: Expr) -> Expr:
        """u as u[j] if loops share it, an argument as its copy in the block."""
        text = str(name)
        if text in self.arrays:
            return Symbol(f"{text}[j]")
        if text in self.scalars:
            return Symbol(f"{text}_[j]")
        return Symbol(self.loads.get(text, f"{text}_j" if text in self.local else text))

    def without(self, names: Iterable[Symbol]) -> "_Names":
        """The same with some names numbers of the loop they are in."""
        local = frozenset(str(s) for s in names)
        return _Names(self.arrays - local, self.scalars, len(self.loads), local)

    def renamed(self, e: Expr) -> Expr:
        """Every name of an expression."""
        return e.subs({s: self.at(s) for s in e.free_symbols}, simultaneous=True)

    def text(self, e: Expr) -> str:
        """An expression, printed."""
        return KERNEL_PRINTER.doprint(self.renamed(e))

    def body(self, assigned: Assignments, depth: int) -> str:
        """Lines of a loop: common subexpressions, then the assignments."""
        return block([(self.at(s), self.renamed(e)) for s, e in assigned], depth)[0]

    def loop(self, assigned: Assignments, depth: int) -> str:
        """A whole loop over lanes."""
        indent = "    " * depth
        return f"{indent}for j in range(WIDTH):\n{self.body(assigned, depth + 1)}"


def _step(w: _Names, step: Step, k: int) -> str:
    if step.first is None:
        R = step.residual_names
        before = w.body(step.before, 3) + "\n" if step.before else ""
        residual = w.body(assign(R, step.residual), 3)
        solved = w.body(assign(step.z, -step.inverse * R), 3)
        after = "\n" + w.body(step.after, 3) if step.after else ""
        return f"        for j in range(WIDTH):\n{before}{residual}\n{solved}{after}"
    entries, solve, change = step.correction()
    local = w.without(s for s, _ in step.moving)  # the displacement of an iteration stays a number
    lines = [local.body(step.moving, 4), local.body(entries, 4)]
    lines.append(_lines((f"{s} = {KERNEL_PRINTER.doprint(e)}" for s, e in solve), 4))
    update = ((w.at(z), c) for z, c in zip(step.z, change, strict=True))
    lines.append(_lines((f"{z} = {z} - {c} if busy[j] else {z}" for z, c in update), 4))
    near = " & ".join(f"(abs({w.text(step.reach * c)}) <= tolerance_[j])" for c in change)
    return fill(
        templates_scene.BLOCK_NEWTON,
        before=w.body(step.before, 3),
        first="\n".join(f"            {w.at(z)} = {w.text(e)}" for z, e in zip(step.z, step.first, strict=True)),
        iteration="\n".join(lines),
        near=near,
        balance=k,
        after=w.body(step.after, 3),
    ).strip("\n")
