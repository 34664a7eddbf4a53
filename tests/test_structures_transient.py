"""How far the energy of free motion may rise, against marches of random structures and what is known."""

import re
from fractions import Fraction

import numpy as np
import pytest
from substep_derive import DeclarationError, certify
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.stability.structure_form import OperatorForm, Rows, within_triangle
from substep_derive.stability.structure_growth import oscillator
from substep_derive.stability.structure_storage import squares, storage
from substep_derive.stability.structure_transient import Limits, _largest
from sympy import QQ, sympify

import substep as ss


def risen(name: str, rng: np.random.Generator, n: int, scale: float, bound: Limits | None = None) -> float:
    """The largest energy over that at the start in 40 steps of h = 1 of a random structure, h^2 K about scale.

    bound: (W, D), up to whose border K and C are made as large; the scale then is that of K to C alone.
    """
    X, Y = rng.standard_normal((2, n, n))
    K = scale * (X @ X.T + 0.1 * np.eye(n))
    row = rng.standard_normal((1, n))
    C = rng.choice([0.0, 1.0, 1.0]) * np.sqrt(scale) * row.T @ row
    M = Y @ Y.T + np.eye(n)
    if bound is not None:
        W, D = bound
        load = K / float(W) + C / float(D or 1)
        share = 0.999 / np.linalg.eigvals(np.linalg.solve(M, load)).real.max()
        K, C = share * K, share * C
    u0 = rng.choice([0.0, 1.0]) * rng.standard_normal(n) / np.sqrt(scale)
    s = ss.structure(M, K, C=C, u0=u0, v0=rng.standard_normal(n))
    r = ss.march(s, name, dt=1.0, t_end=40.0)
    energy = np.einsum("ti,ij,tj->t", r.v, M, r.v) + np.einsum("ti,ij,tj->t", r.u, K, r.u)
    return float(energy.max() / energy[0])


def risen_from_any_start(name: str, Omega: float, xi: float, span: float = 50.0) -> float:
    """The largest energy of an oscillator over that at the start, in steps h = 1, from marches of two starts."""
    columns = []
    for u0, v0 in ((1 / Omega, 0.0), (0.0, 1.0)):
        r = ss.march(ss.scene("linear_oscillator", omega=Omega, xi=xi, u0=u0, v0=v0), name, dt=1.0, t_end=span)
        columns.append(np.stack([Omega * r.u[:, 0], r.v[:, 0]], axis=1))
    return float((np.linalg.norm(np.stack(columns, axis=2), ord=2, axis=(1, 2)) ** 2).max())


@pytest.mark.filterwarnings("ignore:.*has dissipated:UserWarning")
@pytest.mark.parametrize(
    ("name", "most"),
    [
        *(
            ("newmark", 1),
            ("bdf2", 10),
            ("oalts", 2),
            pytest.param("bdf_alpha", "413/125", marks=pytest.mark.thorough),
            ("park", 66),
        ),
        ("rk4", "(1 + sqrt(2))^2 = 3 + 2 sqrt(2)"),
        ("bogacki_shampine", "(1 + sqrt(2))^2 = 3 + 2 sqrt(2)"),
        pytest.param("dormand_prince", "(1 + sqrt(2))^2 = 3 + 2 sqrt(2)", marks=pytest.mark.thorough),
        *(pytest.param(name, 1, marks=pytest.mark.thorough) for name in ("bathe", "radau_iia2", "newmark_bdf2")),
    ],
)
def test_energy_stays_below_what_is_proved(name: str, most: int | str) -> None:
    found = certify(name, structures=True)
    assert found.transient.startswith("none: " if most == 1 else f"bounded: the energy is at most {most} times")
    value, rng, scales = (
        float(sympify(str(most).partition(" = ")[0])),
        np.random.default_rng(50),
        (1e-1, 1.0, 1e1, 1e2, 1e4),
    )
    risings = [risen(name, rng, n, scale, found.bound) for n in (2, 3) for scale in scales for _ in range(3)]
    assert max(risings) <= value * (1 + 1e-9)


@pytest.mark.parametrize(
    ("name", "Omega", "xi", "wrong"), [("park", 1.0, 0.0, 1.017), ("bogacki_shampine", 0.5**0.5, 2**0.5, 1.24)]
)
def test_a_bound_that_is_too_small_is_seen(name: str, Omega: float, xi: float, wrong: float) -> None:
    """On one oscillator the energy rises above a bound that some would believe, and stays below what is proved."""
    assert wrong < risen_from_any_start(name, Omega, xi) < 3 + 2 * 2**0.5


def test_a_triangle_that_is_too_large_is_refused() -> None:
    rows = Rows(ParameterSet.of("rk4", None, {}))
    form = OperatorForm.of(rows)
    assert form is not None
    R = np.array([float(Fraction(str(c))) for c in form.numerator.all_coeffs()]) / float(str(form.den.LC()))
    for W, D in ((7, Fraction(64, 23)), (Fraction(81, 10), 2), (4, 3), (Fraction(1, 2), Fraction(11, 4))):
        along = np.linspace(0, 1, 2001)
        border = np.concatenate(
            [1j * np.sqrt(float(W)) * along, (1j * np.sqrt(float(W))) * (1 - along) - float(D) * along]
        )
        inside = bool(np.abs(np.polyval(R, border)).max() <= 1 + 1e-12)
        assert within_triangle(form, rows.field, Fraction(W), Fraction(D)) == inside == (W in (7, Fraction(1, 2)))


