"""What is declared in an unusual way is right, as an independent stepping shows, or refused with a reason."""

from collections.abc import Callable, Iterator
from fractions import Fraction
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
import pytest
from declared_steps import march, oscillator, vector
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from plain_kernels import uncompiled
from substep_derive import Balance, DeclarationError, Family, Parameter, Root, Scheme, certify, derive
from substep_derive.declare.catalogue import find
from substep_derive.declare.digest import scheme_digest
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.declare.symbols import N, f, h, knot
from substep_derive.emit.scheme_module import own_module
from substep_derive.oscillator.evaluation import Evaluation
from substep_derive.oscillator.order import order_of
from substep_derive.package import package
from substep_derive.stability.conditions import conditions
from substep_derive.study.derivation import order_at, unremarkable
from substep_derive.study.profile import profile
from sympy import Abs, Expr, Integer, Interval, Poly, Rational, Symbol, cos, exp, eye, oo, pi, sin, sqrt
from test_fuzzed_declarations import check_matrix

import substep as ss
from substep.core.roots import only_root, real_roots
from substep.derived import modules
from substep.marching import linear

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
um, vm, am = knot(-1)
half, quarter = Rational(1, 2), Rational(1, 4)
gamma = Symbol("gamma")
NEWMARK = {u1: u0 + h * v0 + h**2 / 4 * (a0 + a1), v1: v0 + h / 2 * (a0 + a1)}


