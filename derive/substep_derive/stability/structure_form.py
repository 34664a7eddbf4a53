"""Step -> the forms in which a theorem on one oscillator is one on every structure, recognised exactly.

Balance form. One balance, all else by numbers: a motion x_(n+1) = lambda x_n makes every symbol of the step a multiple
of one vector phi, and the balance becomes (a(lambda) M + h b(lambda) C + h^2 c(lambda) K) phi = 0.

Operator form. With Z = h L, L = [[0, I], [-M^-1 K, -M^-1 C]] and y = (u, v), the first row of Z says h v = [Z y]_u and
so h^2 v' = [Z^2 y]_u. If there are rational functions r_s with s = [r_s(Z) y_0]_u for every symbol u, h v, h^2 a of
the step, that satisfy all relations, and each balance has inertia = Z^2 force, damping = Z force, then all equations of
the step hold for every M, C, K, and y_1 = R(Z) y_0: only identities of functions of one variable are to be checked. A
multi-step method rho(E) y = Z sigma(E) y of the same operator is recognised likewise, with u_k -> lambda^k.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from sympy import QQ, Expr, Poly, Symbol, cancel, fraction

from ..algebra import rational
from ..algebra.algebraic import Field
from ..algebra.field_matrices import field_matrix
from ..algebra.points import RationalPoint, positive_roots, ring_over, simplest_between
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.symbols import K0, C, M, N, N_discrete, Omega, auxiliary, h, kind_of, knot, knot_of, lam, lattice, z
from ..step.step import Step
from .hurwitz import Verdict, verdict
from .structure_storage import storage

MATRICES = (M, C, K0)
Row = dict[Symbol, Any]  # symbol of a knot -> its coefficient


class Rows:
    """A step with numbers for its parameters, h = 1: the coefficients of the symbols in each of its equations.

    relations: one row each. balances: for each the rows that M, C and K multiply. Coefficients e_1 + e_2 D^-1 M of
    accelerations, with D a sum of positive multiples of M, C and K as in KR-alpha, become numbers with a = M^-1 D w:
    D^-1 M a = w, and M (e_1 + e_2 D^-1 M) a = e_1 D w + e_2 M w. Raises DeclarationError for other coefficients.
    """

    def __init__(self, parameters: ParameterSet) -> None:
        self.field, self.step = parameters.field, Step.of(parameters.scheme)
        self.values = {**parameters.values, h: 1}
        self.symbols = (*self.step.unknowns, *self.step.state)
        scheme = parameters.scheme
        given = [*(s - e for s, e in scheme.relations.items()), *(b.inertia for b in scheme.balances)]
        dens = [
            fraction(cancel(e.diff(s)))[1] for e in given for s in e.free_symbols if knot_of(s) and e.has(*MATRICES)
        ]
        own = next((d for d in dens if d.has(*MATRICES)), None)
        self.D = None if own is None else [self._number(own.diff(matrix)) for matrix in MATRICES]
        if self.D and any(self.field.sign(d * self.D[0]) < bool(k == 0) for k, d in enumerate(self.D)):
            raise self._refused(own)
        self.relations = [self._relation(e) for e in given[: len(scheme.relations)]]
        self.balances = [self._balance(*parts) for parts in ((b.inertia, b.damping, b.force) for b in scheme.balances)]

    def _refused(self, e: object) -> DeclarationError:
        return DeclarationError(
            f"{self.step.scheme.name} on every structure: expected coefficients that are numbers or e_1 + e_2 D^-1 M "
            f"of accelerations with one sum D of positive multiples of M, C, K, got {e}; certify it on oscillators"
        )

    def _number(self, e: Expr) -> Any:
        value = cancel(e.subs(self.values))
        if value.has(*MATRICES):
            raise self._refused(e)
        return self.field.number(value)

    def _parts(self, s: Symbol, e: Expr) -> tuple[Any, Any]:
        """(e_1, e_2) of a coefficient e of s, which is e_1 + e_2 D^-1 M."""
        slope = cancel(e.diff(s).subs(self.values))
        if self.D is None or not slope.has(*MATRICES):
            return self._number(slope), self.field.domain.zero
        D = sum(self.field.expression(d) * matrix for d, matrix in zip(self.D, MATRICES, strict=True))
        above = cancel(slope * D)
        m, *others = (self._number(above.diff(matrix)) for matrix in MATRICES)
        e1 = next(part / d for part, d in zip(others, self.D[1:], strict=True) if d)
        e2 = m - e1 * self.D[0]
        if any(part != e1 * d for part, d in zip(others, self.D[1:], strict=True)) or kind_of(s) != 2:
            raise self._refused(slope)
        return e1, e2

    def _relation(self, e: Expr) -> Row:
        found = {}
        for s in (s for s in self.symbols if e.has(s)):
            e1, e2 = self._parts(s, e)
            if self.D is not None and kind_of(s) == 2 and e1:
                raise self._refused(e)
            found[s] = e2 if self.D is not None and kind_of(s) == 2 else e1
        return found

    def _balance(self, inertia: Expr, damping: Expr, force: Expr) -> tuple[Row, Row, Row]:
        linear = force.replace(N, lambda u: u).replace(N_discrete, lambda u, w: (u + w) / 2)
        rows: list[Row] = [
            {},
            *({s: self._number(e.diff(s)) for s in self.symbols if e.has(s)} for e in (damping, linear)),
        ]
        for s in (s for s in self.symbols if inertia.has(s)):
            e1, e2 = self._parts(s, inertia)
            if self.D is None:
                rows[0][s] = e1
                continue
            for row, share in zip(rows, self.D, strict=True):
                row[s] = row.get(s, self.field.domain.zero) + e1 * share
            rows[0][s] += e2
        return rows[0], rows[1], rows[2]


@dataclass(frozen=True)
class BalanceForm:
    """(a M + h b C + h^2 c K) phi = 0, with polynomials in lambda over the parameters' field."""

    a: Poly
    b: Poly
    c: Poly

    @classmethod
    def of(cls, rows: Rows, live: int) -> "BalanceForm | None":
        """None unless there is one balance, and live eigenvalues, in number, all come from it."""
        if len(rows.balances) != 1:
            return None
        over = rows.field.domain.frac_field(lam)
        shift = over.gens[0]
        equations = [_over(over, row) for row in rows.relations]
        for s, after in zip(rows.step.state, rows.step.after, strict=True):
            equations.append({s: shift, after: -over.one})
        matrix = [[row.get(s, over.zero) for s in rows.symbols] for row in equations]
        _, kernel = rational.affine_solutions(matrix, [over.zero] * len(matrix), len(rows.symbols), over) or (None, [])
        if len(kernel) != 1:
            return None
        x = dict(zip(rows.symbols, kernel[0], strict=True))
        sums = [sum((c * x[s] for s, c in _over(over, row).items()), over.zero) for row in rows.balances[0]]
        polys = [_poly(e, lam) for e in cleared(over, [*kernel[0], *sums])[-3:]]
        degrees = [(p.degree(), min(m[0] for m in p.monoms())) for p in polys if p]
        if max(d for d, _ in degrees) - min(low for _, low in degrees) != live:
            return None
        low = min(low for _, low in degrees)
        a, b, c = (p.exquo(Poly(lam**low, lam, domain=rows.field.domain)) for p in polys)
        return cls(a, b, c)


