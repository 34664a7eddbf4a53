"""Small printing tools of the emitters."""

from collections.abc import Iterable
from string import Formatter

from sympy.printing.pycode import PythonCodePrinter

PRINTER = PythonCodePrinter({"fully_qualified_modules": False})


def fill(template: str, **fields: object) -> str:
    """str.format that also refuses fields the template does not use."""
    wanted = {name for _, name, _, _ in Formatter().parse(template) if name}
    if wanted != set(fields):
        raise KeyError(f"template wants {sorted(wanted)}, got {sorted(fields)}")
    return template.format(**fields)


def literal_tuple(items: Iterable[str]) -> str:
    """Text of a tuple of the items' texts."""
    return "(" + "".join(f"{item}, " for item in items).rstrip() + ")"
