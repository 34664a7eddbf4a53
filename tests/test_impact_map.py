"""The failure map of contact: the trapezoidal rule by hand, runs together and alone, and the page of the map."""

import csv
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import product
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
from substep.studies.failures.impact_bar import (
    COURANT,
    FULL_BOUNCES,
    FULL_SIZE,
    GRAVITY,
    LAWS,
    BarRow,
    Pair,
    fall,
    never_gain,
    row,
)

Array = np.ndarray
PAGE = Path(__file__).parents[1] / "docs" / "contact_map.md"
*MAPS, ALONE = PAGE.read_text(encoding="utf-8").split("## What comes out")[0].split("\n## ")
BESIDE = PAGE.with_name("constraints_and_contact.md").read_text(encoding="utf-8")


def cells(line: str) -> list[str]:
    """Of a line of the map, but the schemes."""
    return re.split(r"(?<!\\)\|", line)[2:-1]


def lines(page: str, size: int) -> list[str]:
    """Of a page those of tables with so many columns beside the schemes."""
    return [x for x in page.splitlines() if x.startswith("| `") and len(cells(x)) == size]


def shown() -> dict[float, dict[str, list[str]]]:
    """The cells of the page by gravity and scheme; those that take the penalty alone have a table of their own."""
    found: dict[float, dict[str, list[str]]] = {}
    for i, (gravity, page) in enumerate(zip(GRAVITY, MAPS, strict=True)):
        every = [(x, cells(x)) for x in lines(page, len(LAWS))]
        every += [(x, ["–"] * (len(LAWS) - 1) + [cells(x)[i]]) for x in lines(ALONE, 2) if cells(x)[i].strip()]
        found[gravity] = {name: own for x, own in every for name in re.findall(r"`(\w+)`", x)}
    return found


CELLS = shown()
QUICKLY = ((0.0, "central_difference"), (0.0, "bdf2"), (10.0, "central_difference"))  # which take seconds
ROW = BarRow("bdf2", "impulse", 0.5, 20, 8, 0.0, 0.0, 0.0, -0.01, 0.0, 0.02, 300.0, 3.0, 0.0)


