"""General ODE solvers on the scenes of the charts: SciPy's, and compiled ones of numbalsoda, where installed."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np
from numba import cfunc, njit

from ...core.schemes import Array
from .measure import LONG, Cost, Run, against, failed, timed
from .reference import Reference

SCIPY = ("RK45", "DOP853", "Radau", "LSODA")
COMPILED = ("dop853", "lsoda")  # numbalsoda
TOLERANCES = tuple(10.0**-k for k in range(2, 13))


@njit
def _oscillator(t: float, y: Array, p: Array) -> tuple[float, ...]:
    return y[1], -2.0 * p[1] * p[0] * y[1] - p[0] * p[0] * y[0]


@njit
def _elastic(t: float, y: Array, p: Array) -> tuple[float, ...]:
    force = p[0] / (2.0 * p[1] ** 3 * p[2]) * (y[0] * y[0] + y[1] * y[1] - p[1] * p[1])
    return y[2], y[3], -force * y[0], -force * y[1]


@njit
def _duffing(t: float, y: Array, p: Array) -> tuple[float, ...]:
    return y[1], -p[0] * y[0] * (1.0 + p[1] * y[0] * y[0])


@njit
def _softening(t: float, y: Array, p: Array) -> tuple[float, ...]:
    return y[1], -p[0] * np.tanh(y[0])


@njit
def _swing(t: float, y: Array, p: Array) -> tuple[float, ...]:
    return y[1], -p[0] * np.sin(y[0])


@njit
def _bounce(t: float, y: Array, p: Array) -> tuple[float, ...]:
    return y[1], -p[0] * min(y[0], 0.0)


@njit
def _chain(t: float, y: Array, p: Array) -> tuple[float, ...]:
    soft = p[1] * (y[1] - y[0])
    return y[2], y[3], p[0] * (np.sin(p[2] * t) - y[0]) + soft, -soft


@njit
def _engineering(t: float, y: Array, p: Array) -> tuple[float, ...]:
    length = np.sqrt(y[0] * y[0] + y[1] * y[1])
    force = p[0] * (length - p[1]) / (p[1] * p[2] * length)
    return y[2], y[3], -force * y[0], -force * y[1]


# right-hand sides as a user of such a solver writes them; p: the scene's parameters in their order
_SLOPES: dict[str, Callable[..., tuple[float, ...]]] = {
    "linear_oscillator": _oscillator,
    "elastic_pendulum": _elastic,
    "duffing": _duffing,
    "softening": _softening,
    "simple_pendulum": _swing,
    "penalty_bounce": _bounce,
    "bathe_noh": _chain,
    "elastic_pendulum_engineering": _engineering,
}


@dataclass(frozen=True)
class Peer:
    """A solver on one scene: solve(rtol) -> (states (samples + 1, 2d), evaluations of the right-hand side)."""

    name: str
    solve: Callable[[float], tuple[Array, int]]


def peers(exact: Reference, wanted: tuple[str, ...] | None = None) -> tuple[list[Peer], dict[str, str]]:
    """The wanted solvers (None: all) that are installed, and the ImportError's message for each missing package.

    Any other error is a mistake here, or a broken installation, and is raised. None for a scene with constraints, which
    is no ordinary differential equation.
    """
    if exact.scene.info.multipliers:
        return [], {}
    slope = _SLOPES[exact.scene.name]
    p = np.array(list(exact.scene.parameters.values()))
    start = np.concatenate([exact.scene.u0, exact.scene.v0])
    scale = float(np.abs(start).max() or np.abs(exact.u).max())  # of absolute tolerances, also of a start from rest
    slope(0.0, start, p)  # compiles
    found: list[Peer] = []
    missing: dict[str, str] = {}
    for package, kinds, make in (("scipy", SCIPY, _scipy), ("numbalsoda", COMPILED, _compiled)):
        names = [kind for kind in kinds if wanted is None or f"{package} {kind}" in wanted]
        try:
            made = make(exact.t, slope, p, start, scale) if names else None
        except ImportError as error:
            missing[package] = f"{type(error).__name__}: {str(error)[:120]}"
            continue
        found += [Peer(f"{package} {kind}", made(kind)) for kind in names if made]
    return found, missing


def _scipy(
    t: Array, slope: Any, p: Array, start: Array, scale: float
) -> Callable[[str], Callable[[float], tuple[Array, int]]]:
    integrate = import_module("scipy.integrate")

    def rates(t: float, y: Array) -> tuple[float, ...]:
        return slope(t, y, p)

    def of(method: str) -> Callable[[float], tuple[Array, int]]:
        def solve(rtol: float) -> tuple[Array, int]:
            r = integrate.solve_ivp(
                rates, (0.0, t[-1]), start, method=method, t_eval=t, rtol=rtol, atol=rtol * scale * 1e-2
            )
            return (r.y.T, int(r.nfev)) if r.success else (np.full((len(t), len(start)), np.nan), int(r.nfev))

        return solve

    return of


def _compiled(
    t: Array, slope: Any, p: Array, start: Array, scale: float
) -> Callable[[str], Callable[[float], tuple[Array, int]]]:
    package = import_module("numbalsoda")
    size, counter = len(start), len(p)

    @cfunc(package.lsoda_sig)
    def rates(t: float, y: Any, dy: Any, data: Any) -> None:
        found = slope(t, y, data)
        for i in range(size):
            dy[i] = found[i]
        data[counter] += 1.0

    def of(method: str) -> Callable[[float], tuple[Array, int]]:
        def solve(rtol: float) -> tuple[Array, int]:
            data = np.append(p, 0.0)
            states, good = getattr(package, method)(
                rates.address, start, t, data, rtol=rtol, atol=rtol * scale * 1e-2, mxstep=10**8
            )  # fmt: skip
            return (states if good else np.full((len(t), size), np.nan)), int(data[counter])

        return solve

    return of


def runs(exact: Reference, peer: Peer, *, every: int, repeats: int) -> Iterator[Run]:
    """Runs of the peer at tolerances from 1e-2 on, each finer by 10^every, until a run takes LONG."""
    scene, d = exact.scene, exact.u.shape[1]
    for rtol in TOLERANCES[::every]:
        (states, evaluations), seconds = timed(partial(peer.solve, rtol), repeats)
        good, u, v = bool(np.isfinite(states).all()), states[:, :d], states[:, d:]
        errors = against(exact, scene, u, v, scene.acceleration(exact.t, u, v)) if good else failed(exact, scene)
        cost, status = Cost(0, evaluations, 0), "completed" if good else "non_finite"
        yield Run(peer.name, np.nan, 0, status, cost, seconds, errors, rtol)
        if seconds > LONG:
            return
