"""A page for each scheme of the catalogue: declaration, properties, closed forms, certificate, chart, code."""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from substep_derive import DeclarationError, certify
from substep_derive.declare import schemes as declared
from substep_derive.declare.catalogue import find
from substep_derive.declare.published import Published
from substep_derive.declare.scheme import Scheme
from substep_derive.study.closed_forms import ClosedForm, closed_forms
from substep_kernels.facts import CATALOGUE
from substep_languages.standalone import standalone
from sympy import And, latex, sympify

import substep as ss

from . import ROOT, charts
from .declarations import declaration
from .markdown import block, code, folded, formula, plain, table, toctree
from .structures import argument

FOLDED = ("amplification matrix", "load vector", "balance")  # sections of long formulas
TITLES = {
    "order": "order of u, v and a on the linear oscillator",
    "nonlinear_order": "order of u, v and a on nonlinear equations",
    "eigenvalue_order": "order of the eigenvalues",
    "rho_inf": "spectral radius as Ω → ∞",
    "critical_Omega": "end of the stable interval of Ω that begins at 0, undamped",
    "critical_curve": "the same, at any damping ratio ξ",
    "A_stable": "stable for every Ω and every ξ",
    "L_stable": "and its spectral radius tends to 0",
    "overshoot": "overshoot: powers with which u and v/ω grow in a step as Ω → ∞",
    "constrained": "error where a constraint prescribes the motion r(t): of v over r‴, of the multiplier over r⁗ at h²",
    "bifurcation": "the complex pair of eigenvalues becomes real at Ω",
    "symmetric": "symmetric",
    "symplectic": "symplectic",
    "conjugate_symplectic": "conjugate symplectic",
}
EXACT = ("rho_inf", "critical_Omega", "critical_curve", "bifurcation")  # expressions as text
COLUMNS = {
    "order": "order of u, v, a",
    "rho_inf": "ρ∞",
    "critical_Omega": "stable up to Ω",
    "A_stable": "A-stable",
    "L_stable": "L-stable",
    "overshoot": "overshoot",
}
WORDS = {("critical_Omega", "none"): "no limit", ("bifurcation", "oo"): "never"}


def pages() -> dict[str, Callable[[Path], str]]:
    """Name of a page -> its text."""
    own = {f"schemes/{name}": partial(page, name) for name in ss.schemes()}
    return {"schemes/index": lambda _: index(), **own}


def index() -> str:
    """The table of the catalogue, as it was derived."""
    rows = []
    for name in ss.schemes():
        row = CATALOGUE[name]
        rows.append([f"[{name}]({name}.md)", *(_shown(key, row[key]) for key in COLUMNS)])
    header = ["scheme", *COLUMNS.values()]
    return "\n".join(
        [
            "# Schemes", "",
            "At default parameters, undamped where a column does not say otherwise; derived, exact. ρ∞ is the spectral",
            "radius as Ω → ∞. A-stable: for every Ω and every damping ratio; L-stable: and ρ∞ = 0. Overshoot U1-V2: in",
            "one step from a unit start u grows like Ω, v/ω like Ω² as Ω → ∞.", "",
            *table(header, rows),
            *toctree(ss.schemes()),
        ]
    )  # fmt: skip


def page(name: str, folder: Path) -> str:
    """The text of one scheme's page; its chart is put into the folder."""
    scheme = find(name)
    charts.stability(name).savefig(folder / f"{name}.svg", metadata={"Date": None})
    path, source = declaration(scheme, declared)
    lines = [f"# {name}", "", plain(scheme.reference) + ".", ""]
    if scheme.parent:
        lines += [f"A member of [{scheme.parent}]({scheme.parent}.md): the same scheme with parameters fixed.", ""]
    lines += [f"![Spectral radius, amplitude error and period error of {name}]({name}.svg)", "", charts.CAPTION, ""]
    lines += ["## Declaration", "", f"In `{path}`; what is not defined here is imported there.", ""]
    lines += [*block("python", source), *_parameters(scheme), *_properties(scheme), *_closed_forms(name)]
    others = code(f"substep certify {name}")
    lines += ["## Certificate", "", f"At default parameters and ξ = 0; at others: {others}.", ""]
    lines += [*block("text", certify(scheme).text)]
    lines += ["On [every structure](../structures_proved.md), at default parameters:", ""]
    lines += [*block("text", argument(name)), *_code(scheme)]
    return "\n".join(lines) + "\n"


