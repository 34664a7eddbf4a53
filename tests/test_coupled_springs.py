"""Springs that each strain several degrees of freedom, on composite schemes: against plain stepping of the equations.

Schemes by their tableaux, whose rows are the sub-steps: u_k = u_0 + h sum of w_kj v_j, v_k = v_0 + h sum of w_kj a_j,
and M a + C v + K u + B^T q = f at each. Forces by the second account of each law, roots by Newton's iteration, halved.
"""

from typing import Any

import law_paths
import numpy as np
import pytest
from test_compiled_steps import by_kernel, one_by_one

import substep as ss

Array = Any
H, STEPS, ALPHA = 0.02, 200, 0.05


def three_substep(gamma: float, rho_inf: float = 0.5) -> list[list[float]]:
    """Zhang et al. (2020), by the coefficients of their section 2."""
    d_1, d_2, d_3 = 1 - 1.5 * gamma, 0.5 - 1.5 * gamma + 0.75 * gamma**2, rho_inf * gamma**3 / 8
    first = gamma / 8 + d_1 / 4 + d_2 / (2 * gamma) + d_3 / gamma**2
    second = gamma / 2 + d_1 / 2 - 2 * d_3 / gamma**2
    return [
        [gamma / 2, gamma / 2], [gamma / 2, gamma, gamma / 2],
        [1 - first - second - gamma / 2, second, first, gamma / 2],
    ]  # fmt: skip


TABLEAUX = {
    "average_acceleration": [[0.5, 0.5]],
    "bathe": [[0.25, 0.25], [1 / 3, 1 / 3, 1 / 3]],
    "three_substep": three_substep(float(ss.scheme("three_substep").parameters["gamma"])),
}


class Coupled:
    """Four masses in a chain, and between any of them five springs by clough, and dampers c |v|^0.5."""

    def __init__(self, seed: int, scale: float, dampers: int = 0) -> None:
        g = np.random.default_rng(seed)
        chain, n = np.eye(4) - np.eye(4, k=-1), 5 + dampers
        self.m, self.K = g.uniform(1, 2, 4), 0.2 * chain.T @ np.diag(g.uniform(150, 300, 4)) @ chain
        self.C, self.B = 0.3 * np.eye(4) + 0.05 * chain.T @ chain, g.normal(size=(n, 4))
        self.k, self.q_y, self.c = g.uniform(100, 300, 5), g.uniform(1, 4, 5), g.uniform(0.3, 1, dampers)
        self.record = ss.Record(0.05, scale * g.normal(size=90))

    def structure(self) -> ss.Structure:
        springs: list[Any] = [(self.B[:5], ss.law("clough", k=self.k, q_y=self.q_y, alpha=ALPHA))]
        if len(self.c):
            springs.append((self.B[5:], ss.law("power_damper", c=self.c, exponent=0.5)))
        return ss.structure(np.diag(self.m), self.K, C=self.C, springs=springs).ground_motion(self.record, 1.0)

    def load(self, t: float) -> Array:
        return -self.m * float(self.record(np.array(t)))

    def stepped(self, tableau: list[list[float]]) -> Array:
        """The displacements (n + 1, 4)."""
        oracles = [law_paths.clough(k, q, ALPHA) for k, q in zip(self.k, self.q_y, strict=True)]
        memory, rows = [start for start, _ in oracles], [(np.zeros(4), np.zeros(4), self.load(0.0) / self.m)]

        def asked(e: Array) -> tuple[Array, list[Any]]:
            found = [follow(x, old, 0.0) for (_, follow), x, old in zip(oracles, e, memory, strict=True)]
            return np.array([q for q, _ in found]), [new for _, new in found]

        for n in range(STEPS):
            knots = [rows[-1]]
            for *weights, last in tableau:
                u, v = (
                    rows[-1][kind] + H * sum(w * x[kind + 1] for w, x in zip(weights, knots, strict=True))
                    for kind in (0, 1)
                )
                u, c = u + H * last * v, H * last
                load = self.load((n + sum(weights) + last) * H)
                a = self.root(u, v, c, load, lambda e: asked(e)[0])
                knots.append((u + c**2 * a, v + c * a, a))
                memory = asked(self.B @ knots[-1][0])[1]
            rows.append(knots[-1])
        return np.array([u for u, _, _ in rows])

    def root(self, u: Array, v: Array, c: float, load: Array, force: Any) -> Array:
        """The a at which forces balance at u + c^2 a and v + c a."""
        B, linear = self.B, np.diag(self.m) + c * self.C + c**2 * self.K

        def left(a: Array) -> Array:
            return linear @ a + self.C @ v + self.K @ u + B.T @ force(B @ (u + c**2 * a)) - load

        a = np.zeros(4)
        for _ in range(100):
            residual = left(a)
            if np.abs(residual).max() <= 1e-13 * (1 + np.abs(load).max()):
                break
            e = B @ (u + c**2 * a)
            slopes = (force(e + 1e-8) - force(e - 1e-8)) / 2e-8
            change = np.linalg.solve(linear + c**2 * B.T @ np.diag(slopes) @ B, -residual)
            while np.abs(left(a + change)).max() > np.abs(residual).max() and np.abs(change).max() > 1e-12:
                change = 0.5 * change
            a = a + change
        assert np.abs(left(a)).max() <= 1e-11 * (1 + np.abs(load).max())
        return a


@pytest.mark.parametrize("scheme", TABLEAUX)
@pytest.mark.parametrize(("seed", "scale"), [(1, 2.0), (7, 4.0)])
def test_both_marches_are_plain_stepping(scheme: str, seed: int, scale: float) -> None:
    """Where some springs never yield, which pass along one line again and again, and where all yield far."""
    model = Coupled(seed, scale)
    u, s = model.stepped(TABLEAUX[scheme]), model.structure()
    for march in (by_kernel, one_by_one):
        r = march(s, scheme, dt=H, t_end=STEPS * H, account=False)
        ductility = np.abs(r.springs.elongations).max(axis=0) * model.k / model.q_y
        assert ductility.max() > 10 if scale > 2 else ductility.min() < 1 < ductility.max()
        assert np.abs(r.u - u).max() <= 1e-11 * np.abs(u).max()


@pytest.mark.parametrize(("scheme", "seed"), [("bathe", 202), ("three_substep", 197)])
def test_dampers_that_come_to_rest(scheme: str, seed: int) -> None:
    """Their slopes are infinite there, so that full changes would go to and fro: forces balance, in few iterations."""
    model = Coupled(seed, 0.5, dampers=5)
    s = model.structure()
    for march in (by_kernel, one_by_one):
        r = march(s, scheme, dt=H, t_end=STEPS * H, account=False)
        assert r.status == "completed"
        rates = r.v @ model.B[5:].T
        assert np.allclose(
            r.springs.forces[:, 5:], model.c * np.sign(rates) * np.sqrt(np.abs(rates)), rtol=0, atol=1e-12
        )
        forces = r.absolute_a * model.m + r.v @ model.C.T + r.u @ model.K.T + r.springs.forces @ model.B
        assert np.abs(forces[1:]).max() <= 1e-7 * np.abs(r.absolute_a * model.m).max()
        assert r.newton_iterations.max() < 15
