"""Response spectrum analysis: peaks of modes from a response spectrum, combined by SRSS or CQC; beside the history."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from ..core.arrays import Array, named
from ..core.coefficients import refuse_damping
from ..core.errors import called_as, real_array, unknown_name
from ..core.exports import Exported
from ..core.loads import Record
from ..core.schemes import Scheme
from ..core.schemes import scheme as make_scheme
from ..run.schemes import numbers_only
from ..structures.march.refusals import require_linear
from ..structures.model.given import Dof
from ..structures.modes.superposition import coordinates
from ..structures.structure import Modes
from .peaks import peaks_at_samples, relative
from .spectrum import record_of

if TYPE_CHECKING:
    from xarray import Dataset

Spectrum = Callable[[Array, Array], ArrayLike]
RULES = ("srss", "cqc")
LONG = {
    "u": "displacement relative to the base",
    "a": "absolute acceleration",
    "shear": "force on the base along the direction",
}


@dataclass(frozen=True, eq=False, repr=False)
class SpectrumAnalysis(Exported):
    """Peaks of a structure on a moving base, estimated from those of its modes.

    dofs: the k degrees of freedom. modal_u, modal_a (m, k): peak of each mode, with the sign of its shape, of the
    displacement relative to the base and of the absolute acceleration, omega^2 times the displacement. modal_shear
    (m,): peak of the force on the base along the direction, effective mass times spectral acceleration. correlation
    (m, m): of the modes' peaks, by which they are combined; the identity for SRSS.
    """

    axes: ClassVar = {
        **{"dofs": ("dofs",), "u": ("dofs",), "a": ("dofs",), "shear": (), "modal_shear": ("mode",)},
        **{"modal_u": ("mode", "dofs"), "modal_a": ("mode", "dofs"), "correlation": ("mode", "other")},
    }

    modes: Modes
    dofs: tuple[Dof, ...]
    modal_u: Array
    modal_a: Array
    modal_shear: Array
    correlation: Array

    def combined(self, modal: ArrayLike) -> Array:
        """The peak of any quantity that is linear in the displacements, from its signed peak in each mode (m, ...).

        A drift between two storeys, for example, is to be combined from the modes' drifts, not from combined
        displacements. Raises ValueError for another number of modes.
        """
        peaks = real_array("modal peaks", modal)
        if peaks.shape[:1] != (len(self.modes),):
            raise ValueError(f"expected a peak of each of {len(self.modes)} modes along axis 0, got {peaks.shape}")
        squares = np.einsum("i...,ij,j...->...", peaks, self.correlation, peaks)
        return np.sqrt(np.maximum(squares, 0.0))

    def __repr__(self) -> str:
        return f"SpectrumAnalysis({len(self.modes)} modes, {len(self.dofs)} degrees of freedom, shear {self.shear:.6g})"

    @property
    def u(self) -> Array:
        """Peak displacements relative to the base (k,)."""
        return self.combined(self.modal_u)

    @property
    def a(self) -> Array:
        """Peak absolute accelerations (k,), without the share of modes that are not there."""
        return self.combined(self.modal_a)

    @property
    def shear(self) -> float:
        """Peak force on the base along the direction."""
        return float(self.combined(self.modal_shear))


@called_as('response_spectrum_analysis(modes, "motion.AT2", direction)')
def response_spectrum_analysis(
    modes: Modes,
    spectrum: ArrayLike | str | Path | Record | Dataset | Spectrum,
    direction: ArrayLike,
    *,
    combine: Literal["srss", "cqc"] = "cqc",
    dofs: Iterable[Dof] | None = None,
    dt: float | None = None,
    scheme: str | Scheme = "average_acceleration",
) -> SpectrumAnalysis:
    """Estimate the peaks of a structure whose base moves along a direction, from those of its modes.

    spectrum: a record of the base's acceleration as `substep.response_spectrum` takes it, with dt and scheme, whose
    spectral displacement is then that of each mode's own period and damping ratio; or a function of periods (m,), s,
    and damping ratios (m,) to pseudo-accelerations (m,), such as that of a code; or a Dataset of `response_spectrum`,
    interpolated linearly in log period at its damping ratio, which has to be that of the modes. direction: as in
    `Structure.ground_motion`. combine: "srss", for modes whose periods lie well apart, or "cqc" (A. Der Kiureghian, A
    response spectrum method for random vibration analysis of MDF systems, Earthq. Eng. Struct. Dyn. 9, 419-435, 1981).
    dofs: names or numbers, all by default.

    The ground motion alone moves the structure: its own loads and its start are left out. Raises ValueError for rigid
    modes, for modes that damping couples, for those of an internal force, for an unknown rule, and for a spectrum that
    does not give them all.

    >>> frame = ss.structure(np.eye(2), [[50.0, -20.0], [-20.0, 20.0]], C=ss.modal_damping(0.05, modes=2))
    >>> found = ss.response_spectrum_analysis(frame.modes(2), lambda T, xi: 2.0 / T, [1.0, 1.0])
    >>> found.u.round(3)
    array([0.063, 0.121])
    """
    if combine not in RULES:
        raise unknown_name("a rule of combination", str(combine), RULES)
    require_linear(modes.structure, "response spectrum analysis")
    if modes.rigid:
        raise ValueError(f"expected modes with a period, got {modes.rigid} rigid ones; support the structure")
    if not modes.lanes:
        raise ValueError(
            f"expected damping that does not couple the modes, got a modal damping matrix with {modes.coupling:.1e} "
            "of its largest entry off its diagonal; take modes.damped(modes.xi) to leave that out, or march the modes"
        )
    displacement = _displacements(modes, spectrum, dt, scheme)
    whole = modes.structure
    kept = whole.kept(dofs)
    participation = modes.participation(direction)
    u = (participation.factors * displacement)[:, None] * modes.shapes[[whole.place(dof) for dof in kept]].T
    acceleration = modes.omega**2
    shear = participation.effective_mass * acceleration * displacement
    correlation = np.eye(len(modes)) if combine == "srss" else cqc_correlation(modes.omega, modes.xi)
    return SpectrumAnalysis(modes, tuple(kept), u, acceleration[:, None] * u, shear, correlation)


@called_as('spectrum_beside_history(modes, "motion.AT2", direction)')
def spectrum_beside_history(
    modes: Modes,
    record: ArrayLike | str | Path | Record,
    direction: ArrayLike,
    *,
    dofs: Iterable[Dof] | None = None,
    dt: float | None = None,
    scheme: str | Scheme = "average_acceleration",
) -> Dataset:
    """Peaks of a structure whose base moves by a record, by SRSS and by CQC, beside those of its time history.

    The arguments are those of `response_spectrum_analysis`; the history is the superposition of the same modes by the
    same scheme in steps of the record, from its first sample to its last. Returns a Dataset over "way", history, srss
    and cqc: u (way, dof), displacements relative to the base, a (way, dof), absolute accelerations, shear (way), the
    force on the base along the direction. u_difference, a_difference and shear_difference, over the same ways, are
    relative to the history, 0 there. Raises ValueError as `response_spectrum_analysis` does.

    >>> frame = ss.structure(np.eye(2), [[50.0, -20.0], [-20.0, 20.0]], C=ss.modal_damping(0.05, modes=2))
    >>> shaken = np.sin(3.0 * np.arange(0.0, 10.0, 0.02))  # m/s^2
    >>> found = ss.spectrum_beside_history(frame.modes(2), shaken, [1.0, 1.0], dt=0.02)
    >>> [round(float(x), 3) for x in found.shear_difference]  # of history, srss, cqc
    [0.0, -0.01, -0.01]
    """
    from ..core.result_dataset import ResultDataset  # noqa: PLC0415 (loads xarray)

    motion = record_of(record, dt)
    cqc = response_spectrum_analysis(modes, motion, direction, dofs=dofs, scheme=scheme)
    at_rest = replace(modes.structure, loads=(), motions=(), u0=0.0 * modes.structure.u0, v0=0.0 * modes.structure.v0)
    moved = replace(at_rest, a0_given=None).ground_motion(motion, direction)
    shaken = replace(modes, structure=moved, known_statics=None)
    t_end = (len(motion.samples) - 1) * motion.dt
    r = shaken.march(scheme, dt=motion.dt, t_end=t_end, dofs=cqc.dofs, account=False)
    forces = modes.participation(direction).factors * modes.omega**2
    shear = coordinates(shaken, scheme, motion.dt, t_end)[:, 0] @ forces
    ways = [replace(cqc, correlation=np.eye(len(modes))), cqc]
    peaks = {
        "u": [np.abs(r.u).max(axis=0), *(way.u for way in ways)],
        "a": [np.abs(r.absolute_a).max(axis=0), *(way.a for way in ways)],
        "shear": [np.abs(shear).max(), *(way.shear for way in ways)],
    }
    variables: dict[str, Any] = {}
    for name, rows in peaks.items():
        values = np.array(rows)
        dims = ("way", "dof")[: values.ndim]
        variables[name] = named(dims, values, {"long_name": f"peak {LONG[name]}"})
        text = {"long_name": f"relative difference of the peak {LONG[name]} from that of the history", "units": "1"}
        variables[f"{name}_difference"] = named(dims, relative(values, values[0]), text)
    dof = np.array(cqc.dofs, dtype=object if modes.structure.names else np.int64)
    coordinates_of = {"way": named("way", np.array(["history", *RULES]), {}), "dof": named("dof", dof, {})}
    return ResultDataset(variables, coordinates_of, {"scheme": make_scheme(scheme).name, "dt": motion.dt})


def cqc_correlation(omega: Array, xi: Array) -> Array:
    """Correlation (m, m) of modes' peaks under wide-band motion: Der Kiureghian 1981, (19).

    Modes without damping are correlated only with themselves.
    """
    r, own, other = omega[:, None] / omega, xi[:, None], xi
    above = 8.0 * np.sqrt(own * other) * (other + r * own) * r**1.5
    below = (1.0 - r**2) ** 2 + 4.0 * own * other * r * (1.0 + r**2) + 4.0 * (own**2 + other**2) * r**2
    same = np.eye(len(omega), dtype=bool) | (below == 0.0)
    return np.where(same, np.where(r == 1.0, 1.0, 0.0), above / np.where(same, 1.0, below))


def _displacements(modes: Modes, spectrum: Any, dt: float | None, scheme: str | Scheme) -> Array:
    """Spectral displacement of each mode (m,)."""
    if hasattr(spectrum, "pseudo_acceleration"):
        return _interpolated(modes, spectrum)
    if callable(spectrum) and not isinstance(spectrum, Record):
        found = cast("Spectrum", spectrum)(modes.periods, modes.xi)
        given = real_array("pseudo-accelerations of the spectrum", found)
        if given.shape != modes.omega.shape or (given < 0.0).any():
            raise ValueError(
                f"expected a pseudo-acceleration >= 0 for each of {len(modes)} modes, got shape {given.shape}"
                + (f" and {given.min():g}" if given.size else "")
            )
        return given / modes.omega**2
    load, s = record_of(spectrum, dt), numbers_only(scheme, "call once for each")
    refuse_damping(s, modes.xi)
    peaks = peaks_at_samples(s, modes.omega, modes.xi, load, errors=False).found[0]
    if not np.isfinite(peaks).all():
        bad = int(np.argmin(np.isfinite(peaks)))
        raise ValueError(
            f"expected a scheme that is stable for all modes at the record's step of {load.dt:g} s, got "
            f"{s.name}, which is not at the period {modes.periods[bad]:.3g} s; take one that is, or fewer modes"
        )
    return peaks


def _interpolated(modes: Modes, spectrum: Dataset) -> Array:
    given, xi = spectrum.period.to_numpy(), np.atleast_1d(spectrum.xi.to_numpy())
    if len(xi) != 1 or not np.allclose(modes.xi, xi[0], rtol=1e-6, atol=1e-12):
        raise ValueError(
            f"expected the spectrum at the modes' damping ratios, {modes.xi.min():.4g} to {modes.xi.max():.4g}, "
            f"got one at {xi.tolist()}; give the record, or modes.damped({xi[0]:g})"
        )
    order = np.argsort(given)[np.count_nonzero(given == 0.0) :]  # without the ground itself
    low, high = given[order].min(initial=np.inf), given[order].max(initial=0.0)
    if modes.periods.min() < low or modes.periods.max() > high:
        raise ValueError(
            f"expected a spectrum from {modes.periods.min():.3g} to {modes.periods.max():.3g} s, got one "
            + (f"from {low:g} to {high:g} s" if order.size else "of the ground alone")
            + "; compute it there, or give the record"
        )
    values = np.squeeze(spectrum.displacement.to_numpy())
    return np.interp(np.log(modes.periods), np.log(given[order]), np.atleast_1d(values)[order])
