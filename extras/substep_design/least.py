"""Which stability function of order n has the least error: among some, or among all for every rho_inf in [0, 1]."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, pairwise

from substep_derive.algebra.algebraic import Algebraic
from substep_derive.declare.symbols import gamma, rho_inf
from sympy import Expr, Integer, Poly, Rational, Symbol, cancel, quo, resultant

from .answer import Budget
from .candidate import Candidate, numerator_of, shown
from .stability_function import StabilityFunction, approximate, coefficient, numbers_with, stable_intervals

OTHER = Symbol("gamma_2")  # gamma on the second of two pieces


def ordered(kept: Iterable[Candidate], criterion: str) -> tuple[Candidate, ...]:
    """The candidates by the size of what is to be least: at gamma, or at rho_inf = 0 and, where equal there, at 1."""

    def size(one: Candidate) -> tuple[Expr, ...]:
        e, (first, last) = one.function.least(criterion), one.ends
        pairs = ((last, Integer(0)), (first, Integer(1)))
        return tuple(round(abs(e.subs({gamma: approximate(x), rho_inf: radius})), 30) for x, radius in pairs)

    return tuple(sorted(kept, key=size))


@dataclass(frozen=True)
class Piece:
    """gamma from low to high, None for oo, of A-stable functions with R(oo) of one sign and without a turn.

    equation: of gamma and rho_inf.
    """

    low: Algebraic
    high: Algebraic | None
    equation: Expr

    def holds(self, number: Algebraic) -> bool:
        """Whether a number gamma lies inside."""
        return between(number, self.low, self.high)

    @property
    def text(self) -> str:
        """The interval in words."""
        return f"gamma from {shown(self.low)} to {'oo' if self.high is None else shown(self.high)}"


@dataclass(frozen=True)
class Least:
    """The piece of the least error for rho_inf from low to high, which are roots of polynomials in rho_inf."""

    low: str
    high: str
    piece: Piece


def between(x: Algebraic, low: Algebraic, high: Algebraic | None) -> bool:
    """Whether x lies inside the interval; None is oo."""
    return approximate(low) < approximate(x) and (high is None or approximate(x) < approximate(high))


def fixed_numerator(n: int, order: int, last: Sequence[Expr] = ()) -> StabilityFunction:
    """The function whose coefficients are those of e^z (1 - gamma z)^n, but for the last ones."""
    first = [coefficient(k, n) for k in range(n + 1 - len(last))]
    return StabilityFunction((*first, *last), order)


def least_for_every_radius(n: int, criterion: str, budget: Budget) -> tuple[Least, ...]:
    """Of all A-stable functions of order n with |R(oo)| = rho_inf the ones of least error, for rho_inf from 0 to 1.

    Raises OutOfTimeError. The order of two errors changes only where |c(gamma_1)| = |c(gamma_2)| at one rho_inf on two
    pieces, and pieces begin and end at the |R(oo)| of their ends: elimination of gamma leaves polynomials in rho_inf,
    and one rational number settles each cell between their roots.
    """
    function = fixed_numerator(n, n)
    pieces, error = list(_pieces(function)), function.least(criterion)
    cuts: list[Algebraic] = []
    for one in pieces:
        for end in (one.low, one.high):
            if end is not None:
                budget.begin_step(f"rho_inf at gamma = {shown(end)}")
                cuts += _radii(resultant(one.equation, end.polynomial.as_expr(gamma), gamma))
    second = error.subs(gamma, OTHER)
    alike = (quo(error - second, gamma - OTHER, gamma), error + second)
    for one, other in combinations_with_replacement(dict.fromkeys(piece.equation for piece in pieces), 2):
        budget.begin_step("rho_inf at which two errors are of one size")
        curve = other.subs(gamma, OTHER)
        if one == other:  # two roots gamma of one equation
            curve = quo(one - curve, gamma - OTHER, gamma)
        cuts += [x for same in alike for x in _radii(resultant(resultant(same, curve, OTHER), one, gamma))]
    marks = {approximate(x): shown(x, rho_inf) for x in sorted(cuts, key=approximate)}
    found: list[Least] = []
    for (a, low), (b, high) in pairwise([(Integer(0), "0"), *marks.items(), (Integer(1), "1")]):
        middle = Rational(a + b) / 2
        sizes = [
            (abs(error.subs(gamma, approximate(x))), k)
            for k, piece in enumerate(pieces)
            for x in numbers_with(piece.equation.subs(rho_inf, middle))
            if piece.holds(x)
        ]
        if not sizes:
            continue
        best = pieces[min(sizes)[1]]
        if found and found[-1].piece is best and found[-1].high == low:
            found[-1] = Least(found[-1].low, high, best)
        else:
            found.append(Least(low, high, best))
    return tuple(found)


def _radii(polynomial: Expr) -> list[Algebraic]:
    """The roots rho_inf inside ]0, 1[ of a polynomial."""
    p = Poly(polynomial, rho_inf)
    if p.is_zero:
        raise ArithmeticError("two errors are of one size at every rho_inf, so that none is the least")
    return numbers_with(p.as_expr().subs(rho_inf, gamma), high=1) if p.degree() else []


def _pieces(function: StabilityFunction) -> Iterable[Piece]:
    at_infinity = function.at_infinity
    edges = [at_infinity, cancel(at_infinity.diff(gamma)), at_infinity - 1, at_infinity + 1]
    marks = [x for e in edges for x in numbers_with(numerator_of(e))]
    for low, high in stable_intervals(function.excess):
        inside = {approximate(x): x for x in marks if between(x, low, high)}
        for left, right in pairwise([low, *(inside[x] for x in sorted(inside)), high]):
            assert left is not None
            middle = approximate(left) + 1 if right is None else (approximate(left) + approximate(right)) / 2
            sign = 1 if at_infinity.subs(gamma, middle) > 0 else -1
            yield Piece(left, right, numerator_of(at_infinity - sign * rho_inf))