@dataclass(frozen=True)
class OperatorForm:
    """y_1 = R(hL) y_0 with R = numerator/den, coprime polynomials in z over the parameters' field."""

    numerator: Poly
    den: Poly

    @classmethod
    def of(cls, rows: Rows) -> "OperatorForm | None":
        """None where the identities do not hold, or a step does not end in equilibrium and goes on from that."""
        step, end = rows.step, knot(1)
        over = rows.field.domain.frac_field(z)
        if any(s not in knot(0) for s in step.state) or (knot(0).a in step.state and not _ends_in_balance(rows)):
            return None
        powers = {s: over.gens[0] ** kind_of(s) for s in step.state}
        equations = [_over(over, row) for row in rows.relations]
        for by_M, by_C, by_K in rows.balances:
            for row, power in ((by_C, 1), (by_M, 2)):
                equations.append(_over(over, row))
                for s, c in _over(over, by_K).items():
                    equations[-1][s] = equations[-1].get(s, over.zero) - over.gens[0] ** power * c
        matrix = [[row.get(s, over.zero) for s in step.unknowns] for row in equations]
        right = [-sum((row[s] * powers[s] for s in step.state if s in row), over.zero) for row in equations]
        found = rational.affine_solutions(matrix, right, len(step.unknowns), over)
        if found is None or found[1]:
            return None
        r = powers | dict(zip(step.unknowns, found[0], strict=True))
        over_one_den = dict(zip(r, cleared(over, [*r.values()]), strict=True))
        left = [
            sum((c.numer.quo_ground(c.denom.LC) * over_one_den[s] for s, c in row.items()), over.field.ring.zero)
            for row in equations
        ]
        for s in step.after:
            left.append(over_one_den[s] - over.field.ring.gens[0] ** kind_of(s) * over_one_den[end.u])
        if step.reported[:2] != (end.u, end.v) or any(c for e in left for c in e.values()):
            return None
        return cls(*(_poly(e, z) for e in (r[end.u].numer, r[end.u].denom)))

    def bounded(self, field: Field) -> bool:
        """Whether |R| <= 1 where Re z <= 0: no pole there, and |den(iy)|^2 - |numerator(iy)|^2 nowhere negative."""
        ring = ring_over(field, Omega)
        mirrored = [
            ring.ground_new(c if k % 2 == 0 else -c) for k, c in enumerate(reversed(self.den.rep.to_list()))
        ]  # its roots are those of den(-z)
        if self.numerator.degree() > self.den.degree():
            return False
        if self.den.degree() and verdict(mirrored, RationalPoint(field, QQ(0))) is not Verdict.INSIDE:
            return False
        difference = _on_axis(self.den, ring) - _on_axis(self.numerator, ring)
        return nowhere_negative(field, difference)


