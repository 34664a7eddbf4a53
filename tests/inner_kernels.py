"""Functions that only kernels call, made callable for tests."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba import njit


def from_python(inner: Any) -> Any:
    """A compiled function that calls the inner one, which has no code of its own for calls from Python."""
    return njit(lambda *arguments: inner(*arguments))  # noqa: PLW0108 (a function of its own is what is wanted)


def block_of(kernel: Any, inputs: Sequence[float], rows: int) -> list[float]:
    """The rows that a kernel of blocks, as plain Python, stores at one point."""
    size = kernel.__globals__["BLOCK"]
    points, stored = np.zeros(len(inputs) * size), np.zeros(rows * size)
    points[::size] = inputs
    kernel(1, points, stored)
    return stored[::size].tolist()
