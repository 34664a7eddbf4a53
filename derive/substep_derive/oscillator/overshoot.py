"""Scheme -> overshoot: how its first step grows as Omega -> oo.

Hilber & Hughes, Earthq. Eng. Struct. Dyn. 6 (1978) 99-117, in the notation U0-V1.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

from ..algebra.points import ring_over
from ..declare.symbols import Omega
from .amplification import Affine
from .evaluation import Evaluation
from .start_up import start_up, stepped


@dataclass(frozen=True)
class Overshoot:
    """Powers of Omega with which u_1 and v_1/omega grow in the scheme's first step as Omega -> oo.

    Undamped, from a unit u_0 and from a unit v_0/omega, each with the consistent a_0: the larger power, at least 0.
    """

    u: int
    v: int

    def __str__(self) -> str:
        return f"U{self.u}-V{self.v}"


def overshoot(evaluation: Evaluation) -> Overshoot:
    """The overshoot of a scheme; for a multi-step scheme that of the first step after the start it declares."""
    ring = ring_over(evaluation.field, Omega)
    x, zero = ring.gens[0], evaluation.field.domain.zero
    one, nothing = (ring.one, ring.one), (ring.zero, ring.one)

    def polynomial(expression: Any) -> Any:
        terms = evaluation.coefficients(expression, zero)
        return ring.from_dict({(power,): c for (power, _), c in terms.items()})

    def apply(affine: Affine, state: Sequence[tuple[Any, Any]], _: object) -> list[tuple[Any, Any]]:
        """Numerators and denominators of N x/den."""
        den, below = polynomial(affine.den), reduce(lambda a, b: a.lcm(b), (d for _, d in state))
        tops = [n * below.exquo(d) for n, d in state]
        rows = [[polynomial(e) for e in affine.N.row(i)] for i in range(affine.N.rows)]
        return [(sum((e * n for e, n in zip(row, tops, strict=True)), ring.zero), den * below) for row in rows]

    found = []
    for given in ((one, nothing, (-(x**2), ring.one)), (nothing, (x, ring.one), nothing)):
        state, _ = start_up(evaluation.amplification, given, apply)
        _, (u, v, _) = stepped(evaluation.amplification, state, apply)
        found.append((_growth(u), _growth(v) - 1))
    return Overshoot(*(max(0, *powers) for powers in zip(*found, strict=True)))


def _growth(ratio: tuple[Any, Any]) -> int:
    """The power of Omega with which a rational function grows; 0 for the function 0."""
    numerator, denominator = ratio
    return numerator.degree() - denominator.degree() if numerator else 0
