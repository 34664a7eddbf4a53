"""What a declaration of energies has to be, and that Lagrange's equations of it hold what a scene needs and no more."""

from dataclasses import replace
from typing import Any

import pytest
from plain_kernels import text_of
from substep_derive import (
    Balance,
    DeclarationError,
    N,
    Scene,
    Scheme,
    acceleration,
    f,
    h,
    knot,
    optional,
    rate,
    required,
    sampled,
    t,
)  # fmt: skip
from substep_derive.declare.scenes import lagrange
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Abs, Expr, Function, I, Rational, Symbol, besselj, cos, erf, sin, symbols

import substep as ss
from substep.derived.modules import uncommitted_pair

u, w, k, c, m = symbols("u w k c m")


def declared(**changes: Any) -> Scene:
    given: dict[str, Any] = {
        "name": "mine", "coordinates": {u: "m", w: "rad"}, "kinetic": m * (rate(u) ** 2 + (u * rate(w)) ** 2) / 2,
        "potential": k * u**2 / 2, "parameters": (optional(m, 2), required(k)), "length": 1,
        "start": {u: 1, w: 0, rate(u): 0, rate(w): 0},
    }  # fmt: skip
    return Scene(**{**given, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kinetic": m * rate(u) ** 2 * rate(w) ** 2}, "expected a kinetic energy quadratic in u_dot, w_dot"),
        ({"kinetic": m * Abs(rate(u)) * rate(w)}, "expected a kinetic energy quadratic"),
        ({"kinetic": m * acceleration(u) * rate(u)}, "kinetic energy holds 'u_ddot'"),
        ({"kinetic": m * rate(u) ** 2 / 2}, "got a singular mass matrix, .* leave out the coordinate"),
        ({"start": {u: 0, w: 0, rate(u): 0, rate(w): 0}}, "singular mass matrix at the start, .*start elsewhere"),
        ({"forces": {k: u}}, "forces are given on 'k', expected one of the coordinates u, w"),
        ({"forces": {u: c * u}}, "force on u holds 'c'"),
        ({"forces": {u: acceleration(w)}}, "holds the acceleration 'w_ddot'.*into the kinetic energy"),
        ({"forces": {u: sampled * cos(w)}}, "force on u holds 'f'"),
        ({"load": {k: t}}, "load are given on 'k'"),
        ({"dissipation": -m * rate(u) ** 2}, "expected a dissipation that is convex"),
        ({"dissipation": m * rate(u) ** 2 * t}, "dissipation holds 't'"),
        ({"potential": besselj(0, u)}, r"in the potential real functions that .*, got besselj\(0, u\); write it by"),
        ({"potential": Function("F")(w)}, r"got F\(w\)"),
        ({"forces": {u: I * u}}, "in the force on u real functions .*, got I;"),
        ({"kinetic": m * (rate(u) ** 2 + erf(u) ** 2 * rate(w) ** 2)}, r"in the kinetic energy .*, got erf\(u\)"),
    ],
)
def test_a_declaration_that_defines_no_motion_is_refused(changes: Any, message: str) -> None:
    with pytest.raises(DeclarationError, match=f"^mine: .*{message}"):
        declared(**changes)


def test_balances_without_a_reading_are_refused() -> None:
    """Of schemes of one's own: two knots that depend on the unknown, or a damping that mixes other velocities."""
    (u0, v0, a0), (u1, v1, a1) = knot(0), knot(1)
    relations = {u1: u0 + h * v0 + h**2 / 4 * (a0 + a1), v1: v0 + h / 2 * (a0 + a1)}

    def with_force(force: Any) -> Scheme:
        return Scheme("mine", relations=relations, balances=(Balance(a1, v1, force, f(1)),))

    two, lagging = with_force((N(u1) + N((u0 + u1) / 2)) / 2), with_force((N(u1) + N(u0)) / 2)
    for scheme, scene, said in (
        (two, "kapitza", "at one knot that depends on the new acceleration, got 2 such on kapitza"),
        (lagging, "van_der_pol", "damping mixes the velocities of the knots"),
    ):
        with pytest.raises(DeclarationError, match=f"^mine: expected .*{said}"):
            uncommitted_pair(scheme, scene)
    assert "once0_0" in text_of(uncommitted_pair(lagging, "kapitza"))  # which asks for no velocity


def test_a_start_at_which_the_mass_is_singular_is_refused() -> None:
    with pytest.raises(ValueError, match="^spring_pendulum: expected a start .* mass .*r_0 = 0"):
        ss.scene("spring_pendulum", r_0=0.0)


def test_lagranges_equations_are_written_with_what_a_scene_needs() -> None:
    """A damper or a constant gyroscopic force in any of the three slots is a matrix, a force of t alone is a load."""
    plain = declared(kinetic=m * (rate(u) ** 2 + rate(w) ** 2) / 2)
    damper = EquationsOfMotion(replace(plain, dissipation=k * rate(u) ** 2 / 2))
    force = EquationsOfMotion(replace(plain, forces={u: -k * rate(u) + m * cos(t)}))
    assert damper.damping == force.damping
    assert list(force.load) == [m * cos(t), 0]
    assert not (damper.general or force.general)
    assert force.linear
    turning = EquationsOfMotion(replace(plain, kinetic=plain.kinetic + m * k * (u * rate(w) - w * rate(u))))
    assert turning.damping.tolist() == [[0, -2 * k * m], [2 * k * m, 0]]
    assert turning.linear
    hoop = EquationsOfMotion(lagrange.rotating_hoop)
    assert not hoop.general
    assert hoop.energy.diff(Symbol("spin")) == hoop.potential.diff(Symbol("spin"))
    cartesian = EquationsOfMotion(
        declared(kinetic=m * ((rate(u) * cos(w) - u * sin(w) * rate(w)) ** 2
                              + (rate(u) * sin(w) + u * cos(w) * rate(w)) ** 2) / 2)
    )  # fmt: skip
    assert cartesian.mass.tolist() == [[m, 0], [0, m * u**2]]
    assert cartesian.angular_momentum == m * u**2 * rate(w)


def test_small_masses_beside_large_ones_are_not_none() -> None:
    """Of eight coordinates, whose masses are in the ratio of 1 to 10^6: the determinant is 10^-24 of the largest's."""
    q = symbols("q1:9")

    def of(mass: Expr) -> Scene:
        kinetic = sum((rate(a) ** 2 for a in q[:4]), Rational(0)) / 2
        kinetic += sum((mass * (rate(a) + rate(q[0])) ** 2 for a in q[4:]), Rational(0)) / 2
        return Scene(
            "light", coordinates=dict.fromkeys(q, "m"), kinetic=kinetic.expand(), potential=q[0] ** 2, parameters=(),
            start={s: 0 for a in q for s in (a, rate(a))}, length=1,
        )  # fmt: skip

    assert of(Rational(1, 10**6)).coordinates
    with pytest.raises(DeclarationError, match="singular mass matrix.* without one of q5, q6, q7, q8"):
        of(Rational(0))
