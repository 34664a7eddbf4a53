"""Which scheme, which step and how many modes, or none, reach a wished accuracy of a structure for the least work."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from ...core import coefficients
from ...core.errors import called_as, real_number, unknown_name, warn
from ...core.exports import Exported
from ...core.schemes import Scheme, schemes
from ...core.schemes import scheme as make_scheme
from ...run.clock import end_asked
from ...structures.march.refusals import require_linear
from ...structures.march.response import StructureResponse
from ...structures.model.given import Dof
from ...structures.structure import Modes, Structure
from ..step_counts import ladder
from .prediction import Parts, Prediction

Model = Literal["any", "direct", "modal"]
MODES = 60  # by which the motion is known, unless told otherwise
MOST_OPERATIONS = 2e8  # of the modes of one run


@dataclass(frozen=True)
class StructureCandidate:
    """A scheme, a constant step, and a model: the first `modes` modes with static correction, or None for all of it.

    error: predicted, the largest of the displacement over the span relative to its largest value. work: operations.
    """

    scheme: Scheme
    steps: int
    dt: float
    modes: int | None
    error: float
    work: float

    @property
    def model(self) -> str:
        """The model in words."""
        return "the whole structure" if self.modes is None else f"{self.modes} modes with static correction"

    @property
    def columns(self) -> dict[str, str | float]:
        """Its row in a file; 0 modes stand for the whole structure."""
        return {
            "scheme": self.scheme.name, "steps": self.steps, "dt": self.dt, "modes": self.modes or 0,
            "error": self.error, "work": self.work,
        }  # fmt: skip


@dataclass(frozen=True)
class StructureChoice(Exported):
    """best: the candidate of the least work within the accuracy, None if none is; parts: of its error.

    modes: those by which errors were predicted. unforeseen: at most about what other modes add to them, see
    `Prediction.unforeseen`. candidates: all tried, of each scheme and step the whole structure, and the fewest modes
    that are accurate, or the most accurate number of them; neither where it would need more work than one that was
    found before. `save` keeps them, and the text.
    """

    axes: ClassVar = {"candidates": ("candidate",), "text": ()}

    quantity: Dof
    accuracy: float
    t_end: float
    modes: Modes
    best: StructureCandidate | None
    parts: Parts | None
    unforeseen: float
    candidates: tuple[StructureCandidate, ...]

    def march(self, **options: Any) -> StructureResponse:
        """Run the best candidate; options as those of `substep.march`, dofs=[quantity] by default.

        Raises ValueError where no candidate is accurate enough.
        """
        if self.best is None:
            raise ValueError(f"expected a candidate within {self.accuracy:g}, got none; see text for the nearest one")
        given = {"dofs": [self.quantity], "dt": self.best.dt, "t_end": self.t_end, **options}
        if self.best.modes is None:
            return self.modes.structure.march(self.best.scheme, **given)
        return self.modes.first(self.best.modes).march(self.best.scheme, static_correction=True, **given)

    def __str__(self) -> str:
        return self.text

    @property
    def text(self) -> str:
        """What is recommended, and why."""
        known = f"predicted from {len(self.modes)} modes against their exact response"
        if not self.modes.lanes:
            known = (
                f"{self.modes.together}: the reduced system of {len(self.modes)} modes was marched, and compared with "
                "its matrix exponential"
            )
        if self.unforeseen > 0.0:
            known += f"; modes that are not known may add up to about {self.unforeseen:.2g}"
        if self.best is None or self.parts is None:
            if not self.candidates:
                return f"nothing was tried: no scheme is stable with few enough steps; {known}"
            near = min(self.candidates, key=lambda c: c.error)
            return (
                f"no candidate keeps the error of {self.quantity!r} below {self.accuracy:g}; the nearest is "
                f"{near.scheme.name} on {near.model} with {near.error:.3g} at dt = {near.dt:.6g}; {known}"
            )
        best, parts = self.best, self.parts
        lines = [
            f"{best.scheme.name} on {best.model}, dt = {best.dt:.6g} ({best.steps} steps): error of {self.quantity!r} "
            f"{best.error:.3g} <= {self.accuracy:g} over {self.t_end:g}, {best.work:.3g} operations",
            f"parts, of which some may cancel others: truncated modes {parts.truncation:.2g}, time integration "
            f"{parts.integration:.2g}, load sampling {parts.load_sampling:.2g}",
        ]
        if other := self.otherwise:
            lines.append(
                f"on {other.model}: {other.scheme.name}, dt = {other.dt:.6g}, error {other.error:.3g}, "
                f"{other.work:.3g} operations"
            )
        return "\n".join([*lines, known])

    @property
    def otherwise(self) -> StructureCandidate | None:
        """The accurate candidate of least work on the whole structure where the best is modal, or vice versa."""
        if self.best is None:
            return None
        direct = self.best.modes is None
        good = [c for c in self.candidates if (c.modes is None) != direct and c.error <= self.accuracy]
        return min(good, key=lambda c: c.work, default=None)


@called_as('choose(structure, 1e-3, t_end=10.0, quantity="roof")')
def choose(
    structure: Structure | Modes,
    accuracy: float,
    *,
    t_end: float,
    quantity: Dof,
    among: Sequence[str | Scheme] | None = None,
    modes: int | None = None,
    model: Model = "any",
) -> StructureChoice:
    """The least work that keeps the displacement of a degree of freedom within the accuracy up to t_end (s).

    accuracy: bound on the largest error over the span, relative to the largest displacement, at 50 times or more and 8
    in a vibration or more; a run takes at least as many steps. quantity: name or number of the degree of freedom.
    among: schemes to choose from, by default all that take the structure's damping, at their default parameters. modes:
    how many modes the prediction is made from, by default 60, or all where there are fewer; a structure's `Modes` may
    be given in its place, and are then not computed again. model: "direct" for the whole structure, "modal" for modes
    with static correction, "any" for the cheaper. Warns where modes that are not known may add as much as the accuracy.

    With classical damping nothing is marched but modes: the error of a scheme on each mode, against its exact response,
    is added up; modes beyond those known are taken to follow statically, and what they may do otherwise is estimated.
    Else the reduced coupled system is. Work is counted in operations: those of the lanes of all modes, or two for each
    nonzero of K twice a balance, as if a factorization had no fill, which is least for direct steps.

    Raises ValueError for an accuracy or span that is not positive, an unknown quantity, model or scheme, a degree of
    freedom that does not move, a structure with an internal force, and as `Structure.modes`.
    """
    accuracy, t_end = real_number("accuracy", accuracy, positive=True), end_asked(t_end)
    if model not in get_args(Model):
        raise unknown_name("a model", str(model), get_args(Model))
    if isinstance(structure, Modes):
        known = structure if modes is None else structure.first(modes)
    else:
        known = known_modes(structure, modes)
    require_linear(known.structure, "a choice by its modes")
    known.structure.place(quantity)
    methods = [make_scheme(s) for s in (schemes() if among is None else among)]
    methods = [s for s in methods if among is not None or not s.info.together]
    methods = [s for s in methods if s.info.damping or not known.damping.any()]
    if not methods:
        raise ValueError("expected schemes to choose among that take damping, got none; leave among out for all")
    prediction = Prediction(known, quantity, t_end, accuracy)
    assert prediction.scale > 0.0  # raises for one that does not move, before anything is tried
    tried: list[StructureCandidate] = []
    bests: dict[bool, StructureCandidate] = {}  # of the whole structure, and of modes
    for n in ladder(prediction.rows):
        within = [s for s in methods if n * _of_modes(known, s, len(known)) <= MOST_OPERATIONS]
        kinds = {s: found for s in within if (found := _may_be_less(known, s, n, model, bests))}
        if not kinds:
            break
        for c in (c for s, wanted in kinds.items() for c in _candidates(prediction, s, n, wanted)):
            tried.append(c)
            direct = c.modes is None
            if c.error <= accuracy and (direct not in bests or c.work < bests[direct].work):
                bests[direct] = c
    best = min(bests.values(), key=lambda c: c.work, default=None)
    parts = None
    if best is not None:
        parts = prediction.parts(best.scheme, best.steps, len(known) if best.modes is None else best.modes)
    unforeseen = prediction.unforeseen
    if unforeseen >= accuracy:
        warn(
            f"errors of {quantity!r} are predicted from {len(known)} modes, and others may add up to about "
            f"{unforeseen:.2g}, which is not within {accuracy:g}; give more modes, or take the choice for right to "
            f"{unforeseen:.2g} only"
        )
    return StructureChoice(quantity, accuracy, t_end, known, best, parts, unforeseen, tuple(tried))


def known_modes(structure: Structure, n: int | None = None) -> Modes:
    """The modes by which a motion is known: n, by default 60, or all where there are fewer. Raises as they do."""
    return structure.modes(min(MODES, structure.size - len(structure.massless)) if n is None else n)


def _candidates(p: Prediction, s: Scheme, n: int, kinds: Sequence[bool]) -> Iterator[StructureCandidate]:
    errors, dt = p.errors(s, n), p.t_end / n
    if True in kinds and np.isfinite(errors[-1]) and p.stable_directly(s, n):
        yield StructureCandidate(s, n, dt, None, float(errors[-1]), n * _of_structure(p.modes, s))
    if False in kinds and np.isfinite(errors).any():
        good = np.flatnonzero(errors <= p.accuracy)
        m = int(good[0]) if len(good) else int(np.argmin(errors))
        yield StructureCandidate(s, n, dt, m, float(errors[m]), n * _of_modes(p.modes, s, m))


def _of_modes(modes: Modes, s: Scheme, m: int) -> float:
    """Operations of a step of m modes: their lanes, or the reduced system where damping couples them."""
    if not modes.lanes:
        return s.balances * 4.0 * m * m
    size, R, K = coefficients.sizes(s)
    return m * 2.0 * (size + R) * (size + K)


def _of_structure(modes: Modes, s: Scheme) -> float:
    """Operations of a step of the whole structure, if factors had no more nonzeros than K."""
    K = modes.structure.K
    return s.balances * 4.0 * (K.size if isinstance(K, np.ndarray) else K.nnz)


def _may_be_less(modes: Modes, s: Scheme, n: int, model: Model, bests: Mapping[bool, StructureCandidate]) -> list[bool]:
    """Where n steps of the scheme may need less work than the best so far: True: the whole structure, False: modes."""
    least = {True: n * _of_structure(modes, s), False: n * _of_modes(modes, s, 1 if modes.lanes else len(modes))}
    wanted = {"direct": (True,), "modal": (False,), "any": (True, False)}[model]
    return [kind for kind in wanted if kind not in bests or least[kind] < bests[kind].work]
