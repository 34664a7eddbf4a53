"""AdaptiveStep -> text of a module that marches one scheme on one scene in steps of chosen length."""

from collections.abc import Iterable, Sequence
from textwrap import indent, wrap

from sympy import Expr, Matrix, Symbol

from ..declare.names import printed
from ..declare.symbols import h, knot, knot_of, t
from ..estimate.estimator import acceleration_lag
from ..estimate.held import END, HALVED, START
from ..kernels.adaptive_step import AdaptiveStep
from ..kernels.interpolant import Interpolant, share
from ..kernels.local_error import LocalError, Terms, combined, weight_names
from ..kernels.scene_step import SceneStep
from ..motion.components import Assignments, assign, component_names
from .printing import KERNEL_PRINTER, KernelPrinter, block, docstring, fill, lines, literal_tuple, operations
from .scene_step_module import balance_text, helpers, state_places
from .templates.adaptive import (
    ACCELERATION,
    ADAPTED,
    ADAPTIVE_HEADER,
    ADAPTIVE_LANE,
    ADAPTIVE_MARCH,
    AGAIN,
    COUNT_STEP,
    DENSE,
    FIRST,
    HALVES,
    JUMP,
    LOCAL_ERROR,
    NOT_CONVERGED,
    RESTART,
    UNEVEN,
)

# what is asked of a run: names of the kernel, after the parameters and the weights
ASKED = (
    *("tolerance", "power", "rtol", "atol_u", "atol_v", "share_v", "length", "dt_first", "dt_min", "dt_max"),
    *("t_end", "bound", "rung"),
)
# what `_halved` is given besides the length and the state
HALVES_GIVEN = ("numbers", "start", "t", "load", "samples", "middle")


def adaptive_module(p: AdaptiveStep, banner: str) -> str:
    """Text of the module."""
    step, motion = p.step, p.step.motion
    parameters = [s.name for s in step.parameters(p.expressions)]
    weights = [s.name for s in weight_names(p.terms)]
    w = KERNEL_PRINTER
    read = [f"{name} = numbers[{k}]" for k, name in enumerate((*parameters, *weights, *ASKED))]
    numbers = _lines(read, 1)
    accelerate, call = _acceleration(p, w)
    lane, counts = _lane(p, w, numbers, call)
    march = fill(ADAPTIVE_MARCH, d=len(motion.coordinates))
    text = "".join([accelerate, _first(p, numbers, call), _halved(p, w, numbers), lane, march])
    header = fill(
        ADAPTIVE_HEADER,
        scheme=step.scheme.name,
        scene=motion.scene.name,
        errors=docstring(_errors(p.terms)),
        scalars=literal_tuple(f'"{name}"' for name in (*parameters, *weights, *ASKED)),
        balances=len(step.steps),
        rung=repr(2**0.5 if p.refactored else 0.0),
        change=f"{sum(operations([a]) for a in p.changing) / max(counts['step'], 1):.3g}",
        state=len(step.scheme.state) + len(p.kept),
        degree=p.between.degree,
        operations=counts,
    )
    return "".join([banner, header, *helpers(text, step), text])


def _errors(terms: Terms) -> str:
    """Lines that say what is estimated."""
    rows = ["Estimated local errors, numerical - exact; the weights are numbers of each lane:"]
    kinds = "u", "v", "v, by the acceleration at the end"
    rows += [f"    of {kind}: {e}" for kind, e in zip(kinds, combined(terms), strict=False)]
    return "\n".join(line for row in rows for line in wrap(row, 110, subsequent_indent=" " * 8))


def _lines(texts: Iterable[str], depth: int) -> str:
    return indent("\n".join(texts), "    " * depth)


