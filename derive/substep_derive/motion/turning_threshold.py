"""Scheme -> the turn a step from which errors along a rigid bar grow, between two rational numbers, proved.

`turning` says to first order in tau how errors along a rigid bar grow. Where they begin to, tau and cos tau count at
once, so that no algebraic number is the answer. It is enclosed here by ball arithmetic (F. Johansson, Arb, IEEE
Transactions on Computers 66 (2017) 1281-1292), in which every number is an interval that holds the exact one.

In the plane z = x + iy a step has the matrices of one coordinate, with lambda e^(i tau) for z and lambda e^(-i tau) for
its conjugate; the bar alone, at the instants of the forces, couples both: displacements along it vanish, and forces
across it are tau^2 times the displacements. Eigenvalues are the zeros in lambda of the determinant p(lambda, tau) of
these equations, which for one force a step, with 1 + Omega^2 n(lambda)/d(lambda) = 0 on an oscillator, is

    p = (n+ d- + n- d+)/2 + tau^2 n+ n-,    n+- = n(lambda e^(+-i tau)),  d+- = d(lambda e^(+-i tau)).

It is a polynomial in lambda and entire in tau, so that its values at roots of unity in both give all coefficients up to
tau^127, but for an error that Cauchy's estimate bounds. How many zeros lie in a region follows from how often p turns
around 0 along the border; the border is covered by discs in each of which, for all tau of an interval at once, p
differs from its value in the middle by less than that value.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib import import_module
from math import ceil, floor
from typing import Any

from sympy import Integer, Matrix, Rational

from ..algebra.algebraic import Field
from ..algebra.exact_number import exact_number
from ..algebra.field_matrices import FieldMatrix, field_matrix, identity
from ..declare.catalogue import find
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..oscillator.evaluation import Evaluation
from .turning import TurningStep, turning

FARTHEST = Rational(3, 4)  # rad a step, up to which the motion across the bar is told from errors along it
SLOW = 2  # eigenvalues of the motion across the bar, which are the nearest to 1
ROOTS, BEYOND = 128, 6  # values of tau with |tau| = 1 that p is taken at, and |tau| up to which it is bounded
WIDEST = Rational(1, 8)  # rad, of an interval of tau
POWERS = 5  # of the distance from an interval's middle that are kept; the others are added as one ball
HALVINGS = 24  # of an arc of a border
RADII = tuple(Rational(k, 16) for k in (4, 8, 2, 12, 3, 6, 10, 1, 5, 14))  # of circles about 1 that hold the two
BITS = 128  # of the middles of balls


@dataclass(frozen=True)
class TurningThreshold:
    """Proved: errors along a rigid bar fade at every turn tau a step of 0 < tau <= low, and one grows at tau = high.

    They fade if all eigenvalues but the two nearest to 1, those of the motion across the bar, have modulus below 1, and
    one grows if the modulus of one of these is above 1. high: None where no growth was found; `low` then is `FARTHEST`,
    or how far the two could be told from the others: beyond, distances from 1 become alike, or one of the two and one
    of the others become a pair of complex ones.
    """

    scheme: Scheme
    low: Rational
    high: Rational | None

    @property
    def text(self) -> str:
        """The verdict in words."""
        low, high = self.decimals
        if high is not None:
            return f"proved: none grows up to tau = {low}, one does at {high}"
        if self.low == FARTHEST:
            return f"proved: none grows up to tau = {self.low}"
        return (
            f"proved: none grows up to tau = {low}; beyond, the two eigenvalues nearest to 1 are not told from others"
        )

    @property
    def decimals(self) -> tuple[float, float | None]:
        """Low and high to five decimals, rounded outwards."""
        low, high = (None if x is None else 10**5 * Fraction(x.p, x.q) for x in (self.low, self.high))
        return floor(low or 0) / 1e5, None if high is None else ceil(high) / 1e5


def turning_threshold(
    scheme: str | Scheme, within: int | str | Rational = "1/1000", **parameters: Any
) -> TurningThreshold:
    """The turn a step from which errors along a rigid bar grow, with proof, for a scheme of which they fade at first.

    within: the largest (high - low)/high, or of `low` where the proof ends. Parameters as for `turning`. Needs
    python-flint, the extra `proofs`.

    Raises DeclarationError, ValueError as `turning`; ValueError for an explicit scheme, and for one whose errors do not
    fade as tau -> 0, of which `turning` has the exact growth; ImportError without python-flint.

    >>> turning_threshold("hht_alpha", alpha="-1/10", within="1/100").text
    'proved: none grows up to tau = 0.19433, one does at 0.1963'
    """
    exact = turning(scheme, **parameters)
    name = exact.scheme.name
    if not exact.at_infinity:
        raise ValueError(f"{name}: expected a scheme that can hold a rigid bar, got an explicit one")
    if (most := exact.at_infinity[0][0]) >= 1:
        raise ValueError(
            f"{name}: expected errors along a rigid bar that fade as tau -> 0, got the factor {most.n(6)} a step; "
            "`turning` has what is exact of their growth"
        )
    share = exact_number(within)
    if not 0 < share < 1:
        raise ValueError(f"expected within between 0 and 1, the width of the bracket as a share, got {within}")
    with _flint().ctx.workprec(BITS):
        return _bracket(exact.scheme, Bar(Evaluation.at(ParameterSet.of(find(scheme), None, parameters))), share)


def _bracket(scheme: Scheme, bar: "Bar", share: Rational) -> TurningThreshold:
    low, width = Integer(0), WIDEST
    while low < FARTHEST and width > share * low / 64 and width > WIDEST / 2**20:
        width = min(width, FARTHEST - low)
        if bar.grow(low + width / 2, width / 2) == 0:
            low, width = low + width, min(2 * width, WIDEST)
            continue
        high = low / (1 - share)
        if width < high - low and bar.grow(high, Integer(0)):
            return TurningThreshold(scheme, low, high)
        width /= 2
    return TurningThreshold(scheme, low, None)


Rows = list[list[Any]]


class Bar:
    """p of a step on a rigid bar: for each power of lambda a polynomial in tau, which holds for |tau| <= 1."""

    def __init__(self, at: Evaluation) -> None:
        flint, field, step = _flint(), at.field, TurningStep.of(at.scheme)
        assert isinstance(field, Field)
        A, B, C, D = _of_forces(step, at, field)
        self.order = 2 * A.shape[0]

        def balls(m: FieldMatrix) -> list[list[Any]]:
            return [[ball(x) for x in row] for row in m.to_list()]

        def ball(number: Any) -> Any:
            near = field.near(number, 2**BITS)
            return flint.arb(near.numerator) / near.denominator * flint.arb(1, 2.0 ** (2 - BITS))

        matrices = [balls(m) for m in (A, B, C, D)]
        instants = [ball(at.number(t)) for t in step.instants[: D.shape[0]]]
        lams, taus = ([flint.acb(flint.arb(2 * k) / n).exp_pi_i() for k in range(n)] for n in (self.order + 1, ROOTS))
        values = [[_equations(*matrices, instants, x, tau).det() for x in lams] for tau in taus]
        by_lam = [flint.acb.dft(row) for row in values]
        error = flint.arb(0, 3) * _largest(*matrices, instants) / (flint.arb(BEYOND) ** ROOTS - 1)
        self.p = [
            flint.arb_poly([c.real / len(lams) / ROOTS + error for c in flint.acb.dft(column)])
            for column in zip(*by_lam, strict=True)
        ]

    def grow(self, middle: Rational, half: Rational) -> int | None:
        """How many eigenvalues besides the two nearest to 1 have modulus above 1, at all tau within half of the middle.

        None where it is not decided.
        """
        flint = _flint()
        center, reach = (flint.arb(x.p) / x.q for x in (middle, half))
        about = [list(c(flint.arb_poly([center, 1]))) for c in self.p]
        p = [flint.acb_poly([c[j] for c in about]) for j in range(POWERS)]
        p.append(flint.acb_poly([flint.arb_poly([0] * POWERS + c[POWERS:])(flint.arb(0, 1) * reach) for c in about]))
        sizes = [*(reach**j for j in range(POWERS)), flint.arb(1)]
        for radius in RADII:
            if _zeros(p, sizes, _around_one(radius)) == SLOW:
                inside = _zeros(p, sizes, _around_both(radius))
                return None if inside is None else self.order - inside
        return None


def _of_forces(step: TurningStep, at: Evaluation, field: Field) -> list[FieldMatrix]:
    """A, B, C, D of one coordinate: states afterwards A s + B f and displacements at the places of forces C s + D f."""
    new, forces = step.of_new

    def rows(matrix: Matrix) -> FieldMatrix:
        return field_matrix([[at.number(e) for e in matrix.row(i)] for i in range(matrix.rows)], field.domain)

    relations, places = rows(step.relations), rows(step.places)
    own, given = [*range(new)], [*range(new, relations.shape[1])]
    solved = relations.extract(own, own).inv() * -relations.extract(own, given)
    columns = solved.vstack(identity(len(given), field.domain))
    parts = [*range(forces, len(given))], [*range(forces)]
    after = columns.extract([*step.after], [*range(len(given))])
    return [m.extract([*range(m.shape[0])], part) for m in (after, places * columns) for part in parts]


def _equations(A: Rows, B: Rows, C: Rows, D: Rows, instants: list[Any], lam: Any, tau: Any) -> Any:
    """The equations of s, its conjugate, f and its conjugate: of the states, then along the bar, then across it."""
    flint = _flint()
    n, K = len(A), len(D)
    i = flint.acb(0, 1)
    found = []
    for side, turn in enumerate(((i * tau).exp(), (-i * tau).exp())):
        for k in range(n):
            states, forces = [0] * (2 * n), [0] * (2 * K)
            states[side * n : side * n + n] = [lam * turn * (j == k) - a for j, a in enumerate(A[k])]
            forces[side * K : side * K + K] = [-b for b in B[k]]
            found.append(states + forces)
    for across in (0, 1):
        for k in range(K):
            x, y = ((sign * i * instants[k] * tau).exp() for sign in (-1, 1))
            p, q = (x * tau**2, -y * tau**2) if across else (x, y)
            row = [e * c for part in (C[k], D[k]) for e in (p, q) for c in part]
            row[2 * n + k] -= across * x
            row[2 * n + K + k] += across * y
            found.append(row)
    return flint.acb_mat(found)


def _largest(A: Rows, B: Rows, C: Rows, D: Rows, instants: list[Any]) -> Any:
    """A bound of |p| where |lambda| = 1 and |tau| <= BEYOND: the product of the sums of the rows (Hadamard)."""
    arb, found = _flint().arb, _flint().arb(1)
    for a, b in zip(A, B, strict=True):
        found *= (arb(BEYOND).exp() + sum(abs(x) for x in (*a, *b))) ** 2
    for c, d, instant in zip(C, D, instants, strict=True):
        turn, total = 2 * (abs(instant) * BEYOND).exp(), sum(abs(x) for x in (*c, *d))
        found *= turn**2 * total * (BEYOND**2 * total + 1)
    return found


Arc = tuple[Any, Any, Any, Any]  # centre and radius of a circle, angles of both ends in rad


def _around_one(radius: Rational) -> list[Arc]:
    """The upper half of the circle about 1."""
    arb = _flint().arb
    return [(1, arb(radius.p) / radius.q, arb(0), arb.pi())]


def _around_both(radius: Rational) -> list[Arc]:
    """The upper half of the border of what that circle and the unit circle hold together."""
    arb = _flint().arb
    r = arb(radius.p) / radius.q
    meet = 2 * (r / 2).asin()
    return [(1, r, arb(0), (arb.pi() + meet) / 2), (0, arb(1), meet, arb.pi())]


def _zeros(p: Sequence[Any], sizes: Sequence[Any], border: list[Arc]) -> int | None:
    """How many zeros p has inside, at every tau of the interval; None if it might have one on the border.

    Coefficients are real, so that the upper half of a border, from the real axis to the real axis, is enough.
    """
    turn = _flint().arb(0)
    for arc in border:
        for part in _turns(p, sizes, arc, HALVINGS):
            if part is None:
                return None
            turn += part
    count = (turn / _flint().arb.pi()).unique_fmpz()
    return None if count is None else int(count)


def _turns(p: Sequence[Any], sizes: Sequence[Any], arc: Arc, halvings: int) -> Iterator[Any]:
    """By which angles p turns around 0 along parts of an arc, each in a disc without zeros; None for lack of one."""
    flint = _flint()
    center, radius, start, end = arc
    middle, reach = (start + end) / 2, radius * (end - start) / 2
    at = [center + radius * flint.acb(0, angle).exp() for angle in (start, middle, end)]
    value, *rest = (
        abs(c) * size * reach**j
        for polynomial, size in zip(p, sizes, strict=True)
        for j, c in enumerate(polynomial(flint.acb_poly([at[1], 1])))
    )
    if value > sum(rest):
        yield (p[0](at[2]) / p[0](at[0])).arg()
    elif halvings:
        yield from _turns(p, sizes, (center, radius, start, middle), halvings - 1)
        yield from _turns(p, sizes, (center, radius, middle, end), halvings - 1)
    else:
        yield None


def _flint() -> Any:
    try:
        return import_module("flint")
    except ImportError as error:
        raise ImportError(
            "expected python-flint, whose ball arithmetic proves thresholds, and it is not installed: "
            "pip install 'substep[proofs]'"
        ) from error
