"""The largest frequency of a structure, and the step up to which a scheme is stable on it."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..core.arrays import Array
from ..core.coefficients import refuse_damping
from ..core.errors import require_numbers
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from .damping import Rayleigh
from .matrices import diagonal_of, require_symmetric
from .refusals import require_decay, require_definite_mass, require_linear
from .structure import Structure

DENSE = 100  # unknowns up to which LAPACK finds the largest mode in less time than Lanczos's method
UNSTABLE = 1.0 + 1e-6  # largest spectral radius of a stable step; it may have only half its digits near 1
BELOW = np.geomspace(1e-6, 1.0, 400)  # of the largest frequency: where damping that is not largest there is looked at


@dataclass(frozen=True)
class CriticalStep:
    """The largest stable step, s; inf for a scheme that is stable at every step.

    omega: the structure's largest circular frequency, rad/s, and xi the damping ratio of its mode. Omega: up to which
    the scheme is stable at xi, as certified by exact algebra; None without end. dt = Omega/omega, or less where a mode
    below, with another damping ratio, is unstable before.
    """

    dt: float
    omega: float
    xi: float
    Omega: float | None


def largest_mode(structure: Structure) -> tuple[float, Array]:
    """The largest circular frequency, rad/s, and its mass-normalised shape (n,), by LAPACK or Lanczos's method.

    Lanczos's method comes to it from below, within 1e-9 of it. Raises ValueError for degrees of freedom without mass,
    for M or K that is not symmetric, and for an M with negative eigenvalues.
    """
    from scipy import linalg  # noqa: PLC0415
    from scipy.sparse.linalg import LinearOperator, eigsh  # noqa: PLC0415

    _require_mass(structure)
    M, K, n = structure.M, structure.K, structure.size
    if n <= DENSE or isinstance(K, np.ndarray):
        M, K = (A if isinstance(A, np.ndarray) else A.toarray() for A in (M, K))
        values, shapes = linalg.eigh(K, M, subset_by_index=[n - 1, n - 1])
    else:
        solve = structure.solve_mass
        inverse = LinearOperator((n, n), matvec=lambda b: solve(b.ravel()), dtype=np.float64)
        first = np.random.default_rng(0).normal(size=n)
        values, shapes = eigsh(K, 1, M=M, Minv=inverse, which="LA", tol=1e-10, v0=first)
    return float(np.sqrt(max(values[0], 0.0))), shapes[:, 0]


def frequency_bound(structure: Structure) -> float:
    """A bound on all circular frequencies, rad/s, by Gershgorin's circles, for a lumped mass: one pass over K.

    Raises ValueError for an M that is not diagonal, degrees of freedom without mass, negative masses, K not symmetric.
    """
    mass = diagonal_of(structure.M)
    if mass is None:
        raise ValueError(
            "expected a lumped (diagonal) mass matrix for Gershgorin's bound, got another; leave bound out"
        )
    _require_mass(structure)
    return float(np.sqrt((np.asarray(abs(structure.K).sum(axis=1)).ravel() / mass).max()))


def critical_step(structure: Structure, scheme: Scheme | str, *, bound: bool = False) -> CriticalStep:
    """The largest step with which a scheme is stable on a linear structure.

    bound: take Gershgorin's bound in place of the largest frequency, which makes the step a safe one, and shorter.
    Under Rayleigh damping every frequency below the largest is looked at too; of another damping matrix the largest
    mode's ratio alone is taken, its coupling to other modes is not.

    Raises ValueError as `largest_mode` and `frequency_bound`, for a structure with an internal force, for K or damping
    with a negative eigenvalue, with which no step is stable, for parameters that are arrays, and for a scheme that
    takes no damping on a structure with damping.
    """
    from ..derived import facade  # noqa: PLC0415 (SymPy)

    require_linear(structure, "a critical step")
    s = make_scheme(scheme)
    require_numbers(s.name, s.parameters, "ask once for each")
    if bound:
        omega, xi = frequency_bound(structure), 0.0
        if structure.C is not None and not isinstance(structure.C, Rayleigh):
            raise ValueError("expected Rayleigh damping, or none, with bound=True, got a matrix; leave bound out")
    else:
        omega, shape = largest_mode(structure)
        xi = 0.5 * float(shape @ (structure.damping @ shape)) / omega if omega > 0.0 else 0.0
    require_decay(structure)
    if isinstance(structure.C, Rayleigh) and omega > 0.0:
        xi = structure.C.ratio(omega)
    xi = max(xi, 0.0)  # of rounding
    refuse_damping(s, xi)
    given = {name: _exact(float(value)) for name, value in s.given.items()}
    Omega = facade.certificate(s.info.source, xi=_exact(xi), **given).critical_Omega
    end = None if Omega is None else float(Omega)
    if omega == 0.0:
        return CriticalStep(np.inf, omega, xi, end)
    dt = np.inf if end is None else end / omega
    if isinstance(structure.C, Rayleigh) and dt > 0.0:
        dt = _stable_below(s, structure.C, omega, dt)
    return CriticalStep(float(dt), omega, xi, end)


def _exact(value: float) -> Fraction:
    """The simplest fraction that prints as this number: a third where one was meant, else the decimal number."""
    near = Fraction(value).limit_denominator(1000)
    return near if float(near) == value else Fraction(repr(value))


def _stable_below(scheme: Scheme, damping: Rayleigh, omega: float, dt: float) -> float:
    """The step, or the largest below it with which all frequencies up to omega are stable, to 1e-9 of it."""
    omegas = omega * BELOW
    xi = np.array([max(damping.ratio(w), 0.0) for w in omegas])

    def stable(h: float) -> bool:
        return bool((scheme.spectral_radius(omegas * h, xi) <= UNSTABLE).all())

    high = dt * (1.0 - 1e-9) if np.isfinite(dt) else 1e3 / omega
    if stable(high):
        return dt
    low = 0.0
    while high - low > 1e-9 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def _require_mass(structure: Structure) -> None:
    require_definite_mass(structure)
    require_symmetric("M", structure.M, "for its largest frequency")
    require_symmetric("K", structure.K, "for its largest frequency")
    if len(massless := structure.massless):
        raise ValueError(
            f"expected mass at each degree of freedom, got none at {structure.named(int(massless[0]))}, whose "
            "frequency is without bound; condense such degrees of freedom, or take an implicit scheme"
        )
