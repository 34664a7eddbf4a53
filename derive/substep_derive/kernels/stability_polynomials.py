"""Live eigenvalues -> the polynomials from which a module computes its stability functions."""

from collections.abc import Iterable, Sequence

from sympy import Add, Expr, Integer, Poly, Symbol, expand, factor, horner

from ..algebra.constant import constants_of
from ..algebra.expanded import coefficients
from ..algebra.rational import factored
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from ..oscillator.amplification import Amplification
from ..oscillator.spectrum import live
from ..oscillator.stability_polynomial import rate, stability_polynomial
from .eigenvalue_defect import EigenvalueDefect, about_one
from .kernel import Kernel, nested


def live_coefficients(amplification: Amplification) -> list[Expr]:
    """Coefficients, lowest first, of the polynomial in lambda whose roots are the live eigenvalues."""
    return list(reversed(live(amplification.charpoly).all_coeffs()))


def factor_coefficients(amplification: Amplification) -> tuple[Expr, ...] | None:
    """Coefficients, lowest first, of the stability polynomial, polynomials in `rate`; None if there is none."""
    found = stability_polynomial(live(amplification.charpoly))
    return tuple(reversed(found.all_coeffs())) if found is not None else None


def stability_kernels(
    scheme: Scheme, live: list[Expr], factor: Sequence[Expr] | None, defect: EigenvalueDefect
) -> tuple[Kernel, ...]:
    """Kernels of the live eigenvalues' polynomial, of its asymmetry, and of its value at the exact eigenvalue.

    factor: coefficients of the stability polynomial, if it is a factor of that polynomial.
    """
    arguments = (Omega, xi, *scheme.values)
    if len(live) > 4:
        polynomial = _polynomial(live, arguments) if factor is None else _factor(factor, scheme.values)
        zeros = 1 if factor is None else 2  # a factor of the stability polynomial's is there twice
        return polynomial, _asymmetry(_opposite(live, zeros), arguments, zeros), _defect(defect, arguments)
    kinds = {3: _two_eigenvalues, 4: _three_eigenvalues}
    return (*kinds[len(live)](live, arguments), _defect(defect, arguments))


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


def _asymmetry(opposite: dict[str, Expr], arguments: tuple[Symbol, ...], zeros: int = 1) -> Kernel:
    """How far the polynomial at xi = 0 is from reading the same backwards, as it is (w) and without roots at 0 (y)."""
    doc = "At xi = 0: w = 0 if the polynomial in lambda reads the same backwards"
    doc += f"; y = 0 if that over lambda{'^2' if zeros == 2 else ''} does." if "y0" in opposite else "."
    outputs = {name: e.subs(xi, 0) for name, e in opposite.items()}
    return _inlined("_asymmetry", (Omega, *arguments[2:]), outputs, doc)


def _defect(defect: EigenvalueDefect, arguments: tuple[Symbol, ...]) -> Kernel:
    doc = f"Parts of the polynomial in tau at e^s, summed up to Omega^{defect.terms - 1}, for `_polynomial_at_exact`."
    return _inlined("_defect", arguments, defect.outputs, doc)


def _inlined(name: str, arguments: tuple[Symbol, ...], outputs: dict[str, Expr], doc: str) -> Kernel:
    """A kernel inlined in its loop; its outputs are in the form of fewest operations that was found.

    That is Horner's form in the first argument, whose coefficients are factored; factors that are sums are in Horner's
    form too.
    """
    if constants_of(outputs.values()):  # numbers without common factors
        return Kernel(name, arguments, tuple((key, nested(e, arguments[0])) for key, e in outputs.items()), doc)
    first = arguments[0]
    degree = {v: max(len(coefficients(e, v)) - 1 for e in outputs.values()) for v in arguments if v not in (first, xi)}
    order = [xi, *sorted(degree, key=lambda v: (degree[v], v.name))]
    alone: dict[Expr, Symbol] = {}
    found: list[tuple[str, Expr]] = []
    for key, output in outputs.items():
        total: Expr = Integer(0)
        for coefficient in coefficients(output, first):
            sums = factored(coefficient).replace(
                lambda e: isinstance(e, Add), lambda e: _nested(expand(e), order, alone)
            )
            total = total * first + sums
        found.append((key, total))
    return Kernel(name, arguments, tuple(found), doc, tuple((r.name, e) for e, r in alone.items()))


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
        for coefficient in coefficients(polynomial, variables[0]):
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


def _polynomial(c: Sequence[Expr], arguments: tuple[Symbol, ...]) -> Kernel:
    outputs = {f"c{j}": e for j, e in enumerate(c)} | {f"b{j}": e for j, e in enumerate(about_one(c))}
    doc = "c0 + c1*lambda + ... = b0 + b1*(lambda - 1) + ... = 0 for eigenvalues not always 0."
    return _inlined("_polynomial", arguments, outputs, doc)


def _factor(c: Sequence[Expr], parameters: Iterable[Symbol]) -> Kernel:
    re, im = Symbol("s0"), Symbol("s1")
    parts = {
        f"{name}{j}{suffix}": part
        for name, coefficients in (("c", c), ("b", about_one(c)))
        for j, e in enumerate(coefficients)
        for suffix, part in zip(("", "i"), _parts(e, re, im), strict=True)
    }
    doc = "Stability polynomial at s0 + i*s1: c0 + i*c0i + (c1 + i*c1i)*lambda + ...; b0, ...: in powers of lambda - 1."
    return _inlined("_polynomial", (re, im, *parameters), parts, doc)


def _parts(polynomial: Expr, re: Symbol, im: Symbol) -> tuple[Expr, Expr]:
    """Real and imaginary part of a polynomial in s = re + i*im with real coefficients."""
    i = Symbol("i")
    at = Poly(Poly(polynomial, rate).as_expr().subs(rate, re + i * im), i).rem(Poly(i**2 + 1, i))
    return at.coeff_monomial(1), at.coeff_monomial(i)


def _opposite(c: Sequence[Expr], zeros: int) -> dict[str, Expr]:
    """What vanishes if the polynomial reads the same backwards (w), and if it does over lambda^zeros (y)."""
    d = len(c) - 1
    opposite = {f"w{j}": c[j] - c[d - j] for j in range((d + 1) // 2)}
    opposite |= {f"y{j}": c[j] for j in range(zeros)}
    return opposite | {f"y{j}": c[j] - c[d + zeros - j] for j in range(zeros, (d + zeros + 1) // 2)}
