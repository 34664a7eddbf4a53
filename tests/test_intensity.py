"""Intensity of ground motions: closed forms, quadrature and roots by SciPy, what scales, and wrong input."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, quad, trapezoid
from scipy.interpolate import PPoly
from scipy.optimize import brentq

import substep as ss
from substep.core.units import STANDARD_GRAVITY

G = STANDARD_GRAVITY
MEASURES = ("pga", "pgv", "pgd", "arias", "cav", "d5_95", "d5_75", "start")


def motion(n: int = 60, seed: int = 5) -> np.ndarray:
    """Coarse noise (n,), m/s^2, whose sign changes within most steps."""
    return np.random.default_rng(seed).normal(size=n) * np.hanning(n)


def values(found: object) -> list[float]:
    return [getattr(found, name) for name in MEASURES]


def test_a_constant_pulse() -> None:
    found = ss.intensity(np.full(101, -3.0), dt=0.02)
    expected = [3.0, 6.0, 6.0, math.pi / (2 * G) * 18.0, 6.0, 1.8, 1.4, 0.1]
    assert values(found) == pytest.approx(expected, rel=1e-12)
    assert found.unit == "m/s^2"


def test_one_ramp_through_zero() -> None:
    """a = 1 - 2t for 0 <= t <= 1: v = t - t^2, u = t^2/2 - t^3/3, and the integral of a^2 is (1 - (1 - 2t)^3)/6."""
    found = ss.intensity([1.0, -1.0], dt=1.0)
    at = [(1.0 - math.copysign(abs(1 - 2 * part) ** (1 / 3), 1 - 2 * part)) / 2 for part in (0.05, 0.75, 0.95)]
    expected = [1.0, 0.25, 1 / 6, math.pi / (2 * G) / 3, 0.5, at[2] - at[0], at[1] - at[0], at[0]]
    assert values(found) == pytest.approx(expected, rel=1e-12)


def test_a_displacement_that_turns_within_a_step() -> None:
    """a = 1 - 3t for 0 <= t <= 1: u = (t^2 - t^3)/2 has its peak at t = 2/3, and is 0 again at t = 1."""
    found = ss.intensity([1.0, -2.0], dt=1.0)
    assert (found.pgv, found.pgd) == pytest.approx((0.5, 2 / 27), rel=1e-12)


def test_a_sine_of_whole_periods() -> None:
    """PGV 2A/w, PGD the drift 2 pi n A/w^2, Arias pi A^2 t/(4g), CAV 2A t/pi; the chords cost (w dt)^2/6 at most."""
    A, T, n, dt = 2.5, 0.8, 10, 0.0002
    w, t_end = 2 * math.pi / T, n * T
    found = ss.intensity(A * np.sin(w * dt * np.arange(round(t_end / dt) + 1)), dt)
    expected = [A, 2 * A / w, A * t_end / w, math.pi * A**2 * t_end / (4 * G), 2 * A * t_end / math.pi]
    assert values(found)[:5] == pytest.approx(expected, rel=1e-5)
    assert found.d5_95 == pytest.approx(0.9 * t_end, rel=1e-4)  # each half period holds a twentieth of the integral
    assert found.d5_75 == pytest.approx(0.7 * t_end, rel=1e-4)
    assert found.start == pytest.approx(T / 2, rel=1e-3)


@pytest.mark.parametrize("seed", range(6))
def test_noise_against_quadrature_and_roots(seed: int) -> None:
    """Piecewise polynomials of SciPy, their antiderivatives, extrema and roots; quadrature of |a| step by step.

    The second differences of noise come back, so that their displacement too has its peak within a step.
    """
    a, h = np.diff(motion(seed=seed), n=2 * (seed % 2)), 0.05
    t = h * np.arange(len(a))
    acceleration = PPoly(np.array([np.diff(a) / h, a[:-1]]), t)
    velocity = acceleration.antiderivative()
    displacement = velocity.antiderivative()

    def peak(x: PPoly) -> float:
        at = np.concatenate([t, x.derivative().roots(extrapolate=False)])
        return float(np.abs(x(at[np.isfinite(at)])).max())

    def line(time: float) -> float:
        return float(np.interp(time, t, a))

    def integral(of: str, k: int) -> float:
        ends, zero = (t[k], t[k + 1]), t[k] - a[k] * h / (a[k + 1] - a[k])
        if of == "square":
            return quad(lambda x: line(x) ** 2, *ends)[0]
        return quad(lambda x: abs(line(x)), *ends, points=[zero] if ends[0] < zero < ends[1] else None)[0]

    squares = np.concatenate([[0.0], np.cumsum([integral("square", k) for k in range(len(a) - 1)])])

    def time_of(part: float) -> float:
        k = int((squares < part * squares[-1]).sum()) - 1
        rest = part * squares[-1] - squares[k]
        return float(brentq(lambda x: quad(lambda y: line(y) ** 2, t[k], x)[0] - rest, t[k], t[k + 1], xtol=1e-13))

    start, at_75, at_95 = map(time_of, (0.05, 0.75, 0.95))
    cav = sum(integral("modulus", k) for k in range(len(a) - 1))
    arias = math.pi / (2 * G) * squares[-1]
    expected = [np.abs(a).max(), peak(velocity), peak(displacement), arias, cav, at_95 - start, at_75 - start, start]
    found = ss.intensity(a, h)
    assert values(found) == pytest.approx(expected, rel=1e-9)
    assert found.pgv > np.abs(velocity(t)).max()  # a peak is within a step
    assert seed % 2 == 0 or found.pgd > np.abs(displacement(t)).max()


def test_fine_samples_of_the_same_lines_have_the_same_intensity() -> None:
    """And the measures are those of Simpson's rule on them, whose sign changes at samples only by chance."""
    a, h, times = motion(200), 0.02, 64
    fine = np.interp(np.arange((len(a) - 1) * times + 1) / times, np.arange(len(a)), a)
    found = values(ss.intensity(a, h))
    assert values(ss.intensity(fine, h / times)) == pytest.approx(found, rel=1e-9)
    v = cumulative_simpson(fine, dx=h / times, initial=0.0)
    u = cumulative_simpson(v, dx=h / times, initial=0.0)
    rough = [np.abs(fine).max(), np.abs(v).max(), np.abs(u).max()]
    rough += [math.pi / (2 * G) * trapezoid(fine**2, dx=h / times), trapezoid(np.abs(fine), dx=h / times)]
    assert found[:5] == pytest.approx(rough, rel=1e-3)


