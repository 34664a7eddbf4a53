"""Names of degrees of freedom by component and place."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike


def placed(components: Sequence[str], places: ArrayLike) -> tuple[str, ...]:
    """Names "ux at 1 0.5" of all components at the first place (d,), then of all at the second, of places (n, d)."""
    at = [" ".join(f"{x + 0.0:.9g}" for x in place) for place in np.asarray(places, dtype=np.float64)]
    return tuple(f"{component} at {place}" for place in at for component in components)
