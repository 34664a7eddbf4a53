"""What long undamped free motion does: whether its energy is kept, and whether it grows by a double eigenvalue."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from substep.core.arrays import Array

from .measured_stability import LONGEST, SCAN, eigenvalues, tolerance_of
from .noise import QUIET, Noise
from .orders import SETTLED
from .probes import Measured, measure, oscillators, own_runs
from .programs.adapter import Load
from .stepper import RunFailed, Stepper

Verdict = Literal["conserved", "conserved on average", "lost", "gained"]
Roots = Callable[[float], Array]  # the eigenvalues at an Omega, undamped

ENERGY_AT = (0.1, 0.5, 1.0)  # Omega
BEFORE, AVERAGED = 128, 384  # steps that die out first, and of each of the two averages
CYCLES = 11.6  # in the averaging window, beyond which an oscillation weighs less than 1e-15 in a Kaiser window
OPERATIONS = 10.0  # roundings of a step
FEWEST = 8  # steps of an average

GROWTH_STEPS = 256
GROWN = 1.5  # times, over the last three quarters: more than phases at which bounded motion is seen can differ
SLOW = 8.0 * np.pi / GROWTH_STEPS  # Omega of a motion that has one period in the first quarter
ON_CIRCLE = 1.0 / GROWTH_STEPS  # |1 - |root|| below which a root neither decays nor grows in so many steps


@dataclass(frozen=True)
class Energy:
    """Of undamped free motion at an Omega: v^2/2 + omega^2 u^2/2.

    per_period: its relative change in a period 2 pi/omega, the trend over many; resolution: the change that rounding
    alone may cause. oscillation: half of the range within the run, relative to the mean, trend excluded.
    """

    Omega: float
    per_period: float
    oscillation: float
    resolution: float

    @property
    def verdict(self) -> Verdict:
        """What happens to it; "on average" where it oscillates and neither grows nor decays."""
        if abs(self.per_period) > self.resolution:
            return "lost" if self.per_period < 0 else "gained"
        return "conserved on average" if self.oscillation > self.resolution else "conserved"

    @property
    def text(self) -> str:
        """In words, such as "lost at 1.2 % a period"."""
        if self.verdict in ("lost", "gained"):
            return f"{self.verdict} at {percent(abs(self.per_period))} a period"
        bounded = f" (bounded oscillation of {percent(self.oscillation)})" if self.verdict != "conserved" else ""
        return f"{self.verdict}{bounded}, to {percent(self.resolution)} a period"


@dataclass(frozen=True)
class Growth:
    """That free motion at an Omega grows like a power of the number of steps: to `factor` of what it was at `steps`/4.

    Two eigenvalues are the same there, or so near that so many steps do not tell them apart.
    """

    Omega: float
    power: int
    factor: float
    steps: int = GROWTH_STEPS

    @property
    def text(self) -> str:
        """In words."""
        like = "n" if self.power == 1 else f"n^{self.power}"
        return f"grows like {like} at Omega = {self.Omega:.9g}, {self.factor:.3g} times from step {self.steps // 4} on"


def percent(x: float) -> str:
    """A share in per cent with two digits."""
    return f"{100 * x:.2g} %"


def energies(stepper: Stepper, noise: float) -> tuple[Energy, ...]:
    """Where the velocity at the ends of steps is returned; none for a run that fails.

    noise: relative, of a number that the stepper returns.
    """
    at = oscillators(stepper, ENERGY_AT, (0.0,))
    try:
        run = measure(stepper, at, (1.0, 0.0, None), Load(), BEFORE + 2 * AVERAGED)
    except RunFailed:
        return ()
    found = []
    for Omega, rows in zip(at.Omega.tolist(), run.rows, strict=True):
        energy = _energy(Omega, rows, noise)
        found += [] if energy is None else [energy]
    return tuple(found)


def _energy(Omega: float, rows: Array, noise: float) -> Energy | None:
    """From a history of u and h*v; None without v, or where it is lost, or grows beyond all bounds, within a few steps.

    The two averages are over equal windows, exact for an energy without trend. The trend is taken out until none is
    left. What has decayed to the noise, which may be absolute, is not averaged.
    """
    e = 0.5 * (rows[:, 1] ** 2 + Omega**2 * rows[:, 0] ** 2)
    inside = np.isfinite(e) & (e > noise * e[0])
    steps = len(e) if inside.all() else int(np.argmin(inside))
    before = min(BEFORE, steps // 4)
    half = min(AVERAGED, (steps - before) // 2)
    if half < FEWEST:
        return None
    e, n = e[before : before + 2 * half], np.arange(2 * half)
    turn = np.pi * np.count_nonzero(np.diff(np.sign(rows[before : before + 2 * half, 0]))) / (2 * half - 1)
    beta = np.pi * np.sqrt(max(0.0, min(CYCLES, min(turn, np.pi - turn) * half / np.pi - 1.0) ** 2 - 1.0))
    window = np.kaiser(half, beta)
    rate = float(np.log(e[-1] / e[0])) / (2 * half - 1)  # of the logarithm, a step
    for _ in range(8):
        level = e * np.exp(-rate * n)
        first, second = (float(window @ part) for part in (level[:half], level[half:]))
        rate += float(np.log(second / first)) / half
    level = e * np.exp(-rate * n)
    oscillation = 0.5 * float(np.ptp(level)) / float(window @ level[half:]) * float(window.sum())
    left = 4.0 * (1.0 + beta) * np.exp(-beta) * oscillation / half  # of the oscillation in the rate, by the side lobes
    period = 2.0 * np.pi / Omega
    return Energy(Omega, float(np.expm1(rate * period)), oscillation, (OPERATIONS * noise + left) * period)


def growths(stepper: Stepper, roots: Roots, critical: float | None, largest: float) -> tuple[Growth, ...]:
    """Where undamped free motion grows like a power of n, although no eigenvalue is outside the unit circle.

    Looked for where two eigenvalues nearly meet on the circle, the first such place, and at the end of what is stable:
    the critical Omega, or the largest one. From unit starts of u and h*v, and of h^2*a where it can be set,
    which shows spurious eigenvalues.
    """
    if critical is not None and not critical > 0.0:  # unstable from the start, or not known
        return ()
    end = largest if critical is None else critical
    starts = [(1.0, 0.0, None), (0.0, 1.0, None)] + ([(0.0, 0.0, 1.0)] if "a" in stepper.can.sets else [])
    found: list[Growth] = []
    for Omega in [*meetings(roots, end), end]:
        if found and Omega != end:
            continue
        at = oscillators(stepper, (Omega,), (0.0,))
        try:
            runs = [measure(stepper, at, start, Load(), GROWTH_STEPS) for start in starts]
        except RunFailed:
            continue
        grown = [one for run in runs if (one := _growth(Omega, run)) is not None]
        found += sorted(grown, key=lambda one: one.power)[-1:]
    return tuple(found)


def _growth(Omega: float, run: Measured) -> Growth | None:
    """From the largest root of the energy in windows that end at a quarter, a half, and all of the steps.

    With M = a + b n^k there, k follows from the ratio of the two differences. What u has of the energy of the start is
    no growth, also where no v is returned.
    """
    size = run.energy_roots[0]
    n = len(size) - 1
    if not np.isfinite(size).all():
        return None
    quarter, half, whole = (float(size[m // 2 : m + 1].max()) for m in (n // 4, n // 2, n))
    if not whole > GROWN * quarter or not whole > half > quarter:
        return None
    power = float(np.log2((whole - half) / (half - quarter)))
    if not 1.0 - SETTLED <= power < LONGEST - SETTLED or abs(power - round(power)) > SETTLED:
        return None  # steps that reach back LONGEST grow like n^(LONGEST - 1) at most: what grows faster is unstable
    return Growth(Omega, round(power), whole / quarter)


def meetings(roots: Roots, end: float) -> list[float]:
    """Omegas below `end` at which two eigenvalues meet on the unit circle, to what GROWTH_STEPS tell apart."""
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 (slow to import)

    def gap(Omega: float) -> float:
        values = roots(Omega)
        values = values[np.abs(np.abs(values) - 1.0) < ON_CIRCLE]
        pairs = np.abs(values[:, None] - values[None, :])[np.triu_indices(len(values), 1)]
        return float(pairs.min(initial=2.0))

    at = SCAN[(SCAN > SLOW) & (0.999 * end > SCAN)]
    gaps = np.array([gap(Omega) for Omega in at.tolist()])
    found = []
    for i in range(1, len(at) - 1):
        if gaps[i] < gaps[i - 1] and gaps[i] <= gaps[i + 1] and gaps[i] < 1.0:
            best = minimize_scalar(gap, bounds=(at[i - 1], at[i + 1]), method="bounded", options={"xatol": 1e-9})
            found += [float(best.x)] if best.fun < ON_CIRCLE else []
    return found


def scheme_roots(amplification: Callable[..., Array]) -> Roots:
    """The eigenvalues of an identified scheme."""
    return lambda Omega: np.linalg.eigvals(amplification(Omega))


def measured_roots(stepper: Stepper, noise: Noise = QUIET) -> Roots:
    """The eigenvalues that histories show; none where the program raises."""

    def roots(Omega: float) -> Array:
        try:
            return eigenvalues(own_runs(stepper, [Omega], [0.0]), 0, tolerance_of(stepper, noise)).roots
        except RunFailed:
            return np.zeros(0)

    return roots
