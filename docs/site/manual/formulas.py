"""An extension of Sphinx: formulas as MathML, and the directive `derived`, which renders what the derivation finds.

MathML needs neither a network nor TeX, scripts or fonts; all current browsers draw it. docutils converts the LaTeX that
SymPy prints.
"""

import re
from html import escape
from typing import Any

import substep_derive
import sympy
from docutils import nodes
from docutils.parsers.rst import directives
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

from . import ROOT

NAMES = {**vars(sympy), **{name: getattr(substep_derive, name) for name in substep_derive.__all__}}


LOGGER = logging.getLogger(__name__)


def mathml(node: nodes.Element, *, block: bool) -> str:
    """The node's formula as MathML; a warning, and the LaTeX itself, where docutils does not know what it holds."""
    latex = node.astext().replace(r"\rho_{inf}", r"\rho_{\infty}")  # how SymPy prints the symbol's name
    try:
        return re.sub(r"\n\s*", "", str(tex2mathml(latex, as_block=block)))
    except MathError as error:
        LOGGER.warning("expected LaTeX that docutils turns into MathML, got %r: %s", latex, error, location=node)
        return f"<code>{escape(latex)}</code>"


def inline(translator: Any, node: nodes.math) -> None:
    """Write a formula within a line."""
    translator.body.append(mathml(node, block=False))
    raise nodes.SkipNode


def displayed(translator: Any, node: nodes.math_block) -> None:
    """Write a formula on a line of its own."""
    translator.body.append(f'<div class="math">{mathml(node, block=True)}</div>\n')
    raise nodes.SkipNode


class Derived(SphinxDirective):
    """A formula computed while the page is built, with the expression that computes it below.

    The content is one Python expression in the public names of `substep_derive` and SymPy; a list gives a formula for
    each of its items. `:left:` is LaTeX that stands before them.
    """

    has_content = True
    option_spec = {"left": directives.unchanged}  # noqa: RUF012 (docutils reads it so)

    def run(self) -> list[nodes.Node]:
        """The formula and the expression. Raises an error of Sphinx where the expression fails."""
        self.env.note_dependency(str(ROOT / "generated" / "substep_kernels" / "stamp.txt"))
        source = "\n".join(self.content)
        try:
            value = eval(source, dict(NAMES))
        except Exception as error:
            raise self.error(f"expected a Python expression that can be computed, got {source!r}: {error!r}") from error
        left = f"{self.options['left']} " if "left" in self.options else ""
        texts = [left + sympy.latex(e, mat_delim="[") for e in (value if isinstance(value, list) else [value])]
        shown = nodes.paragraph("", "", nodes.literal(source, source), classes=["derived-by"])
        return [*(nodes.math_block(text, text, nowrap=False, number=None) for text in texts), shown]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer and the directive."""
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))
    app.add_directive("derived", Derived)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
