"""What derivation has found about a scheme, read from generated/ without SymPy: order, limits, stability, first errors.

The facts of the catalogue hold at a scheme's default parameters, and at those of members that fix all of them, as
linear_acceleration does those of newmark. At others the emitted closed forms and conditions decide, in exact arithmetic
where every parameter is a simple fraction: what is necessary without damping, and what suffices at every damping ratio.
What they do not decide is None, as is all about a scheme of the user's own. `substep_derive.certify` and
`substep_derive.derive` then tell it, exactly.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from ..derived.simple_fraction import simple_fraction
from .arrays import Array
from .entries import SchemeInfo
from .scheme_names import SCHEMES

Term = tuple[int, float]
Number = Fraction | float


@dataclass(frozen=True)
class Facts:
    """order: of u, v and a on the linear oscillator, free and forced; at least that where parameters are given.

    rho_inf: spectral radius as Omega -> oo, undamped; an array where parameters are. critical_Omega: the end of the
    interval from 0 on in which the scheme is stable, undamped; inf where it is stable for every Omega. A_stable: for
    every Omega and every damping ratio; L_stable: and rho_inf = 0. iterated: how many balances of a step have the
    force's tangent or gradient in their effective stiffness. overshoot: such as "U0-V1". damping, period: the first
    terms of numerical damping and period error at small Omega, undamped, as (power, coefficient), to six digits where a
    default is irrational; (0, 0.0) for an error that is 0.
    """

    order: tuple[int, int, int] | None = None
    rho_inf: float | Array | None = None
    critical_Omega: float | None = None
    iterated: int | None = None
    A_stable: bool | None = None
    L_stable: bool | None = None
    overshoot: str | None = None
    damping: Term | None = None
    period: Term | None = None


def _printed() -> Any:
    """The module that `make derive` prints."""
    from substep_kernels import facts  # noqa: PLC0415 (on first use)

    return facts


def facts_at_defaults(name: str) -> Facts:
    """Those of a scheme of the catalogue at its default parameters."""
    row: Mapping[str, Any] = _printed().CATALOGUE[name]
    decided = {"yes": True, "no": False, "open": None}
    damping, period = (
        (0, 0.0) if row[key] is None else (row[key][0], _float(row[key][1])) for key in ("damping", "period")
    )
    return Facts(
        order=row["order"],
        overshoot=row["overshoot"],
        A_stable=decided[row["A_stable"]],
        L_stable=decided[row["L_stable"]],
        iterated=sum("K_t" in k or "N_discrete" in k for k in row["stiffness"]),
        damping=damping,
        period=period,
        **row["values"],
    )


def facts_at(info: SchemeInfo, parameters: Mapping[str, Array]) -> Facts:
    """Those of a scheme of the catalogue with parameters, as far as its closed forms and conditions tell.

    At the parameters of a member of the catalogue they are the member's.
    """
    forms: Mapping[str, Any] = _printed().FORMS[info.name]
    if any(x.ndim for x in parameters.values()):
        limits = np.vectorize(lambda *values: _rho_inf(forms, values), otypes=[np.float64])
        return Facts(rho_inf=limits(*parameters.values()))
    values = {name: float(x) for name, x in parameters.items()}
    for name, entry in SCHEMES.items():
        if entry["module"] == info.module and not entry["parameters"] and entry.get("fixed", {}) == values:
            return facts_at_defaults(name)
    floats = list(values.values())
    exact = [simple_fraction(x) for x in floats]
    if None in exact:
        return Facts(order=_order(info, forms, floats), rho_inf=_rho_inf(forms, floats))
    rho_inf = _rho_inf(forms, exact)
    stable = None if forms["stable"] is None else bool(forms["stable"](*exact))
    suffices = forms["A_stable"] is not None and bool(forms["A_stable"](*exact))
    A_stable = False if stable is False else True if suffices else None
    return Facts(
        order=_order(info, forms, exact),
        rho_inf=rho_inf,
        critical_Omega=math.inf if stable else None,
        A_stable=A_stable,
        L_stable=False if A_stable is False or rho_inf > 0.0 else None if math.isnan(rho_inf) else A_stable,
    )


def other_sign_meant(info: SchemeInfo, given: Mapping[str, Array]) -> str:
    """That the one parameter of a scheme is likely meant with the other sign, that of its default; else nothing.

    So it is where a value takes A-stability away, and its negative does not.
    """
    for key, value in given.items() if info.declaration is None and len(info.parameters) == 1 else ():
        default = info.parameters[key].default
        if value.ndim or default is None or not default() * value < 0.0:
            continue
        if facts_at(info, {key: value}).A_stable is False and facts_at(info, {key: -value}).A_stable:
            return (
                f"{info.name} is not A-stable at {key} = {value:g}, so that motion grows; if the {key} of the other "
                f"sign is meant, it is {-value:g} here: ss.scheme('{info.name}', {key}={-value:g})"
            )
    return ""


def rho_inf_forms(info: SchemeInfo) -> tuple[str, str]:
    """rho_inf in the parameters as text and in LaTeX, empty where generated/ has no such form."""
    known: Mapping[str, Mapping[str, Any]] = _printed().FORMS
    form = known.get(info.name) if info.declaration is None else None
    return (form["limit_text"], form["limit_latex"]) if form else ("", "")


def _order(info: SchemeInfo, forms: Mapping[str, Any], values: Sequence[Any]) -> tuple[int, int, int] | None:
    """That of almost all parameters, or 2 where the conditions for it hold.

    None where a parameter whose default solves an equation has another value, since the order may depend on that.
    """
    earlier: dict[str, float] = {}
    for (name, parameter), value in zip(info.parameters.items(), values, strict=True):
        if parameter.polynomial is not None and abs(parameter.default_of(info.name, earlier) - value) > 1e-14:
            return None
        earlier[name] = float(value)
    conditions = forms["second_order"](*values)
    found = [2 if c and not any(c) else p for p, c in zip(forms["order"], conditions, strict=True)]
    return found[0], found[1], found[2]


def _rho_inf(forms: Mapping[str, Any], values: Sequence[Any]) -> float:
    """The largest modulus of the limits of the eigenvalues, inf if one has none; NaN where the form does not hold."""
    factors = () if forms["limit"] is None else forms["limit"](*values)
    if not all(any(factor) for factor in factors):
        return math.nan  # leading powers of Omega vanish, so that the limit is another
    if forms["limit"] is None or not all(factor[0] for factor in factors):
        return math.inf
    return max((_modulus(factor) for factor in factors), default=0.0)


def _modulus(coefficients: Sequence[Number]) -> float:
    """The largest modulus of the roots of a polynomial, from the highest coefficient; 0 for a constant."""
    if len(coefficients) == 1:
        return 0.0
    if len(coefficients) > 3:
        return float(np.abs(np.roots([float(c) for c in coefficients])).max())
    if len(coefficients) == 2:
        a, b = coefficients
        return float(abs(b / a))
    a, b, c = coefficients
    square = b * b - 4 * a * c
    return math.sqrt(c / a) if square < 0 else (float(abs(b)) + math.sqrt(square)) / float(abs(2 * a))


def _float(text: str) -> float:
    numerator, _, denominator = text.partition("/")
    return float(numerator) / float(denominator or 1)
