"""Which scheme, which step and which model reach a wished accuracy for the least work."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from heapq import heapreplace
from itertools import count
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ...core.errors import real_number, unknown_name
from ...core.scenes import Scene
from ...core.scenes import scene as make_scene
from ...core.schemes import Scheme, scheme, schemes
from ...figures.charts import COLOURS, REFERENCE, look, save
from .cases import SAMPLES
from .charts import SECTION
from .measure import Run, measure, quantities, shared
from .reference import MOST_STEPS, Reference, reference

MOST_OPERATIONS = 2e8  # of one run, some tenths of a second
REPEATS = 20  # of the run that is recommended
PHASES = 8  # errors are reported at least this often in a vibration
FINER = 100  # the reference is this many times more accurate than is wished of a run


@dataclass(frozen=True)
class Candidate:
    """A model, and a scheme at one step on it; error: the largest of the wished quantity over the span."""

    model: Scene
    scheme: Scheme
    run: Run
    error: float

    @property
    def method(self) -> str:
        """The scheme with the parameters that it was given, since two may differ in these alone."""
        given = ", ".join(f"{name}={float(value):.6g}" for name, value in self.scheme.given.items())
        return f"{self.scheme.name}({given})" if given else self.scheme.name


@dataclass(frozen=True)
class Choice:
    """best: the candidate of the fewest operations within the accuracy, None if none is; candidates: all tried.

    For every scheme and model, all steps of the ladder were tried with which a run costs less than the best one.
    """

    quantity: str
    accuracy: float
    reference: Reference
    best: Candidate | None
    candidates: tuple[Candidate, ...]

    @property
    def runner_up(self) -> Candidate | None:
        """The most expensive of the candidates that are cheaper than the best, none of which is accurate enough."""
        if self.best is None:
            return None
        cheaper = [c for c in self.candidates if c.run.cost.operations < self.best.run.cost.operations]
        return max(cheaper, key=lambda c: c.run.cost.operations, default=None)

    @property
    def text(self) -> str:
        """What is recommended, and why."""
        name = {"angle": "angle (rad)"}.get(self.quantity, self.quantity)
        best, next_ = self.best, self.runner_up
        span = self.reference.t[-1]
        if best is None:
            least = min(self.candidates, key=lambda c: c.error)
            return (
                f"no candidate keeps the error of {name} below {self.accuracy:g} over {span:g} s; the nearest is "
                f"{least.method} on {least.model.name} with {least.error:.3g} at dt = {least.run.dt:.6g} s"
            )
        run = best.run
        lines = [
            f"{best.method} on {best.model.name}, dt = {run.dt:.6g} s ({run.steps} steps): error of {name} "
            f"{best.error:.3g} <= {self.accuracy:g} over {span:g} s, {run.cost.operations:.4g} operations, "
            f"{1e3 * run.seconds:.3g} ms"
        ]
        if next_ is not None:
            lines.append(
                f"the next cheaper, {next_.method} on {next_.model.name} at dt = {next_.run.dt:.6g} s "
                f"({next_.run.cost.operations:.4g} operations), is off by {next_.error:.3g}"
            )
        lines.append(f"reference: {self.reference.source}")
        return "\n".join(lines)


def rigid(scene: Scene) -> tuple[Scene, ...]:
    """The simpler model of an elastic pendulum: the same pendulum on a bar that cannot stretch."""
    if scene.info.declaration is not None or not scene.name.startswith("elastic_pendulum"):
        return ()
    return (make_scene("rigid_pendulum", **{name: scene.parameters[name] for name in ("L", "m", "v0")}),)


def ladder(samples: int = SAMPLES) -> Iterator[int]:
    """Numbers of steps: 1, 2, 3, 4, 6, 8, 12, ... times the intervals on which errors are reported."""
    yield samples
    for k in count(1):
        yield samples << k
        yield 3 * samples << (k - 1)


def sampled_reference(scene: Scene, t_end: float, wished: float, quantity: str) -> Reference:
    """The reference at PHASES times of a vibration or more, since fewer could meet it at one phase and hide an error.

    The frequency of the vibration is estimated as sqrt(|a|/|u|), which holds even if the times meet it at one phase.
    """
    samples = SAMPLES
    while True:
        exact = reference(scene, t_end, samples, wished, quantity)
        u, a = (float(np.abs(x).max()) for x in (exact.u, exact.a))
        if not u or samples >= min(PHASES * t_end * np.sqrt(a / u) / (2.0 * np.pi), MOST_STEPS // 4):
            return exact
        samples *= 2


def choose(
    scene: Scene,
    accuracy: float,
    *,
    t_end: float,
    quantity: str = "u",
    simpler: Sequence[Scene] | None = None,
    among: Sequence[str | Scheme] | None = None,
) -> Choice:
    """The least work, counted in operations of the kernels, that keeps a quantity within the accuracy up to t_end (s).

    accuracy: bound on the largest error over the span, relative to the quantity's largest value, or in rad for the
    angle. Errors are taken at equal times, 50 or more and 8 in a vibration or more; a run takes at least as many steps.
    quantity: "u", "v", "a", "energy" or "angle", where the scene has it. simpler: simpler models that may replace the
    scene, by default the rigid bar for an elastic pendulum; one is compared only in quantities that both have.
    among: schemes to choose from, names or handles, by default all, each at its default parameters.
    Raises ValueError for a quantity the scene does not have, an accuracy that is not positive, no schemes, and a scene
    whose motion is neither known nor resolved by 4 million Runge-Kutta steps.
    """
    accuracy, t_end = real_number("accuracy", accuracy, positive=True), real_number("t_end", t_end, positive=True)
    if not isinstance(scene, Scene):
        raise ValueError(f"expected a scene, got {scene!r}; make one with ss.scene")
    if quantity not in quantities(scene):
        raise unknown_name(f"a quantity of {scene.name}", str(quantity), quantities(scene))
    methods = [s if isinstance(s, Scheme) else scheme(s) for s in (schemes() if among is None else among)]
    if not methods:
        raise ValueError("expected schemes to choose among, got none; name one, or leave among out for all")
    exact = sampled_reference(scene, t_end, accuracy / FINER, quantity)
    best: Candidate | None = None
    tried: list[Candidate] = []
    for model in (scene, *(rigid(scene) if simpler is None else simpler)):
        if model is not scene and quantity not in shared(scene, model):
            continue
        limit = MOST_OPERATIONS if best is None else best.run.cost.operations
        found = list(_search(exact, model, methods, quantity, accuracy, limit))
        good = [c for c in found if c.error <= accuracy and c.run.cost.operations < limit]
        best = min(good, key=lambda c: c.run.cost.operations, default=best)
        tried += found
    if best is not None:
        best = replace(best, run=measure(exact, best.scheme, best.run.steps, REPEATS, best.model))
    return Choice(quantity, accuracy, exact, best, tuple(tried))


def _search(
    exact: Reference, model: Scene, methods: Sequence[Scheme], quantity: str, accuracy: float, limit: float
) -> Iterator[Candidate]:
    """Try the next finer step of the method whose last run was the cheapest, until all cost more than an accurate one.

    limit: operations of a run that no candidate may exceed.
    """
    steps = [ladder(len(exact.t) - 1) for _ in methods]
    queue = [(0.0, i) for i in range(len(methods))]  # operations of the last run of a method, and its place
    while queue[0][0] < limit:
        _, i = queue[0]
        run = measure(exact, methods[i], next(steps[i]), 0, model)
        error = run.errors[quantity].maximum
        heapreplace(queue, (run.cost.operations, i))
        if error <= accuracy:
            limit = min(limit, run.cost.operations)
        yield Candidate(model, methods[i], run, error)


def chart(choice: Choice, path: Path) -> None:
    """Draw error over operations of all candidates, and the recommended run, as PNG and SVG."""
    figure = Figure(figsize=(9, 6), layout="constrained")
    axes = figure.subplots()
    best, full = choice.best, choice.reference.scene
    by: dict[tuple[str, str], list[Candidate]] = {}
    for c in choice.candidates:
        by.setdefault((c.method, c.model.name), []).append(c)
    ranked = sorted(by, key=lambda key: min((c.error, c.run.cost.operations) for c in by[key]))
    near = [key for name in dict.fromkeys(m for _, m in ranked) for key in [k for k in ranked if k[1] == name][:4]]
    for (method, model), found in by.items():
        simple = model != full.name
        x, y = [c.run.cost.operations for c in found], [min(max(c.error, 1e-16), 10.0) for c in found]
        style: dict[str, object] = {"color": "0.75", "linewidth": 0.8, "zorder": 1}
        if (method, model) in near:
            i = near.index((method, model))
            style = {"color": look(i)[0], "linestyle": look(i)[1], "linewidth": 1.4, "label": f"{method}, {model}"}
        axes.plot(x, y, marker="s" if simple else "o", markersize=4, markerfacecolor="none", **style)  # pyright: ignore
    axes.axhline(choice.accuracy, color=REFERENCE, linewidth=1, linestyle="--", label="wished accuracy")
    if best is not None:
        axes.plot(best.run.cost.operations, best.error, "*", markersize=16, color=COLOURS[3], zorder=5,
                  label=f"recommended: {best.method}, {best.model.name}, dt = {best.run.dt:.4g} s")  # fmt: skip
    unit = "rad" if choice.quantity == "angle" else "relative"
    axes.set(xscale="log", yscale="log", xlabel="operations of a run", ylim=(None, 20))
    axes.set_ylabel(f"largest error of {choice.quantity} ({unit}); failed runs at 10")
    axes.grid(visible=True, linewidth=0.3, color="0.85")
    figure.suptitle(
        f"{full.name} over {choice.reference.t[-1]:g} s: circles this scene, squares a simpler model", fontsize=11
    )
    figure.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    save(
        figure, path, SECTION,
        f"""What to choose for {full.name} over {choice.reference.t[-1]:g} s with an error of {choice.quantity} of at
        most {choice.accuracy:g}: error over the operations of a run, for every step that was tried of every scheme;
        circles on the scene itself, squares on a simpler model. {choice.text}""",
    )  # fmt: skip
