"""What `import substep` costs and loads, and the layer borders that no linter sees."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def run(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_import_loads_neither_numba_nor_sympy_nor_matplotlib_nor_xarray() -> None:
    code = "import sys, substep; substep.schemes(); substep.scheme('bathe'); print([m for m in {} if m in sys.modules])"
    names = ["numba", "sympy", "matplotlib", "typer", "rich", "scipy", "jinja2"]
    names += ["xarray", "zarr", "distributed", "substep_derive"]
    assert run(code.format(names)) == "[]"


def test_a_stability_function_loads_numba_but_not_sympy() -> None:
    code = "import sys, substep; substep.scheme('bathe').spectral_radius(1.0); print('sympy' in sys.modules)"
    assert run(code) == "False"


def test_only_one_file_touches_the_low_level_of_sympy() -> None:
    for path in (ROOT / "derive" / "substep_derive").rglob("*.py"):
        if path.name != "rational.py":
            text = path.read_text(encoding="utf-8")
            assert "sympy.polys" not in text, path
            assert "sympy_cse" not in text, path


def test_declarations_hold_no_branch_and_the_derivation_no_scheme_name() -> None:
    from substep_derive.declare.schemes import ALL

    asked = {"thesis.py", "design.py"}  # what they answer is asked of one scheme
    for path in set((ROOT / "derive" / "substep_derive").glob("*.py")):
        if path.name in asked:
            continue
        text = path.read_text(encoding="utf-8")
        assert not [s.name for s in ALL if f'"{s.name}"' in text], path
