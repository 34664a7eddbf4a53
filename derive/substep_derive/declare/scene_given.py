"""What a user has given for a scene, as the types that a declaration has: checked before anything is read from it."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, cast

from sympy import Symbol

from .errors import DeclarationError
from .law import Element
from .parameter import Parameter
from .reactions import Friction

BY_SYMBOL = ("coordinates", "start", "invariants", "forces", "load")  # mappings from symbols, and those from names
BY_NAME = ("laws", "constraints", "contacts", "frictions", "outputs")
OF = {"coordinates": "units", "laws": "elements of laws", "frictions": "a Friction"}  # what they lead to, if not ...


class _Given(Protocol):
    """A scene's declaration, as far as its types are looked at."""

    @property
    def name(self) -> Any: ...
    @property
    def parameters(self) -> Any: ...


def require_types(scene: _Given) -> None:
    """Raises DeclarationError for a name, parameters and mappings that are none, and for keys of another type."""
    if not isinstance(scene.name, str):
        raise DeclarationError(f"expected the name of a scene as a text, got {scene.name!r}; name it")
    given, listed = scene.parameters, isinstance(scene.parameters, tuple | list)
    parameters = cast(Sequence[Any], given) if listed else ()
    if not listed or not all(isinstance(p, Parameter) for p in parameters):
        raise DeclarationError(
            f"{scene.name}: expected parameters as a tuple of required(...) and optional(...), got {given!r}; write "
            "parameters=(optional(k, 1),)"
        )
    known = set[Symbol]()
    for p in cast(Sequence[Parameter], parameters):
        if unknown := sorted(p.default_symbols - known, key=str):
            raise DeclarationError(
                f"{scene.name}: expected the default of {p.name} in parameters declared before it, got "
                f"'{unknown[0]}'; declare that first"
            )
        known.add(p.symbol)
    for field, kind, example in (
        *((x, Symbol, "{x: ...} of x = Symbol('x')") for x in BY_SYMBOL), *((x, str, "{'name': ...}") for x in BY_NAME)
    ):  # fmt: skip
        mapping = getattr(scene, field)
        keys = cast(Mapping[Any, Any], mapping) if isinstance(mapping, Mapping) else [mapping]
        if wrong := [key for key in keys if keys is not mapping or not isinstance(key, kind)]:
            of = OF.get(field, "expressions")
            raise DeclarationError(
                f"{scene.name}: expected {field} as a mapping from {'symbols' if kind is Symbol else 'names'} to {of}, "
                f"got {wrong[0]!r}; write {example}"
            )
    for field, kind in (("coordinates", str), ("laws", Element), ("frictions", Friction)):
        for key, x in getattr(scene, field).items():
            if not isinstance(x, kind):
                raise DeclarationError(
                    f"{scene.name}: expected {OF[field]} in {field}, got {x!r} of '{key}'; give "
                    f"{'a text such as m' if kind is str else f'{kind.__name__}(...)'}"
                )
