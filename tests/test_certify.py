"""Certificates of stability against published limits and against 50-digit eigenvalues of stepped matrices."""

import os
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import oracle
import pytest
from declared import BY_NAME, NAMES, for_oracle, parameter_sets
from substep_derive import Balance, DeclarationError
from substep_derive.algebra.algebraic import Algebraic
from substep_derive.declare.symbols import K0, M, f, h
from substep_derive.stability.all_damping import certify_all_damping
from substep_derive.stability.certificate import Certificate, certify
from substep_derive.stability.hurwitz import Verdict
from sympy import CRootOf, Rational, minimal_polynomial, oo, pi, sqrt
from sympy.abc import r, x

SETS, OMEGAS = (2000, 16) if os.environ.get("SUBSTEP_VERIFY") == "1" else (200, 6)
EDGE = mpmath.mpf(10) ** -20
TABLE_4_1 = (("1/4", "1/2"), ("121/400", "3/5"), ("9/25", "7/10"), ("169/400", "4/5"), ("49/100", "9/10"))
SQRT_3 = Algebraic((1, 0, -3), (1, 2))
TWO_MINUS_SQRT_2 = Algebraic((1, -4, 2), ("1/2", "3/5"))


# --- published limits ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "parameters", "critical", "closed"),
    [
        ("newmark", {"beta": 0, "gamma": "1/2"}, 2, False),  # -1 twice
        ("newmark", {"beta": "1/6", "gamma": "1/2"}, 2 * sqrt(3), False),
        ("newmark", {"beta": "1/12", "gamma": "1/2"}, sqrt(6), False),
        ("newmark", {"beta": "1/5", "gamma": "1/2"}, 2 * sqrt(5), False),  # 1/sqrt(gamma/2 - beta)
        ("newmark", {"beta": "1/5", "gamma": "3/5"}, sqrt(10), True),  # -1 once
        ("central_difference", {}, 2, False),
        ("central_difference_lagged", {}, 2, False),
        ("rk4", {}, 2 * sqrt(2), True),
        ("noh_bathe", {"p": "27/50"}, 2 / sqrt((3 * Rational(27, 50) - 1) * (1 - Rational(27, 50))), True),
        ("wilson_theta", {"theta": "34/25"}, 50 * sqrt(39) / 13, True),
        ("kim_two_stage", {"gamma_t": "1/3"}, sqrt(6), True),  # Kratos's runs give 2.449491
    ],
)
def test_conditional(name: str, parameters: dict[str, Any], critical: Any, closed: bool) -> None:
    found = certify(BY_NAME[name], **parameters)
    assert found.critical_Omega == critical
    assert found.intervals == ((0, critical, False, closed),)
    assert not found.stable


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("newmark", {"beta": "1/4", "gamma": "2/5"}),
        ("newmark", {"gamma": "49/100"}),
        ("forward_euler", {}),
        ("rk2", {}),
    ],
)
def test_unstable_at_once(name: str, parameters: dict[str, Any]) -> None:
    found = certify(BY_NAME[name], **parameters)
    assert found.critical_Omega == 0
    assert not found.intervals


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("newmark", {}),
        ("newmark", {"beta": Fraction(121, 400), "gamma": Rational(3, 5)}),
        ("wilson_theta", {"theta": "7/5"}),
        ("wilson_theta", {"theta": (1 + SQRT_3) / 2}),
        ("newmark_bdf2", {"gamma_t": TWO_MINUS_SQRT_2}),
        ("rho_inf_bathe", {"rho_inf": "1/3"}),
        ("three_substep", {"rho_inf": "1/3"}),
        ("backward_euler", {}),
        ("energy_momentum", {}),
        ("houbolt", {}),
        ("park", {}),
    ],
)
def test_unconditional(name: str, parameters: dict[str, Any]) -> None:
    found = certify(BY_NAME[name], **parameters)
    assert found.stable
    assert found.critical_Omega is None
    assert found.intervals == ((0, oo, False, False),)


def test_thresholds_are_met_exactly() -> None:
    """At a threshold, and at 1e-40 from it, floating point would decide wrongly."""
    tiny = Fraction(1, 10**40)
    assert certify("newmark", beta=Fraction(1, 4) + tiny).stable
    assert certify("newmark", beta=Fraction(1, 4) - tiny).critical_Omega == 10**20
    assert certify("newmark", gamma=Fraction(1, 2) - tiny).critical_Omega == 0
    threshold = (1 + SQRT_3) / 2
    assert certify("wilson_theta", theta=threshold + tiny).stable
    assert not certify("wilson_theta", theta=threshold - tiny).stable


