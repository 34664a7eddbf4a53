"""Bodies that meet a stop, with a pressure that only pushes, and bodies that slide, with friction up to a limit."""

from sympy import Expr, Integer, Interval, Rational, Symbol, cos, sin

from ..parameter import NOT_NEGATIVE, REAL
from ..reactions import Contact, Friction
from ..scene import Scene, optional
from ..symbols import rate, t

u, w, m, k, c, g, u0, v0, b = (Symbol(name) for name in ("u", "w", "m", "k", "c", "g", "u0", "v0", "b"))
amplitude, omega_d = Symbol("amplitude"), Symbol("omega_d")
w0, mu, limit, belt, restitution = (Symbol(name) for name in ("w0", "mu", "limit", "belt", "restitution"))

mass_on_floor = Scene(
    "mass_on_floor",
    coordinates={u: "m"},
    kinetic=m * rate(u) ** 2 / 2,
    potential=m * g * u,
    contacts={"floor": u},
    parameters=(optional(m, 1), optional(u0, 1, NOT_NEGATIVE), optional(v0, -1, REAL), optional(g, 0, NOT_NEGATIVE)),
    start={u: u0, rate(u): v0},
    length=1,
    energy_scale=m,
    reference="a mass point meets a floor: how it leaves depends on the phase of the impact within the step",
)

two_masses_on_floor = Scene(
    "two_masses_on_floor",
    coordinates={u: "m", w: "m"},
    kinetic=m * (rate(u) ** 2 + rate(w) ** 2) / 2,
    potential=m * g * (u + w) + k * (w - u - b) ** 2 / 2,
    contacts={"floor": u},
    parameters=(
        optional(m, 1),
        optional(k, 1000),
        optional(b, Rational(1, 2)),
        optional(u0, Rational(1, 2), NOT_NEGATIVE),
        optional(v0, -1, REAL),
        optional(g, 0, NOT_NEGATIVE),
    ),
    start={u: u0, w: u0 + b, rate(u): v0, rate(w): v0},
    length=1,
    energy_scale=m,
    reference="two masses joined by a spring of length b, one above the other, fall on a floor: the shortest bar",
)

impact_oscillator = Scene(
    "impact_oscillator",
    coordinates={u: "m"},
    kinetic=m * rate(u) ** 2 / 2,
    potential=k * u**2 / 2,
    dissipation=c * rate(u) ** 2 / 2,
    load={u: amplitude * cos(omega_d * t)},
    contacts={"stop": Contact(b - u, restitution=restitution)},
    parameters=(
        optional(m, 1),
        optional(k, 1),
        optional(c, 0, NOT_NEGATIVE),
        optional(b, 0, REAL),
        optional(restitution, Rational(4, 5), Interval(0, 1)),
        optional(amplitude, 0, REAL),
        optional(omega_d, 2),
        optional(u0, -1, REAL),
        optional(v0, 0, REAL),
    ),
    start={u: u0, rate(u): v0},
    length=1,
    energy_scale=k,
    reference="Nordmark, J. Sound Vib. 145 (1991) 279-297: a mass on a spring with a stop at u = b, under a periodic "
    "load; grazing where it meets the stop with hardly any velocity",
)

bouncing_ball = Scene(
    "bouncing_ball",
    coordinates={u: "m"},
    kinetic=m * rate(u) ** 2 / 2,
    potential=m * g * u,
    contacts={"floor": Contact(u, restitution=restitution)},
    parameters=(
        optional(m, 1),
        optional(g, Rational("9.81")),
        optional(u0, 1, NOT_NEGATIVE),
        optional(restitution, Rational(1, 2), Interval(0, 1)),
    ),
    start={u: u0, rate(u): 0},
    length=1,
    energy_scale=m,
    reference="a ball that leaves the floor with a share of the velocity with which it meets it",
)

