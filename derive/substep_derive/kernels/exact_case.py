"""Scheme at exact parameters -> numbers that a program of it is tested with: computed in fractions, then rounded."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import cast

from sympy import Abs, Expr, Integer, Matrix, Poly, Rational, Symbol, arg, log, sqrt

from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, kind_of, mu, steps_back, t, xi
from ..oscillator.amplification import Affine, Amplification
from .eigenvalue_defect import about_one
from .stability_polynomials import live_coefficients

DIGITS = 40  # of a parameter that is irrational
H, MASS, OMEGA, DAMPING_RATIO = Rational(1, 4), Integer(2), Integer(2), Rational(1, 10)
LOAD = 3 + 2 * t - t**2  # any function would do that is not the same at two instants of a step
U0, V0, STEPS = Integer(1), Rational(-1, 2), 8
Row = tuple[Expr, Expr, Expr]


def near_values(parameters: ParameterSet) -> dict[Symbol, Rational]:
    """The value of each parameter, and of the scheme's constant, as a fraction: itself, or 40 digits of it."""
    field = parameters.field
    found = {s: field.near(field.number(e), 10**DIGITS) for s, e in parameters.values.items()}
    return {s: Rational(value.numerator, value.denominator) for s, value in found.items()}


@dataclass(frozen=True)
class ExactCase:
    """A step of h of mass*(u'' + 2 xi omega u' + omega^2 u) = LOAD(t) from U0, V0, and the scheme's functions there.

    rows: u, v, a after each of the steps. amplification: the matrix at Omega = omega*h. radius, numerical_damping,
    period_error: at the same Omega and xi, the last two None where all eigenvalues are real.
    """

    Omega: Rational
    xi: Rational
    amplification: Matrix
    radius: Expr
    numerical_damping: Expr | None
    period_error: Expr | None
    rows: tuple[Row, ...]

    @classmethod
    def of(cls, scheme: Scheme, values: Mapping[Symbol, Rational]) -> "ExactCase":
        """At these values of the scheme's parameters and constant, computed once for equal ones."""
        return _exact_case(scheme, tuple(values.items()))


@cache
def _exact_case(scheme: Scheme, values: tuple[tuple[Symbol, Rational], ...]) -> ExactCase:
    damping = DAMPING_RATIO if scheme.takes_damping else Integer(0)
    at = {**dict(values), Omega: OMEGA * H, xi: damping}
    amplification = Amplification.of(scheme)
    return ExactCase(
        at[Omega], damping, _Map.of(amplification.step, (), at).of_state,
        *_spectrum(amplification, at), tuple(_marched(scheme, at, STEPS)),
    )  # fmt: skip


def _spectrum(amplification: Amplification, at: Mapping[Symbol, Rational]) -> tuple[Expr, Expr | None, Expr | None]:
    """Spectral radius, numerical damping and period error, to 30 digits."""
    b = [e.subs(at) for e in about_one(live_coefficients(amplification))]
    found = [1 + root for root in Poly(b[::-1], mu).nroots(n=30, maxsteps=200)]
    radius = max(Abs(root) for root in found)
    pairs = [root for root in found if root.as_real_imag()[1] > 0]
    if not pairs:
        return radius, None, None
    pair = max(pairs, key=Abs)
    cosine = sqrt(1 - at[xi] ** 2)
    angle = arg(pair)
    damping = -log(Abs(pair)) / angle - at[xi] / cosine
    return radius, damping.n(30), (at[Omega] * cosine / angle - 1).n(30)


def _marched(scheme: Scheme, at: Mapping[Symbol, Rational], steps: int) -> list[Row]:
    """u, v, a at t = 0, h, 2h, ...; a at t = 0 is consistent."""

    def load(time: Expr) -> Expr:
        return H**2 * LOAD.subs(t, time) / MASS

    first = U0, H * V0, load(Integer(0)) - 2 * at[xi] * at[Omega] * H * V0 - at[Omega] ** 2 * U0
    history = _scaled(scheme, at, first, load, steps)
    return [(u, v / H, a / H**2) for u, v, a in history]


def _scaled(
    scheme: Scheme, at: Mapping[Symbol, Rational], first: Row, load: Callable[[Expr], Expr], steps: int
) -> list[Row]:
    """u, h*v, h^2*a at t = 0, h, 2h, ...; load: h^2 f/m at a time."""
    amplification = Amplification.of(scheme)
    history = [first]
    if scheme.start_scheme is not None:
        lag = int(max(map(steps_back, scheme.state)))
        history = _scaled(scheme.start_scheme, at, first, load, lag)
        state = Matrix([history[lag - int(steps_back(s))][kind_of(s)] for s in scheme.state])
    elif amplification.start is not None:
        state = _Map.of(amplification.start, amplification.start_stencil, at).applied(Matrix(first), load, 0)
    else:
        state = Matrix([first[kind_of(s)] for s in scheme.state])
    step, outputs = (_Map.of(m, amplification.stencil, at) for m in (amplification.step, amplification.outputs))
    for n in range(len(history) - 1, steps):
        new, others = step.applied(state, load, n), iter(outputs.applied(state, load, n))
        history.append(cast(Row, tuple(new[i] if i >= 0 else next(others) for i in amplification.in_state)))
        state = new
    return history


@dataclass(frozen=True)
class _Map:
    """An affine map of the amplification, in numbers."""

    of_state: Matrix
    of_loads: Matrix
    stencil: tuple[Expr, ...]

    @classmethod
    def of(cls, m: Affine, stencil: Sequence[Expr], at: Mapping[Symbol, Rational]) -> "_Map":
        den = m.den.subs(at)
        return cls(m.N.subs(at) / den, m.load_N.subs(at) / den, tuple(tau.subs(at) for tau in stencil))

    def applied(self, state: Matrix, load: Callable[[Expr], Expr], n: int) -> Matrix:
        """From the state at t = n h."""
        new = self.of_state * state
        return new + self.of_loads * Matrix([load((n + tau) * H) for tau in self.stencil]) if self.stencil else new
