"""Estimator -> LocalError: the estimated local errors as sums of weights, powers of h and of kappa, and vectors.

Besides what a step holds, an estimate may take an acceleration from the equation of motion at an end of the step,
values of the step before, which was kappa*h long, and u and v after two half steps (see `estimate.analysis`). Where
they do not see the force at the end of a step, a third sum compares it with what the step assumed (see `estimate.end`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sympy import Expr, Float, Integer, Poly, Symbol, expand, factor, fraction

from ..algebra.algebraic import Field, generator
from ..declare.names import python_name
from ..declare.parameter import Root
from ..declare.parameter_set import ParameterSet
from ..declare.related import related
from ..declare.scheme import Scheme
from ..declare.symbols import h, knot_of
from ..estimate.end import end_check
from ..estimate.estimator import Estimator, estimator, estimator_at, kappa
from ..estimate.held import END, HALVED, START, earlier
from ..motion.components import Assignments

# of u or v: (symbol of a knot, power of h, power of kappa) of each term, and the powers of kappa in the denominator,
# none where it is 1
TermsOfOne = tuple[tuple[tuple[str, int, int], ...], tuple[int, ...]]
Terms = tuple[TermsOfOne, ...]  # of u, of v, and where it is checked of the end


@dataclass(frozen=True)
class LocalError:
    """Estimated local errors (numerical - exact) of u and v: sums of weight * h^i * kappa^j * symbol.

    A sum may stand over another one, of weight * kappa^j. order: p, where both are O(h^(p+1)). weights: of the terms of
    u and of its denominator, then the same of v; expressions in the parameters left free. Where there is a third sum,
    of the end, it is an error of v too; always: whether each step needs it, or only one that has none before it.
    """

    scheme: Scheme
    terms: Terms
    weights: tuple[Expr, ...]
    order: int
    always: bool

    @classmethod
    def of(cls, scheme: Scheme, exact: Mapping[str, Any], *, damped: bool) -> "LocalError":
        """From the scheme's estimator where steps change, with the given parameters fixed, others at their default.

        damped: it has to hold with damping. A default that is irrational is taken exactly, since an order of accuracy
        may hold there alone. Raises NoEstimator, with the reason, where there is none.
        """
        found = _found(scheme, exact, damped)
        check = end_check(found, damped)
        own = [_collected(e) for e in (found.u, found.v, *([check.error] if check else []))]
        number = _number(found)
        weights = tuple(number(e) for _, above, _, below in own for e in (*above, *below))
        terms = tuple((terms, powers) for terms, _, powers, _ in own)
        return cls(found.scheme, terms, weights, min(found.order), check is None or check.always)

    @cached_property
    def sources(self) -> dict[str, tuple[str, str]]:
        """Of each symbol of the terms, where its value is known, and its name there.

        "step": a vector of the step's plan. "before": one of the step before. "end": u, v or a that is reported at the
        end, a from the equation of motion; "start": that a at the start; "halved": u, v after two half steps.
        """
        before = {earlier(s): s for s in (*self.scheme.unknowns, *self.scheme.state)}
        found: dict[str, tuple[str, str]] = {}
        for name in sorted({name for above, _ in self.terms for name, _, _ in above}):
            s = Symbol(name)
            known = [where for where, ends in (("end", END), ("start", START), ("halved", HALVED)) if s in ends]
            if known:
                found[name] = known[0], name[0]
            elif s in self.scheme.unknowns or s in self.scheme.state:
                found[name] = "step", python_name(s)
            else:
                found[name] = "before", python_name(before[s])
        return found

    @cached_property
    def parameters(self) -> tuple[Symbol, ...]:
        """The parameters that the weights contain, in the order declared."""
        used = {s for e in self.weights for s in e.free_symbols}
        return tuple(s for s in self.scheme.values if s in used)


def _found(scheme: Scheme, exact: Mapping[str, Any], damped: bool) -> Estimator:
    fixed = scheme.fix(exact) if exact else scheme
    if fixed.constant is not None or any(_irrational(p.default) for p in fixed.parameters):
        return estimator_at(ParameterSet.of(scheme, None, exact), damped=damped, changing=True)
    return estimator(related(scheme, exact) if exact else scheme, damped=damped, changing=True)


def _irrational(default: Any) -> bool:
    return isinstance(default, Root) or not (default.free_symbols or default.is_Rational)


def _number(found: Estimator) -> Callable[[Expr], Expr]:
    """What writes a weight: as it is, or as a number where parameters are irrational."""
    evaluation, field = found.evaluation, found.evaluation.field
    if not isinstance(field, Field):
        return lambda e: e
    return lambda e: Float(field.nearest(evaluation.number(e)), 17)


def weight_names(terms: Terms) -> list[Symbol]:
    """A name for each weight."""
    return [Symbol(f"weight_{k}") for k in range(sum(len(above) + len(below) for above, below in terms))]


def combined(terms: Terms) -> list[Expr]:
    """The estimated errors with named weights."""
    factors, errors = factored(terms)
    named = dict(factors)
    return [e.subs(named) for e in errors]


def factored(terms: Terms) -> tuple[Assignments, list[Expr]]:
    """Factors that depend on kappa, each a sum of named weights over another; the estimated errors with them."""
    names, factors, errors = iter(weight_names(terms)), Assignments(), list[Expr]()
    for above, below in terms:
        weights = [next(names) for _ in above]
        den = sum((next(names) * kappa**power for power in below), Integer(0)) if below else Integer(1)
        by_symbol: dict[tuple[str, int], Expr] = {}
        for weight, (symbol, power, of_kappa) in zip(weights, above, strict=True):
            key = symbol, power
            by_symbol[key] = by_symbol.get(key, Integer(0)) + weight * kappa**of_kappa
        error: Expr = Integer(0)
        for (symbol, power), e in by_symbol.items():
            if (whole := e / den).has(kappa):
                factors.append((Symbol(f"factor_{len(factors)}"), whole))
                whole = factors[-1][0]
            error += whole * h**power * Symbol(symbol)
        errors.append(error)
    return factors, errors


def _collected(error: Expr) -> tuple[tuple[tuple[str, int, int], ...], list[Expr], tuple[int, ...], list[Expr]]:
    """(symbol, power of h, power of kappa) of each term, their weights; the same of the denominator."""
    numerator, den = fraction(error if error.has(generator) else factor(error))
    den, below = den.as_independent(kappa, as_Add=False)
    terms: dict[tuple[str, int, int], Expr] = {}
    numerator = expand(numerator)
    for symbol in sorted((s for s in numerator.free_symbols if knot_of(s)), key=str):
        for (of_kappa,), c in Poly(numerator.diff(symbol), kappa).terms():
            for term in expand(c / den).as_ordered_terms():
                weight, power = term.as_independent(h, as_Add=False)
                key = symbol.name, int(power.as_base_exp()[1]) if power != 1 else 0, of_kappa
                terms[key] = terms.get(key, Integer(0)) + weight
    known: list[tuple[tuple[int], Expr]] = Poly(below, kappa).terms() if below != 1 else []
    weights = [e if e.has(generator) else factor(e) for e in terms.values()]
    return (*terms,), weights, tuple(power for (power,), _ in known), [c for _, c in known]
