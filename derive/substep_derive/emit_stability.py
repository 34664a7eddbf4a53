"""Amplification -> text of the stability functions of a module, chosen by the number of live eigenvalues alone."""

from collections.abc import Iterable, Sequence
from textwrap import indent

from . import templates_eigenvalues, templates_many, templates_stability
from .amplification import Amplification
from .printing import fill
from .residual import Residual
from .stability_kernels import live_coefficients

SMALL_OMEGA = 0.125  # below: exact eigenvalue plus its defect; above: direct formulas
BLOCK = 2048  # points whose arrays stay in the second cache; fewer, and the loops' beginnings and ends tell


def stability_functions(amplification: Amplification, arguments: Sequence[str]) -> str:
    """Text after the kernels; arguments: Omega, xi and the parameters."""
    c = live_coefficients(amplification)
    degree, residual = len(c) - 1, Residual.of(c)
    kept = ("root", "third") if degree == 3 else ("root", *(f"o{k}" for k in range(degree - 2)))
    beside = kept[1:]  # the eigenvalues beside the pair, or their polynomial
    point, size = [*arguments, *beside], len(arguments) + len(kept)
    typed = {"arguments": ", ".join(arguments), "arguments_i": ", ".join(f"{a}[i]" for a in arguments)}
    first = 3 if degree <= 3 else 4  # row of what `_near` wants: the largest pair's imaginary part or another's
    rows = range(first, first + len(kept))
    chosen = f"Omega[i] < {SMALL_OMEGA}"
    parts = [
        fill(
            templates_stability.PAIR,
            outputs=", ".join(residual.outputs),
            lines=_indented(residual.text(SMALL_OMEGA)),
        ),
        _eigenvalues(degree, arguments),
        fill(
            templates_stability.NEAR,
            arguments=typed["arguments"],
            kept=", ".join(kept),
            point=", ".join(point),
            point_i=", ".join(f"{a}[i]" for a in point),
            others=_indented(_others(("-third",) if degree == 3 else beside)),
        ),
        fill(
            templates_stability.BLOCK,
            **typed,
            found_i=", ".join(f"s[{j}, i]" for j in range(rows.stop)),
            kept=", ".join(f"s[{j}]" for j in rows),
            kept_i=", ".join(f"s[{j}, i]" for j in rows),
            chosen=f"({chosen}) & (s[{first}, i] > -2.0)" if degree > 3 else chosen,
            gathered=", ".join(f"x[{j}, k]" for j in range(size)),
            rows=", ".join(f"x[{j}]" for j in range(size)),
            size=size,
            size_kept=rows.stop,
        ),
        fill(
            templates_stability.STABILITY,
            **typed,
            arguments_slice=", ".join(f"{a}[i:k]" for a in arguments),
            block=BLOCK,
        ),
    ]
    return "".join(parts)


def _eigenvalues(degree: int, arguments: Sequence[str]) -> str:
    names = {"arguments": ", ".join(arguments), "arguments_no_xi": ", ".join((arguments[0], *arguments[2:]))}
    if degree == 2:
        return fill(templates_eigenvalues.TWO_EIGENVALUES, **names)
    if degree == 3:
        return fill(templates_eigenvalues.THREE_EIGENVALUES, **names)
    others = ", ".join(f"others[{k}] / others[-1]" for k in range(degree - 2))
    sizes = {"half": (degree + 1) // 2, "small_Omega": SMALL_OMEGA}
    return fill(templates_many.MORE_EIGENVALUES, **names, others=others, **sizes)


def _others(coefficients: Sequence[str]) -> Iterable[str]:
    """g0, g1: e^s times the monic polynomial, its other coefficients given lowest first, at e^s = x + i r y."""
    if not coefficients:
        yield "g0, g1 = x, y"
        return
    yield f"g0, g1 = x + {coefficients[-1]}, y".replace("+ -", "- ")
    for coefficient in (*coefficients[-2::-1], ""):
        more = f" + {coefficient}" if coefficient else ""
        yield f"g0, g1 = g0 * x - square * g1 * y{more}, g0 * y + g1 * x"


def _indented(lines: Iterable[str]) -> str:
    return indent("\n".join(lines), "    ")
