"""Everything derived about one scheme, behind one name."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

from sympy import Expr, Matrix, Poly, Rational, Symbol, factor

from ..constrained.prescribed import Prescribed, prescribed_at
from ..declare.catalogue import find
from ..declare.parameter import Root
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, state_label, xi
from ..estimate.estimator import Estimator, estimator
from ..motion.effective import EffectiveSystem, effective_systems
from ..nonlinear.modified import ModifiedEquation, modified_equation
from ..nonlinear.modified_energy import ModifiedEnergy, modified_energy
from ..nonlinear.properties import Nonlinear, nonlinear
from ..oscillator.accuracy import LeadingTerms, leading_terms
from ..oscillator.amplification import Amplification
from ..oscillator.energy import Energy
from ..oscillator.evaluation import Evaluation
from ..oscillator.order import Triple, dampings_of, order_of
from ..oscillator.spectrum import require_convergent, rho_infinity
from ..stability.paper import PRINTER, as_in_paper


@dataclass(frozen=True)
class Derivation:
    """Exact results, computed when first asked for. Omega = omega*h, xi the damping ratio."""

    scheme: Scheme

    def __repr__(self) -> str:
        free = ", ".join(s.name for s in self.scheme.values) or "no parameters"
        return f"<derivation of {self.scheme.name}: {free}; state {', '.join(self.state)}>"

    @property
    def symbols(self) -> Mapping[str, Symbol]:
        """Name -> symbol, for Omega, xi and every free parameter."""
        return {s.name: s for s in (Omega, xi, *self.scheme.values)}

    @property
    def state(self) -> tuple[str, ...]:
        """Labels of the state, the order of A."""
        return tuple(state_label(s) for s in self.scheme.state)

    @cached_property
    def amplification(self) -> Amplification:
        """The derived amplification: numerators, denominators, load, characteristic polynomial."""
        return Amplification.of(self.scheme)

    @property
    def N(self) -> Matrix:
        """Numerators (m, m) of A."""
        return self.amplification.step.N

    @property
    def den(self) -> Expr:
        """Common denominator of A and of the load vectors."""
        return self.amplification.step.den

    @property
    def A(self) -> Matrix:
        """Amplification matrix (m, m) in the order of `state`."""
        return self.N / self.den

    @property
    def A_thesis(self) -> Matrix:
        """A in the thesis's order: rows and columns (h^2*a, h*v, u)."""
        return self.A[::-1, ::-1]

    @cached_property
    def det(self) -> Expr:
        """Determinant of A."""
        p = self.charpoly
        return factor((-1) ** p.degree() * p.eval(-1) / p.LC())

    @property
    def charpoly(self) -> Poly:
        """A multiple of det((1 + mu) I - A), polynomial in mu = lambda - 1 and in all other symbols."""
        return self.amplification.charpoly

    @property
    def load(self) -> Matrix:
        """Load vectors (m, K): x1 = A x0 + load @ [h^2 f(t_n + tau*h) for tau in stencil]."""
        return self.amplification.step.load_N / self.den

    @property
    def stencil(self) -> tuple[Expr, ...]:
        """Instants at which the load is taken, in steps after t_n."""
        return self.amplification.stencil

    @cached_property
    def rho_inf(self) -> Expr:
        """Spectral radius as Omega -> oo."""
        return rho_infinity(self.amplification)

    @cached_property
    def series(self) -> LeadingTerms:
        """Leading terms of numerical damping and period error at small Omega."""
        return leading_terms(self.amplification)

    @cached_property
    def energy(self) -> Energy:
        """The scheme's own energy, and what the load and the damping do to it in a step. Raises NoEnergy."""
        return Energy.of(self.scheme)

    @cached_property
    def order(self) -> Triple:
        """Order of u, v and a, free and forced, damped and undamped.

        With free parameters it is the order that almost all values have, found at two sets in general position. Raises
        InconsistentScheme where the scheme does not converge at its defaults.
        """
        return order_at(*self._convergent)

    @cached_property
    def nonlinear(self) -> Nonlinear:
        """Order of u, v and a on nonlinear equations; whether the step is symmetric, symplectic, or conjugate to that.

        With free parameters it is what almost all values have: the orders are found as in `order`, the verdicts are
        proved with the parameters as symbols, or at one set in general position where one has an implicit default.
        Raises InconsistentScheme as `order` does.
        """
        implicit = any(isinstance(p.default, Root) for p in self.scheme.parameters)
        verdicts_at = self._general[0] if implicit else Evaluation.free(self.scheme)
        return nonlinear(self._convergent, verdicts_at, lambda value: PRINTER.doprint(as_in_paper(value, self.scheme)))

    @cached_property
    def modified(self) -> ModifiedEquation:
        """The equation u'' = -N(u) + h^p f_p + ... that the numerical motion solves, without damping: two terms.

        Raises InconsistentScheme as `modified_equation` does.
        """
        return modified_equation(Evaluation.free(self.scheme))

    @cached_property
    def modified_energy(self) -> ModifiedEnergy | None:
        """The energy that the numerical motion keeps on every potential, and the first rates at which it does not.

        None for a scheme that reads the tangent stiffness at the start.
        """
        return modified_energy(self.modified)

    @cached_property
    def _general(self) -> tuple[Evaluation, ...]:
        """Two sets of parameters in general position; one if there are no parameters."""
        return tuple(unremarkable(self.scheme, k) for k in ((1, 2) if self.scheme.parameters else (1,)))

    @cached_property
    def _convergent(self) -> tuple[Evaluation, ...]:
        """`_general`, of a scheme that converges at its defaults; those of a member may lie outside the intervals."""
        if self.scheme.parent is None or not self.scheme.parameters:
            require_convergent(Evaluation.at_defaults(self.scheme))
        return self._general

    @cached_property
    def estimator(self) -> Estimator:
        """Estimated local errors of u and v, from what a step holds. Raises NoEstimator."""
        return estimator(self.scheme)

    @cached_property
    def prescribed(self) -> Prescribed:
        """Errors of velocity and multiplier where a constraint prescribes the motion, in the free parameters.

        Raises DeclarationError for a scheme that cannot carry a constraint.
        """
        return prescribed_at(Evaluation.free(self.scheme))

    @cached_property
    def balances(self) -> tuple[EffectiveSystem, ...]:
        """Effective stiffness, residual, tangent and recovery, one for each balance."""
        return effective_systems(self.scheme)


