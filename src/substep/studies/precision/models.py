"""Models of one motion, from the full one to those with fewer coordinates, and how far they differ by themselves."""

import numpy as np

from ...core.scene_by_name import scene
from ...core.scenes import Scene
from ..turning import is_elastic_pendulum
from .measure import against, shared
from .reference import Reference, reference


def simpler_models(full: Scene, quantity: str) -> tuple[Scene, ...]:
    """Of an elastic pendulum the same one on a rod that cannot stretch, with the fewest coordinates for the quantity.

    That is the angle where the angle is asked for; else x and y, with the rod as a constraint. Nothing for others.
    """
    if not is_elastic_pendulum(full):
        return ()
    kind = "rigid_pendulum" if quantity == "angle" else "rod_pendulum"
    return (scene(kind, **{name: full.parameters[name] for name in ("L", "m", "v0")}),)


def difference(exact: Reference, model: Scene, quantity: str, wished: float) -> float:
    """The largest error of the quantity that the model has by itself, whatever the scheme; inf if both do not have it.

    wished: how accurately, relative to the quantity's largest value. NaN where the model's own motion is not resolved,
    so that its runs have to tell.
    """
    if quantity not in shared(exact.scene, model):
        return np.inf
    try:
        own = reference(model, float(exact.t[-1]), len(exact.t) - 1, wished, quantity)
    except ValueError:
        return np.nan
    return against(exact, model, own.u, own.v, own.a)[quantity].maximum
