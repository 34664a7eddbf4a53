"""Schemes that reviews and programs name, for the oracle: each step written as its paper has it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from lines import Line, Row, norm, solve


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
            if norm(change) <= 1e-15 * norm(d):
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
            if norm(change) <= 1e-15 * norm(x):
                break
        vp, v1 = x[:n], x[n:]
        u1 = u0 + h / 2 * (vp + v1)
        return Row(u1, v1, s.acceleration(u1, v1, t + h))
