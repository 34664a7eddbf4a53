"""A folder of derived files: written unless its stamp says that it is up to date, or compared.

With --check on the command line, derive whatever the stamp says, compare and write nothing.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

from .emit.stamp import stamped


def differences(folder: Path, files: dict[str, str]) -> list[str]:
    """What a fresh derivation would change in the folder, one line a file."""
    present = files_in(folder)
    lines = [f"{name}: missing" for name in sorted(files.keys() - present)]
    lines += [f"{name}: stale, no declaration emits it" for name in sorted(present - files.keys())]
    lines += [
        f"{name}: differs from what its declaration emits"
        for name in sorted(files.keys() & present)
        if (folder / name).read_text(encoding="utf-8") != files[name]
    ]
    return lines


def files_in(folder: Path) -> set[str]:
    """Paths of the files in a folder that a derivation may write: modules, the explorer's, the table and the stamp."""
    kinds = (".py", ".js", ".md", ".txt")
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.suffix in kinds}


def up_to_date(folder: Path, *more: Path) -> bool:
    """Whether the folder's stamp is the one that belongs to its files and to this generator, without deriving.

    more: as for `generator_version`.
    """
    files = {name: (folder / name).read_text(encoding="utf-8") for name in files_in(folder)}
    return stamped(files, *more) == files


def write(package: Callable[[], dict[str, str]], folder: Path, *more: Path) -> int:
    """Write what `package` derives, unless it is there. Exit status 1 if --check finds a difference.

    package: path -> text of every file, the stamp included. folder: where they go by default. more: as for
    `generator_version`.
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="derive, compare, write nothing, exit 1 on a difference")
    parser.add_argument("--folder", type=Path, default=folder)
    options = parser.parse_args()
    if not options.check and up_to_date(options.folder, *more):
        print("derived: generated/ has the stamp of this generator and of every file, so nothing is derived again")
        return 0
    files = package()
    found = differences(options.folder, files)
    if options.check:
        if found:
            print(
                "generated/ is not what the declarations emit; run `make derive` and commit the result:",
                *found,
                sep="\n  ",
            )
        return bool(found)
    options.folder.mkdir(parents=True, exist_ok=True)
    for name in files_in(options.folder) - files.keys():
        (options.folder / name).unlink()
    changed = {line.split(":")[0] for line in found} & files.keys()
    for name in sorted(changed):  # the others are left alone, so that numba's cache of them stays valid
        path = options.folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(files[name], encoding="utf-8", newline="\n")
    size = sum(len(text.encode()) for text in files.values())
    print(
        f"{len(files)} files, {size / 1000:.0f} kB, {len(found)} changed, {time.process_time():.1f} s of process time"
    )
    return 0
