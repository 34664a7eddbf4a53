"""Scheme -> what one step does to errors on a stiff bar that turns.

A mass at the end of an elastic bar turns about the bar's other end. Small errors d of its position obey
d'' + K(t) d = 0, where K is omega^2 along the bar and theta'^2 across it, by the bar's tension, and the bar turns by
tau = theta' h in a step. Seen from the bar nothing depends on time, so that each step multiplies errors by one matrix.
Balances take the force along the bar as it stands at their instants, and what is axial at one instant is partly across
the bar at the next, however stiff the bar is.

For that reason a scheme that is stable on every oscillator may still gain energy here. Where a step takes the force
once, an eigenvalue lambda that the oscillator has m times as Omega = omega h -> oo is split into m, the largest of them
|lambda| (1 + cot(pi/(2 m)) tau) to first order in tau: beyond 1 if |lambda| is near 1. A pair that tends to 1 or -1
as +-(1 +- i c/Omega) grows iff Omega tau > c, by exp(sqrt(tau^2 - c^2/Omega^2)) a step: the trapezoidal rule iff
h^2 omega theta' > 4. For, with G(lambda) = -u/force at the place where the force is taken, errors along the bar obey
1 + Omega^2 (G(lambda e^(i tau)) + G(lambda e^(-i tau)))/2 = 0 in place of 1 + Omega^2 G(lambda) = 0, but for terms
with the tension: m-fold zeros of G become those of (x + i tau)^m + (x - i tau)^m with x = log(lambda/lambda_oo).
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

from sympy import Dummy, Expr, Integer, Matrix, Poly, cancel, cot, factor, pi, radsimp, sqrt, zeros

from ..algebra import rational
from ..algebra.algebraic import Field
from ..declare.catalogue import find
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import K0, C, K_t, M, N, N_discrete, f, h, kind_of, knot, lam, steps_back, successor
from ..oscillator.evaluation import Evaluation
from ..oscillator.spectrum import live_at, moduli
from ..step.step import Step
from ..step.times import instants_of

PLAIN = {h: Integer(1), M: Integer(1), C: Integer(0)}


@dataclass(frozen=True)
class Turning:
    """What becomes of errors along a very stiff bar that turns by tau in a step.

    at_infinity: of the oscillator's eigenvalues as Omega -> oo the largest modulus of those that are equally often
    multiple, and how often, the largest first; none for an explicit scheme, whose modulus is infinite. once: whether a
    step takes the force at one place. product: c, if it does and a pair tends to 1 or -1: that pair grows iff
    Omega tau > c. None otherwise.
    """

    scheme: Scheme
    at_infinity: tuple[tuple[Expr, int], ...]
    once: bool
    product: Expr | None

    @property
    def growth(self) -> tuple[Expr, Expr] | None:
        """Of the largest the factor a step to first order in tau, c0 + c1 tau, on a rigid bar.

        None of an explicit scheme, of one whose eigenvalues tend to 0, and where a step takes the force at several
        places, whose own turning counts too.
        """
        if not self.at_infinity or not self.once:
            return None
        modulus, times = self.at_infinity[0]
        if not modulus:
            return None
        return modulus, modulus * cot(pi / (2 * times))


def turning(scheme: str | Scheme, **parameters: Any) -> Turning:
    """A scheme of the catalogue by name, or a declaration, on a stiff bar that turns.

    Parameters are exact and those that are left out have their defaults, as for `certify`. Raises DeclarationError as
    `TurningStep.of`, ValueError as `certify` for parameters.

    >>> turning("average_acceleration").product
    4
    >>> turning("generalized_alpha", rho_inf="4/5").at_infinity
    ((4/5, 3),)
    """
    at = Evaluation.at(ParameterSet.of(find(scheme), None, parameters))
    once = TurningStep.of(at.scheme).of_new[1] == 1
    field, rows = at.field, live_at(at, at.field.domain.zero)
    assert isinstance(field, Field)
    highest = max(power for row in rows for power in row)
    stiffest, next_ = ([row.get(p, field.domain.zero) for row in rows] for p in (highest, highest - 2))
    if not stiffest[-1]:
        return Turning(at.scheme, (), once, None)
    found: dict[int, Expr] = {}
    for _, times, modulus in moduli(Poly.from_list(stiffest[::-1], lam, domain=field.domain), field):
        found[times] = max(found.get(times, Integer(0)), modulus, key=lambda x: x.n(20))
    ordered = tuple((found[m], m) for m in sorted(found, key=lambda m: (found[m].n(20), m), reverse=True))
    return Turning(at.scheme, ordered, once, _product(stiffest, next_, field) if once else None)


def _product(stiffest: list[Any], next_: list[Any], field: Field) -> Expr | None:
    """c of a pair that tends to +-1: coefficients of lambda^j beside the two highest powers of Omega."""
    one = field.domain.one
    for end in (one, -one):
        signs = [end**j for j in range(len(stiffest))]

        def at_end(row: list[Any], signs: list[Any] = signs, derivative: int = 0) -> Any:
            """The derivative by log lambda at lambda = +-1."""
            return sum((x * s * one * j**derivative for j, (x, s) in enumerate(zip(row, signs, strict=True))), 0 * one)

        if at_end(stiffest) or at_end(stiffest, derivative=1):
            continue
        curvature = at_end(stiffest, derivative=2)
        if curvature and (square := field.expression(2 * at_end(next_) / curvature)) > 0:
            return radsimp(sqrt(square))
    return None


@dataclass(frozen=True)
class TurningStep:
    """One step, h = 1: relations * (new symbols, new forces, old symbols, kept forces) = 0, all rational functions.

    Symbols are u, v, a in the plane; forces are those per unit mass that balances take. of_new: how many of both are
    new. places: a row for each new force, the displacement at which it is taken, of the same columns; instants: of the
    forces, the new ones first, in steps after t_n. after: of what is kept from step to step, the column it becomes.
    state: of the old symbols the kind, 0, 1, 2 for u, v, a, and the instant in steps. ends: the columns of u_1 and v_1;
    None where one of them is only reported.
    """

    scheme: Scheme
    relations: Matrix
    of_new: tuple[int, int]
    places: Matrix
    instants: tuple[Expr, ...]
    after: tuple[int, ...]
    state: tuple[tuple[int, float], ...]
    ends: tuple[int, int] | None

    @classmethod
    def of(cls, scheme: Scheme) -> "TurningStep":
        """The equations of a scheme.

        Raises DeclarationError for one that takes the force as a discrete gradient, or coefficients from the stiffness
        at the start, whose direction does not turn with the bar.
        """
        return _step(scheme)


@cache
def _step(scheme: Scheme) -> TurningStep:
    step = Step.of(scheme)
    if any(e.has(K0, K_t, N_discrete) for e in step.equations):
        raise DeclarationError(
            f"{scheme.name}: expected forces at displacements, got a discrete gradient or coefficients from the "
            "stiffness at the start, of which no constant matrix follows on a bar that turns; march it instead"
        )
    free = [e.xreplace({load: Integer(0) for load in e.atoms(f)}).subs(PLAIN) for e in step.equations]
    atoms = sorted({a for e in free for a in e.atoms(N)}, key=str)
    later = {a: a.xreplace({s: successor(s) for s in step.state}) for a in atoms}
    kept = [a for a in atoms if later[a] != a and later[a] in atoms]
    new = [a for a in atoms if a not in kept]
    force = {a: Dummy(f"force_{k}") for k, a in enumerate((*new, *kept))}
    columns = [*step.unknowns, *(force[a] for a in new), *step.state, *(force[a] for a in kept)]
    symbols = [s for s in columns if s not in force.values()]
    places = zeros(len(new), len(columns))
    at = instants_of(step)

    def instant(a: Expr) -> Expr:
        slopes = {s: a.args[0].diff(s) for s in a.free_symbols & at.keys()}
        return factor(cancel(sum((slope * at[s] for s, slope in slopes.items()), Integer(0))))

    for k, a in enumerate(new):
        for s in a.free_symbols & {*symbols}:
            places[k, columns.index(s)] = a.args[0].diff(s)
    end = knot(1)
    kept_after = [columns.index(force[later[a]]) for a in kept]
    return TurningStep(
        scheme,
        rational.slopes([e.xreplace(force) for e in free], columns),
        (len(step.unknowns), len(new)),
        places,
        tuple(instant(a) for a in (*new, *kept)),
        (*(columns.index(s) for s in step.after), *kept_after),
        tuple((kind_of(s), -float(steps_back(s))) for s in step.state),
        (columns.index(end.u), columns.index(end.v)) if {*end[:2]} <= {*step.unknowns} else None,
    )
