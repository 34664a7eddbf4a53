"""What the literature states about a scheme, to be held against what is derived."""

from dataclasses import dataclass
from typing import Any

from sympy import Basic


@dataclass(frozen=True)
class Published:
    """Facts about a scheme at its default parameters, undamped. They are tested, and nothing is derived from them.

    order: of accuracy of displacement and velocity. rho_inf: the spectral radius as Omega -> oo, an expression in
    the scheme's parameters or in a family's argument. critical_Omega: up to which the scheme is stable; oo if it is
    so for every Omega. stable_if: what is necessary and sufficient for that, in the parameters. source: where they
    are stated.
    """

    source: str
    order: int | None = None
    rho_inf: Any = None
    critical_Omega: Any = None
    stable_if: tuple[Basic, ...] = ()
