"""The ledger of claims, judged while the site is built."""

from collections.abc import Callable
from pathlib import Path

from substep_thesis.claims import judge

from .markdown import code, plain


def pages() -> dict[str, Callable[[Path], str]]:
    """Name of a page -> its text."""
    return {"claims": lambda _: page()}


def page() -> str:
    """Each claim with its verdict and the evidence."""
    lines = ["# What the thesis claims, judged", ""]
    lines += [
        "Each verdict was computed, those by algebra alone when the kernels were derived, the others for this page.",
        "",
    ]
    for j in judge():
        lines += [f"## {j.id}: {j.verdict}", "", f"Claim: {plain(j.claim)}", "", f"Found: {plain(j.evidence)}.", ""]
        lines += [f"See {code(j.command)}.", ""]
    return "\n".join(lines)
