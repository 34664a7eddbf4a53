"""The catalogue's estimators at default parameters as plain data, from which the runtime computes how good they are."""

from collections.abc import Iterable
from typing import Any

from sympy import Expr, Float, Rational

from ..algebra.algebraic import Field, generator
from ..algebra.constant import approximated
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import h
from ..estimate.analysis import NoEstimator
from ..estimate.estimator import estimator_at
from ..estimate.quality import OnOscillator, filter_of, filters, on_oscillator
from ..estimate.stiff import Polynomial, Row
from ..oscillator.evaluation import Evaluation

Terms = tuple[tuple[int, int, float], ...]


def estimates(schemes: Iterable[Scheme]) -> dict[str, Any]:
    """ESTIMATORS: scheme -> its entry; see `entry`."""
    return {"ESTIMATORS": {scheme.name: entry(scheme) for scheme in schemes}}


def entry(scheme: Scheme) -> dict[str, Any]:
    """A scheme's estimators at its default parameters, or the reason why it has none.

    Polynomials are (power of Omega, power of xi, factor). estimates, dens, back: see `OnOscillator`. filter: numerator
    and denominator on the oscillator; filters: how often it has to be applied for each to vanish as Omega -> oo.
    """
    try:
        found = estimator_at(ParameterSet.of(scheme, None, {}))
    except NoEstimator as reason:
        return {"reason": str(reason)}
    field, rows = found.evaluation.field, OnOscillator.of(found)
    assert isinstance(field, Field)

    def terms(polynomial: Polynomial) -> Terms:
        return tuple((p, q, field.nearest(c)) for (p, q), c in sorted(polynomial.items()))

    def row(entries: Row) -> tuple[Terms, ...]:
        return tuple(terms(e) for e in entries)

    return {
        "u": shown(scheme, found.u),
        "v": shown(scheme, found.v),
        "order": found.order,
        "extra": {str(s): text for s, text in (found.extra or {}).items()},
        "growth": (int(found.displacement.growth), int(found.velocity.growth)),
        "filters": tuple(filters(one, vanishing=True) for one in (found.displacement, found.velocity)),
        "filter": _filter(found.evaluation, terms),
        "estimates": tuple(map(row, rows.estimates)),
        "dens": tuple(map(terms, rows.dens)),
        "back": rows.back,
        "reported": tuple(map(row, rows.reported)),
        "den": terms(rows.growth.den),
    }


def shown(scheme: Scheme, error: Expr) -> str:
    """An estimate as text; with 17 digits of weights that are numbers of a constant's field, which would fill pages."""
    if scheme.constant is None:
        return str(error)
    near = (approximated((error.subs(generator, scheme.constant) * h**2).expand()) / h**2).expand()
    return str(near.xreplace({x: Float(x, 17) for x in near.atoms(Rational) if x.q > 2**53}))


def _filter(evaluation: Evaluation, terms: Any) -> tuple[Terms, Terms] | None:
    found = filter_of(evaluation.scheme)
    if found is None:
        return None
    numerator, denominator = on_oscillator(found).as_numer_denom()
    return tuple(terms(evaluation.coefficients(part.expand())) for part in (numerator, denominator))  # type: ignore