def nowhere_negative(field: Field, polynomial: Any) -> bool:
    """Whether a polynomial in one variable is not negative at any positive one."""
    if not polynomial:
        return True
    ring = polynomial.ring
    roots = positive_roots(field, [polynomial], ring)
    ends = [QQ(0), *(root.high for root in roots)]
    starts = [*(root.low for root in roots), ends[-1] + 2]
    samples = [simplest_between(low, high) for low, high in zip(ends, starts, strict=True)]
    return all(field.sign(polynomial.evaluate(ring.gens[0], field.domain.convert(x))) > 0 for x in samples)


def _on_axis(polynomial: Poly, ring: Any) -> Any:
    """|polynomial(iy)|^2 as a polynomial in y^2."""
    c = list(reversed(polynomial.rep.to_list()))
    even, odd = (ring.from_dict({(j,): (-x if j % 2 else x) for j, x in enumerate(c[k::2]) if x}) for k in (0, 1))
    return even**2 + ring.gens[0] * odd**2


def within_triangle(form: OperatorForm, field: Field, W: Fraction, D: Fraction) -> bool:
    """Whether R is a polynomial with |R| <= 1 in the triangle -D, +-i sqrt(W), that is on its border."""
    if form.den.degree():
        return False
    ring = ring_over(field, Omega)
    s, one = ring.gens[0], ring.one
    number = lambda x: ring.ground_new(field.domain.convert(QQ(x.numerator, x.denominator)))  # noqa: E731
    coefficients, degree = form.numerator.rep.to_list()[::-1], form.numerator.degree()
    square, share = number(W), 1 + s
    for x in (ring.zero, number(D) * s):  # z = (-x + i sqrt(W))/(1 + s), s > 0: up to the corner i sqrt(W), from there
        real, imaginary, power = ring.zero, ring.zero, (one, ring.zero)  # imaginary parts over sqrt(W)
        for k, c in enumerate(coefficients):
            scale = share ** (degree - k)
            real, imaginary = (
                e + (part * scale).mul_ground(c) for e, part in zip((real, imaginary), power, strict=True)
            )
            a, b = power
            power = (-x * a - square * b, a - x * b)
        whole = (share**degree).mul_ground(field.domain.convert(form.den.rep.to_list()[0]))
        if not nowhere_negative(field, whole**2 - real**2 - square * imaginary**2):
            return False
    return True


