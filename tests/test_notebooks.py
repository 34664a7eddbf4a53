"""Notebooks run from top to bottom, and their assertions hold."""

import runpy
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.py"))


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "# %% [markdown]" in text
    assert "assert " in text
    runpy.run_path(str(path), run_name="__main__")
