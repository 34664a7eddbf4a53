"""Functions of potentials -> Taylor series of their divided differences, for arguments that are near each other."""

from dataclasses import dataclass
from math import factorial

import sympy
from sympy import Add, Expr, Function, Rational, Symbol, factor

from ..declare.potentials import log_cosh, negative_part

NEAR = Rational(1, 8)  # arguments no further apart than this take the Taylor series
TAYLOR_TERMS = 6  # the remainder of so many is below 1e-16 for log cosh: (NEAR/pi)^12
FUNCTIONS: dict[str, type[Function]] = {"log_cosh": log_cosh, "negative_part": negative_part}


@dataclass(frozen=True)
class NearSeries:
    """Taylor series of the divided difference of a function, in the mean and the difference d of its arguments.

    slope: the series of its derivative with respect to the new argument. last: the last term of `series`, from whose
    size a kernel sees whether the series has converged: near a singularity, arguments no further apart than `near` may
    still be too far. near: 0 for a function with a kink, which has no series.
    """

    name: str
    function: type[Function]
    near: Rational
    mean: Symbol
    series: Expr
    slope: Expr
    last: Expr

    @classmethod
    def of(cls, name: str) -> "NearSeries":
        """The series of the function of that name: one of `FUNCTIONS`, or one of SymPy's."""
        g, m, d = FUNCTIONS.get(name) or getattr(sympy, name), Symbol("m"), Symbol("d")
        derivatives = [g(m)]
        for _ in range(2 * TAYLOR_TERMS):
            derivatives.append(factor(derivatives[-1].diff(m)))
        # Difference(m, d) = sum of g^(2k+1)(m) (d/2)^(2k)/(2k+1)!; its derivative by new is half of d/dm plus d/dd
        powers = [(d / 2) ** (2 * k) / factorial(2 * k + 1) for k in range(TAYLOR_TERMS)]
        series = Add(*(derivatives[2 * k + 1] * power for k, power in enumerate(powers)))
        slope = Add(
            *(
                derivatives[2 * k + 2] * (d / 2) ** (2 * k) / (2 * factorial(2 * k + 1))
                + k * derivatives[2 * k + 1] * (d / 2) ** (2 * k - 1) / factorial(2 * k + 1)
                for k in range(TAYLOR_TERMS)
            )
        )
        near = Rational(0) if g is negative_part else NEAR
        return cls(name, g, near, m, series, slope, derivatives[2 * TAYLOR_TERMS - 1] * powers[-1])

    def at(self, x: Symbol, order: int = 0) -> Expr:
        """The function at x, or its derivative of that order."""
        g = self.function(self.mean)
        return (g.diff(self.mean, order) if order else g).subs(self.mean, x)
