"""Stability functions of a scheme: amplification matrix, spectral radius, numerical damping, period elongation.

All take Omega = omega*h >= 0 and the damping ratio xi >= 0, which broadcast with each other and with the scheme's
parameters, and raise ValueError for negative or infinite values, NaN, shapes that do not broadcast, and values so
large that the powers of Omega in a step overflow, or that rounding hides the pair that damping and period are of. At
Omega below 1e-150 the errors are their limits, 0. Of a scheme that takes no damping they are NaN at xi > 0.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, common_shape, flat
from .eigenvalues import stability_at_points
from .errors import float_array, non_negative, whole
from .formulas import evaluated
from .norms import largest_norm_of_powers
from .radii_on_device import is_there
from .radii_on_device import spectral_radius as radii_on_device
from .scheme_record import SchemeRecord
from .threads import spread

HIDDEN_FROM = 1e8  # Omega; two eigenvalues part by about 1/Omega where they have one limit, and below they part clearly
LARGE_DAMPING = 1e5  # of two positive eigenvalues that part so little, damping is of this size or above, or NaN
LOST = 1e-14  # eigenvalues below this size are those of rounding, since entries of the matrix are sums of larger terms
AS_ONE = 8.0 * float(np.finfo(float).eps) ** 0.25  # relative distance to which rounding parts a fourfold eigenvalue
MATRICES = 1 << 11  # amplification matrices that are computed at a time, in the second cache
NANOSECONDS = {"spectral_radius": 0.6, "stability": 4.0, "amplification": 20.0}  # per point, of the fastest schemes


def points(scheme: SchemeRecord, Omega: ArrayLike, xi: ArrayLike) -> tuple[tuple[int, ...], list[Array]]:
    """The common shape, and Omega, xi and the parameters of the module at each of its points, as kernels take them."""
    arrays = [non_negative("Omega", Omega), non_negative("xi", xi), *scheme.kernel_parameters]
    shape = common_shape(("Omega", "xi", *scheme.kernels.PARAMETERS), arrays)
    return shape, [flat(array, shape) for array in arrays]


def amplification(scheme: SchemeRecord, Omega: ArrayLike, xi: ArrayLike) -> Array:
    """Amplification matrix (..., m, m) of the free oscillator, in the order of the scheme's state."""
    m = len(scheme.info.state)
    shape, arguments = points(scheme, Omega, xi)
    out = _amplification(scheme, arguments)
    if not np.isfinite(out).all():
        _require_finite(scheme, "amplification matrix", abs(out).max(axis=(1, 2)), *arguments[:2])
    if not scheme.info.damping:
        out[arguments[1] != 0.0] = np.nan
    return out.reshape(*shape, m, m)


def _amplification(scheme: SchemeRecord, arguments: Sequence[Array]) -> Array:
    """The matrices (n, m, m) at Omega, xi and parameters (n,) each."""
    n, m = arguments[0].size, len(scheme.info.state)
    out = np.empty((n, m * m))

    def part(begin: int, end: int) -> None:
        for first in range(begin, end, MATRICES):
            last = min(first + MATRICES, end)
            some = [a[first:last] for a in arguments]
            out[first:last] = evaluated(scheme.kernels.amplification, last - first, some).T

    spread(part, n, MATRICES, nanoseconds=n * NANOSECONDS["amplification"])
    return out.reshape(n, m, m)


def spectral_radius(scheme: SchemeRecord, Omega: ArrayLike, xi: ArrayLike, out: Any = None) -> Array:
    """Largest modulus of the eigenvalues of the amplification matrix; of arrays on a GPU, an array there.

    See `core.radii_on_device` for the latter, and for out. Raises ValueError for out of arrays on the CPU.
    """
    if is_there(Omega) or is_there(xi):
        return radii_on_device(scheme, Omega, xi, out)
    if out is not None:
        raise ValueError("expected out with Omega or xi on a GPU only, got both on the CPU; take what is returned")
    return _evaluated(scheme, "spectral_radius", 1, Omega, xi)[0][0]


def radius_damping_period(scheme: SchemeRecord, Omega: ArrayLike, xi: ArrayLike) -> tuple[Array, Array, Array]:
    """Spectral radius, numerical damping and period error, in one pass."""
    (radius, damping, period), beyond = _evaluated(scheme, "stability", 3, Omega, xi)
    if beyond:
        _require_told_apart(scheme, radius, damping, period, Omega, xi)
    return radius, damping, period


def amplitude_error(numerical_damping: Array) -> Array:
    """1 - exp(-2 pi numerical_damping); -inf for a response that grows beyond the largest number."""
    with np.errstate(over="ignore"):
        return 0.0 - np.expm1(-2.0 * np.pi * numerical_damping)


def power_norm(scheme: SchemeRecord, Omega: ArrayLike, xi: ArrayLike, n: Any) -> Array:
    """The largest of ||A||, ||A^2||, ..., ||A^n|| in the energy norm of (omega*u, v, a/omega); inf on overflow.

    Raises ValueError for an n that is no whole number from 1 on, and for Omega = 0.
    """
    powers = whole("n", n, 1, "powers", "give how many powers of A are looked at")
    omega = non_negative("Omega", Omega)
    if (omega == 0).any():
        raise ValueError("expected Omega > 0, got 0, where the energy does not depend on u; give a positive Omega")
    A = _in_energy_norm(scheme, amplification(scheme, omega, xi), omega)
    largest = largest_norm_of_powers(A.reshape(-1, *A.shape[-2:]), powers)
    return largest.reshape(A.shape[:-2])[()]


