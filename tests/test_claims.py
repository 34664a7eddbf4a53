"""The ledger: every claim has its judge, its verdict is the one known, its numbers are found again by other means."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from oracle import amplification as stepped
from substep_derive import DeclarationError, InconsistentScheme, certify
from substep_derive.declare.schemes.multi_step import gholampour
from substep_derive.declare.symbols import C, gamma_t, h, knot
from substep_derive.oscillator.accuracy import leading_terms
from substep_derive.oscillator.amplification import Amplification
from substep_thesis import claims
from substep_thesis.claims import chapter_2
from substep_thesis.claims.judgement import overall
from substep_thesis.derive import findings as algebra
from substep_thesis.derive import printed
from sympy import Integer, Interval, Rational

# Verdicts and why each is the right one: textbooks, the papers, or the numbers that the tests below find again.
EXPECTED = {
    "C2.1": "true",  # Hughes, The Finite Element Method (1987), table 9.2.1
    "C2.2": "true",  # 2 sqrt 3, sqrt 6 and 2, the same table
    "C2.3": "partly",  # the frequency is; the amplitude from an initial velocity is not
    "C2.4": "true",  # 1.37 > (1 + sqrt 3)/2
    "C2.5": "partly",  # high frequencies are damped less, low ones more
    "C2.6": "partly",  # stable and of second order, but backward Euler damps more
    "C2.7": "partly",  # stable from alpha = -1/2 on, not from -1/3; less damping than Houbolt
    "C2.8": "true",  # Wood, Bossak & Zienkiewicz 1980: alpha_B <= 0
    "C2.9": "true",  # Chung & Hulbert 1993, (16), (17) and (20)
    "C2.10": "partly",  # with delta h^3; not with delta h^3/6
    "C2.11": "partly",  # of second order and dissipative, but its period error is a third larger
    "C2.12": "true",
    "C2.13": "false",  # an L-stable composite dissipates
    "C2.14": "true",  # both stationary at 2 - sqrt 2
    "C4.1": "false",  # twice the entry
    "C4.2": "true",
    "C4.3": "partly",  # all sets of the table; beta = 0 makes the first sub-step explicit
    "C4.4": "partly",  # the first set; gamma > 1/2 damps in the first order of Omega
    "C4.5": "true",
    "C4.6": "true",
    "C4.7": "partly",
    "C4.8": "true",
    "C5.1": "partly",
    "C5.2": "true",
    "C5.3": "partly",
    "C5.4": "partly",  # gamma_t = 0.2, (1/4, 1/2) gains energy on the stiff pendulum
    "C5.5": "partly",
    "C5.6": "true",
    "C6.1": "partly",
    "C6.2": "true",
    "C6.3": "partly",
    **dict.fromkeys(("M2.2", "M2.9", "M2.20", "M2.23", "M2.26", "M2.54", "Mp15", "M3.9"), "false"),
}
BATHE = {"gamma_t": 0.5, "beta": 0.25, "gamma": 0.5}
TENTH = 2 * np.pi * 0.1  # Omega at h/T = 0.1


def test_every_claim_has_one_judge() -> None:
    assert [claim.id for claim in claims.CLAIMS] == list(EXPECTED)
    judges = {claim.id: claim.judge or algebra.JUDGES[claim.id] for claim in claims.CLAIMS}
    assert {claim.id for claim in claims.CLAIMS if claim.judge is None} == set(algebra.JUDGES)
    assert len(set(judges.values())) == len(EXPECTED)
    for claim in claims.CLAIMS:
        kind, number = claim.id[0], claim.id[1:].replace(".", "_")
        assert judges[claim.id].__name__ == {"C": "claim_", "M": "misprint_"}[kind] + number
        assert claim.command.startswith("substep ")


def test_texts_do_not_depend_on_docstrings() -> None:
    code = "from substep_thesis.claims import CLAIMS; print([(c.id, c.text, c.command) for c in CLAIMS])"
    plain, stripped = (
        subprocess.run([sys.executable, *options, "-c", code], capture_output=True, text=True, check=True).stdout
        for options in ([], ["-OO"])
    )
    assert stripped == plain
    assert plain.strip() == str([(c.id, c.text, c.command) for c in claims.CLAIMS])
    assert all(len(claim.text) > 20 for claim in claims.CLAIMS)


@pytest.fixture(scope="module")
def ledger() -> dict[str, claims.Judgement]:
    return {j.id: j for j in claims.judge()}


def test_verdicts(ledger: dict[str, claims.Judgement]) -> None:
    assert {key: j.verdict for key, j in ledger.items()} == EXPECTED


def test_the_ledger_is_written_as_judged(ledger: dict[str, claims.Judgement], tmp_path: Path) -> None:
    claims.write(tmp_path, list(ledger.values()))
    read = json.loads((tmp_path / "claims.json").read_text())
    assert [entry["id"] for entry in read] == list(EXPECTED)
    assert all(entry == ledger[entry["id"]].as_dict() for entry in read)
    assert all(entry["claim"] == c.text for entry, c in zip(read, claims.CLAIMS, strict=True))
    page = (tmp_path / "claims.md").read_text()
    for j in ledger.values():
        assert f"## {j.id}: {j.verdict}\n\nClaim: {j.claim}\n\nFound: {j.evidence}.\n\nSee: `{j.command}`" in page


def errors(name: str, parameters: dict[str, float], Omega: float = TENTH) -> tuple[float, float]:
    """(numerical damping, period error) of an undamped step of the textbook's equations, from its eigenvalues."""
    values = np.linalg.eigvals(np.array(stepped(name, Omega, 0.0, parameters), dtype=float))
    pairs = values[values.imag > 1e-9]
    largest = pairs[np.abs(pairs).argmax()]
    phi = np.angle(largest)
    return float(-np.log(abs(largest)) / phi), float(Omega / phi - 1)


