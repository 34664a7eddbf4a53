"""Deflation of a cubic: its real root and the pair it leaves, next to multiple roots and over all sizes."""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from inner_kernels import from_python
from substep_kernels.shared import eigenvalues_3

EPS = np.finfo(float).eps
RNG = np.random.default_rng(9)
SIZES = 10.0 ** np.arange(-8.0, 9.0, 2.0)
OMEGAS = 10 ** RNG.uniform(-6, 0, 200)
monic_of, pair_of, real_root = map(from_python, (eigenvalues_3._monic, eigenvalues_3._pair, eigenvalues_3._real_root))


def monic(*roots: Any) -> list[Fraction]:
    """Coefficients, highest first, exactly."""
    c = [Fraction(1)]
    for root in roots:
        c = [x - Fraction(root) * y for x, y in zip([*c, Fraction(0)], [Fraction(0), *c], strict=True)]
    return c


def cubics() -> Iterator[tuple[list[Fraction], list[Any]]]:
    """Polynomials and their roots: apart, of all ratios, (nearly) double and triple ones, at 0, 1 and -1."""
    for _ in range(80):
        a, b, c = RNG.uniform(-2, 2, 3)
        yield monic(a, b, c), [a, b, c]
        yield monic(a, a, b), [a, a, b]
        gap = 10 ** RNG.uniform(-12, -1)
        yield monic(a, a + gap, b), [a, a + gap, b]
        yield monic(a, a + gap, a - b * gap), [a, a + gap, a - b * gap]
    for a in (0.0, 1.0, -1.0, 0.3, -7.0):
        yield monic(a, a, a), [a, a, a]
        for b in (0.0, 1.0, -1.0, 0.5):
            yield monic(a, a, b), [a, a, b]
            yield monic(a, b, -b), [a, b, -b]
    for size in SIZES:
        for sign in (1, -1):
            for other in (0.0, 1.0, 0.7, 1e-3):
                yield monic(sign * size, other, -0.3), [sign * size, other, -0.3]
                c = monic(sign * size)  # times a complex pair x +- iy
                x, y = Fraction(float(RNG.uniform(-1, 1))), Fraction(float(other + 1e-4))
                pair = [Fraction(1), -2 * x, x * x + y * y]
                product = [sum(c[i] * pair[k - i] for i in (0, 1) if 0 <= k - i <= 2) for k in range(4)]
                yield product, [sign * size, complex(x, y), complex(x, -y)]


def moves(c: list[Any], roots: list[Any]) -> list[Any]:
    """How far each root moves if the coefficients do by EPS, to the order of its multiplicity."""
    found = []
    for root in roots:
        size = sum(abs(x) * abs(root) ** (3 - i) for i, x in enumerate(c))
        slopes = abs(3 * root**2 + 2 * c[1] * root + c[2]), abs(3 * root + c[1]), mpmath.mpf(1)
        found.append(min((EPS * size / s) ** (mpmath.mpf(1) / k) for k, s in enumerate(slopes, 1) if s > 0))
    return found


@pytest.mark.thorough
def test_the_real_root_and_the_pair_of_any_cubic() -> None:
    """Each root is right to its conditioning; the smaller of a real pair, which is not used, to the larger's size."""
    for exact, _ in cubics():
        c = [float(x) for x in exact]
        scale = 2.0 ** RNG.integers(-20, 20)
        b0, b1 = float(sum(exact)), float(3 * exact[0] + 2 * exact[1] + exact[2])
        monic = monic_of(*(scale * x for x in (*c, b0, b1)))
        (half, less, modulus2, discriminant), third = pair_of(*monic), monic[-1]
        with mpmath.workdps(60):
            given = [mpmath.mpf(x.numerator) / x.denominator for x in exact]
            roots = mpmath.polyroots(given, maxsteps=2000, extraprec=400, error=False)
            allowed = moves(given, roots)
            root = mpmath.sqrt(-mpmath.mpf(discriminant))
            largest = max(abs(x) for x in roots)
            larger = max(abs(half + root), abs(half - root))
            for mine, size in ((mpmath.mpf(third), largest), (half + root, larger), (half - root, larger)):
                nearest = min(range(3), key=lambda k: abs(roots[k] - mine))
                bound = 16 * allowed[nearest] + 8 * EPS * size + 1e-30
                assert abs(mine - roots[nearest]) <= bound, (c, mine, roots, allowed)
            if discriminant > 0:
                assert abs(modulus2 - (half**2 + discriminant)) <= 64 * max(allowed) * max(1, abs(half) + abs(root))
            assert abs(1 + less - modulus2) <= 4 * EPS * max(1, modulus2)


