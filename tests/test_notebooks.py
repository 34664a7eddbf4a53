"""Notebooks run from top to bottom, and their assertions hold."""

import runpy
from pathlib import Path

import pytest
from matplotlib import pyplot, rc_context

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.py"))
LONG = (
    "where_methods_fail", "where_contact_fails", "proofs", "inelastic", "constraints", "double_pendulum",
    "chosen_steps", "speed_against_accuracy", "structures",
)  # fmt: skip


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS
    assert {path.stem for path in NOTEBOOKS} > set(LONG)


@pytest.mark.parametrize(
    "path",  # some compile schemes for long, one proves for some seconds: left to `make verify`
    [pytest.param(p, marks=[pytest.mark.thorough] * (p.stem in LONG)) for p in NOTEBOOKS],
    ids=lambda path: path.stem,
)
def test_notebook(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "# %% [markdown]" in text
    assert "assert " in text
    with rc_context():  # a notebook sets the style of its charts
        runpy.run_path(str(path), run_name="__main__")
    pyplot.close("all")
