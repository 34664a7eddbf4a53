"""Steps of two balances -> a proof for every structure by a multiplier with a memory of some steps.

A motion x_(n+1) = lambda x_n makes every symbol of the step a combination of two vectors X, and the balances become
(A(lambda) x M + B(lambda) x C + D(lambda) x K) X = 0, with 2 x 2 matrices and x Kronecker's product; B X are the
velocities at which the damping forces are taken. Let S(lambda) be such that, on the unit circle, the Hermitian parts of
S A, S B and S D are not negative and that of S A is positive but for lambda = 1. Then Re X* (S x I)(...) X = 0 is a sum
of three terms that are not negative, so that X = 0: no structure has an eigenvalue on the circle but 1, and 1 not if
K > 0. Structures with K > 0 are connected and one of them has all eigenvalues inside, so that all have; where K is
singular none is outside, as a limit.

Conversely, by duality, where there is no S there are Hermitian P, Q, R, none negative, with A P + B Q + D R = 0, or
limits of such: with P > 0 their conjugates as M, h C, h^2 K are two complex, that is four real degrees of freedom with
the eigenvalue lambda. So larger structures show nothing that four degrees of freedom do not.

Taken is S = B* H with H = [[1, w], [w*, 1]] + sum over j of k^j [[a_j, c_j], [c_j, b_j]], w = -(1 - tau) - tau/lambda +
d k (lambda - 1/lambda)/2, k = 1 - (lambda + 1/lambda)/2, and tau the time between the balances over h: these are
multiplied by combinations of their own velocities and of those some steps before and after, which all but vanish on a
slow motion. At small angles the determinant of the Hermitian part of S D begins with minus the square of a linear form
in a_1, b_1, c_1, which gives c_1. Floating point proposes the other constants, first a_1 and b_1 alone; what is claimed
is decided by exact algebra.
"""

from cmath import exp
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import pi, sqrt
from random import Random
from typing import Any

from sympy import QQ, Integer, Poly

from ..algebra import rational
from ..algebra.points import RationalPoint, positive_roots, ring_over
from ..declare.symbols import Omega, knot, lam
from ..step.times import passed
from .hurwitz import Verdict, bilinear, verdict
from .structure_form import Rows, cleared
from .structure_growth import step_matrix

Laurent = dict[int, Fraction]  # power of lambda -> coefficient
Square = list[list[Laurent]]
ANGLES = [0.03, 0.06, *(pi * k / 24 for k in range(1, 25))]
TRIES, DENOMINATOR = 1500, 1024
FREE = (2, 3, 6)  # constants that are tried to be other than 0


@dataclass(frozen=True)
class Multiplier:
    """H (2, 2) in powers of lambda, with which the three Hermitian parts are proved to be positive."""

    H: Square

    @classmethod
    def of(cls, rows: Rows) -> "Multiplier | None":
        """One that is proved, for rational parameters and two balances; None if none was found."""
        if len(rows.balances) != 2 or rows.field.domain != QQ or rows.D is not None:
            return None
        parts, tau = pencil(rows), _between(rows)
        shapes = None if parts is None or not 0 < tau < 1 else _shapes(parts, tau)
        if parts is None or shapes is None:
            return None
        for proposed in _proposed(parts, shapes):
            found = shapes[0]
            for x, shape in zip(proposed, shapes[1:], strict=False):
                found = _sum(found, shape, Fraction(x).limit_denominator(DENOMINATOR))
            if all(_positive(rows, part, strict=k == 0) for k, part in enumerate(_weighted(parts, found))):
                return cls(found)
        return None

    @property
    def text(self) -> str:
        """H in one line."""
        entries = [
            [" + ".join(f"({x}) lambda^{k}" if k else str(x) for k, x in sorted(e.items())) for e in row]
            for row in self.H
        ]
        return "[" + ", ".join(f"[{', '.join(row)}]" for row in entries) + "]"


