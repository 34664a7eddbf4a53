"""MarchForm, Transfer, A and the start -> text of functions that hold formulas, which are not compiled."""

from collections.abc import Iterable, Sequence
from itertools import product
from typing import Any

from sympy import Expr, Integer, Matrix, eye

from ..algebra import rational
from ..algebra.constant import approximated
from ..declare.names import entry_name
from ..declare.symbols import Omega
from ..kernels.kernel import entries, nested
from ..kernels.march_form import MarchForm
from ..kernels.march_shape import loads_for, shape_name
from ..kernels.scheme import SchemeKernels
from ..oscillator.transfer import Transfer
from .double_double import DoubleDouble
from .filter_module import filter_rows
from .printing import PRINTER, fill, wrapped
from .rule_lines import coefficient_lines, increment_lines
from .templates.formulas import AMPLIFICATION, COEFFICIENTS, FORMULAS, FUNCTION, START, STENCIL, TRANSFER

WIDTH = 128  # points of a block, whose rows fit the second cache


def formulas_module() -> str:
    """Text of the module that evaluates formulas, without its banner."""
    return fill(FORMULAS, width=WIDTH)


def formulas(kernels: SchemeKernels, arguments: Sequence[str]) -> str:
    """Text of the functions that hold formulas of a scheme; arguments: Omega, xi and the parameters."""
    form, transfer = kernels.form, kernels.transfer
    m, start, parameters = len(form.scheme.state), kernels.amplification.start, arguments[2:]
    text = _amplification(kernels, arguments)
    instants = [PRINTER.doprint(approximated(tau)) for tau in form.stencil]
    text += _function("stencil", fill(STENCIL), parameters, [], instants)
    text += _coefficients(kernels, arguments)
    if transfer is not None:
        text += _function("transfer", fill(TRANSFER), arguments, _filter(transfer), filter_rows(transfer.order))
    if start is not None:
        K = start.load_N.cols
        named = [("den", start.den, ""), *_named("S", start.N, "den"), *_named("T", start.load_N, "den")]
        doc = fill(START, m=m, K=K)
        text += _function("start", doc, arguments, _fractions(named), [name for name, _, _ in named[1:]])
    return text


def _function(name: str, doc: str, arguments: Sequence[str], lines: Iterable[str], returned: Sequence[str]) -> str:
    """Text of a function of the arguments that holds formulas; what it returns has the names or texts given."""
    return fill(
        FUNCTION,
        name=name,
        doc=doc,
        arguments=", ".join(["by", *arguments]),
        lines="".join(f"    {line}\n" for line in lines),
        returned=wrapped(returned),
    )


def _amplification(kernels: SchemeKernels, arguments: Sequence[str]) -> str:
    step = kernels.amplification.step
    m = step.N.rows
    if kernels.rule:
        lines = increment_lines(kernels.rule)
    else:
        increment = step.N - step.den * eye(m)
        lines = _fractions([("den", step.den, ""), *_named("D_", increment, "den")])
    entries = [(i == j, entry_name("D_", i, j)) for i, j in product(range(m), repeat=2)]
    returned = [f"1.0 + {name}" if diagonal else name for diagonal, name in entries]
    return _function("amplification", fill(AMPLIFICATION, m=m), arguments, lines, returned)


def _coefficients(kernels: SchemeKernels, arguments: Sequence[str]) -> str:
    form, rule = kernels.form, kernels.rule
    m, R, K = form.step.N.rows, form.outputs.N.rows, loads_for(len(form.stencil))
    sizes = {"D": (m, m), "B": (m, K), "O": (R, m), "P": (R, K)}
    entries = [entry_name(name, i, j) for name, size in sizes.items() for i, j in product(*map(range, size))]
    at_end = form.stencil.index(Integer(1)) if rule else 0
    lines = coefficient_lines(rule, at_end, K) if rule else [*_increment(form), *_others(form, K)]
    return _function("coefficients", fill(COEFFICIENTS, march=shape_name(form.shape), K=K), arguments, lines, entries)


def _named(name: str, matrix: Matrix, den: str) -> list[tuple[str, Expr, str]]:
    """The entries of a matrix of numerators row by row: name, numerator, and the name of their denominator."""
    return [(entry, e, den) for entry, e in entries(name, matrix)]


def _increment(form: MarchForm) -> list[str]:
    pairs, N = DoubleDouble(), form.increment
    places = list(product(range(N.rows), repeat=2))
    numerators = [(entry_name("N", *place), nested(N[place], Omega)) for place in places]
    pairs.assign([("den", nested(form.step.den, Omega)), *numerators])
    over = [(entry_name("D", *place), pairs.pair(entry_name("N", *place))) for place in places]
    return [*pairs.lines, *(f"{name} = by.over({numerator}, {pairs.pair('den')})" for name, numerator in over)]


def _others(form: MarchForm, K: int) -> list[str]:
    """Lines for B, O and P in plain doubles: their rounding errors do not grow with the number of steps."""
    parts = (("B", form.step.load_N, "den"), ("O", form.outputs.N, "den_o"), ("P", form.outputs.load_N, "den_o"))
    named: list[tuple[str, Any, str]] = [("den_o", form.outputs.den, "")] if form.outputs.N.rows else []
    for name, matrix, den in parts:
        named += _named(name, matrix, den)
    beyond = [
        f"{entry_name(name, i, j)} = 0.0"
        for name, matrix, _ in (parts[0], parts[2])
        for i, j in product(range(matrix.rows), range(matrix.cols, K))
    ]
    return [*_fractions(named), *beyond]


def _filter(t: Transfer) -> list[str]:
    d = t.order
    named: list[tuple[str, Any, str]] = [("den", t.den, ""), ("whole", t.S, ""), ("P", t.P, "den")]
    named += [(f"g{i}", e, "den") for i, e in enumerate(t.g, start=1)]
    for kind, taps in zip("uva", t.k, strict=True):
        named += [(f"{kind}{i}", taps[i], "whole" if kind == "u" else "den") for i in range(d)]
    return [*_fractions(named), "S = whole / den"]


def _fractions(named: Sequence[tuple[str, Expr, str]]) -> list[str]:
    """Lines that assign each name its numerator over the denominator of that name, or the numerator alone."""
    subexpressions, expressions = rational.cse([nested(e, Omega) for _, e, _ in named])
    lines = [f"{s} = {PRINTER.doprint(e)}" for s, e in subexpressions]
    for (name, _, den), e in zip(named, expressions, strict=True):
        text = PRINTER.doprint(e)
        lines.append(
            f"{name} = ({text}) / {den}" if den and e != 0 else f"{name} = {float(e) if e.is_number else text}"
        )
    return lines