def shown(value: float) -> str:
    return f"{value:.4g}"


@pytest.mark.parametrize(
    ("key", "name", "parameters"),
    [
        ("C2.6", "houbolt", {}),
        ("C2.6", "backward_euler", {}),
        ("C2.7", "hht_alpha", {"alpha": -1 / 3}),
    ],
)
def test_numbers_of_chapter_2(
    ledger: dict[str, claims.Judgement], key: str, name: str, parameters: dict[str, float]
) -> None:
    for value in errors(name, parameters):
        assert f" {shown(value)}" in ledger[key].evidence


def test_houbolt_is_held_against_backward_euler(ledger: dict[str, claims.Judgement]) -> None:
    """It damps less than backward Euler at every h/T looked at, and from some on has more period error."""
    evidence = ledger["C2.6"].evidence
    assert "backward_euler's at 40 of 40 h/T" in evidence
    mine, other = (
        [errors(name, {}, 2 * np.pi * 0.005 * k)[1] for k in range(1, 41)] for name in ("houbolt", "backward_euler")
    )
    count = sum(o >= m for m, o in zip(mine, other, strict=True))
    assert 0 < count < 40
    assert f"backward_euler's at {count} of 40 h/T" in evidence
    assert all(name in evidence for name in chapter_2.OTHERS)


def test_numbers_of_wilson_and_gholampour(ledger: dict[str, claims.Judgement]) -> None:
    thetas = (2.0, 2.5, 3.0, 5.0)
    damping, period = zip(*(errors("wilson_theta", {"theta": t}) for t in thetas), strict=True)
    for values in (damping, period):
        assert "(" + ", ".join(map(shown, values)) + ")" in ledger["C2.5"].evidence
    fifth = 2 * np.pi * 0.2
    own = errors("gholampour", {"delta": 0.4, "alpha_g": 0.22}, fifth)[1]
    trapezoid = errors("newmark", {"beta": 0.25, "gamma": 0.5}, fifth)[1]
    assert f"average_acceleration {own / trapezoid:.3f}" in ledger["C2.11"].evidence


def test_numbers_of_the_composites(ledger: dict[str, claims.Judgement]) -> None:
    lost = [
        1 - np.exp(-2 * np.pi * errors("newmark_bdf2", {**BATHE, "gamma_t": split})[0])
        for split in (0.2, 0.4, 0.5, 0.6, 0.8)
    ]
    assert "(" + ", ".join(map(shown, lost)) + ")" in ledger["C2.13"].evidence
    most = errors("newmark_bdf2", {"gamma_t": 0.8, "beta": 0.49, "gamma": 0.9})[0]
    assert f"{most:.4g} and {20 / 49:.4g}" in ledger["C4.5"].evidence  # |c_n| of the limit by hand: 20/49
    at_20 = 2 * np.pi * 0.05
    mine, bathe = (
        errors("newmark_bdf2", values, at_20)[0] for values in ({"gamma_t": 0.2, "beta": 0.3025, "gamma": 0.6}, BATHE)
    )
    assert f"{mine:.3g} at h/T = 0.05 (Bathe {bathe:.3g})" in ledger["C4.4"].evidence
    fifth = 2 * np.pi * 0.2
    for split in (0.2, 0.4):
        ratio = errors("newmark_bdf2", {**BATHE, "gamma_t": split}, fifth)[1] / errors("newmark_bdf2", BATHE, fifth)[1]
        assert f"gamma_t = {split:g}: (0.25, 0.5) " in ledger["C4.7"].evidence
        assert f"..{ratio:.3f}, (0.3025, 0.6)" in ledger["C4.7"].evidence


