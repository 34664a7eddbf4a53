"""Expressions as a paper writes them: factors that are positive where the parameters lie, ^ for powers, |x|."""

from collections.abc import Mapping
from typing import Any

from sympy import (
    Abs,
    Add,
    Derivative,
    Dummy,
    Expr,
    Interval,
    Mul,
    Poly,
    Pow,
    Symbol,
    factor,
    factor_list,
    fraction,
    oo,
    together,
)
from sympy.core.function import AppliedUndef
from sympy.printing.str import StrPrinter

from ..declare.scheme import Scheme
from ..declare.symbols import C, M, Omega, f, h, xi
from .box import sign_on

PRIMES = 3  # of a derivative with respect to time; a higher one is written u^(4)(t)


class PaperPrinter(StrPrinter):
    """SymPy's text with ^ for powers, | | for moduli, u'''(t), = for equality and cases in words."""

    def _print_Abs(self, expr: Any) -> str:
        return f"|{self._print(expr.args[0])}|"

    def _print_Derivative(self, expr: Any) -> str:
        function, (variable, order), *others = expr.args
        if others or function.args != (variable,):
            return super()._print_Derivative(expr)
        marks = "'" * order if order <= PRIMES else f"^({order})"
        return f"{function.func}{marks}({variable})"

    def _print_Max(self, expr: Any) -> str:
        return f"max({', '.join(self._print(a) for a in expr.args)})"

    def _print_Piecewise(self, expr: Any) -> str:
        *cases, (last, _) = expr.args
        chosen = (f"{self._print(e)} where {self._print(_without_minus(condition))}" for e, condition in cases)
        return f"({', '.join([*chosen, f'else {self._print(last)}'])})"

    def doprint(self, expr: Any) -> str:
        """The expression as text."""
        return super().doprint(expr).replace("**", "^")


def _without_minus(condition: Any) -> Any:
    """An inequality with each term on the side on which it has no minus sign."""
    terms = Add.make_args(condition.lhs - condition.rhs)
    left, right = ([x for x in terms if x.could_extract_minus_sign() == minus] for minus in (False, True))
    return condition.func(Add(*left), -Add(*right), evaluate=False)


PRINTER = PaperPrinter()


def box_of(scheme: Scheme) -> dict[Symbol, Interval]:
    """The intervals of a scheme's parameters, and those of h, M, C, Omega and of xi, which is below 1."""
    positive = dict.fromkeys((h, M, C, Omega), Interval.open(0, oo))
    return {p.symbol: p.domain for p in scheme.parameters} | positive | {xi: Interval.open(0, 1)}


def as_in_paper(expression: Expr, scheme: Scheme) -> Expr:
    """The expression with each term of a sum factored, by factors that are positive where the parameters lie.

    One in xi alone whose sign changes there is positive at small xi, and (1 - xi)(1 + xi) is 1 - xi^2. A factor of a
    modulus stands outside of it where its sign is known.
    """
    box = box_of(scheme)
    if expression.has(Abs):
        return expression.replace(lambda e: isinstance(e, Abs), lambda e: _modulus(e.args[0], box))
    return Add(*(_positive(term, box) for term in Add.make_args(expression)))


def in_powers(polynomial: Expr, symbols: Symbol | tuple[Symbol, ...], scheme: Scheme) -> Expr:
    """A polynomial in a symbol, or in several, with each coefficient as in a paper."""
    of = Poly(polynomial, symbols)
    powers = ((Mul(*map(Pow, of.gens, k)), c) for k, c in of.terms())
    return Add(*(as_in_paper(factor(c), scheme) * power for power, c in powers))


def _modulus(inner: Expr, box: Mapping[Symbol, Interval]) -> Expr:
    _, known, unknown = _split(inner, box)
    return Mul(*known, Abs(Mul(*unknown)))


def _positive(term: Expr, box: Mapping[Symbol, Interval]) -> Expr:
    sign, known, unknown = _split(term, box)
    product = Mul(sign, *known, *unknown)
    powers = product.as_powers_dict()
    shared = powers[1 - xi]
    return product * ((1 - xi**2) / (1 - xi) / (1 + xi)) ** shared if shared == powers[1 + xi] else product


def _split(term: Expr, box: Mapping[Symbol, Interval]) -> tuple[int, list[Expr], list[Expr]]:
    """A sign, factors that are positive, and those whose sign is not known; their product is the term."""
    kept = {e: Dummy() for e in term.atoms(AppliedUndef, Derivative, Pow, f) if not (e.is_Pow and e.exp.is_Integer)}
    rational = term.xreplace(kept)
    if not rational.is_rational_function():
        return 1, [], [term]
    back = {dummy: e for e, dummy in kept.items()}
    sign, known, unknown = 1, [], []
    for part, exponent in zip(fraction(together(rational)), (1, -1), strict=True):
        number, factors = factor_list(part)[:2]
        for base, power in [(number, 1), *factors]:
            found = sign_on(base, box).value if base.free_symbols <= box.keys() else 0
            turn = found or (-1 if base.free_symbols == {xi} and base.subs(xi, 0) < 0 else 1)
            sign *= turn**power
            (known if found else unknown).append((turn * base).xreplace(back) ** (exponent * power))
    return sign, known, unknown
