"""Stability for every damping ratio xi >= 0 at once.

The verdict on (Omega, xi) changes only on finitely many curves F(Omega, xi) = 0, the irreducible factors of the
polynomials of `hurwitz`. Over an open interval of xi without a critical value the curves neither meet nor end, and
on each of them nothing changes either: one rational xi settles the interval. Critical are the xi where a curve has a
vertical tangent, goes to Omega = 0 or oo, meets another, or meets a zero of a condition that decides the verdict on it.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import Any

from sympy import QQ, Expr, Integer, Poly, Rational, oo

from ..algebra.algebraic import Algebraic, Field, RealRoot, closed_form
from ..algebra.points import RationalPoint, point, positive_roots, ring_over, simplest_between
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from ..oscillator.amplification import Amplification
from ..oscillator.spectrum import live
from ..oscillator.stability_polynomial import stability_polynomial
from .certificate import Certificate, certificate, summary
from .hurwitz import Hurwitz, Parts, Spectrum, tidy, verdict, with_derivative

DEGREE = 8  # of an irrational critical xi; beyond it, no certificate over Q(xi) is computed


@dataclass(frozen=True)
class Stretch:
    """A critical xi (low is high) or an open interval of xi (high None: oo), with the certificate of a rational xi.

    certificate is None for an irrational critical xi.
    """

    low: RealRoot
    high: RealRoot | None
    certificate: Certificate | None

    @property
    def is_point(self) -> bool:
        """Whether it is a single xi."""
        return self.low is self.high

    @property
    def ends(self) -> tuple[Expr, Expr]:
        """Both ends of the stretch, exact."""
        return closed_form(self.low, xi), oo if self.high is None else closed_form(self.high, xi)


@dataclass(frozen=True)
class Survey:
    """The curves in the quarter plane Omega > 0, xi > 0, and the xi axis cut at the critical values."""

    parameter_set: ParameterSet
    spectrum: Spectrum
    curves: tuple[Any, ...]
    stretches: tuple[Stretch, ...]

    @classmethod
    def of(cls, parameter_set: ParameterSet) -> "Survey":
        """The survey of a parameter set that leaves xi open. Raises DeclarationError as `certify` does."""
        if not parameter_set.scheme.takes_damping:
            raise DeclarationError(
                f"{parameter_set.scheme.name} is a scheme for u'' = g(t, u), without damping: expected one that takes "
                "damping, to decide its stability at every xi; use certify(...) at xi = 0, or another scheme"
            )
        spectrum, field = Spectrum.of(parameter_set), parameter_set.field
        boundaries = [b for test in Parts.of(spectrum).tests for b in test.boundaries]
        factors = _factors([*boundaries, spectrum.common], field)
        curves = tuple(f for f in factors if f.degree(0) > 0)
        critical = [f for f in factors if f.degree(0) == 0]
        for curve in curves:
            critical += _projections(curve)
            critical += [_eliminate(curve, condition) for condition in _on_curve(curve, spectrum.h)]
        critical += [_eliminate(f, g) for f, g in combinations(curves, 2)]
        over_xi = ring_over(field, xi)
        zero = RealRoot(Poly(xi, domain=QQ), 0, 0)
        roots = [zero, *positive_roots(field, [p for p in (_in_xi(q, over_xi) for q in critical) if p], over_xi)]
        stretches = []
        for low, high in zip(roots, [*roots[1:], None], strict=True):
            stretches.append(Stretch(low, low, None if low.rational is None else _at(parameter_set, low.rational)))
            sample = simplest_between(low.high, low.high + 2 if high is None else high.low)
            stretches.append(Stretch(low, high, _at(parameter_set, sample)))
        return cls(parameter_set, spectrum, curves, tuple(stretches))

    @property
    def first(self) -> Certificate:
        """The certificate at xi = 0."""
        found = self.stretches[0].certificate
        assert found is not None
        return found

    def certificate(self, i: int) -> Certificate | None:
        """The certificate of the i-th stretch, at an irrational xi over Q(xi).

        None at an irrational xi if parameters are irrational too, or if the degree of xi exceeds DEGREE.
        """
        piece = self.stretches[i]
        if piece.certificate or self.parameter_set.field.algebraic or piece.low.polynomial.degree() > DEGREE:
            return piece.certificate
        ends = (as_rational(piece.low.low), as_rational(piece.low.high))
        return certificate(
            self.parameter_set.damped(Algebraic(tuple(piece.low.polynomial.all_coeffs()), ends)), in_square=False
        )

    def stable(self, i: int) -> bool | None:
        """Whether the i-th stretch is stable for every Omega; None if that was not decided.

        At an irrational xi the stretches on both sides are used: eigenvalues that are nowhere outside beside it
        are not outside at it, and one that is outside beside it often still is.
        """
        piece = self.stretches[i]
        if piece.certificate is not None:
            return piece.certificate.stable
        beside = [c for c in (self.stretches[i - 1].certificate, self.stretches[i + 1].certificate) if c is not None]
        over_xi = ring_over(self.parameter_set.field, xi)
        at = point(self.parameter_set.field, piece.low, over_xi)
        if all(c.stable for c in beside):
            excluding = self._where_multiple
            if excluding is not None and all(at.sign(at.value(_in_xi(p, over_xi))) for p in excluding):
                return True
        for x in (p.at.x for c in beside for p in c.proof.pieces if isinstance(p.at, RationalPoint)):
            h = [_in_xi(c.subs(0, self.parameter_set.field.domain.convert(x)), over_xi) for c in self.spectrum.h]
            if not verdict(h, at).stable:
                return False
        if self._inside_where_damped:
            return True
        found = self.certificate(i)
        return None if found is None else found.stable

    @cached_property
    def _inside_where_damped(self) -> bool:
        """Whether every eigenvalue is inside the unit circle at every xi > 0.

        It is where the eigenvalues are R(s_1) and R(s_2), with one rational function R and the oscillator's two s, and
        all open intervals of xi are stable: |R| <= 1 on a dense part of Re s < 0, where R is not constant, so that
        |R| < 1 there by the maximum principle.
        """
        if not all(piece.certificate.stable for piece in self.stretches if piece.certificate is not None):
            return False
        polynomial = stability_polynomial(live(Amplification.of(self.parameter_set.scheme).charpoly))
        return polynomial is not None and polynomial.degree() == 1

    @cached_property
    def _where_multiple(self) -> list[Any] | None:
        """Polynomials in xi: if none vanishes, no eigenvalue on the circle is multiple. None if no such were found."""
        h, field = Hurwitz("h", self.spectrum.h), self.parameter_set.field
        n = h.degree
        pairs = [(h.coefficients[0], h.coefficients[1]), (h.coefficients[-1], h.coefficients[-2])] if n else []
        pairs += [(h.determinant(n - 1), h.determinant(n - 3))] if n > 3 else []  # two pairs on the axis
        found = []
        for a, b in pairs:
            if _one_sign(a, field) or _one_sign(b, field):
                continue
            shared = a.gcd(b)
            if not _one_sign(shared, field):
                return None
            found.append(_eliminate(a.exquo(shared), b.exquo(shared)))
        return found if _one_sign(self.spectrum.common, field) else None


def as_rational(number: Any) -> Rational:
    """A number of QQ for SymPy."""
    return Rational(int(number.numerator), int(number.denominator))


def _at(parameter_set: ParameterSet, damping: Any) -> Certificate:
    return certificate(parameter_set.damped(as_rational(damping)), in_square=False)


def _in_xi(polynomial: Any, over_xi: Any) -> Any:
    """A polynomial that does not hold Omega, as an element of the ring in xi alone."""
    return over_xi.from_dict({(m[-1],): c for m, c in polynomial.terms()})


def _one_sign(polynomial: Any, field: Field) -> bool:
    """Whether all coefficients have one sign, so that there is no zero where Omega > 0 and xi > 0."""
    return len({field.sign(c) for c in polynomial.values()}) == 1


def _factors(polynomials: Iterable[Any], field: Field) -> list[Any]:
    """Distinct irreducible factors over K that may vanish where Omega > 0 and xi > 0."""
    found: dict[Any, None] = {}
    for polynomial in polynomials:
        if polynomial and not _one_sign(polynomial, field):
            found |= {f.monic(): None for f, _ in polynomial.factor_list()[1] if not _one_sign(f, field)}
    return list(found)


def _eliminate(curve: Any, other: Any) -> Any:
    """A polynomial in xi that vanishes where both do; they have no factor in common."""
    return other if other.degree(0) <= 0 else curve.resultant(other)


def _projections(curve: Any) -> Iterator[Any]:
    """Polynomials in xi that vanish where the curve goes to Omega = oo or 0, or where two of its points meet."""
    degree = curve.degree(0)
    for power in (degree, 0):
        yield curve.ring.from_dict({(0, m[1]): c for m, c in curve.terms() if m[0] == power})
    if degree > 1:
        yield curve.discriminant()


def _on_curve(curve: Any, h: Sequence[Any]) -> Iterator[Any]:
    """Polynomials, not zero on the whole curve: between their zeros on it the verdict does not change."""

    def vanishes(polynomial: Any) -> bool:
        return not polynomial.rem(curve)

    kept = [i for i, c in enumerate(h) if not vanishes(c)]
    if not kept:
        return  # the step is not defined anywhere on it
    inner = Hurwitz("h", list(h[kept[0] : kept[-1] + 1]))
    yield inner.coefficients[0]
    yield inner.coefficients[-1]
    pairs = 0
    while vanishes(determinant := inner.determinant(inner.degree - 1 - 2 * pairs)):
        pairs += 1
    yield determinant
    if pairs > 1:
        distinct = Hurwitz("A", with_derivative(inner.shared(pairs))).determinant(2 * pairs - 1)
        if not vanishes(distinct):
            yield distinct


def expression_of(polynomial: Any, field: Field) -> Expr:
    """A polynomial in Omega and xi for SymPy, coefficients coprime."""
    terms = tidy([polynomial], field)[0].terms()
    return sum((field.expression(c) * Omega ** m[0] * xi ** m[1] for m, c in terms), Integer(0))


# --- every xi ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class DampingCell:
    """A maximal interval of xi on which stability for every Omega > 0 has one answer; None: it was not decided."""

    low: Expr
    high: Expr
    low_closed: bool
    high_closed: bool
    stable: bool | None


@dataclass(frozen=True)
class DampingCertificate:
    """Whether a scheme is stable for every Omega > 0 at every xi >= 0, and for which xi it is.

    stable_for_all_xi is None where it is stable wherever it was decided, but not decided everywhere.
    """

    scheme: str
    parameters: dict[str, Rational | Algebraic]
    stable_for_all_xi: bool | None
    cells: tuple[DampingCell, ...]
    survey: Survey = field(repr=False, compare=False)

    @cached_property
    def text(self) -> str:
        """The curves, the critical xi, and what holds on each piece of the xi axis."""
        return "\n".join(_lines(self.survey))


def certify_all_damping(scheme: str | Scheme, **parameters: Any) -> DampingCertificate:
    """Decide for which xi >= 0 a scheme is stable for every Omega > 0.

    Open intervals of xi, xi = 0 and rational critical xi are always decided; of irrational critical xi a few
    may be left open, each as a cell of its own with stable = None.
    Raises as `certify` does.
    """
    survey = Survey.of(ParameterSet.of(scheme, None, parameters))
    answers = [survey.stable(i) for i in range(len(survey.stretches))]
    runs: list[list[int]] = []
    for i, answer in enumerate(answers):
        if runs and answers[i - 1] is answer:
            runs[-1].append(i)
        else:
            runs.append([i])
    cells = tuple(DampingCell(*span(survey, run), answers[run[0]]) for run in runs)
    every = False if False in answers else None if None in answers else True
    return DampingCertificate(survey.first.scheme, survey.first.parameters, every, cells, survey)


def span(survey: Survey, run: Sequence[int]) -> tuple[Expr, Expr, bool, bool]:
    """(low, high, low_closed, high_closed) of consecutive stretches taken together."""
    first, last = survey.stretches[run[0]], survey.stretches[run[-1]]
    return first.ends[0], last.ends[1], first.is_point, last.is_point


def _lines(survey: Survey) -> Iterator[str]:
    yield survey.parameter_set.title
    if survey.curves:
        yield "Curves on which the verdict can change, and what holds between and at their critical xi:"
    else:
        yield "The verdict changes nowhere in Omega > 0, xi > 0: xi = 0 and one xi > 0 settle all."
    for k, curve in enumerate(survey.curves, 1):
        yield f"   F_{k} = {str(expression_of(curve, survey.parameter_set.field)).replace('**', '^')}"
    for i, piece in enumerate(survey.stretches):
        low, high = (_short(root) for root in (piece.low, piece.high))
        if piece.certificate is not None:
            result = summary(piece.certificate)
        else:
            answer = survey.stable(i)
            result = "not decided" if answer is None else f"{'' if answer else 'not '}stable for every Omega > 0"
        where = low if piece.is_point else f"({low}, {high})"
        sample = f", as at {piece.certificate.xi}" if piece.certificate and not piece.is_point else ""
        yield f"   xi {'=' if piece.is_point else 'in'} {where}{sample}: {result}"


def _short(root: RealRoot | None) -> str:
    if root is None:
        return "oo"
    if root.polynomial.degree() <= 2:
        return str(closed_form(root, xi))
    return f"{float(root.approximation()):.12g}... (degree {root.polynomial.degree()})"  # for display only
