"""Spectral radius, numerical damping and period error at many points.

A scheme's module stores the coefficients of its polynomials at the points of a block; modules that all schemes share
find what follows from them, and call it by its address.
"""

from collections.abc import Callable, Sequence
from functools import cache
from types import ModuleType
from typing import Any

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
    n, refused = out.shape[1], False
    stability, given = _called(module, len(out) == 3)

    def part(begin: int, end: int) -> None:
        nonlocal refused
        for first in range(begin, end, PART):
            size = min(end - first, PART)
            inputs = np.empty((len(arguments), size))
            for row, values in zip(inputs, arguments, strict=True):
                row[:] = values if values.size == 1 else values[first : first + size]
            if stability(*given, inputs, out, first):
                refused = True

    spread(part, n, PART, nanoseconds=n * nanoseconds)
    return refused


@cache
def _called(module: ModuleType, all_three: bool) -> tuple[Callable[..., bool], tuple[Any, ...]]:
    """What stores one row, or all three, for a scheme's module; and its arguments that are the same for all points."""
    shared = _eigenvalues(module.EIGENVALUES)
    find = getattr(shared, "find", None)  # what two or three eigenvalues do not need
    kernels = (module.polynomial, 1), (find, 3), (shared.radii, 1), (None, 1), (None, 4)
    if all_three:
        errors = loaded("shared.errors").errors
        kernels = (module.polynomial, 1), (find, 3), (shared.eigenvalues, 1), (module.defect, 1), (errors, 4)
    addresses = (0 if kernel is None else address(kernel, whole) for kernel, whole in kernels)
    return loaded("shared.stability").stability, (*addresses, shared.SIZES)


def _eigenvalues(name: str) -> ModuleType:
    """The module that finds eigenvalues: committed, or printed on first use for an own scheme with more of them."""
    found = committed(f"shared.{name}")
    if found is None:
        from ..derived.modules import eigenvalues_module  # noqa: PLC0415 (the one door to SymPy)

        found = eigenvalues_module(name)
    return found
