"""Laws as they are declared: right, or refused with the reason; and what a handle of one computes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hysteresis import Oscillator, exact, half_sine
from plain_kernels import plain_adaptive, text_of, uncompiled
from substep_derive import DeclarationError, Law, before, e, e_dot, elapsed, required
from substep_derive.declare.branches import larger, smaller
from substep_derive.declare.catalogue import find
from substep_derive.declare.laws import declared
from substep_derive.declare.laws.elastic import linear
from substep_derive.declare.laws.plastic import bilinear
from substep_derive.declare.laws.viscous import power_damper
from substep_derive.declare.scenes.hysteretic import hysteretic_oscillator
from substep_derive.kernels.body import Body
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Abs, Eq, Heaviside, Integer, Interval, Max, Min, Piecewise, Rational, Symbol, floor, sign

import substep as ss
from substep.core import laws
from substep.derived.modules import own_law_module, uncommitted_pair
from substep.marching import adaptive, scene_lanes

k, q_y, alpha, p, u = (Symbol(name) for name in ("k", "q_y", "alpha", "p", "u"))
PARAMETERS = (required(k), required(q_y))
# parameters of each law of the catalogue, for one spring
GIVEN: dict[str, dict[str, float]] = {
    "linear": {"k": 3.0},
    "multilinear": {"k": 10.0, "e_1": 0.1, "k_2": 2.0, "e_2": 0.2, "k_3": 5.0},
    "bilinear": {"k": 10.0, "q_y": 1.0, "alpha": 0.1},
    "isotropic_bilinear": {"k": 10.0, "q_y": 1.0, "alpha": 0.1},
    "coulomb": {"stiffness": 1e3, "q_y": 1.0},
    "slip": {"stiffness": 10.0, "q_y": 1.0, "gap": 0.05},
    "clough": {"k": 10.0, "q_y": 1.0, "alpha": 0.1},
    "bouc_wen": {"k": 10.0, "q_y": 1.0, "alpha": 0.1, "n": 1.5},
    "power_damper": {"c": 2.0, "exponent": 0.5},
    "maxwell": {"stiffness": 10.0, "c": 2.0},
}


@pytest.fixture(autouse=True)
def plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Modules as plain Python functions."""
    monkeypatch.setattr(
        scene_lanes,
        "pair_kernels",
        lambda scene, scheme: uncompiled(text_of(uncommitted_pair(scheme.name, scene.info.source))),
    )
    monkeypatch.setattr(adaptive, "_kernels", plain_adaptive)
    monkeypatch.setattr("substep.derived.modules.own_law_module", lambda law: uncompiled(text_of(own_law_module(law))))
    monkeypatch.setattr(laws, "TRIED", 5)
    laws.tried.cache_clear()


def test_the_table_is_complete() -> None:
    assert set(GIVEN) == set(ss.laws()) == {law.name for law in declared()}


@pytest.mark.parametrize("law", [*declared()], ids=lambda law: law.name)
def test_laws_of_the_catalogue_pass_the_trial_of_a_users_own(law: Law) -> None:
    laws.tried(law)


def own(**said: Any) -> Law:
    return Law("own", **{"parameters": PARAMETERS, "memory": {p: 0}, "update": {p: e}, "force": k * (e - p), **said})


