"""Body x Clock x Layout -> text of one step, in every kernel that marches a scheme on a scene.

A clock says how the time of a lane goes on, a layout where the numbers of lanes lie, a body what a step computes.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from sympy import Matrix, S, Symbol

from ..declare.symbols import h, t
from ..kernels.balance_step import BalanceStep, Part
from ..kernels.body import Body
from ..kernels.linear_system import first_of
from ..motion.components import Assignments
from .printing import KernelPrinter, block, fill, lines, operations, placed
from .templates.step import NEWTON_FAILED, NOT_CONVERGED


@dataclass(frozen=True)
class Clock:
    """How the time of a lane goes on.

    load: text of a load, the `k`-th of the stencil, which is that at the time `at`; `lane` is as in `Layout`. failed:
    lines that leave a step of which an iteration does not converge, where a function marches one lane.
    """

    load: str
    failed: str


# the table of clocks: steps of one length, whose loads are given; and steps that are chosen
DT = Clock("forces[{lane}i, {k}]", NEWTON_FAILED)
TOL = Clock("_load(load, samples, middle, {at})", NOT_CONVERGED)

SETTLING = 12  # iterations in which pressures and frictions have to settle


@dataclass(frozen=True)
class Layout:
    """Where the numbers of lanes lie: a row of the table in `pair_module`.

    each: the line above lines that are done for each lane; empty where a function marches one lane. newton: the text of
    an iteration. lane: which lane's loads are read, in an array of those of all. names: of a body, the texts of the
    variables that are not numbers under their own names. march: text of the functions that march all lanes in steps of
    one length, from the body, the text of its step and the names of the march's arguments.
    """

    each: str
    newton: str
    lane: str
    names: Callable[[Body], Mapping[str, str]]
    march: Callable[[Body, "StepText", Sequence[str]], str]

    @property
    def depth(self) -> int:
        """Indentation of the lines of a lane."""
        return 3 if self.each else 2


@dataclass(frozen=True)
class StepText:
    """Text of one step. phases: all but the last, which the results close; operations: of a step, of each iteration.

    rooms: lines that make the arrays of the systems that it solves, once a run.
    """

    phases: str
    last: str
    operations: dict[str, object]
    printer: KernelPrinter
    rooms: list[str]


def step_text(body: Body, clock: Clock, layout: Layout, results: Iterable[Part | str]) -> StepText:
    """What a step computes; results: what follows its phases, in the same lines of a lane as the last of them."""
    to = _Writer(clock, layout, KernelPrinter(layout.names(body)))
    *phases, last = body.phases
    texts = [to.loads(body)] if body.loads else []
    for phase in phases:
        texts.append(to.newton(phase) if isinstance(phase, BalanceStep) else to.each(to.straight(phase)))
    assert isinstance(last, tuple)  # as `phases` says
    text = to.straight([*last, *results])
    found = {"step": to.operations, "iteration": tuple(to.of_iterations)}
    return StepText("".join(f"{text}\n" for text in texts), text, found, to.printer, list(to.rooms))


class _Writer:
    """Writes the phases of a step, and counts their operations."""

    def __init__(self, clock: Clock, layout: Layout, printer: KernelPrinter) -> None:
        self.clock, self.layout, self.printer = clock, layout, printer
        self.operations, self.of_iterations, self.rooms = 0, list[int](), dict[str, None]()

    def each(self, text: str) -> str:
        """The lines of a lane, for each lane."""
        return "\n".join([*([placed([self.layout.each], 2)] if self.layout.each else []), text])

    def loads(self, body: Body) -> str:
        """Lines that read the loads of a step; side by side a number where all lanes share them, else a row."""
        instants = [self.printer.doprint(t + tau * h) for tau in body.stencil]

        def of(lane: str) -> list[str]:
            return [self.clock.load.format(lane=lane, k=k, at=at) for k, at in enumerate(instants)]

        if not self.layout.each:
            read = (f"{s} = {text}" for s, text in zip(body.loads, of(self.layout.lane), strict=True))
            return placed(read, self.layout.depth)
        common = [f"common_{k} = {text} if forces.shape[0] == 1 else 0.0" for k, text in enumerate(of("0, "))]
        own = (f"    {s}[j] = {text}" for s, text in zip(body.loads, of(self.layout.lane), strict=True))
        own = placed([self.layout.each, *own], 3)
        return "\n".join([placed([*common, "if forces.shape[0] > 1:"], 2), own])

    def straight(self, parts: Sequence[Part | str]) -> str:
        """Lines of assignments."""
        texts: list[str] = []
        for part in parts:
            if isinstance(part, str):
                texts.append(placed([part], self.layout.depth))
            elif part.assignments:
                text, count = self._part(part, self.layout.depth, self.printer)
                texts.append(text)
                self.operations += count
        return "\n".join(texts)

    def newton(self, step: BalanceStep) -> str:
        """An iteration: all that it assigns but the unknown is a number, of a name that no other variable has."""
        k, depth, names = step.k, self.layout.depth + 1, self.printer.names
        moving = {str(s) for s, _ in step.moving}
        local = KernelPrinter({name: f"j_{name}" if name in moving else text for name, text in names.items()})
        # a lane that has converged waits for others by corrections of 0
        entries, solve, change = step.correction(Symbol(f"go_{k}") if self.layout.each else S.One)
        update = [(z, z - c) for z, c in zip(step.z, change, strict=True)]
        parts = [Part(step.moving, False), Part(entries), Part(solve, False), Part(update, False)]
        texts = [self._part(part, depth, local) for part in parts]
        self.of_iterations.append(sum(count for _, count in texts) + len(step.z))
        near = local.doprint(Symbol(f"near_{k}"))
        size = len(change) - step.multipliers
        pass_ = f"passes_{k}" if self.layout.each else f"taken_{k}"
        ends = [*_largest_of(change[:size, :]), *_unsettled(step, change, pass_, local)]
        iteration = "\n".join([*(text for text, _ in texts), placed(ends, depth)])
        failed = {} if self.layout.each else {"failed": placed([self.clock.failed], depth)}
        return fill(self.layout.newton, iteration=iteration, near=near, balance=k, **failed).strip("\n")

    def _part(self, part: Part, depth: int, printer: KernelPrinter) -> tuple[str, int]:
        self.rooms |= dict.fromkeys(rooms(part.assignments))
        return part_text(part, depth, printer)


def part_text(part: Part, depth: int, printer: KernelPrinter) -> tuple[str, int]:
    """Lines of a part, and their operations."""
    if part.named:
        return block(part.assignments, depth, printer)
    return lines(part.assignments, depth, printer), operations(part.assignments)


def rooms(assigned: Assignments) -> list[str]:
    """Lines that make the arrays of the systems that assignments solve, in the order in which they do."""
    solved = (a for _, e in assigned for a in e.atoms(first_of))
    return [f"{name} = np.zeros({2 * size * (size + 1)})" for name, size in (a.args for a in solved)]


def _unsettled(step: BalanceStep, change: Matrix, pass_: str, printer: KernelPrinter) -> list[str]:
    """Lines by which an iteration goes on while branches of pressures and frictions may change, however short the step.

    Corrections that move u by less than Newton's tolerance may be of a wrong branch, whose velocities add up. So one of
    a reaction counts where it is more than a thousandth of it and, of an unknown's row, more than rounding, and the
    first one of an unknown where it is more than a thousandth of its row, since branches are those before it. pass_:
    the number of the iteration, of which the first SETTLING are asked: gap and pressure may both be rounding.
    """
    J, z, first = step.jacobian_names, [printer.doprint(s) for s in step.z], len(change) - step.bounded
    if not step.bounded:
        return []
    rows = {
        i: " + ".join(f"abs({J[i, j]}*{x})" for j, x in enumerate(z) if J[i, j] != 0)
        for i in range(first) if J[i, i] != 0
    }  # fmt: skip
    found = [f"{pass_} < 2 and abs({J[i, i]}*{change[i]}) > 1e-3*({row})" for i, row in rows.items()]
    for p in range(first, len(change)):
        moves = [f"abs({J[i, p]}*{change[p]}) > 1e-10*({row})" for i, row in rows.items() if J[i, p] != 0]
        found.append(f"{pass_} < {SETTLING} and abs({change[p]}) > 1e-3*abs({z[p]}) and ({' or '.join(moves)})")
    return [f"largest = 1e300 if {x} else largest" for x in found]


def _largest_of(change: Matrix) -> list[str]:
    """Lines that find the largest component of the correction; a comparison is one instruction, max several."""
    first, *more = (f"abs({c})" for c in change)
    return [f"largest = {first}", *(f"largest = {c} if {c} > largest else largest" for c in more)]
