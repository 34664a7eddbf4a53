"""Schemes that carry eleven numbers or more from step to step: no entry of a matrix takes another's place."""

from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from by_hand import SCENES
from plain_kernels import SCENE_BY_NAME, committed, itself, text_of, uncompiled
from substep_derive import Balance, Parameter, Scheme, derive
from substep_derive.declare.symbols import h, knot
from substep_derive.emit.first_use import catalogue_pair
from substep_derive.emit.march_module import march_module
from substep_derive.emit.stability_module import eigenvalues_module
from substep_derive.kernels.eigenvalue_kind import EigenvalueKind
from substep_derive.kernels.march_shape import shape_name, shape_of
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Interval, Rational, Symbol

import substep as ss
from substep.core import coefficients, eigenvalues, threads
from substep.marching import linear, scene_lanes
from substep.marching.linear import march_linear
from substep.marching.oscillators import Oscillators
from substep.marching.scene_lanes import march_lanes

Array = np.ndarray
KAPPA = 0.75
u1, v1, a1 = knot(1)


def weights(count: int) -> list[Rational]:
    """Weights that are all different and have the sum 1."""
    different = [Rational((-1) ** j, 2 * j + 3) for j in range(count - 1)]
    return [*different, 1 - sum(different, Rational(0))]


def multi_step(count: int, lag: int = 0) -> Scheme:
    """u_1 from so many displacements before, v_1 from a difference; the displacement reported is `lag` steps old."""
    u0, v0, _ = knot(0)
    before, kappa = [knot(-j).u for j in range(count)], Symbol("kappa")
    known = sum((w * u for w, u in zip(weights(count), before, strict=True)), 0 * h)
    return Scheme(
        "long_history",
        {u1: known + kappa * h**2 * a1, v1: (u1 - u0) / h + h / 2 * a1},
        (Balance.at(knot(1), 1),),
        (Parameter(kappa, Interval(0, 2), Rational(KAPPA)),),
        start={u: u0 - j * h * v0 for j, u in enumerate(before) if j},
        report={u1: knot(1 - lag).u} if lag else {},
    )


def oscillator_step(state: Array, Omega: float, xi: float, f: float) -> tuple[Array, Array]:
    """The state after a step and its u, h*v, h^2*a, under the load h^2 f."""
    known = sum(float(w) * u for w, u in zip(weights(len(state)), state, strict=True))
    slope = 1 + 2 * xi * Omega * (KAPPA + 0.5) + Omega**2 * KAPPA
    a = (f - 2 * xi * Omega * (known - state[0]) - Omega**2 * known) / slope
    u = known + KAPPA * a
    return np.array([u, *state[:-1]]), np.array([u, u - state[0] + a / 2, a])


def matrix(count: int, Omega: float, xi: float) -> Array:
    return np.transpose([oscillator_step(e, Omega, xi, 0.0)[0] for e in np.eye(count)])


