"""The ledger: every claim has its judge, and a verdict follows the formulas."""

import json
from pathlib import Path

import pytest
from substep_derive.study import thesis
from substep_derive.study.thesis import gholampour_printed
from sympy import Rational

from substep.derived import facade
from substep.thesis import claims
from substep.thesis.claims import chapter_2, chapter_4, misprints

IDS = {
    *(f"C2.{k}" for k in range(1, 15)),
    *(f"C4.{k}" for k in range(1, 9)),
    *(f"C5.{k}" for k in range(1, 7)),
    *(f"C6.{k}" for k in range(1, 4)),
    *("M2.2", "M2.9", "M2.20", "M2.23", "M2.26", "M2.54", "Mp15", "M3.9"),
}


def test_every_claim_has_a_judge() -> None:
    assert {claims.key(judge) for judge, _ in claims.JUDGES} == IDS


@pytest.fixture(scope="module")
def ledger() -> dict[str, claims.Judgement]:
    return {j.id: j for j in claims.judge()}


def test_all_are_judged_with_evidence(ledger: dict[str, claims.Judgement], tmp_path: Path) -> None:
    assert set(ledger) == IDS
    for j in ledger.values():
        assert j.verdict in ("true", "false", "partly")
        assert any(c.isdigit() for c in j.evidence) or "True" in j.evidence or "gamma_t" in j.evidence, j
        assert j.command.startswith("substep ")
    claims.write(tmp_path, list(ledger.values()))
    read = json.loads((tmp_path / "claims.json").read_text())
    assert [set(entry) for entry in read] == [{"id", "claim", "verdict", "evidence", "command"}] * len(IDS)
    assert "## C4.1: false" in (tmp_path / "claims.md").read_text()


def test_textbook_facts_come_out(ledger: dict[str, claims.Judgement]) -> None:
    """Facts that literature independent of the thesis settles."""
    assert ledger["C2.1"].verdict == "true"
    assert "2*sqrt(3)" in ledger["C2.2"].evidence
    assert "sqrt(6)" in ledger["C2.2"].evidence
    assert ledger["C2.13"].verdict == "false"  # an L-stable composite dissipates
    assert ledger["C4.1"].verdict == "false"
    assert ledger["C4.2"].verdict == "true"
    assert all(ledger[key].verdict == "false" for key in IDS if key.startswith("M"))


def test_a_verdict_follows_the_formula(monkeypatch: pytest.MonkeyPatch) -> None:
    """Changed on purpose: (4.16) halved is right, a wrong slope in Gholampour's scheme breaks its region."""
    right = thesis.printed_a31()
    monkeypatch.setattr(thesis, "printed_a31", lambda: right / 2)
    assert chapter_4.claim_4_1()[0] == "true"

    def certificate(name: str, xi: object = 0, **parameters: object) -> object:
        return thesis.certify(gholampour_printed if name == "gholampour" else name, xi=xi, **parameters)

    monkeypatch.setattr(facade, "certificate", certificate)
    assert chapter_2.claim_2_10()[0] == "false"
    assert misprints.misprint_2_54()[0] == "true"
    monkeypatch.setattr(thesis, "composite_is_bathe", lambda: False)
    assert chapter_4.claim_4_2()[0] == "false"


def test_printed_ratio_is_a_number() -> None:
    assert thesis.a31_ratio() == Rational(2)
