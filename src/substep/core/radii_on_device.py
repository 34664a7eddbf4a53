"""The spectral radius at points whose arrays are in a GPU's memory: the functions of the CPU, a point in a thread."""

import re
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..derived.module_cache import cached_module
from .device import numba_cuda
from .eigenvalues import eigenvalues_of
from .scheme_record import SchemeRecord

THREADS, POINTS = 256, 16  # of a block, and points of a thread, which have in common what parameters alone decide
INTERFACES = "__cuda_array_interface__", "__cuda_ndarray__"  # the latter numba's own, in its simulator too
GPU, LEGACY = 2, 1  # DLPack's number of CUDA's devices, and of their default stream

TEXT = '''"""The spectral radius of {name} at points in the threads of a GPU."""

import math

import numpy as np
from numba import cuda, float64

BLOCK = 1  # points of a thread
_inner = _inline = cuda.jit(device=True)


{functions}


@cuda.jit(cache=True)
def store(Omega, xi, {parameters}damped, radius):
    """Store the spectral radius of points, NaN where Omega or xi is negative or not finite, or damping not taken."""
    points, rows = cuda.local.array(({inputs}, 1), float64), cuda.local.array({rows}, float64)
    found, largest = cuda.local.array({found}, float64), cuda.local.array(1, float64)
{read}
    i = cuda.grid(1)
    while i < radius.size:
        points[0, 0], points[1, 0] = {Omega}, {xi}
        polynomial(1, points, rows)
        radii(1, points, rows, found, largest)
        whole = points[0, 0] >= 0.0 and points[1, 0] >= 0.0 and (damped or points[1, 0] == 0.0)
        radius[i] = largest[0] if whole and math.isfinite(largest[0]) else math.nan
        i += cuda.gridsize(1)
'''


def is_there(x: Any) -> bool:
    """Whether an array is in a GPU's memory."""
    return any(hasattr(x, name) for name in INTERFACES) or (
        hasattr(x, "__dlpack__") and x.__dlpack_device__()[0] == GPU
    )


def spectral_radius(scheme: SchemeRecord, Omega: Any, xi: Any, out: Any = None) -> Any:
    """The largest modulus of the eigenvalues at arrays on a device, in an array there.

    Omega, xi: floats of double precision in C order, of one shape, or one of them a number; what has the CUDA array
    interface or DLPack's. out: such an array for the results, or a new one of numba. The scheme's parameters are
    numbers. NaN stands where an error would be raised of arrays on the CPU. Raises ValueError for other types and
    shapes, and for schemes of more than three eigenvalues that are not always 0.
    """
    if any(np.ndim(x) for x in scheme.kernel_parameters):
        raise ValueError(f"expected a handle of {scheme.name} whose parameters are numbers, got arrays; call for each")
    given = [_of_device("Omega", Omega), _of_device("xi", xi)]
    there = [not isinstance(x, float) for x in given]
    shapes = {x.shape for x, is_array in zip(given, there, strict=True) if is_array}
    if len(shapes) > 1:
        raise ValueError(f"expected Omega and xi of one shape on the device, got {given[0].shape} and {given[1].shape}")
    (shape,) = shapes
    radius = numba_cuda().device_array(shape) if out is None else _of_device("out", out)
    if isinstance(radius, float) or radius.shape != shape:
        got = () if isinstance(radius, float) else radius.shape
        raise ValueError(f"expected out of the shape {shape} on the device, got {got}; make one so, or give none")
    flat = [x.reshape(x.size) if is_array else x for x, is_array in zip(given, there, strict=True)]
    numbers = [float(x) for x in scheme.kernel_parameters]
    blocks = -(-radius.size // (THREADS * POINTS))
    store = _module(scheme.kernels, *there).store
    store[blocks, THREADS](*flat, *numbers, scheme.info.damping, radius.reshape(radius.size))
    return radius if out is None else out


def _of_device(name: str, x: Any) -> Any:
    """A number, or an array on the device as numba takes it."""
    if not is_there(x):
        if np.ndim(x):
            raise ValueError(f"expected {name} on the device or a number, got an array on the CPU; move it there")
        return float(x)
    found: Any = (
        x
        if hasattr(x, "__cuda_ndarray__")
        else numba_cuda().as_cuda_array(x if hasattr(x, INTERFACES[0]) else _Shared(x))
    )
    if found.dtype != np.float64 or not found.is_c_contiguous():
        raise ValueError(f"expected {name} of float64 in C order, got {found.dtype}; convert it on the device")
    return found


class _Shared:
    """An array that has DLPack's interface alone, with that of CUDA arrays."""

    def __init__(self, x: Any) -> None:
        views: Any = import_module("cuda.core.utils")  # numba-cuda brings it
        self.view = view = views.StridedMemoryView.from_dlpack(x, stream_ptr=LEGACY)
        strides = None if view.strides is None else tuple(n * view.dtype.itemsize for n in view.strides)
        self.__cuda_array_interface__ = {
            "shape": view.shape, "strides": strides, "typestr": view.dtype.str, "data": (view.ptr, view.readonly),
            "version": 3,
        }  # fmt: skip


@cache
def _module(module: ModuleType, Omega: bool, xi: bool) -> ModuleType:
    """The module with the kernel of a scheme: from the cache, or put together from the functions of the CPU.

    Omega, xi: whether these are arrays, and not numbers.
    """
    text = _text(module, Omega, xi)
    return cached_module(f"radii {text}", lambda: text)


def _source(module: ModuleType) -> str:
    return Path(module.__file__ or "").read_text(encoding="utf-8")


def _text(module: ModuleType, Omega: bool = True, xi: bool = True) -> str:
    """The functions that compute radii, of the scheme and for its kind of eigenvalues, and the kernel."""
    shared = eigenvalues_of(module.EIGENVALUES)
    if hasattr(shared, "find"):
        raise ValueError(
            f"expected a scheme of two or three eigenvalues that are not always 0, for a device, got {module.NAME}; "
            "take arrays on the CPU"
        )
    own = [f"@_inner\n{text}" for text in _functions(module) if text.startswith("def polynomial(")]
    helpers = [text for text in _functions(shared) if text.startswith("@_in")]
    radii = [f"@_inner\n{text}" for text in _functions(shared) if text.startswith("def radii(")]
    names = [f"{name}_" for name in module.PARAMETERS]
    rows, found, *_ = shared.SIZES
    return TEXT.format(
        name=module.NAME,
        functions="\n\n\n".join([*helpers, *radii, *own]),
        parameters="".join(f"{name}, " for name in names),
        inputs=len(names) + 2,
        rows=rows,
        found=found,
        read="\n".join(f"    points[{k}, 0] = {name}" for k, name in enumerate(names, start=2)),
        Omega="Omega[i]" if Omega else "Omega",
        xi="xi[i]" if xi else "xi",
    )


def _functions(module: ModuleType) -> list[str]:
    """The texts of a generated module's functions, with their decorators."""
    return [text.strip("\n") for text in re.split(r"\n\n\n", _source(module)) if re.match(r"\n*(@\w+\n)?def ", text)]
