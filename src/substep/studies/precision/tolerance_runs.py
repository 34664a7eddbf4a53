"""Runs in steps that choose themselves, measured as those in constant steps are, and the schemes that can make them."""

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any

import numpy as np

from ...core.response import Response
from ...core.scenes import Scene
from ...core.schemes import Scheme
from ...marching.adaptive import adaptive_kernels
from ...marching.run import marched
from ...marching.scene_lanes import pair_kernels
from .measure import LONG, Cost, Run, measured
from .reference import Reference

TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(2, 25))  # 0.1, 0.03, ... 1e-12
ENOUGH = 1.05  # times the error of the reference
BEYOND = 100.0  # times the kinetic energy


def can_choose(scheme: Scheme, scene: Scene) -> bool:
    """Whether the scheme can march the scene in steps that choose themselves by a kernel: it estimates its local error.

    Scenes with reactions have none, since their steps end at events.
    """
    if scene.info.reactions:
        return False
    try:
        adaptive_kernels(scene, scheme)
    except ValueError:
        return False
    return True


def measure_chosen(exact: Reference, scheme: Scheme, tol: float, repeats: int, model: Scene | None = None) -> Run:
    """March the scheme over the span of the reference in steps chosen by tol; see `measure` for the other arguments.

    Errors are taken at the times of the reference, between steps by the interpolant. See `steps_of` for the run's steps
    and `most_energy` for where it ends early.
    """
    scene, t_end = model or exact.scene, float(exact.t[-1])
    bound = most_energy(exact, scene)

    def run() -> Response:
        return marched(scene, scheme, t_end=t_end, tol=tol, chosen={"grid": exact.t}, energy_bound=bound)

    r, seconds, errors = measured(exact, scene, run, repeats)
    return Run(scheme.name, np.nan, steps_of(r), r.status, cost(scene, scheme, r), seconds, errors, tol)


def most_energy(exact: Reference, scene: Scene) -> float | None:
    """The energy in J at which a run has gone wrong, which would else go on in ever shorter steps; None if unknown.

    Without a load the energy can only fall. The limit lies BEYOND times the largest kinetic energy above the start:
    that of the reference, or of the start of another model.
    """
    u, v = (exact.u, exact.v) if scene is exact.scene else (scene.u0[None], scene.v0[None])
    still, zero = np.zeros(len(u)), np.zeros_like(v)
    kinetic = float((scene.energy(still, u, v) - scene.energy(still, u, zero)).max())
    if scene.load is not None or kinetic <= 0:
        return None
    return float(scene.energy(np.zeros(()), scene.u0, scene.v0)) + BEYOND * kinetic


def steps_of(r: Response) -> int:
    """Steps that were accepted, those that were rejected and, where the run failed, the step that ended it."""
    assert r.statistics is not None
    return r.statistics.accepted + r.statistics.rejected + (r.status != "completed")


def cost(scene: Scene, scheme: Scheme, r: Response) -> Cost:
    """What the run cost; the iterations of a rejected step are not counted, and taken as those of an accepted one.

    Two half steps, where the estimate needs them, count as two steps more; an acceleration that it needs besides the
    step as an evaluation. With reactions the two halves are the steps that count, and a whole one is made besides.
    """
    assert r.statistics is not None
    made, steps, named = r.statistics, steps_of(r), set[str]()
    if scene.info.reactions:
        each, marched = pair_kernels(scene, scheme).OPERATIONS, 3 * steps // 2
    else:
        each, error = adaptive_kernels(scene, scheme).OPERATIONS, scheme.local_error(scene.info.damped)
        named = set(_names(error.terms if error.always else error.terms[:2]))  # of each step
        marched = 3 * steps if any(name.endswith("*halved") for name in named) else steps
    newton = [count * marched / max(made.accepted, 1) for count in made.newton_iterations]
    solves = round(sum(max(count, marched) for count in newton))
    besides = steps if named & {"a_*start", "a_*end"} else 0
    inside = sum(count * one for count, one in zip((x for x in newton if x), each["iteration"], strict=False))
    return Cost(solves, solves + round(sum(newton)) + besides, each["step"] * marched + round(inside))


def _names(terms: Any) -> Iterator[str]:
    """Names of the values in an estimate's terms."""
    if isinstance(terms, str):
        yield terms
    elif isinstance(terms, tuple):
        for part in terms:
            yield from _names(part)


def runs(exact: Reference, scheme: Scheme, *, every: int, repeats: int) -> Iterator[Run]:
    """Runs at tolerances from 0.1 on, by factors 10^(every/2), until one takes LONG or is as good as the reference."""
    for tol in TOLERANCES[::every]:
        run = measure_chosen(exact, scheme, tol, repeats)
        yield run
        if run.seconds > LONG or run.errors["u"].maximum <= ENOUGH * exact.error:
            return


def ranked(tried: Iterable[tuple[Scheme, Run]], quantity: str, accuracy: float) -> list[Scheme]:
    """Schemes from the least work in constant steps on.

    tried: runs in constant steps. The work is that of the cheapest run which keeps the largest error of the quantity
    within the accuracy; schemes without such a run stand behind, by their least error.
    """
    rank: dict[Scheme, tuple[float, float]] = {}
    for scheme, run in tried:
        error = run.errors[quantity].maximum
        operations = run.cost.operations if error <= accuracy else np.inf
        rank[scheme] = min(rank.get(scheme, (np.inf, np.inf)), (operations, error))
    return sorted(rank, key=rank.__getitem__)


def least(tried: Iterable[tuple[Scheme, Run]], scene: Scene, quantity: str, accuracy: float) -> list[Scheme]:
    """The first of the `ranked` that can choose its steps on the scene; none if there is none."""
    return list(islice((s for s in ranked(tried, quantity, accuracy) if can_choose(s, scene)), 1))
