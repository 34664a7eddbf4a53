"""SchemeKernels -> text of a module. The text depends on the declarations alone, byte for byte."""

from collections.abc import Iterable, Mapping, Sequence
from textwrap import wrap

from sympy import Expr, Integer, Symbol, factor

from ..declare.digest import scheme_digest
from ..declare.names import printed
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, state_label
from ..kernels.kernel import entries, nested
from ..kernels.march_shape import loads_for, shape_name
from ..kernels.scheme import SchemeKernels
from ..motion.effective import EffectiveSystem
from ..oscillator.one_rule import OneRule
from ..oscillator.stability_polynomial import rate
from .formulas import formulas
from .index import index_entry
from .printing import decimal, docstring, fill, literal_tuple
from .stability_module import polynomials
from .templates.scheme import BANNER, SCHEME_HEADER


def relations(scheme: Scheme, systems: Iterable[EffectiveSystem]) -> list[str]:
    """Relations, balances and effective stiffness as a paper has them, line by line."""
    shown = [s for s in (scheme.constant,) if s is not None]
    lines = [part for s in shown for part in (f"Constant: {s.definition}.", "")]
    lines += ["Relations and balances:"]
    lines += [f"    {symbol} = {expression}" for symbol, expression in scheme.relations.items()]
    lines += [f"    M*({b.inertia}) + C*({b.damping}) + {b.force} = {b.load}" for b in scheme.balances]
    lines += _start(scheme)
    lines += ["", "Effective stiffness of each balance and its unknown:"]
    return lines + [f"    {e.unknown}: {e.effective_stiffness}" for e in systems]


def relations_and_amplification(kernels: SchemeKernels) -> str:
    """`relations`, and A as a paper has it, for the module's docstring."""
    scheme, step = kernels.scheme, kernels.amplification.step
    declared = {printed(s): s for s in scheme.values}
    lines = relations(scheme, kernels.systems)
    if kernels.rule is None:
        labels = [state_label(s) for s in scheme.state]
        lines += [
            "",
            f"Amplification matrix N/den in ({', '.join(labels)}):",
            f"    den = {decimal(nested(step.den.xreplace(declared), Omega))}",
        ]
        lines += [f"    {name} = {decimal(nested(e, Omega))}" for name, e in entries("N_", step.N.xreplace(declared))]
    else:
        lines += _rule(kernels.rule, kernels.form.stencil, declared)
    wrapped = (wrap(line, 110, subsequent_indent=" " * 8, break_long_words=False) or [""] for line in lines)
    return "\n".join(part for line in wrapped for part in line)


def _rule(rule: OneRule, stencil: Sequence[Expr], declared: Mapping[Symbol, Symbol]) -> list[str]:
    """R and S of a step."""

    def text(coefficients: Sequence[Expr]) -> str:
        return str(sum((factor(c.xreplace(declared)) * rate**k for k, c in enumerate(coefficients)), Integer(0)))

    lines = [
        "",
        "Step (u_1, h v_1) = R(L) (u_0, h v_0) + S_0(L) (0, c) + sum of S(L) (0, h^2 f), of the loads at all instants,",
        "with L = [[0, 1], [-Omega^2, -2 xi Omega]], c = h^2 (a_0 + 2 xi omega v_0 + omega^2 u_0), as functions of s:",
        f"    Q = {text(rule.den)}",
        f"    R = ({text(rule.numerator)})/Q",
    ]
    for k, ((S, scale), tau) in enumerate(zip(rule.loads, stencil, strict=True)):
        over = "Q" if scale == 1 else f"({factor(scale.xreplace(declared))})/Q"
        lines.append(f"    S_{k} = ({text(S)})/{over}{f' of f({tau.xreplace(declared)})' if k else ''}")
    return lines


def _start(scheme: Scheme) -> list[str]:
    """What the state at t = 0 is had from, where it is not just u_0, v_0 and a_0."""
    if (other := scheme.start_scheme) is not None:
        fixed = "".join(f", {name} = {value}" for name, value in other.fixed.items())
        steps = [f"    {symbol} = {e}" for symbol, e in other.relations.items()]
        steps += [f"    M*({b.inertia}) + C*({b.damping}) + {b.force} = {b.load}" for b in other.balances]
        return ["", f"First steps by {other.name}{fixed}:", *steps]
    assert isinstance(scheme.start, Mapping)
    return ["", "Start:", *(f"    {symbol} = {e}" for symbol, e in scheme.start.items())] if scheme.start else []


def scheme_module(kernels: SchemeKernels, source: str) -> str:
    """Text of generated/substep_kernels/schemes/<name>.py."""
    scheme, form, amplification = kernels.scheme, kernels.form, kernels.amplification
    arguments = [s.name for s in kernels.arguments]
    parts = [
        fill(BANNER, source=source, digest=scheme_digest(scheme)),
        fill(
            SCHEME_HEADER,
            title=f"{scheme.name}: stability polynomials and march coefficients.",
            reference=docstring(scheme.reference + "."),
            relations=docstring(relations_and_amplification(kernels)),
            name=scheme.name,
            state=literal_tuple(f'"{state_label(s)}"' for s in scheme.state),
            parameters=literal_tuple(f'"{p.name}"' for p in scheme.parameters),
            march=shape_name(form.shape),
            loads=loads_for(len(form.stencil)),
            kept=form.kept,
            filter_order=kernels.transfer.order if kernels.transfer else 0,
            carrier=form.carrier,
            start_stencil=literal_tuple(str(float(tau)) for tau in amplification.start_stencil),
        ),
        polynomials(kernels),
        formulas(kernels, arguments),
    ]
    return "".join(parts)


def own_module(scheme: Scheme) -> str:
    """Text of a module for a scheme of the user's own: as a committed one, with its index entry as ENTRY."""
    kernels = SchemeKernels.of(scheme)
    entry = "\n".join(f"    {line}" for line in index_entry(scheme, len(kernels.form.stencil), own=True))
    return f"{scheme_module(kernels, f'the declaration of {scheme.name}')}\n\nENTRY = {{\n{entry}\n}}\n"
