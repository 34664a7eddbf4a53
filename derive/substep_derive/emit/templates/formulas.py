"""Fixed text of the module that evaluates formulas of schemes at many points, and of functions that hold formulas."""

FORMULAS = '''"""Formulas evaluated at many points: programs of sums and products, also in pairs of doubles.

A pair is a head and a tail, which is the head's rounding error: 32 digits in all. A program is recorded once from a
function that holds formulas, such as `coefficients` of a scheme's module, so that no scheme's formulas are compiled.
"""

import numpy as np
from numba import njit

WIDTH = {width}  # points of a block, each number of which has a row
FAR = 1 << 50  # beyond any index; loops are vectorised if their first index is known to lie from 0 to FAR
# in the order of their numbers: sums and products of two doubles, of a double and a pair (_one), and of two pairs,
# which are pairs; the quotient of two pairs as a double; then what makes a double of two doubles
OPERATIONS = (
    "plus", "plus_one", "plus_two", "times", "times_one", "times_two", "over",
    "add", "subtract", "multiply", "divide",
)
_PLUS, _PLUS_ONE, _PLUS_TWO, _TIMES, _TIMES_ONE, _TIMES_TWO, _OVER, _ADD, _SUBTRACT, _MULTIPLY = range(10)

# tails are rounding errors, which fastmath would remove
_compile = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
_inline = njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, forceinline=True)


@_inline
def _plus(a, b):
    """The sum of two doubles: head, and tail, which is the rounding error of the head."""
    head = a + b
    rest = head - a
    return head, (a - (head - rest)) + (b - rest)


@_inline
def _times(a, b):
    """The product of two doubles: head and tail, from halves of their digits, whose products are exact."""
    head, c, d = a * b, 134217729.0 * a, 134217729.0 * b
    a1, b1 = c - (c - a), d - (d - b)
    a2, b2 = a - a1, b - b1
    return head, ((a1 * b1 - head) + a1 * b2 + a2 * b1) + a2 * b2


@_inline
def _pair(head, tail):
    """The same sum with a tail that is its rounding error."""
    total = head + tail
    return total, tail - (total - head)


@_compile
def evaluate(operations, numbers, outputs, rows, inputs, out):
    """Do the operations (n, 7) at all points; inputs (k, P), out (m, P).

    operations: the kind, the rows of the result and its tail, of the first operand and its tail, and of the second one;
    rows that a kind does not need are any. Of the rows the first hold the numbers, the next ones the inputs. outputs
    (m,): the rows of what is returned.
    """
    s = np.empty(rows * WIDTH)
    constants, given = numbers.size, inputs.shape[0]
    for i in range(constants):
        for j in range(min(WIDTH, inputs.shape[1])):
            s[i * WIDTH + j] = numbers[i]
    for first in range(0, inputs.shape[1], WIDTH):
        size = min(WIDTH, inputs.shape[1] - first)
        for i in range(given):
            for j in range(size):
                s[(constants + i) * WIDTH + j] = inputs[i, first + j]
        for k in range(operations.shape[0]):
            kind = operations[k, 0]
            r, r_ = min(max(operations[k, 1] * WIDTH, 0), FAR), min(max(operations[k, 2] * WIDTH, 0), FAR)
            p, p_ = min(max(operations[k, 3] * WIDTH, 0), FAR), min(max(operations[k, 4] * WIDTH, 0), FAR)
            q, q_ = min(max(operations[k, 5] * WIDTH, 0), FAR), min(max(operations[k, 6] * WIDTH, 0), FAR)
            if kind == _PLUS:
                for j in range(size):
                    s[r + j], s[r_ + j] = _plus(s[p + j], s[q + j])
            elif kind == _PLUS_ONE:
                for j in range(size):
                    head, tail = _plus(s[p + j], s[q + j])
                    s[r + j], s[r_ + j] = _pair(head, tail + s[q_ + j])
            elif kind == _PLUS_TWO:
                for j in range(size):
                    head, tail = _plus(s[p + j], s[q + j])
                    s[r + j], s[r_ + j] = _pair(head, tail + (s[p_ + j] + s[q_ + j]))
            elif kind == _TIMES:
                for j in range(size):
                    s[r + j], s[r_ + j] = _times(s[p + j], s[q + j])
            elif kind == _TIMES_ONE:
                for j in range(size):
                    a, b, b_ = s[p + j], s[q + j], s[q_ + j]
                    head, tail = _times(a, b)
                    s[r + j], s[r_ + j] = _pair(head, tail + a * b_)
            elif kind == _TIMES_TWO:
                for j in range(size):
                    a, a_, b, b_ = s[p + j], s[p_ + j], s[q + j], s[q_ + j]
                    head, tail = _times(a, b)
                    s[r + j], s[r_ + j] = _pair(head, tail + (a * b_ + a_ * b))
            elif kind == _OVER:
                for j in range(size):
                    a, a_, b, b_ = s[p + j], s[p_ + j], s[q + j], s[q_ + j]
                    head = a / b
                    product, tail = _times(head, b)
                    s[r + j] = head + ((a - product) - tail + a_ - head * b_) / b
            elif kind == _ADD:
                for j in range(size):
                    s[r + j] = s[p + j] + s[q + j]
            elif kind == _SUBTRACT:
                for j in range(size):
                    s[r + j] = s[p + j] - s[q + j]
            elif kind == _MULTIPLY:
                for j in range(size):
                    s[r + j] = s[p + j] * s[q + j]
            else:
                for j in range(size):
                    s[r + j] = s[p + j] / s[q + j]
        for i in range(outputs.size):
            p = min(max(outputs[i] * WIDTH, 0), FAR)
            for j in range(size):
                out[i, first + j] = s[p + j]
'''

FUNCTION = '''

def {name}({arguments}):
    """{doc}"""
{lines}    return {returned}
'''

AMPLIFICATION = "Amplification matrix ({m}, {m}) in the order of STATE, row by row."

STENCIL = "Instants at which the load is taken, in steps after t_n."

COEFFICIENTS = """D, B, O, P of {march}: x1 = x0 + D x0 + B h^2 f and y1 = O x0 + P h^2 f.

    Their entries, matrix by matrix and row by row. D is computed in pairs of doubles and rounded once. Columns of B and
    P beyond the scheme's own load instants, up to the march's {K}, are zero.
    """

TRANSFER = """Filter from a load, linear between steps, to the response from rest (see linear_filter).

    P, g1, ..., k of u, S, k of h*v, k of h^2*a. In a step e0 = h^2 f + g1 e1 + ... - P q, then q += e0,
    u = S (q + k0 e0 + k1 e1 + ...) and h*v, h^2*a = k0 e0 + k1 e1 + ...; e1, e2, ... are e0 of the steps before.
    """

START = """The state at t = 0: S (u, h*v, h^2*a) + T h^2 f(START_STENCIL*h), f the loads.

    The entries of S ({m}, 3), then those of T ({m}, {K}), row by row.
    """
