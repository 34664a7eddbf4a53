"""What a march returns."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from .arrays import Array

if TYPE_CHECKING:
    from .scenes import Scene
    from .schemes import Scheme

Ended = Literal["completed", "newton_failed", "non_finite", "energy_bound", "step_too_small"]
STATUSES: tuple[Ended, ...] = get_args(Ended)  # in the order of the kernels' numbers
Status = Ended | Literal["interrupted"]  # the latter from the keyboard: a march of a structure that is not done


@dataclass(frozen=True)
class Statistics:
    """What steps of chosen length have cost.

    accepted, rejected: steps; newton_failures: those of the rejected whose iteration did not converge.
    newton_iterations, newton_most: of each balance in the accepted steps, their sum and the most in one. shortest,
    longest: accepted steps, s; NaN if there is none.
    """

    accepted: int
    rejected: int
    newton_failures: int
    newton_iterations: tuple[int, ...]
    newton_most: tuple[int, ...]
    shortest: float
    longest: float


@dataclass(frozen=True, eq=False, repr=False)
class Response:
    """Histories u, v (n+1, ndof), and t, energy, angular_momentum (n+1,), which are computed when first read.

    status: "completed", or why the march stopped; then all arrays end at the last good state and
    t_failed is the end of the step that failed. newton_iterations (n, balances): 0 where a balance is
    linear; where another scheme marches the first steps, the sum over its balances counts as the first balance's.
    a (n+1, ndof) is the scheme's own acceleration, else M^-1 (F - C v - N). angular_momentum is None for a
    scene without one; outputs holds the scene's own, such as strain.

    Where the march chose its steps: statistics says what they cost (None for a constant step), t is what is stored, and
    newton_iterations has a row for each accepted step, none where rows were asked for on a grid.
    """

    u: Array
    v: Array
    newton_iterations: NDArray[np.int64]
    status: Status
    t_failed: float | None
    scene: "Scene"
    scheme: "Scheme"
    step: float  # s between two rows; NaN where steps are uneven
    own_a: Array | None
    times: Array | None = None  # s, where steps are uneven
    statistics: Statistics | None = None

    @cached_property
    def t(self) -> Array:
        """Times (n+1,), s."""
        return np.arange(len(self.u)) * self.step if self.times is None else self.times

    @cached_property
    def a(self) -> Array:
        """Acceleration (n+1, ndof)."""
        if self.own_a is not None:
            return self.own_a
        return np.concatenate([self.scene.a0[None], self.scene.acceleration(self.t, self.u, self.v)[1:]])

    @cached_property
    def energy(self) -> Array:
        """Kinetic energy and potential (n+1,), J."""
        return self.scene.energy(self.t, self.u, self.v)

    @cached_property
    def angular_momentum(self) -> Array | None:
        """Angular momentum about the pivot (n+1,), kg m^2/s; None for a scene without one."""
        return self.scene.angular_momentum(self.t, self.u, self.v)

    @cached_property
    def outputs(self) -> Mapping[str, Array]:
        """The scene's named outputs, each (n+1,)."""
        return self.scene.outputs(self.t, self.u, self.v)

    @property
    def strain(self) -> Array:
        """Axial strain (n+1,). Raises AttributeError for a scene without one."""
        if "strain" not in self.outputs:
            raise AttributeError("expected a scene with a strain, such as elastic_pendulum; this one has none")
        return self.outputs["strain"]

    def __repr__(self) -> str:
        end = f"{len(self.t)} rows to t = {self.t[-1]:.6g} s, {self.status}"
        return f"{type(self).__name__}({self.scheme} on {self.scene}, {end})"
