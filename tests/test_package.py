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
from substep_derive.declare.schemes import ALL

import substep as ss

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
        "('explicit', 'designed') if f'substep_derive.declare.schemes.{m}' in sys.modules])"
    )
    assert run(code) == "['explicit']"


@pytest.mark.skipif(not os.environ.get("SUBSTEP_VERIFY"), reason="builds and installs the package: make verify")
@pytest.mark.parametrize("kind", ["wheel", "sdist"])
def test_installed_into_an_empty_environment_it_draws_a_chart(kind: str, tmp_path: Path) -> None:
    """From a wheel of this folder, and from one of the source archive alone; what it imports is that of these tests."""

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
    python(*installer, str(next(tmp_path.glob("*.whl"))))
    # what is imported, but not the editable installation there, whose .pth file is read in its own folder only
    (packages / "imported.pth").write_text(f"{sysconfig.get_path('purelib')}\n", encoding="utf-8")
    code = "import substep as a, substep_derive as b, substep_kernels as c; print(a.__file__, b.__file__, c.__file__)"
    found = python("-c", code, interpreter=bin_folder / "python").split()
    assert all(Path(path).is_relative_to(packages) for path in found), found
    command = "from substep.cli.commands import app; app()"
    python("-c", command, "chart", "bathe", "houbolt", "--file", "chart", interpreter=bin_folder / "python")
    assert (tmp_path / "chart.png").stat().st_size > 10_000
    assert "newmark_bdf2" in python("-c", command, "certify", "newmark_bdf2", interpreter=bin_folder / "python")


def test_only_algebra_touches_the_low_level_of_sympy() -> None:
    touching = []
    for path in DERIVE.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if "sympy.polys" in text or "sympy_cse" in text:
            touching.append(path.relative_to(DERIVE).as_posix())
    assert sorted(touching) == ["algebra/elimination.py", "algebra/rational.py"]


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
            one = imported - {"ALL"} if "declare.schemes" in node.module else imported & PARAMETERS
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
        "from ..declare.schemes import ALL",
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


def test_the_gate_leaves_no_scheme_and_no_test_out() -> None:
    """Each test meets one scheme of each kind, each scheme some tests; what names no scheme is always run."""
    from conftest import in_gate
    from declared import NAMES
    from plain_kernels import kinds

    assert tuple(kinds()) == NAMES
    functions = [f"tests/test_{k}.py::test_{k}" for k in range(400)]
    for function in functions:
        run = [name for name in NAMES if in_gate(function, [name, "elastic_pendulum"], kinds())]
        assert sorted(kinds()[name] for name in run) == sorted(set(kinds().values()))
        assert in_gate(function, ["elastic_pendulum"], kinds())
    assert all(any(in_gate(function, [name], kinds()) for function in functions[:200]) for name in NAMES)


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
