"""What there is to say of a run that has gained energy which nothing gave it."""

import math

import numpy as np

from ..core.arrays import Array
from ..core.coefficients import coefficients
from ..core.fighting import pressed_harder
from ..core.powers import unaccounted
from ..core.response import Response
from ..core.schemes import Scheme

TIMES = 10.0  # the energy at the start, beyond which the one at the end is looked into
SHORT = 0.05  # omega*dt of the shortest step that is looked at for a stable one
TRIED = 400
BESIDE = 0.7  # of the scene's length: how far from the start it is looked at whether energy is conserved
UNSTABLE = 1.0 + 1e-11  # below which a radius is rounding, where eigenvalues are apart as at SHORT


def gained(r: Response, dt: float | None) -> str:
    """That the scheme has gained energy in a run of a scene which is completed, and the cure; else nothing.

    Of a linear oscillator in constant steps, whatever drives it, it is said where the motion at the end holds about ten
    times the energy of the start or more, and the scheme's spectral radius, over these steps, makes so much of any. Of
    other scenes it is said where nothing drives them, and nothing but friction damps them, so that their energy does
    not grow, and it has grown to more than ten times that at the start, by more than half of the largest kinetic
    energy: so that an energy which cancels at the start does not count. Friction that presses contacts harder than
    sliding relieves them, where it has grown most, is named.
    """
    if r.growth <= TIMES or r.status != "completed" or len(r.u) < 2 or r.scene.info.unstrained:
        return ""  # laws with a memory keep an account of their own
    if r.scene.info.oscillator and dt is not None:
        return _unstable(r, dt)
    ends = [0, -1]
    first, last = r.scene.energy(r.t[ends], r.u[ends], r.v[ends])
    if not (last > TIMES * abs(first) and _conservative(r)):
        return ""
    scale = abs(r.scene.E0)
    kinetic = float(np.nanmax(r.energy - r.scene.energy(r.t, r.u, np.zeros_like(r.v))))
    if not (last > TIMES * scale and last - first > 0.5 * kinetic):
        return ""
    unexplained = -unaccounted(r)[-1] if {*r.powers} - {"friction"} else last - first
    if not unexplained > 0.5 * (last - first):  # forces, and what moves, have given it
        return ""
    kept = "whose friction only takes it" if r.scene.info.frictions else "which conserves it"
    why = pressing(r, r.energy) or f"{'take a smaller step' if dt else 'take a smaller tol'}, or another scheme"
    return (
        f"{r.scheme.name} has gained energy on {r.scene.name}, {kept}: {last:.3g} J at t = {r.t[-1]:.6g} "
        f"from {first:.3g} J; {why}"
    )


def pressing(r: Response, energy: Array) -> str:
    """Which friction presses which contact harder than sliding relieves it, in the step in which energy has grown most.

    energy (n+1,), J: of the rows. Nothing where none does.
    """
    k = int(np.nanargmax(np.diff(energy)))
    acting = r.acting(k, float(r.t[k + 1]))
    found = "" if acting is None else pressed_harder(acting)
    return found and f"in the step to t = {r.t[k + 1]:.6g} s, {found}"


def _unstable(r: Response, dt: float) -> str:
    """That the step is unstable on a linear oscillator, if its growth explains the energy at the end."""
    assert r.scene.info.oscillator is not None
    omega: float
    xi: float
    omega, xi, _ = r.scene.info.oscillator(*r.scene.parameters.values())
    first = max(abs(omega * r.u.item(0)), abs(r.v.item(0)))
    last = max(abs(omega * r.u.item(-1)), abs(r.v.item(-1)))
    if not last > math.sqrt(TIMES) * first or xi < 0.0 or r.scheme.A_stable:  # xi < 0: of a motion that grows by itself
        return ""
    Omega, steps = omega * dt, (r.t[-1] - r.t[0]) / dt
    radius = _radii(r.scheme, np.array([Omega]), xi)[0]
    if not 2.0 * steps * math.log(max(radius, 1.0)) > math.log(TIMES):
        return ""
    said = f"{r.scheme.name} is unstable at omega*dt = {Omega:.6g}, xi = {xi:.6g}: its spectral radius is {radius:.6g}"
    shorter = np.geomspace(min(SHORT, Omega), Omega, TRIED)
    stable = _radii(r.scheme, shorter, xi) <= UNSTABLE
    exact = r.scheme.critical_Omega if xi == 0.0 else None
    if exact == 0.0 or not stable[0]:
        return f"{said}, and above 1 at shorter steps too; take another scheme, or other parameters"
    limit = exact if exact and exact < Omega else float(shorter[np.argmin(stable) - 1])
    return f"{said}; it is stable up to omega*dt = {limit:.4g}: take dt up to {limit / omega:.4g} s, or another scheme"


def _radii(scheme: Scheme, Omega: Array, xi: float) -> Array:
    """The spectral radius of a step at each Omega (n,), from the coefficients that a march has at hand."""
    D = coefficients(scheme, Omega, xi)[0]
    return abs(np.linalg.eigvals(D + np.eye(D.shape[1]))).max(axis=1)


def _conservative(r: Response) -> bool:
    """Whether nothing drives the scene, and nothing but friction takes energy from it.

    That is as far as a state beside the start tells at all times: a declared load, or a prescribed motion, shows in the
    acceleration or in the energy there, a stop that moves in its gap, a belt in the rate at which what rests slides.
    """
    scene, frictions = r.scene, len(r.scene.info.frictions)
    rubbed = frictions and not hasattr(scene.module, "POWERS")  # by friction alone
    if scene.load is not None or (scene.info.damped and not (scene.info.oscillator or scene.info.conserves or rubbed)):
        return False
    u, v = (np.tile(x + BESIDE * scene.length, (len(r.t), 1)) for x in (scene.u0, scene.v0))
    memory = np.zeros((len(r.t), len(scene.info.memory)))
    found = [scene.energy(r.t, u, v), *scene.acceleration(r.t, u, v, memory).T]
    if scene.info.contacts:
        found += [*scene.gaps(r.t, u).T]
    if frictions and scene.drift(r.t, u, np.zeros_like(u))[1][:, -frictions:].any():
        return False
    return all(bool((x == x[0]).all()) for x in found)
