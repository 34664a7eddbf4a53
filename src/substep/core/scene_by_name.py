"""Scenes by name: what `substep.scene` makes of a name, or a declaration, and parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .equilibrium import equilibrium
from .errors import called_as, real_number
from .loads import Load
from .scene_catalogue import checked_parameters, scene_info, with_omega
from .scenes import Scene, make_scene
from .units import require_ratio

if TYPE_CHECKING:
    from ..derived.modules import SceneDeclaration


@called_as('scene("linear_oscillator", omega=6.28, xi=0.02)')
def scene(
    name: str | Scene | SceneDeclaration,
    *,
    a0: ArrayLike | str | None = None,
    load: Load | None = None,
    **parameters: Any,
) -> Scene:
    """The scene of that name, or of a declaration of your own (`substep_derive.Scene`); a handle stands for itself.

    Parameters not given take the default of the declaration. linear_oscillator takes exactly one of omega, rad/s, f,
    Hz, and T, s. xi, of any scene, is a damping ratio: one of 2 or more, likely percent, needs overdamped=True. a0: the
    initial acceleration, one number for each coordinate; "consistent" takes it from the equation of motion; by default
    as the scene declares it. load: a function of time in s, for scenes that take one. elastic_pendulum also takes
    strain = "green_lagrange" or "engineering", hysteretic_oscillator law = a name of `laws` or a declaration of your
    own (`substep_derive.Law`). u0="static", where there is a u0: the displacement at which it stays at
    rest under the load at t = 0. Raises ValueError for unknown names, missing parameters and bad values,
    such as an angle beyond a turn.

    >>> pendulum = ss.scene("elastic_pendulum", EA=1e4, a0="consistent")
    >>> pendulum.coordinates, round(pendulum.E0, 3)  # the energy at the start, J
    ((('x', 'm'), ('y', 'm')), 297.992)
    >>> ss.scene("linear_oscillator", T=0.5, xi=0.05).parameters["omega"]  # rad/s
    12.566370614359172
    """
    if isinstance(name, Scene):
        if parameters or a0 is not None or load is not None:
            raise ValueError(
                f"expected a name with parameters, a0 or load, got {name}; write scene({name.name!r}, ...)"
            )
        return name
    info = scene_info(name, parameters)
    static = isinstance(parameters.get("u0"), str) and "u0" in info.parameters
    if static and parameters["u0"] != "static":
        raise ValueError(f"expected u0 as a displacement or 'static', got {parameters['u0']!r}; give a number")
    if static:
        parameters["u0"] = 0.0
    meant = bool(parameters.pop("overdamped", False)) if "xi" in info.parameters else False
    values = checked_parameters(info, with_omega(info, parameters), real_number)
    if not meant and "xi" in values:
        require_ratio(f"xi of {info.name}", values["xi"])
    if static:
        values["u0"] = _at_rest(make_scene(info, values, a0, load))
    return make_scene(info, values, a0, load)


def _at_rest(scene: Scene) -> float:
    """The displacement at which it stays at rest under its load at t = 0. Raises ValueError for more coordinates."""
    if scene.u0.shape != (1,):
        raise ValueError(
            f"expected u0='static' for a scene of one coordinate, got {len(scene.u0)} of {scene.name}; give the "
            "displacements, or march from start={'u': ..., 'v': ...}"
        )
    given = scene.info.unstrained
    unstrained = None if given is None else np.array([given(*scene.parameters.values())])

    def acceleration(u: float) -> float:
        at = np.array([[u]])
        memory = None if unstrained is None else scene.committed(at, unstrained)
        return float(scene.acceleration(np.zeros(1), at, np.zeros((1, 1)), memory)[0, 0])

    return equilibrium(scene.name, acceleration, scene.length)
