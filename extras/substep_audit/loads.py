"""At which instants, and with which weights, a step of a stepper takes the load."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from substep.core.arrays import Array
from substep.structures.march.scheme_plan import step_of

from .fit import largest, recognise
from .identify import FIRST, Match, recursion_terms
from .linear_step import Candidate, Loads
from .noise import QUIET, Noise
from .probes import Measured

INSTANTS = (0.0, 0.5, 1.0)
MOST = 8  # instants of calls that are tried
RESTING = 2  # steps that a late load may leave at rest
SHIFTS = (0.0, -0.5, 0.5, -1.0, 1.0)


@dataclass(frozen=True)
class LoadTaking:
    """How a step takes the load.

    kind: "declared", as the scheme does; "shifted", as the scheme does, but at instants `shift` steps later;
    "weighted", with other weights; "unknown", none of these; "not sought", as there is no scheme; "none", it takes no
    load. loads: of each balance, pairs (weight, instant in steps after t_n). error: the largest deviation relative to
    the state. start: whether the acceleration at t = 0 is that of the equation of motion with the load ("computed") or
    "zero"; "own" if neither. called: the instants, in steps after t_n, at which the program asked for the load.
    """

    kind: Literal["declared", "shifted", "weighted", "unknown", "not sought", "none"]
    loads: Loads = ()
    shift: float = 0.0
    error: float = 0.0
    start: Literal["computed", "zero", "own"] = "computed"
    called: tuple[float, ...] = ()

    @property
    def text(self) -> str:
        """Such as 'f(t_n + h/2)' or '1/2 f(t_n) + 1/2 f(t_n + h)', one a balance."""
        without = {
            "none": "takes no load",
            "unknown": "at no fixed instants that were found",
            "not sought": "not looked for without a scheme",
        }
        if self.kind in without:
            return without[self.kind] + (f"; asked for at {_asked(self.called)}" if self.called else "")
        return "; ".join(_sum(row) for row in self.loads if row)


def load_taking(match: Match, driven: Mapping[str, Measured], noise: Noise = QUIET) -> LoadTaking:
    """How the identified scheme takes the load, from driven runs from rest."""
    if not driven:
        return LoadTaking("none")
    runs = list(driven.values())
    candidate = match.candidate(runs[0].at)
    called = calls_of(runs)
    if not all(np.nan_to_num(run.rows[:, 1:]).any() for run in runs):
        return LoadTaking("unknown", called=called)  # a load that moves nothing tells no instant
    tried = _ways(match, candidate, driven, called, noise)
    return next((way for way in tried if way.error <= noise.match), LoadTaking("unknown", called=called))


def _ways(
    match: Match, candidate: Candidate, driven: Mapping[str, Measured], called: tuple[float, ...], noise: Noise
) -> Iterator[LoadTaking]:
    """How the scheme might take the load, the simplest first: as declared, later or earlier, with other weights."""
    runs = list(driven.values())
    kinds = slice(0, 3 if match.what == "matrix" else 1)
    declared = tuple(system.loads for system in step_of(match.scheme, candidate.at.h).systems)
    for shift in (*SHIFTS, _ramp_shift(candidate, driven["ramp"], declared, kinds, noise)):
        error, start = _best_start(candidate, runs, _moved(declared, shift), kinds, noise)
        yield LoadTaking("shifted" if shift else "declared", _moved(declared, shift), shift, error, start, called)
    tried = [_at_ends(declared, INSTANTS[::2]), _at_ends(declared, INSTANTS), _instants(candidate, declared, called)]
    resting = [run for run in runs if run.load.at(0.0) == 0.0]  # at rest at t = 0, however the start is made
    for instants, given in tried:
        loads = _from_rest(candidate, resting, instants, given, noise)
        error, best = _best_start(candidate, runs, loads, kinds, noise)
        yield LoadTaking("weighted", loads, 0.0, error, best, called)
    if match.what == "matrix" and runs[0].shows(match.scheme.history):
        for instants, given in tried:
            loads = _weighted(candidate, runs, instants, given, noise)
            yield LoadTaking("weighted", loads, 0.0, _one_step_error(candidate, runs, loads), "own", called)
    if match.what == "recursion":
        for shift in SHIFTS:
            loads = _moved(declared, shift)
            kind = "shifted" if shift else "declared"
            yield LoadTaking(kind, loads, shift, _recursion_error(candidate, runs, loads), "own", called)
        for instants, given in tried:
            loads = _by_recursion(candidate, runs, instants, given, noise)
            yield LoadTaking("weighted", loads, 0.0, _recursion_error(candidate, runs, loads), "own", called)


def _ramp_shift(candidate: Candidate, run: Measured, declared: Loads, kinds: slice, noise: Noise) -> float:
    """By how many steps all instants are moved, from a ramp, of which a shift adds a constant, asked for or not.

    0 where nothing moves by which it could be told.
    """
    here, there = (
        _off(replace(candidate, at=run.at, loads=_moved(declared, x)), run, None)[:, RESTING:, kinds]
        for x in (0.0, 1.0)
    )
    unit = there - here
    with np.errstate(all="ignore"):  # where the load moves nothing, deviations relative to the state overflow
        shift = -float(np.nansum(here * unit)) / max(float(np.nansum(unit * unit)), 1e-300)
    return recognise(shift, max(1e-8, noise.rounding))[0] if np.isfinite(shift) else 0.0


def _moved(loads: Loads, shift: float) -> Loads:
    return tuple(tuple((w, tau + shift) for w, tau in row) for row in loads)


def _best_start(
    candidate: Candidate, runs: Sequence[Measured], loads: Loads, kinds: slice, noise: Noise
) -> tuple[float, Literal["computed", "zero", "own"]]:
    """The smallest of the errors with the acceleration at t = 0 computed, zero or, if neither does, fitted."""
    stepped = replace(candidate, loads=loads)
    found: dict[Literal["computed", "zero", "own"], float] = {}
    zero = [_off(stepped, run, 0.0)[..., kinds] for run in runs]
    found["computed"] = max(largest(_off(stepped, run, None)[..., kinds]) for run in runs)
    found["zero"] = max(map(largest, zero))
    if min(found.values()) > noise.match:
        units = [_off(stepped, run, 1.0)[..., kinds] - off for run, off in zip(runs, zero, strict=True)]
        found["own"] = max(largest(_without(off, unit)) for off, unit in zip(zero, units, strict=True))
    best = noise.least(found)
    return found[best], best


def _off(stepped: Candidate, run: Measured, a0: float | None) -> Array:
    """The deviation from a run from rest, with h^2*a at t = 0 given, or the acceleration of the equation of motion."""
    given = None if a0 is None else np.full(len(run.at.Omega), a0 / run.at.powers[2])
    rows = stepped.histories(np.zeros(2), given, run.rows.shape[1] - 1, _load(run))
    return run.deviation(rows * run.at.powers)[:, 1:]


def _without(off: Array, unit: Array) -> Array:
    """The deviation but for a multiple of another one, of each oscillator the one that leaves least."""
    with np.errstate(all="ignore"):
        multiple = np.nansum(off * unit, axis=(1, 2)) / np.nansum(unit * unit, axis=(1, 2))
    return off - np.nan_to_num(multiple)[:, None, None] * unit


def _load(run: Measured) -> Callable[[Array], Array]:
    """The load as a function of an array of times, without a record of the calls."""
    return lambda t: np.array([run.load.at(float(x)) for x in t])


def _from_rest(
    candidate: Candidate, runs: Sequence[Measured], instants: Sequence[float], given: Array, noise: Noise
) -> Loads:
    """The weights nearest to the given ones with which the displacements from rest, a_0 = 0, are the stepper's."""
    balances = len(given)
    columns, rights = [], []
    for run in runs:
        size, zero = np.abs(run.rows[:, 1:, 0]).max(axis=1, keepdims=True), np.zeros(len(run.at.Omega))

        def displacements(loads: Loads, run: Measured = run, size: Array = size, a0: Array = zero) -> Array:
            stepped = replace(candidate, at=run.at, loads=loads)
            rows = stepped.histories(np.zeros(2), a0, run.rows.shape[1] - 1, _load(run))
            return (rows[:, 1:, 0] / size).ravel()

        none: Loads = tuple(() for _ in range(balances))
        unit = [
            displacements(tuple(((1.0, tau),) if i == s else () for i in range(balances)))
            for s in range(balances)
            for tau in instants
        ]
        columns.append(np.array(unit).T)
        rights.append((run.rows[:, 1:, 0] / size).ravel() - displacements(none) - columns[-1] @ given.ravel())
    return _nearest(np.concatenate(columns), np.concatenate(rights), given, instants, noise)


