"""Contacts of a structure: gaps g0 + B u between degrees of freedom and stops, which reactions keep from closing."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.errors import real_array, unknown_name
from ..solvers.matrices import Matrix
from .springs import rows_of

AT_REST = 1e-8  # of a gap's parts and of its rate's, within which it is closed, and at rest
INSIDE = 1e-10  # of a gap's parts, by which it may be negative at the start
DEPENDENT = 1e-12  # of the largest singular value of the rows' directions: with a smaller one they are dependent


class Named:
    """Reactions with names, one or several of each."""

    names: Mapping[str, int | slice]

    def by_name(self, values: Array) -> dict[str, Array]:
        """Values (m, d) of all by name: (m,), or (m, s) of one of several rows."""
        return {name: values[:, where] for name, where in self.names.items()}

    def name_of(self, k: int) -> str:
        """The name of the k-th."""
        places = (
            (name, range(x, x + 1) if isinstance(x, int) else range(x.start, x.stop)) for name, x in self.names.items()
        )
        return next(name for name, x in places if k in x)


@dataclass(frozen=True, eq=False)
class Contacts(Named):
    """d gaps g0 + B u, of u (n,) in the free degrees of freedom.

    columns (m,): the degrees of freedom that B touches; rows (d, m): B there. restitution (d,): the share of the
    velocity that closed a gap with which it opens, NaN for one that is held itself. names: of each contact its rows.
    remembered: whether the acceleration that a scheme keeps for its next step is with that of the reactions.
    """

    columns: NDArray[np.intp]
    rows: Array
    gaps0: Array
    restitution: Array
    names: Mapping[str, int | slice]
    remembered: bool = False
    kind = "contacts"

    @property
    def size(self) -> int:
        """d."""
        return len(self.gaps0)

    @property
    def bouncing(self) -> NDArray[np.bool_]:
        """Which gaps open with a share of the velocity that closed them."""
        return ~np.isnan(self.restitution)

    def gaps(self, u: Array) -> Array:
        """The gaps (d,) at u (n,)."""
        return self.gaps0 + self.rows @ u[self.columns]

    def closed(self, u: Array, v: Array) -> NDArray[np.bool_]:
        """Which gaps (d,) are closed and stay so at u, v (n,)."""
        allowed = [AT_REST * (np.abs(self.rows) @ np.abs(x[self.columns])) for x in (u, v)]
        still = np.abs(self.rows @ v[self.columns]) <= allowed[1]
        return still & (np.abs(self.gaps(u)) <= AT_REST * np.abs(self.gaps0) + allowed[0])

    def forces(self, n: int) -> Array:
        """The forces B^T (n, d) of unit reactions."""
        found = np.zeros((n, self.size))
        found[self.columns] = self.rows.T
        return found

    def require_open(self, u: Array) -> None:
        """Raises ValueError where a gap is negative at the start u (n,)."""
        found = self.gaps(u)
        allowed = INSIDE * (np.abs(self.gaps0) + np.abs(self.rows) @ np.abs(u[self.columns]))
        if (inside := np.flatnonzero(found < -allowed)).size:
            k = int(inside[0])
            raise ValueError(
                f"expected a start with gaps of 0 or more, got {found[k]:.3g} of contact '{self.name_of(k)}'; start "
                "outside, or correct its gap"
            )


def contacts_of(given: Any, restitution: Any, T: Matrix, names: Sequence[str], *, remembered: bool) -> Contacts | None:
    """Contacts from what `structure` takes; T, names: of a `Model`. None without any.

    Raises ValueError for what is no mapping of names to pairs of a row, or rows, and as many gaps, for rows that are 0,
    of fixed degrees of freedom, or dependent where all are closed, and for restitutions that are not from 0 to 1.
    """
    if given is None or (isinstance(given, Mapping) and not given):
        if restitution is not None:
            raise ValueError(f"expected restitution with contacts only, got {restitution!r} without; give contacts=")
        return None
    if not isinstance(given, Mapping):
        raise ValueError(
            f"expected contacts as a mapping of names to pairs (row of B, gap), got {type(given).__name__}; give "
            "{'floor': ({'tip': 1.0}, 0.5)}"
        )
    if remembered and restitution is not None:
        raise ValueError(
            f"expected remembered=True without restitution, which acts in its own step alone, got {restitution!r}; "
            "leave one out"
        )
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    blocks, gaps, shares, where, first = list[Any](), list[Array](), list[Array](), dict[str, int | slice](), 0
    by_name = restitution if isinstance(restitution, Mapping) else dict.fromkeys(given, restitution)
    if unknown := [name for name in by_name if name not in given]:
        raise unknown_name("a contact", str(unknown[0]), given)
    for name, pair in given.items():
        if not isinstance(name, str) or not isinstance(pair, tuple) or len(pair) != 2:
            raise ValueError(
                f"expected contact {name!r} as a name with a pair (row of B, gap), got {repr(pair)[:60]}; give such as "
                "({'tip': 1.0}, 0.5)"
            )
        block, gap = rows_of(pair[0], T.shape[0], names), real_array(f"the gap of contact '{name}'", pair[1])
        count = block.shape[0]
        if gap.shape not in ((), (count,)):
            raise ValueError(
                f"expected one gap of contact '{name}' or {count}, one for each row, got shape {gap.shape}; give these"
            )
        e = by_name.get(name)
        share = np.nan if e is None else float(real_array(f"restitution of contact '{name}'", e))
        if not (np.isnan(share) or 0.0 <= share <= 1.0):
            raise ValueError(f"expected restitution from 0 to 1 of contact '{name}', got {share:g}; give such")
        several = np.ndim(pair[0]) == 2 and not isinstance(pair[0], Mapping)
        where[name] = slice(first, first + count) if several else first
        blocks.append(block)
        gaps.append(np.broadcast_to(gap, count))
        shares.append(np.full(count, share))
        first += count
    full = sparse.csr_array(sparse.vstack(blocks))
    held = np.asarray(abs(T).sum(axis=1)).ravel() == 0.0
    if (fixed := np.flatnonzero(held & (np.asarray(abs(full).sum(axis=0)).ravel() != 0.0))).size:
        dof = f"'{names[fixed[0]]}'" if names else fixed[0]
        raise ValueError(
            f"expected gaps of free degrees of freedom, got one of the fixed degree of freedom {dof}, whose "
            "displacement is 0; leave it out of the row"
        )
    B = sparse.csr_array(full @ T)
    B.eliminate_zeros()
    columns = np.unique(B.indices)
    found = Contacts(columns, B[:, columns].toarray(), np.concatenate(gaps), np.concatenate(shares), where, remembered)
    _require_independent(found)
    return found


def _require_independent(contacts: Contacts) -> None:
    """Raises ValueError for rows that are 0, and for gaps that may all be closed where their rows are dependent.

    Of dependent rows a sum of gaps is constant; if it is not 0, as of stops on both sides, they are never all closed.
    """
    sizes = np.linalg.norm(contacts.rows, axis=1)
    if (idle := np.flatnonzero(sizes == 0.0)).size:
        raise ValueError(
            f"expected gaps that degrees of freedom move, got a row of contact '{contacts.name_of(int(idle[0]))}' that "
            "is 0; remove it"
        )
    gaps = contacts.gaps0 / sizes
    whole = np.column_stack([contacts.rows / sizes[:, None], gaps / max(1e-300, float(np.abs(gaps).max()))])
    for k in range(contacts.size):
        values = np.linalg.svd(whole[: k + 1], compute_uv=False)
        if len(values) <= k or values[-1] <= DEPENDENT * values[0]:
            raise ValueError(
                f"expected independent gaps, got one of contact '{contacts.name_of(k)}' that those before it give, "
                "so that reactions are not known where all are closed; leave it out"
            )
