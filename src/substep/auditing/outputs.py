"""At which instants the velocity and the acceleration stand that a program returns, where they are not the scheme's."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..core.arrays import Array
from .fit import largest
from .identify import Match
from .noise import QUIET, Noise
from .probes import Measured

INSTANTS = (-1.0, -0.5, 0.5, 1.0)  # steps after the end of the step


def output_instants(match: Match, own: Sequence[Measured], noise: Noise = QUIET) -> dict[str, float]:
    """Of v and a, by how many steps those returned stand after the end of their step, where they are the scheme's.

    own: runs that start by themselves. What stands half a step off is compared by the mean of two neighbours.
    """
    if match.what != "displacements" or match.start == "own":
        return {}
    found = {}
    for kind in (1, 2):
        for instant in INSTANTS:
            if largest(np.array([_off(match, run, kind, instant) for run in own])) <= noise.match:
                found["uva"[kind]] = instant
                break
    return found


def _off(match: Match, run: Measured, kind: int, instant: float) -> Array:
    """How far the returned v or a, moved to the ends of steps, is off that of the scheme."""
    at, n = run.at, run.rows.shape[1] - 1
    a0 = np.zeros(len(at.Omega)) if match.start == "zero" else None
    start = np.array([x or 0.0 for x in run.start[:2]]) / at.powers[:2]
    rows = match.candidate(at).histories(start, a0, n) * at.powers
    x = run.rows[..., kind]
    neighbour = np.roll(x, -1 if instant < 0 else 1, axis=1)  # wrong at either end, which is left out
    moved = neighbour if abs(instant) == 1.0 else 0.5 * (x + neighbour)
    with np.errstate(all="ignore"):
        off = (rows[..., kind] - moved) / at.scale[:, None, kind] / run.sizes[..., 0] / at.scale[:, None, 2]
    return off[:, 2 : n - 1]


def instants_text(instants: Mapping[str, float]) -> str:
    """In words, such as 'v stands 1/2 step before the end of its step'."""
    steps = {0.5: "1/2 step", 1.0: "1 step"}
    sides = [(kind, steps[abs(x)], "before" if x < 0 else "after") for kind, x in instants.items()]
    return ", ".join(f"{kind} stands {by} {side} the end of its step" for kind, by, side in sides)