def _at_ends(declared: Loads, instants: Sequence[float]) -> tuple[list[float], Array]:
    """Few instants, at which all balances may take the load, and weights of nothing at them."""
    return list(instants), np.zeros((len(declared), len(instants)))


def _instants(candidate: Candidate, declared: Loads, called: Sequence[float]) -> tuple[list[float], Array]:
    """The instants that are tried, and the declared weights at them (S, J)."""
    own = {float(x) for x in candidate.scheme.parameters.values()}  # such as theta, at which a balance may stand
    instants = sorted({*INSTANTS, *own, *called[:MOST], *(tau for row in declared for _, tau in row)})
    return instants, np.array([[sum(w for w, t in row if t == tau) for tau in instants] for row in declared])


def _nearest(matrix: Array, right: Array, given: Array, instants: Sequence[float], noise: Noise) -> Loads:
    """The given weights changed as little as the equations ask for, as simple numbers to within the noise."""
    known, least = np.isfinite(right), max(1e-8, noise.rounding)
    change = np.linalg.lstsq(matrix[known], right[known], rcond=max(1e-10, noise.size))[0].reshape(given.shape)
    return tuple(
        tuple((recognise(w, least)[0], tau) for w, tau in zip(row, instants, strict=True) if abs(w) > least)
        for row in (given + change).tolist()
    )


