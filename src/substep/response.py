"""What a march returns."""

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
    linear. angular_momentum is None for a scene without one.
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
