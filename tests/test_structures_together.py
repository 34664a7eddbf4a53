"""Balances that are solved together, on structures: against tables typed from their papers, modes and SciPy."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from declared import TOGETHER
from nonlinear_oracle import System, history
from scipy import sparse
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from substep_derive import tableau

import substep as ss

Array = np.ndarray[Any, Any]
N, H, STEPS, OMEGA = 6, 0.3, 8, 1.7
rng = np.random.default_rng(5)
_mixed = rng.normal(size=(N, N))
M = np.diag(rng.uniform(1.0, 3.0, N)) + 0.1 * np.diag(np.ones(N - 1), 1) + 0.1 * np.diag(np.ones(N - 1), -1)
CHAIN = np.diff(np.eye(N), axis=0)
K = CHAIN.T @ np.diag([4.0, 50.0, 3.0, 9.0, 1.0]) @ CHAIN  # free at both ends: singular
C = 0.05 * _mixed @ _mixed.T  # whose modes are coupled
P, U0, V0 = rng.normal(size=(3, N))
T = np.delete(np.eye(N), 2, axis=1) + np.outer(np.eye(N)[2], [0.5, 0.5, 0.0, 0.0, 0.0])  # u_2 = (u_0 + u_1)/2


def force(t: float) -> Array:
    return P * np.sin(OMEGA * t + 0.4)


def stepped(name: str, matrices: tuple[Array, Array, Array], p: Callable[[float], Array], u: Array, v: Array) -> Array:
    """u and v (steps + 1, 2, n) of the oracle."""
    m, c, k = matrices
    system = System(m, c, lambda u: k @ u, lambda u: k, p)
    values = {key: float(x) for key, x in ss.scheme(name).parameters.items()}
    rows = history(name, values, system, H, STEPS, u, v, system.acceleration(u, v, 0.0))
    return np.stack(rows[:2], axis=1)


def in_real_numbers(matrix: Any) -> Callable[[Array], Array]:
    """A solver of a user's own, which takes symmetric real matrices."""
    full = matrix.toarray() if sparse.issparse(matrix) else matrix
    assert full.dtype == np.float64
    assert np.abs(full - full.T).max() < 1e-12 * np.abs(full).max()
    return lambda b: np.linalg.solve(full, b)


@pytest.mark.parametrize("name", TOGETHER)
def test_steps_are_those_of_the_table(name: str) -> None:
    """Damped, forced, with a singular K: dense, sparse with each solver, and with constraints."""
    harmonic = P, ss.Harmonic(1.0, OMEGA, 0.4)
    expected = stepped(name, (M, C, K), force, U0, V0)
    for solver in ("auto", "superlu", "pardiso", in_real_numbers):
        convert: Any = np.array if solver == "auto" else sparse.csr_array
        s = ss.structure(convert(M), convert(K), C=convert(C), load=harmonic, u0=U0, v0=V0, solver=solver)
        r = ss.march(s, name, dt=H, t_end=STEPS * H, account=False)
        assert np.abs(np.stack([r.u, r.v], axis=1) - expected).max() < 1e-10, solver
    reduced = tuple(T.T @ x @ T for x in (M, C, K))
    free = stepped(name, reduced, lambda t: T.T @ force(t), U0[:5], V0[:5])
    s = ss.structure(M, K, C=C, load=harmonic, u0=T @ U0[:5], v0=T @ V0[:5], constraints=T)
    r = ss.march(s, name, dt=H, t_end=STEPS * H, account=False)
    assert np.abs(np.stack([r.u, r.v], axis=1) - free @ T.T).max() < 1e-10


@pytest.mark.parametrize("name", TOGETHER)
def test_each_mode_is_amplified_as_an_oscillator(name: str) -> None:
    stiffness = K + np.eye(N)
    squares, shapes = eigh(stiffness, M)
    s = ss.structure(M, stiffness, C=0.02 * M, u0=shapes.sum(axis=1), a0=-shapes @ squares)
    r = ss.march(s, name, dt=H, t_end=STEPS * H, account=False)
    inverse = np.linalg.inv(shapes)
    for omega, row in zip(np.sqrt(squares), inverse, strict=True):
        A = ss.scheme(name).amplification(omega * H, 0.01 / omega)
        x = np.array([1.0, 0.0, -((omega * H) ** 2)])[: len(A)]
        for u in r.u:
            assert abs(row @ u - x[0]) < 1e-12
            x = A @ x


