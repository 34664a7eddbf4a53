"""Polynomials -> lines that evaluate them in pairs of doubles, head and tail, 32 digits in all.

Over n steps of a march the rounding error of its coefficients grows about n*Omega times, so that they are computed in
such pairs and rounded only once, at the end. What the lines call is the arithmetic `by` that formulas are given.
"""

from collections.abc import Sequence
from itertools import count

from sympy import Expr, Rational

from ..algebra import rational

Number = tuple[str, str | None]  # texts of head and tail; None: the number is a double


class DoubleDouble:
    """Collects the lines; the tail of a name x that has one is in xt."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._tailed: set[str] = set()
        self._fresh = count()

    def assign(self, outputs: Sequence[tuple[str, Expr]]) -> None:
        """Lines that assign the outputs, polynomials with exact coefficients, with their tails."""
        subexpressions, expressions = rational.cse([e for _, e in outputs], names="d")
        named = zip((name for name, _ in outputs), expressions, strict=True)
        self.follow([*((str(s), e) for s, e in subexpressions), *named])

    def follow(self, assigned: Sequence[tuple[str, Expr]]) -> None:
        """Lines that assign each of these, with its tail, as it is written."""
        for name, e in assigned:
            head, tail = self._of(e)
            if tail is None:
                self.lines.append(f"{name} = {head}")
            elif self.lines and self.lines[-1].startswith(f"{head}, {tail} = "):  # e's last operation: name its result
                self.lines[-1] = self.lines[-1].replace(f"{head}, {tail}", f"{name}, {name}t", 1)
                self._tailed.add(name)
            else:
                self.lines.append(f"{name}, {name}t = {head}, {tail}")
                self._tailed.add(name)

    def pair(self, name: str) -> str:
        """Head and tail of an assigned name, as arguments."""
        return f"{name}, {name}t" if name in self._tailed else f"{name}, 0.0"

    def _of(self, e: Expr) -> Number:
        if e.is_Symbol:
            return str(e), f"{e}t" if str(e) in self._tailed else None
        if isinstance(e, Rational):
            tail = float(e - Rational(float(e)))
            return repr(float(e)), repr(tail) if tail else None
        if e.is_Pow:
            return self._fold("times", [self._of(e.base)] * int(e.exp))
        return self._fold("plus" if e.is_Add else "times", [self._of(a) for a in e.args])

    def _fold(self, operation: str, parts: Sequence[Number]) -> Number:
        first, *rest = sorted(parts, key=lambda part: part[1] is not None)  # doubles first, which are cheap
        for part in rest:
            first = self._call(operation, first, part)
        return first

    def _call(self, operation: str, a: Number, b: Number) -> Number:
        if operation == "times" and a[1] is None and _power_of_two(a[0]):
            return f"{a[0]} * {b[0]}", f"{a[0]} * {b[1]}" if b[1] else None
        name = f"s{next(self._fresh)}"
        given = [part for number in sorted((a, b), key=lambda n: n[1] is not None) for part in number if part]
        kind = {2: "", 3: "_one", 4: "_two"}[len(given)]
        self.lines.append(f"{name}, {name}t = by.{operation}{kind}({', '.join(given)})")
        return name, f"{name}t"


def _power_of_two(text: str) -> bool:
    """Whether the text is a power of two, by which a product is exact."""
    try:
        return abs(float(text)).hex().startswith("0x1.0000000000000p")
    except ValueError:
        return False
