"""Schemes that programs of others have, for the oracle, each from its paper or from the program's manual."""

import math
from typing import Any

from oracle import newmark_end, root, scheme, trapezoid_end


@scheme("collocation", "u h*v h^2*a", "theta beta gamma")
def collocation(s, state, p, f):
    """Hilber and Hughes 1978: Newmark and balance at t_n + theta h, with an acceleration linear in time."""
    (u0, v0, a0), th = state, p.theta
    *_, a_th = newmark_end(s, state, th, (p.beta, p.gamma), f(0) + th * (f(1) - f(0)))
    a1 = a0 + (a_th - a0) / th
    return u0 + v0 + (s.one / 2 - p.beta) * a0 + p.beta * a1, v0 + (1 - p.gamma) * a0 + p.gamma * a1, a1


@scheme("theta_method", "u h*v", "theta")
def theta_method(s, state, p, f):
    """y1 = y0 + h ((1 - theta) y0' + theta y1')."""
    (u0, v0), th = state, p.theta
    before = s.acceleration(u0, v0, f(0))

    def end(a):
        v1 = v0 + (1 - th) * before + th * a
        return u0 + (1 - th) * v0 + th * v1, v1, a

    u1, v1, a1 = end(root(lambda a: s.residual(*end(a), f(1))))
    return (u1, v1), (u1, v1, a1)


@scheme("explicit_generalized_alpha", "u h*v h^2*a", "alpha_m alpha_f beta gamma")
def explicit_generalized_alpha(s, state, p, f):
    """Hulbert and Chung 1996; the internal force at the predicted displacement where alpha_f is not 1."""
    (u0, v0, a0), w = state, 1 - p.alpha_f
    predicted = u0 + v0 + (s.one / 2 - p.beta) * a0

    def balance(a1):
        v1 = v0 + (1 - p.gamma) * a0 + p.gamma * a1
        u = p.alpha_f * u0 + w * predicted
        return s.residual(u, w * v1 + p.alpha_f * v0, (1 - p.alpha_m) * a1 + p.alpha_m * a0, f(w))

    a1 = root(balance)
    return predicted + p.beta * a1, v0 + (1 - p.gamma) * a0 + p.gamma * a1, a1


@scheme("trbdf3", "u h*v h^2*a")
def trbdf3(s, state, p, f):
    """OpenSees: over thirds of the step the trapezoidal rule, three-point backward Euler, and Houbolt."""
    (u0, v0, _), d = state, s.one / 3
    ug, vg, _ = trapezoid_end(s, state, d, f(d))

    def backward_euler(u):
        v = (3 * u - 4 * ug + u0) / (2 * d)
        return v, (3 * v - 4 * vg + v0) / (2 * d)

    uk = root(lambda u: s.residual(u, *backward_euler(u), f(2 * d)))

    def houbolt(u):
        return (11 * u - 18 * uk + 9 * ug - 2 * u0) / (6 * d), (2 * u - 5 * uk + 4 * ug - u0) / d**2

    u1 = root(lambda u: s.residual(u, *houbolt(u), f(1)))
    return u1, *houbolt(u1)


@scheme("kim_two_stage", "u h*v h^2*a", "gamma_t")
def kim_two_stage(s, state, par, f):
    """Kim 2019, with the three updates as Kratos has them; a stays that of the second stage."""
    (u0, v0, a0), p, half = state, par.gamma_t, s.one / 2
    fractional = s.acceleration(u0 + p * v0 + half * p * p * a0, v0 + p * a0, f(p))
    u = u0 + v0 + half * a0 * ((3 * p - 1) / (3 * p)) + half * fractional / (3 * p)
    v = v0 + a0 * ((2 * p - 1) / (2 * p)) + fractional / (2 * p)
    a1 = s.acceleration(u, v, f(1))
    u1 = u0 + v0 + half * a0 * ((4 * p - 1) / (6 * p)) - half * fractional / (6 * p * (p - 1))
    v1 = v0 + a0 * ((3 * p - 1) / (6 * p)) - fractional / (6 * p * (p - 1))
    return u1 + half * a1 * ((2 * p - 1) / (6 * (p - 1))), v1 + a1 * ((3 * p - 2) / (6 * (p - 1))), a1


def _register_backward_differences(order: int) -> None:
    weights = [[(-1) ** i * math.comb(j, i) for i in range(j + 1)] for j in range(1, order + 1)]
    earlier = [f"[-{n}]" if n else "" for n in range(order)]

    @scheme(f"bdf{order}", " ".join(f"u{n} h*v{n}" for n in earlier))
    def rule(s, state, p, f):
        """The sum of the backward differences of y, each over its order, is h y1'."""

        def rate(new: Any, kind: int) -> Any:
            values = [new, *state[kind::2]]
            return sum(sum(w * y for w, y in zip(row, values, strict=False)) / len(row[1:]) for row in weights)

        def rates(u):
            v = rate(u, 0)
            return v, rate(v, 1)

        u1 = root(lambda u: s.residual(u, *rates(u), f(1)))
        v1, a1 = rates(u1)
        return (u1, v1, *state[:-2]), (u1, v1, a1)


for _order in range(2, 5):
    _register_backward_differences(_order)
