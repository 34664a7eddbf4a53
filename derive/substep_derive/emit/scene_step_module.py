"""SceneStep -> text of a module that holds the whole march of one scheme on one scene, and calls only itself."""

from collections.abc import Iterable, Sequence
from textwrap import indent, wrap

from sympy import Symbol, symbols

from ..declare.symbols import knot_of, lattice
from ..kernels.near_series import NearSeries
from ..kernels.scene_step import BalanceStep, SceneStep
from ..motion.components import assign, component_names
from ..motion.effective import EffectiveSystem
from .lane_blocks import largest_of, march_block
from .printing import KERNEL_PRINTER, KernelPrinter, block, docstring, fill, lines, literal_tuple, operations
from .templates.scene import (
    COUNT,
    COUNT_NONE,
    DIFFERENCE,
    FAILED,
    LANE,
    LOG_COSH,
    MARCH,
    NEWTON,
    SCENE_STEP_HEADER,
    SINC,
    SINC_SLOPE,
    START,
    STENCIL,
)
from .templates.widest import WIDEST, WIDEST_IMPORTS


def scene_step_module(p: SceneStep, systems: Sequence[EffectiveSystem], banner: str) -> str:
    """Text of the module <scheme>__<scene>.py; systems: one for each balance of the scheme."""
    parameters = [s.name for s in p.parameters(p.expressions)]
    lane = ["h", *parameters, *(["tolerance"] if p.newton else [])]
    forces = ["forces"] if p.motion.is_sampled else []
    counted = ["iterations", "newton"] if p.newton else []
    arguments = [*lane, "state", *forces, "bound", "first", "n", "stride", "out", *counted]
    results = ["peak", "n_done", "status"]
    body, counts = _lane(p, arguments)
    body += march_block(p, [*arguments, *results], state_places(p))
    start_names, start = _start(p)
    text = "".join([body, _march(p, arguments, results, lane), start, _stencil(p)])
    parts = [
        banner,
        fill(
            SCENE_STEP_HEADER,
            imports=WIDEST_IMPORTS,
            scheme=p.scheme.name,
            scene=p.motion.scene.name,
            residuals=docstring(residuals(systems)),
            arguments=literal_tuple(f'"{name}"' for name in (*arguments, *results)),
            scalars=literal_tuple(f'"{name}"' for name in lane),
            start_arguments=literal_tuple(f'"{name}"' for name in start_names),
            state=literal_tuple(f'("{kind}", {-(lattice(label) or 0)})' for kind, label in _state(p)),
            reported="uva"[: len(p.report)],
            operations=counts,
        ),
        WIDEST,
        *helpers(text, p),
        text,
    ]
    return "".join(parts)


def residuals(systems: Sequence[EffectiveSystem]) -> str:
    """Effective mass and residual of every balance, as a paper has them; N and K_t are in the scene's own module."""
    rows = []
    for k, e in enumerate(systems, start=1):
        rows += [f"    balance {k}, unknown z with effective mass {e.effective_mass}:", f"        {e.residual} = 0"]
    title = "Effective mass and residual of each balance, N the internal force and K_t its tangent:"
    wrapped = (wrap(row, 110, subsequent_indent=" " * 12, break_long_words=False) for row in rows)
    return "\n".join([title, *(part for parts in wrapped for part in parts)])


def _state(p: SceneStep) -> list[tuple[str, str]]:
    return [knot_of(s) or ("u", "0") for s in p.scheme.state]


def state_places(p: SceneStep) -> list[tuple[str, str]]:
    """Name of every component of the state, and its row and column."""
    return [
        (name, f"{j}, {i}") for j, s in enumerate(p.scheme.state) for i, name in enumerate(component_names(s, p.motion))
    ]


