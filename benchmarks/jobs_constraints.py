"""Constraints and contacts: rods beside Exudyn and beside elastic ones, a bouncing ball beside Siconos."""

from typing import Any

import numpy as np

import substep as ss

from . import ours, peers
from .job import Goal, Job, Table
from .peers_constrained import ExudynRods, Place, siconos_ball
from .timing import Alternative, Measured, cores, measure

NAME = "constraints"
G, RHO, STEPS = 9.81, 0.8, 20_000
ORIGIN = (0.0, 0.0)
# parameters, step, points, rods between points or from pivots, and the velocity of the start; four_bar ends before its
# bars are in line, where rounding decides how it goes on
MECHANISMS: dict[str, tuple[dict[str, float], float, list[Place], list[tuple[int | Place, int]], Place]] = {
    "rod_pendulum": ({"L": 1.0, "m": 1.0, "v0": 0.0}, 2e-4, [(1.0, 0.0)], [(ORIGIN, 0)], ORIGIN),
    "rod_double_pendulum": ({}, 2e-4, [(1.0, 0.0), (2.0, 0.0)], [(ORIGIN, 0), (0, 1)], ORIGIN),
    "four_bar": (
        {"L": 1.0, "m": 1.0, "v0": 1.0}, 3e-5, [(0.0, 1.0), (1.0, 1.0)], [(ORIGIN, 0), (0, 1), ((1.0, 0.0), 1)],
        (1.0, 0.0),
    ),
}  # fmt: skip
LANES, LANE_STEPS, LANE_DT = 480, 400, 0.01
BALL = (1.0, 10.0, 0.5, 0.00007, 20_000)  # height, g, restitution, step, steps
ANDREWS = (0.03, 6000, "bdf3")  # end, steps, scheme
ANDREWS_AT_END = np.array([  # the seven angles at the end, computed in 80 bits
    15.810771195153712, -15.756371058411845, 0.040822240119645341, -0.53473011634208029, 0.52440996587995393,
    0.53473011634208024, 1.0480807410419376,
])  # fmt: skip


def job(quick: bool) -> Job:
    """Single runs beside the peers, lanes beside elastic pendulums, and Andrews' squeezing mechanism."""
    rounds = 5 if quick else 11
    found = Job(NAME, "Constraints and contacts, one core")
    with cores(1):
        for name in MECHANISMS:
            found.tables.append(_rods(found, name, rounds))
        for scheme in ("generalized_alpha", "newmark_bdf2"):
            found.tables.append(_lanes(found, scheme, rounds))
        found.tables.append(_ball(found, rounds))
        _squeezer(found, rounds)
    found.notes.append(
        "Exudyn takes its steps in one call and keeps no history, substep returns histories of u, v, a, multipliers. "
        "Siconos is stepped from Python, as its examples do, in a process of its own."
    )
    return found


def _rods(found: Job, name: str, rounds: int) -> Table:
    """Generalized alpha with positions as constraints, in both programs."""
    given, dt, points, rods, velocity = MECHANISMS[name]
    scene, scheme = ss.scene(name, g=G, **given), ss.scheme("generalized_alpha", rho_inf=RHO)

    def march() -> Any:
        return ss.march(scene, scheme, dt, STEPS * dt)

    u = march().u[-1].reshape(-1, 2)
    rows = [Alternative("substep", "substep", march, STEPS)]
    try:
        program = ExudynRods(points, rods, velocity, G, RHO, dt, STEPS)
        rows.append(Alternative("exudyn", "peer", program.run, STEPS, lambda x: {"u": float(np.abs(x - u).max())}))
    except peers.MissingPeerError as error:
        found.skipped[f"exudyn, {name}"] = str(error)
    of = {"u": "last positions against substep's, m"}
    table = Table(f"{name}, {STEPS} steps", "step", measure(rows, rounds), of)
    found.compare(table, f"{name}: exudyn / substep", "exudyn", "substep", ">=", 30)
    return table


def _lanes(found: Job, scheme: str, rounds: int) -> Table:
    """Pendulums from as many velocities: the rod as a constraint, and as an elastic bar."""
    v0 = np.linspace(7.0, 8.0, LANES)
    rod, bar = "the rod is a constraint", "the rod is elastic"
    rows = [
        Alternative(
            label, "substep", ours.pendulums(ss.scheme(scheme), scene, v0, LANE_DT, LANE_STEPS), LANES * LANE_STEPS
        )
        for label, scene in ((rod, ss.scene("rod_pendulum", g=0.0)), (bar, ss.scene("elastic_pendulum", EA=1e4)))
    ]
    table = Table(f"{scheme}, {LANES} pendulums x {LANE_STEPS} steps", "lane-step", measure(rows, rounds))
    found.compare(table, f"pendulums, {scheme}: constrained / elastic", rod, bar, "<=", 2.0)
    return table


def _ball(found: Job, rounds: int) -> Table:
    """Moreau and Jean's scheme in both programs."""
    u0, g, restitution, dt, n = BALL
    scene = ss.scene("bouncing_ball", u0=u0, g=g, restitution=restitution)

    def march() -> Any:
        return ss.march(scene, "average_acceleration", dt, n * dt)

    last = march()
    rows = measure([Alternative("substep", "substep", march, n)], rounds)
    try:
        seconds, end = siconos_ball(BALL, rounds)
        errors = {"u": float(abs(end[0] - last.u[-1, 0])), "v": float(abs(end[1] - last.v[-1, 0]))}
        rows.append(Measured("siconos", "peer", seconds / n, errors))
    except peers.MissingPeerError as error:
        found.skipped["siconos"] = str(error)
    of = {"u": "last u against substep's, m", "v": "last v against substep's, m/s"}
    table = Table(f"bouncing_ball, {n} steps", "step", rows, of)
    found.compare(table, "bouncing_ball: siconos / substep", "siconos", "substep", ">=", 30)
    return table


def _squeezer(found: Job, rounds: int) -> None:
    """Time and error of one run."""
    t_end, n, scheme = ANDREWS
    size = np.abs(ANDREWS_AT_END).max()
    rows = measure(
        [
            Alternative(
                "substep", "substep", lambda: ss.march("squeezer", scheme, t_end / n, t_end), 1,
                lambda r: {"u": float(np.abs(r.u[-1] - ANDREWS_AT_END).max() / size)},
            )
        ],
        rounds,
    )  # fmt: skip
    table = Table(f"squeezer, {scheme}, {n} steps", "run", rows, {"u": "last angles, of the largest"})
    found.tables.append(table)
    found.goals.append(Goal("squeezer: a run", "<=", 0.05, rows[0].seconds, unit="s"))
    found.below("squeezer: its error", 1e-6, [rows[0].errors["u"]])
