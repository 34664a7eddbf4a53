"""Compiled stability functions against 60-digit eigenvalues of stepped matrices."""

from typing import Any

import mpmath
import numpy as np
import pytest
from oracle import SCHEMES as ORACLE
from oracle import amplification as stepped
from published import AMPLITUDE_ERROR_PERCENT, PERIOD_ERROR_PERCENT, RATIOS, SPRADIUS_NEWMARK

import substep as ss

EPS = np.finfo(float).eps
TABLE_4_1 = ((0.25, 0.5), (0.3025, 0.6), (0.36, 0.7), (0.4225, 0.8), (0.49, 0.9))
SETS: list[tuple[str, dict[str, float]]] = [
    ("bathe", {}),
    *(
        ("newmark", {"beta": b, "gamma": g})
        for b, g in (*TABLE_4_1, (1 / 6, 0.5), (1 / 12, 0.5), (0.0, 0.5), (0.7, 0.3))
    ),
    *(("silva_bezerra", {"gamma_t": g}) for g in (0.2, 0.7, 0.9)),
    *(("newmark_bdf2", {"gamma_t": g, "beta": b, "gamma": c}) for g in (0.2, 0.5, 0.8, 0.9) for b, c in TABLE_4_1),
]
OMEGAS = np.concatenate([np.logspace(-4, 6, 41), [0.05, 0.1249, 0.126, 0.7, 1.3, 2.1, 3.3, 4.9]])
DAMPINGS = (0.0, 0.05, 0.7)


def exact_pair(name: str, parameters: dict[str, float], omega: float, damping: float) -> tuple[Any, Any]:
    """(trace, determinant) of the two live eigenvalues; the parameters' doubles are taken as exact."""
    matrix = mpmath.matrix(
        stepped(name, mpmath.mpf(omega), mpmath.mpf(damping), {k: mpmath.mpf(v) for k, v in parameters.items()})
    )
    trace = sum(matrix[i, i] for i in range(matrix.rows))
    square = matrix * matrix
    return trace, (trace**2 - sum(square[i, i] for i in range(matrix.rows))) / 2


def test_every_module_is_covered() -> None:
    assert {name for name, _ in SETS} | {"newmark"} == set(ss.schemes())
    assert set(ss.schemes()) <= set(ORACLE)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize(("name", "parameters"), SETS, ids=str)
def test_sixty_digits(name: str, parameters: dict[str, float], damping: float) -> None:
    s = ss.scheme(name, **parameters)
    got = {
        f: getattr(s, f)(OMEGAS, damping)
        for f in ("spectral_radius", "numerical_damping", "amplitude_error", "period_error")
    }
    with mpmath.workdps(60):
        xi = mpmath.mpf(damping)
        root = mpmath.sqrt(1 - xi**2)
        for i, omega in enumerate(OMEGAS):
            trace, det = exact_pair(name, parameters, omega, damping)
            discriminant = det - trace**2 / 4
            scale = abs(det) + trace**2 / 4
            radius = mpmath.sqrt(det) if discriminant > 0 else abs(trace) / 2 + mpmath.sqrt(-discriminant)
            # beside a double root the argument's last digit moves the radius by eps*scale/sqrt(|discriminant|)
            conditioning = (
                0
                if discriminant > 0
                else min(float(scale / mpmath.sqrt(abs(discriminant))), float(mpmath.sqrt(scale / EPS))) / float(radius)
            )
            assert abs(got["spectral_radius"][i] / radius - 1) <= max(1e-13, 16 * EPS * conditioning), omega
            near = abs(discriminant) <= 64 * EPS * scale  # complex or real is undecided in double precision
            if discriminant <= 0:
                assert near or np.isnan(got["numerical_damping"][i]), omega
                continue
            if near:
                continue
            angle = mpmath.atan2(mpmath.sqrt(discriminant), trace / 2)
            exact = {
                "numerical_damping": -mpmath.log(det) / (2 * angle) - xi / root,
                "period_error": omega * root / angle - 1,
            }
            exact["amplitude_error"] = 1 - mpmath.exp(-2 * mpmath.pi * exact["numerical_damping"])
            wobble = 16 * EPS * float(scale / mpmath.sqrt(discriminant) / angle) * float(omega * root / angle + 1)
            for function, value in exact.items():
                error = abs(got[function][i] - value)
                if value == 0:
                    assert got[function][i] == 0, (function, omega)
                bound = max(1e-6 * abs(value), 1e-9 * EPS, wobble if omega > 0.125 else 0.0)
                assert error <= bound, (function, omega, float(value), float(error))


