"""The site: every page is found from its first one, and generated pages say what was declared and derived."""

import importlib
import os
import re
import subprocess
import sys
import zlib
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import manual
import pytest
from declared import BY_NAME, NAMES
from manual import families, ledger, markdown, notebooks, picture, reference, scenes, schemes, structures
from manual.declarations import declaration
from matplotlib.figure import Figure
from plain_kernels import SCENE_BY_NAME
from substep_derive import certify
from substep_derive.declare import scenes as scene_package
from substep_derive.declare import schemes as scheme_package
from substep_derive.declare.digest import scene_digest, scheme_digest
from substep_derive.study.closed_forms import closed_forms
from substep_derive.study.equivalence import MATRIX, SPECTRUM, equivalences
from substep_languages.standalone import standalone
from sympy import latex

import substep as ss

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
VERIFY = pytest.mark.skipif(not os.environ.get("SUBSTEP_VERIFY"), reason="builds the whole site: make verify")


def contents(text: str) -> set[str]:
    """Entries of all tables of contents."""
    found = set()
    for block in re.findall(r"^:::\{toctree\}\n(.*?)^:::$", text, re.MULTILINE | re.DOTALL):
        found |= {line for line in block.splitlines() if line and not line.startswith(":")}
    return found


def test_every_page_is_in_the_table_of_contents_and_every_entry_is_a_page() -> None:
    written = {path.stem for path in DOCS.glob("*.md")} - {"index"}
    entries = contents((DOCS / "index.md").read_text(encoding="utf-8"))
    assert {entry for entry in entries if not entry.startswith("generated/")} == written
    made = {f"generated/{kind}/index" for kind in ("schemes", "scenes", "reference")}
    assert {entry for entry in entries if entry.startswith("generated/")} == made | {
        "generated/claims", "generated/families", "generated/structures_proved", "generated/notebooks/*",
    }  # fmt: skip


def links(page: Path) -> set[str]:
    """Relative addresses of a page's links and pictures, without the place within the page."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    found = {address.partition("#")[0] for address in re.findall(r"\]\(([^)\s]+)\)", text)}
    return {address for address in found if address and "://" not in address}


@pytest.mark.parametrize("page", [*ROOT.glob("*.md"), *DOCS.glob("*.md")], ids=lambda page: page.name)
def test_every_link_leads_to_a_page(page: Path) -> None:
    kinds = (schemes, scenes, reference, ledger, structures, families)
    made = {f"generated/{name}.md" for kind in kinds for name in kind.pages()}
    assert {x for x in links(page) if x not in made and not (page.parent / x).exists()} == set()


@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda page: page.name)
def test_headings_go_down_one_level_at_a_time(page: Path) -> None:
    """As the site's builder wants them, which warns else."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    levels = [len(marks) for marks in re.findall(r"^(#+) ", text, flags=re.MULTILINE)]
    assert all(after <= before + 1 for before, after in pairwise([0, *levels]))


def test_every_scheme_scene_and_notebook_has_a_page() -> None:
    assert set(schemes.pages()) == {"schemes/index", *(f"schemes/{name}" for name in NAMES)}
    assert set(scenes.pages()) == {"scenes/index", *(f"scenes/{name}" for name in ss.scenes())}
    assert contents(schemes.index()) == set(NAMES)
    assert contents(scenes.index()) == set(ss.scenes())
    assert set(notebooks.copies()) == {f"notebooks/{path.stem}" for path in (ROOT / "notebooks").glob("*.py")}


@pytest.mark.parametrize("name", [*NAMES, *ss.scenes()])
def test_the_text_of_a_declaration_declares_it(name: str) -> None:
    """Run in a module that has only what the declaring module imports, it gives an equal declaration."""
    scenes_known = {scene.name: scene for scene in scene_package.declared()}
    known, package, digest = (
        (BY_NAME, scheme_package, scheme_digest) if name in NAMES else (scenes_known, scene_package, scene_digest)
    )
    path, source = declaration(known[name], package)
    text = (ROOT / path).read_text(encoding="utf-8")
    module = importlib.import_module(".".join(Path(path).relative_to("derive").with_suffix("").parts))
    imported = re.findall(r"^from [^\n]* import (?:\([^)]*\)|[^\n]*)", text, re.MULTILINE)
    names: dict = {"__package__": module.__package__, "__name__": "shown"}
    exec("\n".join([*imported, source]), names)
    made = [value for value in names.values() if type(value) is type(known[name]) and value.name == name]
    assert [digest(value) for value in made] == [digest(known[name])]


