"""The fork of a march in chosen steps: where it was before t_end first changed the length of a step."""

from collections.abc import Mapping
from dataclasses import replace

from ...core.arrays import Array, digest
from ...core.state import State, whose
from ...run.clock import Control
from .saved import described
from .steps import Run

FORK = "fork "  # begins the names of its arrays in `State.more`


def stands(state: State, run: Run, asked: Control, shares: tuple[float, float], fork: Mapping[str, Array]) -> State:
    """The state at the end of a march, with its fork."""
    more = {f"{FORK}{name}": x for name, x in fork.items() if x.size}
    return replace(state, of=_of(run, asked, shares, state.t), more=more)


def gone_on_from(run: Run, asked: Control, shares: tuple[float, float]) -> dict[str, Array]:
    """The fork of the march that this one goes on from, if it differs from it in nothing but its end; else nothing."""
    start = asked.start
    if start is None or f"{FORK}numbers" not in start.more or start.of != _of(run, asked, shares, start.t):
        return {}
    return {name.removeprefix(FORK): x for name, x in start.more.items()}


def _of(run: Run, asked: Control, shares: tuple[float, float], t: float) -> str:
    """What a state at t is of: the scheme, the structure with its loads until then, and what steps are chosen by."""
    whole = described(Run(run.structure, run.scheme, t, run.iteration), t)
    steps = asked.rtol, asked.atol_u, asked.atol_v, shares, asked.dt_min, asked.dt_max, asked.rung
    return whose(run.scheme, f"chosen steps {digest(whole, run.iteration, *steps)}")
