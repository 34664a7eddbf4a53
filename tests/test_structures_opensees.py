"""A frame and a shear building of OpenSees, read by `from_opensees`, have OpenSees' own histories in substep.

OpenSees runs in a process of its own: it crashes where MKL was loaded before it, as by PARDISO in another test.
"""

from concurrent.futures import Executor
from typing import Any

import numpy as np
import pytest

import substep as ss
from substep.structures.readers import from_opensees

DT, STEPS = 0.01, 100
WAVE = np.sin(2 * np.pi * 1.5 * np.arange(STEPS + 3) * DT)
PUSH, SHAKE = 1e4 * WAVE, 2.0 * WAVE  # N, m/s^2
ROOF = 5  # the node that is looked at, in both models
MASSES, SPRINGS = (3e4, 3e4, 2.5e4, 2e4), (6e7, 5e7, 4e7, 2.5e7)  # kg and N/m of each storey, from the ground up


def frame(ops: Any) -> None:
    """A frame of two storeys and one bay with lumped masses and Rayleigh damping."""
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for tag, (x, y) in enumerate([(0, 0), (6, 0), (0, 3), (6, 3), (0, 6), (6, 6)], 1):
        ops.node(tag, float(x), float(y))
        if y == 0:
            ops.fix(tag, 1, 1, 1)
        else:
            ops.mass(tag, 2000.0, 2000.0, 500.0)
    ops.geomTransf("Linear", 1)
    for tag, ends in enumerate([(1, 3), (2, 4), (3, 4), (3, 5), (4, 6), (5, 6)], 1):
        ops.element("elasticBeamColumn", tag, *ends, 0.16, 3e10, 0.16 * 0.16 / 12, 1)
    ops.rayleigh(0.5, 1e-4, 0.0, 0.0)


def shear_building(ops: Any) -> None:
    """Four masses on springs, with a dashpot in each storey; that of the roof is strong, so that it couples modes."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for tag in range(1, ROOF + 1):
        ops.node(tag, 0.0)
    ops.fix(1, 1)
    for tag, (m, k, c) in enumerate(zip(MASSES, SPRINGS, (6e4, 5e4, 4e4, 2e5), strict=True), 1):
        ops.mass(tag + 1, m)
        ops.uniaxialMaterial("Elastic", tag, k, c)
        ops.element("zeroLength", tag, tag, tag + 1, "-mat", tag, "-dir", 1)


def in_opensees(model: str, integrator: tuple[Any, ...]) -> tuple[Any, ss.Structure] | str:
    """u, v, a (steps + 1, 3) of the roof and the structure as it is read; or why OpenSees cannot be imported."""
    try:
        import openseespy.opensees as ops  # pyright: ignore[reportMissingImports]
    except (ImportError, RuntimeError) as error:  # besides the wheel it needs BLAS and LAPACK of the system
        return f"openseespy cannot be imported: {error}"
    build = {"frame": frame, "shear building": shear_building}[model]
    build(ops)
    if model == "frame":
        own = from_opensees(ops, load=({f"{ROOF} 1": 1.0}, ss.Record(DT, PUSH)))
    else:
        own = from_opensees(ops).ground_motion(ss.Record(DT, SHAKE), 1.0)
    build(ops)
    ops.timeSeries("Path", 1, "-dt", DT, "-values", *(PUSH if model == "frame" else SHAKE).tolist())
    if model == "frame":
        ops.pattern("Plain", 1, 1)
        ops.load(ROOF, 1.0, 0.0, 0.0)
    else:
        ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.wipeAnalysis()
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator(*integrator)
    ops.analysis("Transient")
    rows = [[0.0, 0.0, 0.0]]
    for _ in range(STEPS):
        assert ops.analyze(1, DT) == 0
        rows.append([ops.nodeDisp(ROOF, 1), ops.nodeVel(ROOF, 1), ops.nodeAccel(ROOF, 1)])
    return np.array(rows), own


def fixed_in_opensees() -> str:
    """What is said of a model without free degrees of freedom, in which OpenSees' own analysis ends the process."""
    try:
        import openseespy.opensees as ops  # pyright: ignore[reportMissingImports]
    except (ImportError, RuntimeError) as error:
        return f"openseespy cannot be imported: {error}"
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.fix(1, 1)
    ops.node(2, 1.0)
    ops.equalDOF(1, 2, 1)
    with pytest.raises(ValueError, match="expected a model with free degrees of freedom in OpenSees, got none"):
        from_opensees(ops)
    return ""


