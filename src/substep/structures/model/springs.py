"""Springs and dampers of declared laws on a structure: elongations B u, and forces B^T q."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.arrays import Array
from ...core.laws import Evaluated, Law
from ..solvers.matrices import Matrix, finite
from .given import Dof, by_dof


class Answers(NamedTuple):
    """Of s springs (..., s): elongation, force, its slopes by that and by its rate, energy stored; and the memory."""

    e: Array
    force: Array
    tangent: Array
    damping: Array
    stored: Array
    memory: tuple[Array, ...]


class Group(NamedTuple):
    """The springs of one law, and their numbers among all."""

    law: Law
    where: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Springs:
    """s springs: B (s, n) gives their elongations in the free degrees of freedom, full (s, N) in all of them.

    lengths (s,): what elongations are divided by for ratios, where they were given, as heights of stories.
    """

    B: Matrix
    full: Matrix
    groups: tuple[Group, ...]
    lengths: Array | None = None

    @classmethod
    def together(cls, every: "Sequence[Springs]") -> "Springs":
        """Springs of structures that differ in parameters alone, as those of one with parameters (lanes, s)."""
        laws = zip(*([law for law, _ in one.groups] for one in every), strict=True)
        groups = tuple(
            Group(
                Law(
                    law.name, law.module, {x: np.array([one.parameters[x] for one in of]) for x in law.parameters}, None
                ),
                where,
            )
            for of, (law, where) in zip(laws, every[0].groups, strict=True)
        )
        return cls(every[0].B, every[0].full, groups)

    @property
    def size(self) -> int:
        """s."""
        return self.B.shape[0]

    @cached_property
    def compressed(self) -> Matrix:
        """B in compressed rows."""
        from scipy import sparse  # noqa: PLC0415 (slow to import)

        return sparse.csr_array(self.B)

    @property
    def of_rate(self) -> bool:
        """Whether some force depends on the rate of its elongation."""
        return any(group.law.of_rate for group in self.groups)

    @cached_property
    def unstrained(self) -> tuple[Array, ...]:
        """What they remember before they are strained."""
        return tuple(group.law.unstrained(len(group.where)) for group in self.groups)

    @cached_property
    def elastic(self) -> Array:
        """The slopes (s,) by elongations before they are strained."""
        return self.at(np.zeros(self.size), np.zeros(self.size), self.unstrained, 0.0).tangent

    def answers(self, u: Array, v: Array, memory: tuple[Array, ...], elapsed: float) -> Answers:
        """At u, v (..., n), from what was last committed, elapsed s before."""
        e = self._elongations(u)
        return self.at(e, self._elongations(v) if self.of_rate else np.zeros(e.shape), memory, elapsed)

    def spread(self, q: Array) -> Array:
        """The forces B^T q (..., n) of the springs' forces (..., s)."""
        return (self.B.T @ q.T).T

    def matrix(self, k: Array) -> Matrix:
        """B^T diag(k) B."""
        if isinstance(self.B, np.ndarray):
            return self.B.T @ (k[:, None] * self.B)
        return self.B.T @ self.B.multiply(k[:, None]).tocsr()

    def named(self, memory: tuple[Array, ...]) -> dict[str, Array]:
        """What is remembered by name (..., s), NaN where a spring's law has no such name."""
        found = dict[str, Array]()
        for group, rows in zip(self.groups, memory, strict=True):
            for k, name in enumerate(group.law.memory):
                values = found.setdefault(name, np.full((*rows.shape[:-2], self.size), np.nan))
                values[..., group.where] = rows[..., k]
        return found

    def from_named(self, named: Mapping[str, Array]) -> tuple[Array, ...]:
        """The opposite of `named`."""
        return tuple(
            np.array([named[name][group.where] for name in group.law.memory]).reshape(-1, len(group.where)).T.copy()
            for group in self.groups
        )

    def _elongations(self, u: Array) -> Array:
        """B u (..., s): of one row and of many the same to the bit, as BLAS would not have them."""
        return np.asarray((self.compressed @ u.T).T)

    def at(self, e: Array, rates: Array, memory: tuple[Array, ...], elapsed: float) -> Answers:
        """At elongations and rates (..., s) of their own, from what was last committed, elapsed s before."""
        if len(self.groups) == 1:
            q, k, c, new, stored = self.groups[0].law.evaluate(e, rates, memory[0], elapsed)
            return Answers(e, q, k, c, stored, (new,))
        found = np.empty((4, *e.shape))
        kept = list[Array]()
        for (law, where), rows in zip(self.groups, memory, strict=True):
            of: Evaluated = law.evaluate(e[..., where], rates[..., where], rows, elapsed)
            found[..., where] = of.force, of.tangent, of.damping, of.stored
            kept.append(of.memory)
        q, k, c, stored = found
        return Answers(e, q, k, c, stored, tuple(kept))


