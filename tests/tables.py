"""Runge-Kutta tables and weights of compositions, typed from their papers.

A second spelling of the catalogue's: numbers of 50 digits, decimals or closed forms, not the fractions and roots of the
declarations; stages carry both slopes (v, a), no velocity is eliminated. A table is a function of the scheme's
parameters, which returns A, b, c.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mpmath import mp

MP = mp.clone()
MP.dps = 50
Table = tuple[list[list[Any]], list[Any], list[Any]]


def number(text: str) -> Any:
    """A fraction, as printed."""
    top, _, bottom = text.partition("/")
    return MP.mpf(top) / MP.mpf(bottom or 1)


def rows(text: str) -> list[list[Any]]:
    return [[number(x) for x in line.split()] for line in text.strip().splitlines()]


def explicit(text: str, c: str) -> Table:
    """The rows below the diagonal; the last one is b, and the last stage begins the next step."""
    A = [[], *rows(text)]
    return A, A[-1], [number(x) for x in c.split()]


def bogacki_shampine() -> Table:
    return explicit("1/2\n0 3/4\n2/9 1/3 4/9", "0 1/2 3/4 1")


def dormand_prince() -> Table:
    """As scipy.integrate.RK45 has it."""
    from scipy.integrate import RK45

    A = [[MP.mpf(float(x)) for x in row[:i]] for i, row in enumerate(RK45.A)]
    exact = explicit(
        """1/5
        3/40 9/40
        44/45 -56/15 32/9
        19372/6561 -25360/2187 64448/6561 -212/729
        9017/3168 -355/33 46732/5247 49/176 -5103/18656
        35/384 0 500/1113 125/192 -2187/6784 11/84""",
        "0 0.2 0.3 0.8 8/9 1 1",
    )
    typed = [*exact[0][:-1], exact[1]]
    theirs = [*A, [MP.mpf(float(x)) for x in RK45.B]]
    assert all(abs(x - y) < 1e-15 * (1 + abs(y)) for r, q in zip(typed, theirs, strict=True)
               for x, y in zip(r, q, strict=True))  # fmt: skip
    return exact


def butcher6() -> Table:
    """As Butcher prints it, with s for the root of 5; decimals."""
    s = MP.sqrt(5)
    A = [
        [],
        [(5 - s) / 10],
        [-s / 10, (5 + 2 * s) / 10],
        [(-15 + 7 * s) / 20, (-1 + s) / 4, (15 - 7 * s) / 10],
        [(5 - s) / 60, 0, 1 / MP.mpf(6), (15 + 7 * s) / 60],
        [(5 + s) / 60, 0, (9 - 5 * s) / 12, 1 / MP.mpf(6), (-5 + 3 * s) / 10],
        [1 / MP.mpf(6), 0, (-55 + 25 * s) / 12, (-25 - 7 * s) / 12, 5 - 2 * s, (5 + s) / 2],
    ]
    low, high = (5 - s) / 10, (5 + s) / 10
    return A, rows("1/12 0 0 0 5/12 5/12 1/12")[0], [0, low, high, low, high, low, 1]


def sdirk2(gamma: Any) -> Table:
    A = [[gamma], [1 - gamma, gamma]]
    return A, A[-1], [gamma, 1]


def sdirk3(gamma: Any) -> Table:
    """Alexander's b_1 = -(6 a^2 - 16 a + 1)/4, b_2 = (6 a^2 - 20 a + 5)/4 and tau_2 = (1 + a)/2."""
    b = [4 * gamma - 3 * gamma**2 / 2 - MP.mpf("0.25"), 3 * gamma**2 / 2 - 5 * gamma + MP.mpf("1.25"), gamma]
    return [[gamma], [(1 - gamma) / 2, gamma], b], b, [gamma, (1 + gamma) / 2, 1]


def crouzeix3(gamma: Any) -> Table:
    return [[gamma], [1 - 2 * gamma, gamma]], [MP.mpf("0.5")] * 2, [gamma, 1 - gamma]


def crouzeix4(gamma: Any) -> Table:
    half, d = MP.mpf("0.5"), 1 / (6 * (2 * gamma - 1) ** 2)
    return (
        [[gamma], [half - gamma, gamma], [2 * gamma, 1 - 4 * gamma, gamma]],
        [d, 1 - 2 * d, d],
        [gamma, half, 1 - gamma],
    )


def esdirk32(gamma: Any) -> Table:
    """By its conditions: stage order 2 in the third stage, order 2 of weights that end in gamma, and R(oo) = 0."""
    c2, c3 = 2 * gamma, MP.mpf("0.6")
    a32 = c3 * (c3 - 2 * gamma) / (4 * gamma)
    a31 = c3 - gamma - a32
    y = MP.lu_solve(MP.matrix([[gamma, 0], [a32, gamma]]), MP.matrix([gamma, a31]))  # R(oo) = (b_1 - b y)/gamma
    conditions = MP.matrix([[1, 1, 1], [0, c2, c3], [1, -y[0], -y[1]]])
    b = [*MP.lu_solve(conditions, MP.matrix([1 - gamma, MP.mpf(1) / 2 - gamma, 0])), gamma]
    return [[], [gamma, gamma], [a31, a32, gamma], b], b, [0, c2, c3, 1]


