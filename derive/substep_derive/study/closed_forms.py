"""Derivation -> the closed forms a reader asks for, as text and as LaTeX."""

from dataclasses import dataclass
from typing import Any

from sympy import Eq, Integer, factor, latex

from ..algebra.rational import horner
from ..declare.symbols import Omega, mu
from ..oscillator.spectrum import limit_polynomial
from .derivation import derive


@dataclass(frozen=True)
class ClosedForm:
    """One derived expression: what it is, as text, and as LaTeX."""

    section: str
    name: str
    text: str
    latex: str


def closed_forms(name: str) -> list[ClosedForm]:
    """Everything derived about a scheme, in the order of a paper.

    Raises DeclarationError for an unknown scheme.
    """
    d = derive(name)
    found: list[ClosedForm] = []

    def add(section: str, label: str, expression: Any) -> None:
        found.append(ClosedForm(section, label, str(expression), f"{label} = {latex(expression)}"))

    for symbol, expression in d.scheme.relations.items():
        found.append(ClosedForm("relations", str(symbol), str(expression), latex(Eq(symbol, expression))))
    for k, system in enumerate(d.balances, start=1):
        section = f"balance {k}, solved for {system.unknown}"
        add(section, "K_eff", system.effective_stiffness)
        add(section, "R", system.residual)
        add(section, "v", system.recover_v)
        add(section, "a", system.recover_a)
    state = ", ".join(d.state)
    add(f"amplification matrix N/den in ({state})", "den", horner(d.den, Omega))
    for i in range(d.N.rows):
        for j in range(d.N.cols):
            add(f"amplification matrix N/den in ({state})", f"N_{i + 1}{j + 1}", horner(d.N[i, j], Omega))
    add("spectrum", "det A", d.det)
    for k, coefficient in enumerate(reversed(d.charpoly.all_coeffs())):
        add("spectrum", f"p_{k} (of {mu}^{k})", horner(coefficient, Omega))
    try:
        add("spectrum", "rho_inf", d.rho_inf)
    except NotImplementedError:
        limit = limit_polynomial(d.amplification)
        add("spectrum", "rho_inf = largest |lambda| of 0", factor(limit.as_expr()))
    for k, tau in enumerate(d.stencil):
        for i, label in enumerate(d.state):
            add("load vector over den", f"B_{label} at t_n + ({tau})*h", d.amplification.step.load_N[i, k])
    for error, terms in (("numerical damping", d.series.numerical_damping), ("period error", d.series.period_error)):
        for power, coefficient in terms.items():
            add("small Omega", f"{error}, Omega^{power}", coefficient)
        if not terms:
            add("small Omega", f"{error}, up to Omega^{d.series.highest}", Integer(0))
    for label, text in d.nonlinear.lines.items():
        in_latex = "".join(rf"\{x}" if x in "_^{}&%$#" else x for x in f"{label}: {text}")
        found.append(ClosedForm("nonlinear equations", label, text, rf"\text{{{in_latex}}}"))
    return found
