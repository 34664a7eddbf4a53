"""docs/audits.md is what its generator makes of the stored reports, and can be read."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.syspath_prepend(str(ROOT))
    sys.modules.pop("audits", None)
    from audits.page import page as made

    return made(ROOT / "audits")


def test_the_page_is_what_is_generated(page: str) -> None:
    assert (ROOT / "docs" / "audits.md").read_text(encoding="utf-8") == page


def test_a_finding_a_row_and_equal_schemes_are_folded_away(page: str) -> None:
    """Against the reports: every statement of a manual that does not hold has one row."""
    from audits import evidence

    reports = [evidence.read(name) for name in evidence.audited()]
    wrong = [
        claim
        for program in reports
        for report in program["reports"]
        for claim in report["claims"]
        if claim["verdict"] in ("false", "partly")
    ]
    findings, _, every = page.partition("## Every integrator")
    rows = [line for line in findings.splitlines() if line.startswith("| `")]
    assert len(rows) == len(wrong) > 50
    assert all(len(row.split(" | ")) == 4 for row in rows)
    table = [line for line in every.splitlines() if line.startswith("| ")][1:]
    assert len(table) == sum(len(program["reports"]) for program in reports)
    shown = [re.sub("<details>.*</details>", "", row.split(" | ")[2]) for row in table]
    assert all(len(re.findall(r"\b[a-z]\w+_\w+\(", cell)) <= 2 for cell in shown)
    assert max(map(len, shown)) <= 220


def test_a_sentence_of_a_manual_is_quoted_once_above_what_does_not_hold_of_it(page: str) -> None:
    """Readable on paper: a heading for each program, no folded text, and the cause beside what runs."""
    findings, _, _ = page.partition("## Every integrator")
    assert "<details>" not in findings
    _, *programs = re.split(r"^### ", findings, flags=re.MULTILINE)
    assert len(programs) > 8
    for program in programs:
        quoted = re.findall("^“.*”$", program, re.MULTILINE)
        assert len(quoted) == len(set(quoted)) == program.count("| integrator | the manual says | what runs | costs |")
    row = next(line for line in findings.splitlines() if line.startswith("| `HHT(alpha=0.9)` | order 2 |"))
    assert "the acceleration at t = 0 is taken as 0, unless it is given" in row
    assert row.endswith("| order 1 in free and driven motion, damped or not |")


def test_the_name_of_the_manual_comes_first(page: str) -> None:
    row = next(line for line in page.splitlines() if "`Newmark(integrator=Newmark, beta=0.25, gamma=0.5)`" in line)
    assert row.split(" | ")[2].startswith("newmark(beta = 1/4, gamma = 1/2), all entries")
    assert "<summary>" in row
