"""Claims of the thesis that algebra alone judges. Each judge returns whether each part of its claim holds, and why."""

from collections.abc import Callable
from fractions import Fraction
from itertools import product
from typing import Any

from substep_derive.declare.scheme import Scheme
from substep_derive.declare.symbols import gamma, xi
from substep_derive.stability.certificate import certify
from substep_derive.stability.conditions import conditions, written
from substep_derive.study.derivation import derive
from sympy import Expr, Rational, factor

from . import printed
from .region import Region, same_conditions, stable_values

Finding = tuple[tuple[bool, ...], str]  # whether each part of the claim holds; the evidence


def claim_2_1() -> Finding:
    """The derived conditions against (2.17), and the numerical damping at small Omega."""
    same = same_conditions(conditions("newmark"), printed.newmark_conditions)
    undamped = factor(derive("newmark").series.numerical_damping[1].subs(xi, 0))
    damps = all(undamped.subs(gamma, value) > 0 for value in map(Rational, ("11/20", "3/4", "1")))
    return (same, damps), (
        f"derived, necessary and sufficient: {_conditions('newmark')}; numerical damping at small Omega "
        f"is ({undamped}) Omega"
    )


def claim_2_2() -> Finding:
    """Exact certificates of the three schemes."""
    limits = {name: certify(name).critical_Omega for name in CONDITIONAL}
    text = ", ".join(f"{name}: Omega_cr = {limit}" for name, limit in limits.items())
    return tuple(limit is not None and bool(limit > 0) for limit in limits.values()), text


CONDITIONAL = ("linear_acceleration", "fox_goodwin", "central_difference")


def claim_2_3() -> Finding:
    """Undamped order of frequency and decay, and of u, v, a in free vibration."""
    frequency, response = printed.undamped_order("fox_goodwin")
    return (frequency >= 4, min(response) >= 4), (
        f"undamped, frequency and decay are of order {frequency}, but u, v, a in free vibration of orders {response}: "
        "the amplitude that an initial velocity excites is of second order"
    )


def claim_2_4() -> Finding:
    """The exact set of stable theta, with certificates at its end and just below."""
    values = stable_values(conditions("wilson_theta"))
    threshold, at_it, below = printed.wilson_at_threshold()
    return (bool(printed.wilson_values.is_subset(values)),), (
        f"stable exactly for theta in {values}; certificates: at the exact threshold theta = {threshold} stable "
        f"{at_it}, at 1e-6 less {below}"
    )


def claim_2_8() -> Finding:
    """The derived conditions on (2.28)-(2.30), and the derived order."""
    region = printed.wbz_region
    order = derive("wbz_alpha", alpha_B=Fraction(-1, 10)).order
    return (region.stable, min(order[:2]) >= 2), (
        f"alpha_B <= 0: {_throughout(region)}; derived, necessary and sufficient: {_conditions('wbz_alpha')}; order of "
        f"u, v, a {order}"
    )


def claim_2_9() -> Finding:
    """The derived conditions on (2.36)-(2.38), the derived order, and three matrices compared."""
    region, same = printed.generalized_alpha_region, printed.generalized_alpha_reductions()
    inside = {name: Fraction(text) for name, text in GENERALIZED_ALPHA.items()}
    order = derive("generalized_alpha", **inside).order
    return (region.stable, min(order[:2]) >= 2, *same.values()), (
        f"region (2.36)-(2.38), edges included: {_throughout(region)} (a double root on the circle counts as "
        f"unstable); derived, necessary and sufficient: {_conditions('generalized_alpha')}; order of "
        f"u, v, a {order} at {', '.join(f'{name} = {value}' for name, value in inside.items())}; same matrix as "
        f"{', '.join(f'{k}: {v}' for k, v in same.items())}"
    )


GENERALIZED_ALPHA = {"alpha_m": "-1/2", "alpha_f": "1/4", "beta": "29/40", "gamma": "5/4"}  # inside the region


def claim_2_10() -> Finding:
    """The derived conditions on (2.56)-(2.57), with (2.54) as corrected and as printed."""
    corrected, as_printed = printed.gholampour_region(), printed.gholampour_region(printed.gholampour_printed)
    exactly = same_conditions(conditions("gholampour"), printed.gholampour_conditions)
    return (corrected.stable, as_printed.stable), (
        f"in the region, as corrected (delta h^3 s): {_throughout(corrected)}; as printed (delta h^3 s/6): "
        f"{_throughout(as_printed)}; derived for the corrected form, iff: {_conditions('gholampour')}, "
        f"which is the region itself: {exactly}"
    )


def claim_2_14() -> Finding:
    """Where the derived leading terms of period error and numerical damping are stationary."""
    least, most, constants = printed.klarmann_wagner()
    return (least == most,), (
        f"leading period error is least at gamma_t = {_show(least)} ({constants[0]} Omega^2), leading numerical "
        f"damping greatest at gamma_t = {_show(most)} ({constants[1]} Omega^3)"
    )


def claim_4_1() -> Finding:
    """The ratio of the printed entry to the derived one."""
    ratio = printed.a31_ratio()
    return (ratio == 1,), f"printed (4.16) over the derived A31 is {ratio} for all Omega, xi, gamma_t, beta, gamma"


def claim_4_2() -> Finding:
    """The two derived matrices compared."""
    same = printed.composite_is_bathe()
    return (same,), f"the nine entries of the two declarations' matrices are identical for all Omega and xi: {same}"