def test_average_acceleration_keeps_its_eigenvalues_on_the_circle() -> None:
    verdicts = {piece.verdict for piece in certify("newmark").proof.pieces}
    assert verdicts == {Verdict.SIMPLE}
    assert {piece.verdict for piece in certify("newmark", xi="1/10").proof.pieces} == {Verdict.INSIDE}


@pytest.mark.parametrize("damping", [0, "1/20", "1/2", 1, 2])
@pytest.mark.parametrize("gamma_t", ["1/5", "2/5", "1/2", "3/5", "4/5"])
def test_table_4_1(gamma_t: str, damping: Any) -> None:
    for beta, gamma in TABLE_4_1:
        assert certify("newmark_bdf2", damping, gamma_t=gamma_t, beta=beta, gamma=gamma).stable


def test_linear_acceleration_then_bdf2_has_a_gap() -> None:
    found = certify("newmark_bdf2", beta="1/6", gamma="1/2", gamma_t="1/2")
    assert found.intervals == ((0, 3 * sqrt(2), False, True), (2 * sqrt(6), oo, True, False))
    assert found.critical_Omega == 3 * sqrt(2)
    assert not found.stable


def test_multiple_eigenvalues_on_the_circle_are_distinguished() -> None:
    """Two equal steps of a method without damping: A = -I at one Omega, bounded, but -1 is not simple."""
    found = certify("noh_bathe", p="1/2")
    assert found.intervals == ((0, 2 * sqrt(2), False, False), (2 * sqrt(2), 4, False, False))
    assert found.multiple == ((2 * sqrt(2), 2 * sqrt(2), True, True), (4, 4, True, True))
    assert "but for a multiple eigenvalue also in {2*sqrt(2)} and {4}" in found.text
    found = certify("rho_inf_bathe", rho_inf=1)
    assert found.intervals == ((0, 4, False, False), (4, oo, False, False))
    assert found.multiple == ((4, 4, True, True),)
    found = certify("oalts", rho_inf=1)  # -1 twice for every Omega
    assert not found.intervals
    assert found.multiple == ((0, oo, False, False),)
    assert "lambda = -1 is an eigenvalue for every Omega, 2-fold" in found.text


def test_a_step_that_is_not_defined_is_not_stable() -> None:
    """Newmark's balance times 1 - Omega^2/4: the same eigenvalues, but nothing to solve for at Omega = 2."""
    newmark = BY_NAME["newmark"]
    scale = 1 - h**2 * K0 / M / 4
    balance = newmark.balances[0]
    scaled = Balance(scale * balance.inertia, scale * balance.damping, scale * balance.force, scale * balance.load)
    found = certify(replace(newmark, name="scaled", balances=(scaled,)))
    assert found.intervals == ((0, 2, False, False), (2, oo, False, False))
    assert not found.multiple
    assert "Omega_1                     +    step not defined: unstable" in found.text
    assert certify_all_damping(replace(newmark, name="scaled", balances=(scaled,))).stable_for_all_xi is False
    nothing = replace(newmark, name="nothing", balances=(Balance(0 * h, 0 * h, 0 * h, f(1)),))
    with pytest.raises(DeclarationError, match="dependent for every Omega"):
        certify(nothing)


# --- exact numbers -------------------------------------------------------------------------------------


def test_algebraic_parameters_give_algebraic_limits() -> None:
    found = certify("noh_bathe", p=TWO_MINUS_SQRT_2)
    p = 2 - sqrt(2)
    assert minimal_polynomial(found.critical_Omega, x) == minimal_polynomial(2 / sqrt((3 * p - 1) * (1 - p)), x)
    assert abs(float(found.critical_Omega) - float(2 / sqrt((3 * p - 1) * (1 - p)))) < 1e-12
    quartic = certify("noh_bathe", p=Algebraic((1, 0, 0, 0, 0, 7, -4), ("1/2", "3/5")))
    p = CRootOf(x**6 + 7 * x - 4, 1)
    assert isinstance(quartic.critical_Omega, CRootOf)
    assert abs(float(quartic.critical_Omega) - float(2 / sqrt((3 * p - 1) * (1 - p)))) < 1e-12


def test_functions_of_one_algebraic_number() -> None:
    split = Algebraic((2, 0, -1), (0, 1))  # 1/sqrt(2)
    found = certify("newmark_bdf2", gamma_t=1 - split, beta=split**2 / 2, gamma=split * split)
    assert found.stable
    assert found.parameters["beta"] == Algebraic((2, 0, -1), (0, 1), r**2 / 2)
    assert certify("newmark", xi=split, beta=0, gamma="1/2").critical_Omega == 2
    assert certify("beta1_beta2_bathe", rho_inf=split).stable
    assert Algebraic((1, 0, -2, 0, 1), (0, 3)).coefficients == (1, -1)  # the factor with the root
    assert certify("newmark", beta=Algebraic((4, -1), (0, 1))).stable


