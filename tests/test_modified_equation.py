"""The modified equation against the linear step's eigenvalues, runs in 40 digits, and what is known of energies."""

from typing import Any

import mpmath
import numpy as np
import pytest
from declared import BY_NAME, NAMES, OF_STIFFNESS, UNDAMPED
from declared_steps import System, amplification, march, oscillator
from nonlinear_systems import defaults
from substep_derive import DeclarationError, ModifiedEquation, ModifiedMotion, Scene, derive, rate
from substep_derive.algebra.algebraic import generator
from substep_derive.motion.discrete import discrete_gradient
from substep_derive.nonlinear.modified import modified_equation
from substep_derive.oscillator.evaluation import Evaluation
from sympy import Rational, lambdify, simplify, symbols, sympify

import substep as ss

x, y = symbols("x y")
TOP = 5

PLANE = Scene(
    "plane_with_cubic_terms",
    coordinates={x: "m", y: "m"},
    kinetic=(rate(x) ** 2 + rate(y) ** 2) / 2,
    potential=2 * x**2 + y**2 + x**2 * y / 3 + x * y**3 / 5 + x**4 / 4,
    parameters=(),
    start={x: Rational(11, 10), y: Rational(1, 10), rate(x): Rational(-2, 5), rate(y): Rational(4, 5)},
    length=1,
)
LINE = Scene(
    "line_with_cubic_terms",
    coordinates={x: "m"},
    kinetic=rate(x) ** 2 / 2,
    potential=2 * x**2 + x**3 / 3 + x**4 / 4,
    parameters=(),
    start={x: Rational(11, 10), rate(x): Rational(-2, 5)},
    length=1,
)


def linear(equation: ModifiedEquation, h: Any, xi: Any) -> tuple[Any, Any]:
    """(a, b) of u'' = a u + b u' on N(u) = u, C = 2 xi, at a step h; numbers of mpmath."""

    def value(tree: int) -> tuple[Any, Any]:
        kind, branches = equation.of.keys[tree]
        if kind in "uv":
            return (1, 0) if kind == "u" else (0, 1)
        if len(branches) != 1:  # the force, or a derivative of it that a linear one does not have
            return int(not branches), 0
        factor = 2 * xi if kind == "C" else 1
        (branch,) = branches
        by_u, by_v = value(branch)
        return factor * by_u, factor * by_v

    a, b = mpmath.mpf(-1), -2 * xi
    number = equation.evaluation.field.expression
    given = defaults_of_root(equation)
    for power, level in equation.terms.items():
        for tree, c in level.items():
            by_u, by_v = value(tree)
            factor = h**power * mpmath.mpf(lambdify([*given], number(c), "mpmath")(*given.values()))
            a, b = a + factor * by_u, b + factor * by_v
    return a, b


def defaults_of_root(equation: ModifiedEquation) -> dict[Any, Any]:
    """The value of the field's root, if it has one."""
    root = getattr(equation.evaluation.field, "root", None)
    if root is None:
        return {}
    while root.high - root.low > Rational(1, 10**60):
        root.narrow()
    return {generator: mpmath.mpf(int(root.low.numerator)) / int(root.low.denominator)}


@pytest.mark.parametrize("xi", ["0", "0.3"])
@pytest.mark.parametrize("name", NAMES)
def test_on_a_linear_oscillator_it_has_the_step_s_eigenvalues(name: str, xi: str) -> None:
    if name in UNDAMPED and xi != "0":
        pytest.skip("takes no damping")
    scheme = BY_NAME[name]
    equation = modified_equation(Evaluation.at_defaults(scheme), TOP, damping=xi != "0")
    with mpmath.workdps(60):
        off = []
        for steps in (64, 128):
            h, damping = mpmath.mpf(1) / steps, mpmath.mpf(xi)
            step = amplification(scheme, defaults(scheme, True), oscillator(2 * damping * h, h**2))
            mu = [mpmath.log(root) / h for root in mpmath.eig(mpmath.matrix(step.tolist()), left=False, right=False)]
            exact = [-damping + s * mpmath.sqrt(damping**2 - 1) for s in (1, -1)]
            principal = [min(mu, key=lambda z, e=e: abs(z - e)) for e in exact]
            a, b = linear(equation, h, damping)
            off.append(max(abs(a + principal[0] * principal[1]), abs(b - principal[0] - principal[1])))
        assert off[1] < 1e-40 or off[0] / off[1] > 2 ** (TOP + 0.8)


def system(scene: Scene) -> System:
    """The scene for `declared_steps`, in mpmath's numbers."""
    found = ModifiedMotion.of(BY_NAME["backward_euler"], scene, 1).equations
    q = found.coordinates
    d = len(q)
    force = lambdify([q], list(found.force(q)), "mpmath")
    tangent = lambdify([q], found.tangent(q).tolist(), "mpmath")
    new = symbols(f"w:{d}")
    gradient = lambdify([q, new], list(discrete_gradient(found, q, new)), "mpmath")
    zero = np.array([[mpmath.mpf(0)] * d] * d)

    def array(values: Any) -> Any:
        return np.array(values, dtype=object)

    return System(
        lambda u: array(force(list(u))),
        lambda u: array(tangent(list(u))),
        lambda u, w: array(gradient(list(u), list(w))),
        zero,
        lambda t: array([mpmath.mpf(0)] * d),
    )


