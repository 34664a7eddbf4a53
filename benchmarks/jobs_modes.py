"""Mode superposition beside pyyeti's, and a corner load on few modes with static correction beside many without."""

from dataclasses import replace
from importlib.util import find_spec
from typing import Any

import numpy as np

import substep as ss
from substep.structures.examples import solid

from .job import Job, Table
from .peers import peer
from .timing import Alternative, cores, measure

NAME = "modes"
CELLS = 10
RAYLEIGH = ss.Rayleigh(1.0, 1e-6)
STEP, N = 2e-5, 20000
RECOVERED = 10  # degrees of freedom
PULSES = (0.86, 2.0)  # lengths of half sines, in periods of the first mode


def job(quick: bool) -> Job:
    """One core; 3-D elasticity of 3630 degrees of freedom, loaded at a corner, classical damping."""
    found = Job(NAME, "Mode superposition, one core")
    if not find_spec("skfem"):
        found.skipped["all"] = "scikit-fem is not installed; pip install 'substep[fem]'"
        return found
    with cores(1):
        shake = ss.Record(STEP, np.sin(2000.0 * STEP * np.arange(N + 1)))  # slower than the first mode
        modes = _solid(shake).modes(80 if quick else 240)
        for m in (60,) if quick else (60, 240):
            _beside_pyyeti(found, modes.first(m), 5 if quick else 11)
        _corner(found, modes.first(80))
    return found


def _solid(load: Any) -> ss.Structure:
    return solid((CELLS,) * 3, load=load, C=RAYLEIGH)


def _beside_pyyeti(found: Job, modes: ss.Modes, rounds: int) -> None:
    """u, v, a at ten degrees of freedom, at each step."""
    model, m = modes.structure, len(modes)
    dofs = model.names[-RECOVERED:]
    shapes = modes.shapes[[model.place(dof) for dof in dofs]]
    (_, record), factor = model.loads[0], modes.load_factors

    def superposed(account: bool) -> Any:
        return ss.march(modes, "average_acceleration", STEP, N * STEP, dofs=dofs, account=account)

    def pyyeti() -> Any:
        solver = peer("pyyeti.ode").SolveUnc(None, 2.0 * modes.xi * modes.omega, modes.omega**2, STEP)
        q = solver.tsolve(factor * record.samples)
        return shapes @ q.d, shapes @ q.v, shapes @ q.a

    own = superposed(False).u
    ways = [
        Alternative("march of modes", "substep", lambda: superposed(False), N * m),
        Alternative("with account", "substep", lambda: superposed(True), N * m),
    ]
    if find_spec("pyyeti"):
        ways.append(
            Alternative(
                "pyyeti SolveUnc", "peer", pyyeti, N * m,
                lambda r: {"march": np.abs(own - r[0].T).max() / np.abs(r[0]).max()},
            )
        )  # fmt: skip
    else:
        found.skipped["pyyeti"] = "it is not installed; pip install 'substep[bench]'"
    title = f"{m} modes, {N} steps, u, v, a at {RECOVERED} degrees of freedom"
    columns = {"march": "largest difference of the march's u from this, which is exact for a load linear in each step"}
    table = Table(title, "mode-step", measure(ways, rounds), columns)
    found.tables.append(table)
    found.below(f"{m} modes: a mode-step of the march", 5e-9, [table.rows[0].seconds], "s")
    found.compare(table, f"{m} modes: pyyeti / march of modes", "pyyeti SolveUnc", "march of modes", ">=", 4.0)


def _corner(found: Job, modes: ss.Modes) -> None:
    """Displacement of the loaded corner, against direct steps of the same scheme and length."""
    for periods in PULSES:
        length = periods * float(modes.periods[0])
        model = _solid(ss.HalfSine(1.0, length))
        dof = model.names[int(np.argmax(model.T @ model.force(0.5 * length)))]
        t_end = STEP * round(3.0 * length / STEP)

        run: dict[str, Any] = {"dt": STEP, "t_end": t_end, "dofs": [dof], "account": False}
        loaded = replace(modes, structure=model)  # another function of time at the same corner
        exact = ss.march(model, "average_acceleration", **run).u
        few = ss.march(loaded.first(5), "average_acceleration", static_correction=True, **run).u
        many = ss.march(loaded, "average_acceleration", **run).u
        off = [float(np.abs(u - exact).max() / np.abs(exact).max()) for u in (few, many)]
        found.notes.append(
            f"Corner load of {periods:g} periods of the first mode on {model.size} degrees of freedom: off by "
            f"{off[0]:.2%} with 5 modes and static correction, by {off[1]:.0%} with {len(modes)} modes without."
        )
        found.below(f"corner load of {periods:g} periods: 5 modes and static correction", 0.01, off[:1])
