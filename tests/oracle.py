"""Every scheme of the project, stepped number by number from its textbook equations: an independent oracle.

This file shares no code and no idea with the symbolic derivation it checks. Nothing here is expanded or simplified: a
step writes the relations of the scheme as its paper prints them, and solves each balance equation for its one unknown
by a scalar division. Amplification matrices come from stepping unit states.

The problem is the linear oscillator a + 2 xi omega v + omega^2 u = f(t) with h = 1 and omega = Omega, so that a state
holds u, h*v and h^2*a. The arithmetic is that of its arguments: Python floats and mpmath.mpf both work, because the
constants are integers and only meet numbers of the type of Omega.

All schemes share the state and the entries below, so that they are one file, which grows with the catalogue.

In the steps, index 0 is t_n, 1 is t_{n+1}, g and p are sub-step knots, `_m` is t_{n-1}, `_mm` is t_{n-2}.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

Number = Any  # float or mpmath.mpf


@dataclass(frozen=True)
class Entry:
    """One scheme; `step(state, Omega, xi, params, f)` has its load per unit mass f(tau) at t_n + tau h.

    A step returns the new state and the displacement, velocity and acceleration reported at t_{n+1}.
    """

    parameters: tuple[str, ...]
    state: tuple[str, ...]
    step: Callable[..., tuple[tuple, tuple]]


@dataclass(frozen=True)
class Oscillator:
    """Damping c = 2 xi Omega, stiffness k = Omega^2 (unit mass, h = 1), and the number one in the type in use."""

    one: Number
    c: Number
    k: Number

    def acceleration(self, u: Number, v: Number, load: Number) -> Number:
        return load - self.c * v - self.k * u

    def residual(self, u: Number, v: Number, a: Number, load: Number) -> Number:
        return a + self.c * v + self.k * u - load


SCHEMES: dict[str, Entry] = {}


def scheme(name: str, state: str, parameters: str = "", optional: str = "") -> Callable:
    """Register a rule from (oscillator, state, params, f) to (new_state, reported), or to one triple that is both."""
    names, labels = tuple(parameters.split()), tuple(state.split())

    def register(rule: Callable) -> Callable:
        def step(state, Omega, xi, params, f):
            if not set(names) <= set(params) <= {*names, *optional.split()}:
                raise ValueError(f"{name} takes the parameters {names}, got {tuple(params)}")
            one = 0 * Omega + 1
            p = SimpleNamespace(**{key: one * value for key, value in params.items()})
            oscillator = Oscillator(one, 2 * xi * Omega, Omega * Omega)
            result = rule(oscillator, [one * x for x in state], p, lambda tau: f(one * tau))
            new, reported = result if len(result) == 2 else (result, result)
            return tuple(new), tuple(reported)

        SCHEMES[name] = Entry(names, labels, step)
        return rule

    return register


def amplification(name: str, Omega: Number, xi: Number, params: dict) -> list[list]:
    """The matrix (list of rows) that takes the state at t_n to the state at t_{n+1} without load."""
    entry, zero = SCHEMES[name], 0 * Omega
    size = range(len(entry.state))
    units = [[zero + (1 if i == j else 0) for i in size] for j in size]
    columns = [entry.step(unit, Omega, xi, params, lambda tau: zero)[0] for unit in units]
    return [list(row) for row in zip(*columns, strict=True)]


def sample_parameters(name: str, rng: Any) -> dict[str, float]:
    """Random admissible parameters; where a scheme has free parameters, unstable sets are among them."""
    if name == "gholampour":  # delta >= 1/3, delta/2 <= alpha_g <= delta - 1/6
        delta = rng.uniform(1 / 3, 1)
        return {"delta": float(delta), "alpha_g": float(rng.uniform(delta / 2, delta - 1 / 6))}
    if name == "chung_lee":
        return {"beta": float(rng.uniform(1, 28 / 27))}
    if name == "theta_method":
        return {"theta": float(rng.uniform(0, 1))}
    if name == "zhai":
        return {key: float(rng.uniform(0, 1)) for key in ("psi", "phi")}
    ranges = {
        "beta": (0.05, 1), "gamma": (0.3, 1.2), "gamma_t": (0.1, 0.9), "theta": (1, 2), "alpha": (-1 / 3, 0),
        "alpha_B": (-1, 0), "alpha_m": (-1, 0.5), "alpha_f": (0, 0.5), "rho_inf": (0, 1), "p": (0.5, 0.9),
        "phi": (1, 2), "beta1": (0.2, 1), "beta2": (0.2, 1), "weight": (0.25, 1.5),
        "rho_1": (0, 1), "rho_2": (0, 1), "rho_3": (0, 1),
    }  # fmt: skip
    return {key: float(rng.uniform(*ranges[key])) for key in SCHEMES[name].parameters}


def root(residual: Callable[[Number], Number]) -> Number:
    """The zero of a residual affine in its unknown; a probe at least as large as the first value limits rounding."""
    r0 = residual(0)
    probe = 1 + abs(r0)
    return -r0 * (probe / (residual(probe) - r0))


@scheme("forward_euler", "u h*v")
def forward_euler(s, state, p, f):
    u0, v0 = state
    u1, v1 = u0 + v0, v0 + s.acceleration(u0, v0, f(0))
    return (u1, v1), (u1, v1, s.acceleration(u1, v1, f(1)))


@scheme("rk2", "u h*v")
def rk2(s, state, p, f):
    """Runge-Kutta, midpoint."""
    u0, v0 = state
    um, vm = u0 + v0 / 2, v0 + s.acceleration(u0, v0, f(0)) / 2
    u1, v1 = u0 + vm, v0 + s.acceleration(um, vm, f(s.one / 2))
    return (u1, v1), (u1, v1, s.acceleration(u1, v1, f(1)))


@scheme("rk4", "u h*v")
def rk4(s, state, p, f):
    """Runge-Kutta, the classical four stages, the last at t_{n+1}."""
    u0, v0 = state

    def slope(u, v, tau):
        return v, s.acceleration(u, v, f(tau))

    k1 = slope(u0, v0, 0)
    k2 = slope(u0 + k1[0] / 2, v0 + k1[1] / 2, s.one / 2)
    k3 = slope(u0 + k2[0] / 2, v0 + k2[1] / 2, s.one / 2)
    k4 = slope(u0 + k3[0], v0 + k3[1], 1)
    u1, v1 = (y + (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]) / 6 for i, y in enumerate((u0, v0)))
    return (u1, v1), (u1, v1, s.acceleration(u1, v1, f(1)))


@scheme("central_difference_lagged", "u h*v[-1/2]")
def central_difference_lagged(s, state, p, f):
    """Leap-frog: the damping force of a(t_n) uses v(t_{n-1/2})."""
    u0, v_before = state
    v_half = v_before + s.acceleration(u0, v_before, f(0))
    u1 = u0 + v_half
    a1 = s.acceleration(u1, v_half, f(1))
    return (u1, v_half), (u1, (v_half + (v_half + a1)) / 2, a1)


@scheme("noh_bathe", "u h*v h^2*a", "p")
def noh_bathe(s, state, par, f):
    """Noh and Bathe 2013, explicit, two sub-steps p h and (1 - p) h."""
    (u0, v0, a0), p, r = state, par.p, 1 - par.p
    q1 = (1 - 2 * p) / (2 * p * (1 - p))
    q2 = s.one / 2 - p * q1
    q0 = s.one / 2 - q1 - q2
    up = u0 + p * v0 + p * p * a0 / 2
    ap = s.acceleration(up, v0 + p * a0, f(p))
    vp = v0 + p * (a0 + ap) / 2
    u1 = up + r * vp + r * r * ap / 2
    a1 = s.acceleration(u1, vp + r * ap, f(1))
    return u1, vp + r * (q0 * a0 + (s.one / 2 + q1) * ap + q2 * a1), a1


@scheme("tchamwa_wielgosz", "u h*v h^2*a", "phi")
def tchamwa_wielgosz(s, state, p, f):
    u0, v0, a0 = state
    u1, v1 = u0 + v0 + p.phi * a0, v0 + a0
    return u1, v1, s.acceleration(u1, v1, f(1))


@scheme("kr_alpha", "u h*v h^2*a", "rho_inf")
def kr_alpha(s, state, p, f):
    """Kolay and Ricles 2014. The state keeps the scheme's own velocity; the reported one is the corrected form."""
    (u0, v0, a0), rho = state, p.rho_inf
    am, af = (2 - rho) / (1 + rho), 1 / (1 + rho)
    beta, gamma = 1 / (1 + rho) ** 2, (3 - rho) / (2 * (1 + rho))
    d = 1 + gamma * s.c + beta * s.k
    alpha1, alpha2 = 1 / d, (s.one / 2 + gamma) / d
    alpha3 = (am + af * gamma * s.c + af * beta * s.k) / d
    u1, v1 = u0 + v0 + alpha2 * a0, v0 + alpha1 * a0
    uf, vf = af * u1 + (1 - af) * u0, af * v1 + (1 - af) * v0
    a1 = root(lambda a: s.residual(uf, vf, alpha3 * a + (1 - alpha3) * a0, f(af)))
    return (u1, v1, a1), (u1, v1 + gamma * alpha1 * a1, a1)