def test_what_scales_and_what_shifts() -> None:
    a, h = motion(), 0.05
    base = values(ss.intensity(a, h))
    powers = [1, 1, 1, 2, 1, 0, 0, 0]
    scaled = values(ss.intensity(-3.0 * a, h))
    assert scaled == pytest.approx([3.0**p * x for p, x in zip(powers, base, strict=True)], rel=1e-12)
    slower = values(ss.intensity(a, 2.0 * h))
    assert slower == pytest.approx([2.0**p * x for p, x in zip([0, 1, 2, 1, 1, 1, 1, 1], base, strict=True)], rel=1e-12)
    later = values(ss.intensity(np.concatenate([np.zeros(40), a]), h))
    assert later == pytest.approx([*base[:-1], base[-1] + 40 * h], rel=1e-12)


def test_units_files_and_records(tmp_path: Path) -> None:
    a, h = motion(), 0.05
    path = tmp_path / "motion.txt"
    rows = [f"{h * i:.2f} {x / G:.17g}" for i, x in enumerate(a)]
    path.write_text("\n".join(["# time (s), acc (g)", *rows]), encoding="utf-8")
    base = ss.intensity(ss.Record(h, a))
    assert base == ss.intensity(a, h)
    for found in (ss.intensity(path), ss.intensity(str(path)), ss.intensity(a / G, h, unit="g")):
        assert found.unit == "g"
        assert values(found) == pytest.approx(values(base), rel=1e-12)
    assert repr(base).startswith(f"Intensity(PGA {base.pga:.4g} m/s^2, PGV {base.pgv:.4g} m/s, PGD")


def test_a_record_of_zeros_has_no_duration() -> None:
    found = ss.intensity(np.zeros(10), 0.01)
    assert values(found)[:5] == [0.0] * 5
    assert np.isnan(values(found)[5:]).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0, 2.0],), "expected dt of the record, got none"),
        (([1.0, 2.0], 0.0), "expected dt of the record > 0"),
        (([1.0], 0.1), "at least two samples in one row"),
        (([1.0, math.inf], 0.1), "values of the record to be finite"),
        (([1.0, 2.0], 0.1, "yd/s2"), "expected unit as one of m/s"),
        ((ss.Record(0.1, [1.0, 2.0]), 0.2), "the record's own dt = 0.1 s, got 0.2 s"),
    ],
)
def test_what_is_refused(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ss.intensity(*arguments)
    with pytest.raises(TypeError, match=r"expected a call such as intensity\(accelerations, dt=0.01\)"):
        ss.intensity([1.0], units="g")  # pyright: ignore
