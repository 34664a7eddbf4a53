"""Inelastic spectra of other laws: against plain stepping of each oscillator with a second account of its law."""

from typing import Any

import committed_steps
import law_paths
import numpy as np
import pytest
from hysteresis import Oscillator
from law_scenes import declared
from matplotlib.figure import Figure
from test_inelastic_spectrum import DT, motion

import substep as ss
from substep.figures.inelastic_charts import inelastic_figure

PERIODS, STRENGTHS, XI, ALPHA = (0.4, 1.1), (0.8, 2.0), 0.05, 0.05
FREE = 12  # periods of free vibration after the record, in which e^-4 is left of what it swings


def stepped(law: str, T: float, strength: float) -> tuple[Any, list[Any]]:
    """u (n+1,), and what is remembered, of the record and the free vibration after it."""
    omega, ground = 2 * np.pi / T, ss.Record(DT, -motion())
    n = len(motion()) - 1 + int(FREE * T / DT)
    scheme, values, _, damping, load = declared("average_acceleration", Oscillator(omega, XI, strength), ground, {})
    spring = committed_steps.Spring(omega**2, *getattr(law_paths, law)(omega**2, strength, ALPHA))
    rows, kept = committed_steps.history(scheme, values, spring, damping, load, DT, n, 0.0, 0.0)
    return rows[:, 0], kept


def lost(T: float, strength: float, u: Any, kept: list[Any]) -> float:
    """The work of clough's force along the path, by trapezoids within each step, less what is stored at the end."""
    k, work = (2 * np.pi / T) ** 2, 0.0
    _, follow = law_paths.clough(k, strength, ALPHA)
    for x, y, memory in zip(u[:-1], u[1:], kept, strict=False):
        forces = [follow(e, memory, 0.0)[0] for e in np.linspace(x, y, 9)]
        work += (sum(forces) - 0.5 * (forces[0] + forces[-1])) * (y - x) / 8
    return work - kept[len(u) - 1][1] ** 2 / (2 * k)


@pytest.mark.matrix
@pytest.mark.usefixtures("plainly")
@pytest.mark.parametrize("law", ["isotropic_bilinear", "clough"])
def test_plain_stepping_finds_the_same(law: str) -> None:
    s = ss.inelastic_spectrum(motion(), DT, PERIODS, XI, strength=STRENGTHS, law=law, hardening=ALPHA, errors=False)
    assert s.law == law
    assert ("residual_displacement" in s) == (law == "isotropic_bilinear")
    for j, T in enumerate(PERIODS):
        for i, strength in enumerate(STRENGTHS):
            u, kept = stepped(law, T, strength)
            n, at, u_y = len(motion()), s.isel(period=j, strength=i), strength / (2 * np.pi / T) ** 2
            peak = np.abs(u[:n]).max()
            assert float(at.displacement) == pytest.approx(peak, rel=1e-11)
            assert float(at.ductility_demand) == pytest.approx(peak / u_y, rel=1e-11)
            memory = np.array(kept)
            plastic = memory[:, 0] if law == "isotropic_bilinear" else memory[:, 2] + memory[:, 4]
            way = np.sign(np.where(np.abs(flow := np.diff(plastic[:n])) > 1e-9 * u_y, flow, 0.0))
            begun = sum(x not in (0.0, y) for x, y in zip(way, [0.0, *way[:-1]], strict=True))
            assert float(at.yield_excursions) == begun > 0
            if law == "isotropic_bilinear":
                assert abs(float(at.residual_displacement) - memory[-1, 0]) <= 1e-11 * peak
                assert abs(u[-1] - memory[-1, 0]) < 0.05 * peak  # where it comes to rest
                H, kappa = ALPHA * (2 * np.pi / T) ** 2 / (1 - ALPHA), memory[n - 1, 1]
                assert float(at.hysteretic_energy) == pytest.approx(strength * kappa + H * kappa**2 / 2, rel=1e-10)
            else:
                assert float(at.hysteretic_energy) == pytest.approx(lost(T, strength, u[:n], kept), rel=1e-3)


@pytest.mark.thorough
@pytest.mark.usefixtures("plainly")
def test_strengths_of_a_ductility_and_a_huge_one() -> None:
    """With a strength that is never reached all laws are the linear spring."""
    elastic = ss.response_spectrum(motion(), DT, PERIODS, XI)
    huge = ss.inelastic_spectrum(motion(), DT, PERIODS, XI, strength=1e6, law="clough", errors=False)
    assert np.allclose(huge.displacement, elastic.displacement, rtol=1e-10, atol=0.0)
    assert not huge.hysteretic_energy.any()
    assert not huge.yield_excursions.any()
    s = ss.inelastic_spectrum(motion(), DT, PERIODS[1:], XI, ductility=3.0, law="clough")
    assert np.allclose(s.ductility_demand, 3.0, rtol=0.01)
    assert {"displacement_error", "hysteretic_energy_error"} == {name for name in s if str(name).endswith("_error")}
    r = s.history(T=PERIODS[1])
    assert np.abs(r.u).max() == pytest.approx(float(s.displacement[0]), rel=1e-12)
    assert r.energy_dissipated[-1] == pytest.approx(float(s.hysteretic_energy[0]), rel=1e-12)
    assert isinstance(inelastic_figure(s), Figure)
