"""Derivation -> the closed forms a reader asks for, part by part, as text, LaTeX and MathML."""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass

from sympy import Add, CRootOf, Expr, Integer, Mul, Symbol, cancel, factor, fraction, latex, together
from sympy.printing.mathml import mathml

from ..declare.errors import DeclarationError, InconsistentScheme
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, mu, xi
from ..motion.turning import turning
from ..motion.turning_threshold import turning_threshold
from ..oscillator.energy import NoEnergy, spurious
from ..oscillator.spectrum import limit_polynomial
from ..stability.paper import PRINTER, as_in_paper, in_powers
from .derivation import Derivation, derive

GREEK = {Symbol("rho_inf"): r"\rho_\infty"}  # what SymPy would set as rho with the subscript inf
TERM = r"\b((?:Omega|lambda|mu)\b|[A-Za-z](?=[_^]))(?:([_^])(\w+))?"  # a Greek letter, or a letter with a script
SIGNS = {"->": r"$\to$", "<": "$<$", ">": "$>$", "|": "$|$", "^": r"\textasciicircum{}"}  # in a text; others escaped


@dataclass(frozen=True)
class ClosedForm:
    """One derived result: its section, what it is, and an expression or a sentence."""

    section: str
    name: str
    value: Expr | str

    @property
    def text(self) -> str:
        """The result as text."""
        return self.value.replace("**", "^") if isinstance(self.value, str) else PRINTER.doprint(self.value)

    @property
    def label(self) -> str:
        """The name in LaTeX: one word as a symbol, several as text."""
        return _latex(Symbol(self.name)) if re.fullmatch(r"\w+", self.name) else _words(self.name)

    @property
    def latex(self) -> str:
        """Name and result in LaTeX, for a display."""
        if isinstance(self.value, str):
            return _words(f"{self.name}: {self.text}")
        return f"{self.label} = {_latex(self.value)}"

    @property
    def mathml(self) -> str:
        """The result, without its name, in MathML; a sentence as it is."""
        return self.value if isinstance(self.value, str) else str(mathml(self.value, printer="presentation"))


def _latex(expression: Expr) -> str:
    return latex(expression, symbol_names=GREEK)


def _words(text: str) -> str:
    """Plain text in LaTeX, with indices and powers set as such and signs that a font of text may lack as formulas."""
    return r"\text{" + re.sub(rf"{TERM}|([_^])(\w+)|->|[_^{{}}&%$#<>|]", _sign, text) + "}"


def _sign(found: re.Match[str]) -> str:
    if base := found[1]:
        return f"${_latex(Symbol(base))}{f'{found[2]}{{{found[3]}}}' if found[2] else ''}$"
    sign, script = found[4] or found[0], found[5]
    if script:
        return f"${sign}{{{script}}}$"
    return SIGNS.get(sign, rf"\{sign}")


def closed_forms(scheme: str | Scheme, part: str = "all") -> Iterator[ClosedForm]:
    """What is derived about a scheme, in the order of a paper: one of PARTS, or all; each derived when it is reached.

    Raises DeclarationError for an unknown scheme, KeyError for an unknown part.
    """
    d = derive(scheme)
    for derived in PARTS.values() if part == "all" else (PARTS[part],):
        yield from derived(d)


def _relations(d: Derivation) -> Iterator[ClosedForm]:
    for symbol, expression in d.scheme.relations.items():
        yield ClosedForm("relations", str(symbol), expression)  # as it is declared


def _stiffness(d: Derivation) -> Iterator[ClosedForm]:
    for k, system in enumerate(d.balances, start=1):
        section = f"balance {k}, solved for {system.unknown}"
        yield ClosedForm(section, "K_eff", as_in_paper(system.effective_stiffness, d.scheme))
        yield ClosedForm(section, "R", _residual(system.residual, d.scheme))
        yield ClosedForm(section, "v", as_in_paper(system.recover_v, d.scheme))
        yield ClosedForm(section, "a", as_in_paper(system.recover_a, d.scheme))


