"""Which scheme, which step and which model reach a wished accuracy for the least work."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...core.errors import called_as, real_number, unknown_name
from ...core.exports import Exported
from ...core.scene_by_name import scene as make_scene
from ...core.scenes import Scene
from ...core.schemes import Scheme, scheme, schemes
from ...core.style import COLOURS, REFERENCE, look, name_curves, styled
from ...figures.charts import save
from ...marching.scene_lanes import pair_kernels
from ...run.clock import end_asked
from ..step_counts import FINER, PHASES, SAMPLES, ladder
from ..turning import is_elastic_pendulum, outgrows
from .charts import SECTION
from .measure import Run, measure, quantities
from .models import difference, simpler_models
from .reference import MOST_STEPS, Reference, reference
from .tolerance_runs import TOLERANCES, least, measure_chosen

MOST_OPERATIONS = 2e8  # of one run, some tenths of a second
FEW = 3  # reasons that a text holds
REPEATS = 20  # of the run that is recommended


@dataclass(frozen=True)
class Candidate:
    """A model, and a scheme on it at one constant step or one tol; error: the largest of the quantity over the span."""

    model: Scene
    scheme: Scheme
    run: Run
    error: float

    @property
    def method(self) -> str:
        """The scheme with the parameters that it was given, since two may differ in these alone."""
        given = ", ".join(f"{name}={float(value):.6g}" for name, value in self.scheme.given.items())
        return f"{self.scheme.name}({given})" if given else self.scheme.name

    @property
    def dt(self) -> float | None:
        """The constant step, s; None where steps are chosen."""
        return self.run.dt if self.tol is None else None

    @property
    def tol(self) -> float | None:
        """The tolerance by which steps are chosen; None where they are constant."""
        return self.run.tol if np.isfinite(self.run.tol) else None

    @property
    def how(self) -> str:
        """The step or the tolerance in words."""
        return f"dt = {self.dt:.6g} s" if self.tol is None else f"tol = {self.tol:.3g}"

    @property
    def columns(self) -> dict[str, str | float]:
        """Its row in a file; nan for the one of dt (s) and tol that it does not have."""
        run, missing = self.run, float("nan")
        return {
            "scheme": self.method, "model": self.model.name, "dt": self.dt or missing, "tol": self.tol or missing,
            "steps": run.steps, "operations": run.cost.operations, "seconds": run.seconds, "error": self.error,
        }  # fmt: skip


@dataclass(frozen=True)
class Unmade:
    """A scheme and a number of steps with which its errors along a stiff bar outgrow the motion: predicted, not run.

    operations: the fewest that the run would have taken.
    """

    model: Scene
    scheme: Scheme
    steps: int
    operations: int


@dataclass(frozen=True)
class Choice(Exported):
    """best: the candidate of the fewest operations within the accuracy, None if none is; candidates: all tried.

    For every scheme and model, all constant steps of the ladder were tried with which a run costs less than the best
    one, but for those `unmade`; so were all tolerances of the schemes that chose their steps. left_out: why models and
    schemes were not tried. interrupted: Ctrl-C ended the search before that, so that something cheaper may have been
    left untried. `save` keeps the candidates, of which the accurate one of the fewest operations is the best, and the
    text.
    """

    axes: ClassVar = {"candidates": ("candidate",), "left_out": ("reason",), "text": ()}

    quantity: str
    accuracy: float
    reference: Reference
    best: Candidate | None
    candidates: tuple[Candidate, ...]
    interrupted: bool = False
    unmade: tuple[Unmade, ...] = ()
    left_out: tuple[str, ...] = ()

    @property
    def runner_up(self) -> Candidate | None:
        """The most expensive of the candidates that are cheaper than the best, none of which is accurate enough."""
        if self.best is None:
            return None
        cheaper = [c for c in self.candidates if c.run.cost.operations < self.best.run.cost.operations]
        return max(cheaper, key=lambda c: c.run.cost.operations, default=None)

    @property
    def otherwise(self) -> Candidate | None:
        """The cheapest accurate candidate in chosen steps where the best has constant ones, or vice versa."""
        if self.best is None:
            return None
        others = [c for c in self.candidates if (c.tol is None) != (self.best.tol is None)]
        good = [c for c in others if c.error <= self.accuracy]
        return min(good, key=lambda c: c.run.cost.operations, default=None)

    def __str__(self) -> str:
        return self.text

    @property
    def text(self) -> str:
        """What is recommended, and why."""
        if self.interrupted:
            complete = replace(self, interrupted=False)
            return f"interrupted after {len(self.candidates)} runs, of which these say:\n{complete.text}"
        name = {"angle": "angle (rad)"}.get(self.quantity, self.quantity)
        best, next_ = self.best, self.runner_up
        span = self.reference.t[-1]
        if not self.candidates:
            return f"no candidate was run; {self._predicted}"
        if best is None:
            nearest = min(self.candidates, key=lambda c: c.error)
            return (
                f"no candidate keeps the error of {name} below {self.accuracy:g} over {span:g} s; the nearest is "
                f"{nearest.method} on {nearest.model.name} with {nearest.error:.3g} at {nearest.how}"
            )
        run = best.run
        timed = f", {1e3 * run.seconds:.3g} ms" if np.isfinite(run.seconds) else ""  # no run is timed before Ctrl-C
        lines = [
            f"{best.method} on {best.model.name}, {best.how} ({run.steps} steps): error of {name} "
            f"{best.error:.3g} <= {self.accuracy:g} over {span:g} s, {run.cost.operations:.4g} operations{timed}"
        ]
        if next_ is not None:
            lines.append(
                f"the next cheaper, {next_.method} on {next_.model.name} at {next_.how} "
                f"({next_.run.cost.operations:.4g} operations), is off by {next_.error:.3g}"
            )
        uneven = dict.fromkeys(c.method for c in self.candidates if c.tol is not None)
        if other := self.otherwise:
            kind = "chosen" if best.tol is None else "constant"
            lines.append(
                f"in {kind} steps: {other.method} on {other.model.name} at {other.how}, "
                f"{other.run.cost.operations:.4g} operations"
            )
        elif uneven:
            kind = f"chosen steps ({', '.join(uneven)})" if best.tol is None else "constant steps"
            lines.append(f"in {kind} nothing is as accurate for less")
        if self.unmade:
            lines.append(self._predicted)
        lines += [f"left out: {reason}" for reason in self.left_out[:FEW]]
        if more := self.left_out[FEW:]:
            lines.append(f"left out: {len(more)} more, `left_out` says why")
        lines.append(f"reference: {self.reference.source}")
        return "\n".join(lines)

    @property
    def _predicted(self) -> str:
        schemes = len({u.scheme.name for u in self.unmade})
        return (
            f"not run: {len(self.unmade)} steps of {schemes} scheme{'s' * (schemes > 1)}, with which errors along the "
            "stiff bar are predicted to grow beyond the motion (substep.studies.turning)"
        )


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


@called_as('choose("duffing", 1e-3, t_end=10.0)')
def choose(
    scene: Scene | str,
    accuracy: float,
    *,
    t_end: float,
    quantity: str = "u",
    simpler: Sequence[Scene] | None = None,
    among: Sequence[str | Scheme] | None = None,
    chosen: Sequence[str | Scheme] | None = None,
) -> Choice:
    """The least work, counted in operations of the kernels, that keeps a quantity within the accuracy up to t_end (s).

    accuracy: bound on the largest error over the span, relative to the quantity's largest value, or in rad for the
    angle. Errors are taken at equal times, 50 or more and 8 in a vibration or more; a run takes at least as many steps.
    quantity: "u", "v", "a", "energy", "angle" or "multipliers", where the scene has it, or a coordinate or an output by
    name. simpler: simpler models that may replace the scene, by default the rigid bar for an elastic pendulum (see
    `simpler_models`); one has to have the quantity too, and the motion of one that differs by more than the accuracy is
    left out, since no scheme mends that. So are schemes that refuse a model, unless they all refuse the scene.
    among: schemes to choose from, names or handles, by default all, each at its default parameters.
    chosen: those that are tried in steps that choose themselves too, besides constant ones; by default, on each model,
    the one that needs the least work in constant steps, since kernels have to be compiled for each.

    Of an elastic pendulum, constant steps with which errors along the bar are predicted to outgrow the motion are not
    run: `Choice.unmade`. Ctrl-C ends the search with the choice among what was tried, `interrupted`, or as
    KeyboardInterrupt if nothing was. Raises ValueError for a quantity the scene does not have, an accuracy that is not
    positive, no schemes, a scheme of `chosen` that cannot change its step, and a scene whose motion is neither known
    nor resolved by 4 million Runge-Kutta steps.
    """
    accuracy, t_end = real_number("accuracy", accuracy, positive=True), end_asked(t_end)
    scene = make_scene(scene)
    if quantity not in quantities(scene):
        raise unknown_name(f"a quantity of {scene.name}", str(quantity), quantities(scene))
    methods = [scheme(s) for s in (schemes() if among is None else among)]
    uneven = None if chosen is None else [scheme(s) for s in chosen]
    if not methods:
        raise ValueError("expected schemes to choose among, got none; name one, or leave among out for all")
    exact = sampled_reference(scene, t_end, accuracy / FINER, quantity)
    simple = simpler_models(scene, quantity) if simpler is None else simpler
    left_out: list[str] = []
    models = [scene, *(model for model in simple if not _differs(exact, model, quantity, accuracy, left_out))]
    tried: list[Candidate] = []  # one by one, so that it holds what was tried if the search is interrupted
    unmade: list[Unmade] = []
    interrupted = False
    try:
        for model in models:
            before = len(tried)
            steps = {s: _constant(exact, model, s, left_out) for s in methods}
            tried.extend(_search(model, steps, quantity, accuracy, _limit(tried, accuracy), unmade))
            if not (tried or unmade):
                raise ValueError(left_out[-1])
            constant = [(c.scheme, c.run) for c in tried[before:]]
            wanted = least(constant, model, quantity, accuracy) if uneven is None else uneven
            tolerances = {s: _chosen(exact, model, s) for s in wanted}
            tried.extend(_search(model, tolerances, quantity, accuracy, _limit(tried, accuracy), unmade))
    except KeyboardInterrupt:
        if not tried:
            raise
        interrupted = True
    best = min((c for c in tried if c.error <= accuracy), key=_work, default=None)
    if best is not None and not interrupted:
        best = replace(best, run=_repeated(exact, best))
    return Choice(quantity, accuracy, exact, best, tuple(tried), interrupted, tuple(unmade), tuple(left_out))


def _differs(exact: Reference, model: Scene, quantity: str, accuracy: float, left_out: list[str]) -> bool:
    """Whether the model itself, without an error of time steps, is less accurate than is wished; left_out gets why."""
    error = difference(exact, model, quantity, accuracy / FINER)
    if error > accuracy:
        left_out.append(
            f"{model.name} differs from {exact.scene.name} by {error:.3g}" if np.isfinite(error)
            else f"{model.name} has no {quantity} to compare"
        )  # fmt: skip
    return error > accuracy


def _work(candidate: Candidate) -> int:
    return candidate.run.cost.operations


def _limit(tried: Sequence[Candidate], accuracy: float) -> float:
    """The operations of the cheapest run so far that is accurate enough, or the most that a run may take."""
    return min((_work(c) for c in tried if c.error <= accuracy), default=MOST_OPERATIONS)


def _constant(exact: Reference, model: Scene, s: Scheme, left_out: list[str]) -> Iterator[Run | Unmade]:
    """Runs in finer and finer constant steps, but for those predicted to fail; left_out gets why a scheme has none."""
    stiff = model is exact.scene and is_elastic_pendulum(model)
    try:
        for steps in ladder(len(exact.t) - 1):
            if stiff and outgrows(s, model, exact.u, exact.v, float(exact.t[-1]) / steps, steps):
                yield Unmade(model, s, steps, pair_kernels(model, s).OPERATIONS["step"] * steps)
            else:
                yield measure(exact, s, steps, 0, model)
    except ValueError as error:
        left_out.append(str(error))


def _chosen(exact: Reference, model: Scene, s: Scheme) -> Iterator[Run]:
    """Runs at smaller and smaller tolerances."""
    return (measure_chosen(exact, s, tol, 0, model) for tol in TOLERANCES)


def _repeated(exact: Reference, best: Candidate) -> Run:
    """The run of the candidate once more, timed."""
    if best.tol is None:
        return measure(exact, best.scheme, best.run.steps, REPEATS, best.model)
    return measure_chosen(exact, best.scheme, best.tol, REPEATS, best.model)


def _search(
    model: Scene,
    ladders: Mapping[Scheme, Iterator[Run | Unmade]],
    quantity: str,
    accuracy: float,
    limit: float,
    unmade: list[Unmade],
) -> Iterator[Candidate]:
    """Try the next finer run of the method whose last run was the cheapest, until all cost more than an accurate one.

    limit: operations of a run that no candidate may exceed. unmade: gets those that are not run.
    """
    methods = list(ladders)
    queue = [(0.0, i) for i in range(len(methods))]  # operations of the last run of a method, and its place
    while queue and queue[0][0] < limit:
        _, i = heappop(queue)
        run = next(ladders[methods[i]], None)
        if run is None:
            continue
        if isinstance(run, Unmade):
            unmade.append(run)
            heappush(queue, (run.operations, i))
            continue
        error = run.errors[quantity].maximum
        heappush(queue, (run.cost.operations, i))
        if error <= accuracy:
            limit = min(limit, run.cost.operations)
        yield Candidate(model, methods[i], run, error)


@styled
def choice_figure(choice: Choice, axes: Axes | None = None) -> Figure:
    """Error over operations of all candidates, and the recommended run; axes: where, in place of a new figure."""
    panel = Figure(figsize=(9, 6)).subplots() if axes is None else axes
    best, full = choice.best, choice.reference.scene
    by: dict[tuple[str, str, bool], list[Candidate]] = {}
    for c in choice.candidates:
        by.setdefault((c.method, c.model.name, c.tol is not None), []).append(c)
    ranked = sorted(by, key=lambda key: min((c.error, c.run.cost.operations) for c in by[key]))
    near = [key for name in dict.fromkeys(k[1] for k in ranked) for key in [k for k in ranked if k[1] == name][:4]]
    for (method, model, uneven), found in by.items():
        simple = model != full.name
        x, y = [c.run.cost.operations for c in found], [min(max(c.error, 1e-16), 10.0) for c in found]
        style: dict[str, object] = {"color": "0.75", "linewidth": 0.8, "zorder": 1}
        if (method, model, uneven) in near:
            colour, line = look(near.index((method, model, uneven)))
            label = f"{method}, {model}" + (", chosen steps" if uneven else "")
            style = {"color": colour, "linestyle": line, "label": label}
        marker = "D" if uneven else "s" if simple else "o"
        panel.plot(x, y, marker=marker, markersize=4, markerfacecolor="none", **style)  # pyright: ignore
    panel.axhline(choice.accuracy, color=REFERENCE, linewidth=1, linestyle="--", label="wished accuracy")
    if best is not None:
        panel.plot(best.run.cost.operations, best.error, "*", markersize=16, color=COLOURS[3], zorder=5,
                   label=f"recommended: {best.method}, {best.model.name}, {best.how}")  # fmt: skip
    unit = "rad" if choice.quantity == "angle" else "relative"
    panel.set(xscale="log", yscale="log", xlabel="operations of a run", ylim=(None, 20))
    panel.set_ylabel(f"largest error of {choice.quantity} ({unit}); failed runs at 10")
    figure: Any = panel.get_figure()
    if axes is not None:
        name_curves(panel, beside=False)
        return figure
    figure.suptitle(
        f"{full.name} over {choice.reference.t[-1]:g} s: circles this scene, squares a simpler model, "
        "diamonds chosen steps"
    )
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    return figure


def chart(choice: Choice, path: Path) -> None:
    """Save `choice_figure` as path.png and path.svg."""
    save(
        choice_figure(choice), path, SECTION,
        f"""What to choose for {choice.reference.scene.name} over {choice.reference.t[-1]:g} s with an error of
        {choice.quantity} of at most {choice.accuracy:g}: error over the operations of a run, for every step that was
        tried of every scheme; circles on the scene itself, squares on a simpler model, diamonds in steps that choose
        themselves. {choice.text}""",
    )  # fmt: skip
