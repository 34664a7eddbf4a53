"""Compiled stability functions against 60-digit eigenvalues of stepped matrices."""

from typing import Any

import flint
import mpmath
import numpy as np
import pytest
from declared import BY_NAME, UNDAMPED, for_oracle
from oracle import amplification as stepped
from published import AMPLITUDE_ERROR_PERCENT, GENERALIZED_ALPHA_LOSS, PERIOD_ERROR_PERCENT, RATIOS, SPRADIUS_NEWMARK

import substep as ss
from substep.core.eigenvalues import PART
from substep.core.norms import spectral_norm

EPS = np.finfo(float).eps
TABLE_4_1 = ((0.25, 0.5), (0.3025, 0.6), (0.36, 0.7), (0.4225, 0.8), (0.49, 0.9))
SETS: list[tuple[str, dict[str, float]]] = [
    *(("newmark", {"beta": b, "gamma": g}) for b, g in (*TABLE_4_1, (0.7, 0.3))),
    *(("silva_bezerra", {"gamma_t": g}) for g in (0.2, 0.7, 0.9)),
    *(("newmark_bdf2", {"gamma_t": g, "beta": b, "gamma": c}) for g in (0.2, 0.5, 0.8, 0.9) for b, c in TABLE_4_1),
    *(("wilson_theta", {"theta": t}) for t in (1.0, 1.4, 2.0, 2.6)),
    *(("generalized_alpha", {"rho_inf": r}) for r in (0.0, 0.5, 1.0)),
    ("generalized_alpha", {"alpha_m": 0.1, "alpha_f": 0.2, "beta": 0.4, "gamma": 0.7}),
    *(("hht_alpha", {"alpha": a}) for a in (-1 / 3, -0.3, 0.0)),
    *(("wbz_alpha", {"alpha_B": a}) for a in (-1.0, -0.3, 0.0)),
    *(
        (name, {"rho_inf": r})
        for name in ("oalts", "kr_alpha", "rho_inf_bathe", "three_substep")
        for r in (0.0, 0.6, 1.0)
    ),
    *(("beta1_beta2_bathe", {"beta1": b, "beta2": 2 * b}) for b in (0.39, 0.5)),
    *(("gholampour", {"delta": d, "alpha_g": a}) for d, a in ((0.4, 0.22), (0.9, 0.5))),
    *(("tchamwa_wielgosz", {"phi": p}) for p in (1.0, 1.5)),
    *(("noh_bathe", {"p": p}) for p in (0.5, 0.54, 0.8)),
    *((name, {}) for name in ss.schemes()),
]
OMEGAS = np.concatenate([np.logspace(-4, 6, 41), [0.05, 0.1249, 0.126, 0.7, 1.3, 2.1, 3.3, 4.9]])
DAMPINGS = (0.0, 0.05, 0.7)
# the sets of the foundation, at every Omega; the others at each third
DENSE = ("newmark", "bathe", "silva_bezerra", "newmark_bdf2")


def polynomial_roots(c: list[Any]) -> list[Any]:
    """All roots to 80 digits, by FLINT, which encloses them; the first coefficient is that of the highest power.

    Raises ValueError for a root that is exactly double.
    """
    with flint.ctx.workprec(400):
        exact = [flint.arb((-int(m) if sign else int(m), int(e))) for sign, m, e, _ in (x._mpf_ for x in c)]
        found = flint.acb_poly(exact[::-1]).roots(tol=1e-80)
        return [mpmath.mpc(*(mpmath.mpf(x.mid().str(90, radius=False)) for x in (r.real, r.imag))) for r in found]


