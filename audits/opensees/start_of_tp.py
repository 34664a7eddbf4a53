"""The first step of OpenSees's _TP integrators forgets the initial velocity and acceleration.

Source, OpenSees v3.7.1, SRC/analysis/integrator: HHT_TP.cpp:171-176 predicts from Utdot and Utdotdot, which only
commit (:472-474) sets; domainChanged (:301) reads the node's committed motion into U, Udot and Udotdot alone, so in the
first step Utdot = Utdotdot = 0. HHT.cpp:163-165 copies them at the head of newStep, as do HHTExplicit_TP.cpp:172-174
and KRAlphaExplicit_TP.cpp. The same holds of HHTGeneralized_TP.cpp:135, HHTGeneralizedExplicit_TP.cpp:139,
AlphaOS_TP.cpp:153, AlphaOSGeneralized_TP.cpp:155 and HHTHS{FixedNumIter,IncrReduct,IncrLimit}_TP.cpp.
A model that starts from complete rest is not affected.

Integrators, by their names in the report: HHT_TP, HHT_TP_all_arguments, HHTGeneralized_TP, HHTGeneralizedExplicit_TP,
AlphaOS_TP, AlphaOS_TP_update, AlphaOSGeneralized_TP, HHTHSFixedNumIter_TP, HHTHSIncrReduct_TP, HHTHSIncrLimit_TP.
"""

import openseespy.opensees as ops

DT = 0.001


def first_step(integrator: str, *arguments: float | str) -> tuple[float, float]:
    """Displacement and velocity after one short step of a free mass that starts with velocity 1."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0, "-mass", 1.0)
    ops.fix(1, 1)
    ops.uniaxialMaterial("Elastic", 1, 1.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.setNodeVel(2, 1, 1.0, "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    if "HS" in integrator:  # those for hybrid tests want iterations
        ops.test("FixedNumIter", 80 if "Reduct" in integrator else 5, 0)
        ops.algorithm("Newton")
    else:
        ops.algorithm("Linear")
    ops.integrator(integrator, *arguments)
    ops.analysis("Transient")
    ops.analyze(1, DT)
    return ops.nodeDisp(2, 1), ops.nodeVel(2, 1)


print(f"u'' + u = 0, u(0) = 0, v(0) = 1, one step of {DT}: expected u = {DT}, v = 1 to six digits")
for name, arguments in (
    ("HHT", (0.9,)),
    ("HHT_TP", (0.9,)),
    ("HHTGeneralized", (0.6,)),
    ("HHTGeneralized_TP", (0.6,)),
    ("HHTGeneralizedExplicit", (0.6, 0.8)),
    ("HHTGeneralizedExplicit_TP", (0.6, 0.8)),
    ("AlphaOS", (0.9,)),
    ("AlphaOS_TP", (0.9,)),
    ("AlphaOSGeneralized", (0.6,)),
    ("AlphaOSGeneralized_TP", (0.6,)),
    ("HHTExplicit_TP", (0.9,)),
    ("KRAlphaExplicit_TP", (0.6,)),
    ("HHTHSFixedNumIter", (0.6,)),
    ("HHTHSFixedNumIter_TP", (0.6,)),
    ("HHTHSIncrReduct", (0.6, 0.5)),
    ("HHTHSIncrReduct_TP", (0.6, 0.5)),
    ("HHTHSIncrLimit", (0.6, 1e9)),
    ("HHTHSIncrLimit_TP", (0.6, 1e9)),
):
    u, v = first_step(name, *arguments)
    print(f"  {name:26s} u = {u: .9f}  v = {v: .6f}")
