"""The rows of the reactions of a stage's balances: what they hold, by name, and the order in which they are solved."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from sympy import Abs, Expr, Integer, Matrix, cancel

from ..constrained.explicit import held_next, mean_velocity
from ..declare.branches import slope
from ..declare.symbols import h
from ..motion.components import Writer
from ..step.places import Place
from ..step.step import Step
from ..step.times import instant_of, moved
from .at_knots import AtKnots
from .balance_step import Part
from .reactions import Moving, by_velocity, rows_of
from .remembering import lasting, lasting_at, of_balance, pushed
from .together import Reach

Taken = tuple[Matrix, Place | None, Matrix]  # inertia with the known accelerations, the place that moves, the load


@dataclass(frozen=True)
class HeldRows:
    """The rows of the reactions of each balance of a stage, and their derivatives by the accelerations of the stage.

    held: for each balance the displacement that constraints hold; rate: the velocity at the knot where it takes the
    force; moving: these and what else has names and moves. settled: what is computed of reactions once they are known.
    """

    rows: Sequence[tuple[Matrix, Matrix]] = ()
    held: Sequence[Moving] = ()
    rate: Sequence[Moving] = ()
    moving: Sequence[Moving] = ()
    settled: tuple[Part, ...] = ()

    @classmethod
    def of(
        cls, at: AtKnots, reach: Reach, taken: Sequence[Taken], named: Callable[[str, Matrix, int, str], Matrix]
    ) -> "HeldRows":
        """Those of a stage; named: names of a vector that moves, by its kind, a number and a word."""
        if not at.w.unknown:
            return cls()
        found = [_of_balance(at, number, reach, one, named) for number, one in enumerate(taken)]
        return cls(
            [rows for rows, *_ in found],
            [held for _, (held, *_), _ in found],
            [rate for _, (_, rate, _), _ in found],
            [one for _, moving, _ in found for one in moving],
            tuple(part for *_, settled in found for part in settled),
        )

    def joined(self, at: AtKnots, residual: Matrix, jacobian: Matrix) -> tuple[Matrix, Matrix, Matrix]:
        """Residual and its derivative with these rows, and with columns of the reactions; and the reactions.

        Those of constraints come first. Of balances that are solved together each constraint's rows are in an order in
        which they can be eliminated, as a balance may move what it holds by the other balances' accelerations alone.
        """
        scene, numbers = at.w.motion.scene, range(len(self.rows))
        c, n = len(scene.constraints), len(scene.multipliers)
        pivots = [
            _pivots(at.w, self.rate if at.w.motion.held.at_velocities[j] else self.held) if j < c else numbers
            for j in range(n)
        ]
        order = [(k, j) for places in (range(c), range(c, n)) for k in numbers for j in places]
        of_balances = [of_balance(scene, k) for k in at.balances]
        unknown = Matrix([of_balances[k][j] for k, j in order])
        chosen = [(self.rows[pivots[j][k]], j) for k, j in order]
        shifts = self.rows[0][0].rows - n  # of constraints that hold displacements and velocities alike
        chosen += [(self.rows[0], n + j) for j in range(shifts)]
        whole = Matrix([*residual, *(rows[j] for (rows, _), j in chosen)])
        left = Matrix.vstack(jacobian, *(by_z[j, :] for (_, by_z), j in chosen))
        return whole, Matrix.hstack(left, Matrix([[slope(e, s) for s in unknown] for e in whole])), unknown


def _pivots(w: Writer, held: Sequence[Moving]) -> list[int]:
    """The order of the balances whose elimination has the largest pivots, at typical parameters."""
    typical = {**w.scheme.typical, h: Integer(1)}
    left = {k: [e.subs(dict(w.constants)).subs(typical) for e in one.each] for k, one in enumerate(held)}
    found = list[int]()
    for column in range(len(held)):
        best = max(left, key=lambda k: (Abs(left[k][column]), -k))
        pivot = left.pop(best)
        found.append(best)
        for k, row in left.items():
            factor = cancel(row[column] / pivot[column])
            left[k] = [cancel(x - factor * y) for x, y in zip(row, pivot, strict=True)]
    return found


Found = tuple[tuple[Matrix, Matrix], tuple[Moving, Moving, Moving], Iterable[Part]]


def _of_balance(
    at: AtKnots, number: int, reach: Reach, taken: Taken, named: Callable[[str, Matrix, int, str], Matrix]
) -> Found:
    """The rows of a balance, by its place in the stage; what they hold; and what is computed of reactions after that.

    The second is the displacement that constraints hold, the velocity at the knot where the balance takes the force,
    and that which contacts and frictions hold, by the names that `named` has given them.
    """
    w, k, (inertia, place, _) = at.w, at.balances[number], taken
    step, unknown = Step.of(w.scheme), of_balance(w.motion.scene, k)
    assert place is not None
    s, velocity = moved(step, k)
    where = held = Moving(w.components(s), reach.get(s, [Integer(0)] * len(at.balances)), number, w.when(s))
    if w.holding and w.holding[k] not in reach:
        u = w.holding[k]
        whole, when = at.in_z(held_next(step, u)), w.instant(w.instants[u] + int(u in step.prior))
        held = Moving(named("u", whole, number, "held"), at.by_z(whole), number, when)

    def of_velocity(e: Expr, label: str) -> Moving:
        whole = at.in_z(e)
        by_z = at.by_z(whole)
        return Moving(named("v", whole, number, label) if any(by_z) else whole, by_z, number, where.when)

    own = any(w.motion.held.at_velocities) or (at.stage.moved and by_velocity(w.motion))
    rate = of_velocity(velocity if own else Integer(0), "held")
    later = (w.motion.scene.contacts or w.motion.scene.frictions) and not at.stage.moved
    mean = of_velocity(mean_velocity(step, k, w.holding[k]), "mean") if later else rate
    rows = rows_of(w, k, at.stage, unknown, (held, where, rate, mean))
    if not w.strengths:
        w.reactions[s] = unknown
        return rows, (held, rate, mean), ()
    v, share = velocity if place.u == s else place.v, place.weight / at.by_z(inertia)[number]
    kept = lasting(w, k, (place.u, instant_of(place.u, w.instants)), at.in_z(place.u), at.in_z(v))
    w.reactions[s] = lasting_at(w.motion.scene, k)
    push = pushed(w, k, where.names, where.when, unknown, w.constant(share))
    return rows, (held, rate, mean), (*kept, *push)