def exact_spectrum(matrix: Any) -> tuple[list[Any], list[Any]]:
    """Nonzero eigenvalues, and how far each moves if the coefficients of its polynomial move by EPS."""
    m = matrix.rows
    c, power = [mpmath.mpf(1)], mpmath.eye(m)  # Faddeev and LeVerrier
    for k in range(1, m + 1):
        power = matrix * power
        c.append(-sum(power[i, i] for i in range(m)) / k)
        power += c[-1] * mpmath.eye(m)
    largest = max(abs(x) ** (mpmath.mpf(1) / max(k, 1)) for k, x in enumerate(c))
    while abs(c[-1]) <= mpmath.mpf(10) ** -84 * largest ** (len(c) - 1):
        c.pop()
    try:
        roots = polynomial_roots(c)
    except ValueError:  # an exactly double root
        everything = sorted(mpmath.eig(matrix, left=False, right=False), key=abs)
        roots = everything[m + 1 - len(c) :]
    derivatives = [c]
    for _ in range(len(c) - 1):
        last = derivatives[-1]
        derivatives.append([x * (len(last) - 1 - i) for i, x in enumerate(last[:-1])])
    moves = []
    for root in roots:
        size = sum(abs(x) * abs(root) ** (len(c) - 1 - i) for i, x in enumerate(c))
        bounds = []
        for k, d in enumerate(derivatives[1:], start=1):
            taylor = abs(mpmath.polyval(d, root)) / mpmath.factorial(k)
            if taylor > 0:
                bounds.append((EPS * size / taylor) ** (mpmath.mpf(1) / k))
        moves.append(min(bounds))
    return roots, moves


def test_every_scheme_is_covered() -> None:
    assert {name for name, _ in SETS} == set(ss.schemes())


def check(value: float, exact: Any, bound: Any, *context: object) -> None:
    assert abs(value - exact) <= bound, (*context, value, float(exact), float(abs(value - exact)), float(bound))


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize(("name", "parameters"), SETS, ids=str)
def test_sixty_digits(name: str, parameters: dict[str, float], damping: float) -> None:
    s = ss.scheme(name, **parameters)
    if damping and name in UNDAMPED:
        assert np.isnan([s.spectral_radius(OMEGAS, damping), *s.stability(OMEGAS, damping)]).all()
        assert np.isnan(s.amplification(1.0, damping)).all()
        return
    functions = ("spectral_radius", "numerical_damping", "amplitude_error", "period_error")
    omegas = OMEGAS if name in DENSE else OMEGAS[::3]
    got = {function: getattr(s, function)(omegas, damping) for function in functions}
    declared = BY_NAME[name]
    other, numbers = for_oracle(declared, {key: float(value) for key, value in s.parameters.items()})
    with mpmath.workdps(90):
        xi = mpmath.mpf(damping)
        root = mpmath.sqrt(1 - xi**2)
        exact_numbers = {key: mpmath.mpf(value) for key, value in numbers.items()}
        for i, omega in enumerate(omegas):
            matrix = mpmath.matrix(stepped(other, mpmath.mpf(omega), xi, exact_numbers))
            values, moves = exact_spectrum(matrix)
            radius = max(abs(x) for x in values)
            move = max(d for x, d in zip(values, moves, strict=True) if abs(x) >= radius * (1 - 1e-9))
            beside = move > 20 * EPS * radius
            # 1e-13 away from a double root; beside one, and for rounded parameters, the conditioning
            slack = (16 if beside else 0) if name in DENSE else 200
            check(got["spectral_radius"][i], radius, max(1e-13 * radius, slack * move), omega)
            pairs = [(abs(x), x, d) for x, d in zip(values, moves, strict=True) if x.imag > 1e-40 * abs(x)]
            if not pairs:
                doubtful = (
                    max(d / abs(x) for x, d in zip(values, moves, strict=True)) > 1e-9
                )  # next to a double root, real and complex cannot be distinguished
                assert doubtful or np.isnan(got["numerical_damping"][i]), omega
                continue
            modulus, pair, move = max(pairs, key=lambda entry: entry[0])
            tied = sum(1 for size, _, _ in pairs if size >= modulus * (1 - 1e-9)) > 1
            if tied or abs(pair.imag) <= max(1e-7 * modulus, 40 * move):
                continue
            angle = mpmath.arg(pair)
            exact = {
                "numerical_damping": -mpmath.log(modulus) / angle - xi / root,
                "period_error": omega * root / angle - 1,
            }
            exact["amplitude_error"] = 1 - mpmath.exp(-2 * mpmath.pi * exact["numerical_damping"])
            wobble = 40 * move / modulus / angle * (1 + omega * root / angle + abs(exact["numerical_damping"]))
            # damping far below the period error's size is rounding of the latter for three eigenvalues and more,
            # and a coefficient that would vanish leaves its rounding where parameters are rounded
            floor = 1e-9 * EPS if name in DENSE else EPS * omega
            for function, value in exact.items():
                error = wobble if omega > 0.125 else floor
                if function == "amplitude_error":
                    error *= 2 * mpmath.pi * (1 - value)
                if abs(value) < 1e300:
                    check(got[function][i], value, max(1e-6 * abs(value), error), function, omega)
                if abs(value) < 1e-45:
                    assert got[function][i] == 0, (function, omega)


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