@scheme("backward_euler", "u h*v")
def backward_euler(s, state, p, f):
    u0, v0 = state
    u1 = root(lambda u: s.residual(u, u - u0, (u - u0) - v0, f(1)))
    v1 = u1 - u0
    return (u1, v1), (u1, v1, v1 - v0)


def newmark_end(s, start, dt, beta_gamma, load, *, weights=(1, 1)):
    """Newmark's relations over a (sub-)step of length dt, with the balance at its end.

    With weights (w_a, w_f) the balance holds for w_a a1 + (1 - w_a) a0, and likewise for u and v with w_f.
    """
    (u0, v0, a0), (beta, gamma), (wa, wf) = start, beta_gamma, weights

    def end(a1):
        u1 = u0 + dt * v0 + dt * dt * ((s.one / 2 - beta) * a0 + beta * a1)
        return u1, v0 + dt * ((1 - gamma) * a0 + gamma * a1), a1

    def balance(a):
        u1, v1, a1 = end(a)
        return s.residual(wf * u1 + (1 - wf) * u0, wf * v1 + (1 - wf) * v0, wa * a1 + (1 - wa) * a0, load)

    return end(root(balance))


scheme("newmark", "u h*v h^2*a", "beta gamma")(
    lambda s, state, p, f: newmark_end(s, state, s.one, (p.beta, p.gamma), f(1))
)
scheme("central_difference", "u h*v h^2*a")(
    lambda s, state, p, f: newmark_end(s, state, s.one, (0 * s.one, s.one / 2), f(1))
)


