"""The layout of lanes side by side: steps outside, lanes inside, which fill vector registers.

The lines are those of the one-lane march with a name `u` replaced by `u[j]` of lane j, where u is a row of the block; a
name that is used in only one loop over lanes stays a number. The result of each lane is the same as if it were marched
alone. Where balances iterate, one that has converged gets corrections of 0, one that fails keeps its state by
selection, and iterations are counted once for all lanes as long as all take the same number. Where none does, nothing
is selected: whether lanes fail is looked at after many steps, and if any does these are taken again, one by one. A lane
that has failed or ended gives its place to a copy of another, so that no loop asks which lanes are at work.
"""

from collections.abc import Iterable, Mapping, Sequence

from sympy import Expr, Symbol

from ..kernels.balance_step import BalanceStep, Phase
from ..kernels.body import Body
from .printing import KernelPrinter, fill, lines, placed
from .step_text import Layout, StepText
from .templates.block import BLOCK, BLOCK_COUNT, BLOCK_COUNTS, BLOCK_ITERATES, BLOCK_LOOKS, LOOK
from .templates.step import NEWTON_SIDE_BY_SIDE

WIDTH = 64  # most lanes of a block: the rows of a step fit a first cache of 32 kB
EACH = "for j in range(begin, end):"


def scalar_rows(body: Body) -> dict[str, str]:
    """Of each number that a lane is given: the name of its row."""
    names = [*body.scalars, "bound"]
    return {name: f"row_{name[:-1]}" if name.endswith("_") else f"{name}_row" for name in names}


def vector_rows(body: Body) -> list[str]:
    """Names of variables that are rows: the state, constants, loads, and what one loop over lanes passes to another."""
    constants = [s for s, _ in (*body.constants, *body.near)]
    return sorted({*_shared(body), *(name for name, _ in body.places), *map(str, (*constants, *body.loads))})


def _shared(body: Body) -> set[str]:
    """Names that one loop over lanes assigns and another reads."""
    *phases, last = body.phases
    assert isinstance(last, tuple)  # as `phases` says
    after = {str(new) for _, new in body.shift}
    groups = [_flow(phase) for phase in (*phases, (*last, *body.results))]
    groups[-1][1].update(after, body.finite)
    groups.append((set(), _read(e for _, e in body.stored if str(e) not in after)))
    return {
        name
        for k, (assigned, _) in enumerate(groups)
        for name in assigned
        if any(name in read for j, (_, read) in enumerate(groups) if j != k)
    }


def _flow(phase: Phase) -> tuple[set[str], set[str]]:
    """Names that a phase leaves with a value, and that it reads."""
    if isinstance(phase, BalanceStep):
        moving = dict(phase.moving)
        bounds = [s for s, _ in phase.bounds]
        read = _read([*moving.values(), *phase.residual, *phase.jacobian, *phase.z, *bounds])
        return set(map(str, [*phase.z, *bounds])), read - set(map(str, moving))
    assigned = [both for part in phase for both in part.assignments]
    return {str(s) for s, _ in assigned}, _read(e for _, e in assigned)


def _read(expressions: Iterable[Expr]) -> set[str]:
    return {str(s) for e in expressions for s in e.free_symbols}


def _names(body: Body) -> Mapping[str, str]:
    """Text of every variable that is a row: its place in this."""
    rows = {name: name for name in (*vector_rows(body), *(f"go_{k}" for k in body.iterated))} | scalar_rows(body)
    loads = {str(s): f"({s}[j] + common_{k})" for k, s in enumerate(body.loads)}
    return {name: f"{row}[j]" for name, row in rows.items()} | loads


