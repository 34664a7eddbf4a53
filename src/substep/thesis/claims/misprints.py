"""Formulas as the thesis prints them. A judge's docstring is what is printed; "false": derivation refutes it."""

from fractions import Fraction

from ...derived import facade
from .chapter_2 import gholampour_points
from .judgement import Verdict, stable


def _found(holds: bool, evidence: str) -> tuple[Verdict, str]:
    return ("true" if holds else "false"), evidence


def misprint_2_2() -> tuple[Verdict, str]:
    """The remainder of the central difference of u' is h^2/3 times the third derivative."""
    factor = facade.thesis().central_difference_remainder()
    return _found(factor == Fraction(1, 3), f"Taylor's theorem gives the factor {factor}")


def misprint_2_9() -> tuple[Verdict, str]:
    """The last stage of RK4 is taken at t + h/2."""
    printed = facade.thesis()
    as_printed, corrected = (printed.printed_forced_order(s) for s in (printed.rk4_printed, printed.rk4))
    return _found(
        as_printed == corrected, f"order of u, v, a under load: {as_printed} as printed, {corrected} at t + h"
    )


def _consistency(name: str, right: str) -> tuple[Verdict, str]:
    printed = facade.thesis()
    as_printed, corrected = (printed.is_consistent(getattr(printed, s)) for s in (name, right))
    return _found(
        as_printed,
        f"an eigenvalue tends to the exact one as Omega -> 0: {as_printed} as printed, {corrected} corrected",
    )


def misprint_2_20() -> tuple[Verdict, str]:
    """Wilson's relations hold u_(n+theta) + u_n and 6/theta v_n."""
    return _consistency("wilson_printed", "wilson_theta")


def misprint_2_23() -> tuple[Verdict, str]:
    """HHT's balance holds - K u_n, and the load at t_(n+alpha)."""
    return _consistency("hht_printed", "hht_alpha")


def misprint_2_26() -> tuple[Verdict, str]:
    """HHT with alpha = 0 has beta = 1/2."""
    beta = facade.thesis().hht_beta_at_zero()
    return _found(beta == Fraction(1, 2), f"the relation for u_(n+1) has beta = {beta} there")


def misprint_2_54() -> tuple[Verdict, str]:
    """Gholampour's velocity holds delta h^3/6 times the second difference quotient of a."""
    points = gholampour_points()
    as_printed = sum(facade.thesis().gholampour_is_stable(p) for p in points)
    corrected = sum(stable("gholampour", **p) for p in points)
    return _found(
        as_printed == corrected,
        f"of {len(points)} points of the claimed region {as_printed} are stable as printed, {corrected} with delta h^3",
    )


def misprint_p15() -> tuple[Verdict, str]:
    """The second sub-step ends at t_(n+1) = t_n + (1 - gamma_t) h."""
    end = facade.thesis().span_of_both_sub_steps()
    return _found(end == 1, f"that is {end} steps after t_n; it must be 1, from t_n + gamma_t h")


def misprint_3_9() -> tuple[Verdict, str]:
    """Effective stiffness and residual (3.7)-(3.9), (3.19)-(3.21) hold no damping."""
    damped = facade.thesis().effective_stiffness_has_damping()
    return _found(not damped, f"the derived effective stiffnesses of both sub-steps hold C: {damped}")


JUDGES = (
    (misprint_2_2, "substep claims"),
    (misprint_2_9, "substep claims"),
    (misprint_2_20, "substep claims"),
    (misprint_2_23, "substep claims"),
    (misprint_2_26, "substep show hht_alpha"),
    (misprint_2_54, "substep claims"),
    (misprint_p15, "substep show silva_bezerra"),
    (misprint_3_9, "substep show newmark_bdf2"),
)
