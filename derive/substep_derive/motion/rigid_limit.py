"""Scheme -> its energy change per step on the stiff pendulum, in closed form.

An elastic bar (length L, mass m at its end, no gravity, no damping) rotates about its pivot at speed V. As its axial
stiffness EA -> infinity at a fixed step h, a balance at a knot becomes a projection: the relations give
u = p + c_u z with p known, z is parallel to u, and |u| = L; hence u = L p/|p| and z = (u - p)/c_u.

In units of L and V the plane is the complex plane, and u, h*v, h^2*a of the start are 1, i tau, (i tau)^2 with
tau = h V/L. All is then a power series in s = i tau with real coefficients: conjugation is s -> -s, and p/|p| is
p(s)/sqrt(p(s) p(-s)). The kinetic energy E is even in tau; the strain energy, of order 1/EA, vanishes.
"""

from collections.abc import Callable
from math import factorial
from typing import Any

from sympy import QQ, Expr, Matrix, Rational, Symbol, cancel, eye, factor, factor_list, fraction, real_roots

from ..algebra import rational
from ..algebra.power_series import PowerSeries
from ..declare.errors import DeclarationError, InconsistentScheme
from ..declare.parameter import Parameter
from ..declare.scheme import Scheme
from ..declare.symbols import K0, C, M, N, h, knot, knot_of, lattice
from ..step.step import Step
from .effective import effective_systems

u0, v0, a0 = start = knot(0)
u1, v1, a1 = end = knot(1)


def energy_change(scheme: Scheme, order: int = 6) -> dict[int, Expr]:
    """(E1 - E0)/E0 of the first step from steady rotation: power of tau = h V/L -> coefficient, up to tau^order.

    All that the step reads lies on the exact rotation, a0 = -V^2/L towards the pivot. Coefficients are factored,
    those that vanish left out. Later steps differ at the same power of tau: `settled_energy_change`.

    Raises DeclarationError if the balances do not become projections, InconsistentScheme where u does not tend to u_0.
    """
    step = _RigidStep(scheme)
    return _change(_energy(step.first(order + 2)[v1]), step.power(0, order + 1))


def momentum_change(scheme: Scheme, order: int = 6) -> dict[int, Expr]:
    """The angular momentum's relative change in the first step, given and refused as by `energy_change`."""
    step = _RigidStep(scheme)
    after = step.first(order + 2)
    return _change(PowerSeries((after[u1].alternated * after[v1]).c[1:]), step.power(0, order + 1))


def settled_energy_change(scheme: Scheme, order: int = 4) -> dict[int, Expr]:
    """(E1 - E0)/E0 of each step after the influence of the start has died out, given as by `energy_change`.

    Then v has a radial part, and a differs from that of the exact rotation. Both are power series in
    tau = h v_tangential/L that a step reproduces, and they are found here order by order. From any start the solution
    tends to them if radial errors die out (rho_infinity < 1). The change is that of every step, at that step's tau:
    from c tau^4 follows E = E0 (1 - 2 c tau0^4 n)^(-1/2) after n steps.

    Raises DeclarationError as `energy_change` does and for a state other than u_0, v_0, a_0; ValueError if radial
    errors have an eigenvalue 1.
    """
    step = _RigidStep(scheme)
    if not {u0, v0} <= set(scheme.state) <= set(start) or scheme.report:
        raise DeclarationError(
            f"{scheme.name}: expected a one-step scheme whose state u_0, v_0 and perhaps a_0 is also what it reports, "
            f"got the state {', '.join(map(str, scheme.state))}; ask for energy_change, the first step's"
        )
    carried = {old: new for old, new in ((v0, v1), (a0, a1)) if old in scheme.state}
    try:
        numerators, den = rational.solve(eye(len(carried)) - step.radial(carried), eye(len(carried)))
    except rational.SingularMatrix as error:
        raise ValueError(f"{scheme.name}: a radial error is carried from step to step, nothing settles") from error

    def relative() -> dict[Symbol, PowerSeries]:
        """The new v and a as seen from the new direction of the bar."""
        after = step(settled)
        return {old: after[new] * after[u1].alternated for old, new in carried.items()}

    settled = {symbol: step.power(k, 3) for k, symbol in enumerate(start) if symbol in scheme.state}
    for n in range(2, order + 2, 2):  # radial parts are even in s; tangentially v is s itself and a is 0
        settled = {symbol: step.fit(x, n + 1) for symbol, x in settled.items()}
        found = relative()
        tangential = PowerSeries(c if k % 2 else step.zero for k, c in enumerate(found[v0].c))
        defect = [(found[symbol].c[n] - settled[symbol].at(tangential).c[n]).as_expr() for symbol in carried]
        for symbol, c in zip(carried, numerators * Matrix(defect) / den, strict=True):
            settled[symbol].c[n] += step.number(c)
    settled = {symbol: step.fit(x, order + 2) for symbol, x in settled.items()}
    return _change(_energy(relative()[v0]), _energy(settled[v0]))


def sign_changes(coefficient: Expr, parameter: Parameter) -> list[Expr]:
    """The zeros inside the parameter's interval at which a coefficient changes sign, exact, in ascending order.

    Raises ValueError if the coefficient has another parameter.
    """
    if others := coefficient.free_symbols - {parameter.symbol}:
        raise ValueError(
            f"expected a function of {parameter.name} alone, got {', '.join(sorted(map(str, others)))} in it; "
            "fix the scheme's other parameters before"
        )
    factors = factor_list(fraction(cancel(coefficient))[0])[1]
    roots = [root for base, power in factors if power % 2 for root in real_roots(base)]
    return sorted(root for root in roots if parameter.domain.start < root < parameter.domain.end)


