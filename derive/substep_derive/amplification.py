"""Scheme -> Amplification: what one step does to a linear oscillator, exactly.

The oscillator is a + 2*xi*omega*v + omega^2*u = f(t). In the state (u, h*v, h^2*a) the step length
drops out, so h = 1 and omega = Omega from the start. Relations and balances together are one linear
system, the pencil  new*X + old*x0 + load*f = 0, whether the step is composite or not.
"""

from dataclasses import dataclass

from sympy import Dummy, Expr, Integer, Matrix, Poly, Symbol, cancel, default_sort_key, eye, zeros

from . import algebra
from .scheme import DeclarationError, Scheme
from .symbols import K0, C, M, N, N_discrete, Omega, f, h, knot, knot_of, lam, lattice, mu, xi

LINEAR_OSCILLATOR = {h: Integer(1), M: Integer(1), C: 2 * xi * Omega, K0: Omega**2}


def on_oscillator(force: Expr) -> Expr:
    """The internal force of the linear oscillator; its discrete gradient is the mean."""
    return force.replace(N, lambda u: Omega**2 * u).replace(N_discrete, lambda u, w: Omega**2 * (u + w) / 2)


@dataclass(frozen=True)
class Pencil:
    """new*X + old*x0 + load*f = 0 for the unknowns X, the old state x0 and h^2 f(t_n + stencil*h)."""

    unknowns: tuple[Symbol, ...]
    state: tuple[Symbol, ...]
    stencil: tuple[Expr, ...]
    new: Matrix
    old: Matrix
    load: Matrix

    @classmethod
    def of(cls, scheme: Scheme) -> "Pencil":
        """Raises DeclarationError for a relation that is not linear in the knots' symbols."""
        unknowns, state = scheme.unknowns, scheme.state
        loads = set().union(*(b.load.atoms(f) for b in scheme.balances))
        if knot(1).a not in unknowns:  # a then follows from the equation of motion at t_n + h
            loads.add(f(Integer(1)))
        typical = {p.symbol: p.default for p in scheme.parameters}
        loads = sorted(loads, key=lambda load: (load.args[0].subs(typical), default_sort_key(load)))
        names = [Dummy(str(load)) for load in loads]
        equations = [symbol - expression for symbol, expression in scheme.relations.items()]
        equations += [
            M * b.inertia + C * b.damping + on_oscillator(b.force) - b.load.subs(dict(zip(loads, names, strict=True)))
            for b in scheme.balances
        ]
        columns = Matrix([*unknowns, *state, *names])
        system = Matrix([e.subs(LINEAR_OSCILLATOR) for e in equations])
        jacobian = system.jacobian(columns)
        if cancelled := [e for e in (system - jacobian * columns).applyfunc(cancel) if e != 0]:
            raise DeclarationError(f"{scheme.name}: not linear in the knots' u, v, a: {cancelled[0]}")
        n, m = len(unknowns), len(state)
        stencil = tuple(load.args[0] for load in loads)
        return cls(unknowns, state, stencil, jacobian[:, :n], jacobian[:, n : n + m], jacobian[:, n + m :])

    def successor(self, symbol: Symbol) -> Symbol:
        """The symbol whose value the state's symbol takes one step later."""
        kind, label = knot_of(symbol) or ("", "")
        return Symbol(f"{kind}_{(lattice(label) or 0) + 1}")

    def characteristic(self) -> Expr:
        """det(new, old) with x1 = lambda*x0: a polynomial in lambda, up to a factor free of it."""
        n, m = len(self.unknowns), len(self.state)
        system = self.new.row_join(self.old)
        for j, symbol in enumerate(self.state):
            row = zeros(1, n + m)
            after = self.successor(symbol)
            row[0, n + j] = lam
            row[0, self.unknowns.index(after) if after in self.unknowns else n + self.state.index(after)] = -1
            system = system.col_join(row)
        return algebra.determinant(system)


@dataclass(frozen=True)
class Amplification:
    """x1 = A x0 + B h^2 f(t_n + stencil*h), with A = N/den and B = load_N/den.

    N: (m, m) polynomials, den: their common denominator; load_N: (m, K). outputs_N, outputs_load_N:
    the rows (3, m), (3, K) of u1, h*v1, h^2*a1, where a1 is the scheme's own or, if it has none,
    follows from the equation of motion. charpoly: den * det((1 + mu) I - A), a polynomial in mu.
    """

    scheme: Scheme
    stencil: tuple[Expr, ...]
    N: Matrix
    load_N: Matrix
    outputs_N: Matrix
    outputs_load_N: Matrix
    den: Expr
    charpoly: Poly

    @classmethod
    def of(cls, scheme: Scheme) -> "Amplification":
        """Raises DeclarationError if the relations and balances do not determine the new state."""
        pencil = Pencil.of(scheme)
        m = len(pencil.state)
        try:
            solution, den = algebra.solve(pencil.new, -pencil.old.row_join(pencil.load))
        except algebra.SingularMatrix as error:
            raise DeclarationError(
                f"{scheme.name}: the relations and balances are dependent, so that "
                f"{', '.join(map(str, pencil.unknowns))} are not determined; check each for a copy of another"
            ) from error
        rows = {symbol: solution[i, :] for i, symbol in enumerate(pencil.unknowns)}
        for j, symbol in enumerate(pencil.state):
            rows.setdefault(symbol, den * eye(solution.cols)[j, :])
        u1, v1, a1 = knot(1)
        if a1 not in rows:
            load = zeros(1, solution.cols)
            load[0, m + pencil.stencil.index(Integer(1))] = den
            rows[a1] = (load - 2 * xi * Omega * rows[v1] - Omega**2 * rows[u1]).applyfunc(cancel)
        missing = [s for s in (u1, v1, *map(pencil.successor, pencil.state)) if s not in rows]
        if missing:
            raise DeclarationError(
                f"{scheme.name}: the step reads {', '.join(map(str, pencil.state))} "
                f"but no relation defines {missing[0]} for the next one"
            )
        step = Matrix.vstack(*(rows[pencil.successor(s)] for s in pencil.state))
        outputs = Matrix.vstack(rows[u1], rows[v1], rows[a1])
        charpoly = algebra.primitive(pencil.characteristic().subs(lam, 1 + mu), mu)
        typical = {p.symbol: p.default for p in scheme.parameters} | {Omega: 0}
        if den.subs(typical) < 0:
            den, step, outputs = -den, -step, -outputs
        if charpoly.LC().subs(typical) < 0:
            charpoly = -charpoly
        return cls(scheme, pencil.stencil, step[:, :m], step[:, m:], outputs[:, :m], outputs[:, m:], den, charpoly)
