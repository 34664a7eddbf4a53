"""SchemeKernels -> text of the stability functions of a module, chosen by the number of live eigenvalues alone."""

from collections.abc import Iterable, Iterator, Sequence
from textwrap import indent

from ..kernels.scheme import SchemeKernels
from .eigenvalue_defect import defect_lines
from .many_eigenvalues import MoreEigenvalues
from .printing import fill
from .templates.eigenvalues import THREE_EIGENVALUES, TWO_EIGENVALUES
from .templates.stability import MONIC, NEAR, PAIR, STABILITY

SMALL_OMEGA = 0.125  # below: exact eigenvalue plus its defect; above: direct formulas
BLOCK = 2048  # points of a block: its arrays stay in the second cache, and it is long beside starting its loops


def stability_functions(kernels: SchemeKernels, arguments: Sequence[str]) -> str:
    """Text that follows the kernels of a module; arguments: Omega, xi and the parameters."""
    degree = len(kernels.live) - 1
    names = {
        "arguments": ", ".join(arguments),
        "arguments_i": ", ".join(f"{a}[i]" for a in arguments),
    }
    blocks = {"arguments_slice": ", ".join(f"{a}[i:k]" for a in arguments), "block": BLOCK}
    no_xi = {"arguments_no_xi": ", ".join((arguments[0], *arguments[2:]))}
    before, taken, beside = "", 0, list[tuple[str, ...]]()  # rows that are prepared; the other eigenvalues' names
    if degree == 2:
        text = fill(TWO_EIGENVALUES, **names, **no_xi, size="c2" if kernels.positive else "abs(c2)")
    elif degree == 3:
        text = fill(THREE_EIGENVALUES, **names, **no_xi, **blocks)
        taken, beside = 6, [("third",)]
        before = fill(MONIC, arguments_i=names["arguments_i"], monic=_rows(range(taken)))
    else:
        more = MoreEigenvalues.of(kernels)
        text = more.text(arguments, {**names, **no_xi, **blocks}, SMALL_OMEGA)
        taken, beside = len(more.prepared), more.others("u", "v")
        before = f"\n    {more.find}({names['arguments']}, s)"
    beside_names = [name for eigenvalue in beside for name in eigenvalue]
    found = range(4 + len(beside_names))
    conjugates = kernels.factor is not None
    return "".join(
        [
            fill(
                PAIR,
                outputs=", ".join(kernels.defect.outputs),
                lines=_indented(defect_lines(kernels.defect, SMALL_OMEGA)),
            ),
            text,
            fill(
                NEAR,
                **names,
                more="".join(f", {name}" for name in beside_names),
                others=_indented(_others(beside, conjugates)),
                re=found.stop,
                im=found.stop + 1,
                kept_i=_rows(found[3:]),
                small_Omega=SMALL_OMEGA,
                size=max(found.stop + 2, taken),
                before=before,
                found_i=_rows(found),
                prepared_i=f", {_rows(range(taken))}" if taken else "",
            ),
            fill(STABILITY, arguments=names["arguments"], **blocks),
        ]
    )


def _rows(numbers: Iterable[int]) -> str:
    return ", ".join(f"s[{j}, i]" for j in numbers)


def _others(eigenvalues: Sequence[tuple[str, ...]], conjugates: bool) -> Iterator[str]:
    """Lines that multiply g0 + i g1 by the distances of the exact tau from the other n eigenvalues.

    Their product is (1 - tau/2)^n times that of e^s - lambda. eigenvalues: names of the real and imaginary part, or of
    a real one; conjugates: whether each stands for its conjugate too.
    """
    if eigenvalues:
        yield "e0, e1, d0, d1 = 1.0 + 0.5 * x, 0.5 * y, 1.0 - 0.5 * x, -0.5 * y  # e^s = e/d"
    for real, *imaginary in eigenvalues:
        for minus, plus in (("-", "+"), ("+", "-")) if conjugates else (("-", "+"),):
            rest = [f" {plus} {i} * d1" for i in imaginary], [f" {minus} {i} * d0" for i in imaginary]
            yield f"j0, j1 = e0 - {real} * d0{''.join(rest[0])}, e1 - {real} * d1{''.join(rest[1])}"
            yield "g0, g1 = g0 * j0 - g1 * j1, g0 * j1 + g1 * j0"


def _indented(lines: Iterable[str]) -> str:
    return indent("\n".join(lines), "    ")
