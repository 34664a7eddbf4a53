"""The scenes of the work-precision charts, their references, and the runs of all schemes on them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...core.scene_by_name import scene
from ...core.scenes import Scene
from ...core.schemes import scheme, schemes
from ...exact.periods import period
from ..step_counts import SAMPLES
from .measure import Run, measure
from .reference import Reference, reference


@dataclass(frozen=True)
class Case:
    """A scene over a span t_end, s.

    note: a remark printed on its chart; limit: a reference in place of the exact motion, where no step resolves that.
    """

    name: str
    title: str
    make: Callable[[], Scene]
    t_end: float
    finest: int  # the finest step is the span over SAMPLES*2^finest
    note: str = ""
    limit: Callable[[Scene, float], Reference] | None = None

    def reference(self) -> Reference:
        """The motion from which errors are computed."""
        model = self.make()
        return self.limit(model, self.t_end) if self.limit else reference(model, self.t_end, SAMPLES, 1e-12)

    def steps(self, every: int) -> list[int]:
        """Numbers of steps, from coarse to fine, by factors of 2^every."""
        return [SAMPLES << k for k in range(0, self.finest + 1, every)]


def rigid_limit(pendulum: Scene, t_end: float) -> Reference:
    """Uniform rotation of the elastic pendulum as if its bar could not stretch."""
    L, v0 = pendulum.parameters["L"], pendulum.parameters["v0"]
    t = np.linspace(0.0, t_end, SAMPLES + 1)
    along = np.stack([np.cos(v0 / L * t), np.sin(v0 / L * t)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return Reference(pendulum, t, L * along, v0 * across, -(v0**2) / L * along, lag(pendulum, t_end), "the rigid limit")


def lag(pendulum: Scene, t_end: float) -> float:
    """Angle in rad by which the elastic bar lags at t_end: it turns slower by twice its strain m v0^2/(EA L)."""
    EA, L, m, v0 = pendulum.parameters.values()
    return 2.0 * m * v0**2 / (EA * L) * v0 / L * t_end


CASES = (
    Case("linear", "Linear oscillator, T = 1 s, ξ = 0, 10 periods",
         partial(scene, "linear_oscillator", omega=2 * np.pi), 10.0, 10),
    Case("flexible", "Flexible pendulum, EA = 10⁴ N, 10 s", partial(scene, "elastic_pendulum", EA=1e4), 10.0, 11),
    Case("stiff", "Stiff pendulum, EA = 10¹⁰ N, 10 s",
         partial(scene, "elastic_pendulum", EA=1e10, a0=(-19.6, 0.0)), 10.0, 14,
         "measured against the rigid limit, since steps of use do not resolve the axial vibration", rigid_limit),
)  # fmt: skip

# drawn in the long form only: kernels of most schemes are derived and compiled for these on first use
FURTHER = (
    Case("duffing", "Duffing, u'' + 100 u (1 + 10 u²) = 0, 10 periods",
         partial(scene, "duffing"), 10 * period(scene("duffing")), 11),
    Case("swing", "Pendulum that almost reaches the top, 2 periods",
         partial(scene, "simple_pendulum"), 2 * period(scene("simple_pendulum")), 11),
    Case("softening", "Softening spring, u'' + 100 tanh u = 0, 10 periods",
         partial(scene, "softening"), 10 * period(scene("softening")), 11),
    Case("bounce", "A mass that meets a spring and leaves it, 6 ms",
         partial(scene, "penalty_bounce"), 0.006, 11,
         "contact begins and ends within a step: no scheme keeps its order"),
    Case("chain", "Bathe and Noh's chain: a stiff spring that is moved, and a soft one, 10 s",
         partial(scene, "bathe_noh"), 10.0, 14),
    Case("engineering", "Flexible pendulum in engineering strain, EA = 10⁴ N, 10 s",
         partial(scene, "elastic_pendulum", EA=1e4, strain="engineering"), 10.0, 11),
)  # fmt: skip

# with constraints, by name alone or in the long form: schemes that refuse these are left out
CONSTRAINED = (
    Case("rod", "Rod pendulum under gravity, a constraint, 2 s", partial(scene, "rod_pendulum", g=9.81), 2.0, 9),
    Case("rods", "Double pendulum on two rods, two constraints, 1 s", partial(scene, "rod_double_pendulum"), 1.0, 9),
    Case("crank", "Slider and crank, two constraints, 0.1 s", partial(scene, "slider_crank"), 0.1, 9),
    Case("squeezer", "Andrews' squeezing mechanism, six constraints, 0.03 s", partial(scene, "squeezer"), 0.03, 9),
)
EVERY = (*CASES, *FURTHER, *CONSTRAINED)


def runs(case: Case, exact: Reference, names: Iterable[str] | None = None, *, every: int, repeats: int) -> list[Run]:
    """Every scheme (or those named) at its default parameters and at each number of steps.

    Without those that refuse a scene with constraints.
    """
    found: list[Run] = []
    for name in names or schemes():
        try:
            found += [measure(exact, scheme(name), n, repeats) for n in case.steps(every)]
        except ValueError:
            if not exact.scene.info.multipliers:
                raise
    return found


def span(model: Scene) -> float:
    """The span (s) of the work-precision chart of this scene. Raises ValueError for a scene without a chart."""
    found = next((case.t_end for case in EVERY if case.make().name == model.name), None)
    if found is None:
        raise ValueError(f"expected a span for {model.name}, which has no chart to take it from; add --t-end in s")
    return found