@scheme("wilson_theta", "u h*v h^2*a", "theta")
def wilson_theta(s, state, p, f):
    """Linear acceleration up to t_n + theta h, balance there, then back to t_{n+1}."""
    (u0, v0, a0), th = state, p.theta
    load = f(0) + th * (f(1) - f(0))

    def rates(u):
        return 3 / th * (u - u0) - 2 * v0 - th / 2 * a0, 6 / th**2 * (u - u0) - 6 / th * v0 - 2 * a0

    _, a_th = rates(root(lambda u: s.residual(u, *rates(u), load)))
    a1 = a0 + (a_th - a0) / th
    return u0 + v0 + (2 * a0 + a1) / 6, v0 + (a0 + a1) / 2, a1


@scheme("hht_alpha", "u h*v h^2*a", "alpha")
def hht_alpha(s, state, p, f):
    """Hilber, Hughes and Taylor 1977, -1/3 <= alpha <= 0."""
    al = p.alpha
    return newmark_end(s, state, s.one, ((1 - al) ** 2 / 4, (1 - 2 * al) / 2), f(1 + al), weights=(1, 1 + al))


@scheme("wbz_alpha", "u h*v h^2*a", "alpha_B")
def wbz_alpha(s, state, p, f):
    """Wood, Bossak and Zienkiewicz 1981, alpha_B <= 0."""
    al = p.alpha_B
    return newmark_end(s, state, s.one, ((1 - al) ** 2 / 4, s.one / 2 - al), f(1), weights=(1 - al, 1))


