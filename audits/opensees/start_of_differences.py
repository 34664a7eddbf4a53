"""How OpenSees's explicit difference integrators start from an initial velocity.

Source, OpenSees v3.7.1, SRC/analysis/integrator: CentralDifference.cpp sets U(t - dt) = U(t) in domainChanged, which
its warning "assuming Ut-1 = Ut" says: the initial velocity is not used. ExplicitDifference.cpp:91-92 adds dt a to the
initial velocity and moves with the sum, and CentralDifferenceAlternative.cpp and CentralDifferenceNoDamping.cpp do the
same: they take the velocity at t = 0 for that at t = -dt/2, so the start, and with it the motion, is of first order.
Neither manual page says so. The right start of a leap-frog has dt/2 a.

Integrators, by their names in the report: CentralDifference, CentralDifferenceAlternative, CentralDifferenceNoDamping,
ExplicitDifference.
"""

import math

import openseespy.opensees as ops


def error(integrator: str, dt: float) -> float:
    """Error of u at t = 2 of u'' + u = 0 from u(0) = 1, v(0) = 1 and its own acceleration, -1."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0, "-mass", 1.0)
    ops.fix(1, 1)
    ops.uniaxialMaterial("Elastic", 1, 1.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.sp(2, 1, 1.0)
    ops.constraints("Lagrange")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator("LoadControl", 0.0)
    ops.analysis("Static")
    ops.analyze(1)  # the spring knows the displacement
    ops.remove("loadPattern", 1)
    ops.wipeAnalysis()
    ops.setTime(0.0)
    ops.setNodeDisp(2, 1, 1.0, "-commit")
    ops.setNodeVel(2, 1, 1.0, "-commit")
    if integrator in ("NewmarkExplicit", "ExplicitDifference"):  # the others neither take nor update an acceleration
        ops.setNodeAccel(2, 1, -1.0, "-commit")
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator(*([integrator, 0.5] if integrator == "NewmarkExplicit" else [integrator]))
    ops.analysis("Transient")
    ops.analyze(round(2 / dt), dt)
    return ops.nodeDisp(2, 1) - (math.cos(2.0) + math.sin(2.0))


names = "NewmarkExplicit CentralDifference CentralDifferenceAlternative CentralDifferenceNoDamping ExplicitDifference"
for name in names.split():
    errors = [error(name, dt) for dt in (0.02, 0.01, 0.005)]
    order = math.log2(abs(errors[1] / errors[2]))
    print(f"{name:30s} errors {errors[0]: .2e} {errors[1]: .2e} {errors[2]: .2e}  order {order:.2f}, expected 2")
