"""Siconos: its one-step integrators of mechanical systems without contact, on a linear Lagrangian system."""

import subprocess

import numpy as np
from adapter import Integrator, Load, serve
from siconos import kernel


def moreau_jean(theta: float) -> Integrator:
    """Moreau and Jean's time stepping, of which no documentation comes with the package: so no claims."""
    return Integrator(arguments={"osi": "MoreauJeanOSI", "theta": theta}, outputs="uv")


INTEGRATORS = {
    "moreau_jean_half": moreau_jean(0.5),
    "moreau_jean_0.6": moreau_jean(0.6),
    "moreau_jean_1": moreau_jean(1.0),
}


class Oscillator(kernel.LagrangianLinearTIDS):
    """A unit mass with a spring and a damper, whose force is called at the instants that the integrator chooses."""

    def __init__(self, omega: float, xi: float, u0: float, v0: float, load: Load) -> None:
        super().__init__([u0], [v0], np.eye(1), np.array([[omega**2]]), np.array([[2 * xi * omega]]))
        self.load = load
        self.setFExtPtr(np.zeros(1))

    def computeFExt(self, t: float) -> None:
        """Write the force at t where the system looks for it."""
        self.fExt()[0] = self.load(t)


def version() -> str:
    """The version of Debian's package: the module tells none."""
    query = ["dpkg-query", "--show", "--showformat=${Version}", "python3-siconos"]
    return subprocess.run(query, capture_output=True, text=True, check=True).stdout.split("+")[0]


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of displacement and velocity."""
    oscillator = Oscillator(omega, xi, u0, v0, load)
    system = kernel.NonSmoothDynamicalSystem(0.0, (n + 1) * dt)
    system.insertDynamicalSystem(oscillator)
    osi = getattr(kernel, arguments["osi"])(arguments["theta"])
    stepping = kernel.TimeStepping(system, kernel.TimeDiscretisation(0.0, dt), osi, kernel.LCP())
    rows = [(u0, v0)]
    for _ in range(n):
        stepping.computeOneStep()
        stepping.nextStep()
        rows.append((float(oscillator.q()[0]), float(oscillator.velocity()[0])))
    u, v = zip(*rows, strict=True)
    return u, v, None


if __name__ == "__main__":
    serve("Siconos", version(), "Apache-2.0", INTEGRATORS, run)
