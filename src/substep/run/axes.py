"""What a sweep is asked for, of a scene or of a structure: its axes, the values of parameters, the step and the end."""

from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, get_args

from numpy.typing import ArrayLike

from ..core.arrays import Array
from ..core.errors import inside, number_or_row, real_number, unknown_name
from ..core.schemes import Scheme, scheme_info
from ..core.schemes import scheme as make_scheme
from .clock import CHOSEN, end_asked, number_of_steps, require_one, require_tol
from .schemes import numbers_only

if TYPE_CHECKING:
    from ..derived.modules import Declaration

Keep = Literal["final", "peak", "history"]
Owner = Literal["step", "scheme", "scene", "load"]
# names in the Dataset that an axis cannot have
RESERVED = {"t", "coordinate", "balance", "u", "v", "a", "energy", "peak_u", "peak_v", "peak_a", "peak_energy"} | {
    "status", "n_done", "newton_iterations", "newton_most", "accepted", "rejected", "t_failed", "draw", "replicate"
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Axis:
    """A parameter that varies: its name in the Dataset, whose it is, its own name, its values (n,), along a dimension.

    Axes with one dimension `dim` vary together along it; most have a dimension to themselves, of their own name. attrs:
    what is said of the values besides their unit and meaning.
    """

    name: str
    owner: Owner
    key: str
    values: Array
    dim: str
    attrs: Mapping[str, Any]


@dataclass(frozen=True, eq=False, kw_only=True)
class Asked:
    """What a user asked of a sweep, checked, as plain data.

    scheme: name, or a declaration of the user's own. axes: in the order of the call. given: parameters that are the
    same in all points, by owner. chosen: what is asked of steps that runs choose, as in `substep.march`, by name.
    t_end, s.
    """

    scheme: "str | Declaration"
    axes: tuple[Axis, ...]
    given: dict[Owner, dict[str, Any]]
    chosen: Mapping[str, Any]
    t_end: float
    keep: Keep

    @property
    def by_tol(self) -> bool:
        """Whether each run chooses its steps."""
        return "tol" in self.given["step"] or any((axis.owner, axis.key) == ("step", "tol") for axis in self.axes)

    @cached_property
    def steps(self) -> tuple[int, ...]:
        """How many steps a run takes, for each dt; none where runs choose. Raises ValueError as `number_of_steps`."""
        if self.by_tol:
            return ()
        swept = [axis.values for axis in self.axes if axis.owner == "step"]
        every = swept[0] if swept else [self.given["step"]["dt"]]
        return tuple(number_of_steps(float(dt), self.t_end) for dt in every)

    def values(self, owner: Owner, at: Mapping[Axis, Any]) -> dict[str, Any]:
        """The owner's parameters by name, those that are swept where `at` says, a number or an array for each axis."""
        swept = {axis.key: axis.values[i] for axis, i in at.items() if axis.owner == owner}
        return {**self.given.get(owner, {}), **swept}


def asked(
    scheme: "Scheme | str | Declaration", dt: ArrayLike | None, tol: ArrayLike | None, t_end: Any, keep: Any,
    values: Mapping[str, Any], owned: Mapping[Owner, Sequence[str]], of_scene: Mapping[str, Any], others: str,
    reserved: Set[str],
) -> Asked:  # fmt: skip
    """The request of a sweep, checked.

    values: axes, parameters, and what is asked of chosen steps. Parameters of the scheme that no value replaces, by
    itself or through a family, are its handle's, and those of a scene are `of_scene`, its handle's. owned: the
    parameters of the others, who are `others` in words. reserved: names that an axis cannot have. Raises ValueError for
    names and values that do not fit, for both or neither of dt and tol, and for a step, a tolerance or an end that is
    not positive.
    """
    require_one(dt, tol, t_end)
    chosen = {name: value for name, value in values.items() if name in CHOSEN}
    if dt is not None:
        require_tol(chosen)
    step = {"tol": tol} if dt is None else {"dt": dt}
    values = {**step, **{name: value for name, value in values.items() if name not in CHOSEN}}
    handles: dict[Owner, dict[str, Any]] = {"scheme": {}, "scene": dict(of_scene)}
    if isinstance(scheme, Scheme):
        numbers_only(scheme, "give it as an axis")
        _require_made(scheme)
        handles["scheme"] = {key: float(x) for key, x in scheme.given.items()}
    info = scheme.info if isinstance(scheme, Scheme) else scheme_info(scheme)
    every: dict[Owner, Sequence[str]] = {"scheme": [*info.parameters, *info.families], **owned}
    axes: list[Axis] = []
    given: dict[Owner, dict[str, Any]] = {"step": {}, "scheme": {}, "scene": {}, "load": {}}
    for name, (owner, key), value in _resolved(every, f"a parameter of {info.name}, {others}", values, reserved):
        family = info.families.get(key) if owner == "scheme" else None
        for replaced in family.values if family else (key,):
            handles.get(owner, {}).pop(replaced, None)
        array = number_or_row(name, value)
        if not array.ndim:
            number = float(array)
            given[owner][key] = real_number(name, number, positive=True) if owner == "step" else number
            continue
        if owner == "step":
            inside(name, array, 0.0, None, True, True)
        (dim,) = getattr(value, "dims", (name,))
        axes.append(Axis(name, owner, key, array.copy(), str(dim), dict(getattr(value, "attrs", {}))))
    _require_together(axes, reserved - {"draw"})
    for owner, of_handle in handles.items():
        given[owner] = {**of_handle, **given[owner]}
    if keep not in get_args(Keep):
        raise unknown_name("keep", str(keep), get_args(Keep))
    end = end_asked(t_end)
    return Asked(scheme=info.source, axes=tuple(axes), given=given, chosen=chosen, t_end=end, keep=keep)


def _require_together(axes: Sequence[Axis], reserved: Set[str]) -> None:
    """Raise ValueError for a dimension that has another length, or another meaning in the Dataset."""
    lengths: dict[str, tuple[int, str]] = {}
    for axis in axes:
        n, first = lengths.setdefault(axis.dim, (len(axis.values), axis.name))
        if len(axis.values) != n:
            raise ValueError(
                f"expected as many values of {axis.name} as of {first} along {axis.dim}, {n}, got {len(axis.values)}; "
                "what varies along one dimension varies together"
            )
        if axis.dim in reserved or any(other.name == axis.dim != other.dim for other in axes):
            raise ValueError(f"expected another dimension of {axis.name} than {axis.dim}, which is taken; rename it")


def _require_made(scheme: Scheme) -> None:
    """Raise ValueError for a handle that `dataclasses.replace` changed: a sweep makes schemes from `given` alone."""
    again = make_scheme(scheme.info.source, **scheme.given).parameters
    for name, value in scheme.parameters.items():
        if value != again[name]:
            raise ValueError(
                f"expected a scheme as ss.scheme makes it, {name} = {again[name]}, got {value}; make it anew"
            )


def _resolved(
    owned: Mapping[Owner, Sequence[str]], what: str, values: Mapping[str, Any], reserved: Collection[str]
) -> Iterator[tuple[str, tuple[Owner, str], Any]]:
    """(name, (owner, key), value) of each value. Raises ValueError for an unknown or ambiguous name.

    what: the parameters that there are, in words.
    """
    prefixed: dict[str, tuple[Owner, str]] = {
        f"{owner}_{key}": (owner, key) for owner, keys in owned.items() for key in keys
    }
    seen: dict[tuple[Owner, str], str] = {}
    found: tuple[Owner, str]
    for name, value in values.items():
        owners: list[Owner] = [owner for owner, keys in owned.items() if name in keys]
        if name in ("dt", "tol"):
            found = "step", name
        elif len(owners) > 1 or (owners and name in reserved):
            choice = " or ".join(f"{owner}_{name}" for owner in owners)
            whose = " and ".join(owners) if len(owners) > 1 else f"the {owners[0]} and the results"
            raise ValueError(f"expected whose {name} is meant, which {whose} have; write {choice}")
        elif owners:
            found = owners[0], name
        elif name in prefixed:
            found = prefixed[name]
        else:
            known = [key for keys in owned.values() for key in keys]
            raise unknown_name(what, name, ["dt", "tol", *CHOSEN, *known])
        if found in seen:
            raise ValueError(f"expected {found[1]} of the {found[0]} once, got {seen[found]} and {name}; drop one")
        seen[found] = name
        yield name, found, value
