"""The spectral radius at points whose arrays are in a GPU's memory: the functions of the CPU, a point in a thread."""

import re
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from .device import numba_cuda
from .eigenvalues import eigenvalues_of
from .scheme_record import SchemeRecord

THREADS = 256  # of a block

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
    i = cuda.grid(1)
    if i < radius.size:
        points = cuda.local.array(({inputs}, 1), float64)
        rows, found = cuda.local.array({rows}, float64), cuda.local.array({found}, float64)
        points[0, 0], points[1, 0] = Omega[i if Omega.size > 1 else 0], xi[i if xi.size > 1 else 0]
{read}
        polynomial(1, points, rows)
        radii(1, points, rows, found, radius[i:])
        whole = points[0, 0] >= 0.0 and points[1, 0] >= 0.0 and (damped or points[1, 0] == 0.0)
        if not (whole and math.isfinite(radius[i])):
            radius[i] = math.nan
'''


def is_there(x: Any) -> bool:
    """Whether an array is in a GPU's memory."""
    return hasattr(x, "__cuda_array_interface__") or hasattr(x, "__cuda_ndarray__")


def spectral_radius(scheme: SchemeRecord, Omega: Any, xi: Any) -> Any:
    """The largest modulus of the eigenvalues at arrays on a device, as an array there, which CuPy and others take.

    Omega, xi: floats of double precision in C order, of one shape, or one of them a number; what has the CUDA array
    interface. The scheme's parameters are numbers. NaN stands where an error would be raised of arrays on the CPU.
    Raises ValueError for other types and shapes, and for schemes of more than three eigenvalues that are not always 0.
    """
    given = [_of_device(name, x) for name, x in (("Omega", Omega), ("xi", xi))]
    shapes = {x.shape for x in given if x.shape != (1,)}
    if len(shapes) > 1:
        raise ValueError(f"expected Omega and xi of one shape on the device, got {given[0].shape} and {given[1].shape}")
    if any(np.ndim(x) for x in scheme.kernel_parameters):
        raise ValueError(f"expected a handle of {scheme.name} whose parameters are numbers, got arrays; call for each")
    shape = shapes.pop() if shapes else (1,)
    radius: Any = numba_cuda().device_array(shape)
    flat = [x.reshape(x.size) for x in (*given, radius)]
    numbers = [float(x) for x in scheme.kernel_parameters]
    store = _module(scheme.kernels).store
    store[-(-radius.size // THREADS), THREADS](flat[0], flat[1], *numbers, scheme.info.damping, flat[2])
    return radius


def _of_device(name: str, x: Any) -> Any:
    """An array on the device as numba takes it, from any with the CUDA array interface, or a number."""
    if not is_there(x):
        if np.ndim(x):
            raise ValueError(f"expected {name} on the device or a number, got an array on the CPU; move it there")
        return numba_cuda().to_device(np.array([x], dtype=np.float64))
    found: Any = x if hasattr(x, "__cuda_ndarray__") else numba_cuda().as_cuda_array(x)
    if found.dtype != np.float64 or not found.is_c_contiguous():
        raise ValueError(f"expected {name} of float64 in C order, got {found.dtype}; convert it on the device")
    return found


@cache
def _module(module: ModuleType) -> ModuleType:
    """The module with the kernel of a scheme: from the cache, or put together from the functions of the CPU."""
    from ..derived.module_cache import cached_module  # noqa: PLC0415

    text = _text(module)
    return cached_module(f"radii {text}", lambda: text)


def _source(module: ModuleType) -> str:
    return Path(module.__file__ or "").read_text(encoding="utf-8")


def _text(module: ModuleType) -> str:
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
        read="\n".join(f"        points[{k}, 0] = {name}" for k, name in enumerate(names, start=2)),
    )


def _functions(module: ModuleType) -> list[str]:
    """The texts of a generated module's functions, with their decorators."""
    return [text.strip("\n") for text in re.split(r"\n\n\n", _source(module)) if re.match(r"\n*(@\w+\n)?def ", text)]