def springs_of(
    given: Iterable[tuple[ArrayLike | Mapping[Dof, float], Law]],
    T: Matrix,
    names: Sequence[str],
    *,
    dense: bool,
) -> Springs:
    """Springs from pairs of a row, or rows, of B and a law; T, names: of a `Model`; dense: whether its matrices are.

    Raises ValueError for what is no such pair, for rows of another length, for parameters of another number than there
    are rows, and for springs that cannot be strained.
    """
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    pairs = list(given)
    if not pairs:
        raise ValueError("expected springs as pairs (row of B, law), got none; leave springs out, or give some")
    rows, laws = list[Any](), dict[str, list[tuple[Law, int, int]]]()
    first = 0
    for pair in pairs:
        if not isinstance(pair, tuple) or len(pair) != 2 or not isinstance(pair[1], Law):
            raise ValueError(
                f"expected springs as pairs (row of B, law), got {repr(pair)[:60]}; give a list such as "
                "[({'roof': 1.0}, ss.law('bilinear', k=1.0, q_y=1.0))]"
            )
        block = rows_of(pair[0], T.shape[0], names)
        count, law = block.shape[0], pair[1]
        for name, x in law.parameters.items():
            if np.shape(x) not in ((), (count,)):
                raise ValueError(
                    f"expected {name} of {law.name} as one number or {count}, one for each row of B, got shape "
                    f"{np.shape(x)}; give as many"
                )
        rows.append(block)
        laws.setdefault(law.module.__name__, []).append((law, first, count))
        first += count
    full = sparse.csr_array(sparse.vstack(rows))
    B = sparse.csr_array(full @ T)
    idle = np.flatnonzero(np.asarray(abs(B).sum(axis=1)).ravel() == 0.0)
    if len(idle):
        raise ValueError(
            f"expected springs that free degrees of freedom strain, got a row of B without any for spring {idle[0]}; "
            "remove it"
        )
    groups = tuple(map(_group, laws.values()))
    return Springs(B.toarray() if dense else B, full, groups)


def _group(members: Sequence[tuple[Law, int, int]]) -> Group:
    """All springs of one law."""
    one = members[0][0]
    values = {
        name: np.concatenate([np.broadcast_to(law.parameters[name], count) for law, _, count in members]).astype(float)
        for name in one.parameters
    }
    where = np.concatenate([np.arange(first, first + count) for _, first, count in members])
    return Group(Law(one.name, one.module, MappingProxyType(values), one.source), where)


def rows_of(given: Any, N: int, names: Sequence[str]) -> Any:
    """Rows of B (s, N), sparse."""
    from scipy import sparse  # noqa: PLC0415

    if isinstance(given, Mapping):
        return sparse.csr_array(by_dof("a row of B", given, names, N)[None])
    found = finite("a row of B", given)
    matrix = found if sparse.issparse(found) else np.atleast_2d(found)
    if len(matrix.shape) != 2 or matrix.shape[1] != N:
        raise ValueError(
            f"expected a row of B with {N} components, one for each degree of freedom, or rows (s, {N}), got shape "
            f"{np.shape(found)}; or give a dictionary from degrees of freedom to coefficients"
        )
    return sparse.csr_array(matrix)
