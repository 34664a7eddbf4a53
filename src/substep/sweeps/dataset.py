"""The Dataset of a sweep: its variables, coordinates and attributes, before anything is run."""

import re
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..core.arrays import named
from ..core.loads import Load, Record, values_at
from ..core.response import STATUSES as ENDED
from ..run.axes import Axis
from .sweep_plan import Plan

if TYPE_CHECKING:
    import xarray

NOT_RUN = -1
STATUSES = {
    "flag_values": [NOT_RUN, *range(len(ENDED))],
    "flag_meanings": " ".join(("not_run", *ENDED)),
}
MEANINGS = {"u": "displacement", "v": "velocity", "a": "acceleration", "energy": "kinetic energy and potential"}
INSTANTS = 4097  # at which a load of the user's own is sampled, to recognise it when the sweep is resumed


class Variable(NamedTuple):
    """A variable of the Dataset: its dimensions beyond the axes, their sizes, the value before a run, attributes."""

    dims: tuple[str, ...]
    sizes: tuple[int, ...]
    fill: Any  # its dtype is that of the variable
    attrs: dict[str, Any]


def variables(plan: Plan) -> dict[str, Variable]:
    """The variables of a sweep's Dataset by name, the status last."""
    units = {unit for _, unit in plan.scene_of_one.coordinates}
    unit = units.pop() if len(units) == 1 else "of the coordinate"
    unit_of = {"u": unit, "v": f"{unit}/s", "a": f"{unit}/s^2", "energy": "J"}
    coordinate, balance = ("coordinate", len(plan.scene_of_one.coordinates)), ("balance", plan.scheme_of_all.balances)
    found: dict[str, Variable] = {}

    def add(name: str, fill: Any, *dims: tuple[str, int], **attrs: Any) -> None:
        found[name] = Variable(tuple(d for d, _ in dims), tuple(n for _, n in dims), fill, attrs)

    for name, meaning in MEANINGS.items():
        dims = [("t", plan.rows)] if plan.keep == "history" else []
        dims += [coordinate] if name != "energy" else []
        peak = plan.keep == "peak"
        if peak and name == "energy" and plan.oscillator and not plan.by_tol:
            continue
        largest = "largest" if name == "energy" else "largest modulus of"
        long_name = {"final": f"{meaning} at t_end", "peak": f"{largest} {meaning}", "history": meaning}[plan.keep]
        add(f"peak_{name}" if peak else name, np.float64(np.nan), *dims, units=unit_of[name], long_name=long_name)
    add(
        "newton_iterations",
        np.float64(np.nan),
        balance,
        units="1",
        long_name="Newton's iterations, mean of the steps done",
    )
    add("newton_most", np.int64(0), balance, units="1", long_name="Newton's iterations, most of any step")
    if plan.by_tol:
        add("accepted", np.int64(0), units="1", long_name="steps accepted")
        add("rejected", np.int64(0), units="1", long_name="steps rejected")
        add("t_failed", np.float64(np.nan), units="s", long_name="end of the step that could not be made")
    else:
        add("n_done", np.int64(0), units="1", long_name="steps completed")
    add("status", np.int8(NOT_RUN), long_name="how the run ended", **STATUSES)
    return found


def template(plan: Plan) -> "xarray.Dataset":
    """A Dataset with the coordinates and attributes of the sweep, without variables."""
    import xarray  # noqa: PLC0415 (on first use)

    coordinates = {axis.name: named(axis.name, axis.values, _attributes(plan, axis)) for axis in plan.axes}
    if plan.keep == "history":
        if plan.by_tol:
            t = np.asarray(plan.chosen["grid"], dtype=np.float64)
        else:
            t = np.arange(plan.rows) * (plan.t_end / (plan.rows - 1) if plan.samples else plan.given["step"]["dt"])
        coordinates["t"] = named("t", t, {"units": "s", "long_name": "time"})
    names = np.array([name for name, _ in plan.scene_of_one.coordinates], dtype=object)
    coordinates["coordinate"] = named("coordinate", names, {"long_name": f"coordinate of {plan.scene_of_one.name}"})
    balances = np.arange(1, plan.scheme_of_all.balances + 1)
    coordinates["balance"] = named("balance", balances, {"long_name": f"balance of {plan.scheme_of_all.name}"})
    return xarray.Dataset(coords=coordinates, attrs=description(plan))