@pytest.fixture(autouse=True)
def own_modules(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Own schemes, and marches that are not committed, run as plain Python; committed kernels stay compiled."""

    def plain(declared: str, text: Callable[[], str]) -> ModuleType:
        module = ModuleType(f"plain_{hash(declared)}")
        module.__dict__.update(vars(uncompiled(text())))
        return module

    monkeypatch.setattr(modules, "cached_module", plain)
    yield
    linear._kernels.cache_clear()  # those of marches that are not committed were plain


# --- start schemes ---------------------------------------------------------------------------------------


def two_step(start: Any, name: str = "two_step") -> Scheme:
    """Houbolt's smaller relative: a three-point backward difference for u and v."""
    relations = {v1: (3 * u1 - 4 * u0 + um) / (2 * h), a1: (3 * v1 - 4 * v0 + vm) / (2 * h)}
    return Scheme(name, relations, (Balance.at(end, 1),), start=start)


def fox_goodwin_like() -> Scheme:
    return find("newmark").fix({"beta": "1/6", "gamma": "1/2"})


OWN_STARTER = Scheme(
    "own_starter", {u1: u0 + h * v0 + h**2 * (a0 / 3 + a1 / 6), v1: v0 + h / 2 * (a0 + a1)}, (Balance.at(end, 1),)
)
DAMPED = oscillator("0.2", 4)


STARTERS = [fox_goodwin_like(), OWN_STARTER, *map(find, ("newmark", "rk4", "central_difference", "bathe"))]


@pytest.mark.parametrize("start", STARTERS, ids=lambda s: f"{s.name}-{len(s.fixed)}")
@mpmath.workdps(40)
def test_the_start_is_the_scheme_that_was_declared(start: Scheme) -> None:
    """Linear and nonlinear runs begin with it, whatever its name, parameters and state."""
    scheme = two_step(start)
    s = ss.scheme(scheme)
    linear = ss.march(ss.scene("linear_oscillator", omega=2.0, xi=0.05, u0=0.7, v0=1.1), s, dt=0.1, t_end=0.5)
    rows = march(scheme, {}, DAMPED, mpmath.mpf("0.1"), 5, vector("0.7"), vector("1.1"))
    np.testing.assert_allclose(np.hstack([linear.u, linear.v]), np.array(rows, dtype=float)[:, :2, 0], rtol=1e-12)


def test_a_start_without_an_acceleration_is_for_one_oscillator() -> None:
    s = ss.scheme(two_step(find("rk4")))
    message = "finds an acceleration, as it does itself, got rk4"
    with pytest.raises(ValueError, match=message):
        ss.march(ss.scene("duffing"), s, dt=0.1, t_end=0.5)
    with pytest.raises(ValueError, match=message):
        ss.march(ss.structure(np.eye(2), np.eye(2), u0=[1.0, 0.0]), s, dt=0.1, t_end=0.5)


def test_a_member_whose_state_is_smaller_is_no_member() -> None:
    smaller = find("oalts").fix({"rho_inf": 0}, name="smaller")
    with pytest.raises(DeclarationError, match="the state of oalts, whose module it shares"):
        package([find("oalts"), find("average_acceleration"), find("newmark"), smaller], [])


def test_two_starts_are_two_schemes() -> None:
    catalogue = find("newmark").fix({"beta": "1/4", "gamma": "1/2"})
    digests = {scheme_digest(two_step(start)) for start in (fox_goodwin_like(), catalogue, find("rk4"), OWN_STARTER)}
    assert len(digests) == 4
    assert "1/6" in own_module(two_step(fox_goodwin_like())) or "0.1666" in own_module(two_step(fox_goodwin_like()))


def test_a_catalogue_scheme_is_started_by_one_of_the_catalogue() -> None:
    with pytest.raises(DeclarationError, match="starts it in the catalogue, got own_starter"):
        package([two_step(OWN_STARTER)], [])


@pytest.mark.parametrize(
    ("start", "message"),
    [
        (find("houbolt"), "one-step scheme to start it, got houbolt"),
        (find("rho_inf_bathe"), r"rational parameters, got rho_inf_bathe with gamma_t"),
        ({um: u0, vm: v0, am: a0}, "start gives a_-1, which no step reads"),
        ({um: u0, vm: v1}, "start of v_-1 holds v_1"),
        ({um: u0}, "reads v_-1, for which start says nothing"),
    ],
    ids=["multi-step", "irrational", "not read", "not given", "missing"],
)
def test_a_start_that_cannot_be(start: Any, message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        two_step(start)


def test_a_start_scheme_does_not_pass_half_steps() -> None:
    vh = knot("-1/2").v
    relations = {knot("1/2").v: vh + h * a0, u1: u0 + h * knot("1/2").v}
    with pytest.raises(DeclarationError, match="does not pass"):
        Scheme("leapfrog", relations, (Balance(a0, vh, N(u0), f(0)),), start=find("rk4"))


# --- implicit defaults -----------------------------------------------------------------------------------

TWO_HUMPS = (gamma - Rational(1, 20)) * ((gamma - Rational(11, 20)) ** 2 + Rational(1, 1000))


UNIT = Interval(0, 1)


def with_default(default: Any, domain: Any = UNIT) -> Scheme:
    mean = (1 - gamma) * a0 + gamma * a1
    relations = {u1: u0 + h * v0 + h**2 / 2 * mean, v1: v0 + h * mean}
    return Scheme("with_default", relations, (Balance.at(end, 1),), (Parameter(gamma, domain, default),))


def test_the_implicit_default_is_the_root_in_the_interval() -> None:
    scheme = with_default(Root(TWO_HUMPS))
    assert float(ss.scheme(scheme).parameters["gamma"]) == pytest.approx(0.05, rel=1e-15)
    assert certify(scheme).parameters == {"gamma": Rational(1, 20)}


@pytest.mark.parametrize(
    ("equation", "count"),
    [
        ((gamma - quarter) * (gamma - half), "got 2"),
        (gamma**2 + 1, "got 0"),
        (gamma - 2, "got 0"),
        (Integer(0) * gamma, "any number"),
        ((gamma - 1) * (gamma - 3), None),
        ((gamma - half) ** 2, None),
    ],
)
def test_no_or_several_roots_are_refused_in_both_places(equation: Expr, count: str | None) -> None:
    c = [float(x) for x in reversed(Poly(equation, gamma).all_coeffs())]
    if count is None:
        with_default(Root(equation))
        only_root("gamma", c, 0.0, 1.0, False, False)
        return
    with pytest.raises(DeclarationError, match=count):
        with_default(Root(equation))
    with pytest.raises(ValueError, match="has no default here"):
        only_root("gamma", c, 0.0, 1.0, False, False)


def test_an_open_end_does_not_hold_its_root() -> None:
    ends = gamma * (gamma - 1) * (gamma - Rational(1, 3))
    assert certify(with_default(Root(ends), Interval.open(0, 1))).parameters == {"gamma": Rational(1, 3)}
    assert only_root("gamma", [0.0, 1 / 3, -4 / 3, 1.0], 0.0, 1.0, True, True) == pytest.approx(1 / 3)
    with pytest.raises(DeclarationError, match="got 3"):
        with_default(Root(ends), Interval(0, 1))


@given(st.lists(st.fractions(-3, 3, max_denominator=12), min_size=1, max_size=5, unique=True), st.booleans())
@settings(max_examples=60, deadline=None)
def test_real_roots_are_all_found(roots: list[Fraction], with_pair: bool) -> None:
    p = np.poly1d([1.0])
    for root in roots:
        p *= np.poly1d([1.0, -float(root)])
    p = p * np.poly1d([1.0, 0.0, 0.25]) if with_pair else p
    found = real_roots([float(c) for c in p.coeffs[::-1]], None, None)
    np.testing.assert_allclose(found, sorted(map(float, roots)), atol=1e-7)
    inside = [x for x in sorted(map(float, roots)) if -1 <= x <= 2]
    assume(all(min(abs(x + 1), abs(x - 2)) > 1e-6 for x in map(float, roots)))
    np.testing.assert_allclose(real_roots([float(c) for c in p.coeffs[::-1]], -1.0, 2.0), inside, atol=1e-7)


# --- irrational parameters and high orders ---------------------------------------------------------------


def test_order_at_an_irrational_default() -> None:
    """gamma = sqrt(2)/2, used as gamma^2 = 1/2, makes Newmark's scheme of second order."""
    relations = {u1: u0 + h * v0 + h**2 / 2 * a0, v1: v0 + h * ((1 - gamma**2) * a0 + gamma**2 * a1)}
    scheme = Scheme(
        "irrational", relations, (Balance.at(end, 1),), (Parameter(gamma, Interval.open(0, 1), sqrt(2) / 2),)
    )
    assert order_at(Evaluation.at_defaults(scheme)) == (2, 2, 2)
    assert profile(scheme).order == (2, 2, 2)
    assert derive(scheme).order == (1, 1, 1)  # of almost all gamma
    rounded = Evaluation.at(ParameterSet.of(scheme, None, {"gamma": Rational(str((sqrt(2) / 2).n(40)))}))
    assert order_at(rounded) == (1, 1, 1)


def test_limits_at_an_irrational_default() -> None:
    """rho_inf of Noh and Bathe's family, whose optimal split is irrational, is the parameter itself, exactly."""
    assert profile(find("rho_inf_bathe")).rho_inf == half
    assert profile(find("three_substep")).rho_inf == half


def taylor(stages: int) -> Scheme:
    """The exponential's Taylor polynomial, a stage a derivative: order = stages on a linear problem."""
    relations: dict[Symbol, Expr] = {}
    balances = []
    u, v = u0, v0
    for k in range(stages, 0, -1):
        stage = knot("1" if k == 1 else f"s{k}")
        knot_here = knot(f"w{k}")
        relations[knot_here.u], relations[knot_here.v] = u, v
        balances.append(Balance(knot_here.a, knot_here.v, N(knot_here.u), f(0)))
        u, v = u0 + h / k * knot_here.v, v0 + h / k * knot_here.a
        if k == 1:
            relations[stage.u], relations[stage.v] = u, v
    return Scheme(f"taylor_{stages}", relations, tuple(balances))


@pytest.mark.parametrize("stages", [4, 7, 8])
def test_the_order_is_found_however_high_it_is(stages: int) -> None:
    scheme = taylor(stages)
    assert order_of(Evaluation.at_defaults(scheme), Rational(0)).free[:2] == (stages, stages)
    assert derive(scheme).series.order == stages


# --- intervals -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "domain", [Interval(-oo, 1), Interval(-oo, oo), Interval.open(0, oo), Interval(half, 2)], ids=str
)
def test_unusual_intervals(domain: Interval) -> None:
    scheme = with_default(half, domain)
    assert derive(scheme).order == (1, 1, 1)
    for k in (1, 2):
        value = unremarkable(scheme, k).values[gamma]
        assert domain.contains(value) == True  # noqa: E712 (a SymPy boolean)
    assert float(ss.scheme(scheme).parameters["gamma"]) == 0.5


@pytest.mark.parametrize(
    ("parameter", "message"),
    [
        (lambda: Parameter(gamma, Interval(0.0, 1.5), half), "rational or infinite ends"),
        (lambda: Parameter(gamma, Interval(1, 0), half), "more than one number"),
        (lambda: Parameter(gamma, Interval(1, 1), half), "more than one number"),
        (lambda: Parameter(gamma, Interval(0, 1), 0.5), "exact default"),
        (lambda: with_default(Rational(3)), "does not lie in"),
        (lambda: with_default(Symbol("beta")), "parameters declared before"),
    ],
)
def test_an_interval_or_default_that_is_not_exact(parameter: Any, message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        parameter()


@pytest.mark.parametrize(
    "domain", [Interval(-oo, 1), Interval(-oo, oo), Interval.open(-3, oo), Interval(-3, 1)], ids=str
)
def test_conditions_in_unusual_intervals(domain: Interval) -> None:
    """Newmark's scheme with beta = 1/4 + gamma^2 is stable from gamma = 1/2 on, wherever gamma may lie."""
    beta = quarter + gamma**2
    relations = {
        u1: u0 + h * v0 + h**2 * ((half - beta) * a0 + beta * a1),
        v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
    }
    scheme = Scheme("unusual", relations, (Balance.at(end, 1),), (Parameter(gamma, domain, half),))
    found = conditions(scheme)
    for text in ("-5", "-1", "0", "49/100", "1/2", "1", "7"):
        value = Rational(text)
        if value in domain:
            assert found.holds({"gamma": value}) == certify(scheme, gamma=value).stable == (value >= half), text


# --- slots and labels -------------------------------------------------------------------------------------


@pytest.mark.parametrize("label", ["0.5", "+1", "01", "2/4", "1e0", "*1"])
def test_labels_that_are_numbers_are_written_in_one_way(label: str) -> None:
    k = knot(label)
    relations = {k.u: u0 + h / 2 * v0, **NEWMARK, u1: k.u + h / 2 * v0 + h**2 / 4 * (a0 + a1)}
    with pytest.raises(DeclarationError, match="rename the knot"):
        Scheme("bad", relations, (Balance.at(end, 1),))


def test_slots_that_hold_what_belongs_elsewhere() -> None:
    for balance, message in (
        (Balance(a1, v1, N(u1), f(1) - u0), "write it into force"),
        (Balance(a1 + N(u0), v1, N(u1), f(1)), "linear combination"),
        (Balance(a1, v1, N(u1) - f(0), f(1)), "hold N of displacements"),
        (Balance(a1, v1, N(u0 + h * v0 + h**2 / 4 * (a0 + a1)), f(1)), "force at displacements, got the unknown a_1"),
        (Balance(a1, v1, N(u1 + h * v1), f(1)), "force at displacements, got the unknown v_1"),
        (Balance(a1, v1, N(u1), f(h)), "steps after t_n"),
    ):
        with pytest.raises(DeclarationError, match=message):
            Scheme("bad", NEWMARK, (balance,))
    with pytest.raises(DeclarationError, match="belong into balances"):
        Scheme("bad", {**NEWMARK, v1: v0 + h * f(0)}, (Balance.at(end, 1),))
    with pytest.raises(DeclarationError, match="report gives 'u_0'"):
        Scheme("bad", NEWMARK, (Balance.at(end, 1),), report={u0: u1})
    for embedded, message in (
        ({a1: a0}, "embedded gives 'a_1'; expected u_1 or v_1"),
        ({u1: knot("g").u}, "embedded of u_1 holds u_g"),
        ({u1: u0 + h}, "as a linear combination"),
        ({v1: v0 * a0}, "as a linear combination"),
    ):
        with pytest.raises(DeclarationError, match=message):
            Scheme("bad", NEWMARK, (Balance.at(end, 1),), embedded=embedded)
    with pytest.raises(DeclarationError, match="got 'gamma' twice"):
        scheme, same = with_default(half), Family(Parameter(gamma, UNIT, half), {gamma: gamma})
        Scheme("bad", scheme.relations, scheme.balances, scheme.parameters, (same,))


def test_plain_numbers_are_expressions_and_text_is_none() -> None:
    still = Scheme("still", {u1: u0, v1: 0}, (Balance(a1, 0, N(u1), 0),))
    assert eye(1) == derive(still).A
    for bad in ({**NEWMARK, v1: "v_0"}, {**NEWMARK, v1: None}):
        with pytest.raises(DeclarationError, match="expected an expression"):
            Scheme("bad", bad, (Balance.at(end, 1),))
    with pytest.raises(DeclarationError, match="expected an expression"):
        Balance(a1, "v_1", N(u1), f(1))


@mpmath.workdps(40)
def test_a_report_that_looks_back_further_than_the_live_eigenvalues() -> None:
    """The last balance takes its force between a stage and the end: there is no filter, and no error either."""
    g = knot("g")
    relations = {
        g.u: u0 + h / 2 * v0 + h**2 / 8 * g.a,
        g.v: v0 + h / 2 * g.a,
        u1: u0 + h * v0 + h**2 / 2 * g.a,
        v1: v0 + h * g.a,
    }
    scheme = Scheme("between", relations, (Balance.at(g, half), Balance(a1, v1, N((u1 + g.u) / 2), f(1))))
    s = ss.scheme(scheme)
    assert s.kernels.FILTER == 0
    check_matrix(scheme, {}, Rational(2), Rational(1, 10))
    found = ss.march(ss.scene("linear_oscillator", omega=2.0, xi=0.05, u0=0.7, v0=1.1), s, dt=0.1, t_end=0.5)
    rows = march(scheme, {}, DAMPED, mpmath.mpf("0.1"), 5, vector("0.7"), vector("1.1"))
    np.testing.assert_allclose(np.hstack([found.u, found.v]), np.array(rows, dtype=float)[:, :2, 0], rtol=1e-12)


def test_functions_in_a_scene_s_start_and_a_default() -> None:
    """They are evaluated by NumPy, in the index as in kernels."""
    from substep_derive import Scene, optional, rate

    q, k = Symbol("q"), Symbol("stiff")
    start = {q: sin(k) + pi * Abs(k), rate(q): exp(-k)}
    scene = Scene("wavy", {q: "m"}, rate(q) ** 2 / 2, k * q**2 / 2, (optional(k, 2),), start, length=cos(k) + 2)
    made = ss.scene(scene)
    assert made.u0 == pytest.approx([np.sin(2.0) + 2.0 * np.pi])
    assert made.v0 == pytest.approx([np.exp(-2.0)])
    assert made.length == pytest.approx(np.cos(2.0) + 2.0)
