"""For the oracle: the step of a scheme that nobody has written there, as its declaration has it, number by number.

It shares the declaration with the derivation, and nothing else: see declared_steps.py. That the declaration is the
paper's, what the paper states has to show, which test_published.py holds against what is derived.
"""

from typing import Any

from declared_steps import Marcher, System
from lines import Row, solve
from substep_derive.declare.catalogue import find
from substep_derive.declare.symbols import NAMED, kind_of, knot_of, state_label, steps_back
from sympy import Symbol


def parameters_of(name: str) -> str:
    return " ".join(p.name for p in find(name).parameters)


def state_of(name: str) -> str:
    return " ".join(map(state_label, find(name).state))


def starter_of(name: str) -> tuple[int, str]:
    """How many steps of which scheme come before the first own one."""
    scheme = find(name)
    starter = scheme.start_scheme
    return (0, name) if starter is None else (max(int(steps_back(s)) for s in scheme.state), starter.name)


class DeclaredSteps:
    """Steps on any system, for `nonlinear_oracle.Run`."""

    s: Any
    rows: list[Any]
    now: Any
    parameters: dict[str, Any]
    auxiliary: dict[str, Any]
    marcher: Marcher | None = None

    def as_declared(self, name: str) -> Row:
        """The row at t + h; what the scheme carries besides is renewed."""
        (s, h, t, u0, *_), scheme = self.now(), find(name)
        assert all(steps_back(symbol).denominator == 1 for symbol in scheme.state), "rows stand at whole steps"
        if self.marcher is None:
            by_mass = System(
                lambda u: solve(s.mass, s.force(u)),
                lambda u: solve(s.mass, s.tangent(u)),
                lambda u, w: solve(s.mass, s.discrete_gradient(u, w)),
                solve(s.mass, s.damping),
                lambda t: solve(s.mass, s.load(t) + 0 * u0),
            )
            values = {p.symbol: self.parameters[p.name] for p in scheme.parameters}
            self.marcher = Marcher(scheme, values, by_mass, h, self.rows[0].u)
        begun = {} if scheme.start_scheme else self.marcher.started(*self.rows[0][:2])
        found = self.marcher.step({symbol: self._held(symbol, begun) for symbol in scheme.state}, t)
        after = self.marcher.after(found)
        self.auxiliary |= {_name(symbol): x for symbol, x in after.items() if _name(symbol)}
        now = {kind_of(symbol): x for symbol, x in after.items() if not (_name(symbol) or steps_back(symbol))}
        return Row(*(now.get(kind, x) for kind, x in enumerate(self.marcher.reported(found, t))))

    def _held(self, symbol: Symbol, begun: dict[Symbol, Any]) -> Any:
        """Of a state its value, or that of its start where there is no row yet."""
        lag = int(steps_back(symbol))
        if _name(symbol):
            return self.auxiliary.get(_name(symbol), begun.get(symbol))
        return self.rows[-1 - lag][kind_of(symbol)] if lag < len(self.rows) else begun[symbol]


def _name(symbol: Symbol) -> str:
    """Of an auxiliary state the name, else nothing."""
    return (knot_of(symbol) or ("", ""))[1].partition(NAMED)[2]
