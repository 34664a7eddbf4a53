"""What S. Kumar's thesis prints, as it is printed, so that derivation can confirm or refute it."""

from fractions import Fraction

from substep_derive.algebra.algebraic import Algebraic
from substep_derive.declare.errors import InconsistentScheme
from substep_derive.declare.scheme import Balance, Scheme
from substep_derive.declare.schemes.alpha import generalized_alpha, hht_alpha, wbz_alpha
from substep_derive.declare.schemes.composite import silva_bezerra
from substep_derive.declare.schemes.explicit import rk4
from substep_derive.declare.schemes.multi_step import gholampour, gholampour_with
from substep_derive.declare.schemes.one_step import wilson_theta
from substep_derive.declare.symbols import (
    N,
    Omega,
    alpha,
    alpha_B,
    alpha_f,
    alpha_g,
    alpha_m,
    beta,
    delta,
    f,
    gamma,
    gamma_t,
    h,
    knot,
    theta,
    xi,
)
from substep_derive.oscillator.accuracy import leading_terms
from substep_derive.oscillator.amplification import Amplification
from substep_derive.oscillator.evaluation import Evaluation
from substep_derive.oscillator.order import order_of
from substep_derive.stability.certificate import certify
from substep_derive.study.derivation import Derivation, derive
from sympy import (
    Expr,
    Integer,
    Interval,
    Poly,
    Rational,
    Symbol,
    cancel,
    diff,
    factor,
    fraction,
    oo,
    real_roots,
    solve,
    together,
    zeros,
)

from .region import Region

u0, v0, a0 = knot(0)
u1, v1, a1 = knot(1)

# (beta, gamma) of Table 4.1, and gamma_t of figures 4.1 to 4.5
newmark_sets = tuple(
    (Fraction(beta), Fraction(gamma))
    for beta, gamma in (("0.25", "0.5"), ("0.3025", "0.6"), ("0.36", "0.7"), ("0.4225", "0.8"), ("0.49", "0.9"))
)
splits = tuple(Fraction(split) for split in ("0.2", "0.4", "0.5", "0.6", "0.8"))
# the schemes of the figures of chapter 4 with their parameters
compared = (
    ("bathe", {}),
    *(("newmark_bdf2", {"gamma_t": t, "beta": b, "gamma": g}) for t in splits for b, g in newmark_sets),
)

# (2.54) prints delta*h^3/6 where the equation of motion requires delta*h^3
gholampour_printed = gholampour_with(delta / 6, "gholampour_printed", "thesis (2.53)-(2.57), as printed")

# (2.9) prints the load of the last stage at t_(n+1/2)
rk4_printed = Scheme(
    "rk4_printed",
    rk4.relations,
    (
        *rk4.balances[:3],
        Balance(rk4.balances[3].inertia, rk4.balances[3].damping, rk4.balances[3].force, f(Rational(1, 2))),
    ),
    reference="thesis (2.8)-(2.9), as printed",
)

_ut, _vt, _at = knot("t")

# (2.20) prints u_(n+theta) + u_n in place of the difference; its 6/theta v_n, which is no acceleration, is read as
# 6/(theta h) v_n
wilson_printed = Scheme(
    "wilson_printed",
    {
        **wilson_theta.relations,
        _at: 6 / (theta * h) ** 2 * (_ut + u0) - 6 / (theta * h) * v0 - 2 * a0,
        _vt: 3 / (theta * h) * (_ut + u0) - 2 * v0 - theta * h / 2 * a0,
    },
    wilson_theta.balances,
    wilson_theta.parameters,
    reference="thesis (2.18)-(2.20), as printed",
)

# (2.23) prints - K u_n in place of - alpha K u_n, and the load at t_(n+alpha)
hht_printed = Scheme(
    "hht_printed",
    hht_alpha.relations,
    (Balance(a1, (1 + alpha) * v1 - alpha * v0, (1 + alpha) * N(u1) - N(u0), f(alpha)),),
    hht_alpha.parameters,
    reference="thesis (2.23)-(2.26), as printed",
)

# Coordinates of the regions in which the thesis claims stability; beyond and above count from an edge of the region
_beyond, _above, _share, _below = (Symbol(name) for name in ("beyond", "above", "share", "below"))
_half, _from_zero = Rational(1, 2), Interval(0, oo)

newmark_conditions = (2 * beta >= gamma, gamma >= _half)  # (2.17)
gholampour_conditions = (delta >= Rational(1, 3), delta / 2 <= alpha_g, alpha_g <= delta - Rational(1, 6))  # (2.56)-57

