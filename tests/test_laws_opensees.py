"""Oscillators with laws beside OpenSees' own materials: the same scheme, step and load; histories, not peaks.

RECORDED, WITH_BOUC_WEN and CHAIN are what the models below found with openseespy 3.7.1.2 (OpenSees 3.7.1), to all
digits, so that the comparison does not need it; `python tests/test_laws_opensees.py` prints them. Where it is
installed, its answers are held against the numbers recorded. OpenSees runs in a process of its own, as it crashes where
MKL was loaded before it.
"""

from concurrent.futures import Executor
from itertools import pairwise
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest
from plain_kernels import text_of, uncompiled
from substep_derive.declare.laws.plastic import bilinear
from substep_derive.declare.scene import Scene
from substep_derive.declare.symbols import rate, sampled
from sympy import Integer, Rational, Symbol

import substep as ss
from substep.derived.modules import uncommitted_pair
from substep.marching import scene_lanes

OMEGA, XI = 4 * np.pi, 0.05
DT, STEPS = 0.01, 1000
STRENGTH, HARDENING = 3.0, 0.05  # m/s^2; of the initial stiffness
LOOKED_AT = (120, 333, 500, 777, 1000)  # steps of which rows are recorded
V0 = 0.1  # m/s, where there is a damper of a power below 1
AGREE = 1e-11  # of the largest value, where the algorithm is the same


class Case(NamedTuple):
    """A law beside materials of OpenSees, each its name and arguments; all act in parallel, with linear damping."""

    law: str
    parameters: dict[str, float]
    materials: tuple[tuple[Any, ...], ...]
    v0: float = 0.0


def bouc_wen(n: float) -> Case:
    """In OpenSees gamma comes before beta, and both are of z in m, not of z over the yield displacement."""
    shape = 0.5 / (STRENGTH / OMEGA**2) ** n
    degrading = 0.0, 0.0, 0.0
    material = "BoucWen", HARDENING, OMEGA**2, n, shape, shape, 1.0, *degrading, 1e-14, 100
    return Case("bouc_wen", {"strength": STRENGTH, "hardening": HARDENING, "n": n}, (material,))


LINEAR = "Elastic", OMEGA**2
GAP = {"stiffness": 400.0, "strength": 5.0, "gap": 0.01}
CASES = {
    "Steel01": Case(
        "bilinear", {"strength": STRENGTH, "hardening": HARDENING}, (("Steel01", STRENGTH, OMEGA**2, HARDENING),)
    ),
    "Steel01 without hardening": Case("bilinear", {"strength": STRENGTH}, (("Steel01", STRENGTH, OMEGA**2, 0.0),)),
    # with "damage" the gap grows by what has yielded, as that of slip; without, OpenSees closes it again
    "ElasticPPGap": Case("slip", GAP, (LINEAR, ("ElasticPPGap", *GAP.values(), 0.0, "damage"))),
    "Viscous 0.5": Case("power_damper", {"c": 0.6, "exponent": 0.5}, (LINEAR, ("Viscous", 0.6, 0.5)), V0),
    "Viscous 1.5": Case("power_damper", {"c": 0.6, "exponent": 1.5}, (LINEAR, ("Viscous", 0.6, 1.5))),
}


def samples(case: Case, dt: float = DT) -> Any:
    """The load per unit mass, m/s^2, linear between its instants DT apart, at instants dt apart.

    At the start it is what the dampers take at the velocity V0: the acceleration there, that OpenSees sets to 0, is 0.
    """
    t = DT * np.arange(STEPS + 1)
    waves = ((4.0, 3.0), (3.0, 7.1), (3.0, 11.3), (2.0, 17.9))
    values = np.sin(np.pi * t / t[-1]) ** 2 * sum(size * np.sin(rate * t) for size, rate in waves)
    if case.v0:
        values[0] = 2 * XI * OMEGA * case.v0 + case.parameters["c"] * case.v0 ** case.parameters["exponent"]
    return np.interp(dt * np.arange(round(t[-1] / dt) + 1), t, values)