@pytest.mark.parametrize("rho", GENERALIZED_ALPHA_LOSS)
def test_published_loss_of_generalized_alpha(rho: float) -> None:
    found = 1 - ss.scheme("generalized_alpha", rho_inf=rho).spectral_radius(2 * np.pi * 0.01)
    assert found == pytest.approx(GENERALIZED_ALPHA_LOSS[rho], rel=0.005)  # three printed digits


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
        numbers = {key: mpmath.mpf(float(value)) for key, value in s.parameters.items()}
        matrix = mpmath.matrix(stepped("newmark_bdf2", mpmath.mpf(high), mpmath.mpf(0), numbers))
        exact = max(abs(x) for x in exact_spectrum(matrix)[0])
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


def test_far_below_the_range_nothing_is_lost() -> None:
    """At Omega = 1e-9 the trace alone no longer distinguishes complex from real; P = det(I - A) does."""
    for s in (ss.scheme("bathe"), ss.scheme("newmark", beta=0.25, gamma=0.5)):
        leading = {"bathe": 1 / 24, "newmark": 1 / 12}[s.name]
        assert s.period_error(1e-9) == pytest.approx(leading * 1e-18, rel=1e-6)


def test_powers_stay_bounded_unless_an_eigenvalue_on_the_circle_is_multiple() -> None:
    average, central = ss.scheme("average_acceleration"), ss.scheme("central_difference")
    omegas = np.array([0.1, 1.0, 30.0])
    assert np.allclose(average.power_norm(omegas, n=200), average.power_norm(omegas, n=2000), rtol=1e-6)
    growth = central.power_norm(2.0, n=1000) / central.power_norm(2.0, n=100)
    assert growth == pytest.approx(10, rel=0.02)
    assert central.power_norm(1.9, n=1000) < 20
    assert central.power_norm(3.0, n=1000) == np.inf
    together = central.power_norm([1.9, 2.0, 3.0], n=1000)  # one that overflows does not end the others' powers
    assert np.array_equal(together, [central.power_norm(x, n=1000) for x in (1.9, 2.0, 3.0)])
    assert ss.scheme("bathe").power_norm(omegas).shape == (3,)
    with pytest.raises(ValueError, match="Omega > 0"):
        average.power_norm(0.0)
    with pytest.raises(ValueError, match="number of powers >= 1"):
        average.power_norm(1.0, n=0)


@pytest.mark.parametrize("m", [2, 3, 4])
def test_spectral_norm_keeps_its_digits(m: int) -> None:
    """Orthogonal matrices around given singular values, equal ones and nearly equal ones among them."""
    rng = np.random.default_rng(m)
    for given in ([1, 1, 0], [1, 1, 1], [1, 0, 0], [1, 1 - 1e-8, 0], [1, 1 - 1e-8, 1 - 1e-8], [1, 0.5, 0.5], [0, 0, 0]):
        singular = np.array([*given, 0.0][:m])
        U, V = (np.linalg.qr(rng.normal(size=(200, m, m)))[0] for _ in "UV")
        for scale in (1e-200, 1.0, 1e300):  # whose squares underflow and overflow
            found = spectral_norm((U * (scale * singular)) @ V)
            # a singular value moves by the rounding of U and V and of the product, some 2.2e-16 of the largest each
            assert np.abs(found / scale - singular[0]).max() <= 4e-15, (given, scale)
    assert spectral_norm(np.full((1, m, m), np.nan)) == np.inf


@pytest.mark.parametrize(("name", "Omega"), [("average_acceleration", 1.25), ("newmark_bdf2", 0.3), ("park", 0.5)])
def test_power_norm_is_that_of_every_power(name: str, Omega: float) -> None:
    """Against powers taken in 30 digits, of numbers that end within, at and after a block of powers."""
    s, n = ss.scheme(name), 150
    with mpmath.workdps(30):
        d = mpmath.diag([mpmath.mpf(Omega) ** (1 - kind) for kind, _ in s.history])
        A = d * mpmath.matrix(s.amplification(Omega).tolist()) * d**-1
        power, norms = A, []
        for _ in range(n):
            G = power.T * power
            norms.append(mpmath.sqrt(max(mpmath.eigsy(G, eigvals_only=True))))
            power = power * A
    # n products round n times
    assert s.power_norm(Omega, n=n) == pytest.approx(float(max(norms)), rel=n * 2.2e-16)
    for few in (1, 2, 64, 65):
        assert s.power_norm(Omega, n=few) == pytest.approx(float(max(norms[:few])), rel=n * 2.2e-16)