def test_the_product_of_two_filters_is_a_difference_and_squares() -> None:
    """On random sequences; and where the real part is negative somewhere there is nothing."""
    rng = np.random.default_rng(3)
    p, q = [QQ(-1, 6), QQ(1), QQ(-5, 2), QQ(5, 3)], [QQ(0), QQ(0), QQ(0), QQ(1)]  # Park's
    G = storage(p, q)
    assert G is not None
    form, w = np.array(G, dtype=float), rng.standard_normal(7)
    found = squares([QQ(5, 3), QQ(-5, 2), QQ(1), QQ(-1, 6)])
    assert found is not None
    for n in range(4):
        now, after, span = w[n : n + 3], w[n + 1 : n + 4], w[n : n + 4]
        product = (span @ np.array(p, float)) * (span @ np.array(q, float))
        lost = sum(float(c) * (span @ np.array(e, float)) ** 2 for c, e in found)
        assert product == pytest.approx(after @ form @ after - now @ form @ now + lost)
    assert storage([QQ(-1, 3), QQ(3, 2), QQ(-3), QQ(11, 6)], q) is None  # bdf3, which is not A-stable


@pytest.mark.parametrize(("name", "least"), [("central_difference", 4), ("newmark_bdf2", 8)])
def test_energy_rises_without_bound_on_damped_oscillators(name: str, least: int) -> None:
    """By the power of t that is said, from runs at two values of t."""
    given = {"gamma_t": "1/5", "beta": "0.3025", "gamma": "3/5"} if name == "newmark_bdf2" else {}
    text = certify(name, structures=True, **given).transient
    p, q, power = map(int, re.findall(r"t\^(-?\d+)", text))
    assert power == least
    s, most = ss.scheme(name, **{k: float(Fraction(v)) for k, v in given.items()}), []
    for t in (30.0, 60.0):
        Omega, xi = t**p, t**q / (2 * t**p)
        runs = []
        for u0, v0 in ((1 / Omega, 0.0), (0.0, 1.0)):
            r = ss.march(
                ss.scene("linear_oscillator", omega=Omega, xi=xi, overdamped=True, u0=u0, v0=v0), s, dt=1.0, t_end=1.0
            )
            runs.append((Omega * r.u[1, 0]) ** 2 + r.v[1, 0] ** 2)
        most.append(max(runs))
    assert np.log2(most[1] / most[0]) == pytest.approx(power, abs=0.2)


@pytest.mark.parametrize("name", ["central_difference_lagged", "beeman", "zhai"])
def test_energy_rises_without_bound_towards_the_end_of_the_bound(name: str) -> None:
    assert "the double eigenvalue -1 of the limit h^2 K -> 4 M" in certify(name, structures=True).transient
    rises = []
    for Omega in (1.99, 1.9999):
        r = ss.march(ss.scene("linear_oscillator", omega=Omega, xi=0.0, u0=1.0, v0=0.3), name, dt=1.0, t_end=400.0)
        rises.append((Omega**2 * r.u[:, 0] ** 2 + r.v[:, 0] ** 2).max())
    assert rises[1] > 5 * rises[0]


@pytest.mark.parametrize(("name", "power"), [("hht_alpha", "U0-V1"), ("wilson_theta", "U2-V1")])
def test_energy_rises_without_bound_where_an_oscillator_overshoots(name: str, power: str) -> None:
    assert f"has the overshoot {power}" in certify(name, structures=True).transient
    for Omega in (1e2, 1e4):
        scene = ss.scene("linear_oscillator", omega=Omega, xi=0.0, u0=1.0, v0=0.0)
        r = ss.march(scene, name, dt=1.0, t_end=1.0)
        assert r.u[1, 0] ** 2 + (r.v[1, 0] / Omega) ** 2 > (Omega / 130) ** 2


@pytest.mark.filterwarnings("ignore:.*has dissipated:UserWarning")
@pytest.mark.parametrize("name", ["houbolt", pytest.param("trbdf3", marks=pytest.mark.thorough)])
def test_what_is_searched_is_what_a_march_does(name: str) -> None:
    """The largest energy over all starts of an oscillator, from marches of two starts that span them."""
    text = certify(name, structures=True).transient
    assert text.startswith("open; of 24 structures") and float(text.partition("energy is ")[2].split()[0]) >= 1.0
    xi, Omega = 0.25, 1.25
    rows = Rows(ParameterSet.of(name, None, {}))
    found = _largest(rows, oscillator(Fraction(25, 16), Fraction(5, 8)))
    assert found == pytest.approx(risen_from_any_start(name, Omega, xi), rel=1e-6)


def test_what_cannot_be_bounded_says_why() -> None:
    assert "refuted" in (found := certify("rk2", structures=True)).text and found.transient.startswith("unbounded: ")
    assert "`derive(scheme).energy.gained`" in certify("rkn43", structures=True).transient
    assert certify("noh_bathe", structures=True).transient.startswith("open; of 24 structures")
    with pytest.raises(DeclarationError, match="expected sums of multiples of the step's symbols"):
        _largest(Rows(ParameterSet.of("kr_alpha", None, {})), oscillator(1))
