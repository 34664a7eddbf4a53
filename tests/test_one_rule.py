"""R and S of steps that take u and v by one rule, and the entries that modules compute from them.

Oracles: steps of y' = z y + f, stage by stage in mpmath, from tables that are typed in tables.py or follow from their
conditions in designed_oracle.py; the amplification matrix in rational arithmetic.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
import tables
from declared import BY_NAME, derived
from designed_oracle import fourth_order, free_fourth_order
from substep_derive.__main__ import GENERATED
from substep_derive.kernels.march_form import MarchForm
from substep_derive.kernels.scheme import LEAST_DEGREE
from substep_derive.oscillator.amplification import Amplification
from substep_derive.oscillator.one_rule import OneRule
from substep_derive.oscillator.transfer import Transfer
from sympy import Rational, Symbol, cancel

import substep as ss

MP = mpmath.mp.clone()
MP.dps = 40
GAMMA = Symbol("gamma")


@cache
def form(name: str) -> MarchForm:
    return MarchForm.of(Amplification.of(BY_NAME[name]))


@cache
def rule(name: str) -> OneRule:
    found = OneRule.of(form(name).step)
    assert found is not None
    return found


def designed(rows: Any, times: Any) -> tables.Table:
    """A table with the first stage at t_n from rows and ends of sub-steps."""
    A = [[MP.mpf(0)], *rows]
    return tables.square((A, A[-1], [MP.mpf(0), *times]))


TYPED: dict[str, Callable[[], tables.Table]] = {
    "four_substep": lambda: designed(*free_fourth_order(MP.mpf(1) / 2)),
    "four_substep_fourth_order": lambda: designed(*fourth_order(MP.mpf(1))),
    "dormand_prince": lambda: tables.square(tables.dormand_prince()),
    "esdirk43": lambda: tables.square(tables.esdirk43()),
}


def stepped(table: tables.Table, z: Any, loads: list[Any]) -> Any:
    """y_1 of y' = z y + f from y_0 = 1, f at each stage."""
    A, b, _ = table
    slopes: list[Any] = []
    for i, row in enumerate(A):
        known = 1 + sum((w * k for w, k in zip(row[:i], slopes, strict=True)), MP.mpf(0))
        slopes.append((z * known + loads[i]) / (1 - z * row[i]))
    return 1 + sum(w * k for w, k in zip(b, slopes, strict=True))


@pytest.mark.parametrize("name", TYPED)
def test_one_step_of_a_scalar_equation(name: str) -> None:
    """R and S at z = -3/2 + i, each load alone; loads of stages at the same time belong together."""
    table, z = TYPED[name](), MP.mpc(-1.5, 1)
    g = table[0][-1][-1]

    def at(coefficients: Any) -> Any:
        numbers = [MP.mpf(str(c.subs(GAMMA, Rational(str(MP.mpf(g)))).n(40))) for c in coefficients]
        return MP.polyval(numbers[::-1], z)

    found, stencil = rule(name), form(name).stencil
    stages, nothing = table[2], [MP.mpf(0)] * len(table[2])
    R = stepped(table, z, nothing)
    assert abs(1 + at(found.increment) / at(found.den) - R) < 1e-30
    times = [MP.mpf(str(tau.subs(GAMMA, Rational(str(MP.mpf(g)))).n(40))) for tau in stencil]
    for (S, scale), time in zip(found.loads, times, strict=True):
        alone = [MP.mpf(abs(c - time) < 1e-30) for c in stages]
        assert sum(alone) > 0
        assert abs(at(S) / at((scale,)) / at(found.den) - (stepped(table, z, alone) - R)) < 1e-28


def test_which_schemes_have_one_and_that_modules_are_written_by_it_from_four_stages_on() -> None:
    """The schemes whose modules are not written by it have fewer stages, or take u and v by two rules."""
    for name in ("newmark", "fox_goodwin", "newmark_bdf2", "forest_ruth", "rkn64"):
        assert OneRule.of(form(name).step) is None
    for name in ("bathe", "rho_inf_bathe", "three_substep", "esdirk32"):
        assert rule(name).degree < LEAST_DEGREE
    assert all(rule(name).degree >= LEAST_DEGREE for name in TYPED)
    texts = {name: GENERATED / "schemes" / f"{name}.py" for name in BY_NAME}
    assert {name for name, path in texts.items() if path.exists() and "by.horner(" in path.read_text()} == {*TYPED}


@pytest.mark.parametrize("name", ["bathe", "three_substep", "dormand_prince", "four_substep_fourth_order"])
def test_the_filter_by_the_rule_is_that_of_cramers_rule(name: str) -> None:
    a = derived(name).amplification
    both = Transfer.of(a, rule(name)), Transfer.of(a)
    one, other = ([x.den, x.P, x.S, *x.g, *(k for row in x.k for k in row)] for x in both if x is not None)
    assert [cancel(x - y) for x, y in zip(one, other, strict=True)] == [0] * len(one)


@pytest.mark.parametrize("name", TYPED)
def test_every_entry_is_rounded_once(name: str) -> None:
    """From Omega = 1e-6 to 1e8, above critical damping too, where the eigenvalues of L lie far apart."""
    s, f = ss.scheme(name), form(name)
    values = {p.symbol: Rational(float(s.parameters[p.name])) for p in BY_NAME[name].parameters}
    points = [(1e-6, 0.0), (0.7, 0.05), (2.4, 1.0), (40.0, 3.0), (1e3, 3.0), (1e8, 0.0), (1e8, 0.2)]
    found = s.coefficients(*np.array(points).T)
    A = s.amplification(*np.array(points).T)
    for k, (Omega, xi) in enumerate(points):
        at = values | {"Omega": Rational(Omega), "xi": Rational(xi)}
        parts = (f.increment, f.step.den), (f.step.load_N, f.step.den), (f.outputs.N, f.outputs.den)
        for (numerators, den), mine in zip((*parts, (f.outputs.load_N, f.outputs.den)), found, strict=True):
            for e, x in zip(numerators, mine[k].flat, strict=True):
                exact = float(e.subs(at) / den.subs(at))
                assert x == pytest.approx(exact, rel=4e-16 if Omega < 1e8 else 1e-13, abs=0), (Omega, xi)
        step = f.amplification.step
        for e, x in zip(step.N, A[k].flat, strict=True):
            assert x == pytest.approx(float(e.subs(at) / step.den.subs(at)), rel=1e-14, abs=3e-16)