@pytest.mark.parametrize(
    ("said", "match"),
    [
        ({"force": k * Symbol("x")}, "the force holds 'x', expected only e, e_dot, k, p, q_y"),
        ({"update": {}}, "memory and update for the same symbols, got only one of both for 'p'"),
        ({"update": {p: e_dot}}, "the update of p holds 'e_dot'"),
        ({"stored": before(p)}, "the stored energy holds 'p_before'"),
        ({"memory": {p: e}}, "the start of p holds 'e'"),
        (
            {"memory": {Symbol("u"): 0}, "update": {Symbol("u"): e}, "force": k * e},
            "memory whose name is free, got 'u'",
        ),
        ({"memory": {k: 0}, "update": {k: e}}, "got 'k' twice; rename one"),
        ({"force": k * e_dot, "dissipated": k * (p - before(p))}, "no account of what a force of the rate dissipates"),
        ({"parameters": required(k)}, "parameters as a tuple of required"),
        ({"memory": [p]}, "memory as a mapping from symbols to expressions"),
        ({"update": {"p": e}}, "update as a mapping from symbols to expressions, got 'p'"),
        ({"memory": {p: float("nan")}}, "memory of p that is finite"),
        ({"update": {p: Eq(e, 1)}}, r"update of p as an expression, got Eq\(e, 1\)"),
        ({"force": float("inf") * e}, "force of a law that is finite"),
        ({"force": Piecewise((k * e, e > 0))}, "a value everywhere"),
        ({"force": k * floor(e)}, r"in the force real functions that compiled kernels have, .*got floor\(e\)"),
        ({"update": {p: Heaviside(e)}}, r"in the update of p real functions .*got Heaviside\(e\)"),
        ({"parameters": (required(k), required(Symbol("law")))}, "parameter whose name is free, got 'law'"),
    ],
)
def test_what_defines_no_law_is_refused(said: Any, match: str) -> None:
    with pytest.raises(DeclarationError, match=match):
        own(**said)


def test_what_is_no_element_of_a_law_is_refused() -> None:
    with pytest.raises(DeclarationError, match="bilinear: expected an elongation as an expression"):
        bilinear.on(Eq(u, 1), k=1, q_y=1, alpha=0)
    with pytest.raises(DeclarationError, match="bilinear: expected a q_y that is finite, got nan"):
        bilinear.on(u, k=1, q_y=float("nan"), alpha=0)


def test_what_the_time_alone_changes_is_a_law() -> None:
    """Once more at once nothing changes."""
    assert ss.law(own(update={p: p + elapsed}), k=1.0, q_y=1.0).memory == ("p",)


@pytest.mark.parametrize(
    ("said", "match"),
    [
        ({"update": {p: p + (e - p) / 2}}, "an update that commits to itself: .* another memory at e = "),
        (
            {"force": k * e + Piecewise((q_y, e > p), (0, True)), "update": {p: p}},
            "a force that is continuous in the elongation, got a jump from .*; close it by a stiff branch",
        ),
    ],
)
def test_what_the_trial_finds_is_refused(said: Any, match: str) -> None:
    with pytest.raises(ValueError, match=match):
        ss.law(own(**said), k=1.0, q_y=1.0)
    with pytest.raises(ValueError, match=match):
        ss.scene("hysteretic_oscillator", law=own(**said), omega=1.0, strength=1.0)


def test_a_law_of_ones_own_is_that_of_the_catalogue() -> None:
    """The declaration of a textbook, with SymPy's own Max and Min."""
    steel = Law(
        "steel",
        parameters=(*PARAMETERS, required(alpha, Interval.Ropen(0, 1))),
        memory={p: 0},
        update={p: e - Max(-q_y / k, Min(q_y / k, e - p))},
        force=alpha * k * e + (1 - alpha) * k * (e - p),
    )
    path = np.cumsum(np.random.default_rng(0).normal(size=40)) * 0.1
    given = {"k": 10.0, "q_y": 0.7, "alpha": 0.2}
    assert ss.law(steel, **given).loop(path)[0] == pytest.approx(ss.law("bilinear", **given).loop(path)[0], abs=1e-13)
    load = ss.HalfSine(4.0, 0.6)
    of = {"omega": 3.0, "xi": 0.02, "strength": 0.7, "hardening": 0.2, "load": load}
    mine, its = (ss.march(ss.scene("hysteretic_oscillator", law=law, **of), "bathe", dt=0.05, t_end=2.0)
                 for law in (steel, "bilinear"))  # fmt: skip
    assert mine.u == pytest.approx(its.u, abs=1e-13)


beyond, below = e - p > q_y / k, k * (e - p) < -q_y
up, down = e - q_y / k, e + q_y / k