def field(motion: ModifiedMotion, h: Any) -> Any:
    """d (u, v)/dt of the reported displacement and velocity, in mpmath's numbers."""
    given = [*motion.equations.coordinates, *motion.scene.rates]
    parts = [motion.rates(q) for q in given]
    root = defaults_of_root(motion.equation)
    functions = [{p: lambdify([*root, *given], e, "mpmath", cse=True) for p, e in part.items()} for part in parts]

    def of(state: Any) -> Any:
        return np.array(
            [sum(h**p * f(*root.values(), *state) for p, f in part.items()) for part in functions], dtype=object
        )

    return of


def flowed(field: Any, start: Any, h: Any) -> Any:
    """The state after h, by Kutta's scheme of order 4 in 8 and 16 steps, extrapolated."""
    ends = []
    for n in (8, 16):
        state, dt = start, h / n
        for _ in range(n):
            k1 = field(state)
            k2 = field(state + dt / 2 * k1)
            k3 = field(state + dt / 2 * k2)
            state = state + dt / 6 * (k1 + 2 * k2 + 2 * k3 + field(state + dt * k3))
        ends.append(state)
    return (16 * ends[1] - ends[0]) / 15


@pytest.mark.matrix(30)
@pytest.mark.parametrize("name", NAMES)
def test_a_step_far_from_the_start_is_its_flow(name: str) -> None:
    scheme = BY_NAME[name]
    scene = LINE if name == "energy_momentum" else PLANE
    with mpmath.workdps(30):
        motion = ModifiedMotion.of(scheme, scene, 3)
        start = [mpmath.mpf(e.p) / e.q for e in scene.start.values()]
        d = len(start) // 2
        off = []
        for steps in (80, 160):
            h = mpmath.mpf(1) / steps
            u, v = (np.array(part, dtype=object) for part in (start[:d], start[d:]))
            rows = march(scheme, defaults(scheme, True), system(scene), h, steps // 4 + 1, u, v)
            before, after = ([*row[0], *row[1]] for row in rows[-2:])
            flow = flowed(field(motion, h), np.array(before, dtype=object), h)
            off.append(max(abs(a - b) for a, b in zip(after, flow, strict=True)))
        assert off[1] < 1e-18 or off[0] / off[1] > 2**4.5  # of v, h^(3 + 2)


ENERGETIC = [name for name in NAMES if name not in OF_STIFFNESS]


@pytest.mark.parametrize(
    ("name", "scene", "top"), [*((name, LINE, TOP) for name in ENERGETIC), ("bathe", PLANE, 3), ("rk2", PLANE, 3)]
)
def test_its_energy_changes_at_the_rate_that_is_found(name: str, scene: Scene, top: int) -> None:
    """By the coordinates of a scene, where the terms were found as scalars on every potential."""
    motion = ModifiedMotion.of(BY_NAME[name], scene, top)
    kept = {0: motion.equations.energy, **motion.kept}
    rates = {power: motion.rates(e) for power, e in kept.items()}
    given = [*motion.equations.coordinates, *motion.scene.rates]
    root = defaults_of_root(motion.equation)
    at = [0.7, -0.4, 0.3, 1.1][: len(given)]
    for power in range(top + 1):
        terms = [rates[k][power - k] for k in kept if k <= power]
        total, lost = (
            lambdify([*root, *given], e)(*map(float, root.values()), *at)
            for e in (sum(terms), motion.energy_rates.get(power, 0))
        )
        assert total == pytest.approx(lost, rel=1e-9, abs=1e-10)


def test_what_is_known_of_energies() -> None:
    verlet = derive("central_difference").modified_energy
    assert verlet is not None
    # Hairer, Lubich & Wanner, Geometric Numerical Integration, IX.3: the Stoermer-Verlet scheme
    assert verlet.coefficients(verlet.terms)[2] == {"V[v, v]": Rational(1, 12), "V[N[]]": Rational(-1, 24)}
    exact = derive("energy_momentum").modified_energy
    assert exact is not None and not exact.terms and not exact.rates


@pytest.mark.parametrize(
    ("name", "power", "scalar", "expected"),
    [
        ("newmark", 1, "V[v, v]", "1/2 - gamma"),
        ("hht_alpha", 3, "V[v, N[v]]", "alpha*(1 + alpha)**2/4"),
        ("wbz_alpha", 3, "V[v, N[v]]", "alpha_B*(1 - alpha_B)**2/4"),
        ("theta_method", 1, "V[v, v]", "1 - 2*theta"),
        ("newmark_bdf2", 1, "V[v, v]", "-gamma_t*(2*gamma - 1)/(2*(2 - gamma_t))"),
        ("bathe", 3, "V[v, N[v]]", "-1/144"),
        ("bdf3", 3, "V[v, N[v]]", "1/2"),  # of these two energy grows
        ("adams_moulton3", 3, "V[v, N[v]]", "1/24"),
        ("bdf_alpha", 3, "V[v, N[v]]", "-(1 + alpha)*(1 + 2*alpha)/2"),
    ],
)
def test_rates_in_the_parameters(name: str, power: int, scalar: str, expected: str) -> None:
    d = derive(name)
    energy = d.modified_energy
    assert energy is not None
    found = energy.coefficients(energy.rates)
    assert min(found) == power and [*found[power]] == [scalar]
    assert simplify(found[power][scalar] - sympify(expected, d.symbols)) == 0


def whole_period(name: str) -> tuple[ss.Scene, float]:
    """A scene that starts where its motion turns or is fastest, and its period, by elliptic integrals or quadrature."""
    if name == "softening":  # V = 100 log(cosh(u)), from u0 = 1 at rest
        speed = lambda u: mpmath.sqrt(200 * mpmath.log(mpmath.cosh(1) / mpmath.cosh(u)))  # noqa: E731
        return ss.scene("softening", k=100.0, u0=1.0), float(4 * mpmath.quad(lambda u: 1 / speed(u), [0, 1]))
    if name == "duffing":
        scene, k, w = ss.scene("duffing", k=1.0, eps=0.5, u0=1.0), 0.5 / 3, np.sqrt(1.5)  # M = eps u0^2/(2 w^2)
    else:
        scene, k, w = ss.scene("simple_pendulum", g_over_L=1.0, v0=1.5), 0.75**2, 1.0
    return scene, float(4 * mpmath.ellipk(k) / w)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("problem", ["duffing", "softening", "simple_pendulum"])
@pytest.mark.parametrize("name", ENERGETIC)
def test_what_is_lost_in_two_periods(name: str, problem: str) -> None:
    """From the end of the first period on, when what the start has put beside the smooth motion has died out."""
    scene, period = whole_period(problem)
    found = ss.energy_drift(scene, name, t_end=3 * period)
    n = 128 if min(derive(name).order[:2]) > 3 else 384
    if found.loss is None:
        r = ss.march(scene, name, dt=period / n, t_end=3 * period)
        change = abs(found.energy(period / n) - found.E0).max()
        assert abs(r.energy[-1] - r.energy[n]) < max(0.02 * change, 1e-13 * n * found.E0)
        return
    while abs(found.rate(period / n)) * 3 * period > 0.02 * found.E0:
        n *= 2
    r = ss.march(scene, name, dt=period / n, t_end=3 * period)
    predicted = found.rate(period / n) * 2 * period
    assert r.energy[n] - r.energy[-1] == pytest.approx(predicted, rel=0.05, abs=1e-13 * n * found.E0)


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.every_scheme
@pytest.mark.parametrize(
    "name",
    [
        name if name in ("bathe", "houbolt", "central_difference") else pytest.param(name, marks=pytest.mark.thorough)
        for name in ENERGETIC
        if name != "energy_momentum"
    ],
)
def test_the_energy_that_is_reported_on_the_elastic_pendulum(name: str) -> None:
    scene, n = ss.scene("elastic_pendulum", EA=1e4), 1000
    found = ss.energy_drift(scene, name, t_end=1.0)
    while abs(found.energy(1 / n) - found.E0).max() > 0.01 * found.E0:
        n *= 2
    r = ss.march(scene, name, dt=1 / n, t_end=1.0)
    predicted, marched = (e[20:] - e[20] for e in (found.energy(1 / n), r.energy[:: n // 200]))
    assert abs(predicted - marched).max() < max(0.05 * abs(marched).max(), 1e-16 * n * found.E0)


@pytest.mark.parametrize(
    ("scene", "given", "scheme", "expected"),
    [
        ("duffing", {"k": 1.0, "eps": 0.1, "u0": 1.0}, "kr_alpha", "without the tangent stiffness at the start"),
        ("elastic_pendulum", {"EA": 1e4}, "energy_momentum", "expected one coordinate for energy_momentum"),
        ("double_pendulum", {}, "energy_momentum", "expected forces at displacements, got a discrete gradient"),
        ("kapitza", {}, "bathe", "expected masses and forces without time"),
        ("van_der_pol", {}, "bathe", "expected forces with a potential, and no others"),
        ("linear_oscillator", {"omega": 1.0, "xi": 0.1}, "bathe", "expected forces with a potential, and no others"),
    ],
)
def test_what_has_none_is_refused(scene: str, given: dict[str, float], scheme: str, expected: str) -> None:
    with pytest.raises(DeclarationError, match=expected):
        ss.energy_drift(ss.scene(scene, **given), scheme, t_end=1.0)


def test_a_load_is_refused() -> None:
    with pytest.raises(ValueError, match="without a load"):
        ss.energy_drift(ss.scene("linear_oscillator", omega=1.0, load=np.sin), "bathe", t_end=1.0)
