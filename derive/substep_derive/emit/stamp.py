"""The stamp of generated/: a digest that says which generator emitted its text, so that it need not be emitted again.

Line endings and the order in which a machine lists files do not enter.
"""

import hashlib
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path

STAMP = "stamp.txt"
SOURCES = Path(__file__).parents[1]


@cache
def generator_version(*more: Path) -> str:
    """Digest of the generator's sources and SymPy's minor version: another one may print other text.

    more: folders of further sources, of a generator that stands on this one.
    """
    sources = [
        (folder, path) for folder in (SOURCES, *more) for kind in ("*.py", "*.j2") for path in folder.rglob(kind)
    ]
    texts = ((path.relative_to(folder).as_posix(), path.read_text("utf-8")) for folder, path in sources)
    return _digest(("SymPy", ".".join(version("sympy").split(".")[:2])), *sorted(texts))


def stamped(files: Mapping[str, str], *more: Path) -> dict[str, str]:
    """File name -> text of these files and of the stamp that belongs to them and to this generator.

    more: as for `generator_version`.
    """
    texts = sorted((name, text) for name, text in files.items() if name != STAMP)
    found = _digest(("generator", generator_version(*more)), *texts)
    return {**dict(texts), STAMP: f"{found}\nof the generator's sources, SymPy's minor version and the files here\n"}


def _digest(*parts: Iterable[str]) -> str:
    """sha256 of texts under their names; the lengths keep a text from running into the next name."""
    digest = hashlib.sha256()
    for text in (text for part in parts for text in part):
        digest.update(f"{len(text)} {text}".encode())
    return digest.hexdigest()
