"""Kernel list -> text of a module. The text depends on the declarations alone, byte for byte."""

import hashlib
from collections.abc import Iterable
from string import Formatter
from textwrap import indent, wrap
from typing import Any

from sympy import Expr, Symbol, count_ops, srepr
from sympy.printing.pycode import PythonCodePrinter

from . import algebra, templates
from .amplification import Amplification
from .effective import effective_systems
from .kernels import Kernel, entries, scheme_kernels
from .scheme import DeclarationError, Parameter, Scheme
from .symbols import Omega, knot, state_label, xi

SMALL_OMEGA = 0.125  # below: exact eigenvalue plus its defect; above: direct formulas
RESERVED = {"out", "i", "den", "increment", "load", "outputs", "outputs_load", "Omega", "xi", "math", "cmath"}
PRINTER = PythonCodePrinter({"fully_qualified_modules": False})


def fill(template: str, **fields: object) -> str:
    """str.format that also refuses fields the template does not use."""
    wanted = {name for _, name, _, _ in Formatter().parse(template) if name}
    if wanted != set(fields):
        raise KeyError(f"template wants {sorted(wanted)}, got {sorted(fields)}")
    return template.format(**fields)


def digest(scheme: Scheme) -> str:
    """sha256 of everything declared about the scheme."""
    declared = [scheme.name, scheme.reference, *(f"{k}={v}" for k, v in scheme.fixed.items())]
    declared += [srepr(part) for p in scheme.parameters for part in (p.symbol, p.domain, p.default)]
    declared += [srepr(part) for relation in scheme.relations.items() for part in relation]
    declared += [srepr(slot) for b in scheme.balances for slot in (b.inertia, b.damping, b.force, b.load)]
    return hashlib.sha256("\n".join(declared).encode()).hexdigest()


def print_kernel(kernel: Kernel) -> str:
    """One jitted scalar function: common subexpressions, then the named outputs."""
    subexpressions, outputs = algebra.cse([e for _, e in kernel.outputs])
    operations = sum(int(count_ops(e)) for e in (*(e for _, e in subexpressions), *outputs))
    lines = [f"{name} = {PRINTER.doprint(e)}" for name, e in subexpressions]
    lines += [f"{name} = {PRINTER.doprint(e)}" for (name, _), e in zip(kernel.outputs, outputs, strict=True)]
    body = indent("\n".join(lines), "    ")
    arguments = ", ".join(a.name for a in kernel.arguments)
    returned = ", ".join(name for name, _ in kernel.outputs)
    return (
        f"\n\n@_compile\ndef {kernel.name}({arguments}):\n"
        f'    """{kernel.docstring} {operations} operations."""\n{body}\n    return {returned}\n'
    )


def closed_forms(scheme: Scheme, amplification: Amplification) -> str:
    """What a reader of the module sees of the paper: relations, balances, effective stiffness, A."""
    lines = ["Relations and balances:"]
    lines += [f"    {symbol} = {expression}" for symbol, expression in scheme.relations.items()]
    lines += [f"    M*({b.inertia}) + C*({b.damping}) + {b.force} = {b.load}" for b in scheme.balances]
    lines += ["", "Effective stiffness of each balance and its unknown:"]
    lines += [f"    {e.unknown}: {e.effective_stiffness}" for e in effective_systems(scheme)]
    labels = [state_label(s) for s in scheme.state]
    lines += [
        "",
        f"Amplification matrix N/den in ({', '.join(labels)}):",
        f"    den = {algebra.horner(amplification.den, Omega)}",
    ]
    lines += [f"    {name} = {algebra.horner(e, Omega)}" for name, e in entries("N", amplification.N)]
    wrapped = (wrap(line, 110, subsequent_indent=" " * 8, break_long_words=False) or [""] for line in lines)
    return "\n".join(part for line in wrapped for part in line)


