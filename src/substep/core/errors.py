"""Messages that say what was expected, what came, and the cure."""

import inspect
import math
import re
import sys
import warnings
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from difflib import SequenceMatcher, get_close_matches
from functools import wraps
from importlib import import_module
from operator import index
from types import ModuleType
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

FEW = 8  # names that are listed before what came
MANY = 25  # names beyond which a message lists the nearest alone
NEAREST = 5
CALLED = {  # what people write, and what it is here: the first of these that is a name here; {} is what they wrote
    "zeta xi damping damping_ratio": (
        "xi, the damping ratio",
        "C, as ss.modal_damping(...) or ss.rayleigh(...) makes it of damping ratios",
        "xi_1 and xi_2, the damping ratios at both frequencies",
    ),
    "c": ("xi = c/(2 sqrt(k m))",),
    "k": ("omega = sqrt(k/m)",),
    "m": ("omega = sqrt(k/m), the load per unit of mass",),
    "T period": (
        "periods, in s",
        "T, in s",
        "omega = 2 pi/{}",
        "t_end",
        "duration, of the pulse: half a period of its sine",
    ),
    "f freq freqs frequency osc_freqs natural_frequency": (
        "frequencies, in Hz",
        "f, in Hz",
        "omega = 2 pi {}",
        "T = 1/{}",
        "load, pairs of a vector and a function of time",
        "duration = 1/(2 {}), of the pulse",
    ),
    "omega w wn w0 omega_n omega_0": ("omega, in rad/s", "periods = 2 pi/{}", "T = 2 pi/{}", "duration = pi/{}"),
    "F P force": ("load, pairs of a vector and a function of time",),
    "x0": ("u0",),
    "h step time_step delta_t": ("dt",),
    "fs sampling_rate sampling_frequency": ("dt = 1/{}",),
    "units": ("unit",),
    "tf tmax t_final duration": ("t_end",),
    "n steps n_steps nsteps num_steps": ("t_end = {} dt",),
    "t": ("dt and t_end, the step and the end",),
    "tspan t_span": ("t_end, as runs begin at t = 0",),
    "delta": ("gamma, which Bathe's books call delta",),
    "alpha_f": ("alpha = -alpha_f, the paper's, from -1/3 to 0",),
    "alpha": (
        "alpha_f = -alpha, for HHT's alpha with alpha_m = 0",
        "alpha_B, the paper's, below 0",
        "beta, which Bathe's books call alpha",
    ),
    "spectral_radius spectralRadius radius": ("rho_inf, the spectral radius at infinity",),
}
WRITTEN = {name: ours for names, ours in CALLED.items() for name in names.split()}
P = ParamSpec("P")
T = TypeVar("T")


def unknown_name(what: str, name: str, known: Iterable[str], lists: str = "") -> ValueError:
    """The error for a name that is not among the known ones; it names the nearest of them.

    lists: what lists them all, where they are many.
    """
    known = tuple(known)
    cure = _cure(name, known)
    if len(known) > MANY:
        near = f" near are: {', '.join(close)};" if (close := _nearest(name, known, cutoff=0.5)) else ""
        text = f"expected {what}, got '{name}'{cure};{near} {lists or f'there are {len(known)}'}"
        return ValueError(text.replace("?;", "?"))
    if len(known) > FEW:
        return ValueError(f"expected {what}, got '{name}'{cure}; known are: {', '.join(known)}".replace("?;", "?"))
    return ValueError(f"expected {what}, one of: {', '.join(known) or 'none'}; got '{name}'{cure}")


def meant(name: str, known: Iterable[str]) -> str:
    """What a name that people write is among the known ones, in words that begin with that; "" for none of them."""
    ours = (text.format(name) for text in WRITTEN.get(name, ()))
    return next((text for text in ours if re.split(r"\W", text)[0] in set(known)), "")


def _cure(name: str, known: Collection[str]) -> str:
    """What follows a name that is not known: what it is here, or the nearest; nothing for one without any."""
    if how := meant(name, known):
        return f"; here it is {how}"
    close = _nearest(name, known, cutoff=0.6)
    begin = [x for x in close if _plain(x).startswith(_plain(name))]
    if not begin or _plain(close[0]) == _plain(name):
        begin = close[:1]
    return f"; did you mean {' or '.join(map(repr, begin))}?" if 0 < len(begin) < NEAREST else ""


