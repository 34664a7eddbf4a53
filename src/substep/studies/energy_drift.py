"""The energy that a scheme gains or loses on a scene, predicted from its modified equation, before any march."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..core.arrays import Array
from ..core.errors import called_as, real_number
from ..core.exports import Exported
from ..core.scene_by_name import scene
from ..core.scenes import Scene
from ..run.clock import end_asked
from ..run.schemes import numbers_only
from .modified_energy import ModifiedEnergy

TIMES = 200  # intervals at whose ends a prediction is given
ACCURATE = 1e-11  # relative tolerance of the exact motion
NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)  # in each step of it, and in each interval


@dataclass(frozen=True)
class EnergyDrift(Exported):
    """Prediction for any step h that resolves the motion, at the times t (n + 1,), s.

    E0: energy at the start, J. lost, swing: power of h -> (n + 1,), J/s^power: how much energy the scheme has lost
    since t = 0, negative where it has gained, and how much less it reports for the time being than it keeps. Where the
    mass moves or forces depend on rates both are in `lost`, at the leading powers only. loss: the lowest power at which
    energy is lost or gained for good, None where none was found.
    """

    axes: ClassVar = {"t": ("t",), "lost": ("power_lost", "t"), "swing": ("power_swing", "t")}

    t: Array
    E0: float
    lost: Mapping[int, Array]
    swing: Mapping[int, Array]
    loss: int | None

    def rate(self, h: float) -> float:
        """The mean loss over the whole time, W."""
        return float(_sum(self.lost, h, self.t)[-1] / self.t[-1])

    def energy(self, h: float) -> Array:
        """T + V (n + 1,) of the displacements and velocities that the scheme reports, J."""
        return self.E0 - _sum(self.lost, h, self.t) - _sum(self.swing, h, self.t)


def _sum(terms: Mapping[int, Array], h: float, t: Array) -> Array:
    h = real_number("h", h, positive=True)
    return sum((h**power * x for power, x in terms.items()), np.zeros(len(t)))


@called_as('energy_drift("simple_pendulum", "bathe", t_end=10.0)')
def energy_drift(model: Any, scheme: Any, *, t_end: float) -> EnergyDrift:
    """What a scheme's own dissipation, or its gain, is on a scene up to t_end, s, by powers of the step.

    The computed motion is the exact motion of another equation (backward error analysis: Hairer, Lubich & Wanner,
    Geometric Numerical Integration, chapter IX), from which an energy is derived that changes at a rate R h^q + ...
    only. R is integrated along the scene's exact motion. This holds where steps resolve the motion and as long as the
    loss is small beside the energy; what the start adds in the first steps, once, is not in it.

    Raises ValueError for a scene with a load or lanes; DeclarationError for one that does not keep its energy, for
    constraints and contacts, and for a scheme without a modified energy.

    >>> found = ss.energy_drift(ss.scene("duffing", k=1.0, eps=0.1, u0=1.0), "bathe", t_end=100.0)
    >>> found.loss, found.rate(0.1) > 0  # lost with the third power of the step
    (3, True)
    """
    given, s = scene(model), numbers_only(scheme, "ask once for each")
    t_end = end_asked(t_end)
    found = ModifiedEnergy.of(given, s)
    t = np.linspace(0.0, t_end, TIMES + 1)
    at_t, ends, inside = _along(given, t)
    kept, rates = found.kept(at_t), found.rates(inside)
    widths, places = np.diff(ends) / 2, np.searchsorted(ends, t)
    lost = {}
    for power, rate in rates.items():
        gained = np.cumsum(widths * (rate.reshape(-1, len(WEIGHTS)) @ WEIGHTS))
        lost[power] = -np.concatenate([[0.0], gained])[places]
    return EnergyDrift(t, given.E0, lost, {power: x - x[0] for power, x in kept.items()}, found.motion.loss)


def _along(given: Scene, t: Array) -> tuple[Array, Array, Array]:
    """Exact states (2 d, n + 1) at times t (n + 1,), ends (k + 1,) of intervals, and states (2 d, 5 k) in them."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415 (slow to import)

    d, at = len(given.u0), np.zeros(())

    def slope(_: float, y: Array) -> Array:
        return np.concatenate([y[d:], given.acceleration(at, y[:d], y[d:])])

    start = np.concatenate([given.u0, given.v0])
    found = solve_ivp(
        slope, (0.0, t[-1]), start, "DOP853", rtol=ACCURATE, atol=ACCURATE * given.length, dense_output=True
    )
    if not found.success:
        raise ArithmeticError(f"{given.name}: {found.message}")
    ends = np.union1d(found.t, t)
    inside = (ends[:-1] + ends[1:])[:, None] / 2 + np.diff(ends)[:, None] / 2 * NODES
    return found.sol(t), ends, found.sol(inside.ravel())
