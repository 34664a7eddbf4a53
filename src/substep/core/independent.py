"""Constraints that repeat others, as those of overconstrained mechanisms do: left out, and watched."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .arrays import Array
from .constraints import ALLOWED, DEPENDENT, sizes
from .errors import called_as, real_number
from .scene_by_name import scene
from .scene_catalogue import checked_parameters, scene_info
from .scenes import Scene

if TYPE_CHECKING:
    from ..derived.modules import SceneDeclaration
    from .response import Response

NEARBY = 1e-3  # of the scene's length: how far from the start the rank is looked at once more


@dataclass(frozen=True)
class Independent:
    """A scene without the constraints that repeat others.

    scene: what can be marched. left_out: the names of those constraints. rank: how many are independent.
    """

    scene: Scene
    left_out: tuple[str, ...]
    rank: int
    _whole: Scene

    def off(self, r: "Response") -> Mapping[str, Array]:
        """What a response leaves of each constraint that was left out, (n+1,), in the units of its coordinates.

        That is its value over the size of its gradient, if it has one; rounding as long as it repeats the others.
        """
        names = self._whole.info.multipliers
        values, G = self._whole.drift(r.t, r.u, r.v)[0], self._whole.directions(r.t, r.u)
        values = values / sizes(G)
        return {name: values[:, names.index(name)] for name in self.left_out}

    def __str__(self) -> str:
        which = f"left out: {', '.join(self.left_out)}" if self.left_out else "none is left out"
        return (
            f"{self.scene.name}: {self.rank} of {self.rank + len(self.left_out)} constraints are independent; {which}"
        )


@called_as("independent(declaration, L=1.0)")
def independent(declaration: "SceneDeclaration", **parameters: Any) -> Independent:
    """A scene of a declaration in which constraints may repeat each other, without those that do.

    The rank of the constraints' gradients at the start decides, in the order in which they are declared: one that adds
    nothing to those before it is left out. It must hold there too, as must its rate. parameters: as of `scene`.

    Raises ValueError for constraints that contradict each other, and for a start at which the rank is lower than
    nearby, where what is left out would be missed later.

    >>> from substep_derive import Scene, rate
    >>> from sympy import Symbol
    >>> x, y = Symbol("x"), Symbol("y")
    >>> held = {"plane": x - y, "again": 2 * x - 2 * y}
    >>> kinetic, start = (rate(x) ** 2 + rate(y) ** 2) / 2, {x: 0, y: 0, rate(x): 1, rate(y): 1}
    >>> declared = Scene("slope", coordinates={x: "m", y: "m"}, kinetic=kinetic, potential=y, constraints=held,
    ...     parameters=(), start=start, length=1)
    >>> print(ss.independent(declared))
    slope: 1 of 2 constraints are independent; left out: again
    """
    whole = _unchecked(declaration, parameters)
    at, names = (np.zeros(1), whole.u0[None], whole.v0[None]), whole.info.multipliers
    if not names:
        return Independent(scene(declaration, **parameters), (), 0, whole)
    kept = _independent(whole.directions(*at[:2])[0][: len(names)])
    left_out = [k for k in range(len(names)) if k not in kept]
    if not left_out:
        return Independent(scene(declaration, **parameters), (), len(names), whole)
    values, rates, _ = whole.drift(*at)
    scales = whole.length, max(float(np.linalg.norm(whole.v0)), float(np.abs(rates).max()))
    across = sizes(whole.directions(*at[:2])[0])
    for k in left_out:
        if any(abs(x[0, k]) > ALLOWED * scale * across[k] for x, scale in zip((values, rates), scales, strict=True)):
            raise ValueError(
                f"expected constraints of {whole.name} that can hold together, got '{names[k]}', which adds nothing to "
                "those before it, and does not hold; correct it, or the start"
            )
    less = replace(declaration, constraints={names[k]: declaration.constraints[names[k]] for k in kept})
    found = scene(less, **parameters)
    moved = found.allowed(found.u0 + NEARBY * found.length * _direction(len(found.u0)), found.v0).u
    if len(_independent(whole.directions(at[0], moved[None])[0][: len(names)])) > len(kept):
        raise ValueError(
            f"expected a start of {whole.name} at which as many constraints are independent as nearby, got "
            f"{len(kept)} of {len(names)}; start elsewhere"
        )
    return Independent(found, tuple(names[k] for k in left_out), len(kept), whole)


def _unchecked(declaration: "SceneDeclaration", parameters: Mapping[str, Any]) -> Scene:
    """The scene before its start and its constraints are looked at."""
    info = scene_info(declaration, {})
    values = checked_parameters(info, parameters, real_number)
    u0, v0 = (np.array(x, dtype=float) for x in info.start(*values.values())[:2] if x is not None)
    return Scene(info, values, u0, v0, u0, None)


def _independent(G: Array) -> list[int]:
    """The rows that add to the span of those before them."""
    basis, kept = np.zeros((0, G.shape[1])), list[int]()
    for k, row in enumerate(G / sizes(G)[:, None]):
        rest = row - basis.T @ (basis @ row)
        rest = rest - basis.T @ (basis @ rest)
        if (size := float(np.linalg.norm(rest))) > DEPENDENT**0.5:
            basis, kept = np.vstack([basis, rest / size]), [*kept, k]
    return kept


def _direction(d: int) -> Array:
    """A direction (d,) that has nothing to do with a mechanism."""
    return np.cos(1.0 + np.arange(d) * 2.0)
