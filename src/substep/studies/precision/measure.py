"""One run, measured: what it costs and how far it is off."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import NamedTuple, TypeVar

import numpy as np

from ...core.coefficients import sizes
from ...core.response import Response, Status
from ...core.scenes import Scene
from ...core.schemes import Array, Scheme
from ...marching.run import march
from ...marching.scene_lanes import march_kernels
from .reference import QUANTITIES, Reference

T = TypeVar("T")
LONG = 0.5  # s, after which a run is not repeated


class Cost(NamedTuple):
    """Counts over a whole run.

    solves: of a balance, by the effective stiffness or, where a balance is explicit, by the mass; evaluations: of the
    internal force and of its tangent; operations: additions, multiplications and divisions of the kernel.
    """

    solves: int
    evaluations: int
    operations: int


class Errors(NamedTuple):
    """Relative to the largest of the reference: at the end, the largest, and the root of the mean square."""

    final: float
    maximum: float
    rms: float


@dataclass(frozen=True)
class Run:
    """One method at one step: dt in s (the mean one of a code that chooses its steps), seconds the median of repeats.

    errors: of each quantity, inf of a run that failed; that of the energy is its drift where none is lost or given.
    """

    method: str
    dt: float
    steps: int
    status: Status
    cost: Cost
    seconds: float
    errors: Mapping[str, Errors]


def quantities(scene: Scene) -> tuple[str, ...]:
    """Which quantities the scene has; an angle where its one coordinate is in rad, or its two are x and y."""
    turns = scene.coordinates[0][1] == "rad" or [name for name, _ in scene.coordinates] == ["x", "y"]
    return tuple(name for name in QUANTITIES if name != "angle" or turns)


def cost(scene: Scene, scheme: Scheme, r: Response, steps: int) -> Cost:
    """What the run cost; of one that failed, at least what it cost until then."""
    iterations = r.newton_iterations
    solves = int(np.maximum(iterations, 1).sum()) + (steps - len(iterations)) * scheme.balances
    if scene.info.oscillator:
        m, R, K = sizes(scheme)
        return Cost(solves, solves, 2 * (m + R) * (m + K) * steps)
    each = march_kernels(scene, scheme).OPERATIONS
    newton = iterations.sum(axis=0)
    inside = sum(count * one for count, one in zip(newton[newton > 0], each["iteration"], strict=False))
    return Cost(solves, solves + int(newton.sum()), each["step"] * steps + int(inside))


def timed(run: Callable[[], T], repeats: int) -> tuple[T, float]:
    """What run() gives and its median time in s, of repeats, but no more once they took LONG."""
    spent: list[float] = []
    while True:
        began = perf_counter()
        result = run()
        spent.append(perf_counter() - began)
        if len(spent) >= repeats or sum(spent) > LONG:
            return result, median(spent)


def measure(exact: Reference, scheme: Scheme, steps: int, repeats: int, model: Scene | None = None) -> Run:
    """The scheme over the span of the reference in so many steps, timed warm; repeats = 0: not timed.

    steps: a multiple of the reference's intervals. model: another scene, marched in place of the reference's; only
    quantities that both have are compared.
    """
    scene = model or exact.scene
    t_end = float(exact.t[-1])
    dt, stride = t_end / steps, steps // (len(exact.t) - 1)

    def run() -> Response:
        return march(scene, scheme, dt, t_end, stride=stride)

    r, seconds = run(), np.nan  # the first run compiles
    if repeats:
        r, seconds = timed(run, repeats)
    told = against(exact, scene, r.u, r.v, r.a) if r.status == "completed" else failed(exact, scene)
    return Run(scheme.name, dt, steps, r.status, cost(scene, scheme, r, steps), seconds, told)


def against(exact: Reference, scene: Scene, u: Array, v: Array, a: Array) -> dict[str, Errors]:
    """Errors of each quantity that both scenes have, from u, v, a (n, d) at the reference's times."""
    found = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for name in shared(exact.scene, scene):
            should = QUANTITIES[name](exact.scene, exact.t, exact.u, exact.v, exact.a)
            off = QUANTITIES[name](scene, exact.t, u, v, a) - should
            size = np.sqrt((off * off).sum(axis=1)) / (np.sqrt((should * should).sum(axis=1)).max() or 1.0)
            found[name] = Errors(float(size[-1]), float(size.max()), float(np.sqrt((size * size).mean())))
    return found


def failed(exact: Reference, scene: Scene) -> dict[str, Errors]:
    """The same of a run that did not reach the end."""
    return dict.fromkeys(shared(exact.scene, scene), Errors(np.inf, np.inf, np.inf))


def shared(one: Scene, other: Scene) -> tuple[str, ...]:
    """Quantities of both; of another model those of its coordinates only if they are the same, and never its energy."""
    if one is other:
        return quantities(one)
    told = ("u", "v", "a", "angle") if one.coordinates == other.coordinates else ("angle",)
    return tuple(name for name in told if name in quantities(one) and name in quantities(other))
