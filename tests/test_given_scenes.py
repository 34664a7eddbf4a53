"""What is no scene is refused where it is declared, with what was expected and the cure, and never marched."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from substep_derive import Constraint, Contact, DeclarationError, Friction, Scene, optional, rate
from sympy import Abs, Eq, Expr, Interval, Max, Min, Piecewise, Rational, Symbol, nan, oo
from sympy import sin as sine

import substep as ss

x, y, k, m = (Symbol(name) for name in ("x", "y", "k", "m"))
v = rate(x)
GIVEN: dict[str, Any] = {
    "name": "given", "coordinates": {x: "m"}, "kinetic": v**2 / 2, "potential": 10 * x**2, "parameters": (),
    "start": {x: 0, v: 1}, "length": 1,
}  # fmt: skip
PLANE: dict[str, Any] = {
    "coordinates": {x: "m", y: "m"}, "kinetic": (v**2 + rate(y) ** 2) / 2, "parameters": (),
    "start": {x: 0, y: 0, v: 1, rate(y): 0}, "length": 1,
}  # fmt: skip


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"name": None}, "name of a scene as a text, got None"),
        ({"coordinates": {"x": "m"}}, "coordinates as a mapping from symbols to units, got 'x'"),
        ({"coordinates": {x: None}}, "units in coordinates, got None of 'x'"),
        ({"constraints": [x]}, r"constraints as a mapping from names to expressions, got \[x\]"),
        ({"constraints": {1: x}}, "constraints as a mapping from names to expressions, got 1"),
        ({"forces": [1]}, "forces as a mapping from symbols"),
        ({"start": []}, "start as a mapping from symbols"),
        ({"outputs": {Symbol("p"): x}}, "outputs as a mapping from names"),
        ({"frictions": {"d": x}}, "a Friction in frictions, got x of 'd'"),
        ({"parameters": optional(k, 1)}, "parameters as a tuple of required"),
        ({"parameters": (k,)}, "parameters as a tuple of required"),
        ({"parameters": (optional(k, m), optional(m, k))}, "default of k in parameters declared before it, got 'm'"),
        ({"start": {x: nan, v: 1}}, "start of x that is finite, got nan"),
        ({"start": {x: oo, v: 1}}, "start of x that is finite, got oo"),
        ({"start": {x: 0, v: 1, Symbol("x_acc"): 5}}, "start is given of 'x_acc', expected only coordinates, rates"),
        ({"length": nan}, "a length that is finite"),
        ({"potential": float("nan")}, "a potential that is finite"),
        ({"potential": Eq(x, 1)}, r"a potential as an expression, got Eq\(x, 1\)"),
        ({"potential": Piecewise((x**2, x > 0))}, "a value everywhere"),
        ({"kinetic": -(v**2) / 2}, "a kinetic energy that is not negative"),
        ({"kinetic": -m * v**2 / 2, "parameters": (optional(m, 1),)}, "in which x has the mass -m"),
        ({"dissipation": nan * v**2}, "a dissipation that is finite"),
        ({"constraints": {"my rod": x}}, "a constraint whose name is an identifier of Python, got 'my rod'"),
        ({"contacts": {"energy": x + 1}}, "a contact whose name is free, got 'energy'"),
        ({"outputs": {"p": Symbol("w")}}, "the output p holds 'w'"),
        ({"energy_scale": Symbol("w")}, "the energy scale holds 'w', expected only numbers"),
        ({"frictions": {"d": Friction(x, -1)}}, "a limit of friction d that is not negative, got -1"),
        ({"frictions": {"d": Friction(x, -k)}, "parameters": (optional(k, 1),)}, "that is not negative, got -k"),
        ({"contacts": {"c": Contact(x + 1, k)}, "parameters": (optional(k, 1),)}, "from 0 to 1 for contact c, got k"),
        (
            {"contacts": {"c": Contact(x + 1, 2 * k)}, "parameters": (optional(k, 1, Interval(0, 1)),)},
            "from 0 to 1 for contact c, got 2",
        ),
    ],
)  # fmt: skip
def test_what_is_no_scene_is_refused(given: dict[str, Any], expected: str) -> None:
    with pytest.raises(DeclarationError, match=expected):
        Scene(**{**GIVEN, **given})


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda: Friction(x, nan), "a limit that is finite"),
        (lambda: Contact(x, penalty=True), "a penalty as an expression, got True"),
        (lambda: Contact(x, penalty=float("inf")), "a penalty that is finite"),
        (lambda: Contact(x, restitution=float("nan")), "a restitution that is finite"),
        (lambda: Constraint(Eq(x**2, 1)), "what is to be 0 as an expression"),
        (lambda: optional(k, float("nan")), "a default that is finite"),
    ],
)
def test_what_is_no_reaction_is_refused(make: Any, expected: str) -> None:
    with pytest.raises(DeclarationError, match=expected):
        make()


@pytest.mark.usefixtures("uncompiled")
def test_branches_are_differentiated_wherever_they_are_declared() -> None:
    """A one-sided spring and Hertz's law beside the same as Piecewise; a limit and a gap that have a kink."""
    for one, other in (
        (50 * Max(x, 0) ** 2, Piecewise((50 * x**2, x > 0), (0, True))),
        (200 * Max(x - Rational(1, 50), 0) ** Rational(5, 2),
         Piecewise((200 * (x - Rational(1, 50)) ** Rational(5, 2), x > Rational(1, 50)), (0, True))),
        (-30 * Min(x, Rational(1, 100)), Piecewise((-30 * x, x < Rational(1, 100)), (-Rational(3, 10), True))),
    ):  # fmt: skip
        r, s = (
            ss.march(ss.scene(Scene(name, potential=V + x**2, **PLANE)), "bathe", dt=0.01, t_end=0.5)
            for name, V in (("by_max", one), ("by_pieces", other))
        )
        assert np.allclose(r.u, s.u, rtol=0.0, atol=1e-12)
    rubbed = Scene("kinked", potential=0 * x, frictions={"pad": Friction(x, 1 + Abs(x))}, **PLANE)
    r = ss.march(ss.scene(rubbed), "average_acceleration", dt=0.001, t_end=1.5)
    assert r.u[-1, 0] == pytest.approx(np.sqrt(2.0) - 1.0, abs=1e-3)  # where 1/2 = u + u^2/2 is its work
    stopped = Scene("stopped", potential=0 * x, contacts={"stop": Contact(1 - Max(x, y), restitution=0)}, **PLANE)
    assert ss.march(ss.scene(stopped), "average_acceleration", dt=0.01, t_end=2.0).u[-1, 0] == pytest.approx(
        1.0, abs=0.02
    )


