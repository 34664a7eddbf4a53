"""SchemeKernels -> text of the stability functions of a module, chosen by the number of live eigenvalues alone."""

from collections.abc import Iterable, Mapping, Sequence
from textwrap import indent

from ..kernels.scheme import SchemeKernels
from .eigenvalue_defect import defect_lines
from .printing import fill
from .templates.eigenvalues import THREE_EIGENVALUES, TWO_EIGENVALUES
from .templates.many_eigenvalues import MORE_EIGENVALUES
from .templates.stability import MONIC, NEAR, PAIR, STABILITY

SMALL_OMEGA = 0.125  # below: exact eigenvalue plus its defect; above: direct formulas
BLOCK = 2048  # points of a block: its arrays stay in the second cache, and it is long beside starting its loops


def stability_functions(kernels: SchemeKernels, arguments: Sequence[str]) -> str:
    """Text that follows the kernels of a module; arguments: Omega, xi and the parameters."""
    degree = len(kernels.live) - 1
    beside = ("third",) if degree == 3 else tuple(f"o{k}" for k in range(degree - 2))
    first = 3 if degree <= 3 else 4  # row of the pair's imaginary part; the other eigenvalues follow
    found = range(first + 1 + len(beside))
    monic = ", ".join(f"s[{j}, i]" for j in range(6)) if degree == 3 else ""
    typed = {"arguments": ", ".join(arguments), "arguments_i": ", ".join(f"{a}[i]" for a in arguments)}
    blocks = {"arguments_slice": ", ".join(f"{a}[i:k]" for a in arguments), "block": BLOCK}
    parts = [
        fill(
            PAIR,
            outputs=", ".join(kernels.defect.outputs),
            lines=_indented(defect_lines(kernels.defect, SMALL_OMEGA)),
        ),
        _eigenvalues(kernels, degree, typed, blocks, arguments),
        fill(
            NEAR,
            **typed,
            more="".join(f", {name}" for name in beside),
            others=_indented(_others(("-third",) if degree == 3 else beside)),
            re=found.stop,
            im=found.stop + 1,
            kept_i=", ".join(f"s[{j}, i]" for j in found[first:]),
            first=first,
            small_Omega=SMALL_OMEGA,
            size=found.stop + 2,
            before=fill(MONIC, arguments_i=typed["arguments_i"], monic=monic) if monic else "",
            found_i=", ".join(f"s[{j}, i]" for j in found),
            prepared_i=f", {monic}" if monic else "",
        ),
        fill(
            STABILITY,
            arguments=typed["arguments"],
            **blocks,
        ),
    ]
    return "".join(parts)


def _eigenvalues(
    kernels: SchemeKernels,
    degree: int,
    typed: Mapping[str, str],
    blocks: Mapping[str, str | int],
    arguments: Sequence[str],
) -> str:
    names = {**typed, "arguments_no_xi": ", ".join((arguments[0], *arguments[2:]))}
    if degree == 2:
        return fill(TWO_EIGENVALUES, **names, size="c2" if kernels.positive else "abs(c2)")
    if degree == 3:
        return fill(THREE_EIGENVALUES, **names, **blocks)
    others = ", ".join(f"others[{k}] / others[-1]" for k in range(degree - 2))
    sizes = {"half": (degree + 1) // 2, "small_Omega": SMALL_OMEGA}
    return fill(MORE_EIGENVALUES, **names, others=others, **sizes)


def _others(coefficients: Sequence[str]) -> Iterable[str]:
    """Lines that multiply g0 + i g1 by the distances of the exact tau from the other n eigenvalues.

    Their product is (1 - tau/2)^n times the monic polynomial in lambda of these coefficients, lowest first.
    """
    if not coefficients:
        return
    yield "e0, e1, d0, d1 = 1.0 + 0.5 * x, 0.5 * y, 1.0 - 0.5 * x, -0.5 * y  # e^s = e/d"
    yield f"j0, j1 = e0 + {coefficients[-1]} * d0, e1 + {coefficients[-1]} * d1".replace("+ -", "- ")
    for k, coefficient in enumerate(coefficients[-2::-1]):
        yield f"c0, c1 = {'c0 * d0 - c1 * d1, c0 * d1 + c1 * d0' if k else 'd0 * d0 - d1 * d1, 2.0 * d0 * d1'}"
        yield f"j0, j1 = j0 * e0 - j1 * e1 + {coefficient} * c0, j0 * e1 + j1 * e0 + {coefficient} * c1"
    yield "g0, g1 = g0 * j0 - g1 * j1, g0 * j1 + g1 * j0"


def _indented(lines: Iterable[str]) -> str:
    return indent("\n".join(lines), "    ")
