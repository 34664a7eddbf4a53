"""Scheme -> the Runge-Kutta-Nystrom form of its step on u'' = g(u), where it is a map of the reported u and v.

u_1 = u_0 + h v_0 - sum bbar_i n_i, h v_1 = h v_0 - sum b_i n_i, with stages n_i = h^2 N(U_i) per unit mass and
U_i = u_0 + c_i h v_0 - sum a_ij n_j; for a discrete gradient a stage has two displacements. Forces are formal symbols
here: what is found holds for every N. A state that holds more than u and v (a_0, a velocity half a step away) is
eliminated if it is a function of the reported u and v after every step, as the start says it is at t = 0, or if
nothing that follows depends on it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..declare.symbols import knot
from .forms import Form
from .parasitic import leading_matrix
from .step import StepSeries

Vector = dict[Any, Any]  # "u", "v", ("y", place in the state) or ("n", number of a stage) -> number
Row = tuple[Any, dict[int, Any]]  # c and a of one displacement


@dataclass(frozen=True)
class Nystrom:
    """stages: the displacement of each, or the two of a discrete gradient; weights_u and weights_v: bbar and b."""

    stages: tuple[tuple[Row, ...], ...]
    weights_u: dict[int, Any]
    weights_v: dict[int, Any]
    one: Any

    def b(self, i: int) -> Any:
        """The weight of stage i in h v_1."""
        return self.weights_v.get(i, self.one - self.one)

    def bbar(self, i: int) -> Any:
        """The weight of stage i in u_1."""
        return self.weights_u.get(i, self.one - self.one)

    def adjoint(self) -> "Nystrom":
        """The inverse of the step of length -h, its stages in the same order."""
        stages = tuple(tuple(self._seen_from_the_end(row) for row in rows) for rows in self.stages)
        u = {i: self.b(i) - self.bbar(i) for i in range(len(self.stages))}
        return Nystrom(stages, u, {i: self.b(i) for i in range(len(self.stages))}, self.one)

    def _seen_from_the_end(self, row: Row) -> Row:
        c, a = row
        zero = self.one - self.one
        seen = {j: a.get(j, zero) + (self.one - c) * self.b(j) - self.bbar(j) for j in range(len(self.stages))}
        return self.one - c, seen

    def permutation_to(self, other: "Nystrom") -> tuple[int, ...] | None:
        """The stage of `other` that each stage is, if both are the same method up to the order of stages."""
        n = len(self.stages)
        fitting = [
            [j for j in range(n) if self.b(i) == other.b(j) and self.bbar(i) == other.bbar(j)
             and sorted(map(str, (row[0] for row in self.stages[i])))
             == sorted(map(str, (row[0] for row in other.stages[j])))]
            for i in range(n)
        ]  # fmt: skip
        for chosen in _choices(fitting, ()):
            mapped = [[(c, _entries({chosen[j]: x for j, x in a.items()})) for c, a in rows] for rows in self.stages]
            if all(
                _same_rows(rows, [(c, _entries(a)) for c, a in other.stages[chosen[i]]])
                for i, rows in enumerate(mapped)
            ):
                return chosen
        return None

    @property
    def is_symplectic(self) -> bool:
        """Whether Suris's conditions hold, which with N the gradient of a potential make (u, M v) symplectic.

        Suris, USSR Comput. Math. Math. Phys. 29 (1989) 138-144; Okunbor & Skeel, Math. Comput. 59 (1992) 439-455.
        """
        n = range(len(self.stages))
        if any(len(rows) > 1 for rows in self.stages):
            return False
        rows = [rows[0] for rows in self.stages]
        zero = self.one - self.one
        first = all(self.bbar(i) == self.b(i) * (self.one - rows[i][0]) for i in n)
        return first and not any(self._defect([row[1] for row in rows], i, j, zero) for i in n for j in range(i))

    def _defect(self, a: Sequence[Mapping[int, Any]], i: int, j: int, zero: Any) -> Any:
        ij, ji = a[i].get(j, zero), a[j].get(i, zero)
        return self.b(i) * (self.bbar(j) - ij) - self.b(j) * (self.bbar(i) - ji)

    def conjugated(self, xi: Any, eta: Any) -> "Nystrom | None":
        """The map that the step is of x = u + xi h^2 N(u), p = h v + eta h^2 N(u); None without stages at both ends."""
        first, last = self.first, self.last
        if first is None or last is None:
            return None
        zero = self.one - self.one

        def plus(level: Mapping[int, Any], *more: tuple[int, Any]) -> dict[int, Any]:
            found = dict(level)
            for j, x in more:
                found[j] = found.get(j, zero) + x
            return found

        stages = tuple(tuple((c, plus(a, (first, xi + c * eta))) for c, a in rows) for rows in self.stages)
        u = plus(self.weights_u, (first, xi + eta), (last, -xi))
        return Nystrom(stages, u, plus(self.weights_v, (first, eta), (last, -eta)), self.one)

    @property
    def first(self) -> int | None:
        """The stage at u_0."""
        return self._at(self.one - self.one, {})

    @property
    def last(self) -> int | None:
        """The stage at u_1."""
        return self._at(self.one, self.weights_u)

    def _at(self, c: Any, a: Mapping[int, Any]) -> int | None:
        wanted = [(c, _entries(a))]
        for i, rows in enumerate(self.stages):
            if [(c, _entries(a)) for c, a in rows] == wanted:
                return i
        return None

    def symplectic_conjugate(self) -> tuple[Any, Any] | None:
        """(xi, eta) of `conjugated` for which that map is symplectic, if there are any.

        xi follows from the condition on the first stage; the others are at most quadratic in eta. Tried are eta = 0
        and the root of a condition that is linear.
        """
        if self.first is None or self.last is None:
            return None
        one, zero = self.one, self.one - self.one
        xi = self.b(self.first) - self.bbar(self.first)
        at = [self.conjugated(xi, eta) for eta in (zero, one, -one)]
        n = len(self.stages)
        candidates = [zero]
        for i in range(n):
            for j in range(i):
                values = [m._defect([rows[0][1] for rows in m.stages], i, j, zero) for m in at if m is not None]
                square, slope = values[1] + values[2] - values[0] * 2, values[1] - values[2]
                if not square and slope:
                    candidates.append(-values[0] * 2 / slope)
        for eta in candidates:
            found = self.conjugated(xi, eta)
            if found is not None and found.is_symplectic:
                return xi, eta
        return None


def _entries(a: Mapping[int, Any]) -> dict[int, Any]:
    return {j: x for j, x in a.items() if x}


def _same_rows(one: Sequence[tuple[Any, dict[int, Any]]], other: Sequence[tuple[Any, dict[int, Any]]]) -> bool:
    """Whether two stages have the same displacements; the two of a discrete gradient may be exchanged."""
    return list(one) == list(other) or list(one) == list(other)[::-1]


def _choices(fitting: Sequence[Sequence[int]], chosen: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    if len(chosen) == len(fitting):
        yield chosen
        return
    for j in fitting[len(chosen)]:
        if j not in chosen:
            yield from _choices(fitting, (*chosen, j))


@dataclass
class _Stages:
    """Formal forces, equal ones under one number."""

    one: Any
    places: dict[Any, int] = field(default_factory=dict)  # atom -> number
    displacements: list[tuple[Vector, ...]] = field(default_factory=list)
    same: dict[int, int] = field(default_factory=dict)

    def of(self, displacements: tuple[Vector, ...]) -> int:
        """The number of the force at these displacements."""
        displacements = tuple(map(self.merged, displacements))
        for i, other in enumerate(self.displacements):
            if i not in self.same and displacements in (other, other[::-1]):
                return i
        self.displacements.append(displacements)
        return len(self.displacements) - 1

    def merged(self, x: Vector) -> Vector:
        """The vector with equal forces under one number."""
        found: Vector = {}
        for key, c in x.items():
            place = ("n", self.same.get(key[1], key[1])) if key[0] == "n" else key
            value = found[place] + c if place in found else c
            found[place] = value
        return {key: c for key, c in found.items() if c}

    def merge(self, substitute: Mapping[Any, Vector]) -> None:
        """Put vectors for the state's symbols, and give equal forces one number."""
        self.displacements = [tuple(_put(x, substitute) for x in both) for both in self.displacements]
        found = True
        while found:
            self.displacements = [tuple(map(self.merged, both)) for both in self.displacements]
            live = [i for i in range(len(self.displacements)) if i not in self.same]
            pairs = ((i, j) for i in live for j in live if j < i)
            found = False
            for i, j in pairs:
                if self.displacements[i] in (self.displacements[j], self.displacements[j][::-1]):
                    self.same = {k: j if v == i else v for k, v in self.same.items()} | {i: j}
                    found = True
                    break


