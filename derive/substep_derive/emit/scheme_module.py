"""SchemeKernels -> text of a module. The text depends on the declarations alone, byte for byte."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from textwrap import indent, wrap

from sympy import Expr, Integer, Symbol, count_ops, eye, factor

from ..algebra import rational
from ..algebra.constant import approximated
from ..declare.digest import scheme_digest
from ..declare.names import entry_name
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, state_label, xi
from ..kernels.kernel import Kernel, entries, nested
from ..kernels.march_shape import loads_for, shape_name
from ..kernels.scheme import SchemeKernels
from ..motion.effective import EffectiveSystem
from ..oscillator.one_rule import OneRule
from ..oscillator.stability_polynomial import rate
from .coefficients import coefficient_functions
from .index import index_entry
from .printing import PRINTER, decimal, docstring, fill, literal_tuple
from .rule_lines import increment_lines
from .stability import stability_functions
from .templates.elementary import ELEMENTARY
from .templates.one_rule import INCREMENT, ONE_RULE
from .templates.scheme import BANNER, SCHEME_FUNCTIONS, SCHEME_HEADER, START


def print_kernel(kernel: Kernel) -> str:
    """One jitted scalar function: common subexpressions, then the named outputs."""
    subexpressions, outputs = rational.cse([e for _, e in kernel.outputs])
    subexpressions = [*(kernel.first or ()), *subexpressions]
    operations = sum(int(count_ops(e)) for e in (*(e for _, e in subexpressions), *outputs))
    lines = [f"{name} = {PRINTER.doprint(e)}" for name, e in subexpressions]
    lines += [f"{name} = {PRINTER.doprint(e)}" for (name, _), e in zip(kernel.outputs, outputs, strict=True)]
    body = indent("\n".join(lines), "    ")
    arguments = ", ".join(a.name for a in kernel.arguments)
    returned = ", ".join(name for name, _ in kernel.outputs)
    return (
        f"\n\n@{'_exact' if kernel.first is None else '_inline'}\ndef {kernel.name}({arguments}):\n"
        f'    """{kernel.docstring} {operations} operations."""\n{body}\n    return {returned}\n'
    )


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
    lines = relations(scheme, kernels.systems)
    if kernels.rule is None:
        labels = [state_label(s) for s in scheme.state]
        lines += [
            "",
            f"Amplification matrix N/den in ({', '.join(labels)}):",
            f"    den = {decimal(nested(step.den, Omega))}",
        ]
        lines += [f"    {name} = {decimal(nested(e, Omega))}" for name, e in entries("N_", step.N)]
    else:
        lines += _rule(kernels.rule, kernels.form.stencil)
    wrapped = (wrap(line, 110, subsequent_indent=" " * 8, break_long_words=False) or [""] for line in lines)
    return "\n".join(part for line in wrapped for part in line)


def _rule(rule: OneRule, stencil: Sequence[Expr]) -> list[str]:
    """R and S of a step."""

    def text(coefficients: Sequence[Expr]) -> str:
        return str(sum((factor(c) * rate**k for k, c in enumerate(coefficients)), Integer(0)))

    lines = [
        "",
        "Step (u_1, h v_1) = R(L) (u_0, h v_0) + S_0(L) (0, c) + sum of S(L) (0, h^2 f), of the loads at all instants,",
        "with L = [[0, 1], [-Omega^2, -2 xi Omega]], c = h^2 (a_0 + 2 xi omega v_0 + omega^2 u_0), as functions of s:",
        f"    Q = {text(rule.den)}",
        f"    R = ({text(rule.numerator)})/Q",
    ]
    for k, ((S, scale), tau) in enumerate(zip(rule.loads, stencil, strict=True)):
        over = "Q" if scale == 1 else f"({factor(scale)})/Q"
        lines.append(f"    S_{k} = ({text(S)})/{over}{f' of f({tau})' if k else ''}")
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
    """Text of generated/substep_kernels/<name>.py."""
    scheme, form, amplification = kernels.scheme, kernels.form, kernels.amplification
    names = {kernel.name: [name for name, _ in kernel.outputs] for kernel in kernels.matrices}
    m = len(scheme.state)
    own = [name for name, _ in entries("D_", eye(m))]
    arguments = [Omega.name, xi.name, *(p.name for p in scheme.parameters)]
    at_i = {p.symbol: Symbol(f"{p.name}[i]") for p in scheme.parameters}
    typed = {"arguments": ", ".join(arguments), "arguments_i": ", ".join(f"{a}[i]" for a in arguments)}
    parts = [
        fill(BANNER, source=source, digest=scheme_digest(scheme)),
        fill(
            SCHEME_HEADER,
            title=f"{scheme.name}: stability functions and march coefficients.",
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
        fill(ELEMENTARY),
        _increment(kernels.rule, arguments, own) if kernels.rule else "",
        *(print_kernel(kernel) for kernel in (*kernels.matrices, *kernels.stability)),
        stability_functions(kernels, arguments),
        fill(
            SCHEME_FUNCTIONS,
            **typed,
            m=m,
            K=len(form.stencil),
            store_amplification=_stores("out", "D_", m, m, identity=True, over="" if kernels.rule else " / den"),
            increment_names=_assigned(names.get("_increment", own)),
            store_stencil="\n".join(
                f"        out[i, {k}] = {PRINTER.doprint(approximated(tau).subs(at_i))}"
                for k, tau in enumerate(form.stencil)
            ),
            parameters_comma="".join(f"{p.name}, " for p in scheme.parameters),
        ),
        coefficient_functions(kernels, arguments),
    ]
    if "_start" in names:
        K = len(amplification.start_stencil)
        stores = "\n".join(part for part in (_stores("given", "S_", m, 3), _stores("load", "T_", m, K)) if part)
        parts.append(fill(START, **typed, m=m, K=K, start_names=_assigned(names["_start"]), store_start=stores))
    return "".join(parts)


def _increment(rule: OneRule, arguments: Sequence[str], names: Sequence[str]) -> str:
    lines = indent("\n".join(increment_lines(rule)), "    ")
    return fill(ONE_RULE) + fill(INCREMENT, arguments=", ".join(arguments), lines=lines, names=", ".join(names))


def _stores(target: str, name: str, rows: int, columns: int, *, identity: bool = False, over: str = " / den") -> str:
    """Lines that store entries over their denominator, or the identity plus these, in the array target."""
    return "\n".join(
        f"        {target}[i, {j}, {k}] = {'1.0 + ' if identity and j == k else ''}{entry_name(name, j, k)}{over}"
        for j, k in product(range(rows), range(columns))
    )


def _assigned(names: Sequence[str]) -> str:
    """The names as the left side of an assignment, over several lines if need be."""
    lines = wrap(", ".join(names), 100)
    return lines[0] if len(lines) == 1 else "(\n            " + "\n            ".join(lines) + "\n        )"


def own_module(scheme: Scheme) -> str:
    """Text of a module for a scheme of the user's own: as a committed one, with its index entry as ENTRY."""
    kernels = SchemeKernels.of(scheme)
    entry = "\n".join(f"    {line}" for line in index_entry(kernels.form, own=True))
    return f"{scheme_module(kernels, f'the declaration of {scheme.name}')}\n\nENTRY = {{\n{entry}\n}}\n"
