"""Energy change on the stiff pendulum: closed forms against steps written from the textbooks, at 50 digits.

The plane is the complex plane. A rule says u = p + c z at each knot; `at_knot(p, c)` then finds u, for the rigid bar
by projection, for the elastic one by Newton's method on the equation of motion.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import mpmath
import pytest
from substep_derive.declare import schemes
from substep_derive.declare.errors import DeclarationError
from substep_derive.declare.parameter import Parameter
from substep_derive.declare.scheme import Balance, Scheme
from substep_derive.declare.symbols import K0, M, beta, gamma_t, h, knot
from substep_derive.motion.rigid_limit import energy_change, momentum_change, settled_energy_change, sign_changes
from sympy import Expr, Interval, Poly, Rational, factor, oo, sqrt

mp = mpmath.MPContext()
mp.dps = 50
BY_NAME = {scheme.name: scheme for scheme in schemes.declared()}
newmark_bdf2 = BY_NAME["newmark_bdf2"]

State = tuple[Any, ...]  # u, v, a as complex numbers
Knot = Callable[[Any, Any], Any]


def rigid(p: Any, c: Any) -> Any:
    return p / abs(p)


def newmark(state: State, k: Any, at_knot: Knot, beta: Any, gamma: Any) -> State:
    u, v, a = state
    p, c = u + k * v + k**2 * (mp.mpf(1) / 2 - beta) * a, beta * k**2
    after = at_knot(p, c)
    z = (after - p) / c
    return after, v + k * ((1 - gamma) * a + gamma * z), z


def newmark_bdf2_step(state: State, h: Any, at_knot: Knot, gamma_t: Any, beta: Any, gamma: Any) -> State:
    """Newmark over gamma_t h, then thesis (3.13)-(3.16)."""
    (u0, v0, _), (ug, vg, _) = state, newmark(state, gamma_t * h, at_knot, beta, gamma)
    c1, c2 = (1 - gamma_t) / (gamma_t * h), -1 / ((1 - gamma_t) * gamma_t * h)
    c3 = (2 - gamma_t) / ((1 - gamma_t) * h)
    p = -(c1 * v0 + c2 * vg + c3 * (c1 * u0 + c2 * ug)) / c3**2
    u1 = at_knot(p, 1 / c3**2)
    v1 = c1 * u0 + c2 * ug + c3 * u1
    return u1, v1, c1 * v0 + c2 * vg + c3 * v1


def rho_inf_bathe_step(state: State, h: Any, at_knot: Knot, rho_inf: Any, gamma_t: Any) -> State:
    """Noh and Bathe 2019: trapezoidal rule over gamma_t h, then weights q_0, q_1, q_2."""
    (u0, v0, a0), (_, vg, ag) = state, newmark(state, gamma_t * h, at_knot, mp.mpf(1) / 4, mp.mpf(1) / 2)
    q1 = (1 + rho_inf) / (2 * gamma_t * (rho_inf - 1) + 4)
    q2 = mp.mpf(1) / 2 - gamma_t * q1
    q0 = 1 - q1 - q2
    p = u0 + h * (q0 * v0 + q1 * vg + q2 * (v0 + h * (q0 * a0 + q1 * ag)))
    u1 = at_knot(p, (q2 * h) ** 2)
    v1 = (u1 - u0 - h * (q0 * v0 + q1 * vg)) / (q2 * h)
    return u1, v1, (v1 - v0 - h * (q0 * a0 + q1 * ag)) / (q2 * h)


def backward_euler(state: State, h: Any, at_knot: Knot) -> State:
    u0, v0, _ = state
    u1 = at_knot(u0 + h * v0, h**2)
    return u1, (u1 - u0) / h, ((u1 - u0) / h - v0) / h


def houbolt(state: State, h: Any, at_knot: Knot) -> State:
    """One step from three knots of the exact rotation."""
    u0, um, umm = state[0], mp.expj(-h), mp.expj(-2 * h)
    u1 = at_knot((5 * u0 - 4 * um + umm) / 2, h**2 / 2)
    v1 = (11 * u1 - 18 * u0 + 9 * um - 2 * umm) / (6 * h)
    return u1, v1, (2 * u1 - 5 * u0 + 4 * um - umm) / h**2


RULES: dict[str, Callable[..., State]] = {
    "newmark": newmark,
    "newmark_bdf2": newmark_bdf2_step,
    "rho_inf_bathe": rho_inf_bathe_step,
    "backward_euler": backward_euler,
    "houbolt": houbolt,
}
FORMS = {"first": energy_change, "momentum": momentum_change, "settled": settled_energy_change}
CASES: list[tuple[str, dict[str, str]]] = [
    ("newmark", {"beta": "1/6", "gamma": "1/2"}),
    ("newmark", {"beta": "49/100", "gamma": "9/10"}),
    ("newmark_bdf2", {"gamma_t": "1/2", "beta": "1/4", "gamma": "1/2"}),
    ("newmark_bdf2", {"gamma_t": "3/10", "beta": "1/4", "gamma": "1/2"}),
    ("newmark_bdf2", {"gamma_t": "2/5", "beta": "1/3", "gamma": "1/2"}),
    ("newmark_bdf2", {"gamma_t": "3/5", "beta": "1/5", "gamma": "1/2"}),
    ("newmark_bdf2", {"gamma_t": "2/5", "beta": "3/10", "gamma": "3/5"}),
    ("newmark_bdf2", {"gamma_t": "7/10", "beta": "2/5", "gamma": "9/10"}),
    ("rho_inf_bathe", {"rho_inf": "1/2", "gamma_t": "2/5"}),
    ("backward_euler", {}),
    ("houbolt", {}),
]


@cache
def form(kind: str, name: str) -> dict[int, Expr]:
    return FORMS[kind](BY_NAME[name])


def numbers(kind: str, name: str, parameters: dict[str, str]) -> dict[int, Any]:
    """The symbolic closed form at a scheme's parameters."""
    values = BY_NAME[name].exact(parameters)
    exact = {k: e.subs(values) for k, e in form(kind, name).items()}
    return {k: mp.mpf(e.p) / e.q for k, e in exact.items() if e != 0}


