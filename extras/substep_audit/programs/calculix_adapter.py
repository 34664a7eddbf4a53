"""CalculiX: direct integration of a mass on a spring, by input files; every run is a process of its own, or two.

Its results are text of seven digits. So that more can be read, a run is repeated: a node C is moved along what the
first run printed, and an equation ties another node B to the difference, u_B = 10^6 (u_A - u_C). Nothing hangs on
either, so that the oscillator A moves as before, and what B prints are the digits that follow.
"""

import math
import os
import re
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from adapter import Integrator, Load, serve

MANUAL = "CalculiX CrunchiX User's Manual version 2.20, "
THEORY = MANUAL + "Types of analysis, Direct integration dynamic analysis"
CRITERIA = "doc/CalculiX.tex of github.com/Dhondtguido/CalculiX, Convergence criteria, Implicit dynamics"
METHOD = "integrated in time using the alpha-method developed by Hilber, Hughes and Taylor"
STABLE = "The implicit version (default) is unconditionally stable."
ORDER = "The method is unconditionally stable and second order accurate."
LARGEST = "the maximum time step is dictated by: Omega_cr/omega_max"
FORMULA = THEORY + ", its equation (2.477) as in calcstabletimeincvol.f:119-123"
DEFAULT = -0.05
DEFAULTS = MANUAL + "Input deck format, *DYNAMIC"
NEWMARK = "alpha = 0 corresponds to the classical Newmark method inducing no dissipation at all"
MAGNIFIED = 1e6  # by which B shows how far A and C are apart

MODEL = """*NODE, NSET=ALL
1, 0., 0., 0.
2, 0., 0., 0.
3, 0., 0., 0.
*ELEMENT, TYPE=MASS, ELSET=M
1, 1
*MASS, ELSET=M
1.
*ELEMENT, TYPE=SPRING1, ELSET=K
2, 1
*SPRING, ELSET=K
1
{k}
*MATERIAL, NAME=NONE
*DAMPING, ALPHA={c}
*BOUNDARY
1, 2, 3
*AMPLITUDE, NAME=LOAD
{load}
{tie}*INITIAL CONDITIONS, TYPE=DISPLACEMENT
1, 1, {u0}
*INITIAL CONDITIONS, TYPE=VELOCITY
1, 1, {v0}
*STEP, INC={most}
*DYNAMIC, {parameters}
{dt}, {end}, {dt}, {dt}
*CLOAD, AMPLITUDE=LOAD
1, 1, 1.
{moved}*NODE PRINT, NSET=ALL
U
*END STEP
"""
TIE = """*EQUATION
3
2, 1, 1., 1, 1, {minus}, 3, 1, {plus}
*AMPLITUDE, NAME=PRINTED
{table}
"""
MOVED = """*BOUNDARY, AMPLITUDE=PRINTED
3, 1, 1, 1.
"""


def implicit(arguments: dict[str, Any], claims: dict[str, tuple[Any, str, str]]) -> Integrator:
    """The procedure *DYNAMIC with its parameters, and what is claimed besides what is claimed for all their values."""
    stated = {"order": (2, ORDER, CRITERIA), "unconditional": (True, STABLE, THEORY)}
    return Integrator(arguments, sets="uva", outputs="u", load="samples", digits=13.0, claims=claims | stated)


def hht(alpha: float) -> Integrator:
    """The method that the manual names, with its parameter given."""
    return implicit({"ALPHA": alpha}, {"scheme": ("hht_alpha", METHOD, THEORY), "alpha": (alpha, METHOD, THEORY)})


def explicit(alpha: float) -> Integrator:
    """The procedure with EXPLICIT; the limit of its steps is computed as the program does, but for its factor 0.98."""
    beta, gamma = (1 - alpha) ** 2 / 4, 0.5 - alpha
    limit = math.sqrt(2 / (gamma + 2 * alpha * (gamma - beta)))
    claims = {"critical_Omega": (limit, LARGEST, FORMULA)}
    arguments = {"ALPHA": alpha, "EXPLICIT": True}
    return Integrator(arguments, outputs="u", load="samples", digits=13.0, claims=claims)


