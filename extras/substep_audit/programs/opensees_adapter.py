"""OpenSeesPy: every transient integrator that its command `integrator` knows, but PFEM's and those for hybrid tests.

The oscillator is a node of unit mass on a zero-length elastic spring; its damping is mass proportional Rayleigh damping
of the node, which acts as c = 2 xi omega. Loads are OpenSees's own series of time, so it takes them when it will.
"""

import math
from importlib.metadata import version
from typing import Any

import openseespy.opensees as ops
from adapter import Integrator, Load, serve

SOURCE = "OpenSees v3.7.1, SRC/analysis/integrator/{}"
PYDOC = "OpenSeesPy documentation, page {}"
MANUAL = "OpenSees documentation, source/user/manual/analysis/integrator/{}.rst"
HHT_DEFAULTS = "The default values ensure the method is second order accurate and unconditionally stable"
OPTIMAL = "The default values ensure the method is unconditionally stable, second order accurate"
OWN_FORM = "an algorithmic class for performing a transient analysis using the {} integration scheme"

Claims = dict[str, tuple[Any, str, str]]


def documented(page: str, quotation: str, **values: Any) -> Claims:
    """Claims with one quotation from a page of the documentation of OpenSeesPy."""
    return {name: (value, quotation, PYDOC.format(page)) for name, value in values.items()}


def header(name: str, line: int, quotation: str, **values: Any) -> Claims:
    """Claims from the description at the head of a class, for integrators that no manual describes."""
    return {key: (value, quotation, SOURCE.format(f"{name}.h:{line}")) for key, value in values.items()}


def usage(name: str, line: int, quotation: str, **values: Any) -> Claims:
    """Claims from the message on the arguments that the command expects, which is all that some of them have."""
    return {key: (value, quotation, SOURCE.format(f"{name}.cpp:{line}")) for key, value in values.items()}


def alpha(name: str, arguments: dict[str, Any], claims: Claims, **defaults: float) -> Integrator:
    """An integrator whose start takes an acceleration that was committed to the node."""
    return Integrator(arguments=arguments, defaults=defaults, sets="uva", load="series", claims=claims)


def newmark(gamma: float, beta: float, quotation: str, **options: Any) -> Integrator:
    """Newmark's method with the arguments in the order of the manual."""
    claims = documented("newmark", quotation, scheme="newmark", gamma=gamma, beta=beta)
    return alpha("Newmark", {"gamma": gamma, "beta": beta} | options, claims)


def hht_claims(factor: float) -> Claims:
    """What the manual says of HHT with its defaults, in its notation: alpha is one plus that of the paper."""
    values = {"alpha_m": 0.0, "alpha_f": 1 - factor, "beta": (2 - factor) ** 2 / 4, "gamma": 1.5 - factor}
    return documented("hht", HHT_DEFAULTS, scheme="generalized_alpha", order=2, unconditional=True, **values)


def family(name: str, line: int, rho: float) -> Integrator:
    """One of the integrators whose single argument is the spectral radius at infinity, by its usage message."""
    return alpha(name, {"rhoInf": rho}, usage(name, line, f"want {name} $rhoInf", rho_inf=rho))


EXPLICIT_NEWMARK = "the explicit Newmark integration scheme (beta = 0)"
KOLAY_RICLES = (
    "unconditionally stable explicit direct integration algorithms with controllable numerical energy dissipation"
)
WEIGHTS = {"alphaI": 1.1, "alphaF": 0.8, "beta": 0.4225, "gamma": 0.8}
PAIR = {"gamma": 0.6, "beta": 0.3025}
HULBERT = {"scheme": "generalized_alpha", "alpha_m": -0.1, "alpha_f": 0.2, "beta": 0.4225, "gamma": 0.8}
HHT = {"scheme": "generalized_alpha", "alpha_m": 0.0, "alpha_f": 0.1}  # of alpha = 0.9, with weights of the old state
GENERAL = documented("generalizedAlpha", OPTIMAL, scheme="generalized_alpha", order=2, unconditional=True)