def test_defaults_may_be_algebraic_and_depend_on_what_is_given() -> None:
    assert certify("rho_inf_bathe", rho_inf=0).parameters["gamma_t"] == TWO_MINUS_SQRT_2_DEFAULT
    assert certify("rho_inf_bathe", rho_inf=1).parameters["gamma_t"] == Rational(1, 2)
    assert certify("generalized_alpha", alpha_m=0, alpha_f="1/3").parameters["beta"] == Rational(4, 9)
    assert certify("three_substep", rho_inf="1/2").parameters["gamma"].coefficients == (9, -38, 48, -24, 4)
    with pytest.raises(ValueError, match="give gamma_t"):
        certify("rho_inf_bathe", rho_inf=TWO_MINUS_SQRT_2)
    with pytest.raises(ValueError, match="give gamma;"):
        certify("three_substep", rho_inf=TWO_MINUS_SQRT_2)


TWO_MINUS_SQRT_2_DEFAULT = Algebraic((1, -4, 2), (0, 1))


def test_algebraic_numbers_are_checked() -> None:
    for wrong in [((1, 0, -2), (-2, 2)), ((1, 0, -2), (2, 3)), ((1, 0, -2), (2, 1)), ((1, 0, 2), (-9, 9))]:
        with pytest.raises(ValueError, match="expected one"):
            Algebraic(*wrong)
    with pytest.raises(ValueError, match="integer coefficients"):
        Algebraic((Fraction(1, 2), -1), (0, 3))  # pyright: ignore
    with pytest.raises(TypeError, match="'1.5'"):
        Algebraic((1, 0, -2), (1, 1.5))
    with pytest.raises(ValueError, match="single one"):
        _ = SQRT_3 + TWO_MINUS_SQRT_2
    assert SQRT_3 * Algebraic((1, 0, -3), ("17/10", "9/5")) - 3 == 0 * SQRT_3 - 3 + SQRT_3**2
    assert str(1 - 2 / SQRT_3) == "(r - 2)/r where r is the root of r**2 - 3 in [1, 2]"
    assert Algebraic.of(sqrt(2) + sqrt(3)).index == 3
    with pytest.raises(ValueError, match="real number"):
        Algebraic.of(sqrt(-2))
    with pytest.raises(ValueError, match="algebraic number"):
        Algebraic.of(pi)


def test_wrong_calls() -> None:
    with pytest.raises(DeclarationError, match="no parameter 'bta'"):
        certify("newmark", bta=0)
    with pytest.raises(DeclarationError, match="no parameter 'bta'"):
        certify("newmark", bta=SQRT_3)
    with pytest.raises(DeclarationError, match="lies outside"):
        certify("newmark", beta=-1)
    with pytest.raises(DeclarationError, match="lies outside"):
        certify("newmark_bdf2", gamma_t=SQRT_3)
    with pytest.raises(DeclarationError, match="lies outside"):
        certify("beta1_beta2_bathe", rho_inf=SQRT_3)
    with pytest.raises(DeclarationError, match="given twice"):
        certify("beta1_beta2_bathe", rho_inf=SQRT_3 - 1, beta1="1/2")
    with pytest.raises(DeclarationError, match=r"did you mean 'newmark'\? near are: "):
        certify("newmrk")
    with pytest.raises(TypeError, match=r"'0\.25'"):
        certify("newmark", beta=0.25)
    with pytest.raises(ValueError, match="xi >= 0"):
        certify("newmark", xi=-1)
    with pytest.raises(ValueError, match="xi >= 0"):
        certify("newmark", xi=1 - SQRT_3)
    with pytest.raises(ValueError, match="rational number"):
        certify("newmark", beta="__import__('os')")
    with pytest.raises(ValueError, match="two algebraic numbers") as caught:
        certify("newmark", beta=SQRT_3, gamma=TWO_MINUS_SQRT_2)
    assert "r**2 - 3" in str(caught.value)
    assert "r**2 - 4*r + 2" in str(caught.value)


def test_the_end_of_a_default_interval_counts() -> None:
    open_end = Algebraic((1, -1), (0, 2))  # 1, written as a root
    with pytest.raises(DeclarationError, match="lies outside"):
        certify("newmark_bdf2", gamma_t=open_end)
    assert certify("wilson_theta", theta=open_end).critical_Omega == 2 * sqrt(3)


