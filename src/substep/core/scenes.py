"""Scenes, the problems that are marched. Each is declared by its energies; its parameters are checked here, once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from types import MappingProxyType, ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..derived import modules
from . import constraints
from .arrays import Array, Values, by_value
from .entries import SceneInfo
from .errors import real_array
from .kernel_modules import committed
from .loads import Load, LoadLanes, values_at
from .scene_catalogue import scene_info
from .state import State
from .units import TURN


@dataclass(frozen=True, eq=False, repr=False)
class Scene:
    """A benchmark problem with its parameters; make one with `substep.scene`.

    u0, v0, a0 (d,): displacement, velocity and acceleration at t = 0, in the units of the coordinates and s. In a
    sweep one handle stands for P lanes: some parameters are (P,), u0, v0, a0 (P, d), and u, v in what follows
    (P, ..., d). Two are equal if they are the same scene with the same parameters, start and load, arrays by shape and
    value; a scene of the user's own is the same if everything declared about it is.
    """

    info: SceneInfo
    parameters: Mapping[str, Any]  # numbers
    u0: Array
    v0: Array
    a0: Array
    load: Load | None
    a0_asked: ArrayLike | str | None = None  # the argument a0 of `substep.scene`

    @property
    def name(self) -> str:
        """The scene's name."""
        return self.info.name

    @property
    def coordinates(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of each coordinate."""
        return self.info.coordinates

    @property
    def reference(self) -> str:
        """Where the scene is from."""
        return self.info.reference

    @property
    def module(self) -> ModuleType:
        """Generated functions of the scene: energy, acceleration, invariants."""
        return _functions(self.info.name) if isinstance(self.info.module, str) else self.info.module

    @property
    def length(self) -> float:
        """What Newton's tolerance is relative to."""
        return self.info.length(*self.parameters.values())

    @property
    def period(self) -> float | None:
        """Undamped natural period of a linear oscillator, s; None for another scene, and for lanes of several."""
        omega = self.info.oscillator(*self.parameters.values())[0] if self.info.oscillator else None
        return TURN / omega if isinstance(omega, float) and omega else None

    @property
    def E0(self) -> float:
        """Energy at t = 0 or, where that is 0, the largest potential scale of the scene; J."""
        memory = self.memory0 if self.info.memory else None
        at_start = float(self.energy(np.zeros(()), self.u0, self.v0, memory))
        return at_start or (self.info.energy_scale(*self.parameters.values()) if self.info.energy_scale else 0.0)

    def lanes(self, where: slice) -> Scene:
        """The scene of some of its lanes."""
        values = {name: x[where] if np.ndim(x) else x for name, x in self.parameters.items()}
        load = self.load.lanes(where) if isinstance(self.load, LoadLanes) else self.load
        u0, v0, a0 = (x[where] if x.ndim > 1 else x for x in (self.u0, self.v0, self.a0))
        return replace(self, parameters=values, u0=u0, v0=v0, a0=a0, load=load)

    @cached_property
    def memory0(self) -> Array:
        """What its laws remember (k,), of lanes (P, k), at t = 0; then its reactions.

        Laws are committed at u0, to which they were strained. Pressures are those under which no gap closes; those that
        steps do not remember, and frictions, are 0.
        """
        laws, c, d = self.info.laws, len(self.info.multipliers), len(self.info.contacts) * (not self.info.impulsive)
        before = self.info.unstrained(*self.parameters.values()) if self.info.unstrained else ()
        found = _joined([*before, *(0.0 for _ in self.info.reactions)], self.u0.shape[:-1])
        found = self.committed(self.u0, found)
        t = np.zeros(self.u0.shape[:-1])
        if d:
            found[..., laws + c :] = constraints.pressures(self, t, self.u0, self.v0, found)
        if c:
            found[..., laws : laws + c] = self.multipliers(t, self.u0, self.v0, found)
        found.flags.writeable = False
        return found

    def committed(self, u: Array, memory: Array, elapsed: ArrayLike = 0.0) -> Array:
        """What its laws remember (..., k) once it is committed at u (..., d), elapsed s after memory (..., k)."""
        if not self.info.unstrained:
            return memory.copy()
        laws = self._evaluate("commit", np.zeros(()), u, u, memory=memory, elapsed=elapsed)
        return np.concatenate([laws, memory[..., laws.shape[-1] :]], axis=-1)

    def energy(self, t: Array, u: Array, v: Array, memory: Array | None = None) -> Array:
        """Kinetic energy and potential (...,) at times t (...,) for u, v (..., d); inf beyond about 1e154.

        memory (..., k): what laws remember, committed at u.
        """
        return self._evaluate("energy", t, u, v, memory=memory)

    def acceleration(
        self, t: Array, u: Array, v: Array, memory: Array | None = None, *, force: float | None = None
    ) -> Array:
        """Acceleration (..., d) from the equation of motion; force: in place of the load's at t."""
        at = np.asarray(t)[None] if isinstance(self.load, LoadLanes) and np.ndim(u) > np.ndim(t) + 1 else t
        given = self.forces(at) if force is None else force
        if not hasattr(self.module, "acceleration"):
            return self._constrained(t, u, v, memory, given)[..., : u.shape[-1]]
        return self._evaluate("acceleration", t, u, v, given, memory=memory)

    def multipliers(self, t: Array, u: Array, v: Array, memory: Array | None = None) -> Array:
        """The multipliers (..., c) of its constraints, from the equations of motion at u, v (..., d) and t (...,)."""
        return self._constrained(t, u, v, memory, self.forces(t))[..., u.shape[-1] :]

    def gaps(self, t: Array, u: Array) -> Array:
        """The gaps (..., d) of its contacts at u and t."""
        c, d = len(self.info.multipliers), len(self.info.contacts)
        return -self.drift(t, u, u)[0][..., c : c + d]

    def drift(self, t: Array, u: Array, v: Array) -> tuple[Array, Array, Array]:
        """What constraints keep at 0, minus gaps, and what slides (..., c), and their first and second derivatives.

        Of the second the part without accelerations.
        """
        found = self._evaluate("drift", t, u, v, memory=self._nothing(u))
        c = found.shape[-1] // 3
        return found[..., :c], found[..., c : 2 * c], found[..., 2 * c :]

    def directions(self, t: Array, u: Array) -> Array:
        """The derivatives (..., c, n) by the coordinates of what `drift` gives."""
        found = self._evaluate("directions", t, u, u, memory=self._nothing(u))
        return found.reshape(*found.shape[:-1], -1, u.shape[-1])

    def allowed(self, u: ArrayLike, v: ArrayLike, t: float = 0.0) -> State:
        """The state at t nearest to u, v (n,) that the constraints allow, nearest by kinetic energy: to start from.

        Raises ValueError where there is none nearby, for other shapes and for numbers that are not finite.
        """
        vectors = [np.atleast_1d(real_array(name, x)) for name, x in (("u", u), ("v", v))]
        if any(x.shape != (len(self.coordinates),) for x in vectors):
            raise ValueError(
                f"expected u and v with {len(self.coordinates)} numbers for {self.name}, got shapes "
                f"{', '.join(str(x.shape) for x in vectors)}; give one for each coordinate"
            )
        return State(t, *constraints.nearest(self, t, *vectors))

    def require_allowed(self, u: Array, v: Array, t: float = 0.0) -> None:
        """Raises ValueError for dependent constraints at u, v (n,), and where constraints or contacts forbid these."""
        constraints.require_allowed(self, t, u, v)

    def constrained(self, t: Array, u: Array, v: Array) -> Array:
        """The matrix (..., n + c, n + c) of mass and directions of constraints."""
        found = self._evaluate("constrained", t, u, v, memory=self._nothing(u))
        return constraints.parts(found, u.shape[-1], len(self.info.multipliers))[0]

    def _nothing(self, u: Array) -> Array:
        """A memory for functions that do not depend on it."""
        return np.zeros((*u.shape[:-1], len(self.info.memory)))

    def _constrained(self, t: Array, u: Array, v: Array, memory: Array | None, force: Any) -> Array:
        values = self._evaluate("constrained", t, u, v, force, memory=memory)
        return constraints.solved(values, u.shape[-1], len(self.info.multipliers))

    def momenta(self, t: Array, u: Array, v: Array) -> dict[str, Array]:
        """Noether's momenta (...,) by name: see `Response.momenta`."""
        found = self._evaluate("momenta", t, u, v, memory=self._nothing(u)) if self.info.momenta else u
        return {name: found[..., k] for k, (name, _) in enumerate(self.info.momenta)}

    def angular_momentum(self, t: Array, u: Array, v: Array) -> Array | None:
        """Angular momentum (...,), kg m^2/s: see `Response.angular_momentum`; None for a scene without one."""
        return self.momenta(t, u, v)[self.info.turned] if self.info.turned else None

    def limits(self, t: Array, u: Array) -> Array:
        """Of each friction its limit without pressures, and how that grows with each of the d, (..., f, 1 + d)."""
        found = self._evaluate("limits", t, u, u, memory=self._nothing(u))
        return found.reshape(*found.shape[:-1], len(self.info.frictions), 1 + len(self.info.contacts))

    def powers(self, t: Array, u: Array, v: Array, memory: Array | None = None) -> dict[str, Array]:
        """The power (...,) of what gives energy to it or takes it, by name, W: see `Response.power_of_each`.

        Beside them `frame`, J, where an energy holds time: what the scene's is beyond the one that they change.
        """
        if not hasattr(self.module, "powers"):
            return {}
        found = self._evaluate("powers", t, u, v, self.forces(t), memory=memory)
        return {name: found[..., k] for k, name in enumerate(self.module.POWERS)}

    def outputs(self, t: Array, u: Array, v: Array, memory: Array | None = None) -> dict[str, Array]:
        """The scene's named outputs, each (...,)."""
        return {name: self._evaluate(name, t, u, v, memory=memory) for name in self.info.outputs}

    def forces(self, t: Array) -> Array:
        """The load at the times t, of their shape. Raises ValueError for one not finite or of another shape."""
        if self.load is None:
            return np.zeros(np.shape(t))
        load = self.load.along_first_axis(np.ndim(t)) if isinstance(self.load, LoadLanes) else self.load
        return values_at(load, np.asarray(t))

    def _evaluate(
        self,
        function: str,
        t: Array,
        u: Array,
        v: Array,
        force: ArrayLike = 0.0,
        *,
        memory: Array | None = None,
        elapsed: ArrayLike | None = None,
    ) -> Array:
        """A function of the module; force: the load, which only the acceleration depends on; elapsed: of a commit.

        Raises ValueError where laws have a memory that is not given: what they do is not known without it.
        """
        pressed = self.info.contacts and not self.info.impulsive
        reads = self.info.laws or (pressed and function in ("acceleration", "constrained"))
        if reads and memory is None:
            raise ValueError(
                f"expected the memory of {self.name}, {', '.join(self.info.memory)}, beside u and v, got none; give "
                "that of a response, r.memory"
            )
        given = [memory] if reads else []
        last = [elapsed] if elapsed is not None else [force] if self.info.sampled else []
        inner = (1,) * (np.ndim(u) - 2)  # axes between a lane's and the coordinates'
        values = (x.reshape(-1, *inner) if getattr(x, "ndim", 0) else x for x in self.parameters.values())
        with np.errstate(all="ignore"):
            return getattr(self.module, function)(*values, t, u, v, *given, *last)

    def __reduce__(self) -> tuple[Any, ...]:
        return _remade, (self.info.source, dict(self.parameters), self.a0_asked, self.load)

    def __repr__(self) -> str:
        values = [f"{name}={x}" for name, x in self.parameters.items()]
        values += [] if self.period is None else [f"T={self.period:.5g} s"]
        load = [] if self.load is None else [f"load={self.load!r}"]
        return f"Scene({', '.join([self.name, *values, f'a0={self.a0.tolist()}', *load])})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene) or (self.info, self._values) != (other.info, other._values):
            return False
        return self.load is other.load or bool(self.load == other.load)

    def __hash__(self) -> int:
        return hash((self.info, self._values))  # without the load, which need not have one

    @cached_property
    def _values(self) -> tuple[Values, Values]:
        return by_value(self.parameters), by_value({"u0": self.u0, "v0": self.v0, "a0": self.a0})


@cache
def _functions(name: str) -> ModuleType:
    """The module of a scene of the catalogue: committed, or printed to the user's cache on first use."""
    return committed(f"scenes.{name}") or modules.scene_module(name)


def make_scene(
    info: SceneInfo, values: Mapping[str, Any], a0: ArrayLike | str | None, load: Load | None, later: bool = False
) -> Scene:
    """A scene with parameters that have been checked, numbers or (P,).

    later: an acceleration at the start that is to follow from the equation of motion is left to who marches it, NaN.
    """
    if load is not None and not info.sampled:
        raise ValueError(
            f"expected no load for {info.name}, got one; its load is part of its declaration, so leave it out"
        )
    if load is not None and not callable(load):
        raise ValueError(
            f"expected load to be None or a function of time such as ss.Harmonic, got {type(load).__name__}; "
            "wrap samples as ss.Record(dt, values)"
        )
    swept = [*values.values(), *(load.parameters.values() if isinstance(load, LoadLanes) else ())]
    lanes = np.broadcast_shapes(*map(np.shape, swept))
    joined = _spread if lanes and len(info.coordinates) == 1 else _joined
    u0, v0, given = (None if x is None else joined(x, lanes) for x in info.start(*values.values()))
    assert u0 is not None
    assert v0 is not None
    draft = Scene(info, MappingProxyType(dict(values)), u0, v0, u0, load, a0)
    if not (np.isfinite(draft.length) & (np.asarray(draft.length) >= 0.0)).all():
        raise ValueError(
            f"expected a length of {info.name} of 0 or more, to which tolerances are relative, got {draft.length}; "
            "declare one that is not negative, as Abs of it, or give other parameters"
        )
    if info.reactions:
        for where in np.ndindex(lanes):
            one = Scene(info, {name: x[where] if np.ndim(x) else x for name, x in values.items()}, u0, v0, u0, load)
            one.require_allowed(u0[where], v0[where])
    wanted = a0 if a0 is not None else "consistent" if given is None else given
    later = later and isinstance(wanted, str)
    found = replace(draft, a0=np.broadcast_to(np.nan, u0.shape) if later else _acceleration(draft, wanted))
    if "memory0" in vars(draft):  # no other with another a0
        vars(found)["memory0"] = draft.memory0
    return found


def require_made(scene: Scene) -> None:
    """Raise ValueError for a scene whose start is not the one that `make_scene` makes of it.

    `dataclasses.replace` has changed it, or a load of the user's has another value at t = 0 than when it was made.
    """
    again = make_scene(scene.info, scene.parameters, scene.a0_asked, scene.load)
    for name in ("u0", "v0", "a0"):
        given, made = getattr(scene, name), getattr(again, name)
        if not np.array_equal(given, made, equal_nan=True):
            raise ValueError(
                f"expected a scene as ss.scene makes it, {name} = {made}, got {given}; set parameters instead, or make "
                "it anew where what its load reads has changed"
            )


def _remade(source: Any, parameters: dict[str, Any], a0: ArrayLike | str | None, load: Load | None) -> Scene:
    """A scene from what a pickled one keeps."""
    return make_scene(scene_info(source, {}), parameters, a0, load)


def _spread(component: Sequence[Any], lanes: tuple[int, ...]) -> Array:
    """A number or an array, of the one component, as an array (*lanes, 1), without a copy."""
    return np.broadcast_to(np.asarray(component[0], np.float64), lanes)[..., None]


def _joined(components: Sequence[Any], lanes: tuple[int, ...]) -> Array:
    """Numbers or arrays, one a component, as one array (*lanes, d)."""
    found = np.empty((*lanes, len(components)))
    for k, x in enumerate(components):
        found[..., k] = x
    return found


def _acceleration(scene: Scene, a0: ArrayLike | str) -> Array:
    if isinstance(a0, str):
        if a0 != "consistent":
            raise ValueError(f"expected a0 to be numbers or 'consistent', got '{a0}'")
        u, v = np.atleast_2d(scene.u0), np.atleast_2d(scene.v0)
        memory = np.atleast_2d(scene.memory0) if scene.info.memory else None
        found = scene.acceleration(np.zeros(len(u)), u, v, memory).reshape(scene.u0.shape)
        if found.ndim == 1 and not np.isfinite(found).all() and np.isfinite([*scene.parameters.values()]).all():
            given = ", ".join(f"{name} = {x:g}" for name, x in scene.parameters.items()) or "t = 0"
            raise ValueError(
                f"{scene.name}: expected a start at which the mass is not singular and all forces are finite, got the "
                f"acceleration {found} at {given}; start elsewhere"
            )
        return found
    array = np.atleast_1d(real_array("a0", a0))
    if array.shape not in (scene.u0.shape, scene.u0.shape[-1:]):
        components = scene.u0.shape[-1]
        raise ValueError(f"expected a0 with {components} components for {scene.name}, got shape {array.shape}")
    return np.broadcast_to(array, scene.u0.shape).copy()
