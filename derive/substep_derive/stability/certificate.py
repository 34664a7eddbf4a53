"""Spectral stability of a scheme for every Omega > 0, decided by exact algebra, with the proof as text.

Stable at Omega means: every eigenvalue in the closed unit disk, and those on the circle simple. What decides
it are polynomials in Omega (see `hurwitz`): nothing changes between their real roots, so that one rational
sample settles each cell, and each root is settled by itself in the field it generates.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from typing import Any

from sympy import QQ, Expr, Integer, Rational, factor, oo

from ..algebra.algebraic import Algebraic, RealRoot, closed_form
from ..algebra.points import Point, RationalPoint, point, positive_roots, simplest_between
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import Omega
from .hurwitz import Parts, Spectrum, Verdict, verdict

OmegaInterval = tuple[Expr, Expr, bool, bool]
STABLE = tuple(v for v in Verdict if v.stable)


@dataclass(frozen=True)
class Piece:
    """A critical point (low is high) or an open cell of the Omega axis; low None is 0, high None is oo."""

    low: RealRoot | None
    high: RealRoot | None
    at: Point
    verdict: Verdict

    @property
    def is_point(self) -> bool:
        """Whether it is a single Omega."""
        return self.low is not None and self.low is self.high


@dataclass(frozen=True)
class Proof:
    """The polynomials and the verdict on each piece of the Omega axis, in ascending order."""

    spectrum: Spectrum
    parts: Parts
    pieces: tuple[Piece, ...]

    @classmethod
    def of(cls, parameter_set: ParameterSet, *, in_square: bool = True) -> "Proof":
        """The proof. Raises DeclarationError where the equations of the step are dependent for every Omega."""
        return cls.of_spectrum(Spectrum.of(parameter_set, in_square=in_square))

    @classmethod
    def of_spectrum(cls, spectrum: Spectrum) -> "Proof":
        """The proof for a characteristic polynomial in one variable, which need not be Omega."""
        parts = Parts.of(spectrum)
        boundaries = [b for test in parts.tests for b in test.boundaries]
        field, ring = spectrum.parameter_set.field, spectrum.ring
        roots = positive_roots(field, [b for b in [*boundaries, spectrum.common] if b], ring)
        pieces = []
        for low, high in zip([None, *roots], [*roots, None], strict=True):
            start = QQ(0) if low is None else low.high
            sample = simplest_between(start, start + 2 if high is None else high.low)
            at: Point = RationalPoint(field, sample)
            pieces.append(Piece(low, high, at, verdict(spectrum.h, at)))
            if high is not None:
                at = point(field, high, ring)
                undefined = at.sign(at.value(spectrum.common)) == 0
                pieces.append(Piece(high, high, at, Verdict.UNDEFINED if undefined else verdict(spectrum.h, at)))
        return cls(spectrum, parts, tuple(pieces))

    def runs(self, verdicts: Sequence[Verdict] = STABLE) -> list[list[Piece]]:
        """Maximal runs of consecutive pieces whose verdict is one of these."""
        groups = groupby(self.pieces, key=lambda piece: piece.verdict in verdicts)
        return [list(pieces) for wanted, pieces in groups if wanted]

    def intervals(self, verdicts: Sequence[Verdict] = STABLE) -> tuple[OmegaInterval, ...]:
        """The runs as (low, high, low_closed, high_closed)."""

        def number(end: RealRoot | None, otherwise: Expr) -> Expr:
            return otherwise if end is None else closed_form(end, Omega, in_square=self.spectrum.in_square)

        return tuple(
            (number(run[0].low, Integer(0)), number(run[-1].high, oo), run[0].is_point, run[-1].is_point)
            for run in self.runs(verdicts)
        )


@dataclass(frozen=True)
class Certificate:
    """For which Omega > 0 a scheme is spectrally stable.

    stable: for all of them. intervals: all maximal ones as (low, high, low_closed, high_closed), exact;
    high is oo for one without end, and low = high for a single stable Omega. critical_Omega: where the
    interval that starts at 0 ends, None if it does not, 0 if there is none. text: the proof, to be checked
    by hand.
    """

    scheme: str
    parameters: dict[str, Rational | Algebraic]
    xi: Rational | Algebraic
    stable: bool
    intervals: tuple[OmegaInterval, ...]
    critical_Omega: Expr | None
    proof: Proof = field(repr=False, compare=False)

    @property
    def multiple(self) -> tuple[OmegaInterval, ...]:
        """The intervals unstable only because an eigenvalue on the circle is multiple: none lies outside it."""
        return self.proof.intervals((Verdict.MULTIPLE,))

    @cached_property
    def text(self) -> str:
        """The proof: polynomials, conditions, and a table of their signs with the verdicts."""
        return "\n".join(_lines(self))


def certify(scheme: str | Scheme, xi: Any = 0, **parameters: Any) -> Certificate:
    """Decide for which Omega > 0 a scheme is spectrally stable at given parameters and damping ratio.

    Values are int, Fraction, Rational, text such as '1/5', or Algebraic; defaults are taken for parameters
    that are not given. All algebraic values must be functions of a single r.

    Raises TypeError for a float, DeclarationError for an unknown scheme or parameter or a value outside its
    interval, ValueError for two different algebraic numbers or a negative xi.

    >>> certify("newmark_bdf2", gamma_t="2/5").stable  # for every Omega, proved
    True
    >>> certify("fox_goodwin").critical_Omega
    sqrt(6)
    """
    return certificate(ParameterSet.of(scheme, xi, parameters))


def certificate(parameter_set: ParameterSet, *, in_square: bool = True) -> Certificate:
    """As `certify`, for values already checked; in_square=False: in Omega even where Omega^2 would do."""
    proof = Proof.of(parameter_set, in_square=in_square)
    runs, intervals = proof.runs(), proof.intervals()
    from_zero = bool(runs) and runs[0][0] is proof.pieces[0]
    critical = intervals[0][1] if from_zero else Integer(0)
    assert parameter_set.damping is not None
    return Certificate(
        scheme=parameter_set.scheme.name,
        parameters=parameter_set.parameters,
        xi=parameter_set.public(parameter_set.damping),
        stable=from_zero and len(runs[0]) == len(proof.pieces),
        intervals=intervals,
        critical_Omega=None if critical is oo else critical,
        proof=proof,
    )


# --- the proof in words ------------------------------------------------------------------------------


def _lines(certificate: Certificate) -> Iterator[str]:
    proof = certificate.proof
    spectrum, parts = proof.spectrum, proof.parts
    n = len(spectrum.p) - 1

    def show(polynomial: Any) -> str:
        return _caret(_expression(polynomial, spectrum))

    yield _caret(spectrum.parameter_set.title)
    yield f"Result: {summary(certificate)}"
    yield f"\n1. Characteristic polynomial without its roots 0: p = {_sum('p', 'lambda', n)}"
    yield from (f"   p_{j} = {show(spectrum.p[j])}" for j in range(n, -1, -1))
    if not spectrum.common.is_ground:
        yield f"   taken out of every coefficient: {show(spectrum.common)}; at its roots the step is not defined"
    yield f"\n2. lambda = (1 + s)/(1 - s) takes the unit disk to Re s < 0 and (1 - s)^{n} p to"
    yield f"   h = {_sum('h', 's', n)}, up to a constant factor"
    yield from (f"   h_{j} = {show(spectrum.h[j])}" for j in range(n, -1, -1))
    if parts.at_one:
        yield f"   lambda = 1 is an eigenvalue for every Omega, {parts.at_one}-fold: h_0 = 0"
    if parts.at_minus_one:
        yield f"   lambda = -1 is an eigenvalue for every Omega, {parts.at_minus_one}-fold: h_{n} = 0"
    if len(parts.circle) > 1:
        terms = [f"({show(c)})" + (f" s^{2 * j}" if j else "") for j, c in enumerate(parts.circle) if c]
        yield "\n3. The even and the odd terms of h share, for every Omega, the pairs +s, -s of roots of"
        yield f"   A = {' + '.join(reversed(terms))}"
        yield "   These are on the axis (eigenvalues on the circle) and simple exactly if A + dA/ds is Hurwitz;"
        yield "   the other eigenvalues are inside exactly if B = h/A (without factors s) is."
    else:
        yield "\n3. The even and the odd terms of h share no factor: B = h (without factors s) has to be Hurwitz."
    conditions = {name: c for test in parts.tests for name, c in test.conditions.items()}
    if conditions:
        yield "   That is (Lienard, Chipart) for a positive first coefficient; else reverse coefficients and odd D:"
        yield from (f"   {name} = {show(c)} > 0" for name, c in conditions.items())
        yield "   Roots s reach the axis only where the first or last coefficient or D_(degree - 1) vanishes (Orlando)."
    yield "\n4. Positive roots of these, and the signs:"
    names = {id(p.low): f"Omega_{k}" for k, p in enumerate((p for p in proof.pieces if p.is_point), 1)}
    yield from (f"   {line}" for line in _root_lines(proof, names))
    yield from (f"   {line}" for line in _table(proof, conditions, names))


def summary(certificate: Certificate) -> str:
    """The result in a line."""
    if certificate.stable:
        return "stable for every Omega > 0"
    found = certificate.intervals
    result = f"stable exactly for Omega in {_spans(found)}" if found else "stable for no Omega > 0"
    return f"{result}; but for a multiple eigenvalue also in {_spans(m)}" if (m := certificate.multiple) else result


def _spans(intervals: Sequence[OmegaInterval]) -> str:
    spans = []
    for low, high, low_closed, high_closed in intervals:
        spans.append(f"{{{low}}}" if low == high else f"{'(['[low_closed]}{low}, {high}{')]'[high_closed]}")
    return _caret(" and ".join(spans))


def _caret(text: Any) -> str:
    return str(text).replace("**", "^")


def _expression(polynomial: Any, spectrum: Spectrum) -> Expr:
    """A polynomial as an expression in Omega, factored if K = Q."""
    number, power = spectrum.parameter_set.field.expression, 2 if spectrum.in_square else 1
    expression = sum((number(c) * Omega ** (power * m[0]) for m, c in polynomial.terms()), Integer(0))
    return expression if spectrum.parameter_set.field.algebraic else factor(expression)


def _sum(name: str, variable: str, n: int) -> str:
    powers = ["", f" {variable}", *(f" {variable}^{j}" for j in range(2, n + 1))]
    return " + ".join(f"{name}_{j}{powers[j]}" for j in range(n, -1, -1))


def _root_lines(proof: Proof, names: dict[int, str]) -> Iterator[str]:
    square = proof.spectrum.in_square
    for piece in proof.pieces:
        root = piece.low
        if not piece.is_point or root is None:
            continue
        approximate = f"{float(root.approximation()) ** (0.5 if square else 1):.12g}"  # for display only
        if root.polynomial.degree() <= 2:
            number = str(closed_form(root, Omega, in_square=square))
            yield f"{names[id(root)]} = {number}" + (f" = {approximate}..." if approximate != number else "")
        else:
            variable = Omega**2 if square else Omega
            polynomial = _caret(root.polynomial.as_expr(variable))
            where = f"{_caret(variable)} the root of {polynomial} in ({root.low}, {root.high})"
            yield f"{names[id(root)]} = {approximate}..., {where}"


def _table(proof: Proof, conditions: dict[str, Any], names: dict[int, str]) -> Iterator[str]:
    field = proof.spectrum.parameter_set.field
    shown = {name: c for name, c in conditions.items() if not (c.is_ground and field.sign(c.coeff(1)) > 0)}
    variable = "Omega^2" if proof.spectrum.in_square else "Omega"
    rows = [["Omega", "sample", *shown, "eigenvalues"]]
    for piece in proof.pieces:
        low = "0" if piece.low is None else names[id(piece.low)]
        high = "oo" if piece.high is None else names[id(piece.high)]
        sample = f"{variable} = {piece.at.x}" if isinstance(piece.at, RationalPoint) and not piece.is_point else ""
        signs = ["-0+"[piece.at.sign(piece.at.value(c)) + 1] for c in shown.values()]
        stable = "" if piece.verdict.stable else ": unstable"
        rows.append([low if piece.is_point else f"({low}, {high})", sample, *signs, piece.verdict.value + stable])
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    for row in rows:
        yield "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
