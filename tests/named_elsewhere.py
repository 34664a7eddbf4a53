"""Schemes that docs/findings.md judges and the catalogue does not have, declared as their papers have them."""

from itertools import pairwise

from substep_derive import Balance, Parameter, Scheme, h, knot
from substep_derive.declare.parameter import Root
from substep_derive.declare.symbols import M, N, alpha, f, gamma, rho_inf
from sympy import Expr, Integer, Interval, Matrix, Rational, Symbol, cancel, factorial

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)


def mssth_weights(n: int) -> list[Expr]:
    """Weights of the rates at t_n and after trapezoids over gamma h, by which R is exp up to z^n (Zhang and others)."""
    z = Symbol("z")
    ratio = [((1 + gamma * z / 2) ** k * (1 - gamma * z / 2) ** (n - 1 - k)).expand() for k in range(n)]
    exponential = sum(z**k / factorial(k) for k in range(n + 1))
    right = ((exponential * (1 - gamma * z / 2) - 1).expand() / z * (1 - gamma * z / 2) ** (n - 1)).expand()
    system = Matrix(n, n, lambda k, j: ratio[j].coeff(z, k))
    return [cancel(w) for w in system.LUsolve(Matrix([right.coeff(z, k) for k in range(n)]))]


def mssth(n: int, equation: Expr, low: str, high: str) -> Scheme:
    weights, relations = mssth_weights(n), dict[Symbol, Expr]()
    places = (knot(0), *(knot(f"x{k}") for k in range(1, n)))
    for x, y in pairwise(places):
        relations |= {y.u: x.u + gamma * h / 2 * (x.v + y.v), y.v: x.v + gamma * h / 2 * (x.a + y.a)}
    relations[u1] = u0 + h * (sum(w * x.v for w, x in zip(weights, places, strict=True)) + gamma / 2 * v1)
    relations[v1] = v0 + h * (sum(w * x.a for w, x in zip(weights, places, strict=True)) + gamma / 2 * a1)
    return Scheme(
        f"mssth{n}",
        parameters=(
            Parameter(rho_inf, Interval(0, 1), half),
            Parameter(gamma, Interval(Rational(low), Rational(high)), Root(equation)),
        ),
        relations=relations,
        balances=(*(Balance.at(x, k * gamma) for k, x in enumerate(places[1:], 1)), Balance.at(end, 1)),
    )


MSSTH = {
    3: mssth(3, 3 * (1 - rho_inf) * gamma**3 - 18 * gamma**2 + 18 * gamma - 4, "0.66", "0.88"),
    4: mssth(4, 3 * (1 - rho_inf) * gamma**4 - 24 * gamma**3 + 36 * gamma**2 - 16 * gamma + 2, "0.78", "1.15"),
    5: mssth(
        5,
        15 * (1 + rho_inf) * gamma**5 - 150 * gamma**4 + 300 * gamma**3 - 200 * gamma**2 + 50 * gamma - 4,
        *("0.49", "0.56"),
    ),
}


def pefrl() -> Scheme:
    """Omelyan, Mryglod and Folk (2002): drifts and kicks, without damping; one number is free, the other a root."""
    drift, kick = Symbol("drift"), Symbol("kick")
    equation = 48 * kick**3 * (1 - 6 * drift + 6 * drift**2) - (1 - 6 * drift) * (
        24 * kick**2 * (1 - 2 * drift) - 1 + 6 * drift
    )
    second, kicks = (1 - 6 * drift) / (24 * kick**2), (half - kick, kick, kick, half - kick)
    u, v, at, relations, balances = u0, v0, Integer(0), dict[Symbol, Expr](), list[Balance]()
    for x, way, push in zip(map(knot, "pqrs"), (drift, second, 1 - 2 * (drift + second), second), kicks, strict=True):
        u, at = u + way * h * v, at + way
        relations[x.u] = u
        balances.append(Balance(x.a, Integer(0), N(x.u), f(at)))
        v += push * h * x.a
    return Scheme(
        "pefrl",
        parameters=(
            Parameter(drift, Interval(Rational("0.17"), Rational("0.2")), Rational("0.1786178958448091")),
            Parameter(kick, Interval(-2, Rational("-0.05")), Root(equation)),
        ),
        relations={**relations, u1: u + drift * h * v, v1: v},
        balances=tuple(balances),
        report={a1: (f(1) - N(u1)) / M},
    )


