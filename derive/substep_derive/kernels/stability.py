"""Live eigenvalues -> the polynomials from which a module computes its stability functions."""

from collections.abc import Sequence

from sympy import Add, Expr, Integer, Poly, Symbol, expand, factor, horner

from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from ..oscillator.amplification import Amplification
from ..oscillator.spectrum import live
from .eigenvalue_defect import EigenvalueDefect, about_one
from .kernel import Kernel


def live_coefficients(amplification: Amplification) -> list[Expr]:
    """Coefficients, lowest first, of the polynomial in lambda whose roots are the live eigenvalues."""
    return list(reversed(live(amplification.charpoly).all_coeffs()))


def never_negative(polynomial: Expr, scheme: Scheme) -> bool:
    """Whether no term of the polynomial can be negative at any Omega, xi and parameters; it may be >= 0 without."""
    bounded = all(p.domain.start >= 0 for p in scheme.parameters if polynomial.has(p.symbol))
    return bounded and all(c > 0 for c in Poly(polynomial, Omega, xi, *scheme.values).coeffs())


def stability_kernels(scheme: Scheme, live: list[Expr], defect: EigenvalueDefect) -> tuple[Kernel, ...]:
    """Kernels of the live eigenvalues' polynomial, of its asymmetry, and of its value at the exact eigenvalue."""
    arguments = (Omega, xi, *scheme.values)
    kinds = {3: _two_eigenvalues, 4: _three_eigenvalues}
    return (*kinds.get(len(live), _more_eigenvalues)(live, arguments), _defect(defect, arguments))


def _two_eigenvalues(c: list[Expr], arguments: tuple[Symbol, ...]) -> list[Kernel]:
    det, trace, c2 = c[0], -c[1], c[2]
    return [
        _inlined(
            "_quadratic",
            arguments,
            {"c2": c2, "b0": c2 - trace + det, "q": c2 - det, "half": trace / 2, "det": det},
            "c2*lambda^2 - 2*half*lambda + det = 0 for eigenvalues not always 0; b0: its value at 1; q = c2 - det.",
        ),
        _asymmetry({"w": c2 - det}, arguments),
    ]


def _three_eigenvalues(c: list[Expr], arguments: tuple[Symbol, ...]) -> list[Kernel]:
    c0, c1, c2, c3 = c
    b0, b1, *_ = about_one(c)
    opposite = {"w0": c0 - c3, "w1": c1 - c2, "y0": c0, "y1": c1 - c3}
    return [
        _inlined(
            "_cubic",
            arguments,
            {"c3": c3, "c2": c2, "c1": c1, "c0": c0, "b0": b0, "b1": b1},
            "c3*lambda^3 + ... + c0 = 0 for eigenvalues not always 0; b0, b1: its value and slope at lambda = 1.",
        ),
        _asymmetry(opposite, arguments),
    ]


def _asymmetry(opposite: dict[str, Expr], arguments: tuple[Symbol, ...]) -> Kernel:
    """How far the polynomial at xi = 0 is from reading the same backwards, as it is (w) and without a root at 0 (y)."""
    doc = "At xi = 0: w = 0 if the polynomial in lambda reads the same backwards"
    doc += "; y = 0 if that over lambda does." if "y0" in opposite else "."
    outputs = {name: e.subs(xi, 0) for name, e in opposite.items()}
    return _inlined("_asymmetry", (Omega, *arguments[2:]), outputs, doc)


def _defect(defect: EigenvalueDefect, arguments: tuple[Symbol, ...]) -> Kernel:
    doc = f"Parts of the polynomial in tau at e^s, summed up to Omega^{defect.terms - 1}, for `_polynomial_at_exact`."
    return _inlined("_defect", arguments, defect.outputs, doc)


def _inlined(name: str, arguments: tuple[Symbol, ...], outputs: dict[str, Expr], doc: str) -> Kernel:
    """A kernel inlined in its loop; its outputs are in the form of fewest operations that was found.

    That is Horner's form in Omega, whose coefficients are factored; factors that are sums are in Horner's form too.
    """
    degree = {v: max(Poly(e, v).degree() for e in outputs.values()) for v in arguments if v not in (Omega, xi)}
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
    """Horner's form; short sums in the last parameter get a name in `alone`, and are computed first.

    Such a sum is nearly exact, so that one that vanishes at a usual value, as 2*gamma - 1 at gamma = 1/2, vanishes in
    doubles too. A sum that cannot vanish gets no name, so that common subexpressions are still found in it.
    """
    variables = [v for v in order if polynomial.has(v)]
    if polynomial.free_symbols == {xi} and all(c > 0 for c in Poly(polynomial, xi).coeffs()):
        return polynomial
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


def _more_eigenvalues(c: list[Expr], arguments: tuple[Symbol, ...]) -> list[Kernel]:
    d = len(c) - 1
    b0, b1, *_ = about_one(c)
    opposite = {f"w{j}": c[j] - c[d - j] for j in range((d + 1) // 2)}
    opposite |= {"y0": c[0], **{f"y{j}": c[j] - c[d + 1 - j] for j in range(1, d // 2 + 1)}}
    return [
        _inlined(
            "_polynomial",
            arguments,
            {**{f"c{j}": e for j, e in enumerate(c)}, "b0": b0, "b1": b1},
            "c0 + c1*lambda + ... = 0 for eigenvalues not always 0; b0, b1: its value and slope at lambda = 1.",
        ),
        _asymmetry(opposite, arguments),
    ]
