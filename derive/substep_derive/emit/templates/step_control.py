"""The fixed text of the controller of steps: part of each kernel that chooses its steps, and a module of its own."""

STEP_CONTROL_HEADER = '''"""How steps are chosen from their estimated errors.

The functions of the compiled kernels, as plain Python, for marches whose steps are not compiled. Errors come as `size`,
the mean of their squares, each over its scale.
"""

import numpy as np


def _inner(function):
    return function
'''

STEP_CONTROL = '''
# squares of weighted errors: the one that is aimed at, and the largest with which a step keeps its length; it keeps it
# too where it could be longer by less than a third, so that what depends on it need not be computed again
AIM, KEPT = 0.16, 0.5


@_inner
def _load(load, samples, middle, t):
    """The load at t: load holds its kind and up to three parameters.

    middle: a time between the same two break points, which decides where the load jumps on which side of it t is.
    """
    if load[0] == 1.0:
        return load[1] * np.sin(load[2] * t + load[3])
    if load[0] == 2.0:
        return load[1] if middle >= load[2] else 0.0
    if load[0] == 3.0:
        return load[1] * np.sin(np.pi * t / load[2]) if 0.0 <= middle and middle <= load[2] else 0.0
    if load[0] == 4.0:
        k = np.int64(np.floor(middle / load[1]))
        if k < 0 or k >= samples.size - 1:
            return 0.0
        share = t / load[1] - k
        return samples[k] * (1.0 - share) + samples[k + 1] * share
    return 0.0


@_inner
def _factor(size, before, ratio, power):
    """The factor for the next step's length: Soderlind's digital filter H211b with b = 4, limited to 0.2 and 2.7.

    size, before: squares of this step's error and of the one before, weighted; ratio: of the lengths of these steps;
    power: 1/(2 p + 2) where the error is O(h^(p + 1)). Soderlind, ACM Trans. Math. Softw. 29 (2003) 1-26.
    """
    wanted = -0.25 * power * np.log(max(size, 1e-30) * max(before, 1e-30) / (AIM * AIM))
    if ratio != 1.0:
        wanted -= 0.25 * np.log(ratio)
    return np.exp(min(max(wanted, -1.6), 1.0))


@_inner
def _on_ladder(wanted, held, base, rung, left, dt_min, change):
    """The longest base * rung**k that is at most the wanted length; the one held where a longer one saves too little.

    left: the time to go, in which a longer step has to save more than `change` steps. And whether it would save less.
    """
    found = base * rung ** np.floor(np.log(wanted / base) / np.log(rung) + 1e-9)
    if found < dt_min and dt_min <= wanted:
        return dt_min, False
    if found > held and left * (1.0 / held - 1.0 / found) <= change:
        return held, True
    return found, False


@_inner
def _reaching(wanted, left):
    """Length of a step with a target `left` ahead, and whether it ends there; no short step is left before it."""
    if wanted >= left * (1.0 - 1e-9):
        return left, True
    return (0.5 * left if wanted > 0.5 * left else wanted), False


@_inner
def _shorter(h, size, power):
    """Length in place of a step h whose error was too large, or not finite."""
    return h * max(0.1, min(0.9, (AIM / size) ** power)) if np.isfinite(size) else 0.1 * h


@_inner
def _kept_from(rung, power):
    """The size from which on a step keeps its length."""
    return AIM * max(rung, 1.35) ** (-1.0 / power)


@_inner
def _next(h, proposed, size, before, last, low, rung, power, measured):
    """Length wanted after an accepted step h, which may be shorter than the proposed one to end on a target.

    before: size of the step before, negative where it tells nothing; last: its length; low: as `_kept_from` gives it.
    measured: False where the estimate could not see all of the error, so that the next step must not be longer.
    """
    if size >= low and size <= KEPT and before >= 0.0:
        wanted = h
    elif before < 0.0 or rung > 1.0:
        wanted = h * min(max((AIM / max(size, 1e-30)) ** power, 0.2), 2.7)
    else:
        wanted = h * _factor(size, before, h / last, power)
    if not measured:
        wanted = min(wanted, h)
    if h < proposed and size <= KEPT:
        wanted = max(wanted, proposed)
    return wanted


@_inner
def _trial(d0, d1, length, fast):
    """Length of a first trial; d0, d1: root mean squares of the motion, and of its slopes, over the scales of errors.

    Where the motion is too small for them, from its length and speed; at complete rest 1e-6 s. It does not depend on
    when the run ends. Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.4.
    """
    return 0.01 * d0 / d1 if d0 > 1e-5 and d1 > 1e-5 else 1e-3 * length / fast if fast > 0.0 else 1e-6


@_inner
def _first_length(d1, d2, trial, power):
    """Length of a step of which nothing is known before it; d2: as d1, of the change of the slopes over the trial."""
    steepest = max(d1, d2)
    return min(100.0 * trial, (0.01 / steepest) ** (2.0 * power)) if steepest > 1e-15 else trial
'''
