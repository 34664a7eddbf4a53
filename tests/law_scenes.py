"""What tests of laws on schemes share: scenes that each scheme takes, and kernels as plain Python."""

from dataclasses import replace
from functools import cache
from types import ModuleType
from typing import Any

import committed_steps
import law_paths
import numpy as np
from declared import BY_NAME, TOGETHER
from hysteresis import Oscillator
from plain_kernels import text_of, uncompiled
from substep_derive.declare.scenes.hysteretic import ALL
from sympy import Integer

import substep as ss
from substep.derived.modules import uncommitted_pair

DISCRETE = {"energy_momentum"}  # takes the force of a potential
MARCHED = [name for name in ss.schemes() if name not in DISCRETE and name not in TOGETHER]
# the scene for schemes of u'' = g(t, u), which refuse any that declares a damper
UNDAMPED = replace(
    ALL[0],
    name="undamped_hysteretic",
    dissipation=Integer(0),
    parameters=tuple(p for p in ALL[0].parameters if p.name != "xi"),
)
OMEGA = 2 * np.pi
BACK_IN_TIME = {"crouzeix4", "forest_ruth", "yoshida6", "tarnow_simo"}  # take the force at an instant before t_n


@cache
def kernels(scheme: str, scene: Any) -> ModuleType:
    """Of the pair, a scene by name or declaration."""
    return uncompiled(text_of(uncommitted_pair(scheme, scene)))


def scene(of: Oscillator, scheme: str, load: Any = None, u: float = 0.0, v: float = 0.0) -> ss.Scene:
    """The oscillator as a scene that the scheme takes."""
    given = {"omega": of.omega, "strength": of.strength, "hardening": of.alpha, "u0": u, "v0": v, "load": load}
    if not BY_NAME[scheme].takes_damping:
        assert of.xi == 0
        return ss.scene(UNDAMPED, **given)
    return ss.scene("hysteretic_oscillator", xi=of.xi, **given)


def fitting(scheme: str, *of: float) -> Oscillator:
    """An oscillator (omega, xi, strength, alpha), without damping where the scheme takes none."""
    found = Oscillator(*of)
    return found if BY_NAME[scheme].takes_damping else replace(found, xi=0.0)


def declared(scheme: str, of: Oscillator, load: Any, values: dict[str, float]) -> tuple[Any, ...]:
    """What plain stepping takes: the declaration, its parameters, the spring, the damper, the load."""
    handle, declaration = ss.scheme(scheme, **values), BY_NAME[scheme]
    parameters = {s: float(handle.parameters[s.name]) for s in declaration.values}
    k = of.omega**2
    spring = committed_steps.Spring(k, *law_paths.bilinear(k, of.strength, of.alpha))
    return declaration, parameters, spring, 2 * of.xi * of.omega, lambda t: float(load(np.array(t)))