INTEGRATORS: dict[str, Integrator] = {
    "Newmark": newmark(0.5, 0.25, "Average Acceleration Method (gamma=1/2, beta = 1/4)"),
    "Newmark_linear": newmark(0.5, 1 / 6, "Linear Acceleration Method (gamma=1/2, beta = 1/6)"),
    "Newmark_damped": newmark(0.6, 0.3025, "integrator('Newmark', gamma, beta, '-form', form)"),
    "Newmark_form_V": newmark(0.6, 0.3025, "'V' -- velocity", **{"-form": "V"}),
    "Newmark_form_A": newmark(0.6, 0.3025, "'A' -- acceleration", **{"-form": "A"}),
    "Newmark_explicit": Integrator(
        arguments={"gamma": 0.5, "beta": 0.0, "-form": "A"},
        sets="uva",
        load="series",
        claims=documented(
            "newmark",
            "beta is chosen as 0, the formulation results in the fast but conditionally stable explicit"
            " Central Difference method",
            scheme="newmark",
            gamma=0.5,
            beta=0.0,
            critical_Omega=2.0,
        ),
    ),
    "Newmark1": alpha("Newmark1", dict(PAIR), usage("Newmark1", 52, "Newmark1 gamma beta", scheme="newmark", **PAIR)),
    "HHT": alpha("HHT", {"alpha": 0.9}, hht_claims(0.9), **PAIR),
    "HHT_least": alpha("HHT", {"alpha": 2 / 3}, hht_claims(2 / 3)),
    "HHT_all_arguments": alpha(
        "HHT",
        {"alpha": 0.9, **PAIR},
        documented("hht", "integrator('HHT',alpha,gamma=1.5-alpha,beta=(2-alpha)^2/4)", **HHT, **PAIR),
    ),
    "HHT_TP": alpha(
        "HHT_TP",
        {"alpha": 0.9},
        header("HHT_TP", 33, OWN_FORM.format("HHT"), scheme="hht_alpha", alpha=-0.1),
        **PAIR,
    ),
    "HHT_TP_all_arguments": alpha(
        "HHT_TP", {"alpha": 0.9, **PAIR}, usage("HHT_TP", 54, "want HHT_TP $alpha <$gamma $beta>", **HHT, **PAIR)
    ),
    "GeneralizedAlpha": alpha("GeneralizedAlpha", {"alphaM": 1.1, "alphaF": 0.8}, GENERAL, gamma=0.8, beta=0.4225),
    "GeneralizedAlpha_hht": alpha(
        "GeneralizedAlpha",
        {"alphaM": 1.0, "alphaF": 0.9},
        documented("generalizedAlpha", "alpha_M = 1.0 corresponds to the HHT method", **HHT, order=2),
    ),
    "GeneralizedAlpha_all_arguments": alpha(
        "GeneralizedAlpha",
        {"alphaM": 1.0, "alphaF": 0.9, **PAIR},
        documented(
            "generalizedAlpha", "integrator('GeneralizedAlpha',alphaM,alphaF,gamma=...,beta=...)", **HHT, **PAIR
        ),
    ),
    "HHTGeneralized": family("HHTGeneralized", 53, 0.6),
    "HHTGeneralized_all_arguments": alpha(
        "HHTGeneralized",
        dict(WEIGHTS),
        usage("HHTGeneralized", 54, "or HHTGeneralized $alphaI $alphaF $beta $gamma", **HULBERT),
    ),
    "HHTGeneralized_TP": family("HHTGeneralized_TP", 53, 0.6),
    "HHTExplicit": alpha(
        "HHTExplicit",
        {"alpha": 0.9},
        header("HHTExplicit", 34, OWN_FORM.format("HHTExplicit") + " (beta = 0)", **HHT, beta=0.0),
    ),
    "HHTExplicit_gamma": alpha(
        "HHTExplicit",
        {"alpha": 0.9, "gamma": 0.6},
        usage("HHTExplicit", 54, "or HHTExplicit $alpha $gamma <-updateElemDisp>", **HHT, gamma=0.6),
    ),
    "HHTExplicit_update": alpha("HHTExplicit", {"alpha": 0.9, "-updateElemDisp": True}, {}),
    "HHTExplicit_TP": alpha("HHTExplicit_TP", {"alpha": 0.9}, {}),
    "HHTGeneralizedExplicit": alpha("HHTGeneralizedExplicit", {"rhoB": 0.6, "alphaF": 0.8}, {}),
    "HHTGeneralizedExplicit_TP": alpha("HHTGeneralizedExplicit_TP", {"rhoB": 0.6, "alphaF": 0.8}, {}),
    "KRAlphaExplicit": alpha(
        "KRAlphaExplicit",
        {"rhoInf": 0.6},
        header("KRAlphaExplicit", 35, KOLAY_RICLES, scheme="kr_alpha_plain_start", unconditional=True, rho_inf=0.6),
    ),
    "KRAlphaExplicit_update": alpha("KRAlphaExplicit", {"rhoInf": 0.6, "-updateElemDisp": True}, {}),
    "KRAlphaExplicit_TP": alpha(
        "KRAlphaExplicit_TP",
        {"rhoInf": 0.6},
        usage("KRAlphaExplicit_TP", 45, "want KRAlphaExplicit_TP $rhoInf", scheme="kr_alpha_plain_start", rho_inf=0.6),
    ),
    "AlphaOS": alpha(
        "AlphaOS",
        {"alpha": 0.9},
        header("AlphaOS", 34, "The parameter alpha corresponds to 1+alpha_{HHT}", scheme="hht_alpha", alpha=-0.1),
    ),
    "AlphaOS_update": alpha("AlphaOS", {"alpha": 0.9, "-updateElemDisp": True}, {}),
    "AlphaOS_all_arguments": alpha(
        "AlphaOS",
        {"alpha": 0.9, "beta": 0.3025, "gamma": 0.6},
        usage("AlphaOS", 54, "or AlphaOS $alpha $beta $gamma <-updateElemDisp>", **HHT, **PAIR),
    ),
    "AlphaOS_TP": alpha("AlphaOS_TP", {"alpha": 0.9}, {}),
    "AlphaOS_TP_update": alpha("AlphaOS_TP", {"alpha": 0.9, "-updateElemDisp": True}, {}),
    "AlphaOSGeneralized": family("AlphaOSGeneralized", 53, 0.6),
    "AlphaOSGeneralized_TP": family("AlphaOSGeneralized_TP", 53, 0.6),
    "Collocation": alpha("Collocation", {"theta": 1.4}, usage("Collocation", 54, "want Collocation $theta")),
    "Collocation_all_arguments": alpha(
        "Collocation",
        {"theta": 1.4, "beta": 1 / 6, "gamma": 0.5},
        usage("Collocation", 55, "or Collocation $theta $beta $gamma", scheme="collocation", beta=1 / 6, gamma=0.5),
    ),
    "WilsonTheta": alpha(
        "WilsonTheta",
        {"theta": 1.4},
        header("WilsonTheta", 34, OWN_FORM.format("WilsonTheta"), scheme="wilson_theta", theta=1.4),
    ),
    "TRBDF2": Integrator(
        sets="uva",
        load="series",
        calls=2,
        claims=documented(
            "trbdf2",
            "a composite scheme that alternates between the Trapezoidal scheme and a 3 point backward Euler scheme",
            scheme="bathe",
        ),
    ),
    "TRBDF3": Integrator(
        sets="uva",
        load="series",
        calls=3,
        claims=header("TRBDF3", 33, "using the so-called TRBDF3 integration scheme", scheme="trbdf3"),
    ),
    "BackwardEuler": Integrator(
        arguments={"option": 0},
        sets="uva",
        load="series",
        claims=header("BackwardEuler", 33, "using 2 or 3 point backward Euler scheme", scheme="bdf2"),
    ),
    "BackwardEuler_1": Integrator(
        arguments={"option": 1},
        sets="uva",
        load="series",
        claims=header(
            "BackwardEuler", 37, "optn 1 ref: T.Liu, C.Zhao, Q.Li, and L.Zhang.", scheme="liu_backward_euler"
        ),
    ),
    "Houbolt": Integrator(
        sets="uva",
        load="series",
        claims=header(
            "Houbolt",
            36,
            "It is 2nd order accurate and unconditionally stable",
            scheme="houbolt",
            order=2,
            unconditional=True,
        ),
    ),
    "NewmarkExplicit": alpha(
        "NewmarkExplicit",
        {"gamma": 0.5},
        header("NewmarkExplicit", 35, EXPLICIT_NEWMARK, scheme="newmark", beta=0.0, gamma=0.5),
    ),
    "NewmarkExplicit_damped": alpha(
        "NewmarkExplicit",
        {"gamma": 0.6},
        header("NewmarkExplicit", 35, EXPLICIT_NEWMARK, scheme="newmark", beta=0.0, gamma=0.6),
    ),
    "CentralDifference": Integrator(
        claims=documented(
            "centralDifference",
            "For stability, dt / T_n < 1 / pi",
            scheme="central_difference",
            critical_Omega=2.0,
        ),
    ),
    "CentralDifferenceAlternative": Integrator(
        outputs="uv",
        late={"v": -0.5},
        claims=header(
            "CentralDifferenceAlternative",
            34,
            "using the alternative form of the Central Difference integration scheme",
            scheme="central_difference_lagged",
        ),
    ),
    "CentralDifferenceNoDamping": Integrator(
        outputs="u",
        load="series",
        damping=False,
        claims=header(
            "CentralDifferenceNoDamping",
            34,
            "using the Central Difference Scheme as implemented in Dyna",
            scheme="central_difference_lagged",
        ),
    ),
    "ExplicitDifference": Integrator(
        sets="uva",
        load="series",
        claims={
            "scheme": ("central_difference_lagged", "Explicit Difference", MANUAL.format("ExplicitDifference")),
            "critical_Omega": (
                2.0,
                "For stability dt <= (sqrt(xi^2 + 1) - xi) 2 / omega",
                MANUAL.format("ExplicitDifference"),
            ),
        },
    ),
    "NewmarkHSFixedNumIter": alpha(
        "NewmarkHSFixedNumIter",
        {"gamma": 0.5, "beta": 0.25, "-polyOrder": 2},
        header("NewmarkHSFixedNumIter", 34, "using the Newmark integration scheme", scheme="newmark"),
    ),
    "NewmarkHSIncrReduct": alpha(
        "NewmarkHSIncrReduct",
        {"gamma": 0.5, "beta": 0.25, "reduct": 0.5},
        header("NewmarkHSIncrReduct", 34, "using the Newmark integration scheme", scheme="newmark"),
    ),
    "NewmarkHSIncrLimit": alpha(
        "NewmarkHSIncrLimit",
        {"gamma": 0.5, "beta": 0.25, "limit": 1e9},
        header("NewmarkHSIncrLimit", 34, "using the Newmark integration scheme", scheme="newmark"),
    ),
    "HHTHSFixedNumIter": alpha("HHTHSFixedNumIter", {"rhoInf": 0.6, "-polyOrder": 2}, {}),
    "HHTHSFixedNumIter_TP": alpha("HHTHSFixedNumIter_TP", {"rhoInf": 0.6, "-polyOrder": 2}, {}),
    "HHTHSIncrReduct": alpha("HHTHSIncrReduct", {"rhoInf": 0.6, "reduct": 0.5}, {}),
    "HHTHSIncrReduct_TP": alpha("HHTHSIncrReduct_TP", {"rhoInf": 0.6, "reduct": 0.5}, {}),
    "HHTHSIncrLimit": alpha("HHTHSIncrLimit", {"rhoInf": 0.6, "limit": 1e9}, {}),
    "HHTHSIncrLimit_TP": alpha("HHTHSIncrLimit_TP", {"rhoInf": 0.6, "limit": 1e9}, {}),
    "CollocationHSFixedNumIter": alpha("CollocationHSFixedNumIter", {"theta": 1.4, "-polyOrder": 2}, {}),
    "CollocationHSIncrReduct": alpha("CollocationHSIncrReduct", {"theta": 1.4, "reduct": 0.5}, {}),
    "CollocationHSIncrLimit": alpha("CollocationHSIncrLimit", {"theta": 1.4, "limit": 1e9}, {}),
}
ITERATIONS = {"FixedNumIter": 5, "IncrReduct": 80, "IncrLimit": 2}


