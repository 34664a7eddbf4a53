"""What a sweep runs, of a scene or of a structure: points of the axes' outer product in C order, in chunks of points.

A point is one run. Plans of both have the same few methods: how points are divided into chunks, what the Dataset is to
hold, and the results of some points.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ..core.arrays import Array, named
from ..core.device import Device
from ..core.outcome import STATUSES
from ..core.single import Dtype
from ..run.axes import Asked, Axis

if TYPE_CHECKING:
    import xarray

Results = dict[str, Any]
NOT_RUN = -1
MEANINGS = {"u": "displacement", "v": "velocity", "a": "acceleration", "energy": "kinetic energy and potential"}
OF_LAWS = {"memory": "what laws remember", "elongation": "elongation of springs", "force": "force of springs"}
OF_LAWS |= {"reaction": "reactions", "gap": "gaps"}


class Chunk(NamedTuple):
    """Points first to last - 1 in C order, and where they stand in the outer product."""

    first: int
    last: int
    where: tuple[slice, ...]


class Variable(NamedTuple):
    """A variable of the Dataset: its dimensions beyond the axes, their sizes, the value before a run, attributes."""

    dims: tuple[str, ...]
    sizes: tuple[int, ...]
    fill: Any  # its dtype is that of the variable
    attrs: dict[str, Any]

    @classmethod
    def of(cls, fill: Any, *dims: tuple[str, int], **attrs: Any) -> "Variable":
        """dims: the dimensions with their sizes."""
        return cls(tuple(name for name, _ in dims), tuple(size for _, size in dims), fill, attrs)


STATUS = Variable.of(
    np.int8(NOT_RUN), long_name="how the run ended", flag_values=[NOT_RUN, *range(len(STATUSES))],
    flag_meanings=" ".join(("not_run", *STATUSES)),
)  # fmt: skip

# of runs that choose their steps
OF_CHOSEN = {
    "accepted": Variable.of(np.int64(0), units="1", long_name="steps accepted"),
    "rejected": Variable.of(np.int64(0), units="1", long_name="steps rejected"),
    "t_failed": Variable.of(np.float64(np.nan), units="s", long_name="end of the step that could not be made"),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class SweepPlan(Asked, ABC):
    """A checked sweep as plain data, which is all that a worker is sent.

    samples, device, dtype: as in `substep.sweep`. bound: energy in J before which runs end, inf for none.
    """

    samples: int | None = None
    bound: float = math.inf
    device: Device = "cpu"
    dtype: Dtype = "float64"
    time_attrs: ClassVar[dict[str, str]] = {"long_name": "time"}

    @property
    @abstractmethod
    def variables(self) -> dict[str, Variable]:
        """The variables of the Dataset by name, the status last."""

    @property
    @abstractmethod
    def labels(self) -> "dict[str, xarray.Variable]":
        """The coordinates of the Dataset besides the axes and time."""

    @property
    @abstractmethod
    def attrs(self) -> dict[str, Any]:
        """The attributes of the Dataset: what is the same in all points."""

    @property
    def in_threads(self) -> bool:
        """Whether chunks may be run by several threads at once: no function of the user's is called."""
        return False

    def about(self, axis: Axis) -> dict[str, str]:
        """The attributes of an axis: none where units are any that are consistent."""
        del axis
        return {}

    @abstractmethod
    def piece(self, cluster: bool) -> tuple[int, ...]:
        """The shape of a chunk, which may be less at an end of an axis; cluster: whether another process runs it."""

    @abstractmethod
    def run(self, first: int, last: int, room: Results) -> Results:
        """Results of the points first to last - 1, by the variables' names in the Dataset, each (last - first, ...).

        room: where some of them may be put, by name and of that shape, or none; the others are new arrays.
        """

    @property
    def dims(self) -> dict[str, int]:
        """The sizes of all dimensions of the axes by their names in the Dataset."""
        return {axis.dim: len(axis.values) for axis in self.axes}

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each dimension has."""
        return tuple(self.dims.values())

    def chunks(self, piece: tuple[int, ...]) -> list[Chunk]:
        """All chunks of that shape, in C order."""
        if not math.prod(self.shape):
            return []
        chunks: list[Chunk] = []
        for corner in product(*(range(0, size, step) for size, step in zip(self.shape, piece, strict=True))):
            where = tuple(slice(i, min(i + p, n)) for i, p, n in zip(corner, piece, self.shape, strict=True))
            first = int(np.ravel_multi_index((0, *corner), (1, *self.shape)))
            chunks.append(Chunk(first, first + math.prod(s.stop - s.start for s in where), where))
        return chunks

    def stride(self, n: int) -> int:
        """How many of n steps lie between two rows of the history."""
        return 1 if self.samples is None else n // self.samples

    @property
    def rows(self) -> int:
        """How many rows a history has, with that of the start or on the grid."""
        return len(self.chosen["grid"]) if self.by_tol else 1 + (self.samples or max(self.steps, default=0))

    @property
    def times(self) -> Array:
        """Of the rows of a history, s."""
        if self.by_tol:
            return np.asarray(self.chosen["grid"], dtype=np.float64)
        return np.arange(self.rows) * (self.t_end / self.samples if self.samples else self.given["step"]["dt"])

    def motion(
        self, name: str, *inner: tuple[str, int], largest: str = "largest", **attrs: Any
    ) -> tuple[str, Variable]:  # fmt: skip
        """u, v, a or the energy as it is kept: a variable by its name in the Dataset; inner: its dimensions but time.

        largest: its peak in words.
        """
        rows = [("t", self.rows)] if self.keep == "history" else []
        meaning, peak = {**MEANINGS, **OF_LAWS}[name], "peak_" * (self.keep == "peak")
        text = {"final": f"{meaning} at t_end", "peak": f"{largest} {meaning}", "history": meaning}[self.keep]
        return peak + name, Variable.of(np.float64(np.nan), *rows, *inner, **attrs, long_name=text)

    def template(self) -> "xarray.Dataset":
        """A Dataset with the coordinates and attributes of the sweep, without variables."""
        from ..core.result_dataset import ResultDataset  # noqa: PLC0415 (loads xarray)

        coordinates = {a.name: named(a.dim, a.values, {**self.about(a), **a.attrs}) for a in self.axes}
        if self.keep == "history":
            coordinates["t"] = named("t", self.times, self.time_attrs)
        return ResultDataset(coords=coordinates | self.labels, attrs=self.attrs)

    def __getstate__(self) -> Mapping[str, Any]:
        """Only the fields: cached handles of scheme and scene hold functions, which cannot be pickled."""
        return {f.name: getattr(self, f.name) for f in fields(self)}
