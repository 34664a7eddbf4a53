"""EasyFEA's hht is the trapezoidal rule below alpha = 1/2 and unstable above; its hht_newmark is first order with
damping.

Manual: EasyFEA 7.1.0, EasyFEA/Simulations/Solvers.py:105, docstring of AlgoType.hht: "second-order, unconditionally
stable", "alpha in [0, 1[, introducing controllable numerical damping"; :122, of AlgoType.hht_newmark: "second-order,
unconditionally stable, dissipative".
Source, EasyFEA/Simulations/_simu.py, _Solver_Evaluate_u_v_a_for_time_scheme: hht (line 1352) weights displacement,
velocity and acceleration (lines 1360-1362) alike, (1 - alpha) new + alpha old, with beta = 1/4 and gamma = 1/2. Its
balance is then the weighted mean of the trapezoidal rule's balances at both ends: what one of them lacks is multiplied
by -alpha / (1 - alpha) in each step, which is nothing where the start is in balance, and grows for alpha above 1/2.
Hilber, Hughes and Taylor leave the inertia at the end and let beta and gamma follow from alpha. hht_newmark (line 1373)
weights the displacement and the load only, so the damping force stands alpha dt after the rest.

Integrators, by their names in the report: hht, hht_beyond_half, hht_newmark, hht_newmark_most.
"""

import math

import numpy as np
from EasyFEA import AlgoType, ElemType, Models, Simulations
from EasyFEA.FEM import BiLinearForm, Field, GroupElemFactory, Mesh


def motion(
    algo: str, dt: float, n: int, damping: float = 0.0, perturbed: float = 0.0, **parameters: float
) -> np.ndarray:
    """Rows (u, v) of u'' + damping u' + u = 0 from u = 1, v = 0, on an element whose field is uniform."""
    ends = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    mesh = Mesh({ElemType.SEG2: GroupElemFactory.Create(ElemType.SEG2, np.array([[0, 1]]), ends)})
    forms = Models.WeakForms(
        Field(mesh.groupElem, 1),
        BiLinearForm(lambda u, v: u.dot(v)),
        BiLinearForm(lambda u, v: damping * u.dot(v)),
        BiLinearForm(lambda u, v: u.dot(v)),
    )
    simulation = Simulations.WeakForms(mesh, forms)
    simulation.Solver_Set_Hyperbolic_Algorithm(dt, algo=AlgoType[algo], **parameters)
    both = np.ones(2)
    simulation._Set_solutions(simulation.problemType, both, 0 * both, (perturbed - 1) * both)
    rows = [(1.0, 0.0)]
    for _ in range(n):
        simulation.Bc_Init()
        simulation.Solve()
        rows.append((simulation.u[0], simulation.v[0]))
    return np.array(rows)


for dt in (0.5, 50.0):
    difference = abs(motion("hht", dt, 100, alpha=0.3) - motion("newmark", dt, 100)).max()
    energy = (motion("hht", dt, 100, alpha=0.3)[-1] ** 2).sum()
    print(
        f"hht(alpha = 0.3), omega dt = {dt}: largest difference from newmark() in 100 steps {difference:.1e},", end=" "
    )
    print(f"energy kept {energy:.12f}")
grown = abs(motion("hht", 0.5, 100, perturbed=1e-9, alpha=0.6)[:, 0])
print(
    f"hht(alpha = 0.6), omega dt = 0.5, first acceleration off by 1e-9: |u| after 100 steps {grown[-1]:.2e},", end=" "
)
print(f"growth a step {(grown[-1] / grown[-11]) ** 0.1:.4f} = alpha / (1 - alpha) = 1.5")
rate = math.sqrt(1 - 0.1**2)
exact = math.exp(-0.4) * (math.cos(4 * rate) + 0.1 / rate * math.sin(4 * rate))
for algo, alpha in (("newmark", 0.0), ("hht_newmark", 1 / 3)):
    errors = [
        abs(motion(algo, dt, round(4 / dt), damping=0.2, alpha=alpha)[-1, 0] - exact) for dt in (0.02, 0.01, 0.005)
    ]
    print(f"{algo}(alpha = {alpha:.2f}), xi = 0.1: errors", *(f"{e:.1e}" for e in errors), end="")
    print(f", order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
