"""Expanded polynomials read term by term: SymPy's own reading would expand them again.

What is not a sum of products of numbers and powers of symbols is left to SymPy.
"""

from collections.abc import Sequence
from math import prod
from typing import Any

from sympy import QQ, ZZ, Add, Expr, Mul, Poly, Symbol, ring

Monomial = tuple[int, ...]


def terms(polynomial: Expr, symbols: Sequence[Symbol]) -> dict[Monomial, Any]:
    """Powers of the symbols -> coefficient, a number of QQ other than 0, of a polynomial in these symbols alone.

    Raises SymPy's PolynomialError or CoercionFailed for anything else.
    """
    found = _multiplied_out(polynomial, symbols)
    if found is not None:
        return found
    read = Poly(polynomial, *symbols, domain=QQ).terms()
    return {powers: QQ(int(c.p), int(c.q)) for powers, c in read if c}


def _multiplied_out(polynomial: Expr, symbols: Sequence[Symbol]) -> dict[Monomial, Any] | None:
    """The terms of sums and products of expanded polynomials; None for anything else."""
    found = expanded_terms(polynomial, symbols)
    if found is not None or not (polynomial.is_Add or polynomial.is_Mul) or not symbols:
        return found
    parts = []
    for part in polynomial.args:
        if (read := _multiplied_out(part, symbols)) is None:
            return None
        parts.append(read)
    if polynomial.is_Mul:
        over = ring(list(symbols), QQ)[0]
        return dict(prod(map(over.from_dict, parts), start=over.one))
    total: dict[Monomial, Any] = {}
    for powers, value in (term for part in parts for term in part.items()):
        total[powers] = total[powers] + value if powers in total else value
    return {powers: value for powers, value in total.items() if value}


def expanded_terms(polynomial: Expr, symbols: Sequence[Symbol]) -> dict[Monomial, Any] | None:
    """The same of an expanded polynomial; None for what is not, or is no polynomial in these symbols alone."""
    place = {s: i for i, s in enumerate(symbols)}
    found: dict[Monomial, Any] = {}
    for term in Add.make_args(polynomial):
        powers, value = [0] * len(symbols), QQ.one
        for factor in Mul.make_args(term):
            if factor.is_Rational:
                value *= QQ(int(factor.p), int(factor.q))
                continue
            base, power = (factor.base, factor.exp) if factor.is_Pow else (factor, 1)
            if base not in place or not (factor.is_Symbol or _is_power(factor)):
                return None
            powers[place[base]] += int(power)
        key = tuple(powers)
        found[key] = found[key] + value if key in found else value
    return {powers: value for powers, value in found.items() if value}


def polynomial_in(variable: Symbol, expression: Expr) -> Poly:
    """SymPy's `Poly(expression, variable)`, over the polynomials in the other symbols, in the order that SymPy has."""
    others = expression.free_symbols - {variable}
    symbols = Poly(Add(*others)).gens if others else ()
    found = expanded_terms(expression, (variable, *symbols))
    if not found:
        return Poly(expression, variable)
    numbers = ZZ if all(value.denominator == 1 for value in found.values()) else QQ
    by_power: dict[Monomial, dict[Monomial, Any]] = {}
    for (power, *rest), value in found.items():
        by_power.setdefault((power,), {})[tuple(rest)] = numbers.convert(value, QQ)
    if not symbols:
        return Poly.from_dict({power: part[()] for power, part in by_power.items()}, variable, domain=numbers)
    domain = numbers.poly_ring(*symbols)
    read = {power: domain.ring.from_dict(part) for power, part in by_power.items()}
    return Poly.from_dict(read, variable, domain=domain)


def _is_power(factor: Expr) -> bool:
    """Whether it is a symbol to the power of a positive whole number."""
    return bool(factor.is_Pow and factor.base.is_Symbol and factor.exp.is_Integer and factor.exp > 0)


def coefficients(polynomial: Expr, variable: Symbol) -> list[Expr]:
    """The coefficients of a polynomial's powers of one variable, expanded, the highest first; of 0, a single 0.

    Other symbols may stand anywhere in them but in a denominator.
    """
    parts: dict[int, list[Expr]] = {}
    for term in Add.make_args(polynomial):
        power, others = 0, []
        for factor in Mul.make_args(term):
            if factor == variable:
                power += 1
            elif _is_power(factor) and factor.base == variable:
                power += int(factor.exp)
            elif factor.is_Rational or factor.is_Symbol or _is_power(factor):
                others.append(factor)
            else:
                return Poly(polynomial, variable).all_coeffs()
        parts.setdefault(power, []).append(Mul(*others))
    return [Add(*parts.get(k, ())) for k in range(max(parts), -1, -1)]
