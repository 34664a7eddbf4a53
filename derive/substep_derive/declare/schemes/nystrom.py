"""Runge-Kutta-Nystrom schemes for u'' = g(t, u): explicit, without damping."""

from fractions import Fraction
from math import prod

from sympy import Rational, oo

from ..published import Published
from ..tableau import nystrom

_Q = Rational

_b_bar = (_Q(1, 14), _Q(8, 27), _Q(25, 189), 0)

rkn43 = nystrom(
    "rkn43",
    A_bar=((), (_Q(1, 32),), (_Q(7, 1000), _Q(119, 500)), _b_bar),
    b_bar=_b_bar,
    b=(_Q(1, 14), _Q(32, 81), _Q(250, 567), _Q(5, 54)),
    c=(0, _Q(1, 4), _Q(7, 10), 1),
    b_bar_hat=(_Q(-7, 150), _Q(67, 150), _Q(3, 20), _Q(-1, 20)),
    b_hat=(_Q(13, 21), _Q(-20, 27), _Q(275, 189), _Q(-1, 3)),
    reference="Dormand, El-Mikkawy & Prince, IMA J. Numer. Anal. 7 (1987) 235-250, RKN4(3)4FM",
    published=Published("Dormand, El-Mikkawy & Prince (1987)", 4, oo),
).known_as("runge_kutta_nystrom")

_b_bar = (_Q(151, 2142), _Q(5, 116), _Q(385, 1368), _Q(55, 168), _Q(-6250, 28101), 0)

rkn64 = nystrom(
    "rkn64",
    A_bar=(
        (),
        (_Q(1, 200),),
        (_Q(-1, 2200), _Q(1, 22)),
        (_Q(637, 6600), _Q(-7, 110), _Q(7, 33)),
        (_Q(225437, 1968750), _Q(-30073, 281250), _Q(65569, 281250), _Q(-9367, 984375)),
        _b_bar,
    ),
    b_bar=_b_bar,
    b=(_Q(151, 2142), _Q(25, 522), _Q(275, 684), _Q(275, 252), _Q(-78125, 112404), _Q(1, 12)),
    c=(0, _Q(1, 10), _Q(3, 10), _Q(7, 10), _Q(17, 25), 1),
    b_bar_hat=(
        *(_Q(1349, 157500), _Q(7873, 50000), _Q(192199, 900000)),
        *(_Q(521683, 2100000), _Q(-16, 125), 0),
    ),
    b_hat=(
        *(_Q(1349, 157500), _Q(7873, 45000), _Q(27457, 90000)),
        *(_Q(521683, 630000), _Q(-2, 5), _Q(1, 12)),
    ),
    reference="Dormand, El-Mikkawy & Prince, IMA J. Numer. Anal. 7 (1987) 235-250, RKN6(4)6FM",
    published=Published("Dormand, El-Mikkawy & Prince (1987)", 6, oo),
).known_as("runge_kutta_nystrom")


def _stoermer(counts: tuple[int, ...]) -> tuple[list[list[Fraction]], list[Fraction]]:
    """A_bar and c of Stoermer's rule with H/n, for each n: the common start, then n stages at H/n, 2H/n, ..., H."""
    size = 1 + sum(counts)
    A_bar, c, first = [[Fraction(0)] * size], [Fraction(0)], 1
    for n in counts:
        for j in range(1, n + 1):
            row = [Fraction(0)] * size
            row[0] = Fraction(j, 2 * n * n)
            for k in range(1, j):
                row[first + k - 1] = Fraction(j - k, n * n)
            A_bar.append(row)
            c.append(Fraction(j, n))
        first += n
    return A_bar, c


def _extrapolated(counts: tuple[int, ...], used: tuple[int, ...]) -> tuple[list[Fraction], list[Fraction]]:
    """b_bar and b of the values at H, extrapolated to n = oo from the counts used, whose errors are even in 1/n."""
    A_bar, _ = _stoermer(counts)
    b_bar, b, first = [Fraction(0)] * len(A_bar), [Fraction(0)] * len(A_bar), 1
    for n in counts:
        if n in used:
            share = prod((Fraction(n * n, n * n - m * m) for m in used if m != n), start=Fraction(1))
            for k, entry in enumerate(A_bar[first + n - 1]):
                b_bar[k] += share * entry
            b[0] += share / (2 * n)
            for k in range(1, n + 1):
                b[first + k - 1] += share * Fraction(1, 2 * n if k == n else n)
        first += n
    return b_bar, b


_counts = (1, 2, 3, 4)
_A_bar, _c = _stoermer(_counts)
_b_bar, _b = _extrapolated(_counts, _counts)
_b_bar_hat, _b_hat = _extrapolated(_counts, _counts[1:])

stoermer_extrapolation = nystrom(
    "stoermer_extrapolation",
    A_bar=[*([*row, 0] for row in _A_bar), [*_b_bar, 0]],
    b_bar=[*_b_bar, 0],
    b=[*_b, 0],
    c=[*_c, 1],
    b_bar_hat=[*_b_bar_hat, 0],
    b_hat=[*_b_hat, 0],
    reference="Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.14, (14.32)-(14.34), "
    "1, 2, 3, 4 sub-steps; embedded: 2, 3, 4",
    published=Published("Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.14", 8, oo),
).known_as("odex2", "gragg_bulirsch_stoer")

ALL = (rkn43, rkn64, stoermer_extrapolation)