def by_hand(n: int, courant: float, phases: int, law: str, gravity: float) -> tuple[Array, Array, Array]:
    """Energy, pressure and gap (P, T) of the trapezoidal rule, which tries the floor without and then with a reaction.

    Without gravity the bar falls with the velocity 10, with it from rest.
    """
    k, h = 90.0 * n, courant * 10.0 / n / 30.0
    K = k * (2.0 * np.eye(n + 1) - np.eye(n + 1, k=1) - np.eye(n + 1, k=-1))
    K[0, 0] = K[n, n] = k
    m = 10.0 / n * np.r_[0.5, np.ones(n - 1), 0.5]
    sprung = K + k * np.outer(np.eye(n + 1)[0], np.eye(n + 1)[0])  # the floor is as stiff as an element
    A, A_sprung = (np.linalg.inv(np.diag(m) + h**2 / 4.0 * x) for x in (K, sprung))
    energies, pressures, gaps = [], [], []
    for phase in (np.arange(phases) + 0.5) / phases:
        first = 5.0 * (1.0 + h * phase) ** 2 if gravity else 5.0 + 10.0 * h * phase
        u, v, a = np.zeros(n + 1), np.full(n + 1, 0.0 if gravity else -10.0), np.full(n + 1, -gravity)
        energy, pressure, gap = [10.0 * gravity * first + 5.0 * v @ v / (n + 1)], [0.0], [first]
        for _ in range(int(np.ceil((16.0 / 3.0 if gravity else 1.25) / h))):
            ahead = u + h * v + h**2 / 4.0 * a
            z, p = -A @ (K @ ahead + gravity * m), 0.0
            inside = -(first + ahead[0] + h**2 / 4.0 * z[0])
            if inside > 0.0 and law == "penalty":
                z = -A_sprung @ (sprung @ ahead + gravity * m + k * first * np.eye(n + 1)[0])
                p = -k * (first + ahead[0] + h**2 / 4.0 * z[0])
            elif inside > 0.0:
                p = inside / (h**2 / 4.0 * A[0, 0])
                z = z + A[:, 0] * p
            u, v = ahead + h**2 / 4.0 * z, v + h / 2.0 * (a + z)
            a = z.copy()
            if law == "impulse":
                a[0] -= p / m[0]
            stored = p**2 / (2.0 * k) if law == "penalty" else 0.0
            energy.append(0.5 * (m @ v**2 + u @ K @ u) + gravity * (m @ u + 10.0 * first) + stored)
            pressure.append(p / 2.0 if law == "impulse" else p)  # that of a step, of which only the impulse counts
            gap.append(first + u[0])
        energies.append(energy)
        pressures.append(pressure)
        gaps.append(gap)
    return np.array(energies), np.array(pressures), np.array(gaps)


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("gravity", GRAVITY)
@pytest.mark.parametrize("law", ["impulse", "remembered", "penalty"])
def test_the_trapezoidal_rule_by_hand(n: int, gravity: float, law: str) -> None:
    """Phases, energies, and what a row says of them, on bars of a few elements."""
    for courant in COURANT:
        energy, pressure, gap = by_hand(n, courant, 8, law, gravity)
        h = courant * 10.0 / n / 30.0
        t = h * np.arange(energy.shape[1])
        since = t - (1.0 if gravity else 0.5) - h * (np.arange(8)[:, None] + 0.5) / 8
        exact = 300.0 * (t if gravity else np.ones_like(t))
        held = np.where((since > 0.05) & (since < 0.6), pressure - exact, np.nan)
        found = row(ss.scheme("average_acceleration"), law, courant, n, 8, gravity)
        gain = energy / energy[:, :1] - 1.0
        assert found.failed == 0.0
        assert found.gain == pytest.approx(gain.max(), rel=1e-6, abs=1e-9)
        assert found.gain_at_end == pytest.approx(gain[:, -1].max(), rel=1e-6)
        assert found.share == np.mean(gain.max(axis=1) > 1e-6)
        assert found.loss == pytest.approx(-gain[:, -1].mean(), rel=1e-6)
        assert found.scatter == pytest.approx(np.nanstd(held, axis=1).max(), rel=1e-6)
        assert found.pressure == pytest.approx(300.0 + np.nanmean(held, axis=1).mean(), rel=1e-6)
        assert found.safe == (found.share == 0.0)
        assert found.safe or law != "impulse"
        assert found.entered == pytest.approx(-gap.min(), abs=1e-9)


@pytest.mark.parametrize("law", ["impulse", "restitution 0"])
def test_bars_beside_each_other_are_the_bar_alone(law: str) -> None:
    gaps, h = 5.0 + np.array([0.1, 0.3, 0.7]), 0.9 * 10.0 / 20 / 30.0
    together = fall(ss.scheme("generalized_alpha"), law, 0.9, 20, gaps)
    for gap, (energy, pressure, above) in zip(gaps, np.moveaxis(together, 1, 0), strict=True):
        r = ss.march(bar(20, float(gap), **LAWS[law]), "generalized_alpha", dt=h, t_end=h * np.ceil(1.25 / h))
        for mine, other in ((r.energy, energy), (r.memory["floor"], pressure), (r.gaps["floor"], above)):
            assert np.allclose(mine, other, rtol=1e-7, atol=1e-7)


