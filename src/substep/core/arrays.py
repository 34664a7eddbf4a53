"""Arrays in the form for which kernels are compiled: contiguous, with one axis, read-only."""

from collections.abc import Iterable, Mapping
from math import prod

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
# arrays by value, see `by_value`: name, shape and bytes of each
Values = tuple[tuple[str, tuple[int, ...], bytes], ...]


def read_only(array: Array) -> Array:
    """The array as contiguous 1-D and read-only: a view where it can be one, since it may be the caller's."""
    if array.ndim == 1 and array.flags.c_contiguous and not array.flags.writeable:
        return array
    flat = array.ravel()
    flat.setflags(write=False)
    return flat


def flat(array: Array, shape: tuple[int, ...]) -> Array:
    """The array broadcast to that shape, then flat and read-only as from `read_only`."""
    if array.shape != shape:
        array = np.full(prod(shape), array.reshape(())[()]) if array.size == 1 else np.broadcast_to(array, shape)
    return read_only(array)


def common_shape(names: Iterable[str], arrays: Iterable[Array]) -> tuple[int, ...]:
    """The shape that the arrays broadcast to. Raises ValueError, with their names, where there is none."""
    arrays = tuple(arrays)
    try:
        return np.broadcast(*arrays).shape
    except ValueError as error:
        shapes = ", ".join(f"{name} {np.shape(a)}" for name, a in zip(names, arrays, strict=True))
        raise ValueError(
            f"expected shapes that broadcast, got {shapes}; add axes, for example Omega[:, None]"
        ) from error


def by_value(arrays: Mapping[str, ArrayLike]) -> Values:
    """Named arrays of floats as something to compare and to hash: equal for equal names, shapes and values."""
    floats = ((name, np.asarray(x, dtype=np.float64)) for name, x in arrays.items())
    return tuple((name, x.shape, (x + 0.0).tobytes()) for name, x in floats)  # + 0.0: -0.0 equals 0.0
