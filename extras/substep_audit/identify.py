"""Which declared scheme a stepper is: the schemes of the catalogue compared with its histories."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Literal

import numpy as np

from substep.core.arrays import Array
from substep.core.schemes import Scheme, schemes
from substep.core.schemes import scheme as make_scheme

from .fit import Residual, described, free_parameters, largest, recognise, simple, solutions, solve
from .linear_step import DAMPED_BY, Candidate, Damping, Oscillators
from .noise import QUIET, Noise
from .probes import Measured

What = Literal["matrix", "displacements", "recursion", "spectrum"]
WHOLE: tuple[What, ...] = ("matrix", "displacements")  # that tell a scheme from others of the same eigenvalues
Start = Literal["computed", "zero", "own"]
PLAIN = 10.0  # largest parameter that is a simple number
FIRST = 2  # steps at the start that another scheme may have made, or a wrong start
SAME = 1e-7  # parameters that differ by less are the same


@dataclass(frozen=True)
class Match:
    """A scheme that does what a stepper does.

    what: "matrix", all that the stepper returns agrees; "displacements", its displacements do, its v or a are others;
    "recursion", the recursion of its displacements does, and there is nothing else to compare but the first steps;
    "spectrum", its eigenvalues do. error: the largest deviation, see `Measured.deviation`. start: where its
    acceleration at t = 0 comes from: "computed" from the equation of motion, or "zero"; "own", neither of these.
    solved: how many parameters were solved for; unsure: by how much the noise may have moved them. damping: of which
    velocity its damping force is. doubtful: that it agrees within the noise, but is not the same as the first match.
    """

    scheme: Scheme
    what: What
    error: float
    start: Start
    solved: int
    unsure: float = 0.0
    damping: Damping = "declared"
    doubtful: bool = False

    @property
    def text(self) -> str:
        """The scheme with its parameters, such as newmark(beta = 1/4, gamma = 1/2)."""
        dialect = "" if self.damping == "declared" else f" damped by {DAMPED_BY[self.damping]}"
        return described(self.scheme, self.unsure) + dialect

    def candidate(self, at: Oscillators) -> Candidate:
        """What it does on oscillators."""
        return Candidate(self.scheme, at, damping=self.damping)


@dataclass(frozen=True)
class Identification:
    """matches: the schemes that do what was measured, best first. nearest: where none does, the one least far off, and
    differs: in what, in words.

    claimed: how far the claimed scheme agrees; None if not even its eigenvalues do, or none is claimed.
    apart: schemes that agree on the linear oscillator, but not under a cubic spring, with their deviation there;
    nonlinear: the least deviation there, None where no spring was tried. undamped: where none matches, the schemes that
    do on undamped oscillators.
    """

    matches: tuple[Match, ...]
    nearest: Match | None = None
    claimed: Match | None = None
    apart: tuple[tuple[Match, float], ...] = ()
    differs: str = ""
    nonlinear: float | None = None
    undamped: tuple[Match, ...] = ()

    @property
    def on_linear(self) -> tuple[Match, ...]:
        """The schemes that do the same on the linear oscillator."""
        return (*self.matches, *(match for match, _ in self.apart))


def levels(free: Sequence[Measured]) -> tuple[What, ...]:
    """What may agree with runs, from the most to the least.

    Where u alone is returned, it is the scheme's from some start if and only if it obeys the scheme's recursion.
    """
    if free[0].start[2] is None and not any(np.isfinite(run.rows[:, 1:, 1:]).any() for run in free):
        return ("matrix", "recursion")
    return ("matrix", "displacements", "spectrum")


def identify(
    free: Sequence[Measured],
    own: Sequence[Measured],
    first: Scheme | None = None,
    noise: Noise = QUIET,
    whats: Sequence[What] | None = None,
) -> Identification:
    """The schemes of the catalogue that do what was measured, those with the fewest parameters left free.

    own: runs in which the stepper finds its own acceleration at t = 0; free: such runs, or those where it was given.
    first: a scheme to try at its own values before all others, such as the one a manual claims; where it matches, it is
    the first of the matches. noise: of the runs; where it hides the scheme, none is looked for. whats: what may agree,
    all `levels` if None.
    """
    if noise.hides:
        return Identification(())
    damping = bool(free[0].at.xi.any())
    pool = [s for s in map(make_scheme, schemes()) if not s.info.together and (s.info.damping or not damping)]
    nearest: Match | None = None
    claimed = None if first is None else agreement(first, free, own, noise)
    for what in levels(free) if whats is None else whats:
        same = [claimed] if claimed is not None and claimed.what == what else []
        for solved, variants in groupby(sorted(_variants(pool), key=_freedom), key=_freedom):
            tried = [fitted(scheme, names, what, free, own, noise) for scheme, names in variants]
            found = [match for match in tried if credible(match, noise)]
            if same and same[0].solved <= solved:
                found = [*same, *(match for match in found if match.scheme.name != same[0].scheme.name)]
            if found:
                return Identification(tuple(found), claimed=claimed)
            if what == "matrix":
                nearest = min([*tried, *([nearest] if nearest else [])], key=lambda match: match.error)
        if same:
            return Identification(tuple(same), claimed=claimed)
    if nearest is not None:  # its parameters are known to a few digits
        names = free_parameters(nearest.scheme)[: nearest.solved]
        nearest = fitted(nearest.scheme, names, "matrix", free, own, noise, worth=np.inf)
    return Identification((), nearest, differs=differing(nearest, free, noise) if nearest else "")


def differing(nearest: Match, free: Sequence[Measured], noise: Noise) -> str:
    """In words, what of the nearest scheme's steps is not what was measured, and where; empty where all agree."""
    at = free[0].at
    tried = [residual(Candidate(nearest.scheme, at)) for residual in residuals(nearest.scheme, "matrix", free)]
    off = np.nan_to_num(np.abs(min(tried, key=largest))).max(axis=(0, 2)) > noise.match  # (P, 3)
    if not off.any():
        return ""
    kinds = " and ".join(name for name, there in zip("uva", off.any(axis=0), strict=True) if there)
    there = off.any(axis=1)
    first, damped = at.Omega[there].min(initial=np.inf), at.xi[there].min(initial=np.inf)
    where = f" from Omega = {first:g} on" + (", where damped only" if damped > 0.0 else "")
    eigen = largest(recursion_residual(Candidate(nearest.scheme, at), free))
    return f", differs in {kinds}{where}" + ("; its eigenvalues too" if eigen > noise.match else "; not in eigenvalues")


