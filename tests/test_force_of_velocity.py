"""Internal forces N(u, v): under every scheme the motion is SciPy's, or the structure is refused."""

import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, OF_STIFFNESS
from scipy.integrate import solve_ivp
from substep_kernels.facts import CATALOGUE

import substep as ss

UNDAMPED = [name for name in CATALOGUE if not ss.scheme(name).info.damping]
OF_COEFFICIENTS = OF_STIFFNESS  # which take C into account at the start only
M = np.array([[2.0, 0.3], [0.3, 1.0]])
K = np.array([[12.0, -4.0], [-4.0, 8.0]])
C = np.array([[0.6, -0.2], [-0.2, 0.3]])
Function = Callable[..., Any]


def spring(force: Function, tangent: Function, potential: Function, u0: float) -> ss.Structure:
    """A mass of one."""
    return ss.structure([[1.0]], internal_force=force, tangent=tangent, potential=potential, u0=u0)


def damped() -> ss.Structure:
    """u'' + u' + 20 u = 0 from 1 at rest."""
    return spring(lambda u, v: 20.0 * u + v, lambda u, v: ([[20.0]], [[1.0]]), lambda u: 10.0 * float(u @ u), 1.0)


def van_der_pol() -> ss.Structure:
    return spring(
        lambda u, v: u - (1.0 - u * u) * v, lambda u, v: ([1.0 + 2.0 * u * v], [u * u - 1.0]),
        lambda u: 0.5 * float(u @ u), 2.0,
    )  # fmt: skip


@cache
def exact(make: Callable[[], ss.Structure], t_end: float) -> Any:
    """u at t_end, at tight tolerance, of a mass of one."""
    s = make()
    assert s.internal is not None
    force = s.internal.force

    def rates(_: float, y: Any) -> Any:
        return [y[1], -force(y[:1], y[1:])[0]]

    return solve_ivp(rates, (0.0, t_end), [s.u0[0], s.v0[0]], method="DOP853", rtol=1e-12, atol=1e-13).y[0, -1]


def test_the_oracle_has_the_value_of_the_closed_form() -> None:
    omega = np.sqrt(20.0 - 0.25)
    assert exact(damped, 5.0) == pytest.approx(
        np.exp(-2.5) * (np.cos(5 * omega) + 0.5 / omega * np.sin(5 * omega)), abs=1e-11
    )


@pytest.mark.parametrize("name", list(BY_NAME))
def test_every_scheme_gives_van_der_pols_motion_in_its_order_or_refuses_it(name: str) -> None:
    if name in UNDAMPED:
        return refuses(name, van_der_pol())
    order = 1 if name in OF_COEFFICIENTS else CATALOGUE[name]["nonlinear_order"][0]
    errors = []
    for h in (0.02, 0.01):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            r = ss.march(van_der_pol(), name, h, 1.0, account=False)
        assert len(said) == (name in OF_COEFFICIENTS)
        for warning in said:
            assert f"{name} takes the damping at the start" in str(warning.message)
        errors.append(abs(float(r.u[-1, 0]) - exact(van_der_pol, 1.0)))
    assert errors[1] <= 1e-9 or np.log2(errors[0] / errors[1]) >= order - 0.4, errors
    assert errors[1] <= 0.05
    return None


def refuses(name: str, s: ss.Structure) -> None:
    for step in ({"dt": 0.01}, {"tol": 1e-6}):
        with pytest.raises(ValueError, match=f"^{name} is a scheme for .*velocities, got one that does at the start"):
            ss.march(s, name, t_end=1.0, **step)
    with pytest.raises(ValueError, match=f"^{name} is a scheme for .*velocities, got one that does at the start"):
        ss.sweep(s, name, dt=[0.01], t_end=1.0)


@pytest.mark.parametrize("name", UNDAMPED)
def test_a_linear_damper_in_the_force_is_refused_as_a_matrix_is(name: str) -> None:
    refuses(name, damped())
    with pytest.raises(ValueError, match=f"^{name} is a scheme for .* without damping, got one with C; take .*dormand"):
        ss.march(ss.structure([[1.0]], [[20.0]], C=[[1.0]], u0=1.0), name, 0.01, 1.0)


@pytest.mark.parametrize("name", [s.name for s in BY_NAME.values() if s.takes_damping])
def test_damping_in_the_force_is_what_it_is_in_a_matrix(name: str) -> None:
    """To rounding and what an iteration leaves, also where coefficients or the start take C.

    That of a matrix is compared with the matrix exponential in test_structures_order.
    """
    start: dict[str, Any] = {"u0": [0.2, -0.1], "v0": [0.5, 1.0], "load": ([1.0, 0.5], np.sin)}
    linear = ss.structure(M, K, C=C, **start)
    given = ss.structure(
        M, internal_force=lambda u, v: K @ u + C @ v, tangent=lambda u, v: (K, C),
        potential=lambda u: 0.5 * float(u @ K @ u), **start,
    )  # fmt: skip
    half = ss.structure(
        M, internal_force=lambda u, v: K @ u + 0.75 * C @ v, tangent=lambda u, v: (K, 0.75 * C), C=0.25 * C,
        potential=lambda u: 0.5 * float(u @ K @ u), **start,
    )  # fmt: skip
    expected, found, split = (ss.march(s, name, 0.02, 0.4, account=False) for s in (linear, given, half))
    for what in ("u", "v", "a"):
        size = np.abs(getattr(expected, what)).max()
        for other in (found, split):
            assert np.abs(getattr(other, what) - getattr(expected, what)).max() <= 1e-9 * size, what
    if name == "average_acceleration":
        rates = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
        push = np.r_[np.zeros(2), np.linalg.solve(M, [1.0, 0.5])]
        y = solve_ivp(
            lambda t, y: rates @ y + push * np.sin(t), (0, 0.4), [0.2, -0.1, 0.5, 1.0], rtol=1e-10, atol=1e-12
        )
        assert np.abs(found.u[-1] - y.y[:2, -1]).max() <= 1e-3


