"""Any declaration, marched number by number on systems of any size, in double or in mpmath's precision.

It shares nothing with the derivation but the declaration. All relations and balances are one linear system in the new
symbols once the forces are known. The forces are found by Newton's method with the tangent at the start, which on a
linear system is exact at once.
"""

import numbers
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import mpmath
import numpy as np
from substep_derive import Scheme
from substep_derive.declare.symbols import K0, C, K_t, M, N, N_discrete, f, h, knot, knot_of, lattice
from sympy import Dummy, Expr, Symbol, fraction, lambdify, together

Array = Any  # of floats, or of mpmath's numbers with dtype object
u0, v0, a0 = KNOWN = knot(0)


def later(symbol: Symbol) -> Symbol:
    """The symbol of a state a step later: u_0 of u_-1, and v_1:rate of v_0:rate."""
    number, *name = symbol.name[2:].split(":")
    return Symbol(":".join([f"{symbol.name[0]}_{Fraction(number) + 1}", *name]))


@dataclass(frozen=True)
class System:
    """u'' = f(t) - C u' - N(u), with the derivative of N, and a discrete gradient of its potential."""

    force: Callable[[Array], Array]
    tangent: Callable[[Array], Array]
    gradient: Callable[[Array, Array], Array]
    damping: Array
    load: Callable[[Any], Array]

    def acceleration(self, u: Array, v: Array, t: Any) -> Array:
        return self.load(t) - self.damping @ v - self.force(u)


def oscillator(damping: Any, stiffness: Any, cubic: Any = 0, load: Callable[[Any], Any] = lambda t: 0) -> System:
    """u'' + damping u' + stiffness u + cubic u^3 = load(t), in mpmath's precision; the gradient is the mean force."""

    def force(u: Array) -> Array:
        return stiffness * u + cubic * u**3

    return System(
        force,
        lambda u: np.diag(stiffness + 3 * cubic * u**2),
        lambda u, w: (force(u) + force(w)) / 2,
        vector(damping)[:, None],
        lambda t: vector(load(t)),
    )


def vector(*x: Any) -> Array:
    """An array of mpmath's numbers."""
    return np.array([exact(value) for value in x], dtype=object)


def exact(value: Any) -> Any:
    """A number, a fraction or SymPy's too, in mpmath's precision."""
    if isinstance(value, numbers.Rational):
        return mpmath.mpf(int(value.numerator)) / int(value.denominator)
    return mpmath.mpf(value)


@dataclass(frozen=True)
class Linear:
    """A sum of coefficient * symbol or atom; parts: factors of 1, C, K0, K_t in each numerator and denominator."""

    atoms: tuple[Expr, ...]
    parts: Callable[..., Any]
    arguments: tuple[tuple["Linear", ...], ...]


def constants(scheme: Scheme, mp: Any) -> dict[Symbol, Any]:
    """The value of the scheme's constant, if it has one: the root of its equation in its interval."""
    if scheme.constant is None:
        return {}
    low, high = (mp.mpf(int(end.p)) / int(end.q) for end in scheme.constant.number.interval)
    roots = mpmath.polyroots(scheme.constant.number.coefficients, maxsteps=500, extraprec=200)
    (found,) = [r.real for r in roots if abs(r.imag) < 1e-9 * abs(r) and low <= r.real <= high]
    return {scheme.constant: mp.mpf(found)}


@cache
def linear(e: Expr, names: tuple[Symbol, ...], modules: str) -> Linear:
    tangent = Symbol("tangent")
    unit: Any = e.subs(M, 1)
    e = unit.replace(K_t, lambda where: tangent)  # taken at u_0, the only place where declarations take it
    marks = {atom: Dummy() for atom in sorted(e.atoms(N, N_discrete, f), key=str)}
    e = e.subs(marks)
    marks |= {s: s for s in sorted(e.free_symbols, key=str) if knot_of(s)}
    parts = []
    for mark in marks.values():
        for part in fraction(together(e.diff(mark))):
            rest = part.subs({C: 0, K0: 0, tangent: 0})
            parts.append([rest, *(part.expand().coeff(x) for x in (C, K0, tangent))])
    arguments = tuple(
        tuple(linear(a, names, modules) for a in atom.args) if isinstance(atom, N | N_discrete) else ()
        for atom in marks
    )
    return Linear(tuple(marks), lambdify([h, *names], parts, modules=modules), arguments)