def _acceleration(p: AdaptiveStep, w: KernelPrinter) -> tuple[str, "_Call"]:
    """Text of `_acceleration`, and how it is called."""
    motion = p.step.motion
    used = {s for e in p.acceleration for s in e.free_symbols}
    u, v = ([Symbol(name) for name in component_names(Symbol(f"{k}_*now"), motion)] for k in "uv")
    given = [w.doprint(s) for s in p.step.parameters(p.acceleration)]
    names = [f"value_{k}" for k in range(len(u))]
    body, _ = block(list(zip(names, p.acceleration, strict=True)), 1, w)
    arguments = [*given, "t", "load", *map(str, (*u, *v))]
    text = fill(ACCELERATION, arguments=", ".join(arguments), body=body, value=", ".join(names))
    return text, _Call(given, Symbol("load") in used, len(u))


class _Call:
    """How `_acceleration` is called in the lane's function: with loads only where the scene takes one."""

    def __init__(self, given: Sequence[str], loaded: bool, size: int) -> None:
        self.given, self.loaded, self.size = given, loaded, size

    def __call__(self, targets: Sequence[str], t: str, u: Iterable[str], v: Iterable[str]) -> str:
        load = f"_load(load, samples, middle, {t})" if self.loaded else "0.0"
        return f"{', '.join(targets)} = _acceleration({', '.join([*self.given, t, load, *u, *v])})"


def _first(p: AdaptiveStep, numbers: str, call: _Call) -> str:
    size = range(call.size)
    names = [f"value_{k}" for k in size]
    return fill(
        FIRST,
        numbers=numbers,
        first_acceleration=_lines([call(names, "t", *([f"start[{k}, {i}]" for i in size] for k in (0, 1)))], 1),
        a_first=_lines((f"size[0, {i}] = {name}" for i, name in enumerate(names)), 1),
        second_acceleration=_lines([call(names, "t", *([f"size[{k}, {i}]" for i in size] for k in (1, 2)))], 1),
        a_second=_lines((f"size[1, {i}] = {name}" for i, name in enumerate(names)), 1),
    )


def _lane(p: AdaptiveStep, w: KernelPrinter, numbers: str, call: _Call) -> tuple[str, dict[str, object]]:
    step = p.step
    places = [*state_places(step), *_kept_places(p)]
    state = [(name, f"state[{place}]") for name, place in places]
    texts, counts, iteration = _balances(step, w, NOT_CONVERGED)
    reported, more = _reported(p, w, call)
    size, weighing = _size(p, w, call)
    ends = [[w.doprint(e) for e in vector] for vector in step.report]
    old_places = [(f"old_{k}_{i}", f"here[{k}, {i}]") for k in range(3) for i in range(call.size)]
    return fill(
        ADAPTIVE_LANE,
        numbers=numbers,
        initial=_lines(_components(p, "u", "start[0, {}]"), 1),
        once=lines(p.once, 1, w),
        begin=_begin(p, call),
        read_state=_lines((f"{name} = {place}" for name, place in state), 1),
        changing=lines(p.changing, 3, w),
        no_step="    at_h, at_last = np.nan, np.nan\n" if p.uneven else "",
        adapted=_adapted(p),
        uneven=fill(UNEVEN, uneven=lines(p.uneven, 3, w)) if p.uneven else "",
        forces=_forces(p.step, w),
        steps=texts,
        reported=reported,
        size=size,
        sum=" + ".join(step.finite),
        count="".join(fill(COUNT_STEP, balance=k) for k in p.newton_balances),
        dense=_dense(p, call, ends),
        remember=_remember(p, call, ends),
        shift=_shift(p, w, call, ends),
        jump=_jump(p, w),
        measured="last == last" if any(p.by_before) else "True",
        restart=_restart(p, old_places),
        first_old=_lines((f"{name} = {at}" for name, at in old_places), 1),
        old_back=_lines((f"{at} = {name}" for name, at in old_places), 1),
        store=_lines((f"out[row, {k}, {i}] = old_{k}_{i}" for k in range(3) for i in range(call.size)), 3),
        write_state=_lines((f"{place} = {name}" for name, place in state), 1),
    ), {"step": counts + more + weighing, "iteration": iteration}


