"""The declared schemes and scenes by name.

The catalogue is imported when something is looked up in it, and up to what is found: to declare it all takes longer
than to derive one scheme.
"""

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from sympy import Rational

from .errors import DeclarationError
from .law import Law
from .scene import Scene
from .scheme import Scheme

NEAREST = 5  # names that answer an unknown one


def find(scheme: str | Scheme) -> Scheme:
    """The scheme of that name; a declaration is returned as it is. Raises DeclarationError for anything else."""
    return scheme if isinstance(scheme, Scheme) else _named(scheme, "scheme", _schemes())


def find_scene(scene: str | Scene) -> Scene:
    """The scene of that name; a declaration is returned as it is. Raises DeclarationError for anything else."""
    return scene if isinstance(scene, Scene) else _named(scene, "scene", _scenes())


def find_law(law: str | Law) -> Law:
    """The law of that name; a declaration is returned as it is. Raises DeclarationError for anything else."""
    return law if isinstance(law, Law) else _named(law, "law", _laws())


def as_member(scheme: Scheme) -> tuple[str, dict[str, Rational]] | None:
    """(name, parameters) of the catalogue's scheme with the same step as a scheme without free parameters, or None.

    Candidates are found by name; relations, balances, report and start decide whether the step is the same.
    """
    for name in (scheme.name, scheme.parent):
        for declared in (one for one in _schemes() if one.name == name):
            values = {p.name: scheme.fixed[p.name] for p in declared.parameters if p.name in scheme.fixed}
            if len(values) == len(declared.parameters) and _same_step(declared.fix(values), scheme):
                return declared.name, values
    return None


def _schemes() -> Iterator[Scheme]:
    from .schemes import declared  # noqa: PLC0415

    return declared()


def _scenes() -> Iterator[Scene]:
    from .scenes import declared  # noqa: PLC0415

    return declared()


def _laws() -> Iterator[Law]:
    from .laws import declared  # noqa: PLC0415

    return declared()


def _same_step(one: Scheme, other: Scheme) -> bool:
    parts = ((s.relations, s.balances, s.report, s.start_scheme or s.start) for s in (one, other))
    return next(parts) == next(parts)


def _named(name: Any, what: str, declared: Iterator[Any]) -> Any:
    if not isinstance(name, str):
        raise DeclarationError(
            f"expected a {what} by name or as a declaration, got {name!r}; of a handle, pass its name, and its "
            "parameters beside it as text such as '1/5'"
        )
    others, meant = list[str](), list[Any]()
    for one in declared:
        if one.name == name:
            return one
        others.append(one.name)
        if name in getattr(one, "synonyms", ()):
            meant.append(one)
    if len(meant) == 1:
        return meant[0]
    if meant:
        which = " or ".join(f"'{one.name}'" for one in meant)
        raise DeclarationError(f"expected one {what}, got '{name}', which may be {which}; write which")
    near = get_close_matches(name, others, n=NEAREST, cutoff=0.3)
    cure = f"did you mean '{near[0]}'? near are: {', '.join(near)}; " if near else ""
    raise DeclarationError(f"expected a {what}, got '{name}'; {cure}`substep {what}s` lists all {len(others)}")