def start_of(ops: Any, load: Any, dt: float, masses: tuple[float, ...]) -> None:
    """A fixed node, one for each mass, and the load, times each mass, on these."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.fix(1, 1)
    ops.timeSeries("Path", 1, "-dt", dt, "-values", *load.tolist())
    ops.pattern("Plain", 1, 1)
    for node, mass in enumerate(masses, 2):
        ops.node(node, 0.0)
        ops.mass(node, mass)
        ops.load(node, mass)


def analysis_of(ops: Any) -> None:
    """Average acceleration, each step to the last digits."""
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-14, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def opensees(case: Case, parts: int = 1) -> Any:
    """u, v, a (n + 1, 3) by OpenSees with `parts` steps in DT; or why it cannot be imported."""
    try:
        import openseespy.opensees as ops  # pyright: ignore[reportMissingImports]
    except (ImportError, RuntimeError) as error:  # besides the wheel it needs BLAS and LAPACK of the system
        return f"openseespy cannot be imported: {error}"
    dt, n = DT / parts, STEPS * parts
    start_of(ops, samples(case, dt), dt, (1.0,))
    materials = ("Elastic", 0.0, 2 * XI * OMEGA), *case.materials
    for tag, (name, *arguments) in enumerate(materials, 1):
        ops.uniaxialMaterial(name, tag, *arguments)
    tags = range(1, len(materials) + 1)
    ops.element("zeroLength", 1, 1, 2, "-mat", *tags, "-dir", *[1] * len(tags))
    analysis_of(ops)
    if case.v0:
        ops.setNodeVel(2, 1, case.v0, "-commit")
    rows = [[0.0, case.v0, 0.0]]
    for _ in range(n):
        assert ops.analyze(1, dt) == 0
        rows.append([ops.nodeDisp(2, 1), ops.nodeVel(2, 1), ops.nodeAccel(2, 1)])
    return np.array(rows)


def substep(case: Case, parts: int = 1) -> Any:
    """u, v, a (n + 1, 3) by average acceleration."""
    scene = ss.scene(
        "hysteretic_oscillator", law=case.law, omega=OMEGA, xi=XI, v0=case.v0, load=ss.Record(DT, samples(case)),
        **case.parameters,
    )  # fmt: skip
    r = ss.march(scene, "average_acceleration", dt=DT / parts, t_end=STEPS * DT)
    assert r.status == "completed"
    return np.column_stack([r.u, r.v, r.a])


def apart(ours: Any, theirs: Any, largest: Any) -> float:
    """The largest difference of u, v and a, relative to the largest value (3,) of each."""
    return float((np.abs(ours - theirs) / largest).max())


# u, v, a of OpenSees at the steps LOOKED_AT
RECORDED = {
    "Steel01": [
        [0.001410684883985333, 0.07299573185374734, 0.2385678620282582],
        [0.07778648491715032, -0.5900793638674001, -0.9002634950910348],
        [0.3957646314613141, 0.20193011079810627, -4.201688108232985],
        [-0.028223911318479337, -0.5918436688846704, 1.4051965684314491],
        [-0.07775253976766007, 0.09353820217173191, 0.7307685833264345],
    ],
    "Steel01 without hardening": [
        [0.001410684883985333, 0.07299573185374734, 0.2385678620282582],
        [0.1197516814088085, -0.4638836094217309, -0.2946682900164665],
        [0.45464244973413825, 0.6695232529657585, -1.8144507015812563],
        [0.13493108309508645, -0.5354521181421104, 1.2614857843246492],
        [0.0818560604667267, 0.08885163636938136, 0.6233774195846816],
    ],
    "ElasticPPGap": [
        [0.0014106848839853326, 0.07299573185374734, 0.2385678620282583],
        [-0.039204322378184706, 0.20325128248677646, 2.0578837228015834],
        [-0.037070256721138034, 0.18863602978531863, 7.643750307589591],
        [-0.042044560890797604, 0.5290431516489025, 3.5632125079370045],
        [0.00987231575148542, 0.02054020904115722, -1.5847852037676282],
    ],
    "Viscous 0.5": [
        [0.002258179246776151, 0.04787207371506675, 0.005030109825161233],
        [-0.06951517842325237, 0.3569653143204944, 6.292740059176034],
        [-0.07108761171518657, 0.5019296466448298, 12.19677736244765],
        [-0.05138392211607547, 0.4112116179318347, 4.801342086382724],
        [0.0007633308810151924, 0.022904770577829116, -0.24012929742559078],
    ],
    "Viscous 1.5": [
        [0.0014231366747392454, 0.07215356041188321, 0.22603097760741028],
        [-0.07051292946473971, 0.4477991465691326, 6.5148384816740235],
        [-0.06917407410685716, 0.5479302043073134, 12.018525220499189],
        [-0.05007547683541769, 0.4868626298740402, 4.680582904443015],
        [0.007914819674728606, 0.04463634308558388, -1.311608184969387],
    ],
}

# u of OpenSees at the same instants, by n of the law and the number of steps in DT
WITH_BOUC_WEN = {
    (1.0, 1): [
        0.0013067028994385981,
        0.0673535716589587,
        0.4043835066619439,
        -0.010409403941128492,
        -0.056771280665966914,
    ],
    (1.0, 2): [
        0.0013291215515692126,
        0.0672611607019852,
        0.4035546532728828,
        -0.011864013963375043,
        -0.056905542614385456,
    ],
    (1.0, 4): [
        0.0013374400618701256,
        0.06718104816493284,
        0.4031952229806647,
        -0.012554657308003045,
        -0.056986237333613805,
    ],
    (1.0, 8): [
        0.0013408904557288405,
        0.06713547243438273,
        0.40298683512418243,
        -0.012889571697844444,
        -0.0570282624696723,
    ],
    (2.0, 1): [
        0.0013974542135333295,
        0.07268070637584015,
        0.401048059354704,
        -0.020494197461696055,
        -0.06674062086314256,
    ],
    (2.0, 2): [
        0.0014119444277531346,
        0.07258883738512599,
        0.4003839946163563,
        -0.021547623019146613,
        -0.0668242377745591,
    ],
    (2.0, 4): [
        0.001415974842813658,
        0.07253071866060648,
        0.4000072854395614,
        -0.0220132471615178,
        -0.06686000651391144,
    ],
    (2.0, 8): [
        0.0014171619565114188,
        0.07249491565176758,
        0.3998169808744163,
        -0.022254868107349782,
        -0.0668940663704849,
    ],
}


@pytest.fixture(autouse=True)
def plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels as plain Python functions, which take less time than compiling them."""
    monkeypatch.setattr(scene_lanes, "pair_kernels", plain)


