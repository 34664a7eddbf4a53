"""Uncertain parameters: distributions as SciPy has them, drawn together along one dimension.

Points are those of Sobol', which fill the unit cube more evenly than random ones, scrambled at random. How exact their
mean is cannot be seen from one scrambling. So the draws are divided into replicates, each scrambled by itself, whose
means differ as independent ones do: A. B. Owen, Scrambling Sobol' and Niederreiter-Xing points, J. Complexity 14,
466-489, 1998.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.arrays import Array, named
from ..core.errors import warn, whole
from ..run.axes import Axis

if TYPE_CHECKING:
    from xarray import Variable

REPLICATES = 16
BITS = 30  # of a coordinate of a point
CURE = "take a distribution that stays inside, such as scipy.stats.truncnorm, or lognorm for what is positive"


def is_distribution(value: Any) -> bool:
    """Whether it has an inverse of its cumulative distribution function, as SciPy's older and newer ones have."""
    return callable(getattr(value, "ppf", None) or getattr(value, "icdf", None))


def require_drawable(structures: bool, *, dt: Any = None, tol: Any = None, keep: str = "final") -> None:
    """Raise ValueError for a distribution where none can be drawn."""
    if structures:
        raise ValueError(
            "expected a scene where a parameter is a distribution, got structures, whose matrices and loads have no "
            "parameters; give a list of structures, one for each draw"
        )
    for name, value in (("dt", dt), ("tol", tol)):
        if is_distribution(value):
            why = "t_end has to be a multiple of each step" if name == "dt" else "it is an error that you choose"
            raise ValueError(f"expected {name} as a number or a row, got a distribution: {why}; give {name}=[...]")
    if keep == "history":
        raise ValueError(
            "expected keep='final' or 'peak' where parameters are distributions, got 'history', whose rows samples "
            "counts; keep one of these, or draw values yourself: xarray.DataArray(values, dims='draw')"
        )


def drawn(values: Mapping[str, Any], samples: Any, seed: Any) -> tuple[dict[str, Any], "Variable"]:
    """The values with N = samples draws in place of distributions, as variables (N,) along "draw", these last.

    The replicate of each draw (N,) comes second. Raises ValueError for no such number of draws.
    """
    N = whole("samples", samples, 1, "draws", "give a power of 2, such as samples=2**12")
    uncertain = {name: x for name, x in values.items() if is_distribution(x)}
    sizes = [len(part) for part in np.array_split(np.empty(N), min(REPLICATES, N))]
    at = np.concatenate(points(sizes, len(uncertain), seed))
    draws = {name: along_draw(quantiles(name, x, u), x) for (name, x), u in zip(uncertain.items(), at.T, strict=True)}
    which = np.repeat(np.arange(len(sizes)), sizes)
    return {**{name: x for name, x in values.items() if name not in draws}, **draws}, named(
        "draw", which, {"sampler": "Sobol', each replicate scrambled by itself", "seed": int(seed)}
    )


def points(sizes: Sequence[int], d: int, seed: Any) -> list[Array]:
    """For each size n, the first n of the points of Sobol' (n, d) in (0, 1), scrambled by themselves from the seed."""
    from scipy.stats.qmc import Sobol  # noqa: PLC0415 (on first use)

    found: list[Array] = []
    seeds = np.random.SeedSequence(whole("seed", seed, 0, "", "give one")).spawn(len(sizes))
    for n, own in zip(sizes, seeds, strict=True):
        sampler = Sobol(d, bits=BITS, seed=np.random.default_rng(own))
        corners = sampler.random_base2((n - 1).bit_length())[:n]
        found.append(corners + 0.5**BITS / 2)  # the middle of its cell, so that no quantile is that of 0
    return found


def quantiles(name: str, distribution: Any, u: Array) -> Array:
    """The values of a parameter at probabilities u. Raises ValueError unless they are finite numbers, one for each."""
    inverse = getattr(distribution, "ppf", None) or distribution.icdf
    try:
        one = np.shape(inverse(0.5))
    except TypeError as error:
        raise ValueError(
            f"expected {name} as a distribution with its parameters, got {about(distribution)} without: {error}; give "
            "them, as in scipy.stats.lognorm(0.1)"
        ) from error
    if one:
        raise ValueError(
            f"expected {name} as the distribution of one number, got {about(distribution)} of shape {one}; give one of "
            "numbers, or draw values yourself: xarray.DataArray(values, dims='draw')"
        )
    with np.errstate(all="ignore"):
        values = np.asarray(inverse(u), dtype=np.float64)
    if bad := int(np.count_nonzero(~np.isfinite(values))):
        raise ValueError(
            f"expected finite draws of {name}, got {bad} of {len(u)} from {about(distribution)} that are not; {CURE}"
        )
    if not np.isfinite(_variance(distribution)):
        warn(
            f"{name} is from {about(distribution)}, of no finite variance: means, standard errors, standard deviations "
            "and Sobol' indices of what grows with it do not settle, however many draws; take percentiles, or a "
            "distribution that ends, such as scipy.stats.truncnorm"
        )
    return values


def _variance(distribution: Any) -> float:
    """That of a distribution as SciPy has them, 0 of one that does not say."""
    found = getattr(distribution, "var", None) or getattr(distribution, "variance", None)
    with np.errstate(all="ignore"):
        return float(found()) if callable(found) else 0.0


def along_draw(values: Array, distribution: Any) -> "Variable":
    """Draws (N,) of a distribution, which is named in their attributes."""
    return named("draw", values, {"distribution": about(distribution)})


def about(distribution: Any) -> str:
    """A distribution in words, such as norm(1.0, scale=0.1)."""
    family = getattr(distribution, "dist", None)
    if family is None:
        return str(getattr(distribution, "name", None) or distribution)
    given = [*map(str, distribution.args), *(f"{name}={x}" for name, x in distribution.kwds.items())]
    return f"{family.name}({', '.join(given)})"


def require_allowed(axis: Axis, check: Callable[[float], Any]) -> None:
    """Raise ValueError if the check does so for any of the draws; it says for how many."""
    refusals: list[ValueError] = []
    for x in (axis.values.min(), axis.values.max()):  # what is allowed is an interval
        try:
            check(float(x))
        except ValueError as error:
            refusals.append(error)
    if refusals:
        outside = sum(not _passes(check, float(x)) for x in axis.values)
        raise ValueError(
            f"{str(refusals[0]).partition(';')[0]}, one of {outside} of {len(axis.values)} draws of {axis.name} from "
            f"{axis.attrs['distribution']} that lie outside; {CURE}"
        )


def _passes(check: Callable[[float], Any], x: float) -> bool:
    with suppress(ValueError):
        check(x)
        return True
    return False