def claim_4_3() -> Finding:
    """Certificates of all sets of Table 4.1 and of other sets, and the derived stability conditions."""
    sets = list(product(printed.splits, printed.newmark_sets))
    good = [s for s, (b, g) in sets if _composite(s, b, g).stable]
    tried = ("1/5", "1/2", "4/5"), ("0", "1/10", "1/6", "1/4"), ("1/2", "3/5", "9/10")
    others = product(*(map(Fraction, texts) for texts in tried))
    failing = [values for values in others if not _composite(*values).stable]
    text = f"{len(good)} of {len(sets)} sets of Table 4.1 are stable for every Omega, by certificate"
    if failing:
        s, b, g = failing[0]
        limit = _composite(s, b, g).critical_Omega
        text += f"; but not any combination is: gamma_t = {s}, beta = {b}, gamma = {g} only up to Omega = {limit}"
    text += f"; derived, necessary and sufficient: {_conditions('newmark_bdf2')}"
    free = conditions("newmark_bdf2")
    return (len(good) == len(sets), free.eliminated and not free.inequalities), text


def misprint_2_2() -> Finding:
    """The printed factor beside that of Taylor's theorem."""
    found = printed.central_difference_remainder()
    return (found == Rational(1, 3),), f"Taylor's theorem gives the factor {found}"


def misprint_2_9() -> Finding:
    """Orders of u, v and a under load, with the formula as printed and as corrected."""
    as_printed, corrected = (printed.printed_forced_order(s) for s in (printed.rk4_printed, printed.rk4))
    return (as_printed == corrected,), f"order of u, v, a under load: {as_printed} as printed, {corrected} at t + h"


def misprint_2_20() -> Finding:
    """Whether the scheme is consistent, with the formula as printed and as corrected."""
    return _consistency(printed.wilson_printed, printed.wilson_theta)


def misprint_2_23() -> Finding:
    """Whether the scheme is consistent, with the formula as printed and as corrected."""
    return _consistency(printed.hht_printed, printed.hht_alpha)


def misprint_2_26() -> Finding:
    """The value of beta in the scheme's relation for u_(n+1)."""
    beta = printed.hht_beta_at_zero()
    return (beta == Rational(1, 2),), f"the relation for u_(n+1) has beta = {beta} there"


def misprint_2_54() -> Finding:
    """Stability in the region (2.56)-(2.57), with the formula as printed and as corrected."""
    as_printed, corrected = printed.gholampour_region(printed.gholampour_printed), printed.gholampour_region()
    return (as_printed.stable,), (
        f"in the region (2.56)-(2.57), as printed: {_throughout(as_printed)}; with delta h^3: {_throughout(corrected)}"
    )


def misprint_p15() -> Finding:
    """The end of the second sub-step, from the coefficients of its three-point formula."""
    at, end = printed.second_sub_step_end_printed, printed.second_sub_step_end()
    return (at == end,), (
        f"printed: {at} steps after t_n; the three-point formula's coefficients are those of an end {end} step "
        "after t_n, from t_n + gamma_t h"
    )


def misprint_3_9() -> Finding:
    """Whether the derived effective stiffnesses hold the damping."""
    damped = printed.effective_stiffness_has_damping()
    return (not damped,), f"the derived effective stiffnesses of both sub-steps hold C: {damped}"


JUDGES: dict[str, Callable[[], Finding]] = {
    "C2.1": claim_2_1,
    "C2.2": claim_2_2,
    "C2.3": claim_2_3,
    "C2.4": claim_2_4,
    "C2.8": claim_2_8,
    "C2.9": claim_2_9,
    "C2.10": claim_2_10,
    "C2.14": claim_2_14,
    "C4.1": claim_4_1,
    "C4.2": claim_4_2,
    "C4.3": claim_4_3,
    "M2.2": misprint_2_2,
    "M2.9": misprint_2_9,
    "M2.20": misprint_2_20,
    "M2.23": misprint_2_23,
    "M2.26": misprint_2_26,
    "M2.54": misprint_2_54,
    "Mp15": misprint_p15,
    "M3.9": misprint_3_9,
}


def _conditions(name: str) -> str:
    """The inequalities of `conditions` as text on one line."""
    found = conditions(name)
    parts = [written(inequality, found.scheme) for inequality in found.inequalities]
    return " and ".join(f"({part})" if " or " in part else part for part in parts) or "none"


def _composite(gamma_t: Fraction, beta: Fraction, gamma: Fraction) -> Any:
    return certify("newmark_bdf2", gamma_t=gamma_t, beta=beta, gamma=gamma)


def _consistency(misprinted: Scheme, right: Scheme) -> Finding:
    as_printed, corrected = (printed.is_consistent(scheme) for scheme in (misprinted, right))
    return (as_printed,), (
        f"an eigenvalue tends to the exact one as Omega -> 0: {as_printed} as printed, {corrected} corrected"
    )


def _throughout(region: Region) -> str:
    """For a reader: whether the derived conditions make a scheme stable everywhere in a region of parameters."""
    if region.counterexample is None:
        return "stable everywhere, for no derived condition is left there"
    first = ", ".join(f"{name} = {value}" for name, value in region.counterexample.items())
    return f"unstable {'everywhere' if region.unstable else 'in a part'}, for one at {first}"


def _show(value: Expr) -> str:
    """An exact number with its decimals."""
    return f"{value}" if value == int(value) else f"{value} = {float(value):.6g}"
