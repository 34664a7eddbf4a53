"""Stability at all damping ratios at once, and the critical Omega as a curve over them."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, parameter_sets
from substep_derive.algebra.algebraic import Algebraic, Field
from substep_derive.algebra.points import ring_over
from substep_derive.stability.all_damping import _on_curve, certify_all_damping
from substep_derive.stability.certificate import certify
from substep_derive.stability.critical_curve import critical_curve
from sympy import Mul, Poly, Rational, Symbol, minimal_polynomial, oo, sqrt
from sympy.abc import x


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
    """For rk2, -1 is double at xi = 1/2, 1 at xi = 1, and a curve has a vertical tangent at xi = sqrt(3)/2."""
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
