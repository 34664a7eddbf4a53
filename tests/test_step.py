"""The step of a scheme: each new symbol is determined once, in order, and the balances hold where they are solved."""

import pytest
from declared import BY_NAME
from substep_derive.declare.errors import DeclarationError
from substep_derive.declare.symbols import N, knot_of
from substep_derive.step.step import Step
from sympy import Expr, Symbol, cancel

import substep as ss


def coupled(scheme: str) -> Step | None:
    """The step of a scheme whose balances can be solved one after another; None of one that couples them."""
    step = Step.of(BY_NAME[scheme].in_doubles)
    try:
        step.stages
    except DeclarationError:
        return None
    return step


@pytest.mark.parametrize("name", ss.schemes())
def test_each_symbol_is_determined_once_and_reads_only_earlier_ones(name: str) -> None:
    step = Step.of(BY_NAME[name])
    assert len(step.equations) == len(step.unknowns)
    assert len(step.after) == len(step.state)
    step = coupled(name)
    if step is None:
        return
    known = {*step.state}

    def read(e: Expr) -> set[Symbol]:
        return {s for s in e.free_symbols if knot_of(s)}

    for e in step.prior.values():
        assert read(e) <= known
    known |= {*step.prior}
    for stage in step.stages:
        assert not known & {*stage.in_z, stage.z}
        assert all(read(e) <= known | {stage.z} for e in stage.in_z.values())
        known |= {*stage.in_z, stage.z}
        assert {s for s in stage.balance.symbols if knot_of(s)} <= known
    assert {*step.unknowns} <= known
    assert {*step.after} <= known


@pytest.mark.parametrize("name", ss.schemes())
def test_relations_and_balances_hold_for_what_is_solved(name: str) -> None:
    """Relations are 0 with the solved symbols; inertia, damping and displacement have the slopes c_a, c_v, c_u by z."""
    step = coupled(name)
    if step is None:
        return
    for symbol, e in step.relations.items():
        assert cancel((symbol - e).subs(step.solved, simultaneous=True)) == 0
    for stage in step.stages:
        b = stage.balance
        for part, slope in ((b.inertia, stage.c_a), (b.damping, stage.c_v)):
            assert cancel(part.subs(stage.in_z, simultaneous=True).diff(stage.z) - slope) == 0
        if b.force.func == N and b.force.args[0].is_Symbol:
            assert cancel(b.force.args[0].subs(stage.in_z).diff(stage.z) - stage.c_u) == 0