def exact_bounces(t: Array) -> tuple[Array, Array]:
    """Gap and pressure (T,) of the bar that is dropped from 5, in one period, of the wave equation."""
    s, late = t - 5.0 / 3.0, t - 13.0 / 3.0
    r = np.mod(s, 2.0 / 3.0)
    when = [t < 1.0, s < 0.0, s < 2.0, late < 0.0]
    gap = np.select(
        when,
        [5.0 - 5.0 * t**2, 0.0 * t, 10.0 * s - 5.0 * s**2 + 10.0 * r**2 - 20.0 / 3.0 * r, 0.0 * t],
        10.0 * late - 5.0 * late**2,
    )
    return gap, np.select(when, [0.0 * t, 300.0 * t, 0.0 * t, 500.0 - 300.0 * (t - 11.0 / 3.0)], 0.0 * t)


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("central_difference", "impulse"),
        ("average_acceleration", "restitution 0"),
        ("generalized_alpha_mixed_displacement", "massless node"),
        ("bdf2", "penalty"),
    ],
)
def test_bounces_under_gravity_are_the_exact_ones(name: str, law: str) -> None:
    """Two contacts with their times and impulses, pressure and gap over a period, no gain, and little loss."""
    n, courant = 60, 0.85
    h = courant * 10.0 / n / 30.0
    energy, p, gap = fall(ss.scheme(name), law, courant, n, np.array([5.0]), 10.0)[:, 0]
    t = h * np.arange(len(energy))
    exact_gap, exact_p = exact_bounces(t)
    assert t[-1] == pytest.approx(16.0 / 3.0, abs=h)
    for when, start in ((t < 2.5, 1.0), (t > 2.5, 11.0 / 3.0)):
        closed = t[when & (p > 0.0)]
        assert closed[0] == pytest.approx(start, abs=0.02)
        assert closed[-1] == pytest.approx(start + 2.0 / 3.0, abs=0.05)  # against a spring it takes 0.04 longer
        assert h * p[when].sum() == pytest.approx(800.0 / 3.0, rel=0.015)
    assert np.abs(p - exact_p).mean() < 0.1 * exact_p.mean()
    assert np.abs(gap - exact_gap).mean() < 0.15  # it jumps in its rate, and arrives later by some steps
    assert energy[0] == pytest.approx(500.0)
    assert energy.max() < 500.0 * (1.0 + 1e-9)
    assert energy[-1] > 0.95 * 500.0


@pytest.mark.parametrize("gravity", GRAVITY)
def test_the_default_pairs_never_gain(gravity: float) -> None:
    """Impulses under the trapezoidal rule, and the pair that the page names; what is turned round keeps its energy."""
    size = FULL_SIZE if VERIFY else (12, 32)
    for courant in COURANT:
        for name, law in (
            ("average_acceleration", "impulse"),
            ("generalized_alpha_mixed_displacement", "massless node"),
        ):
            assert row(ss.scheme(name), law, courant, *size, gravity).safe
        kept = row(ss.scheme("average_acceleration"), "restitution 1", courant, *size, gravity)
        assert kept.safe
        assert abs(kept.loss or 0.0) < 1e-9
        assert kept.scatter is not None and kept.scatter > 250.0  # it rings


