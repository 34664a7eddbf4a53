"""Motions in angles, driven and self-excited oscillators: the mass or the forces depend on position, rates and time.

Angles are measured from the lowest position, the cart's pole from the highest; the gravity g is in m/s^2.
"""

from sympy import Abs, Add, Expr, Integer, Rational, Symbol, cos, pi, sin

from ..parameter import NOT_NEGATIVE, REAL, Parameter
from ..scene import Scene, optional
from ..symbols import rate, t

q, r, x, theta, theta1, theta2 = (Symbol(name) for name in ("q", "r", "x", "theta", "theta1", "theta2"))
m, m1, m2, L, L1, L2, R, g, k, c = (Symbol(name) for name in ("m", "m1", "m2", "L", "L1", "L2", "R", "g", "k", "c"))
omega_d, amplitude, spin, mu, q0, v0 = (Symbol(name) for name in ("omega_d", "amplitude", "spin", "mu", "q0", "v0"))
_gravity = optional(g, Rational("9.81"), NOT_NEGATIVE)


def _starts(**defaults: Expr | int) -> tuple[Parameter, ...]:
    """Parameters of the start, of any sign."""
    return tuple(optional(Symbol(name), value, REAL) for name, value in defaults.items())


_ends = _starts(theta1_0=pi / 2, theta2_0=pi / 2, spin1_0=0, spin2_0=0)

double_pendulum = Scene(
    "double_pendulum",
    coordinates={theta1: "rad", theta2: "rad"},
    kinetic=(m1 + m2) * (L1 * rate(theta1)) ** 2 / 2
    + m2 * (L2 * rate(theta2)) ** 2 / 2
    + m2 * L1 * L2 * rate(theta1) * rate(theta2) * cos(theta1 - theta2),
    potential=-(m1 + m2) * g * L1 * cos(theta1) - m2 * g * L2 * cos(theta2),
    parameters=(*(optional(s, 1) for s in (m1, m2, L1, L2)), _gravity, *_ends),
    start=dict(zip((theta1, theta2, rate(theta1), rate(theta2)), (p.symbol for p in _ends), strict=True)),
    length=1,
    energy_scale=(m1 + m2) * g * L1,
    reference="two point masses on two rods, both horizontal and at rest at the start",
)

_r0, _theta0 = _starts(r_0=Rational(6, 5), theta_0=Rational(1, 2))

spring_pendulum = Scene(
    "spring_pendulum",
    coordinates={r: "m", theta: "rad"},
    kinetic=m * (rate(r) ** 2 + (r * rate(theta)) ** 2) / 2,
    potential=k * (r - L) ** 2 / 2 - m * g * r * cos(theta),
    parameters=(optional(m, 1), optional(k, 40), optional(L, 1), _gravity, _r0, _theta0),
    start={r: _r0.symbol, theta: _theta0.symbol, rate(r): 0, rate(theta): 0},
    length=L,
    reference="a mass on a spring that swings, in polar coordinates; Nayfeh & Mook, Nonlinear Oscillations (1979), 6.2",
)

_theta0 = optional(Symbol("theta_0"), Rational(1, 10), REAL)

rotating_hoop = Scene(
    "rotating_hoop",
    coordinates={theta: "rad"},
    kinetic=m * R**2 * (rate(theta) ** 2 + (spin * sin(theta)) ** 2) / 2,
    potential=m * g * R * (1 - cos(theta)),
    dissipation=c * rate(theta) ** 2 / 2,
    parameters=(
        optional(m, 1),
        optional(R, 1),
        optional(spin, 5, REAL),
        optional(c, 0, NOT_NEGATIVE),
        _gravity,
        _theta0,
    ),
    start={theta: _theta0.symbol, rate(theta): 0},
    length=1,
    energy_scale=m * g * R,
    reference="a bead on a hoop that turns at `spin` about its vertical diameter; beyond sqrt(g/R) it leaves the "
    "bottom: Strogatz, Nonlinear Dynamics and Chaos (1994), 3.5",
)

_gains = _starts(gain_x=0, gain_v=0, gain_angle=0, gain_spin=0)
_tilt = optional(Symbol("theta_0"), Rational(1, 10), REAL)

cart_pole = Scene(
    "cart_pole",
    coordinates={x: "m", theta: "rad"},
    kinetic=(m1 + m2) * rate(x) ** 2 / 2
    + m2 * (L * rate(theta)) ** 2 / 2
    + m2 * L * rate(x) * rate(theta) * cos(theta),
    potential=m2 * g * L * cos(theta),
    forces={x: Add(*(p.symbol * s for p, s in zip(_gains, (x, rate(x), theta, rate(theta)), strict=True)))},
    parameters=(optional(m1, 1), optional(m2, Rational(1, 10)), optional(L, Rational(1, 2)), _gravity, *_gains, _tilt),
    start={x: 0, theta: _tilt.symbol, rate(x): 0, rate(theta): 0},
    length=L,
    energy_scale=m2 * g * L,
    reference="a cart m1 with a pole that stands on it, a point mass m2 at the length L, under a feedback of the "
    "state: Barto, Sutton & Anderson, IEEE Trans. Syst. Man Cybern. 13 (1983) 834-846",
)

