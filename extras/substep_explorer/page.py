"""The explorer: one HTML page with every scheme's stability functions and marches, which needs no server."""

import hashlib
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

SCHEMES = "generated/explorer.js"  # what is derived
CHARTS = "vendored/chart.umd.min.js"  # Chart.js, MIT
OWN = ("march.js", "numbers.js", "certificate.js", "model.js")  # what needs no browser
SCRIPTS = (CHARTS, SCHEMES, *OWN, "view.js")


def source(name: str) -> str:
    """The text of one of the page's files.

    Raises ValueError for a copy of Chart.js that is not the one whose digest is kept beside it.
    """
    here = files(__package__)
    text = here.joinpath(name).read_text(encoding="utf-8")
    if name == CHARTS:
        expected = here.joinpath("vendored/SHA256").read_text(encoding="utf-8").split()[0]
        got = hashlib.sha256(text.encode()).hexdigest()
        if got != expected:
            raise ValueError(f"expected {name} with the sha256 {expected}, got {got}; run make vendor")
    return text


def page() -> str:
    """The text of the page; the same sources give the same bytes."""
    environment = Environment(
        loader=PackageLoader(__package__, "."), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    texts = {name: source(name) for name in (*SCRIPTS, "style.css")}
    return environment.get_template("page.html").render(files=texts, scripts=SCRIPTS)


def write(path: Path) -> Path:
    """Write the page there, and return its path."""
    path.write_text(page(), encoding="utf-8", newline="\n")
    return path
