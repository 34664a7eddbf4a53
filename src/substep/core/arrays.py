"""Arrays in the form for which kernels are compiled, contiguous, with one axis, read-only; and arrays with names."""

import hashlib
from collections.abc import Iterable, Mapping
from math import prod
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from xarray import Variable

Array = NDArray[np.float64]
# arrays by value, see `by_value`: name, shape and bytes of each
Values = tuple[tuple[str, tuple[int, ...], bytes], ...]

ALONE = 1 << 18  # multiplications of a product that OpenBLAS does not share out among threads


def read_only(array: Array) -> Array:
    """The array as contiguous 1-D and read-only: a view where it can be one, since it may be the caller's."""
    flags = array.flags
    if array.ndim == 1 and flags.c_contiguous and not flags.writeable:
        return array
    flat = array.ravel()
    flat.setflags(write=False)
    return flat


def flat(array: Array, shape: tuple[int, ...]) -> Array:
    """The array broadcast to that shape, then flat and read-only as from `read_only`."""
    if array.shape != shape:
        array = np.full(prod(shape), array.item()) if array.size == 1 else np.broadcast_to(array, shape)
    return read_only(array)


def dot(x: Array, y: Array) -> float:
    """The inner product of two vectors (n,), without BLAS.

    OpenBLAS shares it out among threads, which wait for each other longer than it takes: with 100 000 numbers 650 us in
    place of 45, and 8 ms where two threads share a core.
    """
    return float(np.einsum("i,i->", x, y))


def repeated(x: ArrayLike, P: int) -> Array:
    """A number, or one for each of P, as a row (P,): for one at a fifth of the time that NumPy takes for more."""
    array = np.asarray(x, np.float64)
    return array.reshape(1) if P == 1 else np.broadcast_to(array, P)


def alike(x: Array) -> bool:
    """Whether all numbers of a row (P,) are the same, as those of one that is repeated are."""
    return len(x) == 0 or x.strides == (0,) or bool((x == x[0]).all())


def copy_rows(x: Array, to: Array) -> None:
    """Copy x (..., d) into `to`, both contiguous along the last axis, d numbers at a time: one by one takes longer."""
    together = f"V{x.shape[-1] * x.itemsize}"
    to.view(together)[...] = x.view(together)


def common_shape(names: Iterable[str], arrays: Iterable[Array]) -> tuple[int, ...]:
    """The shape that the arrays broadcast to. Raises ValueError, with their names, where there is none."""
    arrays = tuple(arrays)
    shapes = {a.shape for a in arrays} - {()}
    if len(shapes) < 2:  # the usual case, at a fifth of the time
        return shapes.pop() if shapes else ()
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


def named(dims: str | tuple[str, ...], values: NDArray[Any], attrs: Mapping[str, Any]) -> "Variable":
    """The array, as it is, as a variable of a Dataset."""
    from xarray import Variable  # noqa: PLC0415 (on first use)

    # fastpath: else xarray imports dask, where it is installed, to ask whether a NumPy array is one of dask's
    return Variable(dims, values, attrs, fastpath=True)


def digest(*parts: Any) -> str:
    """What tells these arrays, and other values by their text, from others."""
    found = hashlib.sha256()
    for part in parts:
        array = isinstance(part, np.ndarray)
        found.update(np.ascontiguousarray(cast("Array", part)).tobytes() if array else repr(part).encode())
    return found.hexdigest()
