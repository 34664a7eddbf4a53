"""The declared schemes and scenes by name."""

from typing import Any

from .errors import DeclarationError
from .scene import Scene
from .scenes import ALL as SCENES
from .scheme import Scheme
from .schemes import ALL as SCHEMES


def find(scheme: str | Scheme) -> Scheme:
    """The scheme of that name; a declaration itself. Raises DeclarationError for an unknown name."""
    return scheme if isinstance(scheme, Scheme) else _named(scheme, "scheme", SCHEMES)


def find_scene(scene: str | Scene) -> Scene:
    """The scene of that name; a declaration itself. Raises DeclarationError for an unknown name."""
    return scene if isinstance(scene, Scene) else _named(scene, "scene", SCENES)


def _named(name: str, what: str, declared: tuple[Any, ...]) -> Any:
    found = {one.name: one for one in declared}
    if name not in found:
        raise DeclarationError(f"expected a {what}, one of: {', '.join(found)}; got '{name}'")
    return found[name]
