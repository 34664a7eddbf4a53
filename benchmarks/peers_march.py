"""Peers that march: OpenSees on one oscillator, ODE solvers on one elastic pendulum."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .peers import peer

Array = NDArray[np.float64]

# integrators of OpenSees whose scheme is in the catalogue: their names in openseespy, and parameters
OPENSEES = {
    "Newmark": (0.5, 0.25),
    "HHT": (0.9,),
    "GeneralizedAlpha": (1.0, 0.9),
    "TRBDF2": (),
    "Houbolt": (),
    "WilsonTheta": (1.4,),
    "KRAlphaExplicit": (0.8,),
}


class OpenSees:
    """One mass on a spring and a dashpot in openseespy, marched from rest.

    material: of the spring, its name and arguments, solved for with Newton; by default it is elastic.
    """

    def __init__(
        self, integrator: str, omega: float, xi: float, record: Array, dt: float, material: tuple[Any, ...] = ()
    ):  # fmt: skip
        self.ops, self.material = peer("openseespy.opensees"), material
        self.integrator, self.oscillator = integrator, (omega, xi)
        self.record, self.dt = [float(x) for x in record], dt

    def _build(self) -> None:
        ops, (omega, xi) = self.ops, self.oscillator
        ops.wipe()
        ops.model("basic", "-ndm", 1, "-ndf", 1)
        ops.node(1, 0.0)
        ops.node(2, 0.0)
        ops.fix(1, 1)
        ops.mass(2, 1.0)
        ops.uniaxialMaterial("Elastic", 1, 0.0 if self.material else omega**2, 2 * xi * omega)
        ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
        if self.material:
            name, *arguments = self.material
            ops.uniaxialMaterial(name, 2, *arguments)
            ops.element("zeroLength", 2, 1, 2, "-mat", 2, "-dir", 1)
        ops.timeSeries("Path", 1, "-dt", self.dt, "-values", *self.record)
        ops.pattern("Plain", 1, 1)
        ops.load(2, 1.0)
        ops.constraints("Plain")
        ops.numberer("Plain")
        ops.system("BandGeneral")
        ops.test("NormDispIncr", 1e-14, 10)
        ops.algorithm("Newton" if self.material else "Linear")
        ops.integrator(self.integrator, *OPENSEES[self.integrator])
        ops.analysis("Transient")

    def run(self) -> Array:
        """All steps in one call of analyze, as fast as OpenSees goes; the last displacement, (1,)."""
        self._build()
        if self.ops.analyze(len(self.record) - 1, self.dt):
            raise RuntimeError(f"openseespy: {self.integrator} failed")
        return np.array([self.ops.nodeDisp(2, 1)])

    def steps(self) -> Array:
        """All displacements (n + 1,), with one call of analyze for each step, as a history is recorded in Python."""
        self._build()
        out = [0.0]
        for _ in self.record[1:]:
            self.ops.analyze(1, self.dt)
            out.append(self.ops.nodeDisp(2, 1))
        return np.array(out)


class OpenSeesBuilding:
    """A shear building of bilinear stories, each with a dashpot, in openseespy: average acceleration from rest.

    stories: of each mass, stiffness, strength and damping; hardening: of all. record: ground acceleration.
    """

    def __init__(self, stories: list[tuple[float, float, float, float]], hardening: float, record: Array, dt: float):
        self.ops, self.stories, self.hardening = peer("openseespy.opensees"), stories, hardening
        self.record, self.dt = [-float(x) for x in record], dt

    def run(self) -> Array:
        """All steps in one call of analyze, as fast as OpenSees goes; the last displacements (stories,)."""
        ops = self.ops
        ops.wipe()
        ops.model("basic", "-ndm", 1, "-ndf", 1)
        ops.node(1, 0.0)
        ops.fix(1, 1)
        ops.timeSeries("Path", 1, "-dt", self.dt, "-values", *self.record)
        ops.pattern("Plain", 1, 1)
        for i, (mass, k, q_y, c) in enumerate(self.stories, 1):
            ops.node(i + 1, 0.0)
            ops.mass(i + 1, mass)
            ops.load(i + 1, mass)
            ops.uniaxialMaterial("Steel01", 2 * i, q_y, k, self.hardening)
            ops.uniaxialMaterial("Elastic", 2 * i + 1, 0.0, c)
            ops.element("zeroLength", i, i, i + 1, "-mat", 2 * i, 2 * i + 1, "-dir", 1, 1)
        ops.constraints("Plain")
        ops.numberer("Plain")
        ops.system("BandGeneral")
        ops.test("NormDispIncr", 1e-12, 20)
        ops.algorithm("Newton")
        ops.integrator("Newmark", 0.5, 0.25)
        ops.analysis("Transient")
        if ops.analyze(len(self.record) - 1, self.dt):
            raise RuntimeError("openseespy: the building failed")
        return np.array([ops.nodeDisp(i + 2, 1) for i in range(len(self.stories))])


def _slope(stiffness: float, L: float) -> Any:
    def slope(_: float, y: Array) -> list[float]:
        force = stiffness * (y[0] * y[0] + y[1] * y[1] - L * L)
        return [y[2], y[3], -force * y[0], -force * y[1]]

    return slope


def scipy_pendulum(method: str, rtol: float, start: Array, stiffness: float, L: float, t_end: float) -> Array:
    """Last position (2,) by scipy's solve_ivp; stiffness EA/(2 L^3 m)."""
    integrate = peer("scipy.integrate")
    found = integrate.solve_ivp(
        _slope(stiffness, L), (0.0, t_end), start, method=method, rtol=rtol, atol=rtol * L * 1e-2
    )  # fmt: skip
    return found.y[:2, -1]


class NumbaLsoda:
    """numbalsoda with a compiled right-hand side."""

    def __init__(self, stiffness: float, L: float):
        self.package = peer("numbalsoda")
        numba = peer("numba")

        @numba.cfunc(self.package.lsoda_sig)
        def slope(_, y, dy, p):
            force = p[0] * (y[0] * y[0] + y[1] * y[1] - p[1] * p[1])
            dy[0] = y[2]
            dy[1] = y[3]
            dy[2] = -force * y[0]
            dy[3] = -force * y[1]

        self.slope, self.data, self.length = slope, np.array([stiffness, L]), L

    def run(self, method: str, rtol: float, start: Array, t_end: float) -> Array:
        """Last position (2,) by "dop853" or "lsoda"."""
        solver = getattr(self.package, method)
        found, good = solver(
            self.slope.address, start, np.array([0.0, t_end]), self.data, rtol=rtol, atol=rtol * self.length * 1e-2
        )  # fmt: skip
        return found[-1, :2] if good else np.full(2, np.nan)

    def history(self, method: str, rtol: float, start: Array, t: Array) -> Array:
        """Positions (n, 2) at the times t (n,), after as many steps as it takes."""
        found, good = getattr(self.package, method)(
            self.slope.address, start, t, self.data, rtol=rtol, atol=rtol * self.length * 1e-2, mxstep=10**8
        )  # fmt: skip
        return found[:, :2] if good else np.full((len(t), 2), np.nan)