def series(load: Load) -> bool:
    """Make OpenSees's own series for a load; whether there is any."""
    if load.kind == "none" or load.amplitude == 0:
        return False
    if load.kind == "constant":
        ops.timeSeries("Constant", 1, "-factor", load.amplitude)
    elif load.kind == "ramp":
        ops.timeSeries("Linear", 1, "-factor", load.amplitude)
    else:
        period = 2 * math.pi / load.omega
        ops.timeSeries("Trig", 1, 0.0, 1e300, period, "-shift", load.phase, "-factor", load.amplitude)
    return True


def model(omega: float, xi: float, u0: float, v0: float, a0: float | None, load: Load) -> None:
    """The oscillator at t = 0 under its load there.

    An element knows a displacement only after an analysis, so a static one with that displacement prescribed comes
    first: integrators that weight the forces at both ends of a step want those at the start.
    """
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.node(1, 0.0)
    ops.node(2, 0.0, "-mass", 1.0)
    ops.fix(1, 1)
    ops.uniaxialMaterial("Elastic", 1, omega**2)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    ops.rayleigh(2 * xi * omega, 0.0, 0.0, 0.0)
    if series(load):
        ops.pattern("Plain", 1, 1)
        ops.load(2, 1.0)
    ops.timeSeries("Constant", 2)
    ops.pattern("Plain", 2, 2)
    ops.sp(2, 1, float(u0))
    ops.constraints("Lagrange")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator("LoadControl", 0.0)
    ops.analysis("Static")
    if ops.analyze(1) != 0:
        raise RuntimeError("the static analysis before the motion failed")
    ops.remove("loadPattern", 2)
    ops.wipeAnalysis()
    ops.setTime(0.0)
    ops.setNodeDisp(2, 1, float(u0), "-commit")
    ops.setNodeVel(2, 1, float(v0), "-commit")
    ops.setNodeAccel(2, 1, 0.0 if a0 is None else float(a0), "-commit")


