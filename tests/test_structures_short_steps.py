"""Steps of structures from far below to far above their periods, against 50 digits."""

from typing import Any

import mpmath
import numpy as np
import pytest
from declared import ALL
from dense_steps import march as dense_march
from substep_derive.declare.symbols import h, knot
from sympy import Integer, Symbol

import substep as ss
from substep.structures.march.scheme_plan import step_of
from substep.structures.march.steps import Run

M = np.array([[2.0, 0.3], [0.3, 1.0]])
STIFFNESS = np.array([[3.0, -1.0], [-1.0, 2.0]])
START = np.array([[1.0, -0.5], [0.3, 0.7]])  # u, and v/Omega
IMPLICIT = [s for s in ALL if any(x.implicit for x in step_of(ss.scheme(s.name), 1.0).systems)]
FEW, MANY = 1.0, 1e-4  # Omega of a step without, and with, the product with K


def damped(Omega: float, rayleigh: bool = True) -> ss.Structure:
    """With frequencies near Omega, for steps of h = 1."""
    K, C = Omega**2 * STIFFNESS, ss.Rayleigh(0.0625 * Omega, 0.03125 / Omega)
    return ss.structure(M, K, C=C if rayleigh else C.matrix(M, K), u0=START[0], v0=Omega * START[1])


def exact(x: Any) -> Any:
    return np.vectorize(lambda value: mpmath.mpf(float(value)), otypes=[object])(x)


def weight(scheme: Any, values: dict[Symbol, Any]) -> float:
    """The sum of the sizes of the weights of accelerations in v_1, by which their rounding enters it; at least 1.

    It is 1 where all are positive, and 17 for sdirk4, which has the weights 125/16 and -85/12.
    """
    new = scheme.relations.get(knot(1).v, Integer(0)).subs({**values, h: 1}).expand()
    weights = [new.coeff(s) for s in new.free_symbols if s.name[0] == "a"]
    return max(1.0, sum(abs(float(x)) for x in weights if x.is_number))


@pytest.mark.parametrize("scheme", IMPLICIT, ids=lambda s: s.name)
def test_steps_of_any_length_keep_their_digits(scheme: Any) -> None:
    """u, v and a to 1e-14, each relative to its own largest, of a stiff step to the rounding of h^2 a.

    Near 0.2, just before the product with K is kept, to two digits less than rounding. A scheme that keeps
    displacements alone takes v from their differences, which are small beside them.
    """
    handle, n = ss.scheme(scheme.name), 4
    for Omega in (1e-4, 1e-2, 0.2, 1.0, 1e2):
        s = damped(Omega)
        with mpmath.workdps(50):
            values = {Symbol(name): mpmath.mpf(float(x)) for name, x in handle.parameters.items()}
            K, C = exact(s.K), exact(M) * mpmath.mpf(s.C.alpha) + exact(s.K) * mpmath.mpf(s.C.beta)  # type: ignore[union-attr]
            one, u, v = mpmath.mpf(1), exact(s.u0), exact(s.v0)
            expected = np.array(dense_march(scheme, values, exact(M), C, K, lambda t: 0 * u, one, n, u, v))  # noqa: B023
            r = ss.march(s, handle, 1.0, float(n), account=False)
            off, size = (
                abs(x).astype(float).max(axis=(0, 2)) for x in (expected - np.stack([r.u, r.v, r.a], axis=1), expected)
            )
        if all(symbol.name[0] == "u" for symbol in scheme.state):
            size[1:] = np.maximum(size[1:], size[0])
        bound = (1e-13 if Omega == 0.2 else max(1e-14, 2e-15 * Omega**2)) * weight(scheme, values)
        assert (off <= bound * size).all(), (Omega, off / size)


@pytest.mark.parametrize("scheme", IMPLICIT, ids=lambda s: s.name)
def test_one_product_a_balance_unless_a_step_is_short(scheme: Any) -> None:
    """With Rayleigh damping; with a matrix of damping its product comes to it in both."""
    for rayleigh, Omega, names in ((True, FEW, "M"), (True, MANY, "MK"), (False, FEW, "MC"), (False, MANY, "MCK")):
        s, handle = damped(Omega, rayleigh), ss.scheme(scheme.name)
        plan = step_of(handle, 1.0)
        for system, solver in zip(plan.systems, Run(s, handle, 1.0).prepared(plan).systems, strict=True):
            if system.linear_stiffness[: system.place].any() and system.implicit and not system.together:
                assert len(solver.matrices) <= len(names)  # type: ignore[union-attr]
                assert any(matrix is s.K for matrix in solver.matrices) == ("K" in names)  # type: ignore[union-attr]
