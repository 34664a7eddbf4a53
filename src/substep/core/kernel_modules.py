"""Generated modules, imported on first use, and with them numba."""

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .arrays import Array


@cache
def committed(name: str) -> ModuleType | None:
    """The committed module of that name; None for one that is printed on first use."""
    full = f"substep_kernels.{name}"
    return import_module(full) if find_spec(full) else None


def loaded(module: str | ModuleType) -> ModuleType:
    """The module that an entry of the index names; one of the user's own is in the entry itself."""
    found = module if isinstance(module, ModuleType) else committed(module)
    assert found is not None  # the index names only what is committed
    return found


def printed(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters by the names that they have in kernels: with an underscore at the end, as no other name there."""
    return {f"{name}_": value for name, value in parameters.items()}


@cache
def address(kernel: Callable[..., None], whole: int = 1) -> int | Callable[..., None]:
    """Where a kernel of blocks is, compiled or read from numba's cache on first use; itself if numba compiles nothing.

    kernel: a function of so many whole numbers, then of pointers to doubles; `points` are pointers to rows of them.
    """
    from numba import cfunc, types  # noqa: PLC0415 (on first use)

    if not compiles():
        return kernel
    row, code = types.CPointer(types.float64), kernel.__code__
    names = code.co_varnames[whole : code.co_argcount]
    pointers = [types.CPointer(row) if name == "points" else row for name in names]
    signature = types.void(*[types.int64] * whole, *pointers)
    compiled: Any = cfunc(signature, cache=True, error_model="numpy", fastmath={"contract"})(kernel)
    _kept.append(compiled)
    return compiled.address


def addresses(arrays: Sequence[Array]) -> NDArray[np.int64] | tuple[Array, ...]:
    """Where contiguous arrays are, for kernels that are called by their address; themselves if numba compiles nothing.

    The arrays must be kept as long as their addresses are used.
    """
    if not compiles():
        return tuple(arrays)
    return np.array([array.ctypes.data for array in arrays], np.int64)


@cache
def called(kernel: Callable[..., None]) -> Callable[..., None]:
    """A kernel of a whole number and contiguous arrays, which it takes as flat ones, as a function in Python."""
    at = address(kernel)
    if not isinstance(at, int):

        def flat(n: int, *arrays: Array) -> None:
            at(n, *(x.reshape(-1) for x in arrays))

        return flat
    kinds = [ctypes.c_void_p] * (kernel.__code__.co_argcount - 1)
    function: Any = ctypes.CFUNCTYPE(None, ctypes.c_int64, *kinds)(at)

    def call(n: int, *arrays: Array) -> None:
        function(n, *(x.ctypes.data for x in arrays))

    return call


def compiles() -> bool:
    """Whether numba compiles what it is given."""
    import numba  # noqa: PLC0415 (on first use)

    return not cast("Any", numba).config.DISABLE_JIT


_kept: list[Any] = []  # compiled code is freed with the object that holds it
