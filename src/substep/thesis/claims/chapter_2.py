"""Claims of chapter 2. A judge's docstring is the claim; what it returns is the verdict and what decided it."""

from fractions import Fraction
from itertools import product

import numpy as np

from ...core.schemes import scheme
from ...derived import facade
from ..parameter_sets import SPLITS
from .judgement import Verdict, conditions, fractions, listed, overall, row, show, stable

OMEGA = 2 * np.pi * np.linspace(0.005, 0.2, 40)  # h/T of the accuracy figures


def claim_2_1() -> tuple[Verdict, str]:
    """Newmark is unconditionally stable iff 2 beta >= gamma >= 1/2; gamma > 1/2 also damps the low modes."""
    derived = conditions("newmark")
    term = facade.derived("newmark").series.numerical_damping[1]
    at_rest = facade.at_rest(term)
    damps = all(facade.number(at_rest, gamma=g) > 0 for g in fractions("11/20", "3/4", "1"))
    return overall(derived == ["2*beta >= gamma", "gamma >= 1/2"], damps), (
        f"derived, necessary and sufficient: {' and '.join(derived)}; numerical damping at small Omega is ({at_rest}) "
        "Omega"
    )


def claim_2_2() -> tuple[Verdict, str]:
    """Linear acceleration, Fox-Goodwin and central difference are conditionally stable."""
    limits = {name: facade.certificate(name).critical_Omega for name in CONDITIONAL}
    text = ", ".join(f"{name}: Omega_cr = {limit}" for name, limit in limits.items())
    return overall(*(limit is not None and limit > 0 for limit in limits.values())), text


CONDITIONAL = ("linear_acceleration", "fox_goodwin", "central_difference")


def claim_2_3() -> tuple[Verdict, str]:
    """Fox-Goodwin is fourth-order accurate without viscous damping."""
    frequency, response = facade.thesis().undamped_order("fox_goodwin")
    return overall(frequency >= 4, min(response) >= 4), (
        f"undamped, frequency and decay are of order {frequency}, but u, v, a in free vibration of orders {response}: "
        "the amplitude that an initial velocity excites is of second order"
    )


def claim_2_4() -> tuple[Verdict, str]:
    """Wilson-theta is unconditionally stable for theta >= 1.37."""
    tested = fractions("137/100", "7/5", "3/2", "2", "3", "10", "100")
    holds = all(stable("wilson_theta", theta=t) for t in tested)
    threshold, at_it, below = facade.thesis().wilson_at_threshold()
    return overall(holds), (
        f"stable at theta = {', '.join(str(float(t)) for t in tested)}; the exact threshold is theta = {threshold}, "
        f"stable there: {at_it}, at 1e-6 less: {below}"
    )


def claim_2_5() -> tuple[Verdict, str]:
    """For theta > 2 Wilson's numerical dissipation reduces and its period error grows; its overshoot is high."""
    thetas = (2.0, 2.5, 3.0, 5.0)
    runs = [scheme("wilson_theta", theta=t) for t in thetas]
    high = [float(s.spectral_radius(2 * np.pi * 100)) for s in runs]
    low = [float(s.numerical_damping(2 * np.pi * 0.1)) for s in runs]
    period = [float(s.period_error(2 * np.pi * 0.1)) for s in runs]
    overshoot = facade.overshoot("wilson_theta")
    least = min(
        np.linspace(1.37, 2.5, 114), key=lambda t: scheme("wilson_theta", theta=t).spectral_radius(2 * np.pi * 100)
    )
    rising = [all(np.diff(x) > 0) for x in (high, period)]
    return overall(*rising, not all(np.diff(low) > 0), overshoot.u > 0), (
        f"at theta = {thetas}: rho at h/T = 100 is {row(high)} (so high-frequency dissipation falls, and does so from "
        f"theta = {least:.2f} on), but numerical damping at h/T = 0.1 is {row(low)} (it rises); period error at h/T = "
        f"0.1 {row(period)}; overshoot {overshoot}"
    )


RIVALS = ("average_acceleration", "wilson_theta", "hht_alpha", "wbz_alpha", "generalized_alpha", "park", "gholampour")


def claim_2_6() -> tuple[Verdict, str]:
    """Houbolt: unconditionally stable, second order, more damping and period error than the other schemes."""
    order = facade.derived("houbolt").order
    at = 2 * np.pi * 0.1
    mine = scheme("houbolt")
    damping = {name: float(scheme(name).numerical_damping(at)) for name in RIVALS}
    period = {name: float(scheme(name).period_error(at)) for name in RIVALS}
    more = mine.numerical_damping(at) > max(damping.values()), mine.period_error(at) > max(period.values())
    return overall(stable("houbolt"), min(order) >= 2, *more), (
        f"certificate: stable {stable('houbolt')}; order {order}; at h/T = 0.1 its numerical damping is "
        f"{mine.numerical_damping(at):.4g} and period error {mine.period_error(at):.4g}; the largest of "
        f"{', '.join(RIVALS)}: {max(damping.values()):.4g} ({max(damping, key=damping.__getitem__)}) and "
        f"{max(period.values()):.4g} ({max(period, key=period.__getitem__)})"
    )