phi, psi, _I1, _I3, _mgl = (Symbol(name) for name in ("phi", "psi", "I1", "I3", "mgl"))
_start = _starts(theta_0=Rational(2, 5), spin_0=30, precession_0=0)

heavy_top = Scene(
    "heavy_top",
    coordinates={phi: "rad", theta: "rad", psi: "rad"},
    kinetic=_I1 * (rate(theta) ** 2 + (rate(phi) * sin(theta)) ** 2) / 2
    + _I3 * (rate(psi) + rate(phi) * cos(theta)) ** 2 / 2,
    potential=_mgl * cos(theta),
    parameters=(optional(_I1, 1), optional(_I3, Rational(1, 2)), optional(_mgl, 10), *_start),
    start=dict(zip((theta, rate(psi), rate(phi)), (p.symbol for p in _start), strict=True))
    | {phi: 0, psi: 0, rate(theta): 0},
    length=1,
    reference="a symmetric top with a fixed point in Euler's angles: precession phi, nutation theta, spin psi; "
    "Goldstein, Classical Mechanics (1980), 5.7",
)

_g_over_L = Symbol("g_over_L")
_upright = optional(q0, pi - Rational(1, 10), REAL)

kapitza = Scene(
    "kapitza",
    coordinates={q: "rad"},
    kinetic=rate(q) ** 2 / 2,
    potential=-(_g_over_L - amplitude * omega_d**2 * cos(omega_d * t)) * cos(q),
    parameters=(optional(_g_over_L, 1), optional(amplitude, Rational(1, 20), REAL), optional(omega_d, 20), _upright),
    start={q: q0, rate(q): 0},
    length=1,
    reference="a pendulum whose pivot is shaken vertically, amplitude*L*cos(omega_d*t), and that stands upright where "
    "amplitude*omega_d > sqrt(2*g/L): Kapitza, Sov. Phys. JETP 21 (1951) 588-597",
)

van_der_pol = Scene(
    "van_der_pol",
    coordinates={q: "m"},
    kinetic=rate(q) ** 2 / 2,
    potential=q**2 / 2,
    forces={q: mu * (1 - q**2) * rate(q)},
    parameters=(optional(mu, 1, NOT_NEGATIVE), optional(q0, 2, REAL), optional(v0, 0, REAL)),
    start={q: q0, rate(q): v0},
    length=1,
    energy_scale=Integer(2),
    reference="van der Pol, Phil. Mag. 2 (1926) 978-992; on its limit cycle |q| reaches about 2",
)

quadratic_drag = Scene(
    "quadratic_drag",
    coordinates={q: "m"},
    kinetic=rate(q) ** 2 / 2,
    potential=k * q**2 / 2,
    dissipation=c * Abs(rate(q)) ** 3 / 3,
    parameters=(
        optional(k, 1),
        optional(c, Rational(1, 10), NOT_NEGATIVE),
        optional(q0, 1, REAL),
        optional(v0, 0, REAL),
    ),
    start={q: q0, rate(q): v0},
    length=1,
    reference="an oscillator in a fluid, q'' + c |q'| q' + k q = 0, per unit mass",
)

_k3 = Symbol("k3")

driven_duffing = Scene(
    "driven_duffing",
    coordinates={q: "m"},
    kinetic=rate(q) ** 2 / 2,
    potential=k * q**2 / 2 + _k3 * q**4 / 4,
    dissipation=c * rate(q) ** 2 / 2,
    load={q: amplitude * cos(omega_d * t)},
    parameters=(
        optional(k, -1, REAL),
        optional(_k3, 1),
        optional(c, Rational(3, 10), NOT_NEGATIVE),
        optional(amplitude, Rational(1, 2), REAL),
        optional(omega_d, Rational(6, 5)),
        optional(q0, 1, REAL),
        optional(v0, 0, REAL),
    ),
    start={q: q0, rate(q): v0},
    length=1,
    energy_scale=Integer(1),
    reference="a buckled beam under a periodic load, q'' + c q' + k q + k3 q^3 = amplitude*cos(omega_d*t), chaotic at "
    "the defaults: Holmes, Phil. Trans. R. Soc. A 292 (1979) 419-448",
)

ALL = (
    double_pendulum,
    spring_pendulum,
    rotating_hoop,
    cart_pole,
    heavy_top,
    kapitza,
    van_der_pol,
    quadratic_drag,
    driven_duffing,
)