def _lane(p: SceneStep, arguments: Sequence[str]) -> tuple[str, dict[str, object]]:
    state = [(name, f"state[{place}]") for name, place in state_places(p)]
    texts, prior_count = block(p.prior, 2) if p.prior else ("", 0)
    steps, counts, iteration = [texts] if texts else [], prior_count, {}
    for k, step in enumerate(p.steps):
        text, once, again = balance_text(step, k)
        steps.append(text)
        counts += once
        if again:
            iteration[k] = again
    reported, reported_count = block([*p.reported, (Symbol("energy"), p.energy)], 2)
    forces = ""
    if p.motion.is_sampled:
        forces = "".join(f"        f_{k} = forces[i, {k}]\n" for k in range(len(p.stencil)))
    store = [
        f"            row[{kind}, {i}] = {e}" for kind, vector in enumerate(p.report) for i, e in enumerate(vector)
    ]
    text = fill(
        LANE,
        lane_arguments=", ".join(arguments),
        read_state="\n".join(f"    {name} = {place}" for name, place in state),
        constants=lines([*p.constants, *p.near]),
        forces=forces,
        steps="\n".join(steps),
        reported=reported,
        sum=" + ".join(p.finite),
        count_none=COUNT_NONE if p.newton else "",
        count="".join(fill(COUNT, balance=k) for k, step in enumerate(p.steps) if step.first is not None),
        shift="\n".join(f"        {old} = {new}" for old, new in p.shift),
        store="\n".join(store),
        write_state="\n".join(f"    {place} = {name}" for name, place in state),
    )
    return text, {"step": counts + reported_count, "iteration": tuple(iteration.values())}


def balance_text(
    step: BalanceStep, k: int, failed: str = FAILED, printer: KernelPrinter = KERNEL_PRINTER
) -> tuple[str, int, int]:
    """Text of one balance; its operations outside of the iteration, and in one iteration.

    failed: lines for an iteration that does not converge; they leave the step.
    """
    before, counts = block(step.before, 2, printer) if step.before else ("", 0)
    after, after_count = block(step.after, 2, printer) if step.after else ("", 0)
    if step.first is None:
        residual, count = block(assign(step.residual_names, step.residual), 2, printer)
        solved = assign(step.z, -step.inverse * step.residual_names)
        text = "\n".join(part for part in (before, residual, lines(solved, 2, printer), after) if part)
        return text, counts + count + operations(solved) + after_count, 0
    entries, solve, change = step.correction()
    iteration, count = block(entries, 3, printer)
    update = [(z, z - c) for z, c in zip(step.z, change, strict=True)]
    first = list(zip(step.z, step.first, strict=True))
    text = fill(
        NEWTON,
        before=before,
        first=lines(first, 2, printer),
        moving=lines(step.moving, 3, printer),
        iteration=iteration,
        change=lines(solve, 3, printer),
        update=lines(update, 3, printer),
        largest=indent("\n".join(largest_of(change)), " " * 12),
        balance=k,
        failed=indent(failed, " " * 12),
        after=after,
    ).strip("\n")
    again = operations(step.moving) + count + operations(solve) + operations(update) + len(step.z)
    return text, counts + operations(first) + after_count, again


def _march(p: SceneStep, arguments: Sequence[str], results: Sequence[str], lane: Sequence[str]) -> str:
    more = ""
    if "forces" in arguments:
        more += f" forces (lanes or 1, n, {len(p.stencil)}): the load at the stencil."
    if p.newton:
        more += (
            " tolerance: a balance's Newton iteration ends at a correction of u that is no larger. "
            "newton (lanes, 2, balances): Newton iterations of the steps completed, their sum and the most in one step"
            "; iterations (lanes, rows, balances): those of each of the first rows steps."
        )
    docstring = (
        f"{', '.join(lane)}: one number for each lane. "
        f"state (lanes, {len(p.scheme.state)}, {len(p.motion.coordinates)}), rows as STATE: "
        "on entry at step first, on return after the last step completed. "
        f"out (lanes, rows, {len(p.report)}, {len(p.motion.coordinates)}): {', '.join('uva'[: len(p.report)])} every "
        "stride steps; row 0 is left to the caller. "
        "peak (lanes,): largest energy after the steps of this call. first: steps completed before it. "
        "n_done (lanes,): steps completed in all, at most n (lanes,); "
        "status (lanes,). A lane stops before a state that is not finite or whose energy exceeds bound (lanes,)."
    )
    return fill(
        MARCH,
        arguments=", ".join([*arguments, *results]),
        title=f"March every lane n steps of {p.scheme.name}.",
        docstring=indent("\n".join(wrap(docstring + more, 110)), "    "),
        lane_call=", ".join(_calls(arguments)),
    )


