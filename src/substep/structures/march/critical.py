"""The largest frequency of a structure, and the step up to which a scheme is stable on it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...core.arrays import Array
from ...core.exports import Exported
from ...core.schemes import Scheme
from ...run.schemes import numbers_only
from ..model.model import Model
from ..model.rayleigh import Rayleigh
from ..solvers.low_rank import LowRank
from ..solvers.matrices import diagonal_of, require_symmetric
from .refusals import require_decay, require_definite_mass, require_linear, require_undamped
from .scheme_plan import step_of

DENSE = 100  # unknowns up to which LAPACK finds the largest mode in less time than Lanczos's method
UNSTABLE = 1.0 + 1e-6  # largest spectral radius of a stable step; it may have only half its digits near 1
BELOW = np.geomspace(1e-6, 1.0, 400)  # of the largest frequency: where damping that is not largest there is looked at
WHOLE = 120  # unknowns up to which the eigenvalues of a whole step are found, where damping couples the modes
TRIED = 100  # steps below a critical one at which it is looked for instability
LONG = 1e3  # radians or e-foldings in a step that is tried where the scheme is stable without end
SAME = 1e-8  # relative difference of two vectors that are the same but for rounding
NOTHING = 1e-10  # of the largest: a stiffness or damping that is rounding


@dataclass(frozen=True)
class CriticalStep(Exported):
    """The largest stable step, s; inf for a scheme that is stable at every step.

    omega: the structure's largest circular frequency, rad/s, and xi the damping ratio of its mode. Omega: up to which
    the scheme is stable at xi, as certified by exact algebra; None without end. dt = Omega/omega, or less where a mode
    below, with another damping ratio, or modes that damping couples, are unstable before.
    """

    dt: float
    omega: float
    xi: float
    Omega: float | None


def largest_mode(structure: Model) -> tuple[float, Array]:
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


def frequency_bound(structure: Model) -> float:
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


def critical_step(structure: Model, scheme: Scheme | str, *, bound: bool = False) -> CriticalStep:
    """The largest step with which a scheme is stable on a linear structure.

    bound: take Gershgorin's bound in place of the largest frequency, which makes the step a safe one, and shorter.
    Under Rayleigh damping all frequencies below the largest are looked at too. Under another damping matrix, which may
    couple modes, the eigenvalues of the whole step are, up to 120 degrees of freedom; beyond these under modal damping
    every damped mode is. Of a damped structure a hundred shorter steps are tried too.

    Raises ValueError as `largest_mode` and `frequency_bound`, for a structure with an internal force, for K or damping
    with a negative eigenvalue, with which no step is stable, for parameters that are arrays, for a scheme that takes no
    damping on a structure with damping, and for a damping matrix of more than 120 degrees of freedom that is neither
    that of Rayleigh nor of modes.
    """
    from ...derived import facade  # noqa: PLC0415 (SymPy)
    from ...derived.simple_fraction import printed_fraction  # noqa: PLC0415

    require_linear(structure, "a critical step")
    s = numbers_only(scheme, "ask once for each")
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
    require_undamped(structure, s, s.name)
    given = {name: printed_fraction(float(value)) for name, value in s.given.items()}
    Omega = facade.certificate(s.info.source, xi=printed_fraction(xi), **given).critical_Omega
    end = None if Omega is None else float(Omega)
    dt = np.inf if end is None or omega == 0.0 else end / omega
    if structure.C is not None and dt > 0.0:
        dt = _damped(s, structure, omega, dt)
    return CriticalStep(float(dt), omega, xi, end)


def _damped(scheme: Scheme, structure: Model, omega: float, dt: float) -> float:
    """The step, or the largest below it up to which the scheme is stable on the damped structure."""
    known = _ratios(structure, omega)
    if known is not None:
        omegas, xi = known
        end = min(dt * (1.0 - 1e-9), LONG / omega)

        def stable(h: float) -> bool:
            return bool((scheme.spectral_radius(omegas * h, xi) <= UNSTABLE).all())

        return _stable_below(stable, np.linspace(end / TRIED, end, TRIED), dt, 1e-9)
    stiffness, damping = _modal(structure)
    m = len(stiffness)
    if not m:
        return dt
    first_order = np.block([[np.zeros((m, m)), np.eye(m)], [-np.diag(stiffness), -damping]])
    rate = float(np.abs(np.linalg.eigvals(first_order)).max())
    end = min(dt * (1.0 - 1e-9), LONG / rate)
    steps = np.geomspace(min(1e-2 / rate, end / TRIED), end, TRIED)
    return _stable_below(lambda h: _whole_radius(scheme, stiffness, damping, h) <= UNSTABLE, steps, dt, 1e-6)


def _ratios(structure: Model, omega: float) -> tuple[Array, Array] | None:
    """Frequencies up to the largest, rad/s, and the damping ratios there; None where damping may couple modes.

    Of modal damping those of the damped modes and, if there are others, the largest frequency without damping.
    """
    large, omegas = structure.size > WHOLE, omega * BELOW
    rayleigh = structure.C if isinstance(structure.C, Rayleigh) else _as_rayleigh(structure) if large else None
    if omega == 0.0 or (rayleigh is None and not large):
        return None
    if rayleigh is not None:
        return omegas, np.array([max(rayleigh.ratio(w), 0.0) for w in omegas])
    if not isinstance(structure.C, LowRank):
        return None
    shapes = np.column_stack([structure.solve_mass(b) for b in structure.C.B.T])
    forces = structure.K @ shapes
    squares = np.einsum("nm,nm->m", shapes, forces)
    if not np.allclose(forces, (structure.M @ shapes) * squares, rtol=0.0, atol=1e-6 * np.abs(forces).max()):
        return None
    own = np.sqrt(np.maximum(squares, np.finfo(float).tiny))
    others = [omega] * (len(own) < structure.size)
    return np.append(own, others), np.append(np.maximum(0.5 * structure.C.d / own, 0.0), np.zeros(len(others)))


def _as_rayleigh(structure: Model) -> Rayleigh | None:
    """A damping matrix of many degrees of freedom that is alpha M + beta K as these two numbers; None of any other."""
    x = np.random.default_rng(0).normal(size=structure.size)
    parts, whole = np.stack([structure.M @ x, structure.K @ x], axis=-1), np.asarray(structure.damping @ x)
    sizes = np.maximum(np.abs(parts).max(axis=0), np.finfo(float).tiny)
    numbers = np.linalg.lstsq(parts / sizes, whole)[0] / sizes
    same = np.abs(parts @ numbers - whole).max() <= SAME * np.abs(whole).max()
    return Rayleigh(*numbers.tolist()) if same else None


def _modal(structure: Model) -> tuple[Array, Array]:
    """Stiffness (m,) and damping (m, m) in the modes of unit mass, without motions that nothing stiffens or damps.

    These have a double eigenvalue 1 in every scheme, which rounding would split. Raises ValueError for more degrees of
    freedom than WHOLE.
    """
    from scipy import linalg  # noqa: PLC0415

    if isinstance(structure.C, Rayleigh):  # of a structure without stiffness: all motions are alike
        damped = [structure.C.alpha] if structure.C.alpha else []
        return np.zeros(len(damped)), np.diag(damped)
    if structure.size > WHOLE:
        raise ValueError(
            f"expected Rayleigh or modal damping of more than {WHOLE} degrees of freedom, got another damping matrix "
            f"of {structure.size}, whose critical step is not that of its modes; give C=substep.rayleigh(...) or "
            "substep.modal_damping(...), or find a stable step by marches"
        )
    one = np.eye(structure.size)
    M, C, K = (np.asarray(A @ one) for A in (structure.M, structure.damping, structure.K))
    squares, shapes = linalg.eigh(K, M)
    damping = shapes.T @ C @ shapes
    free = np.flatnonzero(squares <= NOTHING * max(squares[-1], 0.0))
    _, sizes, turned = np.linalg.svd(damping[:, free])
    turned = turned[: int((sizes > NOTHING * np.abs(damping).max()).sum())]  # those that are damped
    basis = np.eye(len(squares))
    basis = np.column_stack([basis[:, free] @ turned.T, np.delete(basis, free, axis=1)])
    return np.einsum("im,i,im->m", basis, squares, basis), basis.T @ damping @ basis


def _whole_radius(scheme: Scheme, stiffness: Array, damping: Array, h: float) -> float:
    """The spectral radius of a step of all modes, whose state is that of the scheme."""
    steps, m = step_of(scheme, h), len(stiffness)
    X = np.zeros((steps.vectors, m, steps.given * m))
    X[: steps.given] = np.eye(steps.given * m).reshape(steps.given, m, -1)
    for group in steps.groups:
        unknown = group[0].unknowns
        known = slice(unknown.start)
        parts = [
            (np.eye(m), np.array([s.inertia for s in group])),
            (damping, np.array([s.damping for s in group])),
            (np.diag(stiffness), np.array([s.linear_stiffness for s in group])),
        ]
        right = sum(A @ np.tensordot(rows[:, known], X[known], 1) for A, rows in parts)
        whole = sum(np.kron(rows[:, unknown], A) for A, rows in parts)
        X[unknown] = np.linalg.solve(whole, -right.reshape(len(whole), -1)).reshape(len(group), m, -1)
    scale = np.repeat([h**kind for kind, _ in scheme.history], m)  # u, h*v, h^2*a are of one size
    step = np.tensordot(steps.out, X, 1).reshape(steps.given * m, -1)
    return float(np.abs(np.linalg.eigvals(scale[:, None] * step / scale)).max())


def _stable_below(stable: Callable[[float], bool], steps: Array, dt: float, digits: float) -> float:
    """dt where all steps, which ascend, are stable; else what is before the first one that is not, to `digits`."""
    tried = steps.tolist()
    high = next((h for h in tried if not stable(h)), None)
    if high is None:
        return dt
    low = max((h for h in tried if h < high), default=0.0)
    while high - low > digits * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def _require_mass(structure: Model) -> None:
    require_definite_mass(structure)
    require_symmetric("M", structure.M, "for its largest frequency")
    require_symmetric("K", structure.K, "for its largest frequency")
    if len(massless := structure.massless):
        raise ValueError(
            f"expected mass at each degree of freedom, got none at {structure.named(int(massless[0]))}, whose "
            "frequency is without bound; condense such degrees of freedom, or take an implicit scheme"
        )
