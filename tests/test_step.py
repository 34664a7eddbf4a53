"""The step of a scheme: each new symbol is determined once, in order, and the balances hold where they are solved."""

import pytest
from declared import BY_NAME
from substep_derive.declare.errors import DeclarationError
from substep_derive.declare.symbols import N, knot_of
from substep_derive.declare.tableau import tableau
from substep_derive.step.step import Step
from sympy import Expr, Rational, Symbol, cancel

import substep as ss


@pytest.mark.parametrize("name", ss.schemes())
def test_each_symbol_is_determined_once_and_reads_only_earlier_ones(name: str) -> None:
    step = Step.of(BY_NAME[name])
    assert len(step.equations) == len(step.unknowns)
    assert len(step.after) == len(step.state)
    known = {*step.state}

    def read(e: Expr) -> set[Symbol]:
        return {s for s in e.free_symbols if knot_of(s)}

    for e in step.prior.values():
        assert read(e) <= known
    known |= {*step.prior}
    for stage in step.stages:
        assert not known & {*stage.in_z, *stage.z}
        assert all(read(e) <= known | {*stage.z} for e in stage.in_z.values())
        known |= {*stage.in_z, *stage.z}
        assert all({s for s in balance.symbols if knot_of(s)} <= known for balance in stage.balances)
    assert {*step.unknowns} <= known
    assert {*step.after} <= known


@pytest.mark.parametrize("name", ss.schemes())
def test_relations_and_balances_hold_for_what_is_solved(name: str) -> None:
    """Relations are 0 with the solved symbols; inertia, damping and displacement have the slopes c_a, c_v, c_u by z."""
    step = Step.of(BY_NAME[name].in_doubles)
    for symbol, e in step.relations.items():
        assert cancel((symbol - e).subs(step.solved, simultaneous=True)) == 0
    for stage in step.stages:
        for k, (b, z) in enumerate(zip(stage.balances, stage.z, strict=True)):
            for part, slope in ((b.inertia, stage.c_a(k)), (b.damping, stage.c_v(k))):
                assert cancel(part.subs(stage.in_z, simultaneous=True).diff(z) - slope) == 0
            if b.force.func == N and b.force.args[0].is_Symbol:
                assert cancel(b.force.args[0].subs(stage.in_z).diff(z) - stage.c_u(k)) == 0


def test_balances_that_read_each_other_are_solved_together() -> None:
    """Directly, or through a third; one that only reads the others comes after them, one that they read before."""
    assert Step.of(BY_NAME["gauss3"]).together == ((0, 1, 2),)
    assert Step.of(BY_NAME["lobatto_iiia3"]).together == ((0, 1),)
    assert Step.of(BY_NAME["sdirk3"]).together == ((0,), (1,), (2,))
    half = Rational(1, 2)
    ring = tableau("ring", ((0, half, 0, 0), (0, 0, half, 0), (half, 0, 0, 0), (half, 0, 0, half)), (0, 0, 0, 1),
                   (half, half, half, 1))  # fmt: skip
    assert Step.of(ring).together == ((0, 1, 2), (3,))
    with pytest.raises(DeclarationError, match="balance 1 reads .* later balance; write the balances in the order"):
        _ = Step.of(tableau("late", ((0, half), (0, half)), (0, 1), (half, half))).stages
