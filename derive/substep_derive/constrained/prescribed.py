"""Step -> how well a scheme knows velocity and reaction where a constraint prescribes its displacements.

A constraint leaves no choice in its normal direction: the displacement is a given r(t) at every knot where it is new,
and the reaction is what that takes. With it each balance holds for any acceleration, so that the relations alone say
which velocity and which reaction belong to r. For a smooth r both have errors in powers of h; what else a start holds
is multiplied in each step by the roots of one polynomial.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import factorial
from typing import Any

from sympy import QQ, Dummy, Expr, Integer, Poly, Symbol, factor, radsimp, sympify

from ..algebra.algebraic import Field, closed_form, generator
from ..algebra.field_matrices import FieldMatrix, field_matrix, identity
from ..algebra.rational import SingularMatrix
from ..declare.catalogue import find
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import K0, C, M, N, N_discrete, Omega, h, kind_of, lam, steps_back, successor
from ..oscillator.evaluation import Evaluation
from ..oscillator.spectrum import CLOSE, moduli
from ..step.step import Step
from ..step.times import passed

HIGHEST = 6  # powers of h that are looked at for an error
PLAIN = {h: Integer(1), C: Integer(0), M: Integer(1)}

Row = list[Any]  # numbers of a field, one for each symbol of a basis


@dataclass(frozen=True)
class ErrorTerm:
    """The first term, coefficient h^power r^(k + power), of the error of the k-th derivative of r."""

    power: int
    coefficient: Expr

    def __str__(self) -> str:
        """As -1/12 h^2; to six digits where it is irrational."""
        c = self.coefficient
        return f"{c if c.is_Rational or c.free_symbols else format(float(c), '.6g')} h^{self.power}"


@dataclass(frozen=True)
class Prescribed:
    """What a scheme makes of a displacement r(t) that is prescribed, at some parameters or at almost all.

    held: for each balance the displacement that its reaction holds at r, and its instant in steps after t_n, which is
    beyond the step where the reaction moves no displacement before. at_end: whether u at the ends of steps is held;
    otherwise it drifts from r. velocity: the error of v at t_n + h, or of the newest v that the scheme keeps, if what
    it reports needs the force there. reactions: place where a balance takes the internal force -> the error of the
    acceleration that force and reaction give there; multiplier: that of the last one at t_n + h, or of the last one.
    An error of a power above `HIGHEST` is None. polynomial: of lambda; its roots multiply in each step what a start has
    wrong. decay: their largest modulus, None where parameters are free; grows: whether it is above 1, or 1 with a
    Jordan block.
    """

    scheme: Scheme
    held: tuple[tuple[Symbol, Expr], ...]
    at_end: bool
    velocity: ErrorTerm | None
    reactions: Mapping[Expr, ErrorTerm | None]
    multiplier: ErrorTerm | None
    polynomial: Poly
    decay: Expr | None
    grows: bool | None

    def __str__(self) -> str:
        """In a line: both errors, what becomes of a wrong start, and whether u at the ends of steps drifts."""
        errors = f"v {self.velocity or 'exact'}, multiplier {self.multiplier or 'exact'}"
        return f"{errors}; a wrong start: {self.start}" + (
            "" if self.at_end else "; u at the ends of steps is not held"
        )

    @property
    def start(self) -> str:
        """What becomes of a wrong start, in words."""
        if self.decay is None:
            return f"multiplied by the roots of {factor(self.polynomial.as_expr())}"
        if self.decay == 0:
            return f"gone after {self.polynomial.degree()} steps at the latest"
        times = f"times {float(self.decay):.6g} a step"
        return f"grows, {'linearly' if abs(self.decay.n(40) - 1) < CLOSE else times}" if self.grows else times


def prescribed(scheme: str | Scheme, **parameters: Any) -> Prescribed:
    """A scheme of the catalogue by name, or a declaration, under a prescribed motion.

    Parameters are exact and those that are left out have their defaults, as for `certify`. Raises DeclarationError for
    a scheme that cannot carry a constraint, with the reason; ValueError as `certify` for parameters.

    >>> found = prescribed("newmark", beta="0.3025", gamma="0.6")
    >>> found.multiplier, found.start
    (ErrorTerm(power=1, coefficient=-1/10), 'times 0.818182 a step')
    """
    return prescribed_at(Evaluation.at(ParameterSet.of(find(scheme), None, parameters)))


def prescribed_at(at: Evaluation) -> Prescribed:
    """The same with the numbers of an evaluation; see `prescribed`."""
    motion = StepRows(at)
    expression = motion.expression
    reactions = {
        place: motion.error(row, motion.instant(place), 2)
        for place, row in motion.reactions.items()
        if place not in motion.carried
    }
    at_end = [place for place in reactions if motion.instant(place) == motion.one]
    coefficients = motion.after[0].charpoly()
    decay, grows = motion.fading(coefficients, at.field) if isinstance(at.field, Field) else (None, None)
    return Prescribed(
        scheme=at.scheme,
        held=tuple((u, expression(tau)) for u, tau, _ in motion.held),
        at_end=any(u in motion.step.reported for u, *_ in motion.held),
        velocity=motion.error(*motion.velocity, 1),
        reactions=reactions,
        multiplier=reactions[(at_end or [*reactions])[-1]],
        polynomial=Poly(list(map(expression, coefficients)), lam),
        decay=decay,
        grows=grows,
    )


class StepRows:
    """A step from t_n on, with h = 1, as rows of numbers over its accelerations z and over its state.

    The state is the scheme's own, and the accelerations that belong to forces taken at knots of the step before, which
    a balance may hold too, as that of the generalized-alpha method does: `carried`, by the place of the force.
    """

    def __init__(self, at: Evaluation) -> None:
        self.at, self.step, self.one = at, Step.of(at.scheme), at.field.domain.one
        if any(e.has(K0) for e in self.step.equations):
            raise DeclarationError(
                f"{at.scheme.name} takes its coefficients from the structure: expected relations that hold whatever "
                "the reaction is; take another scheme for constraints"
            )
        self.places = list(dict.fromkeys(place for b in at.scheme.balances for place in _places(b.force)))
        later = {place: place.xreplace({s: successor(s) for s in self.step.state}) for place in self.places}
        self.carried = {
            place: Symbol(f"a at {place}")
            for place in self.places
            if place != later[place] and later[place] in self.places
        }
        self.later = later
        self.z, self.state = self.step.accelerations, (*self.step.state, *self.carried.values())
        self.basis = {s: k for k, s in enumerate((*self.z, *self.state))}
        self.times = {s: self.number(sympify(tau)) for s, tau in passed(self.step).items()}

    def expression(self, number: Any) -> Expr:
        """A number of the field as a number or a function of free parameters, in closed form."""
        field = self.at.field
        found = field.expression(number)
        if isinstance(field, Field) and field.root is not None and found.has(generator):
            return radsimp(found.subs(generator, closed_form(field.root, Omega)).expand())
        return found if isinstance(field, Field) else factor(found)

    @property
    def velocity(self) -> tuple[Row, Any]:
        """The row of the velocity whose error is looked at, and its instant."""
        reported = self.step.reported[1]
        if not reported.has(N):
            return self.row(reported), self.one
        newest = successor(min((s for s in self.step.state if kind_of(s) == 1), key=steps_back))
        return self.rows[newest], self.number(sympify(-steps_back(newest)))

    def instant(self, place: Expr) -> Any:
        """When a balance takes the force, in steps after t_n; of a discrete gradient the middle."""
        return self._sum(place.args, self.times) / len(place.args)

    @cached_property
    def rows(self) -> Mapping[Symbol, Row]:
        """A row for each symbol of the step and of the state."""
        zero, one = self.one - self.one, self.one
        found = {s: [one if k == at else zero for k in range(len(self.basis))] for s, at in self.basis.items()}
        for s, e in self.step.solved.items():
            found[s] = self._combined(e, found)
        return found

    def row(self, expression: Expr) -> Row:
        """The row of an affine expression in symbols of the step."""
        return self._combined(expression, self.rows)

    @cached_property
    def reactions(self) -> Mapping[Expr, Row]:
        """Place where a balance takes the force -> the row of the acceleration that force and reaction give there."""
        found = {place: self.rows[s] for place, s in self.carried.items()}
        for balance in self.at.scheme.balances:
            marks = {place: Dummy() for place in _places(balance.force)}
            force = balance.force.xreplace(marks)
            weights = {place: self.number(force.diff(mark)) for place, mark in marks.items()}
            own = [place for place in weights if place not in found]
            if len(own) != 1:
                raise DeclarationError(
                    f"{self.at.scheme.name}: expected each balance to take the internal force at one place that no "
                    f"other one takes it at, so that its reaction is determined, got {balance.force}; take another "
                    "scheme for constraints"
                )
            inertia = self.row(balance.inertia)
            for place, weight in weights.items():
                if place in found:
                    inertia = [x - weight * y for x, y in zip(inertia, found[place], strict=True)]
            found[own[0]] = [x / weights[own[0]] for x in inertia]
        return found

    @cached_property
    def held(self) -> list[tuple[Symbol, Any, Row]]:
        """For each balance the displacement that its reaction holds at r, its instant, and its row.

        It is the first one that the reaction moves, of those where the balance takes the force, of the others in the
        order in which they are solved, and of the next step's that follow from this one. Of balances that are solved
        together the reactions count together.
        """
        within = [u for stage in self.step.stages for u in sorted(stage.in_z, key=lambda u, s=stage: u not in s.moved)]
        among = [(u, self.times[u], self.rows[u]) for u in within if kind_of(u) == 0]
        after = {s: self.rows.get(successor(s), self.rows[s]) for s in self.step.state}
        among += [
            (u, self.times[u] + 1, self._combined(e, after)) for u, e in self.step.prior.items() if kind_of(u) == 0
        ]
        found = list[tuple[Symbol, Any, Row]]()
        for k, (stage, j) in enumerate(self.step.placed):
            own, columns = stage.moved_by(j), [self.basis[z] for z in stage.z]
            moves = [x for x in among if any(x[2][c] for c in columns) and x not in found]
            mine = min(moves, key=lambda x, own=own: x[0] not in own, default=None)
            if mine is None:
                raise DeclarationError(
                    f"{self.at.scheme.name}: expected the reaction of each balance to move a displacement, of this "
                    f"step or the next, got none that balance {k + 1} moves and no earlier one holds; take another "
                    "scheme for constraints"
                )
            found.append(mine)
        return found

    @cached_property
    def accelerations(self) -> tuple[FieldMatrix, FieldMatrix]:
        """z as matrices over the state and over the values of r where it is held."""
        m = len(self.z)
        try:
            by_r = self._matrix([row[:m] for *_, row in self.held]).inv()
        except SingularMatrix as error:
            raise DeclarationError(
                f"{self.at.scheme.name}: expected reactions that hold the displacements independently of each other, "
                "got two that move them alike; take another scheme for constraints"
            ) from error
        return -by_r * self._matrix([row[m:] for *_, row in self.held]), by_r

    def eliminated(self, rows: Sequence[Row]) -> tuple[FieldMatrix, FieldMatrix]:
        """Rows as matrices over the state and over the values of r where it is held."""
        m, (of_state, of_r) = len(self.z), self.accelerations
        by_z = self._matrix([row[:m] for row in rows])
        return by_z * of_state + self._matrix([row[m:] for row in rows]), by_z * of_r

    @cached_property
    def after(self) -> tuple[FieldMatrix, FieldMatrix]:
        """The state after the step."""
        own = [self.rows[successor(s)] for s in self.step.state]
        return self.eliminated([*own, *(self.reactions[self.later[place]] for place in self.carried)])

    @cached_property
    def smooth(self) -> list[FieldMatrix]:
        """Coefficients of x^k of the state that belongs to r = exp(x t) at t_n = 0, for h = 1."""
        by_state, by_r = self.after
        n, domain = len(self.state), self.at.field.domain
        try:
            solving = (identity(n, domain) - by_state).inv()
        except SingularMatrix as error:
            raise DeclarationError(
                f"{self.at.scheme.name}: expected a state that a smooth motion determines, got one that keeps what it "
                "started with; take another scheme for constraints"
            ) from error
        found = list[FieldMatrix]()
        for k in range(HIGHEST + 3):
            known = by_r * self._powers(k)
            for j, before in enumerate(reversed(found), start=1):
                known -= before * self._share(j)
            found.append(solving * known)
        return found

    def error(self, row: Row, instant: Any, derivative: int) -> ErrorTerm | None:
        """The first term of the error of what a row gives for a derivative of r at an instant."""
        by_state, by_r = self.eliminated([row])
        values = [(by_state * y + by_r * self._powers(k)).to_list()[0][0] for k, y in enumerate(self.smooth)]
        for k in range(len(values)):
            shifted = [values[k - j] * self._power(-instant, j) * self._share(j) for j in range(k + 1)]
            wrong = sum(shifted, start=-self.one if k == derivative else self.one - self.one)
            if wrong:
                return ErrorTerm(k - derivative, self.expression(wrong))
        return None

    def fading(self, coefficients: Sequence[Any], field: Field) -> tuple[Expr, bool]:
        """The largest modulus of the roots, and whether a wrong start grows."""
        found = moduli(Poly.from_list(coefficients, lam, domain=field.domain), field)
        decay = max((modulus for *_, modulus in found), key=lambda x: x.n(40), default=Integer(0))
        beyond = decay.n(40) - 1
        if abs(beyond) > CLOSE:
            return decay, bool(beyond > 0)
        return decay, any(
            times > 1 and abs(modulus.n(40) - 1) < CLOSE and self._jordan(part, times) for part, times, modulus in found
        )

    def _jordan(self, part: Poly, times: int) -> bool:
        """Whether a multiple factor of the characteristic polynomial has fewer eigenvectors than roots."""
        one = identity(len(self.state), self.at.field.domain)
        value = one - one
        for c in part.rep.to_list():
            value = value * self.after[0] + one * c
        return len(self.state) - value.rank() < times * part.degree()

    def number(self, expression: Expr) -> Any:
        """A number of the field, with h = 1."""
        return self.at.number(expression.xreplace(PLAIN))

    def _sum(self, expressions: Sequence[Expr], values: Mapping[Symbol, Any]) -> Any:
        """The sum of affine expressions in symbols with values."""
        total = self.one - self.one
        for e in expressions:
            for s in e.free_symbols & values.keys():
                total += self.number(e.diff(s)) * values[s]
        return total

    def _combined(self, expression: Expr, rows: Mapping[Symbol, Row]) -> Row:
        found = [self.one - self.one] * len(self.basis)
        for s in sorted(expression.free_symbols & rows.keys(), key=str):
            weight = self.number(expression.diff(s))
            found = [x + weight * y for x, y in zip(found, rows[s], strict=True)]
        return found

    def _matrix(self, rows: Sequence[Row]) -> FieldMatrix:
        return field_matrix(rows, self.at.field.domain)

    def _powers(self, k: int) -> FieldMatrix:
        """The coefficient of x^k of exp(x tau) at the instants where r is held."""
        return self._matrix([[self._power(tau, k) * self._share(k)] for _, tau, _ in self.held])

    def _power(self, number: Any, k: int) -> Any:
        """The power of a number of the field; 1 for 0^0, which functions of free parameters do not know."""
        return number**k if k else self.one

    def _share(self, k: int) -> Any:
        return self.at.field.domain.convert(QQ(1, factorial(k)))


def _places(force: Expr) -> list[Expr]:
    """Where a balance takes the internal force, in an order that does not change."""
    return sorted(force.atoms(N, N_discrete), key=str)