@pytest.fixture
def plain_scheme(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ss.Scheme:
    """A handle of the scheme declared; its kernels, and the marches, as plain Python."""
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(threads, "cores", lambda: 1)
    handle = ss.scheme(multi_step(*request.param))
    module = uncompiled(text_of(handle.kernels))

    def kernels(name: str, K: int, in_single: bool) -> tuple[object, object, int]:
        assert not in_single
        march = uncompiled(march_module(shape_of(name), (K,)))
        return getattr(march, f"march_{K}"), getattr(march, f"run_{K}"), march.WIDTH

    def finding(name: str) -> ModuleType:
        return uncompiled(eigenvalues_module(EigenvalueKind.named(name)))

    monkeypatch.setattr(linear, "_kernels", kernels)
    monkeypatch.setattr(eigenvalues, "eigenvalues_of", finding)
    monkeypatch.setattr(eigenvalues, "address", itself)
    monkeypatch.setattr(eigenvalues, "loaded", committed)
    return replace(handle, info=replace(handle.info, module=module))


COUNTS = pytest.mark.parametrize("plain_scheme", [(11,), (12,), (12, 10)], indirect=True, ids=str)


@COUNTS
def test_the_amplification_matrix_and_what_is_derived_from_it(plain_scheme: ss.Scheme) -> None:
    m = len(plain_scheme.state)
    for Omega, xi in ((0.3, 0.0), (0.7, 0.1), (2.5, 0.4)):
        expected = matrix(m, Omega, xi)
        np.testing.assert_allclose(plain_scheme.amplification(Omega, xi), expected, rtol=0, atol=1e-14)
        eigenvalues = np.linalg.eigvals(expected)
        # double precision leaves the eigenvalues, all apart from each other, as many digits
        with np.errstate(all="ignore"):  # as compiled kernels do
            radius = plain_scheme.spectral_radius(Omega, xi)
        assert radius == pytest.approx(np.abs(eigenvalues).max(), rel=1e-12)
        D, B, of_u, of_f = (x[0] for x in plain_scheme.coefficients(Omega, xi))
        np.testing.assert_allclose(D, expected - np.eye(m), rtol=0, atol=1e-14)
        loaded = oscillator_step(np.zeros(m), Omega, xi, 1.0)
        np.testing.assert_allclose(B[:, -1], loaded[0], rtol=0, atol=1e-14)
        own = [kind for kind, place in enumerate(coefficients.places(plain_scheme)) if place == "y"]
        np.testing.assert_allclose(of_f[:, -1], loaded[1][own], rtol=0, atol=1e-14)
        units = np.array([oscillator_step(e, Omega, xi, 0.0)[1][own] for e in np.eye(m)])
        np.testing.assert_allclose(of_u, units.T, rtol=0, atol=1e-14)
        S, _ = coefficients.start_coefficients(plain_scheme, Omega, xi)
        np.testing.assert_array_equal(S[0], [[1, -j, 0] for j in range(m)])


def marched(count: int, lag: int, omega: float, xi: float, dt: float, forces: Array, u: float, v: float) -> Array:
    """u, v, a (n + 1, 3), the displacement as reported."""
    state = np.array([u - j * dt * v for j in range(count)])
    rows, past = [], state.copy()
    for force in forces:
        state, (new, hv, h2a) = oscillator_step(state, omega * dt, xi, dt**2 * force)
        past = np.concatenate([[new], past])
        rows.append([past[lag], hv / dt, h2a / dt**2])
    return np.array(rows)


@COUNTS
def test_the_linear_march(plain_scheme: ss.Scheme) -> None:
    m, lag, dt, n = len(plain_scheme.state), int(coefficients.places(plain_scheme)[0]), 0.1, 17
    load = ss.Harmonic(2.0, 1.7)
    for P in (1, 3):
        omega, xi = np.linspace(1.0, 4.0, P), np.linspace(0.0, 0.2, P)
        start = np.tile([[0.4], [0.3], [0.0]], P)
        o = Oscillators(omega, xi, np.ones(P), np.full(P, dt), start)
        found = march_linear(plain_scheme, o, n, load).out
        forces = load(dt * np.arange(1, n + 1))
        for j in range(P):
            expected = marched(m, lag, omega[j], xi[j], dt, forces, 0.4, 0.3)
            np.testing.assert_allclose(found[1:, :, j], expected, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("plain_scheme", [(11,)], indirect=True, ids=str)
def test_the_march_of_a_scene(plain_scheme: ss.Scheme, monkeypatch: pytest.MonkeyPatch) -> None:
    hand, n = SCENES["duffing"], 15
    pair = uncompiled(catalogue_pair(multi_step(11), EquationsOfMotion(SCENE_BY_NAME["duffing"])))
    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda *_: pair)
    mine = ss.scene("duffing", **hand.parameters)
    found = march_lanes(mine, plain_scheme, np.array([hand.dt]), np.array([n]), history=True).out[0, :, 0, 0]
    u, v = float(hand.u0[0]), float(hand.v0[0])
    state, expected = np.array([u - j * hand.dt * v for j in range(11)]), [u]
    for _ in range(n):
        known = sum(float(w) * x for w, x in zip(weights(11), state, strict=True))
        new = known
        for _ in range(40):
            residual = new - known + KAPPA * hand.dt**2 * hand.system.force(np.array([new]))[0]
            new -= residual / (1 + KAPPA * hand.dt**2 * hand.system.tangent(np.array([new]))[0, 0])
        state = np.array([new, *state[:-1]])
        expected.append(new)
    np.testing.assert_allclose(found, expected, rtol=1e-11)  # Newton's tolerance is 1e-12


def test_names_of_shapes() -> None:
    for m in (2, 3, 10, 11, 12, 112):
        for places in ((0, 1, 2), (0, -1, -1), (m - 1, -1, 0), (-1, -1, m - 2)):
            assert shape_of(shape_name((m, places))) == (m, places)
    assert shape_name((2, (0, 1, -1))) == "linear_march_2_01y"
    assert (
        len({shape_name((m, (i, j, -1))) for m in (1, 11, 111) for i in range(m) for j in range(m)}) == 1 + 121 + 111**2
    )


def test_closed_forms_have_a_name_for_each_entry() -> None:
    d = derive(multi_step(12))
    found = d.A.subs({"Omega": Rational(3, 10), "xi": 0, "kappa": Rational(KAPPA)})
    np.testing.assert_allclose(np.array(found, dtype=float), matrix(12, 0.3, 0.0), rtol=0, atol=1e-15)
