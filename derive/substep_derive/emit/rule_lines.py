"""OneRule -> lines that compute the matrices of a step from R and S, in pairs of doubles, each entry rounded once.

Horner's rule in alpha + beta*L loses digits where the eigenvalues of L lie far apart, so that doubles would not do.
What the lines call is the arithmetic `by` that formulas are given.
"""

from collections.abc import Iterable
from itertools import count

from sympy import Expr, horner

from ..algebra.constant import approximated
from ..declare.names import entry_name
from ..oscillator.one_rule import SQUARE, Coefficients, OneRule
from .double_double import DoubleDouble

ZERO = "0.0, 0.0"


class _Lines:
    """Lines that assign numbers alpha + beta*L; such a number is the four names of alpha, its tail, beta, its tail."""

    def __init__(self, rule: OneRule, constants: Iterable[Expr]) -> None:
        """constants: coefficients that are needed beside those of R."""
        listed = dict.fromkeys(c for c in (*rule.den, *rule.increment, *constants) if not c.is_Integer)
        self._names = {c: f"k{i}" for i, c in enumerate(listed)}
        self._pairs, self._fresh = DoubleDouble(), count()
        square = [(f"w{i}", e) for i, e in enumerate(SQUARE)]
        self._pairs.assign([*square, *((name, horner(approximated(c))) for c, name in self._names.items())])
        self.square = [self._pairs.pair(name) for name, _ in square]
        self._L = ", ".join(self.square)
        self.lines = [*self._pairs.lines]
        Q = self.at_L(rule.den)
        self.lines.append(f"c0, c0t, d0, d0t, n0, n0t = by.conjugate({', '.join(Q)}, {self._L})")

    def constant(self, c: Expr) -> str:
        """Head and tail of a coefficient."""
        return f"{float(c)}, 0.0" if c.is_Integer else self._pairs.pair(self._names[c])

    def _assigned(self, call: str) -> list[str]:
        i = next(self._fresh)
        names = [f"a{i}", f"a{i}t", f"b{i}", f"b{i}t"]
        self.lines.append(f"{', '.join(names)} = {call}")
        return names

    def at_L(self, p: Coefficients) -> list[str]:
        """The value of a polynomial."""
        *rest, highest = p
        value = [*self.constant(highest).split(", "), "0.0", "0.0"]
        for c in reversed(rest):
            value = self.times_L(value, self.constant(c))
        return value

    def times_L(self, value: list[str], plus: str = ZERO) -> list[str]:
        """The value times L, and a number added."""
        return self._assigned(f"by.horner({', '.join(value)}, {self._L}, {plus})")

    def over_Q(self, p: Coefficients) -> list[str]:
        """p(L)/Q(L) times n0."""
        return self._assigned(f"by.product({', '.join(self.at_L(p))}, c0, c0t, d0, d0t, {self._L})")

    def free(self, rule: OneRule) -> tuple[list[str], list[str], list[str]]:
        """The rows of R(L) - 1 and the lower row of L R(L), which gives the acceleration, times n0."""
        upper = self.times_L(self.over_Q(rule.increment[1:]))  # L ((R - 1)/L), which is exactly 0 at Omega = 0
        R = [*self.plus(upper[:2], ["n0", "n0t"]), *upper[2:]]
        return upper, self.times_L(upper), self.times_L(self.times_L(R))

    def loaded(self, S: Coefficients) -> tuple[list[str], list[str], list[str]]:
        """Pairs: u, h*v and L's lower row times these, from a load, times n0 and its scale."""
        u = self.over_Q(S)
        v = self.times_L(u)
        return u[2:], v[2:], self.times_L(v)[2:]

    def den(self, name: str, scale: Expr) -> list[str]:
        """The pair n0*scale."""
        if scale == 1:
            return ["n0", "n0t"]
        self.lines.append(f"{name}, {name}t = by.times_two(n0, n0t, {self.constant(scale)})")
        return [name, f"{name}t"]

    def pair(self, call: str) -> list[str]:
        """A name for the pair that a call returns."""
        i = next(self._fresh)
        self.lines.append(f"a{i}, a{i}t = {call}")
        return [f"a{i}", f"a{i}t"]

    def plus(self, a: list[str], b: list[str]) -> list[str]:
        """The sum of two pairs."""
        return self.pair(f"by.plus_two({', '.join([*a, *b])})")

    def entry(self, name: str, numerator: list[str], den: list[str]) -> None:
        """Assign an entry."""
        self.lines.append(f"{name} = by.over({', '.join([*numerator, *den])})")


def coefficient_lines(rule: OneRule, end: int, instants: int) -> list[str]:
    """Lines that assign the entries of D, B, O, P; columns of B and P beyond the rule's loads, up to instants, are 0.

    end: number of the load at t_n + h, from which the acceleration there follows.
    """
    to = _Lines(rule, [c for S, scale in rule.loads for c in (*S, scale)])
    for (name, i), row in zip((("D", 0), ("D", 1), ("O", 0)), to.free(rule), strict=True):
        for j in range(2):
            to.entry(entry_name(name, i, j), row[2 * j : 2 * j + 2], ["n0", "n0t"])
    for k, (S, scale) in enumerate(rule.loads):
        den = to.den(f"m{k}", scale)
        u, v, a = to.loaded(S)
        a = to.plus(a, den) if k == end else a
        for (name, i), numerator in zip(_COLUMN, (u, v, a), strict=True):
            to.entry(entry_name(name, i, k), numerator, den)
    beyond = [entry_name(name, i, k) for k in range(len(rule.loads), instants) for name, i in _COLUMN]
    return [*to.lines, *(f"{name} = 0.0" for name in beyond)]


_COLUMN = (("B", 0), ("B", 1), ("P", 0))


def increment_lines(rule: OneRule) -> list[str]:
    """Lines that assign the entries of A - I in u, h*v, h^2*a, with an acceleration of any size at the start.

    The first load is what that acceleration has more than the equation of motion at t_n gives: a - w0*u - w1*v.
    """
    S, scale = rule.loads[0]
    to = _Lines(rule, (*S, scale))
    den = to.den("m0", scale)
    for i, (row, load) in enumerate(zip(to.free(rule), to.loaded(S), strict=True)):
        for j in range(2):
            own = ", ".join([*row[2 * j : 2 * j + 2], to.constant(scale), *load])
            difference = to.pair(f"by.difference({own}, {to.square[j]})")
            to.entry(entry_name("D_", i, j), difference, den)
        to.entry(entry_name("D_", i, 2), load, den)
    to.lines.append(f"{entry_name('D_', 2, 2)} -= 1.0")
    return to.lines