def _march(body: Body, step: StepText, arguments: Sequence[str]) -> str:
    """Text of `march_block`."""
    w, iterated, row_of = step.printer, body.iterated, scalar_rows(body)
    after = {str(new): old for old, new in body.shift}
    stored = [(place, after.get(str(e), e)) for place, e in body.stored]
    reported = [str(e) for _, e in stored][: body.reported_numbers]
    extremes, kept, more = [""] * len(reported), list[str](), list[str]()  # rows without a name
    if iterated:
        more = ["peak_row", "seen", "leaves", "size"]
        more += [f"{name}_{k}" for k in iterated for name in ("go", "idle", "sum", "most")] + extremes
    else:  # what is kept comes first, and then what was
        kept = [*(name for name, _ in body.places if name not in reported), "peak_row", *extremes]
        kept, more = kept + [""] * len(reported + kept), ["leaves"]
    others = [name for name in vector_rows(body) if name not in reported + kept]
    rows = [*reported, *kept, *others, *row_of.values(), *more]
    extreme = rows.index("")
    leave = "rows", "leaves", "of_lane", "runs", "begin", "end", "place", "state", "extremes", "peak"
    leaving = ", ".join([*leave, *(["newton", "common"] if iterated else [])])
    stores = [f"row[{place}] = {w.doprint(e)}" for place, e in stored]
    read = [f"{row}[j] = {name}[lane]" for name, row in row_of.items()]
    read += [*(f"{name}[j] = state[lane, {place}]" for name, place in body.places), "peak_row[j] = -np.inf"]
    read += [f"{s}[j] = 0.0" for s in body.loads]
    read += [f"{name}[j] = 0.0" for name in ("leaves", *(f"{sums}_{k}" for k in iterated for sums in ("sum", "most")))]
    constants = lines([*body.constants, *body.near], 2, w)
    loop = {
        "leave": f"_leave({leaving})",
        "steps": step.phases,
        "reported": step.last,
        "sum": " + ".join(w.doprint(Symbol(name)) for name in body.finite),
        "extreme": extreme,
        "store": placed(stores, 6),
    }
    if iterated:
        read_shift, shift = _shift(body, w)
        all_go = f"{placed(map(_all_go, iterated), 4)}\n"
        loop |= {"all_go": all_go, "read_shift": read_shift, "shift": shift, "count": _count(iterated)}
    else:
        loop |= {"kept": len(reported + kept) // 2, "shift": lines(body.shift, 3, w)}
    return fill(
        BLOCK,
        width=WIDTH,
        look="" if iterated else LOOK,
        arguments=", ".join(arguments),
        leaving=leaving,
        results=_results(body, rows),
        rows=len(rows),
        extreme=extreme,
        counts=fill(BLOCK_COUNTS, balances=len(body.scheme.balances)) if iterated else "",
        allocate=placed([*(f"{name} = rows[{k}]" for k, name in enumerate(rows) if name), *step.rooms], 1),
        read=placed(read, 2),
        constants=f"    {EACH}\n{constants}\n" if constants else "",
        loop=fill(BLOCK_ITERATES if iterated else BLOCK_LOOKS, **loop),
    )


def _results(body: Body, rows: Sequence[str]) -> str:
    """Lines that hand over what a lane's column of the rows holds."""
    at = {name: f"rows[{k}, j]" for k, name in enumerate(rows)}
    found = [f"peak[lane] = {at['peak_row']}", *(f"state[lane, {place}] = {at[name]}" for name, place in body.places)]
    for k in body.iterated:
        found += [f"newton[lane, 0, {k}] = common[0, {k}] + {at[f'sum_{k}']}"]
        found += [f"newton[lane, 1, {k}] = max(common[1, {k}], {at[f'most_{k}']})"]
    return placed(found, 3)


def _shift(body: Body, w: KernelPrinter) -> tuple[str, str]:
    """Lines that read what a shift moves, and that select the new values: to read in a selection prevents vectors.

    What is read is added to 0: a selection between a new value and what stands in its place becomes a store with a
    mask, which AMD's cores without AVX-512 take some twelve cycles for.
    """
    rows = dict.fromkeys(str(s) for both in body.shift for s in both if str(s) in w.names)
    local = KernelPrinter({name: f"j_{name}" for name in rows})
    read = placed((f"j_{name} = {w.doprint(Symbol(name))} + 0.0" for name in rows), 3)
    chosen = (f"{w.doprint(old)} = {local.doprint(new)} if good else {local.doprint(old)}" for old, new in body.shift)
    return read, placed(chosen, 3)


def _all_go(k: int) -> str:
    """The line after which no lane waits in an iteration of balance k."""
    return f"go_{k}[j], idle_{k}[j] = 1.0, 0.0"


def _count(iterated: Iterable[int]) -> str:
    """Lines that count the iterations of a step: their sum, the most, and those of each step if asked for."""
    own, common, stored = [], [], []
    for k in iterated:
        own += [f"taken = passes_{k} - idle_{k}[j]", f"sum_{k}[j] += taken", f"most_{k}[j] = max(most_{k}[j], taken)"]
        own += [_all_go(k)]
        common += [f"common[0, {k}] += passes_{k}", f"common[1, {k}] = max(common[1, {k}], passes_{k})"]
        stored += [f"iterations[j - place, i, {k}] = passes_{k} - idle_{k}[j]"]
    return fill(BLOCK_COUNT, own=placed(own, 4), common=placed(common, 3), store=placed(stored, 5))


BLOCK_OF_LANES = Layout(EACH, NEWTON_SIDE_BY_SIDE, "of_lane[j] % forces.shape[0], ", _names, _march)