def _evaluated(
    scheme: SchemeRecord, function: str, outputs: int, Omega: ArrayLike, xi: ArrayLike
) -> tuple[list[Array], bool]:
    """The spectral radius, and if there are three outputs the errors, at all points, each of the common shape.

    Also whether a damping is NaN, or one or a period error as large as LARGE_DAMPING.

    The kernels return whether a value of Omega or xi is bad or a radius is not finite, so that these are searched only
    for the error message.
    """
    given = float_array("Omega", Omega), float_array("xi", xi)
    arguments = (*given, *scheme.kernel_parameters)
    shape = common_shape(("Omega", "xi", *scheme.kernels.PARAMETERS), arguments)
    n = math.prod(shape)
    out = np.empty((outputs, n))
    flats = [a.reshape(1) if a.size == 1 else flat(a, shape) for a in arguments]
    refused, beyond = stability_at_points(scheme.kernels, flats, LARGE_DAMPING, out, NANOSECONDS[function])
    if n == 0 or refused:
        for name, value in (("Omega", Omega), ("xi", xi)):
            non_negative(name, value)
        _require_finite(scheme, "spectral radius", out[0], *(flat(x, shape) for x in given))
    if not scheme.info.damping:
        out[:, flat(given[1], shape) != 0.0] = np.nan
    return list(out.reshape(outputs, *shape)), beyond  # of arrays, or of numbers


def _require_finite(scheme: SchemeRecord, what: str, found: Array, Omega: Array, xi: Array) -> None:
    """Raise ValueError for the first of the points (n,) at which what was found is NaN or infinite."""
    for i in np.flatnonzero(~np.isfinite(found))[:1]:
        raise ValueError(
            f"expected Omega and xi at which a step of {scheme.info.name} can be computed, got Omega = {Omega[i]}, "
            f"xi = {xi[i]}, where its {what} is {found[i]}: powers of Omega overflow, or the step is singular; "
            "give a smaller Omega, for limits take the scheme's rho_inf"
        )


def _require_told_apart(
    scheme: SchemeRecord, radius: Array, damping: Array, period: Array, Omega: ArrayLike, xi: ArrayLike
) -> None:
    """Raise ValueError where rounding hides whether two eigenvalues are real or complex.

    So it may be where damping is large or NaN, or of a pair below the spectral radius. It is so where two of the large
    ones, of the matrix in the energy norm, are as one, or where all are lost in rounding and were a complex pair
    before. NaN of real eigenvalues apart from each other stays, and so does damping of a pair below a real one.
    """
    if not np.any(np.greater(Omega, HIDDEN_FROM)):
        return
    arguments = points(scheme, Omega, xi)[1]
    radius, damping, period = (x.reshape(-1) for x in (radius, damping, period))
    with np.errstate(all="ignore"):
        log_modulus = -(damping * np.sqrt(1.0 - arguments[1] ** 2) + arguments[1]) * arguments[0] / (1.0 + period)
        below = log_modulus < np.log(radius) - 1e-3
    odd = (below | ~(abs(damping) < LARGE_DAMPING)) & np.isfinite(radius)
    odd &= (arguments[0] > HIDDEN_FROM) & (arguments[1] < 1.0)
    if not odd.any():
        return
    arguments, share = [a[odd] for a in arguments], np.where(below[odd], 0.99, 0.5)
    scaled = _in_energy_norm(scheme, _amplification(scheme, arguments), arguments[0])
    beyond: Any = ~np.isfinite(scaled).all(axis=(1, 2))  # no eigenvalue is known, so that none can be told from another
    values = np.linalg.eigvals(np.where(beyond[:, None, None], 0.0, scaled))
    sizes, distances = abs(values), abs(values[:, :, None] - values[:, None, :])
    close = distances <= AS_ONE * sizes.max(axis=1)[:, None, None]
    i, j = np.triu_indices(values.shape[1], 1)
    large = np.minimum(sizes[:, i], sizes[:, j]) > (share * sizes.max(axis=1))[:, None]
    lost = sizes.max(axis=1) < LOST
    lost[lost] = _complex_before(scheme, [a[lost] for a in arguments])
    for k in np.flatnonzero(beyond | lost | (close[:, i, j] & large).any(axis=1))[:1]:
        raise ValueError(
            f"expected Omega at which the eigenvalues of {scheme.name} can be told apart, got Omega = "
            f"{arguments[0][k]}, xi = {arguments[1][k]}, where rounding hides whether a pair is complex, and so its "
            "damping and period; give a smaller Omega, or ask for spectral_radius alone"
        )


def _complex_before(scheme: SchemeRecord, arguments: list[Array]) -> Array:
    """Whether the eigenvalues are a complex pair (n,) at one large Omega, with the xi and parameters (n,) given."""
    out = np.empty((3, len(arguments[0])))
    before = [np.full(len(arguments[0]), HIDDEN_FROM / 10), *arguments[1:]]
    stability_at_points(scheme.kernels, before, LARGE_DAMPING, out, NANOSECONDS["stability"])
    return np.isfinite(out[1])


def _in_energy_norm(scheme: SchemeRecord, A: Array, Omega: Array) -> Array:
    """A (..., m, m) of the state (omega*u, v, a/omega), which is as large in each entry, at Omega (...)."""
    kinds = np.array([kind for kind, _ in scheme.info.history])
    scale = np.broadcast_to(Omega[..., None], A.shape[:-1]) ** (1.0 - kinds)
    return scale[..., :, None] * A / scale[..., None, :]
