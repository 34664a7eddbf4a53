"""What forces are beside their slopes: constants, factors of a load, jumps, stiffness that is negative."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import DeclarationError, Friction, Scene, optional, rate, sampled, t
from substep_derive.declare.branches import absolute, larger, sign_of
from sympy import Abs, Expr, Interval, Max, Rational, Symbol, cos, sign, sin, sympify

import substep as ss

x, y, c, k, w = (Symbol(name) for name in "xyckw")
v = rate(x)
PARAMETERS = (optional(c, Rational(1, 2)), optional(k, 1), optional(w, Rational(3, 10)))
LINE: dict[str, Any] = {
    "coordinates": {x: "m"}, "kinetic": v**2, "parameters": PARAMETERS, "start": {x: 1, v: 0}, "length": 1,
}  # fmt: skip
Force = Callable[[float, float, float], float]


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(
    ("given", "force"),
    [
        ({"potential": k * x**2 - 3 * x}, lambda t, x, v: 3 - 2 * x),
        ({"potential": k * (x - w) ** 2}, lambda t, x, v: -2 * (x - 0.3)),
        ({"potential": k * x**2, "load": {x: 3}}, lambda t, x, v: 3 - 2 * x),
        ({"forces": {x: k * (w - x)}}, lambda t, x, v: 0.3 - x),
        ({"potential": -k * x**2 / 2}, lambda t, x, v: x),
        ({"potential": x**2, "load": {x: 2 * sampled}}, lambda t, x, v: 2 * np.sin(3 * t) - 2 * x),
        ({"potential": x**2, "load": {x: 1 - sampled}}, lambda t, x, v: 1 - np.sin(3 * t) - 2 * x),
        ({"potential": x**2, "load": {x: Max(sin(3 * t), 0)}}, lambda t, x, v: max(np.sin(3 * t), 0.0) - 2 * x),
        ({"potential": x**2, "dissipation": c * (v - w) ** 2 / 2}, lambda t, x, v: -2 * x - 0.5 * (v - 0.3)),
        ({"potential": x**2, "forces": {x: -c * (v - cos(t))}}, lambda t, x, v: -2 * x - 0.5 * (v - np.cos(t))),
        ({"potential": x**2, "forces": {x: -c * (v + 2 * x)}}, lambda t, x, v: -2 * x - 0.5 * (v + 2 * x)),
        ({"potential": x**2, "dissipation": c * v**2 + Abs(v) / 5}, lambda t, x, v: -2 * x - v - np.sign(v) / 5),
        ({"potential": x**2, "forces": {x: -c * v - sign(v) / 5}}, lambda t, x, v: -2 * x - v / 2 - np.sign(v) / 5),
        ({"potential": x**2 + t * Abs(x)}, lambda t, x, v: -2 * x - t * np.sign(x)),
        ({"potential": (1 + t) * y, "invariants": {y: x**2}}, lambda t, x, v: -2 * (1 + t) * x),
        ({"potential": x**2 + t * y, "invariants": {y: w - 3 * x}}, lambda t, x, v: -2 * x + 3 * t),
        ({"potential": y, "invariants": {y: (x - sin(t)) ** 2}}, lambda t, x, v: -2 * (x - np.sin(t))),
    ],
)
def test_forces_are_more_than_their_slopes(given: dict[str, Any], force: Force) -> None:
    made = Scene("affine", **{"potential": 0 * x, **LINE, **given})
    own = {"load": ss.Harmonic(1.0, 3.0)} if any(e.has(sampled) for e in made.load.values()) else {}
    scene = ss.scene(made, **own)
    exact = solve_ivp(lambda t, z: [z[1], force(t, *z) / 2], (0, 2), [1.0, 0.0], rtol=1e-9, max_step=0.002).y[:, -1]
    declared = (made.potential, made.dissipation, *made.forces.values(), *made.load.values())
    jumping = any(e.has(absolute, sign_of, larger) for e in map(sympify, declared))
    for name in ("average_acceleration", "bathe", "rk4"):
        r = ss.march(scene, name, dt=0.002, t_end=2.0)
        assert np.abs(np.array([*r.u[-1], *r.v[-1]]) - exact).max() < (2e-3 if jumping else 1e-5)


@pytest.mark.usefixtures("uncompiled")
def test_only_what_is_an_oscillator_is_marched_as_one() -> None:
    def oscillator(**given: Any) -> bool:
        return ss.scene(Scene("perhaps", **{**LINE, **given}), load=None).info.oscillator is not None

    assert oscillator(potential=k * (x - 1) ** 2 + 2 * k * x, forces={x: -c * (v + x)})
    assert not oscillator(potential=k * (x - 1) ** 2)
    signed = (optional(k, 1, Interval(-2, 2)),)
    assert not oscillator(potential=k * x**2, parameters=signed)
    buckled = Scene("buckled", **{**LINE, "potential": k * x**2, "parameters": signed})
    r = ss.march(ss.scene(buckled, k=-1.0), "rk4", dt=0.01, t_end=1.0)
    assert r.u[-1, 0] == pytest.approx(np.cosh(1.0), rel=1e-8)


@pytest.mark.usefixtures("uncompiled")
def test_a_potential_without_a_value_at_the_start_is_refused() -> None:
    given = Scene("late", **{**LINE, "potential": x * sin(t) / t})
    with pytest.raises(ValueError, match=r"all forces are finite, got the acceleration \[nan\]"):
        ss.march(ss.scene(given), "rk4", dt=0.1, t_end=1.0)


@pytest.mark.parametrize("g", [Abs(v) - rate(y), sign(v) - rate(y), Max(v, 0) + rate(y)])
def test_a_constraint_with_branches_of_rates_is_refused(g: Expr) -> None:
    plane: dict[str, Any] = {
        "coordinates": {x: "m", y: "m"}, "kinetic": v**2 + rate(y) ** 2, "potential": 0 * x, "parameters": (),
        "start": {x: 0, y: 0, v: 1, rate(y): 1}, "length": 1,
    }  # fmt: skip
    with pytest.raises(DeclarationError, match="expected constraint g to be linear in x_dot, y_dot"):
        Scene("branched", **plane, constraints={"g": g})
    with pytest.raises(DeclarationError, match="a limit of friction drag that is linear in pressures"):
        Scene("branched", **plane, contacts={"floor": y}, frictions={"drag": Friction(x, Abs(Symbol("floor") - 2))})
