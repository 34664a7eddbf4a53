"""A march on disk: histories row by row, and the state from which a later call of the same march goes on."""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from ..core.arrays import Array
from ..core.errors import optional
from ..core.loads import is_known, values_at
from ..core.schemes import Scheme
from .damping import Rayleigh
from .matrices import arrays_of
from .step_lengths import reach, rms
from .structure import Structure

BUFFER = 1 << 20  # doubles of histories in memory at a time
IN_MEMORY = 1 << 27  # doubles of histories that a response reads into memory
STATES = 4  # at which an internal force is, of the size of the start or of static displacements
INSTANTS = 257  # at which a load of the user's own is sampled, to recognise the march


class Saved:
    """A Zarr store with u, v and, where the scheme has its own, a (n, k), and what a march needs to go on.

    Rows are written first, then the state under the name that is not in use, and last the attribute that says which
    holds: a march that was stopped at any instant, even by a kill, goes on from the last checkpoint. Raises ValueError
    for a path that holds another march.
    """

    def __init__(self, path: str | Path, digest: str, shape: tuple[int, int, int]) -> None:
        zarr = optional("zarr", "save=", "save")
        self.path, self.count = Path(path), max(1, BUFFER // max(1, shape[1] * shape[2]))
        if not self.path.exists():
            group = zarr.open_group(self.path, mode="w-")
            for kind in "uva"[: shape[1]]:
                chunks = (min(self.count, shape[0]), shape[2])
                group.create_array(kind, shape=(shape[0], shape[2]), chunks=chunks, dtype="float64")
            group.attrs["march"] = digest
        self.group: Any = zarr.open_group(self.path, mode="r+")
        if self.group.attrs.get("march") != digest:
            raise ValueError(
                f"expected the same march as {self.path} holds, or nothing there, got another structure, scheme, step, "
                "end or choice of rows; give save another path, or remove that one"
            )
        self.targets: list[Any] = [self.group[kind] for kind in "uva"[: shape[1]]]
        self.shape = (shape[0], shape[2])
        for target in self.targets:  # shorter where a run ended before
            target.resize(self.shape)
        self.buffer: list[Array] = []
        self.first = 0

    @property
    def last(self) -> dict[str, Any] | None:
        """What the last checkpoint holds: its attributes, and its arrays by name; None before the first."""
        found = self.group.attrs.get("last")
        if found is None:
            return None
        arrays = self.group[found["name"]]
        return {**found, **{name: arrays[name][:] for name in arrays.array_keys()}}

    def put(self, place: int, row: Array) -> None:
        """Row number `place`, kept in memory until there are enough to write; rows come in order."""
        if not self.buffer:
            self.first = place
        self.buffer.append(row)

    @property
    def full(self) -> bool:
        """Whether it is time for a checkpoint."""
        return len(self.buffer) >= self.count

    def read(self, rows: int) -> list[Any]:
        """u, v and a (rows, k): in memory, or as Zarr arrays where they take more than a gigabyte."""
        if rows * self.shape[1] * len(self.targets) <= IN_MEMORY:
            return [target[:rows] for target in self.targets]
        for target in self.targets:
            target.resize((rows, self.shape[1]))
        return self.targets

    def checkpoint(self, arrays: dict[str, Any], **numbers: Any) -> None:
        """Write the rows that are in memory, then the state."""
        if self.buffer:
            rows = np.array(self.buffer)
            for kind, target in enumerate(self.targets):
                target[self.first : self.first + len(rows)] = rows[:, kind]
            self.buffer = []
        old = self.group.attrs.get("last")
        name = "state_1" if old is not None and old["name"] == "state_0" else "state_0"
        group = self.group.create_group(name, overwrite=True)
        for key, x in arrays.items():
            group.create_array(key, data=np.ascontiguousarray(x))
        self.group.attrs["last"] = {"name": name, **numbers}


def digest(structure: Structure, scheme: Scheme, h: float, n: int, *others: Any) -> str:
    """What distinguishes one march from another; functions of the user's are recognised by values at fixed states."""
    found = hashlib.sha256(repr((scheme, h, n, others, structure.names)).encode())
    if scheme.info.declaration is not None:
        found.update(scheme.kernels.__name__.encode())
    for matrix in (structure.M, structure.C, structure.K, structure.T):
        if isinstance(matrix, Rayleigh) or matrix is None:
            found.update(repr(matrix).encode())
        else:
            for part in arrays_of(matrix):
                found.update(np.ascontiguousarray(part).tobytes())
    for x in (structure.u0, structure.v0, structure.a0, *(shape for shape, _ in structure.loads)):
        found.update(x.tobytes())
    for _, load in structure.loads:
        found.update(repr(load).encode() if is_known(load) else b"function")
        found.update(values_at(load, np.linspace(0.0, n * h, INSTANTS)).tobytes())
    if (force := structure.internal) is not None:
        sizes = max(reach(structure, n * h), h * rms(structure.v0)), rms(structure.v0)
        random = np.random.default_rng(0)
        for t in random.uniform(0.0, n * h, STATES):
            u, v = (size * random.normal(size=structure.size) for size in sizes)
            found.update(force(t, u, v).tobytes())
            if force.potential is not None:
                found.update(np.float64(force.energy(u)).tobytes())
    return found.hexdigest()
