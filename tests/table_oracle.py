"""For the oracle, steps by a table of coefficients: Runge-Kutta, Nystrom, extrapolation and composition."""

from typing import Any

import numpy as np
import tables
from lines import Row, newmark_line, norm, same_line, solve


class TableSteps:
    """Steps on any system, for `nonlinear_oracle.Run`."""

    parameters: dict[str, float]
    rows: list[Any]
    h: Any
    one: Any
    kind: Any
    now: Any
    balance: Any

    def runge_kutta(self, p):
        """k = h f(y0 + c k, t + c h) in turn, then y1 = y0 + sum of b k, for the stages (c, b)."""
        s, h, t, u0, v0, _ = self.now()
        ku, kv, u1, v1 = 0 * u0, 0 * v0, u0, v0
        for c, b in ((self.one * c, self.one * b.numerator / b.denominator) for c, b in p.stages):
            ku, kv = h * (v0 + c * kv), h * s.acceleration(u0 + c * ku, v0 + c * kv, t + c * h)
            u1, v1 = u1 + b * ku, v1 + b * kv
        return Row(u1, v1, s.acceleration(u1, v1, t + h))

    def table(self, p):
        """Every stage with its own slopes; a stage on the diagonal is solved for its acceleration."""
        (s, h, t, u0, v0, a0), table = self.now(), tables.of(p.table, self.parameters, self.kind)
        (A, b, c), stages = table, self.together(table) if tables.coupled(table) else []
        end = tables.last_is_end(table)
        for i, (row, tau) in [*enumerate(zip(A, c, strict=True))][len(stages) :]:
            u = u0 + h * sum((w * stage.v for w, stage in zip(row, stages, strict=False)), 0 * u0)
            v = v0 + h * sum((w * stage.a for w, stage in zip(row, stages, strict=False)), 0 * u0)
            if row[i]:
                last = stages[-1] if stages else None
                stages.append(self.balance(tau, same_line(u, v, h * row[i]), last))
            else:
                stages.append(Row(u, v, a0 if i == 0 and end else s.acceleration(u, v, t + tau * h)))
        if end:
            return stages[-1]
        u1 = u0 + h * sum(w * stage.v for w, stage in zip(b, stages, strict=True))
        v1 = v0 + h * sum(w * stage.a for w, stage in zip(b, stages, strict=True))
        return Row(u1, v1, s.acceleration(u1, v1, t + h))

    def together(self, table):
        """All stages by Newton's iteration for their accelerations, from the displacement u0."""
        (s, h, t, u0, v0, a0), (A, _, c) = self.now(), table
        known = int(tables.first_is_start(table) and tables.last_is_end(table))
        A, d, first = np.array(A), len(u0), [a0][:known]
        inner = A[known:, known:]
        a = np.vstack([*first, solve(h * inner @ inner, -np.outer(np.array(c)[known:], v0))])
        for _ in range(60):
            v = v0 + h * A @ a
            u = u0 + h * A @ v
            wrong, slopes = [], []
            for i in range(known, len(c)):
                wrong.append(s.mass @ a[i] + s.damping @ v[i] + s.force(u[i]) - s.load(t + c[i] * h))
                by = [
                    (i == j) * s.mass + h * A[i, j] * s.damping + h**2 * (A @ A)[i, j] * s.tangent(u[i])
                    for j in range(known, len(c))
                ]
                slopes.append(np.hstack(by))
            change = solve(np.vstack(slopes), np.concatenate(wrong)).reshape(-1, d)
            a[known:] -= change
            if norm(change) <= 1e-15 * norm(a):
                break
        v = v0 + h * A @ a
        return [Row(*x) for x in zip(u0 + h * A @ v, v, a, strict=True)]

    def nystrom(self, p):
        (s, h, t, u0, v0, a0), table = self.now(), p.table()
        assert not s.damping.any(), "a Nystrom table is for u'' = g(t, u)"
        found, kind = [a0], self.kind
        for row, c in zip(table.A_bar[1:], map(kind, table.c[1:]), strict=True):
            u = u0 + c * h * v0 + h**2 * sum(kind(w) * a for w, a in zip(row, found, strict=False))
            found.append(s.acceleration(u, 0 * v0, t + c * h))
        u1 = u0 + h * v0 + h**2 * sum(kind(w) * a for w, a in zip(table.b_bar, found, strict=False))
        return Row(u1, v0 + h * sum(kind(w) * a for w, a in zip(table.b, found, strict=False)), found[-1])

    def stoermer(self, p):
        """Stoermer's rule with n sub-steps, for each n, extrapolated."""
        (s, h, t, *given), ends = self.now(), {}
        for n in p.counts:
            u, v, a = given
            for j in range(1, n + 1):
                v = v + h / n * a / 2
                u = u + h / n * v
                a = s.acceleration(u, 0 * v, t + h * j / n)
                v = v + h / n * a / 2
            ends[n] = u, v
        u, v = (tables.extrapolated({n: end[i] for n, end in ends.items()}) for i in range(2))
        return Row(u, v, s.acceleration(u, 0 * v, t + h))

    def composed(self, p):
        """Central differences over parts of the step."""
        row, tau = self.rows[-1], 0 * self.h
        for weight in map(self.kind, p.weights(**self.parameters)):
            tau += weight
            row = self.balance(tau, newmark_line(row, weight * self.h, 0.0, 0.5), row)
        return row