class _RigidStep:
    """One step of a scheme, each balance a projection, for u, h*v and h^2*a as series in s."""

    def __init__(self, scheme: Scheme) -> None:
        self.scheme = scheme
        # with h, so that it is never Q itself
        self.field = rational.RationalFunctions([h, *scheme.values], scheme.constant)
        self.one, self.zero = self.field.domain.one, self.field.domain.zero
        lowered = Step.of(scheme)
        z = lowered.accelerations
        at = [knot((knot_of(symbol) or ("", ""))[1]) for symbol in z]
        for k, balance, system in zip(at, scheme.balances, effective_systems(scheme), strict=True):
            if (balance.inertia, balance.force) != (k.a, N(k.u)) or system.explicit or system.beside:
                raise DeclarationError(
                    f"{scheme.name}: expected each balance at one knot, a_k with N(u_k), u_k depending on it alone, "
                    f"got {balance.inertia} with {balance.force}, where u gains {system.c_u} times the acceleration. "
                    "Collocate at a knot, and give its displacement by an implicit relation"
                )
        if end not in at:
            raise DeclarationError(
                f"{scheme.name}: expected a balance at u_1, got one at {', '.join(str(k.u) for k in at)} only, so that "
                "the bar is strained without limit at t_n + h; collocate at knot 1 too"
            )
        if material := {M, C, K0} & {s for e in scheme.relations.values() for s in e.free_symbols}:
            raise DeclarationError(
                f"{scheme.name}: expected relations in u, v, a and h, got {', '.join(sorted(map(str, material)))} in "
                "them, which have no rigid limit; write the relations without the matrices"
            )
        # u, h*v, h^2*a have one dimension, so that a relation between them is the one of u, v, a at h = 1
        self.solved = {symbol: e.subs(h, 1) for symbol, e in lowered.solved.items()}
        self.balances = [(k.u, k.a) for k in at]

    def __call__(
        self, state: dict[Symbol, PowerSeries], project: Callable[[PowerSeries], PowerSeries] | None = None
    ) -> dict[Symbol, PowerSeries]:
        """The step's symbols from those of its state; project: what takes the place of p/|p| for small errors."""
        known = dict(state)
        for u, z in self.balances:
            p = self._value(self.solved[u], known)
            c_u = self.number(self.solved[u].diff(z))
            known[z] = ((project or self._on_circle)(p) - p).scaled(self.one / c_u)
        return known | {symbol: self._value(e, known) for symbol, e in self.solved.items()}

    def first(self, terms: int) -> dict[Symbol, PowerSeries]:
        """The step from the exact rotation, e^(t s), s e^(t s), s^2 e^(t s) at t_n + t*h; u, v, a as reported."""
        state: dict[Symbol, PowerSeries] = {}
        for symbol in self.scheme.state:
            kind, label = knot_of(symbol) or ("", "")
            t = Rational(lattice(label))
            rotation = [self.one * QQ(t.p, t.q) ** k / factorial(k) for k in range(terms)]
            state[symbol] = self.power("uva".index(kind), terms) * PowerSeries(rotation)
        after = self(state)
        return after | {symbol: self._value(e, after) for symbol, e in self.scheme.report.items()}

    def radial(self, carried: dict[Symbol, Symbol]) -> Matrix:
        """The matrix by which a step multiplies small radial errors of v and a; u has none after a projection."""
        nothing, one = PowerSeries([self.zero]), PowerSeries([self.one])
        exact = dict.fromkeys(self.scheme.state, nothing)
        columns = [self(exact | {old: one}, lambda _: nothing) for old in carried]
        return Matrix([[column[new].c[0].as_expr() for column in columns] for new in carried.values()])

    def number(self, value: Expr) -> Any:
        """A rational function of the parameters, as a coefficient of a series."""
        return self.field.number(cancel(value))

    def power(self, k: int, terms: int) -> PowerSeries:
        """The series s^k."""
        return self.fit(PowerSeries([self.zero] * k + [self.one]), terms)

    def fit(self, series: PowerSeries, terms: int) -> PowerSeries:
        """The series cut, or filled up with zeros, to this number of coefficients."""
        return PowerSeries((series.c + [self.zero] * terms)[:terms])

    def _value(self, expression: Expr, known: dict[Symbol, PowerSeries]) -> PowerSeries:
        total = PowerSeries([self.zero] * len(known[u0]))
        for symbol in known.keys() & expression.free_symbols:
            total = total + known[symbol].scaled(self.number(expression.diff(symbol)))
        return total

    def _on_circle(self, p: PowerSeries) -> PowerSeries:
        if p.c[0] != 1:
            raise InconsistentScheme(f"{self.scheme.name} is not consistent: u does not tend to u_0 as h -> 0")
        return p * (p * p.alternated).to_the(QQ(-1, 2))


def _energy(v: PowerSeries) -> PowerSeries:
    """The kinetic energy in units of m V^2/2: |h*v|^2/tau^2."""
    shorter = PowerSeries(v.c[1:])
    return shorter * shorter.alternated


def _change(after: PowerSeries, before: PowerSeries) -> dict[int, Expr]:
    """after/before - 1 as power of tau -> coefficient; both series are even in s, and s^2 = -tau^2."""
    ratio = (after * before.to_the(QQ(-1))).c
    found = {k: factor((ratio[k] * (-1) ** (k // 2)).as_expr()) for k in range(2, len(ratio), 2)}
    return {k: coefficient for k, coefficient in found.items() if coefficient != 0}