# --- every certificate against 50 digits ---------------------------------------------------------------


def moduli(name: str, omega: Fraction, damping: Fraction, parameters: dict[str, Fraction]) -> list[Any]:
    other, wanted = for_oracle(BY_NAME[name], parameters)
    numbers = (Fraction(str(q)) for q in (omega, damping, *wanted.values()))
    exact = [mpmath.mpf(q.numerator) / q.denominator for q in numbers]
    matrix = oracle.amplification(other, exact[0], exact[1], dict(zip(wanted, exact[2:], strict=True)))
    return mpmath.eig(mpmath.matrix(matrix), left=False, right=False)


def omegas(found: Certificate, rng: np.random.Generator) -> Iterator[Fraction]:
    """Spread over decades, and next to every end."""
    for exponent in rng.uniform(-1.3, 2.5, OMEGAS):
        yield Fraction(10.0**exponent).limit_denominator(1000)
    for end in {e for low, high, _, _ in found.intervals for e in (low, high)}:
        if end != 0 and end is not oo:
            at = Fraction(str(end.evalf(40)))
            yield from (at * (1 - Fraction(1, 10**6)), at * (1 + Fraction(1, 10**6)))


def claimed(found: Certificate, omega: Fraction) -> bool:
    """Whether Omega lies in an interval; never called on an end."""
    ends = [(e if e in (0, oo) else e.evalf(40) for e in interval[:2]) for interval in found.intervals]
    return any(low < Rational(omega) < high for low, high in ends)


def confirm(name: str, found: Certificate, damping: Fraction, parameters: dict[str, Fraction], omega: Fraction) -> None:
    values = moduli(name, omega, damping, parameters)
    largest = max(abs(v) for v in values)
    if claimed(found, omega):
        assert largest <= 1 + EDGE, (parameters, damping, omega, found.intervals)
    elif largest <= 1 + EDGE:
        on_circle = [v for v in values if abs(v) > 1 - EDGE]
        apart = [abs(v - w) for i, v in enumerate(on_circle) for w in on_circle[:i]]
        assert apart and min(apart) < EDGE, (parameters, damping, omega, found.intervals)


@pytest.mark.parametrize("name", NAMES)
def test_fifty_digits(name: str) -> None:
    rng = np.random.default_rng(7)
    with mpmath.workdps(50):
        for parameters, damping in parameter_sets(name, SETS // 16):
            found = certify(BY_NAME[name], damping, **parameters)
            for omega in omegas(found, rng):
                confirm(name, found, damping, parameters, omega)


@pytest.mark.parametrize("name", NAMES)
def test_conditions_in_the_text_say_the_same(name: str) -> None:
    """Lienard and Chipart's conditions, as printed, against Routh's array, which decides."""
    for parameters, damping in parameter_sets(name, 3):
        found = certify(BY_NAME[name], damping, **parameters)
        for piece in found.proof.pieces:
            if piece.is_point:
                continue
            hold = True
            for test in found.proof.parts.tests:
                lead = piece.at.sign(piece.at.value(test.coefficients[-1]))
                for label, condition in test.conditions.items():
                    even = label.startswith("D") and int(label[2 : label.index("(")]) % 2 == 0
                    sign = piece.at.sign(piece.at.value(condition))
                    hold &= sign * (1 if even else lead) > 0
            assert hold == piece.verdict.stable, (parameters, damping)
        assert found.text.count("\n") > 10


# --- the proof as text ---------------------------------------------------------------------------------


def test_text_of_the_central_difference_method() -> None:
    lines = [line.strip() for line in certify("newmark", beta=0, gamma="1/2").text.splitlines()]
    for expected in [
        "newmark, beta = 0, gamma = 1/2, xi = 0",
        "Result: stable exactly for Omega in (0, 2); but for a multiple eigenvalue also in {2}",
        "p_1 = Omega^2 - 2",
        "h_2 = -(Omega - 2)*(Omega + 2)",
        "Omega_1 = 2",
        "Omega_1                     0    0    +    multiple on the circle, none outside: unstable",
    ]:
        assert expected in lines


def test_text_names_roots_without_radicals_and_algebraic_parameters() -> None:
    text = certify("rk4", xi="1/10").text
    assert "the root of 625*Omega^7" in text
    assert "Omega in (0, CRootOf(625*Omega^7" in text
    text = certify("wilson_theta", theta=(1 + SQRT_3) / 2).text
    assert "where r is the root of r^2 - 3 in [1, 2]" in text
    assert "h_3 = 12*r + 36" in text
