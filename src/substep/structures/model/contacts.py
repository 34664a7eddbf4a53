"""Contacts of a structure: gaps g0 + B u between degrees of freedom and stops, which reactions keep from closing.

Frictions, forces up to a limit against the rate of B u, are reactions behind those of the gaps.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import Array
from ...core.errors import real_array, unknown_name
from ..solvers.complementarity import complementary, with_friction
from ..solvers.matrices import Matrix
from .springs import rows_of

AT_REST = 1e-8  # of a gap's parts and of its rate's, within which it is closed, and at rest
ROUNDING = 1e-12  # of a gap's parts, below which it is closed: what rests on a stop stays there
INSIDE = 1e-10  # of a gap's parts, by which it may be negative at the start
DEPENDENT = 1e-12  # of the largest singular value of the rows' directions: with a smaller one they are dependent


class Named:
    """Reactions with names, one or several of each."""

    names: Mapping[str, int | slice]

    @property
    def frictions(self) -> Collection[str]:
        """The names of those that have no gap."""
        return ()

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
    velocity that closed a gap with which it opens, NaN for one that is held itself. names: of each its rows. The last f
    are frictions along B u, of at most limits (f,) + shares (f, d - f) times the reactions of the gaps. remembered:
    whether the acceleration that a scheme keeps for its next step is with that of the reactions.
    """

    columns: NDArray[np.intp]
    rows: Array
    gaps0: Array
    restitution: Array
    names: Mapping[str, int | slice]
    limits: Array
    shares: Array
    remembered: bool = False
    kind = "contacts"

    @property
    def size(self) -> int:
        """d."""
        return len(self.gaps0)

    @property
    def frictions(self) -> Collection[str]:
        """Those of the last rows."""
        first = self.size - len(self.limits)
        return [name for name, x in self.names.items() if (x if isinstance(x, int) else x.start) >= first]

    @property
    def sliding(self) -> NDArray[np.bool_]:
        """Which are frictions."""
        return np.arange(self.size) >= self.size - len(self.limits)

    @property
    def bouncing(self) -> NDArray[np.bool_]:
        """Which gaps open with a share of the velocity that closed them, and frictions: velocities are held."""
        return ~np.isnan(self.restitution)

    @property
    def kinds(self) -> "list[Literal['gap', 'restitution', 'friction']]":
        """The kinds of contact that are among them."""
        held, bouncing = ~self.bouncing, self.bouncing & ~self.sliding
        return [
            kind
            for kind, which in (("gap", held), ("restitution", bouncing), ("friction", self.sliding))
            if which.any()
        ]

    def described(self, u: Array) -> tuple[Any, ...]:
        """What distinguishes them from others; u (n,) is not asked."""
        del u
        parts = self.columns, self.rows, self.gaps0, self.restitution, self.limits, self.shares
        return repr(dict(self.names)), *parts

    def reactions(self, q: Array, W: Array, before: Array, strength: float) -> Array:
        """Reactions (d,) with which q + W p, gaps or rates, are right; strength: as in `scheme_plan.Touch`."""
        if not len(self.limits):
            return complementary(q, W, before)
        return with_friction(q, W, before, strength * self.limits, self.shares)

    def reported(self, p: Array) -> Array:
        """Reactions (d,) as they are reported: frictions, as forces of springs, on the side of K u."""
        return np.where(self.sliding, -p, p)

    def rubbed(self, reactions: Array, change: Array) -> float:
        """The energy that frictions take while u changes by (n,), under the mean reactions (d,) of a step, reported."""
        return float(reactions[self.sliding] @ (self.rows @ change[self.columns])[self.sliding])

    def gaps(self, u: Array) -> Array:
        """The gaps (d,) at u (n,), of frictions B u."""
        return self.gaps0 + self.rows @ u[self.columns]

    def closed(self, u: Array, v: Array) -> NDArray[np.bool_]:
        """Which gaps (d,) are closed and stay so at u, v (n,)."""
        allowed = [AT_REST * (np.abs(self.rows) @ np.abs(x[self.columns])) for x in (u, v)]
        still = np.abs(self.rows @ v[self.columns]) <= allowed[1]
        return still & (np.abs(self.gaps(u)) <= AT_REST * np.abs(self.gaps0) + allowed[0])

    def closing(self, u: Array, change: Array) -> NDArray[np.bool_]:
        """Which gaps (d,) are closed at u (m,) of `columns`, or open by rounding alone; change (m,): of u in a step."""
        parts = np.abs(self.gaps0) + np.abs(self.rows) @ (np.abs(u) + np.abs(change))
        return np.asarray(self.gaps0 + self.rows @ u <= ROUNDING * parts)

    def slipping(self, v: Array) -> Array:
        """Of what slides (d,) at v (n,) the sign of its rate; 0 where it is at rest, and of gaps."""
        rates, parts = self.rows @ v[self.columns], np.abs(self.rows) @ np.abs(v[self.columns])
        return np.where(self.sliding & (np.abs(rates) > AT_REST * parts), np.sign(rates), 0.0)

    def forces(self, n: int) -> Array:
        """The forces B^T (n, d) of unit reactions."""
        found = np.zeros((n, self.size))
        found[self.columns] = self.rows.T
        return found

    def require_open(self, u: Array) -> None:
        """Raises ValueError where a gap is negative at the start u (n,)."""
        found = np.where(self.sliding, 0.0, self.gaps(u))
        allowed = INSIDE * (np.abs(self.gaps0) + np.abs(self.rows) @ np.abs(u[self.columns]))
        if (inside := np.flatnonzero(found < -allowed)).size:
            k = int(inside[0])
            raise ValueError(
                f"expected a start with gaps of 0 or more, got {found[k]:.3g} of contact '{self.name_of(k)}'; start "
                "outside, or correct its gap"
            )


