"""What a claim and a judgement are, and exact helpers that all chapters use."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any, Literal

from ...derived import facade

Verdict = Literal["true", "false", "partly"]
Judge = Callable[[], tuple[Verdict, str]]  # -> verdict, evidence


@dataclass(frozen=True)
class Claim:
    """What the thesis says, under the id of the ledger.

    command: shows what decides it; judge: computes verdict and evidence.
    """

    id: str
    text: str
    command: str
    judge: Judge


@dataclass(frozen=True)
class Judgement:
    """One line of the ledger."""

    id: str
    claim: str
    verdict: Verdict
    evidence: str
    command: str

    def as_dict(self) -> dict[str, str]:
        """For results/claims.json."""
        return asdict(self)


def overall(*parts: bool) -> Verdict:
    """true if all parts hold, false if none does."""
    return "true" if all(parts) else "partly" if any(parts) else "false"


def fractions(*texts: str) -> tuple[Fraction, ...]:
    """Exact numbers."""
    return tuple(Fraction(text) for text in texts)


def stable(name: str, **parameters: Fraction) -> bool:
    """By exact certificate, undamped."""
    return facade.certificate(name, **parameters).stable


def throughout(region: Any) -> str:
    """How the derived conditions decide whether a scheme is stable everywhere in a region."""
    if region.stable:
        return "stable everywhere, for no derived condition is left there"
    first = ", ".join(f"{name} = {value}" for name, value in region.counterexample.items())
    return f"unstable {'everywhere' if region.unstable else 'in a part'}, for one at {first}"


def show(value: Any) -> str:
    """An exact number with its decimals."""
    return f"{value}" if value == int(value) else f"{value} = {float(value):.6g}"


def row(values: Any) -> str:
    """Numbers to four digits."""
    return "(" + ", ".join(f"{float(x):.4g}" for x in values) + ")"


def listed(values: Any) -> str:
    """Exact numbers, or "none"."""
    return ", ".join(str(x) for x in values) or "none"
