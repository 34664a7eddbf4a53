"""Algebra that holds for any parameters: identities of the derived matrices (hypothesis)."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from substep_derive import derive
from substep_derive.declare.symbols import Omega, xi
from sympy import Matrix, Rational, Symbol, eye

import substep as ss

fractions = st.fractions(min_value=0, max_value=1, max_denominator=40)
COMPOSITE = derive("newmark_bdf2")


def exact(value: object) -> Rational:
    return Rational(str(value))


@settings(max_examples=25)
@given(
    split=st.fractions(min_value="1/40", max_value="39/40", max_denominator=40),
    b=fractions,
    c=fractions,
    omega=fractions.map(lambda x: 10 * x),
    damping=fractions,
)
def test_invariants_of_the_composite(split, b, c, omega, damping) -> None:
    """The state after a step obeys the equation of motion, and at Omega = 0 the motion is uniform."""
    values = dict(zip(("gamma_t", "beta", "gamma"), (split, b, c), strict=True))
    where = {Symbol(k): exact(v) for k, v in values.items()} | {Omega: exact(omega), xi: exact(damping)}
    A = COMPOSITE.A.subs(where)
    balance = Matrix([[where[Omega] ** 2, 2 * where[xi] * where[Omega], 1]])
    assert balance * A == Matrix([[0, 0, 0]])  # so that 0 is an eigenvalue, and a is algebraic
    free = COMPOSITE.A.subs(where | {Omega: 0})
    assert free * Matrix([3, 2, 0]) == Matrix([5, 2, 0])
    assert COMPOSITE.det == 0


@settings(max_examples=25)
@given(omega=st.floats(0.0, 1e6), damping=st.floats(0.0, 3.0))
def test_compiled_matrix_and_radius_agree_with_numpy(omega: float, damping: float) -> None:
    for s in (ss.scheme("bathe"), ss.scheme("newmark", beta=0.3, gamma=0.55)):
        A = s.amplification(omega, damping)
        radius = s.spectral_radius(omega, damping)
        found = np.abs(np.linalg.eigvals(A)).max()
        assert abs(radius - found) <= 1e-6 * max(1.0, np.abs(A).max())


@settings(max_examples=25)
@given(omega=fractions.map(lambda x: 10 * x), damping=fractions)
def test_increment_is_the_matrix_less_one_with_a_eliminated(omega, damping) -> None:
    s = ss.scheme("newmark_bdf2", gamma_t=0.4, beta=0.36, gamma=0.7)
    increment, load, _, _ = s.coefficients(float(omega), float(damping))
    A = s.amplification(float(omega), float(damping))
    without = A[:2, :2] - np.outer(A[:2, 2], [float(omega) ** 2, 2 * float(damping * omega)])
    assert np.allclose(increment[0] + np.eye(2), without, rtol=0, atol=1e-13 * max(1, np.abs(without).max()))
    # a constant load of omega^2 holds the oscillator at rest at u = 1
    rest = increment[0] @ [1, 0] + load[0].sum(axis=1) * float(omega) ** 2
    assert np.abs(rest).max() <= 1e-12 * max(1, float(omega) ** 2)


def test_identity_is_what_remains_at_zero_frequency_of_newmark() -> None:
    A = derive("newmark").A.subs(Omega, 0)
    assert A[:2, :2] == eye(2) + Matrix([[0, 1], [0, 0]])
