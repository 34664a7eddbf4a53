"""Scheme -> Profile: its properties at given parameters, as one row of a table."""

from dataclasses import dataclass

from sympy import Expr

from ..declare.scheme import Scheme
from ..nonlinear.properties import Nonlinear, nonlinear
from ..oscillator.bifurcation import bifurcation
from ..oscillator.evaluation import Evaluation
from ..oscillator.overshoot import Overshoot, overshoot
from ..oscillator.spectrum import rho_infinity_at
from ..stability.all_damping import certify_all_damping
from ..stability.certificate import certify
from ..stability.critical_curve import critical_curve
from .derivation import order_at


@dataclass(frozen=True)
class Profile:
    """The properties of a scheme at given parameters.

    stable: for every Omega, undamped. A_stable: at every xi >= 0 too; L_stable: and rho_inf = 0; None where
    that was not decided, or where a scheme that takes no damping is stable for every Omega. critical_Omega as in
    `certify`, critical_curve as a function of xi where it has a closed form.
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
    """The profile at the scheme's default parameters, which are exact even where they are irrational."""
    at = Evaluation.at_defaults(scheme)
    certificate = certify(scheme)
    conditional = certificate.critical_Omega is not None and certificate.critical_Omega != 0
    A_stable, rho_inf = None if certificate.stable else False, rho_infinity_at(at)
    if certificate.stable and scheme.takes_damping:
        A_stable = certify_all_damping(scheme).stable_for_all_xi
    return Profile(
        order=order_at(at),
        rho_inf=rho_inf,
        stable=certificate.stable,
        critical_Omega=certificate.critical_Omega,
        critical_curve=critical_curve(scheme).explicit if conditional and scheme.takes_damping else None,
        A_stable=A_stable,
        L_stable=A_stable and rho_inf == 0,
        overshoot=overshoot(at),
        bifurcation=bifurcation(at),
        nonlinear=nonlinear([at], at),
    )
