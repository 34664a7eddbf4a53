"""March a scene with a scheme."""

import math

import numpy as np

from .errors import real_number
from .response import Response, Status
from .scenes import LinearOscillator
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
    scene: LinearOscillator, scheme: Scheme, dt: float, t_end: float, *, energy_bound: float | None = None
) -> Response:
    """The response of the scene from t = 0 to t_end in steps of dt (s).

    energy_bound: stop before the first state whose energy exceeds it. The load is sampled at the
    scheme's own instants t_n + tau*dt. Raises ValueError for dt <= 0, for t_end that is not a
    multiple of dt, for a scheme whose parameters are arrays and for a load that is not finite.
    A run that leaves the finite numbers does not raise: see Response.status.
    """
    dt = real_number("dt", dt, positive=True)
    n = number_of_steps(dt, real_number("t_end", t_end, positive=True))
    if arrays := [name for name, value in scheme.parameters.items() if value.ndim]:
        raise ValueError(f"expected one value for {arrays[0]} of {scheme.name}, got an array; march once for each")
    history, n_done, finite = _linear_history(scene, scheme, dt, n)
    u, v, a = (history[: n_done + 1, i] / dt**i for i in range(3))
    energy = scene.energy(u, v)
    status: Status = "completed" if finite else "non_finite"
    if energy_bound is not None and (beyond := energy > real_number("energy_bound", energy_bound)).any():
        status, n_done = "energy_bound", max(int(np.argmax(beyond)) - 1, 0)
    kept = slice(0, n_done + 1)
    return Response(
        t=np.arange(n_done + 1) * dt,
        u=u[kept, None],
        v=v[kept, None],
        a=a[kept, None],
        energy=energy[kept],
        angular_momentum=None,
        newton_iterations=np.zeros((n_done, scheme.balances), dtype=np.int64),
        status=status,
        t_failed=None if status == "completed" else (n_done + 1) * dt,
    )


def _linear_history(scene: LinearOscillator, scheme: Scheme, dt: float, n: int) -> tuple[Array, int, bool]:
    """(n + 1, 3) history of (u, h*v, h^2*a), steps completed, whether all are finite."""
    from substep_kernels.linear_march import COMPLETED, linear_march  # noqa: PLC0415 (numba on first use)

    Omega = scene.omega * dt
    out = np.empty((n + 1, 3))
    out[0] = [value * dt**i for i, value in enumerate(scene.start)]
    first = 0  # steps marched by another scheme
    if scheme.start == "given":
        x = out[0, [kind for kind, _ in scheme.history]]
    elif scheme.start == "start":
        given, load = (part[0] for part in scheme.start_coefficients(Omega, scene.xi))
        x = given @ out[0] + load @ _forces(scene, np.array(scheme.kernels.START_STENCIL), dt)
    else:
        first = min(max(lag for _, lag in scheme.history), n)
        head, n_done, finite = _linear_history(scene, make_scheme(scheme.start), dt, first)
        out[: first + 1] = head
        if first == n or not finite:
            return out, n_done, finite
        x = np.array([out[first - lag, kind] for kind, lag in scheme.history])
    increment, load, outputs, outputs_load = scheme.coefficients(Omega, scene.xi)
    forces = np.zeros((n - first, 0))
    if scene.load is None:
        load, outputs_load = load[:, :, :0], outputs_load[:, :, :0]
    else:
        forces = _forces(scene, np.arange(first, n)[:, None] + scheme.stencil(), dt)
    rows, lane_done, status = np.empty((1, n - first + 1, 3)), np.empty(1, dtype=np.int64), np.empty(1, dtype=np.int64)
    rows[0, 0] = out[first]
    matrices = [np.ascontiguousarray(matrix) for matrix in (increment, load, outputs, outputs_load)]
    places = np.array(scheme.kernels.OUTPUTS_IN_STATE)
    linear_march(*matrices, places, x[None].copy(), forces[None], 1, rows, lane_done, status)
    out[first:] = rows[0]
    return out, first + int(lane_done[0]), bool(status[0] == COMPLETED)


def _forces(scene: LinearOscillator, steps: Array, dt: float) -> Array:
    """h^2 f at the instants steps*dt. Raises ValueError for a load that is not finite or changes shape."""
    if scene.load is None:
        return np.zeros(steps.shape)
    forces = dt**2 * np.asarray(scene.load(steps * dt), dtype=np.float64)
    if forces.shape != steps.shape or not np.isfinite(forces).all():
        raise ValueError(
            f"expected a finite load at each of {steps.shape} times, got shape {forces.shape}, "
            f"finite: {bool(np.isfinite(forces).all())}; correct the load function"
        )
    return forces
