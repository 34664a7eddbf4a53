"""Scheme -> SchemeKernels: all that the scheme's module is printed from, each derived once."""

from dataclasses import dataclass

from sympy import Expr, Integer

from ..declare.scheme import Scheme
from ..declare.symbols import xi
from ..motion.effective import EffectiveSystem, effective_systems
from ..oscillator.amplification import Amplification
from ..oscillator.one_rule import OneRule
from ..oscillator.transfer import Transfer
from .eigenvalue_defect import EigenvalueDefect
from .kernel import Kernel
from .march_form import MarchForm
from .stability import factor_coefficients, live_coefficients, never_negative, stability_kernels

LEAST_DEGREE = 4  # of R from which on a step is written by R and S: below, its expanded entries are about as short


@dataclass(frozen=True)
class SchemeKernels:
    """What a scheme's module computes.

    form: the linear march, with the amplification matrix. systems: the effective system of each balance. transfer: the
    digital filter that gives peaks from rest, None where there is none. live: coefficients, lowest first, of the
    polynomial in lambda whose roots are the live eigenvalues, those that are not always 0; positive: whether the last
    of them is positive at all parameters. factor: coefficients, lowest first, of the stability polynomial whose product
    at the oscillator's two s this is; None if there are at most three live eigenvalues, or no such product. defect: the
    polynomial's value at the exact eigenvalue. rule: R and S of a step that is written by these, else None. stability:
    the polynomials from which stability functions are computed.
    """

    form: MarchForm
    systems: tuple[EffectiveSystem, ...]
    transfer: Transfer | None
    live: tuple[Expr, ...]
    positive: bool
    factor: tuple[Expr, ...] | None
    defect: EigenvalueDefect
    rule: OneRule | None
    stability: tuple[Kernel, ...]

    @classmethod
    def of(cls, scheme: Scheme) -> "SchemeKernels":
        """Derive all of it. Raises DeclarationError if the relations and balances do not determine the new state."""
        amplification = Amplification.of(scheme)
        live = live_coefficients(amplification)
        factor = factor_coefficients(amplification) if len(live) > 4 else None
        defect = EigenvalueDefect.of(live, xi if scheme.takes_damping else Integer(0))
        form = MarchForm.of(amplification)
        rule = OneRule.of(form.step) if form.carrier else None
        rule = rule if rule is not None and rule.degree >= LEAST_DEGREE else None
        return cls(
            form=form,
            systems=effective_systems(scheme),
            transfer=Transfer.of(amplification, rule),
            live=tuple(live),
            positive=never_negative(live[-1], scheme),
            factor=factor,
            defect=defect,
            rule=rule,
            stability=stability_kernels(scheme, live, factor, defect),
        )

    @property
    def scheme(self) -> Scheme:
        """The scheme that the module is printed for."""
        return self.form.scheme

    @property
    def amplification(self) -> Amplification:
        """The scheme's amplification matrix in closed form."""
        return self.form.amplification
