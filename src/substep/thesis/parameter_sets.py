"""The parameter sets of the thesis's chapter 4, from the table that the derivation holds."""

from fractions import Fraction

from substep_kernels.facts import NEWMARK_SETS as PRINTED_SETS
from substep_kernels.facts import SPLITS as PRINTED_SPLITS

# thesis, Table 4.1 and the sub-step ratios of figures 4.1-4.5
NEWMARK_SETS = tuple((Fraction(beta), Fraction(gamma)) for beta, gamma in PRINTED_SETS)
SPLITS = tuple(map(Fraction, PRINTED_SPLITS))
