"""Dialects of damping: schemes whose balances take the damping force of another velocity than the declared one.

Explicit programs take it from a velocity that is known before the step is solved, so that no damped mass is inverted;
some implicit ones leave it out of the weighted mean that they form of the other forces. Either costs an order.
"""

from collections.abc import Sequence
from dataclasses import replace

from substep.core.schemes import Scheme
from substep.structures.march.scheme_plan import step_of

from .identify import Identification, Match, credible, fitted, identify, levels
from .linear_step import DAMPED_BY, Damping
from .noise import QUIET, Noise
from .probes import Measured


def identify_damped(
    free: Sequence[Measured], own: Sequence[Measured], first: Scheme | None = None, noise: Noise = QUIET
) -> Identification:
    """As `identify`, but before displacements or eigenvalues alone are compared, dialects of damping are.

    They are those of the schemes that do all that was measured without damping. Where none of them does it with
    damping, and nothing else agrees, these schemes are kept as `undamped`.
    """
    whole, *parts = levels(free)
    found = identify(free, own, first, noise, (whole,))
    if found.matches:
        return found
    undamped = _undamped(free, own, first, noise) if free[0].at.xi.any() else ()
    tried = [
        replace(fitted(match.scheme, (), "matrix", free, own, noise, damping), solved=match.solved)
        for match in undamped
        for damping in dialects_of(match.scheme)
    ]
    if matches := tuple(match for match in tried if credible(match, noise)):
        return Identification(matches)
    rest = identify(free, own, first, noise, parts)
    return rest if rest.matches else replace(found, undamped=undamped)


def _undamped(
    free: Sequence[Measured], own: Sequence[Measured], first: Scheme | None, noise: Noise
) -> tuple[Match, ...]:
    return identify([run.undamped for run in free], [run.undamped for run in own], first, noise, ("matrix",)).matches


def dialects_of(scheme: Scheme) -> list[Damping]:
    """The dialects that a scheme can have: those of one balance from which v at both ends of its step can be told."""
    steps = step_of(scheme, 1.0)
    one = scheme.info.damping and "v_0" in steps.rows and sum(system.balance for system in steps.systems) == 1
    return list(DAMPED_BY) if one else []