def _parameters(scheme: Scheme) -> Iterator[str]:
    if not scheme.parameters and not scheme.families:
        return
    info = ss.scheme(scheme.name)
    rows = [
        [f"`{p.name}`", f"${latex(p.domain)}$", f"{float(info.parameters[p.name]):.10g}"] for p in scheme.parameters
    ]
    rows += [
        [f"`{f.argument.name}`", f"${latex(f.argument.domain)}$", "sets " + ", ".join(f"`{s}`" for s in f.values)]
        for f in scheme.families
    ]
    yield from ["## Parameters", "", *table(["parameter", "lies in", "default"], rows)]


def _properties(scheme: Scheme) -> Iterator[str]:
    yield from ["## Properties", "", "Derived at the default parameters.", ""]
    row = CATALOGUE[scheme.name]
    rows = [[title, _shown(key, row[key])] for key, title in TITLES.items() if row[key] != ""]
    yield from table(["property", "value"], rows)
    if scheme.published is not None:
        yield from [f"Published, and compared by the tests: {_published(scheme.published)}.", ""]


def _published(published: Published) -> str:
    stated = []
    if published.order is not None:
        stated.append(f"order {published.order}")
    if published.rho_inf is not None:
        stated.append(f"ρ∞ ${latex(sympify(published.rho_inf))}$")
    if published.critical_Omega is not None:
        limit = sympify(published.critical_Omega)
        stated.append(f"stable up to Ω = ${latex(limit)}$" if limit.is_finite else "stable for every Ω")
    if published.stable_if:
        stated.append(f"that exactly if ${latex(And(*published.stable_if))}$")
    return f"{', '.join(stated)} ({plain(published.source)})"


def _shown(key: str, value: Any) -> str:
    """A property's value for a reader: exact expressions as formulas."""
    if (key, value) in WORDS:
        return WORDS[key, value]
    if key in EXACT:
        return f"${latex(sympify(value))}$"
    return ",\N{NO-BREAK SPACE}".join(map(str, value)) if isinstance(value, tuple) else plain(str(value))


def _closed_forms(name: str) -> Iterator[str]:
    yield from [
        "## Closed forms",
        "",
        f"Also as text, `substep show {name} --part all`; for a paper, with `--latex`.",
        "",
    ]
    for section, forms in groupby(closed_forms(name), key=lambda form: form.section):
        lines = [line for form in forms for line in _form(name, form)]
        title = section[0].upper() + section[1:]
        yield from folded(title, lines) if section.startswith(FOLDED) else [f"### {title}", "", *lines]


def _form(name: str, form: ClosedForm) -> Iterator[str]:
    if isinstance(form.value, str):
        yield from [f"{plain(form.name)}: {plain(form.text)}.", ""]
        return
    yield from formula(form.latex, f"`substep show {name} --part all` prints {code(form.name)}")


def _code(scheme: Scheme) -> Iterator[str]:
    module = f"schemes/{scheme.parent or scheme.name}.py"
    pair = f"pairs/{scheme.name}__elastic_pendulum.py"
    yield from ["## Code", ""]
    for file, what in (
        (module, "stability polynomials and coefficients of the march"),
        (pair, "the march of the pendulum"),
    ):
        path = ROOT / "generated" / "substep_kernels" / file
        if path.exists():
            yield f"- {{download}}`{file} <../../../{path.relative_to(ROOT).as_posix()}>`: {what}, as printed for numba"
    try:
        text = standalone(scheme, "c")
    except DeclarationError as error:  # of balances that are solved together
        yield from [f"- In no other language: {plain(str(error))}.", ""]
        return
    other = code(f"substep emit {scheme.name} --language python")
    yield f"- As one file that needs nothing else: below in C; {other} prints it in another language,"
    yield from ["  [emit](../../emit.md) says which there are.", ""]
    yield from folded(f"{scheme.name} in C", block("c", text))