def _balances(step: SceneStep, w: KernelPrinter, failed: str) -> tuple[str, int, tuple[int, ...]]:
    """Text of what comes before and in the balances; its operations, and those of an iteration of each."""
    texts, counts, iteration = [], 0, []
    if step.prior:
        text, counts = block(step.prior, 2, w)
        texts.append(text)
    for k, balance in enumerate(step.steps):
        text, once, again = balance_text(balance, k, failed, w)
        texts.append(text)
        counts += once
        iteration += [again] if again else []
    return "\n".join(texts), counts, tuple(iteration)


def _reported(p: AdaptiveStep, w: KernelPrinter, call: _Call) -> tuple[str, int]:
    """Lines that compute what is reported, its energy and the estimated errors; their operations."""
    step, errors = p.step, [*p.error_u, *p.error_v, *(p.error_end if p.always else [])]
    reported = [*step.reported, (Symbol("energy"), step.energy)]
    between: list[str] = []
    if p.end_is_estimated:
        u, v = ([w.doprint(e) for e in vector] for vector in step.report[:2])
        between += [call(component_names(END.a, step.motion), "end", u, v)]
    if p.halved is not None:
        names = [name for s in HALVED[:2] for name in component_names(s, step.motion)]
        state = [name for name, _ in state_places(step)]
        between += [f"{', '.join(names)} = _halved({', '.join([*HALVES_GIVEN, '0.5 * h', *state])})"]
    if not between:
        return block([*reported, *errors], 2, w)
    text, count = block(reported, 2, w)
    more, again = block(errors, 2, w)
    return "\n".join([text, _lines(between, 2), more]), count + again


def _halved(p: AdaptiveStep, w: KernelPrinter, numbers: str) -> str:
    """Text of a function that makes two steps of h."""
    if p.halved is None:
        return ""
    step = p.halved
    u, v = ([w.doprint(e) for e in vector] for vector in step.report[:2])
    reported, _ = block([*step.reported], 2, w) if step.reported else ("", 0)
    given = [f"begin_{k}" for k in range(len(state_places(step)))]
    return fill(
        HALVES,
        arguments=", ".join([*HALVES_GIVEN, "h", *given]),
        numbers=numbers,
        initial=_lines(_components(p, "u", "start[0, {}]"), 1),
        constants=lines([*step.constants, *step.near], 1, w),
        state=_lines((f"{name} = {x}" for (name, _), x in zip(state_places(step), given, strict=True)), 1),
        forces=_forces(step, w),
        steps=_balances(step, w, f"return {', '.join(['np.nan'] * (len(u) + len(v)))}")[0],
        reported=reported,
        shift=lines(step.shift, 2, w),
        result=", ".join([*u, *v]),
    )


def _kept_places(p: AdaptiveStep) -> list[tuple[str, str]]:
    """Name of every component of what is kept besides the scheme's state, and its row and column."""
    first = len(p.step.scheme.state)
    return [
        (name, f"{first + j}, {i}")
        for j, s in enumerate(p.kept)
        for i, name in enumerate(component_names(s, p.step.motion))
    ]


def _components(p: AdaptiveStep, kind: str, place: str) -> list[str]:
    """Lines that read the components of u_0, v_0 or a_0, whose places are filled with their numbers."""
    names = component_names(Symbol(f"{kind}_0"), p.step.motion)
    return [f"{name} = {place.format(i)}" for i, name in enumerate(names)]


def _begin(p: AdaptiveStep, call: _Call) -> str:
    """Lines that take the state from the start."""
    kinds = [(knot_of(s) or ("u", ""))[0] for s in p.step.scheme.state]
    rows = [f"state[{j}] = start[{'uva'.index(kind)}]" for j, kind in enumerate(kinds)]
    for j, s in enumerate(p.kept, start=len(kinds)):
        if s == START.a:
            u, v = ([f"start[{k}, {i}]" for i in range(call.size)] for k in (0, 1))
            rows += [call([f"state[{j}, {i}]" for i in range(call.size)], "0.0", u, v)]
        else:
            rows += [f"state[{j}] = 0.0"]
    return _lines(rows, 2)


