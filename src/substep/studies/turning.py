"""What a scheme makes of errors along a stiff bar that turns: see `substep_derive.motion.turning`."""

from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array
from ..core.scenes import Scene
from ..core.schemes import Scheme
from ..derived.modules import turning_step
from ..marching.scene_lanes import TOLERANCE

SLOW = 2  # eigenvalues of the motion across the bar, which tend to 1 with the turn
FRACTIONS = 24  # of a turn at which they are followed from there
LEAST = 1e-200  # of a determinant: a smaller one is that of an explicit scheme on a rigid bar
FARTHEST = 0.75  # rad a step, up to which the motion across the bar is told from errors along it
CLOSE = 1e-6  # a growth beyond 1 that is none: what double eigenvalues are known to


@dataclass(frozen=True)
class StiffBar:
    """A stiff bar that turns: the angular frequencies in rad/s of its axial vibration, omega, and of its turning."""

    omega: float
    rate: float


def bar_of(pendulum: Scene) -> StiffBar:
    """The bar of an elastic pendulum as it turns at the start."""
    EA, L, m, v0 = (float(pendulum.parameters[name]) for name in ("EA", "L", "m", "v0"))
    return StiffBar((EA / (m * L)) ** 0.5, v0 / L)


def growth(s: Scheme, Omega: ArrayLike, tau: ArrayLike) -> Array:
    """The factor by which errors along a bar grow or fade in a step, of all their eigenvalues the largest modulus.

    Omega: h times the axial angular frequency, inf for a rigid bar; tau: the angle in rad by which the bar turns in a
    step, up to `FARTHEST`. They and the scheme's parameters broadcast. The factor is that of steady turning; where the
    motion itself is slowed down by the scheme tau falls. inf: an explicit scheme on a rigid bar. The two eigenvalues
    of the motion across the bar are those that are the nearest to 1 at small turns, followed from there, since others
    may come nearer below `FARTHEST` already. Where one of the two and another have become a complex pair, as for
    rho_inf_bathe from 0.450 on, that pair counts with the errors; `substep_derive.turning_threshold` says up to where
    they are told apart, with proof.

    Raises DeclarationError for a scheme whose forces have no direction of the bar: a discrete gradient, or
    coefficients from the stiffness at the start; ValueError for Omega that is not above 0, and tau that is not finite.

    >>> import substep as ss
    >>> float(growth(ss.scheme("average_acceleration"), np.inf, 0.05).round(4))
    1.0513
    """
    every = np.broadcast_arrays(Omega, tau, *s.parameters.values())
    stiff, turn, *values = (np.asarray(x, dtype=float).ravel() for x in every)
    if not ((stiff > 0.0).all() and np.isfinite(turn).all()):
        raise ValueError(f"expected Omega > 0, inf for a rigid bar, and a finite tau in rad, got {Omega!r} and {tau!r}")
    given = {name: np.repeat(x, FRACTIONS) for name, x in zip(s.parameters, values, strict=True)}
    turns = turn[:, None] * np.arange(1, FRACTIONS + 1) / FRACTIONS
    J = _matrices(_step(s.info.source), np.repeat(stiff, FRACTIONS), turns.ravel(), given)
    J = J.reshape(len(stiff), FRACTIONS, *J.shape[1:])
    found = np.full(len(stiff), np.inf)
    known = np.isfinite(J).all(axis=(1, 2, 3))
    if known.any():
        found[known] = _of_errors(np.linalg.eigvals(J[known]))
    return found.reshape(every[0].shape)


def _of_errors(eigenvalues: Array) -> Array:
    """The largest modulus (P,) at the last turn but for the two of the motion, of eigenvalues (P, FRACTIONS, m)."""
    first = eigenvalues[:, 0]
    motion = np.take_along_axis(first, np.abs(first - 1.0).argsort(axis=1)[:, :SLOW], axis=1)
    m, places = first.shape[1], np.arange(SLOW)
    for k in range(1, eigenvalues.shape[1]):
        away = np.abs(eigenvalues[:, k, :, None] - motion[:, None, :])
        both = away[:, :, None, 0] + away[:, None, :, 1] + np.where(np.eye(m) > 0, np.inf, 0.0)
        places = np.stack(np.unravel_index(both.reshape(len(both), -1).argmin(axis=1), (m, m)), axis=1)
        motion = np.take_along_axis(eigenvalues[:, k], places, axis=1)
    modulus = np.abs(eigenvalues[:, -1])
    np.put_along_axis(modulus, places, 0.0, axis=1)
    return modulus.max(axis=1)


