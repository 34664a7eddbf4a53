"""Elastic pendulum: a batch with Newton in every sub-step, and one run against ODE solvers."""

import numpy as np

import substep as ss

from . import limits, ours, peers
from .job import BESIDE_C, Job, Table
from .linear import scheme
from .peers_march import NumbaLsoda, scipy_pendulum
from .timing import Alternative, cores, measure

NAME = "pendulum"
LANES, H = 480, 0.01
CASES = {"flexible": (1e4, (0.0, 0.0)), "stiff": (1e10, (-19.6, 0.0))}
# parameters of our kernels in C: newmark_bdf2, which includes bathe, and generalized_alpha, which includes newmark
PARAMETERS = {
    "newmark_bdf2": ("gamma_t", "beta", "gamma"),
    "bathe": (0.5, 0.25, 0.5),
    "newmark": (0.0, 0.0, "beta", "gamma"),
    "generalized_alpha": ("alpha_m", "alpha_f", "beta", "gamma"),
}
V0 = np.linspace(7.0, 8.0, LANES)
LONGER = 20  # times the steps of the batch that a single lane takes


def job(quick: bool) -> Job:
    """480 lanes from 480 start velocities; then one lane of the flexible pendulum."""
    n, rounds = (400, 5) if quick else (4000, 11)  # so many that the set-up of a call, 50 us, hardly counts
    found = Job(NAME, f"Elastic pendulum, {LANES} lanes x {n} steps of {H} s, one core")
    with cores(1):
        for name in PARAMETERS:
            for case, (EA, a0) in CASES.items():
                table = _batch(found, name, case, EA, a0, n, rounds)
                found.tables.append(table)
                text = f"pendulum, {name}, {case}: "
                found.compare(table, text + "substep / C", "substep", "C, vectors", "<=", BESIDE_C)
        _one_run(found, rounds)
    found.notes.append(
        "All start Newton from the last converged position and stop at a correction of 1e-12 of the length. In the "
        "stiff case EA amplifies the round-off of the strain."
    )
    return found


def _batch(found: Job, name: str, case: str, EA: float, a0: tuple[float, float], n: int, rounds: int) -> Table:
    scene, own_parameters = ss.scene("elastic_pendulum", EA=EA, a0=a0), scheme(name).parameters
    parameters = tuple(float(own_parameters[p]) if isinstance(p, str) else p for p in PARAMETERS[name])
    L, m = scene.parameters["L"], scene.parameters["m"]
    start = np.zeros((6, LANES))
    start[0], start[3], start[4], start[5] = L, V0, *a0
    stiffness, peak = np.full(LANES, EA / (2 * L**3 * m)), np.empty(LANES)
    made = ours.pendulum_steps(name, EA, a0, V0, H, n)
    if made < n:
        found.skipped[f"{name}, {case}: {n} steps"] = f"a lane stops after {made}"
    long = LONGER * n  # steps of the single lane, whose call should not weigh more than its march
    if ours.pendulum_steps(name, EA, a0, V0[:1], H, long) < long:
        found.skipped[f"{name}, {case}: substep, one lane"] = f"it stops before {long} steps"
        long = 0
    n = made

    def by_c(vectors: bool, lanes: int = LANES, steps: int = n) -> np.ndarray:
        state = np.ascontiguousarray(start[:, :lanes]).copy()
        done = limits.pendulum(
            state, stiffness, peak, n=steps, h=H, parameters=parameters, length=L, tolerance=1e-12 * L,
            vectors=vectors,
        )  # fmt: skip
        return state[:2].T if done == steps else np.full((lanes, 2), np.nan)

    try:
        C, C_long = by_c(True), by_c(False, 1, long)
    except limits.MissingCompilerError as error:
        found.skipped["C, vectors"] = found.skipped["C, scalar"] = str(error)
        C = C_long = None
    own = ours.pendulum_batch(name, EA, a0, V0, H, n)[0]

    def against(other: np.ndarray | None):
        return lambda u: {} if other is None else {"C": float(np.abs(u - other).max() / L)}

    rows = [
        Alternative(
            "substep", "substep", lambda: ours.pendulum_batch(name, EA, a0, V0, H, n)[0], LANES * n, against(C)
        ),
    ]  # fmt: skip
    if long:
        rows.append(
            Alternative(
                "substep, one lane", "substep", lambda: ours.pendulum_batch(name, EA, a0, V0[:1], H, long)[0], long,
                against(C_long),
            )
        )  # fmt: skip
    if C is not None:
        rows += [
            Alternative("C, vectors", "limit", lambda: by_c(True), LANES * n, against(own)),
            Alternative("C, scalar", "limit", lambda: by_c(False), LANES * n, against(own)),
        ]
    errors = {"C": "distance of the last positions of substep and C, over the length"}
    return Table(f"{name}, {case}: Newton in every sub-step", "lane-step", measure(rows, rounds), errors)


def _one_run(found: Job, rounds: int) -> None:
    """3 s of the flexible pendulum by substep and by ODE solvers, at several accuracies: time and error."""
    EA, t_end = CASES["flexible"][0], 3.0
    scene = ss.scene("elastic_pendulum", EA=EA)
    L, m, v0 = (scene.parameters[key] for key in ("L", "m", "v0"))
    from substep.exact.pendulum import ElasticPendulum  # noqa: PLC0415

    exact = ElasticPendulum(EA, L, m, v0).position(t_end)
    stiffness, start = EA / (2 * L**3 * m), np.array([L, 0.0, 0.0, v0])

    def errors(u: np.ndarray) -> dict[str, float]:
        return {"exact": float(np.abs(np.reshape(u, -1)[:2] - exact).max() / L)}

    rows: list[Alternative] = []

    def add(label: str, kind, run) -> None:
        try:
            run()
        except peers.MissingPeerError as error:
            found.skipped[label.partition(",")[0]] = str(error)
        else:
            rows.append(Alternative(label, kind, run, 1, errors))

    for name in PARAMETERS:
        for n in (300, 3000, 30000):
            add(
                f"substep {name}, h = {t_end / n:g} s", "substep",
                lambda name=name, n=n: ours.pendulum_batch(name, EA, (0.0, 0.0), np.array([v0]), t_end / n, n)[0],
            )  # fmt: skip
    try:
        solver = NumbaLsoda(stiffness, L)
        for method in ("dop853", "lsoda"):
            for rtol in (1e-4, 1e-6, 1e-8):
                add(
                    f"numbalsoda {method}, rtol {rtol:g}", "peer",
                    lambda method=method, rtol=rtol: solver.run(method, rtol, start, t_end),
                )  # fmt: skip
    except peers.MissingPeerError as error:
        found.skipped["numbalsoda"] = str(error)
    for method in ("RK45", "DOP853", "Radau", "LSODA"):
        add(
            f"scipy solve_ivp {method}, rtol 1e-06", "peer",
            lambda method=method: scipy_pendulum(method, 1e-6, start, stiffness, L, t_end),
        )  # fmt: skip
    found.tables.append(
        Table(
            "one flexible pendulum to 3 s: time and error", "run", measure(rows, min(rounds, 5)),
            {"exact": "distance of the last position from the exact one, over the length"},
        )
    )  # fmt: skip
