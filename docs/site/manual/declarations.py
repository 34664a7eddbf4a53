"""The source text of a declaration, with what it needs of its own module."""

import ast
import inspect
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from . import ROOT


def declaration(declared: Any, package: ModuleType) -> tuple[str, str]:
    """(path in the repository, source text) of a scheme's or a scene's declaration in the package's modules.

    The text holds the assignment and, before it, the names of the same module that it is made from. Raises LookupError
    for what no module of the package declares.
    """
    for module in (
        m for m in vars(package).values() if inspect.ismodule(m) and m.__name__.startswith(package.__name__)
    ):
        path = Path(inspect.getfile(module))
        defined = _defined(path)
        own = [name for name, value in vars(module).items() if value is declared and name in defined]
        if own:
            text = path.read_text(encoding="utf-8").splitlines()
            nodes = sorted(_needed(defined[own[0]][-1], defined, set()), key=lambda node: node.lineno)
            return path.relative_to(ROOT).as_posix(), _joined(nodes, text)
    raise LookupError(f"expected a declaration of {package.__name__}, got {declared.name}; add it to a module there")


@cache
def _defined(path: Path) -> Mapping[str, list[ast.stmt]]:
    """Name -> statements at the top of the module that define it, in their order."""
    found: dict[str, list[ast.stmt]] = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        targets = node.targets if isinstance(node, ast.Assign) else ()
        names = [x.id for target in targets for x in ast.walk(target) if isinstance(x, ast.Name)]
        for name in [node.name] if isinstance(node, ast.FunctionDef) else names:
            found.setdefault(name, []).append(node)
    return found


def _needed(node: ast.stmt, defined: Mapping[str, list[ast.stmt]], seen: set[ast.stmt]) -> set[ast.stmt]:
    """The statement and those before it that define what it reads, added to those seen."""
    if node not in seen:
        seen.add(node)
        for name in {x.id for x in ast.walk(node) if isinstance(x, ast.Name) and isinstance(x.ctx, ast.Load)}:
            for before in [x for x in defined.get(name, ()) if x.lineno < node.lineno][-1:]:
                _needed(before, defined, seen)
    return seen


def _joined(nodes: list[ast.stmt], lines: list[str]) -> str:
    """The statements' lines; an empty line stands for what is left out between them."""
    parts, end = [], 0
    for node in nodes:
        if end and node.lineno > end + 1:
            parts.append("")
        parts += lines[node.lineno - 1 : node.end_lineno]
        end = node.end_lineno or node.lineno
    return "\n".join(parts)
