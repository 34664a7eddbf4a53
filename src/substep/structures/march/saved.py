"""A march on disk: histories row by row, and the state from which a later call of the same march goes on."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import Array, digest
from ...core.errors import optional
from ...core.loads import is_known, values_at
from ...core.state import whose
from ..model.memory import RememberingForce
from ..model.rayleigh import Rayleigh
from ..solvers.matrices import Matrix, arrays_of, is_operator
from .step_lengths import reach, rms
from .steps import Run

BUFFER = 1 << 20  # doubles of histories in memory at a time
IN_MEMORY = 1 << 27  # doubles of histories that a response reads into memory
STATES = 4  # at which an internal force is, of the size of the start or of static displacements
PRODUCTS = 2  # by which damping that is known by its products is recognised
SHOWN = ("scheme", "dt", "dofs", "stride", "account")  # what is said of a march as it is
INSTANTS = 257  # at which a load of the user's own is sampled, to recognise the march


class Saved:
    """A Zarr store with u, v and, where the scheme has its own, a (n, k), and what a march needs to go on.

    Rows are written first, then the state under the name that is not in use, and last the attribute that says which
    holds: a march that was stopped at any instant, even by a kill, goes on from the last checkpoint, and so does one to
    a later end. shape: rows, kinds, columns; n: steps of length h, s. described: what distinguishes one march from
    another, a function of the end, s, of the march that the store was made for, until which loads and forces are looked
    at.
    Raises ValueError for a path that holds another march, one that has gone beyond n steps, or something else.
    """

    def __init__(
        self,
        path: str | Path,
        shape: tuple[int, int, int],
        n: int,
        h: float,
        described: Callable[[float], dict[str, str]],
    ) -> None:
        zarr = optional("zarr", "save=", "save")
        self.path, self.count = Path(path), max(1, BUFFER // max(1, shape[1] * shape[2]))
        if not self.path.exists():
            group = zarr.open_group(self.path, mode="w-")
            for kind in "uva"[: shape[1]]:
                chunks = (self.count, max(1, shape[2]))
                group.create_array(kind, shape=(shape[0], shape[2]), chunks=chunks, dtype="float64")
            group.attrs.update({"t_end": n * h, "march": described(n * h)})
        try:
            self.group: Any = zarr.open_group(self.path, mode="r+")
            made_for, there = float(self.group.attrs["t_end"]), dict(self.group.attrs["march"])  # type: ignore[arg-type]
        except (OSError, KeyError, TypeError, ValueError) as error:
            raise ValueError(
                f"expected a saved march or nothing at {self.path}, got something else; give another path"
            ) from error
        if (here := described(made_for)) != there:
            differ = [name for name in {**there, **here} if here.get(name) != there.get(name)]
            shown = (f"{name} ({there[name]} there, {here[name]} here)" if name in SHOWN else name for name in differ)
            raise ValueError(
                f"expected the march that {self.path} holds, got another {', '.join(shown)}; give save another path, "
                "or remove that one"
            )
        done = self.group.attrs.get("last", {"done": 0})["done"]
        if done > n:
            raise ValueError(
                f"expected t_end of at least {done * h:g}, which the march that {self.path} holds has reached, got "
                f"{n * h:g}; give save another path"
            )
        self.targets: list[Any] = [self.group[kind] for kind in "uva"[: shape[1]]]
        self.shape = (shape[0], shape[2])
        for target in self.targets:  # which had another end
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

    def write(self) -> None:
        """Write the rows that are in memory."""
        if self.buffer:
            rows = np.array(self.buffer)
            for kind, target in enumerate(self.targets):
                target[self.first : self.first + len(rows)] = rows[:, kind]
            self.buffer = []

    def checkpoint(self, arrays: dict[str, Any], **numbers: Any) -> None:
        """Write the state; the rows before it were written."""
        old = self.group.attrs.get("last")
        name = "state_1" if old is not None and old["name"] == "state_0" else "state_0"
        group = self.group.create_group(name, overwrite=True)
        for key, x in arrays.items():
            group.create_array(key, data=np.ascontiguousarray(x))
        self.group.attrs["last"] = {"name": name, **numbers}


def described(run: Run, t_end: float, **choices: Any) -> dict[str, str]:
    """What distinguishes one march from another, by name: as it is, or its digest.

    t_end: after the start of the march. Functions of the user's are recognised by values at fixed times until then and
    at fixed states, matrices that are known by their products only by some of these.
    """
    structure, h = run.structure, run.h
    found = {"scheme": whose(run.scheme), "dt": repr(h), **{name: repr(x) for name, x in choices.items()}}
    found["names"] = digest(structure.names)
    for name, matrix in zip("MCK", (structure.M, structure.C, structure.K), strict=True):
        plain = isinstance(matrix, Rayleigh) or matrix is None
        found[name] = repr(matrix) if plain else digest(*_parts(matrix))
    found["constraints"] = digest(*arrays_of(structure.T))
    found["start"] = digest(structure.u0, structure.v0, structure.a0_given)
    if structure.contacts is not None:
        found[structure.contacts.kind] = digest(*structure.contacts.described(structure.u0))
    if run.start is not None:
        found["start"] = digest(run.start, *run.begin)
    begin = run.time(0)
    instants = begin + np.linspace(0.0, t_end, INSTANTS)
    loads = [(x, repr(g) if is_known(g) else "", values_at(g, instants)) for x, g in structure.loads]
    found["loads"] = digest(*(part for load in loads for part in load))
    if (force := structure.internal) is not None:
        moved = max(reach(structure, t_end, structure.u0, structure.v0), h * rms(structure.v0))
        sizes = moved, max(rms(structure.v0), moved / t_end)  # of velocities also where it starts at rest
        random, values = np.random.default_rng(0), []
        for t in begin + random.uniform(0.0, t_end, STATES):
            u, v = (size * random.normal(size=structure.size) for size in sizes)
            values += [force(t, u, v), force.energy(u) if force.potential is not None else 0.0]
        found["internal force"] = digest(*values)
        if isinstance(force, RememberingForce) and run.memory is not None:
            found["memory"] = digest(*run.memory.springs, *map(np.asarray, run.memory.states.values()))
            if (springs := force.springs) is not None:
                tables = (law.table((len(where),)) for law, where in springs.groups)
                names = [law.module.__name__ for law, _ in springs.groups]
                found["springs"] = digest(*arrays_of(springs.compressed), names, *tables)
    return found


def _parts(matrix: Matrix) -> tuple[Array, ...]:
    if is_operator(matrix):
        return (np.asarray(matrix @ np.random.default_rng(0).normal(size=(matrix.shape[1], PRODUCTS))),)
    return arrays_of(matrix)
