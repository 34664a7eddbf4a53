"""At which instants the velocity and the acceleration stand that a program returns, where they are not the scheme's."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isnan, nan

import numpy as np

from substep.core.arrays import Array
from substep.core.schemes import scheme as make_scheme
from substep.core.schemes import schemes

from .fit import largest
from .identify import Identification, Match, credible, fitted
from .noise import QUIET, Noise
from .probes import Measured, own_runs
from .stepper import Stepper

INSTANTS = (0.0, -1.0, -0.5, 0.5, 1.0)  # steps after the end of the step


def output_instants(match: Match, own: Sequence[Measured], noise: Noise = QUIET) -> dict[str, float]:
    """Of v and a, by how many steps those returned stand after the end of their step; NaN where found nowhere.

    Of what both the program and the scheme have. own: runs that start by themselves. What stands half a step off is
    compared by the mean of two neighbours, which is exact for central differences, but not for every scheme.
    """
    if match.what == "spectrum" or match.start == "own":
        return {}
    found = {}
    for kind in (1, 2):
        if any(np.isfinite(_off(match, run, kind, 0.0)).any() for run in own):
            found["uva"[kind]] = next((x for x in INSTANTS if _stands(match, own, kind, x, noise)), nan)
    return found


def elsewhere(instants: Mapping[str, float]) -> dict[str, float]:
    """Those that stand off the end of their step."""
    return {kind: x for kind, x in instants.items() if x and not isnan(x)}


def declared_instants(match: Match, stepper: Stepper, noise: Noise = QUIET) -> dict[str, float]:
    """The instants that an adapter declares of late outputs at which these are the scheme's."""
    late = stepper.can.late
    if not late or match.what == "spectrum" or match.start == "own":
        return {}
    own = noise.over(own_runs(replace(stepper, can=replace(stepper.can, late={}))))
    known = {kind: x for kind, x in late.items() if x in INSTANTS}
    return {kind: x for kind, x in known.items() if _stands(match, own, "uva".index(kind), x, noise)}


def with_late_outputs(found: Identification, own: Sequence[Measured], noise: Noise = QUIET) -> Identification:
    """The same, or the schemes that explain the start too, by v or a that stand elsewhere.

    Central differences with velocities half a step behind are, but for the start, the steps of another scheme. Looked
    for among the claimed scheme and all at their defaults, where the first match leaves the start unexplained.
    """
    if not found.matches or found.matches[0].what != "matrix" or found.matches[0].start != "own":
        return found
    if found.claimed is not None and found.claimed.what == "matrix":
        return found
    damping, claimed = bool(own[0].at.xi.any()), [] if found.claimed is None else [found.claimed]
    names = [name for name in schemes() if name not in [match.scheme.name for match in claimed]]
    pool = [s for s in map(make_scheme, names) if not s.info.together and (s.info.damping or not damping)]
    late = []
    for match in (*claimed, *(fitted(s, (), "displacements", own, own, noise) for s in pool)):
        instants = output_instants(match, own, noise) if credible(match, noise) else {}
        late += [match] if elsewhere(instants) and not any(map(isnan, instants.values())) else []
    return replace(found, matches=tuple(late)) if late else found


def _stands(match: Match, own: Sequence[Measured], kind: int, instant: float, noise: Noise) -> bool:
    return largest(np.array([_off(match, run, kind, instant) for run in own])) <= noise.match


def _off(match: Match, run: Measured, kind: int, instant: float) -> Array:
    """How far the returned v or a, moved to the ends of steps, is off that of the scheme."""
    at, n = run.at, run.rows.shape[1] - 1
    a0 = np.zeros(len(at.Omega)) if match.start == "zero" else None
    start = np.array([x or 0.0 for x in run.start[:2]]) / at.powers[:2]
    rows = match.candidate(at).histories(start, a0, n) * at.powers
    x = run.rows[..., kind]
    neighbour = np.roll(x, -1 if instant < 0 else 1, axis=1)  # wrong at either end, which is left out
    moved = {0.0: x, 0.5: 0.5 * (x + neighbour), 1.0: neighbour}[abs(instant)]
    with np.errstate(all="ignore"):
        off = (rows[..., kind] - moved) / at.scale[:, None, kind] / run.sizes[..., 0] / at.scale[:, None, 2]
    return off[:, 2 : n - 1]


def instants_text(instants: Mapping[str, float]) -> str:
    """In words, such as 'v stands 1/2 step before the end of its step'."""
    steps = {0.5: "1/2 step", 1.0: "1 step"}
    sides = [(kind, steps[abs(x)], "before" if x < 0 else "after") for kind, x in instants.items()]
    return ", ".join(f"{kind} stands {by} {side} the end of its step" for kind, by, side in sides)