@scheme("generalized_alpha", "u h*v h^2*a", "alpha_m alpha_f", optional="beta gamma")
def generalized_alpha(s, state, p, f):
    """Chung and Hulbert 1993; beta and gamma follow from alpha_m and alpha_f unless they are given."""
    am, af = p.alpha_m, p.alpha_f
    beta = getattr(p, "beta", (1 - am + af) ** 2 / 4)
    gamma = getattr(p, "gamma", s.one / 2 - am + af)
    return newmark_end(s, state, s.one, (beta, gamma), f(1 - af), weights=(1 - am, 1 - af))


@scheme("energy_momentum", "u h*v")
def energy_momentum(s, state, p, f):
    """Simo and Tarnow 1992, Gonzalez 1996; for a linear force, the midpoint rule."""
    u0, v0 = state
    v1 = root(lambda v: s.residual(u0 + (v0 + v) / 4, (v0 + v) / 2, v - v0, f(s.one / 2)))
    u1 = u0 + (v0 + v1) / 2
    return (u1, v1), (u1, v1, s.acceleration(u1, v1, f(1)))


@scheme("houbolt", "u u[-1] u[-2]")
def houbolt(s, state, p, f):
    u0, um, umm = state

    def rates(u):
        return (11 * u - 18 * u0 + 9 * um - 2 * umm) / 6, 2 * u - 5 * u0 + 4 * um - umm

    u1 = root(lambda u: s.residual(u, *rates(u), f(1)))
    return (u1, u0, um), (u1, *rates(u1))


@scheme("park", "u h*v u[-1] h*v[-1] u[-2] h*v[-2]")
def park(s, state, p, f):
    u0, v0, um, vm, umm, vmm = state

    def rates(u):
        v = (10 * u - 15 * u0 + 6 * um - umm) / 6
        return v, (10 * v - 15 * v0 + 6 * vm - vmm) / 6

    u1 = root(lambda u: s.residual(u, *rates(u), f(1)))
    v1, a1 = rates(u1)
    return (u1, v1, u0, v0, um, vm), (u1, v1, a1)


@scheme("gholampour", "u h*v h^2*a h^2*a[-1]", "delta alpha_g")
def gholampour(s, state, p, f):
    u0, v0, a0, am = state

    def end(a1):
        jerk, snap = (a1 - am) / 2, a1 + am - 2 * a0
        return u0 + v0 + a0 / 2 + jerk / 6 + p.alpha_g * snap, v0 + a0 + jerk / 2 + p.delta * snap, a1

    new = end(root(lambda a: s.residual(*end(a), f(1))))
    return (*new, a0), new


@scheme("oalts", "u h*v h^2*a u[-1] h*v[-1] h^2*a[-1]", "rho_inf")
def oalts(s, state, p, f):
    """Zhang 2019, optimal A-stable linear two-step method."""
    (u0, v0, a0, um, vm, am), rho = state, p.rho_inf
    a_1 = (4 * rho - 4) / (3 - rho)
    a_2 = -1 - a_1
    b_0 = 2 / ((1 + rho) * (3 - rho))
    b_1, b_2 = 2 - 2 * b_0 + a_1 / 2, a_1 / 2 + b_0

    def end(a1):
        v1 = -a_1 * v0 - a_2 * vm + b_0 * a1 + b_1 * a0 + b_2 * am
        return -a_1 * u0 - a_2 * um + b_0 * v1 + b_1 * v0 + b_2 * vm, v1, a1

    new = end(root(lambda a: s.residual(*end(a), f(1))))
    return (*new, u0, v0, a0), new


def newmark_then_three_point(s, start, split, beta_gamma, f):
    """Newmark up to the knot, then three-point backward Euler from t_n and the knot to t_{n+1}."""
    u0, v0, _ = start
    ug, vg, _ = newmark_end(s, start, split, beta_gamma, f(split))
    c1, c2, c3 = (1 - split) / split, -1 / ((1 - split) * split), (2 - split) / (1 - split)

    def rates(u):
        v = c1 * u0 + c2 * ug + c3 * u
        return v, c1 * v0 + c2 * vg + c3 * v

    u1 = root(lambda u: s.residual(u, *rates(u), f(1)))
    return u1, *rates(u1)


