"""For which parameters a scheme is stable for every Omega > 0: inequalities in the parameters, exactly.

lambda = (1 + s)/(1 - s) takes the characteristic polynomial to h(s) (see `hurwitz`). Up to degree three, and for a
leading coefficient that is positive at small Omega, |lambda| <= 1 at every Omega > 0 if and only if every
coefficient of h and, for degree three, h_1*h_2 - h_0*h_3 is nowhere negative: for two eigenvalues these are
p(1), p(-1) and c_2 - c_0. Multiple eigenvalues on the circle are then s = 0 twice or s = oo twice (lambda = 1 or -1),
which sums of neighbouring coefficients exclude by being positive. "For every Omega > 0" is eliminated by
coefficients and discriminants of polynomials of degree up to three in Omega^2.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from sympy import (
    Expr,
    Integer,
    Intersection,
    Interval,
    Mul,
    Poly,
    Rational,
    Symbol,
    cancel,
    discriminant,
    expand,
    factor,
    factor_list,
    oo,
)
from sympy.core.relational import Eq, Ge, Gt, Le, Lt, Ne, Relational
from sympy.logic.boolalg import And, Boolean, Not, Or, false, true

from ..algebra.exact_number import exact_number
from ..declare.catalogue import find
from ..declare.parameter import written_interval
from ..declare.parameter_set import check_damping
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, lam
from ..declare.symbols import xi as damping_ratio
from ..oscillator.amplification import Amplification
from ..oscillator.spectrum import live
from .box import Box, Sign, sign_on
from .certificate import certify
from .hurwitz import Hurwitz, bilinear
from .paper import PRINTER, as_in_paper

W = Symbol("W", real=True)  # unlike a parameter of that name: Omega^2 where only even powers occur, else Omega
ALL_POSITIVE = Interval.open(0, oo)
ZERO = Integer(0)
HIGHEST = 3  # degree up to which "for every W > 0" is eliminated


@dataclass(frozen=True)
class Atoms:
    """Inequalities in factored form, without the factors whose sign follows from the parameters' intervals."""

    box: Box

    def _split(self, expression: Expr) -> tuple[int, list[Expr], list[Expr]]:
        """(sign of the rest, factors that matter only where they vanish, factors whose sign is not known)."""
        constant, factors = factor_list(expression)[:2]
        sign, touching, open_ = (1 if constant > 0 else -1), [], []
        for base, power in factors:
            known = sign_on(base, self.box)
            if known.value and power % 2:
                sign *= known.value
            if known.value == 0 and power % 2:
                open_.append(base)
            elif not (known.value and known.strict):
                touching.append(base)
        return sign, touching, open_

    def at_least(self, left: Expr, right: Expr = ZERO, *, strict: bool = False) -> Boolean:
        """left >= right, or left > right."""
        if expand(left - right) == 0:
            return false if strict else true
        sign, touching, open_ = self._split(left - right)
        rest = relation(sign * Mul(*open_), left, right, strict=strict) if open_ else (true if sign > 0 else false)
        if strict:
            return And(rest, *(Ne(*sides(e)) for e in touching))
        return rest if rest is true else Or(rest, *(Eq(*sides(e)) for e in touching))

    def zero(self, expression: Expr) -> Boolean:
        """expression == 0."""
        if expand(expression) == 0:
            return true
        _, touching, open_ = self._split(expression)
        return Or(*(Eq(*sides(e)) for e in (*touching, *open_)))


def sides(expression: Expr) -> tuple[Expr, Expr]:
    """(left, right) with left - right a positive multiple of the polynomial, arranged to be read easily.

    A linear polynomial in several symbols has its negative terms on the right. Any other is solved for a symbol that
    occurs linearly with a number as its coefficient, if there is one; otherwise 0 is on the right.
    """
    symbols = sorted(expression.free_symbols, key=str)
    p = Poly(expression, *symbols)
    alone = [x for x in symbols if Poly(expression, x).degree() == 1 and Poly(expression, x).LC().is_number]
    if alone and (p.total_degree() > 1 or len(symbols) == 1):
        x = min(alone, key=lambda x: abs(Poly(expression, x).LC()))
        scale, rest = (Poly(expression, x).coeff_monomial(k) for k in (x, 1))
        solved = x, factor(-rest / scale)
        return solved if scale > 0 else solved[::-1]
    if p.total_degree() > 1:
        return expression, ZERO
    negative = expand(-Poly({m: c for m, c in p.terms() if c < 0} or {(0,) * len(symbols): 0}, *symbols).as_expr())
    return expand(expression + negative), negative


