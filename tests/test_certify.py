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
from declared import BY_NAME, NAMES, for_oracle
from substep_derive import Balance, DeclarationError
from substep_derive.algebraic import Algebraic, Field, RealRoot
from substep_derive.curve import critical_curve
from substep_derive.damping import _on_curve, certify_all_damping
from substep_derive.hurwitz import Hurwitz, Verdict, verdict
from substep_derive.signs import RationalPoint, RootPoint, point, positive_roots, ring_over, simplest_between
from substep_derive.stability import Certificate, certify
from substep_derive.symbols import K0, M, f, h
from sympy import QQ, CRootOf, Mul, Poly, Rational, Symbol, minimal_polynomial, oo, pi, sqrt
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
    """What a decision in floating point gets wrong: distances of 1e-40 to a threshold, and none."""
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


def test_multiple_eigenvalues_on_the_circle_are_told_apart() -> None:
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
    with pytest.raises(DeclarationError, match="one of"):
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


def test_irrational_declarations_are_refused() -> None:
    forward_euler = BY_NAME["forward_euler"]
    relations = {symbol: e * sqrt(2) for symbol, e in forward_euler.relations.items()}
    with pytest.raises(DeclarationError, match="declare a parameter"):
        certify(replace(forward_euler, name="irrational", relations=relations))


def test_the_end_of_a_default_interval_counts() -> None:
    open_end = Algebraic((1, -1), (0, 2))  # 1, written as a root
    with pytest.raises(DeclarationError, match="lies outside"):
        certify("newmark_bdf2", gamma_t=open_end)
    assert certify("wilson_theta", theta=open_end).critical_Omega == 2 * sqrt(3)


# --- signs ---------------------------------------------------------------------------------------------


def test_simplest_rational_between() -> None:
    for low, high, expected in [("0", "1", "1/2"), ("1/3", "1/2", "2/5"), ("2/5", "4", "1"), ("3", "22/7", "25/8")]:
        ends = (QQ(*map(int, (*text.split("/"), "1")[:2])) for text in (low, high))
        assert str(simplest_between(*ends)) == expected


def test_zero_over_an_algebraic_field_is_found() -> None:
    """x^2 - 3 is irreducible over Q but not over Q(sqrt 3): remainders alone do not tell zero."""
    field = Field(SQRT_3)
    ring = ring_over(field, Symbol("w"))
    w, s = ring.gens[0], field.domain.unit
    root = RealRoot(Poly(x**2 - 3, x), 1, 2)
    at = point(field, root, ring)
    assert isinstance(at, RootPoint)
    assert at.sign(at.value((w - s) * (w + 1))) == 0
    assert at.sign(at.value(w + s)) == 1
    fresh = point(field, RealRoot(Poly(x**2 - 3, x), 1, 2), ring)
    assert fresh.sign(fresh.value(w + s)) == 1
    assert fresh.sign(fresh.value(w - s + QQ(1, 10**40))) == 1
    assert fresh.sign(fresh.value(w - s - QQ(1, 10**40))) == -1
    assert [r.rational for r in positive_roots(field, [w**2 - s * w, w**2 - 4], ring)] == [None, 2]
    assert not positive_roots(field, [w + s], ring)


def rooted(*factors: tuple[int, ...]) -> list[Any]:
    """h as a product of polynomials in s, coefficients from the lowest, constants over Q[w]."""
    product = [1]
    for factor in factors:
        product = [
            sum(product[i] * factor[k - i] for i in range(len(product)) if 0 <= k - i < len(factor))
            for k in range(len(product) + len(factor) - 1)
        ]
    ring = ring_over(Field(), Symbol("w"))
    return [ring.one * c for c in product]


INSIDE, OUT, PAIR, OTHER, OFF = (1, 1), (-1, 1), (1, 0, 1), (4, 0, 1), (5, 2, 1)


