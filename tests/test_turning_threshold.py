"""Proved thresholds on a rigid bar, against eigenvalues of other matrices and the polynomial of one force a step."""

import importlib
from typing import Any

import flint
import numpy as np
import pytest
from substep_derive import turning, turning_threshold
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.motion.turning_threshold import FARTHEST, Bar, TurningThreshold, _around_both, _around_one, _zeros
from substep_derive.oscillator.evaluation import Evaluation
from substep_derive.oscillator.spectrum import live_at
from sympy import Rational
from test_turning import STATIC, STEPS, of_unit_states

import substep as ss
from substep.studies import turning as measured

RIGID = 3e4  # Omega, beyond which floats lose digits
module: Any = importlib.import_module("substep_derive.motion.turning_threshold")  # its name is that of the function too


def agrees(found: TurningThreshold, s: ss.Scheme, most: int = 60) -> None:
    """No eigenvalue of the printed step's matrix is beyond 1 up to `low`, and one is at `high`, close above."""
    below = measured.growth(s, np.inf, np.linspace(0.0, float(found.low), most)[1:])
    assert below.max() < 1.0
    if found.high is None:
        return
    assert 0 < found.high - found.low <= found.high / 1000
    assert measured.growth(s, np.inf, float(found.high)) > 1.0


@pytest.mark.parametrize(
    ("name", "given", "turn"),
    [
        ("hht_alpha", {"alpha": "-1/10"}, 0.1947),
        ("generalized_alpha", {"rho_inf": "4/5"}, 0.1511),
        ("generalized_alpha", {"rho_inf": "19/20"}, 0.03493),
        ("bathe", {}, None),
        ("houbolt", {}, None),
    ],
)
def test_thresholds_hold_for_steps_from_the_textbooks(name: str, given: dict[str, str], turn: float | None) -> None:
    found, s = turning_threshold(name, **given), ss.scheme(name, **{k: float(Rational(v)) for k, v in given.items()})
    agrees(found, s)
    if turn is None:
        assert (found.low, found.high, found.text[-3:]) == (FARTHEST, None, "3/4")
    else:
        low, high = found.decimals
        assert found.high and high and low <= found.low < found.high <= high < low + 3e-4 and str(low) in found.text
        assert low < turn < high
    if given.get("rho_inf") != "19/20":  # whose step is not among those
        assert of_unit_states(STEPS[name], RIGID, float(found.low)) < 1.0
        assert found.high is None or of_unit_states(STEPS[name], RIGID, float(found.high)) > 1.0


@pytest.mark.thorough
@pytest.mark.parametrize("name", STATIC)
def test_every_threshold_of_the_catalogue_is_inside_its_bracket(name: str) -> None:
    """Where none is found, floats see none up to there either; what is refused does not fade at small turns."""
    s = ss.scheme(name)
    try:
        agrees(turning_threshold(name), s, 1500)
    except ValueError:
        assert measured.growth(s, np.inf, 1e-3) > 1.0


def test_where_an_error_meets_the_motion_the_proof_ends() -> None:
    """For rho_inf_bathe at 0.4501, where an eigenvalue of the errors and one of the motion become a complex pair."""
    found, s = turning_threshold("rho_inf_bathe"), ss.scheme("rho_inf_bathe")
    assert found.high is None and 0.449 < found.low < 0.451
    assert found.text.startswith(f"proved: none grows up to tau = {found.decimals[0]}; beyond, ")
    step = measured._step(s.info.source)
    values = {k: np.full(2, float(v)) for k, v in s.parameters.items()}
    ends = np.array([0.99, 1.01]) * float(found.low)
    before, after = np.linalg.eigvals(measured._matrices(step, np.full(2, np.inf), ends, values))
    assert abs(before.imag).max() < 1e-7 and (abs(after.imag) > 1e-2).sum() == 2


