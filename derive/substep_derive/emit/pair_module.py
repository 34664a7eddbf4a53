"""Body -> text of a module that holds the whole march of one scheme on one scene."""

from collections.abc import Iterable, Sequence
from textwrap import wrap

from sympy import symbols

from ..declare.symbols import h, kind_of, steps_back
from ..kernels.body import Body
from ..kernels.near_series import NearSeries
from ..motion.components import SINCE
from ..motion.effective import EffectiveSystem
from .blocks import BLOCK_OF_LANES
from .law_functions import law_functions
from .one_lane import ONE_LANE, RESULTS, of_lane
from .printing import KERNEL_PRINTER, block, docstring, fill, lines, literal_tuple, placed
from .step_text import DT, Layout, step_text
from .templates.decorators import COMPILE_AND_INNER
from .templates.pair import HELD_FIRST, PAIR_HEADER, START, STENCIL
from .templates.registers import WIDEST
from .templates.scene import LOG_COSH
from .templates.step import DIFFERENCE, FIRST_OF, SINC, SINC_SLOPE

# the layouts in which each pair marches; of the first are the operations that it states
LAYOUTS: tuple[Layout, ...] = (ONE_LANE, BLOCK_OF_LANES)
OF_MOTION = """

On this scene M*a + C*v + N(u) - f stands for M times a minus the acceleration that the equation of motion gives for the
displacement and the velocity of a knot, so that a balance mixes accelerations.
"""


def pair_module(
    body: Body, systems: Sequence[EffectiveSystem], banner: str, layouts: Sequence[Layout] = LAYOUTS
) -> str:
    """Text of the module <scheme>__<scene>.py; systems: one for each balance of the scheme."""
    arguments = march_arguments(body)
    steps = [step_text(body, DT, layout, body.results) for layout in layouts]
    start_names, start = _start(body)
    marches = (layout.march(body, step, arguments) for layout, step in zip(layouts, steps, strict=True))
    text = "".join([*marches, start, _held_first(body), _stencil(body)])
    header = fill(
        PAIR_HEADER,
        imports=WIDEST,
        scheme=body.scheme.name,
        scene=body.motion.scene.name,
        residuals=docstring(residuals(systems) + (OF_MOTION.rstrip() if body.motion.general else "")),
        arguments=literal_tuple(f'"{name}"' for name in arguments),
        scalars=literal_tuple(f'"{name}"' for name in body.scalars),
        start_arguments=literal_tuple(f'"{name}"' for name in start_names),
        state=literal_tuple(f'("{"uva"[kind_of(s)]}", {steps_back(s)})' for s in body.carried),
        reported="uva"[: len(body.report)],
        operations=steps[0].operations,
    )
    return "".join([banner, header, COMPILE_AND_INNER, *helpers(text, body), text])


def march_arguments(body: Body) -> list[str]:
    """Names of the arguments of a march of all lanes."""
    counted = ["iterations", "newton"] if body.iterated else []
    forces = ["forces"] if body.loads else []
    return [*body.scalars, "state", *forces, "bound", "first", "n", "stride", "out", "extremes", *counted, *RESULTS]


def residuals(systems: Sequence[EffectiveSystem]) -> str:
    """Effective mass and residual of every balance, as a paper has them; N and K_t are in the scene's own module."""
    rows = []
    for k, e in enumerate(systems, start=1):
        rows += [f"    balance {k}, unknown z with effective mass {e.effective_mass}:", f"        {e.residual} = 0"]
    title = "Effective mass and residual of each balance, N the internal force and K_t its tangent:"
    wrapped = (wrap(row, 110, subsequent_indent=" " * 12, break_long_words=False) for row in rows)
    return "\n".join([title, *(part for parts in wrapped for part in parts)])


def _start(body: Body) -> tuple[list[str], str]:
    """Names of the arguments and text of `start`; neither where another scheme marches first, or u, v, a are the state.

    The latter are copied, which need not be compiled.
    """
    start = body.start
    if start is None or [str(e) for e in start.state.T] == [name for name, _ in body.places_of(body.scheme.state)]:
        return [], ""
    expressions = [*start.state, *(e for _, e in start.constants)]
    used = {s.name for e in expressions for s in e.free_symbols}
    loads = len(start.stencil) if body.motion.is_sampled else 0
    parameters = [s.name for s in body.parameters(expressions)]
    since = [SINCE.name] if SINCE.name in used else []
    arguments = ["h", *parameters, *since, *(["start_forces"] if loads else []), *"uva", "state"]
    d = len(body.motion.coordinates)
    given = [(f"f_{k}", f"start_forces[{k}]") for k in range(loads)]
    given += [(name, f"{kind}[{i}]") for kind in "uva" for i, name in enumerate(body.components(f"{kind}_0"))]
    given += [(s.name, f"state[{len(body.carried) + k // d}, {k % d}]") for k, (s, _) in enumerate(body.memory)]
    state = start.state
    stores = [(f"state[{j}, {i}]", state[i, j]) for j in range(state.cols) for i in range(state.rows)]
    text = fill(
        START,
        arguments=", ".join(arguments),
        read=placed((f"{name} = {place}" for name, place in given if name in used), 1),
        body=lines([*start.constants, *stores]),
        lane_call=", ".join(of_lane(arguments)),
        m=state.cols,
        d=d,
        more=f" start_forces (lanes or 1, {loads}): the load at start_stencil." if loads else "",
    )
    return arguments, text


def _held_first(body: Body) -> str:
    """Text of `held_first`, where the reactions at the start hold a displacement of the first step."""
    if body.held_first is None:
        return ""
    factors, instant = body.held_first
    at_velocities = body.motion.held.at_velocities
    return fill(
        HELD_FIRST,
        parameters=", ".join(["h", *(s.name for s in body.scheme.values)]),
        factors=", ".join(KERNEL_PRINTER.doprint(e) for e in factors),
        instant=KERNEL_PRINTER.doprint(instant * h),
        constraints=[k for k in range(len(body.motion.scene.constraints)) if not at_velocities[k]],
    )


def _stencil(body: Body) -> str:
    if not body.motion.is_sampled:
        return ""
    start = () if body.start is None else body.start.stencil
    return fill(
        STENCIL,
        parameters=", ".join(s.name for s in body.scheme.values),
        instants=literal_tuple(KERNEL_PRINTER.doprint(tau) for tau in body.stencil),
        start_instants=literal_tuple(KERNEL_PRINTER.doprint(tau) for tau in start),
    )


def helpers(text: str, body: Body) -> Iterable[str]:
    """Functions that the kernel calls, in an order in which each finds those it calls itself."""
    if "_first_of(" in text:
        yield FIRST_OF
    differences = body.near_series
    if "_log_cosh(" in text or any(d.name == "log_cosh" for d in differences):
        yield fill(LOG_COSH, decorator="@_inner\n")
    if "_sinc(" in text or "_sinc_slope(" in text:
        yield SINC
    if "_sinc_slope(" in text:
        yield SINC_SLOPE
    yield from map(_difference, differences)
    yield from law_functions(text, "@_inner\n")


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
