"""What is decided for every structure, against random structures that are stepped from the declaration alone."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from declared import ALL
from declared_steps import constants
from structure_steps import Blocks, random_structures
from substep_derive import Balance, DeclarationError, Energy, NoEnergy, Scheme, certify
from substep_derive.declare.catalogue import find
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.declare.symbols import K0, C, M, Omega, h, knot, xi
from substep_derive.stability.structure_form import MultiStepForm, Rows
from substep_derive.stability.structure_multiplier import Multiplier, pencil
from substep_thesis.generated.facts import NEWMARK_SETS, SPLITS
from sympy import Matrix, Symbol, cancel, zeros
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app

# what one oscillator decides, by certificates: growth, without damping or with, and stability at small Omega only
CRITICAL = {s.name: ss.scheme(s.name).critical_Omega for s in ALL}
REFUTED = {name for name, at in CRITICAL.items() if at == 0 or (at == np.inf and not ss.scheme(name).A_stable)}
OPEN = {"noh_bathe", "kim_two_stage", "trbdf3", "forest_ruth"}
BOUND = {name for name, at in CRITICAL.items() if at and name not in REFUTED | OPEN and at < np.inf}
OUTSIDE = {"chang", "alpha_os", "lsrt2"}  # have coefficients that no theorem fits
THESIS = {"gamma_t": Fraction(1, 5), "beta": Fraction("0.3025"), "gamma": Fraction(3, 5)}


def largest(name: str, count: int, found: Any, seed: int = 0, **parameters: Any) -> float:
    """The largest modulus of an eigenvalue over random structures, within the bound that was found if there is one."""
    scheme = find(name)
    numbers = {
        Symbol(key): float(x)
        for key, x in ss.scheme(name, **{k: float(v) for k, v in parameters.items()}).parameters.items()
    }
    numbers |= {s: float(x) for s, x in constants(scheme, mpmath).items()}
    rng, worst = np.random.default_rng([seed, len(name)]), 0.0
    for n, rigid in ((1, 0), (2, 0), (2, 1), (3, 0), (4, 1), (5, 0), (5, 2)):
        M, C, K = random_structures(rng, -(-count // 7), n, rigid)
        if not scheme.takes_damping:
            C = 0 * C
        if found.bound is not None:
            W, D = found.bound
            load = K / float(W) + (0 * C if D is None else C / float(D))
            size = np.abs(np.linalg.eigvals(np.linalg.solve(M, load))).max(axis=1)[:, None, None]
            C, K = (C if D is None else C * 0.999 / size), K * 0.999 / size
        blocks = Blocks(scheme, numbers, (M, C, K))
        A = blocks.without_rigid(blocks.amplification(), rigid)
        worst = max(worst, np.abs(np.linalg.eigvals(A)).max())
    return worst


def test_so_many_schemes_are_proved_as_the_findings_say() -> None:
    """Each of them has its verdict below."""
    proved = CRITICAL.keys() - REFUTED - OPEN - BOUND - OUTSIDE
    said = (
        f"Of the {len(ALL)} schemes at their defaults {len(proved)} are proved stable, {len(BOUND)} under a bound on "
        f"h²K/W + hC/D < M, {len(REFUTED)} are refuted by one oscillator, {len(OPEN)} are open"
    )
    assert said in (Path(__file__).parents[1] / "docs" / "findings.md").read_text(encoding="utf-8")


@pytest.mark.thorough
@pytest.mark.parametrize("name", [s.name for s in ALL if s.name not in REFUTED | OPEN | OUTSIDE])
def test_no_structure_of_three_thousand_grows(name: str) -> None:
    assert largest(name, 3000, certify(name, structures=True), seed=1) <= 1 + 1e-10


@pytest.mark.parametrize(
    ("gamma_t", "beta", "gamma"), [("1/5", "0.3025", "3/5"), ("1/2", "1/2", "4/5"), ("3/4", "9/10", "11/8")]
)
def test_newmark_then_bdf2_is_proved_where_its_sub_steps_differ(gamma_t: str, beta: str, gamma: str) -> None:
    given = {"gamma_t": Fraction(gamma_t), "beta": Fraction(beta), "gamma": Fraction(gamma)}
    found = certify("newmark_bdf2", structures=True, **given)
    assert found.verdict == "proved"
    assert largest("newmark_bdf2", 350, found, **given) <= 1 + 1e-10


def has_energy_of_the_operator(scheme: Any) -> bool:
    """Whether the own energy is Omega^2 u^2 + 2 xi Omega u h v + (h v)^2 but for a factor: functions of h L keep it."""
    try:
        form = Energy.of(scheme).P.subs(scheme.typical)
    except NoEnergy:
        return False
    unit = Matrix([[Omega**2, Omega * xi], [Omega * xi, 1]])
    return form.shape == (2, 2) and (form - form[1, 1] * unit).applyfunc(cancel) == zeros(2)


@pytest.mark.parametrize("scheme", ALL, ids=lambda s: s.name)
def test_each_scheme_has_its_verdict_and_no_random_structure_grows_against_it(scheme: Any) -> None:
    name = scheme.name
    if name in OUTSIDE:
        with pytest.raises(DeclarationError, match="on every structure: expected coefficients"):
            certify(scheme, structures=True)
        return
    found = certify(scheme, structures=True)
    verdicts = {"refuted": REFUTED, "open": OPEN, "proved under a bound": BOUND}
    assert found.verdict == next((key for key, names in verdicts.items() if name in names), "proved")
    assert (found.growing is not None) == (found.verdict == "refuted")
    assert (found.bound is not None) == (found.verdict == "proved under a bound")
    assert ("y_1 = R(h L) y_0" in found.text) == has_energy_of_the_operator(scheme)
    if found.growing is not None:  # the exact matrices, in floating point
        numbers = {Symbol(key): float(x) for key, x in ss.scheme(name).parameters.items()}
        numbers |= {s: float(x) for s, x in constants(scheme, mpmath).items()}
        M, C, K = (np.array([part], float) for part in found.growing)
        assert np.abs(np.linalg.eigvals(Blocks(scheme, numbers, (M, C, K)).amplification())).max() > 1
    elif found.verdict != "open":
        assert largest(name, 35, found) <= 1 + 1e-10


def test_a_multiple_eigenvalue_on_the_circle_is_no_growth_for_a_function_of_the_operator() -> None:
    assert certify("rho_inf_bathe", rho_inf=1, gamma_t="1/2").multiple  # where R(hL) = -1
    assert certify("rho_inf_bathe", rho_inf=1, gamma_t="1/2", structures=True).verdict == "proved"
    left = certify("oalts", rho_inf=1, structures=True)
    assert (left.verdict, left.growing) == ("open", None)
    assert "multiple eigenvalue on the unit circle" in left.argument


def test_the_g_matrix_of_bdf2_is_dahlquists() -> None:
    """Hairer & Wanner, Solving Ordinary Differential Equations II, V.6: G = [[1, -2], [-2, 5]]/4."""
    assert "G = [[1/4, -1/2], [-1/2, 5/4]]" in certify("bdf2", structures=True).text


@pytest.mark.parametrize("rho", [Fraction(0), Fraction(1, 2), Fraction(4, 5)])
def test_the_g_matrix_of_oalts_in_closed_form(rho: Fraction) -> None:
    form = MultiStepForm.of(Rows(ParameterSet.of("oalts", None, {"rho_inf": rho})))
    assert form is not None
    assert form.G is not None
    closed = (5 * rho**2 - 4 * rho + 1, -2 * (rho**2 - 3 * rho + 1), rho**2 - 4 * rho + 5)
    upper = (form.G[0][0], form.G[0][1], form.G[1][1])
    assert len({Fraction(str(g)) / c for g, c in zip(upper, closed, strict=True)}) == 1


@pytest.mark.thorough
def test_all_sets_of_the_thesis_are_proved() -> None:
    for split in SPLITS:
        for beta, gamma in NEWMARK_SETS:
            given = {"gamma_t": split, "beta": beta, "gamma": gamma}
            assert certify("newmark_bdf2", structures=True, **given).verdict == "proved"


def test_the_multiplier_is_positive_in_floating_point_as_well() -> None:
    rows = Rows(ParameterSet.of("newmark_bdf2", None, THESIS))
    multiplier, parts = Multiplier.of(rows), pencil(rows)
    assert multiplier is not None
    assert parts is not None
    for angle in np.linspace(1e-2, np.pi, 300):
        A, B, D, H = (
            np.array([[sum(float(c) * np.exp(1j * k * angle) for k, c in e.items()) for e in row] for row in m])
            for m in (*parts, multiplier.H)
        )
        for part in (A, B, D):
            weighted = B.conj().T @ H @ part
            values = np.linalg.eigvalsh(weighted + weighted.conj().T)
            assert values[0] >= -1e-9 * values[1]


def test_the_command_line_has_structures() -> None:
    def said(*arguments: str) -> str:
        return " ".join(CliRunner().invoke(app, ["certify", *arguments, "--structures"]).output.split())

    proof = said("newmark_bdf2", "--gamma-t", "1/5", "--beta", "0.3025", "--gamma", "3/5")
    assert "Result: proved" in proof
    assert "multiplier S = B* H" in proof
    assert "M = [[1]] h C = [[0]] h^2 K = [[1]]" in said("rk2")
    assert "Bound: h^2 K/(4) + h C/(2) < M" in said("central_difference_lagged")
    assert "leave it out" in said("bathe", "--xi", "1/20")
    with pytest.raises(ValueError, match="expected no xi for structures"):
        certify("bathe", xi="1/20", structures=True)


def test_coefficients_that_no_theorem_is_made_for_are_refused() -> None:
    (u0, v0, a0), (u1, v1, a1) = knot(0), knot(1)
    own = Scheme(
        "own",
        relations={u1: u0 + h * v0 + h**5 * K0 * C / (M**2 + h**3 * K0 * C) * a0, v1: v0 + h * a1},
        balances=(Balance.at(knot(1), 1),),
    )
    with pytest.raises(DeclarationError, match="own on every structure: expected coefficients that are numbers or e_1"):
        certify(own, structures=True)
