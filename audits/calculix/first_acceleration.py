"""CalculiX's *DYNAMIC leaves damping out at the start: a damped motion that starts with a velocity is of first order.

Source, CalculiX (github.com/Dhondtguido/CalculiX, commit 35fcfa1 of September 2022; version 2.20 is of July 2022),
nonlingeo.c:1243-1250: at the start of a step "mass x acceleration" is the external less the internal forces, fext - f,
and the damping is in neither; calcresidual.c:95: the first increment then takes the damping force at its start, cvini,
which is zero there. Besides, nonlingeo.c:1254-1264 adds a little stiffness to the mass, on purpose and by the square
of the increment, which costs no order. Manual, doc/CalculiX.tex, Convergence criteria, Implicit dynamics: "The method
is unconditionally stable and second order accurate."

A load at t = 0 alone, of the size of the damping force there, shows the cause, and is the cure for a user.

Integrators, by their names in the report: dynamic_default, dynamic, dynamic_most, dynamic_newmark.
"""

import math
import re
import subprocess
import tempfile
from pathlib import Path

C, T = 0.5, 4.0
DAMPINGS = {
    "*DAMPING, ALPHA": f"*MATERIAL, NAME=NONE\n*DAMPING, ALPHA={C}\n",
    "DASHPOTA": f"*ELEMENT, TYPE=DASHPOTA, ELSET=C\n3, 1, 2\n*DASHPOT, ELSET=C\n\n{C}\n",
}


def error(h: float, damping: str, at_start: float) -> float:
    """Error of u at T of u'' + C u' + u = 0, u = 0, u' = 1 at t = 0, with a load at t = 0 alone."""
    job = f"""*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
*ELEMENT, TYPE=MASS, ELSET=M
1, 1
*MASS, ELSET=M
1.
*ELEMENT, TYPE=SPRING1, ELSET=K
2, 1
*SPRING, ELSET=K
1
1.
{damping}*BOUNDARY
1, 2, 3
2, 1, 3
*AMPLITUDE, NAME=LOAD
0., {at_start}, {h}, 0.
*INITIAL CONDITIONS, TYPE=VELOCITY
1, 1, 1.
*STEP, INC=1000
*DYNAMIC, DIRECT, ALPHA=-0.05
{h}, {T}
*CLOAD, AMPLITUDE=LOAD
1, 1, 1.
*NODE PRINT, NSET=ALL
U
*END STEP
"""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "job.inp").write_text(job)
        subprocess.run(["ccx", "job"], cwd=folder, check=True, capture_output=True)
        printed = re.findall(r"^ +1 +(\S+)", Path(folder, "job.dat").read_text(), re.MULTILINE)
    damped = math.sqrt(1 - C**2 / 4)
    return abs(float(printed[round(T / h) - 1]) - math.exp(-C * T / 2) * math.sin(damped * T) / damped)


for name, damping in DAMPINGS.items():
    for at_start in (0.0, -C):
        errors = [error(h, damping, at_start) for h in (0.0625, 0.03125, 0.015625)]
        print(f"{name}, load {at_start:g} at t = 0: errors", *(f"{e:.2e}" for e in errors), end="")
        print(f", order {math.log2(errors[1] / errors[2]):.2f}, expected 2")
