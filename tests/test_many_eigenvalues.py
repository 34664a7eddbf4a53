"""More than three live eigenvalues: the stability polynomial, its roots side by side, and the pair that is reported."""

from typing import Any

import mpmath
import numpy as np
import pytest
from declared_steps import amplification, exact, oscillator
from inner_kernels import block_of, from_python
from plain_kernels import uncompiled
from substep_derive import Balance, Scheme, derive
from substep_derive.declare.catalogue import find
from substep_derive.declare.symbols import h, knot, lam
from substep_derive.emit.scheme_module import own_module
from substep_derive.emit.stability_module import eigenvalues_module
from substep_derive.kernels.eigenvalue_kind import EigenvalueKind
from substep_derive.oscillator.amplification import Amplification
from substep_derive.oscillator.spectrum import live
from substep_derive.oscillator.stability_polynomial import rate, stability_polynomial
from substep_kernels.shared import eigenvalues_2_twice, eigenvalues_3_twice
from sympy import Expr, I, Poly, Rational, Symbol, expand, re, simplify
from test_stability import exact_spectrum

import substep as ss
from substep.core import kernel_modules

EPS = np.finfo(float).eps
u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
BACKWARD = {  # backward differences of order 2, 3, 4 (Hairer, Norsett & Wanner, III.1): of the values at 1, 0, -1, ...
    2: [Rational(3, 2), -2, Rational(1, 2)],
    3: [Rational(11, 6), -3, Rational(3, 2), Rational(-1, 3)],
    4: [Rational(25, 12), -4, 3, Rational(-4, 3), Rational(1, 4)],
}


def backward(kind: str, order: int) -> Expr:
    """The backward difference of u or v at the step's end, which is its rate."""
    return sum(c * knot(1 - k)["uva".index(kind)] for k, c in enumerate(BACKWARD[order])) / h


def multistep(of_u: int, of_v: int) -> Scheme:
    """Backward differences of one order give the velocity, those of another the acceleration."""
    carried = [s for k in range(1, 4) for s in knot(-k)[:2] if k < (of_u, of_v)["uv".index(s.name[0])]]
    return Scheme(
        f"backward_{of_u}_{of_v}",
        {v1: backward("u", of_u), a1: backward("v", of_v)},
        (Balance.at(end, 1),),
        start={s: knot(0)["uv".index(s.name[0])] for s in carried},
    )


def with_second_differences() -> Scheme:
    """Velocity and acceleration both from displacements: no method for the first-order system."""
    second = (2 * u1 - 5 * u0 + 4 * knot(-1).u - knot(-2).u) / h**2
    return Scheme(
        "second_differences",
        {v1: backward("u", 4), a1: second},
        (Balance.at(end, 1),),
        start={knot(-k).u: u0 for k in (1, 2, 3)},
    )


@pytest.mark.parametrize(("scheme", "roots"), [("park", 3), ("oalts", 2), (2, 2), (3, 3), (4, 4)])
def test_a_multistep_method_has_its_stability_polynomial(scheme: str | int, roots: int) -> None:
    """rho - s sigma, with the published rho and sigma; for oalts those of its declaration."""
    declared = find(scheme) if isinstance(scheme, str) else multistep(scheme, scheme)
    found = stability_polynomial(live(Amplification.of(declared).charpoly))
    assert found is not None
    assert found.degree() == roots
    if scheme == "oalts":
        rho = Symbol("rho_inf")
        a, b = (4 * rho - 4) / (3 - rho), 2 / ((1 + rho) * (3 - rho))
        expected = lam**2 + a * lam - 1 - a - rate * (b * lam**2 + (2 - 2 * b + a / 2) * lam + a / 2 + b)
    else:
        c = BACKWARD[scheme] if isinstance(scheme, int) else [Rational(k, 6) for k in (10, -15, 6, -1)]
        expected = sum(e * lam ** (len(c) - 1 - k) for k, e in enumerate(c)) - rate * lam ** (len(c) - 1)
    factor = (found.as_expr() / expected).cancel()
    assert not factor.has(lam)
    assert not factor.has(rate)


@pytest.mark.parametrize("scheme", [multistep(2, 3), with_second_differences(), find("houbolt"), find("newmark")])
def test_others_have_none(scheme: Scheme) -> None:
    assert stability_polynomial(live(Amplification.of(scheme).charpoly)) is None


def test_bdf_alpha_is_a_stable_for_every_alpha() -> None:
    """Re s = Re rho/sigma >= 0 wherever a root is on the unit circle, exactly if alpha >= -1/2 (and > -1)."""
    found = stability_polynomial(live(Amplification.of(find("bdf_alpha")).charpoly))
    assert found is not None
    a, t = Symbol("a", real=True), Symbol("t", real=True)  # alpha, and the tangent of half the angle
    cosine, circle = (1 - t**2) / (1 + t**2), (1 + I * t) ** 2 / (1 + t**2)
    p = found.as_expr().subs(Symbol("alpha"), a) / -2
    rho, sigma = p.subs({rate: 0, lam: circle}), -p.diff(rate).subs(lam, 1 / circle)
    assert simplify(re(expand(rho * sigma)) - (1 + a) * (1 + 2 * a) * (1 - cosine) ** 2) == 0