def plain(scene: ss.Scene, scheme: ss.Scheme) -> ModuleType:
    return uncompiled(text_of(uncommitted_pair(scheme.info.source, scene.info.source)))


@pytest.mark.parametrize("name", CASES)
def test_histories_are_those_recorded_of_opensees(name: str) -> None:
    """Yielding, a gap that grows, dampers of a power: to OpenSees' own rounding."""
    found, recorded = substep(CASES[name]), np.array(RECORDED[name])
    assert apart(found[list(LOOKED_AT)], recorded, np.abs(found).max(axis=0)) <= AGREE


@pytest.mark.parametrize("name", CASES)
def test_what_was_recorded_is_not_the_motion_without_the_law(name: str) -> None:
    """Else the comparison would not try the law."""
    case = CASES[name]
    linear = ss.scene(
        "linear_oscillator", omega=OMEGA, xi=XI, u0=0.0, v0=case.v0, load=ss.Record(DT, samples(case))
    )  # fmt: skip
    r = ss.march(linear, "average_acceleration", dt=DT, t_end=STEPS * DT)
    found, recorded = np.column_stack([r.u, r.v, r.a])[list(LOOKED_AT)], np.array(RECORDED[name])
    assert apart(found, recorded, np.abs(recorded).max(axis=0)) > 0.2


