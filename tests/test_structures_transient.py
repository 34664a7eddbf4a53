"""How far the energy of free motion may rise, against marches of random structures and what is known."""

from fractions import Fraction

import numpy as np
import pytest
from substep_derive import certify
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.stability.structure_form import Rows
from substep_derive.stability.structure_growth import oscillator
from substep_derive.stability.structure_transient import _largest

import substep as ss


def risen(name: str, rng: np.random.Generator, n: int, scale: float) -> float:
    """The largest energy over that at the start in 40 steps of h = 1 of a random structure, h^2 K about scale."""
    X, Y = rng.standard_normal((2, n, n))
    K = scale * (X @ X.T + 0.1 * np.eye(n))
    row = rng.standard_normal((1, n))
    C = rng.choice([0.0, 1.0, 1.0]) * np.sqrt(scale) * row.T @ row
    M = Y @ Y.T + np.eye(n)
    u0 = rng.choice([0.0, 1.0]) * rng.standard_normal(n) / np.sqrt(scale)
    s = ss.structure(M, K, C=C, u0=u0, v0=rng.standard_normal(n))
    r = ss.march(s, name, dt=1.0, t_end=40.0)
    energy = np.einsum("ti,ij,tj->t", r.v, M, r.v) + np.einsum("ti,ij,tj->t", r.u, K, r.u)
    return float(energy.max() / energy[0])


@pytest.mark.filterwarnings("ignore:.*has dissipated:UserWarning")
@pytest.mark.parametrize(
    ("name", "most"),
    [
        *(("newmark", 1), ("bdf2", 10), ("oalts", 2), ("bdf_alpha", Fraction(413, 125))),
        *(pytest.param(name, 1, marks=pytest.mark.thorough) for name in ("bathe", "radau_iia2", "newmark_bdf2")),
    ],
)
def test_energy_stays_below_what_is_proved(name: str, most: Fraction) -> None:
    text = certify(name, structures=True).transient
    assert text.startswith("none: " if most == 1 else f"bounded: the energy is at most {most} times")
    rng = np.random.default_rng(50)
    found = [risen(name, rng, n, scale) for n in (2, 3) for scale in (1e-1, 1.0, 1e1, 1e2, 1e4) for _ in range(3)]
    assert max(found) <= float(most) * (1 + 1e-9)


@pytest.mark.parametrize(("name", "power"), [("hht_alpha", "U0-V1"), ("wilson_theta", "U2-V1")])
def test_energy_rises_without_bound_where_an_oscillator_overshoots(name: str, power: str) -> None:
    assert f"has the overshoot {power}" in certify(name, structures=True).transient
    for Omega in (1e2, 1e4):
        scene = ss.scene("linear_oscillator", omega=Omega, xi=0.0, u0=1.0, v0=0.0)
        r = ss.march(scene, name, dt=1.0, t_end=1.0)
        assert r.u[1, 0] ** 2 + (r.v[1, 0] / Omega) ** 2 > (Omega / 130) ** 2


@pytest.mark.filterwarnings("ignore:.*has dissipated:UserWarning")
@pytest.mark.parametrize("name", ["park", "tchamwa_wielgosz", "linear_acceleration"])
def test_what_is_searched_is_what_a_march_does(name: str) -> None:
    """The largest energy over all starts of an oscillator, from marches of two starts that span them."""
    text = certify(name, structures=True).transient
    assert text.startswith("open; of 24 structures") and float(text.partition("energy is ")[2].split()[0]) >= 1.0
    xi, Omega = 0.25, 1.25
    rows = Rows(ParameterSet.of(name, None, {}))
    found = _largest(rows, oscillator(Fraction(25, 16), Fraction(5, 8)))
    columns = []
    for u0, v0 in ((1 / Omega, 0.0), (0.0, 1.0)):
        r = ss.march(ss.scene("linear_oscillator", omega=Omega, xi=xi, u0=u0, v0=v0), name, dt=1.0, t_end=50.0)
        columns.append(np.stack([Omega * r.u[:, 0], r.v[:, 0]], axis=1))
    norms = np.linalg.norm(np.stack(columns, axis=2), ord=2, axis=(1, 2)) ** 2
    assert found == pytest.approx(norms.max(), rel=1e-6)


def test_what_is_not_searched_says_why() -> None:
    assert "refuted" in (found := certify("rk2", structures=True)).text and found.transient.startswith("unbounded: ")
    assert "`derive(scheme).energy.gained`" in certify("rkn43", structures=True).transient
    assert "open; not searched, for there are oscillators" in certify("noh_bathe", structures=True).transient
    for name in ("zhai", "houbolt"):
        assert "open; not searched, for what is kept" in certify(name, structures=True).text
