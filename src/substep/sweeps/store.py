"""A sweep on disk: a Zarr store that is filled chunk by chunk, and completed by a later call if it was stopped.

Zarr's local store writes a file under another name and then renames it, so that a variable's chunk is either complete
or absent. The status is written last: a chunk in which no status is -1 is done.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..core.errors import optional
from .sweep_plan import NOT_RUN, Chunk, SweepPlan

if TYPE_CHECKING:
    import xarray

IGNORED = {"interrupted", "chunk"}  # attributes that may differ when a later call goes on with the sweep


class Store:
    """The store at a path, created if there is none. Raises ValueError if it holds another sweep."""

    def __init__(self, path: Path, plan: SweepPlan, template: "xarray.Dataset", piece: tuple[int, ...]) -> None:
        zarr = optional("zarr", "save=", "save")
        self.path = path
        if path.exists():
            self._check(template, tuple(plan.dims))
        else:
            _create(path, plan, template, piece)
        self.group: Any = zarr.open_group(path, mode="r+")
        self.piece: tuple[int, ...] = tuple(self.group.attrs["chunk"]) if plan.dims else ()
        self.coords = [*template.coords]
        self.targets: dict[str, Any] = {name: self.group[name] for name in plan.variables}

    def is_done(self, chunk: Chunk) -> bool:
        """Whether all of the chunk was written."""
        return bool((np.asarray(self.targets["status"][chunk.where]) != NOT_RUN).all())

    def mark(self, interrupted: bool) -> None:
        """Record in the attributes whether something is left to do."""
        self.group.attrs["interrupted"] = int(interrupted)

    def read(self) -> "xarray.Dataset":
        """The Dataset as it is on disk, whose values are read when they are used."""
        import xarray  # noqa: PLC0415 (on first use)

        from ..core.result_dataset import ResultDataset  # noqa: PLC0415

        found = xarray.open_zarr(self.path, chunks=None, consolidated=False)
        del found.attrs["chunk"]
        # as asked, since a folder lists its arrays in any order; as variables, which bring no coordinates of their own
        kept, coords = ({name: found.variables[name] for name in names} for names in (self.targets, self.coords))
        return ResultDataset(kept, coords, found.attrs)

    def _check(self, template: "xarray.Dataset", axes: tuple[str, ...]) -> None:
        import xarray  # noqa: PLC0415 (on first use)

        try:
            found = xarray.open_zarr(self.path, chunks=None, consolidated=False)
            stored = {key: value for key, value in found.attrs.items() if key not in IGNORED}
            _, axes_there = stored["declarations"], found["status"].dims
        except (OSError, KeyError, ValueError) as error:
            raise ValueError(
                f"expected a sweep or nothing at {self.path}, got something else; give another path"
            ) from error
        cure = "give save another path, or remove that one"
        asked = {key: value for key, value in template.attrs.items() if key not in IGNORED}
        for key in [*asked, *stored]:
            if key not in stored or key not in asked or stored[key] != asked[key]:
                raise ValueError(
                    f"expected the sweep that {self.path} holds, whose {key} is {stored.get(key, 'not given')}, "
                    f"got {asked.get(key, 'not given')}; {cure}"
                )
        if axes != axes_there:
            raise ValueError(f"expected axes {axes_there} as in {self.path}, got {axes}; {cure}")
        for name in (name for name, x in template.coords.items() if x.dims and set(x.dims) <= set(axes)):
            if name not in found.coords:
                raise ValueError(f"expected a sweep without {name} as in {self.path}, got it; {cure}")
            if template[name].dims != found[name].dims:
                raise ValueError(
                    f"expected {name} along {', '.join(map(str, found[name].dims))} as in {self.path}, got it along "
                    f"{', '.join(map(str, template[name].dims))}; {cure}"
                )
            here, there = template[name].values, found[name].values
            if len(here) != len(there):
                raise ValueError(f"expected {len(there)} values of {name} as in {self.path}, got {len(here)}; {cure}")
            for k in np.flatnonzero(here != there):
                raise ValueError(f"expected {name}[{k}] = {there[k]} as in {self.path}, got {here[k]}; {cure}")


def _create(path: Path, plan: SweepPlan, template: "xarray.Dataset", piece: tuple[int, ...]) -> None:
    """Create the store under another name, then rename it, so that it has all its variables or does not exist."""
    import tempfile  # noqa: PLC0415 (on first use)

    import zarr  # noqa: PLC0415

    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f"{path.name}.") as folder:
        draft = Path(folder) / "store"
        marked = template.assign_attrs(interrupted=1, chunk=list(piece))
        marked.to_zarr(draft, consolidated=False, zarr_format=3)
        group = zarr.open_group(draft, mode="r+")
        for name, of in plan.variables.items():
            group.create_array(
                name,
                shape=(*plan.shape, *of.sizes),
                chunks=(*piece, *(max(size, 1) for size in of.sizes)),
                dtype=of.fill.dtype,
                fill_value=of.fill,
                dimension_names=(*plan.dims, *of.dims),
                attributes=of.attrs,
            )
        draft.rename(path)
