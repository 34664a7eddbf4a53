"""What is found about a scheme on nonlinear equations, as one object."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

from sympy import Expr, Rational

from ..oscillator.evaluation import Evaluation
from ..oscillator.order import AtLeast, Triple, drift
from .order import Error, nonlinear_order
from .structure import Structure, Verdict, structure

TERMS = (5, 9, 17, 33, 65)  # of the series of the eigenvalue's error, tried one after another


@dataclass(frozen=True)
class Nonlinear:
    """Order of the map and of the frequency, and the verdicts on the map, of a scheme on nonlinear equations.

    free, damped, forced, uva, errors: see `NonlinearOrder`. eigenvalue: the order p of the eigenvalue of the undamped
    oscillator, whose relative error is O((omega h)^p); it says nothing of nonlinear equations, but may be higher than
    the order of the map on linear ones too. symmetric, symplectic, conjugate_symplectic: see `Structure`.
    """

    free: Triple
    damped: Triple
    forced: Triple
    uva: Triple
    errors: tuple[Error, ...]
    eigenvalue: int
    symmetric: Verdict
    symplectic: Verdict
    conjugate_symplectic: Verdict

    @property
    def lines(self) -> dict[str, str]:
        """Each finding in words, under its name."""
        orders = {
            "order of u, v, a on u'' = g(u)": self.free,
            "on u'' = g(u) - C u'": self.damped,
            "on u'' = g(u) + f(t)": self.forced,
            "on u'' = g(u) - C u' + f(t)": self.uva,
        }
        found = {name: ", ".join(map(str, triple)) for name, triple in orders.items()}
        found["order of the oscillator's eigenvalue"] = str(self.eigenvalue)
        verdicts = (self.symmetric, self.symplectic, self.conjugate_symplectic)
        for name, verdict in zip(("symmetric", "symplectic", "conjugate symplectic"), verdicts, strict=True):
            found[name] = str(verdict)
        return found


def nonlinear(
    orders_at: Sequence[Evaluation], verdicts_at: Evaluation, written: Callable[[Expr], str] = str
) -> Nonlinear:
    """The least orders at any of some evaluations, the verdicts at one; written: see `structure`.

    Raises InconsistentScheme, DeclarationError.
    """
    found = [nonlinear_order(evaluation) for evaluation in orders_at]
    least = [_least([getattr(order, name) for order in found]) for name in ("free", "damped", "forced", "uva")]
    weakest = min(found, key=lambda order: sum(order.uva))
    verdicts: Structure = structure(verdicts_at, written)
    return Nonlinear(
        *least,
        weakest.errors,
        min(map(eigenvalue_order, orders_at)),
        verdicts.symmetric,
        verdicts.symplectic,
        verdicts.conjugate_symplectic,
    )


def _least(triples: Sequence[Triple]) -> Triple:
    return cast(Triple, tuple(map(min, zip(*triples, strict=True))))


def eigenvalue_order(evaluation: Evaluation) -> int:
    """The largest p with numerical eigenvalue = exact eigenvalue + O(Omega^(p + 1)), without damping.

    Raises InconsistentScheme for a scheme of which no eigenvalue tends to the exact one.
    """
    found = 0
    for terms in TERMS:
        series = drift(evaluation, Rational(0), terms)
        found = series.valuation - 1
        if series.valuation < len(series):
            return found
    return AtLeast(found)
