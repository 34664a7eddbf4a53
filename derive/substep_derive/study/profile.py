"""Scheme -> Profile: its properties at given parameters, as one row of a table."""

from dataclasses import dataclass

from sympy import Expr, Integer, oo

from ..declare.scheme import Scheme
from ..kernels.march_form import MarchForm
from ..nonlinear.properties import Nonlinear, nonlinear
from ..oscillator.amplification import Amplification
from ..oscillator.bifurcation import bifurcation
from ..oscillator.evaluation import Evaluation
from ..oscillator.one_rule import OneRule
from ..oscillator.overshoot import Overshoot, overshoot
from ..oscillator.spectrum import require_convergent, rho_infinity_at
from ..stability.all_damping import certify_all_damping
from ..stability.certificate import STABLE, certify
from ..stability.critical_curve import critical_curve
from ..stability.hurwitz import Verdict
from .derivation import order_at


@dataclass(frozen=True)
class Profile:
    """The properties of a scheme at given parameters.

    A multiple eigenvalue on the circle counts as stable where the step is a function R of the oscillator's matrix, as
    that of a Runge-Kutta scheme: all its eigenvectors remain, so that nothing grows, as at Omega = 2 sqrt(3) for
    `gauss2`, where u and v change their signs. stable: for every Omega, undamped. A_stable: at every xi >= 0 too;
    L_stable: and rho_inf = 0; None where that was not decided, or where a scheme that takes no damping is stable for
    every Omega. critical_Omega as in `certify` else, critical_curve as a function of xi where it has a closed form.
    """

    order: tuple[int, int, int]
    rho_inf: Expr
    stable: bool
    critical_Omega: Expr | None
    critical_curve: Expr | None
    A_stable: bool | None
    L_stable: bool | None
    overshoot: Overshoot
    bifurcation: Expr
    nonlinear: Nonlinear


def profile(scheme: Scheme) -> Profile:
    """The profile at the scheme's default parameters, which are exact even where they are irrational.

    Raises InconsistentScheme for a scheme that does not converge.
    """
    at = Evaluation.at_defaults(scheme)
    require_convergent(at)
    certificate = certify(scheme)
    stable, critical = certificate.stable, certificate.critical_Omega
    if certificate.multiple and OneRule.of(MarchForm.of(Amplification.of(scheme)).step) is not None:
        (low, high, *_), *_ = certificate.proof.intervals((*STABLE, Verdict.MULTIPLE))
        critical = None if (low, high) == (0, oo) else high if low == 0 else Integer(0)
        stable = critical is None
    conditional = critical is not None and critical != 0
    A_stable, rho_inf = None if stable else False, rho_infinity_at(at)
    if stable and scheme.takes_damping:
        damped = certify_all_damping(scheme)
        A_stable = damped.stable_for_all_xi if certificate.stable else all(cell.stable for cell in damped.cells[1:])
    return Profile(
        order=order_at(at),
        rho_inf=rho_inf,
        stable=stable,
        critical_Omega=critical,
        critical_curve=critical_curve(scheme).explicit if conditional and scheme.takes_damping else None,
        A_stable=A_stable,
        L_stable=A_stable and rho_inf == 0,
        overshoot=overshoot(at),
        bifurcation=bifurcation(at),
        nonlinear=nonlinear([at], at),
    )
