"""Any declaration on M a + C v + K u = f, stepped densely from its own equations, without the derivation."""

from collections.abc import Callable, Mapping
from typing import Any

import mpmath
import numpy as np
from declared_steps import Array, System
from declared_steps import march as march_system
from substep_derive import Scheme
from sympy import Symbol


def structure(M: Array, C: Array, K: Array, load: Callable[[float], Array]) -> System:
    """In mpmath's precision where all are its numbers, with dtype object."""
    by_mass = np.array(mpmath.inverse(mpmath.matrix(M.tolist())).tolist()) if M.dtype == object else np.linalg.inv(M)
    return System(
        lambda x: by_mass @ K @ x, lambda x: by_mass @ K, lambda old, new: by_mass @ K @ (old + new) / 2, by_mass @ C,
        lambda t: by_mass @ load(t),
    )  # fmt: skip


def march(
    scheme: Scheme, values: Mapping[Symbol, Any], M: Array, C: Array, K: Array, load: Callable[[float], Array],
    h: float, n: int, u: Array, v: Array,
) -> list[list[Array]]:  # fmt: skip
    """Rows (u, v, a) at 0, h, ..., n h."""
    return march_system(scheme, values, structure(M, C, K, load), h, n, u, v)
