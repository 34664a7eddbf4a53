"""Schemes that reviews and programs name, for the oracle: each step written as its paper has it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from lines import Line, Row, newmark_line, norm, same_line, solve


def stages_of_the_new_step(rho_1: Any, rho_2: Any, rho_3: Any, u0: bool) -> SimpleNamespace:
    """Lambda_1, 2, 3, 5, 6 and lambda_3, 5 of Zhou and Tamma."""
    q, s = (1 + rho_1) * (1 + rho_2), 3 + rho_1 + rho_2 - rho_1 * rho_2
    L6, L3 = (2 + rho_1 + rho_2 + rho_3 - rho_1 * rho_2 * rho_3) / (q * (1 + rho_3)), 1 / (q * (1 + rho_3))
    if u0:
        L1, L2, L5 = 1 / (1 + rho_3), 1 / (2 * (1 + rho_3)), s / (2 * q * (1 + rho_3))
        return SimpleNamespace(L1=L1, L2=L2, L3=L3, L5=L5, L6=L6, l3=1 / q, l5=s / (2 * q))
    L1, L2, L5 = s / (2 * q), 1 / q, 2 / (q * (1 + rho_3))
    return SimpleNamespace(L1=L1, L2=L2, L3=L3, L5=L5, L6=L6, l3=1 / (2 * (1 + rho_3)), l5=1 / (1 + rho_3))


class FurtherSteps:
    """Steps on any system, for `nonlinear_oracle.Run`."""

    s: Any
    rows: list[Any]
    now: Any
    balance: Any

    def _effective(self, b=1 / 4, g=1 / 2):
        m, c, k = self.s.mass, self.s.damping, self.s.tangent(self.rows[0].u)
        return m, c, m + g * self.h * c + b * self.h**2 * k

    def chang(self, p):
        """Newmark's displacement as if the structure were linear, which makes it known, and his velocity."""
        (_, h, _, u0, v0, a0), b, g = self.now(), p.beta, p.gamma
        m, c, d = self._effective(b, g)
        u1 = u0 + solve(d, (m + g * h * c) @ (h * v0) + h**2 * (m / 2 + (g / 2 - b) * h * c) @ a0)
        return self.balance(1, Line(u1, 0.0, v0 + (1 - g) * h * a0, g * h))

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
            if norm(change) <= 1e-15 * norm(d):
                break
        return Row(u0 + h * v0 + h**2 / 2 * a0 + L.l3 * h**2 * d, v0 + h * a0 + L.l5 * h * d, a0 + d)

    def gssss_u0(self, p):
        return self._zhou_tamma(p, True)

    def gssss_v0(self, p):
        return self._zhou_tamma(p, False)

    def beeman(self, p):
        (_, h, _, u0, v0, a0), am = self.now(), self.rows[-2].a if len(self.rows) > 1 else self.rows[-1].a
        return self.balance(1, Line(u0 + h * v0 + h**2 * (4 * a0 - am) / 6, 0.0, v0 + h * (5 * a0 - am) / 6, h / 3))

    def oess(self, p):
        """Newton's iteration for the new acceleration, whose share differs in mass, damping and stiffness."""
        (s, h, t, u0, v0, a0), r = self.now(), p.rho_inf
        m, k = (2 - r) / (1 + r), 1 / (1 + r)
        g = 0.5 + m - k
        c = (2 * r**2 - 7 * r + 11) / (3 * (1 + r) * (3 - r))
        load, old, a1, beta = k * s.load(t + h) + (1 - k) * s.load(t), s.force(u0), a0, k**2
        for _ in range(60):
            u1 = u0 + h * v0 + h**2 * ((0.5 - beta) * a0 + beta * a1)
            v = (1 - c * g) * h * a0 + c * g * h * a1 + v0 + (k - 1) * h * a0
            left = s.mass @ (m * a1 + (1 - m) * a0) + s.damping @ v + k * s.force(u1) + (1 - k) * old - load
            change = solve(m * s.mass + c * g * h * s.damping + k * beta * h**2 * s.tangent(u1), left)
            a1 = a1 - change
            if norm(change) <= 1e-15 * norm(a1):
                break
        return Row(u0 + h * v0 + h**2 * ((0.5 - beta) * a0 + beta * a1), v0 + h * ((1 - g) * a0 + g * a1), a1)

    def ss22(self, p):
        (s, h, t, u0, v0, _), load = self.now(), (1 - p.theta_1) * self.s.load(self.t)
        load = load + p.theta_1 * s.load(t + h)
        mean = Line(u0 + p.theta_1 * h * v0, p.theta_2 * h**2 / 2, v0, p.theta_1 * h)
        a = self.balance(None, mean, load=load).a
        u1, v1 = u0 + h * v0 + h**2 / 2 * a, v0 + h * a
        return Row(u1, v1, s.acceleration(u1, v1, t + h))

    def ss32(self, p):
        """For the rate of the acceleration, of which every entry of the balance is a line."""
        s, h, t, u0, v0, a0 = self.now()
        q, r, w = p.theta_1, p.theta_2, p.theta_3
        load, x = (1 - q) * s.load(t) + q * s.load(t + h), 0 * a0
        for _ in range(60):
            u = u0 + q * h * v0 + r * h**2 / 2 * a0 + w * h**3 / 6 * x
            v, a = v0 + q * h * a0 + r * h**2 / 2 * x, a0 + q * h * x
            slope = q * h * s.mass + r * h**2 / 2 * s.damping + w * h**3 / 6 * s.tangent(u)
            change = solve(slope, s.mass @ a + s.damping @ v + s.force(u) - load)
            x = x - change
            if norm(change) <= 1e-15 * norm(x):
                break
        return Row(u0 + h * v0 + h**2 / 2 * a0 + h**3 / 6 * x, v0 + h * a0 + h**2 / 2 * x, a0 + h * x)

    def gui_lambda(self, p):
        (s, h, t, u0, v0, a0), q = self.now(), p.lambda_g
        d = 2 * q * s.mass + q * h * s.damping + 2 * h**2 * s.tangent(self.rows[0].u)
        change = 2 * q * h * solve(d, s.mass @ a0)
        u1, v1 = u0 + h * v0 + h * change, v0 + change
        return Row(u1, v1, s.acceleration(u1, v1, t + h))

    def mkr_alpha(self, p):
        (s, h, t, u0, v0, a0), r = self.now(), p.rho_inf
        af, am = 1 / (1 + r), 1 - (2 * r**3 + r**2 - 1) / (r**3 + r**2 + r + 1)
        gamma = 0.5 + am - af
        beta, m, c, k = (0.5 + gamma) / 2, s.mass, s.damping, s.tangent(self.rows[0].u)
        d = m + gamma * h * c + beta * h**2 * k
        alpha3 = solve(d, am * m + af * gamma * h * c + af * beta * h**2 * k)
        pushed = solve(d, m @ a0)
        u1, v1 = u0 + h * v0 + h**2 * (0.5 + gamma) * pushed, v0 + h * pushed
        vf, force = af * v1 + (1 - af) * v0, af * s.force(u1) + (1 - af) * s.force(u0)
        mean = solve(m, s.load(t + af * h) - c @ vf - force)
        return Row(u1, v1, solve(alpha3, mean - (a0 - alpha3 @ a0)))

    def trapezoid_trapezoid_backward(self, p):
        (*_, u0, v0, a0), third = self.now(), self.h / 3
        first = self.balance(self.one / 3, newmark_line(Row(u0, v0, a0), third, 0.25, 0.5))
        second = self.balance(2 * self.one / 3, newmark_line(first, third, 0.25, 0.5), first)
        lead = 1.5 + p.cubic  # of the new value in (nabla + nabla^2/2 + c nabla^3) y

        def known(y0, y1, y2):
            return ((2 + 3 * p.cubic) * y2 - (0.5 + 3 * p.cubic) * y1 + p.cubic * y0) / lead

        us, vs = (known(row0, row1, row2) for row0, row1, row2 in zip((u0, v0), first[:2], second[:2], strict=True))
        return self.balance(1, same_line(us, vs, third / lead), second)

    def gsse(self, p):
        (s, h, t, u0, v0, a0), b, r = self.now(), p.rho_b, p.rho_s
        c = (2 + r - b * r) / ((1 + b) * (1 + r))
        B = b * (b - 1) * r**3 + (b - 1) * (b**2 + 6 * b - 1) * r**2 / 2 + (1 - 5 * b) * r + 1 - b
        B = B / (-(1 + b) * (1 + r) * (b * r - r - 2) ** 2)
        up, vp = u0 + c * h * v0 + c**2 * h**2 / 2 * a0, v0 + c * h * a0
        ap = s.acceleration(up, vp, t + c * h)
        u1 = u0 + h * v0 + h**2 * ((0.5 - B) * a0 + B * ap)
        return Row(u1, v0 + h * ((1 - 1 / (2 * c)) * a0 + ap / (2 * c)), a0 + (ap - a0) / c)

    def tarnow_simo(self, p):
        row, tau = self.rows[-1], 0 * self.h
        for weight in (p.weight, 1 - 2 * p.weight, p.weight):
            tau, w = tau + weight, weight * self.h
            known_u, known_v = row.u + w * row.v + w**2 / 4 * row.a, row.v + w / 2 * row.a
            row = self.balance(tau, Line(known_u, w**2 / 4, known_v, w / 2), row)
        return row

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
            if norm(change) <= 1e-15 * norm(x):
                break
        vp, v1 = x[:n], x[n:]
        u1 = u0 + h / 2 * (vp + v1)
        return Row(u1, v1, s.acceleration(u1, v1, t + h))
