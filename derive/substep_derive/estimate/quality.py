"""How good an estimate is beyond small steps: its quotient with the true error, and the filter for stiff components."""

from dataclasses import dataclass

from sympy import Derivative, Expr, I, Integer, Symbol, cancel, exp, factor, fraction, sqrt

from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import C, K_t, M, Omega, h, kind_of, knot, knot_of, successor, xi
from ..motion.effective import effective_systems
from ..stability.paper import as_in_paper, in_powers
from .estimator import Estimate, Estimator, kappa
from .held import END, START
from .stiff import Growth, Polynomial, Row

K = Symbol("K")  # the tangent stiffness


def filter_of(scheme: Scheme) -> Expr | None:
    """The factor M c_a/(c_a M + c_v C + c_u K), by which Shampine has estimates damped on stiff components.

    It is the solution, for the estimate as right side, of the system that the scheme solves anyway: that of the last
    balance that is implicit. It tends to 1 with the step and so leaves the leading term as it is. None for an explicit
    scheme, and where that balance is solved together with others. Source: Shampine, SIAM J. Sci. Stat. Comput. 5 (1984)
    831-839; Hosea & Shampine (1996), section 5.
    """
    implicit = [system for system in effective_systems(scheme) if not system.explicit]
    if not implicit or implicit[-1].beside:
        return None
    last = implicit[-1]
    # the slope of a discrete gradient in one of its two displacements is half the tangent
    mass = last.effective_mass.replace(K_t, lambda _: K).replace(Derivative, lambda *_: K / 2)
    return factor(last.c_a * M / mass)


def in_paper(scheme: Scheme) -> Expr | None:
    """The filter as a paper writes it, its denominator as a sum of one term each of M, C and K; None as `filter_of`."""
    found = filter_of(scheme)
    if found is None:
        return None
    numerator, denominator = fraction(as_in_paper(found, scheme))
    return numerator / in_powers(denominator, (M, C, K), scheme)


def filters(estimate: Estimate, *, vanishing: bool) -> int:
    """How often an estimate has to be filtered until it stays bounded, or vanishes, as Omega -> oo."""
    powers = estimate.growth + 1 if vanishing else estimate.growth
    return max(0, -(-powers // 2))


@dataclass(frozen=True)
class Effectivity:
    """Closed forms in Omega and xi, on the mode u = 1, h*v = s of the oscillator, s = Omega*(-xi + i sqrt(1 - xi^2)).

    estimate, error: of u and of h*v, the quotients of which tend to 1 with Omega.
    """

    estimate: tuple[Expr, Expr]
    error: tuple[Expr, Expr]

    @property
    def index(self) -> tuple[Expr, Expr]:
        """Estimate / true local error of u and of v; its modulus is the effectivity index."""
        return self.estimate[0] / self.error[0], self.estimate[1] / self.error[1]


@dataclass(frozen=True)
class OnOscillator:
    """Rows of an estimator's two estimates and of the reported u, h*v, over the state of the step.

    back: for each estimate, whether its row is over the state one step earlier. den: of each estimate and of what is
    reported. Polynomials in Omega and xi, with numbers of the estimator's field.
    """

    growth: Growth
    estimates: tuple[Row, Row]
    dens: tuple[Polynomial, Polynomial]
    back: tuple[bool, bool]
    reported: tuple[Row, Row]

    @classmethod
    def of(cls, estimator: Estimator) -> "OnOscillator":
        """From the estimates' formulas. Steps are of equal length."""
        evaluation = estimator.evaluation
        growth, found, rows = Growth(evaluation, None), [], []
        for own, error in enumerate((estimator.u, estimator.v)):
            symbols = tuple(sorted((x for x in error.free_symbols if knot_of(x)), key=str))
            even = error.subs(kappa, 1)
            factors = [evaluation.number(cancel(even.diff(x) * h ** (own - kind_of(x)))) for x in symbols]
            found.append(growth.of_symbols(symbols))
            rows.append(found[-1].combined(factors))
        dens, back = tuple(one.den for one in found), tuple(one.before for one in found)
        return cls(growth, (rows[0], rows[1]), dens, back, (growth.rows[END.u], growth.rows[END.v]))  # type: ignore[arg-type]


def effectivity(estimator: Estimator) -> Effectivity:
    """Effectivity of a scheme whose state is u and v alone, or with the acceleration that balances them.

    Raises DeclarationError for a scheme whose state holds more: its principal modes have no closed form in general, and
    the index is computed at numbers by `substep.studies.estimator_charts`.
    """
    scheme, rows = estimator.scheme, OnOscillator.of(estimator)
    u, v, a = knot(0)
    state, held = scheme.state, rows.growth.rows
    if START.a not in held or not set(state) <= {u, v, a} or (a in state and held[successor(a)] != held[END.a]):
        raise DeclarationError(
            f"{scheme.name}: expected a state of u and v, or with the acceleration that balances them, for a closed "
            f"form, got {', '.join(map(str, state))}; compute the index at numbers"
        )

    def written(polynomial: Polynomial) -> Expr:
        number = estimator.evaluation.field.expression
        return sum((number(c) * Omega**p * xi**q for (p, q), c in polynomial.items()), Integer(0))

    exact = Omega * (-xi + I * sqrt(1 - xi**2))
    den = written(rows.growth.den)

    def reduced(row: Row) -> tuple[Expr, Expr]:
        at = {x: written(e) for x, e in zip(state, row, strict=True)}
        left = at.get(a, Integer(0))
        return at[u] - Omega**2 * left, at[v] - 2 * xi * Omega * left

    (a11, a12), (a21, a22) = (reduced(row) for row in rows.reported)
    now = Integer(1), exact
    # the state before, from which the scheme reaches u = 1, h*v = s
    before = [(a22 - a12 * exact) * den, (a11 * exact - a21) * den]
    det = a11 * a22 - a12 * a21
    found = []
    for row, below, back in zip(rows.estimates, rows.dens, rows.back, strict=True):
        left, right = reduced(row)
        x, y = (before[0] / det, before[1] / det) if back else now
        found.append((left * x + right * y) / written(below))
    errors = [
        (c * now[0] + d * now[1]) / den - exp(exact) * now[k] for k, (c, d) in enumerate(((a11, a12), (a21, a22)))
    ]
    return Effectivity((found[0], found[1]), (errors[0], errors[1]))


def on_oscillator(factor_: Expr) -> Expr:
    """A filter on the oscillator, in Omega and xi."""
    return cancel(factor_.subs({M: 1, C: 2 * xi * Omega, K: Omega**2, h: 1}, simultaneous=True))