def test_a_scene_with_a_law_has_a_page_with_its_motion(tmp_path: Path) -> None:
    text = scenes.page("hysteretic_oscillator", tmp_path)
    assert "Half a sine" in text
    assert (tmp_path / "hysteretic_oscillator.svg").exists()


def test_what_is_not_declared_has_no_text() -> None:
    with pytest.raises(LookupError, match="expected a declaration of substep_derive.declare.schemes, got duffing"):
        declaration(SCENE_BY_NAME["duffing"], scheme_package)


@pytest.mark.parametrize("package", reference.PACKAGES)
def test_every_public_name_has_an_entry(package: str) -> None:
    module, _ = reference.PACKAGES[package]
    text = reference.page(package)
    entries = re.findall(rf"^\.\. (?:auto|py:)(\w+):: {package}\.(\w+)$", text, re.MULTILINE)
    assert sorted(name for _, name in entries) == sorted(reference.public_names(module))
    assert all(reference.directive(getattr(module, name)) == kind for kind, name in entries)
    if package == "substep_derive":
        assert {name for kind, name in entries if kind == "data"} == set(reference.SYMBOLS)


def test_what_docstrings_refer_to_has_an_entry_or_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    text = reference.further_page()
    assert "`substep.studies.precision.choose`" in (ss.choose.__doc__ or "")
    assert ".. autofunction:: substep.studies.precision.choose\n" in text
    assert "Modes" not in text
    monkeypatch.setattr(ss.choose, "__doc__", "See `substep.studies.nosuch`.")
    with pytest.raises(LookupError, match=r"expected an object .* got `substep\.studies\.nosuch`"):
        reference.further()


def test_a_scheme_page_holds_closed_forms_and_the_proof(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("manual.charts.stability", lambda name: Figure())
    text = schemes.page("newmark", tmp_path)
    for form in closed_forms("newmark"):
        assert (markdown.plain(form.text) if isinstance(form.value, str) else latex(form.value)) in text, form.name
    assert certify("newmark").text in text
    assert "| `beta` | $\\left[0, \\infty\\right)$ | 0.25 |" in text
    assert "schemes/newmark.py <../../../generated/substep_kernels/schemes/newmark.py>" in text
    assert f"```c\n{standalone('newmark', 'c')}```\n" in text
    assert (tmp_path / "newmark.svg").exists()


@pytest.mark.thorough
def test_the_map_of_families_has_lines_that_do_not_follow_from_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("newmark", "generalized_alpha", "average_acceleration", "energy_momentum", "hht_alpha", "bathe")
    found = list(equivalences([BY_NAME[name] for name in names], steps=(1,)))
    every = families.whole(found)
    lines = families.members(every)
    assert lines["generalized_alpha", "newmark"] == lines["newmark", "average_acceleration"] == MATRIX
    assert every["newmark", "energy_momentum"] == SPECTRUM
    assert families.alike(every)["energy_momentum"] == "average_acceleration"
    assert ("generalized_alpha", "average_acceleration") not in lines  # it is Newmark's
    assert "bathe" not in {name for pair in lines for name in pair}
    monkeypatch.setattr(families, "equivalences", lambda steps: found)
    text = families.page(tmp_path)
    assert "| [newmark](schemes/newmark.md) `beta = 1/4, gamma = 1/2` | [average_acceleration](schemes/" in text
    drawn = (tmp_path / families.FIGURE).read_text(encoding="utf-8")
    assert all(f"<!-- {name} -->" in drawn for name in names[:5])


def test_the_page_on_structures_has_verdict_and_energy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ss, "schemes", lambda: ["central_difference", "oalts", "wilson_theta"])
    text = structures.page()
    assert r"proved under a bound: h^2 K \< 4 M" in text
    assert r"$(- \frac{\Omega^{4}}{4} + \Omega^{2})\,u^2 + (hv)^2$ | $1$ |" in text
    assert "| [oalts](schemes/oalts.md) | proved |" in text
    assert "the spurious root" in text
    last = [line.rsplit("|", 2)[1].strip() for line in text.splitlines() if line.startswith("| [")]
    assert last == ["explicit", "from between 0.39282 and 0.39322 on", "from between 0.44946 and 0.44992 on"]


