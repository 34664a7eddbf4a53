"""The page of results: what stands in the folder, with the captions figures carry, as valid HTML."""

import json
import struct
import zlib
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image
from substep_thesis import page

from substep.figures.charts import save, save_csv

VOID = {"meta", "link", "img", "br", "hr"}


class Reader(HTMLParser):
    """What the page holds; tags that do not match are an error."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.images: list[str] = []
        self.texts: dict[str, list[str]] = {}
        self.ids: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {key: value or "" for key, value in attrs}
        assert len(found) == len(attrs)
        if tag not in VOID:
            self.open.append(tag)
        self.ids += [found["id"]] if "id" in found else []
        self.links += [found["href"]] if "href" in found else []
        self.images += [found["src"]] if "src" in found else []

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            self.texts.setdefault(self.open[-1], []).append(data.strip())


def figure() -> Figure:
    drawn = Figure(figsize=(2, 1))
    drawn.subplots().plot([0, 1])
    return drawn


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save(figure(), tmp_path / "figure_5_10", "Chapter 5", "The tenth, γ_t < 0.2 & ρ∞ > 0.")
    save(figure(), tmp_path / "figure_5_1", "Chapter 5", "The first,\n        of two lines.")
    save(figure(), tmp_path / "models", "Elastic or rigid", "Models.")
    save_csv(tmp_path / "figure_5_1a.csv", ["h/T", "a <b>"], [np.array([1.0, 2.0]), np.array([0.1, 1 / 3])])
    save_csv(tmp_path / "figure_5_10.csv", ["x"], [np.arange(page.LONGEST + 1.0)])
    claim = {"id": "C1", "claim": "a < b", "verdict": "partly", "evidence": "b & c", "command": "substep claims"}
    (tmp_path / "claims.json").write_text(json.dumps([claim]), encoding="utf-8")
    return tmp_path


def test_every_figure_with_its_caption_claim_and_table(folder: Path) -> None:
    text = page.write(folder).read_text(encoding="utf-8")
    found = Reader(text)
    assert len(set(found.ids)) == len(found.ids)
    assert found.images == ["figure_5_1.png", "figure_5_10.png", "models.png"]
    assert [t for t in found.texts["figcaption"] if t] == [
        "The first, of two lines.", "The tenth, γ_t < 0.2 & ρ∞ > 0.", "Models.",
    ]  # fmt: skip
    assert found.texts["h2"] == ["Chapter 5", "Elastic or rigid", "The ledger", "Tables"]
    assert "γ_t &lt; 0.2 &amp; ρ∞ &gt; 0." in text
    assert {"a < b", "b & c", "0.333333", "0.1"} <= set(found.texts["td"])
    assert "a <b>" in found.texts["th"]
    assert "figure_5_1a.csv: 2 rows" in found.texts["summary"]
    assert "100" not in found.texts["td"]
    assert f"figure_5_10.csv</a>: {page.LONGEST + 1} rows of 1 columns" in text
    for link in [*found.links, *found.images]:
        if link.startswith("#"):
            assert link[1:] in found.ids
        elif link != "claims.md":
            assert (folder / link).exists(), link
    assert "://" not in text
    assert "<script" not in text


def test_numbers_are_linked_at_their_figure(folder: Path) -> None:
    files = ["figure_5_1.csv", "figure_5_10.csv", "figure_5_1a.csv", "models.csv", "models_2.csv"]
    assert page._picture(folder / "figure_5_1.png", files).numbers == ["figure_5_1.csv", "figure_5_1a.csv"]
    assert page._picture(folder / "models.png", files).numbers == ["models.csv", "models_2.csv"]


def test_the_same_files_give_the_same_bytes(folder: Path) -> None:
    once = page.write(folder).read_bytes()
    picture = (folder / "models.png").read_bytes(), (folder / "models.svg").read_bytes()
    save(figure(), folder / "models", "Elastic or rigid", "Models.")
    assert ((folder / "models.png").read_bytes(), (folder / "models.svg").read_bytes()) == picture
    assert page.write(folder).read_bytes() == once
    assert "<dc:description>Models.</dc:description>" in (folder / "models.svg").read_text(encoding="utf-8")


FOUND = [
    {"figure": "models", "text": "7 < 8 models differ.", "claims": ["C1", "C9"]},
    {"figure": "figure_5_10", "text": "It ends at 0.2.", "claims": []},
    {"figure": "not_drawn_yet", "text": "Nothing is known of it.", "claims": []},
]


def test_the_page_opens_with_what_was_found_each_with_its_figure(folder: Path) -> None:
    (folder / "found.json").write_text(json.dumps(FOUND), encoding="utf-8")
    text = page.write(folder).read_text(encoding="utf-8")
    found = Reader(text)
    assert len(set(found.ids)) == len(found.ids)
    assert found.images[:2] == ["models.png", "figure_5_10.png"]  # in the order given, before all sections
    assert len(found.images) == 2 + 3
    assert found.texts["h2"][0] == "What was found"
    assert text.index("7 &lt; 8 models differ.") < text.index('id="section-1"')
    assert {"#models", "#figure_5_10", "#C1"} <= set(found.links)
    assert "#C9" not in found.links  # not in the ledger
    assert "not_drawn_yet" not in text
    assert all(link[1:] in found.ids for link in found.links if link.startswith("#"))


def test_a_page_that_grows_says_so_and_is_whole_at_any_time(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = page.write(folder, "3 of 35 figures are drawn").read_text(encoding="utf-8")
    assert "3 of 35 figures are drawn" in text
    assert 'http-equiv="refresh"' in text
    assert Reader(text).images == ["figure_5_1.png", "figure_5_10.png", "models.png"]
    assert "refresh" not in page.write(folder).read_text(encoding="utf-8")

    def interrupted(self: Path, *_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_text", interrupted)
    with pytest.raises(KeyboardInterrupt):
        page.write(folder)
    assert Reader((folder / "index.html").read_text(encoding="utf-8")).images


def test_an_algebraic_number_is_a_short_cell(folder: Path) -> None:
    root = "6*CRootOf(269*Omega**6 - 270*Omega**4 + 90*Omega**2 - 10, 1)"
    (folder / "catalogue.csv").write_text(f'scheme,critical_Omega\nrkn43,"{root}"\n', encoding="utf-8")
    cells = Reader(page.write(folder).read_text(encoding="utf-8")).texts["td"]
    assert "6*CRootOf(…)" in cells
    assert not any("Omega**" in cell for cell in cells)


def test_captions_after_the_pixels_are_found(folder: Path) -> None:
    """Some programs write a PNG's texts last."""
    Image.new("RGB", (4, 4)).save(folder / "models.png")
    pixels, end = (folder / "models.png").read_bytes(), 12  # of the last chunk, IEND: length, name and checksum
    texts = (b"tEXtDescription\0Written last.", b"tEXtKeywords\0Models")
    chunks = (struct.pack(">I", len(text) - 4) + text + struct.pack(">I", zlib.crc32(text)) for text in texts)
    (folder / "models.png").write_bytes(pixels[:-end] + b"".join(chunks) + pixels[-end:])
    assert "Written last." in [picture.caption for picture in page.pictures(folder)]


def test_a_figure_without_a_caption_is_an_error_that_names_it(folder: Path) -> None:
    Image.new("RGB", (4, 4)).save(folder / "found.png")
    with pytest.raises(ValueError, match=r"expected a caption and a section in the metadata of .*found\.png"):
        page.write(folder)


def test_an_empty_folder_is_a_page(tmp_path: Path) -> None:
    found = Reader(page.write(tmp_path).read_text(encoding="utf-8"))
    assert not found.images
    assert "h2" not in found.texts


def test_a_figure_that_is_not_whole_leaves_the_one_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save(figure(), tmp_path / "models", "Models", "The first.")
    before = {name: (tmp_path / name).read_bytes() for name in ("models.png", "models.svg")}

    def interrupted(self: Figure, path: Path, **_: object) -> None:
        path.write_bytes(b"the first half")
        raise KeyboardInterrupt

    monkeypatch.setattr(Figure, "savefig", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save(figure(), tmp_path / "models", "Models", "The second.")
    assert {name: (tmp_path / name).read_bytes() for name in before} == before
    assert [picture.name for picture in page.pictures(tmp_path)] == ["models"]