def _weighted(parts: Sequence[Square], H: Square) -> list[Square]:
    """S A, S B and S D."""
    S = _times(_adjoint(parts[1]), H)
    return [_times(S, part) for part in parts]


def _shapes(parts: Sequence[Square], tau: Fraction) -> list[Square] | None:
    """H at 0 and what multiplies a_1, b_1, d, a_2, b_2, c_2, c_1 being what takes away the term in the angle^4."""
    one, k, odd = (
        {0: Fraction(1)},
        {-1: Fraction(-1, 2), 0: Fraction(1), 1: Fraction(-1, 2)},
        {-1: Fraction(-1, 2), 1: Fraction(1, 2)},
    )
    square = _product(k, k)
    base = _hermitian(one, one, {-1: -tau, 0: tau - 1})
    of_a, of_b, of_c = _hermitian(k, {}, {}), _hermitian({}, k, {}), _hermitian({}, {}, k)

    def slope(H: Square) -> Fraction:
        """Of that term with respect to c_1, which is linear."""
        at = []
        for step in (1, -1):
            part = _weighted(parts, _sum(H, of_c, Fraction(step)))[2]
            at.append(sum((e * n**4 for n, e in _det(_sum(part, _adjoint(part), Fraction(1))).items()), Fraction(0)))
        return at[0] - at[1]

    origin = slope(base)
    by_a, by_b, by_c = (slope(_sum(base, shape, Fraction(1))) - origin for shape in (of_a, of_b, of_c))
    if not by_c:
        return None
    tied = [_sum(shape, of_c, -by / by_c) for shape, by in ((base, origin), (of_a, by_a), (of_b, by_b))]
    return [
        *tied,
        _hermitian({}, {}, _product(k, odd)),
        _hermitian(square, {}, {}),
        _hermitian({}, square, {}),
        _hermitian({}, {}, square),
    ]


def _hermitian(x: Laurent, y: Laurent, w: Laurent) -> Square:
    return [[x, w], [{-k: c for k, c in w.items()}, y]]


def _between(rows: Rows) -> Fraction:
    """The time from the first balance to the second, in steps: that of the displacements they take the force at."""
    first, last = (
        sum((rows.field.expression(c) * passed(rows.step)[s] for s, c in balance[2].items()), Integer(0)).subs(
            rows.values
        )
        for balance in rows.balances
    )
    return Fraction(str(last - first))


def pencil(rows: Rows) -> tuple[Square, Square, Square] | None:
    """A, B, D in terms of u_0 and h v_0; None if these do not determine the step on the whole circle.

    Neither may a balance be unsolvable for some structure, nor the oscillator with m = h c = h^2 k = 1 not be stable.
    """
    over = QQ.frac_field(lam)
    shift, last = over.gens[0], (knot(0).u, knot(0).v)
    symbols = [*(s for s in rows.symbols if s not in last), *last]
    equations = [{s: over.field.ground_new(c) for s, c in row.items()} for row in rows.relations]
    equations += [{s: shift, after: -over.one} for s, after in zip(rows.step.state, rows.step.after, strict=True)]
    matrix = [[row.get(s, over.zero) for s in symbols] for row in equations]
    _, kernel = rational.affine_solutions(matrix, [over.zero] * len(matrix), len(symbols), over) or (None, [])
    if len(kernel) != 2:
        return None
    columns = [dict(zip(symbols, map(_laurent, cleared(over, vector)), strict=True)) for vector in kernel]
    parts = [
        [[_combined((c, column[s]) for s, c in balance[k].items()) for column in columns] for balance in rows.balances]
        for k in range(3)
    ]
    A, B, D = parts
    one = ((Fraction(1),),)
    scalar = [*reversed(step_matrix(rows, (one, one, one)).charpoly())]  # of one oscillator with m = h c = h^2 k = 1
    top = Poly.from_dict({(k,): c for k, c in enumerate(scalar) if c}, lam, domain=QQ)
    det = _det(_sum(_sum(A, B, Fraction(1)), D, Fraction(1)))
    bottom = Poly.from_dict({(k - min(det),): QQ(c.numerator, c.denominator) for k, c in det.items()}, lam, domain=QQ)
    shared = top.gcd(bottom)
    known = all(_inside(rows, part) for part in (top, top.exquo(shared), bottom.exquo(shared)))
    return (A, B, D) if known and _one_is_free(A, B, D) and _solvable(rows) else None


