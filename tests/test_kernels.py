"""Every kernel is read: it holds what its scene needs and nothing more; and fuzzed: it ends, with a status."""

import ast
import os
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, TOGETHER, UNDAMPED, explicit, random_parameters
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_kernels import SCENE_BY_NAME, gate_pairs, motion, plain, text, variant
from substep_derive.declare.symbols import knot
from substep_derive.package import COMMITTED
from substep_derive.step.step import Step
from substep_kernels.scene_index import SCENES as SCENES_INDEX

import substep as ss
from substep.core.outcome import STATUSES
from substep.marching import scene_lanes

EXPLICIT = {name for name, scheme in BY_NAME.items() if explicit(scheme)}
LINEAR = {"linear_oscillator", "bathe_noh", "rigid_pendulum"}
WITH_TIME = {"bathe_noh"}  # scenes that know the time
CONTROL = {"state", "bound", "first", "n", "stride", "out", "extremes"}
# what each scene's equation of motion and energy hold, read off their textbooks
SYMBOLS = {
    "linear_oscillator": {"omega", "xi"}, "bathe_noh": {"k1", "k2", "omega_p"}, "rigid_pendulum": {"L", "m"},
    "elastic_pendulum": {"EA", "L", "m"}, "elastic_pendulum_engineering": {"EA", "L", "m"},
    "simple_pendulum": {"g_over_L"}, "duffing": {"k", "eps"}, "softening": {"k"}, "penalty_bounce": {"k"},
}  # fmt: skip
PAIRS = [(scheme, scene) for scheme in BY_NAME for scene in SCENE_BY_NAME
         if scene != "linear_oscillator" or scheme not in UNDAMPED]  # fmt: skip


# those that are printed for other tests of the gate
SOME = PAIRS if os.environ.get("SUBSTEP_VERIFY") else gate_pairs()


def lane(scheme: str, scene: str) -> ast.FunctionDef:
    tree = ast.parse(text(scheme, scene))
    return next(n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == "_lane")


def loop_of(function: ast.FunctionDef) -> ast.For:
    return next(n for n in function.body if isinstance(n, ast.For))


def names(node: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}


def test_the_sets_are_complete() -> None:
    assert set(SYMBOLS) == set(SCENE_BY_NAME)
    assert set(BY_NAME) >= EXPLICIT
    assert {name for name in SCENE_BY_NAME if motion(name).linear} == LINEAR