@pytest.mark.parametrize("name", ["average_acceleration", "bathe"])
def test_published_period_error(name: str) -> None:
    s = ss.scheme("newmark") if name == "average_acceleration" else ss.scheme(name)
    found = 100 * s.period_error(2 * np.pi * np.array(RATIOS))
    assert np.abs(found - PERIOD_ERROR_PERCENT[name]).max() < 0.6e-8 * 10  # eight digits after the point, up to 12 %


def test_published_amplitude_error() -> None:
    found = 100 * ss.scheme("bathe").amplitude_error(2 * np.pi * np.array(RATIOS))
    assert np.abs(found - AMPLITUDE_ERROR_PERCENT["bathe"]).max() < 0.6e-8


def test_published_spectral_radius() -> None:
    found = ss.scheme("newmark", beta=0.3025, gamma=0.6).spectral_radius(2 * np.pi * np.logspace(-3, 3, 10))
    assert np.abs(found - SPRADIUS_NEWMARK).max() < 0.6e-8


def test_on_a_bifurcation_the_square_root_of_eps_is_all_there_is() -> None:
    s = ss.scheme("newmark_bdf2", gamma_t=0.8, beta=0.49, gamma=0.9)
    omegas = np.linspace(3.5, 4.5, 2001)
    real = np.isnan(s.period_error(omegas))
    k = int(np.argmax(real))
    low, high = omegas[k - 1], omegas[k]
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if np.isnan(s.period_error(middle)) else (middle, high)
    with mpmath.workdps(60):
        trace, det = exact_pair("newmark_bdf2", {"gamma_t": 0.8, "beta": 0.49, "gamma": 0.9}, high, 0.0)
        exact = mpmath.sqrt(det) if 4 * det > trace**2 else abs(trace) / 2 + mpmath.sqrt(trace**2 / 4 - det)
    assert abs(float(s.spectral_radius(high) / exact - 1)) < 4 * np.sqrt(EPS)


def test_real_eigenvalues_and_overcritical_damping_give_nan() -> None:
    s = ss.scheme("newmark", beta=0.25, gamma=0.5)
    assert np.isnan(s.period_error(1.0, 1.0))
    assert np.isnan(s.numerical_damping(1.0, 2.0))
    assert np.isnan(ss.scheme("newmark", beta=0.0, gamma=0.5).period_error(2.5))
    assert s.period_error(0.0) == 0 == s.numerical_damping(0.0, 0.3)
    assert s.spectral_radius(0.0) == 1


def test_functions_broadcast() -> None:
    s = ss.scheme("newmark_bdf2", gamma_t=np.array([0.2, 0.5])[:, None, None], beta=0.36, gamma=0.7)
    omega, damping = np.linspace(0.1, 5, 7), np.array([0.0, 0.1, 0.3])[:, None]
    radius = s.spectral_radius(omega, damping)
    assert radius.shape == (2, 3, 7)
    assert s.amplification(omega, damping).shape == (2, 3, 7, 3, 3)
    one = ss.scheme("newmark_bdf2", gamma_t=0.5, beta=0.36, gamma=0.7)
    assert radius[1, 2, 3] == one.spectral_radius(omega[3], 0.3)
    assert np.isscalar(one.spectral_radius(1.0))
    strided = np.linspace(0.1, 5, 14)[::2]
    assert np.array_equal(one.spectral_radius(strided), one.spectral_radius(strided.copy()))
    fortran = np.asfortranarray(np.linspace(0.1, 5, 12).reshape(3, 4))
    assert np.array_equal(one.spectral_radius(fortran), one.spectral_radius(np.ascontiguousarray(fortran)))
    assert one.spectral_radius(np.zeros((0, 3))).shape == (0, 3)
