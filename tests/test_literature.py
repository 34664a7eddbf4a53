"""What docs/findings.md says of schemes that papers name, where no other test derives it."""

from fractions import Fraction
from typing import Any

import pytest
from declared import BY_NAME, derived
from named_elsewhere import MSSTH, discontinuous_galerkin_p2_p1, explicit_hht, mssth_weights, pefrl, wat2
from substep_derive import Scheme, certify, derive
from substep_derive.oscillator.evaluation import Evaluation
from substep_derive.oscillator.order import order_of
from substep_derive.stability.all_damping import certify_all_damping
from substep_derive.study.equivalence import MATRIX, SPECTRUM, equivalences
from sympy import I, Matrix, Poly, Rational, Symbol, cancel, eye, integrate, solve, sqrt, symbols, zeros


@pytest.mark.parametrize(
    ("cubic", "first"), [("1/10", 0), ("27/250", 6 * sqrt(62) / 125), ("1/6", 2 * sqrt(6)), ("1/3", 6 * sqrt(3))]
)
def test_a_last_sub_step_by_backward_differences(cubic: str, first: Any) -> None:
    """Stable from 6 sqrt(12 c^2 + 8 c - 1) on, which is 0 at c = (sqrt(7) - 2)/6, and below at every damping ratio."""
    ((low, _, _, _),) = certify("trapezoid_trapezoid_backward", cubic=cubic).intervals
    assert low == first
    c = Rational(cubic)
    assert low**2 == max(36 * (12 * c**2 + 8 * c - 1), 0)
    below = certify_all_damping(BY_NAME["trapezoid_trapezoid_backward"], cubic=cubic).stable_for_all_xi
    assert below == (Fraction(cubic) < (7**0.5 - 2) / 6)


def test_a_composition_that_goes_back_in_time_is_stable_up_to_a_damping_ratio() -> None:
    low, *_, high = certify_all_damping(BY_NAME["tarnow_simo"]).cells
    assert low.stable and not high.stable
    assert float(low.high) == pytest.approx(0.999619849240130, abs=1e-12)
    assert float(high.low) == float(low.high)


@pytest.mark.parametrize("scale", ["2", "4", "5", "23/2"])
def test_structure_dependent_coefficients_that_are_too_soft(scale: str) -> None:
    found, value = certify("gui_lambda", lambda_g=scale).critical_Omega, Rational(scale)
    assert found == (None if value <= 4 else 2 * sqrt(value / (value - 4)))


@pytest.mark.parametrize(
    ("left", "right", "values", "kind"),
    [
        ("ss32", "wilson_theta", "theta, theta**2, theta**3", MATRIX),
        ("ss22", "newmark", "gamma, 2*beta", SPECTRUM),
        ("gui_lambda", "chen_ricles", "4", MATRIX),
        ("alpha_os", "hht_alpha", "alpha", MATRIX),
        ("lsrt2", "sdirk2", "gamma", SPECTRUM),
        ("first_order_generalized_alpha", "oalts", "rho_inf", SPECTRUM),
        ("chang", "newmark", "beta, gamma", SPECTRUM),
    ],
)
def test_which_schemes_they_are(left: str, right: str, values: str, kind: str) -> None:
    (found,) = equivalences([BY_NAME[left], BY_NAME[right]])
    assert (found.left, found.right, found.kind) == (left, right, kind)
    given = found.left_values
    assert ", ".join(str(given[x]) for x in sorted(given, key=lambda s: str(Symbol(str(s))))) == values


@pytest.mark.parametrize("n", [3, 4, pytest.param(5, marks=pytest.mark.thorough)])
def test_mssth_has_its_order_in_free_linear_motion_alone(n: int) -> None:
    """MSSTH(4) and (5) too are of third order with loads and damping."""
    scheme = MSSTH[n]
    assert order_of(Evaluation.at_defaults(scheme), Rational(0)).free[:2] == (n, n)
    assert derive(scheme).order == derive(scheme).nonlinear.uva == (3, 3, 3)
    assert abs(derive(scheme).rho_inf.subs(_numbers(scheme)) - Rational(1, 2)) < 1e-25


