"""Spectral radius, numerical damping and period error at many points.

A scheme's module stores the coefficients of its polynomials at the points of a block; modules that all schemes share
find what follows from them, and call it by its address.
"""

from collections.abc import Callable, Sequence
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np

from ..derived import modules
from .arrays import Array
from .kernel_modules import address, addresses, committed, loaded
from .threads import spread

NONE = np.empty(0, np.int64)
PART = 1 << 13  # points, of which a thread takes a whole number


def stability_at_points(
    module: ModuleType, arguments: Sequence[Array], large: float, out: Array, nanoseconds: float
) -> tuple[bool, bool]:
    """Store spectral radius and, in a second and third row of out (1 or 3, n), damping and period error.

    module: of a scheme. arguments: Omega, xi and its PARAMETERS, (n,) or (1,) each. nanoseconds: about how long a point
    takes. Returns whether an Omega, an xi or a radius is negative or not finite, and whether the size of a damping is
    `large`, or it is NaN.
    """
    n, refused, beyond = out.shape[1], False, False
    stability, width, given = _called(module, len(out) == 3)
    varying, inputs = NONE, NONE
    kept: list[Array] = []
    if n != 1:
        varying = np.array([k for k, values in enumerate(arguments) if values.size != 1], np.int64)
        # kept until the end, since kernels read them by their addresses
        kept = [np.ascontiguousarray(arguments[int(k)], np.float64) for k in varying]
        assert all(x.shape == (n,) for x in kept)  # kernels would read beyond them
        inputs = addresses(kept)

    def part(begin: int, end: int) -> None:
        nonlocal refused, beyond
        block = np.empty((len(arguments) + 2, width))
        for row, values in zip(block, arguments, strict=False):
            if values.size == 1:
                row[:] = values
        some_refused, some_beyond = stability(*given, block, varying, inputs, large, out, begin, end)
        if some_refused:  # never set back, whatever another thread has seen
            refused = True
        if some_beyond:
            beyond = True

    spread(part, n, PART, nanoseconds=n * nanoseconds)
    return refused, beyond


@cache
def _called(module: ModuleType, all_three: bool) -> tuple[Callable[..., tuple[bool, bool]], int, tuple[Any, ...]]:
    """What stores one row, or all three, for a scheme's module; the points of its block; its fixed arguments."""
    shared = eigenvalues_of(module.EIGENVALUES)
    find = getattr(shared, "find", None)  # what two or three eigenvalues do not need
    common = loaded("shared.stability")
    kernels = [(common.look, 1), (module.polynomial, 1), (find, 3), (shared.radii, 1), (None, 1), (None, 4)]
    if all_three:
        kernels[3:] = (shared.eigenvalues, 1), (module.defect, 1), (loaded("shared.errors").errors, 4)
    given = (0 if kernel is None else address(kernel, whole) for kernel, whole in kernels)
    return common.stability, common.BLOCK, (*given, shared.SIZES)


def eigenvalues_of(name: str) -> ModuleType:
    """The module that finds eigenvalues: committed, or printed on first use for an own scheme with more of them."""
    return committed(f"shared.{name}") or modules.eigenvalues_module(name)