def test_a_model_without_free_degrees_of_freedom_is_refused(child: Executor) -> None:
    if said := child.submit(fixed_in_opensees).result():
        pytest.skip(said)


@pytest.mark.parametrize("model", ["frame", "shear building"])
@pytest.mark.parametrize(
    ("scheme", "integrator"),
    [
        (ss.scheme("average_acceleration"), ("Newmark", 0.5, 0.25)),
        (ss.scheme("newmark", beta=0.3025, gamma=0.6), ("Newmark", 0.6, 0.3025)),
        (ss.scheme("hht_alpha", alpha=-0.1), ("HHT", 0.9)),
        (ss.scheme("generalized_alpha", rho_inf=0.8), ("GeneralizedAlpha", 2 / 3, 5 / 9)),
    ],
    ids=["average", "newmark", "hht", "generalized_alpha"],
)
def test_histories_are_those_of_opensees(
    child: Executor, model: str, scheme: ss.Scheme, integrator: tuple[Any, ...]
) -> None:
    """u, v, a to 1e-11 of the largest; OpenSees' alphas are 1 minus, or plus, those of the papers."""
    found = child.submit(in_opensees, model, integrator).result()
    if isinstance(found, str):
        pytest.skip(found)
    theirs, own = found
    nodes, dofs = ((3, 4, 5, 6), (1, 2, 3)) if model == "frame" else ((2, 3, 4, 5), (1,))
    assert set(own.names) == {f"{node} {dof}" for node in nodes for dof in dofs}
    if model == "shear building":
        assert not own.modes(4).classical
    r = ss.march(own, scheme, dt=DT, t_end=STEPS * DT, dofs=[f"{ROOF} 1"], account=False)
    ours = np.column_stack(r.at(f"{ROOF} 1"))
    assert (np.abs(ours - theirs).max(axis=0) <= 1e-11 * np.abs(theirs).max(axis=0)).all()


STORIES, YIELDING = 10, 500  # and steps
SHAKING = np.append(0.0, 10.0 * np.random.default_rng(1).normal(size=YIELDING + 2))  # m/s^2


def yielding_building() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Masses, stiffness, strength and dashpots of the stories of a building, kg, N/m, N and N s/m."""
    k, q_y = np.linspace(3e7, 1e7, STORIES), np.linspace(3e5, 1e5, STORIES)
    return np.full(STORIES, 2e4), k, q_y, np.full(STORIES, 1e5)


def steel_in_opensees() -> np.ndarray | str:
    """Displacements (steps, stories) of that building with OpenSees' Steel01 in each story, by Newton's iteration."""
    try:
        import openseespy.opensees as ops  # pyright: ignore[reportMissingImports]
    except (ImportError, RuntimeError) as error:
        return f"openseespy cannot be imported: {error}"
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(0, 0.0)
    ops.fix(0, 1)
    for tag, (m, k, q_y, c) in enumerate(zip(*(x.tolist() for x in yielding_building()), strict=True), 1):
        ops.node(tag, 0.0)
        ops.mass(tag, m)
        ops.uniaxialMaterial("Steel01", tag, q_y, k, 0.03)
        ops.uniaxialMaterial("Viscous", 100 + tag, c, 1.0)
        ops.element("zeroLength", tag, tag - 1, tag, "-mat", tag, 100 + tag, "-dir", 1, 1)
    ops.timeSeries("Path", 1, "-dt", DT, "-values", *SHAKING.tolist())
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-13, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    rows = []
    for _ in range(YIELDING):
        assert ops.analyze(1, DT) == 0
        rows.append([ops.nodeDisp(tag, 1) for tag in range(1, STORIES + 1)])
    return np.array(rows)


def test_a_building_that_yields(child: Executor) -> None:
    """The same rule of the same steel in the same steps, to rounding; a tenth of the drifts are beyond yield."""
    found = child.submit(steel_in_opensees).result()
    if isinstance(found, str):
        pytest.skip(found)
    m, k, q_y, c = yielding_building()
    B = np.eye(STORIES) - np.eye(STORIES, k=-1)
    steel = ss.law("bilinear", k=k, q_y=q_y, alpha=0.03)
    s = ss.shear_building(m, steel, damping=B.T @ np.diag(c) @ B).ground_motion(ss.Record(DT, SHAKING), 1.0)
    r = ss.march(s, "average_acceleration", dt=DT, t_end=YIELDING * DT)
    assert np.mean(np.abs(r.springs.elongations) > q_y / k) > 0.1
    assert np.abs(r.u[1:] - found).max() < 1e-11 * np.abs(found).max()
