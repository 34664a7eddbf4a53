"""Every target of the Makefile in a fresh clone: what it installs first, and, in `make verify`, that it does its work.

Packages come from the wheelhouse that `make verify` fills beside the environment, so that no test needs a network.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
WHEELHOUSE = ROOT / ".venv" / "wheelhouse"
# in this order in one clone, and what shows that each has done its work; the one that runs tests is given one file of
# them, benchmarks few rounds
DONE = {
    "all": "results/index.html",
    "lint": ".import_linter_cache",
    "test": ".pytest_cache",
    "notebooks": "notebooks/pendulum.ipynb",
    "bench": "results/bench.md",
    "clean": "Makefile",
}
PARTS = {"install", "derive", "reproduce"}  # of `all`
ELSEWHERE = {"derive-check", "docs", "verify"}  # what they do is what other tests of `make verify` do, and itself
DOWNLOADS = {"audits", "test-browser", "vendor"}  # programs, a browser's driver and Chart.js from the network
# programs that each installation brings
BRINGS = {
    "install -e . -e extras": {"substep"},
    "install -e '.[dev]'": {"jupytext", "lint-imports", "pyright", "pytest", "ruff"},
    "install -e '.[docs]'": {"sphinx-build"},
}


def phony() -> set[str]:
    """The targets that the Makefile names."""
    (line,) = re.findall(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    return set(line.split())


def test_no_target_is_left_out() -> None:
    assert set(DONE) | PARTS | ELSEWHERE | DOWNLOADS == phony()


@pytest.mark.parametrize("target", sorted(phony() - {"audits", "clean", "test-browser"}))  # those ask for programs
def test_a_target_installs_what_it_calls(target: str, tmp_path: Path) -> None:
    """In a folder without an environment every program of it comes from what is installed before."""
    for name in ("Makefile", "pyproject.toml", "extras/pyproject.toml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    asked = ["make", "--dry-run", target]
    lines = subprocess.run(asked, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.splitlines()
    here = {"python"} if any("-m venv" in line for line in lines) else set[str]()
    for line in lines:
        called = set(re.findall(r"\.venv/bin/([\w-]+)", line))
        here |= {program for extra, brought in BRINGS.items() if extra in line for program in brought}
        assert called <= here, f"{target}: {line}"
    assert here


@pytest.mark.thorough
@pytest.mark.long
def test_every_target_does_its_work_in_a_fresh_clone(tmp_path: Path) -> None:
    assert WHEELHOUSE.exists(), "expected the wheelhouse of `make verify`; run `make .venv/wheelhouse`"
    clone = tmp_path / "clone"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
    theirs = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "SUBSTEP", "MAKE"))}
    mine = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(WHEELHOUSE), "SUBSTEP_CACHE": str(tmp_path / "cache")}
    mine |= {"PYTEST_ADDOPTS": "tests/test_formulas.py", "BENCH": "--quick"}
    run = {"cwd": clone, "capture_output": True, "text": True}
    for target, shows in DONE.items():
        found = subprocess.run(["make", target], **run, env={**theirs, **mine}, check=False)
        assert found.returncode == 0, found.stdout + found.stderr
        assert (clone / shows).exists()
        changed = subprocess.run(["git", "status", "--porcelain"], **run, check=True).stdout
        assert not changed, f"{target} changes files of the repository, or leaves some that git does not ignore"