def test_all_three_in_one_pass() -> None:
    for name in ("newmark_bdf2", "generalized_alpha", "park"):
        s = ss.scheme(name)
        three = s.stability(np.logspace(-3, 2, 9), [[0.0], [0.3], [1.0]])
        apart = [f(np.logspace(-3, 2, 9), [[0.0], [0.3], [1.0]]) for f in (s.spectral_radius, s.numerical_damping)]
        apart.append(s.period_error(np.logspace(-3, 2, 9), [[0.0], [0.3], [1.0]]))
        assert all(
            np.array_equal(x, y, equal_nan=True) and x.shape == (3, 9) for x, y in zip(three, apart, strict=True)
        )
        assert all(np.isscalar(x) for x in s.stability(0.5, 0.1))


def test_inputs_of_any_layout_are_read_and_left_alone() -> None:
    omegas = np.logspace(-2, 2, 24).reshape(4, 6)
    gamma = np.linspace(0.5, 0.6, 6)
    s = ss.scheme("newmark_bdf2", gamma=gamma)
    expected = s.stability(omegas, 0.1)
    frozen = omegas.copy()
    frozen.flags.writeable = False
    wide = np.repeat(omegas, 2, axis=1)
    unaligned = np.frombuffer(b"x" + omegas.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(4, 6)
    layouts = (
        *(omegas, frozen, np.asfortranarray(omegas), wide[:, ::2], omegas[::-1][::-1], unaligned, omegas.tolist()),
        omegas.astype(">f8"),
    )
    for given in layouts:
        before = np.array(given)
        found = s.stability(given, np.full((4, 1), 0.1))
        assert all(np.array_equal(x, y, equal_nan=True) for x, y in zip(found, expected, strict=True))
        assert np.array_equal(given, before)
    assert omegas.flags.writeable
    assert not frozen.flags.writeable
    mine = s.stability(omegas, 0.1)[0]
    mine[:] = 7.0  # what is returned is the caller's own
    assert np.array_equal(s.stability(omegas, 0.1)[0], expected[0])
    assert s.stability(omegas[1, 2], 0.1)[1].shape == gamma.shape
    assert ss.scheme("newmark").stability(np.float64(0.3))[0] == ss.scheme("newmark").spectral_radius([0.3])[0]
    for empty in (np.zeros((0, 6)), np.zeros((4, 0, 6))):
        assert all(x.shape == empty.shape for x in s.stability(empty, 0.1))
    with pytest.raises(ValueError, match=r"shapes that broadcast, got Omega \(4, 5\).*gamma \(6,\)"):
        s.stability(omegas[:, :5])
    for wrong, message in ((np.array([1.0, np.nan]), "finite"), (-1.0, ">= 0"), ("a", "real number"), (1j, "real")):
        with pytest.raises(ValueError, match=message):
            ss.scheme("newmark").stability(wrong)


@pytest.mark.parametrize("n", [PART + 1, 4 * PART, 5 * PART + 12345])
def test_threads_and_parts_give_the_same_bits(n: int) -> None:
    """Whatever part of the array a thread takes, and whether a parameter is one number or an array."""
    omegas = 10 ** np.random.default_rng(1).uniform(-3, 2, n)
    s = ss.scheme("generalized_alpha", rho_inf=0.6)
    whole = s.stability(omegas, 0.05)
    arrays = {key: np.full(n, value) for key, value in s.parameters.items()}
    again = ss.scheme("generalized_alpha", **arrays).stability(omegas, np.full(n, 0.05))
    few = [*range(5), *range(PART - 3, PART + 1), *range(n - 5, n)]
    for x, y, alone in zip(whole, again, s.stability(omegas[few], 0.05), strict=True):
        assert np.array_equal(x, y, equal_nan=True)
        assert np.array_equal(x[few], alone, equal_nan=True)
