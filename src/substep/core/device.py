"""Kernels in the threads of a GPU, each lane in a thread: the same calls as the kernels of the CPU.

What runs inside `on` takes them in place of those. Arrays of a call go to the device's memory and results come back;
lanes that do not fit there at once go one part after another.
"""

import warnings
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from importlib import import_module
from typing import Any, Literal, get_args

import numpy as np

from ..derived import modules
from . import single
from .arrays import Array
from .errors import unknown_name

Device = Literal["cpu", "cuda", "auto"]

THREADS = 64  # of a block: few, so that a small number of lanes is spread over all of a GPU's processors
SHARE = 0.8  # of the device's free memory that one part of the lanes may take
# of a march of a scene: in steps of one length, in steps that it chooses
RESULTS = {
    *("state", "out", "extremes", "iterations", "newton", "peak", "n_done", "status"),
    *("here", "control", "counts", "times"),
}
SHARED = "samples", "grid"  # arrays that all lanes have in common, whatever their length

_on: ContextVar[bool] = ContextVar("on", default=False)
_march_of_shape, _peaks_of_filter = cache(modules.march_in_threads), cache(modules.filter_in_threads)
_march_of_pair, _adaptive_march = cache(modules.pair_in_threads), cache(modules.adaptive_pair)


@contextmanager
def on(device: Device) -> Generator[None]:
    """Marches called inside run there: on the CPU, on a GPU, or on a GPU if there is one. Raises as `found` does."""
    token = _on.set(found(device))
    try:
        yield
    finally:
        _on.reset(token)


def numba_cuda() -> Any:
    """numba's CUDA, of which nothing is loaded before it is asked for. Raises ImportError where numba has none."""
    return import_module("numba.cuda")


def is_on() -> bool:
    """Whether marches run in the threads of a GPU here."""
    return _on.get()


def found(device: Device | str) -> bool:
    """Whether marches on this device run in the threads of a GPU.

    Raises ValueError for another name; for "cuda" ImportError where numba has no CUDA, and RuntimeError where it finds
    no device, or no compiler for it.
    """
    if device not in get_args(Device):
        raise unknown_name("device", str(device), get_args(Device))
    if device == "cpu":
        return False
    try:
        cuda = numba_cuda()
    except ImportError as error:
        if device == "auto":
            return False
        raise ImportError(
            "expected numba-cuda for device='cuda', got none installed; pip install 'substep[cuda]', or take "
            "device='cpu'"
        ) from error
    if cuda.is_available():
        return True
    if device == "auto":
        return False
    missing = str(cuda.cuda_error() or "numba finds no libNVVM, the compiler for it").strip().replace("\n", " ")
    raise RuntimeError(
        f"expected a CUDA device for device='cuda', got none: {missing}; pip install 'substep[cuda]' on a machine with "
        "an NVIDIA GPU and its driver, or take device='cpu'"
    )


