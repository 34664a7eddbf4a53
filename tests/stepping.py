"""Any declaration, stepped number by number: all its equations at once, solved by Newton's method with mpmath.

It shares nothing with the derivation but the declaration itself: relations and balances are evaluated as they are
written, with no order of balances, no affine form, no state but the symbols that a step reads.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import mpmath
from declared_steps import constants
from substep_derive import Scheme
from substep_derive.declare.symbols import K0, C, K_t, M, N, N_discrete, f, h, knot, knot_of, lattice
from sympy import Dummy, Expr, Rational, Symbol, lambdify

MP = mpmath.mp.clone()
MP.dps = 40
u0, v0, a0 = knot(0)


class Problem:
    """One degree of freedom: mass, damping, internal force and its slope, load in t."""

    def __init__(
        self,
        damping: Any = 0,
        force: Callable[[Any], Any] = lambda u: u,
        slope: Callable[[Any], Any] = lambda u: 1,
        load: Callable[[Any], Any] = lambda t: 0,
    ) -> None:
        self.damping, self.force, self.slope, self.load = MP.mpf(damping), force, slope, load

    def acceleration(self, u: Any, v: Any, t: Any) -> Any:
        return self.load(t) - self.damping * v - self.force(u)


@dataclass(frozen=True)
class Parts:
    """An expression as functions of forces, loads, fixed values and symbols; reads: the symbols that occur in it."""

    body: Callable[..., Any]
    forces: list[tuple[Any, list[Callable[..., Any]]]]
    instants: list[Callable[..., Any]]
    reads: frozenset[Any]


@cache
def _parts(e: Expr, fixed: tuple[Symbol, ...], symbols: tuple[Symbol, ...]) -> Parts:
    forces = {atom: Dummy() for atom in e.atoms(N, N_discrete, K_t)}
    loads = {atom: Dummy() for atom in e.atoms(f)}
    arguments = [list(forces.values()), list(loads.values()), list(fixed), list(symbols)]
    body = lambdify(arguments, e.subs({**forces, **loads}), modules=MP)
    inner = [[lambdify([list(fixed), list(symbols)], a, modules=MP) for a in atom.args] for atom in forces]
    instants = [lambdify([list(fixed)], atom.args[0], modules=MP) for atom in loads]
    return Parts(body, list(zip(map(type, forces), inner, strict=True)), instants, frozenset(e.free_symbols))


@dataclass(frozen=True)
class Function:
    """An expression's value at t for values of its symbols."""

    of: "Stepper"
    parts: Parts

    def __call__(self, t: Any, x: Sequence[Any]) -> Any:
        problem, fixed, found = self.of.problem, list(self.of.fixed.values()), []
        for kind, args in self.parts.forces:
            u = [MP.mpf(arg(fixed, x)) for arg in args]
            if kind is K_t:
                found.append(problem.slope(u[0]))
            elif kind is N:
                found.append(problem.force(u[0]))
            else:
                raise NotImplementedError
        given = [problem.load(t + self.of.h * MP.mpf(tau(fixed))) for tau in self.parts.instants]
        return MP.mpf(self.parts.body(found, given, fixed, x))


