"""Settings of Sphinx: `make docs` builds the site from docs/ and from what `manual` writes into docs/generated/."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

from jupyter_client.manager import KernelManager
from sphinx.application import Sphinx
from substep_explorer.page import write as write_explorer

sys.path.insert(0, str(Path(__file__).parent))

import manual
from manual import docstrings

project = "substep"
author = "the substep maintainers"
project_copyright = author
version = release = version_of("substep")

extensions = ["myst_nb", "sphinx.ext.autodoc", "manual.formulas"]
exclude_patterns = ["site/**"]
root_doc = "index"

html_theme = "furo"
html_title = "substep"
html_static_path = [str(Path(__file__).with_name("static"))]
html_css_files = ["wide.css"]
html_math_renderer = "mathml"
html_show_copyright = False
pygments_style, pygments_dark_style = "friendly", "monokai"

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3

nb_custom_formats = {".py": ["jupytext.reads", {"fmt": "py:percent"}]}
nb_execution_mode = "cache"  # a notebook runs again when its code or the package has changed
nb_execution_cache_path = str(manual.RESULTS / "notebooks" / manual.sources_digest())
nb_execution_raise_on_error = True
nb_execution_timeout = 900
nb_merge_streams = True
KernelManager.transport_encryption.default_value = "auto"  # else ipykernel warns of plain text, once a notebook

default_role = "py:obj"  # docstrings name objects between single backticks
suppress_warnings = ["ref.python"]  # both packages have a Scheme and a Scene: see the glossary
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
toc_object_entries_show_parents = "all"  # two functions are called choose


def setup(app: Sphinx) -> None:
    """Write the generated pages before Sphinx looks for files, and the explorer beside the pages that it has made."""
    app.connect("builder-inited", lambda app: manual.write(Path(app.srcdir) / "generated"))
    app.connect("build-finished", lambda app, error: error or write_explorer(Path(app.outdir) / "explore.html"))
    app.connect("autodoc-process-docstring", docstrings.as_rst)
    app.connect("autodoc-process-signature", docstrings.as_written)