def test_a_spring_at_the_node_takes_the_longest_step() -> None:
    """With that of an element a wave along the end of the bar has (omega l/c)^2 = 2 + 2 sqrt(2), above all others."""
    n = 40
    element = 10.0 / n / 30.0
    for stop, courant in ((0.0, 1.0), (1.0, np.sqrt(2.0 / (1.0 + np.sqrt(2.0))))):
        found = impact_bar._longest(ss.scheme("central_difference"), n, stop) / element
        assert found == pytest.approx(courant, rel=1e-3)
    assert row(ss.scheme("central_difference"), "penalty", 0.9, 12, 4).failed == 0.0
    assert row(ss.scheme("central_difference"), "impulse", 0.95, 12, 4).failed == 0.0
    refused = row(ss.scheme("central_difference"), "penalty", 0.95, 12, 4).refused
    assert refused == ("unstable steps of 0.0264 s on the bar against the spring: stable ones are below 0.0253 s")


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
    assert "discrete gradient" in row(ss.scheme("energy_momentum"), "penalty", 0.5, 12, 8).refused
    assert row(ss.scheme("rk4"), "penalty", 2.0, 12, 8).refused.startswith("unstable steps of 0.0556 s")
    assert "the velocity that an impact leaves" in row(ss.scheme("rk4"), "impulse", 0.5, 12, 8).refused
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
    bounces = [replace(one, gravity=10.0, loss=0.05) for one in rows]
    assert never_gain([*rows, *bounces]) == [Pair("bdf2", "impulse", 0.01, 0.05)]
    assert not never_gain([*rows, *(replace(one, share=0.5) for one in bounces)])
    idle = replace(ROW, scheme="rk2", failed=None, share=None, refused="unstable steps of 1 s")
    assert impact_map.by_gain([idle, *gains, *other, *rows]) == ["park", "bdf2", "bathe", "rk2"]


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
    rows += [replace(one, elements=10, gravity=10.0) for one in rows]
    impact_map.contact_map(tmp_path, rows)
    for name, kind in product(("contact_map", "contact_map_under_gravity"), ("png", "svg")):
        assert (tmp_path / f"{name}.{kind}").stat().st_size > 0
    with (tmp_path / "contact_map.csv").open(encoding="utf-8", newline="") as file:
        written = list(csv.DictReader(file))
    assert [(one["law"], one["courant"], one["gravity"]) for one in written] == [
        (one.law, str(one.courant), str(one.gravity)) for one in rows
    ]
    assert "(20 elements and 10 elements under gravity, 8 phases, " in impact_map.summary(rows)


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


@pytest.mark.parametrize(("gravity", "name"), [(g, name) for g in GRAVITY for name in CELLS[g]] if VERIFY else QUICKLY)
def test_the_page_is_the_study(gravity: float, name: str) -> None:
    """To the digits that are written, but for motions that gain much: these are chaotic, and rounding decides."""
    s = ss.scheme(name)
    size = FULL_BOUNCES if gravity else FULL_SIZE
    rows = [row(s, law, courant, *size, gravity) for law in LAWS for courant in COURANT]
    line = impact_map.table(rows)[-1]
    for cell, other in zip(CELLS[gravity][name], cells(line), strict=True):
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


def test_the_page_has_every_scheme() -> None:
    """Those that take contacts, and all others with the penalty, or named; the page beside it has lines of this one."""
    for own in CELLS.values():
        assert {name for name, found in own.items() if found[0].strip() != "–"} == {*TAKEN, "central_difference"}
    named = set(re.findall(r"`(\w+)`", ALONE.split("| scheme")[0]))
    assert set(CELLS[0.0]) == set(ss.schemes()) - named
    unmeasured = {name for x in lines(ALONE, 2) if not cells(x)[1].strip() for name in re.findall(r"`(\w+)`", x)}
    assert set(CELLS[10.0]) == set(ss.schemes()) - named - unmeasured
    copied = lines(BESIDE, len(LAWS))
    assert len(copied) > 8
    assert set(copied) <= set(lines(MAPS[1], len(LAWS)))


def test_energy_momentum_against_a_spring_needs_its_potential() -> None:
    """As a spring it is refused, as a force with a potential it keeps the energy of an impact."""
    n = 12
    free, gap = impact_bar.bars("impulse", n, np.array([5.0])), 5.0
    k, K, e = 90.0 * n, free.K @ np.eye(n + 1), np.eye(n + 1)[0]

    def inside(u: Array) -> float:
        return min(float(u[0]) + gap, 0.0)

    falling = ss.structure(
        free.M, v0=-10.0, internal_force=lambda u: K @ u + k * inside(u) * e,
        tangent=lambda u: K + k * (inside(u) < 0.0) * np.outer(e, e),
        potential=lambda u: 0.5 * u @ K @ u + 0.5 * k * inside(u) ** 2,
    )  # fmt: skip
    r = ss.march(falling, "energy_momentum", dt=0.9 * 10.0 / n / 30.0, t_end=1.25)
    assert r.status == "completed"
    assert r.u[:, 0].min() < -gap - 0.1
    assert np.abs(r.energy / 500.0 - 1.0).max() < 1e-11