def march_of_shape(name: str, K: int) -> Callable[..., int]:
    """The march of a shape, called as `march_K` of its module for a CPU."""
    kernel = single.here(_march_of_shape(name, K)).march

    def march(C: Array, x: Array, before: Array, *rest: Any) -> int:
        *F, forces, start, n, stride, out, peak_u, peak_v, peak_a, begin = rest
        common, peaks = not forces.size, (peak_u, peak_v, peak_a)
        loads = np.stack([f[:n] for f in F])[..., None] if common else forces
        rows = range(start // stride + 1, n // stride + 1) if len(out) else range(0)
        each = len(C) + len(x) + 3 * (rows.stop + 1) + (0 if common else loads[:, :, 0].size)
        for some in _parts(0, x.shape[1], 8 * each, loads.nbytes if common else 0):
            of_lanes, among = loads if common else loads[:, :, some], slice(begin + some.start, begin + some.stop)
            state, lanes = _there(x[:, some]), some.stop - some.start
            made, largest = _room((rows.stop, 3, lanes)), _room((3, lanes if peak_u.size else 0))
            _launch(kernel, lanes, _there(C[:, some]), state, _there(of_lanes), start, n, stride, made, largest)
            x[:, some] = state.copy_to_host()
            if rows:
                out[rows.start : rows.stop, :, among] = made.copy_to_host()[rows.start :]
            for row, found, first in zip(peaks if peak_u.size else (), largest.copy_to_host(), before, strict=False):
                row[among] = np.maximum(found, np.abs(first[some]))
        return int((~np.isfinite(x)).sum())

    return march


def peaks_of_filter(order: int, followed: int) -> Callable[..., None]:
    """The peaks of digital filters, called as `peaks_...` of the module for a CPU."""
    kernel = single.here(_peaks_of_filter(order, followed)).peaks

    def peaks(T: Array, f: Array, peak: Array, first: int, last: int) -> None:
        load = _there(f)
        for some in _parts(first, last, 8 * (len(T) + len(peak)), 0):
            lanes = some.stop - some.start
            largest = _room((followed, lanes))
            _launch(kernel, lanes, _there(T[:, some]), load, largest)
            peak[:, some] = largest.copy_to_host()

    return peaks


def march_of_pair(scheme: Any, scene: Any, names: Sequence[str]) -> Callable[..., None]:
    """The march of a scheme on a scene, called as `march` of the pair's module for a CPU; names: of its arguments."""
    return _of_lanes(single.here(_march_of_pair(scheme, scene)).march, names)


def adaptive_march(
    scheme: Any, scene: Any, terms: Any, order: int, always: bool, names: Sequence[str]
) -> Callable[..., None]:
    """The march in steps that lanes choose, called as that of the module for a CPU; names: of its arguments."""
    return _of_lanes(_adaptive_march(scheme, scene, terms, order, always, threads=True).march, names)


def _of_lanes(kernel: Any, names: Sequence[str]) -> Callable[..., None]:
    """A kernel that takes these arguments, called with arrays on the CPU, of which the results are written."""

    def march(*given: Any) -> None:
        lanes = len(given[names.index("status")])
        own = [_is_array(x) and len(x) == lanes and name not in SHARED for x, name in zip(given, names, strict=True)]
        each = sum(x[:1].nbytes for x, is_own in zip(given, own, strict=True) if is_own)
        for some in _parts(0, lanes, each, 0):
            here = [x[some] if is_own else x for x, is_own in zip(given, own, strict=True)]
            there = [_there(x) if _is_array(x) else x for x in here]
            _launch(kernel, some.stop - some.start, *there)
            for name, x, result in zip(names, here, there, strict=True):
                if name in RESULTS:
                    x[...] = result.copy_to_host()

    return march


def _parts(first: int, last: int, each: float, common: float) -> Iterable[slice]:
    """Ranges of lanes that the device's memory can hold, of `each` bytes a lane besides those that they have in common.

    Raises MemoryError if it cannot hold one.
    """
    free = numba_cuda().current_context().get_memory_info().free
    together = int(min((SHARE * free - common) / max(each, 1), last - first))
    if together < 1 and last > first:
        raise MemoryError(
            f"expected a lane to fit in the device's memory, got {(each + common) / 1e9:.3g} GB, of "
            f"{free / 1e9:.3g} GB free; keep fewer samples, 'peak' or 'final', or take device='cpu'"
        )
    for begin in range(first, last, max(together, 1)):
        yield slice(begin, min(begin + together, last))


def _is_array(x: Any) -> bool:
    return isinstance(x, np.ndarray)


def _there(x: Array) -> Any:
    """A copy of an array in the device's memory, of floats in the precision of kernels here."""
    return numba_cuda().to_device(np.ascontiguousarray(single.rounded(x) if x.dtype == np.float64 else x))


def _room(shape: tuple[int, ...]) -> Any:
    """Room for an array of floats in the device's memory."""
    return numba_cuda().device_array(shape, np.float32 if single.is_on() else np.float64)


def _launch(kernel: Any, lanes: int, *arguments: Any) -> None:
    """Run a kernel in a thread for each lane."""
    from numba.core.errors import NumbaPerformanceWarning  # noqa: PLC0415

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NumbaPerformanceWarning)  # of few lanes, which were asked for
        kernel[-(-lanes // THREADS), THREADS](*arguments)
