"""The account of energy tells what a scheme dissipates from what the rule for the work of loads and damping misses."""

import warnings
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import Polynomial

import substep as ss
from substep.structures.march.quadrature import middle, of_damped, of_work

M = np.diag([2.0, 1.0, 3.0])
K = np.array([[6.0, -2.0, 0.0], [-2.0, 5.0, -3.0], [0.0, -3.0, 3.0]])
PULSE = ([0.0, 0.0, 1.0], ss.HalfSine(1.0, 0.2))
DAMPINGS = {"none": None, "rayleigh": ss.rayleigh(0.05, 0.05, at=(0.6, 2.9)), "matrix": 0.3 * M + 0.1 * K}
STRETCH = {"internal_force": lambda u: K @ u + 5.0 * u**3, "tangent": lambda u: K + np.diag(15.0 * u**2)}


def stiff(**more: Any) -> ss.Structure:
    """An oscillator of 40 steps of 0.05 in two of its periods, 3 in the pulse."""
    return ss.structure([[1.0]], [[40.0]], load=([1.0], ss.HalfSine(1.0, 0.15)), **more)


def account_of(s: Any, scheme: str, dt: float, t_end: float = 2.0) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ss.march(s, scheme, dt=dt, t_end=t_end).account


def test_the_finer_rule_is_exact_for_cubic_motions_under_quadratic_forces() -> None:
    """Integrated as polynomials of time, which the rule knows by their values at the ends and the middle only."""
    h, t = 0.7, np.array([0.0, 0.35, 0.7])
    motions = [Polynomial([0.3, -1.0, 2.0, 1.5]), Polynomial([-0.2, 0.4, 0.0, -3.0])]
    forces = [Polynomial([1.0, -2.0, 3.0]), Polynomial([0.5, 1.0, -4.0])]
    C = np.array([[2.0, -0.5], [-0.5, 1.0]])
    u, v, p = (np.array([x(t) for x in row]).T for row in (motions, [x.deriv() for x in motions], forces))
    change, ends = u[2] - u[0], (v[0], v[2])
    power = sum((f * x.deriv() for f, x in zip(forces, motions, strict=True)), Polynomial([0.0]))
    work = 0.5 * (p[0] + p[2]) @ change + of_work(p, change, ends, h, np.dot)
    assert work == pytest.approx(power.integ()(h), rel=1e-13)
    rates = [x.deriv() for x in motions]
    lost = sum((C[i, j] * rates[i] * rates[j] for i in (0, 1) for j in (0, 1)), Polynomial([0.0]))
    damped = change @ C @ change / h + of_damped((change, C @ change), ends, (C @ v[0], C @ v[2]), h, np.dot)
    assert damped == pytest.approx(lost.integ()(h), rel=1e-13)
    assert np.allclose(middle(u[0], u[2], *ends, h), (u[1], v[1]), rtol=0, atol=1e-14)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("force", ["linear", "nonlinear"])
@pytest.mark.parametrize("scheme", ["esdirk43", "butcher6"])
def test_what_the_work_is_uncertain_by_is_not_laid_to_an_accurate_scheme(scheme: str, force: str, damping: str) -> None:
    """The trapezoidal work errs as h^2 and dominates; what is laid to the scheme falls at least as h^3."""
    given: Any = {"K": K} if force == "linear" else STRETCH
    s = ss.structure(M, **given, C=DAMPINGS[damping], load=([0.0, 0.0, 4.0], ss.HalfSine(1.0, 0.8)), u0=[0.1, 0.0, 0.2])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        coarse, fine = (ss.march(s, scheme, dt=dt, t_end=2.0).account for dt in (0.2, 0.1))
    assert coarse is not None
    assert fine is not None
    assert np.abs(fine.residual).max() > 20.0 * np.abs(fine.numerical).max()
    assert abs(fine.share) < abs(coarse.share) / 8.0
    total = fine.kinetic + fine.strain + fine.damped + fine.numerical + fine.residual
    assert np.allclose(fine.work, total - fine.kinetic[0] - fine.strain[0], rtol=0, atol=1e-14)


@pytest.mark.parametrize("scheme", ["esdirk43", "butcher6"])
@pytest.mark.parametrize("dt", [0.05, 0.025])
def test_a_short_pulse_brings_no_warning_of_an_accurate_scheme(scheme: str, dt: float) -> None:
    """The trapezoidal work alone would be off by more than the warning's 5 %."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        account = ss.march(stiff(), scheme, dt=dt, t_end=2.0).account
    assert account is not None
    assert np.abs(account.residual).max() > 0.05 * account.work.max() * (dt / 0.05) ** 2


@pytest.mark.parametrize("scheme", [ss.scheme("bathe"), ss.scheme("generalized_alpha", rho_inf=0.0)], ids=str)
@pytest.mark.parametrize("load", [(), ([1.0, 0.0], ss.HalfSine(1.0, 1.0))], ids=["free", "loaded"])
def test_a_dissipative_scheme_on_a_stiff_mode_still_warns(scheme: Any, load: Any) -> None:
    s = ss.structure(np.eye(2), np.diag([4.0, 1e3]), u0=[0.0, 0.1], load=load)
    with pytest.warns(UserWarning, match="has dissipated [7-9].%"):
        ss.march(s, scheme, dt=0.05, t_end=2.0)


@pytest.mark.parametrize("damping", DAMPINGS)
def test_modes_and_steps_of_tol_keep_the_same_account(damping: str) -> None:
    s = ss.structure(M, K, C=DAMPINGS[damping], load=PULSE, u0=[0.1, 0.0, 0.2], v0=0.1)
    if damping != "matrix":  # which couples the modes
        whole, modes = (account_of(x, "bathe", 0.1) for x in (s, s.modes(3)))
        for name in (x.name for x in fields(whole)):
            assert np.allclose(getattr(whole, name), getattr(modes, name), rtol=0, atol=1e-13)
    chosen = ss.march(s, "esdirk43", tol=1e-3, t_end=2.0).account
    assert chosen is not None
    assert np.abs(chosen.residual).max() > 10.0 * np.abs(chosen.numerical).max()


@pytest.mark.parametrize("name", ["powers", "numerical"])
def test_what_a_scene_has_in_its_place_is_said(name: str) -> None:
    r = ss.march(stiff(), "bathe", dt=0.05, t_end=0.5)
    with pytest.raises(AttributeError, match="a response of a scene .* one of a structure; r.account has the work"):
        getattr(r, name)
