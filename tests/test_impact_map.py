"""The failure map of contact: the trapezoidal rule by hand, runs together and alone, and the page of the map."""

import csv
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_constraints import TAKEN, VERIFY
from test_structure_contacts import bar
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.structures.model.contacts import Contacts
from substep.studies import failures
from substep.studies.failures import impact_bar, impact_map
from substep.studies.failures.impact_bar import COURANT, FULL_SIZE, LAWS, BarRow, Pair, fall, never_gain, row

Array = np.ndarray
PAGE = Path(__file__).parents[1] / "docs" / "contact_map.md"
MAP = PAGE.read_text(encoding="utf-8").split("## What comes out")[0]


def cells(line: str) -> list[str]:
    """Of a line of the map, but the schemes."""
    return re.split(r"(?<!\\)\|", line)[2:-1]


CELLS = {name: cells(x) for x in MAP.splitlines() if x.startswith("| `") for name in re.findall(r"`(\w+)`", x)}
QUICKLY = ("central_difference", "bdf2")  # schemes whose rows take a second or two
ROW = BarRow("bdf2", "impulse", 0.5, 20, 8, 0.0, 0.0, -0.01, 0.0, 0.02, 300.0, 3.0, 0.0)


def by_hand(n: int, courant: float, phases: int, remembered: bool) -> tuple[Array, Array]:
    """Energy and pressure (P, T) of the trapezoidal rule, which tries the floor without and then with a reaction."""
    k, h = 90.0 * n, courant * 10.0 / n / 30.0
    K = k * (2.0 * np.eye(n + 1) - np.eye(n + 1, k=1) - np.eye(n + 1, k=-1))
    K[0, 0] = K[n, n] = k
    m = 10.0 / n * np.r_[0.5, np.ones(n - 1), 0.5]
    A = np.linalg.inv(np.diag(m) + h**2 / 4.0 * K)
    energies, pressures = [], []
    for phase in (np.arange(phases) + 0.5) / phases:
        gap, u, v, a = 5.0 + 10.0 * h * phase, np.zeros(n + 1), np.full(n + 1, -10.0), np.zeros(n + 1)
        energy, pressure = [500.0], [0.0]
        for _ in range(int(np.ceil(1.25 / h))):
            ahead = u + h * v + h**2 / 4.0 * a
            z, p = -A @ K @ ahead, 0.0
            if gap + ahead[0] + h**2 / 4.0 * z[0] < 0.0:
                p = -(gap + ahead[0] + h**2 / 4.0 * z[0]) / (h**2 / 4.0 * A[0, 0])
                z = z + A[:, 0] * p
            u, v = ahead + h**2 / 4.0 * z, v + h / 2.0 * (a + z)
            a = z.copy()
            if not remembered:
                a[0] -= p / m[0]
            energy.append(0.5 * (m @ v**2 + u @ K @ u))
            pressure.append(p if remembered else p / 2.0)  # that of a step, of which only the impulse counts
        energies.append(energy)
        pressures.append(pressure)
    return np.array(energies), np.array(pressures)


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("law", ["impulse", "remembered"])
def test_the_trapezoidal_rule_by_hand(n: int, law: str) -> None:
    """Phases, energies, and what a row says of them, on bars of a few elements."""
    for courant in COURANT:
        energy, pressure = by_hand(n, courant, 8, law == "remembered")
        h = courant * 10.0 / n / 30.0
        gaps = 5.0 + 10.0 * h * (np.arange(8) + 0.5) / 8
        since = h * np.arange(energy.shape[1]) - gaps[:, None] / 10.0
        held = np.where((since > 0.05) & (since < 0.6), pressure, np.nan)
        found = row(ss.scheme("average_acceleration"), law, courant, n, 8)
        gain = energy.max(axis=1) / 500.0 - 1.0
        assert found.failed == 0.0
        assert found.gain == pytest.approx(gain.max(), rel=1e-6, abs=1e-9)
        assert found.gain_at_end == pytest.approx((energy[:, -1] / 500.0 - 1.0).max(), rel=1e-6)
        assert found.share == np.mean(gain > 1e-6)
        assert found.loss == pytest.approx(1.0 - energy[:, -1].mean() / 500.0, rel=1e-6)
        assert found.scatter == pytest.approx(np.nanstd(held, axis=1).max(), rel=1e-6)
        assert found.pressure == pytest.approx(np.nanmean(held, axis=1).mean(), rel=1e-6)
        assert found.safe == (law == "impulse")
        assert found.entered == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("law", ["impulse", "restitution 0"])