@pytest.mark.parametrize(
    ("factors", "expected"),
    [
        ([INSIDE, OFF, (7, 1)], Verdict.INSIDE),
        ([INSIDE, OFF, OFF, INSIDE], Verdict.INSIDE),
        ([INSIDE, PAIR], Verdict.SIMPLE),
        ([PAIR, OTHER, INSIDE, OFF], Verdict.SIMPLE),
        ([PAIR, OTHER, (9, 0, 1)], Verdict.SIMPLE),
        ([PAIR, PAIR], Verdict.MULTIPLE),
        ([PAIR, PAIR, OTHER, OFF], Verdict.MULTIPLE),
        ([(0, 1), PAIR, INSIDE], Verdict.SIMPLE),
        ([(0, 1), (0, 1), INSIDE], Verdict.MULTIPLE),
        ([INSIDE, OFF, (1, 0)], Verdict.SIMPLE),  # a leading zero: lambda = -1
        ([INSIDE, OFF, (1, 0, 0)], Verdict.MULTIPLE),
        ([(0, 1), (1, 0)], Verdict.SIMPLE),
        ([OUT, INSIDE], Verdict.OUTSIDE),
        ([OUT, INSIDE, PAIR], Verdict.OUTSIDE),
        ([OUT, OFF, OFF], Verdict.OUTSIDE),
        ([(5, -2, 1), OFF], Verdict.OUTSIDE),
        ([PAIR, (-4, 0, 1)], Verdict.OUTSIDE),
        ([PAIR, PAIR, OUT], Verdict.OUTSIDE),
        ([(1, 0, 1, 0, 1), INSIDE], Verdict.OUTSIDE),
        ([(0, 1), (0, 1), OUT], Verdict.OUTSIDE),
        ([(0,), INSIDE], Verdict.UNDEFINED),
        ([(3,)], Verdict.INSIDE),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_verdicts(factors: list[tuple[int, ...]], expected: Verdict, sign: int) -> None:
    assert verdict([sign * c for c in rooted(*factors)], RationalPoint(Field(), QQ(1))) is expected


def test_shared_factor_by_minors() -> None:
    for pairs, factors in [(1, [PAIR, INSIDE, OFF]), (2, [PAIR, OTHER, INSIDE, OFF]), (2, [PAIR, OTHER, INSIDE])]:
        h = Hurwitz("h", rooted(*factors))
        assert all(not h.determinant(h.degree - 1 - 2 * k) for k in range(pairs))
        assert h.determinant(h.degree - 1 - 2 * pairs)
        shared = h.shared(pairs)
        expected = [1, 1] if pairs == 1 else [4, 5, 1]
        assert [c / shared[-1] for c in shared] == expected


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


def parameter_sets(name: str, count: int) -> Iterator[tuple[dict[str, Fraction], Fraction]]:
    scheme, rng = BY_NAME[name], np.random.default_rng(sorted(BY_NAME).index(name))
    domains = {p.name: p.domain for p in scheme.parameters}
    dampings = [Fraction(0), Fraction(0), Fraction(1, 50), Fraction(3, 10), Fraction(1), Fraction(7, 4)]
    other = for_oracle(scheme, {p.name: scheme.typical[p.symbol] for p in scheme.parameters})[0]
    for k in range(count if scheme.parameters else len(dampings) - 1):
        drawn = oracle.sample_parameters(other, rng).items() if scheme.parameters else ()
        values = {key: Fraction(value).limit_denominator(100) for key, value in drawn}
        if all(domains[key].contains(Rational(value)) for key, value in values.items()):
            yield values, dampings[k % len(dampings) if values else k + 1]


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


# --- every damping -------------------------------------------------------------------------------------


def test_damping_at_once() -> None:
    for name in ("newmark", "bathe", "wilson_theta", "houbolt", "park", "rho_inf_bathe"):
        found = certify_all_damping(BY_NAME[name])
        assert found.stable_for_all_xi is True
        assert [(c.low, c.high, c.low_closed, c.high_closed, c.stable) for c in found.cells] == [
            (0, oo, True, False, True)
        ]
        assert "xi = 0: stable for every Omega > 0" in found.text
    assert certify_all_damping("newmark", beta=0).stable_for_all_xi is False


SOME_STABLE_ONLY_WITH_DAMPING = [
    ("generalized_alpha", {"alpha_m": "1/10", "alpha_f": "3/8", "beta": "3/2", "gamma": "1/2"}),
    ("beta1_beta2_bathe", {"beta1": "5/17", "beta2": "1/2", "gamma_t": "3/17"}),
    ("newmark_bdf2", {"beta": "2/5", "gamma": "1", "gamma_t": "2/17"}),
]


@pytest.mark.parametrize(("name", "parameters"), SOME_STABLE_ONLY_WITH_DAMPING)
def test_stable_only_with_damping(name: str, parameters: dict[str, Any]) -> None:
    found = certify_all_damping(name, **parameters)
    assert [cell.stable for cell in found.cells] == [False, True]
    end = found.cells[1].low
    assert found.cells[1].low_closed
    assert found.cells[0].high == end
    below, above = (Rational(str(end.evalf(30))) * (1 + shift) for shift in (-Rational(1, 10**20), Rational(1, 10**20)))
    assert not certify(name, below, **parameters).stable
    assert certify(name, above, **parameters).stable
    if Poly(minimal_polynomial(end, x)).degree() < 5:
        assert certify(name, Algebraic.of(end), **parameters).stable


@pytest.mark.parametrize("name", ["newmark", "generalized_alpha", "newmark_bdf2", "beta1_beta2_bathe", "gholampour"])
def test_damping_cells_against_single_certificates(name: str) -> None:
    rng = np.random.default_rng(11)
    for parameters, _ in parameter_sets(name, 4):
        found = certify_all_damping(BY_NAME[name], **parameters)
        assert None not in [cell.stable for cell in found.cells]
        for value in rng.uniform(0, 2, 4):
            damping = Rational(str(Fraction(value).limit_denominator(100)))
            cell = next(c for c in found.cells if c.low <= damping < c.high)
            assert certify(BY_NAME[name], damping, **parameters).stable == cell.stable
        for i, piece in enumerate(found.survey.stretches):
            if piece.certificate is None and piece.low.polynomial.degree() <= 4:
                single = found.survey.certificate(i)
                assert single is not None
                assert single.stable == found.survey.stable(i)


def test_critical_xi() -> None:
    """Of rk2: -1 is double at xi = 1/2, 1 at xi = 1, and a curve has a vertical tangent at xi = sqrt(3)/2."""
    survey = certify_all_damping("rk2").survey
    assert [piece.ends[0] for piece in survey.stretches if piece.is_point] == [0, Rational(1, 2), sqrt(3) / 2, 1]


def test_what_decides_on_a_curve() -> None:
    """On Omega = 1 two pairs stay on the axis; they coincide where xi = 1 and leave it where xi = 0."""
    ring = ring_over(Field(), Symbol("Omega"), Symbol("xi"))
    omega, xi = ring.gens
    h = [xi, omega - 1, xi + 1, 0 * xi, 1 + 0 * xi]  # (s^2 + 1)(s^2 + xi) + (Omega - 1) s
    found = [polynomial.subs(0, 1) for polynomial in _on_curve(omega - 1, h)]
    assert all(found)
    product = Poly(Mul(*(polynomial.as_expr() for polynomial in found)), Symbol("xi"))
    assert set(product.real_roots()) == {0, 1}


def test_critical_curves_in_closed_form() -> None:
    xi = Symbol("xi")
    assert critical_curve("central_difference").explicit == 2
    assert critical_curve("newmark").explicit == oo
    assert critical_curve("central_difference_lagged").explicit == 2 * sqrt(xi**2 + 1) - 2 * xi
    curve = critical_curve("noh_bathe")
    assert len(curve.relations) == 1
    for damping in (0, "1/7", 2):
        expected = certify("noh_bathe", damping).critical_Omega
        assert (curve.explicit.subs(xi, Rational(damping)) - expected).equals(0)  # pyright: ignore
    curve = critical_curve("forward_euler")
    assert [(piece.low, piece.high, piece.Omega) for piece in curve.pieces] == [
        (0, 0, 0),
        (0, 1, 2 * xi),
        (1, oo, 2 * xi - 2 * sqrt(xi**2 - 1)),
    ]


def test_critical_curve_without_closed_form() -> None:
    curve = critical_curve("rk4")
    assert curve.explicit is None
    xi, omega = Symbol("xi"), Symbol("Omega")
    for damping in (Rational(1, 100), Rational(2, 5), Rational(9, 10), Rational(5)):
        piece = next(p for p in curve.pieces if p.low < damping and (p.high == oo or damping < p.high))
        end = certify("rk4", damping).critical_Omega
        at = Poly(piece.relation.subs(xi, damping), omega)  # pyright: ignore
        assert not at.rem(Poly(minimal_polynomial(end, omega), omega))