def _solvable(rows: Rows) -> bool:
    """Whether the matrix of each balance, c_a M + c_v C + c_u K, is positive whatever M > 0, C >= 0, K >= 0 are."""
    if not all(stage.alone for stage in rows.step.stages):
        return False
    signs = [
        [rows.field.sign(rows.field.number(c.subs(rows.values))) for c in (stage.c_a(), stage.c_v(), stage.c_u())]
        for stage in rows.step.stages
    ]
    return all(a > 0 and v >= 0 and u >= 0 for a, v, u in signs)


def _inside(rows: Rows, polynomial: Poly) -> bool:
    """Whether all roots are inside the unit circle."""
    ring = ring_over(rows.field, Omega)
    p = [ring.ground_new(c) for c in reversed(polynomial.terms_gcd()[1].rep.to_list())]
    return len(p) == 1 or verdict(bilinear(p), RationalPoint(rows.field, QQ(0))) is Verdict.INSIDE


def _one_is_free(A: Square, B: Square, D: Square) -> bool:
    """Whether for K > 0 no motion has lambda = 1, the first vector being a rigid displacement.

    That is in K's column alone, as d_1; what is orthogonal to d_1 of the equations is (a M + b C + d K) y = 0 for the
    second vector y, which vanishes if a is positive and b, d are not negative.
    """
    at = [[[sum(e.values(), Fraction(0)) for e in row] for row in part] for part in (A, B, D)]
    (a, b, d) = at
    first = d[0][0], d[1][0]
    if any(part[k][0] for part in (a, b) for k in (0, 1)) or first == (0, 0):
        return False
    shares = [part[0][1] * first[1] - part[1][1] * first[0] for part in at]
    return bool(shares[0]) and all(share * shares[0] >= 0 for share in shares)


# --- Laurent polynomials --------------------------------------------------------------------------------


def _laurent(polynomial: Any) -> Laurent:
    return {m[0]: Fraction(int(c.numerator), int(c.denominator)) for m, c in polynomial.terms() if c}


def _combined(terms: Iterable[tuple[Any, Laurent]]) -> Laurent:
    found: Laurent = {}
    for c, e in terms:
        for k, x in e.items():
            found[k] = found.get(k, Fraction(0)) + Fraction(int(c.numerator), int(c.denominator)) * x
    return {k: x for k, x in found.items() if x}


def _product(a: Laurent, b: Laurent) -> Laurent:
    found: Laurent = {}
    for i, x in a.items():
        for j, y in b.items():
            found[i + j] = found.get(i + j, Fraction(0)) + x * y
    return {k: x for k, x in found.items() if x}


def _sum(one: Square, other: Square, factor: Fraction) -> Square:
    return [
        [_combined(((Fraction(1), x), (factor, y))) for x, y in zip(*rows, strict=True)]
        for rows in zip(one, other, strict=True)
    ]


def _times(one: Square, other: Square) -> Square:
    return [
        [_combined((Fraction(1), _product(one[i][k], other[k][j])) for k in (0, 1)) for j in (0, 1)] for i in (0, 1)
    ]


def _adjoint(matrix: Square) -> Square:
    """The adjoint on the unit circle, where the conjugate of lambda is 1/lambda."""
    return [[{-k: x for k, x in matrix[j][i].items()} for j in (0, 1)] for i in (0, 1)]