def credible(match: Match, noise: Noise) -> bool:
    """Whether a deviation is noise, or a little more, and the parameters mean something.

    A scheme with parameters left free can come near another one. Its values are then believed where they are simple
    numbers, or where they lie in their intervals and the deviation is not more than the noise.
    """
    if match.solved == 0:
        return match.error <= noise.match
    found = {name: float(match.scheme.parameters[name]) for name in free_parameters(match.scheme)}
    if all(abs(x) <= PLAIN and simple(recognise(x, 1e-12)[1]) for x in found.values()):
        return match.error <= noise.match
    known = match.scheme.info.parameters
    low, high = ({name: getattr(known[name], end) for name in found} for end in ("low", "high"))
    inside = all(
        (low[name] is None or x >= low[name]) and (high[name] is None or x <= high[name]) for name, x in found.items()
    )
    return inside and match.error <= noise.rounding


def is_claimed(found: Scheme, claimed: Scheme) -> bool:
    """Whether it is the claimed scheme with the values that were claimed; others are free."""
    same = found.name == claimed.name
    return same and all(abs(float(found.parameters[name]) - float(x)) <= SAME for name, x in claimed.given.items())


def _variants(pool: Sequence[Scheme]) -> Iterator[tuple[Scheme, Sequence[str]]]:
    """Every scheme at its defaults, and with its parameters free."""
    for scheme in pool:
        yield scheme, ()
        if names := free_parameters(scheme):
            yield scheme, names


def _freedom(variant: tuple[Scheme, Sequence[str]]) -> int:
    return len(variant[1])


def agreement(scheme: Scheme, free: Sequence[Measured], own: Sequence[Measured], noise: Noise = QUIET) -> Match | None:
    """How far a scheme agrees with what was measured: at its own values, or else with as few others as will do.

    One of its parameters is left free at a time, so that the noise moves no other one, and then all of them.
    """
    names = free_parameters(scheme)
    alone = [[name] for name in names] if len(names) > 1 else []
    for what in levels(free):
        for variants in ([[]], alone, [names]):
            tried = [fitted(scheme, some, what, free, own, noise) for some in variants]
            found = [match for match in tried if credible(match, noise)]
            if found:
                return min(found, key=lambda match: match.error)
    return None


def fitted(
    scheme: Scheme,
    names: Sequence[str],
    what: What,
    free: Sequence[Measured],
    own: Sequence[Measured],
    noise: Noise,
    damping: Damping = "declared",
    worth: float | None = None,
) -> Match:
    """The scheme with the named parameters solved for, whether it matches or not.

    worth: the deviation up to which they are solved for to all digits, that of the noise if None.
    """
    most = noise.worth if worth is None else worth
    fits = [
        solve(scheme, names, free[0].at, lambda c, r=residual: r(replace(c, damping=damping)), most)
        for residual in residuals(scheme, what, free)
    ]
    best = min(fits, key=lambda fit: fit.error)
    match = Match(best.scheme, what, best.error, "own", len(names), best.unsure, damping)
    if best.error > noise.match:
        return match
    return replace(match, start=_start(match.candidate(free[0].at), what, own, noise))


