"""The one door back to the derivation: closed forms and exact results for the command line and tables.

SymPy is imported here and nowhere else, when a function is called.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from substep_derive.show import ClosedForm


def closed_forms(name: str) -> "list[ClosedForm]":
    """Everything derived about a scheme: see `substep_derive.show`."""
    from substep_derive.show import closed_forms as derived  # noqa: PLC0415

    return derived(name)


@dataclass(frozen=True)
class Properties:
    """Exact properties of one parameter set, undamped: rho_inf, order, leading error terms."""

    rho_inf: Any
    order: int
    damping: tuple[int, Any] | None
    period: tuple[int, Any] | None


def properties(name: str, parameters: Mapping[str, Fraction]) -> Properties:
    """rho_inf, order of the free vibration, and the first term (power of Omega, coefficient) of each error."""
    from substep_derive import derive  # noqa: PLC0415
    from substep_derive.symbols import xi  # noqa: PLC0415

    d = derive(name, **parameters)

    def first(terms: Mapping[int, Any]) -> tuple[int, Any] | None:
        at_rest = ((power, coefficient.subs(xi, 0)) for power, coefficient in sorted(terms.items()))
        return next(((power, value) for power, value in at_rest if value != 0), None)

    return Properties(d.rho_inf, d.series.order, first(d.series.numerical_damping), first(d.series.period_error))
