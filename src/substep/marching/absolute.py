"""The force of spring and dashpot over the mass, 2 xi omega v + omega^2 u, in place of the acceleration of a march.

On a moving ground it is the absolute acceleration, with the sign turned.
"""

import numpy as np

from ..core import coefficients
from ..core.arrays import Array
from ..core.kernel_modules import committed
from ..core.schemes import Scheme
from .oscillators import Oscillators


def with_absolute(o: Oscillators, found: Array) -> Array:
    """u, v, 2 xi omega v + omega^2 u (..., 3, P) from u, v, a."""
    u, v = found[..., 0, :], found[..., 1, :]
    return np.stack([u, v, 2.0 * o.xi * o.omega * v + o.omega**2 * u], axis=-2)


def absolute_shape(scheme: Scheme) -> str:
    """The shape of a march that carries no acceleration; v is carried where a committed shape does so."""
    places, m = coefficients.places(scheme), len(coefficients.marched(scheme))
    shape = coefficients.march_name(m, (*places[:2], "y"))
    if places[1] != "y" and committed(f"marches.{shape}") is not None:
        return shape
    return coefficients.march_name(m, (places[0], "y", "y"))


def absolute_rows(scheme: Scheme, C: Array, o: Oscillators, K: int) -> Array:
    """Coefficients of a march of `absolute_shape` for 2 xi omega v + omega^2 u in place of the acceleration.

    C: those of the scheme's own march for K loads a step.
    """
    places, m, P = coefficients.places(scheme), len(coefficients.marched(scheme)), C.shape[1]
    R = places.count("y")
    D, B, y_x, y_f, _ = np.split(C, np.cumsum([m * m, m * K, R * m, R * K]))
    ahead = np.concatenate([D.reshape(m, m, P) + np.eye(m)[..., None], B.reshape(m, K, P)], axis=1)
    reported: Array = np.concatenate([y_x.reshape(R, m, P), y_f.reshape(R, K, P)], axis=1)
    others = iter(reported)
    u, v, _ = (next(others) if p == "y" else ahead[int(p)] / o.dt**kind for kind, p in enumerate(places))
    force = 2.0 * o.xi * o.omega * v + o.omega**2 * u
    carries_v = places[1] != "y" and absolute_shape(scheme) == coefficients.march_name(m, (*places[:2], "y"))
    outputs = [u] * (places[0] == "y") + [v] * (not carries_v) + [force]
    rows = [D, B, *(row[:m] for row in outputs), *(row[m:] for row in outputs), *[1.0 / o.dt[None]] * carries_v]
    return np.ascontiguousarray(np.concatenate(rows))
