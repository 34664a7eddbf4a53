"""What derivation says of the thesis: read from generated/facts.py, or derived when asked for."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import ModuleType
from typing import TYPE_CHECKING, Any

from .generated import facts

if TYPE_CHECKING:
    from substep_derive.oscillator.overshoot import Overshoot

# Table 4.1 and the sub-step ratios of figures 4.1 to 4.5
NEWMARK_SETS = tuple((Fraction(beta), Fraction(gamma)) for beta, gamma in facts.NEWMARK_SETS)
SPLITS = tuple(map(Fraction, facts.SPLITS))


@dataclass(frozen=True)
class Properties:
    """Exact properties of one parameter set, undamped, as text: rho_inf, leading error terms (power, coefficient)."""

    rho_inf: str
    order: int
    damping: tuple[int, str] | None
    period: tuple[int, str] | None


def properties(name: str, parameters: Mapping[str, Fraction]) -> Properties:
    """rho_inf, order of the free vibration, and the first term (power of Omega, coefficient) of each error.

    Those of chapter 4 are in generated/facts.py; others are derived: see `derive.facts.properties`.
    """
    found = facts.PROPERTIES.get((name, *sorted(f"{key}={value}" for key, value in parameters.items())))
    if found is None:
        from .derive.facts import properties as derive_properties  # noqa: PLC0415 (SymPy)

        found = derive_properties(name, parameters)
    return Properties(**found)


def finding(claim: str) -> tuple[tuple[bool, ...], str]:
    """Whether each part of a claim that algebra alone judges holds, and the evidence: see `derive.findings`."""
    return facts.FINDINGS[claim]


def printed() -> ModuleType:
    """The module that compares the thesis's printed formulas with derived ones."""
    from .derive import printed as formulas  # noqa: PLC0415 (SymPy)

    return formulas


def stable_values(name: str) -> Any:
    """The values of a scheme's only parameter for which it is stable at every Omega > 0, undamped: a set of SymPy."""
    from substep_derive.stability.conditions import conditions  # noqa: PLC0415 (SymPy)

    from .derive.region import stable_values as of  # noqa: PLC0415

    return of(conditions(name))


def overshoot(name: str) -> "Overshoot":
    """Overshoot class of a scheme, such as U0-V1, at almost all values of its parameters."""
    from substep_derive.declare.catalogue import find  # noqa: PLC0415 (SymPy)
    from substep_derive.oscillator.evaluation import Evaluation  # noqa: PLC0415
    from substep_derive.oscillator.overshoot import overshoot as of  # noqa: PLC0415

    return of(Evaluation.free(find(name)))


def undamped(expression: Any) -> Any:
    """A derived expression at xi = 0, factored."""
    from substep_derive.declare.symbols import xi  # noqa: PLC0415 (SymPy)

    return expression.subs(xi, 0).factor()
