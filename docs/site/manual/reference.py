"""The reference: every public name of `substep` and `substep_derive`, from its docstring."""

import inspect
import pkgutil
import re
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import substep_derive

import substep as ss

from .markdown import toctree

PACKAGES: dict[str, tuple[ModuleType, str]] = {
    "substep": (ss, "The runtime: `import substep as ss`."),
    "substep_derive": (substep_derive, "The derivation, and the nouns with which schemes and scenes are declared."),
}

FURTHER = "further"
DOTTED = re.compile(r"`(substep(?:_derive)?(?:\.\w+)+)`")
# what the symbols stand for that declarations are written in; `K_t`, `N`, `N_discrete` and `f` are functions of them
SYMBOLS = {
    "C": "Damping of the equation of motion M a + C v + N(u) = f(t).",
    "e": "In a law: the elongation.",
    "e_dot": "In a law: the rate of the elongation.",
    "elapsed": "In a law: the time since what it remembers was last committed.",
    "h": "The time step.",
    "K0": "Tangent stiffness at the start of the march, which coefficients that depend on the structure read.",
    "M": "Mass of the equation of motion.",
    "Omega": "ω h, the angle by which an undamped oscillator of the frequency ω turns in a step.",
    "sampled": "In a scene: the load that the user gives as a function of time.",
    "t": "In a scene: the time.",
    "xi": "The damping ratio.",
}


def public_names(module: ModuleType) -> list[str]:
    """The public names of one of the packages, those that the extras bring to it among them."""
    return dir(module) if module is ss else list(module.__all__)


def pages() -> dict[str, Callable[[Path], str]]:
    """Name of a page -> its text."""
    own = {f"reference/{name}": lambda _, name=name: page(name) for name in PACKAGES}
    return {"reference/index": lambda _: index(), **own, f"reference/{FURTHER}": lambda _: further_page()}


def index() -> str:
    """The two packages, and what their docstrings name besides."""
    return "\n".join(["# Reference", "", *toctree([*PACKAGES, FURTHER], depth=2)])


def page(package: str) -> str:
    """All public names of a package, functions first."""
    module, about = PACKAGES[package]
    lines = [f"# {package}", "", about, ""]
    for title, kind in (("Functions", "function"), ("Classes", "class"), ("Symbols", "data")):
        names = [
            name for name in sorted(public_names(module), key=str.lower) if directive(getattr(module, name)) == kind
        ]
        if names:
            lines += [f"## {title}", "", "```{eval-rst}"]
            lines += [line for name in names for line in entry(package, name, kind)]
            lines += ["```", ""]
    return "\n".join(lines)


def further() -> dict[str, Any]:
    """Dotted name -> function or class that a docstring of a public name, or of one found so, refers to.

    Raises LookupError for a docstring that refers to what there is not.
    """
    found: dict[str, Any] = {}
    public = {
        f"{package}.{name}": getattr(module, name)
        for package, (module, _) in PACKAGES.items()
        for name in public_names(module)
    }
    waiting = list(public.values())
    while waiting:
        value = waiting.pop()
        members = [x for key, x in vars(value).items() if not key.startswith("_")] if inspect.isclass(value) else []
        for text in (inspect.getdoc(x) or "" for x in (value, *members)):
            for name in DOTTED.findall(text):
                if name not in public and name not in found and name not in PACKAGES:
                    found[name] = resolved(name)
                    waiting.append(found[name])
    own = [id(value) for value in public.values()]  # which may be named by the module that defines it, too
    return {name: x for name, x in sorted(found.items()) if not inspect.ismodule(x) and id(x) not in own}


def resolved(name: str) -> Any:
    """The object of a dotted name. Raises LookupError if there is none."""
    try:
        return pkgutil.resolve_name(name)
    except (ImportError, AttributeError) as error:
        raise LookupError(
            f"expected an object that a docstring can refer to, got `{name}`; correct the name"
        ) from error


def further_page() -> str:
    """What docstrings of public names refer to."""
    lines = [
        "# Further functions",
        "",
        "Those that the public names refer to for options and results.",
        "",
        "```{eval-rst}",
    ]
    for name, value in further().items():
        lines += entry(*name.rsplit(".", 1), directive(value))
    return "\n".join([*lines, "```", ""])


def entry(package: str, name: str, kind: str) -> list[str]:
    """Lines of one name: from its docstring, a symbol's from SYMBOLS. Raises KeyError for a symbol not explained."""
    if kind == "data":
        return [f".. py:data:: {package}.{name}", "", f"   {SYMBOLS[name]}", ""]
    return [f".. auto{kind}:: {package}.{name}", *["   :members:"] * (kind == "class"), ""]


def directive(value: object) -> str:
    """The kind of entry that a public name has."""
    if inspect.isclass(value):
        return "class"
    return "function" if inspect.isfunction(value) else "data"