class Stepper:
    """Steps of length `step` of a scheme with the given parameters."""

    def __init__(self, scheme: Scheme, values: Mapping[str, Any], problem: Problem, step: Any, start: Any) -> None:
        self.scheme, self.problem, self.h = scheme, problem, MP.mpf(step)
        self.values = {Symbol(name): MP.mpf(str(value)) if isinstance(value, float) else _mpf(value)
                       for name, value in values.items()}  # fmt: skip
        self.values |= constants(scheme, MP)
        self.fixed = {h: self.h, M: MP.mpf(1), C: problem.damping, K0: problem.slope(start), **self.values}
        unknown = set()
        for symbol, e in scheme.relations.items():
            unknown |= {symbol, *(s for s in e.free_symbols if knot_of(s))}
        for b in scheme.balances:
            unknown |= {s for e in (b.inertia, b.damping, b.force) for s in e.free_symbols if knot_of(s)}
        self.state = list(scheme.state)
        self.unknowns = sorted(unknown - set(self.state), key=str)
        equations = [symbol - e for symbol, e in scheme.relations.items()]
        equations += [M * b.inertia + C * b.damping + b.force - b.load for b in scheme.balances]
        self.equations = [self._function(e, [*self.state, *self.unknowns]) for e in equations]
        self.jacobian: Any = None

    def _function(self, e: Expr, symbols: Sequence[Symbol]) -> Function:
        """The expression as a function of t and of the symbols' values."""
        return Function(self, _parts(e, tuple(self.fixed), tuple(symbols)))

    def step(self, state: Sequence[Any], t: Any = 0) -> dict[Symbol, Any]:
        """All symbols after a step that begins at t."""
        x = [MP.mpf(0)] * len(self.unknowns)
        for symbol in self.state:  # a start near the solution
            for i, other in enumerate(self.unknowns):
                if other.name[0] == symbol.name[0] and symbol in (u0, v0, a0):
                    x[i] = state[self.state.index(symbol)]
        for n in range(60):
            at = [e(t, [*state, *x]) for e in self.equations]
            if self.jacobian is None or n >= 3:  # that of the last step does not do: the problem is not linear
                self.jacobian = self._jacobian(state, x, t, at)
            change = MP.lu_solve(self.jacobian, MP.matrix(at))
            x = [value - d for value, d in zip(x, change, strict=True)]
            if max(abs(d) for d in change) <= MP.mpf(10) ** -25 * (1 + max(map(abs, x))):
                break
        else:
            raise ArithmeticError("Newton's method does not converge")
        return dict(zip([*self.state, *self.unknowns], [*state, *x], strict=True))

    def _jacobian(self, state: Sequence[Any], x: list[Any], t: Any, at: list[Any]) -> Any:
        """By differences, of which those of what an equation does not read are left out."""
        n = len(self.unknowns)
        J = MP.matrix(n, n)
        for j, symbol in enumerate(self.unknowns):
            small = MP.mpf(10) ** -18 * (1 + abs(x[j]))
            moved = [*state, *x[:j], x[j] + small, *x[j + 1 :]]
            for i, e in enumerate(self.equations):
                if symbol in e.parts.reads:
                    J[i, j] = (e(t, moved) - at[i]) / small
        return J

    def carried(self, after: Mapping[Symbol, Any]) -> list[Any]:
        """The state of the next step."""
        found = []
        for symbol in self.state:
            kind, label = knot_of(symbol) or ("", "")
            found.append(after[Symbol(f"{kind}_{(lattice(label) or 0) + 1}")])
        return found

    def reported(self, after: Mapping[Symbol, Any], t: Any) -> tuple[Any, Any, Any]:
        """u, v, a at the end of a step that began at t."""
        values = []
        for kind, symbol in zip("uva", knot(1), strict=True):
            e = self.scheme.report.get(symbol, symbol)
            if kind == "a" and e == symbol and symbol not in after:
                values.append(self.problem.acceleration(values[0], values[1], t + self.h))
            else:
                values.append(self._function(e, list(after))(t, list(after.values())))
        return tuple(values)


def history(
    scheme: Scheme, values: Mapping[str, Any], problem: Problem, step: Any, n: int, start: Sequence[Any]
) -> Any:
    """u, v, a (n + 1 rows) from given u_0, v_0, a_0."""
    rows = [tuple(MP.mpf(x) for x in start)]
    stepper = Stepper(scheme, values, problem, step, rows[0][0])
    if isinstance(scheme.start, Scheme):
        defaults: dict[Symbol, Any] = {}
        for p in scheme.start.parameters:
            defaults[p.symbol] = p.default.subs(defaults)
        lag = max(int(-(lattice((knot_of(s) or ("", "0"))[1]) or 0)) for s in scheme.state)
        rows = history(scheme.start, {s.name: x for s, x in defaults.items()}, problem, step, min(lag, n), start)
        at = [knot_of(s) or ("u", "0") for s in scheme.state]
        state = [rows[lag + int(lattice(label) or 0)]["uva".index(kind)] for kind, label in at] if lag <= n else []
    else:
        given = dict(zip((u0, v0, a0), rows[0], strict=True))
        state = [
            stepper._function(scheme.start.get(s, s), [u0, v0, a0])(0, list(given.values())) for s in stepper.state
        ]
    for i in range(len(rows) - 1, n):
        t = i * stepper.h
        after = stepper.step(state, t)
        rows.append(stepper.reported(after, t))
        state = stepper.carried(after)
    return rows


def amplification(scheme: Scheme, values: Mapping[str, Any], Omega: Any, xi: Any) -> list[list[Any]]:
    """The matrix of one step of h = 1 without load, column by column from unit states."""
    square = MP.mpf(Omega) ** 2
    problem = Problem(2 * MP.mpf(xi) * MP.mpf(Omega), lambda u: square * u, lambda u: square)
    stepper = Stepper(scheme, values, problem, 1, 0)
    m = len(stepper.state)
    columns = [stepper.carried(stepper.step([MP.mpf(int(i == j)) for i in range(m)])) for j in range(m)]
    return [[columns[j][i] for j in range(m)] for i in range(m)]


def _mpf(value: Any) -> Any:
    exact = Rational(str(value))
    return MP.mpf(int(exact.p)) / MP.mpf(int(exact.q))
