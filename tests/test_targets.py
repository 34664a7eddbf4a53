"""Every target of the Makefile, each in a fresh clone of its own: for `make verify`.

Packages come from the wheelhouse that `make verify` fills beside the environment, so that no test needs a network.
"""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
WHEELHOUSE = ROOT / ".venv" / "wheelhouse"
# what shows that a target has done its work; the two that run tests are given one file of them, benchmarks few rounds
DONE = {
    "install": ".venv/bin/substep",
    "derive": "generated/substep_kernels/stamp.txt",
    "derive-check": "generated/substep_kernels/stamp.txt",
    "reproduce": "results/index.html",
    "all": "results/index.html",
    "lint": ".import_linter_cache",
    "test": ".pytest_cache",
    "verify": ".venv/wheelhouse",
    "notebooks": "notebooks/pendulum.ipynb",
    "docs": "results/site/index.html",
    "bench": "results/bench.md",
    "clean": "Makefile",
}
DOWNLOADS = {"audits", "test-browser", "vendor"}  # programs, a browser's driver and Chart.js from the network


def phony() -> set[str]:
    """The targets that the Makefile names."""
    (line,) = re.findall(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    return set(line.split())


def test_no_target_is_left_out() -> None:
    assert set(DONE) | DOWNLOADS == phony()


@pytest.mark.thorough
@pytest.mark.long
@pytest.mark.parametrize("target", DONE)
def test_a_target_needs_nothing_but_a_fresh_clone(target: str, tmp_path: Path) -> None:
    assert WHEELHOUSE.exists(), "expected the wheelhouse of `make verify`; run `make .venv/wheelhouse`"
    clone = tmp_path / "clone"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
    theirs = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "SUBSTEP", "MAKE"))}
    mine = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(WHEELHOUSE), "SUBSTEP_CACHE": str(tmp_path / "cache")}
    if target in ("test", "verify"):
        mine["PYTEST_ADDOPTS"] = "tests/test_formulas.py"
    if target == "bench":
        mine["BENCH"] = "--quick"
    found = subprocess.run(
        ["make", target], cwd=clone, env={**theirs, **mine}, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stdout + found.stderr
    assert (clone / DONE[target]).exists()
    changed = subprocess.run(["git", "status", "--porcelain"], cwd=clone, capture_output=True, text=True, check=True)
    assert not changed.stdout, "a target changes no file of the repository, and leaves none that git does not ignore"
