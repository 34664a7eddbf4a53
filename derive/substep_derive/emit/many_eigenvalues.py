"""Coefficients of a polynomial -> text of the functions that find its roots, for more than three live eigenvalues.

The polynomial is that of the live eigenvalues or, where there is one, the stability polynomial: then each root stands
for itself and its conjugate.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from textwrap import indent

from ..kernels.scheme import SchemeKernels
from .printing import fill
from .templates.many_eigenvalues import BOTH_FACTORS, COEFFICIENTS, COEFFICIENTS_OF_FACTOR, MORE_EIGENVALUES

WIDTH = 32  # points side by side: their coefficients and roots stay in the first cache


@dataclass(frozen=True)
class MoreEigenvalues:
    """What is printed for more than three live eigenvalues.

    n: number of roots that are found. halves: whether they are those of the stability polynomial. opposite: names of
    the outputs of `_asymmetry`.
    """

    n: int
    halves: bool
    opposite: tuple[str, ...]

    @classmethod
    def of(cls, kernels: SchemeKernels) -> "MoreEigenvalues":
        """From the polynomials of a scheme."""
        c = kernels.live if kernels.factor is None else kernels.factor
        asymmetry = next(kernel for kernel in kernels.stability if kernel.name == "_asymmetry")
        return cls(len(c) - 1, kernels.factor is not None, tuple(name for name, _ in asymmetry.outputs))

    @property
    def find(self) -> str:
        """Name of the function that stores what `_eigenvalues` takes of each point, a row each."""
        return "_find_both_roots" if self.halves else "_find_roots"

    @property
    def prepared(self) -> list[str]:
        """Names of these rows: the roots and, beside roots of the stability polynomial, what its other half gives."""
        return [*self._roots(), "square"] if self.halves else self._roots()

    def others(self, real: str, imaginary: str) -> list[tuple[str, ...]]:
        """Names of real and imaginary parts of the eigenvalues beside those of the largest pair."""
        return [(f"{real}{k}", f"{imaginary}{k}") for k in range(1 if self.halves else 2, self.n)]

    def text(self, arguments: Sequence[str], names: Mapping[str, str | int], small_Omega: float) -> str:
        """Text of `_spectral_radii`, `_eigenvalues` and all that they call."""
        n, rows = self.n, self._roots()
        parts = ("", "_") if self.halves else ("",)
        coefficients = [f"c{k}{part}" for k in range(n, -1, -1) for part in parts]
        scratch = [*rows, *coefficients]

        def at(wanted: Iterable[str]) -> str:
            return ", ".join(f"s[{scratch.index(name)} * {WIDTH} + j]" for name in wanted)

        all_arguments = ", ".join(arguments)
        evaluated = {
            "arguments": all_arguments,
            "outputs": ", ".join(f"{name}{k}{part}" for name in "cb" for k in range(n + 1) for part in parts),
            "chosen": ", ".join(f"b{name[1:]} if near else {name}" for name in coefficients),
        }
        if self.halves:
            given = "".join(f", {a}" for a in arguments[2:])
            text = fill(COEFFICIENTS_OF_FACTOR, **evaluated, parameters=given)
            both = fill(BOTH_FACTORS, arguments=all_arguments, rows=2 * n)
        else:
            text, both = fill(COEFFICIENTS, **evaluated), ""
        whole, divided = (" + ".join(f"abs({name})" for name in self.opposite if name[0] == kind) for kind in "wy")
        return fill(
            MORE_EIGENVALUES,
            **names,
            n=n,
            exponent=2**31 // n,
            low=2 * n - 1,
            high=2 * n + 1,
            low_of_square=f"{n - 1}.0 / {2 * n}.0",
            middle=2.0 - 2.0 * (n % 4),
            small_Omega=small_Omega,
            coefficients=text,
            width=WIDTH,
            c_j=", ".join(f"({at([f'c{k}'])}, {at([f'c{k}_']) if self.halves else '0.0'})" for k in range(n, -1, -1)),
            coefficients_j=at(coefficients),
            z=", ".join(rows),
            z_j=at(rows),
            uv=", ".join(f"{part}{k}" for k in range(n) for part in "uv"),
            starts=_lines(_start(k, n, at([f"x{k}", f"y{k}"])) for k in range(n)),
            steps=_lines(_step(k, n) for k in range(n)),
            ends=_lines(f"{at([f'y{k}'])} = _surely_complex(x{k}, y{k}, c)" for k in range(n)),
            scratch_rows=len(scratch),
            rows=2 * n,
            second_argument=", second" if self.halves else "",
            second=", second" if self.halves else "",
            arguments_first=", ".join(f"{a}[first + j]" for a in arguments),
            both=both,
            asymmetry=", ".join(self.opposite),
            whole=whole,
            divided=divided,
            find=self.find,
            prepared=", ".join(self.prepared),
            prepared_i=", ".join(f"s[{k}, i]" for k in range(len(self.prepared))),
            prepared_rows=len(self.prepared),
            placed=indent("\n".join(self._placed()), "    "),
            is_complex="y0 != 0.0" if self.halves else "y0 > 0.0",
            others=", ".join(name for pair in self.others("h", "y") for name in pair),
        )

    def _roots(self) -> list[str]:
        return [f"{part}{k}" for k in range(self.n) for part in "xy"]

    def _placed(self) -> Iterator[str]:
        """Lines that make the largest complex pair the first eigenvalue and, if pairs are two roots, the second."""
        n, beside = self.n, ", square" if self.halves else ""
        yield from (f"h{k}, l{k}, m{k} = _eigenvalue(x{k}, y{k}, near)" for k in range(n))
        yield f"square = max({', '.join(f'm{k}' for k in range(n))}{beside})"
        for k in range(1, n):
            paired, single = (f"y{k} != 0.0", "y0 == 0.0") if self.halves else (f"y{k} > 0.0", "y0 <= 0.0")
            yield f"swap = {paired} and ({single} or m{k} > 1.000000000002 * m0)"
            yield _swapped(0, k, "hlmy")
        for k in range(2, 0 if self.halves else n):
            yield f"swap = abs(h{k} - h0) + abs(y{k} + y0) < abs(h1 - h0) + abs(y1 + y0)"
            yield _swapped(1, k, "hy")


def _lines(lines: Iterable[str]) -> str:
    return indent("\n".join(lines), " " * 8)


def _start(k: int, n: int, target: str) -> str:
    size, angle = 1.0 + 0.004 * k, 2.0 * math.pi * k / n  # no two starts are equal
    c, s = f"{size * math.cos(angle):.6f}", f"{size * math.sin(angle):.6f}"
    return f"{target} = z.real + {c} * p.real - {s} * q.imag, z.imag + {s} * q.real + {c} * p.imag"


def _step(k: int, n: int) -> str:
    beside = "".join(f"(x{j}, y{j}), " for j in range(n) if j != k)
    return f"u{k}, v{k}, moved = _closer(x{k}, y{k}, ({beside.rstrip()}), c)\ncount += moved"


def _swapped(a: int, b: int, names: str) -> str:
    here = ", ".join(f"{name}{k}" for k in (a, b) for name in names)
    there = ", ".join(f"{name}{k}" for k in (b, a) for name in names)
    return f"{here} = ({there}) if swap else ({here})"