def is_elastic_pendulum(scene: Scene) -> bool:
    """Whether it is that scene of the catalogue, by either strain."""
    return scene.info.declaration is None and scene.name.startswith("elastic_pendulum")


def outgrows(s: Scheme, pendulum: Scene, u: Array, v: Array, h: float, steps: int) -> bool:
    """Whether in that many steps h errors along the bar of an elastic pendulum outgrow the motion.

    They grow from what Newton's iteration leaves to a stretch that stores as much energy as the motion has; what the
    step's own error adds to them makes that sooner. u, v (n, 2): the motion at equal times of the span, from which the
    bar's turning follows. False also where nothing is predicted: the bar turns by more than `FARTHEST` in a step, or
    the scheme is one that `growth` refuses.
    """
    bar, rate = bar_of(pendulum), (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / (u * u).sum(axis=1)
    tau = np.abs(rate) * h
    if tau.max() > FARTHEST:
        return False
    try:
        factors = growth(s, bar.omega * h, tau)
    except ValueError:
        return False
    m, L = pendulum.parameters["m"], pendulum.length
    stretch = np.sqrt((v * v).sum(axis=1).max() * m * L / pendulum.parameters["EA"])  # its energy is m v^2/2
    with np.errstate(divide="ignore"):
        return bool(steps * np.log(factors).mean() > np.log(stretch / (TOLERANCE * L)))


def first_growth(s: Scheme, bar: StiffBar, h: Array) -> float:
    """The first of the ascending steps h, s, with which errors along the bar grow; inf if none."""
    grows = growth(s, bar.omega * h, bar.rate * h) > 1.0 + CLOSE
    return float(h[grows.argmax()]) if grows.any() else float("inf")


@cache
def _step(scheme: Any) -> ModuleType:
    return turning_step(scheme)


def early_energy(s: Scheme, Omega: Array, tau: Array, steps: Array) -> Array:
    """The largest energy (P,) over that at the start in the first of a scheme's steps, predicted by linear equations.

    Omega, tau (P,): as for `growth`, finite; steps (P,): how many. Motion begins on a bar of its own length, without
    force and acceleration along it; steps before the start are those of steady turning, without either. Equations are
    linear about the bar that turns steadily, which holds for about a radian. Seen here is what is no growth of errors:
    that a step stretches the bar at once, since the acceleration at the start is none or the force is taken where the
    bar is shorter than its length, as at a mixture of displacements or at stages. The change of the turning itself,
    which is of second order in these forces, is not. NaN where the scheme only reports u or v.

    Raises DeclarationError as `growth`.
    """
    step = _step(s.info.source)
    if step.ENDS is None:
        return np.full(len(Omega), np.nan)
    values = {name: np.broadcast_to(np.asarray(x, dtype=float), len(Omega)) for name, x in s.parameters.items()}
    (X, constant), (J, added) = _affine(step, Omega, tau, values)
    x = np.zeros((len(Omega), 2 * len(step.AFTER)))
    for k, (kind, instant) in ((k, at) for k, at in enumerate(step.STATE) if at[0] < 2):
        angle = tau * instant + kind * np.pi / 2
        x[:, 2 * k], x[:, 2 * k + 1] = tau**kind * np.cos(angle), tau**kind * np.sin(angle)
    most, cosine, sine = np.full(len(Omega), -np.inf), np.cos(tau), np.sin(tau)
    u, v = (2 * column + np.arange(2) for column in step.ENDS)
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(int(steps.max())):
            now = np.einsum("pij,pj->pi", X, x) + constant
            stretch = cosine * now[:, u[0]] + sine * now[:, u[1]] - 1.0
            energy = ((now[:, v] ** 2).sum(axis=1) + (Omega * stretch) ** 2) / tau**2
            most = np.where(k < steps, np.fmax(most, np.where(np.isfinite(energy), energy, np.inf)), most)
            x = np.einsum("pij,pj->pi", J, x) + added
    return most


def _matrices(step: ModuleType, Omega: Array, tau: Array, values: dict[str, Array]) -> Array:
    """What a step multiplies errors by, (P, m, m), as seen from the bar before and after it; NaN if not determined."""
    return _affine(step, Omega, tau, values)[1][0]


def _affine(
    step: ModuleType, Omega: Array, tau: Array, values: dict[str, Array]
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Matrices (P, i, m) and constants (P, i): the new symbols and forces, and what is kept as seen from the next bar.

    Lengths are over that of the bar, which the constants come from, and times over h. Symbols of the step stand in the
    plane in the directions along and across the bar at t_n, forces in those at their own instants.
    """
    relations, places, instants = _numbers(step, values, len(Omega))
    (new, forces), n = step.OF_NEW, relations.shape[2]
    old = new + forces
    of_force = [*range(new, old), *range(n - (instants.shape[1] - forces), n)]
    angle = np.zeros((len(Omega), n))
    angle[:, of_force] = tau[:, None] * instants
    equations = np.concatenate(
        [_turned(relations, angle[:, None, :]), _turned(places, -angle[:, new:old, None])], axis=1
    )
    length = np.zeros((*equations.shape[:2], 1))
    for k in range(forces):  # along the bar r - 1 = force/Omega^2, across it tau^2 s = force
        along = 2 * (relations.shape[1] + k)
        equations[:, along, 2 * (new + k)] -= 1.0 / Omega**2
        equations[:, along + 1] *= tau[:, None] ** 2
        equations[:, along + 1, 2 * (new + k) + 1] -= 1.0
        length[:, along] = 1.0
    A, B = equations[:, :, : 2 * old], np.concatenate([-equations[:, :, 2 * old :], length], axis=2)
    largest = np.abs(A).max(axis=2, keepdims=True)
    largest = np.where(largest > 0.0, largest, 1.0)
    A, B, X = A / largest, B / largest, np.full(B.shape, np.nan)
    regular = np.abs(np.linalg.det(A)) > LEAST
    X[regular] = np.linalg.solve(A[regular], B[regular])
    kept = len(step.AFTER)
    unit = np.broadcast_to(np.eye(kept), (len(Omega), kept, kept))
    same = np.broadcast_to(np.eye(2 * kept, 2 * kept + 1), (len(Omega), 2 * kept, 2 * kept + 1))
    back = np.array([0.0 if column in of_force else -1.0 for column in step.AFTER])
    places_kept = [2 * column + i for column in step.AFTER for i in (0, 1)]
    J = _turned(unit, tau[:, None, None] * back) @ np.concatenate([X, same], axis=1)[:, places_kept]
    return (X[:, :, :-1], X[:, :, -1]), (J[:, :, :-1], J[:, :, -1])


def _turned(numbers: Array, angle: Array) -> Array:
    """Numbers (P, i, j) times turnings by angles that broadcast, as (P, 2 i, 2 j)."""
    P, i, j = numbers.shape
    cosine, sine = numbers * np.cos(angle), numbers * np.sin(angle)
    return np.stack([np.stack([cosine, -sine], -1), np.stack([sine, cosine], -1)], 2).reshape(P, 2 * i, 2 * j)


def _numbers(step: ModuleType, values: dict[str, Array], P: int) -> tuple[Array, Array, Array]:
    """Relations, places and instants with the parameters' values, with an axis (P,) in front."""
    entries = step.numbers(*(values[name] for name in step.PARAMETERS))
    flat = np.stack([np.broadcast_to(np.asarray(x, dtype=float), P) for x in entries], axis=1)
    ends = np.array([step.ROWS, step.ROWS + step.OF_NEW[1]]) * step.COLUMNS
    relations, places, instants = np.split(flat, ends, axis=1)
    return relations.reshape(P, -1, step.COLUMNS), places.reshape(P, -1, step.COLUMNS), instants