def contacts_of(
    given: Any, restitution: Any, friction: Any, T: Matrix, names: Sequence[str], *, remembered: bool
) -> Contacts | None:
    """Contacts and frictions from what `structure` takes; T, names: of a `Model`. None without any.

    Raises ValueError for what is no mapping of names to pairs of a row, or rows, and as many gaps, or limits, for rows
    that are 0, of fixed degrees of freedom, or dependent where all are closed, for restitutions that are not from 0 to
    1, and for limits that are negative or of contacts that are not there.
    """
    given, friction = ({} if x is None else x for x in (given, friction))
    if not given and restitution is not None:
        raise ValueError(f"expected restitution with contacts only, got {restitution!r} without; give contacts=")
    gaps = _declared("contact", "gap", given, T, names)
    rubs = _declared("friction", "limit", friction, T, names)
    if not gaps and not rubs:
        return None
    if remembered and (restitution is not None or rubs):
        what = (
            f"restitution, which acts in its own step alone, got {restitution!r}" if not rubs else "friction, got both"
        )
        raise ValueError(f"expected remembered=True without {what}; leave one out")
    if twice := next((name for name in rubs if name in gaps), None):
        raise ValueError(f"expected names of frictions that no contact has, got '{twice}' twice; rename one")
    by_name = restitution if isinstance(restitution, Mapping) else dict.fromkeys(given, restitution)
    if unknown := [name for name in by_name if name not in given]:
        raise unknown_name("a contact", str(unknown[0]), given)
    gaps0, shares, where, first = list[Array](), list[Array](), dict[str, int | slice](), 0
    for name, one in (gaps | rubs).items():
        where[name] = slice(first, first + one.count) if one.several else first
        first += one.count
    for name, one in gaps.items():
        e = by_name.get(name)
        share = np.nan if e is None else float(real_array(f"restitution of contact '{name}'", e))
        if not (np.isnan(share) or 0.0 <= share <= 1.0):
            raise ValueError(f"expected restitution from 0 to 1 of contact '{name}', got {share:g}; give such")
        gaps0.append(one.numbers("gap", one.given))
        shares.append(np.full(one.count, share))
    f = sum(one.count for one in rubs.values())
    limits, coefficients, row = np.zeros(f), np.zeros((f, first - f)), 0
    for one in rubs.values():
        one.limit(where, limits[row : row + one.count], coefficients[row : row + one.count])
        row += one.count
    B = _free_rows([*gaps.values(), *rubs.values()], T, names)
    columns = np.unique(B.indices)
    found = Contacts(
        columns, B[:, columns].toarray(), np.concatenate([*gaps0, np.zeros(f)]),
        np.concatenate([*shares, np.zeros(f)]), where, limits, coefficients, remembered,
    )  # fmt: skip
    _require_independent(found)
    return found


