"""SchemeKernels -> text of a module's stability polynomials; EigenvalueKind -> text of the module that solves them.

A scheme's module stores the coefficients of its polynomials, at the points of a block. What follows from them does not
depend on the scheme but for the number of live eigenvalues, so that it is printed, and compiled, once for all schemes.
"""

from collections.abc import Iterable, Sequence
from textwrap import wrap

from sympy import Symbol, count_ops

from ..algebra import rational
from ..kernels.eigenvalue_kind import EigenvalueKind
from ..kernels.kernel import Kernel
from ..kernels.scheme import SchemeKernels
from .eigenvalue_defect import defect_lines
from .many_eigenvalues import coefficient_names, more_eigenvalues
from .printing import PointPrinter, fill, placed
from .templates.decorators import COMPILE, INLINE, INNER
from .templates.eigenvalues import SIZES, STABILITY, THREE_EIGENVALUES, TWO_EIGENVALUES
from .templates.elementary import ANGLE, CALL, CALL_IMPORTS, LOG1P, POINTWISE, REFUSED
from .templates.stability import BLOCK_KERNEL, ERRORS, POLYNOMIALS

NJIT = "from numba import njit\n"
SMALL_OMEGA = 0.125  # below: exact eigenvalue plus its defect; above: direct formulas
BLOCK = 512  # points of a block: its rows stay in the caches


def polynomials(kernels: SchemeKernels) -> str:
    """Text of `polynomial` and `defect` of a scheme's module."""
    polynomial, asymmetry, defect = kernels.stability
    kind, names = kernels.kind, [name for name, _ in polynomial.outputs]
    lines, operations = _assignments(polynomial)
    conserved, more = _assignments(asymmetry)
    lines, values = [*lines, *conserved, _conservative(asymmetry)], names
    inputs = kernels.arguments
    if kind.roots > 3 or kind.twice:
        names = coefficient_names(kind)
        inputs += polynomial.arguments[:2] if kind.twice else ()
        values = [f"b{name[1:]} if near else {name}" for name in names]
        lines.append(f"near = Omega * (xi if xi > 1.0 else 1.0) < {SMALL_OMEGA}")
    doc = f"conservative: 1 where the polynomial, or it over lambda{'^2' if kind.twice else ''}, reads the same"
    doc = f"{polynomial.docstring} {doc} backwards, so that pairs are on the unit circle, else 0."
    outputs, results = ["conservative", *names], ["conservative", *values]
    text = fill(POLYNOMIALS, block=BLOCK, eigenvalues=kind.name)
    text += _kernel("polynomial", inputs, lines, outputs, results, doc, operations + more)
    lines, operations = _assignments(defect)
    lines += defect_lines(kernels.defect, SMALL_OMEGA)
    return text + _kernel("defect", kernels.arguments, lines, *AT_EXACT, defect.docstring + _AT_EXACT_DOC, operations)


# what `defect` stores, and the texts of these values
AT_EXACT = (
    ("p0", "p1", "x", "y", "leading"),
    ("p0 - xi * p1", "p1", "Omega * (a1_1 - xi * b1_1)", "Omega * b1_1", "leading"),
)
_AT_EXACT_DOC = (
    " The polynomial in tau = 2 (lambda - 1)/(lambda + 1) has the value Omega^3 (p0 + i r p1) at the exact eigenvalue "
    "e^s, where r = sqrt(1 - xi^2) and tau = x + i r y; s = Omega zeta, where zeta^2 = -2 xi zeta - 1. aj_n + bj_n "
    "zeta is the power series of tau^j from s^n on, divided by Omega^n."
)


def eigenvalues_module(kind: EigenvalueKind) -> str:
    """Text of the module that finds the eigenvalues of a kind, without its banner."""
    if kind.twice or kind.roots > 3:
        begin = _begin(CALL_IMPORTS)
        return more_eigenvalues(kind, SMALL_OMEGA, _sizes, compile=begin, call=fill(CALL), angle=fill(ANGLE))
    if kind.roots == 2:
        return fill(TWO_EIGENVALUES, compile=_begin(NJIT), sizes=_sizes(6, 4, 0, False))
    return fill(THREE_EIGENVALUES, compile=_begin(NJIT), sizes=_sizes(7, 6, 1, False))


def _begin(imports: str) -> str:
    return fill(POINTWISE, block=BLOCK, imports=imports) + INNER + INLINE


def _sizes(rows: int, found: int, others: int, conjugates: bool) -> str:
    return fill(SIZES, rows=rows, found=found, others=others, conjugates=int(conjugates))


def stability_module() -> str:
    """Text of the module of the function that stores what is known of eigenvalues, without its banner."""
    parts = {"compile": _begin(CALL_IMPORTS), "stored": COMPILE, "call": fill(CALL), "refused": fill(REFUSED)}
    return fill(STABILITY, **parts, small_Omega=SMALL_OMEGA)


def errors_module() -> str:
    """Text of the module that computes damping and period error from eigenvalues, without its banner."""
    return fill(ERRORS, compile=_begin(NJIT), log1p=fill(LOG1P), angle=fill(ANGLE), small_Omega=SMALL_OMEGA)


def _assignments(kernel: Kernel) -> tuple[list[str], int]:
    """Lines that assign common subexpressions, then the outputs; and their operations."""
    subexpressions, outputs = rational.cse([e for _, e in kernel.outputs])
    named = [*kernel.first, *subexpressions, *zip((name for name, _ in kernel.outputs), outputs, strict=True)]
    w = PointPrinter({"fully_qualified_modules": False})
    return [f"{name} = {w.doprint(e)}" for name, e in named], sum(int(count_ops(e)) for _, e in named)


def _conservative(asymmetry: Kernel) -> str:
    """Line that says whether complex pairs can only be on the unit circle."""
    kinds = ([f"abs({name})" for name, _ in asymmetry.outputs if name[0] == kind] for kind in "wy")
    zero = " or ".join(f"{' + '.join(names)} == 0.0" for names in kinds if names)
    return f"conservative = 1.0 if xi == 0.0 and ({zero}) else 0.0"


def _kernel(
    name: str,
    inputs: Sequence[Symbol],
    lines: Iterable[str],
    outputs: Sequence[str],
    values: Sequence[str],
    docstring: str,
    operations: int,
) -> str:
    """Text of a kernel whose lines are done at each point of a block; rows of its inputs and of its outputs."""
    rows = [f"row_{k}" for k, _ in enumerate(inputs)]  # read before the loop, in which they do not change
    read = [f"{s} = {row}[i]" for s, row in zip(inputs, rows, strict=True)]
    stored = [f"{_row(k)} = {value}" for k, value in enumerate(values)]
    return fill(
        BLOCK_KERNEL,
        name=name,
        outputs=", ".join(outputs),
        operations=operations,
        docstring=placed(wrap(docstring, 110), 1),
        inputs=", ".join(map(str, inputs)),
        rows=", ".join(rows),
        points=", ".join(f"points[{k}]" for k in range(len(rows))),
        body=placed([*read, *lines, *stored], 2),
    )


def _row(k: int) -> str:
    return ("rows[i]", "rows[BLOCK + i]")[k] if k < 2 else f"rows[{k} * BLOCK + i]"