def test_a_factor_that_does_not_move_is_shared() -> None:
    """Eigenvalues that depend on nothing: each half has them once, if their multiplicity is even."""
    s = [Poly(live(Amplification.of(find(name)).charpoly).as_expr(), lam) for name in ("park", "energy_momentum")]
    double, single = (stability_polynomial(s[1] * Poly((2 * lam - 1) ** k, lam)) for k in (2, 1))
    assert single is None
    assert double is not None
    assert double.degree() == 2
    assert double.eval(Rational(1, 2)) == 0


def polynomial(of_u: list[Any], of_v: list[Any], omega: Any, damping: Any) -> list[Any]:
    """Of the eigenvalues, highest first, for v = p(E) u, a = q(E) v in powers of 1/E, the step backwards: by hand.

    The equation of motion is (q p + 2 xi Omega p + Omega^2) u = 0.
    """
    p, q = ([mpmath.mpf(int(c.p)) / int(c.q) for c in map(Rational, row)] for row in (of_u, of_v))
    c = [mpmath.mpf(0)] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        c[i] += 2 * damping * omega * x
        for j, y in enumerate(q):
            c[i + j] += x * y
    c[0] += omega**2
    return c


def companion(c: list[Any]) -> Any:
    """The matrix whose characteristic polynomial this is."""
    n = len(c) - 1
    m = mpmath.zeros(n)
    for k in range(n):
        m[0, k] = -c[k + 1] / c[0]
        if k:
            m[k, k - 1] = 1
    return m


# scheme, and backward differences: of u for v, of v for a (for second_differences none: a = 2 u1 - 5 u0 + ... = q p u)
PLAIN = [*((multistep(*k), k) for k in ((2, 2), (3, 3), (4, 4), (2, 3))), (with_second_differences(), (4, 0))]


@pytest.mark.usefixtures("plain_functions")
@pytest.mark.parametrize(("scheme", "orders"), PLAIN, ids=lambda x: getattr(x, "name", ""))
def test_eigenvalues_of_own_schemes(scheme: Scheme, orders: tuple[int, int]) -> None:
    """Radius, damping and period error from a polynomial made by hand, at all sizes and dampings."""
    module = uncompiled(own_module(scheme))
    shared = uncompiled(eigenvalues_module(EigenvalueKind.named(module.EIGENVALUES)))
    points = [(o, x) for o in (1e-6, 3e-3, 0.11, 0.13, 1.0, 4.0, 1e3, 1e8) for x in (0.0, 0.3, 1.0, 2.5, 60.0)]
    inputs = np.transpose(points).copy()
    n = len(points)
    found, alone = np.full((3, n), np.nan), np.empty((1, n))
    common, errors = kernel_modules.loaded("shared.stability"), kernel_modules.loaded("shared.errors").errors
    first, rest = (common.look, module.polynomial, shared.find), (module.defect, errors)
    given = shared.SIZES, np.empty((4, common.BLOCK)), (0, 1), inputs, np.inf
    with np.errstate(all="ignore"):
        assert not common.stability(*first, shared.eigenvalues, *rest, *given, found, 0, n)[0]
        assert not common.stability(*first, shared.radii, 0, 0, *given, alone, 0, n)[0]
    assert np.array_equal(alone[0], found[0])
    compared = 0
    for i, (omega, damping) in enumerate(points):
        with mpmath.workdps(90):
            o, x = mpmath.mpf(omega), mpmath.mpf(damping)
            if orders[1]:
                c = polynomial(BACKWARD[orders[0]], BACKWARD[orders[1]], o, x)
            else:
                second, first = [2, -5, 4, -1, 0], polynomial(BACKWARD[4], [0], o, x)
                c = [a + b for a, b in zip(second, first, strict=True)]
            compared += check(found[:, i], *exact_spectrum(companion(c)), omega, damping)
    assert compared >= 12


def check(found: Any, values: list[Any], moves: list[Any], omega: float, damping: float) -> bool:
    """One point's radius; and damping and period error, where the largest pair is well apart: then True."""
    largest = max(abs(x) for x in values)
    move = max(d for x, d in zip(values, moves, strict=True) if abs(x) >= largest * (1 - 1e-9))
    assert abs(found[0] - largest) <= max(1e-13 * largest, 40 * move), (omega, damping)
    if damping >= 1:
        assert np.isnan(found[1:]).all()
        return False
    pairs = [(abs(x), x, d) for x, d in zip(values, moves, strict=True) if x.imag > 1e-40 * abs(x)]
    modulus, pair, move = max(pairs, key=lambda entry: entry[0])
    if pair.imag < max(1e-7 * modulus, 40 * move) or sum(m > modulus * (1 - 1e-9) for m, _, _ in pairs) > 1:
        return False
    angle, root = mpmath.arg(pair), mpmath.sqrt(1 - mpmath.mpf(damping) ** 2)
    exact = -mpmath.log(modulus) / angle - damping / root, omega * root / angle - 1
    floor = EPS * omega if omega < 0.125 else 8 * move / modulus / angle * (1 + omega * root / angle) + 4 * EPS
    for value, expected in zip(found[1:], exact, strict=True):
        assert abs(value - expected) <= max(1e-9 * abs(expected), floor * (1 + abs(expected))), (omega, damping)
    return True


