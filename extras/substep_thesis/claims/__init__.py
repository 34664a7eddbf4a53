"""The ledger: what the thesis claims, each line judged by algebra when generated/ is derived, or by a computation now.

A verdict is the outcome of exact certificates, derived closed forms or compiled functions; none is written by hand.
"true": all that was computed agrees; "false": the claim as a whole fails; "partly": a part of it does.
"""

import json
from collections.abc import Iterator
from pathlib import Path

from ..by_algebra import finding
from . import chapter_2, chapter_4, chapter_5, misprints
from .judgement import Claim, Judgement, overall

CLAIMS: tuple[Claim, ...] = (
    *chapter_2.CLAIMS,
    *chapter_4.CLAIMS,
    *chapter_5.CLAIMS,
    *misprints.CLAIMS,
)


def judged(claim: Claim) -> Judgement:
    """One claim with verdict and evidence: those that its judge computes, or what the derivation has found."""
    if claim.judge is not None:
        verdict, evidence = claim.judge()
    else:
        parts, evidence = finding(claim.id)
        verdict = overall(*parts)
    return Judgement(claim.id, claim.text, verdict, evidence, claim.command)


def judge() -> Iterator[Judgement]:
    """Judge all claims one by one, chapter by chapter, then the misprints."""
    return map(judged, CLAIMS)


def write(folder: Path, judgements: list[Judgement]) -> None:
    """Write claims.md for a reader and claims.json for a program into the folder."""
    lines = [
        "# The thesis's claims, judged",
        "",
        "Each verdict was computed, those by algebra alone when the kernels were derived, the others for this page.",
        "",
    ]
    for j in judgements:
        lines += [f"## {j.id}: {j.verdict}", "", f"Claim: {j.claim}", ""]
        lines += [f"Found: {j.evidence}.", "", f"See: `{j.command}`", ""]
    (folder / "claims.md").write_text("\n".join(lines), encoding="utf-8")
    text = json.dumps([j.as_dict() for j in judgements], indent=1, ensure_ascii=False)
    (folder / "claims.json").write_text(text + "\n", encoding="utf-8")