@pytest.mark.parametrize(
    "plastic",
    [
        Piecewise((up, beyond), (down, below), (p, True)),
        Piecewise((down, below), (up, beyond), (p, True)),
        Piecewise((down, below), (p, e <= p + q_y / k), (up, True)),
        Piecewise((up, beyond), (p, k * (e - p) >= -q_y), (down, True)),
    ],
)
def test_a_law_by_cases_is_solved_in_closed_form(plastic: Any) -> None:
    steel = Law(
        "steel",
        parameters=(*PARAMETERS, required(alpha, Interval.Ropen(0, 1))),
        memory={p: 0},
        update={p: plastic},
        force=alpha * k * e + (1 - alpha) * k * (e - p),
    )
    of = {"omega": 3.0, "xi": 0.02, "strength": 0.7, "hardening": 0.2, "load": ss.HalfSine(4.0, 0.6)}
    mine, its = (ss.march(ss.scene("hysteretic_oscillator", law=law, **of), "bathe", dt=0.05, t_end=2.0)
                 for law in (steel, "bilinear"))  # fmt: skip
    assert mine.u == pytest.approx(its.u, abs=1e-13)
    assert not mine.newton_iterations.any()


@pytest.mark.parametrize(
    ("force", "closed"),
    [
        (Piecewise((k * e, e < q_y / k), (q_y + alpha * k * (e - q_y / k), True)), True),
        (Piecewise((k * e, e > -q_y / k), (-q_y + alpha * k * (e + q_y / k), True)), True),
        (Piecewise((alpha * k * e, e < 0), (k * e, e < q_y / k), (q_y + alpha * k * (e - q_y / k), True)), True),
        (Piecewise((-q_y, e < -q_y / k), (k * e, e < q_y / k), (q_y, True)), True),
        (Piecewise((k * e, e < q_y / k), (2 * q_y + alpha * k * (e - q_y / k), True)), False),  # it jumps
        (Piecewise((k * e, e < 0), (q_y * e, True)), False),  # it may bend to either side
        (Piecewise((k * e, e < 0), (k * e**2, True)), False),
        (Piecewise((k * e, e < p), (k * p, e < q_y), (k * p + k * (e - q_y), True)), False),  # p may be beyond q_y
    ],
)
def test_cases_are_written_without_selections_where_they_are_seen_to_meet(force: Any, closed: bool) -> None:
    law = own(parameters=(*PARAMETERS, required(alpha, Interval.Ropen(0, 1))), update={p: p}, force=force)
    assert law.force.has(Piecewise) != closed
    random = np.random.default_rng(4)
    for _ in range(50):
        at = dict(zip((e, p, k, q_y), map(Rational, random.integers(1, 40, 4)), strict=True))
        at |= {e: at[e] - 20, p: at[p] - 20, alpha: Rational(1, 3)}
        value = law.force.subs(at).replace(larger, Max).replace(smaller, Min)
        assert value == force.subs(at)


def test_a_sweep_takes_a_law_by_name() -> None:
    of: dict[str, Any] = {"law": "isotropic_bilinear", "omega": 3.0, "hardening": 0.2, "load": ss.HalfSine(4.0, 0.6)}
    swept = ss.sweep("hysteretic_oscillator", "bathe", dt=0.05, t_end=1.0, keep="final", strength=[0.5, 1.0], **of)
    alone = [ss.march(ss.scene("hysteretic_oscillator", strength=x, **of), "bathe", dt=0.05, t_end=1.0)
             for x in (0.5, 1.0)]  # fmt: skip
    assert swept.u.values.ravel() == pytest.approx([r.u[-1, 0] for r in alone], abs=1e-13)
    assert swept.memory.sel(remembered="kappa").values == pytest.approx(
        [r.memory["kappa"][-1] for r in alone], abs=1e-13
    )
    with pytest.raises(ValueError, match="expected a law, got 'foo'"):
        ss.sweep("hysteretic_oscillator", "bathe", dt=0.05, t_end=1.0, omega=3.0, strength=[1.0], law="foo")