def _numbers(scheme: Scheme) -> dict[Symbol, Any]:
    """The defaults of rho_inf and of gamma, which is a root, to 30 digits."""
    rho, gamma = scheme.parameters
    roots = Poly(gamma.default.equation.subs(rho.symbol, rho.default), gamma.symbol).nroots(n=40)
    (root,) = [x for x in roots if x.is_real and gamma.domain.contains(x)]
    return {rho.symbol: rho.default, gamma.symbol: root}


def test_weights_of_mssth_are_those_of_the_paper() -> None:
    """As the paper prints them for n = 3 and 4."""
    y = Symbol("gamma")
    three = -(6 * y**3 - 21 * y**2 + 12 * y - 2) / (12 * y**2), -(6 * y**2 - 9 * y + 2) / (6 * y**2)
    assert all((a - b).cancel() == 0 for a, b in zip(mssth_weights(3), three, strict=False))
    four = (
        -(12 * y**4 - 45 * y**3 + 33 * y**2 - 10 * y + 1) / (24 * y**3),
        -(33 * y**3 - 63 * y**2 + 26 * y - 3) / (24 * y**3),
    )
    assert all((a - b).cancel() == 0 for a, b in zip(mssth_weights(4), four, strict=False))


def test_pefrl_is_of_order_4_symmetric_and_symplectic() -> None:
    found = derive(pefrl())
    assert found.order == found.nonlinear.free == (4, 4, 4)
    assert found.nonlinear.symmetric.holds and found.nonlinear.symplectic.holds
    kick = pefrl().parameters[1]
    roots = Poly(kick.default.equation.subs(Symbol("drift"), Rational("0.1786178958448091")), kick.symbol).nroots(n=30)
    (root,) = [x for x in roots if x.is_real]
    assert float(root) == pytest.approx(-0.2123418310626054, abs=1e-15)  # as the paper prints lambda
    second = (1 - 6 * Rational("0.1786178958448091")) / (24 * root**2)
    assert float(second) == pytest.approx(-0.06626458266981849, abs=1e-14)  # and chi


def test_orders_of_schemes_that_are_not_ours() -> None:
    assert derive(wat2()).nonlinear.uva == (3, 3, 2)
    for scheme in (explicit_hht(), explicit_hht(predicted=True)):
        assert derive(scheme).nonlinear.free[:2] == (2, 2)
        assert derive(scheme).nonlinear.uva == (1, 1, 1)


def test_one_function_of_two_unknowns_has_order_3_and_a_given_limit() -> None:
    """That of Fung's complex time steps with two unknowns, whose order and limit his abstract states."""
    z, mu, p1, p2, q1, q2 = symbols("z mu p1 p2 q1 q2")
    left = (1 + p1 * z + p2 * z**2 - (1 + q1 * z + q2 * z**2) * (1 + z + z**2 / 2 + z**3 / 6)).expand()
    (found,) = solve([*(left.coeff(z, k) for k in range(1, 4)), p2 - mu * q2], [p1, p2, q1, q2], dict=True)
    top, bottom = (x.subs(found) for x in (1 + p1 * z + p2 * z**2, 1 + q1 * z + q2 * z**2))
    for name, limit in {"weighted_residual_p2": Symbol("rho_inf"), "radau_iia2": 0, "lobatto_iiia3": 1}.items():
        free, i = derived(name).A.subs("xi", 0), Symbol("Omega") * I
        assert (
            cancel(free.trace() - (top / bottom).subs({z: i, mu: limit}) - (top / bottom).subs({z: -i, mu: limit})) == 0
        )
    free_motion = order_of(Evaluation.at_defaults(BY_NAME["weighted_residual_p2"].fix({"rho_inf": 1})), Rational(0))
    assert free_motion.free[:2] == (4, 4)


