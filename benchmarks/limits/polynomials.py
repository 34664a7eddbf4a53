"""polynomials.h for stability.c: a scheme's polynomials from its derivation, and those of log and atan."""

import ast
from collections.abc import Iterator, Mapping
from typing import Any

from mpmath import atan, atanh, chebyfit, mp, sqrt
from substep_derive import derive
from substep_derive.algebra.rational import cse, horner
from substep_derive.declare.scheme import Scheme
from substep_derive.emit.eigenvalue_defect import defect_lines
from substep_derive.emit.stability import SMALL_OMEGA
from substep_derive.kernels.kernel import Kernel
from substep_derive.kernels.scheme import SchemeKernels
from substep_derive.oscillator.spectrum import live
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
    derivation = derive(scheme)
    coefficients = live(derivation.charpoly).all_coeffs()
    count = len(coefficients) - 1
    if count == 2:
        c2, minus_trace, det = coefficients
        outputs = {"c2": c2, "p": c2 + minus_trace + det, "q": c2 - det, "det": det}
        lines = _quadratic(derivation.scheme)
        with_trace = ["INLINE void polynomials_with_trace(const vec *v, vec *out) {", *(f"    {x}" for x in lines), "}"]
    elif count == 3:
        c3, c2, c1, c0 = coefficients
        outputs = {"c3": c3, "c2": c2, "c1": c1, "c0": c0, "p": c3 + c2 + c1 + c0, "q": 3 * c3 + 2 * c2 + c1}
        with_trace = []
    else:
        raise ValueError(f"expected two or three live eigenvalues, got {count} of {scheme}")
    return "\n".join(
        [
            f"#define INPUTS {len(derivation.symbols)}",
            f"#define EIGENVALUES {count}",
            f"#define SMALL_OMEGA {SMALL_OMEGA}",
            _table("LOG", LOG_TERMS, lambda z: 2 * atanh(sqrt(z)) / sqrt(z) if z else mp.mpf(2), LOG_END),
            _table("ATAN", ATAN_TERMS, lambda z: atan(sqrt(z)) / sqrt(z) if z else mp.mpf(1), ATAN_END),
            "INLINE void polynomials(const vec *v, vec *out) {",
            *(f"    {line}" for line in _polynomials(derivation.symbols, outputs)),
            "}",
            *with_trace,
            "INLINE void residual(const vec *in, vec *out) {",
            *(f"    {line}" for line in _residual(derivation.scheme)),
            "}\n",
        ]
    )


def _polynomials(symbols: Mapping[str, Any], outputs: dict[str, Any]) -> Iterator[str]:
    """C lines of polynomials in Omega, which share their common terms, into out."""
    common, expressions = cse([horner(e, symbols["Omega"]) for e in outputs.values()])
    printer = _VectorPrinter()
    yield from (f"vec {symbol} = v[{i}];" for i, symbol in enumerate(symbols))
    yield from (f"vec {symbol} = all(0.0) + ({printer.doprint(e)});" for symbol, e in common)
    for i, (name, e) in enumerate(zip(outputs, expressions, strict=True)):
        yield f"out[{i}] = all(0.0) + ({printer.doprint(e)});  // {name}"


def _quadratic(scheme: Scheme) -> Iterator[str]:
    """C lines of the kernel `_quadratic`, which is printed for substep too, into out."""
    yield from _kernel(scheme, "_quadratic", "v")
    names = [name for name, _ in _named(scheme, "_quadratic").outputs]
    yield from (f"out[{i}] = {name};" for i, name in enumerate(names))


def _named(scheme: Scheme, name: str) -> Kernel:
    return next(k for k in SchemeKernels.of(scheme).stability if k.name == name)


def _kernel(scheme: Scheme, name: str, inputs: str) -> Iterator[str]:
    """C lines that declare the outputs of a kernel, from an array of its inputs."""
    kernel = _named(scheme, name)
    common, expressions = cse([e for _, e in kernel.outputs])
    outputs = zip((name for name, _ in kernel.outputs), expressions, strict=True)
    printer = _VectorPrinter()
    yield from (f"vec {symbol} = {inputs}[{i}];" for i, symbol in enumerate(kernel.arguments))
    for output, e in (*(kernel.first or ()), *common, *outputs):
        yield f"vec {output} = all(0.0) + ({printer.doprint(e)});"


def _residual(scheme: Scheme) -> Iterator[str]:
    """C lines of the kernel `_defect` and of the text that substep's `_polynomial_at_exact` is printed from."""
    yield from _kernel(scheme, "_defect", "in")
    declared = {name for name, _ in _named(scheme, "_defect").outputs}
    for line in defect_lines(SchemeKernels.of(scheme).defect, SMALL_OMEGA):
        yield from _translated(ast.parse(line), declared)


def _translated(line: ast.Module, declared: set[str]) -> Iterator[str]:
    """C text of a line of Python that assigns or returns sums and products; new names are added to `declared`."""
    for statement in line.body:
        match statement:
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Call(args=[y, z, ast.Tuple(elts=constants)])):
                targets = [ast.unparse(name) for name in names]
                yield from (f"vec {name};" for name in targets if name not in declared)
                table = ", ".join(map(ast.unparse, constants))
                pointers = ", ".join(f"&{name}" for name in targets)
                size = len(constants)
                yield f"in_square({pointers}, {ast.unparse(y)}, {ast.unparse(z)}, (const double[]){{{table}}}, {size});"
                declared.update(targets)
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                for name, value in zip(names, values, strict=True):
                    yield f"vec {ast.unparse(name)} = all(0.0) + ({ast.unparse(value)});"
                    declared.add(ast.unparse(name))
            case ast.Return(value=ast.Tuple(elts=values)):
                yield from (f"out[{i}] = {ast.unparse(value)};" for i, value in enumerate(values))
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