scheme("bathe", "u h*v h^2*a")(
    lambda s, state, p, f: newmark_then_three_point(s, state, s.one / 2, (s.one / 4, s.one / 2), f)
)
scheme("silva_bezerra", "u h*v h^2*a", "gamma_t")(
    lambda s, state, p, f: newmark_then_three_point(s, state, p.gamma_t, (s.one / 4, s.one / 2), f)
)
scheme("newmark_bdf2", "u h*v h^2*a", "beta gamma gamma_t")(  # Kumar 2015, with the damping terms
    lambda s, state, p, f: newmark_then_three_point(s, state, p.gamma_t, (p.beta, p.gamma), f)
)


def weighted_end(s, knots, weights, load):
    """y1 = y0 + the weighted sum of the rates at the knots (t_n first) and at t_{n+1}, for u and v alike."""
    (u0, v0, _), (*before, last) = knots[0], weights

    def end(a1):
        v1 = v0 + sum(w * a for w, (_, _, a) in zip(before, knots, strict=True)) + last * a1
        return u0 + sum(w * v for w, (_, v, _) in zip(before, knots, strict=True)) + last * v1, v1, a1

    return end(root(lambda a: s.residual(*end(a), load)))


def trapezoid_end(s, start, dt, load):
    return newmark_end(s, start, dt, (s.one / 4, s.one / 2), load)


@scheme("rho_inf_bathe", "u h*v h^2*a", "rho_inf gamma_t")
def rho_inf_bathe(s, state, p, f):
    """Noh and Bathe 2019; the split gamma_t is free."""
    g, rho = p.gamma_t, p.rho_inf
    q1 = (1 + rho) / (2 * g * (rho - 1) + 4)
    q2 = s.one / 2 - g * q1
    q0 = 1 - q1 - q2
    knot = trapezoid_end(s, state, g, f(g))
    return weighted_end(s, (state, knot), (q0, q1, q2), f(1))


@scheme("beta1_beta2_bathe", "u h*v h^2*a", "beta1 beta2 gamma_t")
def beta1_beta2_bathe(s, state, p, f):
    """Malakiyeh, Shojaee and Bathe 2019."""
    g, b1, b2 = p.gamma_t, p.beta1, p.beta2
    knot = trapezoid_end(s, state, g, f(g))
    weights = g * (1 - b1), g * b1 + (1 - g) * (1 - b2), (1 - g) * b2
    return weighted_end(s, (state, knot), weights, f(1))


def three_substep_split(rho: Number) -> Number:
    """The smallest real root of 3(1+rho) g^4 - 2(9+rho) g^3 + 24 g^2 - 12 g + 2, by Newton's iteration from 0.35."""
    g, change, last = (0 * rho + 35) / 100, 1, 2
    while change < last:  # until rounding keeps the corrections from shrinking
        value = 3 * (1 + rho) * g**4 - 2 * (9 + rho) * g**3 + 24 * g**2 - 12 * g + 2
        slope = 12 * (1 + rho) * g**3 - 6 * (9 + rho) * g**2 + 48 * g - 12
        g, change, last = g - value / slope, abs(value / slope), change
    return g


@scheme("three_substep", "u h*v h^2*a", "rho_inf")
def three_substep(s, state, p, f):
    """Zhang et al. 2020: two trapezoidal sub-steps of gamma h, then all four knots weighted."""
    rho, g = p.rho_inf, three_substep_split(p.rho_inf)
    d1, d2, d3 = 1 - 3 * g / 2, s.one / 2 - 3 * g / 2 + 3 * g**2 / 4, rho * g**3 / 8
    b1 = g / 8 + d1 / 4 + d2 / (2 * g) + d3 / g**2
    b2 = g / 2 + d1 / 2 - 2 * d3 / g**2
    b3 = 3 * g / 8 + d1 / 4 - d2 / (2 * g) + d3 / g**2
    first = trapezoid_end(s, state, g, f(g))
    second = trapezoid_end(s, first, g, f(2 * g))
    return weighted_end(s, (state, first, second), (b3, b2, b1, g / 2), f(1))


import program_schemes  # noqa: E402, F401 (registers schemes that programs have)  # pyright: ignore[reportUnusedImport]
import tables  # noqa: E402, F401 (registers schemes that are tables)  # pyright: ignore[reportUnusedImport]