@dataclass(frozen=True, eq=False)
class _Declared:
    """A contact or a friction, kind, as declared: rows (s, N), and a gap or a limit."""

    kind: str
    name: str
    rows: Any
    given: Any
    several: bool

    @property
    def count(self) -> int:
        return self.rows.shape[0]

    def numbers(self, what: str, given: Any) -> Array:
        """One number (s,) for each row. Raises ValueError for others."""
        found = real_array(f"the {what} of {self.kind} '{self.name}'", given)
        if found.shape not in ((), (self.count,)):
            raise ValueError(
                f"expected one {what} of {self.kind} '{self.name}' or {self.count}, one for each row, got shape "
                f"{found.shape}; give these"
            )
        return np.broadcast_to(found, self.count)

    def limit(self, places: Mapping[str, int | slice], least: Array, shares: Array) -> None:
        """Put into least (s,) and shares (s, g) what the force is at most. Raises ValueError for what is no limit."""
        by_reaction = self.given if isinstance(self.given, Mapping) else {}
        if not by_reaction:
            least[:] = self.numbers("limit", self.given)
        for contact, coefficient in by_reaction.items():
            known = [name for name in places if self._reaches(places[name], shares)]
            if contact not in known:
                raise unknown_name(f"a contact as the limit of friction '{self.name}'", str(contact), known)
            place, mu = places[contact], self.numbers("coefficient", coefficient)
            at = np.arange(shares.shape[1])[place]
            if np.size(at) not in (1, self.count):
                raise ValueError(
                    f"expected friction '{self.name}' of {np.size(at)} rows, as many as contact '{contact}' has, got "
                    f"{self.count}; give a row for each"
                )
            shares[np.arange(self.count), at] = mu
        if (least < 0.0).any() or (shares < 0.0).any():
            raise ValueError(f"expected a limit of 0 or more of friction '{self.name}', got {self.given!r}; give such")

    @staticmethod
    def _reaches(place: int | slice, shares: Array) -> bool:
        return (place if isinstance(place, int) else place.start) < shares.shape[1]


def _declared(kind: str, what: str, given: Any, T: Matrix, names: Sequence[str]) -> dict[str, _Declared]:
    """Those of a kind, by name, each with a gap or a limit; raises ValueError for what is no mapping to pairs."""
    example = "({'tip': 1.0}, 0.5)"
    if not isinstance(given, Mapping):
        raise ValueError(
            f"expected {kind}s as a mapping of names to pairs (row of B, {what}), got {type(given).__name__}; give "
            f"{{'floor': {example}}}"
        )
    found = dict[str, _Declared]()
    for name, pair in given.items():
        if not isinstance(name, str) or not isinstance(pair, tuple) or len(pair) != 2:
            raise ValueError(
                f"expected {kind} {name!r} as a name with a pair (row of B, {what}), got {repr(pair)[:60]}; give such "
                f"as {example}"
            )
        several = np.ndim(pair[0]) == 2 and not isinstance(pair[0], Mapping)
        found[name] = _Declared(kind, name, rows_of(pair[0], T.shape[0], names), pair[1], several)
    return found


def _free_rows(every: Sequence[_Declared], T: Matrix, names: Sequence[str]) -> Any:
    """All rows in the free degrees of freedom (d, n), sparse. Raises ValueError for those of fixed ones."""
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    full = sparse.csr_array(sparse.vstack([one.rows for one in every]))
    held = np.asarray(abs(T).sum(axis=1)).ravel() == 0.0
    if (fixed := np.flatnonzero(held & (np.asarray(abs(full).sum(axis=0)).ravel() != 0.0))).size:
        dof = f"'{names[fixed[0]]}'" if names else fixed[0]
        raise ValueError(
            f"expected gaps of free degrees of freedom, got one of the fixed degree of freedom {dof}, whose "
            "displacement is 0; leave it out of the row"
        )
    B = sparse.csr_array(full @ T)
    B.eliminate_zeros()
    return B


def _require_independent(contacts: Contacts) -> None:
    """Raises ValueError for rows that are 0, and for gaps that may all be closed where their rows are dependent.

    Of dependent rows a sum of gaps is constant; if it is not 0, as of stops on both sides, they are never all closed.
    Frictions are dependent among themselves where all stick.
    """
    sizes = np.linalg.norm(contacts.rows, axis=1)
    if (idle := np.flatnonzero(sizes == 0.0)).size:
        raise ValueError(
            f"expected gaps that degrees of freedom move, got a row of contact '{contacts.name_of(int(idle[0]))}' that "
            "is 0; remove it"
        )
    gaps = contacts.gaps0 / sizes
    whole = np.column_stack([contacts.rows / sizes[:, None], gaps / max(1e-300, float(np.abs(gaps).max()))])
    g = contacts.size - len(contacts.limits)
    for k in range(contacts.size):
        first = 0 if k < g else g
        values = np.linalg.svd(whole[first : k + 1], compute_uv=False)
        if len(values) <= k - first or values[-1] <= DEPENDENT * values[0]:
            raise ValueError(
                f"expected independent gaps, got one of contact '{contacts.name_of(k)}' that those before it give, "
                "so that reactions are not known where all are closed; leave it out"
            )
