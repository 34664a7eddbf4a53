"""All schemes of the catalogue that do the same as an identified one, whatever parameters have to be solved for."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from substep.core.schemes import Scheme, schemes
from substep.core.schemes import scheme as make_scheme

from .fit import free_parameters, recognise, solutions
from .identify import Identification, Match, credible, fitted, residuals
from .linear_step import with_parameters
from .noise import QUIET, Noise
from .probes import Measured

FEW = (0.3, 3.0)  # Omega of the oscillators on which a scheme is solved for, before it is compared on all
PLAIN = (0.0, 1.0)  # values of parameters that one scheme has and the other has not, which are tried first
NEXT = 1e-6  # nearer to a simple number, a parameter may be that one but for rounding
TRIES = 2  # starts from which they are solved for then


def with_all_members(
    found: Identification, free: Sequence[Measured], own: Sequence[Measured], noise: Noise = QUIET
) -> Identification:
    """The same with every other scheme that does what was measured among its matches.

    free, own: the runs that it was found from; noise: of these. Where that is more than rounding, the others have to do
    what the first match does without it, and those that agree within the noise alone are doubtful. None are looked for
    where only eigenvalues or a recursion agree, for many schemes share these, and where damping is of a dialect.
    Parameters outside their intervals are not named: at their ends a scheme may have no step.
    """
    if not found.matches:
        return found
    best, *others = found.matches
    many = best.what in ("recursion", "spectrum") or best.damping != "declared"
    if not noise.loud:
        known = {match.scheme.name for match in found.matches}
        return found if many else replace(found, matches=(*found.matches, *_others(best, known, free, own, noise)))
    equal: list[Match] = []
    if not many:
        clean = [[_without_noise(best, run) for run in runs] for runs in (free, own)]
        equal = [
            replace(match, error=best.error, start=best.start, unsure=best.unsure)
            for match in _others(best, {best.scheme.name}, *clean, QUIET)
        ]
    names = {match.scheme.name for match in equal}
    doubtful = (replace(match, doubtful=True) for match in others if match.scheme.name not in names)
    return replace(found, matches=(best, *equal, *doubtful))


def _others(
    best: Match, known: Collection[str], free: Sequence[Measured], own: Sequence[Measured], noise: Noise
) -> list[Match]:
    """The schemes of other names than those known that do the same as the best match."""
    damping, more = bool(free[0].at.xi.any()), []
    for scheme in map(make_scheme, schemes()):
        if scheme.name not in known and not scheme.info.together and (scheme.info.damping or not damping):
            solved = len(free_parameters(scheme))
            matches = (
                replace(fitted(at, (), best.what, free, own, noise), solved=solved, unsure=unsure)
                for at, unsure in _near(scheme, best, free, noise)
            )
            first = next((match for match in matches if credible(match, noise) and _allowed(match.scheme)), None)
            more += [] if first is None else [first]
    return sorted(more, key=lambda match: match.solved)


def _without_noise(match: Match, run: Measured) -> Measured:
    """A free run as the scheme makes it, of what the program returns."""
    at, (u, v, a) = run.at, run.start
    given = 0.0 if a is None and match.start == "zero" else a
    a0 = None if given is None else np.full(len(at.Omega), given / at.powers[2])
    rows = match.candidate(at).histories(np.array([u, v]) / at.powers[:2], a0, run.rows.shape[1] - 1) * at.powers
    return replace(run, rows=np.where(np.isnan(run.rows), np.nan, rows), absolute=False)


def _near(scheme: Scheme, best: Match, free: Sequence[Measured], noise: Noise) -> Iterator[tuple[Scheme, float]]:
    """The scheme at values at which it may do the same as the best match: plain ones, and those solved for.

    Beside it, by how much the noise may have moved these.
    """
    names, few = free_parameters(scheme), [run.only(FEW) for run in free]
    shared = {name: float(x) for name, x in best.scheme.parameters.items() if name in names}
    for plain in PLAIN:
        yield with_parameters(scheme, dict.fromkeys(names, plain) | shared), best.unsure
    for residual in residuals(scheme, best.what, few):
        for solution in islice(solutions(scheme, names, few[0].at, residual, noise.worth), TRIES):
            if solution.error <= noise.match:
                yield solution.scheme, solution.unsure


def _allowed(scheme: Scheme) -> bool:
    """Whether the parameters lie in their intervals, not next to an end that is none of these, and fit each other."""
    values = {name: recognise(float(scheme.parameters[name]), NEXT)[0] for name in free_parameters(scheme)}
    try:
        made = make_scheme(scheme.name, **values)
    except ValueError:
        return False
    return all(abs(float(made.parameters[name]) - float(x)) <= NEXT for name, x in scheme.parameters.items())
