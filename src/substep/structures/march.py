"""March a structure: histories at chosen degrees of freedom, the account of energy, and what ends a run."""

import math
import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from ..core.arrays import Array
from ..core.errors import real_number, unknown_name
from ..core.response import Status
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..marching.run import number_of_steps
from .combine import combined, dot
from .linear import marched
from .response import Account, StructureResponse
from .structure import Dof, Structure

WARN = 0.05  # share of the energy beyond which numerical dissipation is worth a warning


class Accounts:
    """Adds up the energies of a run; three products with matrices a step."""

    def __init__(self, structure: Structure) -> None:
        self.structure, self.rows = structure, []
        self.work = self.damped = 0.0
        self.u, self.force = structure.u0, structure.force(0.0)
        self.Ku = structure.K @ self.u
        self.keep(structure.v0)

    def keep(self, v: Array) -> None:
        """Store a row at the displacement of the last step."""
        kinetic, strain = 0.5 * dot(v, self.structure.M @ v), 0.5 * dot(self.u, self.Ku)
        self.rows.append((kinetic, strain, self.work, self.damped))

    def add(self, u: Array, t: float, h: float) -> None:
        """A step of length h to u at the time t."""
        s, change, force = self.structure, u - self.u, self.structure.force(t)
        self.work += 0.5 * dot(self.force + force, change)
        if s.C is not None:
            self.damped += dot(change, s.damping @ change) / h
        self.u, self.force, self.Ku = u, force, s.K @ u

    @property
    def account(self) -> Account:
        """What was stored."""
        return Account(*np.array(self.rows).T)


def march_structure(
    structure: Structure,
    scheme: Scheme | str,
    dt: float | None,
    t_end: float,
    *,
    dofs: Iterable[Dof] | None = None,
    stride: int = 1,
    account: bool = True,
    **others: Any,
) -> StructureResponse:
    """The response of a structure from t = 0 to t_end in steps of dt; `substep.march` calls it.

    dofs: names or numbers of the degrees of freedom to keep, all by default. stride: keep every stride-th step.
    account: whether to add up energies, at three products with matrices a step; a warning is given where the scheme
    has dissipated more than 5 % of the energy in play. A run that fails or is interrupted from the keyboard keeps
    what it has: see Response.status.

    Raises ValueError for what `march` does, for unknown degrees of freedom, and for a singular effective matrix.
    """
    if others:
        raise unknown_name("an argument of march for a structure", next(iter(others)), ("dofs", "stride", "account"))
    if dt is None:
        raise ValueError("expected dt, a constant step, for a structure, got none; steps are chosen on scenes only")
    scheme = make_scheme(scheme) if isinstance(scheme, str) else scheme
    if not scheme.info.damping and structure.C is not None:
        raise ValueError(
            f"{scheme.name} is a scheme for u'' = g(t, u): expected a structure without damping; take another scheme"
        )
    h = real_number("dt", dt, positive=True)
    n = number_of_steps(h, t_end)
    kept = list(dofs) if dofs is not None else list(structure.names or range(structure.T.shape[0]))
    places = [structure.place(dof) for dof in kept]
    select = _selection(structure, places)
    rows = [select(np.array([structure.u0, structure.v0, structure.a0]))]
    accounts = Accounts(structure) if account else None
    status: Status = "completed"
    done = 0
    try:
        for X, steps in marched(structure, scheme, h, n):
            if not math.isfinite(dot(X[-1], X[-1])):
                status = "non_finite"
                break
            done += 1
            if accounts is not None:
                u, v = combined(steps.report[:2], X)
                accounts.add(u, done * h, h)
                if done % stride == 0:
                    accounts.keep(v)
            if done % stride == 0:
                rows.append(select(steps.report, X))
    except KeyboardInterrupt:
        status = "interrupted"
    return _response(structure, scheme, h, stride, kept, rows, status, done, accounts)


def _selection(structure: Structure, places: list[int]) -> Any:
    """A function of rows, and of vectors that they combine, to values (rows, k) at these degrees of freedom."""
    part = structure.T[places]
    columns = np.unique(part.indices)
    part = part[:, columns]
    plain = part.shape[0] == part.shape[1] and (abs(part - np.eye(len(columns))).max() if len(columns) else 1) == 0

    def select(rows: Array, X: Array | None = None) -> Array:
        found = rows[:, columns] if X is None else rows @ X[:, columns]
        return found if plain else (part @ found.T).T

    return select


def _response(
    structure: Structure, scheme: Scheme, h: float, stride: int, kept: list[Dof], rows: list[Array], status: Status,
    done: int, accounts: Accounts | None,
) -> StructureResponse:  # fmt: skip
    own = all(len(row) == 3 for row in rows)
    u, v, *a = (np.array([row[kind] for row in rows]) for kind in range(3 if own else 2))
    account = accounts.account if accounts is not None else None
    if account is not None and account.share > WARN and status == "completed":
        warnings.warn(
            f"{scheme.name} has dissipated {account.share:.0%} of the energy in play at dt = {h:g}: see account; "
            "take a smaller step, or a scheme with less numerical damping, where that energy matters",
            stacklevel=4,
        )
    return StructureResponse(
        u, v, np.zeros((done, scheme.balances), np.int64), status, None if status == "completed" else (done + 1) * h,
        structure, stride * h, a[0] if own else None, dofs=tuple(kept), account=account,
    )  # fmt: skip