def test_exact_facts_of_the_literature(ledger: dict[str, claims.Judgement]) -> None:
    for key, facts in {
        "C2.1": ("2*beta >= gamma and gamma >= 1/2", "((2*gamma - 1)/4) Omega"),
        "C2.2": ("linear_acceleration: Omega_cr = 2*sqrt(3)", "fox_goodwin: Omega_cr = sqrt(6)", "Omega_cr = 2"),
        "C2.3": ("of order 4", "orders (2, 2, 2)"),
        "C2.4": ("1/2 + sqrt(3)/2", "2*r**2 - 2*r - 1", "stable True, at 1e-6 less False"),
        "C2.7": ("Interval(-1/2, 0), claimed: Interval(-1/3, 0)", "order of u, v, a (2, 2, 1)", "U0-V1"),
        "C2.8": ("stable everywhere", "alpha_B <= 0"),
        "C2.9": ("stable everywhere", "newmark: True, hht_alpha: True, wbz_alpha: True"),
        "C2.10": ("stable everywhere", "unstable everywhere", "6*delta >= 6*alpha_g + 1", "the region itself: True"),
        "C2.14": ("least at gamma_t = 2 - sqrt(2) = 0.585786", "greatest at gamma_t = 2 - sqrt(2) = 0.585786"),
        "C4.1": ("is 2 for all",),
        "C4.3": ("25 of 25", "gamma_t = 1/5, beta = 0, gamma = 1/2 only up to", "gamma >= 1/2 and"),
        "M2.2": ("1/6",),
        "M2.9": ("(4, 4, 4) at t + h",),
        "M2.20": ("False as printed, True corrected",),
        "M2.23": ("False as printed, True corrected",),
        "M2.26": ("beta = 1/4",),
        "M2.54": ("as printed: unstable everywhere", "with delta h^3: stable everywhere"),
        "Mp15": ("printed: 1 - gamma_t steps", "an end 1 step after t_n"),
    }.items():
        for fact in facts:
            assert fact in ledger[key].evidence, key


def test_numbers_of_chapters_5_and_6_are_of_a_size(ledger: dict[str, claims.Judgement]) -> None:
    """What single runs of march settle is tested in test_chapter_5; here shares and counts that must be possible."""
    for key in (k for k in EXPECTED if k[:2] in ("C5", "C6")):
        counts = re.findall(r"(\d+) of (\d+)", ledger[key].evidence)
        assert all(int(part) <= int(whole) for part, whole in counts), key
    assert "for 21 of 25 (case, step, set)" in ledger["C5.1"].evidence
    assert "for 15 of 15 (case, step, gamma_t)" in ledger["C5.2"].evidence
    assert "newton_failed" in ledger["C5.4"].evidence
    assert "in 12 of 12 panels" in ledger["C5.6"].evidence
    assert "both: 1: gamma_t = 0.6 (0.25, 0.5)" in ledger["C6.2"].evidence


def test_the_explicit_limit_of_any_combination(ledger: dict[str, claims.Judgement]) -> None:
    """C4.3's exact limit: the spectral radius of the stepped equations passes 1 there."""
    found = re.search(r"only up to Omega = ([^;]*)", ledger["C4.3"].evidence)
    assert found
    limit = float(mpmath.sqrt(2) * mpmath.sqrt(85 - mpmath.sqrt(745)) / 2)
    assert found[1] == "sqrt(2)*sqrt(85 - sqrt(745))/2"
    values = {"gamma_t": 0.2, "beta": 0.0, "gamma": 0.5}
    below, above = (
        np.abs(np.linalg.eigvals(np.array(stepped("newmark_bdf2", limit * x, 0.0, values), dtype=float))).max()
        for x in (1 - 1e-6, 1 + 1e-6)
    )
    assert below <= 1 + 1e-9  # a pair on the circle, to rounding of the eigenvalue solver
    assert above > 1 + 1e-7  # beyond, one of two real eigenvalues leaves it


def verdict(judge: Callable[[], algebra.Finding]) -> str:
    """The verdict of a judge of the algebra, asked now: `generated/` holds what it found when that was derived."""
    return overall(*judge()[0])