def marched(name: str, parameters: dict[str, Any], tau: Any, steps: int = 1) -> list[State]:
    """States from steady rotation with L = V = 1."""
    values = {key: mp.mpf(Rational(value).p) / Rational(value).q for key, value in parameters.items()}
    states: list[State] = [(mp.mpc(1), mp.mpc(0, 1), mp.mpc(-1))]
    for _ in range(steps):
        states.append(RULES[name](states[-1], mp.mpf(tau), rigid, **values))
    return states


def energy(state: State) -> Any:
    return abs(state[1]) ** 2


def momentum(state: State) -> Any:
    return (mp.conj(state[0]) * state[1]).imag


@pytest.mark.parametrize(("kind", "measure"), [("first", energy), ("momentum", momentum)])
@pytest.mark.parametrize(("name", "parameters"), CASES)
def test_first_step_is_the_measured_one(name: str, parameters: dict[str, str], kind: str, measure: Callable) -> None:
    expected = numbers(kind, name, parameters)
    taus = mp.mpf("1e-2"), mp.mpf("5e-3")
    changes = [measure(marched(name, parameters, tau)[1]) - 1 for tau in taus]
    n = min(expected)
    coarse, fine = (change / tau**n for change, tau in zip(changes, taus, strict=True))
    assert float((4 * fine - coarse) / 3 / expected[n]) == pytest.approx(1, rel=1e-7)
    coarse, fine = (
        change - sum(c * tau**k for k, c in expected.items()) for change, tau in zip(changes, taus, strict=True)
    )
    assert float(coarse / fine) == pytest.approx(2**8, rel=1e-3)  # all that is left out is of order tau^8


@pytest.mark.parametrize(("name", "parameters"), CASES[1:-1])
def test_settled_change_is_that_after_many_steps(name: str, parameters: dict[str, str]) -> None:
    expected = numbers("settled", name, parameters)
    left_out = []
    for step in (mp.mpf("2e-3"), mp.mpf("1e-3")):
        *_, before, after = marched(name, parameters, step, 120)
        tau = step * momentum(before)
        change = energy(after) / energy(before) - 1
        left_out.append((change - sum(c * tau**k for k, c in expected.items())) / tau**6)
    assert float(left_out[0] / left_out[1]) == pytest.approx(1, rel=1e-3)