@pytest.mark.parametrize("n", [1.0, 2.0])
def test_bouc_wen_differs_by_the_error_of_opensees_which_halves_with_the_step(n: float) -> None:
    """OpenSees takes backward Euler along the path, of first order; here the path is integrated exactly.

    So what differs halves with the step, and two steps of OpenSees extrapolated are nearer than either.
    """
    found, recorded = {}, {}
    for parts in (1, 2, 4):
        found[parts] = substep(bouc_wen(n), parts)[[parts * step for step in LOOKED_AT], 0]
        recorded[parts] = np.array(WITH_BOUC_WEN[n, parts])
    differ = [np.abs(found[parts] - recorded[parts]).max() for parts in (1, 2, 4)]
    assert differ[0] < 3e-3  # of 0.4 m
    assert 1.8 < differ[0] / differ[1] < 2.2
    assert 1.8 < differ[1] / differ[2] < 2.2
    extrapolated = 2 * np.array(WITH_BOUC_WEN[n, 8]) - np.array(WITH_BOUC_WEN[n, 4])
    assert np.abs(found[4] - extrapolated).max() < differ[2] / 10


# -- a chain of three masses, each on the one below by a yielding spring and a damper; the ground shakes

MASSES, STIFFNESSES, STRENGTHS, DAMPERS = (3.0, 2.5, 2.0), (900.0, 800.0, 600.0), (6.0, 5.0, 3.0), (1.5, 1.25, 1.0)
# u of OpenSees at the steps LOOKED_AT
CHAIN = [
    [0.0010563143317817482, 0.00011981373338318654, -0.0015559448180618805],
    [0.26293008257250766, 0.43062041364646214, 0.4632839922578651],
    [0.22303889548607192, 0.14238818264958986, 0.006148757155111831],
    [0.1639303274661615, 0.3501506923151012, 0.5074666337746507],
    [0.03854195360592611, 0.07736383318614211, 0.09506169695977844],
]


def chain() -> Scene:
    u = [Symbol(f"u_{i}") for i in (1, 2, 3)]
    drifts = {f"story_{i + 1}": x - below for i, (below, x) in enumerate(pairwise([Integer(0), *u]))}
    rates = [x - below for below, x in pairwise([Integer(0), *map(rate, u)])]
    springs = zip(drifts.items(), STIFFNESSES, STRENGTHS, strict=True)
    dissipation = sum((Rational(c) * d**2 / 2 for c, d in zip(DAMPERS, rates, strict=True)), Integer(0))
    return Scene(
        "steel_chain",
        coordinates=dict.fromkeys(u, "m"),
        kinetic=sum((Rational(m) * rate(x) ** 2 / 2 for m, x in zip(MASSES, u, strict=True)), Integer(0)),
        potential=Integer(0),
        dissipation=dissipation,
        laws={
            name: bilinear.on(drift, k=Rational(k), q_y=Rational(q_y), alpha=Rational(1, 20))
            for (name, drift), k, q_y in springs
        },
        load={x: Rational(m) * sampled for x, m in zip(u, MASSES, strict=True)},
        start={**dict.fromkeys(u, 0), **{rate(x): 0 for x in u}},
        parameters=(),
        length=Rational(1, 100),
        energy_scale=1,
        reference="Steel01 in OpenSees",
    )


def chain_in_opensees() -> Any:
    """u (n + 1, 3) by OpenSees; or why it cannot be imported."""
    try:
        import openseespy.opensees as ops  # pyright: ignore[reportMissingImports]
    except (ImportError, RuntimeError) as error:
        return f"openseespy cannot be imported: {error}"
    start_of(ops, samples(CASES["Steel01"]), DT, MASSES)
    for i, (k, q_y, c) in enumerate(zip(STIFFNESSES, STRENGTHS, DAMPERS, strict=True), 1):
        ops.uniaxialMaterial("Steel01", 2 * i, q_y, k, HARDENING)
        ops.uniaxialMaterial("Elastic", 2 * i + 1, 0.0, c)
        ops.element("zeroLength", i, i, i + 1, "-mat", 2 * i, 2 * i + 1, "-dir", 1, 1)
    analysis_of(ops)
    rows = [[0.0, 0.0, 0.0]]
    for _ in range(STEPS):
        assert ops.analyze(1, DT) == 0
        rows.append([ops.nodeDisp(node, 1) for node in (2, 3, 4)])
    return np.array(rows)


