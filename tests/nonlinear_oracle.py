"""Every scheme of the project on nonlinear systems M a + C v + N(u) = F(t), stepped by number: an independent oracle.

This file shares nothing with the code under test: no derivation, no generated kernel, no solver. Each step writes the
relations of the scheme as its paper prints them, except that an implicit step has its relations solved for u and v as
functions of the new acceleration, u = u_p + c_u a and v = v_p + c_v a (a `Line`), so that small time steps lose no
digits; Newton's iteration then runs to rounding.

All schemes are steps of one class, which shares the rows and Newton's iteration. One that nobody has written here is
stepped as it is declared, by as_declared.py.

The arithmetic is that of the step h, floats or mpmath's numbers, which oracle.py takes for linear oscillators.

In the steps, index 0 is t_n, 1 is t_{n+1}, g and p are sub-step knots, m is t_{n-1}, mm is t_{n-2}.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import tables
from as_declared import DeclaredSteps, starter_of
from designed_oracle import fourth_order, free_fourth_order, root_near, third_order
from further_oracle import FurtherSteps
from lines import Array, Line, Row, newmark_line, norm, same_line, solve
from predictor_oracle import PredictorSteps
from table_oracle import TableSteps

TRAPEZOID = {"beta": 1 / 4, "gamma": 1 / 2}
MEMBERS = {  # name: the method that steps it, with these parameters fixed
    "forward_euler": ("runge_kutta", {"stages": [(0, 1)]}),
    "rk2": ("runge_kutta", {"stages": [(0, 0), (1 / 2, 1)]}),
    "rk4": ("runge_kutta", {"stages": [(0, Fraction(1, 6)), *[(1 / 2, Fraction(1, 3))] * 2, (1, Fraction(1, 6))]}),
    "central_difference": ("newmark", {"beta": 0, "gamma": 1 / 2}),
    "average_acceleration": ("newmark", TRAPEZOID),
    "linear_acceleration": ("newmark", {"beta": 1 / 6, "gamma": 1 / 2}),
    "fox_goodwin": ("newmark", {"beta": 1 / 12, "gamma": 1 / 2}),
    "hht_alpha_mixed_displacement": ("hht_alpha", {"mixed": True}),
    "generalized_alpha_mixed_displacement": ("generalized_alpha", {"mixed": True}),
    "bathe": ("newmark_bdf2", {"gamma_t": 1 / 2, **TRAPEZOID}),
    "silva_bezerra": ("newmark_bdf2", TRAPEZOID),
    "kr_alpha_plain_start": ("kr_alpha", {}),
}
MEMBERS |= {f"bdf{order}": ("backward_differences", {"order": order}) for order in range(2, 5)}
MEMBERS |= {name: ("table", {"table": name}) for name in tables.TABLES}
MEMBERS |= {name: ("composed", {"weights": weights}) for name, weights in tables.COMPOSITIONS.items()}
MEMBERS |= {name: ("nystrom", {"table": table}) for name, table in tables.NYSTROM.items()}
MEMBERS |= {name: ("stoermer", {"counts": counts}) for name, counts in tables.EXTRAPOLATIONS.items()}
STARTERS = {  # how many steps of which scheme come before the first own one
    **{name: (2, "average_acceleration") for name in ("houbolt", "park", "bdf3")},
    **{name: (1, "average_acceleration") for name in ("oalts", "bdf2", "adams_moulton3", "bdf_alpha")},
    "bdf4": (3, "esdirk43"),
    "adams_moulton4": (2, "dormand_prince"),
}


@dataclass(frozen=True)
class System:
    """M a + C v + N(u) = F(t), arrays of length d, with the tangent dN/du; only energy_momentum needs the gradient."""

    mass: Array
    damping: Array
    force: Callable[[Array], Array]
    tangent: Callable[[Array], Array]
    load: Callable[[float], Array | float] = lambda t: 0.0
    discrete_gradient: Callable[[Array, Array], Array] | None = None  # N over a step from (u0, u1), also at u1 = u0

    def acceleration(self, u: Array, v: Array, t: float) -> Array:
        return solve(self.mass, self.load(t) - self.damping @ v - self.force(u))


def history(name, parameters: dict[str, float], system: System, dt: float, n: int, u0, v0, a0) -> tuple[Array, ...]:
    """Return u, v and a, each (n + 1, d), at t = 0, dt, ..., n dt; row 0 is the given start."""
    given = Row(*(np.array(x, dtype=float) for x in (u0, v0, a0)))
    with np.errstate(over="ignore", invalid="ignore"):  # an unstable run may overflow
        run = Run(name, parameters, system, dt, given)
        reported = [given]
        for i in range(n):
            run.t = i * dt
            count, starter = STARTERS.get(name, (0, name) if written(name) else starter_of(name))
            run.step(starter if i < count else name)
            reported.append(run.reported())
    return tuple(np.array(column) for column in zip(*reported, strict=True))


def written(name: str) -> bool:
    """Whether the scheme's step is written here, as its paper has it."""
    return hasattr(Run, MEMBERS.get(name, (name,))[0])


