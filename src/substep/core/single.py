"""Kernels in single precision: the same texts and calls as those in double, with twice the lanes in a vector register.

What runs inside `on` takes them. Arrays stay float64 but for loads, which are rounded here; coefficients are rounded
where a kernel reads them.
"""

import math
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from types import ModuleType
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..derived import modules
from .arrays import Array
from .errors import unknown_name, warn

Dtype = Literal["float64", "float32"]

COMPARED = 64  # runs that are made in double precision too, and as many of those that failed
FEWEST = 3  # digits without a warning
MOST = 7  # digits that a number in single precision has
# Newton's iteration ends at a correction of u smaller than this times the scene's length, 84 times the rounding of a
# number of that size: smaller ones may come and go without end. What a correction leaves is about its square
TOLERANCE = 1e-5

_on: ContextVar[bool] = ContextVar("single", default=False)
_single = cache(modules.in_single_precision)


@contextmanager
def on(dtype: Dtype) -> Generator[None]:
    """Marches called inside run in that precision."""
    token = _on.set(dtype == "float32")
    try:
        yield
    finally:
        _on.reset(token)


def is_on() -> bool:
    """Whether marches run in single precision here."""
    return _on.get()


def require_possible(dtype: Dtype | str, refused: Mapping[str, bool]) -> None:
    """Raise ValueError for another dtype, and for float32 with what there are no kernels for, the first that is."""
    if dtype not in get_args(Dtype):
        raise unknown_name("dtype", str(dtype), get_args(Dtype))
    for what, asked in refused.items():
        if asked and dtype == "float32":
            raise ValueError(f"expected dtype='float64' {what}, got 'float32'; leave dtype out")


def here(module: ModuleType) -> ModuleType:
    """A module of kernels as it is, or the same in single precision where that is asked for."""
    return _single(module) if _on.get() else module


def rounded(x: Array) -> Any:
    """An array as it is, or as float32 where single precision is asked for."""
    return rounding()(x)


def rounding() -> Callable[[Array], Any]:
    """What `rounded` does here, for other threads too."""
    return (lambda x: x.astype(np.float32)) if _on.get() else (lambda x: x)


def sample(runs: NDArray[np.int64], failed: NDArray[np.int64]) -> NDArray[np.int64]:
    """Runs to be made in double precision too: COMPARED of all, evenly, and as many of those that failed."""
    of_each = (x[np.linspace(0, len(x) - 1, min(len(x), COMPARED)).astype(int)] for x in (runs, failed))
    return np.union1d(*of_each)


def largest_error(single: Array, double: Array, scale: Any) -> float:
    """Largest modulus of the difference, over a scale that broadcasts; inf where only one of two is finite."""
    same = (single == double) | (np.isnan(single) & np.isnan(double))
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.where(same, 0.0, np.abs(single - double) / scale)
    return float(np.where(np.isnan(error), np.inf, error).max(initial=0.0))


def report(errors: Mapping[str, float], compared: int, differ: int) -> dict[str, Any]:
    """Attributes of a Dataset in single precision: digits that remain, of so many runs compared, so many that differ.

    errors: the largest relative one of each variable. Warns where fewer than FEWEST digits remain, or a run ended
    otherwise than in double precision.
    """
    worst = max(errors, key=errors.__getitem__)
    digits = min(map(digits_of, errors.values()))
    if digits < FEWEST or differ:
        warn(
            f"float32 leaves {digits} digits of {worst}, and {differ} of {compared} runs ended otherwise than in "
            "float64; take dtype='float64', or see float32_error in the attrs of each variable"
        )
    return {"dtype": "float32", "float32_digits": digits, "float32_compared": compared, "float32_differ": differ}


def digits_of(error: float) -> int:
    """Decimal digits that remain at a relative error, 0 to MOST."""
    return MOST if error == 0.0 else int(np.clip(-math.log10(error), 0, MOST)) if math.isfinite(error) else 0


def scale_of(double: Array, by_run: bool) -> Array | float:
    """Largest modulus of finite values (runs, ...) of each run, or of all."""
    size = np.where(np.isfinite(double), np.abs(double), 0.0)
    if by_run:
        return size.max(axis=tuple(range(1, size.ndim)), keepdims=True, initial=0.0)
    return float(size.max(initial=0.0))
