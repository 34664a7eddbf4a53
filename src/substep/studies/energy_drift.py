"""The energy that a scheme gains or loses on a scene, predicted from its modified equation, before any march."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..core.arrays import Array
from ..core.errors import called_as, real_number
from ..core.exports import Exported
from ..core.scenes import Scene, scene
from ..derived.simple_fraction import printed_fraction
from ..run.clock import end_asked
from ..run.schemes import numbers_only

TIMES = 200  # intervals at whose ends a prediction is given
ACCURATE = 1e-11  # relative tolerance of the exact motion


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
    from ..derived import facade  # noqa: PLC0415 (SymPy, and all facts)

    given, s = scene(model), numbers_only(scheme, "ask once for each")
    t_end = end_asked(t_end)
    if given.load is not None or given.u0.ndim > 1:
        what = "a load" if given.load is not None else "lanes"
        raise ValueError(f"expected {given.name} without {what}, for the energy that a scheme loses; leave it out")
    exact = tuple((name, printed_fraction(float(value))) for name, value in s.given.items())
    found = facade.modified_energy(s.info.source, given.info.source, exact)
    t = np.linspace(0.0, t_end, TIMES + 1)
    states, integrals = _along(given, [*found.rates.values()], t)
    swing = {}
    for power, function in found.kept.items():
        kept = np.array([function(*given.parameters.values(), *state) for state in states])
        swing[power] = kept - kept[0]
    return EnergyDrift(t, given.E0, dict(zip(found.rates, -integrals, strict=True)), swing, found.loss)


def _along(given: Scene, rates: list[Any], t: Array) -> tuple[Array, Array]:
    """Exact coordinates and rates (n + 1, 2 d) at times t (n + 1,), and integrals (k, n + 1) of functions of them."""
    from scipy.integrate import solve_ivp  # noqa: PLC0415 (slow to import)

    d, values, at = len(given.u0), [*given.parameters.values()], np.zeros(())

    def slope(_: float, y: Array) -> Array:
        a = given.acceleration(at, y[:d], y[d : 2 * d])
        return np.array([*y[d : 2 * d], *a, *(rate(*values, *y[: 2 * d]) for rate in rates)])

    start = np.concatenate([given.u0, given.v0, np.zeros(len(rates))])
    found = solve_ivp(slope, (0.0, t[-1]), start, "DOP853", t, rtol=ACCURATE, atol=ACCURATE * given.length)
    if not found.success:
        raise ArithmeticError(f"{given.name}: {found.message}")
    return found.y[: 2 * d].T, found.y[2 * d :]
