"""Multi-step schemes: the state holds earlier steps, and each says how it starts."""

from sympy import Expr, Integer, Interval, Rational, binomial, oo

from ..parameter import Parameter
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import C, K_t, M, alpha_g, delta, f, h, knot, rho_inf
from .diagonally_implicit import esdirk43
from .newmark import average_acceleration

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
um, vm, am = knot(-1)
umm, vmm, amm = knot(-2)
half = Rational(1, 2)

houbolt = Scheme(
    "houbolt",
    relations={
        a1: (2 * u1 - 5 * u0 + 4 * um - umm) / h**2,
        v1: (11 * u1 - 18 * u0 + 9 * um - 2 * umm) / (6 * h),
    },
    balances=(Balance.at(end, 1),),
    start=average_acceleration,
    reference="Houbolt, J. Aeronaut. Sci. 17 (1950) 540-550",
    published=Published("Hughes, The Finite Element Method (1987), ch. 9", 2, 0, oo),
)

park = Scheme(
    "park",
    relations={
        v1: (10 * u1 - 15 * u0 + 6 * um - umm) / (6 * h),
        a1: (10 * v1 - 15 * v0 + 6 * vm - vmm) / (6 * h),
    },
    balances=(Balance.at(end, 1),),
    start=average_acceleration,
    reference="Park, J. Appl. Mech. 42 (1975) 464-470",
    published=Published("Park (1975)", 2, 0, oo),
)

_j = (a1 - am) / (2 * h)
_s = (a1 + am - 2 * a0) / h**2


def gholampour_with(slope: Expr, name: str, reference: str) -> Scheme:
    """Gholampour's scheme with v1 = ... + slope*h^3*s: delta, or delta/6 as thesis (2.54) prints it."""
    return Scheme(
        name,
        parameters=(
            Parameter(delta, Interval(0, 2), half),
            Parameter(alpha_g, Interval(0, 2), delta / 2),
        ),
        relations={
            u1: u0 + h * v0 + h**2 / 2 * a0 + h**3 / 6 * _j + alpha_g * h**4 * _s,
            v1: v0 + h * a0 + h**2 / 2 * _j + slope * h**3 * _s,
        },
        balances=(Balance.at(end, 1),),
        # a[-1] = a0 - h*(rate of a0), from the equation of motion and its derivative
        start={am: a0 - (f(1) - f(0) - h * C * a0 - h * K_t(u0) * v0) / M},
        reference=reference,
    )


gholampour = gholampour_with(
    delta, "gholampour", "Gholampour, Ghassemieh & Karimi-Rad, KSCE J. Civ. Eng. 17 (2013); thesis (2.53)-(2.57)"
)

_A1 = (4 * rho_inf - 4) / (3 - rho_inf)
_A2 = -1 - _A1
_B0 = 2 / ((1 + rho_inf) * (3 - rho_inf))
_B1 = 2 - 2 * _B0 + _A1 / 2
_B2 = _A1 / 2 + _B0

oalts = Scheme(
    "oalts",
    parameters=(Parameter(rho_inf, Interval(0, 1), half),),
    relations={
        u1: -_A1 * u0 - _A2 * um + h * (_B0 * v1 + _B1 * v0 + _B2 * vm),
        v1: -_A1 * v0 - _A2 * vm + h * (_B0 * a1 + _B1 * a0 + _B2 * am),
    },
    balances=(Balance.at(end, 1),),
    start=average_acceleration,
    reference="Zhang & Xing, Int. J. Numer. Methods Eng. 118 (2019); optimal A-stable linear two-step",
    published=Published("Zhang & Xing (2019)", 2, rho_inf, oo),
)


def backward_differences(order: int, start: Scheme, published: Published) -> Scheme:
    """The backward differentiation formula of that order, for v and for a."""

    def rate(kind: str) -> Expr:
        """Sum of the backward differences, each over its order."""
        values = [getattr(knot(1 - steps), kind) for steps in range(order + 1)]
        terms = (Rational((-1) ** i * binomial(j, i), j) * values[i] for j in range(1, order + 1) for i in range(j + 1))
        return sum(terms, Integer(0))

    return Scheme(
        f"bdf{order}",
        relations={v1: rate("u") / h, a1: rate("v") / h},
        balances=(Balance.at(end, 1),),
        start=start,
        reference="Gear, Numerical Initial Value Problems (1971), ch. 11",
        published=published,
    )


bdf2 = backward_differences(2, average_acceleration, Published("Gear (1971), ch. 11", 2, 0, oo)).known_as("gear")
bdf3 = backward_differences(3, average_acceleration, Published("Gear (1971), ch. 11", 3, 0)).known_as("gear")
bdf4 = backward_differences(4, esdirk43, Published("Gear (1971), ch. 11", 4, 0)).known_as("gear")

ALL = (houbolt, park, gholampour, oalts, bdf2, bdf3, bdf4)
