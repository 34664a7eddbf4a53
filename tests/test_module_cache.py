"""Modules of the user's cache are printed once and run once, whoever asks for them at the same time."""

import errno
import importlib.util
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from substep_derive.declare.catalogue import find, find_scene
from substep_derive.emit.stamp import generator_version

from substep.derived import file_lock, module_cache, modules

SLOW = "import time\ntime.sleep(0.3)\nx = 1.5\n"  # a module that others can see while it runs

ASK = """
import sys, time
from pathlib import Path
from substep.derived.module_cache import cached_module

here, name = Path(sys.argv[1]), sys.argv[2]
(here / f"ready {name}").touch()
while not (here / "go").exists():
    time.sleep(0.01)

def text():
    (here / f"printing {name}").touch()
    time.sleep(float(sys.argv[3]))
    return "x = 1.5\\n"

print(cached_module("a declaration", text).x)
"""


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    for name in [name for name in sys.modules if name.startswith("substep_own_")]:
        monkeypatch.delitem(sys.modules, name)
    return tmp_path / "cache"


def at_once(ask: Callable[[], Any], threads: int = 8) -> list[Any]:
    """What the threads got, all of which ask at the same time: a result or an exception."""
    together = threading.Barrier(threads)

    def one(_: int) -> Any:
        together.wait()
        try:
            return ask()
        except Exception as error:
            return error

    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(one, range(threads)))


def test_threads_that_ask_at_once_get_one_module_which_has_run() -> None:
    printed = []

    def text() -> str:
        printed.append(threading.get_ident())
        time.sleep(0.3)
        return SLOW

    def ask() -> tuple[ModuleType, float]:
        module = module_cache.cached_module("a declaration", text)
        return module, module.x

    found = at_once(ask)
    assert len(printed) == 1
    assert found == [(found[0][0], 1.5)] * 8


def test_threads_that_ask_for_the_same_pair_can_march() -> None:
    kernels = at_once(lambda: modules.uncommitted_pair("rk4", "duffing").march)
    assert all(kernel is kernels[0] for kernel in kernels), kernels
    assert callable(kernels[0])


@pytest.mark.parametrize("broken", [SLOW + "1 / 0\n", None], ids=["the module", "its printing"])
def test_what_fails_fails_for_every_thread_and_leaves_nothing(broken: str | None) -> None:
    def text() -> str:
        time.sleep(0.01)
        return broken or str(1 / 0)

    found = at_once(lambda: module_cache.cached_module("a declaration", text), 3)
    assert [type(error) for error in found] == [ZeroDivisionError] * 3
    assert not [name for name in sys.modules if name.startswith("substep_own_")]
    assert module_cache.cached_module("another", lambda: "x = 2\n").x == 2


def start(folder: Path, name: str, seconds: float) -> "subprocess.Popen[str]":
    """A process that asks for the module once the file `go` is there, and prints it for so long."""
    (folder / "ask.py").write_text(ASK)
    command = [sys.executable, str(folder / "ask.py"), str(folder), name, str(seconds)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for(*files: Path) -> None:
    end = time.monotonic() + 60
    while not all(file.exists() for file in files):
        assert time.monotonic() < end, files
        time.sleep(0.01)


def test_of_two_processes_that_ask_at_once_one_prints(tmp_path: Path, cache: Path) -> None:
    both = [start(tmp_path, name, 1.0) for name in "ab"]
    wait_for(tmp_path / "ready a", tmp_path / "ready b")
    (tmp_path / "go").touch()
    for process in both:
        out, err = process.communicate(timeout=60)
        assert (process.returncode, out) == (0, "1.5\n"), err
    assert len(list(tmp_path.glob("printing *"))) == 1
    assert len(list(cache.glob("*.py"))) == 1


def test_a_process_that_died_while_it_printed_keeps_nobody_waiting(tmp_path: Path) -> None:
    (tmp_path / "go").touch()
    process = start(tmp_path, "a", 600.0)
    wait_for(tmp_path / "printing a")
    process.kill()
    process.communicate()
    with ThreadPoolExecutor(1) as pool:
        found = pool.submit(module_cache.cached_module, "a declaration", lambda: "x = 2.5\n")
        assert found.result(timeout=10).x == 2.5


def _refuse(number: int) -> Callable[..., None]:
    def refuse(*_: Any) -> None:
        raise OSError(number, os.strerror(number))

    return refuse


@pytest.mark.parametrize(("where", "number"), [("lock", errno.ENOLCK), ("_write", errno.EROFS)])
def test_a_folder_that_cannot_be_written_or_locked_is_named_with_a_cure(
    where: str, number: int, tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as odd:
        odd.setattr(file_lock if where == "lock" else module_cache, where, _refuse(number))
        with pytest.raises(OSError, match=rf"{cache}.*{os.strerror(number)}.*set SUBSTEP_CACHE") as caught:
            module_cache.cached_module("a declaration", lambda: "x = 1\n")
        assert caught.value.errno == number
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "other"))
    assert module_cache.cached_module("a declaration", lambda: "x = 1\n").x == 1


