"""With CalculiX's *DYNAMIC, EXPLICIT, printing the energy changes a damped motion.

Source, CalculiX (github.com/Dhondtguido/CalculiX, commit 35fcfa1 of September 2022; version 2.20 is of July 2022),
nonlingeo.c:3229-3236: since 19 July 2022 the residual at the end of an explicit increment is only computed when an
energy is asked for. That also renews the damping force cv (calcresidual.c:107-116), which the next increment weighs as
cvini: it is that of the velocities at the end of the increment where the energy is printed, and that of the predicted
velocities where it is not. Manual, *EL PRINT: it selects what is printed. Without damping nothing changes.
"""

import re
import subprocess
import tempfile
from pathlib import Path

JOB = """*NODE, NSET=ALL
1, 0., 0., 0.
*ELEMENT, TYPE=MASS, ELSET=M
1, 1
*MASS, ELSET=M
1.
*ELEMENT, TYPE=SPRING1, ELSET=K
2, 1
*SPRING, ELSET=K
1
16.
*MATERIAL, NAME=NONE
*DAMPING, ALPHA={c}
*BOUNDARY
1, 2, 3
*INITIAL CONDITIONS, TYPE=DISPLACEMENT
1, 1, 1.
*STEP, INC=100
*DYNAMIC, DIRECT, EXPLICIT, ALPHA=-0.05
0.25, 1., 0.25, 0.25
*NODE PRINT, NSET=ALL
U
{energy}*END STEP
"""


def displacements(c: float, energy: str) -> list[float]:
    """At the ends of four increments."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "job.inp").write_text(JOB.format(c=c, energy=energy))
        subprocess.run(["ccx", "job"], cwd=folder, check=True, capture_output=True)
        return [float(x) for x in re.findall(r"^ +1 +(\S+)", Path(folder, "job.dat").read_text(), re.MULTILINE)]


for c in (0.0, 0.4):
    for energy in ("", "*EL PRINT, ELSET=K\nENER\n"):
        text = "with ENER" if energy else "without  "
        print(f"damping {c:g}, {text}: u =", *(f"{u: .6f}" for u in displacements(c, energy)))
