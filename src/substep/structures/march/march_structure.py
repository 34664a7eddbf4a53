"""March a structure, and what ends a run."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...core.errors import unknown_name, warn
from ...core.outcome import Status
from ...core.progress import shown
from ...core.schemes import Scheme
from ...core.state import State
from ...marching.gained import pressing
from ...run.clock import CHOSEN, Control, steps_of
from ...run.schemes import numbers_only
from ..model.given import Dof
from ..model.model import Model
from .asked_again import AskedAgain, asked_anew
from .energies import WARN
from .event_histories import EventHistories
from .fixed_steps import FixedSteps
from .going_on import begun
from .histories import ChosenHistories, Histories
from .newton import Iteration
from .reacting import suited
from .refusals import require_definite_mass, require_suited, unknown_in_march, unsymmetric
from .response import StructureResponse
from .scheme_plan import step_of
from .step_control import ChosenSteps
from .steps import Run
from .structure_events import EventSteps
from .time_loop import Clock, steps_taken

ARGUMENTS = ("dt", "t_end", "tol", "start", "dofs", "stride", "account", "save", "progress", "newton", "line_search")


def march_structure(
    structure: Model,
    scheme: Scheme | str,
    dt: float | None,
    t_end: float | None,
    *,
    dofs: Iterable[Dof] | None = None,
    stride: int = 1,
    account: bool = True,
    save: str | Path | None = None,
    progress: bool = True,
    newton: Literal["simplified", "full"] = "simplified",
    line_search: bool = False,
    tol: float | None = None,
    start: Any = None,
    **chosen: Any,
) -> StructureResponse:
    """The response of a structure from t = 0 to t_end in steps of dt, or of tol; `substep.march` calls it.

    dofs: names or numbers of the degrees of freedom to keep, all by default. stride: keep every stride-th step.
    account: whether to add up energies, at a product with each of M and K a step, two that read it once where there is
    damping, and one internal force more where that has no potential, or four where it has one and takes v. A warning is
    given where the scheme has dissipated or gained more than 5 % of the energy in play, beyond what the work is
    uncertain by, and where M or K is not symmetric, so that there is no account. save: a folder for a Zarr store,
    written as the march goes on; the same call again, or one with a later t_end, goes on from the last checkpoint, even
    after a kill, and gives the same to the bit. progress: a bar on the terminal once a second has passed. newton:
    "simplified" keeps a tangent while the iteration contracts by a factor of 5, "full" takes one in every iteration;
    line_search: halve a correction by which the residual grows.

    Damping may be in an internal force that takes v. A scheme of u'' = g(t, u) refuses it, at the start and, by one
    evaluation of such a force a step, when it sets in later. Where coefficients of a scheme take C, as those of
    KR-alpha do, they take the derivative of the force by v at the start besides; a warning is given when the damping
    has become another.

    tol: steps are chosen in place of dt, by the estimates and the controller of scenes (docs/adaptive.md). A step is
    accepted if the root of the mean square of its estimated errors of u and v over all free degrees of freedom, each
    over its scale, is at most 1. A scale is rtol |.| + atol, by default tol |.| + tol times the largest root of the
    mean square of u, or of v, so far; of u at least that of the static displacement under the largest loads. More about
    them: rtol; atol, of u or of u and v, in their units; dt_first, dt_min, dt_max, s; rung, the ratio of the lengths
    between which steps move, by default the root of 2 where a length has factors of its own. Steps end on t_end and
    where a load of substep's own jumps or has a kink; each is a row, so that stride and save take dt. With contacts,
    friction or nonlinear constraints the error is what a step differs by from two of half the length, and steps end
    where what acts changes, as those of scenes: see `happenings` of the response.

    start: as for scenes, with u, v, a (N,) of all degrees of freedom, from which the run goes on; the account of energy
    begins there anew. The tangent that coefficients of KR-alpha and Rayleigh damping take stays that at the
    structure's u0. A force of the user's is asked anew there in each march, as what its function reads may change.

    A run that fails or is interrupted from the keyboard keeps what it has: see Response.status. If a function of the
    user's raises, the exception's `response` is what was done. Raises ValueError for what `march` does, for unknown
    degrees of freedom, for a mass matrix with negative eigenvalues, damping or degrees of freedom without mass with a
    scheme that takes none, for a singular effective matrix, and for another march at `save`; MemoryError for histories
    that do not fit in memory.
    """
    known = tuple(name for name in CHOSEN if name != "grid")  # rows are steps
    if unknown := [name for name in chosen if name not in known]:
        raise unknown_in_march("an argument of march for a structure", unknown[0], (*ARGUMENTS, *known), scheme)
    if newton not in ("simplified", "full"):
        raise unknown_name("a kind of Newton's iteration", newton, ("simplified", "full"))
    scheme = numbers_only(scheme, "substep.sweep takes arrays")
    if tol is not None and (stride != 1 or save is not None):
        raise ValueError("expected stride and save with dt only, got them with tol; keep some dofs, or give dt")
    state = None if start is None else State.given(start, scheme)
    steps = steps_of(dt, tol, t_end, stride=stride, start=state, chosen=chosen)
    structure = asked_anew(structure, at_start=state is None)
    require_definite_mass(structure)
    if account and (name := unsymmetric(structure)):
        warn(
            f"there is no account of energy where {name} is not symmetric, since no energy belongs to such a matrix; "
            "march with account=False"
        )
        account = False
    kept = structure.kept(dofs)
    iteration = Iteration(newton == "full", line_search)
    h = steps.t_end if isinstance(steps, Control) else steps.dt
    require_suited(structure, scheme, h)
    structure = suited(structure, step_of(scheme, h))
    run, tangents = begun(Run(structure, scheme, h, iteration), steps, state)
    if isinstance(steps, Control):
        clock = chosen_clock(run, steps, absolute="atol" in chosen)
        if isinstance(clock, EventSteps):
            return _marched(clock, EventHistories(clock, kept, account, state), progress)
        return _marched(clock, ChosenHistories(clock, kept, account, state), progress)
    found = Histories(run, steps, kept, account, save, state)
    resumed = found.done, found.state, found.tangents or tangents, found.memory, found.stands
    return _marched(FixedSteps(run, steps.n, *resumed), found, progress)


def chosen_clock(run: Run, asked: Control, *, absolute: bool) -> ChosenSteps | EventSteps:
    """The clock of steps of chosen length; absolute: whether atol of u was given, else it is a share of the largest u.

    Raises ValueError for a scheme, or a structure, with which no steps can be chosen.
    """
    share_u, atol_u = (0.0, asked.atol_u) if absolute else (asked.atol_u, 0.0)
    kind = ChosenSteps if run.structure.contacts is None else EventSteps
    return kind(run, replace(asked, atol_u=atol_u), (share_u, asked.share_v))


def _marched(clock: Clock, kept: Histories | ChosenHistories | EventHistories, progress: bool) -> StructureResponse:
    """March to the end, or to what ends the run before it, and respond with what was kept until then.

    progress: whether to show a bar. An exception of a function of the user's, or of a tangent that is singular, carries
    the response until then.
    """
    status: Status = "interrupted"
    try:
        # a run that overflows ends with a status
        with np.errstate(all="ignore"), shown(clock.total, clock.done, progress, "march", clock.unit) as advance:
            done, asked = clock.done, AskedAgain(kept.run)
            for step in steps_taken(clock):
                kept.add(step)  # type: ignore[arg-type]
                asked.after(step)
                advance(clock.done - done)
                done = clock.done
            asked.look()
        status = clock.status
    except KeyboardInterrupt:
        pass
    except Exception as error:
        error.response = kept.response(status)  # type: ignore[attr-defined]
        error.add_note("what the march had done before is in the attribute `response` of this exception")
        raise
    r = kept.response(status)
    gained = status == "completed" and r.account is not None and r.account.share < -WARN
    if gained and r.account is not None and (found := pressing(r, -r.account.numerical)):
        warn(f"{r.scheme.name} has gained energy: {found}")
    return r
