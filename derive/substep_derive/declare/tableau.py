"""Runge-Kutta and Nystrom tables -> declarations of schemes.

The stages of a table are the knots of a step. A stage whose row is empty and whose c is 0 is t_n itself. Where the last
row equals the weights and its c is 1, the last stage is t_n + h ("first same as last", "stiffly accurate"), and its
acceleration is kept for the next step instead of being evaluated again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sympy import Expr, Integer, Rational, Symbol, cancel

from ..algebra.rooted_trees import nystrom_order, runge_kutta_order
from .entries import LABELS, Entries, Row
from .errors import DeclarationError
from .irrational import generated
from .parameter import Family, Parameter
from .published import Published
from .scheme import Balance, Scheme
from .symbols import Knot, N, f, h, knot


def tableau(
    name: str,
    A: Sequence[Row],
    b: Row,
    c: Row,
    b_hat: Row | None = None,
    *,
    parameters: tuple[Parameter, ...] = (),
    families: tuple[Family, ...] = (),
    reference: str = "",
    published: Published | None = None,
) -> Scheme:
    """The scheme of a Runge-Kutta table on u' = v, v' = a; stages that read each other are solved together.

    A: s rows of s entries, or of those up to the diagonal; b, c: s entries. b_hat: weights of a second value of u_1 and
    v_1, of another order, which become `embedded`. Entries are exact: int, Fraction, SymPy Rational, or rational in
    the parameters; irrational algebraic numbers of SymPy, as sqrt(2), become rational in one more parameter, theta,
    whose default is a root. Stage velocities are eliminated from stage displacements, which leaves
    u_i = u_0 + c_i h v_0 + h^2 sum_j (A^2)_ij a_j (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I
    (1993), II.14).

    Raises DeclarationError for wrong shapes, an entry that is not exact, rows that do not sum to c, weights that do not
    sum to 1, and b_hat of the same order as b.
    """
    hats = [] if b_hat is None else [b_hat]
    parameters, (rows, (b, c, *hats)) = generated(name, parameters, (A, (b, c, *hats)))
    table = Entries(name, parameters, (rows, (b, c, *hats)))
    c_ = table.vector("c", c)
    A_ = table.sums("the entries of row {k} of A", table.square("A", rows, len(c_)), c_)
    (b_,) = table.sums("the entries of b", [table.vector("b", b, len(c_))], [Integer(1)])
    second = None
    if hats:
        (second,) = table.sums("the entries of b_hat", [table.vector("b_hat", hats[0], len(c_))], [Integer(1)])
        order, other = (
            runge_kutta_order(table.numbers(A_), table.numbers([row])[0], table.one) for row in (b_, second)
        )
        _check_orders(name, "b_hat", order, other)
    squares = [_product(row, A_) for row in A_]
    return _scheme(
        _Stages(squares, A_, c_, _product(b_, A_), b_),
        None if second is None else {"u": _product(second, A_), "v": second},
        {"name": name, "parameters": parameters, "families": families, "reference": reference, "published": published},
    )


def nystrom(
    name: str,
    A_bar: Sequence[Row],
    b_bar: Row,
    b: Row,
    c: Row,
    A: Sequence[Row] | None = None,
    *,
    b_bar_hat: Row | None = None,
    b_hat: Row | None = None,
    parameters: tuple[Parameter, ...] = (),
    families: tuple[Family, ...] = (),
    reference: str = "",
    published: Published | None = None,
) -> Scheme:
    """The scheme of a Nystrom table; stages that read each other are solved together.

    u_i = u_0 + c_i h v_0 + h^2 sum_j A_bar_ij a_j, v_i = v_0 + h sum_j A_ij a_j at the stages, at the end
    u_1 = u_0 + h v_0 + h^2 sum_i b_bar_i a_i, v_1 = v_0 + h sum_i b_i a_i
    (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.14). Without A the table is one for
    u'' = g(t, u): no stage has a velocity, no balance a damping force, and the scheme is refused where there is
    damping. b_bar_hat, b_hat: weights of a second u_1 and v_1 of another order.

    Raises DeclarationError as `tableau` does; rows of A_bar have to sum to c^2/2, b_bar to 1/2.
    """
    optional = {"b_bar_hat": b_bar_hat, "b_hat": b_hat}
    second = {key: row for key, row in optional.items() if row is not None}
    parameters, (A_bar, velocities, (b_bar, b, c, *rest)) = generated(
        name, parameters, (A_bar, A or (), (b_bar, b, c, *second.values()))
    )
    second = dict(zip(second, rest, strict=True))
    table = Entries(name, parameters, (A_bar, velocities, (b_bar, b, c, *rest)))
    c_ = table.vector("c", c)
    squares, b_, bar = (
        table.square("A_bar", A_bar, len(c_)),
        *(table.vector(what, row, len(c_)) for what, row in (("b", b), ("b_bar", b_bar))),
    )
    given = None if A is None else table.square("A", velocities, len(c_))
    twice = table.sums(
        "twice the entries of row {k} of A_bar", [[2 * e for e in row] for row in squares], [x**2 for x in c_]
    )
    squares = [[e / 2 for e in row] for row in twice]
    A_ = None if given is None else table.sums("the entries of row {k} of A", given, c_)
    (bar,) = table.sums("the entries of b_bar", [bar], [Rational(1, 2)])
    (b_,) = table.sums("the entries of b", [b_], [Integer(1)])
    hats: dict[str, list[Expr]] = {}
    orders = _nystrom_order(table, squares, (bar, b_, c_), A_)
    for kind, what, total in (("u", "b_bar_hat", Rational(1, 2)), ("v", "b_hat", Integer(1))):
        if what in second:
            (hats[kind],) = table.sums(f"the entries of {what}", [table.vector(what, second[what], len(c_))], [total])
            others = _nystrom_order(table, squares, (hats.get("u", bar), hats.get("v", b_), c_), A_)
            place = "uv".index(kind)
            _check_orders(name, what, orders[place], others[place])
    return _scheme(
        _Stages(squares, A_, c_, bar, b_),
        hats or None,
        {"name": name, "parameters": parameters, "families": families, "reference": reference, "published": published},
    )


@dataclass(frozen=True)
class _Stages:
    """u_i = u_0 + c_i h v_0 + h^2 A_bar_i a and v_i = v_0 + h A_i a, no v_i where A is None; u_1, v_1 by b_bar, b."""

    A_bar: list[list[Expr]]
    A: list[list[Expr]] | None
    c: list[Expr]
    b_bar: list[Expr]
    b: list[Expr]

    @property
    def first_is_start(self) -> bool:
        """Whether the first stage is t_n itself."""
        return self.c[0] == 0 and not any(self.A_bar[0])

    @property
    def last_is_end(self) -> bool:
        """Whether the last stage is t_n + h itself."""
        return self.c[-1] == 1 and self.A_bar[-1] == self.b_bar and (self.A is None or self.A[-1] == self.b)

    def knots(self) -> list[Knot]:
        """One for each stage."""
        free = iter(LABELS)
        first, last = self.first_is_start, self.last_is_end
        return [
            knot(0) if first and i == 0 else knot(1) if last and i == len(self.c) - 1 else knot(next(free))
            for i in range(len(self.c))
        ]


def _scheme(stages: _Stages, hats: Mapping[str, list[Expr]] | None, rest: dict[str, Any]) -> Scheme:
    (u0, v0, _), (u1, v1, _) = knot(0), knot(1)
    knots = stages.knots()

    def displacement(c: Expr, weights: Sequence[Expr]) -> Expr:
        return u0 + h * c * v0 + h**2 * _combined(weights, knots)

    def velocity(weights: Sequence[Expr]) -> Expr:
        return v0 + h * _combined(weights, knots)

    relations: dict[Symbol, Expr] = {}
    balances: list[Balance] = []
    for i, (at, c) in enumerate(zip(knots, stages.c, strict=True)):
        if at not in (knot(0), knot(1)):
            relations[at.u] = displacement(c, stages.A_bar[i])
            if stages.A is not None:
                relations[at.v] = velocity(stages.A[i])
        if at != knot(0) or not stages.last_is_end:
            balances.append(Balance(at.a, at.v if stages.A is not None else Integer(0), N(at.u), f(c)))
    relations[u1] = displacement(Integer(1), stages.b_bar)
    relations[v1] = velocity(stages.b)
    embedded: dict[Symbol, Expr] = {}
    if hats and "u" in hats:
        embedded[u1] = displacement(Integer(1), hats["u"])
    if hats and "v" in hats:
        embedded[v1] = velocity(hats["v"])
    return Scheme(relations=relations, balances=tuple(balances), embedded=embedded, **rest)


def _combined(weights: Sequence[Expr], knots: Sequence[Knot]) -> Expr:
    return sum((w * at.a for w, at in zip(weights, knots, strict=True)), Integer(0))


def _product(row: Sequence[Expr], matrix: Sequence[Sequence[Expr]]) -> list[Expr]:
    """The row times the matrix."""
    columns = range(len(row))
    return [cancel(sum((w * line[j] for w, line in zip(row, matrix, strict=True)), Integer(0))) for j in columns]


def _nystrom_order(
    table: Entries, A_bar: list[list[Expr]], rows: Sequence[list[Expr]], A: list[list[Expr]] | None
) -> tuple[int, int]:
    b_bar, b, c = table.numbers(rows)
    return nystrom_order(table.numbers(A_bar), b_bar, b, c, table.one, None if A is None else table.numbers(A))


def _check_orders(name: str, what: str, order: int, other: int) -> None:
    if order == other:
        raise DeclarationError(
            f"{name}: expected {what} of another order than {what.removesuffix('_hat')}, so that their difference "
            f"estimates the error, got order {order} for both; correct {what}, or leave it out"
        )