wilson_values = Interval(Rational(137, 100), oo)  # of theta, p. 11
hht_values = Interval(-Rational(1, 3), 0)  # of alpha, (2.24)

wbz_region = Region(wbz_alpha, {alpha_B: -_above}, {_above: _from_zero})  # (2.28)-(2.30)

# (2.36)-(2.38): alpha_m <= alpha_f <= 1/2, beta >= 1/4 + (alpha_f - alpha_m)/2, gamma = 1/2 - alpha_m + alpha_f
generalized_alpha_region = Region(
    generalized_alpha,
    {
        alpha_f: _half - _below,
        alpha_m: _half - _below - _beyond,
        beta: Rational(1, 4) + _beyond / 2 + _above,
        gamma: _half + _beyond,
    },
    {_below: _from_zero, _beyond: _from_zero, _above: _from_zero},
)


def gholampour_region(scheme: Scheme = gholampour) -> Region:
    """The region (2.56)-(2.57), for the scheme itself or for the one with (2.54) as printed."""
    lowest = Rational(1, 3) + _above
    room = lowest / 2 - Rational(1, 6)  # from delta/2 to delta - 1/6
    return Region(
        scheme, {delta: lowest, alpha_g: lowest / 2 + _share * room}, {_above: _from_zero, _share: Interval(0, 1)}
    )


# p. 15: t_(n+1) = t_n + (1 - gamma_t) h, in steps after t_n
second_sub_step_end_printed = 1 - gamma_t


def second_sub_step_end() -> Expr:
    """Where the composite's three-point formula (2.48) ends, in steps after t_n.

    u = t, known at t_n and t_n + gamma_t h, has v = 1 everywhere: the formula says for which u_(n+1) it has v = 1 at
    the end, and u_(n+1) is the time there.
    """
    end = Symbol("end")
    straight = {u0: Integer(0), knot("g").u: gamma_t * h, u1: end * h}
    (found,) = solve(silva_bezerra.relations[v1].subs(straight) - 1, end)
    return cancel(found)


def printed_a31() -> Expr:
    """The entry A31 as (4.16) prints it, with h = 1 and omega = Omega."""
    c2 = -1 / ((1 - gamma_t) * gamma_t)
    c3 = (2 - gamma_t) / (1 - gamma_t)
    beta_1 = 1 + 2 * xi * Omega * gamma * gamma_t + beta * Omega**2 * gamma_t**2
    beta_2 = c3**2 + 2 * xi * Omega * c3 + Omega**2
    first = c2 * (
        2 * (1 - gamma) * gamma_t
        + 4 * gamma * xi * Omega * (1 - gamma) * gamma_t**2
        + 2 * beta * gamma_t**3 * Omega**2 * (1 - gamma)
        - 4 * xi * Omega * gamma * (1 - gamma) * gamma_t**2
        - Omega**2 * gamma_t**3 * gamma * (1 - 2 * beta)
    )
    second = (c2 * c3 + 2 * xi * Omega * c2) * (
        gamma_t**2 * (1 - 2 * beta)
        + 2 * gamma_t**2 * (1 - 2 * beta) * xi * Omega * gamma * gamma_t
        + beta * gamma_t**4 * Omega**2 * (1 - 2 * beta)
        - 4 * xi * Omega * beta * (1 - gamma) * gamma_t**3
        - beta * (1 - 2 * beta) * gamma_t**4 * Omega**2
    )
    return -(first + second) / (beta_1 * beta_2)


def a31_ratio() -> Expr:
    """The entry A31 of (4.16) divided by the derived one."""
    return factor(cancel(printed_a31() / derive("newmark_bdf2").A_thesis[2, 0]))


def same_amplification(one: Derivation, other: Derivation, values: dict[Symbol, Expr]) -> bool:
    """Whether the amplification matrices agree identically when the other's parameters are replaced."""
    difference = one.A - other.A.subs(values, simultaneous=True)
    return difference.applyfunc(cancel) == zeros(*difference.shape)


def composite_is_bathe() -> bool:
    """Whether the composite scheme has the amplification matrix of Bathe's scheme as a special case (thesis p. 27)."""
    half, quarter = Rational(1, 2), Rational(1, 4)
    return same_amplification(derive("bathe"), derive("newmark_bdf2"), {gamma_t: half, beta: quarter, gamma: half})


