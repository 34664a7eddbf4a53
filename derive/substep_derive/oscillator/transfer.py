"""Amplification -> Transfer: the digital filter from a load given at whole steps to the response.

A load that is linear within each step is one number a step, and u, h*v, h^2*a respond to it from rest as
    q_n = -(c_0 q_(n-d) + ... + c_(d-1) q_(n-1))/c_d + h^2 f_n,   u_n = (n_0 q_(n-d) + ... + n_d q_n)/c_d.
Written with differences e_0 = q_n - q_(n-1), e_1 = q_(n-1) - q_(n-2), ..., which keep the digits of small steps:
    e_0 = h^2 f_n - P q_(n-1) + g_1 e_1 + ... + g_(d-1) e_(d-1),   u_n = S (q_n + k_0 e_0 + ... + k_(d-1) e_(d-1)).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, zip_longest

from sympy import Expr, Integer, Matrix, Poly, cancel, prod, zeros

from ..algebra import rational
from ..algebra.expanded import polynomial_in
from ..declare.symbols import lam
from ..step.step import Step
from .amplification import Amplification, Pencil, coefficients
from .one_rule import SQUARE, OneRule, at_oscillator
from .spectrum import live

ORDERS = (2, 3)  # orders of filters for which kernels are printed


@dataclass(frozen=True)
class Transfer:
    """The filter's coefficients, as numerators over den: P, S of u, and g (d - 1 entries).

    k: d entries for each of u, h*v, h^2*a; those of u are multiplied by S, and the S of the other two is 0.
    """

    den: Expr
    P: Expr
    g: tuple[Expr, ...]
    S: Expr
    k: tuple[tuple[Expr, ...], ...]

    @property
    def order(self) -> int:
        """How many steps the filter looks back."""
        return len(self.g) + 1

    @classmethod
    def of(cls, amplification: Amplification, rule: OneRule | None = None) -> "Transfer | None":
        """The filter of a scheme, from R and S of its step if they are given.

        None where the load is taken outside a step, for an order without a kernel, and where the reported values look
        back further than the live eigenvalues.
        """
        scheme = amplification.scheme
        p = live(amplification.charpoly)
        d = p.degree()
        typical = [tau.subs(scheme.typical) for tau in amplification.stencil]
        if d not in ORDERS or any(not 0 <= tau <= 1 for tau in typical):
            return None
        c = _coefficients(p, d)
        rows = _by_rule(rule, amplification.stencil, p) if rule else _numerators(amplification, p)
        if rows is None or any(row.degree() > d for row in rows):
            return None
        lower = list(accumulate(c))
        sums = [list(accumulate(_coefficients(row, d))) for row in rows]
        if any(s[-1].expand() != 0 for s in sums[1:]):
            return None
        k = tuple(tuple(-s[d - 1 - i] for i in range(d)) for s in sums)
        return cls(c[d], lower[-1], tuple(lower[d - 1 - i] for i in range(1, d)), sums[0][-1], k)


def _coefficients(p: Poly, d: int) -> list[Expr]:
    return [p.coeff_monomial(p.gen**j) for j in range(d + 1)]


def _by_rule(rule: OneRule, stencil: Sequence[Expr], p: Poly) -> list[Poly] | None:
    """The same numerators as `_numerators`: u, h*v = (lam - R(L))^-1 (sum of S(L) (0, h^2 f)), and a by the balance.

    Of the first load, that at t_n, each step takes f_n.
    """
    scale = prod(over for _, over in rule.loads)
    total: list[Expr] = []
    for (S, over), tau in zip(rule.loads, (Integer(0), *stencil), strict=True):
        share = cancel(scale / over) * (1 - tau + tau * lam)
        total = [x + share * c for x, c in zip_longest(total, S, fillvalue=Integer(0))]
    D = at_oscillator(tuple(lam * q - n for q, n in zip_longest(rule.den, rule.numerator, fillvalue=Integer(0))))
    norm = (D[0, 0] * D[1, 1] - D[0, 1] * D[1, 0]).expand()
    u, v = (e.expand() for e in D.adjugate() * at_oscillator(tuple(total))[:, 1])
    common = rational.quotient((norm * scale).expand(), p.as_expr())
    assert common is not None
    a = (norm * scale + SQUARE[0] * u + SQUARE[1] * v).expand()
    divided = [rational.quotient(e, common) for e in (u, v, a)]
    return None if None in divided else [polynomial_in(lam, e) for e in divided]


def _numerators(a: Amplification, p: Poly) -> list[Poly] | None:
    """Numerators of u, h*v, h^2*a over the live characteristic polynomial, by Cramer's rule on relations and balances.

    None where another denominator is needed.
    """
    pencil = Pencil.of(a.scheme)
    columns = [*pencil.unknowns, *pencil.state]
    n, size = len(pencil.unknowns), len(pencil.unknowns) + len(pencil.state)
    shift = zeros(len(pencil.state), size)
    for j, after in enumerate(Step.of(a.scheme).after):
        shift[j, n + j] = lam
        shift[j, columns.index(after)] += -1
    outputs = coefficients(Step.of(a.scheme).reported, columns, pencil.stencil)
    weights = Matrix([1 - tau + tau * lam for tau in pencil.stencil])
    system = pencil.new.row_join(pencil.old).col_join(shift)
    load = (-pencil.load * weights).col_join(zeros(len(pencil.state), 1))
    equations = rational.clear_rows(system.row_join(load))
    # outputs belong to the next step, hence lam; other factors shared with the determinant cancel
    common = rational.quotient(lam * rational.determinant(equations[:, :size]), p.as_expr())
    assert common is not None
    found: list[Poly] = []
    for row in range(3):
        own = (-outputs[row, :size]).row_join(outputs[row, size:] * weights).row_join(Matrix([[1]]))
        *border, scale = rational.clear_rows(own)
        numerator = rational.determinant(equations.col_join(Matrix([border])))
        divided = rational.quotient(numerator, common * scale)
        if divided is None:
            return None
        found.append(polynomial_in(lam, divided))
    return found
