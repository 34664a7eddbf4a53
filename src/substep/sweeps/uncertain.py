"""What uncertain parameters make of the results: statistics over the draws of a sweep, and Sobol' indices."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..core.arrays import Array, named
from ..core.errors import called_as, inside, unknown_name, whole
from ..core.outcome import STATUSES
from ..structures.structure import Structure
from . import sweep
from .draws import along_draw, is_distribution, points, quantiles, require_drawable

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

    from ..core.scenes import Scene
    from ..core.schemes import Scheme
    from ..derived.modules import Declaration, SceneDeclaration

COMPLETED = STATUSES.index("completed")
OF_THE_RUN = {"newton_iterations", "t_failed"}  # floats that say how a run went
RESAMPLES, CONFIDENCE = 999, 0.95


@called_as("uncertainty(ds)")
def uncertainty(ds: Dataset, percentiles: ArrayLike = (5, 50, 95)) -> Dataset:
    """Statistics over the draws of uncertain parameters, of a sweep's results and of variables that you add to them.

    ds: of `substep.sweep`, with a dimension "draw". Each variable of floats along it, but for what says how a run went,
    gets a dimension "statistic" in its place: "mean", "standard_error" of the mean, "standard_deviation",
    "percentile_5" and so on, all in the unit of the variable. They are of the runs that completed: "completed" is their
    number and "failed" the share of the others, with those not made where the sweep was stopped. Where a completed run
    has NaN, so have the statistics.

    The standard error is that of the means of the replicates, each scrambled by itself (`replicate` along "draw"); with
    16 of them the mean is off by less than 2.13 standard errors in 95 % of cases, if replicates' means are normally
    distributed. Draws of your own, which have no replicates, are taken as independent: it is the standard deviation
    over the square root of their number.

    Raises ValueError for a Dataset without draws or status, and for percentiles outside of 0 to 100.

    >>> import scipy.stats
    >>> omega = scipy.stats.norm(2.0, 0.1)
    >>> ds = ss.sweep("linear_oscillator", "newmark", dt=0.1, t_end=1.0, u0=1.0, omega=omega, samples=2**8)
    >>> u = ss.uncertainty(ds).u.sel(coordinate="u")
    >>> [round(float(u.sel(statistic=name)), 2) for name in ("mean", "standard_deviation")]
    [-0.41, 0.09]
    """
    from xarray import broadcast  # noqa: PLC0415 (on first use)

    if "draw" not in getattr(ds, "dims", ()) or "status" not in ds:
        raise ValueError(
            f"expected the Dataset of a sweep with a dimension draw and its status, got {type(ds).__name__} without; "
            "give that of distributions, whole, or name a dimension of your own draws so: ds.rename(structure='draw')"
        )
    q = np.atleast_1d(inside("percentiles", percentiles, 0.0, 100.0, False, False))
    replicate = ds["replicate"].values if "replicate" in ds.coords else np.arange(ds.sizes["draw"])
    ds = ds.isel(draw=np.argsort(replicate, kind="stable"))  # draws may have been sorted by something else
    completed, replicate = ds["status"] == COMPLETED, np.sort(replicate)
    starts = np.flatnonzero(np.diff(replicate, prepend=-1))
    found: dict[str, Any] = {}
    for name, variable in ds.data_vars.items():
        if "draw" in variable.dims and variable.dtype.kind == "f" and name not in OF_THE_RUN:
            x, made = (array.transpose("draw", ...) for array in broadcast(variable, completed))
            dims = "statistic", *map(str, x.dims[1:])
            found[str(name)] = named(dims, _statistics(x.values, made.values, starts, q), variable.attrs)
    made_of = {"units": "1", "long_name": "runs that completed, which statistics are of"}
    failed_of = {"units": "1", "long_name": "share of the runs that did not complete"}
    found["completed"] = completed.sum("draw").assign_attrs(made_of)
    found["failed"] = (~completed).mean("draw").assign_attrs(failed_of)
    names = ["mean", "standard_error", "standard_deviation", *(f"percentile_{x:g}" for x in q)]
    rest = ds.drop_vars([*ds.data_vars, *(name for name, x in ds.coords.items() if "draw" in x.dims)])
    return rest.assign_coords(statistic=np.array(names, dtype=object)).assign(found)


def _statistics(x: Array, made: NDArray[np.bool_], starts: NDArray[np.int64], q: Array) -> Array:
    """Mean, its standard error, standard deviation, percentiles q of x (N, ...) where it was made: (3 + len(q), ...).

    starts: the first draw of each replicate.
    """
    n, replicates = made.sum(axis=0), np.logical_or.reduceat(made, starts, axis=0).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(made, x, 0.0).sum(axis=0) / n
        off = np.where(made, x - mean, 0.0)
        of_replicates = np.add.reduceat(off, starts, axis=0)  # each its number of runs times (its mean - the mean)
        error = np.sqrt(replicates / (replicates - 1) * (of_replicates**2).sum(axis=0)) / n
        deviation = np.sqrt((off**2).sum(axis=0) / np.maximum(n - 1, 0))
    ordered = np.sort(np.where(made, x, np.nan), axis=0)  # NaN is last
    at = q.reshape(-1, *(1,) * n.ndim) / 100.0 * np.maximum(n - 1, 0)
    low = at.astype(np.int64)
    below, above = (np.take_along_axis(ordered, k, axis=0) for k in (low, np.minimum(low + 1, np.maximum(n - 1, 0))))
    between = np.where(np.isnan(mean), np.nan, below + (at - low) * (above - below))
    return np.concatenate([[mean, error, deviation], between])


@called_as('sobol_indices("duffing", "bathe", "u", dt=0.01, t_end=10.0, u0=scipy.stats.norm(1.0, 0.1), k=...)')
def sobol_indices(
    scene: Scene | str | SceneDeclaration,
    scheme: Scheme | str | Declaration,
    quantity: str | Callable[[Dataset], DataArray],
    *,
    samples: int = 2**10,
    seed: int = 0,
    **arguments: Any,
) -> Dataset:
    """Which uncertain parameter the variance of a result comes from: Sobol' indices, by SciPy.

    scene, scheme, arguments: as in `substep.sweep`, with distributions of `scipy.stats` for d >= 2 parameters, which
    are independent. quantity: the name of a variable of that sweep, such as "u" or "peak_u", or a function of its
    Dataset that returns a DataArray along "draw", with any further dimensions; with keep="history" indices are those
    over time. samples: N, a power of 2; one sweep of N (d + 2) runs is made. seed: of the scrambling of the points.

    Returns a Dataset over "parameter" and the further dimensions of the quantity: first_order, the share of its
    variance that the parameter alone accounts for, and total, the share with all its interactions; of additive results
    they are equal and add up to 1. first_order_interval and total_interval, over bound ("low", "high") too, hold 95 %
    of 999 bootstrap resamples, which take points as independent, so that they are rather too wide. Where the quantity
    does not vary all are NaN. Estimates by A. Saltelli et al., Comput. Phys. Commun. 181, 259-270, 2010, as in
    `scipy.stats.sobol_indices`, of N points each: below 0 or above 1 by chance.

    Raises ValueError as `substep.sweep` does, for fewer than two distributions and for a quantity without draws or with
    values that are not finite; RuntimeError, with the sweep as its `dataset`, where a run did not complete.

    >>> import scipy.stats
    >>> given = {"u0": scipy.stats.norm(1.0, 0.1), "v0": scipy.stats.norm(0.0, 0.2)}
    >>> call = {"dt": 0.1, "t_end": 1.0, "omega": 1.0, "samples": 2**8}
    >>> found = ss.sobol_indices("linear_oscillator", "newmark", "u", **call, **given)
    >>> found.first_order.sel(coordinate="u").values.round(1).tolist()
    [0.1, 0.9]
    """
    require_drawable(isinstance(scene, Structure | list | tuple), dt=arguments.get("dt"), tol=arguments.get("tol"))
    uncertain = {name: x for name, x in arguments.items() if is_distribution(x)}
    d, N = len(uncertain), whole("samples", samples, 2, "points", "give a power of 2, such as samples=2**10")
    if d < 2 or N & (N - 1):
        got = f"{d} of them" if d < 2 else f"samples = {N}"
        raise ValueError(
            f"expected distributions of two or more parameters and a power of 2 for samples, got {got}; "
            + ("one has all of the variance" if d == 1 else f"give samples={1 << (N.bit_length() - 1)}")
        )
    (cube,) = points([N], 2 * d, seed)
    designs: dict[str, Any] = {}
    for k, (name, x) in enumerate(uncertain.items()):
        rows = np.tile(quantiles(name, x, cube[:, k]), (d + 2, 1))  # designs A, B, and A with one parameter from B
        rows[[1, 2 + k]] = quantiles(name, x, cube[:, d + k])
        designs[name] = along_draw(rows.ravel(), x)
    ds = sweep(scene, scheme, **{name: x for name, x in arguments.items() if name not in designs}, **designs)
    if failed := int((ds["status"] != COMPLETED).sum()):
        error = RuntimeError(
            f"expected every run to complete, as all are needed, {failed} of {ds['status'].size} did not; see the "
            "status in the attribute `dataset` of this exception, and take narrower distributions or another step"
        )
        error.dataset = ds  # type: ignore[attr-defined]
        raise error
    y = _of_quantity(ds, quantity).transpose("draw", ...)
    f = np.moveaxis(np.asarray(y.values, dtype=np.float64).reshape(d + 2, N, -1), 1, 2)  # (d + 2, s, N)
    shape = (d, *y.shape[1:])
    indices, bounds = (np.swapaxes(x, -1, -2).reshape(*x.shape[:-2], *shape) for x in _indices(f, seed))
    dims = "parameter", *map(str, y.dims[1:])
    found: dict[str, Any] = {}
    for k, (name, text) in enumerate({"first_order": "alone", "total": "with its interactions"}.items()):
        about = {"units": "1", "long_name": f"share of the variance from the parameter {text}"}
        found[name] = named(dims, indices[k], about)
        found[f"{name}_interval"] = named(("bound", *dims), bounds[:, k], about | {"confidence": CONFIDENCE})
    others = (name for name, x in ds.coords.items() if name not in y.coords or "draw" in x.dims)
    rest = ds.drop_vars([*ds.data_vars, *others])
    of_y = {name: x for name, x in y.coords.items() if "draw" not in x.dims}
    labels = {"parameter": np.array([*uncertain], dtype=object), "bound": np.array(["low", "high"], dtype=object)}
    return rest.assign_coords(of_y | labels).assign(found).assign_attrs(samples=N, seed=seed)


def _of_quantity(ds: Dataset, quantity: Any) -> DataArray:
    """The quantity of each draw. Raises ValueError for one that the sweep does not have, or that is not finite."""
    from xarray import DataArray  # noqa: PLC0415 (on first use)

    if isinstance(quantity, str) and quantity not in ds.data_vars:
        raise unknown_name("a variable of the sweep as quantity", quantity, [*map(str, ds.data_vars)])
    y = quantity(ds) if callable(quantity) else ds[quantity]
    if not isinstance(y, DataArray) or y.sizes.get("draw") != ds.sizes["draw"]:
        got = f"dimensions {y.dims}" if isinstance(y, DataArray) else type(y).__name__
        raise ValueError(f"expected of quantity a DataArray along draw, with each draw, got {got}; return such a one")
    if not np.isfinite(y.values).all():
        raise ValueError("expected a quantity with finite values, got NaN or infinity; choose one that each run has")
    return y


def _indices(f: Array, seed: int) -> tuple[Array, Array]:
    """First-order and total indices (2, s, d) of values f (d + 2, s, N), and the ends of their intervals (2, 2, s, d).

    NaN stands where values do not vary.
    """
    from scipy.stats import bootstrap, sobol_indices  # noqa: PLC0415 (on first use)

    d, s, N = len(f) - 2, *f.shape[1:]

    def of(which: NDArray[np.int64]) -> Array:
        some = f[..., which]
        found = sobol_indices(func={"f_A": some[0], "f_B": some[1], "f_AB": some[2:]}, n=N)
        return np.array([found.first_order, found.total_order]).reshape(2, s, d)

    every, made = np.arange(N), {"vectorized": False, "method": "percentile", "n_resamples": RESAMPLES}
    interval = bootstrap(
        [every], of, **made, confidence_level=CONFIDENCE, random_state=np.random.default_rng(seed)
    ).confidence_interval
    varies = np.ptp(f[:2], axis=(0, 2))[:, None] > 0
    indices, bounds = of(every), np.array([interval.low, interval.high])
    return np.where(varies, indices, np.nan), np.where(varies, bounds, np.nan)