def test_a_formula_too_long_to_be_read_is_left_to_the_command_line() -> None:
    assert markdown.formula("x" * markdown.LONGEST, "it")[1] == "x" * markdown.LONGEST
    assert markdown.formula("x" * (markdown.LONGEST + 1), "`substep show a` prints it") == [
        f"A formula of {markdown.LONGEST + 1} characters: `substep show a` prints it.", "",
    ]  # fmt: skip


def test_a_page_is_written_again_only_when_its_stamp_is_another(tmp_path: Path) -> None:
    path, made = tmp_path / "kind" / "page.md", []

    def text(folder: Path) -> str:
        made.append(folder)
        return "# Title\n"

    assert manual.write_page(path, "one", text)
    assert not manual.write_page(path, "one", text)
    assert manual.write_page(path, "two", text)
    assert made == [path.parent, path.parent]
    assert path.read_text(encoding="utf-8").endswith("\n# Title\n")


def test_the_digest_knows_every_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (manual, *(sys.modules[name] for name in ("substep", "substep_derive", "substep_kernels"))):
        assert any(Path(module.__file__ or "").is_relative_to(ROOT / folder) for folder in manual.SOURCES), module
    for folder in manual.SOURCES:
        (tmp_path / folder).mkdir(parents=True)
        assert (ROOT / folder).is_dir()
    monkeypatch.setattr(manual, "ROOT", tmp_path)
    digests = [manual.sources_digest()]
    for folder in manual.SOURCES:
        (tmp_path / folder / "file.py").write_text("", encoding="utf-8")
        digests.append(manual.sources_digest())
    assert len(set(digests)) == len(digests)


def test_the_picture_of_the_readme_shows_what_is_computed_now() -> None:
    """Where it does not, `python -m manual.picture` in docs/site draws it again."""
    text = picture.PATH.read_text(encoding="utf-8")
    assert f"<dc:description>{picture.digest(picture.curves())}</dc:description>" in text
    assert "docs/picture.svg" in (ROOT / "README.md").read_text(encoding="utf-8")


class Loaded(HTMLParser):
    """What a browser loads with a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        if tag in ("script", "img", "iframe", "source"):
            self.addresses += [found["src"] or ""] if "src" in found else []
        elif tag == "link" and found.get("rel") in ("stylesheet", "preload", "icon", "shortcut icon"):
            self.addresses.append(found["href"] or "")


@VERIFY
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("$\\nosuch{x}$", "expected LaTeX that docutils turns into MathML, got '\\\\nosuch{x}'"),
        (":::{derived}\nderive('nosuch').rho_inf\n:::", "expected a Python expression that can be computed"),
    ],
)
def test_a_formula_that_cannot_be_shown_stops_the_site(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "index.md").write_text(f"# Title\n\n{text}\n", encoding="utf-8")
    settings = "extensions = ['myst_nb', 'manual.formulas']\nmyst_enable_extensions = ['colon_fence', 'dollarmath']\n"
    settings += "html_math_renderer, nb_execution_mode = 'mathml', 'off'\n"
    (tmp_path / "conf.py").write_text(settings, encoding="utf-8")
    paths = os.pathsep.join([str(DOCS / "site"), *(path for path in sys.path if path)])
    command = [sys.executable, "-m", "sphinx", "-W", "-q", str(tmp_path), str(tmp_path / "site")]
    environment = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert message in done.stderr


@VERIFY
@pytest.mark.long
def test_the_site_is_built_without_a_warning_and_needs_no_network(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-c", str(DOCS / "site"), str(DOCS)]
    done = subprocess.run([*command, str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pages = [f"schemes/{name}" for name in NAMES] + [f"scenes/{name}" for name in ss.scenes()]
    pages += [f"notebooks/{path.stem}" for path in (ROOT / "notebooks").glob("*.py")]
    for page in pages:
        assert (tmp_path / "generated" / f"{page}.html").exists(), page
    html = {path: path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.html")}
    for path, text in html.items():
        assert not [x for x in Loaded(text).addresses if "//" in x], path
    assert "<math" in html[tmp_path / "generated" / "schemes" / "newmark.html"]
    inventory = zlib.decompress((tmp_path / "objects.inv").read_bytes().split(b"zlib.\n", 1)[1]).decode()
    for package, (module, _) in reference.PACKAGES.items():
        for name in reference.public_names(module):
            assert re.search(rf"^{package}\.{name} py:", inventory, re.MULTILINE), name
