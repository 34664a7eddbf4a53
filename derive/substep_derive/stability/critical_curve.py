"""The critical Omega of a conditionally stable scheme as a curve over the damping ratio."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sympy import Expr, Integer, Poly, Rational, expand, factor, oo, sqrt

from ..algebra.algebraic import Algebraic, RealRoot
from ..algebra.points import positive_roots
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from .all_damping import Survey, as_rational, expression_of, span
from .certificate import Certificate


@dataclass(frozen=True)
class CurvePiece:
    """The critical Omega over an interval of xi: a branch of relation = 0, and as a function of xi where that is short.

    Without a relation Omega is a constant: oo (stable for every Omega), 0 (unstable at once), a number at a single xi,
    or None where it was not decided. by_continuity: single xi of the interval that no certificate covers, so that the
    value is that of the branch on both sides.
    """

    low: Expr
    high: Expr
    low_closed: bool
    high_closed: bool
    relation: Expr | None
    Omega: Expr | None
    by_continuity: tuple[Expr, ...] = ()


@dataclass(frozen=True)
class CriticalCurve:
    """Where the interval of stability that starts at Omega = 0 ends, for every xi >= 0."""

    scheme: str
    parameters: dict[str, Rational | Algebraic]
    pieces: tuple[CurvePiece, ...]

    @property
    def relations(self) -> tuple[Expr, ...]:
        """The irreducible polynomials in Omega and xi on whose zeros the curve lies."""
        return tuple(dict.fromkeys(piece.relation for piece in self.pieces if piece.relation is not None))

    @property
    def explicit(self) -> Expr | None:
        """The function of xi if a single one holds for every xi >= 0."""
        return self.pieces[0].Omega if len(self.pieces) == 1 else None


@dataclass(frozen=True)
class _Branch:
    """The k-th of the `count` positive roots Omega of a curve; without a curve, the constant 0 or oo."""

    curve: Any
    k: int
    count: int
    constant: Expr | None


def critical_curve(scheme: str | Scheme, **parameters: Any) -> CriticalCurve:
    """The critical Omega as a function of xi, at given parameters. Raises as `certify` does."""
    survey = Survey.of(ParameterSet.of(scheme, None, parameters))
    branches = [None if piece.is_point else _branch(survey, i) for i, piece in enumerate(survey.stretches)]
    followed = []
    for i in range(0, len(branches), 2):
        before, after = branches[i - 1] if i else None, branches[i + 1]
        found = survey.certificate(i)
        if found is not None:
            branches[i] = next((b for b in (before, after) if b and _ends_at(b, found)), None)
        elif before == after and before is not None:
            stable, endless = survey.stable(i), before.constant is oo
            if not endless or stable is not False:
                branches[i] = before
            if not endless or stable is None:
                followed.append(i)
    runs: list[list[int]] = []
    for i, branch in enumerate(branches):
        if runs and branch is not None and branch == branches[i - 1]:
            runs[-1].append(i)
        else:
            runs.append([i])
    pieces = tuple(_curve_piece(survey, branches[run[0]], run, followed) for run in runs)
    return CriticalCurve(survey.first.scheme, survey.first.parameters, pieces)


def _critical_root(certificate: Certificate) -> RealRoot | Expr:
    """The end of the first interval as a root in Omega, or 0 or oo."""
    runs = certificate.proof.runs()
    if not runs or runs[0][0] is not certificate.proof.pieces[0]:
        return Integer(0)
    return oo if (end := runs[0][-1].high) is None else end


def _over(curve: Any, certificate: Certificate) -> Any:
    """The curve's polynomial in Omega at a certificate's xi."""
    spectrum = certificate.proof.spectrum
    field = spectrum.parameter_set.field
    assert spectrum.parameter_set.damping is not None
    damping = field.number(spectrum.parameter_set.damping)
    rows: dict[tuple[int, ...], Any] = {}
    for (power, k), c in curve.terms():
        rows[(power,)] = rows.get((power,), field.domain.zero) + field.domain.convert(c) * damping**k
    return spectrum.ring.from_dict({m: c for m, c in rows.items() if c})


def _roots(polynomial: Any, certificate: Certificate) -> list[RealRoot]:
    spectrum = certificate.proof.spectrum
    return positive_roots(spectrum.parameter_set.field, [polynomial] if polynomial else [], spectrum.ring)


def _branch(survey: Survey, i: int) -> _Branch:
    """The branch on which the critical Omega of an open interval of xi lies."""
    found = survey.stretches[i].certificate
    assert found is not None
    end = _critical_root(found)
    if not isinstance(end, RealRoot):
        return _Branch(None, 0, 0, end)
    for curve in survey.curves:
        roots = _roots(_over(curve, found), found)
        for k, root in enumerate(roots):
            if root.is_same(end):
                return _Branch(curve, k, len(roots), None)
    raise AssertionError(f"no curve through Omega = {end.approximation()} at xi = {found.xi}")


def _ends_at(branch: _Branch, certificate: Certificate) -> bool:
    """Whether a branch beside a critical xi tends to the critical Omega there, while no root of its curve is lost."""
    end = _critical_root(certificate)
    if branch.curve is None or not isinstance(end, RealRoot):
        return branch.constant is not None and end == branch.constant
    polynomial = _over(branch.curve, certificate)
    if polynomial.degree() < branch.curve.degree(0) or not polynomial.coeff(1):
        return False
    roots = _roots(polynomial, certificate)
    return len(roots) == branch.count and roots[branch.k].is_same(end)


def _curve_piece(survey: Survey, branch: _Branch | None, run: Sequence[int], followed: Sequence[int]) -> CurvePiece:
    ends = span(survey, run)
    if branch is None:
        at = survey.certificate(run[0])
        return CurvePiece(*ends, None, None if at is None else oo if at.critical_Omega is None else at.critical_Omega)
    skipped = tuple(survey.stretches[i].ends[0] for i in run if i in followed)
    if branch.curve is None:
        return CurvePiece(*ends, None, branch.constant, skipped)
    sample = next(c for i in run if not survey.stretches[i].is_point and (c := survey.stretches[i].certificate))
    relation = expression_of(branch.curve, survey.parameter_set.field)
    end = _critical_root(sample)
    assert isinstance(end, RealRoot)
    return CurvePiece(*ends, relation, _explicit(relation, sample.xi, end), skipped)


def _explicit(relation: Expr, damping: Any, end: RealRoot) -> Expr | None:
    """The branch through a root as a function of xi, if the relation has degree two in Omega or in Omega^2."""
    polynomial = Poly(relation, Omega)
    step = 2 if all(m % 2 == 0 for (m,) in polynomial.monoms()) else 1
    if polynomial.degree() > 2 * step:
        return None
    a, b, c = (polynomial.coeff_monomial(Omega ** (step * k)) for k in (2, 1, 0))
    if a == 0:
        candidates = [factor(-c / b)]
    else:
        root = sqrt(factor(b**2 - 4 * a * c))
        candidates = [expand((-b + sign * root) / (2 * a)) for sign in (1, -1)]
    low, high = as_rational(end.low), as_rational(end.high)
    for candidate in candidates:
        function = candidate if step == 1 else sqrt(candidate)
        number = function.subs(xi, damping)
        if number.is_real and not (number - low).is_negative and not (high - number).is_negative:
            return function
    return None
