"""Estimator -> LocalError: the estimated local errors as sums of weights, powers of h and vectors that a step holds."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sympy import Add, Expr, Integer, Symbol, expand

from ..declare.scheme import Scheme
from ..declare.symbols import h, knot_of
from ..estimate.estimator import NoEstimator, estimator

# of u, then of v: (symbol of a knot, power of h) of each term
Terms = tuple[tuple[tuple[str, int], ...], tuple[tuple[str, int], ...]]


@dataclass(frozen=True)
class LocalError:
    """Estimated local errors (numerical - exact) of u and v: sums of weight * h^power * symbol.

    v has none where what the step holds gives no estimate of its error. order: p, where they are O(h^(p+1)). weights:
    of the terms of u, then of v; expressions in the parameters left free.
    """

    scheme: Scheme
    terms: Terms
    weights: tuple[Expr, ...]
    order: int

    @classmethod
    def of(cls, scheme: Scheme, exact: Mapping[str, Any], *, damped: bool) -> "LocalError":
        """From the scheme's estimator with the given parameters fixed; damped: it has to hold with damping.

        Where what the step holds gives an estimate for u alone, v has no terms. Raises NoEstimator, with the reason,
        where it gives none for u.
        """
        found = estimator(scheme, damped=damped, **exact)
        if found.displacement.extra:
            what = "; ".join(f"{symbol}, {text}" for symbol, text in found.displacement.extra.items())
            raise NoEstimator(
                f"{scheme.name}: expected an estimate of the local error from what its step holds, got one that needs "
                f"{what}; march it with dt, or take a scheme such as bathe, or one with a second value (embedded)"
            )
        held = [one for one in (found.displacement, found.velocity) if not one.extra]
        own, numbers = [_collected(found.scheme, one.error) for one in held], []
        own += [[]] * (2 - len(own))
        for terms in own:
            numbers += [weight for _, _, weight in terms]
        u, v = (tuple((symbol, power) for symbol, power, _ in terms) for terms in own)
        return cls(scheme, (u, v), tuple(numbers), min(one.order for one in held))

    @cached_property
    def parameters(self) -> tuple[Symbol, ...]:
        """The parameters that the weights contain, in the order declared."""
        used = {s for e in self.weights for s in e.free_symbols}
        return tuple(s for s in self.scheme.values if s in used)


def weight_names(terms: Terms) -> list[Symbol]:
    """A name for each term's weight."""
    return [Symbol(f"weight_{k}") for k in range(sum(map(len, terms)))]


def combined(terms: Terms) -> tuple[Expr, Expr]:
    """The estimated errors of u and v with named weights."""
    names = iter(weight_names(terms))
    u, v = (sum((next(names) * h**power * Symbol(symbol) for symbol, power in own), Integer(0)) for own in terms)
    return u, v


def _collected(scheme: Scheme, error: Expr) -> list[tuple[str, int, Expr]]:
    """(symbol, power of h, weight) of each term."""
    found: list[tuple[str, int, Expr]] = []
    error = expand(error)
    for symbol in sorted((s for s in error.free_symbols if knot_of(s)), key=str):
        for term in Add.make_args(expand(error.diff(symbol))):
            factor, power = term.as_independent(h)
            _, exponent = power.as_base_exp() if power != 1 else (h, Integer(0))
            known = [k for k, (name, p, _) in enumerate(found) if (name, p) == (symbol.name, int(exponent))]
            if known:
                found[known[0]] = (symbol.name, int(exponent), found[known[0]][2] + factor)
            else:
                found.append((symbol.name, int(exponent), factor))
    return [(name, power, weight.factor()) for name, power, weight in found]
