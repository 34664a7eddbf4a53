"""The largest frequency of a structure, and the step up to which a scheme is stable on it."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..core.arrays import Array
from ..core.coefficients import refuse_damping
from ..core.errors import require_numbers
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from .damping import Rayleigh
from .low_rank import LowRank
from .matrices import diagonal_of, require_symmetric
from .plan import step_of
from .refusals import require_decay, require_definite_mass, require_linear
from .structure import Structure

DENSE = 100  # unknowns up to which LAPACK finds the largest mode in less time than Lanczos's method
UNSTABLE = 1.0 + 1e-6  # largest spectral radius of a stable step; it may have only half its digits near 1
BELOW = np.geomspace(1e-6, 1.0, 400)  # of the largest frequency: where damping that is not largest there is looked at
WHOLE = 120  # unknowns up to which the eigenvalues of a whole step are found, where damping couples the modes
SHORTER = np.geomspace(0.02, 1.0, 20)  # of a step: at which it is looked for the first unstable one
SAME = 1e-8  # relative difference of two vectors that are the same but for rounding


@dataclass(frozen=True)
class CriticalStep:
    """The largest stable step, s; inf for a scheme that is stable at every step.

    omega: the structure's largest circular frequency, rad/s, and xi the damping ratio of its mode. Omega: up to which
    the scheme is stable at xi, as certified by exact algebra; None without end. dt = Omega/omega, or less where a mode
    below, with another damping ratio, or modes that damping couples, are unstable before.
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
    Under Rayleigh damping every frequency below the largest is looked at too, under modal damping every damped mode,
    and under any other damping matrix, which may couple modes, the eigenvalues of the whole step.

    Raises ValueError as `largest_mode` and `frequency_bound`, for a structure with an internal force, for K or damping
    with a negative eigenvalue, with which no step is stable, for parameters that are arrays, for a scheme that takes no
    damping on a structure with damping, and for a damping matrix of more than 120 degrees of freedom that is neither
    that of Rayleigh nor of modes.
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
    if structure.C is not None and dt > 0.0:
        dt = _damped(s, structure, omega, dt)
    return CriticalStep(float(dt), omega, xi, end)


def _exact(value: float) -> Fraction:
    """The simplest fraction that prints as this number: a third where one was meant, else the decimal number."""
    near = Fraction(value).limit_denominator(1000)
    return near if float(near) == value else Fraction(repr(value))


def _damped(scheme: Scheme, structure: Structure, omega: float, dt: float) -> float:
    """The step, or the largest below it up to which the scheme is stable on the damped structure."""
    known = _ratios(structure, omega)
    if known is not None:
        omegas, xi = known

        def stable(h: float) -> bool:
            return bool((scheme.spectral_radius(omegas * h, xi) <= UNSTABLE).all())

        return _stable_below(stable, omega, dt, 1e-9, np.ones(1))
    if structure.size > WHOLE:
        raise ValueError(
            f"expected Rayleigh or modal damping of more than {WHOLE} degrees of freedom, got another damping matrix "
            f"of {structure.size}, whose critical step is not that of its modes; give C=substep.rayleigh(...) or "
            "substep.modal_damping(...), or find a stable step by marches"
        )
    return _stable_below(lambda h: _whole_radius(scheme, structure, h) <= UNSTABLE, omega, dt, 1e-6, SHORTER)


def _ratios(structure: Structure, omega: float) -> tuple[Array, Array] | None:
    """Frequencies up to the largest, rad/s, and the damping ratios there, where damping couples no modes."""
    M, K, omegas = structure.M, structure.K, omega * BELOW
    rayleigh = structure.C if isinstance(structure.C, Rayleigh) else _as_rayleigh(structure)
    if rayleigh is not None:
        return omegas, np.array([max(rayleigh.ratio(w), 0.0) for w in omegas])
    if not isinstance(structure.C, LowRank):
        return None
    shapes = np.column_stack([structure.solve_mass(b) for b in structure.C.B.T])
    forces = K @ shapes
    squares = np.einsum("nm,nm->m", shapes, forces)
    if not np.allclose(forces, (M @ shapes) * squares, rtol=0.0, atol=1e-6 * np.abs(forces).max()):
        return None
    own = np.sqrt(np.maximum(squares, np.finfo(float).tiny))
    return np.append(omegas, own), np.append(np.zeros(len(omegas)), np.maximum(0.5 * structure.C.d / own, 0.0))


def _as_rayleigh(structure: Structure) -> Rayleigh | None:
    """A damping matrix that is alpha M + beta K as these two numbers; None of any other."""
    x = np.random.default_rng(0).normal(size=structure.size)
    parts, whole = np.stack([structure.M @ x, structure.K @ x], axis=-1), np.asarray(structure.damping @ x)
    sizes = np.maximum(np.abs(parts).max(axis=0), np.finfo(float).tiny)
    numbers = np.linalg.lstsq(parts / sizes, whole)[0] / sizes
    same = np.abs(parts @ numbers - whole).max() <= SAME * np.abs(whole).max()
    return Rayleigh(*numbers.tolist()) if same else None


def _whole_radius(scheme: Scheme, structure: Structure, h: float) -> float:
    """The spectral radius of a step of the whole structure, whose state is that of the scheme."""
    known: tuple[Any, ...] = (structure.M, structure.damping, structure.K)
    M, C, K = (A if isinstance(A, np.ndarray) else A @ np.eye(structure.size) for A in known)
    steps, n = step_of(scheme, h), structure.size
    X = np.zeros((steps.vectors, n, steps.given * n))
    X[: steps.given] = np.eye(steps.given * n).reshape(steps.given, n, -1)
    for system in steps.systems:
        rows = (M, system.inertia), (C, system.damping), (K, system.linear_stiffness)
        right = sum(A @ np.tensordot(row[: system.place], X[: system.place], 1) for A, row in rows)
        X[system.place] = np.linalg.solve(sum(row[system.place] * A for A, row in rows), -right)
    scale = np.repeat([h**kind for kind, _ in scheme.history], n)  # u, h*v, h^2*a are of one size
    step = np.tensordot(steps.out, X, 1).reshape(steps.given * n, -1)
    return float(np.abs(np.linalg.eigvals(scale[:, None] * step / scale)).max())


def _stable_below(stable: Callable[[float], bool], omega: float, dt: float, digits: float, shorter: Array) -> float:
    """The step, or the largest below it with which `stable` holds, to so many digits of it.

    shorter: fractions of the step at which it is looked for the first one that is not stable.
    """
    end = dt * (1.0 - 1e-9) if np.isfinite(dt) else 1e3 / omega
    tried = (end * shorter).tolist()
    high = next((h for h in tried if not stable(h)), None)
    if high is None:
        return dt
    low = max((h for h in tried if h < high), default=0.0)
    while high - low > digits * high:
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
