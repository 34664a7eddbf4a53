"""Derived objects -> Kernel list: what the printer is asked to print about a scheme."""

from collections.abc import Sequence
from dataclasses import dataclass

from sympy import Expr, Integer, Matrix, Symbol, eye

from .accuracy import defect_series, live
from .algebra import horner
from .amplification import Amplification
from .symbols import Omega, xi

DEFECT_TERMS = 7  # powers of Omega that are cancelled symbolically; a consistent scheme's first differ from 0 there

UP_TO = f"up to Omega^{DEFECT_TERMS - 1}"


@dataclass(frozen=True)
class Kernel:
    """A scalar function with named outputs: the only thing the printer accepts."""

    name: str
    arguments: tuple[Symbol, ...]
    outputs: tuple[tuple[str, Expr], ...]
    docstring: str


def entries(name: str, matrix: Matrix) -> list[tuple[str, Expr]]:
    """The entries row by row, named name_00, name_01, ..."""
    return [(f"{name}_{i}{j}", matrix[i, j]) for i in range(matrix.rows) for j in range(matrix.cols)]


def polynomial_kernel(name: str, arguments: Sequence[Symbol], outputs: list[tuple[str, Expr]], doc: str) -> Kernel:
    """Outputs nested in Omega with factored coefficients."""
    return Kernel(name, tuple(arguments), tuple((key, horner(e, Omega)) for key, e in outputs), doc)


def scheme_kernels(amplification: Amplification) -> list[Kernel]:
    """Polynomials from which a scheme's module computes all its functions."""
    arguments = (Omega, xi, *amplification.scheme.values)
    step, outputs, start = amplification.step, amplification.outputs, amplification.start
    increment = [("den", step.den), *entries("D", step.N - step.den * eye(step.N.rows)), *entries("B", step.load_N)]
    if outputs.N.rows:
        increment += [("den_o", outputs.den), *entries("O", outputs.N), *entries("P", outputs.load_N)]
    kernels = [
        polynomial_kernel(
            "_increment",
            arguments,
            increment,
            "Denominators and numerators of A - I, of the load vectors, and of outputs not in the state.",
        ),
    ]
    if start is not None:
        kernels.append(
            polynomial_kernel(
                "_start",
                arguments,
                [("den", start.den), *entries("S", start.N), *entries("T", start.load_N)],
                "Denominator and numerators of the state at t = 0 from u, h*v, h^2*a and the load.",
            )
        )
    return kernels + _spectrum_kernels(amplification, arguments)


def _spectrum_kernels(amplification: Amplification, arguments: tuple[Symbol, ...]) -> list[Kernel]:
    c = list(reversed(live(amplification.charpoly).all_coeffs()))
    d = len(c) - 1
    defects, columns = defect_series(amplification, DEFECT_TERMS)
    by_power = polynomial_kernel(
        "_columns",
        arguments[1:],
        [(f"c{j}_{i}", e) for j, column in enumerate(columns) for i, e in enumerate(column)],
        "Coefficients of the live polynomial, by power of lambda, then of Omega.",
    )
    if d == 2:
        det, trace, c2 = c[0], -c[1], c[2]
        return [
            polynomial_kernel(
                "_quadratic",
                arguments,
                [("c2", c2), ("c1", 2 * c2 - trace), ("trace", trace), ("det", det), ("q", c2 - det)],
                "Live eigenvalues: c2*lambda^2 - trace*lambda + det = 0; c1 = 2*c2 - trace, q = c2 - det.",
            ),
            polynomial_kernel(
                "_defect",
                arguments,
                list(defects.items()),
                f"Residual of the exact eigenvalue, r_0 + r_1*zeta, and of its modulus, g, {UP_TO}.",
            ),
            by_power,
        ]
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