@pytest.mark.parametrize("name", GIVEN)
def test_slopes_are_those_of_the_force(name: str) -> None:
    """By differences, away from the bends, which few of the points are near."""
    law, rng, d = ss.law(name, **GIVEN[name]), np.random.default_rng(1), 1e-7
    memory = law.evaluate(rng.normal(size=50) * 0.2).memory
    x, v = rng.normal(size=50) * 0.3, rng.normal(size=50)
    at = law.evaluate(x, v, memory, 0.1)
    by_e = (law.evaluate(x + d, v, memory, 0.1).force - law.evaluate(x - d, v, memory, 0.1).force) / (2 * d)
    by_v = (law.evaluate(x, v + d, memory, 0.1).force - law.evaluate(x, v - d, memory, 0.1).force) / (2 * d)
    assert np.isclose(at.tangent, by_e, rtol=1e-5, atol=1e-5).mean() > 0.95
    assert np.isclose(at.damping, by_v, rtol=1e-4, atol=1e-4).mean() > 0.95
    assert law.of_rate == bool(at.damping.any())


def test_a_softening_law_fails_where_the_effective_stiffness_vanishes() -> None:
    """With a short step it falls as the law says; with a long one no branch has a root, and the state is kept."""
    soft = Law(
        "softening_steel",
        parameters=(*PARAMETERS, required(alpha, Interval(-10, 1))),
        memory={p: 0},
        update={p: Max(e - q_y / k, Min(e + q_y / k, p))},
        force=alpha * k * e + (1 - alpha) * k * (e - p),
    )
    falls = ss.scene(
        "hysteretic_oscillator", law=soft, omega=6.28, strength=1.0, hardening=-2.0, load=ss.HalfSine(4.0, 0.6)
    )
    with np.errstate(all="ignore"):
        short, long = (ss.march(falls, "average_acceleration", dt=dt, t_end=1.0) for dt in (0.01, 0.5))
    assert short.status == "completed"
    assert short.u[-1, 0] > 10.0
    assert (long.status, long.t_failed, len(long.u)) == ("non_finite", 0.5, 1)


def test_schemes_that_take_no_law_say_why() -> None:
    with pytest.raises(DeclarationError, match="energy_momentum takes the internal force as a discrete gradient"):
        Body.of(find("energy_momentum"), EquationsOfMotion(hysteretic_oscillator(bilinear)))
    with pytest.raises(DeclarationError, match="energy_momentum takes the internal force as a discrete gradient"):
        Body.of(find("energy_momentum"), EquationsOfMotion(hysteretic_oscillator(linear)))
    damped = hysteretic_oscillator(power_damper)
    without = replace(damped, name="without", dissipation=Integer(0))
    with pytest.raises(DeclarationError, match="rkn43 is a scheme for .*: expected a scene without damping"):
        Body.of(find("rkn43"), EquationsOfMotion(without))


@pytest.mark.parametrize("scheme", ["average_acceleration", "dormand_prince"])
def test_chosen_steps_see_yielding_and_reversals(scheme: str) -> None:
    """Errors against the exact motion follow the tolerance, also where an elongation turns back within a step."""
    of, push = Oscillator(2 * np.pi, 0.05, 1.0), half_sine(4.0, 0.6)
    wanted = exact(of, push, 2.0, 0.0, 0.0).at(2.0)[:3, 0]
    model = ss.scene("hysteretic_oscillator", omega=of.omega, xi=of.xi, strength=1.0, load=ss.HalfSine(4.0, 0.6))
    for tol in (1e-4, 1e-6):
        r = ss.march(model, scheme, tol=tol, t_end=2.0)
        found = np.array([r.u[-1, 0], r.v[-1, 0], r.memory["p"][-1]])
        assert np.abs(found - wanted).max() < 20 * tol ** (2 / 3 if scheme == "average_acceleration" else 1.0)
        assert r.statistics
        assert r.statistics.rejected > 0
    times = [0.1, 0.35, 0.9, 2.0]
    gridded = ss.march(model, scheme, tol=1e-6, t_end=2.0, grid=times)
    p_exact = [exact(of, push, t, 0.0, 0.0).at(t)[2, 0] for t in times]
    assert gridded.memory["p"] == pytest.approx(p_exact, abs=2e-3)


