"""Formulas of a scheme's module at many points, without compiling them.

A function that holds formulas, such as `coefficients` of a generated module, is called once, with numbers that record
what is done with them. The kernel `formulas`, one for all functions, then does it at every point.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .kernel_modules import loaded

Pair = tuple[Any, Any]  # head and tail


def evaluated(function: Callable[..., Sequence[Any]], P: int, arguments: Sequence[Array]) -> Array:
    """What the function returns (m, P) at P points; arguments: those after the first one, numbers or (P,) each."""
    return at_points(function, arguments)(slice(0, P))


def at_points(function: Callable[..., Sequence[Any]], arguments: Sequence[Array]) -> Callable[[slice], Array]:
    """What gives the values (m, p) of the function at some of the points; arguments: as for `evaluated`.

    One that is the same at all points, a number or a row without strides, is read once.
    """
    fixed = tuple(not x.ndim or (x.strides == (0,) and len(x) > 0) for x in map(np.asarray, arguments))
    program, own = _program(function, fixed), [x for x, one in zip(arguments, fixed, strict=True) if not one]
    numbers = [np.asarray(x).flat[0] for x, one in zip(arguments, fixed, strict=True) if one]
    known, evaluate = np.concatenate([program.numbers, numbers]), loaded("shared.formulas").evaluate

    def values(some: slice) -> Array:
        inputs = np.empty((len(own), some.stop - some.start))
        for row, x in zip(inputs, own, strict=True):
            row[:] = x[some]
        out = np.empty((len(program.outputs), inputs.shape[1]))
        evaluate(program.operations, known, program.outputs, program.rows, inputs, out)
        return out

    return values


def _paired(kind: str, first: int) -> Callable[..., Pair]:
    """An operation of `Pairs`; first: how many of the numbers given are its first operand, 1, or 2 for a pair."""

    def recorded(self: "Pairs", *numbers: Any) -> Pair:
        return self.record.pair(kind, numbers[:first], numbers[first:])

    return recorded


class Pairs:
    """Arithmetic in pairs of doubles, head and tail, as formulas call it; the kernels' own operations are recorded.

    The names say how many operands are pairs: none, the second one (_one), or both (_two).
    """

    def __init__(self, record: "_Record") -> None:
        self.record = record

    plus, times = _paired("plus", 1), _paired("times", 1)  # of a, b
    plus_one, times_one = _paired("plus_one", 1), _paired("times_one", 1)  # of a, b, b_
    plus_two, times_two = _paired("plus_two", 2), _paired("times_two", 2)  # of a, a_, b, b_

    def over(self, a: Any, a_: Any, b: Any, b_: Any) -> Any:
        """a/b, rounded to a double."""
        return self.record.double("over", (a, a_), (b, b_))

    def difference(self, a: Any, a_: Any, b: Any, b_: Any, c: Any, c_: Any, d: Any, d_: Any) -> Pair:
        """a*b - c*d."""
        return self.plus_two(*self.times_two(a, a_, b, b_), *self.times_two(-c, -c_, d, d_))

    # a + b*L is the matrix [[a, b], [w0*b, a + w1*b]], with L^2 = w0 + w1*L

    def horner(
        self, a: Any, a_: Any, b: Any, b_: Any, w0: Any, w0_: Any, w1: Any, w1_: Any, c: Any, c_: Any
    ) -> tuple[Any, ...]:
        """(a + b*L) L + c."""
        x = self.plus_two(*self.times_two(w0, w0_, b, b_), c, c_)
        y = self.plus_two(*self.times_two(w1, w1_, b, b_), a, a_)
        return *x, *y

    def conjugate(self, a: Any, a_: Any, b: Any, b_: Any, w0: Any, w0_: Any, w1: Any, w1_: Any) -> tuple[Any, ...]:
        """The c + d*L whose product with a + b*L is a number, and that number."""
        c, c_ = self.plus_two(*self.times_two(w1, w1_, b, b_), a, a_)
        square = self.times_two(-w0, -w0_, *self.times_two(b, b_, b, b_))
        return c, c_, -b, -b_, *self.plus_two(*self.times_two(a, a_, c, c_), *square)

    def product(
        self, a: Any, a_: Any, b: Any, b_: Any, c: Any, c_: Any, d: Any, d_: Any, w0: Any, w0_: Any, w1: Any, w1_: Any
    ) -> tuple[Any, ...]:
        """(a + b*L) (c + d*L)."""
        x, y = self.times_two(a, a_, d, d_), self.times_two(b, b_, d, d_)
        x0, x0_, y0, y0_ = self.horner(*x, *y, w0, w0_, w1, w1_, 0.0, 0.0)
        return *self.plus_two(x0, x0_, *self.times_two(a, a_, c, c_)), *self.plus_two(
            y0, y0_, *self.times_two(b, b_, c, c_)
        )


def _binary(kind: str) -> tuple[Callable[..., "_Number"], Callable[..., "_Number"]]:
    """An operation of a number with another one to its right, and with one to its left."""

    def left(self: "_Number", other: Any) -> "_Number":
        return self.record.double(kind, (self,), (other,))

    def right(self: "_Number", other: Any) -> "_Number":
        return self.record.double(kind, (other,), (self,))

    return left, right


class _Number:
    """A double in a formula: an input, or the result of an operation."""

    __slots__ = ("name", "record")

    def __init__(self, record: "_Record", name: int) -> None:
        self.record, self.name = record, name

    __add__, __radd__ = _binary("add")
    __sub__, __rsub__ = _binary("subtract")
    __mul__, __rmul__ = _binary("multiply")
    __truediv__, __rtruediv__ = _binary("divide")

    def __neg__(self) -> "_Number":
        return self.record.double("multiply", (-1.0,), (self,))

    def __pow__(self, exponent: Any) -> "_Number | float":
        if not isinstance(exponent, int):
            raise TypeError(f"expected a whole power in a formula, got {exponent!r}: formulas are rational functions")
        if exponent < 1:
            return 1.0 / self**-exponent if exponent else 1.0
        half = self ** (exponent // 2) if exponent > 1 else None
        square = None if half is None else half * half
        return self if square is None else square * self if exponent % 2 else square


class _Record:
    """Operations in their order. The names of numbers count up; a constant's name is its bits."""

    def __init__(self) -> None:
        self.operations: list[tuple[str, tuple[int, ...], tuple[Any, ...], tuple[Any, ...]]] = []
        self.constants: dict[bytes, float] = {}
        self._names = 0

    def number(self) -> _Number:
        """A new number."""
        self._names += 1
        return _Number(self, self._names)

    def double(self, kind: str, a: tuple[Any, ...], b: tuple[Any, ...]) -> _Number:
        """The result of an operation between two numbers, or pairs of such."""
        return self._done(kind, 1, a, b)[0]

    def pair(self, kind: str, a: tuple[Any, ...], b: tuple[Any, ...]) -> Pair:
        """The result with its tail."""
        head, tail = self._done(kind, 2, a, b)
        return head, tail

    def _done(self, kind: str, size: int, a: tuple[Any, ...], b: tuple[Any, ...]) -> list[_Number]:
        made = [self.number() for _ in range(size)]
        names = tuple(x.name for x in made)
        self.operations.append((kind, names, tuple(map(self.name, a)), tuple(map(self.name, b))))
        return made

    def name(self, x: Any) -> int | bytes:
        """The name of a number, or of a constant, which is kept."""
        if isinstance(x, _Number):
            return x.name
        bits = np.float64(x).tobytes()  # -0.0 is not 0.0
        self.constants[bits] = float(x)
        return bits


