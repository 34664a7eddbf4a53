"""Scheme -> is its step on u'' = g(u) symmetric, symplectic, conjugate to a symplectic one? With proofs.

A verdict holds for the reported u and v, started consistently. `True` comes from an identity between the coefficients
of the step's Nystrom form, `False` from a tree, a monomial or an eigenvalue that contradicts; else it is open.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from sympy import Expr, Rational, factor, ring

from ..oscillator.evaluation import Evaluation
from ..oscillator.order import drift
from .nystrom import Nystrom, nystrom
from .step import StepSeries, exact
from .trees import Series, Trees, U, V, trees

HIGHEST_WEIGHT = 8  # of trees in which a contradiction is sought
TERMS = (5, 7, 13)  # of the series of the eigenvalue's modulus, tried one after another


@dataclass(frozen=True)
class Verdict:
    """holds: True with a proof, False with a counterexample, None where neither was found. reason: that, as text."""

    holds: bool | None
    reason: str

    @property
    def word(self) -> str:
        """'yes', 'no' or 'open'."""
        return {True: "yes", False: "no", None: "open"}[self.holds]

    def __bool__(self) -> bool:
        """Whether it holds, with a proof."""
        return self.holds is True

    def __str__(self) -> str:
        return f"{self.word}: {self.reason}"


@dataclass(frozen=True)
class Structure:
    """Verdicts on the map from (u_n, v_n) to (u_n+1, v_n+1) on u'' = g(u), for mass 1.

    symmetric: the step of length -h is its inverse, whatever g. symplectic: for every g that is minus the gradient of a
    potential the map preserves du ^ d(Mv). conjugate_symplectic: for every such g there is a change of u and v near the
    identity after which it does; its long-time behaviour is then that of a symplectic map.
    """

    symmetric: Verdict
    symplectic: Verdict
    conjugate_symplectic: Verdict


def structure(evaluation: Evaluation, written: Callable[[Expr], str] = str) -> Structure:
    """The verdicts at the numbers that an evaluation has for the parameters. Raises InconsistentScheme.

    written: the eigenvalue's modulus as text.
    """
    if damped := _modulus(evaluation, written):
        return Structure(*[Verdict(False, damped)] * 3)
    step = StepSeries(evaluation)
    form = nystrom(step)
    if form is None:
        own = "the step is no map of u and v alone, and it neither damps the oscillator nor feeds it"
        return Structure(*[Verdict(None, own)] * 3)
    of = trees(False, False, False)
    of.grow(HIGHEST_WEIGHT + 1)
    u, v, _ = exact(of, step.one, HIGHEST_WEIGHT)
    _, (u1, v1, _) = step.step(of, step.start(of, u, v))
    symplectic = _symplectic(form, of, evaluation, u1, v1)
    return Structure(_symmetric(form, step, of, u1, v1), symplectic, _conjugate(form, symplectic))


def _modulus(evaluation: Evaluation, written: Callable[[Expr], str]) -> str | None:
    """The first term of the oscillator's eigenvalue's modulus minus 1, as text; None if all that are sought vanish."""
    for terms in TERMS:
        real = [c.alpha for c in drift(evaluation, Rational(0), terms).c]  # zeta = i without damping
        for power, c in enumerate(real):
            if c:
                value = written(factor(evaluation.field.expression(c)))
                return f"on u'' = -omega^2 u its eigenvalues have the modulus 1 + ({value})*(omega h)^{power} + ..."
    return None


def _symmetric(form: Nystrom, step: StepSeries, of: Trees, u1: Series, v1: Series) -> Verdict:
    permutation = form.permutation_to(form.adjoint())
    if permutation is not None:
        pairs = ", ".join(f"{i} -> {j}" for i, j in enumerate(permutation))
        return Verdict(
            True,
            "with t_n and t_n + h exchanged and h replaced by -h the equations of the step are the same; stages "
            f"{pairs or 'none'}",
        )
    back = step.step(of, step.start(of, u1, v1, direction=-1), direction=-1)[1]
    for w in range(HIGHEST_WEIGHT + 1):
        for quantity, series, own in (("u", back[0], U), ("h v", back[1], V)):
            for tree, c in sorted(series[w].items()):
                if tree != own:
                    return Verdict(
                        False,
                        f"a step of h and one of -h leave ({_text(step, c)})*{of.text(tree)} in {quantity}",
                    )
    return Verdict(None, f"a step of h and one of -h differ from none in no tree up to weight {HIGHEST_WEIGHT}")


def _text(step: StepSeries, c: Any) -> str:
    return str(step.evaluation.field.expression(c))


def _symplectic(form: Nystrom, of: Trees, evaluation: Evaluation, u1: Series, v1: Series) -> Verdict:
    if form.is_symplectic:
        return Verdict(
            True, "bbar_i = b_i (1 - c_i) and b_i (bbar_j - a_ij) = b_j (bbar_i - a_ji) for all stages (Suris)"
        )
    found = _area(of, evaluation, u1, v1)
    if found:
        return Verdict(False, f"on one coordinate du_1 ^ dv_1 = (1 + {found} + ...) du_0 ^ dv_0")
    return Verdict(None, f"on one coordinate it preserves area up to h^{HIGHEST_WEIGHT}")


def _area(of: Trees, evaluation: Evaluation, u1: Series, v1: Series) -> str | None:
    """The first term of the Jacobian's determinant minus 1, with N', N'', ... at u_0 as N1, N2, ...."""
    names = ["v", *(f"N{k}" for k in range(HIGHEST_WEIGHT + 2))]
    R, v, *N = ring(names, evaluation.field.domain)

    def value(tree: int) -> Any:
        kind, branches = of.keys[tree]
        found = v if kind == "v" else N[len(branches)]
        for branch in branches:
            found = found * value(branch)
        return found

    def by_u(p: Any) -> Any:
        return sum((p.diff(N[k]) * N[k + 1] for k in range(len(N) - 1)), R.zero)

    levels = [[sum((value(x) * c for x, c in s[w].items() if x != U), R.zero) for w in range(len(s))]
              for s in (u1, v1)]  # fmt: skip
    by = [[[by_u(p) for p in s], [p.diff(v) for p in s[1:]]] for s in levels]
    by[0][0][0] += 1
    for w in range(HIGHEST_WEIGHT):
        total = sum((by[0][0][i] * by[1][1][w - i] - by[0][1][i] * by[1][0][w - i] for i in range(w + 1)), R.zero)
        if total != (1 if w == 0 else 0):
            terms = sorted(str(x) for x in total.as_expr().as_ordered_terms())
            return f"h^{w}*({' + '.join(terms)})"
    return None


def _conjugate(form: Nystrom, symplectic: Verdict) -> Verdict:
    if symplectic.holds:
        return Verdict(True, "it is symplectic itself")
    change = form.symplectic_conjugate()
    if change is None:
        return Verdict(None, "no change of u by h^2 N(u) and of v by h N(u) was found that makes it symplectic")
    xi, eta = change
    return Verdict(
        True,
        f"with x = u + {xi} h^2 N(u) and p = v + {eta} h N(u), per unit mass, the step from (x, p) satisfies Suris's "
        "conditions",
    )