def wat2() -> Scheme:
    """Wang, Adams and Tamma (2024), as suanPan's GERKN.cpp has it."""
    t, (ug, vg, ag), (uk, vk, ak) = Symbol("tau"), knot("g"), knot("k")
    E, G = 2 * t - 1, 3 * t**2 - 3 * t + 1
    r, b0, b1 = (3 * t - 2) / (3 * E), (4 * t - 1) / (12 * t), (6 * t**2 - 5 * t + 2) / (24 * t * G)
    w, e0, e1 = 2 * G / (9 * t * E**2), (1 - 3 * t) / t, (-3 * t**2 + 4 * t - 1) / (t * G)
    return Scheme(
        "wat2",
        parameters=(Parameter(t, Interval(Rational("0.3"), Rational("0.4")), Rational(1, 3)),),
        relations={
            ug: u0 + t * h * v0 + t / 6 * h**2 * a0,
            vg: v0 + t * h * a0,
            uk: u0 + r * h * v0 + h**2 * ((3 * t - 1) / (18 * t) * a0 + G / (18 * t * E**2) * ag),
            vk: v0 + h * ((r - w) * a0 + w * ag),
            u1: u0 + h * v0 + h**2 * (b0 * a0 + b1 * ag + (half - b0 - b1) * ak),
            v1: v0 + h * (ag / (4 * G) + (1 - 1 / (4 * G)) * ak),
            a1: e0 * a0 + e1 * ag + (1 - e0 - e1) * ak,
        },
        balances=(Balance.at(knot("g"), t), Balance.at(knot("k"), r)),
    )


def explicit_hht(predicted: bool = False) -> Scheme:
    """Miranda, Ferencz and Hughes (1989): Newmark's predictors in the balance of HHT-alpha.

    The old forces are those at t_n or, as some programs have it, at the predictors for t_n.
    """
    (up, vp, _), beta = knot("p"), (1 - alpha) ** 2 / 4
    old_u, old_v = (u0 - h**2 * beta * a0, v0 - h * (half - alpha) * a0) if predicted else (u0, v0)
    return Scheme(
        "explicit_hht",
        parameters=(Parameter(alpha, Interval(-Rational(1, 3), 0), -Rational(1, 10)),),
        relations={
            up: u0 + h * v0 + h**2 * (half - beta) * a0,
            vp: v0 + h * (half + alpha) * a0,
            u1: up + h**2 * beta * a1,
            v1: vp + h * (half - alpha) * a1,
        },
        balances=(
            Balance(
                a1,
                (1 + alpha) * vp - alpha * old_v,
                (1 + alpha) * N(up) - alpha * N(old_u),
                (1 + alpha) * f(1) - alpha * f(0),
            ),
        ),
    )


def discontinuous_galerkin_p2_p1(radau: bool = False) -> Scheme:
    """Hulbert (1992): displacements of degree 2, velocities of degree 1; both may jump at t_n.

    Against K the displacement's equation is met by the integral of the velocity, so that it does not jump. That of the
    velocity is taken against 1 and 2 s by Simpson's quadrature, exact for linear forces, or by Radau's of two points.
    """
    vp, um, third = knot("p").v, knot("m").u, Rational(1, 3)
    at, inner, last = (third, half, half) if radau else (half, 2 * third, third)  # an instant, weights against 2 s
    forces = (3 * N(um) + N(u1)) / 4 if radau else (N(u0) + 4 * N(um) + N(u1)) / 6
    loads = (3 * f(third) + f(1)) / 4 if radau else (f(0) + 4 * f(half) + f(1)) / 6
    return Scheme(
        "discontinuous_galerkin_p2_p1",
        relations={um: u0 + h * (at * vp + at**2 / 2 * (v1 - vp)), u1: u0 + h * (vp + v1) / 2},
        balances=(
            Balance((v1 - v0) / h, (vp + v1) / 2, forces, loads),
            Balance((v1 - vp) / h, (vp + 2 * v1) / 3, inner * N(um) + last * N(u1), inner * f(at) + last * f(1)),
        ),
    )
