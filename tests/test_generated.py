"""generated/ is what the declarations emit, whatever the session; hand edits and stale files are found."""

import ast
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import plain_kernels
import pytest
from declared import ALL, BY_NAME
from declared import COMMITTED as OWN_MODULES
from plain_kernels import kinds
from substep_derive import __main__ as command
from substep_derive import written
from substep_derive.__main__ import GENERATED
from substep_derive.declare import laws, scenes
from substep_derive.emit import stamp
from substep_derive.emit.operations import function_costs
from substep_derive.emit.printing import fill
from substep_derive.package import COMMITTED, ON_FIRST_USE
from substep_explorer.derive import __main__ as explorer
from substep_thesis.derive import __main__ as thesis

import substep as ss

CURE = "run `make derive` and commit the result"


def derive_module(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "substep_derive", *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


# how eigenvalues are found; of the last, bdf4 alone takes half a minute
KINDS = ["eigenvalues_2", "eigenvalues_2_twice", "eigenvalues_3", "eigenvalues_3_twice"]
SESSIONS = [{"PYTHONHASHSEED": "20151", "SYMPY_GROUND_TYPES": "flint"}]
if os.environ.get("SUBSTEP_VERIFY"):
    SESSIONS += [{"PYTHONHASHSEED": "1", "SYMPY_GROUND_TYPES": "python"}]


@pytest.fixture
def derived(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command's derivation gives the committed text; that it does is tested in processes of their own."""
    committed = {name: (GENERATED / name).read_text() for name in written.files_in(GENERATED)}
    monkeypatch.setattr(command, "package", lambda *_: committed)


@pytest.fixture
def tampered(tmp_path: Path) -> Path:
    """A copy of generated/ with a file edited by hand, one missing and one that no declaration emits."""
    folder = tmp_path / "substep_kernels"
    shutil.copytree(GENERATED, folder, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "gone.py").write_text("# a scheme that is no longer declared\n")
    edited = folder / "schemes" / "bathe.py"
    edited.write_text(edited.read_text() + "# edited by hand\n")
    (folder / "operations.md").write_text((folder / "operations.md").read_text().replace("| 7 |", "| 6 |", 1))
    (folder / "schemes" / "newmark.py").unlink()
    return folder


# prints the digests of the files that schemes have of their own, of the schemes named
PART = """
import hashlib, sys
from substep_derive.declare.scenes import declared
from substep_derive.declare.catalogue import find
from substep_derive.package import package
for name, text in package([find(name) for name in sys.argv[1:]], declared()).items():
    if name.partition("/")[0] in ("schemes", "plans", "scenes", "shared", "pairs"):
        print(name, hashlib.sha256(text.encode()).hexdigest())
"""


@pytest.mark.long
def test_what_a_scheme_of_each_kind_has_of_its_own_is_what_is_derived() -> None:
    """The gate's part of the next test, which takes minutes; that of all files is the stamp: see below."""
    alike = ([n for n, k in kinds().items() if k[0] == kind and n in OWN_MODULES] for kind in KINDS)
    names = [min(names, key=lambda n: len(BY_NAME[n].balances), default="") for names in alike]
    found = subprocess.run(
        [sys.executable, "-c", PART, *filter(None, names)],
        env={**os.environ, **SESSIONS[0]}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    lines = [line.split() for line in found.stdout.splitlines()]
    assert len(lines) > 2 * len(names)
    for name, digest in lines:
        assert digest == hashlib.sha256((GENERATED / name).read_bytes()).hexdigest(), f"{name}: {CURE}"


@pytest.mark.thorough
@pytest.mark.parametrize("environment", SESSIONS, ids=str)
def test_committed_text_is_what_is_derived_and_nothing_else_passes(environment: dict[str, str], tampered: Path) -> None:
    found = derive_module("--check", "--folder", str(tampered), **environment)
    assert found.returncode == 1
    head, *lines = found.stdout.splitlines()
    assert CURE in head
    assert [line.split(",")[0].strip() for line in lines] == [
        "schemes/newmark.py: missing",
        "gone.py: stale",
        "operations.md: differs from what its declaration emits",
        "schemes/bathe.py: differs from what its declaration emits",
    ]


EXTRAS = {"explorer": (explorer, explorer.SOURCES), "thesis": (thesis, (thesis.HERE,))}


@pytest.mark.parametrize("name", EXTRAS)
def test_what_the_extras_derive_has_the_stamp_of_its_generator(name: str, tmp_path: Path) -> None:
    derives, sources = EXTRAS[name]
    folder = tmp_path / "generated"
    shutil.copytree(derives.GENERATED, folder, ignore=shutil.ignore_patterns("__pycache__"))
    assert written.up_to_date(folder, *sources)
    assert not written.up_to_date(folder)  # their own sources count
    (edited,) = (path for path in folder.iterdir() if path.name in ("explorer.js", "facts.py"))
    edited.write_text(edited.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert not written.up_to_date(folder, *sources), CURE


@pytest.mark.thorough
@pytest.mark.parametrize("name", EXTRAS)
def test_what_the_extras_commit_is_what_they_derive(name: str) -> None:
    derives, _ = EXTRAS[name]
    assert written.differences(derives.GENERATED, derives.package()) == [], CURE


PAIRS = [(scheme.name, "elastic_pendulum") for scheme in ALL if (scheme.name, "elastic_pendulum") not in COMMITTED]
DIGESTS = """
import hashlib, sys
from substep_derive.declare.catalogue import find, find_scene
from substep_derive.motion.equations import EquationsOfMotion
from substep_derive.emit.first_use import catalogue_pair
for scheme, scene in zip(sys.argv[1::2], sys.argv[2::2]):
    print(hashlib.sha256(catalogue_pair(find(scheme), EquationsOfMotion(find_scene(scene))).encode()).hexdigest())
"""


@pytest.mark.parametrize("environment", SESSIONS, ids=str)
def test_pairs_that_are_not_committed_are_printed_alike_in_every_session(environment: dict[str, str]) -> None:
    """Those on the scene whose pairs were committed once; the gate prints every thirtieth."""
    pairs = PAIRS if os.environ.get("SUBSTEP_VERIFY") else PAIRS[::30]
    found = subprocess.run(
        [sys.executable, "-c", DIGESTS, *(name for pair in pairs for name in pair)],
        env={**os.environ, **environment}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    here = [hashlib.sha256(plain_kernels.text(*pair).encode()).hexdigest() for pair in pairs]
    assert found.stdout.split() == here


@pytest.mark.usefixtures("derived")
def test_deriving_writes_what_differs_and_removes_what_is_stale(
    tampered: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def changed() -> dict[str, int]:
        return {name: (tampered / name).stat().st_mtime_ns for name in written.files_in(tampered)}

    before = changed()
    monkeypatch.setattr(sys, "argv", ["substep_derive", "--folder", str(tampered)])
    assert command.main() == 0
    assert written.differences(tampered, command.package(ALL, scenes.declared())) == []
    after = changed()
    rewritten = {name for name in after if after[name] != before.get(name)}
    assert rewritten == {"schemes/bathe.py", "schemes/newmark.py", "operations.md"}
    assert written.up_to_date(tampered)


@pytest.mark.usefixtures("derived")
def test_checking_what_is_in_order_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["substep_derive", "--check"])
    assert command.main() == 0


@pytest.fixture
def nothing_is_derived(monkeypatch: pytest.MonkeyPatch) -> None:
    def derive(*_: object) -> dict[str, str]:
        raise AssertionError("derived, although the stamp matches")

    monkeypatch.setattr(command, "package", derive)
    monkeypatch.setattr(sys, "argv", ["substep_derive"])


@pytest.mark.usefixtures("nothing_is_derived")
def test_what_the_stamp_vouches_for_is_not_derived_again(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main() == 0
    assert "nothing is derived again" in capsys.readouterr().out


@pytest.mark.usefixtures("nothing_is_derived")
def test_a_check_derives_whatever_the_stamp_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["substep_derive", "--check"])
    with pytest.raises(AssertionError, match="derived"):
        command.main()


def test_an_edited_missing_or_added_file_breaks_the_stamp(tampered: Path, tmp_path: Path) -> None:
    assert written.up_to_date(GENERATED)
    assert not written.up_to_date(tampered)
    assert not written.up_to_date(tmp_path)
    for change in ("edited", "missing", "added", "no stamp"):
        folder = tmp_path / change
        shutil.copytree(GENERATED, folder, ignore=shutil.ignore_patterns("__pycache__"))
        assert written.up_to_date(folder)
        if change == "edited":
            edited = folder / "schemes" / "rk4.py"
            edited.write_text(edited.read_text().replace("2.0", "3.0", 1))
        elif change == "added":
            (folder / "more.py").write_text("")
        else:
            (folder / {"missing": "schemes/rk4.py", "no stamp": stamp.STAMP}[change]).unlink()
        assert not written.up_to_date(folder), change


def test_the_stamp_depends_on_the_generator_and_on_sympy_but_not_on_the_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sources = tmp_path / "sources"
    shutil.copytree(stamp.SOURCES, sources, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(stamp, "SOURCES", sources)
    here = stamp.generator_version()

    def elsewhere() -> str:
        return stamp.generator_version.__wrapped__()

    for path in sources.rglob("*.py"):
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert elsewhere() == here
    with monkeypatch.context() as other:
        other.setattr(stamp, "version", lambda _: "1.14.7")
        assert elsewhere() == here  # pyproject.toml allows every release of a minor version
        other.setattr(stamp, "version", lambda _: "1.15.0")
        assert elsewhere() != here
    (sources / "emit" / "index.py").rename(sources / "emit" / "other.py")
    assert elsewhere() != here


def test_every_scheme_has_its_module_and_nothing_else_is_there() -> None:
    own = OWN_MODULES
    modules = {f"{folder}/{name}" for folder in ("schemes", "plans") for name in own} | {"plans/central_difference"}
    modules |= {f"scenes/{scene.name}" for scene in scenes.declared() if scene not in ON_FIRST_USE} | {
        "marches/linear_filter"
    }
    modules |= {f"marches/{ss.scheme(name).kernels.MARCH}" for name in own}
    modules |= {f"laws/{law.name}" for law in laws.declared()}
    modules |= {f"shared/{ss.scheme(name).kernels.EIGENVALUES}" for name in own}
    modules |= {
        f"shared/{name}"
        for name in [
            "combinations",
            "errors",
            "formulas",
            "interpolant",
            "loads",
            "registers",
            "stability",
            "step_control",
        ]
    }
    modules |= {f"pairs/{scheme}__{scene}" for scheme, scene in COMMITTED}
    modules |= {f"{name.partition('/')[0]}/__init__" for name in modules}
    modules |= {"__init__", "estimators", "facts", "index", "law_index", "scene_index"}
    assert written.files_in(GENERATED) == {f"{name}.py" for name in modules} | {
        "operations.md",
        stamp.STAMP,
    }


def test_modules_stay_small_and_say_where_they_come_from() -> None:
    table = (GENERATED / "operations.md").read_text(encoding="utf-8")
    paths = {path.relative_to(GENERATED).as_posix().removesuffix(".py"): path for path in GENERATED.rglob("*.py")}
    modules = {name: path.read_text(encoding="utf-8") for name, path in paths.items()}
    for name, text in modules.items():
        lines = text.count("\n")
        assert lines <= 1000, name
        assert "make derive" in text.splitlines()[0]
        assert str(Path.home()) not in text
    kernels = {name: text for name, text in modules.items() if not name.startswith("plans/")}  # plans are plain data
    for name, text in kernels.items():
        assert f"| {name} | {text.count(chr(10))} | {len(text.encode()) / 1000:.1f} |" in table
    assert f"{sum(len(text.encode()) for text in kernels.values()) / 1000:.0f} kB" in table
    assert sum(text.count("\n") for text in modules.values()) <= 32_000  # the budget of the design
    assert table.count("\n") <= 20 * len(ALL)


@pytest.mark.parametrize("path", sorted(GENERATED.rglob("*.py")), ids=lambda path: path.stem)
def test_what_cannot_be_called_from_python_has_a_private_name(path: Path) -> None:
    """Such a call would end the process, so only kernels of the same module make it."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    options = {
        node.targets[0].id: {keyword.arg for keyword in node.value.keywords}
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call) and isinstance(node.targets[0], ast.Name)
    }
    for function in (node for node in tree.body if isinstance(node, ast.FunctionDef)):
        decorators = {d.id for d in function.decorator_list if isinstance(d, ast.Name)}
        if any("no_cpython_wrapper" in options.get(d, ()) for d in decorators):
            assert function.name.startswith("_"), function.name
        elif decorators & {"_compile", "_fused"}:
            assert not function.name.startswith("_"), f"{function.name} is compiled for Python too"


def test_operations_are_counted_as_written() -> None:
    text = """
def f(x, y):
    y += -x * g(x[2 * i + 1] + 1.0, x**2)
    for i in range(3 * n):
        return y / (2.0 / 3.0) + np.sin(-1.0)
def nothing(x):
    return x
"""
    # += - * + ** and, in the loop, * in its range, / and +
    assert [(c.name, c.operations, c.calls) for c in function_costs(text)] == [("f", 8, 2)]


def test_a_template_field_too_many_or_too_few_is_refused() -> None:
    with pytest.raises(KeyError, match="template wants"):
        fill("{a}", a=1, b=2)
    with pytest.raises(KeyError, match="template wants"):
        fill("{a} {b}", a=1)