def _weighted(
    candidate: Candidate, runs: Sequence[Measured], instants: Sequence[float], given: Array, noise: Noise
) -> Loads:
    """The weights nearest to the given ones with which each step from the stepper's own state is the next one."""
    h = candidate.at.h
    columns, rights = [], []
    for run in runs:
        rest, unit, t = _one_step(candidate, run)
        f = np.array([_load(run)(t + tau * h) for tau in instants])  # (J, K)
        columns.append(np.einsum("pcs,jk->pkcsj", unit, f).reshape(-1, unit.shape[2] * len(instants)))
        rights.append((rest - np.einsum("pcs,sj,jk->pkc", unit, given, f)).ravel())
    return _nearest(np.concatenate(columns), np.concatenate(rights), given, instants, noise)


def _one_step(candidate: Candidate, run: Measured) -> tuple[Array, Array, Array]:
    """What the load adds to each step (P, K, R), what unit loads add (P, R, S), both scaled, and the times t_n (K,)."""
    step, first = candidate.step, max(1 + candidate.lag, run.startup)
    rows, R = run.rows / run.at.powers, step.report.shape[1]
    scale = run.at.powers[:R] / run.at.scale[:, :R]
    added = (rows[:, 1 + first :, :R] - candidate.undriven(rows)[:, first - 1 - candidate.lag :]) * scale[:, None]
    times = np.arange(first, rows.shape[1] - 1) * run.at.h
    return added, step.report[:, :, step.given :] * scale[..., None], times


def _one_step_error(candidate: Candidate, runs: Sequence[Measured], loads: Loads) -> float:
    """The largest deviation of a driven step from the stepper's own state, relative to what the load adds."""
    worst = 0.0
    for run in runs:
        added, unit, t = _one_step(candidate, run)
        load = _load(run)
        forces = np.array([sum((w * load(t + tau * run.at.h) for w, tau in row), np.zeros(len(t))) for row in loads])
        off = added - np.einsum("prs,sk->pkr", unit, forces)
        worst = max(worst, float(np.nanmax(np.abs(off)) / np.nanmax(np.abs(added))))
    return worst


def _by_recursion(
    candidate: Candidate, runs: Sequence[Measured], instants: Sequence[float], given: Array, noise: Noise
) -> Loads:
    """The weights nearest to the given ones with which the displacements obey the candidate's driven recursion."""
    columns, rights = [], []
    for run in runs:

        def off(weights: Array, run: Measured = run) -> Array:
            loads = tuple(tuple(zip(row, instants, strict=True)) for row in weights.tolist())
            return _recursion_off(replace(candidate, loads=loads), run).ravel()

        none = off(np.zeros_like(given))
        units = np.eye(given.size).reshape(-1, *given.shape)
        columns.append(np.array([none - off(unit) for unit in units]).T)
        rights.append(none - columns[-1] @ given.ravel())
    return _nearest(np.concatenate(columns), np.concatenate(rights), given, instants, noise)


def _recursion_error(candidate: Candidate, runs: Sequence[Measured], loads: Loads) -> float:
    """The largest deviation from the driven recursion."""
    return max(largest(_recursion_off(replace(candidate, loads=loads), run)) for run in runs)


def _recursion_off(stepped: Candidate, run: Measured) -> Array:
    """What the load adds to the recursion of u (P, K), less what it adds to the candidate's, over the largest term.

    Neither knows of the start.
    """
    at = run.at
    stepped = replace(stepped, at=at)
    own = stepped.histories(np.zeros(2), np.zeros(len(at.Omega)), run.rows.shape[1] - 1, _load(run)) * at.powers
    found, expected = (recursion_terms(stepped, rows)[..., 0] for rows in (run.rows, own))
    with np.errstate(all="ignore"):
        off = (found.sum(axis=0) - expected.sum(axis=0)) / np.abs(found).max(axis=0)
    return off[:, max(FIRST, run.startup) :]


def calls_of(runs: Sequence[Measured]) -> tuple[float, ...]:
    """The different instants of calls within a step, 0 to 1, where the end of one step is the start of the next."""
    h = runs[0].at.h
    instants = {round(t / h % 1.0, 6) % 1.0 for run in runs for calls in run.called for t in calls}
    return tuple(sorted(recognise(x, 1e-6)[0] for x in instants))


def _asked(called: Sequence[float]) -> str:
    """The instants of calls in words; 0 is where one step ends and the next one begins."""
    inside = ", ".join(f"{x:g}" for x in called if x)
    ends = ["the ends of steps"] if 0.0 in called else []
    return " and ".join(ends + ([f"{inside} of a step"] if inside else []))


def _sum(row: Sequence[tuple[float, float]]) -> str:
    return " + ".join(f"{_factor(w)}f({_instant(tau)})" for w, tau in row)


def _factor(w: float) -> str:
    return "" if w == 1.0 else f"{recognise(w, 1e-9)[1]} "


def _instant(tau: float) -> str:
    if tau == 0.0:
        return "t_n"
    text = recognise(abs(tau), 1e-9)[1]
    return f"t_n {'+' if tau > 0 else '-'} {'' if text == '1' else text + ' '}h"