def _forces(step: SceneStep, w: KernelPrinter) -> str:
    if not step.motion.is_sampled:
        return ""
    instants = (w.doprint(t + tau * h) for tau in step.stencil)
    return "".join(f"        f_{k} = _load(load, samples, middle, {at})\n" for k, at in enumerate(instants))


def _size(p: AdaptiveStep, w: KernelPrinter, call: _Call) -> tuple[str, int]:
    """Lines that sum the squares of the weighted errors, and their operations."""
    rows, size, alone = [], len(p.step.motion.coordinates), p.by_before.count(False)
    end, first = _end_rows(p) if p.error_end else [], []
    if end and not p.always:
        if p.takes_end(p.error_end):
            u, v = ([w.doprint(e) for e in vector] for vector in p.step.report[:2])
            first += [call(component_names(END.a, p.step.motion), "end", u, v)]
        first += [*block(p.error_end, 0, w)[0].splitlines(), *end]
        end = []
    fast = f"{'max(' * size}speed{''.join(f', abs({e}))' for e in p.step.report[1])}"
    rows += [f"fast = {fast}", "floor = atol_v + share_v * fast + 1e-300"]
    late: list[str] = []
    for kind, (errors, base) in enumerate(((p.error_u, "atol_u"), (p.error_v, "floor"))):
        into = late if p.by_before[kind] else rows
        for i, (name, _) in enumerate(errors):
            new = p.step.report[kind][i]
            into += [f"part = {name} / ({base} + rtol * max(abs(old_{kind}_{i}), abs({new})))"]
            into += ["size += part * part"]
    if late:
        rows += ["if last == last:", *(f"    {row}" for row in late), f"    size *= {0.5 / size!r}"]
        first = [*([f"size *= {1.0 / size!r}"] if alone else []), *first]
        rows += ["else:", *(f"    {row}" for row in first)] if first else []
    else:
        rows += [f"size *= {0.5 / size!r}"]
    return _lines([*rows, *end], 2), 14 * size + size + (8 * size if end else 0)


def _end_rows(p: AdaptiveStep) -> list[str]:
    """Lines that put the error by the acceleration at the end in the others' place where it is too large.

    Where it is not, the lengths of steps do not depend on it.
    """
    rows = ["late = 0.0"]
    for i, (name, _) in enumerate(p.error_end):
        rows += [f"part = {name} / (floor + rtol * max(abs(old_1_{i}), abs({p.step.report[1][i]})))"]
        rows += ["late += part * part"]
    return [*rows, f"late *= {1.0 / len(p.error_end)!r}", "size = size if late <= 1.0 else late"]


def _dense(p: AdaptiveStep, call: _Call, ends: Sequence[Sequence[str]]) -> str:
    """Lines that fill a row of the grid from the interpolant of the step."""
    size = range(call.size)
    now = [f"now_{i}" for i in size]
    before: list[str] = []
    begin, end = ([f"old_2_{i}" for i in size], ends[2] if p.own_acceleration else now)
    if not p.own_acceleration:
        begin = [f"then_{i}" for i in size]
        before = [
            call(begin, "t", *([f"old_{k}_{i}" for i in size] for k in (0, 1))),
            call(now, "end", ends[0], ends[1]),
        ]
    values = [ends[0], ends[1], end]
    at_end = [f"out[place, {k}, {i}] = {values[k][i]}" for k in range(3) for i in size]
    rows: list[str] = []
    old = [[f"old_0_{i}" for i in size], [f"old_1_{i}" for i in size], begin]
    for i in size:
        names = {s.name: old[k][i] for k, s in enumerate(knot(0))} | {
            s.name: values[k][i] for k, s in enumerate(knot(1))
        }
        rows += [block(_between(p.between, i), 4, KernelPrinter(names))[0]]
    texts = [_lines(before, 3)] if before else []
    return "\n".join([*texts, fill(DENSE, at_end=_lines(at_end, 4), between="\n".join(rows))])