@pytest.mark.parametrize("parameter", [None, 0.0, 0.5, 1.0], ids=str)
def test_above_critical_damping_the_radius_is_over_both_rates(parameter: float | None) -> None:
    """There the eigenvalues at the two rates are no longer conjugates; 33 points, so that a block is left over."""
    s = ss.scheme("park") if parameter is None else ss.scheme("oalts", rho_inf=parameter)
    numbers = {} if parameter is None else {Symbol("rho_inf"): exact(parameter)}
    points = [(o, x) for o in (0.0, 1e-5, 0.01, 0.1, 0.5, 2.0, 30.0, 1e3) for x in (0.999, 1.0, 1.5, 20.0)]
    points.append((3.0, 1.1))
    radius = s.spectral_radius(*np.transpose(points))
    for (omega, damping), found in zip(points, radius, strict=True):
        if omega == 0:
            assert found == 1
            continue
        with mpmath.workdps(60):
            system = oscillator(2 * exact(damping) * exact(omega), exact(omega) ** 2)
            matrix = amplification(find(s.name), numbers, system)
            values, moves = exact_spectrum(mpmath.matrix(matrix.tolist()))
            largest = max(abs(x) for x in values)
            assert abs(found - largest) <= max(1e-14 * largest, 20 * max(moves)), (omega, damping)


@pytest.mark.parametrize(("name", "parameters"), [("oalts", {"rho_inf": 1.0}), ("bdf_alpha", {"alpha": -0.5})])
def test_a_pair_on_the_unit_circle_beside_others_that_do_not_move(name: str, parameters: dict[str, float]) -> None:
    """The trapezoidal rule with a double eigenvalue -1, or 0: its damping is 0, and NaN nowhere."""
    Omega = np.concatenate([np.logspace(-6, 2, 200), [0.125, 2.0]])
    radius, damping, period = ss.scheme(name, **parameters).stability(Omega)
    assert (damping == 0).all()
    assert np.abs(radius - 1).max() <= 4 * EPS
    assert period == pytest.approx(ss.scheme("newmark", beta=0.25, gamma=0.5).period_error(Omega), rel=1e-12)


@pytest.mark.parametrize(("name", "module", "n"), [("park", eigenvalues_3_twice, 3), ("oalts", eigenvalues_2_twice, 2)])
@pytest.mark.parametrize("spread", [(-2, 1), (-6, 8)], ids=str)
def test_few_steps_find_all_roots(name: str, module: Any, n: int, spread: tuple[int, int]) -> None:
    """The starts are within some percent, so that three steps of third order and a look suffice; here one more may."""
    start_roots, closer_roots = map(from_python, (module._start_roots, module._closer_roots))
    polynomial = ss.scheme(name).kernels.polynomial
    random = np.random.default_rng(8)
    lanes = np.ones((4 * n + 2, 32))
    for _ in range(16):
        Omega, xi = 10 ** random.uniform(*spread, 32), random.uniform(0, 0.9, 32) * random.choice([0, 1], 32)
        for j in range(32):
            parameters = [random.uniform(0.01, 0.99)] if n == 2 else []
            root = Omega[j] * complex(-xi[j], np.sqrt(1 - xi[j] ** 2))
            point = (Omega[j], xi[j], *parameters, root.real, root.imag)
            lanes[2 * n :, j] = block_of(polynomial, point, 2 * n + 3)[1:]
        s = lanes.ravel().copy()
        start_roots(s)
        steps = [closer_roots(s) for _ in range(6)]
        assert steps[-1] == 0, steps
        before = s.copy()
        closer_roots(s)
        assert np.array_equal(s, before)  # what has converged does not move while others are sought


def test_the_derived_matrix_has_the_same_eigenvalues() -> None:
    """The polynomial of an own scheme with a stability polynomial of degree four, at one point, by NumPy."""
    d, s = derive(multistep(4, 4)), complex(-0.3 * 0.7, 0.7 * np.sqrt(1 - 0.09))
    A = np.array((d.N / d.den).subs({Symbol("Omega"): 0.7, Symbol("xi"): 0.3}).evalf().tolist(), dtype=float)
    polynomial = np.array([float(c) for c in BACKWARD[4]], dtype=complex)
    polynomial[0] -= s
    both = np.concatenate([np.roots(polynomial), np.roots(polynomial).conj()])
    values = np.linalg.eigvals(A)
    assert all(np.abs(values - x).min() < 1e-10 for x in both)
