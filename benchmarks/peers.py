"""Other libraries on the same work. Each is imported when a job calls it; the report names those not installed."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class MissingPeerError(RuntimeError):
    """A peer that is not installed, or does not load."""


def peer(module: str) -> Any:
    """The peer's module. Raises MissingPeerError if it cannot be imported, whatever the reason."""
    try:
        return import_module(module)
    except Exception as error:  # a peer's libraries may fail to load in any way
        raise MissingPeerError(f"{type(error).__name__}: {str(error)[:120]}") from error


def eigenvalues(matrices: Array, Omega: Array, xi: Array) -> tuple[Array, Array, Array]:
    """Spectral radius, numerical damping, period error by np.linalg.eigvals of the amplification matrices."""
    found = np.linalg.eigvals(matrices)
    modulus = np.abs(found)
    modulus_of_pair = np.where(found.imag > 0, modulus, -1.0)
    pair = np.take_along_axis(found, modulus_of_pair.argmax(axis=1)[:, None], axis=1)[:, 0]
    with np.errstate(all="ignore"):
        damped, angle = np.sqrt(1.0 - xi * xi), np.where(pair.imag > 0, np.angle(pair), np.nan)
        return modulus.max(axis=1), -np.log(np.abs(pair)) / angle - xi / damped, Omega * damped / angle - 1.0


def radius(matrices: Array) -> Array:
    """Spectral radius alone."""
    return np.abs(np.linalg.eigvals(matrices)).max(axis=1)


def closed_form(name: str) -> Callable[..., tuple[Array, Array, Array]]:
    """A function like `eigenvalues` of (Omega, xi, parameters), in NumPy, as one writes it without substep.

    From the closed form of a scheme with two eigenvalues other than 0. Raises ValueError for a scheme with more.
    """
    from substep_derive import derive  # noqa: PLC0415 (SymPy, only where it is needed)
    from substep_derive.oscillator.spectrum import live  # noqa: PLC0415
    from sympy import lambdify  # noqa: PLC0415

    derivation = derive(name)
    coefficients = live(derivation.charpoly).all_coeffs()
    if len(coefficients) != 3:
        raise ValueError(f"expected a scheme with two eigenvalues that are not always 0, got {name}")
    c2, minus_trace, det = coefficients
    function = lambdify(list(derivation.symbols.values()), [-minus_trace / c2, det / c2], "numpy", cse=True)

    def evaluate(Omega: Array, xi: Array, *parameters: Array) -> tuple[Array, Array, Array]:
        half, modulus2 = function(Omega, xi, *parameters)
        half = 0.5 * half
        with np.errstate(all="ignore"):
            gap = modulus2 - half * half
            radius = np.where(gap > 0, np.sqrt(modulus2), np.abs(half) + np.sqrt(-gap))
            damped, angle = np.sqrt(1.0 - xi * xi), np.arctan2(np.sqrt(gap), half)
            return radius, -0.5 * np.log(modulus2) / angle - xi / damped, Omega * damped / angle - 1.0

    return evaluate


# Response spectra: peak |u| of each oscillator


def numpy_across_lanes(D: Array, B0: Array, B1: Array, forces: Array) -> Array:
    """A loop over steps in Python with NumPy over all lanes; D (m, m, lanes), forces h^2 f (n + 1,)."""
    x = np.zeros_like(B0)
    peak = np.zeros(B0.shape[1])
    for f0, f1 in zip(forces[:-1].tolist(), forces[1:].tolist(), strict=True):
        x = x + np.einsum("ijk,jk->ik", D, x) + B0 * f0 + B1 * f1
        np.maximum(peak, np.abs(x[0]), out=peak)
    return peak


def lfilter_peaks(numerator: Array, denominator: Array, forces: Array) -> Array:
    """Peak |u| (lanes,) by scipy.signal.lfilter, a lane at a time."""
    signal = peer("scipy.signal")
    lanes = zip(numerator, denominator, strict=True)
    return np.array([np.abs(signal.lfilter(b, a, forces)).max() for b, a in lanes])


def pyyeti_peaks(omegas: Array, xi: float, record: Array, dt: float) -> Array:
    """Peak |u| (lanes,) by pyyeti.srs, without resampling."""
    srs = peer("pyyeti.srs")
    return srs.srs(
        record, 1.0 / dt, omegas / (2 * np.pi), 0.5 / xi, stype="reldisp", rolloff="none", parallel="no"
    )  # fmt: skip


def pyyeti_spectrum(omegas: Array, xi: float, record: Array, dt: float) -> Array:
    """SD, SV, SA (3, lanes) of pyyeti.srs, a call for each."""
    srs, arguments = peer("pyyeti.srs"), (record, 1.0 / dt, omegas / (2 * np.pi), 0.5 / xi)
    kinds = ("reldisp", "relvelo", "absacce")
    return np.stack([srs.srs(*arguments, stype=kind, rolloff="none", parallel="no") for kind in kinds])


def eqsig_spectrum(omegas: Array, xi: float, record: Array, dt: float) -> Array:
    """SD, SV, SA (3, lanes) of eqsig's Nigam-Jennings response; its acceleration is absolute."""
    return np.stack(
        [np.abs(x).max(axis=1) for x in peer("eqsig.sdof").response_series(record, dt, 2 * np.pi / omegas, xi)]
    )


def eqsig_peaks(omegas: Array, xi: float, record: Array, dt: float) -> Array:
    """Peak |u| (lanes,) of eqsig's Nigam-Jennings response."""
    sdof = peer("eqsig.sdof")
    return np.abs(sdof.response_series(record, dt, 2 * np.pi / omegas, xi)[0]).max(axis=1)


# One linear run: u at the steps' ends


def python_loop(D: Array, B0: Array, B1: Array, forces: Array) -> Array:
    """A loop in plain Python for one oscillator; D (2, 2), B0, B1 (2,)."""
    (d00, d01), (d10, d11) = D.tolist()
    (b00, b01), (b10, b11) = B0.tolist(), B1.tolist()
    u = v = 0.0
    out = [u]
    f0, *rest = forces.tolist()
    for f1 in rest:
        du = d00 * u + d01 * v + b00 * f0 + b10 * f1
        v += d10 * u + d11 * v + b01 * f0 + b11 * f1
        u += du
        f0 = f1
        out.append(u)
    return np.array(out)


def lfilter_run(numerator: Array, denominator: Array, forces: Array) -> Array:
    """scipy.signal.lfilter."""
    return peer("scipy.signal").lfilter(numerator, denominator, forces)


def lsim_run(omega: float, xi: float, record: Array, dt: float) -> Array:
    """scipy.signal.lsim, exact for a load linear between samples."""
    signal = peer("scipy.signal")
    system = signal.StateSpace([[0.0, 1.0], [-(omega**2), -2 * xi * omega]], [[0.0], [1.0]], [[1.0, 0.0]], [[0.0]])
    return signal.lsim(system, record, dt * np.arange(len(record)))[1]


def solve_unc_run(omega: float, xi: float, record: Array, dt: float) -> Array:
    """pyyeti's SolveUnc, exact for a load linear between samples."""
    ode = peer("pyyeti.ode")
    return ode.SolveUnc(1.0, 2 * xi * omega, omega**2, dt).tsolve(np.atleast_2d(record)).d[0]
