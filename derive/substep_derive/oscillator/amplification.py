"""Scheme -> Amplification: what one step does to a linear oscillator, exactly.

The oscillator is a + 2*xi*omega*v + omega^2*u = f(t). In the state (u, h*v, h^2*a) the step length
drops out, so h = 1 and omega = Omega from the start. Relations and balances together are one linear
system, the pencil  new*X + old*x0 + load*f = 0, whether the step is composite or not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import cast

from sympy import Dummy, Expr, Integer, Matrix, Poly, Symbol, eye, zeros

from ..algebra import rational
from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import K0, C, K_t, M, N, N_discrete, Omega, f, h, knot, lam, mu, successor, xi
from ..step.step import Step, instants

LINEAR_OSCILLATOR = {h: Integer(1), M: Integer(1), C: 2 * xi * Omega, K0: Omega**2}


def on_oscillator(expression: Expr) -> Expr:
    """The expression with the linear oscillator's N and K_t; its discrete gradient is the mean of two forces."""
    linear = expression.replace(N, lambda u: Omega**2 * u).replace(K_t, lambda u: Omega**2)
    return linear.replace(N_discrete, lambda u, w: Omega**2 * (u + w) / 2).subs(LINEAR_OSCILLATOR)


def coefficients(expressions: Sequence[Expr], columns: Sequence[Symbol], stencil: Sequence[Expr]) -> Matrix:
    """The matrix of linear expressions in the columns and in f(tau) for tau in the stencil."""
    loads = {f(tau): Dummy(f"f_{k}") for k, tau in enumerate(stencil)}
    system = [on_oscillator(e).subs(loads) for e in expressions]
    return rational.slopes(system, [*columns, *loads.values()])


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
        """The pencil of a scheme."""
        return _pencil(scheme)

    @classmethod
    def _derived(cls, scheme: Scheme) -> "Pencil":
        step = Step.of(scheme)
        unknowns, state, stencil = step.unknowns, step.state, step.stencil
        matrix = coefficients(step.equations, [*unknowns, *state], stencil)
        n, m = len(unknowns), len(state)
        return cls(unknowns, state, stencil, matrix[:, :n], matrix[:, n : n + m], matrix[:, n + m :])

    @cached_property
    def characteristic(self) -> Expr:
        """The pencil's determinant with x1 = lambda*x0: the characteristic polynomial times a factor free of lambda."""
        n, m = len(self.unknowns), len(self.state)
        system = self.new.row_join(self.old)
        for j, symbol in enumerate(self.state):
            row = zeros(1, n + m)
            after = successor(symbol)
            row[0, n + j] = lam
            row[0, self.unknowns.index(after) if after in self.unknowns else n + self.state.index(after)] = -1
            system = system.col_join(row)
        return rational.determinant(system)


@dataclass(frozen=True)
class Affine:
    """The map (N x + load_N h^2 f)/den of a state x and loads f, with one denominator for all entries."""

    N: Matrix
    load_N: Matrix
    den: Expr

    @classmethod
    def of(cls, rows: Matrix, columns: int, positive_at: Mapping[Symbol, Expr], over: Expr | None = None) -> "Affine":
        """From a matrix whose first `columns` columns belong to x; den is made positive at these values.

        over: the denominator of all entries, which are then numerators.
        """
        numerators, den = rational.common_denominator(rows) if over is None else rational.cancelled(rows, over)
        if den.subs(positive_at) < 0:
            numerators, den = -numerators, -den
        return cls(numerators[:, :columns], numerators[:, columns:], den)


@dataclass(frozen=True)
class Amplification:
    """x1 = A x0 + B h^2 f(t_n + stencil*h), with A = step.N/step.den and B = step.load_N/step.den.

    in_state: for u, h*v, h^2*a as reported at t_n + h, the place in the new state, or -1. outputs: for
    each -1 among these a row that gives the value from x0 and the same loads. start: the state at t = 0
    from (u_0, h*v_0, h^2*a_0) and loads at start_stencil; None where it consists of these values, or where
    another scheme marches the first steps.
    charpoly: a multiple of det((1 + mu) I - A), a polynomial in mu.
    """

    scheme: Scheme
    stencil: tuple[Expr, ...]
    step: Affine
    outputs: Affine
    in_state: tuple[int, int, int]
    start: Affine | None
    start_stencil: tuple[Expr, ...]
    charpoly: Poly

    def __repr__(self) -> str:
        m, loads = self.step.load_N.shape
        return f"<amplification of {self.scheme.name}: {m} x {m}, loads at {loads} instants>"

    @classmethod
    def of(cls, scheme: Scheme) -> "Amplification":
        """Derived once for equal schemes. Raises DeclarationError if the new state is not determined."""
        return _amplification(scheme)

    @classmethod
    def _derived(cls, scheme: Scheme) -> "Amplification":
        pencil = Pencil.of(scheme)
        m = len(pencil.state)
        at_zero = scheme.typical | {Omega: Integer(0)}
        try:
            solution, den = rational.solve(pencil.new, -pencil.old.row_join(pencil.load))
        except rational.SingularMatrix as error:
            raise DeclarationError(
                f"{scheme.name}: the relations and balances are dependent, so that "
                f"{', '.join(map(str, pencil.unknowns))} are not determined; check each for a copy of another"
            ) from error
        rows = {symbol: solution[i, :] for i, symbol in enumerate(pencil.unknowns)}
        for j, symbol in enumerate(pencil.state):
            rows.setdefault(symbol, den * eye(solution.cols)[j, :])
        after, reports = Step.of(scheme).after, Step.of(scheme).reported
        in_state = tuple(after.index(e) if e in after else -1 for e in reports)
        derived = [e for e, place in zip(reports, in_state, strict=True) if place < 0]
        load = zeros(len(pencil.stencil), m).row_join(eye(len(pencil.stencil)))
        known = Matrix.vstack(*(rows[s] for s in rows), den * load)
        outputs = coefficients(derived, list(rows), pencil.stencil) * known if derived else zeros(0, known.cols)
        charpoly = rational.primitive(pencil.characteristic, lam).shift(1).replace(lam, mu)
        start, start_stencil = _start(scheme, at_zero)
        return cls(
            scheme,
            pencil.stencil,
            Affine.of(Matrix.vstack(*(rows[s] for s in after)), m, at_zero, den),
            Affine.of(outputs, m, at_zero, den),
            cast(tuple[int, int, int], in_state),
            start,
            start_stencil,
            -charpoly if charpoly.LC().subs(at_zero) < 0 else charpoly,
        )


@cache
def in_lambda(charpoly: Poly) -> Poly:
    """A characteristic polynomial, which is one in mu = lambda - 1, as one in lambda."""
    return charpoly.shift(-1).replace(mu, lam)


@cache
def _pencil(scheme: Scheme) -> Pencil:
    return Pencil._derived(scheme)


@cache
def _amplification(scheme: Scheme) -> Amplification:
    return Amplification._derived(scheme)


def _start(scheme: Scheme, at_zero: Mapping[Symbol, Expr]) -> tuple[Affine | None, tuple[Expr, ...]]:
    expressions = Step.of(scheme).start
    if expressions is None or not scheme.start:
        return None, ()
    stencil = instants(expressions, scheme.typical)
    return Affine.of(coefficients(expressions, knot(0), stencil), 3, at_zero), stencil
