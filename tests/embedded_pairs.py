"""Pairs of two orders, declared by hand: Bogacki-Shampine 3(2), Dormand-Prince 5(4), extrapolated Stormer 8(6)."""

from collections.abc import Sequence
from typing import Any

from substep_derive import Balance, Scheme, h, knot
from sympy import Expr, Integer, Rational

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)


def _runge_kutta(name: str, A: Sequence[str], c: str, second: str) -> Scheme:
    """Rows of A; the last stage stands at the end, so that it begins the next step."""
    stages = [knot(0), *(knot(f"k{i}") for i in range(1, len(A))), end]
    rows = [[Rational(x) for x in row.split()] for row in A]
    relations: dict[Any, Expr] = {}
    for stage, row in zip(stages[1:], rows, strict=True):
        relations[stage.u] = u0 + h * sum(x * s.v for x, s in zip(row, stages, strict=False))
        relations[stage.v] = v0 + h * sum(x * s.a for x, s in zip(row, stages, strict=False))
    weights = [Rational(x) for x in second.split()]
    embedded = {
        u1: u0 + h * sum(x * s.v for x, s in zip(weights, stages, strict=True)),
        v1: v0 + h * sum(x * s.a for x, s in zip(weights, stages, strict=True)),
    }
    balances = tuple(Balance.at(s, Rational(x)) for s, x in zip(stages[1:], c.split(), strict=True))
    return Scheme(name, relations=relations, balances=balances, embedded=embedded)


bogacki_shampine = _runge_kutta("pair_3_2", ["1/2", "0 3/4", "2/9 1/3 4/9"], "1/2 3/4 1", "7/24 1/4 1/3 1/8")

dormand_prince = _runge_kutta(
    "pair_5_4",
    [
        "1/5",
        "3/40 9/40",
        "44/45 -56/15 32/9",
        "19372/6561 -25360/2187 64448/6561 -212/729",
        "9017/3168 -355/33 46732/5247 49/176 -5103/18656",
        "35/384 0 500/1113 125/192 -2187/6784 11/84",
    ],
    "1/5 3/10 4/5 8/9 1 1",
    "5179/57600 0 7571/16695 393/640 -92097/339200 187/2100 1/40",
)


def _extrapolated(name: str, counts: Sequence[int]) -> Scheme:
    """Velocity Verlet in 1, 2, ... sub-steps, extrapolated in h^2; the second value leaves the first of them out."""
    relations: dict[Any, Expr] = {}
    balances, ends = [], []
    for n in counts:
        u, v, a = u0, v0, a0
        for k in range(1, n + 1):
            new = knot(f"n{n}k{k}")
            half = h / (2 * n) if k == 1 else h / n  # v of the knots is that in the middle of a sub-step
            relations |= {new.v: v + half * a, new.u: u + h / n * (v + half * a)}
            balances.append(Balance.at(new, Rational(k, n)))
            u, v, a = new
        ends.append((u, v + h / (2 * n) * a))

    def combined(chosen: Sequence[int], kind: int) -> Expr:
        total: Expr = Integer(0)
        for n in chosen:
            weight = Integer(1)
            for m in chosen:
                weight *= Rational(n**2, n**2 - m**2) if m != n else 1
            total += weight * ends[counts.index(n)][kind]
        return total

    relations |= {u1: combined(counts, 0), v1: combined(counts, 1)}
    embedded = {u1: combined(counts[1:], 0), v1: combined(counts[1:], 1)}
    return Scheme(name, relations=relations, balances=(*balances, Balance.at(end, 1)), embedded=embedded)


stormer_8_6 = _extrapolated("pair_8_6", (1, 2, 3, 4))

PAIRS = {bogacki_shampine: 3, dormand_prince: 5, stormer_8_6: 8}  # and the order of the value that is marched
