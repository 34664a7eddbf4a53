"""March a structure, and what ends a run."""

import math
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..core.errors import real_number, unknown_name
from ..core.progress import shown
from ..core.response import Status
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..marching.run import number_of_steps
from .histories import Histories
from .newton import Iteration, NewtonFailed
from .response import Account, StructureResponse
from .steps import Run
from .structure import Dof, Structure

ARGUMENTS = ("dt", "t_end", "dofs", "stride", "account", "save", "progress", "newton", "line_search")
WARN = 0.05  # share of the energy beyond which numerical dissipation is worth a warning


def march_structure(
    structure: Structure,
    scheme: Scheme | str,
    dt: float | None,
    t_end: float,
    *,
    dofs: Iterable[Dof] | None = None,
    stride: int = 1,
    account: bool = True,
    save: str | Path | None = None,
    progress: bool = True,
    newton: Literal["simplified", "full"] = "simplified",
    line_search: bool = False,
    **others: Any,
) -> StructureResponse:
    """The response of a structure from t = 0 to t_end in steps of dt; `substep.march` calls it.

    dofs: names or numbers of the degrees of freedom to keep, all by default. stride: keep every stride-th step.
    account: whether to add up energies, at three products with matrices a step; a warning is given where the scheme
    has dissipated more than 5 % of the energy in play. save: a folder for a Zarr store, written as the march goes on;
    the same call again goes on from the last checkpoint, even after a kill, and a linear structure then gives the same
    to the bit. progress: a bar on the terminal once a second has passed. newton: "simplified" keeps a tangent while the
    iteration contracts by a factor of 5, "full" takes one in every iteration; line_search: halve a correction by which
    the residual grows.

    A run that fails or is interrupted from the keyboard keeps what it has: see Response.status. If a function of the
    user's raises, the exception's `response` is what was done. Raises ValueError for what `march` does, for unknown
    degrees of freedom, for a singular effective matrix, and for another march at `save`.
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
    run = Run(structure, scheme, h, Iteration(newton == "full", line_search))
    found = Histories(run, n, [structure.place(dof) for dof in kept], stride, account, save)
    status: Status = "completed"
    try:
        # a run that overflows ends with a status
        with np.errstate(all="ignore"), shown(n, found.done, progress, "march", "steps") as advance:
            for X, march in run.marched(n, found.state, found.done):
                if not math.isfinite(float(X[-1].sum())):
                    status = "non_finite"
                    break
                found.add(X, march)
                advance(1)
    except NewtonFailed:
        status = "newton_failed"
    except KeyboardInterrupt:
        status = "interrupted"
    except Exception as error:  # of a load or a force of the user's, or a tangent that is singular
        found.checkpoint()
        error.response = _response(found, "interrupted", kept)  # type: ignore[attr-defined]
        error.add_note("what the march had done before is in the attribute `response` of this exception")
        raise
    found.checkpoint()
    return _response(found, status, kept)


def _response(found: Histories, status: Status, kept: list[Dof]) -> StructureResponse:
    run, balances = found.run, found.run.scheme.balances
    counts = np.array([(row + [0] * balances)[:balances] for row in found.iterations[: found.done]], np.int64)
    account = Account(*np.array(found.accounts[: found.kept]).T) if found.accounts else None
    if account is not None and account.share > WARN and status == "completed":
        warnings.warn(
            f"{run.scheme.name} has dissipated {account.share:.0%} of the energy in play at dt = {run.h:g}: see "
            "Response.account; take a smaller step, or a scheme with less numerical damping, where that energy matters",
            stacklevel=5,
        )
    u, v, *a = found.read()
    return StructureResponse(
        u, v, counts, status, None if status == "completed" else (found.done + 1) * run.h, run.structure,
        found.stride * run.h, a[0] if a else None, dofs=tuple(kept), account=account,
    )  # fmt: skip
