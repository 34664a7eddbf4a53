"""Scheme -> SchemeKernels: all that the scheme's module is printed from, each derived once."""

from dataclasses import dataclass

from sympy import Expr, Integer, eye

from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from ..motion.effective import EffectiveSystem, effective_systems
from ..oscillator.amplification import Amplification
from ..oscillator.one_rule import OneRule
from ..oscillator.transfer import Transfer
from .eigenvalue_defect import EigenvalueDefect
from .kernel import Kernel, entries, polynomial_kernel
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
    polynomial's value at the exact eigenvalue. rule: R and S of a step that is written by these, else None. matrices,
    stability: the polynomials from which matrices and stability functions are computed.
    """

    form: MarchForm
    systems: tuple[EffectiveSystem, ...]
    transfer: Transfer | None
    live: tuple[Expr, ...]
    positive: bool
    factor: tuple[Expr, ...] | None
    defect: EigenvalueDefect
    rule: OneRule | None
    matrices: tuple[Kernel, ...]
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
            matrices=_matrices(amplification, rule),
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


def _matrices(amplification: Amplification, rule: OneRule | None) -> tuple[Kernel, ...]:
    """Kernels of A - I, unless a rule gives it, and, where the scheme has its own start, of the start's matrices."""
    arguments = (Omega, xi, *amplification.scheme.values)
    step, start = amplification.step, amplification.start
    increment = [("den", step.den), *entries("D_", step.N - step.den * eye(step.N.rows))]
    doc = "Denominator and numerators of A - I."
    kernels = [] if rule else [polynomial_kernel("_increment", arguments, increment, doc)]
    if start is not None:
        outputs = [("den", start.den), *entries("S_", start.N), *entries("T_", start.load_N)]
        doc = "Denominator and numerators of the state at t = 0 from u, h*v, h^2*a and the load."
        kernels.append(polynomial_kernel("_start", arguments, outputs, doc))
    return tuple(kernels)