@pytest.mark.parametrize("solver", ["auto", "superlu"])
def test_a_hardening_chain_is_that_of_scipy(solver: str) -> None:
    """N(t, u, v) with its tangent by u and by v, in steps that keep a tangent and with one in every iteration."""

    def internal(t: float, u: Array, v: Array) -> Array:
        e = CHAIN @ u
        return CHAIN.T @ (4.0 * e + 5.0 * e**3) + 0.3 * np.cos(t) * v

    def tangent(t: float, u: Array, v: Array) -> Any:
        e = CHAIN @ u
        return convert(CHAIN.T @ np.diag(4.0 + 15.0 * e**2) @ CHAIN), convert(0.3 * np.cos(t) * np.eye(N))

    convert: Any = np.array if solver == "auto" else sparse.csr_array
    s = ss.structure(convert(M), C=convert(C), internal_force=internal, tangent=tangent, u0=0.3 * U0, v0=V0,
                     solver=solver, load=(P, ss.Harmonic(1.0, OMEGA, 0.4)))  # fmt: skip

    def rate(t: float, y: Array) -> Array:
        return np.r_[y[N:], np.linalg.solve(M, force(t) - C @ y[N:] - internal(t, y[:N], y[N:]))]

    y = solve_ivp(rate, (0.0, 0.5), np.r_[0.3 * U0, V0], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    for name, newton in (("gauss3", "simplified"), ("gauss3", "full"), ("radau_iia3", "simplified")):
        errors = []
        for n in (4, 8):
            r = ss.march(s, name, dt=0.5 / n, t_end=0.5, account=False, newton=newton)  # type: ignore[arg-type]
            assert r.newton_iterations[:, 0].min() >= 2
            assert not r.newton_iterations[:, 1:].any()
            errors.append(np.abs(np.r_[r.u[-1], r.v[-1]] - y).max())
        order = 6 if name == "gauss3" else 5
        assert errors[1] < 1e-5
        assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.8)


def test_what_cannot_be_taken_apart_is_refused() -> None:
    """A table with one eigenvalue, 1/2, twice, and one eigenvector."""
    half, quarter = Fraction(1, 2), Fraction(1, 4)
    own = tableau("singly", A=((quarter, -quarter), (quarter, 3 * quarter)), b=(half, half), c=(0, 1))
    with pytest.raises(ValueError, match="singly solves balances together .* have no eigenvectors in common: expected"):
        ss.march(ss.structure(M, K, u0=U0), own, dt=H, t_end=H)


def test_modal_damping_beside_an_internal_force_is_refused() -> None:
    s = ss.structure(M, C=ss.modal_damping(0.02, modes=2), internal_force=lambda u: K @ u, tangent=lambda u: K, u0=U0)
    with pytest.raises(ValueError, match="expected damping and tangents as dense or sparse matrices where balances"):
        ss.march(s, "gauss2", dt=H, t_end=H, account=False)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("name", ["gauss2", "radau_iia3", "lobatto_iiic3", "discontinuous_galerkin_p1"])
@pytest.mark.parametrize("n", [1, 2])
def test_nonlinear_structures_in_chosen_steps(name: str, n: int) -> None:
    """Against SciPy; one and two degrees of freedom, as the error was once filtered by the matrix of all blocks."""
    frame = ss.structure(
        np.eye(n), internal_force=lambda u: 100.0 * u + u**3, tangent=lambda u: np.diag(100.0 + 3.0 * u**2), u0=1.0
    )
    r = ss.march(frame, name, tol=1e-7, t_end=0.5)
    wanted = solve_ivp(
        lambda _, y: [y[1], -100.0 * y[0] - y[0] ** 3], (0.0, 0.5), [1.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13
    )
    assert r.status == "completed"
    assert np.abs(r.u[-1] - wanted.y[0, -1]).max() < 1e-5
