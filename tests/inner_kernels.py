"""Functions that only kernels call, made callable for tests."""

from typing import Any

from numba import njit


def from_python(inner: Any) -> Any:
    """A compiled function that calls the inner one, which has no code of its own for calls from Python."""
    return njit(lambda *arguments: inner(*arguments))  # noqa: PLW0108 (a function of its own is what is wanted)
