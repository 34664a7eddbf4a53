"""Order, overshoot, bifurcation and stability classes against what the literature says of them."""

from typing import Any

import flint
import numpy as np
import pytest
from declared import BY_NAME, NAMES, UNDAMPED
from substep_derive import derive
from substep_derive.declare.symbols import alpha, gamma
from substep_derive.oscillator.bifurcation import bifurcation
from substep_derive.oscillator.evaluation import Evaluation
from substep_derive.oscillator.order import order_conditions, order_of
from substep_derive.oscillator.overshoot import Overshoot, overshoot
from substep_kernels.facts import CATALOGUE
from sympy import Expr, Float, Poly, Rational, oo, sqrt, symbols, sympify

import substep as ss


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        # Hilber & Hughes 1978; Chung & Hulbert 1993; Kolay & Ricles 2014
        ("hht_alpha", "U0-V1"),
        ("wilson_theta", "U2-V1"),
        ("average_acceleration", "U0-V0"),
        ("bathe", "U0-V0"),
        ("generalized_alpha", "U0-V1"),
        ("kr_alpha", "U1-V0"),
        ("houbolt", "U0-V0"),
    ],
)
def test_overshoot_of_the_literature(name: str, expected: str) -> None:
    assert str(overshoot(Evaluation.free(BY_NAME[name]))) == expected


@pytest.mark.filterwarnings("ignore:.* is unstable at")  # explicit schemes are, and overshoot all the same
@pytest.mark.parametrize("name", NAMES)
def test_overshoot_is_what_a_run_shows(name: str) -> None:
    """The growth of u and v/omega from Omega = 1e3 to 1e5 in the scheme's own first step, and what is committed."""
    s = ss.scheme(name)
    lag = max(back for _, back in s.history) if s.info.start == "scheme" else 0
    sizes = []
    for omega in (1e4, 1e5):
        u, v = [], []
        for start in ({"u0": 1.0, "v0": 0.0}, {"u0": 0.0, "v0": omega}):
            r = ss.march(ss.scene("linear_oscillator", omega=omega, **start), s, dt=1.0, t_end=lag + 1.0)
            u.append(abs(r.u[-1, 0]))
            v.append(abs(r.v[-1, 0]) / omega)
        sizes.append((max(u), max(v)))
    (u0, v0), (u1, v1) = sizes
    grown = [round(float(np.log10(b / a))) if a > 1e-9 and b > 1e-9 else 0 for a, b in ((u0, u1), (v0, v1))]
    assert str(Overshoot(max(grown[0], 0), max(grown[1], 0))) == CATALOGUE[name]["overshoot"]


def test_bifurcation() -> None:
    assert bifurcation(Evaluation.at_defaults("linear_acceleration")) == 2 * sqrt(3)
    assert bifurcation(Evaluation.at_defaults(derive("noh_bathe", p="1/2").scheme)) == 4
    assert bifurcation(Evaluation.at_defaults("bathe")) == oo
    with pytest.raises(ValueError, match="expected values for"):
        bifurcation(Evaluation.free(BY_NAME["newmark_bdf2"]))


def real_root(polynomial: Expr, k: int) -> Expr:
    """The k-th of the real roots, by FLINT: one of degree 120 keeps SymPy busy for seconds."""
    roots: Any = flint.fmpz_poly([int(c) for c in Poly(polynomial).all_coeffs()[::-1]]).complex_roots()
    return Float(sorted(float(r.real.mid()) for r, _ in roots if r.imag.is_zero())[k])


@pytest.mark.parametrize("name", NAMES)
def test_profile_agrees_with_the_compiled_functions(name: str) -> None:
    """The profile as it is committed; that it is what is derived is tested in test_generated."""
    row = CATALOGUE[name]
    stable, A_stable, rho_inf = (
        row["critical_Omega"] == "none",
        row["A_stable"] == "yes",
        float(sympify(row["rho_inf"])),
    )
    s = ss.scheme(name)
    omegas = np.logspace(-3, 5, 400)
    radius = s.spectral_radius(omegas)
    assert row["critical_Omega"] == "0" or stable == bool((radius <= 1 + 1e-9).all())
    if row["critical_Omega"] not in ("none", "0"):
        end = float(sympify(row["critical_Omega"], locals={"CRootOf": real_root}))
        assert s.spectral_radius(0.999 * end) <= 1 + 1e-9 < s.spectral_radius(1.001 * end)
    if np.isfinite(rho_inf):
        assert s.spectral_radius(1e15) == pytest.approx(rho_inf, abs=1e-3)  # eight roots of one number come near 0
    if A_stable:
        assert (s.spectral_radius(omegas, np.array([[0.1], [0.5], [1.0], [3.0]])) <= 1 + 1e-9).all()