def elastic(EA: Any, m: Any, L: Any) -> Knot:
    """Newton's method for m z + N(u) = 0 with Green-Lagrange strain."""
    k = EA / (2 * L**3)

    def at_knot(p: Any, c: Any) -> Any:
        u = L * p / abs(p)
        for _ in range(20):
            stretch = abs(u) ** 2 - L**2
            residual = m * (u - p) / c + k * stretch * u
            x, y, d = u.real, u.imag, m / c + k * stretch
            tangent = mp.matrix([[d + 2 * k * x * x, 2 * k * x * y], [2 * k * x * y, d + 2 * k * y * y]])
            du = mp.lu_solve(tangent, mp.matrix([residual.real, residual.imag]))
            u -= mp.mpc(*du)
            if mp.norm(du) < mp.mpf(10) ** -40 * L:
                return u
        raise AssertionError("Newton's method did not converge")

    return at_knot


@pytest.mark.parametrize(
    "parameters",
    [("1/2", "1/4", "1/2"), ("3/10", "1/4", "1/2"), ("2/5", "3/10", "3/5")],
)
def test_projection_is_the_limit_of_the_stiff_bar(parameters: tuple[str, ...]) -> None:
    L, m, v0 = mp.mpf("3.0443"), mp.mpf(10), mp.mpf("7.72")
    values = [mp.mpf(Rational(x).p) / Rational(x).q for x in parameters]
    tau, steps = mp.mpf("0.1"), 5

    def changes(at_knot: Knot) -> list[Any]:
        states: list[State] = [(mp.mpc(L), mp.mpc(0, v0), mp.mpc(-(v0**2) / L))]
        for _ in range(steps):
            states.append(newmark_bdf2_step(states[-1], tau * L / v0, at_knot, *values))
        return [energy(state) / v0**2 - 1 for state in states[1:]]

    limit = changes(lambda p, c: L * p / abs(p))
    expected = energy(marched("newmark_bdf2", dict(zip(("gamma_t", "beta", "gamma"), parameters, strict=True)), tau)[1])
    assert float(limit[0] + 1 - expected) == pytest.approx(0, abs=1e-45)  # tau is all that it depends on
    gaps = [
        [abs(x - y) for x, y in zip(changes(elastic(mp.mpf(10) ** power, m, L)), limit, strict=True)]
        for power in (16, 18, 20)
    ]
    for soft, stiff, stiffer in zip(*gaps, strict=True):
        assert float(soft / stiff) == pytest.approx(100, rel=1e-6)
        assert float(stiff / stiffer) == pytest.approx(100, rel=1e-6)
        assert stiffer < mp.mpf("1e-9") * abs(limit[0])


def test_closed_forms_where_newmark_is_of_second_order() -> None:
    g = gamma_t
    silva_bezerra = BY_NAME["silva_bezerra"]
    expected = -(g**2) * (1 - g) ** 2 / (4 * (2 - g) ** 2)
    assert factor(energy_change(silva_bezerra, 4)[4] - expected) == 0
    settled = -g * (2 * g**3 - 7 * g**2 + 8 * g - 2) / (4 * (2 - g) ** 2)
    assert factor(settled_energy_change(silva_bezerra)[4] - settled) == 0
    half = newmark_bdf2.fix({"gamma": "1/2"})
    assert min(energy_change(half)) == min(settled_energy_change(half)) == 4


def test_leading_term_is_dissipative_for_larger_gamma() -> None:
    gamma = newmark_bdf2.values[2]
    for kind in ("first", "settled"):
        assert factor(form(kind, "newmark_bdf2")[2] + gamma_t * (2 * gamma - 1) / (2 - gamma_t)) == 0


@pytest.mark.parametrize("kind", FORMS)
def test_bathe_is_a_member_of_newmark_bdf2(kind: str) -> None:
    member = newmark_bdf2.fix({"gamma_t": "1/2", "beta": "1/4", "gamma": "1/2"})
    assert form(kind, "bathe") == FORMS[kind](member)
    assert form("first", "bathe")[4] == Rational(-1, 144)
    assert form("settled", "bathe")[4] == Rational(-1, 36)


