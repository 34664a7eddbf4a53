"""Declarations at random on matrices: the printed plan against dense stepping of what was declared."""

import os
from dataclasses import replace
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from dense_steps import march as dense_march
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from substep_derive import DeclarationError, Scheme
from substep_derive.declare.schemes.alpha import kr_alpha
from substep_derive.declare.symbols import K0, C, M, N, h, knot
from substep_derive.emit.first_use import own_plan
from sympy import Integer, Rational, Symbol
from test_fuzzed_declarations import declarations

import substep as ss
from substep.structures.march import scheme_plan
from substep.structures.march.fixed_steps import FixedSteps
from substep.structures.march.linear import combined
from substep.structures.march.steps import Run
from substep.structures.march.time_loop import steps_taken

u0, v0, a0 = knot(0)
u1, v1, a1 = knot(1)
U = knot("x").u
MASS = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, 0.1], [0.0, 0.1, 3.0]])
STIFFNESS = np.array([[6.0, -2.0, 0.0], [-2.0, 5.0, -3.0], [0.0, -3.0, 4.0]])
DAMPINGS = {
    "none": None,
    "rayleigh": ss.Rayleigh(0.1, 0.02),
    "full": np.array([[0.3, 0.1, 0], [0.1, 0.2, 0], [0, 0, 0.1]]),
}
SWAY = ss.Harmonic(1.0, 2.0, 0.3)
QUOTIENTS = {
    "one": Integer(1),
    "mass": M / (M + h * C / 2 + h**2 * K0 / 7),
    "damping": (M + h * C) / (2 * M),
    "stiffness": (M - h**2 * K0) / (M + h**2 * K0),
}


def marched(scheme: Scheme, values: dict[str, Any], frame: ss.Structure, dt: float, n: int) -> Any:
    """u and v after each step, by the scheme's plan as it is printed."""
    module = ModuleType("plan_of_fuzzed")
    exec(own_plan(scheme), module.__dict__)
    info = SimpleNamespace(fixed={}, declaration=scheme, start="function" if scheme.start else "given")
    history = [("uva".index(s.name[0]), 0) for s in scheme.state]
    handle: Any = SimpleNamespace(name=scheme.name, parameters=values, starter=None, info=info, history=history)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scheme_plan, "_module", lambda scheme: module)
        clock = FixedSteps(Run(frame, handle, dt), n)
        return np.array([combined(step.march.steps.report[:2], step.X) for step in steps_taken(clock)])


@given(declarations(longest=2), st.sampled_from(list(QUOTIENTS)), st.sampled_from(list(DAMPINGS)))
@settings(
    max_examples=25 if os.environ.get("SUBSTEP_VERIFY") else 4, deadline=None, suppress_health_check=list(HealthCheck)
)
def test_fuzzed_plans_step_as_they_were_declared(declared: Any, quotient: str, damping: str) -> None:
    scheme, values = declared
    coefficient = QUOTIENTS[quotient]
    relations = {s: e.coeff(a0) * (coefficient - 1) * a0 + e for s, e in scheme.relations.items()}
    scheme = replace(scheme, relations={s: e.expand() if quotient == "one" else e for s, e in relations.items()})
    frame = ss.structure(
        MASS, STIFFNESS, C=DAMPINGS[damping], load=([1.0, 0.0, -1.0], SWAY), u0=[0.1, 0.2, -0.1], v0=[0.3, 0.0, 0.1]
    )
    dt, n = 0.05, 5
    numbers = {name: float(x) for name, x in values.items()}
    found = marched(scheme, numbers, frame, dt, n)
    symbols = {Symbol(name): x for name, x in numbers.items()}
    load = np.array([1.0, 0.0, -1.0])
    rows = dense_march(
        scheme,
        symbols,
        MASS,
        frame.damping,
        STIFFNESS,
        lambda t: load * SWAY(np.array([t]))[0],
        dt,
        n,
        frame.u0,
        frame.v0,
    )
    expected = np.array([row[:2] for row in rows[1:]])
    assume(np.abs(expected).max() < 1e6)
    scale = np.array([1.0, dt])[:, None]
    assert np.abs(scale * (found - expected)).max() <= 1e-10 * np.abs(scale * expected).max()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"relations": {u1: u0 + h * v0 + h**2 * M**2 / (M**2 + (h * C) ** 2) * a0}}, "each linear in M, C, K0"),
        ({"relations": {u1: u0 + h * v0 + h**2 * M / (M + h * C) * a1}}, "to depend on a_1 by a number"),
        ({"damping": v0 + h * a1}, "an explicit balance"),
        ({"relations": {U: u1 + h**2 * a1}, "force": N(U)}, "an explicit balance"),
    ],
)
def test_what_a_plan_has_no_systems_for_is_refused(change: dict[str, Any], message: str) -> None:
    """Kolay and Ricles's scheme with one part changed."""
    scheme = kr_alpha.fix({"rho_inf": Rational(1, 2)})
    balance = replace(scheme.balances[0], **{k: e for k, e in change.items() if k != "relations"})
    scheme = replace(scheme, balances=(balance,), relations={**scheme.relations, **change.get("relations", {})})
    with pytest.raises(DeclarationError, match=f"kr_alpha on a structure: expected.*{message}"):
        own_plan(scheme)
