"""Schemes that need no tangent where the motion has got to, for the oracle: each step written as its paper has it."""

from typing import Any

from lines import Row, newmark_line, solve


class PredictorSteps:
    """Steps on any system, for `nonlinear_oracle.Run`."""

    s: Any
    rows: list[Any]
    now: Any
    balance: Any

    def fully_explicit_generalized_alpha(self, p):
        (s, h, t, u0, v0, a0), r = self.now(), p.rho_inf
        am, beta = (2 * r - 1) / (1 + r), (r * r - 5 * r + 10) / (6 * (r - 2) * (r + 1))
        new = 1 - (am - 0.5)
        up, v1 = u0 + h * v0 + h**2 * (0.5 - beta) * a0, v0 + h * a0
        force = new * s.force(up) + (1 - new) * s.force(u0)
        mean = solve(s.mass, s.load(t + new * h) - s.damping @ (new * v1 + (1 - new) * v0) - force)
        a1 = (mean - am * a0) / (1 - am)
        return Row(up + beta * h**2 * a1, v1, a1)

    def alpha_os(self, p):
        (s, h, t, u0, v0, a0), w = self.now(), 1 + p.alpha
        line, load = newmark_line(self.rows[-1], h, (1 - p.alpha) ** 2 / 4, 0.5 - p.alpha), w * s.load(t + h)
        k = line.c_u * s.tangent(self.rows[0].u)  # of the start
        old = s.force(u0 - line.c_u * a0) + k @ a0
        damped = s.damping @ (w * line.v_p + (1 - w) * v0)
        known = load - p.alpha * s.load(t) - damped - w * s.force(line.u_p) - (1 - w) * old
        return line.end(solve(s.mass + w * line.c_v * s.damping + w * k, known))

    def lsrt2(self, p):
        """Rosenbrock's stages k_1 and k_2 of (u, v), each from its own pair of linear equations."""
        (s, h, t, u0, v0, a0), g = self.now(), p.gamma
        m, c, k = s.mass, s.damping, s.tangent(self.rows[0].u)

        def stage(right_u, right_v):
            """(ku, kv) with ku - g h kv = h right_u and M kv + g h (K ku + C kv) = h M right_v."""
            kv = solve(m + g * h * c + g**2 * h**2 * k, h * (m @ right_v) - g * h**2 * (k @ right_u))
            return h * right_u + g * h * kv, kv

        ku, kv = stage(v0, a0)
        q = 2 * g - g * g  # the place at which R(oo) = 1 - (2 g - q)/g^2 vanishes: 1/2 for the paper's gamma
        um, vm = u0 + q * ku, v0 + q * kv
        bent = solve(m, k @ ku + c @ kv)
        lu, lv = stage(vm - g * kv, s.acceleration(um, vm, t + q * h) + g * bent)
        return Row(u0 + lu, v0 + lv, s.acceleration(u0 + lu, v0 + lv, t + h))
