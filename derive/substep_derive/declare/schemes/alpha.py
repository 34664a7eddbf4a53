"""Alpha schemes, whose balance takes weighted means of the two ends of the step."""

from sympy import Expr, Interval, Rational, Symbol, oo

from ..parameter import Family, Parameter
from ..published import Published
from ..scheme import Balance, Scheme
from ..symbols import K0, C, M, N, alpha, alpha_B, alpha_f, alpha_m, beta, f, gamma, h, knot, rho_inf
from .newmark import newmark

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)


def newmark_relations(b: Expr, g: Expr) -> dict[Symbol, Expr]:
    """Newmark's relations with other expressions for beta and gamma."""
    return {symbol: e.subs({beta: b, gamma: g}, simultaneous=True) for symbol, e in newmark.relations.items()}


def mixed(new: Expr, old: Expr, weight: Expr) -> Expr:
    """The weighted mean (1 - weight) new + weight old."""
    return (1 - weight) * new + weight * old


def hht(name: str, force: Expr) -> Scheme:
    """HHT-alpha with one of the two forms of the internal force."""
    return Scheme(
        name,
        parameters=(Parameter(alpha, Interval(-1, half), -Rational(1, 10)),),
        families=(
            Family(Parameter(rho_inf, Interval(half, 1), Rational(4, 5)), {alpha: (rho_inf - 1) / (rho_inf + 1)}),
        ),
        relations=newmark_relations((1 - alpha) ** 2 / 4, (1 - 2 * alpha) / 2),
        balances=(Balance(a1, mixed(v1, v0, -alpha), force, f(1 + alpha)),),
        reference="Hilber, Hughes & Taylor, Earthq. Eng. Struct. Dyn. 5 (1977) 283-292; thesis (2.23)-(2.26)",
        published=Published("Hilber, Hughes & Taylor (1977)", 2, rho_inf, oo),
    )


hht_alpha = hht("hht_alpha", mixed(N(u1), N(u0), -alpha)).known_as("hht", "hilber_hughes_taylor")
hht_alpha_mixed_displacement = hht("hht_alpha_mixed_displacement", N(mixed(u1, u0, -alpha)))

wbz_alpha = Scheme(
    "wbz_alpha",
    parameters=(Parameter(alpha_B, Interval(-1, half), -Rational(1, 10)),),
    families=(Family(Parameter(rho_inf, Interval(0, 1), Rational(4, 5)), {alpha_B: (rho_inf - 1) / (rho_inf + 1)}),),
    relations=newmark_relations((1 - alpha_B) ** 2 / 4, half - alpha_B),
    balances=(Balance(mixed(a1, a0, alpha_B), v1, N(u1), f(1)),),
    reference="Wood, Bossak & Zienkiewicz, Int. J. Numer. Methods Eng. 15 (1980) 1562-1566; thesis (2.27)-(2.30)",
    published=Published("Wood, Bossak & Zienkiewicz (1980)", 2, rho_inf, oo, (alpha_B <= 0,)),
    synonyms=("wbz", "bossak", "wood_bossak_zienkiewicz", "bossak_newmark"),
)


def chung_hulbert(name: str, force: Expr) -> Scheme:
    """Generalized-alpha with one of the two forms of the internal force."""
    return Scheme(
        name,
        parameters=(
            Parameter(alpha_m, Interval(-1, half), Rational(1, 3)),
            Parameter(alpha_f, Interval(0, half), Rational(4, 9)),
            Parameter(beta, Interval(0, oo), (1 - alpha_m + alpha_f) ** 2 / 4),
            Parameter(gamma, Interval(0, oo), half - alpha_m + alpha_f),
        ),
        families=(
            Family(
                Parameter(rho_inf, Interval(0, 1), Rational(4, 5)),
                {alpha_m: (2 * rho_inf - 1) / (rho_inf + 1), alpha_f: rho_inf / (rho_inf + 1)},
            ),
        ),
        relations=dict(newmark.relations),
        balances=(Balance(mixed(a1, a0, alpha_m), mixed(v1, v0, alpha_f), force, f(1 - alpha_f)),),
        reference="Chung & Hulbert, J. Appl. Mech. 60 (1993) 371-375; thesis (2.31)-(2.38)",
        published=Published("Chung & Hulbert (1993)", 2, rho_inf, oo),
    )


