"""Claims of chapters 5 and 6, judged by runs of the elastic pendulum, for chapter 5 those of its figures."""

from collections.abc import Sequence
from functools import cache
from itertools import product

import numpy as np

from substep.core.schemes import Array, scheme
from substep.derived import facade
from substep.marching.scene_lanes import march_lanes

from ..by_algebra import NEWMARK_SETS
from ..by_algebra import SPLITS as LINEAR_SPLITS
from ..figures_5 import FLEXIBLE, MARCHES, NAMES, SETS, SPLITS, STIFF, March, Parameters, Run, exact, runs
from .judgement import Claim, Verdict, overall, row

Key = Parameters | None  # None: Bathe's scheme
VISIBLE = 0.01  # of L or of E0: curves closer than this look like one in the thesis's figures
GAIN = 1.01  # a run whose energy exceeds this times E0 gains energy
LONG = 1000.0  # s
ALL_SETS: tuple[Parameters, ...] = tuple(
    (split, *pair) for split, pair in product(sorted({*LINEAR_SPLITS, *SPLITS}), NEWMARK_SETS)
)
STEPS = 0.05 * np.arange(1, 31)  # s, of the search for the largest step that the stiff pendulum survives
FASTER = 1e-6 * np.arange(4)  # relative increases of v0: with steps this large rounding decides how a single run ends


def name(key: Key) -> str:
    """A scheme for a reader: gamma_t and (beta, gamma), or Bathe."""
    return "Bathe" if key is None else f"gamma_t = {float(key[0]):g} ({float(key[1]):g}, {float(key[2]):g})"


def names(keys: list[Parameters]) -> str:
    """The number of schemes and their names, or "none"."""
    return f"{len(keys)}: " + ", ".join(map(name, keys)) if keys else "none"


def losses(march: March) -> dict[Key, Array]:
    """Relative loss of energy and of angular momentum at the end of each run."""
    ends = {key: np.array([run.energy[-1], run.angular_momentum[-1]]) for key, run in runs(march).items()}
    first = next(iter(runs(march).values()))
    start = np.array([first.energy[0], first.angular_momentum[0]])
    return {key: 1 - end / start for key, end in ends.items()}


def where(march: March) -> str:
    """Case and step for a reader."""
    return f"{march.case}, h = {march.h:g} s"


def claim_5_1() -> tuple[Verdict, str]:
    """Losses at the end of every run of the figures, over gamma_t."""
    parts, texts = [], []
    for pair in NEWMARK_SETS:
        rising = []
        for march in MARCHES:
            lost = np.array([losses(march)[split, *pair] for split in SPLITS])
            rising.append(bool((np.diff(lost, axis=0) > 0).all()))
            if not rising[-1]:
                texts.append(f"{where(march)}, ({float(pair[0]):g}, {float(pair[1]):g}): {row(lost[:, 0])}")
        parts += rising
    return overall(*parts), (
        f"both losses rise with gamma_t = 0.2, 0.5, 0.9 for {sum(parts)} of {len(parts)} (case, step, set); not so, "
        f"shares of energy lost: {'; '.join(texts)}"
    )


def claim_5_2() -> tuple[Verdict, str]:
    """Losses at the end of every run of the figures, along Table 4.1."""
    parts, least = [], np.inf
    for march, split in product(MARCHES, SPLITS):
        lost = np.array([losses(march)[split, *pair] for pair in NEWMARK_SETS])
        parts.append(bool((np.diff(lost, axis=0) > 0).all()))
        least = min(least, float(np.diff(lost, axis=0).min()))
    at = losses(FLEXIBLE[0.01])
    shown = row(100 * at[SPLITS[1], *pair][0] for pair in NEWMARK_SETS)
    return overall(*parts), (
        f"both losses rise along Table 4.1 for {sum(parts)} of {len(parts)} (case, step, gamma_t), from set to set by "
        f"{least:.2g} of the start at least; flexible, h = 0.01 s, gamma_t = 0.5: {shown} % of the energy in 30 s"
    )


