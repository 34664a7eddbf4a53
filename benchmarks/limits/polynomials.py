"""polynomials.h for stability.c: a scheme's polynomials from its derivation, and those of log and atan."""

from typing import Any

from mpmath import atan, atanh, chebyfit, mp, sqrt
from substep_derive import derive
from substep_derive.accuracy import live
from substep_derive.algebra import cse, horner
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
    """C text: EIGENVALUES, and polynomials() that gives the coefficients stability.c wants, each nested in Omega.

    Raises ValueError for a scheme with other than two or three live eigenvalues.
    """
    derivation = derive(scheme)
    coefficients = live(derivation.charpoly).all_coeffs()
    count = len(coefficients) - 1
    if count == 2:
        c2, minus_trace, det = coefficients
        outputs = {"c2": c2, "p": c2 + minus_trace + det, "q": c2 - det, "det": det}
    elif count == 3:
        c3, c2, c1, c0 = coefficients
        outputs = {"c3": c3, "c2": c2, "c1": c1, "c0": c0, "p": c3 + c2 + c1 + c0, "q": 3 * c3 + 2 * c2 + c1}
    else:
        raise ValueError(f"expected two or three live eigenvalues, got {count} of {scheme}")
    Omega = derivation.symbols["Omega"]
    common, expressions = cse([horner(e, Omega) for e in outputs.values()])
    printer = _VectorPrinter()
    lines = [f"vec {symbol} = v[{i}];" for i, symbol in enumerate(derivation.symbols)]
    lines += [f"vec {symbol} = all(0.0) + ({printer.doprint(e)});" for symbol, e in common]
    stored = zip(outputs, expressions, strict=True)
    lines += [f"out[{i}] = all(0.0) + ({printer.doprint(e)});  // {name}" for i, (name, e) in enumerate(stored)]
    return "\n".join(
        [
            f"#define INPUTS {len(derivation.symbols)}",
            f"#define EIGENVALUES {count}",
            _table("LOG", LOG_TERMS, lambda z: 2 * atanh(sqrt(z)) / sqrt(z) if z else mp.mpf(2), LOG_END),
            _table("ATAN", ATAN_TERMS, lambda z: atan(sqrt(z)) / sqrt(z) if z else mp.mpf(1), ATAN_END),
            "INLINE void polynomials(const vec *v, vec *out) {",
            *(f"    {line}" for line in lines),
            "}\n",
        ]
    )


def _table(name: str, terms: int, function: Any, end: Any) -> str:
    """Coefficients of the polynomial nearest to a function of the square, on [0, end], lowest first."""
    with mp.workdps(40):
        found = reversed(chebyfit(function, [0, end], terms))
        numbers = ", ".join(mp.nstr(c, 20) for c in found)
    return f"#define {name}_TERMS {terms}\nstatic const double {name}_POLYNOMIAL[] = {{{numbers}}};"
