"""A layout is a row: its march is printed from the same step as those of the layouts that there are."""

import ast
from collections.abc import Sequence

import numpy as np
import plain_kernels
import pytest
from declared import BY_NAME
from substep_derive.declare.catalogue import find_scene
from substep_derive.emit.first_use import catalogue_pair
from substep_derive.emit.one_lane import ONE_LANE
from substep_derive.emit.pair_module import LAYOUTS, pair_module
from substep_derive.emit.printing import lines, placed
from substep_derive.emit.step_text import Layout, StepText
from substep_derive.emit.templates.step import NEWTON
from substep_derive.kernels.body import Body
from substep_derive.motion.effective import effective_systems
from substep_derive.motion.equations import EquationsOfMotion

FIRST_STEP = """

def first_step({arguments}):
    own, n = np.zeros({size}), 1
{read}
{constants}
    for i in range(1):
{step}
        return [{reported}], energy
    return status
"""


def _names(body: Body) -> dict[str, str]:
    """Every number of a run is in one array, as in the memory of a thread."""
    names = [name for name, _ in body.places] + [str(s) for s, _ in (*body.constants, *body.near)]
    return {name: f"own[{k}]" for k, name in enumerate(names)}


def _march(body: Body, step: StepText, arguments: Sequence[str]) -> str:
    w = step.printer
    return FIRST_STEP.format(
        arguments=", ".join([*body.scalars, "state", "forces"]),
        size=len(w.names),
        read=placed((f"{w.names[name]} = state[{place}]" for name, place in body.places), 1),
        constants=lines([*body.constants, *body.near], 1, w),
        step=step.phases + step.last,
        reported=", ".join(w.doprint(e) for vector in body.report for e in vector),
    )


@pytest.mark.parametrize(
    ("scheme", "scene"),
    [
        ("newmark_bdf2", "elastic_pendulum"),
        ("energy_momentum", "penalty_bounce"),
        ("rk4", "simple_pendulum"),
        ("kr_alpha", "linear_oscillator"),
    ],
)
def test_a_layout_that_keeps_a_lane_in_an_array_makes_the_same_step(scheme: str, scene: str) -> None:
    declared, motion = BY_NAME[scheme].in_kernels, plain_kernels.motion(scene).in_kernels
    body, thread = Body.of(declared, motion), Layout("", NEWTON, "", _names, _march)
    assert ONE_LANE in LAYOUTS
    text = pair_module(body, effective_systems(BY_NAME[scheme]), "", (ONE_LANE, thread))
    kernels = plain_kernels.uncompiled(text)
    assert "march_block" not in vars(kernels)
    random, d = np.random.default_rng(8), len(motion.coordinates)
    numbers = {name: random.uniform(0.3, 0.9, 1) for name in kernels.SCALARS}
    numbers |= {"h": np.array([0.01]), "tolerance": np.array([1e-12])}
    state = random.uniform(0.4, 1.0, (1, len(kernels.STATE), d))
    forces = random.uniform(-1.0, 1.0, (1, 1, max(len(body.stencil), 1)))
    given = [numbers[name][0] for name in kernels.SCALARS]
    reported, energy = kernels.first_step(*given, state[0].copy(), forces[0])
    out, results = np.zeros((1, 2, len(body.report), d)), {"peak": np.zeros(1), "n_done": np.zeros(1, int)}
    results |= {"status": np.zeros(1, int), "newton": np.zeros((1, 2, 3), int), "iterations": np.zeros((1, 1, 3), int)}
    steps = {"first": 0, "n": np.array([1]), "stride": 1, "out": out, "bound": np.array([np.inf])}
    steps["extremes"] = np.zeros((1, 0))
    values = {**numbers, **steps, **results, "state": state, "forces": forces}
    kernels.march(*(values[name] for name in kernels.ARGUMENTS))
    assert results["status"][0] == kernels.COMPLETED
    assert np.array_equal(out[0, 1].ravel(), reported)
    assert results["peak"][0] == energy


@pytest.mark.parametrize("scene", ["rotating_hoop", "double_pendulum", "mass_on_floor"])
def test_what_a_block_counts_by_is_no_variable_of_a_step(scene: str) -> None:
    """A name that is a number of the step, and counts rows elsewhere in the function, has two types and no kernel."""
    text = catalogue_pair(BY_NAME["newmark"], EquationsOfMotion(find_scene(scene)))
    (block,) = (x for x in ast.parse(text).body if isinstance(x, ast.FunctionDef) and x.name == "_block")
    counted = {x.target.id for x in ast.walk(block) if isinstance(x, ast.For) and isinstance(x.target, ast.Name)}
    given = [target for x in ast.walk(block) if isinstance(x, ast.Assign) for target in x.targets]
    assert counted
    assert not counted & {
        x.id for target in given for x in ast.walk(target) if isinstance(x, ast.Name) and isinstance(x.ctx, ast.Store)
    }