@pytest.mark.parametrize("damping", ["0", "1/4"])
@pytest.mark.parametrize("name", NAMES)
def test_derived_order_is_the_observed_one(name: str, damping: str) -> None:
    """Free vibration at a fixed time, u, v and a, from step sizes 1/200 to 1/1600."""
    if name in UNDAMPED and damping != "0":
        with pytest.raises(ValueError, match="without damping: expected xi = 0"):
            ss.march(ss.scene("linear_oscillator", omega=1.0, xi=0.25), ss.scheme(name), dt=0.1, t_end=0.1)
        return
    exact = order_of(Evaluation.at_defaults(name), Rational(damping)).free
    omega, xi = 2.0, float(Rational(damping))
    t = 1.5 if name == "butcher6" else 1.0  # at t = 1 its error in a changes its sign between these steps
    scene = ss.scene("linear_oscillator", omega=omega, xi=xi, u0=0.7, v0=1.1)
    s = np.roots([1.0, 2 * xi * omega, omega**2])
    c = np.linalg.solve([[1, 1], s], [0.7, 1.1])
    truth = [float(np.real((c * s**k * np.exp(s * t)).sum())) for k in range(3)]
    steps = np.array([50, 100, 200, 400]) // (10 if min(exact) > 5 else 1)
    runs = [ss.march(scene, ss.scheme(name), dt=t / n, t_end=t) for n in steps]
    for k, (order, field) in enumerate(zip(exact, ("u", "v", "a"), strict=True)):
        errors = np.array([abs(getattr(r, field)[-1, 0] - truth[k]) for r in runs])
        with np.errstate(divide="ignore", invalid="ignore"):  # an error that is 0
            observed = np.log2(errors[:-1] / errors[1:])[-1]
        assert observed == pytest.approx(order, abs=0.25) or errors[-1] < 1e-12, (field, observed, errors)


def test_order_conditions_with_symbolic_parameters() -> None:
    newmark = order_conditions(BY_NAME["newmark"])
    assert newmark == dict.fromkeys("uva", (2 * gamma - 1,))
    assert order_conditions(BY_NAME["hht_alpha"]) == {"u": (), "v": (), "a": (alpha,)}
    assert order_conditions(BY_NAME["houbolt"]) == dict.fromkeys("uva", ())
    assert order_conditions(BY_NAME["backward_euler"]) == dict.fromkeys("uva", (1,))


@pytest.mark.thorough
def test_order_conditions_are_as_few_as_say_the_same_within_the_intervals() -> None:
    """By hand: the a of generalized-alpha balances between the ends of the step, where it is the mean of both."""
    alpha_m, alpha_f = symbols("alpha_m alpha_f")
    found = order_conditions(BY_NAME["generalized_alpha"])
    assert found["u"] == found["v"] == (2 * alpha_f - 2 * alpha_m - 2 * gamma + 1,)
    assert found["a"] == (2 * gamma - 1, alpha_f - alpha_m)
    assert order_conditions(BY_NAME["newmark_bdf2"])["u"] == (2 * gamma - 1,)  # no factor gamma_t, which is positive
    assert order_conditions(BY_NAME["kr_alpha"]) == {"u": (), "v": (), "a": (1,)}  # no common root
    assert order_conditions(BY_NAME["kr_alpha_plain_start"])["u"] == (1,)  # rho_inf = 3 is outside [0, 1]


def test_error_constants_of_average_acceleration() -> None:
    """Its frequency error is Omega^2/12 (free) and its forced error comes from the same rational function."""
    found = order_of(Evaluation.at_defaults("average_acceleration"), Rational(0))
    assert found.free == found.forced == (2, 2, 2)
    assert (0, Rational(-1, 12)) in [tuple(Rational(str(x)) for x in pair) for pair in found.free_constants[0]]