def test_branches_of_a_law_are_differentiated_as_those_of_a_scene() -> None:
    """Forces with |e| and sign beside the same without; one that jumps is refused as such."""
    c, x, rates = 2.0, np.array([-0.7, -0.1, 0.3, 1.2]), np.array([-2.0, 0.5, 1.0, -0.3])
    one = (required(k),)
    drag = ss.law(Law("drag", one, k * e_dot * Abs(e_dot)), k=c).evaluate(x, rates)
    assert np.allclose(drag.force, c * rates * np.abs(rates))
    assert np.allclose(drag.damping, 2 * c * np.abs(rates))
    hardening = ss.law(Law("hardening", one, k * e * Abs(e)), k=c).evaluate(x)
    assert np.allclose(hardening.tangent, 2 * c * np.abs(x))
    root = ss.law(Law("root", one, k * Abs(e) ** Rational(3, 2) * sign(e)), k=c).evaluate(x)
    assert np.allclose(root.force, c * np.abs(x) ** 1.5 * np.sign(x))
    assert np.allclose(root.tangent, 1.5 * c * np.sqrt(np.abs(x)))
    with pytest.raises(ValueError, match="jump"):
        ss.law(Law("jumps", one, k * sign(e)), k=c)


def test_corners_in_the_other_order_leave_no_part_between_them() -> None:
    """Of k_2 up to e_2, where e_2 is before e_1: k goes up to e_1, and k_3 beyond."""
    x = np.linspace(-0.5, 0.5, 41)
    straight = ss.law("multilinear", k=10.0, e_1=0.2, k_2=2.0, e_2=0.1, k_3=5.0).evaluate(x)
    assert np.allclose(straight.force, 5.0 * x + 5.0 * np.clip(x, -0.2, 0.2))


def test_what_no_law_is_asked_is_refused() -> None:
    steel = ss.law("bilinear", k=1.0, q_y=1.0)
    with pytest.raises(ValueError, match=r"memory of bilinear with the shape \(2, 2\), .* got \(1, 2\)"):
        steel.evaluate([1.0, 2.0], memory=np.zeros((1, 2)))
    with pytest.raises(ValueError, match=r"got \(2, 1\)"):
        steel.evaluate([1.0, 2.0], memory=np.zeros((2, 1)))
    assert steel.evaluate([]).force.shape == (0,)
    with pytest.raises(ValueError, match="expected e "):
        steel.loop([0.0, np.nan, 1.0])
    with pytest.raises(ValueError, match="a row of elongations of one spring, got shape"):
        steel.loop([[1.0, 2.0]])
    for of_time in (ss.law("power_damper", c=2.0), ss.law("maxwell", stiffness=2.0, c=0.1)):
        with pytest.raises(ValueError, match="a law of the elongation alone for a loop"):
            of_time.loop([0.0, 1.0])
    with pytest.raises(ValueError, match="a name or a declaration with parameters, got Law"):
        ss.law(steel, k=7.0)
    with pytest.raises(ValueError, match=r"k of linear as a number or a row of them, .*got shape \(2, 2\)"):
        ss.law("linear", k=np.ones((2, 2)))
    with pytest.raises(ValueError, match="a law by name, linear.* got 3"):
        ss.law(3)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="each degree of freedom once in a row of B, got 0 again"):
        ss.structure(np.eye(2), np.eye(2), springs=[({"a": 1.0, 0: 2.0}, steel)], names=["a", "b"])
    with pytest.raises(ValueError, match="springs as pairs .* got 3; leave springs out"):
        ss.structure(np.eye(2), np.eye(2), springs=3)  # pyright: ignore[reportArgumentType]
    for laws_given in ("bilinear", None, ["bilinear", "bilinear"]):
        with pytest.raises(ValueError, match="laws as one, or a list of one for each story, got"):
            ss.shear_building([1.0, 1.0], laws_given)  # pyright: ignore[reportArgumentType]
    yielding = ss.scene("hysteretic_oscillator", omega=1.0, strength=1.0)
    with pytest.raises(ValueError, match="memory of start as numbers by name, got"):
        ss.march(yielding, "bathe", dt=0.1, t_end=1.0, start={"t": 0.0, "u": 0.0, "v": 0.0, "memory": [0.0, 0.0]})
