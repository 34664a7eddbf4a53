"""README and docs: every block of Python, every command of `substep` and every example of a docstring runs.

The Python blocks of a file run in order as one program. A block that begins with a comment such as "# my_scheme.py"
is also a file of that name, which later blocks import. Commands are also parsed, those too that are not run.
"""

import inspect
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from all_commands import all_commands

import substep as ss
from substep.cli.arguments import exact_options
from substep.core.scene_catalogue import scene_info
from substep.core.schemes import scheme_info

ROOT = Path(__file__).parents[1]
LONG = (
    "adding_a_scene",
    "auditing",
    "choose",
    "constraints_and_contact",
    "contact_map",
    "design",
    "going_on",
    "large_sweeps",
    "laws",
    "questions",
    "spectra",
    "structures",
    "sweeps",
)  # pages whose blocks take long: left to `make verify`
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
NOT_RUN = (  # beginnings of commands that the pages show and that are parsed only
    "substep reproduce",  # draws everything, which takes minutes; test_cli draws less
    "substep chart work-precision",  # runs every scheme in many steps, which takes minutes
    "substep failures",  # runs every scheme on many scenes, which takes minutes
    "substep failure-map",  # serves until it is stopped, or makes millions of runs
    "substep claims",  # computes for a dozen seconds
    "substep choose",  # compiles and runs many schemes, for a quarter of a minute and more; test_cli_choose asks less
    "substep audit opensees",  # needs the program
)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LANGUAGES = {"python", "sh", "bash"}
# of pages, each of several in a fork of one process that has imported what nearly all of them do
PROGRAMS = """
import json, os, runpy, sys, warnings
import matplotlib.pyplot, substep, substep_derive
def run(folder, name):
    os.chdir(folder)
    sys.path.insert(0, folder)
    os.environ["PYTHONPATH"] = os.pathsep.join([folder, os.environ["PYTHONPATH"]])  # for processes that it starts
    warnings.filterwarnings("error", category=DeprecationWarning, module="__main__")
    runpy.run_path(name, run_name="__main__")
failed, programs = [], json.loads(sys.argv[1])
if len(programs) == 1:
    sys.exit(run(*programs[0]))
for folder, name in programs:
    if not (child := os.fork()):
        run(folder, name)
        sys.exit()
    if os.waitpid(child, 0)[1]:
        failed.append(name)
sys.exit(" ".join(failed) or 0)
"""
COMMANDS = """
import json, shlex, sys
from typer.testing import CliRunner
from substep.cli.commands import app
results = {line: CliRunner().invoke(app, shlex.split(line, comments=True)[1:]) for line in json.loads(sys.argv[1])}
print(json.dumps({line: r.output + repr(r.exception) for line, r in results.items() if r.exit_code}))
"""
EXAMPLES = """
import doctest, inspect, json
import numpy, substep, substep_derive
found, runner = {}, doctest.DocTestRunner()
for package in (substep, substep_derive):
    for name, x in ((name, getattr(package, name)) for name in dir(package)):
        for test in doctest.DocTestFinder().find(x, name) if inspect.isclass(x) or inspect.isfunction(x) else ():
            test.globs = {"ss": substep, "np": numpy, **vars(substep_derive)}
            found[test.name] = [len(test.examples), runner.run(test).failed]
print(json.dumps(found))
"""


def blocks(page: Path, *languages: str) -> list[tuple[int, str]]:
    """(line of its first line, text) of each block in one of these languages."""
    text = page.read_text(encoding="utf-8")
    found = [(text.count("\n", 0, b.start(2)), b[2]) for b in FENCE.finditer(text) if b[1] in languages]
    return [(line + 1, block) for line, block in found]


def commands(page: Path) -> list[str]:
    """Command lines of `substep`: lines of shell blocks, and code between single backticks."""
    text = page.read_text(encoding="utf-8")
    lines = [line for _, block in blocks(page, "sh", "bash") for line in block.splitlines()]
    return [x for x in [*lines, *re.findall(r"`(substep [^`\n]+)`", FENCE.sub("", text))] if x.startswith("substep ")]