def test_bars_beside_each_other_are_the_bar_alone(law: str) -> None:
    gaps, h = 5.0 + np.array([0.1, 0.3, 0.7]), 0.9 * 10.0 / 20 / 30.0
    together = fall(ss.scheme("generalized_alpha"), law, 0.9, 20, gaps)
    for gap, (energy, pressure, above) in zip(gaps, np.moveaxis(together, 1, 0), strict=True):
        r = ss.march(bar(20, float(gap), **LAWS[law]), "generalized_alpha", dt=h, t_end=h * np.ceil(1.25 / h))
        for mine, other in ((r.energy, energy), (r.memory["floor"], pressure), (r.gaps["floor"], above)):
            assert np.allclose(mine, other, rtol=1e-7, atol=1e-7)


def test_the_mass_of_the_node_is_elsewhere() -> None:
    mass = impact_bar.bars("massless node", 10, np.array([5.0, 5.1])).M.diagonal().reshape(2, 11)
    assert np.array_equal(mass[0], mass[1])
    assert mass[0, 0] == 0.0
    assert mass[0].sum() == pytest.approx(10.0)
    assert mass[0] @ np.linspace(0.0, 10.0, 11) == pytest.approx(50.0)


def test_runs_that_fail_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each bar marches alone where one fails; here those do whose gap is more than half a step's way beyond 5."""
    march, h = impact_bar.marched, 0.9 * 10.0 / 12 / 30.0

    def fails(structure: ss.Structure, *given: Any, **options: Any) -> Any:
        r, contacts = march(structure, *given, **options), structure.contacts
        assert isinstance(contacts, Contacts)
        if contacts.gaps0.max() < 5.0 + 5.0 * h:
            return r
        memory = {name: x[:7] for name, x in r.memory.items()}
        return SimpleNamespace(t=r.t[:7], u=r.u[:7], v=r.v[:7], memory=memory, status="non_finite")

    monkeypatch.setattr(impact_bar, "marched", fails)
    found = row(ss.scheme("average_acceleration"), "impulse", 0.9, 12, 8)
    assert found.failed == 0.5
    assert found.share == 0.0
    assert not found.safe
    assert impact_map.percent(found) == "failed"


def test_what_is_not_run_says_why() -> None:
    central = ss.scheme("central_difference")
    assert row(central, "impulse", 2.0, 12, 8).refused.startswith("unstable steps of 0.0556 s")
    assert "mass at each degree of freedom" in row(central, "massless node", 0.5, 12, 8).refused
    assert row(ss.scheme("bdf3"), "impulse", 0.5, 12, 8).refused.startswith("unstable")
    assert "undetermined" in row(ss.scheme("gholampour"), "massless node", 0.5, 12, 8).refused
    for found in (row(central, "impulse", 2.0, 12, 8), row(ss.scheme("bathe"), "restitution 0", 0.5, 12, 8)):
        assert found.gain is found.failed is found.scatter is None
        assert not found.safe


def test_pairs_that_never_gain() -> None:
    rows = [replace(ROW, courant=courant) for courant in COURANT]
    other = [replace(one, scheme="park", scatter=6.0 * one.courant) for one in rows]
    gains = [replace(one, scheme="bathe", gain=0.7, share=float(one.courant == 2.0)) for one in rows]
    fails = [replace(one, law="remembered", failed=0.25) for one in rows]
    not_run = replace(ROW, scheme="newmark", failed=None, share=None)
    found = never_gain([*other, *rows, *gains, *fails, not_run])
    assert found == [Pair("bdf2", "impulse", 0.01, 0.02), Pair("park", "impulse", 0.04, 0.02)]
    said = impact_map.summary([*other, *rows])
    assert said.endswith("bdf2 with impulse (the pressure scatters by 1 %, and 2 % is lost).")
    assert impact_map.summary(gains).endswith("none.")
    assert impact_map.by_gain([*gains, *other, *rows]) == ["park", "bdf2", "bathe"]


