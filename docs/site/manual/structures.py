"""A page on what is proved of each scheme for every structure, and the energy that it has of its own."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

from substep_derive import (
    DeclarationError,
    Energy,
    NoEnergy,
    StructuresCertificate,
    certify,
    turning,
    turning_threshold,
)
from substep_derive.declare.catalogue import find
from substep_derive.motion.turning_threshold import FARTHEST
from substep_derive.nonlinear.modified_energy import leading_loss
from substep_derive.oscillator.evaluation import Evaluation
from substep_derive.stability.structures import bound_text
from sympy import latex

import substep as ss

from .markdown import code, plain, table

LONGEST = 160  # characters of LaTeX in a cell
HEADER = (
    "scheme", "every structure", "because", "energy of free motion, for a while",
    "own energy at ξ = 0", "its ratio a step", "lost on every potential",
    "gains energy on a rigid bar that turns by τ a step",
)  # fmt: skip


def pages() -> dict[str, Callable[[Path], str]]:
    """Name of a page -> its text."""
    return {"structures_proved": lambda _: page()}


@cache
def decided(name: str) -> StructuresCertificate | DeclarationError:
    """The certificate at the default parameters, or why no theorem fits the scheme."""
    try:
        return certify(name, structures=True)
    except DeclarationError as error:
        return error


def argument(name: str) -> str:
    """What is said on a scheme's own page."""
    found = decided(name)
    return str(found) if isinstance(found, DeclarationError) else found.text


def page() -> str:
    """One row for each scheme of the catalogue, at its default parameters."""
    rows = [
        [f"[{name}](schemes/{name}.md)", *_decision(decided(name)), *_energy(name), _lost(name), _turning(name)]
        for name in ss.schemes()
    ]
    others = code("substep certify NAME --structures")
    more = code("substep show NAME --part energy")
    return "\n".join(
        [
            "# Every structure, and the scheme's own energy", "",
            "Whether a scheme is stable for all M > 0, C ≥ 0 not proportional and K ≥ 0 of any size, at its",
            f"default parameters, by exact algebra; {others} has the argument, and other parameters.",
            "The column after the argument says how far the energy of free motion may rise above that at the start.",
            "The own energy is a form in (u, h v) that an undamped step multiplies by one number, derived with free",
            f"parameters; {more} has it with damping and load.",
            "The column before the last is the leading rate at which a scheme loses energy on nonlinear scenes for",
            "good, at its default parameters, where steps resolve the motion;",
            f"{code('substep show NAME --part modified')} has the energy, and the equation that the motion solves.",
            f"The last one says from which turn on, up to {FARTHEST} rad a step, errors along a rigid bar grow, as on",
            "the stiff pendulum and on a rod that is a constraint, numbers with proof by ball arithmetic;",
            "where it says `not told`, an eigenvalue of these errors meets one of the motion itself;",
            f"{code('substep show NAME --part turning')} has what is exact.",
            "",
            *table(HEADER, rows),
        ]
    )  # fmt: skip


def _decision(found: StructuresCertificate | DeclarationError) -> list[str]:
    if isinstance(found, DeclarationError):
        return ["not decided", plain(str(found)), ""]
    bound = "" if found.bound is None else f": {plain(bound_text(found.bound))}"
    return [found.verdict + bound, plain(found.argument.partition(". ")[0].rstrip(".") + "."), plain(found.transient)]


def _energy(name: str) -> list[str]:
    try:
        found = Energy.of(find(name))
    except NoEnergy:
        return ["not in closed form", ""]
    form, ratio = found.undamped
    if found.third != 0:
        return [r"in $u_{n+1} - \lambda_s u_n$, $\lambda_s$ the spurious root", r"$\lambda_1 \lambda_2$"]
    parts = {r"u^2": form[0, 0], r"u\,hv": 2 * form[0, 1], r"(hv)^2": form[1, 1]}
    terms = (symbols if e == 1 else rf"({latex(e)})\,{symbols}" for symbols, e in parts.items() if e != 0)
    return [_cell(" + ".join(terms)), _cell(latex(ratio))]


def _lost(name: str) -> str:
    found = leading_loss(Evaluation.at_defaults(name))
    if found is None:
        return "not in closed form"
    if found.loss is None:
        return f"nothing up to $h^{found.equation.top}$"
    terms = found.coefficients(found.rates)[found.loss]
    return f"$h^{found.loss}$: " + ", ".join(f"{-float(e.evalf()):.5g} {scalar}" for scalar, e in terms.items())


def _turning(name: str) -> str:
    try:
        exact = turning(name)
    except DeclarationError:
        return "no constant matrix"
    if not exact.at_infinity:
        return "explicit"
    if (most := exact.at_infinity[0][0]) > 1:
        return "unstable for Ω → ∞"
    if most == 1:
        return "always" if exact.product is None else f"iff Ωτ > {exact.product}"
    found = turning_threshold(name)
    low, high = found.decimals
    beyond = "never" if found.low == FARTHEST else f"not up to {low}; beyond, not told"
    return beyond if high is None else f"from between {low} and {high} on"


def _cell(text: str) -> str:
    return f"${text}$" if len(text) < LONGEST else "on its page"
