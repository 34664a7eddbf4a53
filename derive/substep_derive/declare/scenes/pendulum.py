"""The pendulums: an elastic bar, the same bar taken as rigid, and the one that gravity swings."""

from sympy import Expr, Rational, Symbol, cos, sqrt

from ..parameter import REAL
from ..scene import Scene, optional, required
from ..symbols import acceleration, rate

x, y, s = (Symbol(name) for name in ("x", "y", "s"))
EA, L, m, v0, u0 = (Symbol(name) for name in ("EA", "L", "m", "v0", "u0"))

_length = optional(L, Rational("3.0443"))
_mass = optional(m, 10)
_speed = optional(v0, Rational("7.72"), REAL)


def elastic(name: str, strain: Expr, reference: str) -> Scene:
    """A pinned bar along x with its mass lumped at the free end, which starts along y."""
    return Scene(
        name,
        coordinates={x: "m", y: "m"},
        kinetic=m * (rate(x) ** 2 + rate(y) ** 2) / 2,
        invariants={s: x**2 + y**2},
        potential=EA * L * strain**2 / 2,
        parameters=(required(EA), _length, _mass, _speed),
        start={x: L, y: 0, rate(x): 0, rate(y): v0, acceleration(x): 0, acceleration(y): 0},
        length=L,
        outputs={"strain": strain},
        reference=reference,
    )


elastic_pendulum = elastic(
    "elastic_pendulum",
    (s - L**2) / (2 * L**2),
    "Kuhl & Crisfield, Int. J. Numer. Methods Eng. 45 (1999) 569-599; thesis, chapter 5; Green-Lagrange strain",
)
elastic_pendulum_engineering = elastic(
    "elastic_pendulum_engineering",
    (sqrt(s) - L) / L,
    "as elastic_pendulum, with engineering strain",
)

theta, phi = Symbol("theta"), Symbol("phi")

rigid_pendulum = Scene(
    "rigid_pendulum",
    coordinates={theta: "rad"},
    kinetic=m * L**2 * rate(theta) ** 2 / 2,
    potential=0 * theta,
    parameters=(_length, _mass, _speed),
    start={theta: 0, rate(theta): v0 / L},
    length=1,
    reference="the elastic pendulum in the limit of a stiff bar: uniform rotation",
)

g_over_L = Symbol("g_over_L")

simple_pendulum = Scene(
    "simple_pendulum",
    coordinates={phi: "rad"},
    kinetic=rate(phi) ** 2 / 2,
    potential=g_over_L * (1 - cos(phi)),
    parameters=(
        optional(g_over_L, 1),
        optional(u0, 0, REAL),
        optional(v0, Rational("1.999999238456499"), REAL),
    ),
    start={phi: u0, rate(phi): v0},
    length=1,
    energy_scale=2 * g_over_L,
    reference="a swing that almost reaches the top; per unit of m L^2",
)

ALL = (elastic_pendulum, elastic_pendulum_engineering, rigid_pendulum, simple_pendulum)