def _between(found: Interpolant, i: int) -> list[tuple[str, Expr]]:
    assert found.u.has(share)
    return [(f"out[place, {k}, {i}]", e) for k, e in enumerate((found.u, found.v, found.a))]


def _remember(p: AdaptiveStep, call: _Call, ends: Sequence[Sequence[str]]) -> str:
    """Lines that keep what was reached, for the scales of the next step, for rows and for the interpolant."""
    size = range(call.size)
    rows = [f"old_{k}_{i} = {ends[k][i]}" for k in range(len(ends)) for i in size]
    text = _lines([*rows, "speed = fast"], 2)
    if p.own_acceleration:
        return text
    if p.end_is_estimated:
        made = _lines((f"old_2_{i} = {name}" for i, name in enumerate(component_names(END.a, p.step.motion))), 2)
        return text + "\n" + made
    made = call([f"old_2_{i}" for i in size], "end", ends[0], ends[1])
    return text + "\n" + _lines(["if row < times.size or end >= t_end:", f"    {made}"], 2)


def _adapted(p: AdaptiveStep) -> str:
    """Lines that bring an acceleration which depends on the length of its step to that of the next."""
    if p.lag is None:
        return ""
    both = zip(*(component_names(s, p.step.motion) for s in (knot(0).a, START.a)), strict=True)
    return fill(ADAPTED, lag=p.lag, rows=_lines((f"{a} = {own} + ratio * ({a} - {own})" for a, own in both), 3))


def _shift(p: AdaptiveStep, w: KernelPrinter, call: _Call, ends: Sequence[Sequence[str]]) -> str:
    """Lines that keep what an estimate reads of this step in the next, and make its end the start of that."""
    rows = []
    for s, source in p.kept.items():
        names = component_names(s, p.step.motion)
        if source == END.a and not p.end_is_estimated:
            rows += [call(names, "end", ends[0], ends[1])]
        else:
            found = component_names(source, p.step.motion)
            rows += [f"{new} = {old}" for new, old in zip(names, found, strict=True)]
    return "\n".join(part for part in (_lines(rows, 2), lines(p.step.shift, 2, w)) if part)


def _jump(p: AdaptiveStep, w: KernelPrinter) -> str:
    """Lines for a jump of the load at the end of a step: the acceleration jumps with it, by M^-1 of it."""
    if not p.step.motion.is_sampled:
        return ""
    slope = p.acceleration.diff(Symbol("load"))
    found: Assignments = []
    if knot(0).a in p.step.scheme.state:
        found = assign(p.step_components("a"), slope)
    if START.a in p.kept:
        found += assign(Matrix([Symbol(name) for name in component_names(START.a, p.step.motion)]), slope)
    rows = [f"{w.doprint(name)} += {w.doprint(e)} * jump" for name, e in found if e != 0]
    rows += [f"old_2_{i} += {w.doprint(e)} * jump" for i, e in enumerate(slope) if e != 0]
    return fill(JUMP, jumps=_lines(rows, 4))


def _restart(p: AdaptiveStep, old_places: Iterable[tuple[str, str]]) -> str:
    """Lines for a break point of the load, behind which the step before does not help to estimate an error."""
    if not any(p.by_before):
        return ""
    again = fill(AGAIN, old_back=_lines((f"{at} = {name}" for name, at in old_places), 3)) if p.by_before[0] else ""
    return fill(RESTART, again=again)


def local_error_module(found: LocalError) -> str:
    """Text of a module that holds the terms of an estimate of the local error, and their weights as a function."""
    names = {s.name: printed(s).name for s in found.parameters}
    w = KernelPrinter(names)
    return fill(
        LOCAL_ERROR,
        scheme=found.scheme.name,
        terms=found.terms,
        always=found.always,
        sources=found.sources,
        order=found.order,
        lag=acceleration_lag(found.scheme),
        parameters=literal_tuple(f'"{s.name}"' for s in found.parameters),
        arguments=", ".join(names.values()),
        weights=literal_tuple(w.doprint(e) for e in found.weights),
    )
