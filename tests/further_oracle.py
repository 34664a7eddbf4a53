"""Schemes that reviews and programs name, for both oracles: each step written as its paper has it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import tables
from designed_oracle import sample_parameters
from lines import Line, Row
from oracle import root, scheme

__all__ = ["FurtherSteps", "sample_parameters"]  # of all schemes, those of this file among them
solve = np.linalg.solve


def stages_of_the_new_step(rho_1: Any, rho_2: Any, rho_3: Any, u0: bool) -> SimpleNamespace:
    """Lambda_1, 2, 3, 5, 6 and lambda_3, 5 of Zhou and Tamma."""
    q, s = (1 + rho_1) * (1 + rho_2), 3 + rho_1 + rho_2 - rho_1 * rho_2
    L6, L3 = (2 + rho_1 + rho_2 + rho_3 - rho_1 * rho_2 * rho_3) / (q * (1 + rho_3)), 1 / (q * (1 + rho_3))
    if u0:
        L1, L2, L5 = 1 / (1 + rho_3), 1 / (2 * (1 + rho_3)), s / (2 * q * (1 + rho_3))
        return SimpleNamespace(L1=L1, L2=L2, L3=L3, L5=L5, L6=L6, l3=1 / q, l5=s / (2 * q))
    L1, L2, L5 = s / (2 * q), 1 / q, 2 / (q * (1 + rho_3))
    return SimpleNamespace(L1=L1, L2=L2, L3=L3, L5=L5, L6=L6, l3=1 / (2 * (1 + rho_3)), l5=1 / (1 + rho_3))


@scheme("chang", "u h*v h^2*a")
def chang(s, state, p, f):
    u0, v0, a0 = state
    d = 1 + s.c / 2 + s.k / 4
    u1 = u0 + (1 + s.c / 2) / d * v0 + a0 / (2 * d)
    a1 = root(lambda a: s.residual(u1, v0 + (a0 + a) / 2, a, f(1)))
    new = u1, v0 + (a0 + a1) / 2, a1
    return new, new


@scheme("chen_ricles", "u h*v h^2*a")
def chen_ricles(s, state, p, f):
    u0, v0, a0 = state
    d = 1 + s.c / 2 + s.k / 4
    u1, v1 = u0 + v0 + a0 / d, v0 + a0 / d
    new = u1, v1, s.acceleration(u1, v1, f(1))
    return new, new


@scheme("chung_lee", "u h*v h^2*a", "beta")
def chung_lee(s, state, p, f):
    u0, v0, a0 = state
    a1 = s.acceleration(u0, v0, f(0))
    new = u0 + v0 + (s.one / 2 - p.beta) * a0 + p.beta * a1, v0 - a0 / 2 + 3 * a1 / 2, a1
    return new, new


@scheme("adams_moulton3", "u h*v h^2*a h^2*a[-1]")
def adams_moulton3(s, state, p, f):
    u0, v0, a0, am = state

    def end(a1):
        return u0 + v0 + (3 * a1 + 10 * a0 - am) / 24, v0 + (5 * a1 + 8 * a0 - am) / 12, a1

    new = end(root(lambda a: s.residual(*end(a), f(1))))
    return (*new, a0), new


@scheme("adams_moulton4", "u h*v h^2*a h^2*a[-1] h^2*a[-2]")
def adams_moulton4(s, state, p, f):
    u0, v0, a0, am, amm = state

    def end(a1):
        u1 = u0 + v0 + 19 * a1 / 180 + 19 * a0 / 40 - am / 10 + 7 * amm / 360
        return u1, v0 + 3 * a1 / 8 + 19 * a0 / 24 - 5 * am / 24 + amm / 24, a1

    new = end(root(lambda a: s.residual(*end(a), f(1))))
    return (*new, a0, am), new


@scheme("bdf_alpha", "u h*v h^2*a u[-1] h*v[-1]", "alpha")
def bdf_alpha(s, state, p, f):
    u0, v0, a0, um, vm = state

    def mean(x0, xm, rate1, rate0):
        """x1 from (3/2 + alpha) x1 - (2 + 2 alpha) x0 + (1/2 + alpha) xm = (1 + alpha) x1' - alpha x0'."""
        known = 2 * (1 + p.alpha) * x0 - (1 + 2 * p.alpha) * xm / 2
        return (known + (1 + p.alpha) * rate1 - p.alpha * rate0) / (3 * s.one / 2 + p.alpha)

    def end(a1):
        v1 = mean(v0, vm, a1, a0)
        return mean(u0, um, v1, v0), v1, a1

    new = end(root(lambda a: s.residual(*end(a), f(1))))
    return (*new, u0, v0), new


@scheme("zhai", "u h*v h^2*a h^2*a[-1]", "psi phi")
def zhai(s, state, p, f):
    u0, v0, a0, am = state
    u1, v1 = u0 + v0 + (s.one / 2 + p.psi) * a0 - p.psi * am, v0 + (1 + p.phi) * a0 - p.phi * am
    new = u1, v1, s.acceleration(u1, v1, f(1))
    return (*new, a0), new


def _gssss(name: str, u0_family: bool) -> None:
    @scheme(name, "u h*v h^2*a", "rho_1 rho_2 rho_3")
    def rule(s, state, p, f):
        (u0, v0, a0), L = state, stages_of_the_new_step(p.rho_1, p.rho_2, p.rho_3, u0_family)

        def wrong(a1):
            d = a1 - a0
            u, v = u0 + L.L1 * v0 + L.L2 * a0 + L.L3 * d, v0 + L.L1 * a0 + L.L5 * d
            return s.residual(u, v, a0 + L.L6 * d, (1 - L.L1) * f(0) + L.L1 * f(1))

        a1 = root(wrong)
        new = u0 + v0 + a0 / 2 + L.l3 * (a1 - a0), v0 + a0 + L.l5 * (a1 - a0), a1
        return new, new


_gssss("gssss_u0", True)
_gssss("gssss_v0", False)


@scheme("discontinuous_galerkin_p1", "u h*v")
def discontinuous_galerkin_p1(s, state, p, f):
    """Moments 1 and 2 t - 1 of u' = v and of the balance, both fields linear in time, with jumps at t_n.

    u_p, u_1, v_p, v_1 are solved together; the balance's moments take the load at Radau's points.
    """
    u0, v0 = state
    one, third = s.one, s.one / 3
    first, last = f(third), f(one)
    mean, slope = 3 * first / 4 + last / 4, -first / 4 + last / 4  # moments of the load
    rows = [  # of (u_p, u_1, v_p, v_1); the jump counts with t = 0, where 2 t - 1 is -1
        [0 * one, one, -one / 2, -one / 2, u0],
        [-one, 0 * one, one / 6, -one / 6, -u0],
        [s.k / 2, s.k / 2, s.c / 2, one + s.c / 2, mean + v0],
        [-s.k / 6, s.k / 6, -one - s.c / 6, s.c / 6, slope - v0],
    ]
    _, u1, _, v1 = tables.solved(rows)
    return (u1, v1), (u1, v1, s.acceleration(u1, v1, last))


class FurtherSteps:
    """Steps on any system, for `nonlinear_oracle.Run`."""

    s: Any
    rows: list[Any]
    now: Any
    balance: Any

    def _effective(self):
        m, c, k = self.s.mass, self.s.damping, self.s.tangent(self.rows[0].u)
        return m, c, m + self.h / 2 * c + self.h**2 / 4 * k

    def chang(self, p):
        (_, h, _, u0, v0, a0), (m, c, d) = self.now(), self._effective()
        u1 = u0 + h * solve(d, (m + h / 2 * c) @ v0) + h**2 / 2 * solve(d, m @ a0)
        return self.balance(1, Line(u1, 0.0, v0 + h / 2 * a0, h / 2))

    def chen_ricles(self, p):
        (s, h, t, u0, v0, a0), (m, _, d) = self.now(), self._effective()
        change = h * solve(d, m @ a0)
        u1, v1 = u0 + h * v0 + h * change, v0 + change
        return Row(u1, v1, s.acceleration(u1, v1, t + h))

    def chung_lee(self, p):
        s, h, t, u0, v0, a0 = self.now()
        a1 = s.acceleration(u0, v0, t)
        return Row(u0 + h * v0 + h**2 * ((0.5 - p.beta) * a0 + p.beta * a1), v0 + h * (3 * a1 - a0) / 2, a1)

    def adams_moulton3(self, p):
        (_, h, _, u0, v0, a0), am = self.now(), self.rows[-2].a
        known_u, known_v = u0 + h * v0 + h**2 * (10 * a0 - am) / 24, v0 + h * (8 * a0 - am) / 12
        return self.balance(1, Line(known_u, h**2 / 8, known_v, 5 * h / 12))

    def adams_moulton4(self, p):
        (_, h, _, u0, v0, a0), am, amm = self.now(), self.rows[-2].a, self.rows[-3].a
        known_u = u0 + h * v0 + h**2 * (19 * a0 / 40 - am / 10 + 7 * amm / 360)
        return self.balance(1, Line(known_u, 19 * h**2 / 180, v0 + h * (19 * a0 - 5 * am + amm) / 24, 3 * h / 8))

    def bdf_alpha(self, p):
        (_, h, _, u0, v0, a0), (um, vm, _), b = self.now(), self.rows[-2], 1.5 + p.alpha
        known_v = (2 * (1 + p.alpha) * v0 - (0.5 + p.alpha) * vm - p.alpha * h * a0) / b
        known_u = (2 * (1 + p.alpha) * u0 - (0.5 + p.alpha) * um - p.alpha * h * v0) / b
        g = (1 + p.alpha) * h / b
        return self.balance(1, Line(known_u + g * known_v, g**2, known_v, g))

    def zhai(self, p):
        (s, h, t, u0, v0, a0), am = self.now(), self.rows[-2].a if len(self.rows) > 1 else self.rows[-1].a
        u1 = u0 + h * v0 + h**2 * ((0.5 + p.psi) * a0 - p.psi * am)
        v1 = v0 + h * ((1 + p.phi) * a0 - p.phi * am)
        return Row(u1, v1, s.acceleration(u1, v1, t + h))

    def _zhou_tamma(self, p, u0_family):
        """The balance at its own knot, where the unknown is the change of acceleration."""
        (s, h, t, u0, v0, a0), L = self.now(), stages_of_the_new_step(p.rho_1, p.rho_2, p.rho_3, u0_family)
        load = (1 - L.L1) * s.load(t) + L.L1 * s.load(t + h)
        known = u0 + L.L1 * h * v0 + L.L2 * h**2 * a0
        d = (u0 - known) / (L.L3 * h**2)
        for _ in range(60):
            u, v, a = known + L.L3 * h**2 * d, v0 + L.L1 * h * a0 + L.L5 * h * d, a0 + L.L6 * d
            slope = L.L6 * s.mass + L.L5 * h * s.damping + L.L3 * h**2 * s.tangent(u)
            change = solve(slope, s.mass @ a + s.damping @ v + s.force(u) - load)
            d = d - change
            if np.linalg.norm(change) <= 1e-15 * np.linalg.norm(d):
                break
        return Row(u0 + h * v0 + h**2 / 2 * a0 + L.l3 * h**2 * d, v0 + h * a0 + L.l5 * h * d, a0 + d)

    def gssss_u0(self, p):
        return self._zhou_tamma(p, True)

    def gssss_v0(self, p):
        return self._zhou_tamma(p, False)

    def discontinuous_galerkin_p1(self, p):
        """The four fields' values by Newton's iteration on the two velocities, from which displacements follow."""
        s, h, t, u0, v0, _ = self.now()
        n, first, last = len(u0), s.load(t + h / 3), s.load(t + h)
        x = np.concatenate([v0, v0])
        for _ in range(60):
            vp, v1 = x[:n], x[n:]
            up, u1 = u0 + h / 6 * (vp - v1), u0 + h / 2 * (vp + v1)
            Np, N1, Kp, K1 = s.force(up), s.force(u1), s.tangent(up), s.tangent(u1)
            one = s.mass @ (v1 + vp - 2 * v0) / h + s.damping @ (2 * vp + v1) / 3 + (2 * Np + N1) / 3 - first
            two = s.mass @ (v1 - vp) / h + s.damping @ (vp + 2 * v1) / 3 + (Np + 2 * N1) / 3 - (first + last) / 2
            m, c = s.mass / h, s.damping / 3
            J = np.block(
                [
                    [m + 2 * c + h * (Kp / 9 + K1 / 6), m + c + h * (K1 / 6 - Kp / 9)],
                    [-m + c + h * (Kp / 18 + K1 / 3), m + 2 * c + h * (K1 / 3 - Kp / 18)],
                ]
            )
            change = solve(J, np.concatenate([one, two]))
            x = x - change
            if np.linalg.norm(change) <= 1e-15 * np.linalg.norm(x):
                break
        vp, v1 = x[:n], x[n:]
        u1 = u0 + h / 2 * (vp + v1)
        return Row(u1, v1, s.acceleration(u1, v1, t + h))
