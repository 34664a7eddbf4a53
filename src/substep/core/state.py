"""Where a run stands: what a later run goes on from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .arrays import Array, named
from .errors import float_array, real_array, real_number, unknown_name, warn
from .scheme_record import SchemeRecord
from .stability import amplification

if TYPE_CHECKING:
    from xarray import Dataset

UNITS = ("", "h*", "h^2*")  # of u, v, a in the labels of a scheme's state
GIVEN = ("t", "u", "v", "a", "history", "memory")  # what a dictionary may say


@dataclass(frozen=True, eq=False)
class State:
    """Displacement, velocity and acceleration at the time t (s), and what the scheme carries into its next step.

    u, v, a (d,): of the coordinates of a scene or of all degrees of freedom of a structure; a is the scheme's own where
    it has one, None to take it from the equation of motion. history: rows (k,) by their labels, as `Scheme.state` has
    them for the oscillator ("u", "h*v", "u[-1]") and without the h elsewhere; empty where none is known.

    The history is that of a scheme, with its parameters, and of a kind of run, both in `of`, and of steps of `dt` (s):
    with these, a run goes on as if it had not been broken, else the scheme starts anew from u, v, a. steps: of this dt
    since the time `origin`, for the instants of the load to be the same to the bit. dt_next: of a run with chosen
    steps, the length of its next one, s. more: what else only such a run reads, as the tangents that an iteration
    keeps, and the fork of a run with chosen steps: where it was before t_end first changed the length of a step, with
    all that its steps are chosen by. memory: what the laws of a scene remember, by name; of a structure, arrays: of
    springs (s,), NaN where one remembers nothing of that name, with the work that went into them where some law keeps
    no account of what it dissipates, and states.
    """

    t: float
    u: Array
    v: Array
    a: Array | None = None
    history: Mapping[str, Array] = field(default_factory=dict[str, Array])
    of: str = ""
    dt: float = np.nan
    steps: int = 0
    origin: float = 0.0
    dt_next: float | None = None
    more: Mapping[str, Array] = field(default_factory=dict[str, Array])
    memory: Mapping[str, Any] = field(default_factory=dict[str, Any])

    @classmethod
    def given(cls, start: Any, scheme: SchemeRecord) -> State:
        """The state that a user gives: of a response, of its file, or a dictionary of u, v and what else is known.

        Raises ValueError for anything else, for numbers that are not finite, and for other names. Warns where a
        dictionary leaves out an acceleration that the scheme would carry on and that is not the consistent one.
        """
        if isinstance(start, State):
            return start
        if (state := getattr(start, "state", None)) is not None:
            return state
        if "origin" in getattr(start, "attrs", ()):
            return cls.of_dataset(start)
        shown = repr(start)[:60]
        if hasattr(start, "attrs") or not isinstance(start, Mapping) or not {"u", "v"} <= start.keys():
            raise ValueError(
                "expected start as a response, its `state`, what ss.load reads of a file by r.save or r.state.save, or "
                f"a dictionary with u and v, got {shown}; give r, or {{'t': 0.0, 'u': ..., 'v': ..., 'a': ...}}"
            )
        parts = cast("Mapping[str, Any]", start)
        if unknown := [name for name in parts if name not in GIVEN]:
            raise unknown_name("a part of start", str(unknown[0]), GIVEN)
        u, v = (np.atleast_1d(real_array(name, parts[name])) for name in ("u", "v"))
        a, carried, t = parts.get("a"), parts.get("history"), real_number("t of start", parts.get("t", 0.0))
        if a is None and not carried and t > 0.0 and _carries_its_own_a(scheme):
            warn(
                f"start has no acceleration at t = {t:.6g}, and {scheme.name} carries one that is not that of the "
                "equation of motion, from which the run now begins anew, as another motion than that of a run which "
                "goes on; give the response or its r.state, 'a': r.a[-1], or 'a': 'consistent' if this is meant"
            )
        a = "consistent" if a is None else a
        if isinstance(a, str) and a != "consistent":
            raise ValueError(f"expected a of start as numbers or 'consistent', got {a!r}; give one, or leave it out")
        own_a = None if isinstance(a, str) else np.atleast_1d(real_array("a", a))
        if carried is not None and not isinstance(carried, Mapping):
            raise ValueError(
                f"expected history of start as rows by the labels of Scheme.state, got {repr(carried)[:60]}; give "
                "{'u': ..., 'u[-1]': ...}, or leave it out"
            )
        rows = cast("Mapping[str, Any]", carried or {})
        history = {label: np.atleast_1d(real_array(label, x)) for label, x in rows.items()}
        remembered = parts.get("memory")
        if remembered is not None and not isinstance(remembered, Mapping):
            raise ValueError(
                f"expected memory of start as numbers by name, got {repr(remembered)[:60]}; give r.state, or a "
                "dictionary"
            )
        given = cast("Mapping[str, Any]", remembered or {})
        # of structures NaN stands where a spring remembers nothing of that name
        arrays = {name: (real_array if np.ndim(x) == 0 else float_array)(f"{name} of start", x)
                  for name, x in given.items()}  # fmt: skip
        memory = {name: x if x.ndim else float(x) for name, x in arrays.items()}
        return cls(t, u, v, own_a, history, memory=memory)

    def goes_on(self, of: str, dt: float) -> bool:
        """Whether it is where a run `of` this scheme and kind in steps of dt can go on as if it had not been broken."""
        return self.of == of and self.dt == dt

    def rows(self, labels: Sequence[str], of: str, dt: float) -> Array | None:
        """The rows (m, k) of these labels for a run `of` that scheme and kind in steps of dt, None where not known.

        A history that a user has given is not asked for its scheme; raises ValueError where a label is missing in it,
        or is there which the scheme does not carry.
        """
        if not self.history or (self.of and not self.goes_on(of, dt)):
            return None
        found: list[Array] = []
        for label in labels:
            at = self.history.get(label)
            if at is None and not self.of:
                at = self._scaled(label, dt)
            if at is None:
                raise ValueError(
                    f"expected {label} in the history of start, got {', '.join(self.history)}; a scheme that carries "
                    f"{', '.join(labels)} needs each of them, or none for it to start anew from u, v, a"
                )
            found.append(at)
            self._require_same(label, at, dt)
        carried = set(bare(labels))
        if not self.of and (more := [other for other in self.history if _power(other)[1] not in carried]):
            raise ValueError(
                f"expected no {', '.join(more)} in the history of start, for a scheme that carries {', '.join(labels)}"
                "; leave it out, or take the scheme whose history it is"
            )
        return np.array(found)

    def _require_same(self, label: str, x: Array, dt: float) -> None:
        """Raises ValueError for a row of a user's history that is u or v now and differs from them."""
        power, name = _power(label)
        now = {"u": self.u, "v": self.v}.get(name)
        if self.of or now is None:
            return
        if x.shape != now.shape or not np.allclose(x, now * dt**power, rtol=1e-9, atol=0.0):
            raise ValueError(
                f"expected {label} in the history of start to be what {name} of start says, {now * dt**power}, got "
                f"{x}; give the same twice"
            )

    def _scaled(self, label: str, dt: float) -> Array | None:
        """A row that is there without the power of h of the label, or with one that the label does not have."""
        power, bare = _power(label)
        for other, x in self.history.items():
            has, name = _power(other)
            if name == bare:
                return x * dt ** (power - has)
        return None

    def save(self, path: str | Path) -> None:
        """Write it to a netCDF file, which `substep.load` reads for `march(start=)`; OSError where it cannot."""
        self.to_xarray().to_netcdf(path, engine="scipy")  # pyright: ignore[reportUnknownMemberType]

    def to_xarray(self) -> Dataset:
        """u, v, a over the coordinates, the rows of the history over their labels, and all numbers as attributes."""
        import xarray  # noqa: PLC0415 (on first use)

        vectors = {name: x for name in "uva" if (x := getattr(self, name)) is not None}
        found: dict[str, Any] = {name: named("place", x, {}) for name, x in vectors.items()}
        if self.history:
            found["history"] = named(("label", "row"), np.array(list(self.history.values())), {})
        numbers = {name: getattr(self, name) for name in ("t", "dt", "origin")}
        numbers |= {f"memory {name}": x for name, x in self.memory.items() if np.ndim(x) == 0}
        attrs = {**numbers, "steps": float(self.steps), "of": self.of, "dt_next": self.dt_next or np.nan}
        found |= {
            name: named(tuple(f"{name} {k}" for k in range(np.ndim(x))), x, {})
            for kind, arrays in (("more", self.more), ("memory", self.memory))
            for name, x in ((f"{kind} {key}", y) for key, y in arrays.items() if kind == "more" or np.ndim(y))
        }
        labels = named("label", np.array(list(self.history), dtype=object), {})
        return xarray.Dataset(found, {"label": labels} if self.history else {}, attrs)

    @classmethod
    def of_dataset(cls, found: Dataset) -> State:
        """What `to_xarray` has made of a state."""
        arrays = {str(name): np.array(x.values, np.float64) for name, x in found.items()}
        labels = [str(label) for label in found["label"].values] if "label" in found.coords else []
        t, dt, origin, dt_next = (float(found.attrs[name]) for name in ("t", "dt", "origin", "dt_next"))
        return cls(
            t, arrays["u"], arrays["v"], arrays.get("a"),
            dict(zip(labels, arrays.get("history", ()), strict=True)), str(found.attrs["of"]), dt,
            int(found.attrs["steps"]), origin, None if np.isnan(dt_next) else dt_next,
            {name.removeprefix("more "): x for name, x in arrays.items() if name.startswith("more ")},
            {
                **{str(k).removeprefix("memory "): float(x) for k, x in found.attrs.items() if str(k)[:7] == "memory "},
                **{k.removeprefix("memory "): x for k, x in arrays.items() if k.startswith("memory ")},
            },
        )  # fmt: skip

    def consistent(self) -> State:
        """The same without an acceleration or a history: a run from it takes a from the equation of motion."""
        return replace(self, a=None, history={}, of="", dt_next=None, more={})

    def __repr__(self) -> str:
        kept = f"history {', '.join(self.history)}" if self.history else "no history"
        return f"State(t = {self.t:.6g} s, {len(self.u)} coordinates, {kept})"


