"""Notebooks run from top to bottom, and their assertions hold."""

import os
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib import pyplot, rc_context

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.py"))
LONG = ("where_methods_fail", "where_contact_fails", "proofs", "inelastic", "constraints", "double_pendulum")
PLAIN = ("chosen_steps",)  # march so few steps with so many kernels that plain Python is done before these are compiled


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS
    assert {path.stem for path in NOTEBOOKS} >= set(PLAIN)


@pytest.mark.parametrize(
    "path",  # some compile schemes for long, one proves for some seconds: left to `make verify`
    [pytest.param(p, marks=[pytest.mark.thorough] * (p.stem in LONG)) for p in NOTEBOOKS],
    ids=lambda path: path.stem,
)
def test_notebook(path: Path) -> None:
    """Compiled, but for those that in the gate are quicker without; `make verify` compiles these too."""
    text = path.read_text(encoding="utf-8")
    assert "# %% [markdown]" in text
    assert "assert " in text
    if path.stem not in PLAIN or os.environ.get("SUBSTEP_VERIFY"):
        with rc_context():  # a notebook sets the style of its charts
            runpy.run_path(str(path), run_name="__main__")
        pyplot.close("all")
        return
    environment = {**os.environ, "MPLBACKEND": "Agg", "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, str(path)], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
