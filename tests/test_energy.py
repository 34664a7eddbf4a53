"""A scheme's own energy: that it falls by one factor, what it is for known schemes, and the identities in print."""

from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from declared import ALL
from declared_steps import constants
from dense_steps import march
from substep_derive import derive
from substep_derive.declare.symbols import Omega, beta, gamma, lam, xi
from substep_derive.oscillator.amplification import in_lambda
from substep_derive.oscillator.energy import Energy, NoEnergy, spurious
from sympy import Expr, Matrix, Rational, factor, sympify, zeros

import substep as ss

OMEGA, XI = Rational(3, 5), Rational(1, 25)
# at least two live spurious eigenvalues
WITHOUT = {
    s.name for s in ALL if (np.abs(np.linalg.eigvals(ss.scheme(s.name).amplification(1.3, xi=0.0))) > 1e-4).sum() > 3
}


def at(e: Expr, values: dict[Any, Any]) -> Any:
    return mpmath.mpf(e.subs(values).n(60))


@pytest.mark.parametrize("scheme", ALL, ids=lambda s: s.name)
def test_the_energy_falls_by_one_factor_along_declared_steps(scheme: Any) -> None:
    """The declaration is stepped by an independent program in 40 digits."""
    if scheme.name in WITHOUT:
        with pytest.raises(NoEnergy, match="expected a principal pair and at most one"):
            Energy.of(scheme)
        return
    with mpmath.workdps(45):
        _check_ratio(scheme)


def _check_ratio(scheme: Any) -> None:
    found, damping = Energy.of(scheme), XI if scheme.takes_damping else Rational(0)
    values = {**scheme.typical, **constants(scheme, mpmath), Omega: OMEGA, xi: damping}
    numbers = {s: mpmath.mpf(sympify(e).n(60)) for s, e in values.items()}
    if found.third != 0:
        cubic = [mpmath.mpf(found.third.coeff(spurious, k).subs(values).n(60)) for k in range(3, -1, -1)]
        roots = mpmath.mp.polyroots(cubic, maxsteps=200, extraprec=200)
        values[spurious] = min(roots, key=lambda z: abs(z.imag)).real
    M, C, K = (
        np.array([[mpmath.mpf(x)]], dtype=object) for x in (1, 2 * numbers[xi] * numbers[Omega], numbers[Omega] ** 2)
    )
    one, zero = np.array([mpmath.mpf(1)], dtype=object), np.array([mpmath.mpf(0)], dtype=object)
    rows = march(scheme, numbers, M, C, K, lambda t: zero, mpmath.mpf(1), 7, one, one / 3)
    u, v = ([row[k][0] for row in rows] for k in (0, 1))
    if found.third != 0:
        w = [u[n + 1] - values[spurious] * u[n] for n in range(7)]
        pairs = list(pairwise(w))
    elif "h*v[-1/2]" in found.state:
        pairs = [(u[n], u[n] - u[n - 1]) for n in range(1, 7)]
    else:
        pairs = list(zip(u, v, strict=True))
    uu, uv, vv = (at(found.form[i, j], values) for i, j in ((0, 0), (0, 1), (1, 1)))
    E = [uu * a * a + 2 * uv * a * b + vv * b * b for a, b in pairs]
    for now, after in pairwise(E[2:]):
        assert abs(after - at(found.ratio, values) * now) <= mpmath.mpf("1e-30") * abs(now)


@pytest.mark.parametrize("name", ["newmark", "newmark_bdf2", "wilson_theta", "central_difference_lagged", "houbolt"])
def test_the_identity_is_exact_with_free_parameters(name: str) -> None:
    found = Energy.of(derive(name).scheme)
    A, P = found.A, found.P
    defect = A.T * P * A - found.ratio * P
    numbers = {s: Rational(2 * k + 3, 7 * k + 11) for k, s in enumerate(sorted(defect.free_symbols, key=str))}
    numbers.pop(spurious, None)
    for e in defect.subs(numbers):  # for a cubic: 0 modulo it
        top = e.as_numer_denom()[0].as_poly(spurious) if found.third != 0 else None
        left = e if top is None else top.rem(found.third.subs(numbers).as_poly(spurious)).as_expr()
        assert left == 0


def test_known_energies() -> None:
    unit = Matrix([[Omega**2, Omega * xi], [Omega * xi, 1]])
    for name in ("average_acceleration", "bathe", "esdirk43", "rk4", "theta_method"):  # rational functions of h L
        assert unit == derive(name).energy.P
    assert derive("central_difference").energy.undamped == (
        Matrix([[Omega**2 * (1 - Omega**2 / 4), 0], [0, 1]]).expand(),
        1,
    )
    with_damper = derive("average_acceleration").energy.damping
    half_velocity = Matrix([[-(Omega**2), 2]])  # times (u, h v) it is (v_0 + v_1) h times (1 + Omega xi + Omega^2/4)
    expected = 16 * Omega * xi / (Omega**2 + 4 * Omega * xi + 4) ** 2 * half_velocity.T * half_velocity
    assert (with_damper - expected).applyfunc(factor) == zeros(2)