def whose(scheme: SchemeRecord, kind: str = "") -> str:
    """A scheme in words, the user's own with the digest of its declaration, and the kind of a run: `State.of`."""
    own = scheme.kernels.__name__ if scheme.info.declaration is not None else ""
    return f"{kind and kind + ': '}{scheme!r}{own}"


def _carries_its_own_a(scheme: SchemeRecord) -> bool:
    """Whether its acceleration after a free step is another one than -omega^2 u, as that of the alpha schemes is."""
    entries = scheme.info.history
    if not {(0, 0), (2, 0)} <= set(entries):
        return False
    A = amplification(scheme, 1.0, 0.0)
    return bool(np.abs(A[entries.index((0, 0))] + A[entries.index((2, 0))]).max() > 1e-9)


def bare(labels: Iterable[str]) -> list[str]:
    """Labels without powers of h: those of a scheme's state where it is not that of the oscillator."""
    return [_power(label)[1] for label in labels]


def _power(label: str) -> tuple[int, str]:
    """The power of h in a label, and the label without it."""
    for power in (2, 1):
        if label.startswith(UNITS[power]):
            return power, label[len(UNITS[power]) :]
    return 0, label


def require_coordinates(start: Any, coordinates: Sequence[tuple[str, str]], name: str) -> None:
    """Raises ValueError for a response of a scene with other coordinates than those of the scene of that name."""
    other = getattr(getattr(start, "scene", None), "coordinates", coordinates)
    if tuple(other) != tuple(coordinates):
        given, own = (", ".join(f"{q} ({unit})" for q, unit in x) for x in (other, coordinates))
        raise ValueError(
            f"expected start as a response of a scene with the coordinates of {name}, {own}, got one of "
            f"{start.scene.name}, {given}; give a dictionary of t, u, v if this is meant"
        )
