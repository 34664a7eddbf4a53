"""Why a stepper departs from what it is said to be: root causes, each with what follows from it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from substep.core.arrays import Array
from substep.core.schemes import Scheme

from .claims import Judgement
from .declared import declared
from .fit import family_of, free_parameters, number, recognise, stated
from .identify import SAME, WHOLE, Identification, Match, agreement, is_claimed
from .linear_step import DAMPED_BY
from .loads import LoadTaking
from .noise import ROUNDING
from .orders import MOTIONS, UNDAMPED, Order, written
from .outputs import instants_text
from .probes import given_runs, own_runs
from .stepper import Stepper

FREE, DRIVEN, FROM_REST = MOTIONS


@dataclass(frozen=True)
class Deviation:
    """A root cause, in words, and what follows from it.

    kind: "scheme", "parameter", "damping", "start", "load", "output", "precision", or "claim" for a claim that fails
    without any of these: the scheme is what it is said to be, and does not have the property.
    """

    kind: str
    text: str
    consequences: tuple[str, ...] = ()


@dataclass(frozen=True)
class Evidence:
    """What deviations are found from.

    orders: as observed; expected: of the identified scheme, by the same runs. instants: of v and a, by
    `output_instants`.
    """

    stepper: Stepper
    claimed: Scheme | None
    found: Identification
    load: LoadTaking
    judgements: Sequence[Judgement]
    orders: Mapping[str, Order]
    expected: Mapping[str, Order]
    instants: Mapping[str, float]

    @property
    def failed(self) -> list[Judgement]:
        """The claims that do not hold, but for that of the scheme."""
        return [j for j in self.judgements if j.claim != "scheme" and j.verdict in ("false", "partly")]

    def lowered(self, motion: str, kind: int = 0) -> str:
        """In words, the order of u, v or a that a motion, damped or not, loses against the identified scheme."""
        for name in (motion, UNDAMPED + motion):
            found, expected = (
                orders[name][kind] if name in orders else None for orders in (self.orders, self.expected)
            )
            if found is None or math.isnan(found) or (expected is None and kind):
                continue
            if expected is None or found <= expected - 0.25:
                return f"order of {'uva'[kind]} in {name} motion: {written(found)}, not {written(expected)}"
        return ""


def deviations(e: Evidence) -> tuple[Deviation, ...]:
    """Root causes, by comparison with the claimed scheme, and with the identified one."""
    failed = tuple(_failed(judgement) for judgement in e.failed)
    if not e.found.matches:
        if e.claimed is None:
            return tuple(Deviation("claim", text) for text in failed)
        if any(is_claimed(match.scheme, e.claimed) for match in e.found.undamped):
            return (Deviation("damping", f"only without damping it is {stated(e.claimed)}", failed),)
        near = f"; nearest is {e.found.nearest.text}" if e.found.nearest else ""
        return (Deviation("scheme", f"it is not {stated(e.claimed)}, nor any scheme of the catalogue{near}", failed),)
    best = e.found.matches[0]
    causes = [
        *_of_scheme(e, best),
        *_of_damping(e, best),
        *_of_start(e, best),
        *_of_load(e),
        *_of_outputs(e, best),
        *_of_precision(e, best),
    ]
    follows = {id(cause): list(cause.consequences) for cause in causes}
    left = []
    for judgement in e.failed:
        cause = _cause(causes, judgement)
        if cause is None:
            left.append(Deviation("claim", _failed(judgement)))
        else:
            follows[id(cause)].append(_failed(judgement))
    return (*(Deviation(cause.kind, cause.text, tuple(follows[id(cause)])) for cause in causes), *left)


def _cause(causes: Sequence[Deviation], judgement: Judgement) -> Deviation | None:
    """The one of the causes by which a claim fails.

    An order that holds from rest fails by the start, one that holds in free motion by the load; all else by the scheme.
    """
    kinds = ["damping", "scheme", "parameter"]
    if judgement.claim == "order":
        failing = {motion.removeprefix(UNDAMPED) for motion in judgement.motions}
        if FROM_REST not in failing:
            kinds = ["start", *kinds]
        elif FREE not in failing:
            kinds = ["load", "start", *kinds]
        else:
            kinds = [*kinds, "load", "start", "precision"]
    return next((cause for kind in kinds for cause in causes if cause.kind == kind), None)


def _failed(judgement: Judgement) -> str:
    return f"{judgement.claim}: claimed {judgement.claimed}, found {judgement.found}"


def _of_scheme(e: Evidence, best: Match) -> list[Deviation]:
    claimed, lost = e.claimed, tuple(filter(None, map(e.lowered, MOTIONS)))
    near = e.found.claimed
    agreeing = [*e.found.on_linear, *([near] if near is not None and near.what in WHOLE else [])]
    if claimed is None or any(is_claimed(match.scheme, claimed) for match in agreeing):
        if claimed is not None and best.what == "spectrum":
            return [Deviation("scheme", f"only the eigenvalues are those of {best.text}", lost)]
        return []
    if near is not None and near.what not in WHOLE and is_claimed(near.scheme, claimed):
        started = Deviation("start", f"u obeys the recursion of {near.text}; with the first steps it is {best.text}")
        other = Deviation("scheme", f"only the eigenvalues are those of {near.text}; it steps as {best.text}")
        return [started if near.what == "recursion" else other]
    same = next((match for match in e.found.on_linear if match.scheme.name == claimed.name), None)
    if same is None:
        if one := _one_parameter(e, claimed):
            return [Deviation("parameter", one)]
        return [Deviation("scheme", f"it is {best.text}, not {stated(claimed)}")]
    texts = _of_parameters(claimed.given, same.scheme.parameters, same.unsure)
    if len(texts) > 1 and (was := family_of(claimed)) and (got := family_of(same.scheme)).keys() == was.keys():
        texts = _of_parameters(was, got, same.unsure)
    return [Deviation("parameter", text) for text in texts]


def _one_parameter(e: Evidence, claimed: Scheme) -> str:
    """In words, the one parameter in which the claimed scheme, as a case of a found one, is changed; or nothing."""
    stepper = declared(claimed)
    free, own = given_runs(stepper), own_runs(stepper)
    for match in e.found.on_linear:
        names = free_parameters(match.scheme)
        case = agreement(match.scheme, free, own) if len(names) > 1 else None
        if case is not None and case.what == "matrix":
            values = {name: case.scheme.parameters[name] for name in names}
            changed = _of_parameters(values, match.scheme.parameters, match.unsure)
            if len(changed) == 1:
                return f"{changed[0]} as {stated(claimed)} has it as a case of {match.scheme.name}"
    return ""


def _of_parameters(
    claimed: Mapping[str, Array | float], found: Mapping[str, Array | float], unsure: float
) -> list[str]:
    """What happened to the values: exchanged, of the other sign, counted from the other end of the step, or changed."""
    was, got = ({name: float(values[name]) for name in claimed} for values in (claimed, found))
    within = max(SAME, unsure)

    def near(one: float, other: float) -> bool:
        return abs(one - other) <= within

    def pair(name: str) -> str:
        return f"{name} is {number(got[name], unsure)}, not {number(was[name], 0.0)}"

    changed = [name for name in was if not near(was[name], got[name])]
    texts, done = [], set()
    for one in changed:
        for other in changed:
            if one < other and near(was[one], got[other]) and near(was[other], got[one]):
                texts.append(f"{one} and {other} are exchanged: {pair(one)}, {pair(other)}")
                done |= {one, other}
    for name in changed:
        if name in done:
            continue
        if near(got[name], -was[name]):
            texts.append(f"{name} has the other sign: {pair(name)}")
        elif near(got[name], 1.0 - was[name]):
            texts.append(f"{name} weighs the other end of the step: {pair(name)}")
        else:
            texts.append(pair(name))
    return texts


def _of_damping(e: Evidence, best: Match) -> list[Deviation]:
    """Where another velocity than the declared one damps and costs order, if a scheme is claimed or a claim fails."""
    lost, said = e.lowered(FREE), e.claimed is not None or bool(e.failed)
    if best.damping == "declared" or not lost or not said:
        return []
    return [Deviation("damping", f"the damping force is that of {DAMPED_BY[best.damping]}", (lost,))]


def _of_start(e: Evidence, best: Match) -> list[Deviation]:
    """Where the start costs order; of a scheme that carries an acceleration, or that another one starts which does."""
    carries = best.scheme.starter is not None or any(kind == 2 for kind, _ in best.scheme.history)
    if not carries or best.what == "spectrum":
        return []
    lost = tuple(text for text in (e.lowered(FREE), e.lowered(DRIVEN)) if text)
    if not lost:
        return []
    if best.start == "zero":
        given = ", unless it is given" if "a" in e.stepper.can.sets else ""
        return [Deviation("start", f"the acceleration at t = 0 is taken as 0{given}", lost)]
    if best.start == "own":
        return [Deviation("start", "the first step is not the scheme's, with a_0 computed or 0", lost)]
    if e.load.start == "zero" and e.load.kind in ("declared", "shifted", "weighted"):
        return [Deviation("start", "the acceleration at t = 0 leaves out the load", tuple(lost[-1:]))]
    return []


def _of_load(e: Evidence) -> list[Deviation]:
    """Where other instants than the scheme's cost order; else they are a choice, and stand in the report."""
    lost = e.lowered(FROM_REST)
    if not lost or e.load.kind in ("declared", "none"):
        return []
    text = f"the load is taken as {e.load.text}"
    if e.load.kind == "shifted":
        by = recognise(abs(e.load.shift), 1e-9)[1]
        text = f"the load is that of {by} step {'before' if e.load.shift < 0 else 'after'}: {e.load.text}"
    if e.load.kind == "unknown":
        text = f"the load is taken {e.load.text}"
    return [Deviation("load", text, (lost,))]


def _of_outputs(e: Evidence, best: Match) -> list[Deviation]:
    """Where u is the scheme's, and v or a is another one and of lower order."""
    lost = tuple(filter(None, (e.lowered(FROM_REST, kind) for kind in (1, 2))))
    if best.what != "displacements" or e.lowered(FROM_REST) or not lost:
        return []
    if e.instants:
        return [Deviation("output", instants_text(e.instants), lost)]
    return [Deviation("output", f"u is that of {best.text}; the v or a that is returned is not", lost)]


def _of_precision(e: Evidence, best: Match) -> list[Deviation]:
    if best.error > max(ROUNDING, 10.0 ** (3.0 - e.stepper.can.digits)):
        return [Deviation("precision", f"results hold {-math.log10(best.error):.0f} digits")]
    return []