@pytest.mark.parametrize(("rho", "Omega", "xi"), [("1/3", "7/5", "1/20"), ("0", "3", "2"), ("1", "1/2", "0")])
def test_mixed_pade_approximations_on_linear_structures(rho: str, Omega: str, xi: str) -> None:
    """PTIM of order 22 (Song and others 2023, TimeIntgCoeff.m): p(H) y_0 + moments of a quadratic load, over q(H)."""
    w, W, x = Rational(rho), Rational(Omega), Rational(xi)
    H, one = Matrix([[0, 1], [-(W**2), -2 * x * W]]), eye(2)
    top = w * (12 * one + 6 * H + H**2) + (1 - w) * (6 * one + 2 * H)
    bottom = w * (12 * one - 6 * H + H**2) + (1 - w) * (6 * one - 4 * H + H**2)
    R = bottom.inv() * top
    moments = [H.inv() * (R - one)]  # of loads 1, tau and tau^2
    moments += [H.inv() * (moments[0] - one)]
    moments += [H.inv() * (2 * moments[1] - one)]
    scheme = derived("weighted_residual_p2")
    values = {"rho_inf": w, "Omega": W, "xi": x}
    step, load = scheme.A.subs(values), scheme.load.subs(values)
    start = Matrix([[1, 0], [0, 1], [-(W**2), -2 * x * W]])  # the equation of motion at t_n, for h^2 a
    assert step[:2, :] * start == R
    by = {tau: load[:2, k] for k, tau in enumerate(scheme.stencil)}
    by[Rational(0)] = by.get(Rational(0), zeros(2, 1)) + step[:2, 2]
    # Lagrange's quadratics, of t_n, the middle and the end
    for tau, weights in {"0": (1, -3, 2), "1/2": (0, 4, -4), "1": (0, -1, 2)}.items():
        theirs = sum((k * m for k, m in zip(weights, moments, strict=True)), zeros(2, 2))
        assert by[Rational(tau)] == theirs[:, 1]


def test_galerkin_with_displacements_of_degree_2() -> None:
    """Its first moment by hand: of an oscillator without damping, whose displacement at the end is R_11 u_0."""
    scheme = discontinuous_galerkin_p2_p1()
    found, w = derive(scheme), Symbol("Omega")
    assert found.order == found.nonlinear.uva == (3, 3, 3) and found.rho_inf == 1
    assert all(certify(scheme, xi=xi).stable for xi in ("0", "1/50", "1", "20"))
    s, p, v = symbols("s p v")
    u = 1 + integrate(p + s * (v - p), (s, 0, s))  # from u_0 = 1 and h v_0 = 0
    moments = [v + w**2 * integrate(u, (s, 0, 1)), (v - p) + w**2 * integrate(2 * s * u, (s, 0, 1))]
    end = u.subs(s, 1).subs(solve(moments, [p, v], dict=True)[0])
    assert cancel(end - found.A[0, 0].subs("xi", 0)) == 0
    radau = discontinuous_galerkin_p2_p1(radau=True)
    (same,) = equivalences((radau, BY_NAME["radau_iia2"]))
    assert same.kind == MATRIX


def test_what_embedded_weights_of_sdirk4_see_of_a_jump() -> None:
    """A load of 1 from the instant x of a step on: what it adds to v_1 too much, and to both values apart, over h."""
    c = [Rational(x) for x in ("1/4", "3/4", "11/20", "1/2", "1")]
    b = [Rational(x) for x in ("25/24", "-49/48", "125/16", "-85/12", "1/4")]
    b_hat = [Rational(x) for x in ("59/48", "-17/96", "225/32", "-85/12", "0")]

    def after(x: Any, weights: list[Any]) -> Any:
        return sum(w for w, place in zip(weights, c, strict=True) if place > x)

    early, late = Rational(1, 4) - Rational(1, 10**9), Rational(21, 40)
    assert after(early, b) == after(early, b_hat) == 1
    assert float(after(early, b) - (1 - early)) == pytest.approx(1 / 4)
    error, seen = after(late, b) - (1 - late), after(late, b) - after(late, b_hat)
    assert float(error / seen) == pytest.approx(35, abs=0.2)