def claim_5_3() -> tuple[Verdict, str]:
    """Energy lost in 30 s at h = 1e-4 s."""
    parts, texts = [], []
    for march in (FLEXIBLE[1e-4], STIFF[1e-4]):
        lost = {key: float(loss[0]) for key, loss in losses(march).items()}
        visible = [key for key in SETS if lost[key] > VISIBLE]
        parts += [lost[key] <= VISIBLE for key in SETS]
        first = max(abs(lost[split, *NEWMARK_SETS[0]]) for split in SPLITS)
        texts.append(
            f"{march.case}: {first:.2g} of the energy in 30 s at most for (0.25, 0.5), but {lost[SETS[-1]]:.3g} for "
            f"{name(SETS[-1])}; more than {VISIBLE:g} for {names(visible)}"
        )
    return overall(*parts), "; ".join(texts)


def _gain(found: dict[Key, Run]) -> tuple[float, str]:
    """The largest ratio of energy to that at the start, and as text with the scheme that reaches it."""
    worst = max(found, key=lambda key: found[key].peak)
    ratio = found[worst].peak / found[worst].energy[0]
    return ratio, f"{ratio:.6g} E0, {name(worst)}"


def claim_5_4() -> tuple[Verdict, str]:
    """The largest energy of the figures' runs and of longer ones."""
    flexible = (*FLEXIBLE.values(), *(March("flexible", h, LONG) for h in (0.01, 0.05)))
    highest, text = max(_gain(runs(march)) for march in flexible)
    _, coarser = _gain(runs(March("flexible", 0.3, 999.0)))
    within, text_within = _gain(runs(STIFF[0.1]))
    culprit: Parameters = SETS[0]
    later = runs(March("stiff", 0.1, 2 * LONG))
    run = later[culprit]
    momentum = runs(STIFF[0.1])[culprit].angular_momentum
    others = max(r.peak / r.energy[0] for key, r in later.items() if key != culprit)
    at = np.searchsorted(run.t, LONG)
    fine = runs(March("stiff", 0.01, LONG))[culprit]
    (limit,) = facade.rigid_energy("newmark_bdf2", beta=culprit[1], gamma=culprit[2]).sign_changes
    return overall(highest <= GAIN, within <= GAIN, others <= GAIN, run.peak <= GAIN * run.energy[0]), (
        f"flexible, h <= 0.05 s, to 1000 s: at most {text} (but h = 0.3 s: {coarser}); stiff, h = 0.1 s: at most "
        f"{text_within}, within 50 s (angular momentum {momentum[-1] / momentum[0]:.4g} of the start), "
        f"{run.energy[at] / run.energy[0]:.3g} E0 at {run.t[at]:g} s, then {run.status} at {run.reached:g} s with "
        f"{run.peak / run.energy[0]:.3g} E0; h = 0.01 s: {fine.energy[-1] / fine.energy[0]:.6f} E0 at 1000 s; all "
        f"other sets to 2000 s at most {others:.6g} E0; in the rigid limit (0.25, 0.5) gains energy for gamma_t below "
        f"{limit:.6g}"
    )


def distances(march: March) -> dict[Parameters, float]:
    """Largest distance in m from Bathe's position at the same time."""
    found = runs(march)
    return {key: float(np.linalg.norm(found[key].u - found[None].u, axis=1).max()) for key in SETS}


def rings_apart(march: March) -> float:
    """Largest difference in m between a scheme's and Bathe's least or greatest distance from the pivot."""
    radii = {key: np.linalg.norm(run.u, axis=1) for key, run in runs(march).items()}
    rings = {key: np.array([r.min(), r.max()]) for key, r in radii.items()}
    return max(float(np.abs(rings[key] - rings[None]).max()) for key in SETS)


def claim_5_5() -> tuple[Verdict, str]:
    """Distances from the positions of Bathe's scheme at the same time, and differences of the rings that paths fill."""
    parts, texts = [], []
    for march in MARCHES:
        apart, close = distances(march), VISIBLE * march.scene.length
        agreeing = [key for key, distance in apart.items() if distance <= close]
        parts += [len(agreeing) == len(SETS), rings_apart(march) <= close]
        texts.append(
            f"{where(march)}: within {close:.2g} m for {len(agreeing)} of {len(SETS)} sets, at most "
            f"{max(apart.values()):.3g} m; rings differ by {rings_apart(march):.2g} m"
        )
    return overall(*parts), (
        "without their time all curves fill one ring; positions at the same time part, distance from Bathe's over "
        f"the figure's span: {'; '.join(texts)}"
    )


