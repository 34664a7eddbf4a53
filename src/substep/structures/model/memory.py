"""An internal force with a memory: K u, springs by declared laws, and a material of the user's own.

It is taken from what was last committed, and says what would be remembered if it were committed where it is taken.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ...core.arrays import Array
from ..solvers.matrices import Matrix
from .material import Material, States
from .springs import Answers, Springs

WORK = "work"  # what went into springs until a march stands, if some law keeps no account of what it dissipates


class Memory(NamedTuple):
    """What is remembered: of springs an array (s_g, k_g) for each group, and the states of a material.

    Of many rows each array has one more axis, the first.
    """

    springs: tuple[Array, ...] = ()
    states: States = MappingProxyType({})

    def at(self, rows: Any) -> "Memory":
        """One row of many, or some; of one memory with None, the only row."""
        states = {name: np.asarray(x)[rows] for name, x in self.states.items()}
        return Memory(tuple(x[rows] for x in self.springs), states)

    @classmethod
    def joined(cls, parts: Sequence["Memory"]) -> "Memory":
        """The rows of all parts."""
        springs = zip(*(part.springs for part in parts), strict=True)
        states = {name: np.concatenate([part.states[name] for part in parts]) for name in parts[0].states}
        return cls(tuple(map(np.concatenate, springs)), states)


class Recalled(NamedTuple):
    """The memory that was last committed, and the time since then, s."""

    memory: Memory
    elapsed: float = 0.0


class Answer(NamedTuple):
    """The force (n,), what of it springs bear, the material's slopes by u and v, and the memory to commit."""

    force: Array
    of_springs: Answers | None
    slopes: tuple[Matrix | None, Matrix | None]
    memory: Memory


