"""What a march returns."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Status = Literal["completed", "newton_failed", "non_finite", "energy_bound"]


@dataclass(frozen=True)
class Response:
    """Histories at t (n+1,): u, v, a (n+1, ndof), energy (n+1,).

    status: "completed", or why the march stopped; then all arrays end at the last good state and
    t_failed is the end of the step that failed. newton_iterations (n, balances): 0 where a balance is
    linear. a is the scheme's own acceleration, else M^-1 (F - C v - N). angular_momentum is None for a
    scene without one; outputs holds the scene's own, such as strain.
    """

    t: Array
    u: Array
    v: Array
    a: Array
    energy: Array
    angular_momentum: Array | None
    newton_iterations: NDArray[np.int64]
    status: Status
    t_failed: float | None
    outputs: Mapping[str, Array]

    @property
    def strain(self) -> Array:
        """Axial strain (n+1,). Raises AttributeError for a scene without one."""
        if "strain" not in self.outputs:
            raise AttributeError("expected a scene with a strain, such as elastic_pendulum; this one has none")
        return self.outputs["strain"]
