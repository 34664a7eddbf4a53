"""Supports that move: loads of the free degrees of freedom from the motion of those that are held."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.loads import Load, Record, values_at
from .given import Dof
from .model import Model
from .rayleigh import Rayleigh


def accelerated(s: Model, record: Record, dofs: Iterable[Dof]) -> Model:
    """The structure with these supports moved together by an acceleration of the ground.

    Its motion is that beyond the displacements which the supports would give it if they moved slowly: those are
    `influence` times the displacement of the ground. Chopra, Dynamics of Structures, 9.7 (multiple supports).
    """
    return s.ground_motion(record, influence(s, dofs))


def displaced(s: Model, displacement: Load, velocity: Load | None, dofs: Iterable[Dof]) -> Model:
    """The structure with these supports moved together by a displacement, by the forces of the springs that they hold.

    Its motion is that itself, not relative to anything. velocity: of the supports, for the forces of the dashpots that
    they hold. Raises ValueError where these are there without a velocity, or known only among the free degrees of
    freedom, and for mass that couples with a support. A start that was asked for as static is so with the supports
    where they are at t = 0; their velocity does not count for it.
    """
    moved = _moved(s, dofs)
    if _forces(s, s.full_mass, moved).any():
        raise ValueError(
            "expected supports that no mass couples with, got a mass matrix that does; give acceleration= in place of "
            "displacement=, or a lumped mass"
        )
    held = _forces(s, _stiffness(s), moved)
    loads = [*s.loads, (-held, displacement)]
    if s.C is not None:
        damped = _damping(s, held, moved)
        if damped.any() and velocity is None:
            raise ValueError(
                "expected velocity= with displacement=, since damping acts between the supports and the structure, got "
                "none; give the velocity of the supports too"
            )
        if damped.any() and velocity is not None:
            loads.append((-damped, velocity))
    u0 = s.u0
    if s.static and (put := float(values_at(displacement, np.zeros(1))[0])) != 0.0:
        u0 = u0 - put * s.factorized(s.K, "K, the stiffness matrix, for u0='static'")(held)
    return replace(s, loads=tuple(loads), u0=u0)


def require_still_supports(s: Model) -> None:
    """Raises ValueError where supports move by a displacement, whose load has the forces of the dashpots there are."""
    if len(s.loads) > s.given_loads + len(s.motions):
        raise ValueError(
            "expected the damping before supports move by a displacement, whose load has the forces of dashpots, got "
            "another one after it; give each damping as C of a structure, and then support_motion"
        )


def influence(s: Model, dofs: Iterable[Dof]) -> Array:
    """Static displacements (N,) of all degrees of freedom where these supports are displaced by one.

    Raises ValueError for one that is not held, and for a structure without K or whose K is singular.
    """
    moved = _moved(s, dofs)
    held = _forces(s, _stiffness(s), moved)
    return moved - s.T @ s.factorized(s.K, "K, the stiffness matrix, for moved supports")(held)


def _moved(s: Model, dofs: Iterable[Dof]) -> Array:
    """1 at these degrees of freedom (N,), which are held, 0 at others."""
    free = np.asarray(abs(s.T).sum(axis=1)).ravel() > 0.0
    found = np.zeros(s.T.shape[0])
    for dof in s.kept(dofs):
        place = s.place(dof)
        if free[place]:
            raise ValueError(f"expected supports, degrees of freedom that are fixed, got {dof!r}, which moves; fix it")
        found[place] = 1.0
    if not found.any():
        raise ValueError("expected at least one support that moves, got none; name degrees of freedom that are fixed")
    return found


def _stiffness(s: Model) -> Any:
    if s.internal is not None:
        raise ValueError(
            "expected K for supports that move, got an internal force, which takes the displacement of its supports "
            "itself; move them in it, as a function of t, u and v"
        )
    return s.full_stiffness


def _damping(s: Model, held: Array, moved: Array) -> Array:
    """What the damping makes of a velocity of the supports, whose displacement gives the forces `held` (n,)."""
    if isinstance(s.C, Rayleigh):
        return s.C.beta * held
    if s.full_damping is None:
        raise ValueError(
            "expected damping between supports and structure that is known: none, ss.rayleigh or a matrix, got ratios "
            "of modes; give acceleration= in place of displacement=, or the force as a load"
        )
    return _forces(s, s.full_damping, moved)


def _forces(s: Model, matrix: Any, moved: Array) -> Array:
    """What a matrix (N, N) makes of the supports' motion in the free degrees of freedom (n,)."""
    return np.asarray(s.T.T @ (matrix @ moved))