@pytest.mark.parametrize("name", ["hht_alpha", "wilson_theta", "oalts"])
def test_the_polynomial_of_one_force(name: str) -> None:
    """(n+ d- + n- d+)/2 + tau^2 n+ n-, with d + Omega^2 n of the oscillator."""
    at = Evaluation.at(ParameterSet.of(name, None, {}))
    assert turning(name).once
    rows = [{k: at.field.nearest(c) for k, c in row.items()} for row in live_at(at, at.field.domain.zero)]  # type: ignore
    n, d = ([row.get(power, 0.0) for row in rows] for power in (2, 0))
    points = np.array([[0.3 + 0.4j, 0.7], [-0.9, 0.2], [1.2j, 0.5]])

    def expected(x: complex, tau: complex) -> complex:
        plus, minus = x * np.exp(1j * tau), x * np.exp(-1j * tau)
        (a, b), (c, e) = ([np.polyval(row[::-1], z) for z in (plus, minus)] for row in (n, d))
        return (a * e + b * c) / 2 + tau**2 * a * b

    with flint.ctx.workprec(128):
        p = Bar(at).p
        found = [sum(complex(c(flint.arb(tau.real)).mid()) * x**k for k, c in enumerate(p)) for x, tau in points]
    ratios = np.array(found) / [expected(x, tau.real) for x, tau in points]
    powers = [points[:, 0] ** k for k in range(13)]  # the states that are not live have eigenvalues 0
    assert min(np.abs(ratios / x * (x / ratios)[0] - 1).max() for x in powers) < 1e-9


def test_zeros_are_counted() -> None:
    rng = np.random.default_rng(50)
    for _ in range(20):
        size, phase = rng.uniform(0.2, 1.5, 5), rng.uniform(0, np.pi, 5)
        roots = np.concatenate([size * np.exp(1j * phase), size * np.exp(-1j * phase), rng.uniform(-1.4, 1.4, 2)])
        with flint.ctx.workprec(128):
            p = [flint.acb_poly([float(c) for c in np.poly(roots).real[::-1]])]
            for radius in (Rational(1, 4), Rational(3, 4)):
                near = abs(roots - 1) < radius
                assert _zeros(p, [flint.arb(1)], _around_one(radius)) == near.sum()
                assert _zeros(p, [flint.arb(1)], _around_both(radius)) == (near | (abs(roots) < 1)).sum()


def test_a_zero_on_the_border_is_not_counted() -> None:
    p = [flint.acb_poly([1, 0, 1])]  # +-i
    assert _zeros(p, [flint.arb(1)], _around_both(Rational(1, 4))) is None


def test_a_wrong_matrix_is_not_certified(monkeypatch: pytest.MonkeyPatch) -> None:
    """Houbolt's, whose error across the bar has the eigenvalue 1/2 without a force, with one of 11/10 in its place."""
    right = module._of_forces

    def wrong(*given: Any) -> list[Any]:
        A, *others = right(*given)
        half, beyond = (A.domain.convert(x) for x in (Rational(1, 2), Rational(11, 10)))
        d = A.charpoly()
        assert not sum((c * half ** (len(d) - 1 - k) for k, c in enumerate(d)), A.domain.zero)
        return [A * (beyond / half), *others]

    assert turning_threshold("houbolt").low == FARTHEST
    monkeypatch.setattr(module, "_of_forces", wrong)
    assert turning_threshold("houbolt").low == 0


def test_what_has_no_threshold_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, words in (
        ("central_difference", "central_difference: expected a scheme that can hold a rigid bar, got an explicit one"),
        ("gauss2", "gauss2: expected errors along a rigid bar that fade as tau -> 0, got the factor 1.0"),
        ("chang", "chang: expected forces at displacements"),
    ):
        with pytest.raises(ValueError, match=words):
            turning_threshold(name)
    with pytest.raises(ValueError, match="expected within between 0 and 1"):
        turning_threshold("bathe", within=1)

    def without(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(module, "import_module", without)
    with pytest.raises(ImportError, match=r"pip install 'substep\[proofs\]'"):
        turning_threshold("bathe")