def test_a_chain_of_yielding_springs_is_that_of_opensees() -> None:
    scene = ss.scene(chain(), load=ss.Record(DT, samples(CASES["Steel01"])))
    r = ss.march(scene, "average_acceleration", dt=DT, t_end=STEPS * DT)
    assert all(np.ptp(p) > 0.1 for p in r.memory.values())  # m: all of them yield
    assert apart(r.u[list(LOOKED_AT)], np.array(CHAIN), np.abs(r.u).max(axis=0)) <= AGREE


# u of OpenSees 3.7.1 after 1, 2, 20 steps from rest under a load of 1 m/s^2 that begins with the first step: the model
# of `opensees` with the materials Elastic and Viscous, undamped otherwise
FROM_REST = {
    0.1: [1.6465608243571296e-05, 8.111284811450207e-05, 0.006470116636694527],
    0.3: [2.1969222494798047e-05, 0.00010838311374749532, 0.008619987633381615],
    0.5: [2.386936912367808e-05, 0.00011822968742057167, 0.009732796209765136],
}


@pytest.mark.parametrize("exponent", FROM_REST)
def test_a_damper_of_a_power_below_1_lets_go_from_rest(exponent: float) -> None:
    """The displacements of OpenSees, and the balance of forces at every step."""
    c, n, load = 0.6, 20, ss.Record(DT, [0.0] + 20 * [1.0])
    scene = ss.scene("hysteretic_oscillator", law="power_damper", omega=OMEGA, c=c, exponent=exponent, load=load)
    r = ss.march(scene, "average_acceleration", dt=DT, t_end=n * DT)
    u, v, a = (x[1:, 0] for x in (r.u, r.v, r.a))
    assert np.abs(a + OMEGA**2 * u + c * np.sign(v) * np.abs(v) ** exponent - 1.0).max() < 1e-9
    assert u[[0, 1, 19]] == pytest.approx(FROM_REST[exponent], rel=1e-10)


@pytest.mark.parametrize("name", CASES)
def test_whole_histories_are_those_of_opensees(child: Executor, name: str) -> None:
    """Where it is installed: every step, and the rows recorded of it once more."""
    theirs = child.submit(opensees, CASES[name]).result()
    if isinstance(theirs, str):
        pytest.skip(theirs)
    largest = np.abs(theirs).max(axis=0)
    assert apart(substep(CASES[name]), theirs, largest) <= AGREE
    assert apart(theirs[list(LOOKED_AT)], np.array(RECORDED[name]), largest) <= AGREE


def test_the_whole_chain_of_opensees(child: Executor) -> None:
    theirs = child.submit(chain_in_opensees).result()
    if isinstance(theirs, str):
        pytest.skip(theirs)
    scene = ss.scene(chain(), load=ss.Record(DT, samples(CASES["Steel01"])))
    r = ss.march(scene, "average_acceleration", dt=DT, t_end=STEPS * DT)
    assert apart(r.u, theirs, np.abs(theirs).max(axis=0)) <= AGREE
    assert apart(theirs[list(LOOKED_AT)], np.array(CHAIN), np.abs(theirs).max(axis=0)) <= AGREE


@pytest.mark.parametrize("n", [1.0, 2.0])
def test_bouc_wen_of_opensees_is_what_was_recorded(child: Executor, n: float) -> None:
    theirs = child.submit(opensees, bouc_wen(n)).result()
    if isinstance(theirs, str):
        pytest.skip(theirs)
    recorded = np.array(WITH_BOUC_WEN[n, 1])
    assert apart(theirs[list(LOOKED_AT), 0], recorded, np.abs(theirs[:, 0]).max()) <= AGREE


if __name__ == "__main__":
    for name, case in CASES.items():
        print(f'    "{name}": {opensees(case)[list(LOOKED_AT)].tolist()},')
    for n in (1.0, 2.0):
        for parts in (1, 2, 4, 8):
            rows = opensees(bouc_wen(n), parts)[[parts * step for step in LOOKED_AT]]
            print(f"    ({n}, {parts}): {rows[:, 0].tolist()},")
    print(f"CHAIN = {chain_in_opensees()[list(LOOKED_AT)].tolist()}")
