"""Energy under changing steps: against plain steps of the same lengths, and what the verdicts on symplecticity say."""

from pathlib import Path

import numpy as np
import pytest

import substep as ss
from substep.studies import energy_charts
from substep.studies.energy_charts import SCHEMES, drift, nature

pytestmark = pytest.mark.usefixtures("uncompiled")
flexible = ss.scene("elastic_pendulum", EA=1e4)
TIMES = np.linspace(0.5, 40.0, 80)


def leapfrog(steps: np.ndarray) -> np.ndarray:
    """|E/E0 - 1| at the end of each step of the central difference method, written as its textbook form."""
    EA, L, m, v0 = 1e4, 3.0443, 10.0, 7.72
    u, v = np.array([L, 0.0]), np.array([0.0, v0])

    def force(u: np.ndarray) -> np.ndarray:
        return EA * (u @ u - L**2) / (2 * L**3) * u

    a, errors = -force(u) / m, []
    for h in steps:
        half = v + h / 2 * a
        u = u + h * half
        a = -force(u) / m
        v = half + h / 2 * a
        energy = m * (v @ v) / 2 + EA * L * ((u @ u - L**2) / (2 * L**2)) ** 2 / 2
        errors.append(abs(energy / (m * v0**2 / 2) - 1))
    return np.array(errors)


def test_the_energy_is_that_of_the_same_steps_taken_by_hand() -> None:
    r = ss.march(flexible, "central_difference", t_end=4.0, tol=1e-4)
    found = drift(flexible, "central_difference", 1e-4, np.array([1.0, 4.0]))
    steps = np.diff(r.t)
    assert found.steps == len(steps)
    uneven, even = leapfrog(steps), leapfrog(np.full(len(steps), 4.0 / len(steps)))
    first = np.searchsorted(r.t, 1.0, side="right") - 1
    np.testing.assert_allclose(found.chosen, [uneven[:first].max(), uneven.max()], rtol=1e-8)
    np.testing.assert_allclose(found.constant[1], even.max(), rtol=1e-8)


@pytest.mark.parametrize("name", ["central_difference", "fox_goodwin", "silva_bezerra"])
def test_what_is_symplectic_loses_its_energy_in_chosen_steps_alone(name: str) -> None:
    found = drift(flexible, name, 1e-4, TIMES)
    chosen, constant = (x[-1] / x[4] for x in (found.chosen, found.constant))
    assert chosen > 3
    if nature(name) == "not symplectic":
        assert constant > 1.5
    else:
        assert constant == pytest.approx(1.0, abs=0.03)
        assert found.chosen[-1] > 5 * found.constant[-1]


def test_natures_are_those_derived() -> None:
    assert [nature(name) for name in (*SCHEMES, "fox_goodwin", "average_acceleration", "rk4")] == [
        *("symplectic", "not symplectic", "conjugate symplectic", "conjugate symplectic", "not symplectic"),
    ]


def test_the_chart_and_its_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(energy_charts, "MARKS", np.linspace(0.5, 5.0, 10))
    monkeypatch.setattr(energy_charts, "TOL", 1e-4)
    energy_charts.energy_under_changing_steps(tmp_path)
    rows = (tmp_path / "energy_under_changing_steps.csv").read_text().splitlines()
    assert len(rows) == 11
    last = drift(flexible, SCHEMES[0], 1e-4, energy_charts.MARKS)
    assert [float(x) for x in rows[-1].split(",")][:3] == [5.0, last.chosen[-1], last.constant[-1]]
    assert (tmp_path / "energy_under_changing_steps.png").stat().st_size > 10_000
