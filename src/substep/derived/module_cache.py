"""Generated modules in the user's cache: printed once, checked, and imported from real files, so that numba can cache
what it compiles.

Threads and processes that ask for the same module at the same time wait for the one that prints it.
"""

import hashlib
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from threading import Lock
from types import ModuleType

from . import file_lock

DEEP = 20_000  # calls: numba follows names from block to block by recursion, and long eliminations have many blocks
_locks: dict[str, Lock] = {}  # of each module, between threads


def cache_folder() -> Path:
    """Folder of the user's own modules: $SUBSTEP_CACHE, or the platform's cache folder; made if missing.

    Raises PermissionError if others own it or may write to it, for what lies there is run as code; OSError if it
    cannot be made.
    """
    folder = Path(os.environ.get("SUBSTEP_CACHE") or _of_platform())
    with _cure(folder):
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    found = folder.stat()
    if hasattr(os, "getuid") and (found.st_uid != os.getuid() or found.st_mode & 0o022):
        raise PermissionError(
            f"expected the cache folder {folder} to be yours alone, got owner {found.st_uid} and mode "
            f"{found.st_mode & 0o777:o}; run chmod 700 on it, or set SUBSTEP_CACHE to a folder of your own"
        )
    return folder


def _of_platform() -> str:
    import platformdirs  # noqa: PLC0415 (where no folder is named)

    return platformdirs.user_cache_dir("substep")


def cached_module(declared: str, text: Callable[[], str]) -> ModuleType:
    """The module of the declarations with the digest `declared`; text() prints it if the cache has no intact file.

    Raises OSError if it has to be printed and the cache folder cannot be written or locked.
    """
    module_name = f"substep_own_{hashlib.sha256((_generator_version() + declared).encode()).hexdigest()[:24]}"
    with _locks.setdefault(module_name, Lock()):  # a module is among sys.modules before it has run
        module = sys.modules.get(module_name)
        if module is None:
            path = cache_folder() / f"{module_name}.py"
            if not _intact(path):
                _print(path, text)
            sys.setrecursionlimit(max(sys.getrecursionlimit(), DEEP))
            module = _load(module_name, path)
    return module


@cache
def _generator_version() -> str:
    """See `substep_derive.emit.stamp`, which is run by itself: as a part of its package it would import SymPy."""
    package = importlib.util.find_spec("substep_derive")
    assert package is not None
    assert package.origin is not None
    return _load("substep_stamp", Path(package.origin).with_name("emit") / "stamp.py").generator_version()


def _print(path: Path, text: Callable[[], str]) -> None:
    """Print the module, unless another process has done so while this one waited for it."""
    with _cure(path.parent):
        file = path.with_suffix(".lock").open("w", encoding="utf-8")
    with file:
        with _cure(path.parent):
            file_lock.lock(file)
        try:
            if not _intact(path):
                printed = text()
                with _cure(path.parent):
                    _write(path, printed)
        finally:
            file_lock.unlock(file)


@contextmanager
def _cure(folder: Path) -> Iterator[None]:
    """Say of which folder an error is, and what helps."""
    try:
        yield
    except OSError as error:
        raise OSError(
            error.errno,
            f"expected a cache folder {folder} that can be made, written and locked, got '{error.strerror}'; "
            "set SUBSTEP_CACHE to a folder of your own on a local disk",
        ) from error


def _intact(path: Path) -> bool:
    """Whether the file is there and its first line is the sha256 of the rest."""
    try:
        first, rest = path.read_text(encoding="utf-8").split("\n", 1)
    except (FileNotFoundError, ValueError):
        return False
    return first == "# sha256 " + hashlib.sha256(rest.encode()).hexdigest()


def _write(path: Path, text: str) -> None:
    """Write the file in one move, so that who reads it sees either the old file or the whole new one."""
    part = path.with_suffix(".part")
    part.write_text(f"# sha256 {hashlib.sha256(text.encode()).hexdigest()}\n{text}", encoding="utf-8", newline="\n")
    part.replace(path)


def _load(name: str, path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"expected a Python module at {path}; remove the file and try again")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # before it runs: numba's cache looks functions up by their module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module
