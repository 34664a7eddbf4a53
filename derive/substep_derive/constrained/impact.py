"""Step -> the velocity with which a mass point leaves a stop, exactly, by the phase of the impact within the step.

A point without forces meets a stop with the velocity 1, a share phi of a step after t_n. Until a contact opens or
closes, its state is affine in phi, so that every balance divides the phases into those where it is open and those where
it is closed, and the velocity in the end is affine in phi on each of the pieces.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sympy import Expr, Integer, Symbol

from ..algebra.field_matrices import field_matrix, identity
from ..declare.catalogue import find
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import kind_of, steps_back, successor
from ..oscillator.evaluation import Evaluation
from .explicit import explicit, require_held
from .prescribed import StepRows, prescribed_at

LONGEST, MOST = 60, 64  # steps that are followed, and pieces that the phases may have
phi = Symbol("phi")

Affine = tuple[Any, Any]  # numbers a, b of a + b*phi


@dataclass(frozen=True)
class Piece:
    """Phases from low to high, in steps after t_n, and the velocity for them, affine in phi."""

    low: Expr
    high: Expr
    velocity: Expr


@dataclass(frozen=True)
class Impact:
    """What a scheme makes of an impact with the velocity 1, without restitution: see `Contact`.

    pieces: of all phases, from 0 to 1, or to the last displacement that a step holds where that is beyond 1, so that a
    step meets the stop that begins more than a step before it. least, most: bounds of the velocities. gains: the share
    of phases that leave with more than 1, and so with more energy.
    """

    scheme: Scheme
    remembered: bool
    pieces: tuple[Piece, ...]
    least: Expr
    most: Expr
    gains: Expr

    def __str__(self) -> str:
        """In a line, to three digits."""
        share = f"gains energy at {100 * float(self.gains):.3g} % of the phases" if self.gains else "never gains energy"
        return f"leaves with {float(self.least):.3g} to {float(self.most):.3g}; {share}"


def impact(scheme: str | Scheme, *, remembered: bool = False, **parameters: Any) -> Impact:
    """A scheme of the catalogue by name, or a declaration, at an impact.

    remembered: as of `Contact`. Parameters are exact, and those that are left out have their defaults, as for
    `certify`. Raises DeclarationError for an explicit scheme that does not move on with what an impact leaves, and as
    `prescribed`; ValueError as `certify` for parameters.

    >>> found = impact("average_acceleration")
    >>> [(piece.low, piece.high, piece.velocity) for piece in found.pieces]
    [(0, 1/2, 1 - 2*phi), (1/2, 1, 2*phi - 1)]
    """
    return _Impact(Evaluation.at(ParameterSet.of(find(scheme), None, parameters)), remembered).found


class _Impact:
    """Follows all phases at once; numbers are of the field of the scheme's parameters."""

    def __init__(self, at: Evaluation, remembered: bool) -> None:
        self.rows, self.field = StepRows(at), at.field
        self.remembered = remembered or explicit(self.rows.step)  # as reactions of explicit balances are
        self.one, self.m = self.rows.one, len(self.rows.z)
        self.zero = self.one - self.one
        self.reactions = list(self.rows.reactions.values())[len(self.rows.carried) :]
        self.held = [row for *_, row in self.rows.held]
        if not all(stage.alone for stage in self.rows.step.stages):
            raise DeclarationError(
                f"{at.scheme.name} solves balances together: expected balances that are solved one after the other; "
                "take another scheme"
            )
        if explicit(self.rows.step):
            require_held(self.rows.step, prescribed_at(at), bounded=True, gaps=True)
        if not any(u in self.rows.step.reported for u, *_ in self.rows.held):
            raise DeclarationError(
                f"{at.scheme.name} takes no force at the end of its steps: expected one that holds the displacement "
                "there; take another scheme"
            )

    @property
    def found(self) -> Impact:
        """The result."""
        expression, scheme = self.rows.expression, self.rows.at.scheme
        pieces = list[tuple[Any, Any, Affine]]()
        for low, high, velocity in self._followed:
            if pieces and pieces[-1][2] == velocity:
                pieces[-1] = (pieces[-1][0], high, velocity)
            else:
                pieces.append((low, high, velocity))
        ends = [v for low, high, (a, b) in pieces for v in (a + b * low, a + b * high)]
        gains = self.zero
        for low, high, velocity in pieces:
            gains += sum((y - x for x, y in self._above(low, high, velocity)), self.zero)
        least, most = self._least(ends), -self._least([-v for v in ends])
        return Impact(
            scheme, self.remembered,
            tuple(Piece(expression(x), expression(y), expression(a) + expression(b) * phi) for x, y, (a, b) in pieces),
            expression(least), expression(most), expression(gains),
        )  # fmt: skip

    @cached_property
    def last(self) -> Any:
        """The last time at which a step holds a displacement, in steps: 1, unless it is beyond, or the next step's."""
        return -self._least([-self.one, *(-tau for _, tau, _ in self.rows.held)])

    def _start(self) -> list[Affine]:
        """The state at t_n of a motion with the velocity -1 that meets the stop at phi."""
        state = list[Affine]()
        for s in self.rows.step.state:
            back = self.rows.number(Integer(1) * steps_back(s))
            state.append([(back, self.one), (-self.one, self.zero), (self.zero, self.zero)][kind_of(s)])
        return state + [(self.zero, self.zero)] * len(self.rows.carried)

    @property
    def _followed(self) -> list[tuple[Any, Any, Affine]]:
        """Pieces of the phases in order, each until all balances have been open for more steps than a state holds.

        Raises DeclarationError for more pieces than `MOST` or steps than `LONGEST`, where impacts do not end.
        """
        left, found = [(self.last - self.one, self.last, self._start(), 0, 0)], []
        while left:
            low, high, state, steps, apart = left.pop(0)
            velocity = self._sum(self.leaving, state)
            away = apart > len(state) and all(self.field.sign(velocity[0] + velocity[1] * x) >= 0 for x in (low, high))
            if away:
                found.append((low, high, velocity))
                continue
            pieces = self._balances(low, high, state, [], True)
            left = [
                (x, y, self._after(state, z), steps + 1, (apart + 1) * is_open) for x, y, z, is_open in pieces
            ] + left
            if len(left) + len(found) > MOST or steps == LONGEST:
                raise DeclarationError(
                    f"{self.rows.at.scheme.name}: expected impacts that end, got more than {MOST} pieces of the "
                    f"phases, or more than {LONGEST} steps; take another scheme"
                )
        return found

    def _balances(self, low: Any, high: Any, state: Sequence[Affine], z: list[Affine], is_open: bool) -> list[Any]:
        """Phases, with the accelerations z of the balances, and whether all of these are open."""
        k = len(z)
        if k == self.m:
            return [(low, high, z, is_open)]
        free = self._solved(self.reactions[k], z, state)
        gap = self._sum(self.held[k], [*z, free, *[(self.zero, self.zero)] * (self.m - k - 1), *state])
        found = []
        for x, y in self._pieces(low, high, gap):
            middle = gap[0] + gap[1] * (x + y) / 2
            stays = self.field.sign(middle) >= 0
            new = free if stays else self._solved(self.held[k], z, state)
            found += self._balances(x, y, state, [*z, new], is_open and stays)
        return found

    def _solved(self, row: Sequence[Any], z: Sequence[Affine], state: Sequence[Affine]) -> Affine:
        """The acceleration of the next balance by which a row is 0."""
        k = len(z)
        rest = self._sum(row, [*z, *[(self.zero, self.zero)] * (self.m - k), *state])
        return -rest[0] / row[k], -rest[1] / row[k]

    def _after(self, state: Sequence[Affine], z: Sequence[Affine]) -> list[Affine]:
        whole = [*z, *state]
        return [self._sum(row, whole) for row in self.next]

    @cached_property
    def next(self) -> list[list[Any]]:
        """Rows of the next state over the accelerations and the state."""
        rows, found = self.rows, []
        for s in rows.step.state:
            row = list(rows.rows[successor(s)])
            if kind_of(s) == 2 and not self.remembered:
                for k, balance in enumerate(rows.at.scheme.balances):
                    inertia = rows.row(balance.inertia)
                    row = [x - rows.rows[successor(s)][k] * y / inertia[k] for x, y in zip(row, inertia, strict=True)]
            found.append(row)
        nothing = [self.zero] * len(rows.basis)
        return found + [rows.reactions[rows.later[p]] if self.remembered else nothing for p in rows.carried]

    @cached_property
    def leaving(self) -> list[Any]:
        """The velocity that a motion from a state has in the end without a stop: what no step changes, as a row."""
        m, n, domain = self.m, len(self.rows.state), self.field.domain
        by_z = field_matrix([row[:m] for row in self.reactions], domain)
        of_state = -by_z.inv() * field_matrix([row[m:] for row in self.reactions], domain)
        after = field_matrix([row[:m] for row in self.next], domain) * of_state
        after += field_matrix([row[m:] for row in self.next], domain)
        (kept,) = (after.transpose() - identity(n, domain)).nullspace().to_list()
        uniform = [self._moving(s) for s in self.rows.step.state] + [self.zero] * len(self.rows.carried)
        scale = sum((x * y for x, y in zip(kept, uniform, strict=True)), self.zero)
        return [x / scale for x in kept]

    def _moving(self, s: Symbol) -> Any:
        """A symbol of the state in a motion with the velocity 1 that is at 0 at t_n."""
        return [-self.rows.number(Integer(1) * steps_back(s)), self.one, self.zero][kind_of(s)]

    def _pieces(self, low: Any, high: Any, value: Affine) -> list[tuple[Any, Any]]:
        """The phases from low to high, divided where a value changes its sign."""
        a, b = value
        if b and self.field.sign((root := -a / b) - low) > 0 and self.field.sign(high - root) > 0:
            return [(low, root), (root, high)]
        return [(low, high)]

    def _above(self, low: Any, high: Any, velocity: Affine) -> list[tuple[Any, Any]]:
        """The phases that leave with more than 1."""
        excess = velocity[0] - self.one, velocity[1]
        return [
            (x, y)
            for x, y in self._pieces(low, high, excess)
            if self.field.sign(excess[0] + excess[1] * (x + y) / 2) > 0
        ]

    def _least(self, numbers: Sequence[Any]) -> Any:
        least = numbers[0]
        for x in numbers:
            least = x if self.field.sign(x - least) < 0 else least
        return least

    def _sum(self, row: Sequence[Any], values: Sequence[Affine]) -> Affine:
        a = sum((x * y for x, (y, _) in zip(row, values, strict=True)), self.zero)
        return a, sum((x * y for x, (_, y) in zip(row, values, strict=True)), self.zero)
