"""What derivation finds once and for all, as plain data: rows of tables."""

from collections.abc import Iterable, Mapping
from typing import Any

from sympy import Expr, Integer

from ..algebra.algebraic import closed_form, generator
from ..constrained.prescribed import prescribed
from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from ..emit.printing import Code
from ..oscillator.accuracy import leading_terms
from ..oscillator.evaluation import Evaluation
from ..oscillator.spectrum import live_at
from ..stability.paper import PRINTER, as_in_paper
from .derivation import derive
from .forms import forms
from .profile import profile


def facts(schemes: Iterable[Scheme]) -> dict[str, Any]:
    """Name in generated/substep_kernels/facts.py -> value, of numbers and texts alone."""
    schemes = tuple(schemes)
    return {
        "CATALOGUE": {scheme.name: row(scheme) for scheme in schemes},
        "FORMS": {scheme.name: forms(scheme) for scheme in schemes if scheme.parameters},
    }


def row(scheme: Scheme) -> dict[str, Any]:
    """A scheme's properties at its default parameters, exact values as text: see `profile`."""
    p, d = profile(scheme), derive(scheme)
    damping, period = _first_terms(scheme, p.nonlinear.symmetric.word == "yes" or _on_circle(scheme))
    rho, bifurcation = (f"{float(x):.6g}" if x.is_finite else "oo" for x in (p.rho_inf, p.bifurcation))
    A, L = ({True: "yes", False: "no", None: "open"}[x] for x in (p.A_stable, p.L_stable))
    return {
        "order": p.order,
        "rho_inf": rho,
        "critical_Omega": "none" if p.critical_Omega is None else str(p.critical_Omega),
        "critical_curve": "" if p.critical_curve is None else str(p.critical_curve),
        "A_stable": A,
        "L_stable": L,
        "overshoot": str(p.overshoot),
        "bifurcation": bifurcation,
        "nonlinear_order": p.nonlinear.uva,
        "eigenvalue_order": p.nonlinear.eigenvalue,
        **{name: getattr(p.nonlinear, name).word for name in ("symmetric", "symplectic", "conjugate_symplectic")},
        "constrained": _constrained(scheme),
        "damping": damping,
        "period": period,
        "values": {name: _value(x) for name, x in (("rho_inf", p.rho_inf), ("critical_Omega", p.critical_Omega))},
        "stiffness": tuple(PRINTER.doprint(as_in_paper(x.effective_stiffness, scheme)) for x in d.balances),
    }


def _constrained(scheme: Scheme) -> str:
    """What the scheme makes of a prescribed motion, or why it cannot carry a constraint."""
    try:
        return str(prescribed(scheme))
    except DeclarationError as error:
        return f"refused: {error}"


def _value(number: Expr | None) -> Any:
    """A number as a float; None, for no limit, and infinity as inf."""
    return float(number) if number is not None and number.is_finite else Code("inf")


def _on_circle(scheme: Scheme) -> bool:
    """Whether undamped eigenvalues come in pairs lambda, 1/lambda: their polynomial reads the same backwards."""
    rows = live_at(Evaluation.at_defaults(scheme), Integer(0))
    return rows == rows[::-1]


def _first_terms(scheme: Scheme, conservative: bool) -> tuple[tuple[int, str] | None, tuple[int, str] | None]:
    """The first term of numerical damping and of period error at the defaults; None for one that is 0.

    conservative: whether the scheme is known to have no numerical damping.
    """
    for highest in (3, 5, 7, 9):
        series = leading_terms(derive(scheme).amplification, highest)
        damping, period = (_first(scheme, terms) for terms in (series.numerical_damping, series.period_error))
        if period and (damping or conservative):
            return damping, period
    raise NotImplementedError(f"{scheme.name}: expected errors of order 9 or less")


def _first(scheme: Scheme, terms: Mapping[int, Expr]) -> tuple[int, str] | None:
    """The first term, undamped, that does not vanish at the defaults, as text: exact where these are rational."""
    at = Evaluation.at_defaults(scheme)
    for power, coefficient in sorted(terms.items()):
        if found := at.number(coefficient.subs(xi, 0)):
            value = at.field.expression(found)
            if value.is_Rational:
                return power, str(value)
            return power, f"{float(value.subs(generator, closed_form(at.field.root, Omega))):.6g}"
    return None
