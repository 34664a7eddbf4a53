"""The sentences with which the page of results opens: their numbers from steps, runs and roots of the test's own."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from oracle import amplification as stepped
from substep_thesis import found
from substep_thesis.catalogue_charts import CERTIFIED, EQUAL_COST

import substep as ss
from substep.core.schemes import Array

SETS = ((0.25, 0.5), (0.3025, 0.6), (0.36, 0.7), (0.4225, 0.8), (0.49, 0.9))  # Table 4.1
BATHE = {"gamma_t": 0.5, "beta": 0.25, "gamma": 0.5}


def damping_of(matrix: Array) -> float:
    """Numerical damping of the principal pair of eigenvalues."""
    values = np.linalg.eigvals(matrix)
    largest = max(values[values.imag > 1e-9], key=abs)
    return float(-np.log(abs(largest)) / np.angle(largest))


def damping(parameters: dict[str, float], Omega: float) -> float:
    """That of Newmark-BDF2, from one step of the textbook's equations."""
    return damping_of(np.array(stepped("newmark_bdf2", Omega, 0.0, parameters), dtype=float))


def stable(split: float, beta: float, gamma: float) -> bool:
    """Whether no spectral radius exceeds 1, at steps from small to very large ones."""
    s = ss.scheme("newmark_bdf2", gamma_t=split, beta=beta, gamma=gamma)
    return bool((s.spectral_radius(np.geomspace(1e-2, 1e6, 4000)) <= 1 + 1e-8).all())


def test_five_sentences_are_written_for_the_page(tmp_path: Path) -> None:
    names = ("stability", "low_modes", "equal_cost", "energy", "positions")
    assert tuple(sentence.__name__ for sentence in found.SENTENCES) == names
    found.write(tmp_path, [found.Found("figure_4_1", ("C4.4",), "0.28 times γ_t")])
    text = (tmp_path / "found.json").read_text(encoding="utf-8")
    assert json.loads(text) == [{"figure": "figure_4_1", "claims": ["C4.4"], "text": "0.28 times γ_t"}]


def test_how_many_are_stable() -> None:
    one = found.stability()
    sets = [stable(split, *pair) for split in (0.2, 0.4, 0.5, 0.6, 0.8) for pair in SETS]
    points = [(gamma, stable(float(t), float(gamma + Fraction(1, 2)) ** 2 / 4, float(gamma))) for t, gamma in CERTIFIED]
    good = [gamma for gamma, holds in points if holds]
    assert one.text.startswith(f"{sum(sets)} of the {len(sets)} parameter sets of chapter 4 are stable at every step")
    assert f"so are {len(good)} of {len(points)} points of the plane" in one.text
    assert one.text.endswith(f"the lowest at γ = {min(good)}.")
    assert (one.figure, one.claims) == ("stability_region", ("C4.3",))


def test_low_modes_are_damped_less_by_one_set_and_more_by_the_other() -> None:
    one, Omega = found.low_modes(), 2 * np.pi * 0.05
    for beta, gamma in SETS[:2]:
        ratio = damping({"gamma_t": 0.2, "beta": beta, "gamma": gamma}, Omega) / damping(BATHE, Omega)
        assert f"{ratio:.2g} times Bathe's with (β, γ) = ({beta:g}, {gamma:g})" in one.text
    assert (one.figure, one.claims) == ("figure_4_1", ("C4.4",))


def test_amplitude_lost_at_equal_cost() -> None:
    """Newmark-BDF2 and Bathe's scheme solve twice a step, so that 100 solves a period are 50 steps."""
    one, Omega = found.equal_cost(), 2 * np.pi / 50
    for said, values in (
        ("Newmark-BDF2 (γ = 0.6) loses ", {**BATHE, "beta": 0.3025, "gamma": 0.6}), ("Bathe's scheme ", BATHE),
    ):  # fmt: skip
        assert f"{said}{100 * (1 - np.exp(-2 * np.pi * damping(values, Omega))):.2g} %" in one.text
    lost = {}
    for name in EQUAL_COST:
        s = ss.scheme(name)
        lost[name] = -100 * np.expm1(-2 * np.pi * damping_of(s.amplification(2 * np.pi * s.balances / 100)))
    least = min(lost, key=lost.__getitem__)
    start = f"the least of {len(EQUAL_COST) + 1}, {least}, "
    assert float(one.text.partition(start)[2].removesuffix(" %.")) == pytest.approx(lost[least], rel=0.03)
    assert one.figure == "trade_off_equal_cost"


def stiff(scheme: ss.Scheme, t_end: float) -> ss.Response:
    return ss.march(ss.scene("elastic_pendulum", EA=1e10, a0=(-19.6, 0.0)), scheme, dt=0.1, t_end=t_end)


def test_energy_of_the_stiff_pendulum_grows() -> None:
    one, s = found.energy(), ss.scheme("newmark_bdf2", gamma_t=0.2, beta=0.25, gamma=0.5)
    shown, longer = stiff(s, 50.0), stiff(s, 2000.0)
    at = int(np.argmin(np.abs(longer.t - 1000.0)))
    (root,) = (x.real for x in np.roots([2, -7, 8, -2]) if abs(x.imag) < 1e-9)  # of the change a step, by hand
    assert f"at most {shown.energy.max() / shown.energy[0]:.3g} E0 in 50 s" in one.text
    assert f"{longer.energy[at] / longer.energy[0]:.2g} E0 at 1000 s" in one.text
    assert f"ends as {longer.status} at {longer.t[-1]:g} s" in one.text
    assert longer.status != "completed"
    assert one.text.endswith(f"E grows for γ_t < {root:.4g}.")
    assert (one.figure, one.claims) == ("map_newmark_bdf2_gamma_t", ("C5.4",))


def test_positions_part_from_those_of_bathe() -> None:
    one, reference = found.positions(), stiff(ss.scheme("bathe"), 50.0).u
    runs = [
        stiff(ss.scheme("newmark_bdf2", gamma_t=split, beta=beta, gamma=gamma), 50.0).u
        for split in (0.2, 0.5, 0.9)
        for beta, gamma in SETS
    ]
    apart = [np.linalg.norm(u - reference, axis=1).max() for u in runs]
    near = 0.01 * np.linalg.norm(reference[0])
    assert f"{sum(d <= near for d in apart)} of 15 sets keep within {near:.1g} m" in one.text
    assert f"others are up to {max(apart):.2g} m away" in one.text
    radii = [np.linalg.norm(u, axis=1) for u in (reference, *runs)]
    ring = max(max(abs(r.min() - radii[0].min()), abs(r.max() - radii[0].max())) for r in radii[1:])
    assert one.text.endswith(f"on one ring, to {ring:.1g} m.")
    assert (one.figure, one.claims) == ("figure_5_25", ("C5.5",))