def claim_2_7() -> tuple[Verdict, str]:
    """HHT-alpha: second order; unconditionally stable exactly for -1/3 <= alpha <= 0; U0-V1; less dissipation and
    period error than Houbolt and Wilson-theta."""
    inside = fractions("-1/3", "-3/10", "-1/4", "-1/5", "-1/10", "-1/20", "0")
    outside = fractions("-1", "-3/4", "-1/2", "-2/5", "-34/100", "1/100", "1/10")
    works = all(stable("hht_alpha", alpha=a) for a in inside)
    also = [a for a in outside if stable("hht_alpha", alpha=a)]
    order, overshoot = facade.derived("hht_alpha", alpha=Fraction(-1, 10)).order, facade.overshoot("hht_alpha")
    at = 2 * np.pi * 0.1
    weakest = scheme("hht_alpha", alpha=-1 / 3)
    others = [scheme("houbolt"), scheme("wilson_theta")]
    less = all(
        weakest.numerical_damping(at) < s.numerical_damping(at) and weakest.period_error(at) < s.period_error(at)
        for s in others
    )
    return overall(works, not also, min(order[:2]) >= 2, str(overshoot) == "U0-V1", less), (
        f"stable at alpha = {listed(inside)}: {works}; but stable also at alpha = {listed(also)}; "
        f"order of u, v, a {order} ; overshoot {overshoot}; at h/T = 0.1 and alpha = -1/3 "
        f"damping {weakest.numerical_damping(at):.4g}, period error {weakest.period_error(at):.4g}, both less than "
        f"Houbolt and Wilson: {less}"
    )


def claim_2_8() -> tuple[Verdict, str]:
    """WBZ-alpha: second order and unconditionally stable under (2.28)-(2.30)."""
    inside = fractions("-1", "-1/2", "-1/3", "-1/10", "0")
    works = [a for a in inside if stable("wbz_alpha", alpha_B=a)]
    order = facade.derived("wbz_alpha", alpha_B=Fraction(-1, 10)).order
    beyond = stable("wbz_alpha", alpha_B=Fraction(1, 100))
    return overall(len(works) == len(inside), min(order[:2]) >= 2), (
        f"stable at alpha_B = {listed(works)} of {listed(inside)}, at 1/100: {beyond}; derived, necessary and "
        f"sufficient: {' and '.join(conditions('wbz_alpha'))}; order of u, v, a {order}"
    )


def claim_2_9() -> tuple[Verdict, str]:
    """Generalized-alpha: (2.36)-(2.38); reduces to Newmark, HHT-alpha, WBZ-alpha."""
    points = []
    for am, af in product(fractions("-1", "-1/2", "0", "1/4", "1/2"), fractions("0", "1/4", "2/5", "1/2")):
        for extra in fractions("0", "1/10"):
            if am <= af:
                beta = Fraction(1, 4) + (af - am) / 2 + extra
                points.append({"alpha_m": am, "alpha_f": af, "beta": beta, "gamma": Fraction(1, 2) - am + af})
    good = [p for p in points if stable("generalized_alpha", **p)]
    bad = [p for p in points if p not in good]
    order = facade.derived("generalized_alpha", **points[5]).order
    same = facade.thesis().generalized_alpha_reductions()
    return overall(not bad, min(order[:2]) >= 2, *same.values()), (
        f"stable at {len(good)} of {len(points)} points of (2.36)-(2.38)"
        + (f", unstable at {_point(bad[0])} (a double root on the circle counts)" if bad else "")
        + f"; derived, necessary and sufficient: {' and '.join(conditions('generalized_alpha'))}"
        + f"; order of u, v, a {order}; same matrix as {', '.join(f'{k}: {v}' for k, v in same.items())}"
    )


def _point(values: dict[str, Fraction]) -> str:
    return ", ".join(f"{key} = {value}" for key, value in values.items())


def gholampour_points() -> list[dict[str, Fraction]]:
    """Corners, edges and inside of delta >= 1/3, delta/2 <= alpha_g <= delta - 1/6."""
    points = []
    for delta in fractions("1/3", "2/5", "1/2", "3/4", "1", "3/2"):
        low, high = delta / 2, delta - Fraction(1, 6)
        points += [{"delta": delta, "alpha_g": low + share * (high - low)} for share in fractions("0", "1/2", "1")]
    return points