@pytest.mark.usefixtures("uncompiled")
def test_a_limit_below_nothing_rubs_no_more() -> None:
    pad = Scene("fading", potential=0 * x, frictions={"pad": Friction(x, Rational(1, 10) - x)}, **PLANE)
    r = ss.march(ss.scene(pad), "average_acceleration", dt=0.001, t_end=2.0)
    assert r.v[-1, 0] == pytest.approx(np.sqrt(1.0 - 0.1**2), abs=1e-4)  # the work of 0.1 - u up to u = 0.1


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("force", [x * Symbol("t"), 3 * x])
def test_a_discrete_gradient_of_a_constraint_is_without_forces(force: Any) -> None:
    rod = Scene(
        "pushed_rod", potential=10 * y, constraints={"rod": (x**2 + y**2 - 1) / 2}, forces={y: force},
        **{**PLANE, "start": {x: Rational(3, 5), y: -Rational(4, 5), v: Rational(4, 5), rate(y): Rational(3, 5)}},
    )  # fmt: skip
    one, two, exact = (
        ss.march(ss.scene(rod), name, dt=dt, t_end=0.5).u[-1]
        for name, dt in (("energy_momentum", 0.01), ("energy_momentum", 0.005), ("bdf4", 0.0005))
    )
    errors = np.abs(one - exact).max(), np.abs(two - exact).max()
    assert errors[0] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.usefixtures("uncompiled")
def test_forces_that_repeat_each_other_are_named() -> None:
    th, g = Symbol("th"), Rational(981, 100)
    legs = Scene(
        "three_legs", {y: "m", th: "rad"}, (rate(y) ** 2 + rate(th) ** 2) / 2, g * y, (),
        {y: 0, th: 0, rate(y): 0, rate(th): 0}, 1,
        contacts={"left": Contact(y - sine(th)), "middle": Contact(y), "right": Contact(y + sine(th))},
    )  # fmt: skip
    r = ss.march(ss.scene(legs), "average_acceleration", dt=0.001, t_end=0.01)
    assert r.status == "newton_failed"
    assert "contact 'left', contact 'middle' and contact 'right' repeat each other" in r.failure
    slot = Scene("slot", potential=g * y, constraints={"slot": y}, contacts={"floor": Contact(y)}, **PLANE)
    assert (
        "contact 'floor' acts where constraints leave no motion"
        in ss.march(ss.scene(slot), "average_acceleration", dt=0.01, t_end=0.1).failure
    )
    pads = Scene("pads", potential=0 * x, frictions={"a": Friction(x, 1), "b": Friction(x, 2)}, **PLANE)
    assert (
        "friction 'a' and friction 'b' repeat each other"
        in ss.march(ss.scene(pads), "average_acceleration", dt=0.01, t_end=1.0).failure
    )