def esdirk43() -> Table:
    A, _, c = explicit(
        """1/4 1/4
        8611/62500 -1743/31250 1/4
        5012029/34652500 -654441/2922500 174375/388108 1/4
        15267082809/155376265600 -71443401/120774400 730878875/902184768 2285395/8070912 1/4
        82889/524892 0 15625/83664 69875/102672 -2260/8211 1/4""",
        "0 0.5 0.332 0.62 0.85 1",
    )
    return A, A[-1], c


def sdirk4() -> Table:
    A = rows(
        """1/4 0 0 0 0
        0.5 1/4 0 0 0
        0.34 -0.04 1/4 0 0
        371/1360 -137/2720 15/544 1/4 0
        25/24 -49/48 125/16 -85/12 1/4"""
    )
    return A, A[-1], rows("1/4 3/4 11/20 1/2 1")[0]


def collocation(*c: Any) -> Table:
    """a_ij and b_j are the integrals of Lagrange's polynomials of these instants, from 0 to c_i and to 1."""

    def integrals(to: Any) -> list[Any]:
        """Weights that integrate 1, t, ..., t^(s - 1) exactly."""
        powers = MP.matrix([[MP.mpf(x) ** k for x in c] for k in range(len(c))])
        return [*MP.lu_solve(powers, MP.matrix([MP.mpf(to) ** (k + 1) / (k + 1) for k in range(len(c))]))]

    return [[x if abs(x) > MP.mpf(10) ** -40 else MP.mpf(0) for x in integrals(to)] for to in c], integrals(1), [*c]


def gauss(*roots: Any) -> Table:
    """Collocation at the roots of Legendre's polynomial, which are given for (-1, 1)."""
    return collocation(*((1 + x) / 2 for x in roots))


def lobatto_iiic(*c: Any) -> Table:
    """a_i1 = b_1, and stages that integrate polynomials of degree s - 2 exactly."""
    _, b, _ = collocation(*c)
    size = range(len(c) - 1)
    A = []
    for to in c:
        powers = MP.matrix([[MP.mpf(x) ** k for x in c[1:]] for k in size])
        known = [MP.mpf(to) ** (k + 1) / (k + 1) - b[0] * MP.mpf(c[0]) ** k for k in size]
        A.append([b[0], *MP.lu_solve(powers, MP.matrix(known))])
    return [*A[:-1], b], b, [*c]


def weighted_residual_p2(rho_inf: Any) -> Table:
    """Simpson's weights, and in the middle those that integrate 1 and t exactly and leave rho_inf of R(oo)."""
    A, b, c = ending(collocation(0, MP.mpf(1) / 2, 1))

    def middle(x: Any) -> list[Any]:
        return [w + x * d for w, d in zip(A[1], (1, -2, 1), strict=True)]

    def left(x: Any) -> Any:  # R(oo) is e' (1 - A_11^-1 a_10) for the last stage, which is the end
        row = middle(x)
        return -MP.lu_solve(MP.matrix([row[1:], b[1:]]), MP.matrix([row[0], b[0]]))[1] - rho_inf

    return [A[0], middle(MP.findroot(left, (MP.mpf(-0.02), MP.mpf(-0.06)))), b], b, c


def ending(table: Table) -> Table:
    """With the last row equal to the weights to the last digit, as it is to rounding."""
    A, b, c = table
    assert max(abs(x - y) for x, y in zip(A[-1], b, strict=True)) < MP.mpf(10) ** -45
    return [*A[:-1], b], b, c


@dataclass(frozen=True)
class Nystrom:
    """A table for u'' = g(t, u): damping is left out."""

    A_bar: list[list[Any]]
    b_bar: list[Any]
    b: list[Any]
    c: list[Any]


def rkn43() -> Nystrom:
    """RKN4(3)4FM, of 1987; b_bar is the last row of A_bar."""
    A_bar = [[], *rows("1/32\n7/1000 119/500\n1/14 8/27 25/189")]
    return Nystrom(A_bar, A_bar[-1], rows("1/14 32/81 250/567 5/54")[0], rows("0 1/4 7/10 1")[0])


def rkn64() -> Nystrom:
    """RKN6(4)6FM, of 1987; b_bar is the last row of A_bar."""
    A_bar = [
        [],
        *rows(
            """1/200
            -1/2200 1/22
            637/6600 -7/110 7/33
            225437/1968750 -30073/281250 65569/281250 -9367/984375
            151/2142 5/116 385/1368 55/168 -6250/28101"""
        ),
    ]
    b = rows("151/2142 25/522 275/684 275/252 -78125/112404 1/12")[0]
    return Nystrom(A_bar, A_bar[-1], b, rows("0 1/10 3/10 7/10 17/25 1")[0])


