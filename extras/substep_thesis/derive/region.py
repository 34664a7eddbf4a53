"""Whether a scheme is stable everywhere in a region of its parameters, and whether two sets of conditions are the same.

A region is written as the image of a box: every parameter as a polynomial in coordinates that run through intervals.
The scheme with the coordinates for its parameters is a scheme like any other, so `conditions` applies to it: it is
stable everywhere in the region exactly if no condition on the coordinates is left.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

from substep_derive.declare.parameter import Parameter
from substep_derive.declare.scheme import Scheme
from substep_derive.stability.conditions import Conditions, conditions
from sympy import Expr, Interval, Poly, Rational, Set, Symbol, expand
from sympy.core.relational import Eq, Ge, Gt, Le, Lt, Ne
from sympy.logic.boolalg import And, Boolean, Or, false, true


@dataclass(frozen=True)
class Region:
    """Parameters of a scheme as functions of coordinates, each of which runs through its interval.

    values: parameter -> polynomial in the coordinates; coordinates: symbol -> interval with a finite start. The
    scheme's own intervals are set aside: the region alone says where its parameters lie.
    """

    scheme: Scheme
    values: Mapping[Symbol, Expr]
    coordinates: Mapping[Symbol, Interval]

    @property
    def member(self) -> Scheme:
        """The scheme with the coordinates for parameters."""

        def replaced(expressions: Mapping[Symbol, Expr]) -> dict[Symbol, Expr]:
            return {symbol: e.subs(self.values, simultaneous=True) for symbol, e in expressions.items()}

        scheme = self.scheme
        return replace(
            scheme,
            parameters=tuple(Parameter(x, i, _inside(i)[-1]) for x, i in self.coordinates.items()),
            families=(),
            relations=replaced(scheme.relations),
            start=replaced(scheme.start) if isinstance(scheme.start, Mapping) else scheme.start,
            report=replaced(scheme.report),
            embedded=replaced(scheme.embedded),
            balances=tuple(balance.replace(self.values) for balance in scheme.balances),
        )

    @cached_property
    def conditions(self) -> Conditions:
        """Conditions on the coordinates for undamped stability at every Omega > 0. Raises as `conditions` does."""
        return conditions(self.member)

    @cached_property
    def counterexample(self) -> dict[str, Rational] | None:
        """Exact parameters of the region at which the scheme is unstable; None if it is stable everywhere in it.

        A double root on the circle counts as unstable. None is a proof: no condition on the coordinates is left.
        Raises NotImplementedError where conditions are left and yet hold at every point tried.
        """
        found = self.conditions
        if found.eliminated and And(*found.inequalities) is true:
            return None
        for at in self._points():
            if not found.holds({x.name: value for x, value in at.items()}):
                return self._parameters(at)
        raise NotImplementedError(f"undecided, though no point tried is unstable: {found.text}")

    def points(self) -> list[dict[str, Rational]]:
        """Exact parameters on the edges of the region that belong to it, and inside."""
        return [self._parameters(at) for at in self._points()]

    def _points(self) -> Iterator[dict[Symbol, Rational]]:
        """The points of `points` in the region's coordinates."""
        for chosen in product(*(_inside(interval) for interval in self.coordinates.values())):
            yield dict(zip(self.coordinates, chosen, strict=True))

    def _parameters(self, at: Mapping[Symbol, Rational]) -> dict[str, Rational]:
        return {x.name: Rational(e.subs(at)) for x, e in self.values.items()}

    @property
    def stable(self) -> bool:
        """Whether the scheme is stable everywhere in the region. Raises as `counterexample` does."""
        return self.counterexample is None

    @property
    def unstable(self) -> bool:
        """Whether it is proved to be stable nowhere in the region."""
        return And(*self.conditions.inequalities) is false


def _inside(interval: Interval) -> list[Rational]:
    """Some exact numbers of an interval: its ends if they belong to it, quarters, and its middle as the last."""
    width = interval.end - interval.start if interval.end.is_finite else Rational(2)
    numbers = [interval.start + width * Rational(k, 4) for k in (0, 1, 3, 4, 2)]
    return [x for x in numbers if x in interval]


def same_conditions(found: Conditions, printed: Iterable[Boolean]) -> bool:
    """Whether derived conditions, necessary and sufficient, are the printed ones.

    Inequalities are compared as polynomials, up to a positive factor and whichever way they are written.
    """
    return found.eliminated and _canonical(And(*found.inequalities)) == _canonical(And(*printed))


def _canonical(condition: Boolean) -> Any:
    """A form that is equal for conditions that differ only in order, in their sides, or by a positive factor."""
    if isinstance(condition, And | Or):
        return type(condition).__name__, frozenset(_canonical(part) for part in condition.args)
    if isinstance(condition, Eq | Ne):
        p = _primitive(condition.lhs - condition.rhs)
        return type(condition).__name__, max(p, -p, key=lambda q: q.LC()).as_expr()
    if isinstance(condition, Ge | Gt | Le | Lt):
        strict = isinstance(condition, Gt | Lt)
        return "> 0" if strict else ">= 0", _primitive(condition.gts - condition.lts).as_expr()
    return str(condition)  # true or false


def _primitive(expression: Expr) -> Poly:
    """The positive multiple of a polynomial whose coefficients are integers without a common factor."""
    p = Poly(expand(expression), *sorted(expression.free_symbols, key=str))
    return p.clear_denoms(convert=True)[1].primitive()[1]


def stable_values(found: Conditions) -> Set:
    """The exact set of values of a scheme's only parameter at which it is stable at every Omega > 0.

    Raises ValueError for several parameters, or where Omega could not be eliminated.
    """
    if len(found.scheme.parameters) != 1 or not found.eliminated:
        raise ValueError(
            f"{found.scheme.name}: expected one parameter and conditions free of Omega, got {found.text}; "
            "fix the other parameters, or ask for a certificate at exact values"
        )
    (parameter,) = found.scheme.parameters
    left = And(*found.inequalities)
    return parameter.domain if left is true else parameter.domain.intersect(left.as_set())
