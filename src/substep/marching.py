"""March a scene with a scheme."""

import math
from typing import Any

import numpy as np

from .errors import real_number
from .lanes import STATUSES, march_lanes
from .response import Response, Status
from .scenes import Scene
from .schemes import Array, Scheme
from .schemes import scheme as make_scheme


def number_of_steps(dt: float, t_end: float) -> int:
    """t_end/dt, a whole number up to 1e-9, else a ValueError naming the two nearest spans."""
    ratio = t_end / dt
    n = round(ratio)
    if abs(ratio - n) > 1e-9 * max(1.0, ratio) or n == 0:
        low = math.floor(ratio)
        around = [f"{k * dt:.12g}" for k in (low, low + 1) if k > 0]
        raise ValueError(
            f"expected t_end to be a multiple of dt = {dt:.12g}, got {t_end:.12g}; "
            f"the nearest {'is' if len(around) == 1 else 'are'} {' and '.join(around)}"
        )
    return n


def march(
    scene: Scene, scheme: Scheme, dt: float, t_end: float, *, energy_bound: float | None = None, stride: int = 1
) -> Response:
    """The response of the scene from t = 0 to t_end in steps of dt (s).

    energy_bound: stop before the first state whose energy exceeds it, in J. stride: keep every stride-th
    step. The load is sampled at the scheme's own instants t_n + tau*dt. Raises ValueError for dt <= 0, for
    t_end that is not a multiple of dt, for a scheme whose parameters are arrays and for a load that is not
    finite. A run that fails does not raise: see Response.status.
    """
    dt = real_number("dt", dt, positive=True)
    n = number_of_steps(dt, real_number("t_end", t_end, positive=True))
    if arrays := [name for name, value in scheme.parameters.items() if value.ndim]:
        raise ValueError(f"expected one value for {arrays[0]} of {scheme.name}, got an array; march once for each")
    if stride < 1:
        raise ValueError(f"expected stride >= 1, got {stride}")
    bound = math.inf if energy_bound is None else real_number("energy_bound", energy_bound)
    if scene.entry["oscillator"]:
        return _oscillator_response(scene, scheme, dt, n, bound, stride)
    lanes = march_lanes(scene, scheme, np.array([dt]), np.array([n]), bound=bound, stride=stride, history=True)
    n_done = int(lanes.n_done[0])
    rows = lanes.out[0, : n_done // stride + 1]
    iterations = lanes.iterations[0, :n_done]
    return _response(scene, dt, stride, rows, n_done, STATUSES[lanes.status[0]], iterations)


def _response(
    scene: Scene, dt: float, stride: int, rows: Array, n_done: int, status: Status, iterations: Any
) -> Response:
    """From rows (steps, u v a, d); without a, from the equation of motion."""
    t = np.arange(len(rows)) * stride * dt
    u, v = rows[:, 0], rows[:, 1]
    a = rows[:, 2] if rows.shape[1] > 2 else np.concatenate([scene.a0[None], scene.acceleration(t, u, v)[1:]])
    return Response(
        t=t,
        u=u,
        v=v,
        a=a,
        energy=scene.energy(t, u, v),
        angular_momentum=scene.angular_momentum(t, u, v),
        newton_iterations=iterations,
        status=status,
        t_failed=None if status == "completed" else (n_done + 1) * dt,
        outputs=scene.outputs(t, u, v),
    )


def _oscillator_response(scene: Scene, scheme: Scheme, dt: float, n: int, bound: float, stride: int) -> Response:
    """The linear march, which does not depend on the scheme's formulas but on its coefficients."""
    history, n_done, finite = _linear_history(scene, scheme, dt, n)
    rows = (history[: n_done + 1] / dt ** np.arange(3))[..., None]
    status: Status = "completed" if finite else "non_finite"
    beyond = scene.energy(np.arange(n_done + 1) * dt, rows[:, 0], rows[:, 1]) > bound
    if beyond.any():
        status, n_done = "energy_bound", max(int(np.argmax(beyond)) - 1, 0)
    iterations = np.zeros((n_done, scheme.balances), dtype=np.int64)
    return _response(scene, dt, stride, rows[: n_done + 1 : stride], n_done, status, iterations)


def _linear_history(scene: Scene, scheme: Scheme, dt: float, n: int) -> tuple[Array, int, bool]:
    """(n + 1, 3) history of (u, h*v, h^2*a), steps completed, whether all are finite."""
    from substep_kernels.linear_march import COMPLETED, linear_march  # noqa: PLC0415 (numba on first use)

    omega, xi, mass = scene.entry["oscillator"](**scene.parameters)
    Omega = omega * dt
    out = np.empty((n + 1, 3))
    out[0] = [scene.u0[0], scene.v0[0] * dt, scene.a0[0] * dt**2]

    def forces(steps: Array) -> Array:
        return dt**2 / mass * scene.forces(steps * dt)

    first = 0  # steps marched by another scheme
    if scheme.start == "given":
        x = out[0, [kind for kind, _ in scheme.history]]
    elif scheme.start == "start":
        given, load = (part[0] for part in scheme.start_coefficients(Omega, xi))
        x = given @ out[0] + load @ forces(np.array(scheme.kernels.START_STENCIL))
    else:
        first = min(max(lag for _, lag in scheme.history), n)
        head, n_done, finite = _linear_history(scene, make_scheme(scheme.start), dt, first)
        out[: first + 1] = head
        if first == n or not finite:
            return out, n_done, finite
        x = np.array([out[first - lag, kind] for kind, lag in scheme.history])
    increment, load, outputs, outputs_load = scheme.coefficients(Omega, xi)
    at_stencil = np.zeros((n - first, 0))
    if scene.load is None:
        load, outputs_load = load[:, :, :0], outputs_load[:, :, :0]
    else:
        at_stencil = forces(np.arange(first, n)[:, None] + scheme.stencil())
    rows, lane_done, status = np.empty((1, n - first + 1, 3)), np.empty(1, dtype=np.int64), np.empty(1, dtype=np.int64)
    rows[0, 0] = out[first]
    matrices = [np.ascontiguousarray(matrix) for matrix in (increment, load, outputs, outputs_load)]
    places = np.array(scheme.kernels.OUTPUTS_IN_STATE)
    linear_march(*matrices, places, x[None].copy(), at_stencil[None], 1, rows, lane_done, status)
    out[first:] = rows[0]
    return out, first + int(lane_done[0]), bool(status[0] == COMPLETED)