def analysis(integrator: str, arguments: dict[str, Any]) -> None:
    """A transient analysis: one linear solution a step, or the fixed number of iterations that hybrid tests want."""
    kind = integrator.split("_", maxsplit=1)[0] + "_TP" * ("_TP" in integrator)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    iterations = next((n for part, n in ITERATIONS.items() if part in kind), 0)
    if iterations:
        ops.test("FixedNumIter", iterations, 0)
        ops.algorithm("Newton")
    else:
        ops.algorithm("Linear")
    values: list[Any] = []
    for name, value in arguments.items():
        if name.startswith("-"):
            values.append(name)
        if value is not True:
            values.append(value)
    ops.integrator(kind, *values)
    ops.analysis("Transient")


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    """Histories of the free node after every call of analyze."""
    model(omega, xi, u0, v0, a0, load)
    analysis(integrator, arguments)
    rows = [(ops.nodeDisp(2, 1), ops.nodeVel(2, 1), ops.nodeAccel(2, 1))]
    for i in range(n):
        if ops.analyze(1, dt) != 0:
            raise RuntimeError(f"analyze failed in step {i + 1}")
        rows.append((ops.nodeDisp(2, 1), ops.nodeVel(2, 1), ops.nodeAccel(2, 1)))
    outputs = INTEGRATORS[integrator].outputs if integrator in INTEGRATORS else "uva"
    return tuple(list(y) if name in outputs else None for name, y in zip("uva", zip(*rows, strict=True), strict=True))


if __name__ == "__main__":
    LICENCE = "OpenSees licence (free for research, education and internal use)"
    serve("OpenSeesPy", version("openseespy"), LICENCE, INTEGRATORS, run)