INTEGRATORS = {
    "dynamic_default": implicit(
        {},
        {
            "scheme": ("hht_alpha", METHOD, THEORY),
            "alpha": (DEFAULT, f"The default value is {DEFAULT:g}.", DEFAULTS),
        },
    ),
    "dynamic": hht(-0.1),
    "dynamic_most": hht(-1 / 3),
    "dynamic_newmark": implicit(
        {"ALPHA": 0.0}, {"scheme": ("newmark", NEWMARK, THEORY), "rho_inf": (1.0, NEWMARK, THEORY)}
    ),
    "dynamic_explicit": explicit(DEFAULT),
}


def version() -> str:
    """The version that the program tells."""
    told = subprocess.run(["ccx", "-v"], capture_output=True, text=True, check=False).stdout
    return told.split("Version")[1].split()[0]


def field(x: float) -> str:
    """A number in the twenty characters that the program reads."""
    return next(text for text in (f"{x:.{digits}e}" for digits in (16, 15, 14, 13, 12)) if len(text) <= 20)


def table(dt: float, values: Sequence[float]) -> str:
    """Lines of an amplitude: pairs of a time and a value."""
    return "\n".join(f"{field(i * dt)}, {field(value)}" for i, value in enumerate(values))


def displacements(text: str, folder: Path, n: int) -> list[list[float]]:
    """Of each node, what the program prints at the ends of n steps. Raises ValueError where it stops before."""
    (folder / "job.inp").write_text(text)
    told = subprocess.run(
        ["ccx", "job"],
        cwd=folder,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    rows = re.findall(r"^ +([123]) +(\S+)", (folder / "job.dat").read_text(), re.MULTILINE)
    found = [[number(value) for node, value in rows if node == name] for name in "123"]
    if len(found[0]) != n:
        raise ValueError(f"expected {n} steps, got {len(found[0])}; ccx says: {told.stdout.strip()[-300:]}")
    return found


def loads(
    alpha: float, omega: float, xi: float, dt: float, n: int, u0: float, v0: float, a0: float | None, load: Load
) -> list[float]:
    """The load at the ends of the steps, and such that the motion starts from a0 if one is given.

    The program finds a0 from (1 + beta (1 + alpha) (omega dt/10)^2) a0 = f(0) - omega^2 u0, without the damping
    (nonlingeo.c:1243-1264, see audits/calculix), so that the load at t = 0 decides it. What this load does to the
    balances of the HHT method, which take (1 + alpha) f(t_n+1) - alpha f(t_n), the later ones take back. To any other
    method these would be loads, and would show as such.
    """
    values = [load.at(i * dt) for i in range(n + 1)]
    if a0 is None:
        return values
    inertia = (1 + (1 - alpha) ** 2 / 4 * (1 + alpha) * (omega * dt / 10) ** 2) * a0
    change = inertia + omega**2 * u0 + 2 * xi * omega * v0 - values[0]
    values[0] = inertia + omega**2 * u0
    return [values[0], *(f + change * (alpha / (1 + alpha)) ** i for i, f in enumerate(values[1:], 1))]


def number(text: str) -> float:
    """A number of Fortran's, which leaves out the E before an exponent of three digits."""
    return float(re.sub(r"(\d)([+-]\d{3})$", r"\1E\2", text))


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Displacements, of which the second run adds the digits that the first one cannot print."""
    given = [name if value is True else f"{name}={field(value)}" for name, value in arguments.items()]
    numbers = {"k": omega**2, "c": 2 * xi * omega, "u0": u0, "v0": v0, "dt": dt, "end": n * dt}
    model = {name: field(x) for name, x in numbers.items()}
    model |= {"parameters": ", ".join(["DIRECT", *given]), "most": str(n + 1)}
    model["load"] = table(dt, loads(arguments.get("ALPHA", DEFAULT), omega, xi, dt, n, u0, v0, a0, load))
    with tempfile.TemporaryDirectory() as folder:
        printed, *_ = displacements(MODEL.format(**model, tie="", moved=""), Path(folder), n)
        tie = TIE.format(minus=field(-MAGNIFIED), plus=field(MAGNIFIED), table=table(dt, [u0, *printed]))
        _, rest, _ = displacements(MODEL.format(**model, tie=tie, moved=MOVED), Path(folder), n)
    return [u0, *(u + more / MAGNIFIED for u, more in zip(printed, rest, strict=True))], None, None


if __name__ == "__main__":
    serve("CalculiX", version(), "GPL-2.0-or-later", INTEGRATORS, run)
