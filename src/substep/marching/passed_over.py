"""What there is to say of a step that is longer than what it is to follow, as one is whose number is in ms."""

from ..core.loads import HalfSine, Harmonic, Load, Record
from ..core.response import Response
from ..core.units import TURN

LONG = 1.0  # s, a step from which on ms are likelier


def passed_over(r: Response, dt: float) -> str:
    """That a step passes over a load, or under one over half a period of the oscillator, and what it is in ms.

    It is said of a completed run in which a record or a pulse is over before the first step is, or a harmonic load, or
    a loaded oscillator, has fewer than two steps a period, so that it looks like one of another frequency. A free
    oscillator in long steps is what stability and overshoot are studied on. Empty where there is nothing to say.
    """
    loads = [load for load in r.loads if load is not None]
    if not loads or r.status != "completed":
        return ""
    seen = [_of_load(load) for load in loads]
    if (period := getattr(r.scene, "period", None)) is not None:
        seen.append((0.5 * period, "half the period of the oscillator"))
    for longest, what in seen:
        if dt > longest:
            in_ms = f": {dt:g} ms are dt = {dt / 1000.0:g}" if dt >= LONG else ""
            return (
                f"dt = {dt:g} s is longer than {what}, {longest:.4g} s, so that steps pass over it; take a shorter "
                f"one{in_ms}"
            )
    return ""


def _of_load(load: Load) -> tuple[float, str]:
    """The longest step, s, that sees anything of a load, and what it is; any step of one that is not known."""
    if isinstance(load, Record):
        return load.dt * (len(load.samples) - 1), "the whole record"
    if isinstance(load, HalfSine):
        return load.duration, "the whole pulse"
    if isinstance(load, Harmonic) and load.omega != 0.0:
        return 0.5 * TURN / abs(load.omega), "half the period of the load"
    return float("inf"), ""
