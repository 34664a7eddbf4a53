"""For the oracle, each step written as its paper has it: schemes that need no tangent, or carry an auxiliary state."""

from typing import Any

from lines import Line, Row, newmark_line, solve


class PredictorSteps:
    """Steps on any system, for `nonlinear_oracle.Run`."""

    s: Any
    rows: list[Any]
    now: Any
    balance: Any
    auxiliary: dict[str, Any]

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

    def first_order_generalized_alpha(self, p):
        """Jansen's scheme for (u, v)' = (v, M^-1(...)); the rate d of u is another one than v."""
        (_, h, _, u0, v0, a0), r, d0 = self.now(), p.rho_inf, self.auxiliary["rate"]
        am, af = (3 - r) / (2 * (1 + r)), 1 / (1 + r)
        g = 0.5 + am - af
        v_p = v0 + (1 - g) * h * a0
        d_p, d_c = (af * v_p + (1 - af) * v0 - (1 - am) * d0) / am, af * g * h / am
        row = self.balance(af, Line(u0 + h * ((1 - g) * d0 + g * d_p), g * h * d_c, v_p, g * h), weights=(am, af))
        self.auxiliary["rate"] = d_p + d_c * row.a
        return row

    def arnold_bruels(self, p):
        """(1 - am) x1 + am x0 = (1 - af) a1 + af a0, Newmark's relations with x, and the balance with a1."""
        (_, h, _, u0, v0, a0), r, x0 = self.now(), p.rho_inf, self.auxiliary["weighted"]
        am, af = (2 * r - 1) / (r + 1), r / (r + 1)
        g = 0.5 + af - am
        b, x_p, x_c = (g + 0.5) ** 2 / 4, (af * a0 - am * x0) / (1 - am), (1 - af) / (1 - am)
        known_u, known_v = u0 + h * v0 + h**2 * ((0.5 - b) * x0 + b * x_p), v0 + h * ((1 - g) * x0 + g * x_p)
        row = self.balance(1, Line(known_u, h**2 * b * x_c, known_v, h * g * x_c))
        self.auxiliary["weighted"] = x_p + x_c * row.a
        return row
