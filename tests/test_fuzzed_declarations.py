"""Declarations at random: relations, labels, names, histories and intervals, against an independent stepping."""

import os
from typing import Any

import mpmath
import numpy as np
import pytest
from declared_steps import amplification, exact, march, oscillator, vector
from hypothesis import HealthCheck, assume, given, reject, settings
from hypothesis import strategies as st
from plain_kernels import uncompiled
from substep_derive import Balance, DeclarationError, Parameter, Scheme, derive
from substep_derive.declare.symbols import Omega, h, knot, xi
from substep_derive.emit.first_use import catalogue_pair
from substep_derive.emit.scheme_module import own_module
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Expr, Integer, Interval, Rational, Symbol, oo

from substep.core.formulas import evaluated

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)
NEWMARK = {u1: u0 + h * v0 + h**2 / 4 * (a0 + a1), v1: v0 + h / 2 * (a0 + a1)}
VERIFY = bool(os.environ.get("SUBSTEP_VERIFY"))  # searches for new examples, the gate draws the same each time
DUFFING = oscillator(0, 1, 1)


LABELS = [
    "g",
    "m1",
    "star",
    "s",
    "reported",
    "reported_u",
    "1x",
    "n1",
    "0_",
    "Ω",
    "a",
    "u",
    "r_0",
    "h",
    "i",
    "½",
    "x.y",
    "in",
]
NAMES = ["gamma", "q", "c0", "x1", "velocity", "np", "r", "W", "near_0", "u", "lam", "class", "theta_", "den"]
small = st.fractions(-2, 2, max_denominator=6)


@st.composite
def declarations(draw: Any, longest: int = 4) -> tuple[Scheme, dict[str, Rational]]:
    """One or two stages, implicit or explicit, and a history of up to `longest` entries beyond the step's own."""
    p = Symbol(draw(st.sampled_from(NAMES)))
    low, high = draw(st.sampled_from([(0, 1), (-oo, oo), (-2, oo), (-oo, 3)]))
    parameter = Parameter(p, Interval(low, high), half)
    past = draw(st.lists(st.sampled_from([s for k in range(1, 5) for s in knot(-k)]), max_size=longest, unique=True))

    def whole(symbols: list[Symbol]) -> list[Symbol]:
        """The symbols with those of the steps between, so that each is carried over from the step before."""
        kinds = {
            kind: max((int(s.name.split("_-")[1]) for s in symbols if s.name[0] == kind), default=0) for kind in "uva"
        }
        return [knot(-k)["uva".index(kind)] for kind, deepest in kinds.items() for k in range(1, deepest + 1)]

    past = whole(past)
    scale = {"u": Integer(1), "v": h, "a": h**2}

    def mixture(own: dict[Symbol, Any], power: int) -> Expr:
        """A linear combination of the symbols, scaled as u, h*v, h^2*a, divided by h^power."""
        total = sum((c * scale[s.name[0]] * s for s, c in own.items()), Integer(0))
        return total / h**power

    def some(symbols: Any) -> dict[Symbol, Any]:
        found = {s: Rational(draw(small)) or Rational(1, 7) for s in symbols}  # what is carried has to be read
        return {s: c + (p if draw(st.booleans()) else 0) for s, c in found.items()}

    relations: dict[Symbol, Expr] = {}
    balances = []
    known = [u0, v0, a0, *past]
    stages = draw(st.lists(st.sampled_from(LABELS), max_size=1, unique=True))
    for label in (*stages, "1"):
        k, implicit = knot(label), Integer(draw(st.sampled_from([0, 1, 1])))
        relations[k.u] = mixture({u0: Integer(1), **some([v0, a0, *past]), k.a: implicit * Rational(1, 3)}, 0)
        relations[k.v] = mixture({v0: Integer(1), **some([a0, *known[3:]]), k.a: implicit * half}, 1)
        balances.append(Balance.at(k, half if label != "1" else 1))
        known += list(k)
    start = {s: knot(0)["uva".index(s.name[0])] for s in past}
    try:
        scheme = Scheme("fuzzed", relations, tuple(balances), (parameter,), start=start)
    except DeclarationError as error:
        assert "rename" in str(error)
        reject()
    return scheme, {p.name: Rational(draw(st.sampled_from(["1/3", "1/2", "4/5"])))}


