"""What gives energy to a scene along a run, and takes it, and what is left for the scheme."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any, Protocol

import numpy as np

from .arrays import Array
from .rows import Rows


class _Run(Rows, Protocol):
    """A response of a scene, as far as its energy is asked about."""

    @property
    def energy(self) -> Any: ...
    @property
    def energy_dissipated(self) -> Array: ...
    @property
    def memory(self) -> Mapping[str, Array]: ...
    @property
    def multipliers(self) -> Any: ...
    @property
    def powers(self) -> Any: ...
    @property
    def power_of_each(self) -> Any: ...


def powers(r: _Run) -> Mapping[str, Array]:
    """See `Response.powers`."""
    found: dict[str, Array] = {}
    for name, x in r.power_of_each.items():
        kind = name.partition(" ")[0]
        found[kind] = found[kind] + x if kind in found else x
    return found


def power_of_each(r: _Run) -> Mapping[str, Array]:
    """See `Response.power_of_each`."""
    _require_scene(r)
    found = {name: x for name, x in _of_scene(r).items() if name != "frame"}
    info = r.scene.info
    if info.multipliers or info.frictions:
        along = np.einsum("ncd,nd->nc", r.scene.directions(r.t, r.u), r.v).T
        held, rubbed = along[: len(info.multipliers)], along[len(info.multipliers) + len(info.contacts) :]
        forces = zip(info.multipliers, r.multipliers.values(), held, strict=True)
        found |= {f"constraints {name}": -multiplier * rate for name, multiplier, rate in forces}
        found |= {f"friction {name}": -_of_steps(r, name) * x for name, x in zip(info.frictions, rubbed, strict=True)}
    return found


def _of_steps(r: _Run, name: str) -> Array:
    """A reaction (n+1,) that steps compute: at the end of each, and at the start that of the first."""
    found = r.memory[name].copy()
    found[0] = found[min(1, len(found) - 1)]
    return found


def numerical(r: _Run) -> Array:
    """See `Response.numerical`."""
    _require_scene(r)
    if acting := r.scene.info.contacts:
        raise ValueError(
            f"expected a scene without contacts for the energy that the scheme dissipates, got {', '.join(acting)}, "
            "which act within a step; r.impacts says what each impact takes, r.powers what else gives or takes energy"
        )
    return unaccounted(r)


def unaccounted(r: _Run) -> Array:
    """The energy (n+1,), J, that no power of a response and no law accounts for, from the start on; also of impacts."""
    own = r.energy - _of_scene(r).get("frame", 0.0) + (r.energy_dissipated if "dissipated" in r.memory else 0.0)
    power = sum(r.powers.values(), np.zeros(len(r.t)))
    if len(r.t) < 3:  # as Simpson's rule needs
        return own[0] - own + np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(r.t))])
    integrate: Any = import_module("scipy.integrate")  # slow to import
    return own[0] - own + np.asarray(integrate.cumulative_simpson(power, x=r.t, initial=0.0))


def _require_scene(r: _Run) -> None:
    """Raises AttributeError for a response of a structure."""
    if not hasattr(r.scene, "powers"):
        raise AttributeError(
            "expected a response of a scene for powers and what the scheme has dissipated, got one of a structure; "
            "r.account has the work of its loads, what is damped, and `numerical`"
        )


def _of_scene(r: _Run) -> dict[str, Array]:
    return r.scene.powers(r.t, r.u, r.v, *r.memory_of_rows(slice(None)))
