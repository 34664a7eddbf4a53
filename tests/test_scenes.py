"""Scenes from their energies: declarations checked, discrete gradients exact, motions against other integrators."""

import os
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from by_hand import SCENES
from declared import BY_NAME
from plain_kernels import SCENE_BY_NAME, motion, plain, uncompiled
from scipy.integrate import solve_ivp
from substep_derive import DeclarationError, Scene
from substep_derive.declare.scene import optional, required
from substep_derive.declare.symbols import rate, sampled, t
from substep_derive.emit.first_use import catalogue_pair
from substep_derive.motion.differences import divided_difference
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Rational, Symbol, cos, cosh, exp, log, sin, sqrt, symbols

import substep as ss

u, w, k, c, m = symbols("u w k c m")


def declared(**changes: object) -> Scene:
    given = {
        "name": "mine", "coordinates": {u: "m"}, "kinetic": m * rate(u) ** 2 / 2, "potential": k * u**4 / 4,
        "parameters": (optional(m, 2), required(k)), "start": {u: 1, rate(u): 0}, "length": 1,
    }  # fmt: skip
    return Scene(**{**given, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"potential": k * w}, "the potential holds 'w'"),
        ({"kinetic": w * rate(u) ** 2}, "kinetic energy holds 'w'"),
        ({"kinetic": rate(u) ** 3}, "expected a kinetic energy quadratic"),
        ({"dissipation": k * rate(u) ** 3}, "expected a dissipation that is convex"),
        ({"invariants": {w: u**3}}, "at most quadratic"),
        ({"start": {u: 1}}, "start says nothing of u_dot"),
        ({"length": w}, "length holds 'w'"),
        ({"load": {u: w * t}}, "load on u holds 'w'"),
        ({"parameters": (optional(m, 2), required(k), required(u))}, "got 'u' twice; rename one"),
    ],
)
def test_a_declaration_that_defines_no_motion_is_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        declared(**changes)


def test_a_scheme_and_a_scene_may_not_share_a_parameter() -> None:
    beta = Symbol("beta")
    scene = declared(potential=beta * u**4, parameters=(optional(m, 2), optional(beta, 1)))
    with pytest.raises(DeclarationError, match="'beta'"):
        catalogue_pair(BY_NAME["newmark"], EquationsOfMotion(scene))


def test_time_that_only_pushes_is_a_load() -> None:
    stiffer = EquationsOfMotion(declared(potential=k * u**2 * sin(t)))
    assert stiffer.general
    assert list(stiffer.load) == [0]
    assert list(EquationsOfMotion(declared(potential=k * (u - sin(t)) ** 2 / 2)).load) == [k * sin(t)]


@pytest.mark.parametrize(
    "g",
    [
        u**5 - 3 * u,
        sqrt(u),
        u ** Rational(3, 2),
        1 / u**2,
        u ** Rational(-1, 2),
        sin(u) * u,
        cos(2 * u),
        (u**2 + 1) ** 3,
    ],
    ids=str,
)
def test_divided_differences_cancel(g) -> None:
    """At distances 0 to 1, with floats, against 60 digits; and no difference is left to divide by."""
    old, new = symbols("old new")
    found = divided_difference(g, u, old, new)
    for x0 in (0.7, 1.9):
        for d in (0.0, 1e-12, 1e-4, 1.0):
            with mpmath.workdps(60):
                a, b = mpmath.mpf(x0), mpmath.mpf(x0 + d)
                at = [mpmath.mpf(g.subs(u, Symbol("z")).evalf(60, subs={"z": v})) for v in (a, b)]
                exact = (at[1] - at[0]) / (b - a) if d else mpmath.mpf(g.diff(u).evalf(60, subs={u: a}))
            value = found.subs({old: x0, new: x0 + d}) if d else found.subs(new, old)
            value = value.replace(
                lambda e: type(e).__name__ == "sinc", lambda e: sin(e.args[0]) / e.args[0] if e.args[0] else 1
            )
            assert float(value.subs(old, x0)) == pytest.approx(float(exact), rel=1e-14)


