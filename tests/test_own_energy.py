"""The account of energy by a scheme's own energy: that it closes, and textbooks' balances."""

from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, NAMES, OF_STIFFNESS, random_parameters
from hypothesis import given, settings
from hypothesis import strategies as st
from substep_derive import DeclarationError, Scene, rate
from substep_derive.declare.symbols import auxiliary
from substep_kernels.facts import CATALOGUE
from sympy import Symbol, exp, log
from test_constraints import VERIFY
from test_energy import WITHOUT

import substep as ss
from substep.studies.own_energy import OwnEnergy

# whose velocity is not that of their state, or which carry more than runs report
REPORTING = {"kr_alpha", "central_difference_lagged", *(s for s in NAMES if any(map(auxiliary, BY_NAME[s].state)))}
CLOSED = 2e-13  # of the largest energy, of some hundred steps
omega, xi, h = 2.0, 0.03, 0.2


def oscillator(name: str, **given: Any) -> ss.Scene:
    damping = xi if BY_NAME[name].takes_damping else 0.0
    return ss.scene("linear_oscillator", **{"omega": omega, "xi": damping, "u0": 1.0, "v0": 0.3, **given})


def gap(own: OwnEnergy) -> float:
    change = own.energy - own.energy[0] - (own.work - own.damped - own.numerical)
    return float(abs(change).max() / abs(own.energy).max())


def dt_of(name: str) -> float:
    return h / 5 if name == "forward_euler" else h


@pytest.mark.parametrize("name", NAMES)
def test_it_closes_for_every_scheme(name: str) -> None:
    r = ss.march(oscillator(name, load=ss.Harmonic(1.0, 3.0)), name, dt=dt_of(name), t_end=10.0)
    if name in WITHOUT | REPORTING:
        with pytest.raises(ValueError, match="expected a principal pair|expected a scheme whose runs report its state"):
            ss.own_energy(r)
        return
    own = ss.own_energy(r)
    assert gap(own) < CLOSED
    assert own.work[-1] > 0.01
    if BY_NAME[name].takes_damping:
        assert own.damped[-1] > 0.1
    mechanical = r.energy[-len(own.t) :]
    assert own.energy.mean() == pytest.approx(mechanical.mean(), rel=0.15)


@settings(max_examples=60 if VERIFY else 10)
@given(st.sampled_from(["newmark", "newmark_bdf2", "generalized_alpha", "collocation", "gssss_v0"]), st.data())
def test_it_closes_at_any_parameters_and_loads(name: str, data: st.DataObject) -> None:
    rng = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    s = ss.scheme(name, **{key: float(x) for key, x in random_parameters(BY_NAME[name], rng).items()})
    load = ss.Record(0.11, rng.normal(size=40))
    scene = oscillator(name, omega=10 ** rng.uniform(-1, 0.5), xi=rng.uniform(0, 0.5), load=load)
    r = ss.march(scene, s, dt=h, t_end=4.0)
    if abs(r.u).max() > 1e3:
        return  # unstable at these parameters
    try:
        own = ss.own_energy(r)
    except ValueError as refused:
        assert "a pair of complex eigenvalues" in str(refused)
        return
    assert gap(own) < 1e-9


@pytest.mark.parametrize("n", [1, 6])
def test_average_acceleration_has_the_textbook_s_balance(n: int) -> None:
    """Work of the mean load, damping of the mean velocity and no numerical dissipation: as `Account` has them."""
    building, _ = chain(n)
    r = ss.march(building, "average_acceleration", dt=0.03, t_end=6.0, account=True)
    own, account = ss.own_energy(r), r.account
    assert account is not None
    assert np.allclose(own.energy, r.energy, rtol=1e-11, atol=1e-12)
    assert np.allclose(own.work, account.work, rtol=1e-10, atol=1e-11)
    assert np.allclose(own.damped, account.damped, rtol=1e-10, atol=1e-11)
    assert not own.numerical.any()


def chain(n: int) -> tuple[ss.Structure, Any]:
    rng = np.random.default_rng(n)
    K = 40.0 * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    M = np.diag(rng.uniform(1.0, 2.0, n))
    load = (rng.normal(size=n), ss.Harmonic(2.0, 1.3))
    return ss.structure(M, K, C=0.02 * M + 0.01 * K, load=load, u0=0.1 * rng.normal(size=n)), rng


@pytest.mark.parametrize("name", ["bathe", "generalized_alpha", "houbolt", "noh_bathe", "gauss2"])
def test_modes_and_the_direct_march_have_one_account(name: str) -> None:
    building, _ = chain(5)
    direct, modal = (
        ss.own_energy(ss.march(whole, name, dt=0.03, t_end=3.0, account=False))
        for whole in (building, building.modes(5))
    )
    for key in ("energy", "work", "damped", "numerical"):
        assert np.allclose(getattr(direct, key), getattr(modal, key), rtol=1e-7, atol=1e-9), key
    assert gap(direct) < 1e-11
    assert direct.numerical[-1] > 0.0 or name == "gauss2"


def test_backward_euler_divides_its_energy_by_one_number() -> None:
    r = ss.march(oscillator("backward_euler", xi=0.0), "backward_euler", dt=h, t_end=2.0)
    own = ss.own_energy(r)
    left = own.energy[0] / (1.0 + (omega * h) ** 2) ** np.arange(11)
    assert np.allclose(own.energy, left, rtol=1e-13)
    assert np.allclose(own.numerical, own.energy[0] - left, rtol=1e-13)


