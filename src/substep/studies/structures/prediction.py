"""The displacement of one degree of freedom by modes: exact, by a scheme, and what each mode's error makes of it."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...core.arrays import Array
from ...core.schemes import Scheme
from ...exact.coupled import coupled_histories
from ...exact.oscillator import exact_histories
from ...marching.linear import march_linear
from ...run.clock import ConstantSteps
from ...structures.march.critical import UNSTABLE, largest_mode
from ...structures.model.given import Dof
from ...structures.model.rayleigh import Rayleigh
from ...structures.modes.eigen import static_response
from ...structures.modes.modal_lanes import modal_lanes
from ...structures.modes.superposition import coordinates, residual_flexibility
from ...structures.solvers.low_rank import LowRank
from ...structures.structure import Modes
from ..step_counts import FINER, PHASES, SAMPLES

SIGNIFICANT = 0.01  # of the largest displacement: a mode that vibrates with less does not count for PHASES
ROUNDING = 1e-12  # but no more accurate than this
MOST_STEPS = 1 << 22  # of the reference
BEYOND = 1e3  # times the last known frequency: up to there unknown ones are looked for
UNBOUNDED = 1e6  # omega dt of what has no mass; powers of it do not overflow in any step


@dataclass(frozen=True)
class Parts:
    """Parts of an error, each the largest over the span relative to the largest displacement; their sum bounds it.

    truncation: modes left out, beside their static response. integration: the scheme, under a load that is linear
    between steps. load_sampling: what such a load differs by from the true one; both cancel in part where the scheme
    takes the load at other instants.
    """

    truncation: float
    integration: float
    load_sampling: float


@dataclass(frozen=True, eq=False)
class Prediction:
    """The displacement of `quantity` over `t_end`, relative to whose largest value errors are.

    modes: those by which the motion is known; the rest of the structure is taken to follow statically.
    """

    modes: Modes
    quantity: Dof
    t_end: float
    accuracy: float
    _exact: dict[int, Array] = field(default_factory=dict, init=False, repr=False)  # by the number of steps

    @cached_property
    def weights(self) -> Array:
        """What each mode contributes to the displacement (m,)."""
        whole = self.modes.structure
        return (whole.T[[whole.place(self.quantity)]] @ self.modes.free_shapes)[0]

    @cached_property
    def statics(self) -> tuple[Array, Array]:
        """Static response of the displacement to each load: of the structure (J,), and of its elastic modes (m, J)."""
        whole, modes = self.modes.structure, self.modes
        own = np.zeros_like(modes.load_factors)
        elastic = slice(modes.rigid, None)
        own[elastic] = self.weights[elastic, None] * modes.load_factors[elastic] / modes.omega[elastic, None] ** 2
        return (whole.T[[whole.place(self.quantity)]] @ modes.statics)[0], own

    def samples(self, n: int) -> Array:
        """All loads at the ends of n steps (n + 1, J)."""
        return self.modes.structure.load_values(np.arange(n + 1) * (self.t_end / n))

    def exact(self, n: int, rows: int) -> Array:
        """Exact modal displacements, weighted, (rows + 1, m), under loads that are linear within each of n steps."""
        if n not in self._exact or len(self._exact[n]) != rows + 1:
            self._exact[n] = self._exactly(n, rows) * self.weights
        return self._exact[n]

    def _exactly(self, n: int, rows: int) -> Array:
        modes, dt, stride = self.modes, self.t_end / n, n // rows
        given = self.samples(n)
        if not modes.lanes:
            start = modes.start[:2]
            return coupled_histories(modes.omega, modes.damping, modes.load_factors, dt, start, given, stride)
        total, of_load = np.zeros((rows + 1, len(modes))), iter(given.T)
        for lane in modal_lanes(modes, ConstantSteps(dt, n)):
            o = lane.oscillators
            samples = np.zeros(n + 1) if lane.load is None else next(of_load)
            total += lane.factor * exact_histories(o.omega, o.xi, dt, o.start[:2], samples, stride)[:, 0]
        return total

    def by_scheme(self, scheme: Scheme, n: int, rows: int) -> Array:
        """Modal displacements of a scheme in n steps, weighted, (rows + 1, m); not finite where it overflows."""
        modes, dt, stride = self.modes, self.t_end / n, n // rows
        with np.errstate(all="ignore"):
            if not modes.lanes:
                found = np.full((rows + 1, len(modes)), np.nan)
                own = coordinates(modes, scheme, dt, self.t_end, stride=stride)[:, 0]
                found[: len(own)] = own
                return found * self.weights
            total = np.zeros((rows + 1, len(modes)))
            for lane in modal_lanes(modes, ConstantSteps(dt, n)):
                total += lane.factor * march_linear(scheme, lane.oscillators, n, lane.load, stride=stride).out[:, 0]
            return total * self.weights

    @cached_property
    def rows(self) -> int:
        """At how many times errors are taken."""
        first = self.exact(64 * SAMPLES, SAMPLES)
        moving = np.abs(first - self.quasi_static(SAMPLES)).max(axis=0)
        scale = np.abs(self.displacement(first, SAMPLES)).max()
        omega = self.modes.omega[moving > SIGNIFICANT * scale].max(initial=0.0)
        return max(SAMPLES, int(np.ceil(PHASES * self.t_end * omega / (2.0 * np.pi))))

    @cached_property
    def reference(self) -> Array:
        """Exact modal displacements, weighted, (rows + 1, m), with the load sampled finely enough.

        Raises ValueError where 4 million samples are not enough.
        """
        n, before, wished = 16 * self.rows, None, max(self.accuracy / FINER, ROUNDING)
        while n <= MOST_STEPS:
            found = self.exact(n, self.rows)
            total = found.sum(axis=1)
            if before is not None:
                scale = np.abs(self.displacement(found, self.rows)).max()
                if np.abs(total - before).max() <= wished * scale:
                    return found
            n, before = 2 * n, total
        raise ValueError(
            f"expected loads that {MOST_STEPS} samples resolve over {self.t_end:g} s to {wished:.1g}, got "
            "others; end the span where a load jumps, or give it as a record"
        )

    def quasi_static(self, rows: int) -> Array:
        """What each elastic mode would contribute if it followed the loads statically (rows + 1, m)."""
        return self.samples(rows) @ self.statics[1].T

    def displacement(self, modal: Array, rows: int) -> Array:
        """The displacement (rows + 1,) from modal ones, with the static response of all other modes."""
        whole, own = self.statics
        return modal.sum(axis=1) + self.samples(rows) @ (whole - own.sum(axis=0))

    @cached_property
    def scale(self) -> float:
        """The largest exact displacement. Raises ValueError where it does not move."""
        largest = float(np.abs(self.displacement(self.reference, self.rows)).max())
        if largest == 0.0:
            raise ValueError(
                f"expected a degree of freedom that moves, got {self.quantity!r}, which stays at 0; choose another, or "
                "give the structure a load or a start"
            )
        return largest

    @cached_property
    def left_out(self) -> Array:
        """What is missing if only the first i modes are taken, beside the static response (rows + 1, m + 1)."""
        dynamic = self.reference - self.quasi_static(self.rows)
        missing = np.zeros((len(dynamic), dynamic.shape[1] + 1))
        missing[:, :-1] = np.cumsum(dynamic[:, ::-1], axis=1)[:, ::-1]
        return missing

    @cached_property
    def unforeseen(self) -> float:
        """At most about what modes that are not known do beside following statically, relative to `scale`.

        How much flexibility the unknown modes have is what the known ones lack of the static one, and so is its mean
        of 1/omega^2; no modes with these two follow a load less than `_most` says. The displacement elsewhere is
        bounded by the inequality of Cauchy and Schwarz, that of a start by the energy that it has beside known modes.
        """
        modes, whole = self.modes, self.modes.structure
        if len(modes) == whole.size - len(whole.massless):
            return 0.0
        at_loads, at_quantity = self._lacking
        omega = max(modes.omega[-1], 1.0 / self.t_end) * np.geomspace(1.0, BEYOND, 25)
        n, total = 16 * self.rows, np.sqrt(at_quantity[0] * self._energy_beyond)
        for samples, lacking in zip(self.samples(n).T, at_loads.T, strict=True):
            start = np.array([samples[0] / omega**2, 0.0 * omega])
            u = exact_histories(omega, self._ratios_beyond(omega), self.t_end / n, start, samples, 4)[:, 0]
            missed = np.abs(u * omega**2 - samples[::4, None]).max(axis=0)
            total += np.sqrt(_most(*lacking, omega, missed) * _most(*at_quantity, omega, missed))
        return float(total) / self.scale

    @property
    def _lacking(self) -> tuple[Array, Array]:
        """What the known modes lack of the sums of f^2/omega^2 and f^2/omega^4 over all modes, f their factors.

        Those of each load (2, J), and the shapes' values at the quantity (2,). The latter are taken to be to those of
        the load of the largest as both are in the upper half of the known modes, exact at the loaded degree of freedom,
        which saves factors of K; without a load they are computed.
        """
        modes, whole = self.modes, self.modes.structure
        elastic = slice(modes.rigid, None)
        powers = modes.omega[elastic] ** np.array([[-2.0], [-4.0]])
        own, known = powers * self.weights[elastic] ** 2, powers @ modes.load_factors[elastic] ** 2
        at_loads = self._sums(whole.load_vectors, modes.statics) - known
        upper = slice(own.shape[1] // 2, None)
        shares = (modes.load_factors[elastic][upper] / modes.omega[elastic][upper, None]) ** 2
        j = int(np.argmax(shares.sum(axis=0))) if whole.loads else 0
        if whole.loads and (share := shares[:, j].sum()) > 0.0:
            at_quantity = at_loads[:, j] * own[0, upper].sum() / share
        else:
            unit = whole.T[[whole.place(self.quantity)]].T
            unit = unit if isinstance(unit, np.ndarray) else unit.toarray()
            moved = static_response(whole, unit, modes.free_shapes[:, : modes.rigid])
            at_quantity = self._sums(unit, moved)[:, 0] - own.sum(axis=1)
        return np.maximum(at_loads, 0.0), np.maximum(at_quantity, 0.0)

    def _sums(self, loads: Array, moved: Array) -> Array:
        """Of f^2/omega^2 and f^2/omega^4 over all modes (2, J): from the loads (n, J) and what they move statically."""
        return np.array([(loads * moved).sum(axis=0), (moved * (self.modes.structure.M @ moved)).sum(axis=0)])

    @property
    def _energy_beyond(self) -> float:
        """Twice the energy that the start has beside the known modes and the static response of all others."""
        modes, whole = self.modes, self.modes.structure
        u = whole.u0 - modes.free_shapes @ modes.start[0] - residual_flexibility(modes) @ self.samples(1)[0]
        v = whole.v0 - modes.free_shapes @ modes.start[1]
        return float(max(u @ (whole.K @ u), 0.0) + v @ (whole.M @ v))

    def errors(self, scheme: Scheme, n: int) -> Array:
        """The error of the displacement with the first i modes, i = 0 to m, (m + 1,), relative to `scale`.

        inf for numbers of modes that leave out a rigid one or hold an unstable one.
        """
        wrong = self.by_scheme(scheme, n, self.rows) - self.reference
        found = np.full(len(self.modes) + 1, np.inf)
        with np.errstate(all="ignore"):
            summed = np.zeros_like(self.left_out)
            summed[:, 1:] = np.cumsum(wrong, axis=1)
            errors = np.abs(summed - self.left_out).max(axis=0) / self.scale
        good = np.isfinite(errors)
        found[good] = errors[good]
        found[: max(self.modes.rigid, 1)] = np.inf
        if self.modes.lanes:
            radius = scheme.spectral_radius(self.modes.omega * (self.t_end / n), self.modes.xi)
            radius[: self.modes.rigid] = 1.0
            found[1:][~(np.maximum.accumulate(radius) <= UNSTABLE)] = np.inf
        else:
            found[:-1] = np.inf  # with fewer of them it would be another coupled system
        return found

    def parts(self, scheme: Scheme, n: int, m: int) -> Parts:
        """Of the error with the first m modes."""
        sampled = self.exact(n, self.rows)[:, :m].sum(axis=1)
        marched = self.by_scheme(scheme, n, self.rows)[:, :m].sum(axis=1)
        true = self.reference[:, :m].sum(axis=1)
        parts = (self.left_out[:, m], marched - sampled, sampled - true)
        return Parts(*(float(np.abs(part).max()) / self.scale for part in parts))

    def stable_directly(self, scheme: Scheme, n: int) -> bool:
        """Whether all modes of the structure are stable, as far as its largest frequency tells.

        That is computed only where many frequencies, from the least on that it can be, are not all stable or all
        unstable.
        """
        dt, beyond = self.t_end / n, np.geomspace(1e-3, UNBOUNDED, 400)
        xi = self.modes.xi[[self.modes.rigid, -1]] if self.modes.lanes and len(self.modes) > self.modes.rigid else [0.0]
        if all((scheme.spectral_radius(beyond, x) <= UNSTABLE).all() for x in xi):
            return True
        if self._least_top is not None:
            omega = np.geomspace(self._least_top, max(UNBOUNDED / dt, self._least_top), 400)
            ratios = self._ratios_beyond(omega)
            stable = scheme.spectral_radius(np.minimum(omega * dt, UNBOUNDED), ratios) <= UNSTABLE
            if stable.all() or not stable.any():
                return bool(stable[0])
        omega, own = self._top
        return bool(scheme.spectral_radius(min(omega * dt, UNBOUNDED), own) <= UNSTABLE)

    @cached_property
    def _least_top(self) -> float | None:
        """What the largest frequency (rad/s) is not below: Rayleigh's quotient of a degree of freedom moving alone.

        None where the largest one needs no computation, or damping beyond the known modes is not known without it.
        """
        whole = self.modes.structure
        known = whole.C is None or isinstance(whole.C, Rayleigh | LowRank)
        if not known or len(whole.massless) or len(self.modes) == whole.size:
            return None
        return float(np.sqrt((whole.K.diagonal() / whole.M.diagonal()).max()))

    def _ratios_beyond(self, omega: Array) -> Array:
        """Damping ratios (P,) of modes beyond the known ones at frequencies (P,), rad/s."""
        C = self.modes.structure.C
        return np.maximum(0.5 * (C.alpha / omega + C.beta * omega), 0.0) if isinstance(C, Rayleigh) else 0.0 * omega

    @cached_property
    def _top(self) -> tuple[float, float]:
        whole = self.modes.structure
        if len(whole.massless):
            return np.inf, 0.0
        if len(self.modes) == whole.size and self.modes.lanes:
            return float(self.modes.omega[-1]), float(self.modes.xi[-1])
        omega, shape = largest_mode(whole)
        return omega, max(0.0, 0.5 * float(shape @ (whole.damping @ shape)) / omega) if omega > 0.0 else 0.0


def _most(flexibility: float, squared: float, omega: Array, missed: Array) -> float:
    """The most that modes with these sums of f^2/omega^2 and f^2/omega^4 can miss, if one at omega misses that share.

    That is the flexibility times the concave hull of `missed` over x = 1/omega^2, at their mean; Jensen's inequality.
    Modes beyond the largest omega are taken to miss what that one does.
    """
    if flexibility == 0.0:
        return 0.0
    x, y = np.append(1.0 / omega**2, 0.0), np.append(missed, missed[-1])
    mean = min(squared / flexibility, x[0])
    right, left = x >= mean, x <= mean
    width = x[right][:, None] - x[left]
    share = np.divide(mean - x[left], width, out=np.zeros_like(width), where=width > 0.0)
    return flexibility * float((y[left] + share * (y[right][:, None] - y[left])).max())
