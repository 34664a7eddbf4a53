"""Symbols of a declaration that stand for something else than is meant are refused, and elongations have branches."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import Contact, DeclarationError, Law, Parameter, Scene, e, optional, rate, t
from sympy import Abs, Interval, Max, Min, Piecewise, Rational, Symbol, oo, sqrt

import substep as ss

x, y, k, r = (Symbol(name) for name in ("x", "y", "k", "r"))
v = rate(x)
LINE: dict[str, Any] = {
    "coordinates": {x: "m"}, "kinetic": v**2 / 2, "potential": x**2, "parameters": (), "start": {x: 1, v: 0},
    "length": 1,
}  # fmt: skip
PLANE: dict[str, Any] = {
    "coordinates": {x: "m", y: "m"}, "kinetic": (v**2 + rate(y) ** 2) / 2, "potential": x**2 + (x - y) ** 2,
    "parameters": (), "start": {x: 1, y: 0, v: 0, rate(y): 0}, "length": 1,
}  # fmt: skip
SPRING = Law("spring", (optional(k, 3),), force=k * e, stored=k * e**2 / 2)


@pytest.mark.parametrize("name", ["elapsed", "dissipated", "e_dot"])
def test_names_of_what_laws_speak_of_are_no_coordinates(name: str) -> None:
    """The time since the last commit was taken for 0, and so was a coordinate of its name, in energies too."""
    q = Symbol(name)
    given = {"coordinates": {q: "m"}, "kinetic": rate(q) ** 2, "potential": q**2, "start": {q: 1, rate(q): 0}}
    with pytest.raises(DeclarationError, match=f"a coordinate whose name is free, got '{name}'.*rename"):
        Scene("named", **{**LINE, **given})
    for kind in ({"contacts": {name: Contact(x, remembered=True)}}, {"constraints": {name: x - y}}):
        with pytest.raises(DeclarationError, match=f"whose name is free, got '{name}'.*rename"):
            Scene("named", **PLANE, **kind)


def test_an_output_has_no_name_of_a_law_s_force() -> None:
    laws = {"a": SPRING.on(x), "b": SPRING.on(y - x)}
    with pytest.raises(DeclarationError, match="not those of the forces of laws, got 'a_force' twice"):
        Scene("named", **PLANE, laws=laws, outputs={"a_force": 7 * x})
    assert Scene("named", **PLANE, laws={"a": SPRING.on(x)}, outputs={"a_force": 7 * x}).output_of == {"a": "force"}


@pytest.mark.parametrize(
    ("invariant", "expected"),
    [
        (x**2 + k, "invariant r holds 'k'"),
        (x**2 + v, "invariant r holds 'x_dot'"),
        (x**2 + Symbol("s"), "invariant r holds 's'"),
        (Piecewise((x**2, x > 1), (0, True)), "invariant r at most quadratic"),
        (Max(x, 0), "invariant r"),
    ],
)
def test_an_invariant_is_of_coordinates(invariant: Any, expected: str) -> None:
    given: dict[str, Any] = {**LINE, "potential": r + Symbol("s") * 0}
    with pytest.raises(DeclarationError, match=expected):
        Scene("turned", **given, invariants={r: invariant, Symbol("s"): x})
    Scene("turned", **given, invariants={r: (x - t) ** 2})


@pytest.mark.parametrize(
    ("assumed", "domain"),
    [
        ({"positive": True}, Interval(-1, 5)),
        ({"positive": True}, Interval(0, 5)),
        ({"nonnegative": True}, Interval(-oo, oo)),
        ({"negative": True}, Interval(-1, 5)),
        ({"nonzero": True}, Interval(0, 5)),
        ({"integer": True}, Interval(1, 5)),
        ({"imaginary": True}, Interval(1, 5)),
    ],
)
def test_assumptions_of_a_symbol_hold_where_it_may_lie(assumed: dict[str, bool], domain: Interval) -> None:
    """SymPy writes sqrt(k**2) as k where it takes k to be positive, and k = -3 would be another motion."""
    told = Symbol("k", **assumed)
    with pytest.raises(DeclarationError, match=f"assumes to be {next(iter(assumed))}; write Symbol"):
        Parameter(told, domain, Rational(2))
    if "nonzero" not in assumed:
        q = Symbol("x", **assumed)
        given = {"coordinates": {q: "m"}, "kinetic": rate(q) ** 2, "potential": Abs(q) ** 3}
        with pytest.raises(DeclarationError, match="stands for a coordinate, any real number, got one that SymPy"):
            Scene("told", **{**LINE, **given, "start": {q: -1, rate(q): 0}})


def test_assumptions_that_hold_are_taken() -> None:
    Parameter(Symbol("k", positive=True), Interval.open(0, oo), Rational(2))
    Parameter(Symbol("k", nonnegative=True, real=True), Interval(0, 1), Rational(1))
    Parameter(Symbol("k", nonzero=True), Interval.open(0, oo), Rational(2))
    q = Symbol("x", real=True)
    given = {"coordinates": {q: "m"}, "kinetic": rate(q) ** 2, "potential": sqrt(q**2) ** 3}
    Scene("told", **{**LINE, **given, "start": {q: -1, rate(q): 0}})


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("elongation", [Abs(x - y), Max(x - y, 0), Min(y, x / 2)])
def test_a_law_over_an_elongation_with_branches(elongation: Any) -> None:
    """A spring without memory, as a law and as SciPy has its force."""
    scene = ss.scene(Scene("branched", **PLANE, laws={"spring": SPRING.on(elongation)}))

    def force(a: float, b: float) -> np.ndarray:
        if elongation.func is Abs:
            return 3 * (a - b) * np.array([1, -1])
        if elongation.func is Max:
            return 3 * max(a - b, 0) * np.array([1, -1])
        return 3 * b * np.array([0, 1]) if b <= a / 2 else 3 * a / 4 * np.array([1, 0])

    def slopes(_: float, z: np.ndarray) -> np.ndarray:
        a, b = z[:2]
        return np.append(z[2:], -np.array([2 * a + 2 * (a - b), 2 * (b - a)]) - force(a, b))

    exact = solve_ivp(slopes, (0, 2), [1.0, 0.0, 0.0, 0.0], rtol=1e-9, max_step=0.01).y[:, -1]
    for scheme in ("average_acceleration", "rk4"):
        found = ss.march(scene, scheme, dt=0.005, t_end=2.0)
        assert np.abs(np.append(found.u[-1], found.v[-1]) - exact).max() < 1e-3


@pytest.mark.usefixtures("uncompiled")
def test_scenes_that_differ_in_the_order_of_their_coordinates_are_two() -> None:
    """The equations of one were taken for the other, so that masses were exchanged; laws remember in order too."""
    plane = {**PLANE, "kinetic": (v**2 + 2 * rate(y) ** 2) / 2, "potential": 2 * x**2 + 3 * y**4 + x * y}
    one, other = (Scene("ordered", **{**plane, "coordinates": dict.fromkeys(order, "m")}) for order in ((x, y), (y, x)))
    assert one != other
    assert one == Scene("ordered", **plane)
    for scheme in ("average_acceleration", "rk4"):
        a, b = (ss.march(ss.scene(scene), scheme, dt=0.05, t_end=0.5) for scene in (one, other))
        np.testing.assert_allclose(a.u, b.u[:, ::-1], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(a.energy, b.energy, rtol=0.0, atol=1e-12)
    p, q = Symbol("p"), Symbol("q")
    first, second = (Law("kept", (), e - p, dict.fromkeys(m, 0), {p: e, q: p}) for m in ((p, q), (q, p)))
    assert first != second
