"""Structures M, C, K: every scheme against dense stepping of its own equations, modes, and published histories."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from dense_steps import march as dense_march
from sympy import Symbol

import substep as ss

SIZE, STEPS = 8, 12
PULSE = ss.Harmonic(1.0, 2.0, 0.3)
DAMPINGS = ("none", "rayleigh", "full")


@cache
def system() -> dict[str, Any]:
    """Random M and K with frequencies from 0.3 to 30 rad/s, start and load."""
    rng = np.random.default_rng(0)

    def rotation() -> Any:
        return np.linalg.qr(rng.normal(size=(SIZE, SIZE)))[0]

    def symmetric(A: Any) -> Any:
        return (A + A.T) / 2

    Q, P, A = rotation(), rotation(), rng.normal(size=(SIZE, SIZE))
    M = symmetric(Q @ np.diag(rng.uniform(1, 3, SIZE)) @ Q.T)
    L = np.linalg.cholesky(M)
    K = symmetric(L @ P @ np.diag(np.geomspace(0.3, 30.0, SIZE) ** 2) @ P.T @ L.T)
    u, v, p = rng.normal(size=(3, SIZE))
    return {"M": M, "K": K, "u": u, "v": v, "p": p, "full": 0.05 * A @ A.T, "none": None,
            "rayleigh": ss.Rayleigh(0.02, 0.001)}  # fmt: skip


def make(damping: str, **more: Any) -> ss.Structure:
    s = system()
    return ss.structure(s["M"], s["K"], C=s[damping], load=(s["p"], PULSE), u0=s["u"], v0=s["v"], **more)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("scheme", BY_NAME.values(), ids=lambda s: s.name)
def test_every_scheme_is_its_own_equations_on_matrices(scheme: Any, damping: str) -> None:
    """u, h v, h^2 a to 1e-11 of the largest of the three, at steps from which explicit schemes do not grow."""
    s, h = system(), 0.5 / 30.0
    frame = make(damping)
    if not scheme.takes_damping and damping != "none":
        with pytest.raises(ValueError, match="without damping"):
            ss.march(frame, scheme.name, h, STEPS * h)
        return
    handle = ss.scheme(scheme.name)
    values = {Symbol(name): float(x) for name, x in handle.parameters.items()}
    rows = dense_march(
        scheme,
        values,
        s["M"],
        frame.damping,
        s["K"],
        lambda t: s["p"] * PULSE(np.array([t]))[0],
        h,
        STEPS,
        s["u"],
        s["v"],
    )
    expected = np.array(rows) * np.array([1.0, h, h * h])[:, None]
    r = ss.march(frame, handle, h, STEPS * h, account=False)
    found = np.stack([r.u, h * r.v, h * h * r.a], axis=1)
    assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()
    assert r.status == "completed"


BATHE = {  # Finite Element Procedures (1996), ch. 9: u_1 and u_2 after each of 12 steps
    "average_acceleration": (
        ".00673 .0505 .189 .485 .961 1.58 2.23 2.76 3.00 2.85 2.28 1.40",
        ".364 1.35 2.68 4.00 4.95 5.34 5.13 4.48 3.64 2.90 2.44 2.31",
    ),
    "bathe": (
        ".00458 .0445 .183 .486 .979 1.62 2.28 2.81 3.03 2.83 2.21 1.28",
        ".373 1.38 2.73 4.04 4.97 5.31 5.06 4.38 3.55 2.85 2.46 2.40",
    ),
}


@pytest.mark.parametrize("scheme", BATHE)
def test_bathes_example_to_one_unit_of_its_last_digit(scheme: str) -> None:
    example = ss.structure(np.diag([2.0, 1.0]), [[6.0, -2.0], [-2.0, 4.0]], load=([0.0, 10.0], ss.Step(1.0)))
    r = ss.march(example, scheme, dt=0.28, t_end=12 * 0.28)
    for column, texts in zip(r.u[1:].T, BATHE[scheme], strict=True):
        for value, text in zip(column, texts.split(), strict=True):
            unit = 10.0 ** -len(text.split(".")[1])
            assert abs(value - float(text)) <= unit


@pytest.mark.parametrize(("scheme", "solves"), [("kr_alpha", 3), ("average_acceleration", 1), ("bathe", 2)])
def test_no_system_is_solved_twice(scheme: str, solves: int) -> None:
    """The last of kr_alpha's four systems, by which a velocity is reported, is the first one of the next step."""
    calls = []

    def solver(A: Any) -> Any:
        def solve(b: Any) -> Any:
            calls.append(1)
            return np.linalg.solve(A, b)

        return solve

    counts = []
    for steps in (10, 25):
        calls.clear()
        ss.march(make("full", solver=solver), scheme, 0.01, steps * 0.01, account=False)
        counts.append(len(calls))
    assert counts[1] - counts[0] == 15 * solves


def test_sub_steps_with_one_effective_matrix_share_its_factorization() -> None:
    counted = []

    def solver(matrix: Any) -> Any:
        counted.append(matrix)
        inverse = np.linalg.inv(matrix)
        return lambda b: inverse @ b

    for scheme, distinct in (("rho_inf_bathe", 1), ("three_substep", 1), ("four_substep", 1), ("bathe", 2)):
        counted.clear()
        ss.march(make("full", solver=solver, a0=0.0), scheme, 0.01, 0.1)
        assert len(counted) == distinct, scheme