def claim_5_6() -> tuple[Verdict, str]:
    """Peak strain in the last second of each figure."""
    parts, texts, peaks = [], [], {}
    for march, end in ((FLEXIBLE[1e-4], 15.0), (FLEXIBLE[0.01], 15.0), (STIFF[1e-4], 30.0), (STIFF[0.1], 50.0)):
        for split in SPLITS:
            found = {key: run for key, run in runs(march).items() if key is None or key[0] == split}
            last = (found[None].t > end - 1) & (found[None].t <= end)  # 3 axial periods of the flexible bar
            peaks = {key: float(run.strain[last].max()) for key, run in found.items()}
            parts.append(min(peaks, key=peaks.__getitem__) == (split, *NEWMARK_SETS[-1]))
        texts.append(f"{where(march)}, gamma_t = {float(SPLITS[-1]):g}: {row(peaks.values())}")
    return overall(*parts), (
        f"peak strain in the last second of the figure is least for (0.49, 0.9) in {sum(parts)} of {len(parts)} "
        f"panels; along Table 4.1 and Bathe: {'; '.join(texts)}"
    )


@cache
def largest_steps() -> dict[Key, float]:
    """The largest of STEPS, in s, up to which the stiff pendulum survives 1000 s with each, at all FASTER speeds.

    Survived: completed with E <= 1.01 E0 throughout.
    """
    pendulum = STIFF[0.1].scene
    dt = np.repeat(STEPS, len(FASTER))
    speeds = np.tile(1 + FASTER, len(STEPS))

    def survived(method: str, keys: Sequence[Key], values: dict[str, Array]) -> dict[Key, float]:
        h = np.tile(dt, len(keys))
        v = np.tile(speeds, len(keys))[:, None] * pendulum.v0
        u, a = (np.broadcast_to(x, v.shape) for x in (pendulum.u0, pendulum.a0))
        bound = GAIN * pendulum.energy(np.zeros(len(v)), u, v)
        n = np.round(LONG / h).astype(np.int64)
        lanes = march_lanes(pendulum, scheme(method, **values), h, n, start=(u, v, a), bound=bound)
        good = (lanes.status == 0).reshape(len(keys), len(STEPS), len(FASTER)).all(axis=2)
        counts = np.minimum.accumulate(good, axis=1).sum(axis=1)
        return {key: float(STEPS[count - 1]) if count else 0.0 for key, count in zip(keys, counts, strict=True)}

    columns = np.repeat(np.array(ALL_SETS, dtype=np.float64), len(dt), axis=0).T
    newmark = survived("newmark_bdf2", ALL_SETS, dict(zip(NAMES, columns, strict=True)))
    return newmark | survived("bathe", (None,), {})


def claim_6_1() -> tuple[Verdict, str]:
    """Energy lost against the largest step that the stiff pendulum survives."""
    limits, lost = largest_steps(), {key: loss[0] for key, loss in losses(FLEXIBLE[0.01]).items()}
    more = [key for key in SETS if lost[key] > lost[None]]
    better = [key for key in more if limits[key] > limits[None]]
    worse = [key for key in more if limits[key] < limits[None]]
    most = max(more, key=lost.__getitem__)
    pendulum = STIFF[0.1].scene
    turn = limits[None] * pendulum.v0[1] / pendulum.length
    return overall(*(key in better for key in more)), (
        f"{len(more)} of {len(SETS)} sets lose more energy than Bathe (flexible, h = 0.01 s); the stiff pendulum "
        f"survives 1000 s up to a larger step than Bathe's, {limits[None]:g} s or {turn:.2g} rad, with {len(better)} "
        f"of them, up to a smaller one with {names(worse)} ({row(limits[key] for key in worse)} s); the most "
        f"dissipative, {name(most)}: {limits[most]:g} s"
    )