generalized_alpha = chung_hulbert("generalized_alpha", mixed(N(u1), N(u0), alpha_f)).known_as(
    "gen_alpha", "generalised_alpha", "g_alpha", "genalpha", "chung_hulbert", "ch_alpha"
)
generalized_alpha_mixed_displacement = chung_hulbert("generalized_alpha_mixed_displacement", N(mixed(u1, u0, alpha_f)))

_rho_b = Symbol("rho_b")

explicit_generalized_alpha = Scheme(
    "explicit_generalized_alpha",
    parameters=(
        Parameter(alpha_m, Interval(-1, half), Rational(1, 3)),
        Parameter(alpha_f, Interval(0, 1), Rational(1)),
        Parameter(beta, Interval(0, oo), (7 - 8 * alpha_m) * (2 - alpha_m) ** 2 / (27 * (1 - alpha_m))),
        Parameter(gamma, Interval(0, oo), half - alpha_m + alpha_f),
    ),
    families=(
        Family(
            Parameter(_rho_b, Interval(0, 1), Rational(4, 5)),  # the spectral radius at bifurcation
            {alpha_m: (2 * _rho_b - 1) / (_rho_b + 1), alpha_f: Rational(1)},
        ),
    ),
    relations=dict(newmark.relations),
    balances=(
        Balance(
            mixed(a1, a0, alpha_m),
            mixed(v1, v0, alpha_f),
            N(u0 + (1 - alpha_f) * (h * v0 + h**2 * (half - beta) * a0)),
            f(1 - alpha_f),
        ),
    ),
    reference="Hulbert & Chung, Comput. Methods Appl. Mech. Eng. 137 (1996) 175-188",
    published=Published("Hulbert & Chung (1996)", 2, oo),
    synonyms=("hulbert_chung",),
)

_am, _af = (2 - rho_inf) / (1 + rho_inf), 1 / (1 + rho_inf)
_b, _g = 1 / (1 + rho_inf) ** 2, (3 - rho_inf) / (2 * (1 + rho_inf))
_alpha1 = M / (M + _g * h * C + _b * h**2 * K0)


def kolay_ricles(
    name: str,
    am: Expr,
    b: Expr,
    g: Expr,
    start: dict[Symbol, Expr],
    report: dict[Symbol, Expr],
    reference: str = "Kolay & Ricles, Earthq. Eng. Struct. Dyn. 43 (2014) 1361-1380",
    published: Published | None = None,
) -> Scheme:
    """KR-alpha with its share of the new acceleration, beta and gamma, and a given start and report of its velocity."""
    D = M + g * h * C + b * h**2 * K0
    alpha3 = (am * M + _af * g * h * C + _af * b * h**2 * K0) / D
    return Scheme(
        name,
        parameters=(Parameter(rho_inf, Interval(0, 1), half),),
        relations={u1: u0 + h * v0 + h**2 * (half + g) * (M / D) * a0, v1: v0 + h * (M / D) * a0},
        balances=(
            Balance(
                alpha3 * a1 + (1 - alpha3) * a0,
                _af * v1 + (1 - _af) * v0,
                _af * N(u1) + (1 - _af) * N(u0),
                f(_af),
            ),
        ),
        start=start,
        report=report,
        reference=reference,
        published=published or Published("Kolay & Ricles (2014)", 2 if start else None, rho_inf, oo),
    )


# the scheme's v_n stands for v(t_n - gamma*h)
kr_alpha = kolay_ricles(
    "kr_alpha", _am, _b, _g, {v0: v0 - _g * h * _alpha1 * a0}, {v1: v1 + _g * h * _alpha1 * a1}
).known_as("kr", "kolay_ricles", "kr_alpha_explicit")
kr_alpha_plain_start = kolay_ricles("kr_alpha_plain_start", _am, _b, _g, {}, {}).known_as("kr_alpha_explicit")

ALL = (
    hht_alpha,
    hht_alpha_mixed_displacement,
    wbz_alpha,
    generalized_alpha,
    generalized_alpha_mixed_displacement,
    explicit_generalized_alpha,
    kr_alpha,
    kr_alpha_plain_start,
)
