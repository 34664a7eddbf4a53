"""Amplification -> Kernel list: the polynomials a module computes its stability functions from."""

from collections.abc import Sequence
from math import factorial

from sympy import Add, Expr, Integer, Poly, Symbol, chebyshevt, expand, factor, horner

from .accuracy import defect_series, live
from .amplification import Amplification
from .kernels import Kernel, polynomial_kernel
from .symbols import Omega, xi

# powers of Omega that are cancelled symbolically; for a consistent scheme the first three vanish
DEFECT_TERMS = 6  # of a scheme without parameters
DEFECT_TERMS_WITH_PARAMETERS = 4  # their rounding is as large as what further powers would save
DEFECT_TERMS_OF_MANY = 7  # for more than two live eigenvalues

UP_TO = f"up to Omega^{DEFECT_TERMS_OF_MANY - 1}"
# tails of exponentials in the defect: see `_tails` of the templates
EVEN_AND_ODD = tuple(Symbol(f"e{k}") for k in range(1, 8))
GROWTH = tuple(Symbol(f"f{k}") for k in range(1, 7))
TAILS = (*EVEN_AND_ODD, *GROWTH)


def stability_kernels(amplification: Amplification) -> list[Kernel]:
    """Of the live eigenvalues: their polynomial, and how far it is from having the exact ones as roots."""
    arguments = (Omega, xi, *amplification.scheme.values)
    c = list(reversed(live(amplification.charpoly).all_coeffs()))
    return _two(c, arguments) if len(c) == 3 else _more(amplification, c, arguments)


def _two(c: list[Expr], arguments: tuple[Symbol, ...]) -> list[Kernel]:
    det, trace, c2 = c[0], -c[1], c[2]
    terms = DEFECT_TERMS_WITH_PARAMETERS if arguments[2:] else DEFECT_TERMS
    w, g = pair_defect(det, trace, c2, terms)
    return [
        _inlined(
            "_quadratic",
            arguments,
            {"c2": c2, "b0": c2 - trace + det, "q": c2 - det, "trace": trace, "det": det},
            "Live eigenvalues: c2*lambda^2 - trace*lambda + det = 0; b0, its value at 1; q = c2 - det.",
        ),
        _inlined(
            "_defect",
            (*arguments, *TAILS),
            {"w": w, "g": g},
            f"Re(c2*e^s + det*e^-s - trace) and det*e^(2*xi*Omega) - c2, cancelled up to Omega^{terms - 1}.",
        ),
    ]


def _inlined(name: str, arguments: tuple[Symbol, ...], outputs: dict[str, Expr], doc: str) -> Kernel:
    """Outputs nested in Omega, and what does not factor in xi and the parameters: the fewest operations."""
    degree = {v: max(Poly(e, v).degree() for e in outputs.values()) for v in arguments[2:] if v not in TAILS}
    order = [xi, *sorted(degree, key=lambda v: (degree[v], v.name))]
    alone: dict[Expr, Symbol] = {}
    nested: list[tuple[str, Expr]] = []
    for key, output in outputs.items():
        total: Expr = Integer(0)
        for coefficient in Poly(output, Omega).all_coeffs():
            sums = factor(coefficient).replace(lambda e: isinstance(e, Add), lambda e: _nested(expand(e), order, alone))
            total = total * Omega + sums
        nested.append((key, total))
    return Kernel(name, arguments, tuple(nested), doc, tuple((r.name, e) for e, r in alone.items()))


def _nested(polynomial: Expr, order: Sequence[Symbol], alone: dict[Expr, Symbol]) -> Expr:
    """Horner's form; short sums in the last parameter get a name in `alone`, to be formed before all else.

    They are nearly exact, so that what vanishes at usual values, such as 1/2 of 2*gamma - 1, does so.
    """
    variables = [v for v in order if polynomial.has(v)]
    if len(variables) > 1:
        total: Expr = Integer(0)
        for coefficient in Poly(polynomial, variables[0]).all_coeffs():
            total = total * variables[0] + _nested(coefficient, variables[1:], alone)
        return total
    if not variables or polynomial.free_symbols - set(variables):
        return polynomial

    def named(part: Expr) -> Expr:
        if Poly(part, *variables).degree() > 2:
            return horner(part)
        content, part = part.primitive()
        if Poly(part, *variables).LC() < 0:
            content, part = -content, -part
        return content * alone.setdefault(horner(part), Symbol(f"r{len(alone)}"))

    return factor(polynomial).replace(lambda e: isinstance(e, Add), named)


def pair_defect(det: Expr, trace: Expr, c2: Expr, terms: int) -> tuple[Expr, Expr]:
    """Re(c2*e^s + det*e^-s - trace) and det*e^(2*xi*Omega) - c2, exactly.

    Powers of Omega below `terms`, of which the first cancel because the scheme is consistent, are written
    out; the rest is in the tails of the exponentials.
    """
    powers = range(max(Poly(e, Omega).degree() for e in (det, trace, c2)) + 1)
    D, T, C = ([Poly(e, Omega).coeff_monomial(Omega**i) for i in powers] for e in (det, trace, c2))
    w: list[Expr] = [Integer(0)] * (terms + len(powers) + 2)
    g = list(w)
    for i in powers:
        both = C[i] + D[i], C[i] - D[i]  # of the even and of the odd powers of s
        rest = max(terms - i, 1)  # not 0: what cancels at Omega = 0 cancels in every power
        for k in range(rest):
            w[i + k] += both[k % 2] * chebyshevt(k, -xi) / factorial(k)  # Re(s^k) = Omega^k T_k(-xi)
            g[i + k] += D[i] * (2 * xi) ** k / factorial(k)
        for k in (rest, rest + 1):
            w[i + k] += both[k % 2] * EVEN_AND_ODD[k - 1]
        g[i + rest] += D[i] * (2 * xi) ** rest * GROWTH[rest - 1]
        w[i] -= T[i]
        g[i] -= C[i]
    return tuple(sum((expand(e) * Omega**n for n, e in enumerate(part)), Integer(0)) for part in (w, g))


def _more(amplification: Amplification, c: list[Expr], arguments: tuple[Symbol, ...]) -> list[Kernel]:
    d = len(c) - 1
    defects, columns = defect_series(amplification, DEFECT_TERMS_OF_MANY)
    by_power = polynomial_kernel(
        "_columns",
        arguments[1:],
        [(f"c{j}_{i}", e) for j, column in enumerate(columns) for i, e in enumerate(column)],
        "Coefficients of the live polynomial, by power of lambda, then of Omega.",
    )
    return [
        polynomial_kernel(
            "_polynomial",
            arguments,
            [*((f"c{j}", e) for j, e in enumerate(c)), ("b1", sum((j * e for j, e in enumerate(c)), Integer(0)))],
            "Live eigenvalues: c0 + c1*lambda + ... = 0; b1, the slope at lambda = 1.",
        ),
        polynomial_kernel(
            "_asymmetry",
            arguments,
            [
                *((f"w{j}", c[j] - c[d - j]) for j in range((d + 1) // 2)),
                *((f"y{j}", c[j] - c[d + 1 - j]) for j in range(1, d // 2 + 1)),
            ],
            "Differences of the polynomial's opposite coefficients: w, and y for the polynomial over lambda.",
        ),
        polynomial_kernel(
            "_defect",
            arguments,
            [(name, defects[name]) for name in ("r_0", "r_1")],
            f"Residual of the exact eigenvalue, r_0 + r_1*zeta, {UP_TO}.",
        ),
        by_power,
    ]
