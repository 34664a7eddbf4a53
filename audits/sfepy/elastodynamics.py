"""SfePy's elastodynamics solvers: dropped loads, loads at the wrong instant, and a damping force half a step late.

Source, SfePy 2026.3, sfepy/solvers/ts_solvers.py.
1. transform_equations_ed (lines 403-421), which the option auto_transform_equations calls, sorts a term by its
   unknowns; a term without one, which loads are, is in no list and in none of the new equations.
2. BatheTS.step solves the first sub-step with the loads of prestep_fun at t(n+1), then calls ts.set_substep_time(0.5 *
   dt), which adds to the time (sfepy/solvers/ts.py:65-67), and prestep_fun again: the second sub-step has the loads
   of t(n+1) + dt/2. Both are half a step late. Bathe's method takes them at t(n) + dt/2 and t(n+1).
3. GeneralizedAlphaTS takes the loads of t(n+1), and says so in a comment ("TODO ... loads should be applied in the
   mid-step time"); its docstring says "second-order accurate".
4. VelocityVerletTS.create_nlst evaluates damping with the middle velocity, CentralDifferenceTS with the end's: with
   damping they are not "mathematically equivalent", and the first is of first order.

Integrators, by their names in the report: bathe, generalized_alpha_0.5, generalized_alpha_1, velocity_verlet.
"""

import math
import sys

import numpy as np
from sfepy.base.base import output
from sfepy.base.conf import ProblemConf
from sfepy.discrete import Problem
from sfepy.discrete.fem.meshio import UserMeshIO
from sfepy.mesh.mesh_generators import gen_block_mesh

output.set_output(quiet=True)
asked: list[float] = []


def motion(
    kind: str, dt: float, n: int, damping: float, load, u0: float, v0: float, transform: bool = False
) -> np.ndarray:
    """Displacements of u'' + damping u' + u = load, on a unit square with one degree of freedom."""

    def mesh(mesh, mode):
        return gen_block_mesh([1.0, 1.0], [2, 2], [0.5, 0.5], name="square", verbose=False) if mode == "read" else None

    def force(ts, coordinates, mode=None, **others):
        if mode != "qp":
            return None
        asked.append(float(ts.time))
        return {"f": np.full((coordinates.shape[0], 1, 1), load(ts.time))}

    solver = {"t0": 0.0, "t1": n * dt, "n_step": n + 1, "var_names": {"u": "u", "du": "du", "ddu": "ddu"}}
    forces = "dw_dot.i.Omega(m.one, v, u) - dw_volume_lvf.i.Omega(load.f, v) = 0"
    variables = {"u": ("unknown field", "f", 0), "v": ("test field", "f", "u")}
    if transform:
        equations = {"all": f"dw_dot.i.Omega(m.one, v, ddu) + dw_dot.i.Omega(m.c, v, du) + {forces}"}
    else:
        variables |= {"du": ("unknown field", "f", 1), "ddu": ("unknown field", "f", 2)}
        variables |= {"dv": ("test field", "f", "du"), "ddv": ("test field", "f", "ddu")}
        equations = {"M": "dw_dot.i.Omega(m.one, ddv, ddu) = 0", "C": "dw_dot.i.Omega(m.c, dv, du) = 0", "K": forces}
    description = {
        "filename_mesh": UserMeshIO(mesh),
        "regions": {"Omega": "all"},
        "materials": {"m": ({"one": 1.0, "c": damping},), "load": "force"},
        "functions": {"force": (force,)},
        "fields": {"f": ("real", "scalar", "Omega", 0)},
        "integrals": {"i": 1},
        "variables": variables,
        "ics": {"ic": ("Omega", {"u.0": u0, "du.0": v0})},
        "equations": equations,
        "solvers": {
            "ls": ("ls.scipy_direct", {}),
            "nls": ("nls.newton", {"i_max": 2, "eps_a": 1e-300, "eps_r": 1e-15}),
            "ts": (f"ts.{kind}", solver),
        },
        "options": {"ts": "ts", "nls": "nls", "ls": "ls", "save_times": [], "auto_transform_equations": transform},
    }
    asked.clear()
    history: list[float] = []
    problem = Problem.from_conf(ProblemConf.from_dict(description, sys.modules[__name__]))
    problem.solve(save_results=False, step_hook=lambda p, ts, now: history.append(float(now["u"]()[0])), verbose=False)
    return np.array(history)


def show(title: str, run, exact: float, expected: int = 2) -> None:
    """Errors at t = 2 under halved steps, and the order."""
    errors = [abs(run(dt)[-1] - exact) for dt in (0.02, 0.01, 0.005)]
    print(f"{title}: errors", *(f"{e:.1e}" for e in errors), end="")
    print(f", order {math.log2(errors[1] / errors[2]):.2f}, expected {expected}")


pushed = motion("newmark", 0.1, 20, 0.0, lambda t: 1.0, 0.0, 0.0, transform=True)
print(f"1. newmark, auto_transform_equations, a constant load 1 from rest: u(2) = {pushed[-1]:.6f},", end=" ")
print(f"expected {1 - math.cos(2.0):.6f}; the load was asked for {len(asked)} times")
wave = lambda t: math.sin(2 * t)  # noqa: E731  its motion from u = 0, u' = -2/3 is -sin(2t)/3
motion("bathe", 0.5, 2, 0.0, wave, 0.0, -2 / 3)
print("2. bathe, two steps of 0.5, load asked for at", asked, "expected [0.0, 0.25, 0.5, 0.75, 1.0]")
exact = -math.sin(4.0) / 3
for kind in ("newmark", "bathe", "generalized_alpha"):
    show(f"2., 3. {kind}, load sin 2t", lambda dt, k=kind: motion(k, dt, round(2 / dt), 0.0, wave, 0.0, -2 / 3), exact)
rate = math.sqrt(1 - 0.1**2)
exact = math.exp(-0.2) * (math.cos(2 * rate) + 0.1 / rate * math.sin(2 * rate))
for kind in ("central_difference", "velocity_verlet"):
    show(f"4. {kind}, xi = 0.1", lambda dt, k=kind: motion(k, dt, round(2 / dt), 0.2, lambda t: 0.0, 1.0, 0.0), exact)
