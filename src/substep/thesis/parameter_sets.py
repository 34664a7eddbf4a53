"""The parameter sets of the thesis's chapter 4."""

from fractions import Fraction

# thesis, Table 4.1 and the sub-step ratios of figures 4.1-4.5
NEWMARK_SETS = tuple(
    (Fraction(beta), Fraction(gamma))
    for beta, gamma in (("0.25", "0.5"), ("0.3025", "0.6"), ("0.36", "0.7"), ("0.4225", "0.8"), ("0.49", "0.9"))
)
SPLITS = tuple(Fraction(split) for split in ("0.2", "0.4", "0.5", "0.6", "0.8"))