def _nearest(name: str, known: Iterable[str], cutoff: float) -> list[str]:
    """At most five names that begin so, then those that are spelt alike, capitals and underscores apart."""
    spelt = {_plain(x): x for x in reversed(tuple(known))}
    asked = _plain(name)
    begin = sorted(x for x in spelt if asked and x.startswith(asked) and (len(asked) > 1 or len(x) < 4))
    alike = get_close_matches(asked, spelt, n=NEAREST, cutoff=cutoff)
    alike.sort(key=lambda x: abs(len(x) - len(asked)) / 20 - SequenceMatcher(None, x, asked).ratio())
    return [spelt[x] for x in dict.fromkeys((*sorted(begin, key=len), *alike))][:NEAREST]


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name.lower())


def warn(message: str) -> None:
    """Warn of the line that called this package, or one that extends it, whatever of their functions lies between."""
    level, frame = 1, sys._getframe()  # pyright: ignore[reportPrivateUsage]
    while frame is not None and _of_ours(frame.f_globals):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, stacklevel=level)


def _of_ours(module: Mapping[str, Any]) -> bool:
    """Whether the names of a module are those of one in this package, or in one whose name begins so, as of extras/."""
    package = str(module.get("__package__") or "").partition(".")[0]
    return package == "substep" or package.startswith("substep_")


def optional(package: str, what_for: str, extra: str) -> ModuleType:
    """A package that only some users need, imported. Raises ImportError, with the cure, where it is not installed."""
    try:
        return import_module(package)
    except ModuleNotFoundError as error:
        raise ImportError(
            f"expected {package} for {what_for}, got none installed; pip install 'substep[{extra}]'"
        ) from error