def test_a_folder_that_cannot_be_made_is_named_with_a_cure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.raises(OSError, match=r"cache.*set SUBSTEP_CACHE"):
        module_cache.cached_module("a declaration", lambda: "x = 1\n")


def test_a_module_that_is_there_needs_no_lock(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a cache that was filled once, and is read by many from a disk that they cannot write to."""
    del sys.modules[module_cache.cached_module("a declaration", lambda: "x = 1\n").__name__]
    monkeypatch.setattr(file_lock, "lock", _refuse(errno.EROFS))
    assert module_cache.cached_module("a declaration", lambda: "x = 2\n").x == 1


def test_what_was_printed_for_the_catalogue_once_is_found_without_sympy() -> None:
    """By each process: to import SymPy and declare the catalogue takes seconds."""
    code = (
        "import sys; from substep.derived import modules; pair = modules.uncommitted_pair('rk4', 'duffing')\n"
        "error = modules.local_error_module('newmark', {'beta': 0.3, 'gamma': 0.6}, True)\n"
        "adaptive = modules.adaptive_pair('newmark', 'duffing', error.TERMS, error.ORDER, error.ALWAYS)\n"
        "print('sympy' in sys.modules, *(module.__name__ for module in (pair, error, adaptive)))"
    )
    found = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(2)]
    (printed, *names), (imported, *again) = (one.stdout.split() for one in found)
    assert (printed, imported) == ("True", "False")
    assert names == again
    assert len(set(names)) == 3


def test_a_name_of_the_catalogue_and_its_declaration_are_printed_alike() -> None:
    one = modules.uncommitted_pair("rk4", "duffing")
    other = modules.uncommitted_pair(find("rk4"), find_scene("duffing"))
    assert Path(str(one.__file__)).read_text() == Path(str(other.__file__)).read_text()


def test_the_generators_version_is_that_of_the_generator() -> None:
    assert module_cache._generator_version() == generator_version()


def test_on_windows_a_lock_is_awaited_for_longer_than_its_ten_tries(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against msvcrt as its documentation has it: LK_LOCK raises after ten seconds, EDEADLOCK from its C library."""
    calls, held = [], [True, True]

    def locking(file: int, mode: int, size: int) -> None:
        calls.append((mode, size))
        if mode == 1 and held:
            held.pop()
            raise OSError(errno.EDEADLK, "Resource deadlock avoided")

    monkeypatch.setitem(sys.modules, "msvcrt", SimpleNamespace(LK_LOCK=1, LK_UNLCK=0, locking=locking))
    monkeypatch.setattr(sys, "platform", "win32")
    spec = importlib.util.spec_from_file_location("file_lock_on_windows", str(file_lock.__file__))
    assert spec is not None
    assert spec.loader is not None
    there = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(there)
    with (tmp_path / "lock").open("w") as file:
        there.lock(file)
        assert calls == [(1, 1)] * 3
        there.unlock(file)
        assert calls[3:] == [(0, 1)]
        monkeypatch.setattr(sys.modules["msvcrt"], "locking", _refuse(errno.EACCES))
        with pytest.raises(PermissionError):
            there.lock(file)