def _residual(residual: Expr, scheme: Scheme) -> Expr:
    """A residual whose forces stay apart: M and C times sums as in a paper."""
    forces = (Mul.make_args(force) for force in Add.make_args(residual))
    return Add(*(Mul(*(as_in_paper(e, scheme) if e.is_Add else e for e in factors)) for factors in forces))


def _amplification(d: Derivation) -> Iterator[ClosedForm]:
    section = f"amplification matrix N/den in ({', '.join(d.state)})"
    yield ClosedForm(section, "den", in_powers(d.den, Omega, d.scheme))
    for i in range(d.N.rows):
        for j in range(d.N.cols):
            yield ClosedForm(section, f"N_{i + 1}{j + 1}", in_powers(d.N[i, j], Omega, d.scheme))


def _spectrum(d: Derivation) -> Iterator[ClosedForm]:
    yield ClosedForm("spectrum", "det A", d.det)
    for k, coefficient in enumerate(reversed(d.charpoly.all_coeffs())):
        yield ClosedForm("spectrum", f"p_{k} (of {mu}^{k})", in_powers(coefficient, Omega, d.scheme))
    try:
        yield ClosedForm("spectrum", "rho_inf", as_in_paper(d.rho_inf, d.scheme))
    except ValueError:
        limit = limit_polynomial(d.amplification)
        yield ClosedForm("spectrum", "rho_inf = largest |lambda| of 0", factor(limit.as_expr()))


def _energy(d: Derivation) -> Iterator[ClosedForm]:
    section = "own energy E of a free step"
    try:
        found = d.energy
    except NoEnergy as error:
        yield ClosedForm(section, "none in closed form", str(error))
        return
    if found.third == 0:
        yield ClosedForm(section, "E", f"x^T P x for x = ({', '.join(found.state)})")
        for i, j in ((0, 0), (0, 1), (1, 1)):
            yield ClosedForm(section, f"P_{i + 1}{j + 1}", in_powers(found.form[i, j], Omega, d.scheme))
        name = "E_1/E_0 = det A"
    else:
        yield ClosedForm(
            section, "E", "w_1^2 - t w_0 w_1 + d w_0^2 with w_0 = u_1 - lambda_s u_0, w_1 = u_2 - lambda_s u_1"
        )
        yield ClosedForm(section, "lambda_s is the real root of", in_powers(found.third, spurious, d.scheme))
        yield ClosedForm(section, "t", cancel(-2 * found.form[0, 1]))
        name = "d = E_1/E_0"
    yield ClosedForm(section, name, as_in_paper(found.ratio, d.scheme))
    if found.ratio.has(xi):
        yield ClosedForm(section, f"{name} at xi = 0", as_in_paper(found.undamped[1], d.scheme))
    with suppress(NoEnergy):
        roots = "largest over least root x of x^2 - (P_11/Omega^2 + P_22) x + (P_11 P_22 - P_12^2)/Omega^2"
        most = roots if found.gained != 1 and found.form.subs(xi, 0)[0, 1] != 0 else found.gained
        yield ClosedForm(section, "(Omega^2 u^2 + (h v)^2)/that at the start, at most, xi = 0", most)
    yield ClosedForm(section, "with a load", "E_1 = (E_1/E_0) E_0 + (x_1 + A x_0)^T P B h^2 f")


def _load(d: Derivation) -> Iterator[ClosedForm]:
    for k, tau in enumerate(d.stencil):
        for i, label in enumerate(d.state):
            name = f"B of {label} at t_n + ({PRINTER.doprint(tau)})*h"
            yield ClosedForm(
                "load vector over den", name, in_powers(d.amplification.step.load_N[i, k], Omega, d.scheme)
            )


def _series(d: Derivation) -> Iterator[ClosedForm]:
    for error, terms in (("numerical damping", d.series.numerical_damping), ("period error", d.series.period_error)):
        for power, coefficient in terms.items():
            if coefficient.has(xi) and (undamped := coefficient.subs(xi, 0)) != 0:
                yield ClosedForm("small Omega", f"{error} at xi = 0, Omega^{power}", as_in_paper(undamped, d.scheme))
            yield ClosedForm("small Omega", f"{error}, Omega^{power}", as_in_paper(coefficient, d.scheme))
        if not terms:
            yield ClosedForm("small Omega", f"{error}, up to Omega^{d.series.highest}", Integer(0))


