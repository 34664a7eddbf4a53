"""What a sweep is asked for, of a scene or of a structure: its axes, the values of parameters, the step and the end."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

from numpy.typing import ArrayLike

from ..core.arrays import Array
from ..core.entries import SchemeInfo
from ..core.errors import inside, number_or_row, real_number, require_numbers, unknown_name
from ..core.schemes import Scheme, scheme_info
from ..core.schemes import scheme as make_scheme
from .clock import CHOSEN, require_tol

if TYPE_CHECKING:
    from ..derived.modules import Declaration

Keep = Literal["final", "peak", "history"]
Owner = Literal["step", "scheme", "scene", "load"]
# names in the Dataset that an axis cannot have
RESERVED = {"t", "coordinate", "balance", "u", "v", "a", "energy", "peak_u", "peak_v", "peak_a", "peak_energy"} | {
    "status", "n_done", "newton_iterations", "newton_most", "accepted", "rejected", "t_failed"
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Axis:
    """A dimension: its name in the Dataset, whose parameter it is, the parameter's own name, and its values (n,)."""

    name: str
    owner: Owner
    key: str
    values: Array


def asked(
    scheme: "Scheme | str | Declaration",
    values: Mapping[str, Any],
    owned: Mapping[Owner, Sequence[str]],
    of_scene: Mapping[str, Any],
    others: str,
    reserved: Collection[str],
) -> tuple[SchemeInfo, tuple[Axis, ...], dict[Owner, dict[str, Any]]]:
    """The scheme, the axes in the order of `values`, and by owner the values that are the same in all points.

    Those of the scheme are its handle's, as far as no value replaces them, by itself or through a family, and those of
    a scene are `of_scene`, its handle's. owned: the parameters of the others, who are `others` in words. reserved:
    names that an axis cannot have. Raises ValueError for names and values that do not fit, and for a step or a
    tolerance that is not positive.
    """
    handles: dict[Owner, dict[str, Any]] = {"scheme": {}, "scene": dict(of_scene)}
    if isinstance(scheme, Scheme):
        require_numbers(scheme.name, scheme.parameters, "give it as an axis")
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
        axes.append(Axis(name, owner, key, array.copy()))
    for owner, of_handle in handles.items():
        given[owner] = {**of_handle, **given[owner]}
    return info, tuple(axes), given


def checked_end(keep: Any, t_end: Any) -> float:
    """t_end. Raises ValueError for one that is not positive, and for an unknown choice of what to keep."""
    if keep not in get_args(Keep):
        raise unknown_name("keep", str(keep), get_args(Keep))
    return real_number("t_end", t_end, positive=True)


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


def step_asked(
    dt: ArrayLike | None, tol: ArrayLike | None, values: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """{"dt": ...} or {"tol": ...}; what is asked of chosen steps; the other values. Raises ValueError for both."""
    if (dt is None) == (tol is None):
        raise ValueError(
            f"expected either dt, a constant step, or tol, for chosen steps; got {'none' if dt is None else 'both'}"
        )
    chosen = {name: value for name, value in values.items() if name in CHOSEN}
    if dt is not None:
        require_tol(chosen)
    step = {"tol": tol} if dt is None else {"dt": dt}
    return step, chosen, {name: value for name, value in values.items() if name not in CHOSEN}
