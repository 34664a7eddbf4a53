"""What is chosen for a structure: predictions against direct marches and solve_ivp, and against trying everything."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from plane_elements import cantilever, shear_building
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

import substep as ss
from substep.exact.coupled import coupled_histories
from substep.exact.oscillator import exact_histories
from substep.studies.structures.prediction import Prediction

T_END = 2.0
PULSE = ss.HalfSine(40.0, T_END)
RATES = (1.0, 8.0, 0.3, 20.0)


@cache
def building(coupled: bool = False) -> ss.Structure:
    M, K = shear_building([2.0, 1.5, 1.5, 1.0], [900.0, 700.0, 600.0, 400.0])
    C: Any = np.diag([0.0, 0.0, 0.0, 1.5]) if coupled else ss.rayleigh(0.02, 0.03, at=(8.0, 40.0))
    return ss.structure(M, K, C=C, load=[([0, 0, 0, 1.0], PULSE), ([1.0, 0, 0, 0], ss.Harmonic(5.0, 11.0))], v0=0.1,
                        names=["1", "2", "3", "roof"])  # fmt: skip


@cache
def true_roof(coupled: bool, steps: int) -> Any:
    """Displacement of the roof at the ends of equal steps, by DOP853."""
    s = building(coupled)
    inverse = np.linalg.inv(s.M)

    def rate(t: float, y: Any) -> Any:
        u, v = y[:4], y[4:]
        return np.concatenate([v, inverse @ (s.force(t) - s.damping @ v - s.K @ u)])

    t = np.linspace(0.0, T_END, steps + 1)
    found = solve_ivp(rate, (0, T_END), np.concatenate([s.u0, s.v0]), "DOP853", t, rtol=1e-11, atol=1e-12)
    return found.y[3]


def measured(coupled: bool, r: Any, steps: int) -> float:
    """The largest error of the roof at `steps` equal intervals, relative to its largest displacement."""
    true = true_roof(coupled, steps)
    return float(np.abs(r.u[:: (len(r.u) - 1) // steps, r.dofs.index("roof")] - true).max() / np.abs(true).max())


@pytest.mark.thorough
@pytest.mark.matrix
@pytest.mark.parametrize("coupled", [False, True], ids=["classical", "coupled"])
@pytest.mark.parametrize("model", ["any", "direct"])
@pytest.mark.parametrize("accuracy", [1e-2, 1e-4])
def test_its_answer_has_the_error_that_it_predicts(accuracy: float, model: Any, coupled: bool) -> None:
    among = ["bathe", "average_acceleration", "generalized_alpha", "park", "rk4", "central_difference"]
    found = ss.choose(building(coupled), accuracy, t_end=T_END, quantity="roof", among=among, model=model)
    assert found.best is not None
    rows = Prediction(found.modes, "roof", T_END, accuracy).rows
    own = measured(coupled, found.march(), rows)
    assert own == pytest.approx(found.best.error, rel=0.05)
    assert own <= 1.001 * accuracy
    assert ("damping couples the modes" in found.text) == coupled
    parts = found.parts
    assert parts is not None
    assert parts.truncation + parts.integration + parts.load_sampling >= 0.999 * found.best.error
    assert (parts.truncation == 0.0) == (found.best.modes in (None, 4))


def test_trying_everything_finds_nothing_cheaper() -> None:
    """Every scheme and step of the ladder marched directly: the choice is the accurate one of least work."""
    among, accuracy = ["bathe", "average_acceleration", "central_difference", "rk4"], 1e-3
    found = ss.choose(building(), accuracy, t_end=T_END, quantity="roof", among=among, model="direct")
    assert found.best is not None
    rows = min(c.steps for c in found.candidates)
    cost = {}
    for name in among:
        scheme = ss.scheme(name)
        for factor in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32):
            n = factor * rows
            r = ss.march(building(), scheme, T_END / n, T_END, dofs=["roof"], account=False)
            if r.status == "completed" and measured(False, r, rows) <= accuracy:
                cost[name, n] = n * scheme.balances
                break
    assert len(cost) >= 3
    cheapest = min(cost, key=lambda key: cost[key])
    assert (found.best.scheme.name, found.best.steps) == cheapest
    assert found.best.modes is None
    assert found.best.work == 4.0 * 16 * cost[cheapest]


def test_few_modes_of_a_large_structure_tell_the_error_of_direct_steps() -> None:
    """240 degrees of freedom, 40 modes known: what is predicted is what direct steps show, to 5 %."""
    M, K, fixed, tip = cantilever(20, 5)
    P = np.zeros(M.shape[0])
    P[tip] = 1.0
    body = ss.structure(M, K, C=ss.rayleigh(0.01, 0.02, at=(4.0, 60.0)), fixed=fixed, load=(P, ss.HalfSine(1.0, 3.0)))
    modes = body.modes(40)
    found = ss.choose(
        modes, 5e-3, t_end=3.0, quantity=tip, among=["average_acceleration", "bathe", "rk4"], model="direct"
    )
    assert found.best is not None
    assert found.best.scheme.name != "rk4"  # which is unstable on the modes that are not known
    fine = ss.march(body, "esdirk43", 3.0 / 4000, 3.0, dofs=[tip], account=False).u[:, 0]
    rows = Prediction(modes, tip, 3.0, 5e-3).rows
    at = np.linspace(0, 4000, rows + 1)
    assert np.allclose(at, np.round(at))
    at = at.astype(int)
    own = found.march(account=False).u[:: found.best.steps // rows, 0]
    error = np.abs(own - fine[at]).max() / np.abs(fine[at]).max()
    assert error == pytest.approx(found.best.error, rel=0.05)
    few = ss.choose(modes, 5e-3, t_end=3.0, quantity=tip, among=["average_acceleration", "bathe"])
    assert few.best is not None
    assert few.best.modes is not None
    assert few.best.modes < 10
    assert few.otherwise is not None
    assert few.otherwise.modes is None
    assert few.best.work < 0.01 * few.otherwise.work
    own = few.march().u[:: few.best.steps // rows, 0]
    assert np.abs(own - fine[at]).max() / np.abs(fine[at]).max() == pytest.approx(few.best.error, rel=0.05)


@pytest.mark.parametrize("damping", [None, ss.rayleigh(0.01, 0.02, at=(4.0, 60.0))], ids=["undamped", "damped"])
@pytest.mark.parametrize(
    "load", [ss.HalfSine(1.0, 3.0), ss.HalfSine(1.0, 0.1), ss.Harmonic(1.0, 9.0, 1.0), None],
    ids=["slow", "short", "sudden", "start"],
)  # fmt: skip
def test_what_unknown_modes_do_is_not_more_than_is_said(load: Any, damping: Any) -> None:
    """Against all 240 modes: a bound, at the loaded degree of freedom of undamped modes within 5 times of it."""
    M, K, fixed, tip = cantilever(20, 5)
    P = np.zeros(M.shape[0])
    P[tip] = 1.0
    start = {} if load else {"v0": 1.0}
    body = ss.structure(M, K, C=damping, fixed=fixed, load=(P, load) if load else (), **start)
    every = body.modes(body.size)
    for quantity in (tip, 41):
        whole = Prediction(every, quantity, 3.0, 1e-4)
        assert whole.unforeseen == 0.0
        for n in (5, 15, 40):
            part = Prediction(every.first(n), quantity, 3.0, 1e-4)
            fine, rows = 64 * part.rows, part.rows
            known, true = (p.displacement(p.exact(fine, rows), rows) for p in (part, whole))
            missed = np.abs(known - true).max() / part.scale
            assert missed <= 1.001 * part.unforeseen
            if quantity == tip and load and damping is None:
                assert part.unforeseen <= 5.0 * missed


def test_a_wish_that_the_known_modes_do_not_allow_is_warned_of() -> None:
    M, K, fixed, tip = cantilever(20, 5)
    P = np.zeros(M.shape[0])
    P[tip] = 1.0
    body = ss.structure(M, K, fixed=fixed, load=(P, ss.HalfSine(1.0, 0.1)))
    with pytest.warns(
        UserWarning, match=r"from 5 modes, and others may add up to about 0\.0[0-9]+, which is not within"
    ):
        found = ss.choose(body.modes(5), 1e-3, t_end=3.0, quantity=tip, among=["bathe"])
    assert "modes that are not known may add up to about" in found.text
    assert found.unforeseen > 1e-3


@pytest.mark.thorough
def test_damping_ratios_of_modes_are_those_of_direct_steps() -> None:
    """What was chosen for modes that were given ratios is marched with them, on the whole structure too."""
    M, K = shear_building([2.0, 1.5, 1.5, 1.0], [900.0, 700.0, 600.0, 400.0])
    bare = ss.structure(M, K, load=([0, 0, 0, 1.0], PULSE))
    found = ss.choose(bare.modes(4).damped(0.2), 1e-2, t_end=T_END, quantity=3, among=["bathe"], model="direct")
    assert found.best is not None
    damped = ss.structure(M, K, C=ss.modal_damping(0.2, 4), load=([0, 0, 0, 1.0], PULSE))
    direct = ss.march(damped, "bathe", T_END / found.best.steps, T_END, dofs=[3], account=False)
    assert np.allclose(found.march().u, direct.u, rtol=1e-9, atol=1e-12)
    undamped = ss.march(bare, "bathe", T_END / found.best.steps, T_END, dofs=[3], account=False)
    assert np.abs(undamped.u - direct.u).max() > 0.1 * np.abs(direct.u).max()
    assert ss.choose(bare.modes(4).damped(0.0), 1e-2, t_end=T_END, quantity=3, among=["rkn64"]).march().u.any()


@pytest.mark.parametrize("scheme", ["central_difference", "noh_bathe", "rk4", "bdf3", "yoshida6", "rkn64"])
@pytest.mark.parametrize("damping", [None, ss.Rayleigh(0.1, 2e-4)], ids=["undamped", "damped"])
def test_stability_beyond_the_known_modes_is_that_of_the_largest_frequency(scheme: str, damping: Any) -> None:
    """The largest frequency is found only where a bound from below leaves the answer open; it agrees with LAPACK's."""
    s, steps = ss.scheme(scheme), 3 << np.arange(14)
    if damping is not None and not s.info.damping:
        pytest.skip("takes no damping")
    M, K, fixed, tip = cantilever(6, 2)
    P = np.zeros(M.shape[0])
    P[tip] = 1.0
    body = ss.structure(M, K, C=damping, fixed=fixed, load=(P, ss.HalfSine(1.0, 3.0)))
    top = np.sqrt(eigh(body.K.toarray(), body.M.toarray(), eigvals_only=True).max())
    p, xi = Prediction(body.modes(5), tip, 3.0, 1e-2), 0.0 if damping is None else damping.ratio(top)
    stable = [p.stable_directly(s, int(n)) for n in steps]
    assert stable == [bool(s.spectral_radius(top * 3.0 / n, xi) <= 1.0 + 1e-6) for n in steps]
    assert (True in stable) and (False in stable or scheme == "bdf3")  # whose unstable frequencies are a narrow band


