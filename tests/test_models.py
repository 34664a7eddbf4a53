"""The stiff pendulum, elastic or rigid: what suffices for a wished accuracy."""

from pathlib import Path

import numpy as np
import pytest

import substep as ss
from substep import models


@pytest.fixture(scope="module")
def attempts() -> list[models.Attempt]:
    return models.compare(names=("energy_momentum", "bathe"), steps=(0.1, 1e-3, 1e-4), repeats=1)


def test_the_rigid_model_is_off_by_the_stretching_it_leaves_out(attempts: list[models.Attempt]) -> None:
    """Steady rotation at L(1 + e), e = m v0^2/(EA L), turns slower by 2 e; the bar oscillates about it from e = 0."""
    L, m, v0, EA, t_end = 3.0443, 10.0, 7.72, 1e10, 30.0
    strain = m * v0**2 / (EA * L)
    expected = 2 * strain * v0 / L * t_end
    for a in attempts:
        if a.model == "rigid_pendulum":
            assert a.angle_error == pytest.approx(expected, rel=1e-2)
            assert a.energy_error < 1e-13


def test_a_scheme_converges_on_the_elastic_model(attempts: list[models.Attempt]) -> None:
    errors = {(a.scheme, a.dt): a.angle_error for a in attempts if a.model == "elastic_pendulum"}
    for name in ("energy_momentum", "bathe"):
        assert errors[name, 1e-3] / errors[name, 1e-4] == pytest.approx(100, rel=0.25)


def test_the_least_that_suffices(attempts: list[models.Attempt]) -> None:
    coarse, fine = models.cheapest(attempts, 1e-5), models.cheapest(attempts, 1e-6)
    assert coarse is not None
    assert fine is not None
    assert coarse.model == "rigid_pendulum"
    assert fine.model == "elastic_pendulum"
    assert models.cheapest(attempts, 1e-12) is None


def test_failed_runs_are_no_answer() -> None:
    (bad,) = [a for a in models.compare(names=("rk4",), steps=(0.1,), repeats=1) if a.model == "elastic_pendulum"]
    assert np.isinf([bad.angle_error, bad.energy_error]).all()
    assert models.cheapest([bad], 1e9) is None


def test_chart_and_table(attempts: list[models.Attempt], tmp_path: Path) -> None:
    models.chart(attempts, tmp_path)
    assert (tmp_path / "models.png").stat().st_size > 10_000
    assert len((tmp_path / "models.csv").read_text().splitlines()) == 1 + len(attempts)
    rows = models.operations(tmp_path)
    assert [row[0] for row in rows] == list(ss.schemes())
    assert all(rigid < elastic for _, elastic, _, rigid in rows)
    assert len((tmp_path / "operations.csv").read_text().splitlines()) == 1 + len(rows)
