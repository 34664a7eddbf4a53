"""Scheme -> SchemeKernels: all that the scheme's module is printed from, each derived once."""

from dataclasses import dataclass

from sympy import Expr, Integer, Symbol

from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from ..motion.effective import EffectiveSystem, effective_systems
from ..oscillator.amplification import Amplification
from ..oscillator.one_rule import OneRule
from ..oscillator.transfer import Transfer
from .eigenvalue_defect import EigenvalueDefect
from .eigenvalue_kind import EigenvalueKind
from .kernel import Kernel
from .march_form import MarchForm
from .stability_polynomials import factor_coefficients, live_coefficients, stability_kernels

LEAST_DEGREE = 4  # of R from which on a step is written by R and S: below, its expanded entries are about as short


@dataclass(frozen=True)
class SchemeKernels:
    """What a scheme's module computes.

    scheme: as it is declared; in all that follows, its parameters are named as they are printed. form: the linear
    march, with the amplification matrix. systems: the effective system of each balance, as declared. transfer: the
    digital filter that gives peaks from rest, None where there is none. live: coefficients, lowest first, of the
    polynomial in lambda whose roots are the live eigenvalues, those that are not always 0. factor: coefficients, lowest
    first, of the stability polynomial whose product at the oscillator's two s this is; None if there are at most three
    live eigenvalues, or no such product. defect: the polynomial's value at the exact eigenvalue. rule: R and S of a
    step that is written by these, else None. stability: the polynomials from which stability functions are computed.
    """

    scheme: Scheme
    form: MarchForm
    systems: tuple[EffectiveSystem, ...]
    transfer: Transfer | None
    live: tuple[Expr, ...]
    factor: tuple[Expr, ...] | None
    defect: EigenvalueDefect
    rule: OneRule | None
    stability: tuple[Kernel, ...]

    @classmethod
    def of(cls, scheme: Scheme) -> "SchemeKernels":
        """Derive all of it. Raises DeclarationError if the relations and balances do not determine the new state."""
        inside = scheme.in_kernels
        amplification = Amplification.of(inside)
        live = live_coefficients(amplification)
        factor = factor_coefficients(amplification) if len(live) > 4 else None
        defect = EigenvalueDefect.of(live, xi if scheme.takes_damping else Integer(0))
        form = MarchForm.of(amplification)
        rule = OneRule.of(form.step) if form.carrier else None
        rule = rule if rule is not None and rule.degree >= LEAST_DEGREE else None
        return cls(
            scheme=scheme,
            form=form,
            systems=effective_systems(scheme),
            transfer=Transfer.of(amplification, rule),
            live=tuple(live),
            factor=factor,
            defect=defect,
            rule=rule,
            stability=stability_kernels(inside, live, factor, defect),
        )

    @property
    def amplification(self) -> Amplification:
        """The scheme's amplification matrix in closed form."""
        return self.form.amplification

    @property
    def kind(self) -> EigenvalueKind:
        """How the live eigenvalues are found."""
        return EigenvalueKind(len(self.factor or self.live) - 1, self.factor is not None)

    @property
    def arguments(self) -> tuple[Symbol, ...]:
        """What the stability polynomials are functions of: Omega, xi and the parameters."""
        return Omega, xi, *self.form.scheme.values