@pytest.mark.pairs
@pytest.mark.parametrize(("scheme", "scene"), PAIRS)
def test_a_kernel_holds_what_its_scene_needs(scheme: str, scene: str) -> None:
    function = lane(scheme, scene)
    loop, linear, explicit = loop_of(function), scene in LINEAR, scheme in EXPLICIT
    arguments = {a.arg for a in function.args.args}
    read = {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
    assert arguments <= read, "an argument that nothing reads"
    # a parameter that only the default of another one reads is no argument of a kernel
    of_scheme = {f"{p.name}_" for p in BY_NAME[scheme].parameters if p.symbol in BY_NAME[scheme].mentioned}
    control = CONTROL | ({"forces"} if scene == "linear_oscillator" else set())
    control |= {"since"} if scene in WITH_TIME else set()
    control |= set() if linear or explicit else {"tolerance", "iterations", "newton"}
    assert arguments - of_scheme == {"h"} | {f"{name}_" for name in SYMBOLS[scene]} | control
    if scene != "rigid_pendulum":  # whose force vanishes, and with it what weights the force
        assert of_scheme <= arguments
    inner = [n for n in ast.walk(loop) if isinstance(n, ast.For | ast.While) and n is not loop]
    assert len(inner) == (0 if linear or explicit else len(Step.of(BY_NAME[scheme]).stages))
    stored = any(kind == "a" and lag == 0 for kind, lag in plain(scheme, scene).STATE)
    assert stored == (knot(0).a in BY_NAME[scheme].state)
    used = names(function)
    if len(motion(scene).coordinates) == 1 and scheme not in TOGETHER:
        assert not {n for n in used if n in ("one_over_det", "change_1", "jacobian_01")}
    elif inner and scheme not in TOGETHER:
        assert {"one_over_det", "change_1"} <= names(inner[0])
    if (
        not inner and scheme not in TOGETHER
    ):  # constant matrices are inverted before the first step: what is divided by is a number
        divisors = [n.right for n in ast.walk(loop) if isinstance(n, ast.BinOp) and isinstance(n.op, ast.Div)]
        if scene != "elastic_pendulum_engineering":  # whose force divides by the bar's length
            assert all(isinstance(d, ast.Constant) for d in divisors)
    if scene != "linear_oscillator":
        assert not {n for n in used if n.startswith("f_")}


def test_the_rigid_pendulum_needs_less_than_the_elastic_one() -> None:
    for scheme in [scheme for scheme, scene in SOME if scene == "rigid_pendulum"]:
        elastic, rigid = (plain(scheme, scene).OPERATIONS for scene in ("elastic_pendulum", "rigid_pendulum"))
        assert rigid["iteration"] == ()
        assert 2 * rigid["step"] < elastic["step"] + 2 * sum(elastic["iteration"])


@st.composite
def runs(draw: st.DrawFn, pairs: Sequence[tuple[str, str]] = SOME) -> tuple[ss.Scene, ss.Scheme, float]:
    scheme, scene = draw(st.sampled_from(pairs))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    parameters = {k: float(Fraction(str(v))) for k, v in random_parameters(BY_NAME[scheme], rng).items()}
    options: dict[str, Any] = {}
    for key, low, high, *_, default in SCENES_INDEX[scene]["parameters"]:
        size = 10.0 ** draw(st.floats(-3, 3)) * (default or 1.0)
        if low == 0.0 and draw(st.booleans()):
            options[key] = size
        elif low is None and draw(st.booleans()):
            options[key] = -abs(size) if high == 0.0 else draw(st.sampled_from([-1.0, 0.0, 1.0])) * size
        elif default is None:
            options[key] = size
    if "xi" in options:
        options["overdamped"] = True  # ratios are meant as they are
    if scene == "simple_pendulum" and abs(float(options.get("u0", 0.0))) > 6.0:
        options["u0"] = 6.0  # rad: more than a turn is refused
    d = len(motion(scene).coordinates)
    a0 = draw(st.sampled_from([None, "consistent", [draw(st.floats(-1e3, 1e3))] * d]))
    return variant(scene, a0=a0, **options), ss.scheme(scheme, **parameters), 10.0 ** draw(st.floats(-7, 2))


def ends_with_a_status(scene: ss.Scene, scheme: ss.Scheme, dt: float) -> None:
    n = 12
    found = scene_lanes.march_lanes(
        scene, scheme, np.array([dt]), np.array([n]), bound=1e250, history=True, counts=True
    )
    status, done = STATUSES[found.status[0]], int(found.n_done[0])
    assert 0 <= done <= n
    assert (done == n) == (status == "completed")
    assert np.isfinite(found.out[0, : done + 1]).all()
    assert found.iterations.max() <= 50


@pytest.mark.filterwarnings("ignore:.* is not A-stable at")
@pytest.mark.thorough
@settings(max_examples=3000 if os.environ.get("SUBSTEP_VERIFY") else 250)
@given(runs())
def test_any_run_ends_with_a_status_and_loses_nothing(run: tuple[ss.Scene, ss.Scheme, float]) -> None:
    with pytest.MonkeyPatch.context() as patch, np.errstate(all="ignore"):
        patch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: plain(scheme.name, scene.name))
        ends_with_a_status(*run)


VERIFY = bool(os.environ.get("SUBSTEP_VERIFY"))
ON_THE_BAR = [pair for pair in SOME if pair[1].startswith("elastic_pendulum")] if VERIFY else COMMITTED


@pytest.mark.filterwarnings("ignore:.* is not A-stable at")
@settings(max_examples=1000 if VERIFY else 100)
@given(runs(ON_THE_BAR))
def test_so_does_any_compiled_run(run: tuple[ss.Scene, ss.Scheme, float]) -> None:
    """On the bar with either strain in `make verify`, in the gate with schemes whose kernels are compiled already."""
    ends_with_a_status(*run)


@pytest.mark.skipif(not os.environ.get("SUBSTEP_VERIFY"), reason="compiles every pair; part of make verify")
@pytest.mark.parametrize(("scheme", "scene"), PAIRS)
def test_every_pair_compiles_and_steps_as_its_plain_text(scheme: str, scene: str) -> None:
    from by_hand import SCENES

    hand = SCENES[scene]
    here = variant(scene, **hand.parameters)
    s = ss.scheme(scheme)
    compiled = scene_lanes.march_lanes(here, s, np.array([hand.dt]), np.array([20]), history=True)
    with pytest.MonkeyPatch.context() as patch, np.errstate(all="ignore"):
        patch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: plain(scheme.name, scene.name))
        python = scene_lanes.march_lanes(here, s, np.array([hand.dt]), np.array([20]), history=True)
    assert np.allclose(compiled.out, python.out, rtol=1e-9, atol=1e-9 * np.abs(python.out).max())
    assert compiled.status[0] == python.status[0]
