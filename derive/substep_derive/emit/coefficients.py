"""MarchForm and Transfer -> text of the functions that compute what a linear march needs, block by block of lanes."""

from collections.abc import Sequence
from itertools import product
from textwrap import indent
from typing import Any

from sympy import Expr, Integer

from ..algebra import rational
from ..declare.names import entry_name
from ..declare.symbols import Omega
from ..kernels.kernel import nested
from ..kernels.march_form import MarchForm
from ..kernels.march_shape import loads_for, shape_name
from ..kernels.scheme import SchemeKernels
from ..oscillator.transfer import Transfer
from .double_double import DoubleDouble
from .filter_module import filter_rows
from .march_module import WIDTH
from .printing import PRINTER, fill
from .rule_lines import coefficient_lines
from .templates.march import BY_BLOCKS, COEFFICIENTS, DOUBLE_DOUBLE, TRANSFER


def coefficient_functions(kernels: SchemeKernels, arguments: Sequence[str]) -> str:
    """Text of `coefficients` and, where there is one, `transfer` of a scheme whose functions take these arguments."""
    form, transfer, rule = kernels.form, kernels.transfer, kernels.rule
    m, R, K = form.step.N.rows, form.outputs.N.rows, loads_for(len(form.stencil))
    sizes = {"D": (m, m), "B": (m, K), "O": (R, m), "P": (R, K)}
    entries = [entry_name(name, i, j) for name, size in sizes.items() for i, j in product(*map(range, size))]
    doc = fill(COEFFICIENTS, march=shape_name(form.shape), K=K, rows=len(entries))
    text = fill(DOUBLE_DOUBLE)
    at_end = form.stencil.index(Integer(1)) if rule else 0
    lines = coefficient_lines(rule, at_end, K) if rule else [*_increment(form), *_others(form, K)]
    text += _by_blocks("coefficients", arguments, lines, entries, doc)
    if transfer is not None:
        rows = filter_rows(transfer.order)
        doc = fill(TRANSFER, rows=len(rows))
        text += _by_blocks("transfer", arguments, _filter(transfer), rows, doc)
    return text


def _by_blocks(name: str, arguments: Sequence[str], lines: Sequence[str], entries: Sequence[str], doc: str) -> str:
    rows = [*arguments, *entries]

    def at(names: Sequence[str]) -> str:
        return ", ".join(f"s[{rows.index(name) * WIDTH} + j]" if rows.index(name) else "s[j]" for name in names)

    return fill(
        BY_BLOCKS,
        name=name,
        doc=doc,
        width=WIDTH,
        arguments=", ".join(arguments),
        at_arguments=at(arguments),
        arguments_at=", ".join(f"{name}[first + j]" for name in arguments),
        lines=indent("\n".join(lines), " " * 8),
        entries=", ".join(entries),
        at_entries=at(entries),
        rows=len(entries),
        all_rows=len(rows),
        given=len(arguments),
    )


def _increment(form: MarchForm) -> list[str]:
    pairs, N = DoubleDouble(), form.increment
    places = list(product(range(N.rows), repeat=2))
    numerators = [(entry_name("N", *place), nested(N[place], Omega)) for place in places]
    pairs.assign([("den", nested(form.step.den, Omega)), *numerators])
    over = [(entry_name("D", *place), pairs.pair(entry_name("N", *place))) for place in places]
    return [*pairs.lines, *(f"{name} = _over({numerator}, {pairs.pair('den')})" for name, numerator in over)]


def _others(form: MarchForm, K: int) -> list[str]:
    """Lines for B, O and P in plain doubles: their rounding errors do not grow with the number of steps."""
    parts = (("B", form.step.load_N, "den"), ("O", form.outputs.N, "den_o"), ("P", form.outputs.load_N, "den_o"))
    named: list[tuple[str, Any, str]] = [("den_o", form.outputs.den, "")] if form.outputs.N.rows else []
    for name, matrix, den in parts:
        named += [
            (entry_name(name, i, j), matrix[i, j], den) for i, j in product(range(matrix.rows), range(matrix.cols))
        ]
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
