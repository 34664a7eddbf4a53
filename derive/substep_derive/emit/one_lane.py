"""The layout of one lane after another, in steps of one length: a function marches a lane through all its steps."""

from collections.abc import Iterable, Sequence
from textwrap import wrap

from ..kernels.body import Body
from .printing import fill, lines, placed
from .step_text import Layout, StepText
from .templates.pair import COUNT_OF_LANE, LANE, LANES
from .templates.step import NEWTON

RESULTS = "peak", "n_done", "status"


def _march(body: Body, step: StepText, arguments: Sequence[str]) -> str:
    """Text of `march`."""
    return lane_function(body, step, arguments) + fill(
        LANES,
        arguments=", ".join(arguments),
        scheme=body.scheme.name,
        docstring=placed(wrap(_meaning(body), 110), 1),
        lane_call=", ".join(of_lane(given(arguments))),
    )


def given(arguments: Sequence[str]) -> Sequence[str]:
    """The arguments of a march that the function for one lane takes."""
    return arguments[: -len(RESULTS)]


def lane_function(body: Body, step: StepText, arguments: Sequence[str]) -> str:
    """Text of the function that marches one lane; arguments: those of the march of all."""
    counts = [f"newton[0, {k}], newton[1, {k}] = sum_{k}, most_{k}" for k in body.iterated]
    return fill(
        LANE,
        lane_arguments=", ".join(given(arguments)),
        read_state=placed((f"{name} = state[{place}]" for name, place in body.places), 1),
        constants=opened(step.rooms, lines([*body.constants, *body.near])),
        steps=step.phases,
        reported=step.last,
        sum=" + ".join(body.finite),
        no_counts="".join(f"    sum_{k}, most_{k} = 0, 0\n" for k in body.iterated),
        count="".join(fill(COUNT_OF_LANE, balance=k) for k in body.iterated),
        shift=lines(body.shift, 2),
        extremes=placed(_extremes(body), 3),
        store=placed((f"row[{place}] = {e}" for place, e in body.stored), 4),
        write=placed([*(f"state[{place}] = {name}" for name, place in body.places), *counts], 1),
    )


def opened(rooms: Iterable[str], text: str) -> str:
    """The first lines of a function, after those that make its arrays."""
    return "\n".join([*(placed([line], 1) for line in rooms), text])


def _extremes(body: Body) -> list[str]:
    """Lines that keep the largest moduli of u, or of all that is reported, as `extremes` has room for."""
    found, d = list[str](), len(body.motion.coordinates)
    for r, (_, e) in enumerate(body.stored[: body.reported_numbers]):
        found += [f"if extremes.shape[0] > {r}:"] if r % d == 0 else []
        found += [f"    extremes[{r}] = max(extremes[{r}], abs({e}))"]
    return found


def _meaning(body: Body) -> str:
    """What the arguments are."""
    d, kinds = len(body.motion.coordinates), "uva"[: len(body.report)]
    text = (
        f"{', '.join(body.scalars)}: one number for each lane. "
        f"state (lanes, {len(body.carried)}, {d}), rows as STATE: "
        "on entry at step first, on return after the last step completed. "
        f"out (lanes, rows, {len(kinds)}, {d}): {', '.join(kinds)} every "
        "stride steps; row 0 is left to the caller. "
        f"extremes (lanes, 0, {d} or {d * len(kinds)}): the largest moduli so far at these steps, of u or of all. "
        "peak (lanes,): largest energy after the steps of this call. first: steps completed before it. "
        "n_done (lanes,): steps completed in all, at most n (lanes,); "
        "status (lanes,). A lane stops before a state that is not finite or whose energy exceeds bound (lanes,)."
    )
    if body.loads:
        text += f" forces (lanes or 1, n, {len(body.stencil)}): the load at the stencil."
    if body.iterated:
        text += (
            " tolerance: a balance's Newton iteration ends at a correction of u that is no larger. "
            "newton (lanes, 2, balances): Newton iterations of the steps completed, their sum and the most in one step"
            "; iterations (lanes, rows, balances): those of each of the first rows steps."
        )
    return text


def of_lane(arguments: Sequence[str]) -> list[str]:
    """Arguments of the call for one lane; one row of forces may serve all lanes."""
    forces = {name: f"{name}[lane % {name}.shape[0]]" for name in ("forces", "start_forces")}
    own = {"first": "first", "stride": "stride"} | forces
    return [own.get(name, f"{name}[lane]") for name in arguments]


ONE_LANE = Layout("", NEWTON, "", lambda body: {}, _march)