friction_oscillator = Scene(
    "friction_oscillator",
    coordinates={u: "m"},
    kinetic=m * rate(u) ** 2 / 2,
    potential=k * u**2 / 2,
    frictions={"pad": Friction(u - belt * t, limit)},
    parameters=(
        optional(m, 1),
        optional(k, 1),
        optional(limit, Rational(1, 10), NOT_NEGATIVE),
        optional(belt, 0, REAL),
        optional(u0, Rational("1.05"), REAL),
        optional(v0, 0, REAL),
    ),
    start={u: u0, rate(u): v0},
    length=1,
    energy_scale=k,
    reference="a block on a spring, held by friction up to a limit, N, on a ground that moves with the velocity `belt`",
)

sliding_block = Scene(
    "sliding_block",
    coordinates={u: "m", w: "m"},
    kinetic=m * (rate(u) ** 2 + rate(w) ** 2) / 2,
    potential=m * g * w,
    contacts={"floor": w},
    frictions={"drag": Friction(u, mu * Symbol("floor"))},
    parameters=(
        optional(m, 1),
        optional(g, Rational("9.81")),
        optional(mu, Rational(3, 10), NOT_NEGATIVE),
        optional(v0, 3, REAL),
        optional(w0, 0, NOT_NEGATIVE),
    ),
    start={u: 0, w: w0, rate(u): v0, rate(w): 0},
    length=1,
    energy_scale=m,
    reference="a block thrown along a floor, on which it slides with the coefficient of friction mu until it rests",
)

x, y, phi, phi0, L = (Symbol(name) for name in ("x", "y", "phi", "phi0", "L"))

pendulum_at_wall = Scene(
    "pendulum_at_wall",
    coordinates={phi: "rad"},
    kinetic=m * L**2 * rate(phi) ** 2 / 2,
    potential=-m * g * L * cos(phi),
    contacts={"wall": Contact(b + L * sin(phi), restitution=restitution)},
    parameters=(
        optional(m, 1),
        optional(L, 1),
        optional(g, Rational("9.81")),
        optional(b, 0, REAL),
        optional(restitution, Rational(1, 2), Interval(0, 1)),
        optional(phi0, 1, REAL),
    ),
    start={phi: phi0, rate(phi): 0},
    length=1,
    energy_scale=m * g * L,
    reference="a pendulum on a rod, let go at phi0, meets a wall at the distance b beyond the vertical",
)


def _corner(side: int) -> tuple[Expr, Expr]:
    """Where the block's left (-1) or right (1) lower corner is."""
    return x + side * b * cos(phi) + c * sin(phi), y + side * b * sin(phi) - c * cos(phi)


rocking_block = Scene(
    "rocking_block",
    coordinates={x: "m", y: "m", phi: "rad"},
    kinetic=m * (rate(x) ** 2 + rate(y) ** 2 + (b**2 + c**2) / 3 * rate(phi) ** 2) / 2,
    potential=m * g * y,
    contacts={name: Contact(_corner(side)[1], restitution=Integer(0)) for name, side in (("left", -1), ("right", 1))},
    frictions={
        f"{name}_drag": Friction(_corner(side)[0], mu * Symbol(name)) for name, side in (("left", -1), ("right", 1))
    },
    parameters=(
        optional(m, 1),
        optional(g, Rational("9.81")),
        optional(b, Rational(1, 4)),
        optional(c, 1),
        optional(mu, 1, NOT_NEGATIVE),
        optional(phi0, Rational(1, 10), NOT_NEGATIVE),
    ),
    start={
        x: b * cos(phi0) - c * sin(phi0) - b,
        y: b * sin(phi0) + c * cos(phi0),
        phi: phi0,
        rate(x): 0,
        rate(y): 0,
        rate(phi): 0,
    },
    length=c,
    energy_scale=m,
    reference="Housner 1963, Bull. Seism. Soc. Am. 53: a block of 2b x 2c let go at phi0, which rocks on its corners",
)

ALL = (
    mass_on_floor,
    two_masses_on_floor,
    impact_oscillator,
    bouncing_ball,
    friction_oscillator,
    sliding_block,
    pendulum_at_wall,
    rocking_block,
)