def _det(matrix: Square) -> Laurent:
    (a, b), (c, d) = matrix
    return _combined(((Fraction(1), _product(a, d)), (Fraction(-1), _product(b, c))))


def _positive(rows: Rows, matrix: Square, *, strict: bool) -> bool:
    """Whether the Hermitian part is positive on the circle but for lambda = 1, and for -1 unless strict."""
    hermitian = _sum(matrix, _adjoint(matrix), Fraction(1))
    return all(_in_cosine(rows, e, strict) for e in (hermitian[0][0], _det(hermitian)))


def _in_cosine(rows: Rows, real: Laurent, strict: bool) -> bool:
    """Whether a Laurent polynomial with the same coefficients of lambda^k and lambda^-k is positive there.

    With cos = (1 - x)/(1 + x) it is a polynomial in x > 0 over a power of 1 + x.
    """
    ring = ring_over(rows.field, Omega)
    x = ring.gens[0]
    degree = max(real, default=0)
    if not real:
        return False
    below, now = ring.one, 1 - x  # (1 + x)^k times Chebyshev's T_k
    total = ring.zero
    for k in range(degree + 1):
        c = real.get(k, Fraction(0)) * (2 if k else 1)
        total += (below * (1 + x) ** (degree - k)).mul_ground(QQ(c.numerator, c.denominator))
        below, now = now, 2 * (1 - x) * now - (1 + x) ** 2 * below
    if strict and total.degree() < degree:
        return False
    return not positive_roots(rows.field, [total], ring) and total.evaluate(x, QQ(1)) > 0


# --- proposals ------------------------------------------------------------------------------------------


def _proposed(parts: Sequence[Square], shapes: Sequence[Square]) -> Iterator[list[float]]:
    """Constants for which all three Hermitian parts are positive at some angles, by a search at random."""
    at = []
    for angle in ANGLES:
        value = exp(1j * angle)
        H = [_at(shape, value) for shape in shapes]
        A, b, D = (_at(part, value) for part in parts)
        det = b[0][0] * b[1][1] - b[0][1] * b[1][0]
        inverse = [[b[1][1] / det, -b[0][1] / det], [-b[1][0] / det, b[0][0] / det]]
        for m in (A, b, D):
            by_velocity = [[sum(m[i][k] * inverse[k][j] for k in (0, 1)) for j in (0, 1)] for i in (0, 1)]
            at.append(((1 - value.real) ** 2, [_part(h, by_velocity) for h in H]))

    def margin(constants: Sequence[float]) -> float:
        least = 1.0
        weights = (1.0, *constants)
        for scale, parts_at in at:
            x, y, z = (sum(w * part[k] for w, part in zip(weights, parts_at, strict=True)) for k in (0, 1, 2))
            if x + y <= 0:
                return -1e9 + x + y
            least = min(least, (1 - sqrt((x - y) ** 2 + abs(z) ** 2) / (x + y)) / scale)
        return least

    random, best = Random(0), [0.0] * FREE[-1]
    for free in FREE:
        reach, value = 0.5, margin(best)
        for _ in range(TRIES):
            other = [x + reach * random.gauss(0, 1) * (k < free) for k, x in enumerate(best)]
            if (found := margin(other)) > value:
                best, value, reach = other, found, min(2.0, 2 * reach)
            else:
                reach = max(1e-3, 0.95 * reach)
        if value > 0:
            yield best


def _at(matrix: Square, value: complex) -> list[list[complex]]:
    return [[sum((float(c) * value**k for k, c in e.items()), 0j) for e in row] for row in matrix]


def _part(h: list[list[complex]], m: list[list[complex]]) -> tuple[float, float, complex]:
    """The Hermitian part of h m: both diagonal entries, and twice the upper one."""
    (a, b), (c, d) = ([sum((h[i][k] * m[k][j] for k in (0, 1)), 0j) for j in (0, 1)] for i in (0, 1))
    return a.real, d.real, b + c.conjugate()
