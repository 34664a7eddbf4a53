"""EasyFEA: its time schemes for hyperbolic problems, on one bar element whose field stays uniform.

The weak forms k u v, c v' v and u'' v make every node of a uniform field the same oscillator. The manual writes each
scheme as K u^t + C v^t + M a^t = F^t at an instant t of its own; the load is handed over at that instant.
"""

from importlib.metadata import version
from typing import Any

import numpy as np
from adapter import Integrator, serve
from quiet import printing_aside

with printing_aside():
    from EasyFEA import AlgoType, ElemType, Models, Simulations
    from EasyFEA.FEM import BiLinearForm, Field, GroupElemFactory, Mesh

PLACE = "docstring of EasyFEA.AlgoType.{}"
HHT = "Hilber-Hughes-Taylor-alpha method (second-order, unconditionally stable)"
DOYEN = "Hilber-Hughes-Taylor-Newmark method (second-order, unconditionally stable, dissipative)"


def scheme(
    algo: str,
    quotation: str,
    arguments: dict[str, Any] | None = None,
    defaults: dict[str, float] | None = None,
    **values: Any,
) -> Integrator:
    """A scheme with the parameters that it takes."""
    claims = {name: (value, quotation, PLACE.format(algo)) for name, value in values.items()}
    return Integrator(
        arguments={"algo": algo} | (arguments or {}),
        defaults=defaults or {},
        load="each step",
        sets="uv" if algo.startswith("euler") else "uva",
        claims=claims,
    )


STABLE = {"order": 2, "unconditional": True}
INTEGRATORS = {
    "newmark": scheme(
        "newmark",
        "Newmark method (default beta=1/4, gamma=1/2)",
        defaults={"beta": 0.25, "gamma": 0.5},
        scheme="newmark",
        beta=0.25,
        gamma=0.5,
    ),
    "newmark_damped": scheme(
        "newmark",
        "Newmark method (default beta=1/4, gamma=1/2)",
        {"beta": 0.3025, "gamma": 0.6},
        scheme="newmark",
        beta=0.3025,
        gamma=0.6,
    ),
    "midpoint": scheme("midpoint", "Midpoint rule (hht with alpha=1/2, beta=1/4, gamma=1/2)", scheme="midpoint"),
    "hht": scheme("hht", HHT, {"alpha": 0.1}, scheme="hht_alpha", alpha=-0.1, **STABLE),
    "hht_beyond_half": scheme("hht", HHT, {"alpha": 0.6}, scheme="hht_alpha", alpha=-0.6, **STABLE),
    "hht_newmark": scheme("hht_newmark", DOYEN, {"alpha": 1 / 6}, scheme="hht_alpha", alpha=-1 / 6, **STABLE),
    "hht_newmark_most": scheme("hht_newmark", DOYEN, {"alpha": 1 / 3}, scheme="hht_alpha", alpha=-1 / 3, **STABLE),
    "euler_implicit": scheme(
        "euler_implicit",
        "Backward-Euler (first-order, unconditionally stable, dissipative)",
        scheme="backward_euler",
        order=1,
        unconditional=True,
    ),
    "euler_explicit": scheme(
        "euler_explicit",
        "Forward-Euler (first-order, conditionally stable, linear only)",
        scheme="forward_euler",
        order=1,
    ),
}


def instant(algo: str, alpha: float) -> float:
    """Where in the step, from 0 to 1, the manual has a scheme's F^t."""
    if algo in ("hht", "hht_newmark"):
        return 1 - alpha
    return {"midpoint": 0.5, "euler_explicit": 0.0}.get(algo, 1.0)


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of one node; the first acceleration, which the program leaves to its user, is that of the balance."""
    parameters = dict(arguments)
    algo = parameters.pop("algo")
    ends = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    mesh = Mesh({ElemType.SEG2: GroupElemFactory.Create(ElemType.SEG2, np.array([[0, 1]]), ends)})
    k, c = omega**2, 2 * xi * omega
    forms = Models.WeakForms(
        Field(mesh.groupElem, 1),
        BiLinearForm(lambda u, v: k * u.dot(v)),
        BiLinearForm(lambda u, v: c * u.dot(v)),
        BiLinearForm(lambda u, v: u.dot(v)),
    )
    simulation = Simulations.WeakForms(mesh, forms)
    simulation.Solver_Set_Hyperbolic_Algorithm(dt, algo=AlgoType[algo], **parameters)
    start = load.at(0.0) - c * v0 - k * u0 if a0 is None else a0
    both = np.ones(2)
    simulation._Set_solutions(simulation.problemType, u0 * both, v0 * both, start * both)
    rows = [(u0, v0, start)]
    for i in range(n):
        simulation.Bc_Init()
        force = load((i + instant(algo, parameters.get("alpha", 0.0))) * dt)
        simulation.add_neumann(np.array([0, 1]), [force], ["u"])  # shared among the nodes
        simulation.Solve()
        rows.append((simulation.u[0], simulation.v[0], simulation.a[0]))
    return tuple(zip(*rows, strict=True))


if __name__ == "__main__":
    serve("EasyFEA", version("easyfea"), "GPL-3.0-or-later", INTEGRATORS, run)
