"""The table of results, and how they are measured."""

import ast
import inspect
import json
import signal
import time
import traceback
from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numba import cuda

import substep as ss
from substep.core import device

EACH = 60  # seconds that one measurement may take
DT = 0.005
RATE = "multiply-adds in float64"
OURS = "spectrum, kernel"


class Kernels:
    """Times of launches, from which those of a device's kernels follow without the copies around them."""

    def __init__(self) -> None:
        self.seconds: list[float] = []
        self.launch = device._launch
        device._launch = self.timed

    def timed(self, *arguments: Any) -> None:
        """A launch and its end."""

        cuda.synchronize()
        begin = time.perf_counter()
        self.launch(*arguments)
        cuda.synchronize()
        self.seconds.append(time.perf_counter() - begin)

    @contextmanager
    def counted(self):
        """The seconds of the launches inside, in a list that is filled when they are over."""
        first, found = len(self.seconds), list[float]()
        yield found
        found.extend(self.seconds[first:])


@contextmanager
def threads_of_a_block(threads: int):
    """Kernels inside run in blocks of so many threads."""
    before, device.THREADS = device.THREADS, threads
    try:
        yield
    finally:
        device.THREADS = before


class Report:
    """Rows of results, kept on disk."""

    def __init__(self, folder: Path, seconds: float, small: bool) -> None:
        self.small, self.kernels = small, Kernels()
        self.folder, self.end, self.begin = folder, time.perf_counter() + seconds, time.perf_counter()
        self.rows: list[dict[str, Any]] = []
        self.facts: dict[str, Any] = {}
        folder.mkdir(parents=True, exist_ok=True)

    def add(self, name: str, value: Any, unit: str = "", note: str = "") -> None:
        """Keep a result."""
        self.rows.append({"name": name, "value": value, "unit": unit, "note": note})
        shown = f"{value:.6g}" if isinstance(value, float) else value
        print(f"[{time.perf_counter() - self.begin:6.1f} s] {name}: {shown} {unit} {note}", flush=True)

    def measure(self, run: Callable[["Report"], None], possible: bool = True) -> None:
        """Run a measurement, whatever becomes of it, where it is possible, and write the table."""
        name, left = run.__name__.strip("_").replace("_", " "), self.end - time.perf_counter()
        if not possible:
            self.add(name, "not measured", note="no device")
        elif left < 5.0:
            self.add(name, "skipped", note="no time left")
        else:
            signal.signal(signal.SIGALRM, _late)
            signal.alarm(int(min(left, EACH)))
            try:
                run(self)
            except Exception as error:  # the others go on
                where = traceback.extract_tb(error.__traceback__)[-1]
                self.add(
                    name, "failed", note=f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
                )
                traceback.print_exc()
            finally:
                signal.alarm(0)
        self.write()

    def value(self, name: str) -> float:
        """The value of the last row of that name."""
        return next(float(row["value"]) for row in reversed(self.rows) if row["name"] == name)

    def write(self) -> None:
        """Write device.json and device.md."""
        (self.folder / "device.json").write_text(json.dumps({"facts": self.facts, "rows": self.rows}, indent=1))
        lines = ["# Measured on a device", "", *(f"- {key}: {value}" for key, value in self.facts.items()), ""]
        lines += ["| what | value | unit | note |", "|---|---|---|---|"]
        for row in self.rows:
            value = f"{row['value']:.4g}" if isinstance(row["value"], float) else row["value"]
            note = str(row["note"]).replace("|", "/").replace("\n", " ")
            lines.append(f"| {row['name']} | {value} | {row['unit']} | {note} |")
        (self.folder / "device.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def missing_device() -> str:
    """Why nothing can be measured on a device here; empty where there is one, or its simulator."""
    try:
        device.found("cuda")
    except (ImportError, RuntimeError) as error:
        return str(error).partition(";")[0]
    return ""


def _late(*_: Any) -> None:
    raise TimeoutError(f"took more than {EACH} s, or all that was left")


def best(run: Callable[[], Any], rounds: int = 5, least: float = 0.0) -> float:
    """The least of the seconds of some calls, after one that does not count."""
    run()
    found, begin = [], time.perf_counter()
    while len(found) < rounds or time.perf_counter() - begin < least:
        start = time.perf_counter()
        run()
        found.append(time.perf_counter() - start)
        if time.perf_counter() - begin > 4.0:
            break
    return min(found)


def operations(kernel: Any) -> tuple[int, int]:
    """Instructions of a step in double precision as a kernel's text has them: fused sums and products, comparisons."""
    function = getattr(kernel, "py_func", None) or getattr(kernel, "fn", kernel)
    loop = next(n for n in ast.walk(ast.parse(inspect.getsource(function))) if isinstance(n, ast.For))
    sums = [n for n in ast.walk(loop) if isinstance(n, ast.BinOp | ast.AugAssign)]
    sums = [n for n in sums if not _whole(n)]
    added = [n for n in sums if isinstance(n.op, ast.Add | ast.Sub)]
    fused = sum(any(_product(x) for x in ast.iter_child_nodes(n)) for n in added)
    products = sum(_product(n) for n in sums)
    called = [n for n in ast.walk(loop) if isinstance(n, ast.Call) and getattr(n.func, "id", "") == "max"]
    return len(added) + products - fused, len(called)


def _product(n: ast.AST) -> bool:
    return isinstance(n, ast.BinOp) and isinstance(n.op, ast.Mult)


def _whole(n: ast.AST) -> bool:
    """Whether an operation counts steps."""
    return any(isinstance(x, ast.Name) and x.id in ("i", "stride") for x in ast.walk(n))


def shaken(n: int) -> ss.Record:
    """A record of n samples after a first one of 0."""
    return ss.Record(DT, np.concatenate([[0.0], np.random.default_rng(1).standard_normal(n)]), unit="m/s^2")