def run_apart(program: str, *arguments: str, folder: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """A program of Python run in a folder of its own, with `more` in its environment."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), **more}
    command = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


def test_the_lists_name_pages_that_are_there() -> None:
    """A page that is renamed would run in the gate with nobody noticing."""
    assert {*LONG} <= {page.stem for page in WITH_PYTHON}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_block_has_a_language(page: Path) -> None:
    marks = re.findall(r"^```(.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(marks) % 2 == 0
    assert set(marks[::2]) <= LANGUAGES
    assert set(marks[1::2]) <= {""}


WITH_PYTHON = [page for page in PAGES if blocks(page, "python")]
SHORT = [page for page in WITH_PYTHON if page.stem not in LONG]
TOGETHER = [
    *([pytest.param(SHORT, id="short")] if hasattr(os, "fork") else [pytest.param([p], id=p.stem) for p in SHORT]),
    *(pytest.param([p], id=p.stem, marks=pytest.mark.thorough) for p in WITH_PYTHON if p.stem in LONG),
]


@pytest.mark.long
@pytest.mark.parametrize("pages", TOGETHER)
def test_python_blocks_run(pages: list[Path], tmp_path: Path) -> None:
    """In the gate without compiling, for other tests do that; compiled in `make verify`."""
    programs = []
    for page in pages:
        folder = tmp_path / page.stem
        folder.mkdir()
        lines: list[str] = []  # each line of the program has the number that it has in the page
        for first, block in blocks(page, "python"):
            lines += [""] * (first - 1 - len(lines)) + block.splitlines()
            if named := re.match(r"# (\w+\.py)\b", block):
                (folder / named[1]).write_text(block, encoding="utf-8")
        lines += ["assert 'r' not in vars() or r.status == 'completed'"]  # the response, where the page has one
        programs.append((str(folder), f"{page.stem}_blocks.py"))
        Path(*programs[-1]).write_text("\n".join(lines), encoding="utf-8")
    plain = {} if os.environ.get("SUBSTEP_VERIFY") else {"NUMBA_DISABLE_JIT": "1"}
    run_apart(PROGRAMS, json.dumps(programs), folder=tmp_path, MPLBACKEND="Agg", **plain)


def test_the_front_page_has_a_picture_ten_lines_and_four_questions() -> None:
    """In this order; its blocks of Python stand alone, since a visitor copies one."""
    text = PAGES[0].read_text(encoding="utf-8")
    programs = [block for _, block in blocks(PAGES[0], "python")]
    assert all(block.startswith("import ") for block in programs)
    assert len([line for line in programs[0].splitlines() if line]) == 10
    _, _, after = text.partition("## Four questions\n")
    assert text.index("![") < text.index(programs[0]) < text.index(after)
    asked = re.findall(r"^\| ([A-Z][^|]+\?) \| `substep ", after.partition("\n## ")[0], re.MULTILINE)
    assert asked == ["Which scheme?", "Is it stable?", "How large a step?", "What does my program do?"]


def parameters() -> set[str]:
    """Names of all parameters of schemes, their families and scenes: options of commands that take these."""
    schemes = [scheme_info(name) for name in ss.schemes()]
    return {key for s in schemes for key in (*s.parameters, *s.families)} | {
        key for name in ss.scenes() for key in scene_info(name, {}).parameters
    }


@pytest.mark.parametrize("page", [p for p in PAGES if commands(p)], ids=lambda page: page.stem)
def test_commands_are_taken_by_the_command_line(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Parsed, not run: the command is there, and so are its options."""
    monkeypatch.chdir(tmp_path)
    taken, known = all_commands(), parameters()
    for line in commands(page):
        _, name, *arguments = shlex.split(line, comments=True)
        assert name in taken, line
        context = taken[name].make_context(name, arguments)
        assert exact_options(context.args).keys() <= known, line


def files_that_pages_name(folder: Path) -> None:
    """A ground motion, and a declaration of one's own."""
    t = np.arange(200) * 0.02
    np.savetxt(folder / "motion.txt", np.column_stack([t, np.sin(9 * t)]))
    head = "PEER\n\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 200, DT= .0200 SEC\n"
    (folder / "motion.AT2").write_text(head + "\n".join(f"{x:.7e}" for x in np.sin(9 * t)), encoding="utf-8")
    declared = "from substep_derive.declare.schemes.newmark import newmark as my_scheme\n"
    (folder / "my_schemes.py").write_text(declared, encoding="utf-8")


@pytest.mark.thorough
def test_commands_run(tmp_path: Path) -> None:
    """Lines of shell blocks, all but `NOT_RUN`, in one process; the kernels that they call are compiled ahead."""
    shown = [x for page in PAGES for _, block in blocks(page, "sh", "bash") for x in block.splitlines()]
    shown = [x for x in shown if x.startswith("substep ")]
    assert all(any(x.startswith(beginning) for x in shown) for beginning in NOT_RUN)
    files_that_pages_name(tmp_path)
    run = list(dict.fromkeys(shlex.join(shlex.split(x, comments=True)) for x in shown if not x.startswith(NOT_RUN)))
    assert len(run) > 15
    failed = json.loads(run_apart(COMMANDS, json.dumps(run), folder=tmp_path).stdout)
    assert failed == {}


def test_examples_of_docstrings_run(tmp_path: Path) -> None:
    done = run_apart(EXAMPLES, folder=tmp_path, NUMBA_DISABLE_JIT="1")
    *reports, last = done.stdout.splitlines()
    found = json.loads(last)
    assert [name for name, (_, failed) in found.items() if failed] == [], reports
    with_examples = {name for name, (count, _) in found.items() if count}
    public = {name for name in dir(ss) if inspect.isfunction(getattr(ss, name))}
    assert with_examples >= public | {"certify", "derive", "Scheme.stability"}


@pytest.mark.parametrize("line", ["substep nosuch", "substep show bathe --nosuch", "substep run duffing bathe --dt 1"])
def test_a_wrong_command_is_found(line: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"```sh\n{line}  # wrong\n```\n", encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch, pytest.raises(Exception, match="nosuch|t_end"):
        test_commands_are_taken_by_the_command_line(page, tmp_path, patch)