def relation(expression: Expr, left: Expr = ZERO, right: Expr = ZERO, *, strict: bool) -> Boolean:
    """expression > 0 or >= 0; as left > right, both scaled to differ by the expression, if they stay polynomials."""
    shares: list[Any] = [factor(x * cancel(expression / (left - right))) for x in (left, right)] if right != 0 else []
    more, less = shares if shares and all(x.is_polynomial() for x in shares) else sides(factor(expression))
    if more.is_number:
        return Lt(less, more) if strict else Le(less, more)
    return Gt(more, less) if strict else Ge(more, less)


@dataclass(frozen=True)
class ForAll:
    """The requirement that polynomial >= 0, or > 0 if strict, for every Omega > 0.

    variable: Omega^2 or Omega, for which W stands. eliminated: the equivalent in the parameters alone, or None.
    """

    name: str
    polynomial: Expr
    strict: bool
    variable: Expr
    eliminated: Boolean | None

    def holds(self, values: Mapping[Symbol, Rational]) -> bool:
        """Whether the requirement is met at exact values, by counting real roots."""
        p = Poly(self.polynomial.subs(values), W)
        if p.is_zero:
            return not self.strict
        while p.eval(0) == 0:
            p = p.quo(Poly(W, W))
        odd = [part for part, power in p.sqf_list()[1] if self.strict or power % 2]
        return p.LC() > 0 and not any(part.count_roots(0, None) for part in odd)

    def __str__(self) -> str:
        shown = str(factor(self.polynomial.subs(W, self.variable))).replace("**", "^")
        return f"for all Omega > 0: {shown} {'>' if self.strict else '>='} 0"


def for_all(polynomial: Expr, strict: bool, box: Box) -> Boolean | None:
    """polynomial >= 0 (or > 0) for every W > 0 as a condition on the parameters; None for too high a degree."""
    atoms = Atoms({**box, W: ALL_POSITIVE})
    if expand(polynomial) == 0:
        return false if strict else true
    constant, factors = factor_list(polynomial)[:2]
    sign, content, kept = Integer(1 if constant > 0 else -1), Integer(1), Integer(1)
    for base, power in factors:
        known = sign_on(base, atoms.box)
        if known.value and known.strict:
            sign *= known.value**power
        elif known.value and not base.has(W):
            sign *= known.value**power
            content *= base
        else:
            kept *= base**power
    inner = _for_all_coefficients(Poly(sign * kept, W).all_coeffs()[::-1], strict, atoms)
    if inner is None or content == 1:
        return inner
    return And(inner, Not(atoms.zero(content))) if strict else Or(inner, atoms.zero(content))


def _for_all_coefficients(a: Sequence[Expr], strict: bool, atoms: Atoms) -> Boolean | None:
    """The condition of `for_all` for a[0] + a[1]*W + ..., whose first and last coefficients may vanish."""
    while len(a) > 1 and expand(a[0]) == 0:
        a = a[1:]
    at_least = [atoms.at_least(c) for c in a]
    some = Or(*(atoms.at_least(c, strict=True) for c in a)) if strict else true
    if len(a) <= 2 or And(*at_least) is true:
        return And(*at_least, some)
    if len(a) - 1 > HIGHEST:
        return None
    ends = And(at_least[0], at_least[-1])
    if len(a) == 3:
        return And(ends, Or(And(at_least[1], some), atoms.at_least(4 * a[0] * a[2], a[1] ** 2, strict=strict)))
    one_real_root = atoms.at_least(-discriminant(Poly(a[::-1], W)), strict=strict)
    cases = [And(*at_least, some), And(one_real_root, *(atoms.at_least(a[i], strict=True) for i in (0, 3)))]
    for gone, rest in ((a[0], a[1:]), (a[3], a[:3])):
        if (vanishes := atoms.zero(gone)) is not false:
            cases.append(And(vanishes, _for_all_coefficients(rest, strict, atoms)))
    return And(ends, Or(*cases))


def not_both_zero(f: Expr, g: Expr, known: Boolean, box: Box) -> Boolean | None:
    """The condition that f + g > 0 for every W > 0; known includes that f and g are nowhere negative there."""
    atoms = Atoms({**box, W: ALL_POSITIVE})
    arms: list[Boolean] = []
    for one, other in ((f, g), (g, f)):
        a = [c for c in Poly(one, W).all_coeffs() if expand(c) != 0]
        if len(a) > 2 and any(atoms.at_least(c) is not true for c in a):
            continue  # it could vanish at one W without vanishing at every W
        zeros = [atoms.zero(c) for c in a]
        if all(contradicts(known, chosen, box) for chosen in product(*(Or.make_args(e) for e in zeros))):
            return true
        rest = for_all(other, True, box)
        if rest is not None:
            arms.append(Or(*(atoms.at_least(c, strict=True) for c in a), rest))
    return min(arms, key=lambda e: e.count_ops()) if arms else for_all(expand(f + g), True, box)


