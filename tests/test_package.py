"""What `import substep` costs and loads, and the layer borders that no linter sees."""

import ast
import inspect
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import textwrap
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from declared import ALL
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.core import extras

ROOT = Path(__file__).parents[1]
DERIVE = ROOT / "derive" / "substep_derive"


def run(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_import_loads_neither_numba_nor_sympy_nor_matplotlib_nor_xarray() -> None:
    code = "import sys, substep; substep.schemes(); substep.scheme('bathe'); print([m for m in {} if m in sys.modules])"
    names = ["numba", "sympy", "matplotlib", "typer", "rich", "scipy", "jinja2"]
    names += ["xarray", "zarr", "distributed", "substep_derive"]
    assert run(code.format(names)) == "[]"


def test_import_needs_numpy_alone() -> None:
    """What is loaded beyond the standard library, and was not there before (an environment may load its own)."""
    code = (
        "import sys; before = set(sys.modules); import substep; substep.schemes(); substep.scheme('bathe'); "
        "new = {m.partition('.')[0] for m in set(sys.modules) - before}; print(sorted(new - sys.stdlib_module_names))"
    )
    assert run(code) == "['numpy', 'substep', 'substep_kernels']"


def test_a_response_spectrum_does_not_wait_for_dask() -> None:
    """Which xarray imports, with much of SciPy, to ask of each array whether it is one of dask's."""
    code = "import sys, substep; substep.response_spectrum([0.0, 1.0], 0.1, [1.0]); print('dask.array' in sys.modules)"
    assert run(code) == "False"


STEPS = {"dt": 0.1, "t_end": 1.0}
STRUCTURE = ss.structure(np.eye(2), np.eye(2))


@pytest.mark.parametrize("call", [
    lambda path: ss.sweep("linear_oscillator", "bathe", **STEPS, omega=[1.0, 2.0], save=path),
    lambda path: ss.march(STRUCTURE, "bathe", **STEPS, save=path),
], ids=["sweep", "structure"])  # fmt: skip
def test_saving_without_zarr_names_the_extra_and_leaves_nothing(
    call: Callable[[Path], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "zarr", None)  # importing it fails, as where it is not installed
    with pytest.raises(ImportError, match=r"expected zarr for save=, got none.*pip install 'substep\[save\]'"):
        call(tmp_path / "run")
    assert not list(tmp_path.iterdir())


def test_what_is_not_saved_needs_no_zarr(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "zarr", None)
    found = ss.sweep("linear_oscillator", "bathe", **STEPS, omega=[1.0, 2.0])
    assert found.u.sizes == {"omega": 2, "coordinate": 1}
    assert ss.march(STRUCTURE, "bathe", **STEPS).status == "completed"
    assert "period" in ss.response_spectrum([0.0, 1.0], 0.1, [1.0]).sizes


def test_a_stability_function_loads_numba_but_not_sympy() -> None:
    code = "import sys, substep; substep.scheme('bathe').spectral_radius(1.0); print('sympy' in sys.modules)"
    assert run(code) == "False"


def test_a_declaration_of_your_own_does_not_wait_for_the_catalogue() -> None:
    """To declare all of the catalogue takes longer than to derive one scheme."""
    code = (
        "import sys; from substep_derive import Balance, Scheme, derive, h, knot\n"
        "(u0, v0, a0), end = knot(0), knot(1); "
        "u1, v1, a1 = end; mine = Scheme('mine', {u1: u0 + h*v0 + h**2*a1/2, v1: v0 + h*a1}, (Balance.at(end, 1),)); "
        "derive(mine).A; print('substep_derive.declare.schemes' in sys.modules)"
    )
    assert run(code) == "False"


def test_a_pair_that_is_printed_does_not_wait_for_the_whole_catalogue(tmp_path: Path) -> None:
    code = (
        f"import os, sys; os.environ['SUBSTEP_CACHE'] = {str(tmp_path / 'cache')!r}\n"
        "from substep.derived import modules; modules.uncommitted_pair('rk4', 'duffing'); print([m for m in "
        "('schemes.explicit', 'schemes.designed', 'scenes.nonlinear', 'scenes.lagrange', 'laws.plastic') "
        "if f'substep_derive.declare.{m}' in sys.modules])"
    )
    assert run(code) == "['schemes.explicit', 'scenes.nonlinear']"


ABSENT = r"expected the package substep-extras for .*, got none installed; pip install \./extras"


@pytest.fixture
def without_extras(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where extras/ is not installed: no package declares an entry point."""
    monkeypatch.setattr(extras, "installed", lambda _: {})


@pytest.mark.usefixtures("without_extras")
@pytest.mark.parametrize("name", extras.OF_EXTRAS[extras.NAMES])
def test_a_name_of_the_extras_says_what_to_install(name: str) -> None:
    with pytest.raises(ImportError, match=ABSENT):
        getattr(ss, name)
    with pytest.raises(ImportError, match=ABSENT):
        exec(f"from substep import {name}")
    assert name not in dir(ss)


@pytest.mark.usefixtures("without_extras")
@pytest.mark.parametrize("name", extras.OF_EXTRAS[extras.COMMANDS])
def test_a_command_of_the_extras_says_what_to_install(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    result = CliRunner().invoke(app, [name, "--help"])
    assert result.exit_code == 2
    assert re.search(ABSENT, result.output)
    listed = CliRunner().invoke(app, ["--help"])
    assert listed.exit_code == 0
    assert not re.search(rf"^│ {name} ", listed.output, re.MULTILINE)
    assert re.search(r"^│ march|^│ run ", listed.output, re.MULTILINE)


@pytest.mark.usefixtures("without_extras")
def test_the_core_is_whole_without_the_extras() -> None:
    found: dict[str, Any] = {}
    exec("from substep import *", found)
    assert set(dir(ss)) == found.keys() - {"__builtins__"}
    with pytest.raises(AttributeError, match="no attribute 'marsh'"):
        _ = ss.marsh


def test_the_extras_bring_what_the_core_says_of_them() -> None:
    for group, names in extras.OF_EXTRAS.items():
        assert tuple(extras.installed(group)) == names
        assert all(extras.brought(group, name) is not None for name in names)
    assert {*ss.__all__, *extras.OF_EXTRAS[extras.NAMES]} == set(dir(ss))


def test_what_the_extras_bring_is_looked_up_when_it_is_asked_for() -> None:
    code = (
        "import sys, substep; substep.schemes(); own = [m for m in sys.modules if m.startswith('substep_')]; "
        "print([m for m in own if 'kernels' not in m], 'importlib.metadata' in sys.modules)"
    )
    assert run(code) == "[] False"


# what the core does by itself, and how it answers for what it does not have
WITHOUT = """
import substep as ss
from substep_derive import derive
from typer.testing import CliRunner
from substep.cli.commands import app
print(derive("bathe").order[0] ** 6)
print(ss.sweep("linear_oscillator", "bathe", dt=0.1, t_end=1.0, omega=[1.0, 2.0, 3.0]).sizes["omega"])
print(ss.march("duffing", "bathe", dt=0.1, t_end=1.0).status)
try:
    ss.audit
except ImportError as error:
    print("pip install ./extras" in str(error))
print(CliRunner().invoke(app, ["audit", "list"]).exit_code)
"""
# what the extras bring: an audit of the average acceleration method, a program's arguments, a file in another language
WITH = """
import substep as ss
def run(omega, xi, dt, n, u0, v0, load):
    u, v, a = [u0], [v0], [load(0.0) - 2 * xi * omega * v0 - omega**2 * u0]
    for i in range(1, n + 1):
        p, q = u[-1] + dt * v[-1] + dt**2 / 4 * a[-1], v[-1] + dt / 2 * a[-1]
        mass = 1 + xi * omega * dt + (omega * dt / 2) ** 2
        a.append((load(i * dt) - 2 * xi * omega * q - omega**2 * p) / mass)
        u.append(p + dt**2 / 4 * a[-1])
        v.append(q + dt / 2 * a[-1])
    return u, v, a
report = ss.audit(run, ss.Claims("average_acceleration", order=2))
print(report.identified.startswith("average_acceleration"), len(report.deviations))
print(round(float(ss.dialect("opensees.HHT", alpha=0.9).parameters["alpha"]), 12), "def " in ss.emit("bathe", "python"))
"""


@pytest.mark.skipif(not os.environ.get("SUBSTEP_VERIFY"), reason="builds and installs the package: make verify")
@pytest.mark.parametrize("kind", ["wheel", "sdist"])
def test_installed_into_an_empty_environment_it_draws_a_chart(kind: str, tmp_path: Path) -> None:
    """From a wheel of this folder, and from one of the source archive alone; what it imports is that of these tests.

    First the core alone, then the extras beside it.
    """

    def python(*arguments: str, interpreter: Path = Path(sys.executable), cwd: Path = tmp_path) -> str:
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        environment |= {"SUBSTEP_CACHE": str(tmp_path / "cache"), "MPLBACKEND": "Agg"}
        command = [str(interpreter), *arguments]
        done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    source = ROOT
    if kind == "sdist":
        python("-m", "hatchling", "build", "-t", "sdist", "-d", str(tmp_path), cwd=ROOT)
        safely: Any = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}  # which Python 3.11.4 brought
        shutil.unpack_archive(next(tmp_path.glob("*.tar.gz")), tmp_path, **safely)
        (source,) = (path for path in tmp_path.iterdir() if path.is_dir())
    python("-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path), cwd=source)
    python("-m", "venv", "--without-pip", "environment")
    bin_folder = tmp_path / "environment" / ("Scripts" if os.name == "nt" else "bin")
    packages = Path(
        python(
            "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", interpreter=bin_folder / "python"
        ).strip()
    )
    installer = ("-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target", str(packages))
    (core,) = tmp_path.glob("*.whl")
    python(*installer, str(core))
    # what is imported, but nothing of the project's own installation there
    imported = tmp_path / "imported"
    imported.mkdir()
    for path in Path(sysconfig.get_path("purelib")).iterdir():
        if "substep" not in path.name and path.suffix != ".pth":
            (imported / path.name).symlink_to(path)
    (packages / "imported.pth").write_text(f"{imported}\n", encoding="utf-8")
    code = "import substep as a, substep_derive as b, substep_kernels as c; print(a.__file__, b.__file__, c.__file__)"
    found = python("-c", code, interpreter=bin_folder / "python").split()
    assert all(Path(path).is_relative_to(packages) for path in found), found
    command = "from substep.cli.commands import app; app()"
    python("-c", command, "chart", "bathe", "houbolt", "--file", "chart", interpreter=bin_folder / "python")
    assert (tmp_path / "chart.png").stat().st_size > 10_000
    assert "newmark_bdf2" in python("-c", command, "certify", "newmark_bdf2", interpreter=bin_folder / "python")
    assert python("-c", WITHOUT, interpreter=bin_folder / "python").split() == ["64", "3", "completed", "True", "2"]
    python("-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path), cwd=source / "extras")
    (wheel,) = tmp_path.glob("substep_extras*.whl")
    python(*installer, str(wheel))
    assert python("-c", WITH, interpreter=bin_folder / "python").split() == ["True", "0", "-0.1", "True"]
    assert "A-stable" in python("-c", command, "design", "--sub-steps", "2", interpreter=bin_folder / "python")
    python("-c", command, "emit", "bathe", "--language", "c", "--out", "bathe.c", interpreter=bin_folder / "python")
    python("-c", command, "explorer", interpreter=bin_folder / "python")
    assert (tmp_path / "explorer.html").stat().st_size > 500_000
    assert (tmp_path / "bathe.c").read_text(encoding="utf-8").startswith("// bathe")


def test_only_algebra_touches_the_low_level_of_sympy() -> None:
    touching = []
    for path in DERIVE.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if "sympy.polys" in text or "sympy_cse" in text:
            touching.append(path.relative_to(DERIVE).as_posix())
    assert sorted(touching) == ["algebra/elimination.py", "algebra/field_matrices.py", "algebra/rational.py"]


SCHEMES = {scheme.name for scheme in ALL}
PARAMETERS = {p.name for s in ALL for p in (*s.parameters, *(family.argument for family in s.families))}
ABOUT_ONE_SCHEME = ("declare/schemes",)


def branches(source: str) -> list[str]:
    """Places of a source that treat a scheme of the catalogue by its name or by its parameters.

    These are: a string that is a scheme's name; a parameter's name that is compared, matched or looked up; a comparison
    or a question of a scheme's own name; an import of one declaration, or of a parameter's symbol.
    """
    found = []
    for node in ast.walk(ast.parse(source)):
        texts: list[ast.expr] = []
        if isinstance(node, ast.Constant) and node.value in SCHEMES:
            found.append(f"line {node.lineno}: names the scheme {node.value}")
        elif isinstance(node, ast.ImportFrom) and node.module:
            imported = {alias.name for alias in node.names}
            one = imported - {"declared"} if "declare.schemes" in node.module else imported & PARAMETERS
            if one and ("declare.schemes" in node.module or node.module.endswith("symbols")):
                found.append(f"line {node.lineno}: imports {', '.join(sorted(one))}")
        elif isinstance(node, ast.Compare):
            texts = [node.left, *node.comparators]
            found += [f"line {node.lineno}: compares {ast.unparse(x)}" for x in texts if _asks_for_the_name(x)]
        elif isinstance(node, ast.Match):
            texts = [p.value for case in node.cases for p in ast.walk(case.pattern) if isinstance(p, ast.MatchValue)]
            found += [f"line {node.lineno}: matches {ast.unparse(node.subject)}"] * _asks_for_the_name(node.subject)
        elif isinstance(node, ast.Subscript):
            texts = [node.slice]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            texts = node.args[:1] if node.func.attr in ("get", "pop") else []
            found += [f"line {node.lineno}: asks {ast.unparse(node.func)}"] * _asks_for_the_name(node.func.value)
        strings = (x.value for text in texts for x in ast.walk(text) if isinstance(x, ast.Constant))
        found += [f"line {getattr(node, 'lineno', 0)}: looks for {x}" for x in strings if x in PARAMETERS]
    return found


def _asks_for_the_name(e: ast.expr) -> bool:
    """Whether it is the name of something called scheme: scheme.name, self.scheme.name, amplification.scheme.name."""
    own = e.value if isinstance(e, ast.Attribute) and e.attr == "name" else None
    return (isinstance(own, ast.Name) and own.id == "scheme") or (
        isinstance(own, ast.Attribute) and own.attr == "scheme"
    )


@pytest.mark.parametrize(
    "broken",
    [
        'if scheme.name == "bathe": order = 3',
        "order = 3 if self.scheme.name != wanted else 2",
        'SPECIAL = {"kr_alpha": 1}',
        'match scheme.name:\n    case "rk4":\n        pass',
        "match scheme.name:\n    case other:\n        pass",
        'if scheme.name.startswith("kr_"): pass',
        'if "rho_inf" in values: pass',
        'match key:\n    case "gamma_t":\n        pass',
        'split = values["gamma_t"]',
        'split = values.get("gamma_t")',
        "from ..declare.symbols import Omega, gamma_t",
        "from ..declare.schemes.composite import bathe",
        "from substep_derive.declare.schemes import alpha",
    ],
)
def test_a_branch_for_one_scheme_is_seen(broken: str) -> None:
    assert branches(broken)


@pytest.mark.parametrize(
    "general",
    [
        'raise ValueError(f"{scheme.name} is not consistent")',
        '"""Bathe\'s scheme, bathe, is one of them."""',
        "from ..declare.schemes import declared",
        "from ..declare.symbols import Omega, xi",
        "if scene.name == COMMITTED: pass",
        'p = Hurwitz("p", coefficients)',
    ],
)
def test_what_holds_for_every_scheme_is_not_taken_for_a_branch(general: str) -> None:
    assert not branches(general)


def test_no_scheme_has_a_branch_of_its_own() -> None:
    """The derivation, and what runs its kernels, know no scheme: what is special about one is in its declaration."""
    looked_at = 0
    for folder in (DERIVE, ROOT / "src" / "substep" / "core", ROOT / "src" / "substep" / "marching"):
        for path in sorted(folder.rglob("*.py")):
            if not path.relative_to(folder).as_posix().startswith(ABOUT_ONE_SCHEME):
                assert branches(path.read_text(encoding="utf-8")) == [], path
                looked_at += 1
    assert looked_at > 50
    for exempt in ABOUT_ONE_SCHEME:  # an exemption that nothing needs is one too many
        files = (DERIVE / exempt).rglob("*.py")
        assert any(branches(path.read_text(encoding="utf-8")) for path in files), exempt


def test_what_notebooks_say_they_need_is_installed_for_the_site() -> None:
    """`make docs` executes them with the extra `docs` alone; a notebook names the other extras that it takes."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    notebooks = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("notebooks/*.py"))
    named = set(re.findall(r"\(extra `(\w+)`\)", notebooks))
    assert "fem" in named
    for name in named:
        assert set(extras[name]) <= set(extras["docs"]), name


@pytest.mark.parametrize("name", [name for name in dir(ss) if inspect.isfunction(getattr(ss, name))])
def test_a_signature_fits_a_screen(name: str) -> None:
    """Types by the names of their aliases, and no default that prints an array."""
    shown = f"{name}{inspect.signature(getattr(ss, name))}"
    assert len(textwrap.wrap(shown, 80)) <= 12
    assert "Union[" not in shown
    assert "array(" not in shown


@pytest.mark.parametrize("house", ["derive/substep_derive", "src/substep", "extras"])
def test_the_readme_lists_every_room_and_those_in_layers_in_their_order(house: str) -> None:
    sections = (ROOT / "README.md").read_text(encoding="utf-8").partition("\n## The rooms\n")[2].split("\n`")
    (section,) = (x for x in sections if x.startswith(f"{house}/`"))
    listed = re.findall(r"^\| `(\w+)/` \|", section, re.MULTILINE)
    there = {p.parent.name for p in (ROOT / house).glob("*/__init__.py")}
    assert sorted(listed) == sorted(there)
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = [c["layers"] for c in contracts if c.get("containers") == [house.rpartition("/")[2]]]
    assert len(layers) == (house != "extras")  # those stand beside one another
    assert all([room for room in reversed(layer) if room in there] == listed for layer in layers)