def _put(x: Vector, values: Mapping[Any, Vector]) -> Vector:
    found: Vector = {}
    for key, c in x.items():
        if key in values:
            _gather(found, values[key], c)
        else:
            found[key] = found[key] + c if key in found else c
    return {key: c for key, c in found.items() if c}


def nystrom(step: StepSeries) -> Nystrom | None:
    """The form, or None for a scheme that is not seen to have one: K0 in it, a history, a state of its own."""
    reads_operators = step.reads_tangent or step.starter is not None
    if reads_operators or any(applied.kind != "C" for e in step.starts for applied in e.applied):
        return None
    stages, values = _Stages(step.one), {s: {("y", j): step.one} for j, s in enumerate(step.state)}
    after = _after(step, stages, values)
    u1, v1 = (_value(e, after, stages) for e in step.reports[:2])
    observed = [x for both in stages.displacements for x in both] + [u1, v1]
    new_state = [after[s] for s in step.after]
    began = _start(step, stages, {"u": step.one}, {"v": step.one})
    put = {("y", j): x for j, x in enumerate(began)}
    stages.merge(put)
    u1, v1 = (stages.merged(_put(x, put)) for x in (u1, v1))
    new_state = [stages.merged(_put(x, put)) for x in new_state]
    begun_again = [stages.merged(x) for x in _start(step, stages, u1, v1)]
    difference = [_minus(x, y) for x, y in zip(new_state, begun_again, strict=True)]
    if _is_observed(step, observed, difference):
        return None
    return _read(stages, u1, v1)


