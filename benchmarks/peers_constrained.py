"""Peers with constraints and contacts: Exudyn on points and rods, Siconos on a bouncing ball."""

import json
import os
import subprocess
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .peers import MissingPeerError, peer

Array = NDArray[np.float64]


Place = tuple[float, float]


class ExudynRods:
    """Point masses of 1 kg on rods of 1 m, in exudyn: generalized alpha, index 3.

    points: where they start, with one velocity; rods: each from a point, by its number, or a pivot, to a point.
    """

    def __init__(
        self, points: list[Place], rods: list[tuple[int | Place, int]], velocity: Place, g: float, rho_inf: float,
        dt: float, n: int,
    ):  # fmt: skip
        self.exudyn, self.items = peer("exudyn"), peer("exudyn.itemInterface")
        self.points, self.rods, self.velocity, self.g = points, rods, velocity, g
        self.settings = self._settings(rho_inf, dt, n)

    def _settings(self, rho_inf: float, dt: float, n: int) -> Any:
        """Fixed steps, a full Newton iteration with analytic tangents, and no files."""
        chosen = self.exudyn.SimulationSettings()
        chosen.solution.file.write = False
        time = chosen.timeIntegration
        time.numberOfSteps, time.endTime, time.verboseMode = n, n * dt, 0
        time.automaticStepSize = time.adaptiveStep = time.newton.useModifiedNewton = False
        time.newton.relativeTolerance, time.newton.absoluteTolerance = 1e-12, 1e-13
        time.generalizedAlpha.spectralRadius = rho_inf
        time.generalizedAlpha.computeInitialAccelerations = True
        time.generalizedAlpha.useIndex2Constraints = False
        return chosen

    def run(self) -> Array:
        """All steps in one call; the last positions (points, 2)."""
        container, i = self.exudyn.SystemContainer(), self.items
        system = container.AddSystem()
        ground = system.AddObject(i.ObjectGround(referencePosition=[0, 0, 0]))
        nodes, markers = [], []
        for place in self.points:
            node = i.NodePoint2D(referenceCoordinates=list(place), initialVelocities=list(self.velocity))
            nodes.append(system.AddNode(node))
            body = system.AddObject(i.ObjectMassPoint2D(mass=1.0, nodeNumber=nodes[-1]))
            markers.append(system.AddMarker(i.MarkerBodyPosition(bodyNumber=body, localPosition=[0, 0, 0])))
            system.AddLoad(i.LoadForceVector(markerNumber=markers[-1], loadVector=[0, -self.g, 0]))
        for end, point in self.rods:
            if isinstance(end, int):
                begin = markers[end]
            else:
                begin = system.AddMarker(i.MarkerBodyPosition(bodyNumber=ground, localPosition=[*end, 0]))
            system.AddObject(i.ObjectConnectorDistance(markerNumbers=[begin, markers[point]], distance=1.0))
        system.Assemble()
        system.SolveDynamic(self.settings, solverType=self.exudyn.DynamicSolverType.GeneralizedAlpha)
        position = self.exudyn.OutputVariableType.Position
        return np.array([system.GetNodeOutput(node, position)[:2] for node in nodes])


SICONOS = """
import json, time
import numpy as np
from siconos import kernel

def run(u0, g, restitution, dt, n):
    ball = kernel.LagrangianLinearTIDS(np.array([u0]), np.zeros(1), np.eye(1))
    ball.setFExtPtr(np.array([-g]))
    floor = kernel.Interaction(kernel.NewtonImpactNSL(restitution), kernel.LagrangianLinearTIR(np.eye(1)))
    system = kernel.NonSmoothDynamicalSystem(0.0, (n + 0.5) * dt)
    system.insertDynamicalSystem(ball)
    system.link(floor, ball)
    osi = kernel.MoreauJeanOSI(0.5, 1.0)  # theta; a contact is looked at if y + 1.0 h v closes its gap
    stepping = kernel.TimeStepping(system, kernel.TimeDiscretisation(0.0, dt), osi, kernel.LCP())
    began = time.process_time()
    for _ in range(n):
        stepping.computeOneStep()
        stepping.nextStep()
    return time.process_time() - began, ball.q()[0], ball.velocity()[0]

print(json.dumps([run(*{given}) for _ in range({rounds})]))
"""


def siconos_ball(given: tuple[float, float, float, float, int], rounds: int) -> tuple[Array, Array]:
    """Seconds of each of some runs of n steps (rounds,), and the last u, v, by Moreau and Jean's scheme.

    given: height of the start, g, restitution, step and n. Siconos is Debian's package python3-siconos, for Debian's
    own Python (SICONOS_PYTHON, by default /usr/bin/python3), so that it runs in a process of its own.
    """
    python = os.environ.get("SICONOS_PYTHON", "/usr/bin/python3")
    program = SICONOS.format(given=given, rounds=rounds)
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    try:
        found = subprocess.run([python, "-c", program], capture_output=True, text=True, check=True, env=clean)
    except (OSError, subprocess.CalledProcessError) as error:
        raise MissingPeerError(f"{type(error).__name__}: {str(getattr(error, 'stderr', error))[-120:]}") from error
    rows = np.array(json.loads(found.stdout.splitlines()[-1]))
    return rows[:, 0], rows[-1, 1:]
