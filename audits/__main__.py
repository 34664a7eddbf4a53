"""Audit programs and write what comes out: `python -m audits FOLDER [PROGRAM ...]`, or `python -m audits` for the page.

FOLDER holds the environments that environments.sh makes. The reports go to reports/, one compressed file a program, and
the page docs/audits.md is written from them and from the scripts that show a deviation without this package, the table
in docs/conventions.md from the dialects that were found, and docs/catalogue_of_programs.md from what manuals and
sources say.
"""

import json
import shlex
import subprocess
import sys
from datetime import date
from pathlib import Path
from typing import Any

from substep_audit.dialects import TABLE, Dialect, find_dialect, to_plain
from substep_audit.instrument import audit_program
from substep_audit.program import Program, programs

from . import evidence, named
from .page import conventions, page

HERE = Path(__file__).parent
PAGE = HERE.parent / "docs" / "audits.md"
CONVENTIONS = PAGE.with_name("conventions.md")
CATALOGUE = PAGE.with_name("catalogue_of_programs.md")


def environment(name: str, folder: Path) -> str:
    """The command of the interpreter that has a program, made if it is not there."""
    made = subprocess.run(
        ["bash", str(HERE / "environments.sh"), name, str(folder)], capture_output=True, text=True, check=False
    )
    if made.returncode:
        raise RuntimeError(made.stderr.strip())
    return made.stdout.strip().splitlines()[-1]


def audited(name: str, python: str) -> dict[str, Any]:
    """The reports of a program, with what could not be run."""
    reports, failed, dialects = [], [], {}
    with Program(name, python) as program:
        for integrator in program.integrators:
            try:
                (report,) = audit_program(program, [integrator])
            except ValueError as error:
                failed.append({"integrator": integrator, "error": str(error)})
                print(f"{name} {integrator}: {error}", flush=True)
                continue
            print(f"{report.text}\n", flush=True)
            plain = {key: x for key, x in report.to_dict().items() if key != "curves"}
            reports.append(plain | {"integrator": integrator})
            if (dialect := find_dialect(program, integrator)) is not None:
                dialects[f"{name}.{integrator}"] = dialect
        return {
            "program": program.program, "version": program.version, "license": program.license,
            "date": date.today().isoformat(), "reports": reports, "failed": failed,
            "dialects": to_plain(dialects),
        }  # fmt: skip


IMPORTED_FIRST = """
import ast, os, runpy, sys
path = sys.argv[1]
answers = os.dup(1)
os.dup2(2, 1)
for node in ast.parse(open(path, encoding="utf-8").read()).body:
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        exec(compile(ast.Module([node], []), path, "exec"), {})
sys.stdout.flush()
os.dup2(answers, 1)
runpy.run_path(path, run_name="__main__")
"""


def shown(script: Path, python: str) -> str:
    """What a script that shows a deviation prints, without what the program prints while it is imported."""
    command = [*shlex.split(python), "-c", IMPORTED_FIRST, str(script)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def main() -> None:
    """Audit what is asked for, then write the page."""
    if len(sys.argv) > 1:
        folder = Path(sys.argv[1])
        for name in sys.argv[2:] or programs():
            try:
                python = environment(name, folder)
                found = audited(name, python)
            except (RuntimeError, ValueError) as error:
                print(f"{name}: {error}", flush=True)
                continue
            evidence.write(name, found)
            for script in sorted((HERE / name).glob("*.py")):
                script.with_suffix(".txt").write_text(shown(script, python), encoding="utf-8")
    found = {}
    for name in evidence.audited():
        found |= evidence.read(name)["dialects"]
    TABLE.write_text(json.dumps(found, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    PAGE.write_text(page(HERE), encoding="utf-8")
    CATALOGUE.write_text(named.page(), encoding="utf-8")
    table = {name: Dialect.from_plain(entry) for name, entry in found.items()}
    CONVENTIONS.write_text(conventions(CONVENTIONS.read_text(encoding="utf-8"), table), encoding="utf-8")


if __name__ == "__main__":
    main()
