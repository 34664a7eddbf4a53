"""Amplification -> the kernels from which a scheme's module computes its matrices."""

from sympy import eye

from ..declare.symbols import Omega, xi
from ..oscillator.amplification import Amplification
from .kernel import Kernel, entries, polynomial_kernel


def scheme_kernels(amplification: Amplification) -> list[Kernel]:
    """Polynomials from which a scheme's module computes its matrices."""
    arguments = (Omega, xi, *amplification.scheme.values)
    step, start = amplification.step, amplification.start
    increment = [("den", step.den), *entries("D_", step.N - step.den * eye(step.N.rows))]
    kernels = [
        polynomial_kernel(
            "_increment",
            arguments,
            increment,
            "Denominator and numerators of A - I.",
        ),
    ]
    if start is not None:
        kernels.append(
            polynomial_kernel(
                "_start",
                arguments,
                [("den", start.den), *entries("S_", start.N), *entries("T_", start.load_N)],
                "Denominator and numerators of the state at t = 0 from u, h*v, h^2*a and the load.",
            )
        )
    return kernels