FUNCTIONS = {
    "softening": ("log_cosh", lambda x: mpmath.log(mpmath.cosh(x))),
    "penalty_bounce": ("negative_part", lambda x: min(x, mpmath.mpf(0))),
}


@pytest.mark.parametrize("scene", FUNCTIONS)
@pytest.mark.parametrize("d", [0.0, 1e-12, 1e-4, 0.12, 0.126, 1.0, -1e-12, -1e-4, -1.0])
def test_what_cannot_be_cancelled_is_guarded(scene: str, d: float) -> None:
    name, g = FUNCTIONS[scene]
    module = plain("energy_momentum", scene)
    difference, slope = (getattr(module, f"_{name}_{kind}") for kind in ("difference", "difference_slope"))
    for x0 in (-3.0, -0.4, 1e-3, 0.5, 4.0):
        x1 = x0 + d
        with mpmath.workdps(60):
            a, b = mpmath.mpf(x0), mpmath.mpf(x1)

            def exact(b: Any, a: Any = a) -> Any:
                return (g(b) - g(a)) / (b - a) if b != a else mpmath.diff(g, a)

            small = mpmath.mpf(10) ** -20
            expected = float(exact(b))
            by_new = (
                float((exact(b + small) - exact(b - small)) / (2 * small)) if d else float(mpmath.diff(g, a, 2) / 2)
            )
        with np.errstate(all="ignore"):
            assert difference(np.float64(x0), np.float64(x1)) == pytest.approx(expected, rel=1e-14, abs=1e-300)
            assert slope(np.float64(x0), np.float64(x1)) == pytest.approx(float(by_new), rel=2e-12, abs=1e-13)


@pytest.mark.parametrize(("x0", "x1"), [(0.05, 0.15), (0.05, 0.0502), (2.0, 2.1), (0.3, 0.3)])
def test_near_a_singularity_the_series_is_not_trusted(x0: float, x1: float) -> None:
    """A user's log: 0.1 apart is near at 2, and far at 0.05."""
    module = uncompiled(
        catalogue_pair(BY_NAME["energy_momentum"], EquationsOfMotion(declared(potential=k * (u**2 - log(u)))))
    )
    a, b = mpmath.mpf(x0), mpmath.mpf(x1)
    difference = mpmath.log(b / a) / (b - a) if x0 != x1 else 1 / a
    slope = (1 / b - difference) / (b - a) if x0 != x1 else -1 / (2 * a * a)
    assert module._log_difference(np.float64(x0), np.float64(x1)) == pytest.approx(float(difference), rel=1e-12)
    assert module._log_difference_slope(np.float64(x0), np.float64(x1)) == pytest.approx(float(slope), rel=1e-9)


def test_log_cosh_neither_overflows_nor_loses_digits() -> None:
    from substep_kernels.scenes.softening import _log_cosh

    x = np.array([0.0, 1e-9, -1e-4, 0.3, -2.0, 19.0, 21.0, 800.0, -1e6])
    with mpmath.workdps(40):
        exact = [float(mpmath.log(mpmath.cosh(mpmath.mpf(v)))) for v in x]
    assert _log_cosh(x) == pytest.approx(exact, rel=4e-16 * 4)


@pytest.mark.parametrize("h", [1e-3, 0.01, 0.1])
@pytest.mark.parametrize(("EA", "a0"), [(1e4, None), (1e10, (-19.6, 0.0))], ids=["flexible", "stiff"])
def test_energy_momentum_conserves_both(EA: float, a0: tuple[float, float] | None, h: float) -> None:
    r = ss.march(ss.scene("elastic_pendulum", EA=EA, a0=a0), ss.scheme("energy_momentum"), h, 2000 * h)
    assert r.status == "completed"
    assert np.abs(r.energy / r.energy[0] - 1).max() < 1e-11
    assert r.angular_momentum is not None
    assert np.abs(r.angular_momentum / r.angular_momentum[0] - 1).max() < 1e-11


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scene", ["duffing", "softening", "simple_pendulum", "elastic_pendulum_engineering"])
def test_energy_momentum_conserves_energy_of_every_potential(scene: str) -> None:
    strain = {"strain": "engineering", "EA": 1e4} if "engineering" in scene else {}
    here = ss.scene(scene.removesuffix("_engineering"), **strain)
    h = {"duffing": 0.02, "softening": 0.05, "simple_pendulum": 0.5}.get(scene, 0.05)
    r = ss.march(here, ss.scheme("energy_momentum"), h, 400 * h)
    assert r.status == "completed"
    assert np.abs(r.energy / r.energy[0] - 1).max() < 1e-11