def test_a_record_with_samples_at_the_steps_has_no_error_of_sampling() -> None:
    t = np.arange(0.0, T_END + 0.005, 0.01)
    quake = ss.structure(*shear_building([1.0, 1.0], [30.0, 20.0])).ground_motion(ss.Record(0.01, np.sin(7.0 * t)), 1.0)
    p = Prediction(quake.modes(2), 1, T_END, 1e-6)
    assert p.rows == 50
    scheme = ss.scheme("average_acceleration")
    at_samples, between = (p.parts(scheme, n, 2) for n in (200, 150))
    assert at_samples.load_sampling < 1e-11
    assert between.load_sampling > 1e-5
    assert at_samples.integration > 1e-5
    assert p.parts(scheme, 200, 1).truncation > 1e-3


def test_exact_histories_are_those_of_a_general_solver() -> None:
    """Damped, undamped and free oscillators under loads that are linear between samples, coupled ones too."""
    rng = np.random.default_rng(2)
    omega, xi, dt, n = np.array([0.0, 3.0, 20.0]), np.array([0.0, 0.3, 0.0]), 0.05, 40
    samples, start, C = rng.normal(size=n + 1), rng.normal(size=(2, 3)), np.diag(2 * xi * omega)

    def solved(C: Any) -> Any:
        x = np.concatenate(start)
        rows = [x]
        for i in range(n):  # a load without kinks for each call

            def rate(t: float, y: Any, i: int = i) -> Any:
                f = samples[i] + (samples[i + 1] - samples[i]) * t / dt
                return np.concatenate([y[3:], f - C @ y[3:] - omega**2 * y[:3]])

            x = solve_ivp(rate, (0.0, dt), x, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
            rows.append(x)
        return np.array(rows)

    own = exact_histories(omega, xi, dt, start, samples, 4)
    expected = solved(C)[::4]
    assert np.abs(own[:, 0] - expected[:, :3]).max() < 1e-9
    assert np.abs(own[:, 1] - expected[:, 3:]).max() < 1e-8
    full = C + 0.5 * rng.normal(size=(3, 3))
    coupled = coupled_histories(omega, full, np.ones((3, 1)), dt, start, samples[:, None], 5)
    expected = solved(full)[::5, :3]
    assert np.abs(coupled - expected).max() < 1e-9 * np.abs(expected).max()


def test_what_cannot_be_chosen_is_refused_by_name() -> None:
    run: dict[str, Any] = {"t_end": T_END, "quantity": "roof"}
    with pytest.raises(ValueError, match="a model, one of: any, direct, modal; got 'both'"):
        ss.choose(building(), 1e-2, model="both", **run)
    with pytest.raises(ValueError, match="a degree of freedom, .*; got 'rof'; did you mean 'roof'"):
        ss.choose(building(), 1e-2, t_end=T_END, quantity="rof")
    with pytest.raises(ValueError, match="accuracy > 0"):
        ss.choose(building(), 0.0, **run)
    with pytest.raises(ValueError, match="that take damping, got none"):
        ss.choose(building(), 1e-2, among=["rkn43"], **run)
    still = ss.structure(*shear_building([1.0, 1.0], [3.0, 2.0]))
    with pytest.raises(ValueError, match="a degree of freedom that moves, got 0"):
        ss.choose(still, 1e-2, t_end=1.0, quantity=0)
    none = ss.choose(building(), 1e-8, among=["backward_euler"], **run)
    assert none.best is None
    assert "no candidate keeps the error of 'roof' below 1e-08; the nearest is backward_euler" in none.text
    with pytest.raises(ValueError, match="a candidate within 1e-08, got none"):
        none.march()
    with pytest.raises(ValueError, match="expected a scene"):
        ss.choose(3, 1e-2, t_end=1.0)