@dataclass(frozen=True)
class MultiStepForm:
    """rho(E) y_n = h L sigma(E) y_n, with E the shift by a step: a linear multi-step method of the operator L."""

    rho: Poly
    sigma: Poly

    @classmethod
    def of(cls, rows: Rows) -> "MultiStepForm | None":
        """None where the relations are not all the same one, for u and for v."""
        if len(rows.balances) != 1 or not _ends_in_balance(rows):
            return None
        labels = {s: lattice((knot_of(s) or ("", ""))[1]) for s in rows.symbols}
        if any(k is None or k.denominator > 1 for k in labels.values()) or any(map(auxiliary, rows.step.state)):
            return None
        first = min(k for k in labels.values() if k is not None)
        power = {s: lam ** int(k - first) * z ** kind_of(s) for s, k in labels.items() if k is not None}
        domain = rows.field.domain
        residuals = [
            sum(
                (Poly(power[s], lam, z, domain=domain).mul_ground(c) for s, c in row.items()),
                Poly(0, lam, z, domain=domain),
            )
            for row in rows.relations
        ]
        parts = [p.terms_gcd()[1].monic() for p in residuals]
        if any(p != parts[0] for p in parts) or parts[0].degree(z) != 1:
            return None
        rho, sigma = (Poly(parts[0].as_expr().coeff(z, k), lam, domain=domain) for k in (0, 1))
        return cls(rho, -sigma)

    @property
    def G(self) -> list[list[Any]] | None:
        """G (k, k), positive definite, of a method of k steps with rational parameters.

        Re <rho y, sigma y> = |Y_1|_G^2 - |Y_0|_G^2 + sum |e_j(E) y_0|^2 (Dahlquist, BIT 18 (1978) 384-401; Hairer &
        Wanner II, V.6), which the dissipative L makes not positive. None where `squares` finds no such sum.
        """
        if self.rho.domain != QQ or (k := self.rho.degree()) < 2:
            return None
        G = storage(*([QQ.from_sympy(p.coeff_monomial((j,))) for j in range(k + 1)] for p in (self.rho, self.sigma)))
        minors = [] if G is None else [field_matrix([r[:m] for r in G[:m]], QQ).det() for m in range(1, k + 1)]
        return G if minors and all(m > 0 for m in minors) else None


def _over(over: Any, row: Row) -> Row:
    """The row with coefficients in a field of rational functions over theirs."""
    return {s: over.field.ground_new(c) for s, c in row.items()}


def cleared(over: Any, values: Sequence[Any]) -> list[Any]:
    """Polynomials: the rational functions times a common denominator."""
    den = over.one
    for e in values:
        den *= over.field.new((e * den).denom)
    return [(e * den).numer.mul_ground(over.domain.one / (e * den).denom.LC) for e in values]


def _poly(polynomial: Any, variable: Symbol) -> Poly:
    return Poly.from_dict(dict(polynomial.terms()), variable, domain=polynomial.ring.domain)


def _ends_in_balance(rows: Rows) -> bool:
    """Whether a balance is that of the end of the step alone."""
    one = rows.field.domain.one
    return any([*map(dict, balance)] == [{s: one} for s in reversed(knot(1))] for balance in rows.balances)
