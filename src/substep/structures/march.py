"""March a structure: histories at chosen degrees of freedom, the account of energy, and what ends a run."""

import math
import warnings
from collections.abc import Iterable
from typing import Any, Literal

import numpy as np

from ..core.arrays import Array
from ..core.errors import real_number, unknown_name
from ..core.response import Status
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..marching.run import number_of_steps
from .newton import Iteration, NewtonFailed
from .plan import step_of
from .response import Account, StructureResponse
from .steps import Run
from .structure import Dof, Structure

ARGUMENTS = ("dt", "t_end", "dofs", "stride", "account", "newton", "line_search")
WARN = 0.05  # share of the energy beyond which numerical dissipation is worth a warning


class Accounts:
    """Adds up the energies of a run; three products with matrices a step."""

    def __init__(self, structure: Structure) -> None:
        self.structure, self.rows = structure, []
        self.work = self.damped = self.strain = 0.0
        self.u, self.load = structure.u0, structure.force(0.0)
        self.held = structure.restoring(0.0, structure.u0, structure.v0)
        self.keep(structure.v0)

    def keep(self, v: Array) -> None:
        """Store a row at the displacement of the last step."""
        s = self.structure
        if s.internal is None:
            self.strain = 0.5 * float(self.u @ self.held)
        elif s.internal.potential is not None:
            self.strain = s.internal.energy(self.u)
        self.rows.append((0.5 * v @ (s.M @ v), self.strain, self.work, self.damped))

    def add(self, u: Array, v: Array, t: float, h: float) -> None:
        """A step of length h to u, v at the time t; a strain energy without a potential is the work of its force."""
        s, change = self.structure, u - self.u
        load, held = s.force(t), s.restoring(t, u, v)
        self.work += 0.5 * float((self.load + load) @ change)
        self.strain += 0.5 * float((self.held + held) @ change)
        if s.C is not None:
            self.damped += float(change @ (s.damping @ change)) / h
        self.u, self.load, self.held = u, load, held

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
    newton: Literal["simplified", "full"] = "simplified",
    line_search: bool = False,
    **others: Any,
) -> StructureResponse:
    """The response of a structure from t = 0 to t_end in steps of dt; `substep.march` calls it.

    dofs: names or numbers of the degrees of freedom to keep, all by default. stride: keep every stride-th step.
    account: whether to add up energies, at three products with matrices a step; a warning is given where the scheme
    has dissipated more than 5 % of the energy in play. A run that fails or is interrupted from the keyboard keeps
    what it has: see Response.status.

    Raises ValueError for what `march` does, for unknown degrees of freedom, and for a singular effective matrix.
    """
    if "tol" in others or dt is None:
        raise ValueError(
            "expected dt, a constant step, for a structure, got tol or none; steps are chosen on scenes only"
        )
    if others:
        raise unknown_name("an argument of march for a structure", next(iter(others)), ARGUMENTS)
    if newton not in ("simplified", "full"):
        raise unknown_name("a kind of Newton's iteration", newton, ("simplified", "full"))
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
    own = 3 if len(step_of(scheme, h).report) == 3 else 2  # u, v and, where the scheme has its own, a
    rows = np.empty((n // stride + 1, own, len(kept)))
    rows[0] = select(np.array([structure.u0, structure.v0, structure.a0][:own]))
    accounts = Accounts(structure) if account else None
    status: Status = "completed"
    iterations: list[list[int]] = []
    done = 0
    try:
        with np.errstate(all="ignore"):  # a run that overflows ends with a status
            for X, march in Run(structure, scheme, h, Iteration(newton == "full", line_search)).marched(n):
                steps = march.steps
                if not math.isfinite(float(np.vdot(X[-1], X[-1]))):
                    status = "non_finite"
                    break
                done += 1
                iterations.append(march.counts)
                if accounts is not None:
                    u, v = steps.report[:2] @ X
                    accounts.add(u, v, done * h, h)
                    if done % stride == 0:
                        accounts.keep(v)
                if done % stride == 0:
                    rows[done // stride] = select(steps.report[:own], X)
    except NewtonFailed:
        status = "newton_failed"
    except KeyboardInterrupt:
        status = "interrupted"
    rows = rows[: done // stride + 1]
    return _response(structure, scheme, h, stride, kept, rows, status, iterations, accounts)


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
    structure: Structure, scheme: Scheme, h: float, stride: int, kept: list[Dof], rows: Array, status: Status,
    iterations: list[list[int]], accounts: Accounts | None,
) -> StructureResponse:  # fmt: skip
    counts = np.array([(row + [0] * scheme.balances)[: scheme.balances] for row in iterations], np.int64)
    account = accounts.account if accounts is not None else None
    if account is not None and account.share > WARN and status == "completed":
        warnings.warn(
            f"{scheme.name} has dissipated {account.share:.0%} of the energy in play at dt = {h:g}: see account; "
            "take a smaller step, or a scheme with less numerical damping, where that energy matters",
            stacklevel=4,
        )
    return StructureResponse(
        rows[:, 0], rows[:, 1], counts, status, None if status == "completed" else (len(iterations) + 1) * h,
        structure, stride * h, rows[:, 2] if rows.shape[1] == 3 else None, dofs=tuple(kept), account=account,
    )  # fmt: skip