def _attributes(plan: Plan, axis: Axis) -> dict[str, Any]:
    if axis.owner == "step":
        return {"units": "s", "long_name": "step"} if axis.key == "dt" else {"units": "1", "long_name": "tolerance"}
    whose = {"scheme": plan.scheme_of_all.name, "scene": plan.scene_of_one.name, "load": f"the load {_name(plan.load)}"}
    return {"long_name": f"{axis.key} of {whose[axis.owner]}"}


def description(plan: Plan) -> dict[str, Any]:
    """Everything that is the same in all points, as values that attributes of a file can hold."""
    scene, scheme = plan.scene_of_one, plan.scheme_of_all
    swept = {(axis.owner, axis.key) for axis in plan.axes}
    found: dict[str, Any] = {"scene": scene.name, "scheme": scheme.name}
    found |= {f"scene_{k}": x for k, x in scene.parameters.items() if ("scene", k) not in swept}
    found |= {f"scheme_{k}": float(x) for k, x in scheme.parameters.items() if not x.ndim}
    if plan.a0 is not None:
        found["scene_a0"] = plan.a0 if isinstance(plan.a0, str) else np.atleast_1d(plan.a0).astype(float).tolist()
    if plan.load is not None:
        found |= {"load": _name(plan.load)} | {
            f"load_{k}": x for k, x in _description_of(plan.load, plan.t_end).items() if ("load", k) not in swept
        }
    found |= dict(plan.given["step"]) | {"t_end": plan.t_end, "keep": plan.keep}
    found |= {name: np.atleast_1d(x).astype(float).tolist() for name, x in plan.chosen.items()}
    found |= {} if plan.samples is None else {"samples": plan.samples}
    found |= {} if np.isinf(plan.bound) else {"energy_bound": plan.bound}
    declarations = "".join(map(_declaration_digest, (scheme.kernels, scene.module)))
    return {
        **found,
        "declarations": _digest(declarations.encode()),
        "substep_version": _version(),
        "interrupted": 0,
    }


def _name(load: Load | None) -> str:
    return getattr(load, "__qualname__", type(load).__qualname__)


def _description_of(load: Load, t_end: float) -> dict[str, Any]:
    """What distinguishes a load: its fields, and a digest of its values where the fields do not determine it."""
    if isinstance(load, Record):
        return {"dt": float(load.dt), "samples_sha256": _digest(load.samples.tobytes())}
    values = {f.name: getattr(load, f.name) for f in fields(load) if f.init} if is_dataclass(load) else {}
    values = values if all(isinstance(x, int | float | str) for x in values.values()) else {}
    if values and type(load).__module__ == Record.__module__:
        return values
    at = values_at(load, np.linspace(0.0, t_end, INSTANTS), finite=False)  # a run that meets another value says so
    return values | {"samples_sha256": _digest(at.tobytes())}


@cache
def _declaration_digest(module: ModuleType) -> str:
    """The digest of the declaration that a generated module was printed from."""
    text = Path(module.__file__ or "").read_text(encoding="utf-8")
    found = re.search(r"Declaration digest: (\w+)", text)
    return found[1] if found else text


def _digest(data: bytes) -> str:
    import hashlib  # noqa: PLC0415 (on first use)

    return hashlib.sha256(data).hexdigest()


@cache
def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415 (on first use)

    try:
        return version("substep")
    except PackageNotFoundError:
        return "unknown"