def _after(step: StepSeries, stages: _Stages, values: Mapping[Any, Vector]) -> dict[Any, Vector]:
    """All symbols after a step, in the state's symbols and formal forces."""
    found: dict[Any, Vector] = {**values, **{s: {} for s in step.unknowns}}
    atoms = {t.of: t for e in step.equations for t in e.terms if t.arguments}
    for k, atom in enumerate(atoms):
        stages.places[atom] = k
        stages.displacements.append(())
    for equation, contributions in zip(step.equations, step.solution, strict=True):
        held: Vector = {}
        for term in equation.terms:
            if term.arguments:
                _gather(held, {("n", stages.places[term.of]): step.one}, term.plain)
            elif term.of in values:
                _gather(held, values[term.of], term.plain)
        for j, c in contributions:
            _gather(found[step.unknowns[j]], held, c)
    for k, term in enumerate(atoms.values()):
        stages.displacements[k] = tuple(_value(e, found, stages) for e in term.arguments)
    return found


def _value(e: Form, values: Mapping[Any, Vector], stages: _Stages) -> Vector:
    """A form in the state's symbols and formal forces, without damping and load."""
    total: Vector = {}
    for term in e.terms:
        if term.instant is not None:
            continue
        if term.arguments:
            where = tuple(_value(argument, values, stages) for argument in term.arguments)
            _gather(total, {("n", stages.of(where)): stages.one}, term.plain)
        else:
            _gather(total, values[term.of], term.plain)
    return {key: c for key, c in total.items() if c}


def _start(step: StepSeries, stages: _Stages, u: Vector, v: Vector) -> list[Vector]:
    """The state that the start makes of these u_0 and h v_0, with the acceleration that they have."""
    at = dict(zip(knot(0), (u, v, {("n", stages.of((u,))): -step.one}), strict=True))
    return [_value(e, at, stages) for e in step.starts]


def _gather(total: Vector, more: Vector, factor: Any) -> None:
    for key, c in more.items():
        total[key] = total[key] + c * factor if key in total else c * factor


def _minus(x: Vector, y: Vector) -> Vector:
    total = dict(x)
    _gather(total, y, -1)
    return {key: c for key, c in total.items() if c}


def _is_observed(step: StepSeries, outputs: Sequence[Vector], difference: Sequence[Vector]) -> bool:
    """Whether a change of the state ever changes one of the outputs."""
    A, m = leading_matrix(step), len(difference)
    zero = step.one - step.one
    for key in {key for x in difference for key in x}:
        change = [x.get(key, zero) for x in difference]
        for _ in range(m):
            if any(sum((x.get(("y", j), zero) * c for j, c in enumerate(change)), zero) for x in outputs):
                return True
            change = [sum((a * c for a, c in zip(row, change, strict=True)), zero) for row in A]
    return False


def _read(stages: _Stages, u1: Vector, v1: Vector) -> Nystrom | None:
    """The form from vectors in u, v and formal forces; only forces on which u_1 or v_1 depends are kept."""
    kept: list[int] = []
    waiting = [key[1] for x in (u1, v1) for key in x if key[0] == "n"]
    while waiting:
        i = waiting.pop()
        if i not in kept:
            kept.append(i)
            waiting += [key[1] for x in stages.displacements[i] for key in x if key[0] == "n"]
    number = {i: k for k, i in enumerate(sorted(kept))}
    zero, one = stages.one - stages.one, stages.one

    def row(x: Vector) -> Row:
        return x.get("v", zero), {number[key[1]]: -c for key, c in x.items() if key[0] == "n"}

    whole = [x for i in sorted(kept) for x in stages.displacements[i]]
    if any(x.get("u") != one for x in (*whole, u1)) or (v1.get("u"), v1.get("v"), u1.get("v")) != (None, one, one):
        return None
    displacements = tuple(tuple(row(x) for x in stages.displacements[i]) for i in sorted(kept))
    return Nystrom(displacements, row(u1)[1], row(v1)[1], one)