def reference(name: str, t_end: float, method: str) -> np.ndarray:
    """(u, v) at t_end of the scene written by hand, at its default parameters, by SciPy."""
    force = {
        "duffing": lambda x: 100 * x * (1 + 10 * x**2),
        "softening": lambda x: 100 * np.tanh(x),
        "penalty_bounce": lambda x: 1e6 * np.minimum(x, 0.0),
    }[name]
    start = {"duffing": (1.5, 0.0), "softening": (4.0, 0.0), "penalty_bounce": (1e-3, -1.0)}[name]
    solution = solve_ivp(
        lambda t, y: [y[1], -force(y[0])], (0, t_end), start, method, rtol=3e-13, atol=1e-15, max_step=t_end / 200
    )
    return solution.y[:, -1]


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "energy_momentum", "central_difference", "rk4"])
@pytest.mark.parametrize("scene", ["duffing", "softening", "penalty_bounce"])
def test_against_an_independent_integration(scene: str, scheme: str) -> None:
    t_end = {"duffing": 0.2, "softening": 1.0, "penalty_bounce": 4e-3}[scene]
    exact = reference(scene, t_end, "DOP853")
    if scene != "penalty_bounce":
        assert reference(scene, t_end, "Radau") == pytest.approx(exact, rel=1e-9)
    s, n = ss.scheme(scheme), 2000
    found = []
    for steps in (n, 2 * n):
        r = ss.march(ss.scene(scene), s, t_end / steps, t_end)
        found.append(np.array([r.u[-1, 0], r.v[-1, 0]]))
    scale = np.abs(exact)
    errors = [np.abs(x - exact) / scale for x in found]
    assert (errors[1] < (1e-3 if scene == "penalty_bounce" else 1e-4)).all()
    if scene != "penalty_bounce":  # contact begins within a step, which costs the order
        order = 4 if scheme == "rk4" else 2
        extrapolated = found[1] + (found[1] - found[0]) / (2**order - 1)
        assert np.abs(extrapolated / exact - 1).max() < 2e-7


@pytest.mark.usefixtures("uncompiled")
def test_bathe_and_noh() -> None:
    """Bathe & Noh (2012): k1 -> infinity gives u2 = sin 1.2t, u3 = (30/11) sin t - (25/11) sin 1.2t."""
    scene, h = ss.scene("bathe_noh"), 0.2618
    l_stable = {
        "bathe": {}, "newmark_bdf2": {"gamma_t": 0.5, "beta": 0.36, "gamma": 0.7}, "park": {}, "houbolt": {},
        "oalts": {"rho_inf": 0.0}, "generalized_alpha": {"rho_inf": 0.0}, "rho_inf_bathe": {"rho_inf": 0.0},
        "three_substep": {"rho_inf": 0.0},
    }  # fmt: skip
    for name, parameters in l_stable.items():
        r = ss.march(scene, ss.scheme(name, **parameters), h, 100 * h)
        late = r.t > 10 * h
        assert np.abs(r.v[late, 0] - 1.2 * np.cos(1.2 * r.t[late])).max() < 0.06, name
        assert np.abs(r.a[late, 0] + 1.44 * np.sin(1.2 * r.t[late])).max() < 0.5, name
    bathe = ss.march(scene, ss.scheme("bathe"), h, 10 * h)
    assert np.abs(bathe.u[:, 1] - (30 * np.sin(bathe.t) - 25 * np.sin(1.2 * bathe.t)) / 11).max() < 0.06
    assert np.abs(bathe.v[2:, 0] - 1.2 * np.cos(1.2 * bathe.t[2:])).max() < 0.06  # clean after the first step
    r = ss.march(scene, ss.scheme("average_acceleration"), h, 100 * h)
    size = np.abs(r.a[:, 0])
    assert size[80:].max() > 1.8 * size[30:50].max() > 6 * size[5:10].max()


