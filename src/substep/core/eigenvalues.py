"""Spectral radius, numerical damping and period error at many points.

A scheme's module stores the coefficients of its polynomials at the points of a block; modules that all schemes share
find what follows from them, and call it by its address.
"""

from collections.abc import Sequence
from functools import cache
from types import ModuleType

import numpy as np

from .arrays import Array
from .kernel_modules import address, committed, loaded
from .threads import spread

PART = 1 << 13  # points of a call, whose inputs stay in the second cache


def stability_at_points(module: ModuleType, arguments: Sequence[Array], out: Array, nanoseconds: float) -> bool:
    """Store spectral radius and, in a second and third row of out (1 or 3, n), damping and period error.

    module: of a scheme. arguments: Omega, xi and its PARAMETERS, (n,) or (1,) each. nanoseconds: about how long a point
    takes. Returns whether an Omega, an xi or a radius is negative or not finite.
    """
    n, shared = out.shape[1], _eigenvalues(module.EIGENVALUES)
    own, kernel = (address(module.polynomial),), shared.spectral_radius
    if len(out) == 3:
        own, kernel = (*own, address(module.defect), address(loaded("shared.errors").errors, 4)), shared.stability
    refused = False

    def part(begin: int, end: int) -> None:
        nonlocal refused
        for first in range(begin, end, PART):
            size = min(end - first, PART)
            inputs = np.empty((len(arguments), size))
            for row, values in zip(inputs, arguments, strict=True):
                row[:] = values if values.size == 1 else values[first : first + size]
            if kernel(*own, inputs, out, first):
                refused = True

    spread(part, n, PART, nanoseconds=n * nanoseconds)
    return refused


@cache
def _eigenvalues(name: str) -> ModuleType:
    """The module that finds eigenvalues: committed, or printed on first use for an own scheme with more of them."""
    found = committed(f"shared.{name}")
    if found is None:
        from ..derived.modules import eigenvalues_module  # noqa: PLC0415 (the one door to SymPy)

        found = eigenvalues_module(name)
    return found