def claim_2_10() -> tuple[Verdict, str]:
    """Gholampour is unconditionally stable for delta >= 1/3, delta/2 <= alpha_g <= delta - 1/6."""
    points = gholampour_points()
    right = [p for p in points if stable("gholampour", **p)]
    printed = [p for p in points if facade.thesis().gholampour_is_stable(p)]
    derived = conditions("gholampour")
    exactly = derived == ["2*alpha_g >= delta", "delta >= 1/3", "6*delta >= 6*alpha_g + 1"]
    return overall(exactly and len(right) == len(points), len(printed) == len(points)), (
        f"derived for the corrected form, iff: {' and '.join(derived)}; as corrected (delta h^3 s) "
        f"stable at {len(right)} of {len(points)} points of the region; as printed (delta h^3 s/6) at {len(printed)}"
    )


def claim_2_11() -> tuple[Verdict, str]:
    """Gholampour: second order with numerical damping; period error similar to average acceleration and
    generalized-alpha, less than Wilson-theta."""
    order = facade.derived("gholampour", delta=Fraction(2, 5), alpha_g=Fraction(11, 50)).order
    mine = scheme("gholampour", delta=0.4, alpha_g=0.22)
    errors = {
        name: scheme(name).period_error(OMEGA) for name in ("average_acceleration", "generalized_alpha", "wilson_theta")
    }
    own = mine.period_error(OMEGA)
    damps = bool((mine.numerical_damping(OMEGA) > 0).all())
    ratios = {name: float(own[-1] / e[-1]) for name, e in errors.items()}
    similar = all(0.8 < ratios[name] < 1.25 for name in ("average_acceleration", "generalized_alpha"))
    return overall(min(order) >= 2, damps, similar, bool((own < errors["wilson_theta"]).all())), (
        f"delta = 2/5, alpha_g = 11/50: order {order}; numerical damping positive to h/T 0.2: {damps}; period error "
        f"at h/T = 0.2 {own[-1]:.4g}, its ratio to "
        + ", ".join(f"{name} {value:.3f}" for name, value in ratios.items())
        + " (similar: within a quarter)"
    )


def claim_2_12() -> tuple[Verdict, str]:
    """Park: unconditionally stable, second order, smaller amplitude and period error than Houbolt, strong high-
    frequency dissipation."""
    order, limit = facade.derived("park").order, float(scheme("park").spectral_radius(1e6))
    mine, other = scheme("park"), scheme("houbolt")
    smaller = [
        bool((getattr(mine, f)(OMEGA) < getattr(other, f)(OMEGA)).all()) for f in ("amplitude_error", "period_error")
    ]
    return overall(stable("park"), min(order) >= 2, *smaller, limit < 0.01), (
        f"certificate: stable {stable('park')}; order {order}; for h/T <= 0.2 amplitude error smaller than Houbolt's: "
        f"{smaller[0]}, period error: {smaller[1]}; rho at Omega = 1e6: {limit:.2g}"
    )


def claim_2_13() -> tuple[Verdict, str]:
    """Silva-Bezerra preserves energy and momentum."""
    term = facade.at_rest(facade.derived("silva_bezerra").series.numerical_damping[3])
    loss = {s: float(scheme("silva_bezerra", gamma_t=float(s)).amplitude_error(2 * np.pi * 0.1)) for s in SPLITS}
    return overall(max(loss.values()) < 1e-12), (
        f"numerical damping at small Omega is ({term}) Omega^3, positive for all gamma_t; amplitude lost per period "
        f"at h/T = 0.1, gamma_t = {listed(float(s) for s in loss)}: {row(loss.values())}"
    )


def claim_2_14() -> tuple[Verdict, str]:
    """For one sub-step size the period elongation of the Bathe family is least and its dissipation greatest."""
    least, most, constants = facade.thesis().klarmann_wagner()
    return overall(least == most), (
        f"leading period error is least at gamma_t = {show(least)} ({constants[0]} Omega^2), leading numerical damping "
        f"greatest at gamma_t = {show(most)} ({constants[1]} Omega^3)"
    )


JUDGES = (
    (claim_2_1, "substep certify newmark --beta 1/4 --gamma 1/2"),
    (claim_2_2, "substep certify fox_goodwin"),
    (claim_2_3, "substep show fox_goodwin"),
    (claim_2_4, "substep certify wilson_theta --theta 137/100"),
    (claim_2_5, "substep reproduce"),
    (claim_2_6, "substep certify houbolt"),
    (claim_2_7, "substep certify hht_alpha --alpha -1/2"),
    (claim_2_8, "substep certify wbz_alpha --alpha_B -1"),
    (claim_2_9, "substep certify generalized_alpha --alpha_m 0 --alpha_f 1/4"),
    (claim_2_10, "substep certify gholampour --delta 1/2 --alpha_g 1/4"),
    (claim_2_11, "substep reproduce"),
    (claim_2_12, "substep certify park"),
    (claim_2_13, "substep show silva_bezerra"),
    (claim_2_14, "substep show silva_bezerra"),
)
