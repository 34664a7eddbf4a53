"""One run, measured: its cost and its errors."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import NamedTuple, TypeVar

import numpy as np

from ...core.coefficients import sizes
from ...core.outcome import Status
from ...core.response import Response
from ...core.scenes import Scene
from ...core.schemes import Array, Scheme
from ...marching.run import marched
from ...marching.scene_lanes import pair_kernels
from .reference import QUANTITIES, Reference, places, value

T = TypeVar("T")
SHORT = 0.025  # s: a run that takes longer is repeated less often
OWN = "own_multipliers"  # those with which a scheme has solved its balances, beside those of the equations of motion
LONG = 0.5  # s, after which a method is not tried any finer


class Cost(NamedTuple):
    """Counts over a whole run.

    solves: of a balance, by the effective stiffness or, where a balance is explicit, by the mass; evaluations: of the
    internal force and of its tangent; operations: additions, multiplications and divisions of the kernel.
    """

    solves: int
    evaluations: int
    operations: int


class Errors(NamedTuple):
    """Errors relative to the reference's largest value: at the end, the largest, and the root of the mean square."""

    final: float
    maximum: float
    rms: float


@dataclass(frozen=True)
class Run:
    """One method at one step: dt in s (NaN where steps are chosen, by tol), seconds the median of repeats.

    errors: by quantity, inf for a run that failed; where energy is conserved, its error is its drift.
    """

    method: str
    dt: float
    steps: int
    status: Status
    cost: Cost
    seconds: float
    errors: Mapping[str, Errors]
    tol: float = np.nan


def quantities(scene: Scene) -> tuple[str, ...]:
    """The quantities that the scene has: an angle if its one coordinate is in rad or its two are x and y.

    Multipliers if it has constraints; places are its coordinates and outputs, by name.
    """
    turns = scene.coordinates[0][1] == "rad" or [name for name, _ in scene.coordinates] == ["x", "y"]
    has = {"angle": turns, "multipliers": bool(scene.info.multipliers)}
    return (*(name for name in QUANTITIES if has.get(name, True)), *places(scene))


def cost(scene: Scene, scheme: Scheme, r: Response, steps: int) -> Cost:
    """What the run cost; the steps that a failed run did not take count as one solve a balance each."""
    iterations = r.newton_iterations
    solves = int(np.maximum(iterations, 1).sum()) + (steps - len(iterations)) * scheme.balances
    if scene.info.oscillator:
        m, R, K = sizes(scheme)
        return Cost(solves, solves, 2 * (m + R) * (m + K) * steps)
    each = pair_kernels(scene, scheme).OPERATIONS
    newton = iterations.sum(axis=0)
    inside = sum(count * one for count, one in zip(newton[newton > 0], each["iteration"], strict=False))
    return Cost(solves, solves + int(newton.sum()), each["step"] * steps + int(inside))


def timed(run: Callable[[], T], repeats: int) -> tuple[T, float]:
    """The result of run() and its median time in s, of `repeats` runs or of those in the time of as many SHORT ones."""
    spent: list[float] = []
    while True:
        began = perf_counter()
        result = run()
        spent.append(perf_counter() - began)
        if len(spent) >= repeats or sum(spent) > repeats * SHORT:
            return result, median(spent)


def measure(exact: Reference, scheme: Scheme, steps: int, repeats: int, model: Scene | None = None) -> Run:
    """March the scheme over the span of the reference; timed after a run that compiles, or not at all if repeats = 0.

    steps: a multiple of the reference's intervals. model: another scene, marched in place of the reference's; only
    quantities that both have are compared.
    """
    scene = model or exact.scene
    t_end = float(exact.t[-1])
    dt, stride = t_end / steps, steps // (len(exact.t) - 1)

    r, seconds, errors = measured(exact, scene, lambda: marched(scene, scheme, dt, t_end, stride=stride), repeats)
    return Run(scheme.name, dt, steps, r.status, cost(scene, scheme, r, steps), seconds, errors)


def measured(
    exact: Reference, scene: Scene, run: Callable[[], Response], repeats: int
) -> tuple[Response, float, dict[str, Errors]]:
    """The response of run(), its median time in s after a run that compiles, NaN for no repeats, and its errors."""
    r, seconds = run(), np.nan
    if repeats:
        r, seconds = timed(run, repeats)
    if r.status != "completed":
        return r, seconds, failed(exact, scene)
    own = [r.memory[name] for name in scene.info.multipliers]
    return r, seconds, against(exact, scene, r.u, r.v, r.a, np.stack(own, axis=1) if own else None)


def against(
    exact: Reference, scene: Scene, u: Array, v: Array, a: Array, own: Array | None = None
) -> dict[str, Errors]:
    """Errors of each quantity that both scenes have, from u, v, a (n, d) at the reference's times.

    own: the scheme's multipliers (n, c), which are compared on the scene of the reference.
    """
    found = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for name in _compared(exact, scene) if own is not None else shared(exact.scene, scene):
            expected, here = (
                value("multipliers" if name == OWN else name, of, exact.t, *uva)
                for of, uva in ((exact.scene, (exact.u, exact.v, exact.a)), (scene, (u, v, a)))
            )
            error = (own if name == OWN and own is not None else here) - expected
            size = np.sqrt((error * error).sum(axis=1)) / (np.sqrt((expected * expected).sum(axis=1)).max() or 1.0)
            found[name] = Errors(float(size[-1]), float(size.max()), float(np.sqrt((size * size).mean())))
    return found


def failed(exact: Reference, scene: Scene) -> dict[str, Errors]:
    """The errors of a run that did not reach the end: all are inf."""
    return dict.fromkeys(_compared(exact, scene), Errors(np.inf, np.inf, np.inf))


def _compared(exact: Reference, scene: Scene) -> tuple[str, ...]:
    """The quantities of a run's errors."""
    return (*shared(exact.scene, scene), *([OWN] if scene is exact.scene and scene.info.multipliers else []))


def shared(one: Scene, other: Scene) -> tuple[str, ...]:
    """Quantities in which two models compare: what both have, u, v, a if their coordinates are alike; not the energy.

    Coordinates and outputs compare by name.
    """
    if one is other:
        return quantities(one)
    apart = {"energy", *(() if one.coordinates == other.coordinates else "uva")}
    return tuple(name for name in quantities(one) if name in quantities(other) and name not in apart)
