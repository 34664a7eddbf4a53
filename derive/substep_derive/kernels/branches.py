"""The root of a balance whose force is piecewise linear, in closed form: a linear solve for each branch.

A force of Min and Max of linear functions of the unknown z gives a residual of that kind. Where every branch of the
residual increases with z, the root of Min(f, g) is the larger of both roots, that of Max(f, g) the smaller: the branch
that holds is found by comparing roots, without trying one branch after another.
"""

from collections.abc import Sequence
from typing import Any

from sympy import Add, And, Dummy, Expr, Mul, Piecewise, S, Symbol, collect, nan

from ..declare.branches import larger, smaller
from ..declare.parameter import Parameter, positive
from ..motion.components import Writer


def root(residual: Expr, z: Symbol, w: Writer) -> Expr | None:
    """The z at which the residual is 0, NaN where a branch does not increase; None if it is not piecewise linear."""
    branches = dict[Expr, Expr]()
    found = _root(residual, z, (*w.scheme.parameters, *w.motion.scene.parameters), branches)
    if found is None:
        return None
    slopes = {e: e.diff(z) for e in branches.values()}
    run = {e: s for e, s in slopes.items() if s.free_symbols <= w.fixed}
    of_run = w.constant(_unless([s > 0 for s in dict.fromkeys(run.values())]))
    of_step = [w.hoist(s) > 0 for s in dict.fromkeys(slopes.values()) if not s.free_symbols <= w.fixed]
    roots = {name: _of_branch(e, slopes[e], z, w, of_run) for name, e in branches.items()}
    # a comparison with NaN is false, so that it is added, not compared: to the reciprocal slopes of all branches, or
    # where some are those of a law whose stiffness it remembers, to the root
    return found.xreplace(roots) + (of_run + _unless(of_step) if of_step else S.Zero)


def _unless(rises: Sequence[Any]) -> Expr:
    """0 where all of these hold, else NaN."""
    return Piecewise((0, And(*rises)), (nan, True)) if rises else S.Zero


def _of_branch(e: Expr, slope: Expr, z: Symbol, w: Writer, nothing: Expr) -> Expr:
    """The root of a linear branch; nothing: 0, or NaN where there is no root, a constant."""
    known = e.subs(z, 0)
    if not slope.free_symbols <= w.fixed:
        return -w.hoist(known) / w.hoist(slope)
    over = w.constant(1 / slope + nothing)
    moving = sorted(known.free_symbols - w.fixed, key=str)
    return w.hoist(collect((-over * known).expand(), moving)) if known != 0 else nothing


def _root(e: Expr, z: Symbol, parameters: Sequence[Parameter], branches: dict[Expr, Expr]) -> Expr | None:
    """The root in names of the roots of the branches, which are put into a dictionary."""
    e = _distributed(e)
    for term in Add.make_args(e):
        factors = Mul.make_args(term)
        branching = [x for x in factors if isinstance(x, larger | smaller) and x.has(z)]
        if not branching:
            continue
        factor = Mul(*(x for x in factors if x is not branching[0]))
        rises = positive(factor, parameters, or_zero=True)
        if len(branching) > 1 or factor.has(z) or not (rises or positive(-factor, parameters, or_zero=True)):
            return None
        roots = [_root(factor * x + (e - term), z, parameters, branches) for x in branching[0].args]
        found = [x for x in roots if x is not None]
        if len(found) < len(roots):
            return None
        return (larger if isinstance(branching[0], smaller) == rises else smaller)(*found)
    whole = e.expand()
    if whole.diff(z).has(z):
        return None
    name = Dummy()
    branches[name] = whole
    return name


def _distributed(e: Expr) -> Expr:
    """The expression with products of sums that branch multiplied out."""
    terms = list[Expr]()
    for term in Add.make_args(e):
        sums = [x for x in Mul.make_args(term) if isinstance(x, Add) and x.has(larger, smaller)]
        if not sums:
            terms.append(term)
            continue
        factor = Mul(*(x for x in Mul.make_args(term) if x is not sums[0]))
        terms += [_distributed(factor * x) for x in sums[0].args]
    return Add(*terms)
