"""The languages a scheme is printed in: SymPy's printer of each, and how a comment begins."""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from sympy import Expr, Float, Rational
from sympy.printing.c import C99CodePrinter
from sympy.printing.codeprinter import CodePrinter
from sympy.printing.fortran import FCodePrinter
from sympy.printing.jscode import JavascriptCodePrinter
from sympy.printing.julia import JuliaCodePrinter
from sympy.printing.octave import OctaveCodePrinter
from sympy.printing.pycode import PythonCodePrinter

TEMPLATES = Path(__file__).parent / "templates"
# reserved in a language whose printer of SymPy's does not know them
KEYWORDS = """
    arguments await baremodule begin catch class const debugger delete do else elseif end enum eval export extends
    finally for function global if implements import in instanceof interface let local macro module mutable new null
    otherwise package parfor persistent private protected public quote return spmd static struct super switch this
    throw true false try typeof unwind_protect using var void while with yield
"""
LARGEST = 2**31 - 1  # a whole number that is larger is no literal of every language
ENVIRONMENT = Environment(
    loader=FileSystemLoader(TEMPLATES), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    keep_trailing_newline=True,
)  # fmt: skip


@dataclass(frozen=True)
class Language:
    """One language: its name, the suffix of its files, what a comment begins with, and SymPy's printer."""

    name: str
    suffix: str
    comment: str
    printer: Callable[[], CodePrinter]

    @cached_property
    def words(self) -> frozenset[str]:
        """Keywords, and every word of the templates, in small letters: names that a scheme's symbols must not take.

        What a template says to the program that fills it in, and comments that fill their line, do not count.
        """
        sources = [ENVIRONMENT.loader.get_source(ENVIRONMENT, name)[0] for name in self._templates]  # type: ignore[union-attr]
        code = re.sub(r"{%.*?%}|{{.*?}}|{#.*?#}", " ", "\n".join(sources), flags=re.DOTALL)
        code = re.sub(rf"^ *{re.escape(self.comment)}.*", "", code, flags=re.MULTILINE)
        return frozenset(re.findall(r"[a-z_]\w*", f"{KEYWORDS}{code}".lower()))

    @property
    def _templates(self) -> list[str]:
        return [name for name in ENVIRONMENT.list_templates() if name.split(".")[0] == self.name]

    def text(self, names: Iterable[str], functions: Iterable[str] = ()) -> Callable[[Expr], str]:
        """A function from expressions to their text.

        names: of symbols, which get a suffix if the template has them. functions: that the template defines.
        """
        printer = self.printer()
        printer.known_functions = {**printer.known_functions, **{name: name for name in functions}}
        printer.reserved_words = printer.reserved_words | {name for name in names if name.lower() in self.words}

        def text(e: Expr) -> str:
            long = {x: Float(x, 17) for x in e.atoms(Rational) if max(abs(x.p), x.q) > LARGEST}
            return printer.doprint(e.xreplace(long))

        return text

    def file(self, fields: Mapping[str, Any], part: str = "") -> str:
        """The template, or the one of that part, filled in."""
        return ENVIRONMENT.get_template(f"{self.name}.{part}.j2" if part else f"{self.name}.j2").render(fields)


LANGUAGES = {
    language.name: language
    for language in (
        Language("c", "c", "//", C99CodePrinter),
        Language("fortran", "F90", "!", lambda: FCodePrinter({"source_format": "free", "standard": 2008})),
        Language("julia", "jl", "#", JuliaCodePrinter),
        Language("javascript", "js", "//", JavascriptCodePrinter),
        Language("matlab", "m", "%", OctaveCodePrinter),
        Language("python", "py", "#", PythonCodePrinter),
    )
}
