"""What the attributes of a sweep of a scene say: everything that is the same in all points, or a digest of it."""

import re
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.loads import Load, Record, values_at
from ..core.scenes import Scene
from ..core.schemes import Scheme
from .sweep_plan import SweepPlan

INSTANTS = 4097  # at which a load of the user's own is sampled, to recognise it when the sweep is resumed


def description(
    plan: SweepPlan, scene: Scene, scheme: Scheme, a0: ArrayLike | str | None, load: Load | None
) -> dict[str, Any]:
    """Everything that is the same in all points, as values that attributes of a file can hold.

    scene, scheme: of all points. a0, load: as the plan has them.
    """
    swept = {(axis.owner, axis.key) for axis in plan.axes}
    found: dict[str, Any] = {"scene": scene.name, "scheme": scheme.name}
    found |= {f"scene_{k}": x for k, x in scene.parameters.items() if ("scene", k) not in swept}
    found |= {f"scheme_{k}": float(x) for k, x in scheme.parameters.items() if not x.ndim}
    if a0 is not None:
        found["scene_a0"] = a0 if isinstance(a0, str) else np.atleast_1d(a0).astype(float).tolist()
    if load is not None:
        found |= {"load": name_of(load)} | {
            f"load_{k}": x for k, x in _description_of(load, plan).items() if ("load", k) not in swept
        }
    found |= dict(plan.given["step"]) | {"t_end": plan.t_end, "keep": plan.keep}
    found |= {name: np.atleast_1d(x).astype(float).tolist() for name, x in plan.chosen.items()}
    found |= {} if plan.dtype == "float64" else {"dtype": plan.dtype}
    found |= {} if plan.samples is None else {"samples": plan.samples}
    found |= {} if np.isinf(plan.bound) else {"energy_bound": plan.bound}
    declarations = "".join(map(_declaration_digest, (scheme.kernels, scene.module)))
    return {
        **found,
        "declarations": _digest(declarations.encode()),
        "substep_version": _version(),
        "interrupted": 0,
    }


def name_of(load: Load | None) -> str:
    """The name of a load's class, or of a function of the user's own."""
    return getattr(load, "__qualname__", type(load).__qualname__)


def _description_of(load: Load, plan: SweepPlan) -> dict[str, Any]:
    """What distinguishes a load: its fields, and a digest of its values where the fields do not determine it.

    Those are taken at both ends of what is swept too: it may be 0 with the parameters that it was given.
    """
    if isinstance(load, Record):
        return {"dt": float(load.dt), "samples_sha256": _digest(load.samples.tobytes())}
    values = {f.name: getattr(load, f.name) for f in fields(load) if f.init} if is_dataclass(load) else {}
    values = values if all(isinstance(x, int | float | str) for x in values.values()) else {}
    if values and type(load).__module__ == Record.__module__:
        return values
    swept = [axis for axis in plan.axes if axis.owner == "load" and len(axis.values)]
    ends = ({axis.key: float(axis.values[end]) for axis in swept} for end in ((0, -1) if swept else ()))
    loads = [load, *(replace(load, **own) for own in ends)]  # type: ignore[type-var]
    t = np.linspace(0.0, plan.t_end, INSTANTS)
    at = [values_at(one, t, finite=False) for one in loads]  # a run that meets a value that is not finite says so
    return values | {"samples_sha256": _digest(np.array(at).tobytes())}


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