@dataclass(frozen=True, eq=False)
class _Program:
    """Arguments of the kernel `evaluate`, without the points and the numbers that are the same at all of them."""

    operations: NDArray[np.int64]
    numbers: Array
    outputs: NDArray[np.int64]
    rows: int


@cache
def _program(function: Callable[..., Sequence[Any]], fixed: tuple[bool, ...]) -> _Program:
    """What the function does with these arguments. A row is used again once its number was read for the last time.

    fixed: which of them are the same at all points; their rows come first.
    """
    record = _Record()
    inputs = [record.number() for _ in fixed]
    outputs = [record.name(x) for x in function(Pairs(record), *inputs)]
    kinds = {name: k for k, name in enumerate(loaded("shared.formulas").OPERATIONS)}
    names = [x.name for _, x in sorted(zip(fixed, inputs, strict=True), key=lambda pair: not pair[0])]
    row: dict[Any, int] = {name: k for k, name in enumerate([*record.constants, *names])}
    last = {name: k for k, (_, made, a, b) in enumerate(record.operations) for name in (*made, *a, *b)}
    kept, rows, free = {*row, *outputs}, len(row), list[int]()
    operations = np.zeros((len(record.operations), 7), np.int64)
    for k, (kind, made, a, b) in enumerate(record.operations):
        for name in made:  # not the rows of the operands, in which loops could not be vectorised
            row[name] = free.pop() if free else rows
            rows = max(rows, row[name] + 1)
        operations[k, 0] = kinds[kind]
        for at, names in ((1, made), (3, a), (5, b)):
            operations[k, at : at + len(names)] = [row[name] for name in names]
        free += [row[name] for name in dict.fromkeys((*made, *a, *b)) if last[name] == k and name not in kept]
    numbers = np.array(list(record.constants.values()))
    return _Program(operations, numbers, np.array([row[name] for name in outputs], np.int64), rows)
