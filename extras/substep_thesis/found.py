"""What was found, in five sentences, each with the figure that shows it: the opening of the page of results.

Every number in a sentence is computed when the results are. Sentences compare; verdicts are the ledger's.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import numpy as np

from substep.core.schemes import scheme
from substep.derived import facade

from .by_algebra import NEWMARK_SETS, SPLITS
from .catalogue_charts import CERTIFIED, at_equal_cost, certified, compared
from .claims.chapter_4 import composite
from .claims.chapter_5 import LONG, VISIBLE, distances, rings_apart
from .figures_5 import PLOTS, SETS, STIFF, March, runs


@dataclass(frozen=True)
class Found:
    """A sentence, the name of the figure that shows it, and the ids of claims that it bears on."""

    figure: str
    claims: tuple[str, ...]
    text: str


def stability() -> Found:
    """How many sets of Table 4.1, and how many points of the plane around them, are certified stable."""
    proved = [
        facade.certificate("newmark_bdf2", gamma_t=split, beta=beta, gamma=gamma).stable
        for split, (beta, gamma) in product(SPLITS, NEWMARK_SETS)
    ]
    stable = [point for point in CERTIFIED if certified(*point)]
    return Found(
        "stability_region", ("C4.3",),
        f"{sum(proved)} of the {len(proved)} parameter sets of chapter 4 are stable at every step, by exact proof; so "
        f"are {len(stable)} of {len(CERTIFIED)} points of the plane (γ_t, γ), the lowest at γ = "
        f"{min(gamma for _, gamma in stable)}.",
    )  # fmt: skip


def low_modes() -> Found:
    """The damping of a low mode beside Bathe's, of the two sets that are said to preserve low modes better."""
    ratio, split = 0.05, SPLITS[0]
    at = 2 * np.pi * ratio
    bathe = scheme("bathe").numerical_damping(at)
    first, second = (
        f"{float(composite(split, beta, gamma).numerical_damping(at) / bathe):.2g} times Bathe's with "
        f"(β, γ) = ({float(beta):g}, {float(gamma):g})"
        for beta, gamma in NEWMARK_SETS[:2]
    )
    return Found(
        "figure_4_1", ("C4.4",),
        f"At γ_t = {float(split):g}, h/T = {ratio:g} numerical damping is {first} and {second}.",
    )  # fmt: skip


def equal_cost() -> Found:
    """Amplitude lost in a period at the same number of solves: Newmark-BDF2, Bathe's scheme and the least."""
    solves = 100
    gamma = next(iter(compared().values())).parameters["gamma"]
    lost = {s.name: float(at_equal_cost(s, solves)[0]) for s in compared().values()}
    least = min(lost, key=lost.__getitem__)
    return Found(
        "trade_off_equal_cost", (),
        f"At {solves} solves a period Newmark-BDF2 (γ = {float(gamma):g}) loses {lost['newmark_bdf2']:.2g} % of its "
        f"amplitude in a period, Bathe's scheme {lost['bathe']:.2g} %, the least of {len(lost)}, {least}, "
        f"{lost[least]:.2g} %.",
    )  # fmt: skip


def energy() -> Found:
    """How the energy of the stiff pendulum grows with the first set, within the thesis's figure and beyond it."""
    split, beta, gamma = SETS[0]
    march = STIFF[0.1]
    shown, longer = (runs(one)[SETS[0]] for one in (march, March(march.case, march.h, 2 * LONG)))
    (limit,) = facade.rigid_energy("newmark_bdf2", beta=beta, gamma=gamma).sign_changes
    at = np.searchsorted(longer.t, LONG)
    E0 = shown.energy[0]
    return Found(
        "map_newmark_bdf2_gamma_t", ("C5.4",),
        f"On the stiff pendulum (h = {march.h:g} s) ({beta}, {gamma}), γ_t = {float(split):g} has at most "
        f"{shown.peak / E0:.3g} E0 in {march.t_end:g} s, but {longer.energy[at] / E0:.2g} E0 at {LONG:g} s, and ends "
        f"as {longer.status} at {longer.reached:g} s; derived: E grows for γ_t < {limit:.4g}.",
    )  # fmt: skip


def positions() -> Found:
    """How far positions on the stiff pendulum part from those of Bathe's scheme at the same time."""
    march = STIFF[0.1]
    apart, close = distances(march), VISIBLE * march.scene.length
    drawn = next(p for p in PLOTS if p.kind == "trajectory" and p.march == march)
    return Found(
        f"figure_5_{drawn.number}", ("C5.5",),
        f"On the stiff pendulum (h = {march.h:g} s) {sum(d <= close for d in apart.values())} of {len(apart)} sets "
        f"keep within {close:.1g} m of Bathe's position for {march.t_end:g} s; others are up to "
        f"{max(apart.values()):.2g} m away from it, though all move on one ring, to {rings_apart(march):.1g} m.",
    )  # fmt: skip


SENTENCES: tuple[Callable[[], Found], ...] = (stability, low_modes, equal_cost, energy, positions)


def write(folder: Path, found: Sequence[Found]) -> None:
    """Write found.json into the folder, from which the page of results takes its opening."""
    text = json.dumps([asdict(one) for one in found], indent=1, ensure_ascii=False)
    (folder / "found.json").write_text(text + "\n", encoding="utf-8")
