"""polynomials.h for stability.c: a scheme's polynomials from its derivation, and those of log and atan."""

import ast
from collections.abc import Iterator
from typing import Any

from mpmath import atan, atanh, chebyfit, mp, sqrt
from substep_derive import derive
from substep_derive.algebra.rational import cse
from substep_derive.emit.eigenvalue_defect import defect_lines
from substep_derive.emit.stability_module import AT_EXACT, SMALL_OMEGA
from substep_derive.kernels.kernel import Kernel
from substep_derive.kernels.scheme import SchemeKernels
from sympy.printing.c import C99CodePrinter

LOG_TERMS, ATAN_TERMS = 8, 12  # the fewest that reach the last digit
LOG_END, ATAN_END = (mp.sqrt(2) - 1) ** 2 / (mp.sqrt(2) + 1) ** 2, mp.tan(mp.pi / 8) ** 2


class _VectorPrinter(C99CodePrinter):
    """C99 with powers as products: GCC's vectors know no pow."""

    def _print_Pow(self, expr: Any) -> str:
        base, exponent = expr.as_base_exp()
        if not exponent.is_Integer or exponent < 2:
            raise ValueError(f"expected a polynomial, got {expr}")
        return "(" + "*".join([f"({self._print(base)})"] * int(exponent)) + ")"


def header(scheme: str) -> str:
    """C text: EIGENVALUES, polynomials(), the coefficients stability.c wants, and residual() at the exact eigenvalue.

    Raises ValueError for a scheme with other than two or three live eigenvalues.
    """
    kernels = SchemeKernels.of(derive(scheme).scheme)
    by_name = {kernel.name: kernel for kernel in kernels.stability}
    count = 2 if "_quadratic" in by_name else 3
    polynomials = by_name.get("_quadratic") or by_name.get("_cubic")
    if polynomials is None:
        raise ValueError(f"expected two or three live eigenvalues, got more of {scheme}")
    return "\n".join(
        [
            f"#define INPUTS {len(polynomials.arguments)}",
            f"#define EIGENVALUES {count}",
            f"#define SMALL_OMEGA {SMALL_OMEGA}",
            _table("LOG", LOG_TERMS, lambda z: 2 * atanh(sqrt(z)) / sqrt(z) if z else mp.mpf(2), LOG_END),
            _table("ATAN", ATAN_TERMS, lambda z: atan(sqrt(z)) / sqrt(z) if z else mp.mpf(1), ATAN_END),
            "INLINE void polynomials(const vec *v, vec *out) {",
            *(f"    {line}" for line in _kernel(polynomials, "v")),
            *(f"    out[{i}] = {name};" for i, (name, _) in enumerate(polynomials.outputs)),
            "}",
            "INLINE void residual(const vec *in, vec *out) {",
            *(f"    {line}" for line in _residual(kernels, by_name["_defect"])),
            "}\n",
        ]
    )


def _kernel(kernel: Kernel, inputs: str) -> Iterator[str]:
    """C lines that declare the outputs of a kernel, which is printed for substep too, from an array of its inputs."""
    common, expressions = cse([e for _, e in kernel.outputs])
    outputs = zip((name for name, _ in kernel.outputs), expressions, strict=True)
    printer = _VectorPrinter()
    yield from (f"vec {symbol} = {inputs}[{i}];" for i, symbol in enumerate(kernel.arguments))
    for name, e in (*(kernel.first or ()), *common, *outputs):
        yield f"vec {name} = all(0.0) + ({printer.doprint(e)});"


def _residual(kernels: SchemeKernels, defect: Kernel) -> Iterator[str]:
    """C lines of the kernel `_defect`, and of the text that substep's `defect` is printed from."""
    yield from _kernel(defect, "in")
    declared = {name for name, _ in defect.outputs}
    for line in defect_lines(kernels.defect, SMALL_OMEGA):
        yield from _translated(ast.parse(line), declared)
    yield from (f"out[{i}] = {value};" for i, value in enumerate(AT_EXACT[1]))


def _translated(line: ast.Module, declared: set[str]) -> Iterator[str]:
    """C text of a line of Python that assigns sums and products; new names are added to `declared`."""
    for statement in line.body:
        match statement:
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                targets = [ast.unparse(name) for name in names]
                yield from (f"vec {name};" for name in targets if name not in declared)
                declared.update(targets)
                found = (f"vec new_{i} = all(0.0) + ({ast.unparse(value)});" for i, value in enumerate(values))
                kept = (f"{name} = new_{i};" for i, name in enumerate(targets))
                yield f"{{ {' '.join([*found, *kept])} }}"  # all values are computed before a name changes
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                yield f"vec {name} = {ast.unparse(value)};"
            case _:
                yield f"{ast.unparse(statement)};"


def _table(name: str, terms: int, function: Any, end: Any) -> str:
    """Coefficients of the polynomial nearest to a function of the square, on [0, end], lowest first."""
    with mp.workdps(40):
        found = reversed(chebyfit(function, [0, end], terms))
        numbers = ", ".join(mp.nstr(c, 20) for c in found)
    return f"#define {name}_TERMS {terms}\nstatic const double {name}_POLYNOMIAL[] = {{{numbers}}};"