@pytest.mark.parametrize("kind", FORMS)
def test_average_acceleration_keeps_the_energy(kind: str) -> None:
    assert form(kind, "average_acceleration") == {}


def change_near(gamma_t: Expr, side: int, beta: str, tau: str, steps: int) -> Any:
    at = Rational(str(gamma_t.evalf(30))) + Rational(side, 1000)
    *_, before, after = marched("newmark_bdf2", {"gamma_t": at, "beta": beta, "gamma": "1/2"}, tau, steps)
    return energy(after) / energy(before) - 1


@pytest.mark.parametrize(
    ("beta_value", "expected"),
    [("1/4", []), ("1/6", [(3 - sqrt(5)) / 2]), ("1/8", [Rational(2, 3)]), ("1/3", [(21 - sqrt(89)) / 22])],
)
def test_first_step_changes_sign_where_derived(beta_value: str, expected: list[Expr]) -> None:
    coefficient = energy_change(newmark_bdf2.fix({"gamma": "1/2", "beta": beta_value}), 4)[4]
    found = sign_changes(coefficient, newmark_bdf2.parameters[0])
    assert [(x - y).equals(0) for x, y in zip(found, expected, strict=True)] == [True] * len(expected)
    for root in found:
        below, above = (change_near(root, side, beta_value, "1e-3", 1) for side in (-1, 1))
        assert below * above < 0


def test_settled_change_changes_sign_where_derived() -> None:
    coefficient = settled_energy_change(BY_NAME["silva_bezerra"])[4]
    (root,) = sign_changes(coefficient, newmark_bdf2.parameters[0])
    assert Poly(2 * gamma_t**3 - 7 * gamma_t**2 + 8 * gamma_t - 2, gamma_t).eval(root).equals(0)
    assert float(root) == pytest.approx(0.342702, abs=1e-6)
    below, above = (change_near(root, side, "1/4", "1e-3", 40) for side in (-1, 1))
    assert below > 0 > above


def test_a_touching_zero_and_the_interval_s_ends_are_no_sign_changes() -> None:
    x = Parameter(gamma_t, Interval(0, 2), Rational(1))
    assert sign_changes(gamma_t * (gamma_t - 1) ** 2 * (2 * gamma_t - 1) ** 3 / (gamma_t - 3), x) == [Rational(1, 2)]
    with pytest.raises(ValueError, match="gamma_t alone, got beta"):
        sign_changes(beta * gamma_t, x)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("rk4", "expected each balance at one knot.*gains 0 times"),
        ("central_difference", "gains 0 times"),
        ("generalized_alpha", "expected each balance at one knot"),
        ("energy_momentum", "N_discrete"),
        ("wilson_theta", "expected a balance at u_1, got one at u_t only"),
    ],
)
def test_other_balances_are_refused(name: str, message: str) -> None:
    with pytest.raises(DeclarationError, match=f"^{name}: .*{message}"):
        energy_change(BY_NAME[name])


def test_what_has_no_limit_is_refused() -> None:
    (u0, v0, a0), (u1, v1, a1) = knot(0), knot(1)
    end = (Balance.at(knot(1), 1),)
    domain = (Parameter(beta, Interval(0, oo), Rational(1, 4)),)
    velocity = v0 + h / 2 * (a0 + a1)
    material = Scheme("own", {u1: u0 + h * v0 + h**2 / (1 + h**2 * K0 / M) * a1, v1: velocity}, end)
    with pytest.raises(DeclarationError, match="own: expected relations in u, v, a and h"):
        energy_change(material)
    inconsistent = Scheme("own", {u1: 2 * u0 + h * v0 + beta * h**2 * a1, v1: velocity}, end, domain)
    with pytest.raises(ValueError, match="own is not consistent"):
        energy_change(inconsistent)
    with pytest.raises(DeclarationError, match="houbolt: expected a one-step scheme"):
        settled_energy_change(BY_NAME["houbolt"])
    with pytest.raises(ValueError, match="nothing settles"):
        settled_energy_change(BY_NAME["rho_inf_bathe"].fix({"rho_inf": 1}))
