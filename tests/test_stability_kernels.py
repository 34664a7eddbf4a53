"""The printed stability functions: elementary functions, digits from Omega = 1e-6 to 1e8, conventions, shapes."""

from typing import Any

import mpmath
import numpy as np
import pytest
from declared import BY_NAME, NAMES, UNDAMPED, for_oracle
from inner_kernels import block_of, from_python
from oracle import amplification as stepped
from substep_kernels.shared import eigenvalues_2, errors
from test_stability import exact_spectrum

import substep as ss
from substep.core.eigenvalues import stability_at_points

EPS = np.finfo(float).eps
OF_THE_PAIR = ("numerical_damping", "amplitude_error", "period_error")
RNG = np.random.default_rng(4)


def ulps(value: float, exact: Any) -> float:
    return float(abs(value - exact) / np.spacing(abs(float(exact))))


def spread(low: float, high: float, n: int = 400) -> Any:
    return 10 ** RNG.uniform(np.log10(low), np.log10(high), n)


def test_log1p() -> None:
    log1p = from_python(errors._log1p)
    for u in [*spread(1e-300, 1e300), *-spread(1e-20, 0.99), *RNG.uniform(-0.999, 3, 800), 0.0, -0.5, 1.0]:
        with mpmath.workdps(40):
            assert log1p(u, 1.0 + u) == 0 if u == 0 else ulps(log1p(u, 1.0 + u), mpmath.log1p(u)) < 2
    for m in spread(1e-300, 0.4):  # where 1 - Q has no digits left, from the determinant alone
        with mpmath.workdps(40):
            assert ulps(log1p(-1.0, m), mpmath.log(m)) < 2


def test_angle() -> None:
    angle = from_python(errors._angle)
    y, x = np.concatenate([spread(1e-9, 1e4, 800), RNG.uniform(0, 2, 800)]), RNG.uniform(-2, 2, 1600)
    for b, a in [*zip(y, x, strict=True), (1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1e-300, 1.0)]:
        with mpmath.workdps(40):
            exact = mpmath.atan2(b, a)
            assert angle(b, a) == exact if exact == 0 else ulps(angle(b, a), exact) < 3


@pytest.mark.parametrize("Omega", [1e-6, 1e-2, 0.7, 3.0, 1e4])
def test_the_sign_of_the_polynomial_does_not_matter(Omega: float) -> None:
    _, *coefficients = block_of(ss.scheme("newmark_bdf2").kernels.polynomial, (Omega, 0.1, 0.4, 0.3025, 0.6), 6)
    radius_of = from_python(eigenvalues_2._radius)
    radius, product, split = radius_of(*coefficients)
    assert radius_of(*(-c for c in coefficients)) == (radius, -product, split)


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.7])
@pytest.mark.parametrize("name", NAMES)
def test_digits_from_small_to_large(name: str, damping: float) -> None:
    """Relative errors: radius and period 1e-13, damping 1e-9, beyond the conditioning.

    That is, far from Omega = 0, of the eigenvalue; near it, of coefficients that cancel for parameters
    that are rounded: EPS*Omega in the damping, and in the period error xi times that and EPS*Omega^2.
    """
    s = ss.scheme(name)
    if damping and name in UNDAMPED:
        assert np.isnan(s.stability(1.0, damping)).all()
        return
    omegas = np.concatenate([np.logspace(-6, 8, 29), [0.12, 0.2499, 0.2501, 0.6]])
    radius, added, period = s.stability(omegas, damping)
    other, numbers = for_oracle(BY_NAME[name], {key: float(value) for key, value in s.parameters.items()})
    with mpmath.workdps(120):
        xi = mpmath.mpf(damping)
        root = mpmath.sqrt(1 - xi**2)
        exact_numbers = {key: mpmath.mpf(value) for key, value in numbers.items()}
        for i, omega in enumerate(omegas):
            values, moves = exact_spectrum(mpmath.matrix(stepped(other, mpmath.mpf(omega), xi, exact_numbers)))
            largest = max(abs(x) for x in values)
            move = max(d for x, d in zip(values, moves, strict=True) if abs(x) >= largest * (1 - 1e-9))
            assert abs(radius[i] - largest) <= max(1e-13 * largest, 200 * move), omega
            pairs = [(abs(x), x, d) for x, d in zip(values, moves, strict=True) if x.imag > 1e-40 * abs(x)]
            if not pairs:
                continue
            modulus, pair, move = max(pairs, key=lambda entry: entry[0])
            tied = sum(1 for size, _, _ in pairs if size >= modulus * (1 - 1e-9)) > 1
            if tied or pair.imag <= max(1e-7 * modulus, 40 * move):
                continue
            angle = mpmath.arg(pair)
            damped, longer = -mpmath.log(modulus) / angle - xi / root, omega * root / angle - 1
            wobble = 8 * move / modulus / angle * (1 + omega * root / angle + abs(damped)) + 4 * EPS * (1 + abs(longer))
            near = omega < 0.12
            floors = (EPS * omega * (4 * damping + omega), 4 * EPS * omega) if near else (wobble, wobble)
            assert abs(period[i] - longer) <= max(1e-13 * abs(longer), floors[0]), (omega, period[i], float(longer))
            assert abs(added[i] - damped) <= max(1e-9 * abs(damped), floors[1]), (omega, added[i], float(damped))
            assert abs(damped) > 1e-80 or added[i] == 0, omega  # a conservative pair's damping is exactly 0


