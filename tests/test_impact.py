"""Impacts derived exactly, by the phase within the step: against marches, closed forms and the table of the page."""

import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from substep_derive import DeclarationError, impact
from substep_derive.constrained.impact import phi
from test_constraints import TAKEN, VERIFY
from test_contact import SOME, H, remembered

import substep as ss

PAGE = Path(__file__).parents[1] / "docs" / "constraints_and_contact.md"
# whether remembered where impacts do not end; None for both
UNENDING = {"oalts": False, **dict.fromkeys(("esdirk43", "sdirk4"))}
CASES = [(name, kept) for name in (TAKEN if VERIFY else SOME) for kept in (True, False)]
ENDING = [(name, kept) for name, kept in CASES if name not in UNENDING or UNENDING[name] == (not kept)]


def velocity_of(found: Any, at: float) -> float:
    """The derived velocity at a phase, or at the same in the step before, whose last sub-step has met the stop."""
    at += float(at < float(found.pieces[0].low))
    piece = next(p for p in found.pieces if float(p.low) <= at <= float(p.high))
    return float(piece.velocity.subs(phi, at))


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(("name", "kept"), ENDING)
def test_marches_leave_with_the_velocity_that_is_derived(name: str, kept: bool) -> None:
    scene = remembered("mass_on_floor") if kept else "mass_on_floor"
    found, phases = impact(name, remembered=kept), (np.arange(12) + 0.37) / 12
    ds = ss.sweep(scene, name, dt=H, t_end=12.0, keep="final", u0=1 + H * phases, progress=False)
    derived = [velocity_of(found, float(at)) for at in phases]
    assert np.allclose(ds.v.values[:, 0], derived, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("name", [name for name, kept in UNENDING.items() if kept is None])
def test_impacts_that_do_not_end_are_said(name: str) -> None:
    with pytest.raises(DeclarationError, match="impacts that end, got more than 64 pieces"):
        impact(name)


def test_newmark_never_gains_at_a_stop_where_gamma_is_at_most_twice_beta() -> None:
    """The velocity that an impact leaves is gamma/beta*(1 - phi) - 1 where it opens at once."""
    for beta, gamma in (("1/4", "1/2"), ("3/10", "11/20"), ("1/3", "2/3"), ("1", "3/2")):
        assert impact("newmark", beta=beta, gamma=gamma).gains == 0
    for beta, gamma in (("1/6", "1/2"), ("1/12", "1/2"), ("1/4", "11/20")):
        found = impact("newmark", beta=beta, gamma=gamma)
        assert found.most == Fraction(gamma) / Fraction(beta) - 1
        assert found.gains > 0


def test_the_trapezoidal_rule_is_known() -> None:
    kept = impact("average_acceleration", remembered=True)
    assert (kept.least, kept.most, kept.gains) == (Fraction(1, 3), 3, Fraction(3, 4))
    assert [str(piece.velocity) for piece in impact("average_acceleration").pieces] == ["1 - 2*phi", "2*phi - 1"]
    assert str(kept) == "leaves with 0.333 to 3; gains energy at 75 % of the phases"


@pytest.mark.usefixtures("uncompiled")
def test_central_differences_lose_what_meets_a_stop() -> None:
    """The step that meets it ends there, and the next one stays: Paoli and Schatzman's scheme without restitution."""
    found, phases = impact("central_difference"), (np.arange(12) + 0.37) / 12
    assert (found.least, found.most, found.gains, found.remembered) == (0, 0, 0, True)
    ds = ss.sweep("mass_on_floor", "central_difference", dt=H, t_end=3.0, keep="final", u0=1 + H * phases)
    assert np.abs(ds.v.values).max() < 1e-12
    assert np.abs(ds.u.values).max() < 1e-12


def test_what_holds_no_gap_is_refused() -> None:
    for name, reason in (("rk4", "does not move on"), ("wilson_theta", "no force at the end")):
        with pytest.raises(DeclarationError, match=reason):
            impact(name)


def test_the_page_has_what_is_derived() -> None:
    """Each row: schemes, then least, most and the share that gains, for both readings."""
    rows = re.findall(r"^\| (`[^|]*) \| ([^|]*) \| ([^|]*) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    said = {name: cells for names, *cells in rows for name in re.findall(r"`(\w+)`", names)}
    assert said.keys() == {*TAKEN, "central_difference"}
    for name in [*(TAKEN if VERIFY else SOME), "central_difference"]:
        for kept, cell in zip((False, True), said[name], strict=True):
            if name in TAKEN and (name, kept) not in ENDING:
                assert cell == "does not end"
                continue
            found = impact(name, remembered=kept)
            assert cell == f"{float(found.least):.2f} to {float(found.most):.2f}, {100 * float(found.gains):.0f} %"
