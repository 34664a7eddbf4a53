"""OpenSeesPy takes the optional arguments of GeneralizedAlpha and HHT_TP as beta, gamma where it documents gamma, beta.

Manual: OpenSeesPy documentation, page generalizedAlpha, integrator('GeneralizedAlpha', alphaM, alphaF, gamma, beta); so
do the OpenSees documentation, source/user/manual/analysis/integrator/GeneralizedAlpha.rst ("integrator GeneralizedAlpha
$alphaM $alphaF <$gamma $beta>"), and the command's own usage message.
Source, OpenSees v3.7.1, SRC/analysis/integrator: GeneralizedAlpha.cpp:54 (usage), :67 (hands the third argument on as
the third) and :103 (the constructor's third is beta); HHT_TP.cpp:54, :67 and :100 likewise. HHT.cpp:67 is right: it
exchanges them and says so.

Integrators, by their names in the report: GeneralizedAlpha, GeneralizedAlpha_all_arguments, HHT_TP,
HHT_TP_all_arguments.
"""

import numpy as np
import openseespy.opensees as ops

DT, STEPS = 0.5, 10


def opensees(integrator: str, *arguments: float) -> np.ndarray:
    """Displacements of u'' + u = t from complete rest, whose load is zero at the start."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0, "-mass", 1.0)
    ops.fix(1, 1)
    ops.uniaxialMaterial("Elastic", 1, 1.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(2, 1.0)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator(integrator, *arguments)
    ops.analysis("Transient")
    u = [0.0]
    for _ in range(STEPS):
        ops.analyze(1, DT)
        u.append(ops.nodeDisp(2, 1))
    return np.array(u)


def formula(alpha_m: float, alpha_f: float, gamma: float, beta: float) -> np.ndarray:
    """The same with the generalized alpha method; under a ramp both ways of weighting the load are one."""
    u = v = a = 0.0
    history = [u]
    for i in range(STEPS):
        predicted = u + DT * v + DT**2 * (0.5 - beta) * a
        load = (i + alpha_f) * DT
        force = (1 - alpha_f) * u + alpha_f * predicted
        new = (load - (1 - alpha_m) * a - force) / (alpha_m + alpha_f * beta * DT**2)
        u = predicted + beta * DT**2 * new
        v += DT * ((1 - gamma) * a + gamma * new)
        a = new
        history.append(u)
    return np.array(history)


for name, given, weights in (
    ("GeneralizedAlpha", (1.1, 0.8, 0.7, 0.4), (1.1, 0.8)),
    ("HHT_TP", (0.9, 0.7, 0.4), (1.0, 0.9)),
    ("HHT", (0.9, 0.7, 0.4), (1.0, 0.9)),
):
    obtained = opensees(name, *given)
    documented = formula(*weights, gamma=0.7, beta=0.4)
    exchanged = formula(*weights, gamma=0.4, beta=0.7)
    print(f"{name}{given}: the last two are documented as gamma = 0.7, beta = 0.4")
    print(f"  obtained u(5)  {obtained[-1]: .15f}")
    print(f"  as documented  {documented[-1]: .15f}  largest difference {abs(obtained - documented).max():.1e}")
    print(f"  exchanged      {exchanged[-1]: .15f}  largest difference {abs(obtained - exchanged).max():.1e}")
