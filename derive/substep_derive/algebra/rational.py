"""Exact linear algebra over rational functions: with `elimination` the only file that touches sympy.polys, and cse.

Everything is kept as polynomial numerators over one common denominator, so that nothing has to be
simplified after it was built. Where an algebraic constant occurs, `constant.Polynomials` does the same over its field.
"""

from collections.abc import Sequence
from functools import lru_cache
from math import lcm
from typing import Any

from sympy import QQ, ZZ, Expr, Integer, Matrix, Poly, Symbol, factor, ring
from sympy import cse as sympy_cse
from sympy.polys.matrices import DomainMatrix

from . import elimination
from .constant import Constant, Polynomials
from .expanded import coefficients, expanded_terms, polynomial_in, terms

SingularMatrix = elimination.SingularMatrix


def _rational(matrix: Matrix) -> DomainMatrix:
    """The matrix over the rational functions with integer coefficients, common factors cancelled."""
    symbols = sorted(matrix.free_symbols, key=str)
    domain = ZZ.frac_field(*symbols) if symbols else QQ
    return DomainMatrix([[_read(e, symbols, domain) for e in row] for row in matrix.tolist()], matrix.shape, domain)


def _read(e: Expr, symbols: Sequence[Symbol], domain: Any) -> Any:
    """A rational function with rational coefficients as an element of the domain of `_rational`."""
    found = expanded_terms(e, symbols) if symbols else None
    if found is None:
        return domain.from_sympy(e)
    den = lcm(*(int(c.denominator) for c in found.values()))
    numerator = domain.field.ring.from_dict({powers: ZZ(int(c * den)) for powers, c in found.items()})
    return domain.field.raw_new(numerator, domain.field.ring.ground_new(ZZ(den)))


def _cleared(matrix: Matrix) -> DomainMatrix:
    """`clear_rows` in SymPy's fast representation of matrices."""
    return _rational(matrix).clear_denoms_rowwise(convert=True)[1]


def clear_rows(matrix: Matrix) -> Matrix:
    """The matrix with each row multiplied by its common denominator, so that its entries are polynomials."""
    if over_field := Polynomials.of([*matrix]):
        rows = over_field.cleared(matrix)
        return Matrix([[over_field.expression(e) for e in row] for row in rows])
    return _cleared(matrix).to_Matrix()


def solve(matrix: Matrix, right: Matrix) -> tuple[Matrix, Expr]:
    """(numerators, den) with matrix * numerators/den = right, common factors cancelled.

    Raises SingularMatrix for a singular matrix.
    """
    if over_field := Polynomials.of([*matrix, *right]):
        return over_field.solve(matrix, right)
    rows, domain = _over_field(matrix.row_join(right))
    found, den = elimination.solution(rows, matrix.cols, domain)
    over_ZZ = domain.set_domain(ZZ)
    scale = QQ(lcm(*(int(c.denominator) for row in (*found, [den]) for e in row for c in e.values())))
    (*rows, [den]) = [[over_ZZ.convert(e.mul_ground(scale), domain) for e in row] for row in (*found, [den])]
    numerators, den = DomainMatrix(rows, (len(rows), right.cols), over_ZZ).cancel_denom(den)
    return numerators.to_Matrix(), over_ZZ.to_sympy(den)


def cancelled(numerators: Matrix, den: Expr) -> tuple[Matrix, Expr]:
    """(numerators, den) of a matrix numerators/den, common factors cancelled."""
    if not numerators.rows:
        return numerators, Integer(1)
    if over_field := Polynomials.of([*numerators, den]):
        return over_field.cancelled(numerators, den)
    both = _cleared(Matrix([[*numerators, den]]))
    ((*entries, below),) = both.to_list()
    rows = [entries[i * numerators.cols : (i + 1) * numerators.cols] for i in range(numerators.rows)]
    found, below = DomainMatrix(rows, numerators.shape, both.domain).cancel_denom(below)
    return found.to_Matrix(), both.domain.to_sympy(below)


def in_factors(numerators: Matrix, den: Expr) -> Matrix:
    """The entries of a matrix numerators/den of polynomials without constants, common factors of each cancelled."""
    both = _cleared(Matrix([[*numerators, den]]))
    if not both.domain.is_Poly:
        return numerators / den
    ((*entries, below),) = both.to_list()
    pairs = (map(both.domain.to_sympy, e.cancel(below)) for e in entries)
    return Matrix(*numerators.shape, [factor(above / below) for above, below in pairs])


def common_denominator(matrix: Matrix) -> tuple[Matrix, Expr]:
    """(numerators, den) of a matrix of rational functions, common factors cancelled."""
    if not matrix.rows:
        return matrix, Integer(1)
    if over_field := Polynomials.of([*matrix]):
        return over_field.common_denominator(matrix)
    den, numerators = _rational(matrix).clear_denoms(convert=True)
    return numerators.to_Matrix(), numerators.domain.to_sympy(den.element)


def determinant(matrix: Matrix) -> Expr:
    """The determinant, each row cleared of its denominators."""
    if over_field := Polynomials.of([*matrix]):
        return over_field.determinant(matrix)
    rows, domain = _over_field(matrix)
    return domain.to_sympy(elimination.determinant(rows, domain))


def _over_field(matrix: Matrix) -> tuple[list[list[Any]], Any]:
    """The rows of `_cleared` over the rationals, and their domain; an unused symbol where there are none."""
    cleared = _cleared(matrix)
    domain = QQ.poly_ring(*(getattr(cleared.domain, "symbols", ()) or [Symbol("unused")]))
    return [[domain.convert(e, cleared.domain) for e in row] for row in cleared.to_list()], domain