def slope(force: Callable[[Array], Array], u: Array) -> Array:
    """Return the derivative by central differences; its error only slows Newton's iteration."""
    shift = 1e-6 * norm(u) or 1e-6
    return np.array([(force(u + e) - force(u - e)) / (2 * shift) for e in shift * np.eye(len(u))]).T


class Run(TableSteps, FurtherSteps, PredictorSteps, DeclaredSteps):
    """One run; a method with the name of a scheme returns the row at t + h from the rows up to t."""

    def __init__(self, name: str, parameters: dict[str, float], s: System, h: float, given: Row):
        self.parameters, self.s, self.h, self.t, self.rows, self.one = parameters, s, h, 0 * h, [given], h / h
        self.kind = float if isinstance(h, float) else type(h)  # of all numbers
        self.lag = None  # v(t_n) - lag a_n is what the rows hold as v
        u, v, a = given
        self.auxiliary = {"rate": v, "weighted": a}  # what schemes carry besides, from their starts on
        if name == "central_difference_lagged":  # v_{n-1/2}
            self.lag = h / 2 * np.eye(len(u))
            v_half = v - self.lag @ s.acceleration(u, v, 0.0)
            self.rows = [Row(u, v_half, s.acceleration(u, v_half, 0.0))]
        elif name == "kr_alpha":  # v(t_n - gamma h)
            _, gamma, alpha1, _ = self.kr_constants(parameters["rho_inf"])
            self.lag = gamma * h * alpha1
            self.rows = [Row(u, v - self.lag @ a, a)]
        elif name == "gholampour":  # a_{-1}, from the differentiated equation of motion; u_{-1}, v_{-1} are not used
            change = s.load(h) - s.load(0.0) - h * (s.damping @ a) - h * (s.tangent(u) @ v)
            self.rows = [Row(u, v, a - solve(s.mass, change)), given]

    def step(self, name: str) -> None:
        if not written(name):
            self.rows.append(self.as_declared(name))
            return
        method, fixed = MEMBERS.get(name, (name, {}))
        self.rows.append(getattr(self, method)(SimpleNamespace(**self.parameters, **fixed)))

    def reported(self) -> Row:
        u, v, a = self.rows[-1]
        return Row(u, v if self.lag is None else v + self.lag @ a, a)

    def now(self):
        return self.s, self.h, self.t, *self.rows[-1]

    def balance(self, tau, line, last=None, *, weights=(1, 1), mixed=False, load=None, force=None) -> Row:
        """Return the row at t + tau h, where the load is taken, by Newton's iteration from u of `last`, the last knot.

        With weights (w_a, w_f) the equation of motion holds for w_a a1 + (1 - w_a) a0, likewise for v with w_f, and for
        N(u1) and N(u0) with w_f or, if `mixed`, for N of the mixed displacement. A given force(u1) replaces N.
        """
        s, last, (wa, wf) = self.s, last or self.rows[-1], weights
        load = s.load(self.t + tau * self.h) if load is None else load
        a, more = (last.u - line.u_p) / line.c_u if line.c_u else last.a, 4 if self.kind is float else 0
        for _ in range(100):
            u, v, _ = line.end(a)
            uf, vf, af = wf * u + (1 - wf) * last.u, wf * v + (1 - wf) * last.v, wa * a + (1 - wa) * last.a
            if force:
                n, tangent = force(u), slope(force, u)
            elif mixed:
                n, tangent = s.force(uf), wf * s.tangent(uf)
            else:
                n, tangent = wf * s.force(u) + (1 - wf) * s.force(last.u), wf * s.tangent(u)
            derivative = wa * s.mass + wf * line.c_v * s.damping + line.c_u * tangent
            change = solve(derivative, s.mass @ af + s.damping @ vf + n - load)
            a = a - change
            more -= norm(line.c_u * change) <= 1e-12 * (norm(last.u) + norm(line.u_p) + norm(line.c_u * a))
            if more <= 0:  # u stood still four times, which brings a to rounding; with mpmath the system is linear
                return line.end(a)
        raise RuntimeError("Newton's iteration does not converge")

    # One step, explicit
    def central_difference_lagged(self, p):
        s, h, t, u0, v_before, _ = self.now()
        v_half = v_before + h * s.acceleration(u0, v_before, t)
        u1 = u0 + h * v_half
        return Row(u1, v_half, s.acceleration(u1, v_half, t + h))

    def noh_bathe(self, par):
        (s, h, t, u0, v0, a0), p, r = self.now(), par.p, 1 - par.p
        q1 = (1 - 2 * p) / (2 * p * (1 - p))
        q2 = 0.5 - p * q1
        q0 = 0.5 - q1 - q2
        up = u0 + p * h * v0 + (p * h) ** 2 / 2 * a0
        ap = s.acceleration(up, v0 + p * h * a0, t + p * h)
        vp = v0 + p * h / 2 * (a0 + ap)
        u1 = up + r * h * vp + (r * h) ** 2 / 2 * ap
        a1 = s.acceleration(u1, vp + r * h * ap, t + h)
        return Row(u1, vp + r * h * (q0 * a0 + (0.5 + q1) * ap + q2 * a1), a1)

    def tchamwa_wielgosz(self, p):
        s, h, t, u0, v0, a0 = self.now()
        u1, v1 = u0 + h * v0 + p.phi * h**2 * a0, v0 + h * a0
        return Row(u1, v1, s.acceleration(u1, v1, t + h))

    def kim_two_stage(self, par):
        (s, h, t, u0, v0, a0), p = self.now(), par.gamma_t
        fractional = s.acceleration(u0 + p * h * v0 + (p * h) ** 2 / 2 * a0, v0 + p * h * a0, t + p * h)
        u = u0 + h * v0 + h**2 / 2 * ((3 * p - 1) * a0 + fractional) / (3 * p)
        v = v0 + h * ((2 * p - 1) * a0 + fractional) / (2 * p)
        a1, known = s.acceleration(u, v, t + h), fractional / (6 * p * (p - 1))
        u1 = u0 + h * v0 + h**2 / 2 * ((4 * p - 1) / (6 * p) * a0 - known + (2 * p - 1) / (6 * (p - 1)) * a1)
        return Row(u1, v0 + h * ((3 * p - 1) / (6 * p) * a0 - known + (3 * p - 2) / (6 * (p - 1)) * a1), a1)

    def kr_constants(self, rho):
        """Return alpha_f, gamma, alpha1 and alpha3, with the tangent at the start of the run."""
        h, m, c, k = self.h, self.s.mass, self.s.damping, self.s.tangent(self.rows[0].u)
        am, af, beta, gamma = (2 - rho) / (1 + rho), 1 / (1 + rho), 1 / (1 + rho) ** 2, (3 - rho) / (2 * (1 + rho))
        d = m + gamma * h * c + beta * h**2 * k
        return af, gamma, solve(d, m), solve(d, am * m + af * gamma * h * c + af * beta * h**2 * k)

    def kr_alpha(self, p):
        (s, h, t, u0, v0, a0), (af, gamma, alpha1, alpha3) = self.now(), self.kr_constants(p.rho_inf)
        u1, v1 = u0 + h * v0 + h**2 * (0.5 + gamma) * alpha1 @ a0, v0 + h * alpha1 @ a0
        vf, force = af * v1 + (1 - af) * v0, af * s.force(u1) + (1 - af) * s.force(u0)
        mean = solve(s.mass, s.load(t + af * h) - s.damping @ vf - force)  # alpha3 a1 + (I - alpha3) a0
        return Row(u1, v1, solve(alpha3, mean - (a0 - alpha3 @ a0)))

    # One step, implicit
    def backward_euler(self, p):
        return self.balance(1, same_line(self.rows[-1].u, self.rows[-1].v, self.h))

    def newmark(self, p, wa=1, wf=1):
        line = newmark_line(self.rows[-1], self.h, p.beta, p.gamma)
        return self.balance(wf, line, weights=(wa, wf), mixed=getattr(p, "mixed", False))

    def wilson_theta(self, p):
        """Linear acceleration up to t_n + theta h, balance there with the load extrapolated, then back to t_{n+1}."""
        (s, h, t, u0, v0, a0), th = self.now(), p.theta
        load = s.load(t) + th * (s.load(t + h) - s.load(t))
        a_th = self.balance(th, newmark_line(self.rows[-1], th * h, self.one / 6, 1 / 2), load=load).a
        a1 = a0 + (a_th - a0) / th
        return Row(u0 + h * v0 + h**2 / 6 * (2 * a0 + a1), v0 + h / 2 * (a0 + a1), a1)

    def collocation(self, p):
        """Newmark up to t_n + theta h with the load extrapolated, and over h with an acceleration linear in time."""
        (s, h, t, *_, a0), th = self.now(), p.theta
        load = s.load(t) + th * (s.load(t + h) - s.load(t))
        a_th = self.balance(th, newmark_line(self.rows[-1], th * h, p.beta, p.gamma), load=load).a
        return newmark_line(self.rows[-1], h, p.beta, p.gamma).end(a0 + (a_th - a0) / th)

    def theta_method(self, p):
        """y1 = y0 + h times the weighted mean of the slopes at both ends, each from the equation of motion."""
        (s, h, t, u0, v0, _), th = self.now(), p.theta
        before = s.acceleration(u0, v0, t)
        if th == 0:
            u1, v1 = u0 + h * v0, v0 + h * before
            return Row(u1, v1, s.acceleration(u1, v1, t + h))
        known_v = v0 + (1 - th) * h * before
        return self.balance(1, same_line(u0 + (1 - th) * h * v0, known_v, th * h))

    def hht_alpha(self, p):
        p.beta, p.gamma = (1 - p.alpha) ** 2 / 4, (1 - 2 * p.alpha) / 2
        return self.newmark(p, 1, 1 + p.alpha)

    def wbz_alpha(self, p):
        p.beta, p.gamma = (1 - p.alpha_B) ** 2 / 4, 0.5 - p.alpha_B
        return self.newmark(p, 1 - p.alpha_B, 1)

    def generalized_alpha(self, p):
        p.beta = getattr(p, "beta", (1 - p.alpha_m + p.alpha_f) ** 2 / 4)
        p.gamma = getattr(p, "gamma", 0.5 - p.alpha_m + p.alpha_f)
        return self.newmark(p, 1 - p.alpha_m, 1 - p.alpha_f)

    def explicit_generalized_alpha(self, p):
        """Hulbert and Chung 1996: the internal force at the predicted displacement, so that only M and C are solved."""
        (s, h, t, u0, v0, a0), w = self.now(), 1 - p.alpha_f
        u_p, _, v_p, c_v = newmark_line(self.rows[-1], h, p.beta, p.gamma)
        force = s.force(u0 + w * (u_p - u0))
        known = s.mass @ (p.alpha_m * a0) + s.damping @ (w * v_p + (1 - w) * v0) + force - s.load(t + w * h)
        a1 = solve((1 - p.alpha_m) * s.mass + w * c_v * s.damping, -known)
        return newmark_line(self.rows[-1], h, p.beta, p.gamma).end(a1)

    def energy_momentum(self, p):
        """u1 = u0 + h (v0 + v1)/2 with the unknown (v1 - v0)/h; v of the line is (v0 + v1)/2."""
        (s, h, t, u0, v0, _), gradient = self.now(), self.s.discrete_gradient
        assert gradient, "energy_momentum needs a discrete gradient"
        line = Line(u0 + h * v0, h**2 / 2, v0, h / 2)
        u1, _, a = self.balance(1 / 2, line, force=lambda u: gradient(u0, u))
        v1 = v0 + h * a
        return Row(u1, v1, s.acceleration(u1, v1, t + h))

    # Multi-step
    def houbolt(self, p):
        """2 u1 - 5 u0 + 4 um - umm = h^2 a1 and 11 u1 - 18 u0 + 9 um - 2 umm = 6 h v1."""
        (umm, um, u0), h = (row.u for row in self.rows[-3:]), self.h
        u_p = (5 * u0 - 4 * um + umm) / 2
        return self.balance(1, Line(u_p, h**2 / 2, (11 * u_p - 18 * u0 + 9 * um - 2 * umm) / (6 * h), 11 * h / 12))

    def park(self, p):
        """10 y1 - 15 y0 + 6 ym - ymm = 6 h y1'."""
        known_u, known_v, _ = ((15 * y0 - 6 * ym + ymm) / 10 for ymm, ym, y0 in zip(*self.rows[-3:], strict=True))
        return self.balance(1, same_line(known_u, known_v, 6 * self.h / 10))

    def backward_differences(self, p):
        """The sum over j = 1 ... order of the j-th backward difference of y, over j, is h y1'."""
        weights = [
            sum(self.one * (-1) ** i * math.comb(j, i) / j for j in range(max(i, 1), p.order + 1))
            for i in range(p.order + 1)
        ]
        earlier = self.rows[: -p.order - 1 : -1]
        known_u, known_v = (
            -sum(w * row[kind] for w, row in zip(weights[1:], earlier, strict=True)) / weights[0] for kind in (0, 1)
        )
        return self.balance(1, same_line(known_u, known_v, self.h / weights[0]))

    def gholampour(self, p):
        """Relations with the jerk (a1 - am)/(2 h) and the snap (a1 + am - 2 a0)/h^2."""
        am, (u0, v0, a0), h = self.rows[-2].a, self.rows[-1], self.h
        u_p = u0 + h * v0 + h**2 / 2 * a0 - h**3 / 6 * am / (2 * h) + p.alpha_g * h**2 * (am - 2 * a0)
        v_p = v0 + h * a0 - h**2 / 2 * am / (2 * h) + p.delta * h * (am - 2 * a0)
        return self.balance(1, Line(u_p, h**2 / 12 + p.alpha_g * h**2, v_p, h / 4 + p.delta * h))

    def oalts(self, p):
        """y1 + A1 y0 + A2 ym = h (B0 y1' + B1 y0' + B2 ym')."""
        (um, vm, am), (u0, v0, a0), h, rho = *self.rows[-2:], self.h, p.rho_inf
        a_1, b_0 = (4 * rho - 4) / (3 - rho), 2 / ((1 + rho) * (3 - rho))
        a_2, b_1, b_2 = -1 - a_1, 2 - 2 * b_0 + a_1 / 2, a_1 / 2 + b_0
        known_u = -a_1 * u0 - a_2 * um + h * (b_1 * v0 + b_2 * vm)
        return self.balance(1, same_line(known_u, -a_1 * v0 - a_2 * vm + h * (b_1 * a0 + b_2 * am), h * b_0))

    # Composite
    def newmark_bdf2(self, p):
        """Newmark up to the knot, then three-point backward Euler c1 y0 + c2 yg + c3 y1 = y1'."""
        (u0, v0, _), h, g = self.rows[-1], self.h, p.gamma_t
        knot = self.balance(g, newmark_line(self.rows[-1], g * h, p.beta, p.gamma))
        c1, c2, c3 = (1 - g) / (g * h), -1 / ((1 - g) * g * h), (2 - g) / ((1 - g) * h)
        return self.balance(1, same_line(-(c1 * u0 + c2 * knot.u) / c3, -(c1 * v0 + c2 * knot.v) / c3, 1 / c3), knot)

    def trbdf3(self, p):
        """Over thirds of the step: trapezoidal rule, three-point backward Euler, Houbolt."""
        (u0, v0, _), h = self.rows[-1], self.h / 3
        first = self.balance(self.one / 3, newmark_line(self.rows[-1], h, 1 / 4, 1 / 2))
        line = same_line((4 * first.u - u0) / 3, (4 * first.v - v0) / 3, 2 * h / 3)
        second = self.balance(2 * self.one / 3, line, first)
        u_p = (5 * second.u - 4 * first.u + u0) / 2
        v_p = (11 * u_p - 18 * second.u + 9 * first.u - 2 * u0) / (6 * h)
        return self.balance(1, Line(u_p, h**2 / 2, v_p, 11 * h / 12), second)

    def trapezoids_then(self, split: float, *weights: float) -> Row:
        """Trapezoids over `split` each, then y1 = y0 + h times the weighted sum of the rates at all knots."""
        knots, h = [self.rows[-1]], self.h
        for i in range(1, len(weights) - 1):
            knots.append(self.balance(i * split, newmark_line(knots[-1], split * h, 1 / 4, 1 / 2), knots[-1]))
        known_u = knots[0].u + h * sum(w * knot.v for w, knot in zip(weights, knots, strict=False))
        known_v = knots[0].v + h * sum(w * knot.a for w, knot in zip(weights, knots, strict=False))
        return self.balance(1, same_line(known_u, known_v, h * weights[-1]), knots[-1])

    def rho_inf_bathe(self, p):
        g, rho = p.gamma_t, p.rho_inf
        q1 = (1 + rho) / (2 * g * (rho - 1) + 4)
        q2 = 0.5 - g * q1
        return self.trapezoids_then(g, 1 - q1 - q2, q1, q2)

    def beta1_beta2_bathe(self, p):
        g, b1, b2 = p.gamma_t, p.beta1, p.beta2
        return self.trapezoids_then(g, g * (1 - b1), g * b1 + (1 - g) * (1 - b2), (1 - g) * b2)

    def three_substep(self, p):
        rho = p.rho_inf
        g = root_near(35 * self.one / 100, [3 * (1 + rho), -2 * (9 + rho), 24, -12, 2])
        d1, d2, d3 = 1 - 3 * g / 2, 0.5 - 3 * g / 2 + 3 * g**2 / 4, rho * g**3 / 8
        b1 = g / 8 + d1 / 4 + d2 / (2 * g) + d3 / g**2
        b2 = g / 2 + d1 / 2 - 2 * d3 / g**2
        b3 = 3 * g / 8 + d1 / 4 - d2 / (2 * g) + d3 / g**2
        return self.trapezoids_then(g, b3, b2, b1, g / 2)

    def stages(self, table: tuple[list[list[float]], list[float]]) -> Row:
        """y_i = y_0 + h sum_j a_ij y'_j, one row a_i for each sub-step and the time of its end."""
        knots, h = [self.rows[-1]], self.h
        for (*before, last), time in zip(*table, strict=True):
            known_u = knots[0].u + h * sum(w * knot.v for w, knot in zip(before, knots, strict=True))
            known_v = knots[0].v + h * sum(w * knot.a for w, knot in zip(before, knots, strict=True))
            knots.append(self.balance(time, same_line(known_u, known_v, h * last), knots[-1]))
        return knots[-1]

    def three_substep_third_order(self, p):
        return self.stages(third_order(p.rho_inf))

    def four_substep(self, p):
        return self.stages(free_fourth_order(p.rho_inf))

    def four_substep_fourth_order(self, p):
        return self.stages(fourth_order(self.one))