NYSTROM: dict[str, Callable[[], Nystrom]] = {"rkn43": rkn43, "rkn64": rkn64}
# numbers of sub-steps of Stoermer's rule, from whose results u and v are extrapolated
EXTRAPOLATIONS = {"stoermer_extrapolation": (1, 2, 3, 4)}


def extrapolated(values: dict[int, Any]) -> Any:
    """The limit of values at 1, 2, ... sub-steps by the scheme of Aitken and Neville; their errors are even in 1/n."""
    counts, column = sorted(values), [values[n] for n in sorted(values)]
    for k in range(1, len(counts)):
        column = [
            new + (new - old) * counts[i] ** 2 / (counts[i + k] ** 2 - counts[i] ** 2)
            for i, (old, new) in enumerate(itertools.pairwise(column))
        ]
    return column[0]


TABLES: dict[str, tuple[Callable[..., Table], str]] = {
    "bogacki_shampine": (bogacki_shampine, ""),
    "dormand_prince": (dormand_prince, ""),
    "butcher6": (butcher6, ""),
    "sdirk2": (sdirk2, "gamma"),
    "sdirk3": (sdirk3, "gamma"),
    "crouzeix3": (crouzeix3, "gamma"),
    "crouzeix4": (crouzeix4, "gamma"),
    "esdirk32": (esdirk32, "gamma"),
    "esdirk43": (esdirk43, ""),
    "sdirk4": (sdirk4, ""),
    "gauss2": (lambda: gauss(-1 / MP.sqrt(3), 1 / MP.sqrt(3)), ""),
    "gauss3": (lambda: gauss(*(k * MP.sqrt(MP.mpf(3) / 5) for k in (-1, 0, 1))), ""),
    "radau_iia2": (lambda: ending(collocation(MP.mpf(1) / 3, MP.mpf(1))), ""),
    "radau_iia3": (lambda: ending(collocation(*((4 + k * MP.sqrt(6)) / 10 for k in (-1, 1)), MP.mpf(1))), ""),
    "lobatto_iiia3": (lambda: ending(collocation(0, MP.mpf(1) / 2, 1)), ""),
    "weighted_residual_p2": (weighted_residual_p2, "rho_inf"),
    "lobatto_iiic2": (lambda: lobatto_iiic(0, 1), ""),
    "lobatto_iiic3": (lambda: lobatto_iiic(0, MP.mpf(1) / 2, 1), ""),
}


def yoshida6() -> list[Any]:
    """The triple jump of order 6 of that of order 4 (Yoshida, Phys. Lett. A 150 (1990) 262-268)."""

    def jump(order: int) -> list[Any]:
        x = 1 / (2 - MP.mpf(2) ** (MP.mpf(1) / (order + 1)))
        return [x, 1 - 2 * x, x]

    return [outer * inner for outer in jump(4) for inner in jump(2)]


# weights of central differences, one after another
COMPOSITIONS: dict[str, Callable[..., list[Any]]] = {
    "suzuki": lambda weight: [weight, weight, 1 - 4 * weight, weight, weight],
    "forest_ruth": lambda weight: [weight, 1 - 2 * weight, weight],
    "yoshida6": yoshida6,
}


DAMPED_COMPOSITIONS = ("forest_ruth",)


def square(table: Table) -> Table:
    """The table with rows filled up with zeros."""
    A, b, c = table
    return [[*row, *[0] * (len(c) - len(row))] for row in A], [*b, *[0] * (len(c) - len(b))], c


def first_is_start(table: Table) -> bool:
    return not any(table[0][0])


def last_is_end(table: Table) -> bool:
    return table[2][-1] == 1 and list(table[0][-1]) == list(table[1])


def carries_acceleration(name: str) -> bool:
    """Whether the first stage of a step is the last one of the step before."""
    make, parameters = TABLES[name]
    sample = square(make(**dict.fromkeys(parameters.split(), MP.mpf("0.45"))))
    return first_is_start(sample) and last_is_end(sample)


def of(name: str, values: dict[str, Any], kind: Callable[[Any], Any]) -> Table:
    """The table at these values of the parameters, in numbers of this kind."""
    A, b, c = square(TABLES[name][0](**{key: MP.mpf(str(value)) if isinstance(value, float) else MP.mpf(value)
                                        for key, value in values.items()}))  # fmt: skip
    return [[kind(x) for x in row] for row in A], [kind(x) for x in b], [kind(x) for x in c]


def coupled(table: Table) -> bool:
    """Whether stages read later ones."""
    return any(w for i, row in enumerate(table[0]) for w in row[i + 1 :])


def solved(rows: list[list[Any]]) -> list[Any]:
    """The solution of equations, each with its right side at the end, by elimination with the largest pivots."""
    rows, n = [[*row] for row in rows], len(rows)
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        for i in range(n):
            if i != k:
                times = rows[i][k] / rows[k][k]
                rows[i] = [x - times * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [rows[k][n] / rows[k][k] for k in range(n)]