def test_central_differences_keep_the_leapfrog_s_energy() -> None:
    """(v_(n+1/2))^2/2 + omega^2 u_n u_(n+1)/2 is kept; here over 1 - Omega^2/4, for the amplitude of u."""
    r = ss.march(oscillator("central_difference", xi=0.0), "central_difference", dt=h, t_end=2.0)
    u = r.u[:, 0]
    leapfrog = 0.5 * (np.diff(u) / h) ** 2 + 0.5 * omega**2 * u[1:] * u[:-1]
    assert np.allclose(ss.own_energy(r).energy * (1.0 - (omega * h) ** 2 / 4.0), leapfrog[0], rtol=1e-12)


def test_small_steps_keep_their_digits() -> None:
    r = ss.march(oscillator("bathe", xi=0.0), "bathe", dt=1e-3, t_end=1.0)
    own = ss.own_energy(r)
    expected = 1000 * own.energy[0] * (omega * 1e-3) ** 4 / 144 / 1.0  # of one step Omega^4/144 of the energy, nearly
    assert own.numerical[-1] == pytest.approx(expected, rel=1e-3)


def test_a_start_that_does_not_fit_is_left_out() -> None:
    scene = oscillator("hht_alpha", a0=[5.0])
    assert len(ss.own_energy(ss.march(scene, "newmark", dt=h, t_end=1.0)).t) == 5
    assert gap(ss.own_energy(ss.march(scene, "hht_alpha", dt=h, t_end=1.0))) < CLOSED
    r = ss.march(oscillator("houbolt"), "houbolt", dt=h, t_end=1.0)
    assert len(ss.own_energy(r).t) == 4  # u of three steps


@pytest.mark.usefixtures("plain_in_gate")
def test_what_has_no_account_is_refused() -> None:
    bounce = ss.march(ss.scene("penalty_bounce"), "bathe", dt=0.1, t_end=0.5)
    with pytest.raises(DeclarationError, match="got one that bends or jumps"):
        ss.own_energy(bounce)
    for scheme in ("bathe", "central_difference"):
        seldom = ss.march(ss.scene("simple_pendulum", v0=1.5), scheme, dt=0.05, t_end=1.0, stride=5)
        with pytest.raises(ValueError, match="rows of all 20 steps.*got 4 after the start; march without stride="):
            ss.own_energy(seldom)
    with pytest.raises(ValueError, match="constant steps"):
        ss.own_energy(ss.march(oscillator("bathe"), "bathe", tol=1e-4, t_end=1.0))
    for stride in (2, 5):
        r = ss.march(oscillator("bathe"), "bathe", dt=0.02, t_end=2.0, stride=stride)
        with pytest.raises(ValueError, match="march without stride="):
            ss.own_energy(r)
    building, rng = chain(3)
    with pytest.raises(ValueError, match="all degrees of freedom"):
        ss.own_energy(ss.march(building, "bathe", dt=0.1, t_end=0.5, dofs=[0]))
    free = ss.structure(np.eye(2), [[1.0, -1.0], [-1.0, 1.0]], v0=[1.0, 0.0])
    with pytest.raises(ValueError, match="a structure that is held"):
        ss.own_energy(ss.march(free, "bathe", dt=0.1, t_end=0.5))
    damper = np.diag([1.0, 0.0, 0.0])
    coupled = ss.structure(np.eye(3), np.diag([1.0, 2.0, 3.0]) + 0.1, C=damper, v0=rng.normal(size=3))
    with pytest.raises(ValueError, match="damping that does not couple the modes"):
        ss.own_energy(ss.march(coupled, "bathe", dt=0.1, t_end=0.5))
    stiff = oscillator("hht_alpha", omega=1e4, xi=0.0)
    with pytest.raises(ValueError, match="a pair of complex eigenvalues"):
        ss.own_energy(ss.march(stiff, "wilson_theta", dt=h, t_end=1.0))


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.matrix(25)  # an odd number, so that both scenes are met
@pytest.mark.parametrize("problem", ["simple_pendulum", "elastic_pendulum"])
@pytest.mark.parametrize("name", [name for name in NAMES if name not in OF_STIFFNESS])
def test_on_a_nonlinear_scene_it_is_the_modified_energy(name: str, problem: str) -> None:
    """It takes away nearly all that T + V does, from where the start has died out."""
    if problem == "elastic_pendulum" and name == "energy_momentum":
        pytest.skip("its discrete gradient on two coordinates has no modified energy")
    scene, T = (
        (ss.scene("simple_pendulum", v0=1.5), 8.0)
        if problem == "simple_pendulum"
        else (ss.scene("elastic_pendulum", EA=1e4), 0.5)
    )
    n = 200 if min(CATALOGUE[name]["nonlinear_order"][:2]) > 1 else 1600
    r = ss.march(scene, name, dt=T / n, t_end=T)
    own = ss.own_energy(r)
    assert own.energy[0] == pytest.approx(r.energy[0], rel=0.02)
    left, change = (np.ptp(e[n // 10 :]) for e in (own.energy + own.numerical, r.energy))
    assert left < max(0.1 * change, 1e-14 * n * own.energy[0])


@pytest.mark.usefixtures("uncompiled")
def test_a_power_whose_exponent_moves_is_an_exponential() -> None:
    u = Symbol("u")
    given: dict[str, Any] = {"coordinates": {u: "m"}, "parameters": (), "start": {u: 1, rate(u): 0}, "length": 1}
    wells = [2**u + 2 ** (-u), exp(u * log(2)) + exp(-u * log(2))]
    scenes = [Scene(f"well{k}", kinetic=rate(u) ** 2 / 2, potential=V, **given) for k, V in enumerate(wells)]
    owns = [ss.own_energy(ss.march(ss.scene(scene), "bathe", dt=0.05, t_end=2.0)) for scene in scenes]
    assert np.allclose(owns[0].energy, owns[1].energy, rtol=1e-14)
    assert np.abs(owns[0].left - owns[0].left[20])[20:].max() < 1e-8