def _calls(arguments: Sequence[str]) -> list[str]:
    """Arguments of the call for one lane; one row of forces may serve all lanes."""
    some = {"first": "first", "stride": "stride", "forces": "forces[lane % forces.shape[0]]"}
    return [some.get(name, f"{name}[lane]") for name in arguments]


def _start(p: SceneStep) -> tuple[list[str], str]:
    """Names of the arguments and text of `start`; neither where another scheme marches first, or u, v, a are the state.

    The latter are copied, which need not be compiled.
    """
    if p.start is None or [str(e) for e in p.start.state.T] == [name for name, _ in state_places(p)]:
        return [], ""
    expressions = [*p.start.state, *(e for _, e in p.start.constants)]
    used = {s.name for e in expressions for s in e.free_symbols}
    loads = [f"f_{k}" for k in range(len(p.start.stencil))] if p.motion.is_sampled else []
    arguments = ["h", *(s.name for s in p.parameters(expressions)), *(["start_forces"] if loads else [])]
    calls = [f"{a}[lane]" for a in arguments]
    if loads:
        calls[-1] = "start_forces[lane % start_forces.shape[0]]"
    vectors = [*"uva", "state"]
    body = [f"    {name} = start_forces[{k}]" for k, name in enumerate(loads) if name in used]
    for kind in "uva":
        for i, name in enumerate(component_names(Symbol(f"{kind}_0"), p.motion)):
            body += [f"    {name} = {kind}[{i}]"] if name in used else []
    state = p.start.state
    stores = [(f"state[{j}, {i}]", state[i, j]) for j in range(state.cols) for i in range(state.rows)]
    text = fill(
        START,
        lane_arguments=", ".join([*arguments, *vectors]),
        body="\n".join([*body, *([lines(p.start.constants)] if p.start.constants else []), lines(stores)]),
        arguments=", ".join([*arguments, *vectors]),
        lane_call=", ".join([*calls, *(f"{vector}[lane]" for vector in vectors)]),
        m=state.cols,
        d=state.rows,
        more=f" start_forces (lanes or 1, {len(loads)}): the load at start_stencil." if loads else "",
    )
    return [*arguments, *vectors], text


def _stencil(p: SceneStep) -> str:
    if not p.motion.is_sampled:
        return ""
    start = () if p.start is None else p.start.stencil
    return fill(
        STENCIL,
        parameters=", ".join(s.name for s in p.scheme.values),
        instants=literal_tuple(KERNEL_PRINTER.doprint(tau) for tau in p.stencil),
        start_instants=literal_tuple(KERNEL_PRINTER.doprint(tau) for tau in start),
    )


def helpers(text: str, p: SceneStep) -> Iterable[str]:
    """Functions that the kernel calls, in an order in which each finds those it calls itself."""
    differences = p.near_series
    if "_log_cosh(" in text or any(d.name == "log_cosh" for d in differences):
        yield fill(LOG_COSH, decorator="@_inner\n")
    if "_sinc(" in text or "_sinc_slope(" in text:
        yield SINC
    if "_sinc_slope(" in text:
        yield SINC_SLOPE
    yield from map(_difference, differences)


def _difference(d: NearSeries) -> str:
    (old, new), printed = symbols("old new"), KERNEL_PRINTER.doprint
    return fill(
        DIFFERENCE,
        g=d.name,
        near=printed(d.near.n(5)) if d.near else "0.0",
        series=block([("difference", d.series), ("last", d.last)], 2)[0],
        slope_series=block([("difference", d.series), ("last", d.last), ("slope", d.slope)], 2)[0],
        at_old=printed(d.at(old)),
        at_new=printed(d.at(new)),
        slope_at_new=printed(d.at(new, 1)),
    )