@pytest.mark.parametrize("name", NAMES)
def test_conventions(name: str) -> None:
    s = ss.scheme(name)
    for function in OF_THE_PAIR:
        f = getattr(s, function)
        assert f(0.0, 0.0) == 0
        assert np.isnan(f(0.0, 0.4)) if name in UNDAMPED else f(0.0, 0.4) == 0
        assert np.isnan(f([0.0, 0.1, 2.0, 1e3], 1.0)).all()
        assert np.isnan(f([0.0, 0.1, 2.0, 1e3], 1.7)).all()
    damped = s.spectral_radius([0.0, 1e-9, 0.1, 1.0, 1e3], [[0.0], [0.5], [1.0], [2.0]])
    assert np.isfinite(damped[0]).all()
    assert (np.isnan if name in UNDAMPED else np.isfinite)(damped[1:]).all()
    omegas = np.array([[0.01], [0.1], [0.5], [2.0]])
    assert s.amplitude_error(omegas) == pytest.approx(1 - np.exp(-2 * np.pi * s.numerical_damping(omegas)), nan_ok=True)


def test_real_eigenvalues_are_nan_at_every_size() -> None:
    explicit = ss.scheme("newmark", beta=0.0, gamma=0.5)
    beyond = 2.0 + np.logspace(-3, 3, 50)
    assert np.isnan(explicit.period_error(beyond)).all()
    assert np.isnan(explicit.numerical_damping(beyond, 0.1)[5:]).all()
    found = ss.scheme("newmark", beta=0.0, gamma=15.0).period_error([0.05, 0.2])
    assert np.array_equal(np.isnan(found), [False, True])


def test_a_pair_far_from_the_exact_one_near_zero() -> None:
    """Where dissipation is so large that the distance's series would not do."""
    compared = 0
    for gamma in (0.6, 2.0, 4.0, 8.0, 20.0):
        beta, omegas = (gamma + 0.5) ** 2 / 4, np.array([0.001, 0.01, 0.03, 0.06, 0.12])
        _, added, period = ss.scheme("newmark", beta=beta, gamma=gamma).stability(omegas, 0.02)
        for i, omega in enumerate(omegas):
            with mpmath.workdps(50):
                A = stepped("newmark", mpmath.mpf(omega), mpmath.mpf(0.02), {"beta": beta, "gamma": gamma})
                pair = max(mpmath.eig(mpmath.matrix(A), left=False, right=False), key=mpmath.im)
                if pair.imag < 1e-6:
                    assert np.isnan(period[i])
                    continue
                angle, root = mpmath.arg(pair), mpmath.sqrt(1 - mpmath.mpf(0.02) ** 2)
                longer = omega * root / angle - 1
                damped = -mpmath.log(abs(pair)) / angle - mpmath.mpf(0.02) / root
                compared += 1
                assert period[i] == pytest.approx(float(longer), rel=1e-12)
                assert added[i] == pytest.approx(float(damped), rel=1e-12)
    assert compared > 20


@pytest.mark.parametrize("bad", [-1e-300, np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["newmark", "generalized_alpha", "park"])
def test_one_point_that_is_refused_refuses_all(name: str, bad: float) -> None:
    values = np.linspace(0.0, 3.0, 100)
    values[[0, 50]] = -0.0, 0.3
    s = ss.scheme(name)
    assert np.isfinite(s.spectral_radius(values, values)).all()
    values[77] = bad
    for function in (s.spectral_radius, s.stability):
        with pytest.raises(ValueError, match="expected Omega"):
            function(values, 0.1)
        with pytest.raises(ValueError, match="expected xi"):
            function(0.1, values)
        with pytest.raises(ValueError, match="expected xi"):
            function(np.empty(0), bad)


@pytest.mark.parametrize("name", [name for name in NAMES if not BY_NAME[name].fixed])
def test_any_size_and_stride_gives_the_same_bits(name: str) -> None:
    s = ss.scheme(name)
    n = 2049 if name not in ("park", "oalts") else 70
    values = [10 ** RNG.uniform(-3, 2, n), RNG.uniform(0, 0.6, n)]
    values += [np.full(n, float(s.parameters[p])) for p in s.kernels.PARAMETERS]
    whole = _called(s, "stability", values)
    assert np.array_equal(_called(s, "spectral_radius", values)[0], whole[0])
    pieces = [slice(0, 0), slice(3, 4), slice(5, 12), slice(0, 65), slice(1, n - 2), slice(2, n, 3)]
    for kernel, expected in (("spectral_radius", whole[:1]), ("stability", whole)):
        for part in (*pieces, np.argsort(values[0]), values[0] < 0.125, values[0] >= 0.125):
            assert np.array_equal(_called(s, kernel, [v[part] for v in values]), expected[:, part], equal_nan=True)
        single = [_called(s, kernel, [v[i : i + 1] for v in values])[:, 0] for i in range(64)]
        assert np.array_equal(np.transpose(single), expected[:, :64], equal_nan=True)


def _called(s: ss.Scheme, function: str, values: list[Any]) -> Any:
    out = np.empty((3 if function == "stability" else 1, values[0].size))
    stability_at_points(s.kernels, values, np.inf, out, 1.0)
    return out