def test_a_verdict_follows_the_formula(monkeypatch: pytest.MonkeyPatch) -> None:
    """Printed formulas corrected on purpose, right ones broken on purpose."""
    right = printed.printed_a31()
    monkeypatch.setattr(printed, "printed_a31", lambda: right / 2)
    assert verdict(algebra.claim_4_1) == "true"
    monkeypatch.setattr(printed, "composite_is_bathe", lambda: False)
    assert verdict(algebra.claim_4_2) == "false"
    monkeypatch.setattr(printed, "second_sub_step_end_printed", Integer(1))
    assert verdict(algebra.misprint_p15) == "true"
    monkeypatch.setattr(printed, "wilson_printed", printed.wilson_theta)
    assert verdict(algebra.misprint_2_20) == "true"
    monkeypatch.setattr(printed, "newmark_conditions", printed.newmark_conditions[:1])
    assert verdict(algebra.claim_2_1) == "partly"


def test_a_region_follows_the_scheme(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a wrong slope in Gholampour's scheme its region is refuted; with the right one as printed both hold."""
    with monkeypatch.context() as broken:
        region = printed.gholampour_region
        broken.setattr(printed, "gholampour_region", lambda _=None: region(printed.gholampour_printed))
        assert verdict(algebra.claim_2_10) == "false"
    monkeypatch.setattr(printed, "gholampour_printed", gholampour)
    assert verdict(algebra.claim_2_10) == "true"
    assert verdict(algebra.misprint_2_54) == "true"


def test_the_claimed_interval_of_hht_alpha_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    assert chapter_2.claim_2_7()[0] == "partly"
    monkeypatch.setattr(printed, "hht_values", Interval(-Rational(1, 2), 0))
    assert chapter_2.claim_2_7()[0] == "true"
    monkeypatch.setattr(printed, "wilson_values", Interval(Rational(136, 100), 2))
    assert verdict(algebra.claim_2_4) == "false"


def test_printed_ratio_is_a_number() -> None:
    assert printed.a31_ratio() == Rational(2)


def test_the_second_sub_step_ends_with_the_step() -> None:
    """By the formula's coefficients, on u = t in the judge and here on u = t^2, which it differentiates exactly too."""
    assert printed.second_sub_step_end() == 1
    relation = printed.silva_bezerra.relations[knot(1).v]
    parabola = {knot(0).u: 0, knot("g").u: (gamma_t * h) ** 2, knot(1).u: h**2}
    assert (relation.subs(parabola) - 2 * h).simplify() == 0


def test_the_end_is_derived_from_the_coefficients(monkeypatch: pytest.MonkeyPatch) -> None:
    """A first-order difference over the second sub-step, taken for a step h after t_n, would end elsewhere."""
    v1, (u1, ug) = knot(1).v, (knot(1).u, knot("g").u)
    other = replace(printed.silva_bezerra, relations={**printed.silva_bezerra.relations, v1: (u1 - ug) / h})
    monkeypatch.setattr(printed, "silva_bezerra", other)
    assert printed.second_sub_step_end() == 1 + gamma_t
    assert verdict(algebra.misprint_p15) == "false"


def test_only_inconsistency_is_taken_for_inconsistency(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InconsistentScheme, match="wilson_printed is not consistent"):
        leading_terms(Amplification.of(printed.wilson_printed))
    assert not printed.is_consistent(printed.wilson_printed)
    (u0, *_), (u1, v1, _) = knot(0), knot(1)
    relations = {**printed.wilson_theta.relations, u1: u0 + h * v1, v1: (u1 - u0) / h}
    mistyped = replace(printed.wilson_theta, name="mistyped", relations=relations)
    with pytest.raises(DeclarationError, match="mistyped: the relations and balances are dependent"):
        printed.is_consistent(mistyped)
    monkeypatch.setattr(printed, "wilson_printed", mistyped)
    with pytest.raises(DeclarationError, match="mistyped: the relations and balances are dependent"):
        algebra.misprint_2_20()


def test_certificates_agree_with_the_claimed_regions() -> None:
    """Points of (2.56)-(2.57) by hand, corners and edges among them."""
    for delta in map(Fraction, ("1/3", "2/5", "1/2", "3/4", "1", "3/2")):
        low, high = delta / 2, delta - Fraction(1, 6)
        for share in map(Fraction, ("0", "1/2", "1")):
            point = {"delta": delta, "alpha_g": low + share * (high - low)}
            assert certify("gholampour", **point).stable
            assert not certify(printed.gholampour_printed, **point).stable


def test_a_stiffness_without_damping_would_confirm_the_printed_one(monkeypatch: pytest.MonkeyPatch) -> None:
    stiffnesses = [system.effective_stiffness for system in printed.derive("newmark_bdf2").balances]
    assert verdict(algebra.misprint_3_9) == "false"
    undamped = SimpleNamespace(balances=[SimpleNamespace(effective_stiffness=k.subs(C, 0)) for k in stiffnesses])
    monkeypatch.setattr(printed, "derive", lambda _: undamped)
    assert verdict(algebra.misprint_3_9) == "true"
