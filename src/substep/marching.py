"""March a scene with a scheme."""

import math

import numpy as np

from .errors import real_number
from .response import Response, Status
from .scenes import LinearOscillator
from .schemes import Array, Scheme


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

    kernels = scheme.kernels
    coefficients = scheme.coefficients(scene.omega * dt, scene.xi)
    forces = np.zeros((1, n, 0))
    if scene.load is None:
        coefficients = (coefficients[0], coefficients[1][:, :, :0], coefficients[2], coefficients[3][:, :, :0])
    else:
        times = (np.arange(n)[:, None] + scheme.stencil()) * dt
        forces = dt**2 * np.asarray(scene.load(times), dtype=np.float64)[None]
        if forces.shape[1:] != times.shape or not np.isfinite(forces).all():
            raise ValueError(
                f"expected a finite load at each of {times.shape} times, got shape {forces.shape[1:]}, "
                f"finite: {bool(np.isfinite(forces).all())}; correct the load function"
            )
    out = np.empty((1, n + 1, 3))
    out[0, 0] = [value * dt**i for i, value in enumerate(scene.start)]
    in_state = np.array(kernels.OUTPUTS_IN_STATE)
    x = np.array([[out[0, 0, list(in_state).index(k)] for k in range(len(scheme.state))]])
    n_done, status = np.empty(1, dtype=np.int64), np.empty(1, dtype=np.int64)
    linear_march(*map(np.ascontiguousarray, coefficients), in_state, x, forces, 1, out, n_done, status)
    return out[0], int(n_done[0]), bool(status[0] == COMPLETED)
