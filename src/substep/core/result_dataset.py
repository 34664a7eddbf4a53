"""A Dataset of xarray's that prints in ten lines."""

from collections.abc import Hashable, Iterator
from pathlib import Path
from textwrap import wrap
from typing import Any, Self

import numpy as np
from xarray import DataArray, Dataset

from .state import State

STATE = "state "  # what the names of a run's state begin with in its file
LINES, WIDTH = 10, 100  # of the print at most
TEXT = 24  # characters of an attribute


class ResultDataset(Dataset):
    """What sweeps, spectra and `Response.to_xarray` return: any method of a Dataset applies, and gives such a one.

    It prints in ten lines at most: how many runs have completed, the axes, what there is along them, the attributes.
    xarray's own print, a line for each variable and attribute, is that of `xarray.Dataset(found.data_vars)`; notebooks
    show xarray's table.
    """

    __slots__ = ("state",)
    state: State  # where the run of a response stands; selections and the like do not have it

    def save(self, path: str | Path) -> None:
        """Write it to a netCDF file, which `substep.load` and other programs read; OSError where that cannot be done.

        The state of a run is in it as variables and attributes whose names begin with "state ".
        """
        found: Dataset = self
        if (state := getattr(self, "state", None)) is not None:
            kept = state.to_xarray()
            kept = kept.rename({name: f"{STATE}{name}" for name in {*kept.variables, *kept.dims}})
            attrs = {**self.attrs, **{f"{STATE}{name}": x for name, x in kept.attrs.items()}}
            found = Dataset({**self.data_vars, **kept.data_vars}, {**self.coords, **kept.coords}, attrs)
        found.to_netcdf(path, engine="scipy")  # pyright: ignore[reportUnknownMemberType]

    @classmethod
    def of_file(cls, found: Dataset) -> Self:
        """What `save` has written, with the state of a run apart from its histories."""
        names = {str(x) for x in (*found.variables, *found.dims) if str(x).startswith(STATE)}
        whole = found.drop_vars(names, errors="ignore")
        attrs, own = (
            {str(x): y for x, y in found.attrs.items() if str(x).startswith(STATE) == k} for k in (False, True)
        )
        made = cls(whole.data_vars, whole.coords, attrs)
        if names:
            alone = found.drop_vars(list(whole.variables)).rename({x: x.removeprefix(STATE) for x in names})
            made.state = State.of_dataset(alone.assign_attrs({x.removeprefix(STATE): y for x, y in own.items()}))
        return made

    def __repr__(self) -> str:
        rows = [row for line in self._lines() for row in wrap(line, WIDTH, subsequent_indent="  ")]
        return "\n".join(rows if len(rows) <= LINES else [*rows[: LINES - 1], "  ..."])

    def _lines(self) -> Iterator[str]:
        yield f"<{type(self).__name__} {self._subject()}>"
        if self.sizes:
            yield "axes: " + ", ".join(f"{name} {self._axis(str(name), n)}" for name, n in self.sizes.items())
        along: dict[str, list[str]] = {}
        for name, x in self.data_vars.items():
            along.setdefault(f"({', '.join(map(str, x.dims))})" if x.ndim else "numbers", []).append(_named(name, x))
        yield from (f"{axes}: {', '.join(names)}" for axes, names in along.items())
        if others := [_named(name, self[name]) for name in self.coords if name not in self.sizes]:
            yield f"besides: {', '.join(others)}"
        given = {name: _text(x) for name, x in self.attrs.items() if name not in ("scheme", "scene")}
        if shown := [f"{name} = {text}" for name, text in given.items() if text]:
            yield f"attributes: {', '.join(shown)}"

    def _subject(self) -> str:
        """Scheme and scene, as far as the attributes know them, how many runs have completed, and the size."""
        on = " on ".join(str(self.attrs[name]) for name in ("scheme", "scene") if name in self.attrs)
        status = self.get("status")
        parts = [on] if on else []
        if status is not None and status.ndim and "flag_meanings" in status.attrs:
            completed = status.attrs["flag_meanings"].split().index("completed")
            code = np.ravel(status.attrs["flag_values"])[completed]
            parts += [f"{int(np.count_nonzero(status.values == code))} of {status.size} runs completed"]
        return ", ".join([*parts, _bytes(self.nbytes)])

    def _axis(self, name: str, n: int) -> str:
        """Of an axis its length, with its values where these are few, else the first and the last, and their unit."""
        if name not in self.coords or n == 0:
            return str(n)
        values, unit = self[name].values, _unit(self[name])
        if n <= 3:
            return f"{n} ({', '.join(map(_text, values))}{unit})"
        return f"{n} ({_text(values[0])} ... {_text(values[-1])}{unit})"


def _named(name: Hashable, x: DataArray) -> str:
    """The name of a variable; of a single number its value too."""
    return str(name) if x.ndim else f"{name} = {_text(x.values[()])}{_unit(x)}"


def _unit(x: DataArray) -> str:
    unit = str(x.attrs.get("units", ""))
    return f" {unit}" if unit not in ("", "1") else ""


def _text(x: Any) -> str:
    """A number in five digits, and anything else as it prints, of a long text the beginning."""
    text = f"{x:.5g}" if isinstance(x, float | np.floating) else str(x)
    return text if len(text) <= TEXT else f"{text[: TEXT - 3]}..."


def _bytes(n: int) -> str:
    """A size in the largest unit of which it has at least one."""
    power = min(max(len(str(n)) - 1, 0) // 3, 4)
    return f"{n / 1000**power:.3g} {('B', 'kB', 'MB', 'GB', 'TB')[power]}"