def generalized_alpha_reductions() -> dict[str, bool]:
    """Scheme -> whether generalized-alpha reduces to it, as thesis p. 13 says."""
    general, zero, half = derive("generalized_alpha"), Integer(0), Rational(1, 2)
    hht = {alpha_m: zero, alpha_f: -alpha, beta: (1 - alpha) ** 2 / 4, gamma: half - alpha}
    wbz = {alpha_f: zero, alpha_m: alpha_B, beta: (1 - alpha_B) ** 2 / 4, gamma: half - alpha_B}
    return {
        "newmark": same_amplification(derive("newmark"), general, {alpha_m: zero, alpha_f: zero}),
        "hht_alpha": same_amplification(derive("hht_alpha"), general, hht),
        "wbz_alpha": same_amplification(derive("wbz_alpha"), general, wbz),
    }


def klarmann_wagner() -> tuple[Expr, Expr, tuple[Expr, Expr]]:
    """(gamma_t of least leading period error, of greatest leading damping, both terms) of Silva-Bezerra."""
    series = derive("silva_bezerra").series
    period, damping = series.period_error[2].subs(xi, 0), series.numerical_damping[3].subs(xi, 0)
    return _extremum(period), _extremum(damping), (factor(period), factor(damping))


def _extremum(term: Expr) -> Expr:
    """The stationary point of a rational function of gamma_t inside (0, 1)."""
    stationary = Poly(fraction(together(diff(term, gamma_t)))[0], gamma_t)
    inside = [root for root in sorted(set(real_roots(stationary))) if 0 < root < 1]
    if len(inside) != 1:
        raise ValueError(f"expected one stationary point in (0, 1), got {inside}")
    return inside[0]


def undamped_order(name: str) -> tuple[int, tuple[int, int, int]]:
    """Order of frequency and decay, and of u, v, a in free vibration, at xi = 0."""
    d = derive(name)
    terms = leading_terms(d.amplification, 5)
    errors = [*terms.period_error.items(), *terms.numerical_damping.items()]
    powers = [power for power, coefficient in errors if coefficient.subs(xi, 0) != 0]
    return min(powers, default=6), order_of(Evaluation.at_defaults(d.scheme), Rational(0)).free


def printed_forced_order(scheme: Scheme) -> tuple[int, int, int]:
    """Orders of u, v, a under load, undamped."""
    return order_of(Evaluation.at_defaults(scheme), Rational(0)).forced


def is_consistent(scheme: Scheme) -> bool:
    """Whether an eigenvalue tends to the exact one. Any other error of a mistyped formula is raised."""
    fixed = scheme.fix({p.name: scheme.typical[p.symbol] for p in scheme.parameters})
    try:
        leading_terms(Amplification.of(fixed))
    except InconsistentScheme:
        return False
    return True


def wilson_threshold() -> Poly:
    """The polynomial in theta that changes sign where Wilson's scheme becomes stable at Omega -> oo.

    On the limit of the characteristic polynomial p, lambda = -1 is a root exactly there: a real eigenvalue
    leaves the circle at -1.
    """
    d = derive("wilson_theta")
    at_minus_one = d.charpoly.eval(-2)  # mu = lambda - 1
    leading = Poly(Poly(at_minus_one, Omega).LC(), theta)
    changing = [base for base, power in leading.factor_list()[1] if power % 2]
    (found,) = [p for p in changing if any(root > 1 for root in p.real_roots())]
    return found


def effective_stiffness_has_damping() -> bool:
    """Whether the derived effective stiffnesses hold C, which (3.9) and (3.21) leave out as printed."""
    return all(Symbol("C") in system.effective_stiffness.free_symbols for system in derive("newmark_bdf2").balances)


def central_difference_remainder() -> Rational:
    """The factor of h^2 and the third derivative in (u(t + h) - u(t - h))/(2h) - u', for (2.2)."""
    t = Symbol("t")
    u = t + t**2 / 2 + t**3 / 6  # all derivatives are 1 at t = 0
    return Rational(cancel((u.subs(t, h) - u.subs(t, -h)) / (2 * h) - 1).coeff(h, 2))


def wilson_at_threshold() -> tuple[Algebraic, bool, bool]:
    """The threshold, whether Wilson's scheme is stable there, and whether a millionth below."""
    polynomial = wilson_threshold()
    exact = Algebraic(tuple(int(c) for c in polynomial.all_coeffs()), ("1", "2"))
    (root,) = (r for r in polynomial.real_roots() if r > 1)
    below = Rational(str(root.n(20))) - Rational(1, 10**6)
    return exact, certify("wilson_theta", theta=exact).stable, certify("wilson_theta", theta=below).stable


def hht_beta_at_zero() -> Rational:
    """beta at alpha = 0, from the scheme's own relation for u_1 (the remark after (2.26) says 1/2)."""
    return Rational(cancel(hht_alpha.relations[u1].diff(a1).subs(alpha, 0) / h**2))
