"""Claims of chapter 2. Each judge returns the verdict and the evidence; claims without one are judged by algebra."""

from fractions import Fraction

import numpy as np

from substep.core.schemes import scheme
from substep.derived import facade

from .. import by_algebra
from ..by_algebra import SPLITS
from .judgement import Claim, Verdict, listed, overall, row, stable

OMEGA = 2 * np.pi * np.linspace(0.005, 0.2, 40)  # h/T of the accuracy figures
AT = 19  # place of h/T = 0.1 in OMEGA


def claim_2_5() -> tuple[Verdict, str]:
    """Spectral radius, damping and period error at four theta, and the derived overshoot."""
    thetas = (2.0, 2.5, 3.0, 5.0)
    runs = [scheme("wilson_theta", theta=t) for t in thetas]
    high = [float(s.spectral_radius(2 * np.pi * 100)) for s in runs]
    low = [float(s.numerical_damping(2 * np.pi * 0.1)) for s in runs]
    period = [float(s.period_error(2 * np.pi * 0.1)) for s in runs]
    overshoot = by_algebra.overshoot("wilson_theta")
    least = min(
        np.linspace(1.37, 2.5, 114), key=lambda t: scheme("wilson_theta", theta=t).spectral_radius(2 * np.pi * 100)
    )
    rising = [all(np.diff(x) > 0) for x in (high, period)]
    return overall(*rising, not all(np.diff(low) > 0), overshoot.u > 0), (
        f"at theta = {thetas}: rho at h/T = 100 is {row(high)} (so high-frequency dissipation falls, and does so from "
        f"theta = {least:.2f} on), but numerical damping at h/T = 0.1 is {row(low)} (it rises); period error at h/T = "
        f"0.1 {row(period)}; overshoot {overshoot}"
    )


# "Other schemes" (p. 12): the implicit ones of section 2.2.2 that have no parameter or a default for each
OTHERS = (
    *("backward_euler", "average_acceleration", "linear_acceleration", "fox_goodwin", "wilson_theta", "hht_alpha"),
    *("wbz_alpha", "generalized_alpha", "bathe", "silva_bezerra", "gholampour", "park"),
)


def claim_2_6() -> tuple[Verdict, str]:
    """A certificate, the derived order, and both errors against the implicit schemes of section 2.2.2."""
    order, proved, mine = facade.derived("houbolt").order, stable("houbolt"), scheme("houbolt")
    parts, texts = [], []
    for kind, function in (("numerical damping", "numerical_damping"), ("period error", "period_error")):
        own = getattr(mine, function)(OMEGA)
        other = {name: getattr(scheme(name), function)(OMEGA) for name in OTHERS}
        above = {name: int((values >= own).sum()) for name, values in other.items() if (values >= own).any()}
        parts.append(not above)
        largest = max(other, key=lambda name: other[name][AT])
        texts.append(
            f"{kind} {own[AT]:.4g} at h/T = 0.1, the largest other {other[largest][AT]:.4g} ({largest}); not more than "
            + (", ".join(f"{name}'s at {count} of {len(OMEGA)} h/T" for name, count in above.items()) or "none's")
        )
    return overall(proved, min(order) >= 2, *parts), (
        f"certificate: stable {proved}; order {order}; {'; '.join(texts)}; the other schemes are the implicit ones of "
        f"section 2.2.2, at default parameters: {', '.join(OTHERS)}"
    )


def claim_2_7() -> tuple[Verdict, str]:
    """The exact set of stable alpha against (2.24), derived order and overshoot, and both errors."""
    claimed, values = by_algebra.printed().hht_values, by_algebra.stable_values("hht_alpha")
    order, overshoot = facade.derived("hht_alpha", alpha=Fraction(-1, 10)).order, by_algebra.overshoot("hht_alpha")
    at = 2 * np.pi * 0.1
    weakest = scheme("hht_alpha", alpha=-1 / 3)
    others = [scheme("houbolt"), scheme("wilson_theta")]
    less = all(
        weakest.numerical_damping(at) < s.numerical_damping(at) and weakest.period_error(at) < s.period_error(at)
        for s in others
    )
    parts = claimed.is_subset(values), claimed == values, min(order[:2]) >= 2, str(overshoot) == "U0-V1", less
    return overall(*parts), (
        f"stable exactly for alpha in {values}, claimed: {claimed}; order of u, v, a {order}; overshoot {overshoot}; "
        f"at h/T = 0.1 and alpha = -1/3 damping {weakest.numerical_damping(at):.4g}, period error "
        f"{weakest.period_error(at):.4g}, both less than Houbolt and Wilson: {less}"
    )