def test_the_work_of_a_load_closes_the_balance() -> None:
    found = derive("newmark_bdf2", gamma_t="1/3", beta="3/10", gamma="3/5").energy
    values = {Omega: Rational(7, 5), xi: Rational(1, 9)}
    A, B, P, W = (part.subs(values) for part in (found.A, found.B, found.P, found.work))
    x, f = Matrix([2, -3]), Matrix([1, 5, -2])
    free, after = A * x, A * x + B * f
    work = ((after + free).T * W * f)[0]
    assert (after.T * P * after)[0] == found.ratio.subs(values) * (x.T * P * x)[0] + work


def test_newmark_s_identity_as_hughes_prints_it() -> None:
    """Hughes, The Finite Element Method (1987), 9.4: with B = 1 + (beta - gamma/2) Omega^2, in a and v, undamped."""
    d = derive("newmark")
    step = d.A.subs(xi, 0)
    B = 1 + (beta - gamma / 2) * Omega**2
    consistent = Matrix([[1, 0], [0, 1], [-(Omega**2), 0]])  # (u, h v) -> (u, h v, h^2 a)
    after = step * consistent
    form = Matrix([[0, 0, 0], [0, Omega**2, 0], [0, 0, B]])
    jump = Matrix([[after[2, j] - consistent[2, j] for j in (0, 1)]])
    change = after.T * form * after - consistent.T * form * consistent
    assert (change + (2 * gamma - 1) * B * jump.T * jump).applyfunc(factor) == zeros(2)
    own = d.energy.undamped[0].subs(gamma, Rational(1, 2))  # where nothing dissipates it is the scheme's own energy
    hughes = consistent.T * form * consistent / Omega**2
    assert (own - hughes.subs(gamma, Rational(1, 2))).applyfunc(factor) == zeros(2)


def test_generalized_alpha_has_the_energy_of_erlicher_and_others() -> None:
    """Erlicher, Bonaventura & Bursi, Comput. Mech. 28 (2002): alpha-weighted energies, whose decrement is two squares.

    With gamma = 1/2 + g, g = alpha_f - alpha_m, and X_alpha = (1 - alpha) X_(n+1) + alpha X_n for two levels.
    """
    m, f, b, stiffness, half = Rational(1, 5), Rational(2, 5), Rational(3, 8), Rational(16, 9), Rational(1, 2)
    g = f - m
    A = derive("generalized_alpha", alpha_m=m, alpha_f=f, beta=b, gamma=half + g).A.subs({xi: 0, Omega: Rational(4, 3)})
    levels = [A**n for n in range(3)]

    def weighted(alpha: Any, n: int, row: int) -> Matrix:
        return (1 - alpha) * levels[n + 1][row, :] + alpha * levels[n][row, :]

    def square(row: Matrix) -> Matrix:
        return row.T * row

    extra = stiffness * (b - (half + g) / 2)

    def energy(n: int) -> Matrix:
        jump = levels[n + 1][2, :] - levels[n][2, :]
        own = square(weighted(m, n, 2)) + stiffness * square(weighted(f, n, 1)) + extra * square(weighted(f, n, 2))
        return (own + g * (half - f) * square(jump)) / 2

    slip = weighted(f, 1, 2) - weighted(f, 0, 2)
    bend = levels[2][2, :] - 2 * levels[1][2, :] + levels[0][2, :]
    taken = extra * g * square(slip) + g * (half - f) * (half - m) * square(bend)
    assert energy(1) - energy(0) + taken == zeros(3)


def test_the_characteristic_polynomial_vanishes_at_the_spurious_root() -> None:
    d = derive("hht_alpha")
    assert (d.energy.third - in_lambda(d.charpoly).as_expr().subs(lam, spurious)).expand() == 0


@pytest.mark.parametrize("scheme", ALL, ids=lambda s: s.name)
def test_the_mechanical_energy_is_never_larger_than_derived(scheme: Any) -> None:
    """Powers of the step in NumPy, over 3000 steps; where nothing is lost, the bound is what they come to."""
    try:
        found = Energy.of(scheme)
        bound = found.gained
    except NoEnergy as error:
        assert scheme.name in WITHOUT or "a state of u and v" in str(error)
        return
    values = {**scheme.typical, **constants(scheme, mpmath), xi: 0}
    for step in (Rational(2, 7), Rational(9, 10)):
        A, form = (np.array(X.subs({**values, Omega: step}).evalf(20).tolist(), float) for X in (found.A, found.form))
        ratio, most = (float(e.subs({**values, Omega: step}).evalf(30)) for e in (found.ratio, bound))
        if np.linalg.det(form) <= 0.0 or ratio > 1.0 + 1e-12:
            continue  # no complex pair, or unstable: nothing is claimed
        to_energy = np.diag([float(step), 1.0])
        A, power, largest = to_energy @ A @ np.linalg.inv(to_energy), np.eye(2), 1.0
        for _ in range(3000):
            power = A @ power
            largest = max(largest, float(np.linalg.norm(power, 2)) ** 2)
        assert largest <= most * (1.0 + 1e-9)
        assert abs(ratio - 1.0) > 1e-12 or largest > 1.0 + 0.99 * (most - 1.0) - 1e-9


@pytest.mark.thorough
def test_so_many_schemes_never_overshoot_as_the_findings_say() -> None:
    one = 0
    for scheme in ALL:
        with suppress(NoEnergy):
            one += Energy.of(scheme).gained == 1
    findings = (Path(__file__).parents[1] / "docs" / "findings.md").read_text(encoding="utf-8")
    assert f"It is 1 at every Ω and all parameters for {one} schemes of u and v" in findings
