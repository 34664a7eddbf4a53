"""Amplification -> the energy that a scheme itself has: a quadratic form that each free step multiplies by one number.

With the principal pair of eigenvalues as roots of lambda^2 - t lambda + d, any quantity w without the other eigenvalues
satisfies w_2 = t w_1 - d w_0, so that E_n = w_(n+1)^2 - t w_n w_(n+1) + d w_n^2 has E_(n+1) = d E_n exactly. It is
definite exactly where the pair is complex. On a motion that (u, h*v) describe alone, with x_1 = A x_0, that is
x^T P x with P = [[-A_21, (A_11 - A_22)/2], [., A_12]] up to a factor, and d = det A. For Newmark's (1/4, 1/2) it is
Omega^2 u^2 + (h v)^2, for the central difference Omega^2 (1 - Omega^2/4) u^2 + (h v)^2.

One spurious eigenvalue that is no rational function of Omega stays as lambda_s: w_n is then u_(n+1) - lambda_s u_n.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any, NamedTuple

from sympy import (
    Expr,
    Float,
    Integer,
    Matrix,
    Max,
    Poly,
    Rational,
    Symbol,
    cancel,
    eye,
    factor,
    gcd,
    im,
    lambdify,
    re,
    sqrt,
    zeros,
)

from ..algebra import rational
from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, auxiliary, kind_of, state_label, steps_back, xi
from .amplification import Amplification
from .spectrum import live

spurious = Symbol("lambda_s")
CUBIC = 3
DIGITS = 60  # in which P and its changes are computed, since they cancel at small Omega


class NoEnergy(DeclarationError):
    """The principal pair cannot be split off with one algebraic number."""


class EnergyInNumbers(NamedTuple):
    """Of the undamped form E = x^T P x: what changes it in a step with damping, to which damping is a load as others.

    With x_1 of the damped step and s = x_1 + A x_0, where A and `loss` are those of the undamped step,
    E_1 = (1 - loss) E_0 + s^T work h^2 f - s^T (damped x_0 + damped_load h^2 f).
    stencil: instants of f in steps after t_n. The matrices are lists of rows. P is scaled so that E = Omega^2 U^2 with
    the amplitude U of u in the free undamped motion of the principal pair on which x lies.
    """

    A: list[list[float]]
    P: list[list[float]]
    work: list[list[float]]
    damped: list[list[float]]
    damped_load: list[list[float]]
    stencil: list[float]
    loss: float


@dataclass(frozen=True)
class Energy:
    """x^T P x with A^T P A = ratio*P, for the step x_1 = A x_0 + B h^2 f(t_n + stencil*h).

    x: `state`, labels of u, h*v and what else the motion needs; the acceleration is left out where the equation of
    motion gives it. rows (2, m), form (2, 2): P = rows^T form rows, where rows is the unit matrix or takes x to (w_0,
    w_1). third: 0, or the polynomial in `spurious` whose real root that symbol stands for in rows, form and ratio; A
    (m, m) and B (m, K) are free of it. All are rational in Omega, xi and the parameters; units are those of u.
    """

    scheme: Scheme
    state: tuple[str, ...]
    stencil: tuple[Expr, ...]
    A: Matrix
    B: Matrix
    rows: Matrix
    form: Matrix
    ratio: Expr
    third: Expr

    @classmethod
    def of(cls, scheme: Scheme) -> "Energy":
        """Derived at free parameters. Raises NoEnergy for multi-step schemes with two or more live spurious roots."""
        p = live(Amplification.of(scheme).charpoly)
        if p.degree() > CUBIC:
            raise NoEnergy(
                f"{scheme.name} has {p.degree()} eigenvalues that are not 0: expected a principal pair and at most one "
                "more to split off"
            )
        state, stencil, N, load, den = _plane(scheme)
        c = p.all_coeffs()
        if p.degree() == CUBIC:
            A = N / den
            t = -c[1] / c[0] - spurious
            d = c[2] / c[0] - t * spurious
            first = eye(N.rows)[0, :] * (A if len(state) > CUBIC else eye(N.rows))  # a root 0 is split off as well
            w0 = first * (A - spurious * eye(N.rows))
            w1 = w0 * A
            rows, form = w0.col_join(w1), Matrix([[d, -t / 2], [-t / 2, 1]])
            third: Expr = p.as_expr().subs(p.gen, spurious)
        else:
            rows, d, third = eye(2), c[2] / c[0], Integer(0)
            entries = [-N[1, 0], N[0, 0] - N[1, 1], N[0, 1]]
            shared = reduce(gcd, entries)
            shared *= cancel(entries[2] / shared).subs(Omega, 0)
            uu, uv, vv = (cancel(e / shared) for e in entries)
            form = Matrix([[uu, uv / 2], [uv / 2, vv]])
        return cls(scheme, state, stencil, N / den, load / den, rows, form, factor(d), third)

    @cached_property
    def P(self) -> Matrix:
        """The form (m, m), symmetric."""
        return self.rows.T * self.form * self.rows

    @cached_property
    def undamped(self) -> tuple[Matrix, Expr]:
        """P and ratio at xi = 0."""
        return self.P.subs(xi, 0), factor(self.ratio.subs(xi, 0))

    @cached_property
    def gained(self) -> Expr:
        """The mechanical energy after any number of free steps without damping over that at the start, at most.

        With E between least and most times Omega^2 u^2 + (h v)^2 it is most/least, since E does not grow where the step
        is stable: 1 where E is the mechanical energy. Where ratio = 1 it is reached in the limit of many steps. On a
        structure without damping it is the largest of its modes. Raises NoEnergy for a state that is not u and v.
        """
        if self.third != 0 or self.state != ("u", "h*v"):
            raise NoEnergy(f"{self.scheme.name}: expected a state of u and v, got {', '.join(self.state)}")
        form = self.form.subs(xi, 0)
        uu, uv, vv = (cancel(e) for e in (form[0, 0] / Omega**2, form[0, 1] / Omega, form[1, 1]))
        if uv == 0:  # one of both is the largest
            return Max(factor(cancel(uu / vv)), factor(cancel(vv / uu)))
        half, apart = (uu + vv) / 2, cancel((((uu - vv) / 2) ** 2 + uv**2) / Omega**2)
        root = Omega * sqrt(factor(apart))
        return (half + root) / (half - root)

    @cached_property
    def damping(self) -> Matrix:
        """D with E_1 = ratio E_0 - x_0^T D x_0 for the undamped form E: what the structure's damping takes in a step.

        Raises NoEnergy where a spurious eigenvalue, which moves with xi, does not leave it in closed form.
        """
        if self.third != 0:
            raise NoEnergy(f"{self.scheme.name}: its spurious eigenvalue depends on xi; expected one that does not")
        P, ratio = self.undamped
        return (ratio * P - self.A.T * P * self.A).applyfunc(factor)

    @property
    def reported(self) -> bool:
        """Whether the state is what a run reports: no auxiliary state, nor a velocity that is not the reported one."""
        own = any("/" in label for label in self.state) or any(map(auxiliary, self.scheme.state))
        return not self.scheme.report and not own

    @property
    def starts_otherwise(self) -> bool:
        """Whether at t = 0 an entry of the state is not the u, v or a of that time."""
        start = self.scheme.start
        return not isinstance(start, Scheme) and any(steps_back(symbol) == 0 for symbol in start)

    def in_numbers(self, at: float, damping: float, parameters: Mapping[str, float]) -> EnergyInNumbers:
        """At Omega, xi and parameters that are exactly the numbers given.

        Raises NoEnergy where the principal pair is not complex at xi = 0: there the form has no sign.
        """
        constant = () if self.scheme.constant is None else (self.scheme.constant.approximation,)
        given = (at, damping, *(parameters[p.name] for p in self.scheme.parameters), *constant)
        W, Z, *others = (Float(Rational(x), DIGITS) for x in given)
        root = self._spurious_root(W, *others)
        A, B, rows, form, (ratio,), stencil = map(Matrix, self._function(W, Integer(0), root, *others))
        with_damping, loaded = map(Matrix, self._function(W, Z, root, *others)[:2])
        if not form.det() > 0:
            raise NoEnergy(
                f"expected a step at which {self.scheme.name} has a pair of complex eigenvalues, for an energy of its "
                f"own, got Omega = {at:.6g}, where they are real; take a shorter step, or fewer modes"
            )
        P = rows.T * form * rows * (W**2 * form[1, 1] / form.det())  # Omega^2 times the amplitude of w, squared
        if self.third != 0:
            of_u = ratio + 2 * form[0, 1] * root + root**2  # |lambda - lambda_s|^2, w over u, with t = -2 form[0, 1]
            P /= of_u * ratio if len(self.state) > CUBIC else of_u
        found = (A, P, P * B, P * (A - with_damping), P * (B - loaded))
        return EnergyInNumbers(
            *([[float(x) for x in row] for row in X.tolist()] for X in found),
            [float(x) for x in stencil],
            float(1 - ratio),
        )

    def _spurious_root(self, *numbers: Any) -> Expr:
        """Of `third` at xi = 0, Omega and the parameters: 0 without one."""
        if self.third == 0:
            return Integer(0)
        coefficients = Poly(self.third.subs(xi, 0), spurious).all_coeffs()
        values = lambdify((Omega, *self._others), coefficients, "sympy")(*numbers)
        roots = Poly(values, spurious).nroots(DIGITS, maxsteps=200)
        return re(min(roots, key=lambda root: abs(im(root))))

    @property
    def _others(self) -> tuple[Symbol, ...]:
        """The scheme's parameters, and its constant where it has one."""
        constant = () if self.scheme.constant is None else (self.scheme.constant,)
        return (*(p.symbol for p in self.scheme.parameters), *constant)

    @cached_property
    def _function(self) -> Callable[..., Any]:
        """A, B, rows, form, ratio, stencil as lists at Omega, xi, the spurious root, the parameters, the constant."""
        parts = [X.tolist() for X in (self.A, self.B, self.rows, self.form, Matrix([self.ratio]), Matrix(self.stencil))]
        return lambdify((Omega, xi, spurious, *self._others), parts, "sympy", cse=True)

    @cached_property
    def work(self) -> Matrix:
        """W (m, K) with E_1 = ratio E_0 + (x_1 + A x_0)^T W h^2 f: the work of the loads at the stencil, any xi."""
        return self.P * self.B


