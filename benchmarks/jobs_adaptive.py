"""Steps that the march chooses: one run of the elastic pendulum against dop853, and what choosing adds to a step."""

from collections.abc import Callable, Iterator

import numpy as np

import substep as ss
from substep.exact.pendulum import ElasticPendulum
from substep.marching.adaptive import adaptive_kernels, lanes_of
from substep.marching.scene_lanes import march_lanes
from substep.run.clock import Control

from . import peers
from .job import Goal, Job, Table
from .linear import scheme
from .peers_march import NumbaLsoda
from .timing import Alternative, cores, measure

NAME = "adaptive"
STIFFNESSES, ACCURACIES, T_END, SAMPLES = (1e4, 1e6, 1e8), (1e-6, 1e-8), 10.0, 10
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(4, 27))
LEAST_ORDER = 3  # of an estimate: schemes of lower order are no rivals of dop853 at these accuracies
STEP = {"average_acceleration": True, "bathe": True, "newmark_bdf2": True, "noh_bathe": False}  # whether implicit
H, MADE = 0.005, 40_000  # the constant step, s, and so many that the set-up of a call hardly counts


def job(quick: bool) -> Job:
    """The fastest scheme that chooses its steps against dop853, at each stiffness and accuracy; then single steps."""
    rounds = 5 if quick else 15
    found = Job(NAME, f"Chosen steps: one elastic pendulum over {T_END:g} s, one core")
    with cores(1):
        for EA in STIFFNESSES:
            for accuracy in ACCURACIES:
                _against_dop853(found, EA, accuracy, rounds)
        _overhead(found, rounds)
    found.notes.append(
        f"Errors are the largest of the angle at {SAMPLES} times: equal intervals (dop853), ends of steps (substep)."
    )
    return found


def candidates() -> Iterator[ss.Scheme]:
    """Schemes of the catalogue whose local error is estimated to a high order."""
    for name in ss.schemes():
        s = scheme(name)
        try:
            order = s.local_error(damped=False).order
        except ValueError:  # no estimate, or a step that cannot change
            continue
        if order >= LEAST_ORDER:
            yield s


def _tolerance(error: Callable[[float], float], accuracy: float) -> float | None:
    """The coarsest tolerance whose error, and that of the next finer, is within the accuracy; None if there is none."""
    before: float | None = None
    for tol in TOLERANCES:
        good = error(tol) <= accuracy
        if good and before is not None:
            return before
        before = tol if good else None
    return None


def _against_dop853(found: Job, EA: float, accuracy: float, rounds: int) -> None:
    pendulum = ss.scene("elastic_pendulum", EA=EA)
    L, m, v0 = (pendulum.parameters[key] for key in ("L", "m", "v0"))
    model, rows = ElasticPendulum(EA, L, m, v0), []
    t = np.linspace(0.0, T_END, SAMPLES + 1)

    def angle_error(times: np.ndarray, u: np.ndarray) -> float:
        exact = np.array([model.position(float(x)) for x in times])
        turn = np.arctan2(u[:, 1], u[:, 0]) - np.arctan2(exact[:, 1], exact[:, 0])
        return float(np.abs((turn + np.pi) % (2 * np.pi) - np.pi).max())

    def of_run(r: ss.Response) -> float:
        if r.status != "completed":
            return np.inf
        some = np.unique(np.linspace(0, len(r.t) - 1, SAMPLES + 1).round().astype(int))
        return angle_error(r.t[some], r.u[some])

    for s in candidates():

        def run(tol: float, s: ss.Scheme = s) -> ss.Response:
            return ss.march(pendulum, s, tol=tol, t_end=T_END)

        tol = _tolerance(lambda tol, run=run: of_run(run(tol)), accuracy)
        if tol is not None:
            rows.append(
                Alternative(f"substep {s.name}, tol {tol:.1e}", "substep", lambda tol=tol, run=run: run(tol), 1,
                            lambda r: {"angle": of_run(r)})
            )  # fmt: skip
    try:
        solver, start = NumbaLsoda(EA / (2 * L**3 * m), L), np.array([L, 0.0, 0.0, v0])
        tol = _tolerance(lambda tol: angle_error(t, solver.history("dop853", tol, start, t)), accuracy)
        if tol is not None:
            rows.append(
                Alternative(f"numbalsoda dop853, rtol {tol:.1e}", "peer",
                            lambda tol=tol: solver.history("dop853", tol, start, t), 1,
                            lambda u: {"angle": angle_error(t, u)})
            )  # fmt: skip
    except peers.MissingPeerError as error:
        found.skipped["numbalsoda"] = str(error)
    text = f"EA = {EA:g} N, angle within {accuracy:g} rad"
    table = Table(text, "run", measure(rows, rounds) if rows else [], {"angle": "largest error of the angle, rad"})
    found.tables.append(table)
    ours, theirs = ([row for row in table.rows if row.kind == kind] for kind in ("substep", "peer"))
    if not ours or not theirs:
        why = "no scheme of high order reaches it" if not ours else "numbalsoda was left out, or does not reach it"
        found.goals.append(Goal(f"{text}: substep / dop853", "<=", 1.0, None, why=why))
        return
    best = min(ours, key=lambda row: float(np.median(row.samples)))
    found.compare(table, f"{text}: {best.name} / dop853", best.name, theirs[0].name, "<=", 1.0)


def _overhead(found: Job, rounds: int) -> None:
    """A step of chosen length against a constant one of the same scheme, on the flexible pendulum; kernels alone."""
    pendulum, n = ss.scene("elastic_pendulum", EA=1e4), MADE
    for name, implicit in STEP.items():
        s = scheme(name)
        module = adaptive_kernels(pendulum, s)
        asked = Control.of(pendulum.length, 1e-6, T_END)
        arguments = lanes_of(pendulum, s, asked, rows=50_000)

        def chosen(module: object = module, arguments: dict[str, np.ndarray] = arguments) -> np.ndarray:
            arguments["counts"][:] = 0
            module.march(*arguments.values())
            return arguments["counts"]

        steps = chosen()[0]
        tried = int(steps[module.ACCEPTED] + steps[module.REJECTED])
        rows = [
            Alternative(
                "constant steps", "substep",
                lambda s=s: march_lanes(pendulum, s, np.array([H]), np.array([n]), history=True, counts=True), n,
            ),
            Alternative("chosen steps", "substep", chosen, tried),
        ]  # fmt: skip
        table = Table(f"{name}, flexible pendulum, tol 1e-6", "step", measure(rows, rounds), {})
        found.tables.append(table)
        if implicit:
            found.compare(table, f"{name}: chosen / constant step", "chosen steps", "constant steps", "<=", 1.25)