def scheme_module(scheme: Scheme, source: str) -> str:
    """Text of generated/substep_kernels/<name>.py."""
    amplification = Amplification.of(scheme)
    kernels = scheme_kernels(amplification)
    by_name = {kernel.name: kernel for kernel in kernels}
    m, K = amplification.load_N.shape
    arguments = [Omega.name, xi.name, *(p.name for p in scheme.parameters)]
    if taken := [a for a in arguments[2:] if a in RESERVED or (a[0] == "x" and a[1:].isdigit())]:
        raise DeclarationError(
            f"{scheme.name}: the name '{taken[0]}' is used by the generated module; rename the parameter"
        )
    typed = {"arguments": ", ".join(arguments), "arguments_i": ", ".join(f"{a}[i]" for a in arguments)}
    names = {key: [name for name, _ in by_name[key].outputs] for key in ("_amplification", "_increment")}
    targets = {"N": "out", "D": "increment", "B": "load", "O": "outputs", "P": "outputs_load"}

    def stores(kernel: str) -> str:
        rows = (f"        {targets[name[0]]}[i, {name[2]}, {name[3]}] = {name} / den" for name in names[kernel][1:])
        return "\n".join(rows)

    at_i = {p.symbol: Symbol(f"{p.name}[i]") for p in scheme.parameters}
    instants = [PRINTER.doprint(tau.subs(at_i)) for tau in amplification.stencil]
    state = [knot(0)[i] for i in range(3)]
    header = fill(
        templates.SCHEME_HEADER,
        title=f"{scheme.name}: stability functions and march coefficients.",
        reference=scheme.reference + ".",
        closed_forms=closed_forms(scheme, amplification),
        name=scheme.name,
        state=_tuple(state_label(s) for s in scheme.state),
        parameters=_tuple(p.name for p in scheme.parameters),
        outputs_in_state=tuple(scheme.state.index(s) if s in scheme.state else -1 for s in state),
    )
    functions = fill(
        templates.SCHEME_FUNCTIONS,
        **typed,
        small_Omega=SMALL_OMEGA,
        m=m,
        K=K,
        den_and_N=", ".join(names["_amplification"]),
        den_and_DB=",\n            ".join(wrap(", ".join(names["_increment"]), 100)).replace(",,", ","),
        store_N=stores("_amplification"),
        store_DB=stores("_increment"),
        store_stencil="\n".join(f"        out[i, {k}] = {tau}" for k, tau in enumerate(instants)),
        parameters_comma="".join(f"{p.name}, " for p in scheme.parameters),
    )
    banner = fill(templates.BANNER, source=source, digest=digest(scheme))
    return banner + header + "".join(print_kernel(kernel) for kernel in kernels) + functions


def _tuple(names: Iterable[str]) -> str:
    return "(" + "".join(f'"{name}", ' for name in names).rstrip() + ")"


def index_module(schemes: Iterable[Scheme]) -> str:
    """Text of generated/substep_kernels/index.py: names, parameters and members as literals."""
    lines = ["{"]
    for scheme in schemes:
        described: dict[str, Any] = {
            "module": scheme.parent or scheme.name,
            "parameters": tuple(_describe(p) for p in scheme.parameters),
            "fixed": {name: float(value) for name, value in scheme.fixed.items()},
            "balances": len(scheme.balances),
            "loads": Amplification.of(scheme).load_N.cols,
            "state": tuple(state_label(s) for s in scheme.state),
            "reference": scheme.reference,
        }
        lines += [f'    "{scheme.name}": {{', *(f'        "{k}": {v!r},' for k, v in described.items()), "    },"]
    text = fill(templates.INDEX, schemes="\n".join([*lines, "}"]))
    return (
        fill(templates.BANNER, source="substep_derive.schemes", digest=hashlib.sha256(text.encode()).hexdigest()) + text
    )


def _bound(end: Expr) -> float | None:
    return float(end) if end.is_finite else None


def _describe(parameter: Parameter) -> tuple[str, float | None, float | None, bool, bool, float]:
    """(name, low, high, low excluded, high excluded, default); None: unbounded."""
    domain = parameter.domain
    return (
        parameter.name,
        _bound(domain.start),
        _bound(domain.end),
        bool(domain.left_open),
        bool(domain.right_open),
        float(parameter.default),
    )


def package(schemes: Iterable[Scheme]) -> dict[str, str]:
    """File name -> text of everything in generated/substep_kernels/."""
    schemes = tuple(schemes)
    files = {"__init__.py": '"""Generated by `make derive`: kernels of every scheme. Do not edit."""\n'}
    files["index.py"] = index_module(schemes)
    source = hashlib.sha256(templates.LINEAR_MARCH.encode()).hexdigest()
    files["linear_march.py"] = (
        fill(templates.BANNER, source="substep_derive.templates", digest=source) + templates.LINEAR_MARCH
    )
    for scheme in schemes:
        if scheme.parent is None:
            files[f"{scheme.name}.py"] = scheme_module(
                scheme, f"the declaration of {scheme.name} in substep_derive.schemes"
            )
    return files
