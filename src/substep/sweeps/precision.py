"""How many digits a sweep in single precision keeps: some of its runs made in double precision too."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.arrays import named
from ..core.outcome import STATUSES
from ..core.single import largest_error, report, sample, scale_of
from .scene_plan import ScenePlan
from .sweep_plan import MEANINGS, NOT_RUN

if TYPE_CHECKING:
    import xarray


def compared(plan: ScenePlan, ds: "xarray.Dataset") -> "xarray.Dataset":
    """The Dataset, in single precision, with attributes that say how runs made in double precision differ.

    Of each variable `float32_error`: the largest difference found, over the largest value of that variable in the same
    run or, where only the end of runs is kept, in all of those compared. Of the Dataset those of `report`.
    """
    status = ds["status"].to_numpy().ravel()
    made = np.flatnonzero(status != NOT_RUN)
    if not len(made):
        return ds
    points = sample(made, made[status[made] != STATUSES.index("completed")])
    double = plan.at(points)
    where = np.unravel_index(points, plan.shape) if plan.dims else ()
    some = ds[list(double)].isel({name: named("run", i, {}) for name, i in zip(plan.dims, where, strict=True)})
    errors, single = dict[str, float](), dict[str, Any]()
    for name, values in double.items():
        single[name] = some[name].to_numpy().reshape(values.shape)
        if name.removeprefix("peak_") in (*MEANINGS, "memory"):
            errors[name] = largest_error(single[name], values, scale_of(values, plan.keep != "final"))
    differ = (single["status"] != double["status"]) | (single["n_done"] != double["n_done"])
    for name, error in errors.items():
        ds[name].attrs["float32_error"] = error
    return ds.assign_attrs(report(errors, len(points), int(differ.sum())))
