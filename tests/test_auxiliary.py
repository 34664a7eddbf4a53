"""Auxiliary states: what a scheme carries beside u, v and a, under a name of its own."""

import numpy as np
import pytest
from declared import BY_NAME
from substep_derive import Balance, DeclarationError, N, Scheme, derive, f, h, knot
from substep_derive.declare.symbols import auxiliary, successor

import substep as ss

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
x0, x1 = knot(0, "memory").v, knot(1, "memory").v
CARRYING = [name for name, s in BY_NAME.items() if any(map(auxiliary, s.state))]


def scheme(start: object = v0, name: str = "memory") -> Scheme:
    """The velocity that is reported stays behind: x is that of the trapezoidal rule, and v the mean of two x."""
    old, new = knot(0, name).v, knot(1, name).v
    return Scheme(
        "behind",
        relations={new: old + h * (a0 + a1) / 2, u1: u0 + h * (old + new) / 2, v1: (old + new) / 2},
        balances=(Balance.at(end._replace(v=new), 1),),
        start={old: start} if start is not None else {},  # type: ignore[dict-item]
    )


def test_its_symbols_go_from_step_to_step() -> None:
    assert (successor(x0), successor(knot(-1, "memory").a)) == (x1, knot(0, "memory").a)
    assert derive(scheme()).state == ("u", "h^2*a", "h*memory")
    assert derive("arnold_bruels").state == ("u", "h*v", "h^2*a", "h^2*weighted")


def test_a_step_with_one_is_its_formulas() -> None:
    """Against the trapezoidal rule, whose velocity the auxiliary one is."""
    structure = ss.structure([[1.0]], [[20.0]], C=[[0.4]], u0=[1.0], v0=[0.5])
    r, plain = (ss.march(structure, s, dt=0.05, t_end=2.0, account=False) for s in (scheme(), "average_acceleration"))
    assert np.allclose(r.u, plain.u, rtol=0, atol=1e-13)
    assert np.allclose(r.v[1:], (plain.v[1:] + plain.v[:-1]) / 2, rtol=0, atol=1e-12)
    assert r.state.history["memory"] == pytest.approx(plain.v[-1], abs=1e-12)


@pytest.mark.parametrize("name", CARRYING)
def test_a_run_goes_on_with_it(name: str) -> None:
    """On a scene and on a structure: two halves are the whole, to the bit."""
    structure = ss.structure(np.eye(2), [[20.0, -10.0], [-10.0, 10.0]], C=0.1 * np.eye(2), u0=[1.0, 0.0])
    for system in (ss.scene("linear_oscillator", omega=6.28, xi=0.02), structure):
        half = ss.march(system, name, dt=0.02, t_end=0.4)
        whole, on = (ss.march(system, name, dt=0.02, t_end=0.8, **way) for way in ({}, {"start": half}))
        assert np.array_equal(on.u[-1], whole.u[-1])
        assert set(half.state.history) - {"u", "v", "a", "h*v", "h^2*a"}


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("name", CARRYING)
def test_a_ball_bounces_under_it(name: str) -> None:
    """It falls from 1 m, and leaves with half of its velocity; what is kept of reactions has the state's name."""
    r = ss.march(ss.scene("bouncing_ball"), name, dt=5e-4, t_end=0.7)
    g, fall = 9.81, np.sqrt(2 / 9.81)
    since = r.t[-1] - fall
    assert r.u[-1, 0] == pytest.approx(g * fall / 2 * since - g / 2 * since**2, abs=2e-3)
    assert r.status == "completed"


@pytest.mark.parametrize("name", CARRYING)
def test_steps_by_a_tolerance_are_refused_by_name(name: str) -> None:
    with pytest.raises(ValueError, match=f"one-step or composite scheme .*, got {name}, which carries .*; give dt"):
        ss.march("duffing", name, tol=1e-6, t_end=1.0)


def test_what_is_no_auxiliary_state_is_refused() -> None:
    with pytest.raises(DeclarationError, match="behind: the step reads v_0:memory, for which start says nothing; give"):
        scheme(start=None)
    expected = r"expected an auxiliary state at a number of steps from .* got '{}'; write it as knot\(0, 'rate'\).v"
    for name in ("v", "two words", "1st"):
        with pytest.raises(DeclarationError, match=expected.format(f"0:{name}")):
            scheme(name=name)
    g = knot("g", "memory").u
    with pytest.raises(DeclarationError, match=expected.format("g:memory")):
        Scheme("stage", {g: u0 + h * v0, u1: g, v1: v0 + h * a1}, (Balance(a1, v0, N(g), f(0)),))
