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
    stored = np.zeros(rows * size)
    kernel(1, [[x] for x in inputs], stored)
    return stored[::size].tolist()
