"""Polynomial of the live eigenvalues -> its value at the exact eigenvalue e^s, computed without loss of digits.

Live eigenvalues are those that are not always 0. s = Omega*zeta with zeta^2 = -2*xi*zeta - 1, so that every number is
written as alpha + beta*zeta. The polynomial is written in tau = 2*(lambda - 1)/(lambda + 1), which is 2*tanh(s/2) at
lambda = e^s: there its coefficients become small as its value does, E_0 of order Omega^2 and E_1 of order Omega. Terms
that cancel because the scheme is consistent are cancelled here, symbolically. What is left are tails of the power
series of tau, tau^2, ..., each of which has only every second power of s.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from math import comb

from sympy import Add, Expr, Integer, Rational, expand

from ..algebra.expanded import coefficients
from ..algebra.power_series import powers_of_zeta
from ..declare.symbols import Omega, xi

LEAST_TERMS, MOST_TERMS = 4, 9  # powers of Omega summed symbolically; a consistent scheme's first 3 sums are 0
DIGITS = 2.0**-46  # relative error allowed in a tail: it limits the digits of the scheme's errors, not of lambda


def about_one(c: Sequence[Expr]) -> list[Expr]:
    """Coefficients in powers of lambda - 1 from those in powers of lambda, lowest first."""
    return [expand(sum((comb(k, j) * e for k, e in enumerate(c) if k >= j), Integer(0))) for j in range(len(c))]


def in_tau(c: list[Expr]) -> list[Expr]:
    """Coefficients E_k in powers of tau, lowest first, of (1 - tau/2)^d times the polynomial of degree d in lambda.

    lambda = (1 + tau/2)/(1 - tau/2).
    """
    d = len(c) - 1

    def weight(j: int, k: int) -> Rational:
        """The coefficient of tau^k in (1 + tau/2)^j (1 - tau/2)^(d - j)."""
        return Rational(sum((-1) ** (k - i) * comb(j, i) * comb(d - j, k - i) for i in range(k + 1)), 2**k)

    return [expand(Add(*(weight(j, k) * e for j, e in enumerate(c)))) for k in range(d + 1)]


@cache
def series(j: int, n: int) -> Rational:
    """Coefficient of s^n in tau^j, by the recurrence that tau' = 1 - tau^2/4 gives."""
    if j == 0 or n < j:
        return Rational(n == j)
    return Rational(j, n) * (series(j - 1, n - 1) - series(j + 1, n - 1) / 4)


@dataclass(frozen=True)
class EigenvalueDefect:
    """The value at tau = 2*tanh(s/2): Omega^3*(p0 + p1*zeta) + Omega^terms*(constant + sum of k_jn*t_jn).

    p0, p1: from the powers of Omega below `terms`, which are summed symbolically. tails: (j, n) -> k_jn, where t_jn is
    the power series of tau^j from s^n on, divided by Omega^n. leading: the polynomial's coefficient of lambda^d.
    """

    terms: int
    p0: Expr
    p1: Expr
    constant: Expr
    tails: dict[tuple[int, int], Expr]
    leading: Expr

    @classmethod
    def of(cls, c: list[Expr], damping: Expr = xi) -> "EigenvalueDefect":
        """From the coefficients of the polynomial in lambda, lowest first; damping: xi, or 0 where there is none."""
        b = [[] if e == 0 else coefficients(e, Omega)[::-1] for e in in_tau(c)]
        zeta = powers_of_zeta(MOST_TERMS, damping)

        def shares_of(power: int) -> tuple[Expr, Expr]:
            """Those of Omega^power and of Omega^power*zeta in the value."""
            shares = [
                (column[power - n] * series(j, n), zeta[n])
                for j, column in enumerate(b)
                for n in range(j, power + 1)
                if power - n < len(column)
            ]
            return tuple(expand(sum((s * z[part] for s, z in shares), Integer(0))) for part in (0, 1))

        terms = LEAST_TERMS
        while terms < MOST_TERMS and shares_of(terms - 1) == (0, 0):
            terms += 1
        sums = [sum((shares_of(n)[part] * Omega ** (n - 3) for n in range(3, terms)), Integer(0)) for part in (0, 1)]
        tails: dict[tuple[int, int], Expr] = {}
        for j, column in enumerate(b):
            for i, e in enumerate(column):
                n = max(terms - i, j)
                n += (n - j) % 2
                if e != 0:
                    tails[j, n] = tails.get((j, n), Integer(0)) + e * Omega ** (n - terms + i)
        constant = tails.get((0, 0), Integer(0))
        return cls(terms, sums[0], sums[1], constant, {key: e for key, e in tails.items() if key[0]}, c[-1])

    @property
    def outputs(self) -> dict[str, Expr]:
        """What the kernel `_defect` returns: p0, p1, k0 for `constant`, k<j>_<n>, and the leading coefficient."""
        tails = {f"k{j}_{n}": self.tails[j, n] for j, n in sorted(self.tails)}
        return {"p0": self.p0, "p1": self.p1, "k0": self.constant, **tails, "leading": self.leading}


def until_negligible(j: int, first: int, small_Omega: float) -> Iterator[Rational]:
    """Coefficients of s^first, s^(first + 2), ... in tau^j: all that matter where |s| <= small_Omega, at least two."""
    n = first
    while n < first + 4 or abs(series(j, n)) * small_Omega ** (n - first) > DIGITS * abs(series(j, first)):
        yield series(j, n)
        n += 2