def claim_2_11() -> tuple[Verdict, str]:
    """The derived order, and damping and period error for h/T up to 0.2."""
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
    """A certificate, the derived order, both errors for h/T up to 0.2, and the spectral radius at Omega = 1e6."""
    order, limit = facade.derived("park").order, float(scheme("park").spectral_radius(1e6))
    park, houbolt = scheme("park"), scheme("houbolt")
    smaller = [
        bool((getattr(park, f)(OMEGA) < getattr(houbolt, f)(OMEGA)).all()) for f in ("amplitude_error", "period_error")
    ]
    return overall(stable("park"), min(order) >= 2, *smaller, limit < 0.01), (
        f"certificate: stable {stable('park')}; order {order}; for h/T <= 0.2 amplitude error smaller than Houbolt's: "
        f"{smaller[0]}, period error: {smaller[1]}; rho at Omega = 1e6: {limit:.2g}"
    )


def claim_2_13() -> tuple[Verdict, str]:
    """The amplitude lost in a period, beside the derived damping at small Omega."""
    term = by_algebra.undamped(facade.derived("silva_bezerra").series.numerical_damping[3])
    loss = {s: float(scheme("silva_bezerra", gamma_t=float(s)).amplitude_error(2 * np.pi * 0.1)) for s in SPLITS}
    return overall(max(loss.values()) < 1e-12), (
        f"numerical damping at small Omega is ({term}) Omega^3, positive for all gamma_t; amplitude lost per period "
        f"at h/T = 0.1, gamma_t = {listed(float(s) for s in loss)}: {row(loss.values())}"
    )


CLAIMS = (
    Claim(
        "C2.1",
        "Newmark is unconditionally stable iff 2 beta >= gamma >= 1/2; gamma > 1/2 also damps the low modes.",
        "substep certify newmark --beta 1/4 --gamma 1/2",
    ),
    Claim(
        "C2.2",
        "Linear acceleration, Fox-Goodwin and central difference are conditionally stable.",
        "substep certify fox_goodwin",
    ),
    Claim(
        "C2.3",
        "Fox-Goodwin is fourth-order accurate without viscous damping.",
        "substep show fox_goodwin --part series",
    ),
    Claim(
        "C2.4",
        "Wilson-theta is unconditionally stable for theta >= 1.37.",
        "substep certify wilson_theta --theta 137/100",
    ),
    Claim(
        "C2.5",
        "For theta > 2 Wilson's numerical dissipation reduces and its period error grows; its overshoot is high.",
        "substep reproduce",
        claim_2_5,
    ),
    Claim(
        "C2.6",
        "Houbolt: unconditionally stable, second order, more damping and period error than the other schemes.",
        "substep certify houbolt",
        claim_2_6,
    ),
    Claim(
        "C2.7",
        "HHT-alpha: second order; unconditionally stable exactly for -1/3 <= alpha <= 0; U0-V1; less "
        "dissipation and period error than Houbolt and Wilson-theta.",
        "substep certify hht_alpha --alpha -1/2",
        claim_2_7,
    ),
    Claim(
        "C2.8",
        "WBZ-alpha: second order and unconditionally stable under (2.28)-(2.30).",
        "substep certify wbz_alpha --alpha_B -1",
    ),
    Claim(
        "C2.9",
        "Generalized-alpha: (2.36)-(2.38); reduces to Newmark, HHT-alpha, WBZ-alpha.",
        "substep certify generalized_alpha --alpha_m 0 --alpha_f 1/4",
    ),
    Claim(
        "C2.10",
        "Gholampour is unconditionally stable for delta >= 1/3, delta/2 <= alpha_g <= delta - 1/6.",
        "substep certify gholampour --delta 1/2 --alpha_g 1/4",
    ),
    Claim(
        "C2.11",
        "Gholampour: second order with numerical damping; period error similar to average acceleration and "
        "generalized-alpha, less than Wilson-theta.",
        "substep reproduce",
        claim_2_11,
    ),
    Claim(
        "C2.12",
        "Park: unconditionally stable, second order, smaller amplitude and period error than Houbolt, strong "
        "high- frequency dissipation.",
        "substep certify park",
        claim_2_12,
    ),
    Claim(
        "C2.13",
        "Silva-Bezerra preserves energy and momentum.",
        "substep show silva_bezerra",
        claim_2_13,
    ),
    Claim(
        "C2.14",
        "For one sub-step size the period elongation of the Bathe family is least and its dissipation greatest.",
        "substep show silva_bezerra --part series",
    ),
)
