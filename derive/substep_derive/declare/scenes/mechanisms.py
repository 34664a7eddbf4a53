"""Mechanisms in relative coordinates: bodies whose mass matrix moves with them, joined by constraints."""

from sympy import Add, Rational, Symbol, cos, sin, sqrt

from ..scene import Scene
from ..symbols import rate


def _numbers(**values: str) -> tuple[Rational, ...]:
    """Decimals as they are published, exact."""
    return tuple(map(Rational, values.values()))


phi1, phi2, x3 = (Symbol(name) for name in ("phi1", "phi2", "x3"))
M1, M2, M3, L1, L2, J1, J2 = _numbers(
    M1="0.36", M2="0.151104", M3="0.075552", L1="0.15", L2="0.30", J1="0.002727", J2="0.0045339259"
)

slider_crank = Scene(
    "slider_crank",
    coordinates={phi1: "rad", phi2: "rad", x3: "m"},
    kinetic=((J1 + M2 * L1**2) * rate(phi1) ** 2 + J2 * rate(phi2) ** 2 + M3 * rate(x3) ** 2) / 2
    + L1 * L2 * M2 * cos(phi1 - phi2) / 2 * rate(phi1) * rate(phi2),
    potential=0 * phi1,
    constraints={"pin": L1 * sin(phi1) + L2 * sin(phi2), "slot": x3 - L1 * cos(phi1) - L2 * cos(phi2)},
    parameters=(),
    start={phi1: 0, phi2: 0, x3: L1 + L2, rate(phi1): 150, rate(phi2): -75, rate(x3): 0},
    length=1,
    reference="Simeon, Mech. Struct. Mach. 24 (1996) 1-18, its bodies rigid: crank, rod and block",
)

beta, theta, gamma, phi, delta, omega, epsilon = Q = tuple(
    Symbol(name) for name in ("beta", "theta", "gamma", "phi", "delta", "omega", "epsilon")
)
m1, m2, m3, m4, m5, m6, m7 = _numbers(
    m1="0.04325", m2="0.00365", m3="0.02373", m4="0.00706", m5="0.07050", m6="0.00706", m7="0.05498"
)
i1, i2, i3, i4, i5, i6, i7 = _numbers(
    i1="2.194e-6", i2="4.410e-7", i3="5.255e-6", i4="5.667e-7", i5="1.169e-5", i6="5.667e-7", i7="1.912e-5"
)
xa, ya, xb, yb, xc, yc, c0, l0 = _numbers(
    xa="-0.06934", ya="-0.00227", xb="-0.03635", yb="0.03273", xc="0.014", yc="0.072", c0="4530", l0="0.07785"
)
d, da, e, ea, rr, ra, ss, sa, sb, sc, sd = _numbers(
    d="0.028", da="0.0115", e="0.02", ea="0.01421", rr="0.007", ra="0.00092",
    ss="0.035", sa="0.01874", sb="0.01043", sc="0.018", sd="0.02",
)  # fmt: skip
ta, tb, u, ua, ub, zf, zt, fa, mom = _numbers(
    ta="0.02308", tb="0.00916", u="0.04", ua="0.01228", ub="0.00449", zf="0.02", zt="0.04", fa="0.01421", mom="0.033"
)
_mass = {
    (0, 0): m1 * ra**2 + m2 * (rr**2 - 2 * da * rr * cos(theta) + da**2) + i1 + i2,
    (1, 0): m2 * (da**2 - da * rr * cos(theta)) + i2,
    (1, 1): m2 * da**2 + i2,
    (2, 2): m3 * (sa**2 + sb**2) + i3,
    (3, 3): m4 * (e - ea) ** 2 + i4,
    (4, 3): m4 * ((e - ea) ** 2 + zt * (e - ea) * sin(phi)) + i4,
    (4, 4): m4 * (zt**2 + 2 * zt * (e - ea) * sin(phi) + (e - ea) ** 2) + m5 * (ta**2 + tb**2) + i4 + i5,
    (5, 5): m6 * (zf - fa) ** 2 + i6,
    (6, 5): m6 * ((zf - fa) ** 2 - u * (zf - fa) * sin(omega)) + i6,
    (6, 6): m6 * ((zf - fa) ** 2 - 2 * u * (zf - fa) * sin(omega) + u**2) + m7 * (ua**2 + ub**2) + i6 + i7,
}
_spring = sqrt((sd * cos(gamma) + sc * sin(gamma) + xb - xc) ** 2 + (sd * sin(gamma) - sc * cos(gamma) + yb - yc) ** 2)
_x, _y = (rr * f(beta) - d * f(beta + theta) for f in (cos, sin))

squeezer = Scene(
    "squeezer",
    coordinates=dict.fromkeys(Q, "rad"),
    kinetic=Add(*(x * rate(Q[i]) * rate(Q[j]) / (2 if i == j else 1) for (i, j), x in _mass.items())),
    potential=c0 * (_spring - l0) ** 2 / 2 - mom * beta,
    constraints={
        "x_of_3": _x - ss * sin(gamma) - xb,
        "y_of_3": _y + ss * cos(gamma) - yb,
        "x_of_5": _x - e * sin(phi + delta) - zt * cos(delta) - xa,
        "y_of_5": _y + e * cos(phi + delta) - zt * sin(delta) - ya,
        "x_of_7": _x - zf * cos(omega + epsilon) - u * sin(epsilon) - xa,
        "y_of_7": _y - zf * sin(omega + epsilon) + u * cos(epsilon) - ya,
    },
    parameters=(),
    start={
        beta: Rational("-0.0617138900142764496358948458001"),
        theta: 0,
        gamma: Rational("0.455279819163070380255912382449"),
        phi: Rational("0.222668390165885884674473185609"),
        delta: Rational("0.487364979543842550225598953530"),
        omega: Rational("-0.222668390165885884674473185609"),
        epsilon: Rational("1.23054744454982119249735015568"),
        **{rate(q): 0 for q in Q},
    },
    length=1,
    energy_scale=c0 * l0**2 / 2,
    reference="Andrews' squeezing mechanism: seven bodies in a plane; Test Set for IVP Solvers, II-18",
)

ALL = (slider_crank, squeezer)