def same(a: Matrix, b: Matrix) -> bool:
    """Whether two matrices of rational functions are equal."""
    difference = a - b
    if over_field := Polynomials.of([*difference]):
        return not any(over_field.fraction(e)[0] for e in difference)
    return bool(_rational(difference).is_zero_matrix)


def quotient(a: Expr, b: Expr) -> Expr | None:
    """The quotient a/b of two polynomials, None where b does not divide a."""
    if over_field := Polynomials.of([a, b]):
        return over_field.quotient(a, b)
    symbols = sorted(a.free_symbols | b.free_symbols, key=str)
    above, below = (Poly.from_dict(terms(e, symbols), *symbols, domain=QQ) for e in (a, b))
    found, rest = above.div(below)
    return found.as_expr() if rest.is_zero else None


def primitive(expression: Expr, variable: Symbol) -> Poly:
    """The expression as a polynomial in one variable, without the factors its coefficients share."""
    if over_field := Polynomials.of([expression], variable):
        return over_field.primitive(expression, variable)
    return polynomial_in(variable, expression).clear_denoms(convert=True)[1].primitive()[1]


def polynomial_ring(symbols: Sequence[Symbol]) -> tuple[Any, ...]:
    """Sparse polynomials over the rationals: the ring and its generators."""
    return ring(list(symbols), QQ)


class RationalFunctions:
    """The field of rational functions in some symbols, over Q or that of a constant; Q itself if there are none."""

    def __init__(self, symbols: Sequence[Symbol], constant: Constant | None = None) -> None:
        """Raises ValueError for a constant without symbols: its field is `algebraic.Field`."""
        if constant is not None and not symbols:
            raise ValueError(f"expected symbols besides the constant {constant}; take the field of its number")
        self._polynomials = None if constant is None else Polynomials(constant, symbols)
        over = QQ if self._polynomials is None else self._polynomials.field.domain
        self.domain: Any = over.frac_field(*sorted(symbols, key=str) if constant else symbols) if symbols else QQ

    def number(self, value: Expr) -> Any:
        """A rational function as an element of the field."""
        if self._polynomials is None:
            return self.domain.from_sympy(value)
        numerator, den = (self.domain.convert(e, self._polynomials.domain) for e in self._polynomials.fraction(value))
        return numerator / den

    def expression(self, number: Any) -> Expr:
        """An element as an expression."""
        if self._polynomials is None:
            return self.domain.to_sympy(number)
        parts = (self._polynomials.domain.convert(e) for e in (number.numer, number.denom))
        numerator, den = map(self._polynomials.expression, parts)
        return numerator / den


def factored(polynomial: Expr) -> Expr:
    """The polynomial in factors; a single term is left as it is."""
    return factor(polynomial) if polynomial.is_Add else polynomial


def slopes(expressions: Sequence[Expr], symbols: Sequence[Symbol]) -> Matrix:
    """The matrix of the derivatives of expressions by symbols, most of which do not occur in most of them."""
    held = [e.free_symbols for e in expressions]
    return Matrix(
        len(expressions),
        len(symbols),
        lambda i, j: expressions[i].diff(symbols[j]) if symbols[j] in held[i] else Integer(0),
    )


@lru_cache(maxsize=512)  # docstrings and functions of a module show the same entries
def horner(expression: Expr, variable: Symbol) -> Expr:
    """Nested form in one variable with factored coefficients: few operations, few digits lost."""
    nested: Expr = Integer(0)
    for coefficient in coefficients(expression, variable):
        nested = nested * variable + factored(coefficient)
    return nested


def cse(expressions: Sequence[Expr], names: str = "x") -> tuple[list[tuple[Symbol, Expr]], list[Expr]]:
    """Common subexpression elimination, in an order that is the same in every session."""
    counter = (Symbol(f"{names}{i}") for i in range(10**6))
    return sympy_cse(list(expressions), symbols=counter, order="canonical")


def matrix_inverse(rows: Sequence[Sequence[Any]], domain: Any) -> list[list[Any]]:
    """The inverse of a square matrix of elements of a field. Raises SingularMatrix."""
    n = len(rows)
    return DomainMatrix([list(row) for row in rows], (n, n), domain).inv().to_list() if n else []


def affine_solutions(
    rows: Sequence[Sequence[Any]], right: Sequence[Any], columns: int, domain: Any
) -> tuple[list[Any], list[list[Any]]] | None:
    """(one solution, basis of the solutions of the homogeneous system) of rows * x = right; None where there is none.

    Elements are from a field. The first solution is 0 in the unknowns that the others leave free.
    """
    zero, one = domain.zero, domain.one
    if not rows:
        return [zero] * columns, [[one if i == j else zero for j in range(columns)] for i in range(columns)]
    augmented = [[*row, value] for row, value in zip(rows, right, strict=True)]
    reduced, pivots = DomainMatrix(augmented, (len(augmented), columns + 1), domain).rref()
    if columns in pivots:
        return None
    entries = reduced.to_list()
    particular = [zero] * columns
    for i, pivot in enumerate(pivots):
        particular[pivot] = entries[i][columns]
    basis = []
    for free in (j for j in range(columns) if j not in pivots):
        vector = [zero] * columns
        vector[free] = one
        for i, pivot in enumerate(pivots):
            vector[pivot] = -entries[i][free]
        basis.append(vector)
    return particular, basis


def polynomial_roots_modulo(polynomial: Poly, p: int) -> list[int]:
    """The roots of a polynomial with integer coefficients among the remainders modulo a prime that does not divide
    its first one.
    """
    reduced = Poly(polynomial.as_expr(), polynomial.gen, modulus=p)
    linear = [factor for factor, _ in reduced.factor_list()[1] if factor.degree() == 1]
    return sorted(int(-factor.TC() * pow(int(factor.LC()), -1, p)) % p for factor in linear)
