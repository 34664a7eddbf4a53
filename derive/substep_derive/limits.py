"""Amplification -> what happens at large Omega: overshoot, and where the eigenvalues turn real.

Overshoot: Hilber & Hughes, Earthq. Eng. Struct. Dyn. 6 (1978) 99-117, in the notation U0-V1.
"""

from dataclasses import dataclass
from itertools import pairwise

from sympy import Expr, Integer, Matrix, Poly, Rational, fraction, oo, together

from .accuracy import live
from .amplification import Amplification
from .curve import critical_curve
from .damping import certify_all_damping
from .derivation import Derivation, at_defaults
from .scheme import Scheme
from .stability import certify
from .symbols import Omega, knot_of, lam, lattice, xi


@dataclass(frozen=True)
class Overshoot:
    """Powers of Omega with which u_1 and v_1/omega grow in the scheme's first step as Omega -> oo.

    For unit u_0 and unit v_0/omega with the consistent a_0, undamped; the larger of the two, negative as 0.
    """

    u: int
    v: int

    def __str__(self) -> str:
        return f"U{self.u}-V{self.v}"


def overshoot(amplification: Amplification) -> Overshoot:
    """Of a multi-step scheme, in the first step that is its own, after the start it declares."""
    found = [(_first_own_step(amplification, given)) for given in ((1, 0, -(Omega**2)), (0, Omega, 0))]
    u = max(_growth(step[0]) for step in found)
    v = max(_growth(step[1] / Omega) for step in found)
    return Overshoot(max(u, 0), max(v, 0))


def _growth(expression: Expr) -> int:
    """Degree in Omega of a rational function; that of 0 counts as 0."""
    numerator, denominator = fraction(together(expression))
    degrees = [Poly(part, Omega).degree() for part in (numerator, denominator)]
    return int(degrees[0] - degrees[1]) if numerator != 0 else 0


def _first_own_step(amplification: Amplification, given: tuple[Expr, Expr, Expr]) -> Matrix:
    """Reported u, h*v, h^2*a after it, undamped."""
    scheme = amplification.scheme
    start = Matrix(given)
    if isinstance(scheme.start, Scheme):
        first = Amplification.of(scheme.start).step
        history = [start]
        at = [knot_of(s) or ("u", "0") for s in scheme.state]
        for _ in range(int(max(-(lattice(label) or 0) for _, label in at))):
            history.append(first.N.subs(xi, 0) * history[-1] / first.den.subs(xi, 0))
        x = Matrix([history[-1 + int(lattice(label) or 0)]["uva".index(kind)] for kind, label in at])
    elif amplification.start is None:
        x = Matrix([start["uva".index(s.name[0])] for s in scheme.state])
    else:
        x = amplification.start.N.subs(xi, 0) * start / amplification.start.den.subs(xi, 0)
    after = amplification.step.N.subs(xi, 0) * x / amplification.step.den.subs(xi, 0)
    outputs = amplification.outputs
    told = outputs.N.subs(xi, 0) * x / outputs.den.subs(xi, 0)
    rest = iter(range(told.rows))
    return Matrix([after[place] if place >= 0 else told[next(rest)] for place in amplification.in_state])


def bifurcation(amplification: Amplification) -> Expr:
    """The smallest Omega at which, undamped, a complex pair turns real; oo if none does.

    Exact (an algebraic number). All parameters of the scheme must have values; raises ValueError for
    free ones.
    """
    p = Poly(live(amplification.charpoly).as_expr().subs(xi, 0), lam)
    if free := p.as_expr().free_symbols - {lam, Omega}:
        raise ValueError(f"expected values for {', '.join(map(str, free))}; fix them before")
    discriminant = Poly(p.discriminant(), Omega)
    if discriminant.is_zero:  # a root that is double at every Omega: look at the others
        p = p.quo(p.gcd(p.diff(lam)))
        discriminant = Poly(p.discriminant(), Omega)
    places = [root for root in sorted(set(discriminant.real_roots())) if root > 0]
    cells = _samples(places)
    counts = [_real_eigenvalues(p, sample) for sample in cells]
    for place, (before, behind) in zip(places, pairwise(counts), strict=True):
        if behind > before:
            return place
    return oo


def _samples(places: list[Expr]) -> list[Expr]:
    """One rational in each cell that the places cut out of (0, oo)."""
    ends = [Integer(0), *places]
    inside = [_between(low, high) for low, high in pairwise(ends)]
    last = Integer(1) if not places else Integer(int(places[-1].n(20)) + 2)
    return [*inside, last]


def _between(low: Expr, high: Expr) -> Expr:
    digits = 20
    while True:
        middle = ((low + high) / 2).n(digits)
        exact = Integer(int(middle * 10**digits)) / 10**digits
        if low < exact < high:
            return exact
        digits *= 2


def _real_eigenvalues(p: Poly, at: Expr) -> int:
    """How many real roots p has at one rational Omega, with their multiplicities."""
    q = Poly(p.as_expr().subs(Omega, at), lam)
    return sum(factor.count_roots() * power for factor, power in q.sqf_list()[1])


@dataclass(frozen=True)
class Profile:
    """What a scheme is at given parameters: the row of a table.

    stable: for every Omega, undamped. A_stable: at every xi >= 0 too; L_stable: and rho_inf = 0; None where
    that was not decided. critical_Omega as in `certify`, critical_curve as a function of xi where it has a
    closed form.
    """

    order: tuple[int, int, int]
    rho_inf: Expr
    stable: bool
    critical_Omega: Expr | None
    critical_curve: Expr | None
    A_stable: bool | None
    L_stable: bool | None
    overshoot: Overshoot
    bifurcation: Expr


def profile(scheme: Scheme) -> Profile:
    """At the scheme's default parameters.

    Certificates take them exactly, algebraic ones too; order, overshoot and bifurcation take irrational
    ones within 1e-40.
    """
    at = Derivation(at_defaults(scheme))
    certificate, damped = certify(scheme), certify_all_damping(scheme)
    conditional = certificate.critical_Omega is not None and certificate.critical_Omega != 0
    A_stable = damped.stable_for_all_xi
    vanishes = abs(at.rho_inf.n(30)) < Rational(1, 10**25)
    return Profile(
        order=at.order,
        rho_inf=at.rho_inf,
        stable=certificate.stable,
        critical_Omega=certificate.critical_Omega,
        critical_curve=critical_curve(scheme).explicit if conditional else None,
        A_stable=A_stable,
        L_stable=A_stable and vanishes,
        overshoot=overshoot(at.amplification),
        bifurcation=bifurcation(at.amplification),
    )
