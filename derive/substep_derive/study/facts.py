"""What derivation finds once and for all, as plain data: rows of tables, and findings on the thesis's claims."""

from collections.abc import Iterable, Mapping
from typing import Any

from ..declare.scheme import Scheme
from ..declare.symbols import xi
from .derivation import derive
from .ledger import JUDGES
from .profile import profile
from .thesis import compared, newmark_sets, splits


def facts(schemes: Iterable[Scheme]) -> dict[str, Any]:
    """Name in generated/substep_kernels/facts.py -> value, of numbers and texts alone."""
    return {
        "CATALOGUE": {scheme.name: row(scheme) for scheme in schemes},
        "SPLITS": tuple(map(str, splits)),
        "NEWMARK_SETS": tuple(tuple(map(str, pair)) for pair in newmark_sets),
        "PROPERTIES": {
            (name, *sorted(f"{key}={value}" for key, value in parameters.items())): properties(name, parameters)
            for name, parameters in compared
        },
        "FINDINGS": {key: judge() for key, judge in JUDGES.items()},
    }


def row(scheme: Scheme) -> dict[str, Any]:
    """A scheme's properties at its default parameters, exact values as text: see `profile`."""
    p = profile(scheme)
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
    }


def properties(name: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """rho_inf, order of the free vibration, and the first term (power of Omega, coefficient) of each error, undamped.

    Exact values as text; None for an error that is 0.
    """
    d = derive(name, **parameters)

    def first(terms: Mapping[int, Any]) -> tuple[int, str] | None:
        values = ((power, coefficient.subs(xi, 0)) for power, coefficient in sorted(terms.items()))
        return next(((power, str(value)) for power, value in values if value != 0), None)

    return {
        "rho_inf": str(d.rho_inf),
        "order": d.series.order,
        "damping": first(d.series.numerical_damping),
        "period": first(d.series.period_error),
    }