@mpmath.workdps(40)
def check_matrix(scheme: Scheme, values: dict[str, Rational], omega: Rational, damping: Rational) -> None:
    """Derived A, and the emitted module's, against unit states stepped."""
    numbers = {Symbol(name): exact(x) for name, x in values.items()}
    system = oscillator(2 * exact(damping) * exact(omega), exact(omega) ** 2)
    expected = amplification(scheme, numbers, system).astype(float)
    d = derive(scheme)
    where = {Symbol(k): v for k, v in values.items()} | {Omega: omega, xi: damping}
    den = d.den.subs(where)
    if den == 0:
        return
    found = np.array((d.N.subs(where) / den).tolist(), dtype=float)
    size = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(found, expected, atol=1e-13 * size)
    try:
        module = uncompiled(own_module(scheme))
    except DeclarationError as error:
        assert "rename" in str(error)
        return
    out = evaluated(module.amplification, 1, [np.array([float(x)]) for x in (omega, damping, *values.values())])
    np.testing.assert_allclose(out.reshape(found.shape), expected, atol=1e-10 * size)


@given(declarations(), st.sampled_from(["1/2", "3", "1/10"]), st.sampled_from(["0", "1/5"]))
@settings(max_examples=100 if VERIFY else 6, deadline=None, suppress_health_check=list(HealthCheck))
def test_fuzzed_declarations_step_as_they_are_written(declared: Any, omega: str, damping: str) -> None:
    scheme, values = declared
    check_matrix(scheme, values, Rational(omega), Rational(damping))


@pytest.mark.parametrize("deep", [9, 10])
def test_histories_of_eleven_and_twelve_entries(deep: int) -> None:
    relations = {**NEWMARK, u1: NEWMARK[u1] + sum(Rational(k, 100) * knot(-k).u for k in range(1, deep + 1))}
    scheme = Scheme("deep", relations, (Balance.at(end, 1),), start={knot(-k).u: u0 for k in range(1, deep + 1)})
    assert len(scheme.state) == deep + 3
    check_matrix(scheme, {}, Rational(2), Rational(1, 10))


@given(declarations(longest=2))
@settings(max_examples=50 if VERIFY else 5, deadline=None, suppress_health_check=list(HealthCheck))
def test_fuzzed_declarations_march_as_they_are_written(declared: Any) -> None:
    """On Duffing's equation, by the kernel of the pair as plain Python."""
    scheme, values = declared
    try:
        text = catalogue_pair(scheme, EquationsOfMotion(_duffing()))
    except DeclarationError as error:
        assert "rename" in str(error)
        return
    module, n, dt = uncompiled(text), 4, 0.1
    numbers = {Symbol(name): exact(x) for name, x in values.items()}
    try:
        with mpmath.workdps(40):
            rows = np.array(march(scheme, numbers, DUFFING, mpmath.mpf("0.1"), n, vector("0.2"), vector("0.3")))
    except (ArithmeticError, ZeroDivisionError):
        return
    rows = rows[:, :, 0].astype(float)
    assume(np.abs(rows).max() < 1e3)
    scalars = {"h": dt, "tolerance": 1e-12, "k_": 1.0, "eps_": 1.0, **{f"{k}_": float(v) for k, v in values.items()}}
    arrays: dict[str, Any] = {name: np.array([x]) for name, x in scalars.items()}
    u, v, a = (np.array([[x]]) for x in (0.2, 0.3, -0.208))
    arrays |= {"u": u, "v": v, "a": a, "n": np.array([n]), "first": 0, "stride": 1, "bound": np.array([np.inf])}
    arrays["state"] = np.zeros((1, len(module.STATE), 1))
    arrays["out"] = np.zeros((1, n + 1, len(module.REPORTED), 1))
    arrays["extremes"] = np.zeros((1, len(module.REPORTED)))
    arrays["newton"] = np.zeros((1, 2, len(scheme.balances)), dtype=np.int64)
    arrays["iterations"] = np.zeros((1, n, len(scheme.balances)), dtype=np.int64)
    arrays |= {"n_done": np.zeros(1, dtype=np.int64), "status": np.zeros(1, dtype=np.int64), "peak": np.zeros(1)}
    for k, (kind, _) in enumerate(module.STATE):
        arrays["state"][:, k] = arrays[kind]
    with np.errstate(all="ignore"):
        if module.START_ARGUMENTS:
            module.start(*(arrays[name] for name in module.START_ARGUMENTS))
        module.march(*(arrays[name] for name in module.ARGUMENTS))
    assume(arrays["status"][0] == 0)
    size = np.abs(rows).max(axis=0)
    for k, kind in enumerate(module.REPORTED):
        error = np.abs(arrays["out"][0, 1:, k, 0] - rows[1:, "uva".index(kind)]).max()
        assert error <= 1e-8 * max(1.0, size["uva".index(kind)]), kind
    assert (arrays["extremes"] == np.abs(arrays["out"]).max(axis=1)[:, :, 0]).all()


def _duffing() -> Any:
    from substep_derive.declare.catalogue import find_scene

    return find_scene("duffing")
