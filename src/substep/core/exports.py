"""A response as a Dataset of xarray's and a DataFrame of pandas'; `history_figure` draws it."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, cast

import numpy as np

from .arrays import Array, named
from .errors import called_as

if TYPE_CHECKING:
    from pandas import DataFrame

    from .result_dataset import ResultDataset


class History(NamedTuple):
    """A quantity over the rows of a response: values (n+1,), or (n+1, k) with k columns; unit may be empty."""

    values: Array
    unit: str
    meaning: str


class Histories(NamedTuple):
    """All there is to export. columns: names of the k; dimension: what they are; attrs: what all rows share."""

    t: Array
    quantities: Mapping[str, History]
    columns: Sequence[Any]
    dimension: str
    attrs: Mapping[str, Any]


class Exported:
    """A result that can be kept in a file, as a Dataset of its numbers, its arrays, and rows by a mapping's keys.

    axes: of arrays and of mappings the names of their axes; also of properties that belong to it. A tuple of records,
    each with a mapping `columns`, becomes one array along its axis for each of these.
    """

    axes: ClassVar[Mapping[str, tuple[str, ...]]] = {}

    def to_xarray(self) -> "ResultDataset":
        """Its numbers and arrays, with texts as attributes; what is None, or is a handle, is left out."""
        from .result_dataset import ResultDataset  # noqa: PLC0415 (loads xarray)

        variables: dict[str, Any] = {}
        attrs: dict[str, str] = {}
        own = (f.name for f in fields(cast("Any", self)) if not f.name.startswith("_"))
        for name in dict.fromkeys([*own, *self.axes]):
            x, axes = getattr(self, name), self.axes.get(name, ())
            if isinstance(x, Mapping) and x:
                rows = cast("Mapping[Any, Any]", x)
                variables[axes[0]] = named(axes[0], np.array(list(rows)), {})
                x = list(rows.values())
            records = cast("tuple[Any, ...]", x) if isinstance(x, tuple) else ()
            if rows := [r.columns for r in records if hasattr(r, "columns")]:
                variables |= {key: named(axes, np.array([row[key] for row in rows]), {}) for key in rows[0]}
            elif isinstance(x, str):
                attrs[name] = x
            elif (values := np.array(x)).dtype.kind in "iufU" and values.size:
                variables[name] = named(axes, values, {})
        return ResultDataset(variables, attrs=attrs)

    def save(self, path: str | Path) -> None:
        """Write `to_xarray` to a netCDF file, which `substep.load` reads; OSError where that cannot be done."""
        self.to_xarray().save(path)


def to_dataset(found: Histories) -> "ResultDataset":
    """Quantities over t and the columns, with units and meanings as attributes."""
    from .result_dataset import ResultDataset  # noqa: PLC0415 (loads xarray)

    variables: dict[str, Any] = {}
    for name, (values, unit, meaning) in found.quantities.items():
        attrs = {"units": unit, "long_name": meaning} if unit else {"long_name": meaning}
        variables[name] = named(("t", found.dimension)[: values.ndim], values, attrs)
    whole = all(isinstance(x, int | np.integer) for x in found.columns)
    labels = np.array(found.columns, dtype=np.int64 if whole else object)
    coordinates = {
        "t": named("t", found.t, {"units": "s", "long_name": "time"}),
        found.dimension: named(found.dimension, labels, {}),
    }
    return ResultDataset(variables, coordinates, dict(found.attrs))


@called_as('load("response.nc")')
def load(path: str | Path) -> "ResultDataset":
    """The Dataset of a netCDF file that `save` of a response, a sweep, a spectrum or any other result has written.

    That of a response goes on by `march(start=)`. Raises OSError for a file that cannot be read, and ValueError for one
    that is not netCDF.

    >>> ss.march("duffing", "bathe", dt=0.1, t_end=1.0).save("duffing.nc")
    >>> found = ss.load("duffing.nc")
    >>> found.attrs["scheme"], dict(found.u.sizes)
    ('bathe', {'t': 11, 'coordinate': 1})
    """
    import xarray  # noqa: PLC0415 (on first use)

    from .result_dataset import ResultDataset  # noqa: PLC0415 (loads xarray)

    try:
        found = xarray.load_dataset(path, engine="scipy")  # pyright: ignore[reportUnknownMemberType]
        return ResultDataset.of_file(found)
    except (TypeError, ValueError) as error:
        raise ValueError(f"expected a netCDF file, got {path}: {error}; write one by Response.save") from error


def to_frame(found: Histories) -> "DataFrame":
    """A row for each time, a column for each quantity of each of the k, such as "u x". Raises ImportError."""
    try:
        import pandas  # noqa: PLC0415 (needed here alone)
    except ImportError as error:
        raise ImportError(
            "expected pandas for to_pandas(), which is not installed; pip install pandas, or take to_xarray()"
        ) from error
    columns = {label: values for name in found.quantities for label, values in curves_of(found, name)}
    return pandas.DataFrame(columns, index=pandas.Index(found.t, name="t"))


def curves_of(found: Histories, name: str) -> list[tuple[str, Array]]:
    """A quantity's curves (n+1,) with labels; the quantity's name alone where there is one curve."""
    values = found.quantities[name].values
    if values.ndim == 1:
        return [(name, values)]
    alone = values.shape[1] == 1
    return [(name if alone else f"{name} {c}", values[:, i]) for i, c in enumerate(found.columns)]
