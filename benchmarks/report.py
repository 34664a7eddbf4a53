"""Reports of what was measured: on the terminal, in results/bench.json and as a page, results/bench.md."""

import json
import math
import os
import platform
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table as Grid

from . import limits, registers, target
from .job import Goal, Job, Table

PACKAGES = ("substep", "numpy", "numba", "scipy", "sympy", "numbalsoda", "pyyeti", "eqsig", "openseespy", "exudyn")


def machine() -> dict[str, Any]:
    """The machine, the versions, the date."""
    facts = {"system": platform.platform(), "processor": platform.processor() or platform.machine()}
    information = Path("/proc/cpuinfo")
    if information.exists():
        pairs = [line.partition(":") for line in information.read_text().splitlines()]
        first = {key.strip(): value.strip() for key, _, value in reversed(pairs) if value}
        facts["processor"] = first.get("model name", facts["processor"])
        flags = first.get("flags", "").split()
        facts["vectors"] = "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else "other"
    facts["target"] = target.march()
    try:
        facts["compiler"] = f"{limits.compiler()} {' '.join(limits.FLAGS)}"
        wide = registers.wide_registers()
        facts["zmm_registers"] = f"{wide['numba']} in numba's code of one kernel, {wide['C']} in that of C"
    except limits.MissingCompilerError as error:
        facts["compiler"] = str(error)
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else math.nan
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        **facts,
        "cores": os.cpu_count(),
        "load_at_start": round(load, 2),
        "python": platform.python_version(),
        "versions": {name: found for name in PACKAGES if (found := _version(name))},
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def time_text(seconds: float) -> str:
    """A time with the unit that leaves one to three digits before the point."""
    if not math.isfinite(seconds):
        return "-"
    for scale, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if seconds >= scale:
            return f"{seconds / scale:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns" if seconds >= 1e-9 else f"{seconds * 1e9:.2g} ns"


def _number(goal: Goal, value: float | None) -> str:
    if value is None:
        return "-"
    if goal.unit == "":
        return f"{value:.1e}"
    return time_text(value) if goal.unit == "s" else f"{value:.3g} x"


def _verdict(goal: Goal) -> str:
    return {True: "yes", False: "no", None: f"not measured: {goal.why}"}[goal.met]


def _goal_rows(jobs: Sequence[Job]) -> Iterator[tuple[str, str, str, str, str]]:
    for job in jobs:
        for goal in job.goals:
            spread = "" if goal.low is None or goal.high is None else f"{goal.low:.3g} .. {goal.high:.3g}"
            bound = f"{goal.sense} {_number(goal, goal.bound)}"
            yield goal.text, bound, _number(goal, goal.reached), spread, _verdict(goal)


def _table_rows(table: Table) -> Iterator[list[str]]:
    own = table.row("substep") or table.rows[0]
    for row in table.rows:
        errors = [f"{row.errors[key]:.1e}" if key in row.errors else "-" for key in table.errors]
        relative = row.seconds / own.seconds
        yield [row.name, row.kind, time_text(row.seconds), f"{100 * row.spread:.0f} %", f"{relative:.3g}", *errors]


GOALS = ("goal", "bound", "reached", "quartiles", "met")


def _head(table: Table) -> list[str]:
    return ["", "kind", f"a {table.unit}", "spread", "time / first", *(f"error: {key}" for key in table.errors)]


def show(job: Job, console: Console) -> None:
    """One job on the terminal."""
    console.rule(job.title)
    for table in job.tables:
        grid = Grid(*_head(table), title=table.title, title_justify="left", show_edge=False)
        for row in _table_rows(table):
            grid.add_row(*row, style="bold" if row[1] == "substep" else None)
        console.print(grid)
    for what, why in job.skipped.items():
        console.print(f"left out: {what} ({why})", style="yellow", markup=False)


def show_goals(jobs: Sequence[Job], console: Console) -> None:
    """All goals on the terminal, after the tables."""
    grid = Grid(*GOALS, title="Goals", show_edge=False)
    for row in _goal_rows(jobs):
        grid.add_row(*row, style={"yes": "green", "no": "red"}.get(row[-1], "yellow"))
    console.print(grid)


def write(jobs: Sequence[Job], facts: dict[str, Any], folder: Path) -> tuple[Path, Path]:
    """bench.json and bench.md in the folder, made if missing."""
    folder.mkdir(parents=True, exist_ok=True)
    data, page = folder / "bench.json", folder / "bench.md"
    whole = {"machine": facts, "jobs": [_plain(job) for job in jobs]}
    data.write_text(json.dumps(_finite(whole), indent=1, ensure_ascii=False) + "\n")
    page.write_text("\n".join(_page(jobs, facts)) + "\n")
    return data, page


def _plain(job: Job) -> dict[str, Any]:
    tables = [
        {
            "title": table.title, "unit": table.unit, "errors": table.errors,
            "rows": [
                {
                    "name": row.name, "kind": row.kind, "seconds": row.seconds, "spread": row.spread,
                    "samples": row.samples.tolist(), "errors": row.errors,
                }
                for row in table.rows
            ],
        }
        for table in job.tables
    ]  # fmt: skip
    goals = [{**asdict(goal), "met": goal.met} for goal in job.goals]
    return {
        **{key: getattr(job, key) for key in ("name", "title", "skipped", "notes")},
        "tables": tables,
        "goals": goals,
    }


def _finite(value: Any) -> Any:
    """A copy in which null stands for NaN and infinity, which JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _page(jobs: Sequence[Job], facts: dict[str, Any]) -> Iterator[str]:
    yield from ("# Speed and error", "")
    versions = ", ".join(f"{name} {number}" for name, number in facts["versions"].items())
    yield f"{facts['date']}, {facts['processor']} ({facts.get('vectors', 'unknown vectors')}), {facts['cores']} cores,"
    yield f"load {facts['load_at_start']} at the start; {facts['system']}; Python {facts['python']}, {versions};"
    yield f"C by `{facts['compiler']}`. Kernels are compiled for {facts['target']}; zmm registers:"
    yield f"{facts.get('zmm_registers', 'not looked for')}."
    yield ""
    yield "Medians over rounds in which all alternatives take turns; ratios are taken round by round. One core, and the"
    yield "process's own time, unless a title says otherwise. Ratios stay the same when the machine's speed drifts."
    yield from ("", "## Goals", "", *_markdown(GOALS, _goal_rows(jobs)))
    for job in jobs:
        yield from ("", f"## {job.title}")
        for table in job.tables:
            yield from ("", f"**{table.title}**", "", *_markdown(_head(table), _table_rows(table)))
            meanings = "; ".join(f"{key}: {meaning}" for key, meaning in table.errors.items())
            if meanings:
                yield from ("", f"Errors: {meanings}.")
        for note in job.notes:
            yield from ("", note)
        for what, why in job.skipped.items():
            yield from ("", f"Left out: {what} ({why}).")


def _markdown(head: Sequence[str], rows: Iterator[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield "|" + "---|" * len(head)
    for row in rows:
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |"
