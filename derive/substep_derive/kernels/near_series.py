"""Functions of potentials -> Taylor series of their divided differences, for arguments that are near each other."""

from math import factorial

from sympy import Add, Expr, Function, Rational, Symbol, factor

NEAR = Rational(1, 8)  # arguments no further apart take the Taylor series


TAYLOR_TERMS = 6  # its remainder there is below 1e-16 for log cosh: (NEAR/pi)^12


def near_series(g: type[Function]) -> tuple[Expr, Expr, Expr, Symbol]:
    """Taylor series of g's divided difference, of its slope by x1, and the former's last term; the mean m.

    In m and the difference d. The last term tells whether the series has converged: near a singularity of g
    arguments no further apart than NEAR may still be too far.
    """
    m, d = Symbol("m"), Symbol("d")
    derivatives = [g(m)]
    for _ in range(2 * TAYLOR_TERMS):
        derivatives.append(factor(derivatives[-1].diff(m)))
    # Difference(m, d) = sum of g^(2k+1)(m) (d/2)^(2k)/(2k+1)!; by x1, half of d/dm plus d/dd
    series = Add(*(derivatives[2 * k + 1] * (d / 2) ** (2 * k) / factorial(2 * k + 1) for k in range(TAYLOR_TERMS)))
    slope = Add(
        *(
            derivatives[2 * k + 2] * (d / 2) ** (2 * k) / (2 * factorial(2 * k + 1))
            + k * derivatives[2 * k + 1] * (d / 2) ** (2 * k - 1) / factorial(2 * k + 1)
            for k in range(TAYLOR_TERMS)
        )
    )
    last = derivatives[2 * TAYLOR_TERMS - 1] * (d / 2) ** (2 * TAYLOR_TERMS - 2) / factorial(2 * TAYLOR_TERMS - 1)
    return series, slope, last, m