def called_as(example: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """A function that answers a call which does not fit its arguments with an example of one that does.

    It is a TypeError, as it is in Python: for arguments by position that have to be given by name, for missing ones and
    for names that the function does not take.
    """

    def of(function: Callable[P, T]) -> Callable[P, T]:
        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> T:
            try:
                return function(*args, **kwargs)
            except TypeError as error:
                if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                    raise  # the function was entered, so that the error is not of this call
                raise TypeError(f"expected a call such as {example}; {_misfit(function, args, kwargs)}") from None

        return called

    return of


def _misfit(function: Callable[..., Any], args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> str:
    """What is wrong with arguments that do not fit a function, and those that do."""
    takes = inspect.signature(function)
    by_name = [name for name, p in takes.parameters.items() if p.kind is p.KEYWORD_ONLY]
    others = [f"**{p.name}" for p in takes.parameters.values() if p.kind is p.VAR_KEYWORD]
    at_first = [name for name, p in takes.parameters.items() if p.kind is p.POSITIONAL_OR_KEYWORD and name != "self"]
    unknown = [] if others else [name for name in kwargs if name not in takes.parameters]
    try:
        takes.bind(*args, **kwargs)
    except TypeError as error:
        cures = [f"got an unexpected keyword argument '{x}'{_cure(x, [*at_first, *by_name])}" for x in unknown]
        named = ", ".join([*by_name, *others]) or "none"
        said = f"{'; '.join(cures) or error}; it takes {', '.join(at_first)} and, by name only, {named}"
        return said.replace("?;", "?")
    return "it takes other arguments"


def made_as(example: str) -> Callable[[type[T]], type[T]]:
    """A class that answers a call which does not fit as a function does that is `called_as` the example."""

    def of(made: type[T]) -> type[T]:
        made.__init__ = called_as(example)(made.__init__)
        return made

    return of


def float_array(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The value as a float array, else a ValueError: also for a mask or imaginary parts, which would be lost."""
    if isinstance(value, np.ndarray) and isinstance(value, np.ma.MaskedArray):
        raise ValueError(
            f"expected {name} without a mask, got a masked array; choose its values by .compressed() or .filled(...)"
        )
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "bcSU":  # truth values and text are not what was meant
            return array.astype(np.float64, copy=False)
    except (TypeError, ValueError) as error:
        raise ValueError(f"expected {name} to be a real number or an array of them, got {value!r}") from error
    if array.dtype.kind == "c":
        raise complex_numbers(name)
    raise ValueError(f"expected {name} to be a real number or an array of them, got {value!r}; give numbers")


def complex_numbers(name: str) -> ValueError:
    """The error for complex numbers, whose imaginary part would be lost."""
    return ValueError(f"expected {name} to be real, got complex numbers; give its real part if that is meant")


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
        raise ValueError(f"expected one number for {name}, got shape {array.shape}; give one, or call once for each")
    if positive and array <= 0:
        raise ValueError(f"expected {name} > 0, got {float(array)}; give a positive value")
    return float(array)


def whole(name: str, value: Any, least: int, of: str, cure: str) -> int:
    """The value as a whole number, else a ValueError: also for one below the least. of: what it counts, or nothing."""
    with suppress(TypeError):
        if not isinstance(value, bool) and index(value) >= least:
            return index(value)
    counted = f" of {of}" if of else ""
    raise ValueError(f"expected {name} to be a whole number{counted} >= {least}, got {value!r}; {cure}")


def number_or_row(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The value as a finite number () or a row of them (n,), for an axis of a sweep, else a ValueError."""
    array = real_array(name, value)
    if array.ndim > 1:
        raise ValueError(f"expected {name} to be a number or a row of them, got shape {array.shape}; give an axis each")
    return array


def damping_ratio(name: str, value: ArrayLike, *, overdamped: bool | None = None) -> NDArray[np.float64]:
    """Damping ratios of a structure as an array, else a ValueError: also for those above 1, as of percent.

    overdamped: whether the user says that these are meant; None where that cannot be said.
    """
    ratios = non_negative(name, value)
    if not overdamped and (ratios > 1.0).any():
        largest = float(ratios.max())
        meant = "" if overdamped is None else f"; if the ratio {largest:g} is meant, add overdamped=True"
        raise ValueError(
            f"expected {name} as a ratio, at most 1, got {largest:g}; {largest:g} % is {largest / 100.0:g}{meant}"
        )
    return ratios


def inside(
    name: str, value: ArrayLike, low: float | None, high: float | None, low_open: bool, high_open: bool
) -> NDArray[np.float64]:
    """The value as an array of finite numbers in an interval, None for no bound, else a ValueError."""

    def beyond(x: Any) -> tuple[Any, Any]:
        below = low is not None and (x <= low if low_open else x < low)
        return below, high is not None and (x >= high if high_open else x > high)

    if type(value) is np.ndarray and value.dtype == np.float64 and value.size > 1:
        plain = cast("NDArray[np.float64]", value)
        ends = float(plain.min()), float(plain.max())  # both NaN where one number is
        if all(math.isfinite(x) and not any(beyond(x)) for x in ends):
            return plain  # the usual case, without temporary arrays
    array = real_array(name, value)
    below, above = beyond(array if array.ndim else float(array))  # of one number NumPy makes arrays, at more time
    if np.any(below) or np.any(above) if array.ndim else below or above:
        ends = ("-inf" if low is None else low), ("inf" if high is None else high)
        interval = f"{'(' if low_open else '['}{ends[0]}, {ends[1]}{')' if high_open else ']'}"
        worst = array[below | above].flat[0] if array.ndim else float(array)
        raise ValueError(f"expected {name} in {interval}, got {worst}; choose a value inside")
    return array


def non_negative(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """The value as an array of finite numbers not below 0, else a ValueError."""
    if type(value) is np.ndarray and value.dtype == np.float64 and value.size > 0:
        plain = cast("NDArray[np.float64]", value)
        if plain.min() >= 0 and plain.max() < np.inf:  # the usual case, without temporary arrays; NaN fails it
            return plain
    array = real_array(name, value)
    if (array < 0).any():
        raise ValueError(f"expected {name} >= 0, got {array.min()}; give non-negative values")
    return array