def contradicts(known: Boolean, zeros: Sequence[Boolean], box: Box) -> bool:
    """Whether the equations, solved where they are linear in a symbol, are shown to contradict what is known."""
    values: dict[Any, Any] = {}
    for equation in zeros:
        if not isinstance(equation, Eq):
            return equation is false
        rest: Any = expand((equation.lhs - equation.rhs).subs(values))
        if rest.is_number and rest != 0:
            return True
        for x in sorted(rest.free_symbols, key=str):
            if Poly(rest, x).degree() == 1 and rest.coeff(x).is_number:
                value = expand(x - rest / rest.coeff(x))
                if value.is_number and value not in box[x]:
                    return True
                values = {k: expand(e.subs(x, value)) for k, e in values.items()} | {x: value}
                break
    known_now = [e for e in And.make_args(known) if isinstance(e, Ge | Gt | Le | Lt)]
    signs = [sign_on(expand((e.gts - e.lts).subs(values)), box) for e in known_now]
    return any(sign.value < 0 and sign.strict for sign in signs)


def implies(known: Boolean, condition: Boolean, box: Box) -> bool:
    """Whether one inequality is shown to follow from another: their difference, one scaled, is not negative."""
    if not (isinstance(known, Ge | Gt | Le | Lt) and isinstance(condition, Ge | Gt | Le | Lt)):
        return False
    given, wanted = (expand(e.gts - e.lts) for e in (known, condition))
    strict = isinstance(condition, Gt | Lt) and not isinstance(known, Gt | Lt)
    symbols = sorted(given.free_symbols | wanted.free_symbols, key=str)
    p, q = Poly(given, *symbols), Poly(wanted, *symbols)
    scales = {q.coeff_monomial(m) / c for m, c in p.terms()}
    signs = [sign_on(expand(wanted - scale * given), box) for scale in scales if scale > 0]
    return any((sign.value > 0 and (sign.strict or not strict)) or sign == Sign(0, not strict) for sign in signs)


@dataclass(frozen=True)
class Conditions:
    """Spectral stability at every Omega > 0 and one damping ratio, as conditions on the parameters.

    requirements: what has to hold for every Omega > 0, necessary and sufficient together up to three
    eigenvalues that are not 0; for more (`exact` False) sufficient, and necessary but for eigenvalues that
    stay on the circle. inequalities: all of those from which Omega could be eliminated, to hold together with
    the parameters' intervals. eliminated: whether they are all there is, necessary and sufficient.
    """

    scheme: Scheme
    xi: Rational
    requirements: tuple[ForAll, ...]
    inequalities: tuple[Boolean, ...]
    exact: bool

    def __repr__(self) -> str:
        count = len(self.inequalities) + sum(r.eliminated is None for r in self.requirements)
        return f"<conditions on {self.scheme.name}, xi = {self.xi}: {count}, written by .text>"

    @property
    def eliminated(self) -> bool:
        """Whether the inequalities alone are necessary and sufficient."""
        done = all(r.eliminated is not None for r in self.requirements)
        return done and (self.exact or And(*self.inequalities) is true)

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Whether the scheme is stable for every Omega > 0 at exact values of all its parameters.

        Raises DeclarationError for an unknown parameter or a value outside its interval, ValueError for a
        missing one, TypeError for a float.
        """
        given = self.scheme.exact(values)
        if missing := [s.name for s in self.scheme.values if s not in given]:
            raise ValueError(f"{self.scheme.name}: give a value for {', '.join(missing)}")
        if not self.exact and not self.eliminated:
            return certify(self.scheme, self.xi, **{s.name: v for s, v in given.items()}).stable
        if not all(bool(inequality.subs(given)) for inequality in self.inequalities):
            return False
        return all(r.holds(given) for r in self.requirements if r.eliminated is None)

    @property
    def text(self) -> str:
        """The conditions, one a line."""
        if And(*self.inequalities) is false:
            never = f"{self.scheme.name}, xi = {self.xi}: not stable for every Omega > 0"
            never += ", whatever the parameters" if self.scheme.parameters else ""
            return never if self.exact else f"{never}, but for eigenvalues kept on the circle, which certify decides"
        lines = [f"{self.scheme.name}, xi = {self.xi}: stable for every Omega > 0 if and only if"]
        if not self.exact and not self.eliminated:
            lines[0] = lines[0].replace("if and only if", "if (and, but for eigenvalues kept on the circle, only if)")
        domain = [p.written for p in self.scheme.parameters]
        whole = self._interval
        each = [whole] if whole else [*domain, *(written(i, self.scheme) for i in self.inequalities)]
        lines += [f"  {e}" for e in each]
        lines += [f"  {r}" for r in self.requirements if r.eliminated is None]
        if len(lines) == 1:
            return f"{self.scheme.name}, xi = {self.xi}: stable for every Omega > 0, without a condition"
        return "\n".join(lines)

    @property
    def _interval(self) -> str:
        """Where the interval and the inequalities of one parameter, quadratic at most, are one interval; or empty."""
        if len(self.scheme.parameters) != 1:
            return ""
        (parameter,) = self.scheme.parameters
        differences = [e.lhs - e.rhs for e in And(*self.inequalities).atoms(Relational)]
        if any(Poly(e, parameter.symbol).degree() > 2 for e in differences):
            return ""
        held = Intersection(parameter.domain, *(i.as_set() for i in self.inequalities))
        return written_interval(parameter.name, held) if isinstance(held, Interval) else ""


def written(condition: Boolean, scheme: Scheme) -> str:
    """A condition on a scheme's parameters as a paper writes it."""
    if isinstance(condition, Or | And):
        word = " or " if isinstance(condition, Or) else " and "
        parts = (written(part, scheme) for part in condition.args)
        return word.join(f"({part})" if " or " in part or " and " in part else part for part in parts)
    if not isinstance(condition, Relational):
        return str(condition)
    left, right = (PRINTER.doprint(as_in_paper(side, scheme)) for side in (condition.lhs, condition.rhs))
    return f"{left} { {'==': '='}.get(condition.rel_op, condition.rel_op) } {right}"


