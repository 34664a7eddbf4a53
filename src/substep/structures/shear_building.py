"""Shear buildings: a mass and a law for each story."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..core.errors import damping_ratio, inside, real_array
from ..core.laws import Law
from .model.memory import RememberingForce
from .modes.modal_damping import modal_damping
from .structure import Structure, damped_by, structure


def shear_building(
    masses: Any,
    laws: Sequence[Law] | Law,
    *,
    heights: Any = None,
    damping: Any = None,
    modes_damped: int | None = None,
    **options: Any,
) -> Structure:
    """A building of n stories, each a law over its drift: masses (n,) of the floors, the lowest one first.

    Displacements are those of the floors relative to the ground; the drift of a story is that of its floor less that of
    the floor below. laws: one for each story, of its shear over its drift; or one law with parameters (n,).
    heights: of the stories (n,) or of all, for `Response.springs.ratios`. damping: a ratio of the `modes_damped` lowest
    modes, by default of all, with the stiffness before anything is strained; or what `substep.structure` takes as C.
    options: of `substep.structure`, such as load, u0 and names.

    Raises ValueError for masses and heights that are not positive, for another number of laws, for C in place of
    damping, and for what `substep.structure` raises it.

    >>> story = ss.law("bilinear", k=2e7, q_y=[4e5, 3e5], alpha=0.02)
    >>> building = ss.shear_building([2e4, 2e4], story, heights=3.0, damping=0.05)
    >>> shaken = building.ground_motion(ss.Record(0.1, [0.0, 8.0, -8.0, 0.0]), 1.0)
    >>> r = ss.march(shaken, "average_acceleration", dt=0.01, t_end=2.0)
    >>> print(f"{abs(r.springs.elongations).max():.4f} m, {r.energy_dissipated[-1]:.0f} J")
    0.0357 m, 6827 J
    """
    m = np.atleast_1d(real_array("masses", masses))
    n = len(m)
    if m.ndim != 1 or not (m > 0.0).all():
        raise ValueError(f"expected masses (n,) of the floors, each positive, got {masses!r}; give a list of numbers")
    if not isinstance(laws, Law) and not (isinstance(laws, list | tuple) and all(isinstance(x, Law) for x in laws)):
        raise ValueError(
            f"expected laws as one, or a list of one for each story, got {laws!r}; give "
            "ss.law('bilinear', k=..., q_y=...)"
        )
    drifts = np.eye(n) - np.eye(n, k=-1)
    stories = [(drifts, laws)] if isinstance(laws, Law) else list(zip(drifts, laws, strict=False))
    if not isinstance(laws, Law) and len(laws) != n:
        raise ValueError(f"expected {n} laws, one for each story, got {len(laws)}; give as many as masses")
    if "C" in options:
        raise ValueError("expected damping of a shear building as damping=, got C; give the same as damping=")
    made = structure(np.diag(m), springs=stories, **options)
    force = made.internal
    assert isinstance(force, RememberingForce)
    assert force.springs is not None
    if heights is not None:
        each = inside("heights", heights, 0.0, None, True, True)
        if each.shape not in ((), (n,)):
            raise ValueError(f"expected heights of all stories as one number or {n}, got shape {each.shape}")
        force.springs = replace(force.springs, lengths=np.broadcast_to(each, (n,)))
    if isinstance(damping, int | float) and not isinstance(damping, bool):
        damping = modal_damping(damping_ratio("damping", damping), modes=n if modes_damped is None else modes_damped)
        damping = damping.matrix(made).toarray()
    elif modes_damped is not None:
        raise ValueError("expected modes_damped beside a ratio as damping, got another; leave it out")
    return damped_by(made, damping)
