"""Two filters of a sequence -> the form that their product changes by, but for a sum of squares.

For real polynomials p, q of degree k in the shift E, and any sequence w, p(E) w_n q(E) w_n = V_(n+1) - V_n + sum of
c_j (e_j(E) w_n)^2 with V_n = sum of G_ij w_(n+i) w_(n+j), i, j < k, if Re p(lambda) q(1/lambda) = sum of
c_j |e_j(lambda)|^2 on the unit circle. This holds in every inner product: in that of M, of C and of K.
"""

from collections.abc import Sequence
from math import comb
from typing import Any

from sympy import QQ

Form = list[list[Any]]


def storage(p: Sequence[Any], q: Sequence[Any]) -> Form | None:
    """G (k, k), rational, for k + 1 coefficients of p and of q by ascending powers; None if `squares` finds none."""
    k = len(p) - 1
    both = [[(p[i] * q[j] + p[j] * q[i]) / 2 for j in range(k + 1)] for i in range(k + 1)]
    found = squares([sum(both[i][i + j] for i in range(k + 1 - j)) * (2 if j else 1) for j in range(k + 1)])
    if found is None:
        return None
    for c, e in found:
        for i in range(k + 1):
            for j in range(k + 1):
                both[i][j] -= c * e[i] * e[j]
    G = [[QQ(0)] * k for _ in range(k)]
    for i in range(k):
        for j in range(k):
            G[i][j] = (G[i - 1][j - 1] if i and j else QQ(0)) - both[i][j]
    return G


def squares(cosines: Sequence[Any]) -> list[tuple[Any, list[Any]]] | None:
    """(c, e), c > 0, with sum of c_j cos(j t) = sum of c |e(exp(i t))|^2; e by ascending powers, as many.

    With x = |1 - lambda|^2/4 and y = |1 + lambda|^2/4 = 1 - x it is a sum of products x^i y^j, i + j = k, each of which
    is a square. None if one of their coefficients is negative: where the sum is positive these become positive for
    larger k (Bernstein), which are not tried, so that there may be squares nevertheless.
    """
    k = len(cosines) - 1
    chebyshev = [[QQ(1)], [QQ(1), QQ(-2)]]  # of cos(j t) by powers of x
    while len(chebyshev) <= k:
        last, before = chebyshev[-1], chebyshev[-2]
        chebyshev.append([2 * c for c in _times([QQ(1), QQ(-2)], last)])
        for i, c in enumerate(before):
            chebyshev[-1][i] -= c
    powers = [
        sum((c * T[i] for c, T in zip(cosines, chebyshev, strict=False) if i < len(T)), QQ(0)) for i in range(k + 1)
    ]
    found = []
    for i in range(k + 1):
        c = sum((powers[m] * comb(k - m, i - m) for m in range(i + 1)), QQ(0))
        if c < 0:
            return None
        if c:
            e = [QQ(1)]
            for factor in [[QQ(1), QQ(-1)]] * i + [[QQ(1), QQ(1)]] * (k - i):
                e = _times(e, factor)
            found.append((c / 4**k, e))
    return found


def _times(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    product = [QQ(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            product[i + j] += x * y
    return product
