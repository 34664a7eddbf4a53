"""What a composite scheme is asked to be, checked."""

from dataclasses import dataclass
from typing import Any

from substep_derive.algebra.exact_number import exact_number
from substep_derive.declare.errors import DeclarationError
from sympy import Rational

FREE = "free"
CRITERIA = {
    "error_constant": "the first coefficient of e^z - R(z)",
    "period_error": "the first coefficient of the period error",
    "damping": "the numerical damping of low frequencies",
}
MOST_SUB_STEPS = 9


@dataclass(frozen=True)
class Wish:
    """Requirements of a scheme of n sub-steps.

    order: on linear and nonlinear problems. rho_inf: a number, `FREE` for every value in [0, 1], None for any.
    one_stiffness: whether all effective stiffnesses have to be the same. least: which error is to be least in size
    among all that meets the rest, a key of `CRITERIA`.
    """

    sub_steps: int
    order: int
    rho_inf: Rational | str | None = None
    one_stiffness: bool = True
    least: str = "error_constant"

    @classmethod
    def of(cls, sub_steps: Any, order: Any, rho_inf: Any, *, one_stiffness: bool, l_stable: bool, least: str) -> "Wish":
        """The wish. Raises DeclarationError for one that contradicts itself, TypeError for a float."""
        for name, number, most in (("sub-steps", sub_steps, MOST_SUB_STEPS), ("order", order, 2 * MOST_SUB_STEPS)):
            if isinstance(number, bool) or not isinstance(number, int) or not 1 <= number <= most:
                raise DeclarationError(f"expected {name} as an integer from 1 to {most}, got {number!r}; choose one")
        if order > 2 * sub_steps:
            raise DeclarationError(
                f"expected an order of at most 2 n = {2 * sub_steps} for n = {sub_steps} sub-steps, which no implicit "
                f"method exceeds (Butcher), got {order}; ask for a lower order or for more sub-steps"
            )
        if least not in CRITERIA:
            raise DeclarationError(f"expected what is to be least as one of {', '.join(CRITERIA)}; got {least!r}")
        wished = rho_inf if rho_inf in (None, FREE) else exact_number(rho_inf)
        if isinstance(wished, Rational) and not 0 <= wished <= 1:
            raise DeclarationError(
                f"expected rho_inf from 0 to 1, the spectral radius of a stable scheme, got {wished}; choose one "
                f"inside, or '{FREE}' for all of them"
            )
        if l_stable and wished not in (None, 0):
            raise DeclarationError(
                f"expected rho_inf = 0 for an L-stable scheme, got rho_inf = {wished}; ask for one of the two"
            )
        return cls(sub_steps, order, Rational(0) if l_stable else wished, one_stiffness, least)

    @property
    def text(self) -> str:
        """The wish in a line."""
        radius = {None: "any rho_inf", FREE: "every rho_inf in [0, 1]"}.get(self.rho_inf, f"rho_inf = {self.rho_inf}")
        stiffness = "one effective stiffness" if self.one_stiffness else "effective stiffnesses that may differ"
        steps = f"{self.sub_steps} sub-step{'s' if self.sub_steps > 1 else ''}"
        least = self.least.replace("_", " ")
        return f"{steps}, order {self.order}, {radius}, {stiffness}, A-stable, least {least}"