@pytest.mark.parametrize(
    ("changed", "text"),
    [
        ({}, "0"),
        ({"gain": 2e-6, "share": 0.125}, "<.01"),
        ({"gain": 0.00726, "share": 0.5}, "0.73"),
        ({"gain": 0.0996, "share": 0.5}, "10"),
        ({"gain": 15.11, "share": 1.0}, "1511"),
        ({"failed": 0.125}, "failed"),
        ({"failed": 1.0, "gain": None, "share": None}, "failed"),
        ({"refused": "unstable steps of 1 s"}, "unstable"),
        ({"refused": "bathe does not keep the velocity"}, ""),
    ],
)
def test_cells(changed: dict[str, Any], text: str) -> None:
    assert impact_map.percent(replace(ROW, **changed)) == text


def test_the_map_is_written_and_drawn(tmp_path: Path) -> None:
    gains = dict(zip(COURANT, (0.0, 0.1, 9.0), strict=True))
    rows = [replace(ROW, law=law, courant=one, gain=g, share=g) for law in LAWS for one, g in gains.items()]
    rows[0], rows[-1] = replace(rows[0], failed=0.5), replace(rows[-1], failed=None, refused="unstable steps")
    impact_map.contact_map(tmp_path, rows)
    for kind in ("png", "svg"):
        assert (tmp_path / f"contact_map.{kind}").stat().st_size > 0
    with (tmp_path / "contact_map.csv").open(encoding="utf-8", newline="") as file:
        written = list(csv.DictReader(file))
    assert [(one["law"], one["courant"]) for one in written] == [(one.law, str(one.courant)) for one in rows]


def test_the_command_says_what_never_gains(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def battery(folder: Path, step: Callable[[list[BarRow]], object], full: bool) -> None:
        step([replace(ROW, courant=courant) for courant in COURANT])

    monkeypatch.setattr(failures, "battery", battery)
    result = CliRunner().invoke(app, ["failures", "--folder", str(tmp_path)])
    assert result.exit_code == 0
    assert "never gain energy (20 elements, 8 phases, Courant numbers 0.5, 0.9, 2.0)" in result.output
    assert "bdf2 with impulse (the pressure scatters by 1 %, and 2 % is lost)" in result.output


def numbers(cell: str) -> tuple[list[str], float, float]:
    """The gains of a cell of the page as texts, share and scatter in %."""
    gains, share, scatter = cell.split(";")
    return [text.strip(" |\\") for text in gains.split("|")], float(share), float(scatter)


@pytest.mark.parametrize("name", list(CELLS) if VERIFY else QUICKLY)
def test_the_page_is_the_study(name: str) -> None:
    """To the digits that are written, but for motions that gain much: these are chaotic, and rounding decides."""
    s = ss.scheme(name)
    rows = [row(s, law, courant, *FULL_SIZE) for law in LAWS for courant in COURANT]
    line = impact_map.table(rows)[-1]
    for cell, other in zip(CELLS[name], cells(line), strict=True):
        if ";" not in other:
            assert cell.strip() == other.strip()
            continue
        (gains, share, scatter), (again, share_again, scatter_again) = numbers(cell), numbers(other)
        for text, new in zip(gains, again, strict=True):
            if text.replace(".", "").isdigit() and float(text) > 2.0:
                assert float(new) > 1.0
            else:
                assert new == text
        calm = not any(text.isdigit() and float(text) > 2.0 for text in gains)
        assert share_again == pytest.approx(share, abs=1.0 if calm else 20.0)
        assert scatter_again == pytest.approx(scatter, rel=0.05 if calm else 1.0)


def test_the_page_has_every_scheme_that_takes_contacts() -> None:
    assert set(CELLS) == {*TAKEN, "central_difference"}