def test_the_real_root_is_the_one_alone() -> None:
    """It is the root farthest from the other two, right to its conditioning: a simple root's unless all three meet."""
    for exact, _ in cubics():
        a2, a1, a0 = (float(x) for x in exact[1:])
        third = real_root(a2, a1, a0)
        assert np.isfinite(third)
        with mpmath.workdps(60):
            given = [mpmath.mpf(1), *map(mpmath.mpf, (a2, a1, a0))]
            roots = mpmath.polyroots(given, maxsteps=2000, extraprec=400, error=False)
            real = [x.real for x in roots if abs(x.imag) <= 1e-20 * abs(x) + mpmath.mpf(10) ** -40]
            middle = sum(roots).real / 3
            alone = max(real, key=lambda x: abs(x - middle))
            size = max(abs(alone - middle), EPS ** (1 / 3) * (abs(a2) + abs(a1) ** 0.5 + abs(a0) ** (1 / 3)))
            ties = [x for x in real if abs(abs(x - middle) - abs(alone - middle)) < 1e-6 * size]
            spread = sum(abs(x) * max(abs(middle), abs(alone)) ** (3 - i) for i, x in enumerate(given))
            assert min(abs(third - x) for x in ties) <= 40 * max(EPS * spread / size**2, EPS * abs(alone), 1e-50)


def test_two_steps_are_enough_for_every_shape() -> None:
    """The root of y^3 + 3 p y = size is right to the last digit for all p, from the smallest to the largest size."""
    for ratio in [*np.linspace(-3, 3, 401), *10.0 ** np.arange(-12, 13), *-(10.0 ** np.arange(-12, 13))]:
        for size in (*10.0 ** np.arange(-60.0, 61.0, 20.0), *RNG.uniform(0.5, 8, 4)):
            p = ratio * size ** (2 / 3)
            y = real_root(0.0, 3 * p, -size)
            with mpmath.workdps(40):
                exact = _positive(mpmath.mpf(3 * p), mpmath.mpf(size))
                assert abs(y - exact) <= 4 * EPS * exact, (ratio, size)
                assert abs(real_root(0.0, 3 * p, size) + exact) <= 4 * EPS * exact


def _positive(p3: Any, size: Any) -> Any:
    y = mpmath.sqrt(max(-p3, 0)) + mpmath.cbrt(size)
    for _ in range(200):
        step = (y**3 + p3 * y - size) / (3 * y**2 + p3)
        y -= step
        if abs(step) <= abs(y) * mpmath.mpf(10) ** -35:
            break
    return y


@pytest.mark.parametrize("third", [-1.0, -0.5, 0.0, 0.4, 0.999, 1.0, 30.0])
def test_a_pair_near_one_keeps_its_digits(third: float) -> None:
    """P = det(I - A) of the pair has the digits of b0 and b1, unless the third root is as near to 1."""
    for omega in OMEGAS:
        P, Q = Fraction(omega) ** 2, Fraction(omega) ** 2 / 7
        if third == 1.0 or (1 - third) ** 2 < 4 * P:
            continue
        r, T = Fraction(third), P + Q
        b0, b1 = P * (1 - r), T * (1 - r) + P
        c = (1, T - 2 - r, 1 - Q + r * (2 - T), -r * (1 - Q))
        monic = monic_of(*(float(x) for x in (*c, b0, b1)))
        (_, less, _, discriminant), found = pair_of(*monic), monic[-1]
        assert found == pytest.approx(third, abs=4 * EPS * max(1.0, abs(third)) / min(1.0, (1 - third) ** 2))
        beside = 1.0 / abs(1 - third)
        if Fraction(1, 2) * min(1, (1 - r) ** 2) > P:
            assert discriminant == pytest.approx(float(P - T * T / 4), rel=32 * EPS * beside**2)
            assert less == pytest.approx(-float(Q), rel=200 * EPS * beside**4)