@pytest.mark.usefixtures("uncompiled")
def test_a_start_is_of_the_same_coordinates() -> None:
    other = Scene("other", {y: "m"}, rate(y) ** 2 / 2, y**2, (), {y: 1, rate(y): 0}, 1)
    r = ss.march(ss.scene(other), "rk4", dt=0.1, t_end=0.2)
    with pytest.raises(ValueError, match=r"coordinates of given, x \(m\), got one of other, y \(m\)"):
        ss.march(ss.scene(Scene(**GIVEN)), "rk4", dt=0.1, t_end=1.0, start=r)
    given = {"t": 0.2, "u": r.u[-1], "v": r.v[-1]}
    assert ss.march(ss.scene(Scene(**GIVEN)), "rk4", dt=0.1, t_end=1.0, start=given).status == "completed"


def test_without_constraints_none_repeats_another() -> None:
    found = ss.independent(Scene(**GIVEN))
    assert (found.rank, found.left_out) == (0, ())


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(
    ("potential", "energy"),
    [
        (x**2 / 10 + Max(x, 0) ** 2 / 2, lambda x: x**2 / 10 + max(x, 0.0) ** 2 / 2),
        (x**2 / 2 + 5 * Min(x, 0) ** 2, lambda x: x**2 / 2 + 5 * min(x, 0.0) ** 2),
        (Abs(x) ** 3, lambda x: abs(x) ** 3),
        (Abs(x) + x**2 / 2, lambda x: abs(x) + x**2 / 2),
        (Max(x, -x / 2), lambda x: max(x, -x / 2)),
        (50 * Max(x - 1, -1 - x, 0) ** 2, lambda x: 50 * max(x - 1, -1 - x, 0) ** 2),
    ],
)
def test_energy_momentum_keeps_potentials_with_branches(potential: Expr, energy: Callable[[float], float]) -> None:
    """Against SciPy with differences of the energy for forces; one that jumps is not linear, though its slope is 0."""
    given = Scene(
        "branches", coordinates={x: "m"}, kinetic=v**2 / 2, potential=potential, parameters=(),
        start={x: 1, v: Rational(3, 10)}, length=1,
    )  # fmt: skip

    def slope(t: float, z: np.ndarray) -> list[float]:
        return [z[1], (energy(z[0] - 1e-7) - energy(z[0] + 1e-7)) / 2e-7]

    exact = solve_ivp(slope, (0, 5), [1.0, 0.3], rtol=1e-8, atol=1e-9, max_step=2e-3).y[:, -1]
    scene = ss.scene(given)
    assert scene.info.oscillator is None
    for name, close, kept in (("energy_momentum", 1e-4, 1e-13), ("rk4", 5e-3, 1e-2)):
        r = ss.march(scene, name, dt=0.005, t_end=5.0)
        assert r.energy[0] == pytest.approx(0.045 + energy(1.0), rel=1e-14)
        assert np.abs(np.array([*r.u[-1], *r.v[-1]]) - exact).max() < close
        assert np.ptp(r.energy) < kept


def test_a_potential_of_which_no_discrete_gradient_is_formed_is_named() -> None:
    given = Scene(
        "pieces", coordinates={x: "m"}, kinetic=rate(x) ** 2 / 2, potential=Piecewise((x**2, x > 0), (x**2 / 2, True)),
        parameters=(), start={x: 1, rate(x): 0}, length=1,
    )  # fmt: skip
    with pytest.raises(DeclarationError, match=r"got Piecewise\(\(x\*\*2, x > 0\).* take another scheme"):
        ss.march(ss.scene(given), "energy_momentum", dt=0.01, t_end=1.0)


@pytest.mark.usefixtures("uncompiled")
def test_a_force_that_jumps_is_named_where_a_step_has_no_solution() -> None:
    """Dry friction by a sign: the velocity of the step in which the motion turns is neither positive nor negative."""
    rubbed = Scene(
        "by_a_sign", coordinates={x: "m"}, kinetic=v**2 / 2, potential=x**2 / 2, dissipation=Abs(v) / 2, parameters=(),
        start={x: 1, v: Rational(3, 10)}, length=1,
    )  # fmt: skip
    r = ss.march(ss.scene(rubbed), "average_acceleration", dt=0.01, t_end=1.0)
    assert r.status == "newton_failed"
    assert r.t[-1] == pytest.approx(0.19)
    assert (
        "the force on 'x' jumps with sign(x_dot), so that a step that ends where it does has no solution" in r.failure
    )
    smooth = Scene(
        "by_its_cube", coordinates={x: "m"}, kinetic=v**2 / 2, potential=x**2 / 2, dissipation=Abs(v) ** 3 / 6,
        parameters=(), start={x: 1, v: 0}, length=1,
    )  # fmt: skip
    assert not ss.scene(smooth).info.jumps


def test_a_negative_length_is_refused() -> None:
    """No iteration would end by it: a start of -1 m as a length needs its modulus."""
    given = GIVEN | {"parameters": (optional(k, -1, Interval(-oo, oo)),), "start": {x: k, v: 0}}
    with pytest.raises(ValueError, match=r"expected a length of given of 0 or more, .* got -1.0; .* as Abs of it"):
        ss.scene(Scene(**given | {"length": k}))
    assert ss.scene(Scene(**given | {"length": Abs(k)})).length == 1.0