@dataclass(eq=False)
class RememberingForce:
    """N(t, u, v) (n,) in the free degrees of freedom from what was last committed; K (n, n): its linear part, if any.

    The last two answers are kept: a scheme that takes the force at both ends of a step computes each but once.
    """

    T: Matrix
    K: Matrix | None
    springs: Springs | None = None
    material: Material | None = None
    kept: list[tuple[tuple[Any, ...], Answer]] = field(default_factory=list, repr=False)
    evaluations: int = 0
    potential: None = None
    remembers: bool = True

    @cached_property
    def unstrained(self) -> Memory:
        """What is remembered before anything was strained."""
        return Memory(
            () if self.springs is None else self.springs.unstrained,
            {} if self.material is None else self.material.states,
        )

    @property
    def reads(self) -> int:
        """1 for N(u), 2 for N(u, v), 3 for N(t, u, v), besides the memory."""
        return 3 if self.material is not None else 2 if self.springs is not None and self.springs.of_rate else 1

    @property
    def tangent(self) -> Callable[..., Any]:
        """Its derivatives, which it always has."""
        return self.stiffness

    def __call__(self, t: float, u: Array, v: Array, recalled: Recalled | None = None) -> Array:
        """The force; recalled: by default nothing was ever strained."""
        return self.answer(t, u, v, recalled).force

    def answer(self, t: float, u: Array, v: Array, recalled: Recalled | None = None) -> Answer:
        """The force with its slopes and the memory that a commit here would keep."""
        memory, elapsed = Recalled(self.unstrained) if recalled is None else recalled
        for (at, old_u, old_v, old, since), found in self.kept:
            same = old is memory and since == elapsed and (at == t or self.material is None)
            if same and (old_u == u).all() and (self.reads < 2 or (old_v == v).all()):
                return found
        self.evaluations += 1
        force = np.zeros(len(u)) if self.K is None else np.asarray(self.K @ u)
        of_springs, slopes, states = None, (None, None), memory.states
        if self.springs is not None:
            of_springs = self.springs.answers(u, v, memory.springs, elapsed)
            force = force + self.springs.spread(of_springs.force)
        if self.material is not None:
            own, *slopes, states = self.material.answer(t, self.T @ u, self.T @ v, memory.states, self.T)
            force = force + own
        found = Answer(
            force, of_springs, tuple(slopes), Memory(() if of_springs is None else of_springs.memory, states)
        )
        self.kept = [((t, u.copy(), v.copy(), memory, elapsed), found), *self.kept[:1]]
        return found

    def along(self, u: Array, v: Array, memories: Memory, elapsed: float = 0.0) -> tuple[Array, Answers]:
        """The forces (m, n) at rows u, v (m, n), each from its memory, and what springs answer; without a material."""
        assert self.springs is not None
        found = self.springs.answers(u, v, memories.springs, elapsed)
        return self.held(u, found.force), found

    def held(self, u: Array, q: Array) -> Array:
        """The forces (m, n) at rows u (m, n), of springs that bear q (m, s)."""
        assert self.springs is not None
        force = self.springs.spread(q)
        return force if self.K is None else force + (self.K @ u.T).T

    def committed(self, t: float, u: Array, v: Array, recalled: Recalled) -> Memory:
        """What is remembered once it is committed here."""
        return self.answer(t, u, v, recalled).memory

    def stiffness(self, t: float, u: Array, v: Array, recalled: Recalled | None = None) -> tuple[Matrix, Matrix | None]:
        """The derivative by u, and that by v where there is one."""
        found = self.answer(t, u, v, recalled)
        by_u, by_v = found.slopes
        terms = [x for x in (self.K, by_u) if x is not None]
        if self.springs is not None and found.of_springs is not None:
            terms.append(self.springs.matrix(found.of_springs.tangent))
            if self.springs.of_rate:
                damping = self.springs.matrix(found.of_springs.damping)
                by_v = damping if by_v is None else by_v + damping
        return sum(terms[1:], terms[0]), by_v

    def damping(self, t: float, u: Array, v: Array) -> Array:
        """What velocities add to the force before anything was strained (n,): N(t, u, v) - N(t, u, 0)."""
        return self(t, u, v) - self(t, u, np.zeros_like(v))

    def damps(self, t: float, u: Array, v: Array) -> bool:
        """Whether the force is another one for v than at rest."""
        return self.reads > 1 and bool(self.damping(t, u, v).any())

    def at_start(self, u: Array, v: Array) -> tuple[Matrix, Matrix | None]:
        """What coefficients of schemes and Rayleigh damping know: the slopes before anything is strained.

        Of springs that is at no elongation, and without what they damp, as on scenes.
        """
        slopes = self.answer(0.0, u, v).slopes
        terms = [x for x in (self.K, slopes[0]) if x is not None]
        if self.springs is not None:
            terms.append(self.springs.matrix(self.springs.elastic))
        return sum(terms[1:], terms[0]), slopes[1]

    def stored(self, u: Array, memory: Memory) -> float | None:
        """The energy that could be given back, committed at u; None of a material of the user's, which does not say."""
        if self.material is not None:
            return None
        linear = 0.0 if self.K is None else 0.5 * float(u @ (self.K @ u))
        of_springs = self.answer(0.0, u, np.zeros_like(u), Recalled(memory)).of_springs
        return linear + (0.0 if of_springs is None else float(of_springs.stored.sum()))

    def named(self, memory: Memory) -> dict[str, Array]:
        """What is remembered by name: of springs (..., s), NaN where a law has no such name; states as they are."""
        found = {} if self.springs is None else self.springs.named(memory.springs)
        return found | {name: np.asarray(x) for name, x in memory.states.items()}

    def remembered(self, named: Mapping[str, Any]) -> Memory:
        """The memory of these names. Raises ValueError where some are missing or too many."""
        expected = self.named(self.unstrained)
        if wrong := sorted(expected.keys() ^ named.keys()):
            raise ValueError(
                f"expected memory of start with {', '.join(expected)}, what this structure remembers, got "
                f"{', '.join(named) or 'none'}: see {', '.join(wrong)}; give r.state, or memory={{...}} beside u and v"
            )
        for name, x in expected.items():
            if np.shape(named[name]) != x.shape:
                raise ValueError(
                    f"expected {name} in the memory of start of shape {x.shape}, got {np.shape(named[name])}; give "
                    "what r.state.memory has"
                )
        arrays = {name: np.array(x, dtype=np.float64) for name, x in named.items()}
        for name, x in expected.items():
            if (lost := np.argwhere(np.isfinite(x) & ~np.isfinite(arrays[name]))).size:
                raise ValueError(
                    f"expected {name} in the memory of start to be finite where it is remembered, got "
                    f"{arrays[name][tuple(lost[0])]} at index {tuple(lost[0].tolist())}; give what r.state.memory has"
                )
        states = {name: arrays[name] for name in self.unstrained.states}
        return Memory(() if self.springs is None else self.springs.from_named(arrays), states)
