"""Messages that say what was expected, what came, and the cure."""

import math
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def unknown_name(what: str, name: str, known: Iterable[str]) -> ValueError:
    """The error for a name that is not among the known ones; it names the nearest of them."""
    known = tuple(known)
    near = get_close_matches(name, known, n=1)
    cure = f"; did you mean '{near[0]}'?" if near else ""
    return ValueError(f"expected {what}, one of: {', '.join(known) or 'none'}; got '{name}'{cure}")


def float_array(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The value as a float array, else a ValueError."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"expected {name} to be a real number or an array of them, got {value!r}") from error


def real_array(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The value as a float array without NaN or infinity, else a ValueError."""
    array = float_array(name, value)
    if not (math.isfinite(array) if array.ndim == 0 else np.isfinite(array).all()):
        where = np.argwhere(~np.isfinite(np.atleast_1d(array)))[0]
        at = f" at index {tuple(int(i) for i in where)}" if array.ndim else ""
        raise ValueError(
            f"expected {name} to be finite, got {np.atleast_1d(array)[tuple(where)]}{at}; remove or replace it"
        )
    return array


def real_number(name: str, value: Any, *, positive: bool = False) -> float:
    """The value as one finite (positive) float, else a ValueError."""
    if type(value) is float and math.isfinite(value) and not (positive and value <= 0):
        return value  # the usual case, at a tenth of the time
    array = real_array(name, value)
    if array.ndim:
        raise ValueError(f"expected one number for {name}, got shape {array.shape}; give one, or march each")
    if positive and array <= 0:
        raise ValueError(f"expected {name} > 0, got {float(array)}; give a positive value")
    return float(array)


def number_or_row(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The value as a finite number () or a row of them (n,), for an axis of a sweep, else a ValueError."""
    array = real_array(name, value)
    if array.ndim > 1:
        raise ValueError(f"expected {name} to be a number or a row of them, got shape {array.shape}; give an axis each")
    return array


def require_numbers(owner: str, parameters: Mapping[str, NDArray[np.float64]], cure: str) -> None:
    """Raises ValueError, with the cure, for the first parameter that is an array."""
    for name, value in parameters.items():
        if value.ndim:
            raise ValueError(f"expected one value for {name} of {owner}, got an array; {cure}")


def inside(
    name: str, value: ArrayLike, low: float | None, high: float | None, low_open: bool, high_open: bool
) -> NDArray[np.float64]:
    """The value as an array of finite numbers in an interval, None for no bound, else a ValueError."""
    array = real_array(name, value)
    values = array if array.ndim else float(array)  # of one number NumPy makes arrays, which takes longer
    below = low is not None and (values <= low if low_open else values < low)
    above = high is not None and (values >= high if high_open else values > high)
    if np.any(below) or np.any(above) if array.ndim else below or above:
        ends = ("-inf" if low is None else low), ("inf" if high is None else high)
        interval = f"{'(' if low_open else '['}{ends[0]}, {ends[1]}{')' if high_open else ']'}"
        worst = array[below | above].flat[0] if array.ndim else float(array)
        raise ValueError(f"expected {name} in {interval}, got {worst}; choose a value inside")
    return array


def non_negative(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The value as an array of finite numbers not below 0, else a ValueError."""
    plain = isinstance(value, np.ndarray) and value.dtype == np.float64 and value.size > 0
    if plain and value.min() >= 0 and value.max() < np.inf:  # the usual case, without temporary arrays; NaN fails it
        return value
    array = real_array(name, value)
    if (array < 0).any():
        raise ValueError(f"expected {name} >= 0, got {array.min()}; give non-negative values")
    return array


def no_acceleration(scheme: str, starter: str) -> ValueError:
    """The error for a scheme with an acceleration of its own that is started by one without, off one oscillator."""
    return ValueError(
        f"expected a scheme to start {scheme} that finds an acceleration, as it does itself, got {starter}, which "
        "does so on one linear oscillator only; start it with one that carries a, such as dormand_prince"
    )
