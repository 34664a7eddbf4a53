"""What a claim and a judgement are, and what the judges of all chapters use."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any, Literal

from substep.derived import facade

Verdict = Literal["true", "false", "partly"]
Judge = Callable[[], tuple[Verdict, str]]  # -> verdict, evidence


@dataclass(frozen=True)
class Claim:
    """A statement of the thesis, under its id in the ledger.

    command: a command that shows what decides it; judge: computes verdict and evidence, or is None for a claim that
    algebra alone judges, when generated/ is derived.
    """

    id: str
    text: str
    command: str
    judge: Judge | None = None


@dataclass(frozen=True)
class Judgement:
    """One line of the ledger: a claim, its verdict and the evidence."""

    id: str
    claim: str
    verdict: Verdict
    evidence: str
    command: str

    def as_dict(self) -> dict[str, str]:
        """For results/claims.json."""
        return asdict(self)


def overall(*parts: bool) -> Verdict:
    """The verdict on a claim of several parts: "true" if all hold, "false" if none does, else "partly"."""
    return "true" if all(parts) else "partly" if any(parts) else "false"


def stable(name: str, **parameters: Fraction) -> bool:
    """Whether a scheme is stable for every Omega > 0, undamped, by exact certificate."""
    return facade.certificate(name, **parameters).stable


def row(values: Any) -> str:
    """Numbers for a reader, to four digits."""
    return "(" + ", ".join(f"{float(x):.4g}" for x in values) + ")"


def listed(values: Any) -> str:
    """Values for a reader, separated by commas, or "none"."""
    return ", ".join(str(x) for x in values) or "none"