def _errors(march: March) -> dict[Key, float]:
    """Largest distance in m from the exact position."""
    _, truth = exact(march, 1)
    return {key: float(np.linalg.norm(run.u - truth, axis=1).max()) for key, run in runs(march, ALL_SETS).items()}


def claim_6_2() -> tuple[Verdict, str]:
    """Errors of the flexible pendulum against the largest step that the stiff one survives."""
    limits, coarse, fine = largest_steps(), _errors(FLEXIBLE[0.05]), _errors(FLEXIBLE[0.01])
    # less by more than rounding: one of the sets is Bathe's scheme itself
    accurate = [key for key in ALL_SETS if all(e[key] < (1 - 1e-6) * e[None] for e in (coarse, fine))]
    stable = [key for key in ALL_SETS if limits[key] > limits[None]]
    both = [key for key in accurate if key in stable]
    text = (
        f"of {len(ALL_SETS)} sets (gamma_t of chapters 4 and 5), largest error of the flexible pendulum's position in "
        f"30 s below Bathe's at h = 0.01 and 0.05 s: {names(accurate)}; the stiff one survives up to a larger step: "
        f"{len(stable)}; both: {names(both)}"
    )
    if both:
        best = min(both, key=fine.__getitem__)
        text += (
            f", error {fine[best]:.4g} and {coarse[best]:.4g} m (Bathe {fine[None]:.4g} and {coarse[None]:.4g} m), "
            f"step {limits[best]:g} s (Bathe {limits[None]:g} s)"
        )
    return overall(bool(both)), text


def claim_6_3() -> tuple[Verdict, str]:
    """Energy lost in 30 s over four steps."""
    parts, texts, steps = [], [], (0.01, 0.05, 0.1, 0.2)
    for case in ("flexible", "stiff"):
        lost = [losses(March(case, h, 30.0)) for h in steps]
        series = {key: [float(loss[key][0]) for loss in lost] for key in lost[0]}
        rising = [bool(np.diff(values).min() > 0) for values in series.values()]
        parts += rising
        shown = "; ".join(f"{name(key)} {row(series[key])}" for key in (None, SETS[0], SETS[-1]))
        texts.append(f"{case}: for {sum(rising)} of {len(rising)} schemes, {shown}")
    return overall(*parts), (
        f"the share of energy lost in 30 s rises over h = {', '.join(f'{h:g}' for h in steps)} s, {'; '.join(texts)}"
    )


CLAIMS = (
    Claim(
        "C5.1",
        "For the same step, dissipation of energy and angular momentum grows with gamma_t (flexible; stiff).",
        "substep reproduce",
        claim_5_1,
    ),
    Claim(
        "C5.2",
        "Dissipation grows with the Newmark parameters, greatest for (.49, .9).",
        "substep reproduce",
        claim_5_2,
    ),
    Claim(
        "C5.3",
        "At h = 1e-4 s dissipation is very small.",
        "substep reproduce",
        claim_5_3,
    ),
    Claim(
        "C5.4",
        "No growth in energy and momentum is observed (flexible; and the stiff case, beyond the axes of the "
        "figures and beyond 50 s).",
        "substep reproduce --full",
        claim_5_4,
    ),
    Claim(
        "C5.5",
        "Complete agreement of trajectories with Bathe (flexible, all h; stiff, h = 1e-4 s); slight variation"
        " at h = .1 s.",
        "substep reproduce",
        claim_5_5,
    ),
    Claim(
        "C5.6",
        "Least axial strain for (.49, .9).",
        "substep reproduce",
        claim_5_6,
    ),
    Claim(
        "C6.1",
        "Higher dissipation gives better numerical stability than Bathe.",
        "substep claims",
        claim_6_1,
    ),
    Claim(
        "C6.2",
        "Some combinations are better than Bathe in stability and accuracy (both at once?).",
        "substep claims",
        claim_6_2,
    ),
    Claim(
        "C6.3",
        "Too large a time step leads to excessive dissipation.",
        "substep claims",
        claim_6_3,
    ),
)
