"""MarchForm -> text of the functions that compute a scheme's march coefficients, block by block of lanes."""

from collections.abc import Sequence
from itertools import product
from textwrap import indent
from typing import Any

from . import algebra, templates_march
from .double_double import DoubleDouble
from .emit_march import WIDTH, loads_for, shape_name
from .march_form import MarchForm
from .printing import PRINTER, fill
from .symbols import Omega


def coefficient_functions(form: MarchForm, arguments: Sequence[str]) -> str:
    """Text of `coefficients` of a scheme whose functions take these arguments."""
    m, R, K = form.step.N.rows, form.outputs.N.rows, loads_for(len(form.stencil))
    sizes = {"D": (m, m), "B": (m, K), "O": (R, m), "P": (R, K)}
    entries = [f"{name}{i}{j}" for name, size in sizes.items() for i, j in product(*map(range, size))]
    rows = [*arguments, *entries]

    def at(names: Sequence[str]) -> str:
        return ", ".join(f"s[{rows.index(name) * WIDTH} + j]" if rows.index(name) else "s[j]" for name in names)

    return fill(templates_march.PAIRS) + fill(
        templates_march.COEFFICIENTS,
        told=", ".join(arguments),
        width=WIDTH,
        arguments=", ".join(arguments),
        at_arguments=at(arguments),
        arguments_at=", ".join(f"{name}[first + j]" for name in arguments),
        lines=indent("\n".join([*_increment(form), *_others(form, K)]), " " * 8),
        entries=", ".join(entries),
        at_entries=at(entries),
        march=shape_name(form.shape),
        K=K,
        rows=len(entries),
        all_rows=len(rows),
        given=len(arguments),
    )


def _increment(form: MarchForm) -> list[str]:
    pairs, N = DoubleDouble(), form.increment
    numerators = {f"{i}{j}": N[i, j] for i, j in product(range(N.rows), repeat=2)}
    nested = [(f"N{place}", algebra.horner(e, Omega)) for place, e in numerators.items()]
    pairs.assign([("den", algebra.horner(form.step.den, Omega)), *nested])
    return [
        *pairs.lines,
        *(f"D{place} = _over({pairs.pair(f'N{place}')}, {pairs.pair('den')})" for place in numerators),
    ]


def _others(form: MarchForm, K: int) -> list[str]:
    """B, O and P, whose rounding does not add up."""
    parts = [("B", form.step.load_N, "den"), ("O", form.outputs.N, "den_o"), ("P", form.outputs.load_N, "den_o")]
    named: list[tuple[str, Any, str]] = []
    if form.outputs.N.rows:
        named.append(("den_o", form.outputs.den, ""))
    for name, matrix, den in parts:
        named += [(f"{name}{i}{j}", matrix[i, j], den) for i, j in product(range(matrix.rows), range(matrix.cols))]
    subexpressions, expressions = algebra.cse([algebra.horner(e, Omega) for _, e, _ in named])
    lines = [f"{s} = {PRINTER.doprint(e)}" for s, e in subexpressions]
    for (name, _, den), e in zip(named, expressions, strict=True):
        lines.append(f"{name} = ({PRINTER.doprint(e)}) / {den}" if den and e != 0 else f"{name} = {PRINTER.doprint(e)}")
    beyond = [
        (name, i, j)
        for name, matrix, _ in parts
        if name != "O"
        for i in range(matrix.rows)
        for j in range(matrix.cols, K)
    ]
    return [*lines, *(f"{name}{i}{j} = 0.0" for name, i, j in beyond)]