def order_at(*evaluations: Evaluation) -> Triple:
    """Order of u, v and a, free and forced, undamped and, unless it takes no damping, damped: the least at any set."""
    found = [order_of(e, damping).uva for e in evaluations for damping in dampings_of(e.scheme)]
    return cast(Triple, tuple(map(min, zip(*found, strict=True))))


def unremarkable(scheme: Scheme, k: int) -> Evaluation:
    """The scheme at the k-th set of parameters that satisfy no simple relation; implicit ones have their default."""
    values = {
        p.name: p.inside(Rational(31 * k + 7 * i, 97 + 12 * i))
        for i, p in enumerate(scheme.parameters)
        if not isinstance(p.default, Root)
    }
    return Evaluation.at(ParameterSet.of(scheme, None, values))


def derive(scheme: str | Scheme, **parameters: Any) -> Derivation:
    """Derive a scheme of the catalogue by name, or a declaration; parameters (exact) are fixed first.

    Raises DeclarationError for an unknown name or parameter.

    >>> derive("theta_method").rho_inf
    Abs((theta - 1)/theta)
    >>> derive("theta_method", theta="1/2").order  # of u, v and a
    (2, 2, 2)
    """
    declared = find(scheme)
    return Derivation(declared.fix(parameters) if parameters else declared)
