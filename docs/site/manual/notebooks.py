"""The notebooks, copied to where Sphinx finds them; it executes them."""

from . import ROOT

FOLDER = ROOT / "notebooks"


def copies() -> dict[str, str]:
    """Name of a notebook among the pages -> its text."""
    return {f"notebooks/{path.stem}": path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.py"))}
