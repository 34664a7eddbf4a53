"""Calls as a newcomer writes them: names, handles, arguments by position, masks, loads of one time, extreme Omega."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from substep_kernels.facts import CATALOGUE

import substep as ss
from substep.core.errors import called_as

OSCILLATOR = ss.scene("linear_oscillator", omega=6.28)
BATHE = ss.scheme("bathe")
M, K = np.eye(2), np.array([[3.0, -1.0], [-1.0, 2.0]])
MOTION = np.sin(np.arange(20.0))

Call = Callable[[Any], Any]
TAKE_A_SCHEME: dict[str, Call] = {
    "march": lambda s: ss.march(OSCILLATOR, s, 0.1, 1.0),
    "march of a structure": lambda s: ss.march(ss.structure(M, K), s, 0.1, 1.0),
    "march of modes": lambda s: ss.march(ss.structure(M, K).modes(1), s, 0.1, 1.0),
    "sweep": lambda s: ss.sweep(OSCILLATOR, s, dt=0.1, t_end=1.0),
    "sweep of a structure": lambda s: ss.sweep(ss.structure(M, K), s, dt=0.1, t_end=1.0),
    "spectrum": lambda s: ss.response_spectrum(MOTION, dt=0.1, periods=[1.0], scheme=s),
    "critical step": lambda s: ss.structure(M, K).critical_step(s),
}
TAKE_A_SCENE: dict[str, Call] = {
    "march": lambda scene: ss.march(scene, "bathe", 0.1, 1.0),
    "sweep": lambda scene: ss.sweep(scene, "bathe", dt=0.1, t_end=1.0),
    "choose": lambda scene: ss.choose(scene, 0.5, t_end=0.1, among=["bathe"], chosen=[]),
}


@pytest.mark.matrix
@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("entry", TAKE_A_SCHEME)
def test_a_scheme_is_named_or_a_handle(entry: str) -> None:
    call = TAKE_A_SCHEME[entry]
    by_name, by_handle = (call(s) for s in ("average_acceleration", ss.scheme("average_acceleration")))
    for found in (by_name, by_handle):
        assert type(found) is type(by_name)
    values = [np.asarray(x.u if hasattr(x, "u") else getattr(x, "displacement", 0.0)) for x in (by_name, by_handle)]
    assert np.array_equal(*values)
    with pytest.raises(ValueError, match=r"write scheme\('newmark', beta=1/4,gamma=\.5\) in Python"):
        call("newmark:beta=1/4,gamma=.5")
    with pytest.raises(ValueError, match=r"expected a scheme by name, handle or declaration, got 3; .*schemes\(\)"):
        call(3)
    with pytest.raises(ValueError, match="did you mean 'bathe'"):
        call("bath")
    with pytest.raises(ValueError, match=r"expected a scheme .*got Scene\(linear_oscillator, omega=6.28"):
        call(OSCILLATOR)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("entry", TAKE_A_SCENE)
def test_a_scene_is_named_or_a_handle(entry: str) -> None:
    call = TAKE_A_SCENE[entry]
    assert type(call("duffing")) is type(call(ss.scene("duffing")))
    with pytest.raises(ValueError, match=r"expected a scene by name, handle or declaration, got .*scenes\(\)"):
        call(BATHE)
    with pytest.raises(ValueError, match="did you mean 'duffing'"):
        call("dufing")


def test_a_handle_stands_for_itself_and_takes_no_more() -> None:
    assert ss.scheme(BATHE) is BATHE
    assert ss.scene(OSCILLATOR) is OSCILLATOR
    with pytest.raises(ValueError, match="expected a name with parameters"):
        ss.scheme(ss.scheme("newmark"), beta=0.3)
    for more in ({"omega": 1.0}, {"a0": 1.0}, {"load": ss.Step(1.0)}):
        with pytest.raises(ValueError, match="expected a name with parameters, a0 or load"):
            ss.scene(OSCILLATOR, **more)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: ss.scheme("newmark", 0.25), ['scheme("newmark", beta=0.25', "too many positional"]),
        (ss.scheme, ['scheme("newmark"', "missing", "'name'"]),
        (lambda: ss.scene("linear_oscillator", 6.28), ["omega=6.28", "too many positional", "a0, load, **parameters"]),
        (lambda: ss.march("duffing", "bathe", 0.1, 1.0, 3), ["dt=0.01", "scene, scheme, dt, t_end and, by name only"]),
        (lambda: ss.march("duffing"), ["march(", "'scheme'"]),
        (lambda: ss.sweep("duffing", "bathe", 0.1, 1.0), ["sweep(", "too many positional", "by name only, t_end, dt"]),
        (lambda: ss.structure(M, K, K), ["structure(M, K, C=C", "too many positional"]),
        (lambda: ss.structure(M, K, D=K), ["'D'", "internal_force"]),
        (lambda: ss.choose("duffing", 1e-3, 1.0), ["choose(", "too many positional"]),
        (lambda: ss.choose("duffing", 1e-3), ["t_end=10.0", "missing"]),
        (lambda: ss.choose(ss.structure(M, K), 1e-3, t_end=1.0), ['quantity="roof"', "'quantity'"]),
        (lambda: ss.response_spectrum(MOTION, dt=0.1, damping=0.05), ["xi=0.05", "'damping'", "periods, xi"]),
        (ss.audit, ["audit(run", "'stepper'"]),
    ],
)
def test_a_call_that_does_not_fit_is_answered_with_one_that_does(call: Callable[[], Any], words: list[str]) -> None:
    with pytest.raises(TypeError, match="expected a call such as") as raised:
        call()
    assert all(word in str(raised.value) for word in words), raised.value


def test_a_type_error_inside_a_function_stays_its_own() -> None:
    @called_as("f(1)")
    def f(x: Any) -> Any:
        return x + "one"

    with pytest.raises(TypeError, match="unsupported operand"):
        f(1)


@pytest.mark.parametrize(
    "call",
    [
        BATHE.spectral_radius,
        lambda x: BATHE.stability(1.0, x),
        BATHE.amplification,
        BATHE.power_norm,
        lambda x: ss.scheme("newmark", beta=x),
        lambda x: ss.scheme("generalized_alpha", rho_inf=x),
        lambda x: ss.Record(0.1, x),
        lambda x: ss.response_spectrum(x, dt=0.1),
        lambda x: ss.structure(np.ma.array(M, mask=M), K),
        lambda x: ss.structure(M, K, u0=x),
        lambda x: ss.scene("elastic_pendulum", EA=1e4, a0=x),
        lambda x: ss.sweep("duffing", "bathe", dt=0.1, t_end=1.0, u0=x),
        lambda x: ss.march(ss.scene("linear_oscillator", omega=1.0, load=np.ma.array), BATHE, 0.1, 1.0),
    ],
)
def test_a_mask_is_not_dropped(call: Call) -> None:
    with pytest.raises(ValueError, match=r"without a mask, got a masked array; .*compressed"):
        call(np.ma.array([0.3, 0.4], mask=[False, True]))


@pytest.mark.parametrize(
    "load",
    [lambda t: 1.0, math.sin, lambda t: 1.0 if t < 0.5 else 0.0, lambda t: t[:1]],
    ids=["constant", "math.sin", "if", "another shape"],
)
@pytest.mark.parametrize("dt", [0.1, [0.1, 0.2]], ids=["march", "sweep"])
def test_a_load_of_one_time_is_refused_with_the_cure(load: Any, dt: Any) -> None:
    with pytest.raises(ValueError, match=r"expected a load that takes an array of times .*np.where in place of if"):
        scene = ss.scene("linear_oscillator", omega=1.0, load=load)
        ss.march(scene, "bathe", dt, 1.0) if isinstance(dt, float) else ss.sweep(scene, "bathe", dt=dt, t_end=1.0)


def test_a_load_that_is_not_finite_is_refused_as_such() -> None:
    scene = ss.scene("linear_oscillator", omega=1.0, load=lambda t: np.where(t > 0.5, np.inf, 0.0))
    with pytest.raises(ValueError, match="expected a finite load at every time, got inf"):
        ss.march(scene, "bathe", 0.1, 1.0)


@pytest.mark.parametrize("name", ss.schemes())
def test_extreme_omega_gives_the_limit_or_is_refused(name: str) -> None:
    """At small Omega every scheme has the errors 0; at large Omega a radius is finite and right, or refused."""
    s = ss.scheme(name)
    small = np.array([0.0, 5e-324, 1e-320, 1e-300, 1e-162, 1e-155, 1e-151, 1e-150, 1e-140])
    radius, damping, period = s.stability(small)
    assert radius == pytest.approx(1.0, abs=1e-14)
    assert abs(damping).max() < 1e-100
    assert abs(period).max() < 1e-100
    assert s.stability(1e-300)[1:] == (0.0, 0.0)
    for Omega in 10.0 ** np.array([9, 20, 45, 60, 100, 150, 156, 200, 300]):
        try:
            found = float(s.spectral_radius(Omega))
        except ValueError as error:
            assert f"Omega = {Omega}" in str(error)
            with pytest.raises(ValueError, match=f"a step of {name} can be computed"):
                s.stability(np.array([1.0, Omega, 2.0]))
            break
        if s.spectral_radius(1e6) < 2.0:  # neither grows nor has grown
            limit = float(s.rho_inf)  # bdf4 approaches it as slowly as Omega^(-1/4)
            assert abs(found - limit) <= abs(float(s.spectral_radius(1e8)) - limit) + 2e-3
        else:
            assert 2.0 < found < math.inf


FALLING = ("lobatto_iiic3",)  # the angle of whose pair falls with 1/Omega, by which damping is divided


@pytest.mark.parametrize("name", ss.schemes())
def test_errors_at_extreme_omega_are_those_of_a_pair_or_refused(name: str) -> None:
    """They are NaN only where the pair has become real, as derivation has found; where rounding hides it, refused."""
    s, refused = ss.scheme(name), False
    for Omega in 10.0 ** np.array([7.3, 8.1, 9.0, 9.4, 11.0, 15.4, 16.0, 18.0, 20.0, 30.0, 60.0]):
        try:
            _, damping, period = s.stability(Omega)
        except ValueError as error:
            assert f"Omega = {Omega}" in str(error)
            refused |= "can be told apart" in str(error)
            continue
        assert math.isnan(damping) == math.isnan(period) == math.isnan(s.numerical_damping([1.0, Omega])[1])
        assert math.isfinite(damping) or CATALOGUE[name]["bifurcation"] != "oo"
        grows = name in FALLING or s.spectral_radius(1e8) > 2.0
        assert math.isnan(damping) or abs(damping) < 1e7 or grows
    if refused:
        assert CATALOGUE[name]["bifurcation"] == "oo"


def test_a_pair_hidden_by_rounding_is_refused_and_a_real_one_is_not() -> None:
    hidden, real = ss.scheme("rk2"), ss.scheme("newmark", beta=0.25, gamma=0.9)
    with pytest.raises(
        ValueError, match=r"rk2 can be told apart, got Omega = 1000000000000\.0, .*ask for spectral_radius alone"
    ):
        hidden.period_error([[0.1, 5.0], [2.0, 1e12]])
    assert np.isnan(hidden.stability(1e12, [1.0, 2.0])[1]).all()  # xi >= 1
    assert np.isnan(real.numerical_damping([1e9, 1e12, 1e20])).all()
    with pytest.raises(ValueError, match=r"rho_inf_bathe can be told apart, got Omega = 1e\+16"):
        ss.scheme("rho_inf_bathe").numerical_damping(1e16)  # whose pair seems complex there, by rounding
    with pytest.raises(ValueError, match=r"bdf_alpha can be told apart, got Omega = 1e\+17, xi = 0\.5"):
        ss.scheme("bdf_alpha").stability([1e9, 1e17], 0.5)  # whose second pair seems to be the only one


def test_the_point_beyond_reach_is_found_among_many() -> None:
    Omega = np.linspace(0.0, 10.0, 30_000)
    Omega[17_000] = 1e200
    with pytest.raises(ValueError, match=r"got Omega = 1e\+200, xi = 0.0"):
        BATHE.stability(Omega)
    with pytest.raises(ValueError, match="amplification matrix is"):
        BATHE.amplification([1.0, 1e200])
    Omega[17_000] = 1e-200
    assert BATHE.numerical_damping(Omega)[17_000] == 0.0


@pytest.mark.parametrize("package", ["substep_audit", "substep_audit.programs", "substep.cli", "study", "substeps", ""])
def test_a_warning_points_at_the_line_outside_of_ours_and_what_extends_it(package: str) -> None:
    """Ours are substep and packages whose name begins with it and an underscore, as those of extras/."""
    module: dict[str, Any] = {"__package__": package, "unstable": OSCILLATOR, "march": ss.march}
    exec(
        compile("def run():\n    march(unstable, 'central_difference', dt=1.0, t_end=40.0)", "theirs.py", "exec"),
        module,
    )
    with pytest.warns(UserWarning, match="central_difference is unstable") as warned:
        module["run"]()
    ours = package.partition(".")[0] in ("substep", "substep_audit")
    assert [w.filename for w in warned] == [__file__ if ours else "theirs.py"]
