"""What a user has given for a scene, as the types that a declaration has: checked before anything is read from it."""

from typing import Any, Protocol

from sympy import Symbol

from .errors import DeclarationError
from .expressions import require_mapping
from .law import Element
from .parameter import require_parameters
from .reactions import Friction

BY_SYMBOL = ("coordinates", "start", "invariants", "forces", "load")  # mappings from symbols, and those from names
BY_NAME = ("laws", "constraints", "contacts", "frictions", "outputs")
OF = {"coordinates": (str, "units"), "laws": (Element, "elements of laws"), "frictions": (Friction, "a Friction")}


class _Given(Protocol):
    """A scene's declaration, as far as its types are looked at."""

    @property
    def name(self) -> Any: ...
    @property
    def parameters(self) -> Any: ...


def require_types(scene: _Given) -> None:
    """Raises DeclarationError for a name, parameters and mappings that are none, and for values of another type."""
    if not isinstance(scene.name, str):
        raise DeclarationError(f"expected the name of a scene as a text, got {scene.name!r}; name it")
    require_parameters(scene.name, scene.parameters)
    for fields, key in ((BY_SYMBOL, Symbol), (BY_NAME, str)):
        for field in fields:
            require_mapping(scene.name, field, getattr(scene, field), key, OF.get(field, (None, "expressions"))[1])
    for field, (kind, of) in OF.items():
        for name, x in getattr(scene, field).items():
            if not isinstance(x, kind):
                raise DeclarationError(
                    f"{scene.name}: expected {of} in {field}, got {x!r} of '{name}'; give "
                    f"{'a text such as m' if kind is str else f'{kind.__name__}(...)'}"
                )