def with_other_values(match: Match, free: Sequence[Measured], noise: Noise) -> Iterator[Match]:
    """The same scheme at other values of its parameters that do what was measured as well, where they were solved for.

    Two sub-steps of silva_bezerra's, for one, may be exchanged.
    """
    names = free_parameters(match.scheme)[: match.solved]
    for residual in residuals(match.scheme, match.what, free) if names else ():
        for solution in solutions(match.scheme, names, free[0].at, residual, noise.worth):
            other = replace(match, scheme=solution.scheme, error=solution.error)
            if credible(other, noise) and not is_claimed(match.scheme, solution.scheme):
                yield other


def residuals(scheme: Scheme, what: What, free: Sequence[Measured]) -> list[Residual]:
    """What vanishes for a candidate that does what was measured."""
    if what in ("recursion", "spectrum"):
        return [lambda c: recursion_residual(c, free)]
    own_state = scheme.info.start == "function"  # what is carried need not be what is reported
    if what == "matrix" and not own_state and free[0].shows(scheme.history):
        return [lambda c: one_step_residual(c, free)]
    kinds = slice(0, 3 if what == "matrix" else 1)
    starts = ["given"] if free[0].start[2] is not None else ["computed", "zero"]
    return [lambda c, s=s: history_residual(c, free, s)[..., kinds] for s in starts]


def one_step_residual(candidate: Candidate, free: Sequence[Measured]) -> Array:
    """Each step after the first from the stepper's own state before it, so that the start plays no part."""
    h = candidate.at.powers
    found = []
    for measured in free:
        reported = candidate.undriven(measured.rows / h)
        after = np.full_like(measured.rows, np.nan)
        after[:, 2 + candidate.lag :, : reported.shape[2]] = reported
        after[:, : measured.startup + 1] = np.nan
        found.append(measured.deviation(after * h))
    return np.array(found)


def history_residual(candidate: Candidate, free: Sequence[Measured], start: str) -> Array:
    """All steps from t = 0 on."""
    P = len(candidate.at.Omega)
    found = []
    for measured in free:
        u, v, a = measured.start
        given = None if start == "computed" else np.full(P, (a or 0.0) if start == "given" else 0.0)
        h = candidate.at.powers
        if given is not None:
            given = given / h[2]
        rows = candidate.histories(np.array([u, v]) / h[:2], given, measured.rows.shape[1] - 1) * h
        found.append(measured.deviation(rows)[:, 1:])
    return np.array(found)


def recursion_residual(candidate: Candidate, free: Sequence[Measured]) -> Array:
    """How far the histories are off the recursion of the candidate's characteristic polynomial."""
    found = []
    for measured in free:
        terms = recursion_terms(candidate, measured.rows / measured.at.scale[:, None])
        with np.errstate(all="ignore"):
            sizes = np.nan_to_num(np.abs(terms)).max(axis=(0, 3))[..., None]
            off = terms.sum(axis=0) / sizes / measured.at.scale[:, None, 2:]
        found.append(off[:, max(FIRST, measured.startup) :])
    return np.array(found)


def recursion_terms(candidate: Candidate, rows: Array) -> Array:
    """The terms (G+1, P, n+1-G, 3) of the candidate's recursion, which add to 0 in its undriven histories.

    rows: histories (P, n+1, 3). G is the number of entries of the state.
    """
    step = candidate.step
    coefficients = characteristic(step.out[:, :, : step.given])
    order, n = coefficients.shape[1] - 1, rows.shape[1]
    return np.stack([c[:, None, None] * rows[:, order - i : n - i] for i, c in enumerate(coefficients.T)])


def characteristic(matrices: Array) -> Array:
    """Coefficients (P, G+1), from the highest power, of the characteristic polynomials of real matrices (P, G, G)."""
    found = np.ones((len(matrices), 1), np.complex128)
    for root in np.linalg.eigvals(matrices).astype(np.complex128).T:
        longer = np.pad(found, ((0, 0), (0, 1)))
        longer[:, 1:] -= root[:, None] * found
        found = longer
    return found.real


def _start(candidate: Candidate, what: What, own: Sequence[Measured], noise: Noise) -> Start:
    """The acceleration at t = 0 with which the candidate's histories are those that start by themselves."""
    kinds = slice(0, 3 if what == "matrix" else 1)
    starts: tuple[Start, ...] = ("computed", "zero")
    errors = {start: largest(history_residual(candidate, own, start)[..., kinds]) for start in starts}
    best = noise.least(errors)
    return best if errors[best] <= noise.match else "own"
