"""Claims of chapter 4. Each judge returns the verdict and the evidence; claims without one are judged by algebra."""

from collections.abc import Iterator
from fractions import Fraction
from itertools import product

import numpy as np

from substep.core.schemes import Array, Scheme, scheme

from ..by_algebra import NEWMARK_SETS, SPLITS, properties
from .judgement import Claim, Verdict, overall

RATIOS = np.linspace(0.005, 0.2, 40)  # h/T of the accuracy figures
OMEGA = 2 * np.pi * RATIOS


def composite(split: Fraction, beta: Fraction, gamma: Fraction) -> Scheme:
    """Newmark-BDF2 at one parameter set."""
    return scheme("newmark_bdf2", gamma_t=float(split), beta=float(beta), gamma=float(gamma))


def claim_4_4() -> tuple[Verdict, str]:
    """Numerical damping for h/T up to 0.2."""
    bathe = scheme("bathe").numerical_damping(OMEGA)
    parts, texts = [], []
    for beta, gamma in NEWMARK_SETS[:2]:
        mine = composite(SPLITS[0], beta, gamma).numerical_damping(OMEGA)
        parts.append(bool((mine < bathe).all()))
        less = [r for r, m, b in zip(RATIOS, mine, bathe, strict=True) if m < b]
        texts.append(
            f"({float(beta)}, {float(gamma)}): damping {mine[9]:.3g} at h/T = 0.05 (Bathe {bathe[9]:.3g}), less than "
            f"Bathe's at {len(less)} of {len(RATIOS)} h/T up to 0.2"
        )
    return overall(*parts), "gamma_t = 0.2: " + "; ".join(texts)


def claim_4_5() -> tuple[Verdict, str]:
    """Damping of a low mode and the exact rho_inf, along Table 4.1 at each gamma_t."""
    low, high = {}, {}
    for split, (beta, gamma) in product(SPLITS, NEWMARK_SETS):
        low[split, beta] = float(composite(split, beta, gamma).numerical_damping(2 * np.pi * 0.1))
        exact = properties("newmark_bdf2", {"gamma_t": split, "beta": beta, "gamma": gamma})
        high[split, beta] = float(Fraction(exact.rho_inf))
    order = [beta for beta, _ in NEWMARK_SETS]
    rising = [all(np.diff([table[s, b] for b in order]) > 0) for table in (low, high) for s in SPLITS]
    worst = [max(table, key=table.__getitem__) == (SPLITS[-1], order[-1]) for table in (low, high)]
    return overall(all(rising), all(worst)), (
        f"along the table damping at h/T = 0.1 and rho_inf rise at {sum(rising)} of {len(rising)} (gamma_t, measure); "
        f"both largest of all 25 at gamma_t = 4/5, (.49, .9): {worst}, {low[SPLITS[-1], order[-1]]:.4g} and "
        f"{high[SPLITS[-1], order[-1]]:.4g}"
    )


def beside_bathe(function: str, split: Fraction) -> Iterator[tuple[str, Array]]:
    """Name and ratio of its error to that of Bathe's scheme, over h/T, for each set of Table 4.1."""
    bathe = getattr(scheme("bathe"), function)(OMEGA)
    for beta, gamma in NEWMARK_SETS:
        yield f"({float(beta):g}, {float(gamma):g})", getattr(composite(split, beta, gamma), function)(OMEGA) / bathe


def claim_4_6() -> tuple[Verdict, str]:
    """The ratio of amplitude errors for h/T up to 0.2."""
    parts, texts = [], []
    for split in SPLITS:
        (_, first), *others = beside_bathe("amplitude_error", split)
        if split != Fraction(1, 2):
            parts.append(bool((first > 1).all()) if split == Fraction(3, 5) else bool((first < 1).all()))
        parts.append(all(bool((ratio > 1).all()) for _, ratio in others))
        worst = min(float(ratio.min()) for _, ratio in others)
        texts.append(f"gamma_t = {float(split):g}: {first[0]:.3f}..{first[-1]:.3f}, others from {worst:.3f}")
    return overall(*parts), "ratio to Bathe's amplitude error for h/T <= 0.2, (.25, .5): " + "; ".join(texts)


def _period(split: Fraction) -> tuple[dict[str, Array], str]:
    """Ratios of period errors by set, and their first and last values as text."""
    ratios = dict(beside_bathe("period_error", split))
    text = f"gamma_t = {float(split):g}: " + ", ".join(f"{k} {v[0]:.3f}..{v[-1]:.3f}" for k, v in ratios.items())
    return ratios, text


def claim_4_7() -> tuple[Verdict, str]:
    """The ratio of period errors for h/T up to 0.2."""
    parts, texts = [], []
    for split in SPLITS[:2]:
        ratios, text = _period(split)
        (_, first), *others = ratios.items()
        parts += [all(bool((first >= r).all()) for _, r in others), all(bool((r < 1).all()) for _, r in others)]
        texts.append(text)
    return overall(*parts), "ratio to Bathe's period error for h/T <= 0.2: " + "; ".join(texts)


def claim_4_8() -> tuple[Verdict, str]:
    """The ratio of period errors for h/T up to 0.2."""
    at_6, text_6 = _period(SPLITS[3])
    at_4, text_4 = _period(SPLITS[1])
    values = list(at_4.values())
    parts = [all(bool((r < 1).all()) for r in at_6.values()), all(bool((r < 1).all()) for r in values[3:])]
    parts.append(bool((np.abs(values[2] - 1) < 0.05).all()))
    return overall(*parts), f"ratio to Bathe's period error for h/T <= 0.2: {text_6}; {text_4}"


CLAIMS = (
    Claim(
        "C4.1",
        "The printed A31 (4.16).",
        "substep show newmark_bdf2 --part amplification",
    ),
    Claim(
        "C4.2",
        "For gamma_t = 1/2, beta = 1/4, gamma = 1/2 the scheme is Bathe's.",
        "substep show bathe --part amplification",
    ),
    Claim(
        "C4.3",
        "Unconditional stability of every Table 4.1 set at every gamma_t shown; any combination of the "
        "parameters may be chosen.",
        "substep certify newmark_bdf2 --gamma_t 1/5 --beta 0 --gamma 1/2",
    ),
    Claim(
        "C4.4",
        "Gamma_t = .2: (.25, .5) and (.3025, .6) preserve the low modes better than Bathe.",
        "substep reproduce",
        claim_4_4,
    ),
    Claim(
        "C4.5",
        "From (.25, .5) to (.49, .9) low modes are preserved less and high modes damped less; gamma_t = .8, "
        "(.49, .9) is least efficient.",
        "substep reproduce",
        claim_4_5,
    ),
    Claim(
        "C4.6",
        "Amplitude error of (.25, .5): quite less than Bathe at gamma_t = .2, .4, .8, slightly more at .6; "
        "high for all other sets at all gamma_t.",
        "substep reproduce",
        claim_4_6,
    ),
    Claim(
        "C4.7",
        "Period error at gamma_t = .2 and .4: greatest for (.25, .5); all other sets less than Bathe.",
        "substep reproduce",
        claim_4_7,
    ),
    Claim(
        "C4.8",
        "Period error at gamma_t = .6: less than Bathe for all sets; at .4: (.4225, .8), (.49, .9) less, "
        "(.36, .7) almost the same.",
        "substep reproduce",
        claim_4_8,
    ),
)
