"""An inelastic spectrum that knows its record, and the history of one of its oscillators."""

import numpy as np

from ..core.errors import real_number
from ..core.loads import Record
from ..core.response import Response
from ..core.result_dataset import ResultDataset
from ..core.scene_by_name import scene
from ..core.scene_catalogue import WITH_LAW
from ..marching.run import march
from .yield_strengths import Asked, strengths


class InelasticSpectrum(ResultDataset):
    """The Dataset of `substep.inelastic_spectrum`, with the history of an oscillator of any period besides.

    What xarray makes of it, as `s.sel(period=0.5)` or a file does, has the values but no longer the record.
    """

    __slots__ = ("asked",)
    asked: Asked

    def history(
        self, T: float, *, ductility: float | None = None, strength: float | None = None, R_y: float | None = None
    ) -> Response:
        """The response of the oscillator with the period T, s, any > 0, from rest, in the spectrum's steps.

        u (n+1, 1), m, v and a are relative to the ground; force is the spring's, m/s^2. ductility, strength in m/s^2,
        or R_y: what is constant in the spectrum, at any value; by default the spectrum's own, if it has only one.

        Raises ValueError for what is out of range, for another of the three than that of the spectrum, where no
        strength gives the ductility, and where xarray has made the Dataset, so that the record is not known.
        """
        asked: Asked | None = getattr(self, "asked", None)
        if asked is None:
            raise ValueError(
                "expected the spectrum that inelastic_spectrum returned, got one made from it, which does not know the "
                "record; call history of the first one"
            )
        given = {"ductility": ductility, "strength": strength, "R_y": R_y}
        value = given.pop(asked.kept)
        if others := [name for name, x in given.items() if x is not None]:
            raise ValueError(f"expected {asked.kept}, which is constant in this spectrum, got {others[0]}")
        if value is None:
            if asked.values.size > 1:
                raise ValueError(f"expected {asked.kept}, one of {asked.values.tolist()} or any other, got none")
            value = asked.values.item()
        wanted = real_number(asked.kept, value, positive=True)
        if asked.kept == "ductility" and wanted < 1.0:
            raise ValueError(f"expected ductility >= 1, got {wanted:g}; 1 is the elastic spectrum")
        omega = 2.0 * np.pi / real_number("T", T, positive=True)
        found = strengths(asked._replace(values=np.array(wanted)), np.array([omega])).strength.item()
        if np.isnan(found):
            raise ValueError(
                f"expected a strength that gives {asked.kept} = {wanted:g} at T = {T:g} s, found none with "
                f"{asked.scheme.name} in steps of {asked.record.dt:g} s"
            )
        load = Record(asked.record.dt, -asked.record.samples)
        given = {"omega": omega, "xi": asked.xi, "strength": found, "hardening": asked.hardening}
        oscillator = scene(WITH_LAW, law=asked.law, **given, load=load)
        return march(oscillator, asked.scheme, load.dt, (len(load.samples) - 1) * load.dt)