def conditions(scheme: str | Scheme, xi: Any = 0) -> Conditions:
    """Conditions on the free parameters for stability at every Omega > 0, at one exact damping ratio.

    Jury's or Lienard and Chipart's conditions with Omega eliminated; see the module. Raises DeclarationError
    for an unknown scheme, TypeError for a float, NotImplementedError for a scheme with a constant, and where the
    intervals of the parameters do not tell the sign of the leading coefficient at small Omega.
    """
    declared, number = find(scheme), exact_number(xi)
    check_damping(declared, number)
    if declared.constant is not None:
        raise NotImplementedError(
            f"{declared.name}: expected numbers that are rational in the parameters, got the constant "
            f"{declared.constant}; take certify, which decides at given parameters"
        )
    box = {p.symbol: p.domain for p in declared.parameters}
    p = Poly(live(Amplification.of(declared).charpoly).as_expr().subs(damping_ratio, number), lam).terms_gcd()[1]
    c, variable = _in_square(p.all_coeffs()[::-1])
    c = [e * leading_sign(declared, c[-1], box) for e in c]
    n = len(c) - 1
    h = [expand(e) for e in bilinear(c)]
    if n <= 3:
        needed = [(f"h_{i}", e, False) for i, e in enumerate(h)]
        needed += [("h_1*h_2 - h_0*h_3", h[1] * h[2] - h[0] * h[3], False)] if n == 3 else []
    else:
        needed = [(name, e, True) for name, e in Hurwitz("h", [expand(e) for e in h]).conditions.items()]
    requirements = [
        ForAll(name, expand(e), strict, variable, for_all(expand(e), strict, box)) for name, e, strict in needed
    ]
    if n <= 3:
        known = And(*(r.eliminated for r in requirements if r.eliminated is not None))
        for name, e, g in (("lambda = 1 not twice", h[0], h[1]), ("lambda = -1 not twice", h[n], h[n - 1])):
            requirements.append(ForAll(name, expand(e + g), True, variable, not_both_zero(e, g, known, box)))
    done = [r.eliminated for r in requirements if r.eliminated is not None]
    return Conditions(declared, number, tuple(requirements), together(done, box), n <= 3)


def _in_square(coefficients: Sequence[Expr]) -> tuple[list[Expr], Expr]:
    """The coefficients in W, and Omega^2 or Omega, for which W stands."""
    even = all(m[0] % 2 == 0 for e in coefficients for m in Poly(e, Omega).monoms())
    if not even:
        return [e.subs(Omega, W) for e in coefficients], Omega
    return [Poly({(m[0] // 2,): k for m, k in Poly(e, Omega).terms()}, W).as_expr() for e in coefficients], Omega**2


def leading_sign(scheme: Scheme, leading: Expr, box: Box) -> int:
    """The sign of the leading coefficient at small Omega."""
    if not (sign := sign_on(Poly(leading, W).EC(), box)).strict or not sign.value:
        raise NotImplementedError(f"{scheme.name}: the sign of {leading} at small Omega depends on the parameters")
    return sign.value


def together(eliminated: Iterable[Boolean], box: Box) -> tuple[Boolean, ...]:
    """All eliminated requirements as one list of conditions, without those that another one implies."""
    found = And(*eliminated)
    kept = sorted(And.make_args(found), key=lambda e: (e.count_ops(), str(e))) if found is not true else []
    for condition in list(kept):
        if any(other is not condition and implies(other, condition, box) for other in kept):
            kept.remove(condition)
    return tuple(kept)
