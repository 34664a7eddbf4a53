"""Fixed text of what several shared modules of stability functions have: their beginning, and elementary functions."""

POINTWISE = """
import math

import numpy as np
{imports}
# points of a block: a row of a block is one variable at all its points
BLOCK = {block}

# contract: a * b + c may become one operation, rounded once
"""

CALL_IMPORTS = """from llvmlite import ir
from numba import njit
from numba.core import cgutils, types
from numba.extending import intrinsic, overload
"""

# numba's cache does not notice a change of a function that another module calls; a call by address does not need it to
CALL = '''

@intrinsic
def _call_at(typing, address, arguments):
    """Call the C function at the address, with whole numbers, pointers, and pointers to the data of arrays."""

    def lower(context, builder, signature, values):
        given = []
        for kind, value in zip(signature.args[1], cgutils.unpack_tuple(builder, values[1])):
            if isinstance(kind, types.Array):
                given.append(context.make_array(kind)(context, builder, value).data)
            elif isinstance(kind, types.CPointer):
                given.append(value)
            else:
                given.append(context.cast(builder, value, kind, types.int64))
        kind = ir.FunctionType(ir.VoidType(), [value.type for value in given])
        builder.call(builder.inttoptr(values[0], kind.as_pointer()), given)
        return context.get_dummy_value()

    return types.none(types.int64, arguments), lower


def _call(function, *arguments):
    """Call a kernel of another module: in compiled code by its address."""
    function(*arguments)


@overload(_call)
def _call_compiled(function, *arguments):
    return lambda function, *arguments: _call_at(function, arguments)
'''

# numba does not vectorise log1p and atan2; these are polynomials of least maximal error without branches
LOG1P = '''

@_inline
def _log1p(u, m):
    """ln(1 + u), where m = 1 + u > 0; for u < -1/2 computed from m alone."""
    bits = np.float64(m).view(np.int64)
    k = (bits - 0x3FE6A09E667F3BCD) >> 52  # m = 2^k (1 + f), 1 + f from sqrt(1/2) to sqrt(2)
    rest = u - (m - 1.0) if u > -0.5 else 0.0  # the rounding error of m
    rest *= np.int64((1023 - k) << 52).view(np.float64)
    f = np.int64(bits - (k << 52)).view(np.float64) - 1.0
    s = f / (2.0 + f)
    z = s * s
    p = 0.1818356432645545 + z * (0.15314050542042326 + z * 0.14795949810482026)
    p = 0.39999999999414676 + z * (0.28571428742387633 + z * (0.22222198573179955 + z * p))
    half = 0.5 * f * f
    log = f - (half - (s * (half + z * (0.6666666666666734 + z * p)) + (rest + k * 1.9082149292705877e-10)))
    return k * 0.6931471803691238 + log  # ln 2 in two parts
'''

ANGLE = '''

@_inline
def _angle(y, x):
    """atan2(y, x) for y >= 0."""
    flat = abs(x)
    low, high = (flat, y) if y > flat else (y, flat)
    steep = low > 0.41421356237309503 * high  # tan(pi/8)
    t = (low - high) / (low + high) if steep else low / high
    z = t * t
    p = 0.07690083348291338 + z * (-0.06641246187674198 + z * (0.056931644865597986 + z * -0.043608244913722165))
    p += z * z * z * z * 0.02128013148948228
    p = 0.11111106703546104 + z * (-0.09090783528237137 + z * p)
    p = -0.3333333333333022 + z * (0.19999999999104665 + z * (-0.14285714196526547 + z * p))
    angle = t + t * z * p
    angle = 0.7853981633974483 + angle if steep else angle
    angle = 1.5707963267948966 - angle if y > flat else angle
    return 3.141592653589793 - angle if x < 0.0 else angle
'''

REFUSED = '''

@_inline
def _refused(Omega, xi, radius):
    """A negative integer if Omega or xi is negative or -0, or their sum is not finite: bits beyond the largest one."""
    a, b, largest = np.float64(Omega).view(np.int64), np.float64(xi).view(np.int64), np.int64(0x7FEFFFFFFFFFFFFF)
    return a | b | (largest - np.float64(abs(Omega + xi + radius)).view(np.int64))
'''
