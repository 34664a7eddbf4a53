"""Formulas as the thesis prints them: a claim's text is the printed formula, "false" that derivation refutes it."""

from fractions import Fraction

from ...derived import facade
from .judgement import Claim, Verdict, throughout


def _found(holds: bool, evidence: str) -> tuple[Verdict, str]:
    return ("true" if holds else "false"), evidence


def misprint_2_2() -> tuple[Verdict, str]:
    """The printed factor beside that of Taylor's theorem."""
    factor = facade.thesis().central_difference_remainder()
    return _found(factor == Fraction(1, 3), f"Taylor's theorem gives the factor {factor}")


def misprint_2_9() -> tuple[Verdict, str]:
    """Orders of u, v and a under load, with the formula as printed and as corrected."""
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
    """Whether the scheme is consistent, with the formula as printed and as corrected."""
    return _consistency("wilson_printed", "wilson_theta")


def misprint_2_23() -> tuple[Verdict, str]:
    """Whether the scheme is consistent, with the formula as printed and as corrected."""
    return _consistency("hht_printed", "hht_alpha")


def misprint_2_26() -> tuple[Verdict, str]:
    """The value of beta in the scheme's relation for u_(n+1)."""
    beta = facade.thesis().hht_beta_at_zero()
    return _found(beta == Fraction(1, 2), f"the relation for u_(n+1) has beta = {beta} there")


def misprint_2_54() -> tuple[Verdict, str]:
    """Stability in the region (2.56)-(2.57), with the formula as printed and as corrected."""
    printed = facade.thesis()
    as_printed, corrected = printed.gholampour_region(printed.gholampour_printed), printed.gholampour_region()
    return _found(
        as_printed.stable,
        f"in the region (2.56)-(2.57), as printed: {throughout(as_printed)}; with delta h^3: {throughout(corrected)}",
    )


def misprint_p15() -> tuple[Verdict, str]:
    """The end of the second sub-step, from the coefficients of its three-point formula."""
    printed, end = facade.thesis().second_sub_step_end_printed, facade.thesis().second_sub_step_end()
    return _found(
        printed == end,
        f"printed: {printed} steps after t_n; the three-point formula's coefficients are those of an end {end} step "
        "after t_n, from t_n + gamma_t h",
    )


def misprint_3_9() -> tuple[Verdict, str]:
    """Whether the derived effective stiffnesses hold the damping."""
    damped = facade.thesis().effective_stiffness_has_damping()
    return _found(not damped, f"the derived effective stiffnesses of both sub-steps hold C: {damped}")


CLAIMS = (
    Claim(
        "M2.2",
        "The remainder of the central difference of u' is h^2/3 times the third derivative.",
        "substep claims",
        misprint_2_2,
    ),
    Claim(
        "M2.9",
        "The last stage of RK4 is taken at t + h/2.",
        "substep claims",
        misprint_2_9,
    ),
    Claim(
        "M2.20",
        "Wilson's relations hold u_(n+theta) + u_n and 6/theta v_n.",
        "substep claims",
        misprint_2_20,
    ),
    Claim(
        "M2.23",
        "HHT's balance holds - K u_n, and the load at t_(n+alpha).",
        "substep claims",
        misprint_2_23,
    ),
    Claim(
        "M2.26",
        "HHT with alpha = 0 has beta = 1/2.",
        "substep show hht_alpha",
        misprint_2_26,
    ),
    Claim(
        "M2.54",
        "Gholampour's velocity holds delta h^3/6 times the second difference quotient of a.",
        "substep claims",
        misprint_2_54,
    ),
    Claim(
        "Mp15",
        "The second sub-step ends at t_(n+1) = t_n + (1 - gamma_t) h.",
        "substep show silva_bezerra",
        misprint_p15,
    ),
    Claim(
        "M3.9",
        "Effective stiffness and residual (3.7)-(3.9), (3.19)-(3.21) hold no damping.",
        "substep show newmark_bdf2",
        misprint_3_9,
    ),
)