def product(matrix: Array) -> Callable[[Array], Array]:
    """x -> matrix @ x; in mpmath's precision without the matrix's zeros, and each sum rounded once."""
    if matrix.dtype != object:
        return lambda x: matrix @ x
    rows = [[(c, j) for j, c in enumerate(row) if c] for row in matrix]
    return lambda x: np.array([mpmath.fdot((c, x[j]) for c, j in row) for row in rows], dtype=object)


class Marcher:
    """Steps of one length of a scheme on a system, from u_0 at t = 0, of which K0 is the tangent."""

    def __init__(self, scheme: Scheme, values: Mapping[Symbol, Any], system: System, step: Any, start: Array) -> None:
        self.scheme, self.system, self.h, self.d = scheme, system, step, len(start)
        self.exact = start.dtype == object
        self.modules = "mpmath" if self.exact else "math"
        values = {**constants(scheme, mpmath.mp if self.exact else mpmath.fp), **values}
        self.names, self.values = tuple(values), [step, *values.values()]
        self.eye = np.array([[step / step if i == j else 0 * step for j in range(self.d)] for i in range(self.d)])
        self.matrices = [self.eye, system.damping, system.tangent(start), system.tangent(start)]
        equations = [symbol - e for symbol, e in scheme.relations.items()]
        equations += [M * b.inertia + C * b.damping + b.force - b.load for b in scheme.balances]
        self.state, self.unknowns = scheme.state, scheme.unknowns
        self.when: dict[Expr, Any] = {}
        forms = [self.form(e) for e in equations]
        self.forces = list({t[0]: t for terms in forms for t in terms if t[2]}.values())
        self.loads = list({t[0]: t for terms in forms for t in terms if isinstance(t[0], f)}.values())
        columns = [*self.unknowns, *self.state, *(t[0] for t in self.forces), *(t[0] for t in self.loads)]
        matrix, known = self.blocks(forms, columns, len(self.unknowns))
        known = -(self.inverted(matrix) @ known)  # new symbols from the state, forces and loads
        k = len(self.state) * self.d
        self.of_force = slice(k, k + len(self.forces) * self.d)
        where = [
            new @ known + old for new, old in (self.blocks(t[2], columns, len(self.unknowns)) for t in self.forces)
        ]
        means = [w.reshape(-1, self.d, w.shape[1]).mean(axis=0)[:, self.of_force] for w in where]
        chord = np.eye(len(self.forces) * self.d, dtype=int) * self.eye[0, 0]
        chord = chord - np.concatenate([self.matrices[3] @ mean for mean in means])
        self.correction = product(self.inverted(chord))  # of forces, by those at the places that they lead to
        self.known, self.where = product(known), [product(w) for w in where]

    def blocks(self, forms: Sequence[Any], columns: Sequence[Any], split: int) -> tuple[Array, Array]:
        """The forms as a matrix, its first `split` columns and the others."""
        d = self.d
        matrix = np.array([[0 * self.h] * (len(columns) * d) for _ in range(len(forms) * d)])
        for i, terms in enumerate(forms):
            for atom, c, _ in terms:
                j = columns.index(atom)
                matrix[i * d : i * d + d, j * d : j * d + d] += c
        return matrix[:, : split * d], matrix[:, split * d :]

    def inverted(self, matrix: Array) -> Array:
        if not self.exact:
            return np.linalg.inv(matrix)
        return np.array(mpmath.inverse(mpmath.matrix(matrix.tolist())).tolist(), dtype=object)

    def form(self, e: Expr) -> list[tuple[Expr, Array, list[Any]]]:
        """(symbol or atom, matrix, forms of its arguments) of each term."""
        return self._evaluated(linear(e, self.names, self.modules))

    def _evaluated(self, e: Linear) -> list[tuple[Expr, Array, list[Any]]]:
        values, found = e.parts(*self.values), []
        for k, (atom, arguments) in enumerate(zip(e.atoms, e.arguments, strict=True)):
            over, under = (
                sum((c * m for c, m in zip(part, self.matrices, strict=True) if c), 0 * self.eye)
                for part in values[2 * k : 2 * k + 2]
            )
            found.append((atom, self.inverted(under) @ over, [self._evaluated(a) for a in arguments]))
        return found

    def value(self, terms: Any, x: Mapping[Symbol, Array], t: Any) -> Array:
        """A form's value."""
        total = np.array([0 * self.h] * self.d)
        for atom, c, arguments in terms:
            if isinstance(atom, f):
                own = self.system.load(t + self.h * self.instant(atom))
            elif arguments:
                where = [self.value(a, x, t) for a in arguments]
                own = self.system.force(*where) if isinstance(atom, N) else self.system.gradient(*where)
            else:
                own = x[atom]
            total = total + c @ own
        return total

    def instant(self, load: Expr) -> Any:
        """When in the step a load is taken, as a fraction of the step."""
        if load not in self.when:
            self.when[load] = lambdify(list(self.names), load.args[0], modules=self.modules)(*self.values[1:])
        return self.when[load]

    def step(self, state: Mapping[Symbol, Array], t: Any) -> dict[Symbol, Array]:
        """All symbols after a step that begins at t."""
        loads = [self.value([(t_[0], self.eye, [])], {}, t) for t_ in self.loads]
        zero = [0 * self.eye[0]] * len(self.forces)
        given = np.concatenate([*(state[s] for s in self.state), *zero, *loads])
        small, last = (mpmath.mpf(10) ** (5 - mpmath.mp.dps) if self.exact else 1e-15), None
        for _ in range(300):
            places = [where(given).reshape(-1, self.d) for where in self.where]
            own = [
                self.system.force(*where) if isinstance(atom, N) else self.system.gradient(*where)
                for (atom, _, _), where in zip(self.forces, places, strict=True)
            ]
            change = self.correction(np.concatenate(own) - given[self.of_force])
            given[self.of_force] += change
            off, size = abs(change).max(), abs(given[self.of_force]).max()
            if off <= small * size or (last is not None and last <= off <= 1e5 * small * size):
                found = self.known(given).reshape(-1, self.d)
                return {**state, **dict(zip(self.unknowns, found, strict=True))}
            last = off
        raise ArithmeticError(f"{self.scheme.name}: Newton's method does not converge at h = {self.h}")

    def reported(self, x: Mapping[Symbol, Array], t: Any) -> list[Array]:
        """u, v, a at the end of a step that began at t."""
        rows: list[Array] = []
        for symbol in knot(1):
            e = self.scheme.report.get(symbol, symbol)
            if e == symbol and symbol not in x:
                rows.append(self.system.acceleration(rows[0], rows[1], t + self.h))
            else:
                rows.append(x[e] if e in x else self.value(self.form(e), x, t))
        return rows

    def started(self, u: Array, v: Array) -> dict[Symbol, Array]:
        """The state of a scheme that starts itself at t = 0, from consistent u, v, a."""
        given = dict(zip(KNOWN, (u, v, self.system.acceleration(u, v, 0 * self.h)), strict=True))
        start: Any = self.scheme.start
        return {s: self.value(self.form(start.get(s, s)), given, 0 * self.h) for s in self.state}

    def after(self, x: Mapping[Symbol, Array]) -> dict[Symbol, Array]:
        """The state of the next step."""
        return {s: x[later(s)] for s in self.state}


