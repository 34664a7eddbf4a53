"""The page of results, index.html: what was found, every figure with its caption, the ledger of claims, the tables.

The page shows every file of its folder; no list of files is kept elsewhere.
"""

import csv
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from PIL import Image

LONGEST = 100  # most rows of a table that is shown; a longer one is only linked
ROOT = re.compile(r"CRootOf\([^()]*\)")  # a root of a polynomial, which may have a hundred terms
NUMBER = re.compile(r"[-+]?\d+\.\d{6,}(e[-+]?\d+)?")  # a number shown to six digits, of which the file has more


@dataclass(frozen=True)
class Picture:
    """A figure of the folder: its PNG's size in pixels, section and caption, and the CSV files of its numbers."""

    name: str
    width: int
    height: int
    section: str
    caption: str
    numbers: Sequence[str]


@dataclass(frozen=True)
class CsvTable:
    """A CSV file of the folder: its name, how many rows it has below its header, and the rows if they are few."""

    file: str
    size: int
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


def write(folder: Path, growing: str = "") -> Path:
    """Write index.html into the folder of results and return its path; the same files give the same bytes.

    Figures are PNG files, whose metadata hold section and caption (`charts.save`); the ledger is read from claims.json
    and the sentences with which the page opens from found.json if there are such files, tables from CSV files.
    growing: how far the results are, of a page that reloads itself since more will come. Raises ValueError, which names
    the file, for a figure without a caption.
    """
    tables = [_table(path) for path in sorted(folder.glob("*.csv"), key=_natural)]
    names = [table.file for table in tables]
    by_section = sorted(pictures(folder, names), key=lambda picture: picture.section)
    claims, found = (_read(folder / f"{name}.json") for name in ("claims", "found"))
    drawn, verdicts = {picture.name: picture for picture in by_section}, {c["id"]: c["verdict"] for c in claims}
    environment = Environment(
        loader=PackageLoader(__package__),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["short"] = _short
    contents: Mapping[str, Any] = {
        "sections": [(name, list(own)) for name, own in groupby(by_section, key=lambda picture: picture.section)],
        "found": [(drawn[one["figure"]], one["text"], one["claims"]) for one in found if one["figure"] in drawn],
        "verdicts": verdicts,
        "claims": claims,
        "tables": tables,
        "growing": growing,
    }
    path, part = folder / "index.html", folder / "index.html.part"
    part.write_text(environment.get_template("index.html").render(contents), encoding="utf-8")
    return part.replace(path)


def pictures(folder: Path, files: Sequence[str] = ()) -> list[Picture]:
    """All figures of the folder, each with those of the named CSV files that hold its numbers.

    Raises ValueError, which names the file, for a figure without a caption.
    """
    return [_picture(path, files) for path in sorted(folder.glob("*.png"), key=_natural)]


def _read(path: Path) -> list[Any]:
    """The list that a JSON file holds, empty where there is no such file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else []


def _natural(path: Path) -> list[str]:
    """A key by which file names sort with 2 before 10."""
    return [part.zfill(9) if part.isdigit() else part for part in re.split(r"(\d+)", path.stem)]


def _picture(path: Path, files: Sequence[str]) -> Picture:
    with Image.open(path) as image:
        if "Description" not in image.info:
            image.load()  # metadata may follow the pixels, which take a hundred times as long to read
        (width, height), metadata = image.size, image.info
    section, caption = metadata.get("Keywords"), metadata.get("Description")
    if not section or not caption:
        raise ValueError(
            f"expected a caption and a section in the metadata of {path}, got none; save it with "
            f"substep.figures.charts.save or take it out of the folder"
        )
    own = re.compile(re.escape(path.stem) + r"(?!\d).*\.csv")  # figure_1.csv, figure_1a.csv, not figure_10.csv
    return Picture(path.stem, width, height, section, caption, [file for file in files if own.fullmatch(file)])


def _table(path: Path) -> CsvTable:
    with path.open(encoding="utf-8", errors="replace", newline="") as file:  # it may end within a letter as yet
        reader = csv.reader(file)
        header, rows, size = next(reader, []), [], 0
        for row in reader:
            size += 1
            if size <= LONGEST:
                rows.append(row)
    return CsvTable(path.name, size, header, rows if size <= LONGEST else [])


def _short(text: str) -> str:
    return f"{float(text):.6g}" if NUMBER.fullmatch(text) else ROOT.sub("CRootOf(…)", text)
