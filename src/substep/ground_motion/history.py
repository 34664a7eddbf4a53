"""A response spectrum that knows its record, and the history of one of its oscillators."""

from dataclasses import fields
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..core.arrays import Array
from ..core.coefficients import refuse_damping
from ..core.errors import called_as, damping_ratio, real_number
from ..core.loads import Record
from ..core.response import Response
from ..core.result_dataset import ResultDataset
from ..core.scene_by_name import scene
from ..core.schemes import Scheme
from ..marching.run import march
from .peaks import is_stable, peaks_refined, refined


class MadeFrom(NamedTuple):
    """What a spectrum is of: the record, the scheme, and whether this steps between samples where it needs to."""

    record: Record
    scheme: Scheme
    auto: bool


class SpectralResponse(Response):
    """The history of an oscillator on a moving ground: u, v, a are relative to the ground.

    outputs, and so `to_xarray`, `to_pandas` and `plot`, hold absolute_acceleration besides.
    """

    @cached_property
    def absolute_acceleration(self) -> Array:
        """-(2 xi omega v + omega^2 u) (n+1,), m/s^2: that of the mass, of which the spectrum's SA is the peak."""
        omega, xi = (self.scene.parameters[name] for name in ("omega", "xi"))
        return -(2.0 * xi * omega * self.v[:, 0] + omega**2 * self.u[:, 0])

    @cached_property
    def outputs(self) -> dict[str, Array]:
        """The absolute acceleration, by its name."""
        return {"absolute_acceleration": self.absolute_acceleration}


class Spectrum(ResultDataset):
    """The Dataset of `substep.response_spectrum`, with the history of an oscillator of any period besides.

    What xarray makes of it, as `s.sel(period=0.5)` or a file does, has the values but no longer the record.
    """

    __slots__ = ("made_from",)
    made_from: MadeFrom

    @called_as("spectrum.history(T=0.5)")
    def history(self, T: float, xi: float | None = None) -> SpectralResponse:
        """The response of the oscillator with the period T, s, any > 0, from rest, in the scheme's own steps.

        u (n+1, 1), m, v and a are relative to the ground, absolute_acceleration (n+1,), m/s^2, is that of the mass.
        Steps are those of the record, or with refine="auto" as many more as the spectrum would take at T. xi: damping
        ratio, by default that of the spectrum, if it has only one.

        Raises ValueError for a T that is not positive, for several xi of which none is chosen, for a scheme that is
        unstable at T, and where xarray has made the Dataset from another one, so that the record is not known.
        """
        made_from: MadeFrom | None = getattr(self, "made_from", None)
        if made_from is None:
            raise ValueError(
                "expected the spectrum that response_spectrum returned, got one made from it, which does not know "
                "the record; call history of the first one, with T= and xi="
            )
        record, s, auto = made_from
        omega, ratio = np.array([2.0 * np.pi / real_number("T", T, positive=True)]), self._ratio(xi)
        refuse_damping(s, ratio)
        load = refined(record, int(peaks_refined(s, omega, ratio, record).factor[0])) if auto else record
        if not is_stable(s, omega, ratio, load.dt)[0]:
            cure = "take another scheme" if auto else 'give refine="auto" to response_spectrum, or another scheme'
            raise ValueError(f"expected {s.name} to be stable at T = {T:g} s in steps of {load.dt:g} s; {cure}")
        ground = Record(load.dt, -load.samples)
        oscillator = scene(
            "linear_oscillator", omega=omega[0], xi=ratio[0], u0=0.0, v0=0.0, a0="consistent", load=ground
        )
        r = march(oscillator, s, load.dt, (len(load.samples) - 1) * load.dt)
        values: dict[str, Any] = {field.name: getattr(r, field.name) for field in fields(r)}
        return SpectralResponse(**values)

    def _ratio(self, xi: float | None) -> Array:
        """The damping ratio (1,) that was asked for, or the spectrum's own."""
        if xi is not None:
            return damping_ratio("xi", real_number("xi", xi)).reshape(1)
        own = self.xi.to_numpy()
        if own.size > 1:
            raise ValueError(f"expected xi, one of the spectrum's {own.tolist()} or any other, got none; give xi=")
        return own.reshape(1)