def march(
    scheme: Scheme, values: Mapping[Symbol, Any], system: System, step: Any, n: int, u: Array, v: Array,
) -> list[list[Array]]:  # fmt: skip
    """Rows (u, v, a) at 0, h, ..., n h."""
    rows = [[u, v, system.acceleration(u, v, 0 * step)]]
    marcher = Marcher(scheme, values, system, step, u)
    starter = scheme.start_scheme
    if starter is not None:
        lag = max(-int(lattice(knot_of(s)[1])) for s in scheme.state)  # type: ignore[index, arg-type]
        rows = march(starter, {}, system, step, lag, u, v)
        state = {s: rows[lag + int(lattice(knot_of(s)[1]))]["uva".index(s.name[0])] for s in scheme.state}  # type: ignore[index, arg-type]
    else:
        state = marcher.started(u, v)
    for i in range(len(rows) - 1, n):
        x = marcher.step(state, i * step)
        rows.append(marcher.reported(x, i * step))
        state = marcher.after(x)
    return rows


def amplification(scheme: Scheme, values: Mapping[Symbol, Any], system: System) -> Array:
    """The matrix of one step of h = 1 on a linear system without load, column by column from unit states."""
    d, zero = len(system.damping), 0 * system.damping[0, 0]
    marcher = Marcher(scheme, values, system, zero + 1, np.array([zero] * d))
    size, columns = range(len(scheme.state) * d), []
    for unit in np.array([[zero + int(i == j) for i in size] for j in size]):
        state = dict(zip(scheme.state, unit.reshape(-1, d), strict=True))
        columns.append(np.concatenate([*marcher.after(marcher.step(state, zero)).values()]))
    return np.array(columns).T
