"""The smooth motion of a scheme, expanded in the step: what each held value and the local error are on it.

Where the state holds more than u and v - an acceleration of its own, earlier steps - all but two of the scheme's modes
have died out, or never began, and the rest of the state follows from u, v and the load: it lies in the plane of the
scheme's two principal modes. The local error is that of one step from there, against the exact solution from the u
and v that the scheme reports.
"""

from collections.abc import Iterable
from typing import Any

from sympy import QQ, Symbol

from ..declare.symbols import kind_of, steps_back
from ..oscillator.evaluation import Evaluation
from .expanded_step import ExpandedStep, applied, reciprocal_factorial
from .expansion import Expansion, derivative, load, of_g, taylor, weight
from .held import END, HALVED, START, earlier


class SmoothMotion:
    """Expansions, up to a weight, of everything that a step holds; numbers are from the evaluation's field.

    damped: whether c is not 0. state: that of the smooth motion.
    """

    def __init__(self, evaluation: Evaluation, top: int, damped: bool = True) -> None:
        self.evaluation, self.top, self.damped = evaluation, top, damped
        self.equations = ExpandedStep(evaluation, top, damped)
        self.step, self.one, self.zero = self.equations.held, self.equations.one, self.equations.zero
        self.state = self._manifold()

    def _manifold(self) -> list[Expansion]:
        """The state on the smooth motion, weight by weight.

        At each weight it has to satisfy that a step leads to the same state, in the derivatives one step later.
        """
        step = self.equations
        places = range(len(self.step.state))
        u, v = (step.free[self.step.unknowns.index(s)] for s in END[:2])
        system = [[step.rest[i] * u[j] + step.moving[i] * v[j] - step.new[i][j] for j in places] for i in places]
        for i in places:
            system[i][i] += self.one
        reason = f"{self.step.scheme.name}: an eigenvalue besides the principal pair tends to 1 with the step"
        inverse = step.inverted(system, reason)
        state = [
            Expansion({key: value for key, value in (((0, 0, 0), r), ((0, 0, 1), q)) if value})
            for r, q in zip(step.rest, step.moving, strict=True)
        ]
        for w in range(1, self.top + 1):
            values = step.advanced(state, w)
            later = self.shifted(values, w)
            new = (step.after(s, values, state) for s in self.step.state)
            residual = [(y - self.composed(x, later, w)).at_weight(w) for x, y in zip(state, new, strict=True)]
            for x, correction in zip(state, applied(inverse, residual), strict=True):
                x.add(correction, self.one, 0, 0, w)
        return state

    def shifted(self, values: list[Expansion], top: int) -> dict[int, Expansion]:
        """Place -> its value one step later, where the exact solution starts anew from what the scheme reports."""
        found = {k: values[self.step.unknowns.index(s)] for k, s in enumerate(END[:2])}
        for m in range(top - 1):
            g, both = Expansion(), Expansion()
            for k in range(top - 1 - m):
                g.add(Expansion({(0, 0, of_g(m + k)): self.one}), reciprocal_factorial(k) * self.one, 0, 0, top)
                both.add(load(m + k, self.one, self.damped), reciprocal_factorial(k) * self.one, 0, 0, top)
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
        values = self.equations.advanced(self.state, self.top)
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
                y.add(Expansion(difference.at_weight(w)), self.one, 0, 0, w)
            factor = ratio ** -kind_of(symbol)
            found[earlier(symbol)] = Expansion({key: c * factor for key, c in y.scaled(ratio).terms.items()})
        return {symbol: value for symbol, value in found.items() if symbol not in held}

    def halved(self) -> dict[Symbol, Expansion]:
        """u, h*v at t_n + h after two steps of h/2 from the same state; none where the state holds earlier steps."""
        if any(map(steps_back, self.step.state)):
            return {}
        half, two = self.one * QQ(1, 2), self.one * 2
        # from here on in powers of h/2
        state = values = [
            Expansion().plus(x.scaled(two), half ** kind_of(s))
            for s, x in zip(self.step.state, self.state, strict=True)
        ]
        for later in range(2):
            values = self.equations.advanced(state, self.top, later)
            state = [self.equations.after(s, values, state) for s in self.step.state]
        ends = (values[self.step.unknowns.index(s)] for s in END[:2])
        return {
            s: Expansion().plus(e.scaled(half), two**k) for k, (s, e) in enumerate(zip(HALVED[:2], ends, strict=True))
        }