OWN = declared(
    name="my_bar",
    coordinates={u: "m", w: "m"},
    kinetic=m * (rate(u) ** 2 + 2 * rate(w) ** 2) / 2,
    potential=k * log(cosh(u)) + k * (1 - exp(-((u - w) ** 2) / 10)),
    dissipation=c * (rate(u) - rate(w)) ** 2 / 2,
    load={w: sampled},
    parameters=(optional(m, 2), required(k), optional(c, Rational(1, 5))),
    start={u: Rational(1, 2), w: 0, rate(u): 0, rate(w): 1},
    outputs={"elongation": u - w},
)


@pytest.mark.parametrize("scheme", ["bathe", "kr_alpha", "energy_momentum"])
def test_a_scene_of_ones_own(
    scheme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    """Two masses, a damper, a load, an exponential: from an energy to a cached kernel, against SciPy.

    The gate compiles that of the first scheme and runs the others' as plain Python; `make verify` compiles all.
    """
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    compiled = scheme == "bathe" or os.environ.get("SUBSTEP_VERIFY")
    if not compiled:
        request.getfixturevalue("plain_pairs")
    scene = ss.scene(OWN, k=30.0, load=ss.Harmonic(4.0, 3.0))
    r = ss.march(scene, ss.scheme(scheme), 5e-4, 2.0)
    assert r.status == "completed"
    assert r.outputs["elongation"] == pytest.approx(r.u[:, 0] - r.u[:, 1])

    def rates(t: float, y: np.ndarray) -> list[float]:
        x, z, vx, vz = y
        spring = 30 * np.exp(-((x - z) ** 2) / 10) * (x - z) / 5
        damper = 0.2 * (vx - vz)
        return [vx, vz, (-30 * np.tanh(x) - spring - damper) / 2, (4 * np.sin(3 * t) + spring + damper) / 4]

    y = solve_ivp(rates, (0, 2), [0.5, 0, 0, 1], "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    assert r.u[-1] == pytest.approx(y[:2], abs=1e-5)
    assert r.v[-1] == pytest.approx(y[2:], abs=1e-5)
    assert not compiled or list((tmp_path / "cache").glob("substep_own_*.py"))
    assert scene.a0 == pytest.approx(rates(0.0, np.array([0.5, 0, 0, 1]))[2:])


@pytest.mark.usefixtures("plain_in_gate")
def test_own_scheme_on_a_committed_scene_and_on_an_own_one() -> None:
    from test_own_scheme import OWN as TEXT

    space: dict = {}
    exec(TEXT, space)
    s = ss.scheme(space["mine"], gamma=0.6)
    same = ss.scheme("newmark", beta=0.18, gamma=0.6)
    scene = ss.scene("elastic_pendulum", EA=1e4)
    a, b = (ss.march(scene, x, 0.01, 1.0) for x in (s, same))
    assert np.allclose(a.u, b.u, rtol=0, atol=1e-12)


def test_given_and_consistent_accelerations() -> None:
    assert list(ss.scene("elastic_pendulum", EA=1e4).a0) == [0.0, 0.0]
    assert list(ss.scene("elastic_pendulum", EA=1e10, a0=(-19.6, 0)).a0) == [-19.6, 0.0]
    assert ss.scene("duffing").a0[0] == pytest.approx(-100 * 1.5 * (1 + 10 * 1.5**2))
    assert ss.scene("duffing", a0=3.0).a0[0] == 3.0
    assert ss.scene("elastic_pendulum", EA=1e4, strain="engineering").name == "elastic_pendulum_engineering"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ss.scene("elastic_pendulum"), "expected a value for EA of elastic_pendulum, got none"),
        (lambda: ss.scene("elastic_pendulum", EA=-1.0), r"EA of elastic_pendulum in \(0\.0, inf\), got -1"),
        (lambda: ss.scene("elastic_pendulum", EA=float("nan")), "EA of elastic_pendulum to be finite"),
        (lambda: ss.scene("elastic_pendulum", EA=1e4, a0=(1.0, 2.0, 3.0)), "a0 with 2 components"),
        (lambda: ss.scene("elastic_pendulum", EA=1e4, strain="log"), "one of: green_lagrange, engineering"),
        (lambda: ss.scene("elastic_pendulum", EA=1e4, strain=["engineering"]), "one of: green_lagrange, engineering"),
        (lambda: ss.scene("elastic_pendulum", EA=1e4, load=ss.Step(1.0)), "expected no load for elastic_pendulum"),
        (lambda: ss.scene("duffing", epsilon=1.0), "did you mean 'eps'"),
        (lambda: ss.scene("penalty_bounce", v0=1.0), r"v0 of penalty_bounce in \(-inf, 0\.0\), got 1"),
        (lambda: ss.scene("doffing"), "did you mean 'duffing'"),
        (
            lambda: ss.march(ss.scene("duffing"), ss.scheme("bathe"), 0.01, 0.1, stride=0),
            "stride to be a whole number of steps >= 1",
        ),
    ],
)
def test_wrong_input(call, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.usefixtures("plain_in_gate")
def test_failures_keep_what_was_computed() -> None:
    scene = ss.scene("elastic_pendulum", EA=1e10, a0=(-19.6, 0))
    r = ss.march(scene, ss.scheme("average_acceleration"), 0.1, 50.0)
    assert r.status == "newton_failed"
    assert r.t_failed == pytest.approx(r.t[-1] + 0.1)
    assert len(r.t) == len(r.u) == len(r.energy) == len(r.newton_iterations) + 1
    assert (r.newton_iterations > 0).all()
    assert np.isfinite(r.u).all()
    bounded = ss.march(scene, ss.scheme("average_acceleration"), 0.1, 50.0, energy_bound=1.1 * scene.E0)
    assert bounded.status == "energy_bound"
    assert bounded.t_failed == pytest.approx(3.5)
    assert np.array_equal(bounded.u, r.u[: len(bounded.u)])
    thinned = ss.march(scene, ss.scheme("bathe"), 0.1, 5.0, stride=10)
    assert np.array_equal(thinned.u, ss.march(scene, ss.scheme("bathe"), 0.1, 5.0).u[::10])
    blown = ss.march(ss.scene("elastic_pendulum", EA=1e10), ss.scheme("forward_euler"), 0.1, 50.0)
    assert blown.status == "non_finite"
    with pytest.raises(AttributeError, match="a scene with a strain"):
        _ = ss.march(ss.scene("linear_oscillator", omega=1.0), ss.scheme("bathe"), 0.1, 1.0).strain


@pytest.mark.usefixtures("plain_in_gate")
def test_multi_step_schemes_start_within_strides_and_failures() -> None:
    scene = ss.scene("elastic_pendulum", EA=1e4)
    whole, thin = (ss.march(scene, ss.scheme("houbolt"), 0.01, 0.2, stride=k) for k in (1, 5))
    assert np.array_equal(whole.u[::5], thin.u)
    short = ss.march(scene, ss.scheme("houbolt"), 0.01, 0.01)
    assert np.array_equal(short.u, ss.march(scene, ss.scheme("average_acceleration"), 0.01, 0.01).u)
    early = ss.march(scene, ss.scheme("park"), 0.01, 0.2, energy_bound=1.0)
    assert (early.status, early.t_failed, len(early.t)) == ("energy_bound", 0.01, 1)


def test_every_scene_says_what_it_is() -> None:
    assert set(SCENE_BY_NAME) == set(SCENES)
    for name in SCENE_BY_NAME:
        assert motion(name).scene.reference