def _plane(scheme: Scheme) -> tuple[tuple[str, ...], tuple[Expr, ...], Matrix, Matrix, Expr]:
    """(state, stencil, N, load, den) of the step, without an acceleration that a step leaves in equilibrium."""
    found = Amplification.of(scheme)
    state, stencil, N, load = scheme.state, found.stencil, found.step.N, found.step.load_N
    now = [next((i for i, s in enumerate(state) if (kind_of(s), steps_back(s)) == (k, 0)), -1) for k in range(3)]
    if min(now) >= 0:
        u, v, a = now
        damping = 2 * xi * Omega if scheme.takes_damping else Integer(0)
        residual = N[a, :] + damping * N[v, :] + Omega**2 * N[u, :]
        if rational.same(residual, zeros(1, N.cols)):
            kept = [i for i in range(N.rows) if i != a]
            column, N, load = N[:, a], N[:, kept], load[kept, :]
            N[:, kept.index(u)] -= Omega**2 * column
            N[:, kept.index(v)] -= damping * column
            if Integer(0) not in stencil:
                stencil, load = (Integer(0), *stencil), zeros(len(kept), 1).row_join(load)
            load[:, stencil.index(Integer(0))] += Matrix([column[i] for i in kept])
            state, N = tuple(state[i] for i in kept), N[kept, :]
            both, den = rational.cancelled(N.row_join(load), found.step.den)
            return tuple(map(state_label, state)), stencil, both[:, : N.cols], both[:, N.cols :], den
    return tuple(map(state_label, state)), stencil, N, load, found.step.den
