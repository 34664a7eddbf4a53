"""The smooth motion of a scheme, expanded in the step: what each held value and the local error are on it.

Where the state holds more than u and v - an acceleration of its own, earlier steps - all but two of the scheme's modes
have died out, or never began, and the rest of the state follows from u, v and the load: it lies in the plane of the
scheme's two principal modes. The local error is that of one step from there, against the exact solution from the u
and v that the scheme reports.
"""

from collections.abc import Iterable
from typing import Any

from sympy import QQ, Symbol

from ..algebra.rational import SingularMatrix, affine_solutions, matrix_inverse
from ..declare.errors import InconsistentScheme
from ..declare.symbols import h, knot_of, lattice, successor
from ..oscillator.evaluation import Evaluation
from .expansion import Expansion, Key, derivative, load, of_g, taylor, weight
from .held import END, HALVED, START, HeldStep, earlier

Rows = list[list[Any]]


class SmoothMotion:
    """Expansions, up to a weight, of everything that a step holds; numbers are from the evaluation's field.

    damped: whether c is not 0.
    """

    def __init__(self, evaluation: Evaluation, top: int, damped: bool = True) -> None:
        self.evaluation, self.top, self.damped = evaluation, top, damped
        self.step = HeldStep.of(evaluation.scheme)
        self.one = evaluation.field.domain.one
        self.zero = evaluation.field.domain.zero
        self._read()
        self.state = self._manifold()

    def _read(self) -> None:
        """The step's equations as sparse rows of (column, power of h*c, power of h^2*k, number)."""
        step, n = self.step, len(self.step.unknowns)
        self.rows: list[list[tuple[int, int, int, Any]]] = []
        for i in range(step.matrix.rows):
            row: list[tuple[int, int, int, Any]] = []
            for column, entry in enumerate(step.matrix.row(i)):
                # Omega^a xi^b = (h*c/2)^b (h^2*k)^((a-b)/2)
                found = self.evaluation.coefficients(entry).items() if entry != 0 else ()
                kept = (((a, b), value) for (a, b), value in found if self.damped or not b)
                row += [(column, b, (a - b) // 2, value * QQ(1, 2**b)) for (a, b), value in kept]
            self.rows.append(row)
        leading = [[self.at_rest(row, c) for c in range(n + len(step.state))] for row in self.rows]
        try:
            self.inverse = matrix_inverse([row[:n] for row in leading], self.evaluation.field.domain)
        except SingularMatrix as error:
            raise InconsistentScheme(f"{step.scheme.name}: a step of length 0 is not determined") from error
        old = [row[n:] for row in leading]
        m = len(step.state)
        self.free = [
            [-sum((self.inverse[i][k] * old[k][j] for k in range(n)), self.zero) for j in range(m)] for i in range(n)
        ]

    def at_rest(self, row: list[tuple[int, int, int, Any]], column: int) -> Any:
        """The number of a column in a row where the step has no length, so that neither c nor k acts."""
        return next((value for at, i, j, value in row if at == column and i == j == 0), self.zero)

    def _manifold(self) -> list[Expansion]:
        """The state on the smooth motion, weight by weight."""
        step, one, zero = self.step, self.one, self.zero
        m = len(step.state)
        place = {s: k for k, s in enumerate(step.unknowns)}
        identity = [[one if i == j else zero for j in range(m)] for i in range(m)]
        new = [
            self.free[place[after]] if (after := successor(s)) in place else identity[step.state.index(after)]
            for s in step.state
        ]
        u, v = self.free[place[END.u]], self.free[place[END.v]]
        less = [[new[i][j] - identity[i][j] for j in range(m)] for i in range(m)]
        # rest (u = 1) and uniform motion (u = 1, h*v = 1 at the step's end) are the modes of a step of length 0
        rest = self._mode([*less, u, v], [zero] * m + [one, zero])
        moving = self._mode([*less, u, v], [*rest, one, one])
        self.rest, self.moving = rest, moving
        system = [[rest[i] * u[j] + moving[i] * v[j] - less[i][j] for j in range(m)] for i in range(m)]
        try:
            inverse = matrix_inverse(system, self.evaluation.field.domain)
        except SingularMatrix as error:
            raise InconsistentScheme(
                f"{step.scheme.name}: an eigenvalue besides the principal pair tends to 1 with the step"
            ) from error
        state = [Expansion({(0, 0, 0): r, (0, 0, 1): q}) for r, q in zip(rest, moving, strict=True)]
        for x in state:
            x.terms = {key: value for key, value in x.terms.items() if value}
        self._instants()
        for w in range(1, self.top + 1):
            self.state = state
            values = self.advanced(state, w)
            later = self.shifted(values, w)
            residual = []
            for i, s in enumerate(step.state):
                after = successor(s)
                x = values[place[after]] if after in place else state[step.state.index(after)]
                residual.append((x - self.composed(state[i], later, w)).at_weight(w))
            for key in sorted({key for r in residual for key in r}):
                column = [r.get(key, zero) for r in residual]
                for i in range(m):
                    value = sum((inverse[i][k] * column[k] for k in range(m)), zero)
                    if value:
                        known = state[i].terms.get(key, zero) + value
                        state[i].terms[key] = known
                        if not known:
                            del state[i].terms[key]
        return state

    def _mode(self, rows: Rows, right: list[Any]) -> list[Any]:
        found = affine_solutions(rows, right, len(rows[0]), self.evaluation.field.domain)
        if found is None or found[1]:
            raise InconsistentScheme(f"{self.step.scheme.name}: it does not keep rest and uniform motion as they are")
        return found[0]

    def _instants(self) -> None:
        """The times at which loads and forces are taken, the latter by the displacement in uniform motion."""
        step, number = self.step, self.evaluation.number
        m = len(step.state)
        motion = {s: self.moving[j] for j, s in enumerate(step.state)}
        for i, s in enumerate(step.unknowns):
            motion[s] = sum((self.free[i][j] * self.moving[j] for j in range(m)), self.zero)
        self.times = [number(tau) for tau in step.stencil]
        self.force_times = [
            [  # motion has h*v and h^2*a, so that h is 1 in what multiplies them
                sum((number(e.diff(s).subs(h, 1)) * motion[s] for s in e.free_symbols if s in motion), self.zero)
                for e in arguments
            ]
            for arguments in step.forces
        ]

    def _load(self, k: int, later: int) -> Expansion:
        """h^2 f at the k-th instant."""
        found, power = Expansion(), self.one
        for m in range(self.top - 1):
            found.add(load(m, self.one, self.damped), power, 0, 0, self.top)
            power = power * (self.times[k] + later) * QQ(1, m + 1)
        return found

    def _force(self, k: int, later: int) -> Expansion:
        """h^2 g at the k-th argument of N; the mean over the time between two, for a discrete gradient."""
        found, times = Expansion(), [time + later for time in self.force_times[k]]
        powers = [self.one for _ in times]
        for m in range(self.top - 1):
            if len(times) == 1:
                value = powers[0]
            else:  # the divided difference of t^(m+1)/(m+1)!
                value, (a, b) = self.zero, times
                power = self.one
                for _ in range(m + 1):  # a^m + a^(m-1) b + ... + b^m
                    value, power = value * a + power, power * b
                value = value * _reciprocal_factorial(m + 1)
            if value:
                found.terms[0, 0, of_g(m)] = value
            powers = [power * time * QQ(1, m + 1) for power, time in zip(powers, times, strict=True)]
        return found

    def advanced(self, state: list[Expansion], top: int, later: int = 0) -> list[Expansion]:
        """The unknowns after a step from a state, which is that at t_n + later*h."""
        n = len(self.step.unknowns)
        loads = [self._load(k, later) for k in range(len(self.step.stencil))]
        given = [*state, *loads, *(self._force(k, later) for k in range(len(self.step.forces)))]
        rest = [Expansion() for _ in self.rows]
        for row, right in zip(self.rows, rest, strict=True):
            for column, i, j, value in row:
                if column >= n:
                    right.add(given[column - n], -value, i, j, top)
        found = [Expansion() for _ in range(n)]
        for w in range(top + 1):
            layer = self._solved([right.at_weight(w) for right in rest])
            for x, part in zip(found, layer, strict=True):
                x.terms |= part.terms
            for row, right in zip(self.rows, rest, strict=True):
                for column, i, j, value in row:
                    if column < n and (i or j):
                        right.add(layer[column], -value, i, j, top)
        return found

    def _solved(self, right: list[dict[Key, Any]]) -> list[Expansion]:
        """The inverse at rest times terms of one weight."""
        found = [Expansion() for _ in right]
        for key in {key for part in right for key in part}:
            column = [(k, part[key]) for k, part in enumerate(right) if key in part]
            for x, inverse in zip(found, self.inverse, strict=True):
                value = sum((inverse[k] * c for k, c in column if inverse[k]), self.zero)
                if value:
                    x.terms[key] = value
        return found

    def shifted(self, values: list[Expansion], top: int) -> dict[int, Expansion]:
        """Place -> its value one step later, where the exact solution starts anew from what the scheme reports."""
        place = {s: k for k, s in enumerate(self.step.unknowns)}
        found = {0: values[place[END.u]], 1: values[place[END.v]]}
        for m in range(top - 1):
            g, both = Expansion(), Expansion()
            for k in range(top - 1 - m):
                g.add(Expansion({(0, 0, of_g(m + k)): self.one}), _reciprocal_factorial(k) * self.one, 0, 0, top)
                both.add(load(m + k, self.one, self.damped), _reciprocal_factorial(k) * self.one, 0, 0, top)
            found[of_g(m)] = g
            both.add(g, -self.one, 0, 0, top)
            if self.damped:
                both.add(found[m + 1], -self.one, 1, 0, top)
            both.add(found[m], -self.one, 0, 1, top)
            found[m + 2] = both
        return found

    def composed(self, x: Expansion, places: dict[int, Expansion], top: int) -> Expansion:
        """An expansion with others in place of the derivatives."""
        found = Expansion()
        for (i, j, place), value in x.terms.items():
            if weight((i, j, place)) <= top:
                found.add(places[place], value, i, j, top)
        return found

    def held(self) -> dict[Symbol, Expansion]:
        """Each value of the step, times its power of h: u, h*v, h^2*a; a_*start among them."""
        values = self.advanced(self.state, self.top)
        found = dict(zip(self.step.state, self.state, strict=True)) | dict(zip(self.step.unknowns, values, strict=True))
        return found | {START.a: derivative(2, self.one)}

    def errors(self, held: dict[Symbol, Expansion]) -> tuple[Expansion, Expansion]:
        """Numerical minus exact u and h*v after one step."""
        exact = (taylor(order, self.one, self.one, self.top) for order in (0, 1))
        u, v = (value - e for value, e in zip((held[END.u], held[END.v]), exact, strict=True))
        return u, v

    def before(self, held: dict[Symbol, Expansion], symbols: Iterable[Symbol], ratio: Any) -> dict[Symbol, Expansion]:
        """Some of the held values as they were in the step before, which was ratio*h long."""
        later = self.shifted([held[s] for s in self.step.unknowns], self.top)
        found = {}
        for symbol in symbols:
            value = held[symbol]
            # find y with y(one step later) = value
            y = Expansion(value.terms)
            for w in range(self.top + 1):
                difference = value - self.composed(y, later, self.top)
                for key, c in difference.at_weight(w).items():
                    total = y.terms.get(key, self.zero) + c
                    y.terms[key] = total
                    if not total:
                        del y.terms[key]
            power = "uva".index((knot_of(symbol) or ("u", ""))[0])
            scaled = y.scaled(ratio)
            found[earlier(symbol)] = Expansion({key: c * ratio**-power for key, c in scaled.terms.items()})
        return {symbol: value for symbol, value in found.items() if symbol not in held}

    def halved(self) -> dict[Symbol, Expansion]:
        """u, h*v at t_n + h after two steps of h/2 from the same state; none where the state holds earlier steps."""
        if any(lattice((knot_of(s) or ("", ""))[1]) for s in self.step.state):
            return {}
        half, two = self.one * QQ(1, 2), self.one * 2
        kinds = ["uva".index((knot_of(s) or ("u", ""))[0]) for s in self.step.state]
        # from here on in powers of h/2
        state = [Expansion().plus(x.scaled(two), half**kind) for x, kind in zip(self.state, kinds, strict=True)]
        values = state
        for later in range(2):
            values = self.advanced(state, self.top, later)
            known = dict(zip(self.step.unknowns, values, strict=True)) | dict(zip(self.step.state, state, strict=True))
            state = [known[successor(s)] for s in self.step.state]
        known = dict(zip(self.step.unknowns, values, strict=True))
        return {
            s: Expansion().plus(known[e].scaled(half), two**k)
            for k, (s, e) in enumerate(((HALVED.u, END.u), (HALVED.v, END.v)))
        }


def _reciprocal_factorial(n: int) -> Any:
    value = QQ(1)
    for k in range(2, n + 1):
        value = value / k
    return value
