"""OpenSees takes the first acceleration as zero unless it is set, and then motion under load or damping is first order.

Source, OpenSees v3.7.1, SRC/analysis/integrator: domainChanged reads the acceleration that is committed in the nodes
(Newmark.cpp:418, HHT.cpp:345, and so on in every integrator below), which is zero in a new model, and newStep begins
from it (Newmark.cpp:212-221); none of them solves the balance at the start. BackwardEuler.cpp:135-144 begins with two
steps of the trapezoidal rule from that acceleration; TRBDF2.cpp:309 and Houbolt.cpp:307 read it, too.
Manual: OpenSeesPy documentation, pages newmark, hht and generalizedAlpha, "second order accurate"; neither these nor
the page setNodeAccel say that it has to be set. That is the cure for a user: commit, by setNodeAccel, the acceleration
of the balance at t = 0.

Integrators, by their names in the report: Newmark, Newmark_linear, Newmark_explicit, NewmarkExplicit, HHT, HHT_least,
HHT_all_arguments, GeneralizedAlpha, GeneralizedAlpha_hht, HHTGeneralized, HHTGeneralized_all_arguments,
HHTExplicit_gamma, HHTGeneralizedExplicit, AlphaOS, AlphaOS_update, AlphaOS_all_arguments, AlphaOSGeneralized,
Collocation, Collocation_all_arguments, WilsonTheta, TRBDF2, Houbolt, BackwardEuler, NewmarkHSFixedNumIter,
NewmarkHSIncrReduct, NewmarkHSIncrLimit, HHTHSFixedNumIter, HHTHSIncrReduct, HHTHSIncrLimit, CollocationHSFixedNumIter,
CollocationHSIncrReduct, CollocationHSIncrLimit.
"""

import math

import openseespy.opensees as ops

XI, V0, T = 0.1, 1.0, 2.0
DT = (0.01, 0.005, 0.0025)


def error(integrator: list, dt: float, a0: float | None) -> float:
    """Error of u at T of u'' + 2 XI u' + u = 1 from u = 0, u' = V0, the first acceleration set to a0 or left alone."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0, "-mass", 1.0)
    ops.fix(1, 1)
    ops.uniaxialMaterial("Elastic", 1, 1.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.rayleigh(2 * XI, 0.0, 0.0, 0.0)
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(2, 1.0)
    ops.setNodeVel(2, 1, V0, "-commit")
    if a0 is not None:
        ops.setNodeAccel(2, 1, a0, "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    if "HS" in integrator[0]:  # those for hybrid tests want iterations
        ops.test("FixedNumIter", 80 if "Reduct" in integrator[0] else 5, 0)
        ops.algorithm("Newton")
    else:
        ops.algorithm("Linear")
    ops.integrator(*integrator)
    ops.analysis("Transient")
    ops.analyze(round(T / dt), dt)
    damped = math.sqrt(1 - XI**2)
    amplitude = (V0 - XI) / damped
    return ops.nodeDisp(2, 1) - 1 + math.exp(-XI * T) * (math.cos(damped * T) - amplitude * math.sin(damped * T))


def order(integrator: list, a0: float | None) -> float:
    """From the errors under two halved steps."""
    errors = [error(integrator, dt, a0) for dt in DT]
    return math.log2(abs(errors[1] / errors[2]))


print("orders of u, expected 2:     as it is  a(0) set")
for integrator in (
    ["Newmark", 0.5, 0.25],
    ["Newmark", 0.5, 1 / 6],
    ["Newmark", 0.5, 0.0, "-form", "A"],
    ["NewmarkExplicit", 0.5],
    ["HHT", 0.9],
    ["HHT", 2 / 3],
    ["HHT", 0.9, 0.6, 0.3025],
    ["GeneralizedAlpha", 1.1, 0.8],
    ["GeneralizedAlpha", 1.0, 0.9],
    ["HHTGeneralized", 0.6],
    ["HHTGeneralized", 1.1, 0.8, 0.4225, 0.8],
    ["HHTExplicit", 0.9, 0.6],
    ["HHTGeneralizedExplicit", 0.6, 0.8],
    ["AlphaOS", 0.9],
    ["AlphaOS", 0.9, "-updateElemDisp"],
    ["AlphaOS", 0.9, 0.3025, 0.6],
    ["AlphaOSGeneralized", 0.6],
    ["Collocation", 1.4],
    ["Collocation", 1.4, 1 / 6, 0.5],
    ["WilsonTheta", 1.4],
    ["TRBDF2"],
    ["Houbolt"],
    ["BackwardEuler", 0],
    ["NewmarkHSFixedNumIter", 0.5, 0.25, "-polyOrder", 2],
    ["NewmarkHSIncrReduct", 0.5, 0.25, 0.5],
    ["NewmarkHSIncrLimit", 0.5, 0.25, 1e9],
    ["HHTHSFixedNumIter", 0.6, "-polyOrder", 2],
    ["HHTHSIncrReduct", 0.6, 0.5],
    ["HHTHSIncrLimit", 0.6, 1e9],
    ["CollocationHSFixedNumIter", 1.4, "-polyOrder", 2],
    ["CollocationHSIncrReduct", 1.4, 0.5],
    ["CollocationHSIncrLimit", 1.4, 1e9],
):
    name = " ".join(f"{x:.4g}" if isinstance(x, float) else str(x) for x in integrator)
    print(f"{name:44s} {order(integrator, None):5.2f} {order(integrator, 1 - 2 * XI * V0):9.2f}")
