"""The estimated local error of a step of a structure: the scheme's derived estimate on its vectors."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...core.arrays import Array
from ...core.error_estimate import LocalError
from ..solvers.combine import combined
from .steps import StructureSteps

Source = tuple[str, str]  # where a vector is known, and its name there: see `core.error_estimate.LocalError`


@dataclass(frozen=True, eq=False)
class Estimate:
    """The estimate of a scheme on a structure; error: of the scheme, with or without damping."""

    error: LocalError

    def names(self, where: str, kinds: Iterable[int] = range(3)) -> tuple[str, ...]:
        """Names of the vectors that its sums of these kinds take from there."""
        sums = [above for kind, (above, _) in enumerate(self.error.terms) if kind in kinds]
        known = [self.error.sources[name] for above in sums for name, _, _ in above]
        return tuple(dict.fromkeys(name for place, name in known if place == where))

    @cached_property
    def by_before(self) -> tuple[bool, bool]:
        """Whether the errors of u, of v need the step before."""
        u, v = (bool(self.names("before", (kind,))) for kind in (0, 1))
        return u, v

    def kinds(self, first: bool) -> tuple[int, ...]:
        """The sums that a step needs: 0, 1, 2 for u, v and the end; first: it has no step before it."""
        found = [kind for kind in (0, 1) if not (first and self.by_before[kind])]
        return (*found, 2) if len(self.error.terms) > 2 and (first or self.error.always) else (*found,)

    def of(self, kind: int, march: StructureSteps, X: Array, kappa: float, known: Mapping[Source, Array]) -> Array:
        """The estimated error (n,) of u (kind 0), or of v (1, or 2 by the end) after a step X; kappa: the length of the
        step before, over h.

        known: the vectors that neither the step nor its report holds.
        """
        row, total = np.zeros(march.steps.vectors), np.zeros(X.shape[1])
        for source, factor in self._factors(kind, march.run.h, kappa).items():
            where, name = source
            if where == "step":
                row += factor * march.steps.rows[name]
            elif where == "end" and name != "a":
                row += factor * march.steps.report["uv".index(name)]
            else:
                total += factor * known[source]
        return filtered(march, total + combined(row[None], X)[0])

    def _factors(self, kind: int, h: float, kappa: float) -> dict[Source, float]:
        """The factor of each vector."""
        weights, found = iter(self.error.weights), []
        for above, below in self.error.terms:
            factors: dict[Source, float] = {}
            for name, of_h, of_kappa in above:
                source, weight = self.error.sources[name], next(weights)
                factors[source] = factors.get(source, 0.0) + weight * h**of_h * kappa**of_kappa
            over = sum(next(weights) * kappa**power for power in below) if below else 1.0
            found.append({source: factor / over for source, factor in factors.items()})
        return found[kind]


def filtered(march: StructureSteps, error: Array) -> Array:
    """The error times the effective matrix's part without stiffness over all of it, of the last implicit balance.

    It is bounded where a mode is stiff, and equal for small steps. Shampine & Baca, Appl. Numer. Math. 1 (1985)
    495-506. A nonlinear structure takes the factors of its last iteration. What balances that are solved together give
    is left as it is, as on scenes.
    """
    s = march.run.structure
    for system, solver in list(zip(march.steps.systems, march.systems, strict=True))[::-1]:
        j = system.place
        alone = system.unknowns.stop - system.unknowns.start == 1
        if alone and system.balance and system.implicit and solver.solve is not None:
            free = float(system.inertia[j]) * (s.M @ error)
            if s.C is not None and system.damping[j] != 0.0:
                free += float(system.damping[j]) * (s.damping @ error)
            return solver.solve(free)
    return error