def test_modes_have_the_damping_of_the_tangent() -> None:
    linear = ss.structure(M, K, C=C)
    given = ss.structure(M, internal_force=lambda u, v: K @ u + C @ v, tangent=lambda u, v: (K, C))
    assert np.allclose(given.modes(2).damping, linear.modes(2).damping, rtol=0, atol=1e-13)


def caught(u: Any, v: Any) -> Any:
    """A spring that meets a dashpot below u = 0.5."""
    return 20.0 * u + np.where(u < 0.5, v, 0.0)


@pytest.mark.parametrize("step", [{"dt": 0.01}, {"tol": 1e-6}], ids=["dt", "tol"])
@pytest.mark.parametrize("name", UNDAMPED)
def test_damping_that_sets_in_later_is_refused_then(name: str, step: Any) -> None:
    """With what was done before, of which nothing is wrong: until t = arccos(1/2)/sqrt(20) there is no damping."""
    s = ss.structure([[1.0]], internal_force=caught, u0=1.0)
    with pytest.raises(ValueError, match=f"^{name} is a scheme for .* velocities, got one that does at t = ") as error:
        ss.march(s, name, t_end=2.0, account=False, **step)
    done = error.value.response  # type: ignore[attr-defined]
    assert 0.5 <= done.u[-1, 0] < (0.65 if "dt" in step else 0.75)
    assert np.abs(done.u[:, 0] - np.cos(np.sqrt(20.0) * done.t)).max() <= 1e-4
    if "dt" in step:
        with pytest.raises(ValueError, match=f"^{name} is a scheme for .* got one that does at t = "):
            ss.sweep(s, name, t_end=2.0, dt=[0.01])


@pytest.mark.parametrize("account", [False, True])
@pytest.mark.parametrize("name", UNDAMPED)
def test_a_force_that_is_given_v_but_does_not_use_it_is_marched_at_an_evaluation_a_step_more(
    name: str, account: bool
) -> None:
    """The same to the bit as that of u alone; the account of energy, which takes v anyway, shares evaluations."""
    plain, given = (
        ss.structure([[1.0]], internal_force=f, u0=1.0) for f in (lambda u: 20.0 * u, lambda u, v: 20.0 * u)
    )
    expected, found = (ss.march(s, name, 0.01, 1.0, account=account) for s in (plain, given))
    for what in ("u", "v"):
        assert np.array_equal(getattr(found, what), getattr(expected, what))
    assert plain.internal is not None
    assert given.internal is not None
    assert given.internal.evaluations - plain.internal.evaluations <= 105 + 100 * account
    chosen = [ss.march(s, name, tol=1e-6, t_end=1.0, account=False).u for s in (plain, given)]
    assert np.allclose(chosen[0][-1], chosen[1][-1], rtol=0, atol=1e-6)


def test_a_scheme_with_coefficients_of_damping_asks_for_the_derivative_by_velocity() -> None:
    half = ss.structure([[1.0]], internal_force=lambda u, v: 20.0 * u + v, tangent=lambda u, v: [[20.0]], u0=1.0)
    for name in (*OF_COEFFICIENTS, "gholampour"):  # whose start takes C
        with pytest.raises(
            ValueError, match=f"{name} takes the damping at the start: expected tangent= to return a pair"
        ):
            ss.march(half, name, 0.01, 1.0)
    assert ss.march(half, "average_acceleration", 0.01, 1.0, account=False).u[-1, 0] == pytest.approx(
        exact(damped, 1.0), abs=1e-3
    )


@pytest.mark.parametrize("step", [{"dt": 0.02}, {"tol": 1e-5}], ids=["dt", "tol"])
@pytest.mark.parametrize("name", ["dormand_prince", "average_acceleration", "energy_momentum"])
def test_damping_in_the_force_is_booked_as_damped(name: str, step: Any) -> None:
    """u'' + u' + 20 u = 0 from 10 J: nearly all is damped, and of it nothing is the scheme's."""
    found = ss.march(damped(), name, t_end=5.0, **step)
    by_matrix = ss.march(ss.structure([[1.0]], [[20.0]], C=[[1.0]], u0=1.0), name, t_end=5.0, **step)
    account = found.account
    assert account is not None
    rest = account.kinetic[-1] + account.strain[-1]
    assert account.damped[-1] == pytest.approx(10.0 - rest, abs=0.02 if "dt" in step else 0.3)
    assert np.abs(account.numerical).max() <= 1e-3
    assert account.strain == pytest.approx(by_matrix.account.strain, abs=1e-4)
    total = account.kinetic + account.strain + account.damped + account.numerical + account.residual
    assert np.allclose(total - 10.0, 0.0, rtol=0, atol=1e-12)
    if name == "energy_momentum" and "dt" in step:  # whose balance of energy is exact with the force at its midpoint
        assert np.abs(account.numerical).max() <= 1e-9
