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
    rows = [line for line in findings.splitlines() if line.startswith("| ")][1:]
    assert len(rows) == len(wrong) > 50
    assert all(len(row.split(" | ")) == 5 for row in rows)
    table = [line for line in every.splitlines() if line.startswith("| ")][1:]
    assert len(table) == sum(len(program["reports"]) for program in reports)
    shown = [re.sub("<details>.*</details>", "", row.split(" | ")[2]) for row in table]
    assert all(len(re.findall(r"\b[a-z]\w+_\w+\(", cell)) <= 2 for cell in shown)
    assert max(map(len, shown)) <= 220


def test_the_name_of_the_manual_comes_first(page: str) -> None:
    row = next(line for line in page.splitlines() if "`Newmark(integrator=Newmark, beta=0.25, gamma=0.5)`" in line)
    assert row.split(" | ")[2].startswith("newmark(beta = 1/4, gamma = 1/2), all entries")
    assert "<summary>" in row
