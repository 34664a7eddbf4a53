"""What a design ends with: schemes, a proof that there are none, or what was tried before the time was up."""

from dataclasses import dataclass
from functools import cached_property
from time import process_time

from substep_derive.algebra.algebraic import Algebraic
from substep_derive.declare.scheme import Scheme
from substep_derive.stability.certificate import Certificate, certify
from sympy import Expr

from .wish import Wish


class OutOfTimeError(Exception):
    """The CPU time allowed is used up; says what was about to be done."""


class Budget:
    """CPU seconds of this process that a design may use, asked between exact steps, and the record of those steps."""

    def __init__(self, seconds: float) -> None:
        self.begin, self.seconds = process_time(), seconds
        self.done: list[str] = []

    def begin_step(self, what: str) -> None:
        """Note an exact step before it is taken. Raises OutOfTimeError where no time is left."""
        if process_time() - self.begin >= self.seconds:
            raise OutOfTimeError(f"no CPU time was left for: {what}")
        self.done.append(what)


@dataclass(frozen=True)
class Found:
    """A scheme of n sub-steps that meets the wish.

    gamma: the diagonal coefficient, a number, or None where every rho_inf has its own, the root of `equation` in
    `interval` (the numbers for rho_inf = 1 and 0). values: coefficients of z^2, z^3, ... in the numerator of the
    stability function R(z) = P(z)/(1 - gamma z)^n, in gamma (and rho_inf). error_constant: the first coefficient of
    e^z - R, that of z^(order + 1). table, times: rows of the coefficients and ends of the sub-steps, rational in gamma
    (and rho_inf). scheme: the declaration, ready for derive, certify and march.
    """

    gamma: Algebraic | Expr | None
    equation: Expr
    interval: tuple[Expr, Expr]
    numerator: tuple[Expr, ...]
    rho_inf: Expr
    error_constant: Expr
    table: tuple[tuple[Expr, ...], ...]
    times: tuple[Expr, ...]
    scheme: Scheme
    proof: tuple[str, ...]

    @cached_property
    def certificate(self) -> Certificate:
        """The exact certificate on the undamped oscillator, at rho_inf = 1/2 where it is free.

        A multiple eigenvalue on the circle, as of two trapezoidal steps, is unstable there and not for A-stability.
        """
        return certify(self.scheme)


@dataclass(frozen=True)
class Answer:
    """verdict: 'found', 'none' (proved) or 'undecided'. found: the best scheme, or None. proof: line by line."""

    wish: Wish
    verdict: str
    found: Found | None
    proof: tuple[str, ...]

    @property
    def text(self) -> str:
        """The wish, the verdict, and why."""
        words = {"found": "found", "none": "there is none", "undecided": "undecided"}
        lines = [f"{self.wish.text}: {words[self.verdict]}", *self.proof]
        if self.found is not None:
            lines += [f"{self.found.scheme.name}:", *(f"  {line}" for line in self.found.proof)]
        return "\n".join(lines)
