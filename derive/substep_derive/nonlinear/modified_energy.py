"""Modified equation -> the energy that a scheme keeps on every potential, and the first rate at which it does not.

On u'' = -N(u), N per unit mass the gradient of a potential V, a modified energy H = T + V + h^p H_p + ... is sought
with dH/dt = 0 along the modified equation, power by power. The H_p are sums of scalar products, each a contraction of
derivatives of V with velocities; so is the rate. Where no H_p makes a power of the rate vanish, what is left is the
leading rate at which the computed energy changes, whatever the potential.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from sympy import Expr

from ..algebra.rational import affine_solutions
from ..oscillator.evaluation import Evaluation
from .modified import HIGHEST, Along, ModifiedEquation, modified_equation
from .trees import Trees, V, add

Scalar = tuple[int, ...]  # V^(m)(x, y, ...) of these trees x, y, ..., among its equal forms the least; () is T + V
Scalars = dict[Scalar, Any]  # -> number


@dataclass(frozen=True)
class ModifiedEnergy:
    """H = T + V + sum of h^power H_power for the reported u and v, with dH/dt = sum of h^power R_power.

    terms: power -> the scalars of H_power, rates: power -> those of R_power; powers without any are left out. A scalar
    in which v occurs an odd number of times has the mean 0 on a motion that runs through the same states forwards and
    backwards.
    """

    equation: ModifiedEquation
    terms: dict[int, Scalars]
    rates: dict[int, Scalars]

    @property
    def loss(self) -> int | None:
        """The lowest power of a rate that need not have the mean 0, None where there is none."""
        of = self.equation.of
        lasting = (power for power, scalars in self.rates.items() if any(_occurrences(of, s) % 2 == 0 for s in scalars))
        return min(lasting, default=None)

    def coefficients(self, found: dict[int, Scalars]) -> dict[int, dict[str, Expr]]:
        """Power -> scalar as text -> its factor, of `terms` or `rates`.

        V[v, v] is v V''(u) v, V[v, N[v]] the square of V''(u) v and V[N[]] that of V'(u), by the inverse of the mass.
        """
        of, closed = self.equation.of, self.equation.closed
        return {
            power: {f"V[{', '.join(map(of.text, s))}]": closed(c) for s, c in sorted(scalars.items())}
            for power, scalars in found.items()
        }


def modified_energy(equation: ModifiedEquation) -> ModifiedEnergy | None:
    """The modified energy; None for an equation with damping or K0 in it."""
    of = equation.of
    if of.damping or of.tangent:
        return None
    domain = equation.evaluation.field.domain
    one = domain.one
    along = Along(of, equation.field, one)
    levels: dict[int, Scalars] = {2: {(): one}}  # by weight
    rates: dict[int, Scalars] = {}
    for w in range(3, equation.top + 3):
        residual: Scalars = {}
        for lower, scalars in levels.items():
            for s, c in scalars.items():
                add(residual, derivative(along, s, w + 1 - lower), c)
        basis, targets = _scalars(of, w), _scalars(of, w + 1)
        columns = [derivative(along, s, 1) for s in basis] + [{s: one} for s in targets]
        rows = [[column.get(s, one - one) for column in columns] for s in targets]
        solved = affine_solutions(rows, [-residual.get(s, one - one) for s in targets], len(columns), domain)
        assert solved is not None  # each target is a column of its own
        values = solved[0]
        levels[w] = {s: c for s, c in zip(basis, values[: len(basis)], strict=True) if c}
        left = {s: -c for s, c in zip(targets, values[len(basis) :], strict=True) if c}
        if left:
            rates[w - 2] = left
    terms = {w - 2: found for w, found in levels.items() if w > 2 and found}
    return ModifiedEnergy(equation, terms, rates)


def leading_loss(evaluation: Evaluation) -> ModifiedEnergy | None:
    """The modified energy up to the lowest power at which energy is lost or gained for good, and at least two terms.

    None as of `modified_energy`; without a loss where there is none up to `HIGHEST`.
    """
    equation = modified_equation(evaluation)
    found = modified_energy(equation)
    while found is not None and found.loss is None and equation.top < HIGHEST:
        equation = modified_equation(evaluation, equation.top + 1)
        found = modified_energy(equation)
    return found


def _occurrences(of: Trees, branches: tuple[int, ...]) -> int:
    """How often v occurs in some trees."""
    return sum(x == V or _occurrences(of, of.keys[x][1]) for x in branches)


def _scalars(of: Trees, w: int) -> list[Scalar]:
    """All scalars of a weight, those first that a linear force has: V[v, v], V[v, N[v]], ..., which are squares."""
    of.grow(w)
    found = {least(of, of.keys[tree][1]) for tree in of.levels[w] if of.keys[tree][0] == "N"}
    return sorted(found, key=lambda s: (not _is_square(of, s), s))


def _is_square(of: Trees, s: Scalar) -> bool:
    """Whether it is V[v, v], V[v, N[v]], V[v, N[N[v]]] or the like."""
    return any(len(form) == 2 and form[0] == V and _chain(of, form[1]) for form in forms(of, s))


def _chain(of: Trees, tree: int) -> bool:
    branches = of.keys[tree][1]
    return tree == V or (len(branches) == 1 and _chain(of, branches[0]))


def forms(of: Trees, s: tuple[int, ...]) -> Iterator[Scalar]:
    """All ways to write a scalar: V[x, ..., N[y, ...]] = V[y, ..., N[x, ...]]."""
    waiting, seen = [tuple(sorted(s))], set[Scalar]()
    while waiting:
        form = waiting.pop()
        if form in seen:
            continue
        seen.add(form)
        yield form
        for k, x in enumerate(form):
            kind, branches = of.keys[x]
            if kind == "N":
                other = of.number("N", *form[:k], *form[k + 1 :])
                waiting.append(tuple(sorted((*branches, other))))


def least(of: Trees, s: tuple[int, ...]) -> Scalar:
    """The form of a scalar that stands for all."""
    return min(forms(of, s))


def derivative(along: Along, s: Scalar, more: int) -> Scalars:
    """The part of h times a scalar's derivative that weighs `more` more; of T + V, for (), that of h^2 (T + V)."""
    of, found = along.of, Scalars()
    X_u, X_v = along.field
    if s == ():
        w = more + 1  # d T = v X_v, and V[...] with v; d V = V[X_u]
        for x, c in X_v[w].items() if w < len(X_v) else ():
            kind, branches = of.keys[x]
            assert kind == "N"
            add(found, {least(of, (*branches, V)): along.one}, c)
        for x, c in X_u[more].items() if more < len(X_u) else ():
            add(found, {least(of, (x,)): along.one}, c)
        return found
    for x, c in X_u[more].items() if more < len(X_u) else ():
        add(found, {least(of, (*s, x)): along.one}, c)
    for k, branch in enumerate(s):
        for x, c in along.derivative(branch, more).items():
            add(found, {least(of, (*s[:k], x, *s[k + 1 :])): along.one}, c)
    return found