def _nonlinear(d: Derivation) -> Iterator[ClosedForm]:
    for label, text in d.nonlinear.lines.items():
        yield ClosedForm("nonlinear equations", label, text)


def _modified(d: Derivation) -> Iterator[ClosedForm]:
    """Trees as they are written in `nonlinear.trees`: N[v, v] is N''(u)(u', u')."""
    section = "modified equation u'' = -N(u) + h^p f_p + ..."
    try:
        found, energy = d.modified, d.modified_energy
    except InconsistentScheme as error:
        yield ClosedForm(section, "none", str(error))
        return
    yield from _by_power(d, section, found.coefficients, f"all f_p up to p = {found.top}")
    if energy is None:
        return
    section = "modified energy H = T + V + h^p H_p + ... on every potential"
    yield from _by_power(d, section, energy.coefficients(energy.terms), f"all H_p up to p = {found.top}")
    yield from _by_power(d, "dH/dt", energy.coefficients(energy.rates), f"dH/dt, up to h^{found.top}")


def _by_power(
    d: Derivation, section: str, terms: Mapping[int, Mapping[str, Expr]], nothing: str
) -> Iterator[ClosedForm]:
    for power, factors in terms.items():
        for what, value in factors.items():
            yield ClosedForm(section, f"h^{power} {what}", as_in_paper(value, d.scheme))
    if not terms:
        yield ClosedForm(section, nothing, Integer(0))


def _constrained(d: Derivation) -> Iterator[ClosedForm]:
    section = "prescribed motion: errors over its derivative of order 1 (v) or 2 (multiplier) plus the power of h"
    try:
        found = d.prescribed
    except DeclarationError as error:
        yield ClosedForm(section, "refused", str(error))
        return
    for what, term in (("v", found.velocity), ("the multiplier", found.multiplier)):
        name = f"error of {what}" + ("" if term is None else f", h^{term.power}")
        yield ClosedForm(section, name, Integer(0) if term is None else as_in_paper(term.coefficient, d.scheme))
    numerator = fraction(together(found.polynomial.as_expr()))[0]
    yield ClosedForm(section, "0 = of a wrong start", as_in_paper(factor(numerator), d.scheme))


def _turning(d: Derivation) -> Iterator[ClosedForm]:
    section = "errors on a stiff bar that turns by tau in a step, at default parameters"
    try:
        found = turning(d.scheme)
    except DeclarationError as error:
        yield ClosedForm(section, "refused", str(error))
        return
    for modulus, times in found.at_infinity:
        yield ClosedForm(section, f"|lambda| for Omega -> oo, {times}-fold", _short(modulus))
    if found.growth:
        c0, c1 = found.growth
        yield ClosedForm(
            section, "factor a step on a rigid bar, to first order", _short(c0) + _short(c1) * Symbol("tau")
        )
    if found.product is not None:
        yield ClosedForm(section, "they grow iff Omega tau exceeds", found.product)
    if found.at_infinity and found.at_infinity[0][0] < 1:
        try:
            yield ClosedForm(section, "on a rigid bar, by ball arithmetic", turning_threshold(d.scheme).text)
        except ImportError as error:
            yield ClosedForm(section, "refused", str(error))


def _short(number: Expr) -> Expr:
    """The number, or six digits of a root that has no short form."""
    return number.n(6) if number.has(CRootOf) else number


PARTS: Mapping[str, Callable[[Derivation], Iterator[ClosedForm]]] = {
    "relations": _relations,
    "stiffness": _stiffness,
    "amplification": _amplification,
    "spectrum": _spectrum,
    "energy": _energy,
    "load": _load,
    "series": _series,
    "nonlinear": _nonlinear,
    "modified": _modified,
    "constrained": _constrained,
    "turning": _turning,
}
