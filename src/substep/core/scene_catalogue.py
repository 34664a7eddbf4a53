"""Scenes by name: what the catalogue knows of each, and parameters, which are checked here, once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from ..derived import modules
from .entries import SceneInfo
from .errors import real_number, unknown_name
from .kernel_modules import loaded
from .laws import LAWS, tried
from .units import TURN, require_angle

if TYPE_CHECKING:
    from ..derived.modules import LawDeclaration, SceneDeclaration

SCENES: Mapping[str, Mapping[str, Any]] = loaded("scene_index").SCENES
OF_OSCILLATOR = ("f", "T")  # arguments that are no parameters of the declaration
WITH_LAW = "hysteretic_oscillator"  # takes law = a name of `laws`, or a declaration
STRAIN_MEASURES = {"green_lagrange": "elastic_pendulum", "engineering": "elastic_pendulum_engineering"}


def scenes() -> tuple[str, ...]:
    """Names of all scenes; one that differs only in the strain measure is an option of its scene.

    >>> "duffing" in ss.scenes()
    True
    """
    return tuple(name for name in SCENES if name not in STRAIN_MEASURES.values() or name == "elastic_pendulum")


def arguments_of(info: SceneInfo) -> tuple[str, ...]:
    """What `scene` takes as numbers: the parameters, what may stand in their place, and what xi is meant as."""
    more = (*(OF_OSCILLATOR if info.oscillator else ()), *(["overdamped"] if "xi" in info.parameters else []))
    return (*info.parameters, *(name for name in more if name not in info.parameters))


def with_omega(info: SceneInfo, given: Mapping[str, Any]) -> Mapping[str, Any]:
    """The parameters of a linear oscillator with omega, rad/s, in place of f, Hz, or T, s; else as they are."""
    if info.oscillator is None or "omega" not in info.parameters or {"f", "T"} & set(info.parameters):
        return given
    names = [name for name in ("omega", "f", "T") if name in given]
    if len(names) > 1:
        raise ValueError(
            f"expected exactly one of omega, rad/s, f, Hz, and T, s, of {info.name}, got {' and '.join(names)}; drop "
            "all but one"
        )
    if names in ([], ["omega"]):
        return given
    name = names[0]
    value = real_number(f"parameter {name} of {info.name}", given[name], positive=True)
    omega = TURN * value if name == "f" else TURN / value
    return {"omega": omega, **{key: x for key, x in given.items() if key != name}}


def scene_info(name: str | SceneDeclaration, parameters: dict[str, Any]) -> SceneInfo:
    """Description of a scene of the catalogue, or of the user's own, which is derived if it is not in the cache.

    Removes the strain measure, which decides between two scenes of the catalogue, from the parameters. Raises
    ValueError for an unknown name, DeclarationError for energies that do not define a motion.
    """
    if isinstance(name, str):
        if name not in SCENES:
            raise unknown_name("a scene", name, scenes(), "substep.scenes(), or `substep scenes`, lists all")
        if name == "elastic_pendulum" and "strain" in parameters:
            measure = parameters.pop("strain")
            if not isinstance(measure, str) or measure not in STRAIN_MEASURES:
                raise unknown_name("a strain measure", str(measure), STRAIN_MEASURES)
            name = STRAIN_MEASURES[measure]
        if name == WITH_LAW and (law := parameters.pop("law", "bilinear")) != "bilinear":
            return _with_law(law)
        return _in_catalogue(name)
    if not hasattr(name, "potential"):
        raise ValueError(
            f"expected a scene by name, handle or declaration, got {name!r}; substep.scenes() lists the names, "
            "and substep.structure(M, K) makes of matrices what can be marched"
        )
    for element in name.laws.values():
        tried(element.law)
    return _own(name)


def _own(declaration: SceneDeclaration) -> SceneInfo:
    module = modules.scene_module(declaration)
    return SceneInfo.of(declaration.name, module.ENTRY, module, declaration)


def _with_law(law: str | LawDeclaration) -> SceneInfo:
    """The oscillator with another law, by name or of the user's own; derived if it is not in the cache."""
    if isinstance(law, str):
        if law not in LAWS:
            raise unknown_name("a law", law, LAWS)
        return _with(law)
    if not hasattr(law, "update"):
        raise ValueError(f"expected law as a name of substep.laws() or a declaration, got {law!r}; give one of these")
    tried(law)
    return _with(law)


@cache
def _with(law: Any) -> SceneInfo:
    return _own(modules.oscillator_with(law))


@cache
def _in_catalogue(name: str) -> SceneInfo:
    return SceneInfo.of(name, SCENES[name])


def checked_parameters(
    info: SceneInfo, parameters: Mapping[str, Any], number: Callable[[str, Any], ArrayLike]
) -> dict[str, Any]:
    """All parameters, defaults filled in, as floats or, where `number` returns them, arrays."""
    for key in parameters:
        if key not in info.parameters:
            more = ["strain"] if info.name.startswith("elastic_pendulum") else []
            known = [*arguments_of(info), *more, "a0", *(["load"] if info.sampled else [])]
            raise unknown_name(f"a parameter of {info.name}", key, known)
    values: dict[str, Any] = {}
    for key, parameter in info.parameters.items():
        if key not in parameters and parameter.default is None and parameter.polynomial is None:
            others = "; T, s, or f, Hz, may stand in its place" if key == "omega" and info.oscillator else ""
            raise ValueError(
                f"expected a value for {key} of {info.name}, got none; give it by "
                f"ss.scene({info.name!r}, {key}=...), or as --{key.replace('_', '-')} in a command{others}"
            )
        what = f"parameter {key} of {info.name}"
        given = parameters[key] if key in parameters else parameter.default_of(info.name, values)
        value = parameter.inside(what, number(what, given))
        if key == "u0" and info.declaration is None and info.coordinates[0][1] == "rad":
            require_angle(what, value)
        values[key] = value if value.ndim else float(value)
    return values
