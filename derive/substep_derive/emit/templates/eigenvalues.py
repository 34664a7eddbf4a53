"""The fixed text of the module that all stability functions are of, and of those that find two or three eigenvalues."""

STABILITY = '''"""Spectral radius, numerical damping and period error at many points, whatever the scheme."""
{compile}
{stored}{call}{refused}

def _rows(block):
    """The rows of an array: in compiled code their addresses."""
    return list(block)


@overload(_rows)
def _rows_compiled(block):
    return lambda block: np.array([block[k].ctypes.data for k in range(len(block))])


def _from(row, i):
    """A row from its i-th value on: in compiled code by its address."""
    return row[i:]


@overload(_from)
def _from_compiled(row, i):
    return lambda row, i: row + 8 * i


def look(n, points, radius, seen):
    """Store whether any of n points of a block is refused, and how many have Omega < {small_Omega}."""
    Omegas, xis = points[0], points[1]
    refused, near = np.int64(0), 0
    for i in range(n):
        refused |= _refused(Omegas[i], xis[i], radius[i])
        near += Omegas[i] < {small_Omega}
    seen[0], seen[1] = 1.0 if refused < 0 else 0.0, float(near)


@_compile
def stability(look, polynomial, find, place, defect, errors, sizes, block, varying, inputs, large, out, begin, end):
    """Store the spectral radius in row 0 of out, columns begin to end; in two more rows, damping and period error.

    block: a row each for Omega, xi and the parameters of a scheme, and two rows of scratch. Those that `varying` names
    differ from point to point: each is read from the column `begin` of its array in inputs on. These are arrays or, as
    the functions, addresses. polynomial, defect: of the scheme's module; find, sizes, and `radii` or, for three rows,
    `eigenvalues` for `place`: of the module that finds its eigenvalues, find is 0 where that has none; errors: of the
    module of that name. damping: that of the complex pair of largest modulus, less the physical one; period: the
    numerical period over the exact one, less 1; both are NaN where all eigenvalues are real. Returns whether any
    Omega, xi or radius is negative or not finite, and whether any damping or period is `large` in size, or NaN.
    """
    refused, beyond, all_three = False, 0, out.shape[0] == 3
    points, seen = _rows(block), np.empty(2)
    rows_count, found_count, others, conjugates = sizes
    rows, found = np.empty(rows_count * BLOCK), np.empty(found_count * BLOCK)
    exact = np.empty(7 * BLOCK if all_three else 0)  # what `defect` stores, and two rows of scratch
    for first in range(begin, end, BLOCK):
        n = min(BLOCK, end - first)
        for j in range(len(varying)):
            points[varying[j]] = _from(inputs[j], first)
        if find == 0:
            _call(polynomial, n, points, rows)
        else:
            _call(find, polynomial, n, len(block) - 2, points, rows, found)
        radius = out[0, first : first + n]
        _call(place, n, points, rows, found, radius)
        _call(look, n, points, radius, seen)
        refused |= seen[0] > 0.0
        if all_three:
            near = np.int64(seen[1])
            if near > 0:
                _call(defect, n, points, exact)
            damping = out[1, first : first + n]
            period = out[2, first : first + n]
            _call(errors, n, near, others, conjugates, points, rows, found, exact, damping, period)
            for i in range(n):
                beyond += not (abs(damping[i]) < large and period[i] < large)
    return refused, beyond > 0
'''

SIZES = """
# rows of a block that are read, and stored; other eigenvalues than the largest pair, each beside its conjugate or not
SIZES = {rows}, {found}, {others}, {conjugates}
"""

TWO_EIGENVALUES = '''"""Eigenvalues of schemes that have a pair which is not always 0."""
{compile}{sizes}

@_inline
def _radius(c2, b0, q, half, det):
    """|c2| times the spectral radius; c2 times the pair's squared modulus; c2^2 times that of half its difference.

    Near lambda = 1, b0/c2 = det(I - A) and q/c2 = 1 - det A keep all digits; elsewhere trace and determinant do.
    Nothing is divided by c2 here, so that a pair on the unit circle has radius 1 exactly.
    """
    size, total = abs(c2), 0.5 * (b0 + q)
    split = total * total - b0 * c2 if abs(b0) < 0.5 * size else half * half - det * c2  # < 0: complex
    product = c2 - q if abs(q) < 0.5 * size else det
    real = 0.0 if split < 0.0 else abs(half)
    return real + math.sqrt(product * c2 if split < 0.0 else split), product, split


@_inline
def _divided(x, c, inverse):
    """x/c from 1/c: with the remainder, which a fused multiply-add has exactly, it is rounded as a division is."""
    y = x * inverse
    return y + (x - c * y) * inverse


def radii(n, points, rows, found, radius):
    """Store the spectral radius at n points of a block, from what the scheme's `polynomial` has stored."""
    for i in range(n):
        largest, _, _ = _radius(
            rows[BLOCK + i], rows[2 * BLOCK + i], rows[3 * BLOCK + i], rows[4 * BLOCK + i], rows[5 * BLOCK + i]
        )
        radius[i] = largest / abs(rows[BLOCK + i])


def eigenvalues(n, points, rows, found, radius):
    """Store the radius, and in found half the trace, modulus^2 - 1, modulus^2 and imaginary part of the largest pair.

    The imaginary part is -1 where no pair is complex. Below are real and imaginary part of each other eigenvalue.
    """
    for i in range(n):
        c2, b0, q, half = rows[BLOCK + i], rows[2 * BLOCK + i], rows[3 * BLOCK + i], rows[4 * BLOCK + i]
        largest, product, split = _radius(c2, b0, q, half, rows[5 * BLOCK + i])
        inverse = 1.0 / c2
        found[i], found[BLOCK + i], found[2 * BLOCK + i] = half * inverse, -q * inverse, product * inverse
        found[3 * BLOCK + i] = math.sqrt(abs(split)) * abs(inverse) if split < 0.0 else -1.0
        radius[i] = _divided(largest, abs(c2), abs(inverse))
'''

THREE_EIGENVALUES = '''"""Eigenvalues of schemes that have three which are not always 0: a pair, and a real one."""
{compile}{sizes}

@_inline
def _closer(y, p, size):
    """One step, of fourth order, from y towards the positive root of y^3 + 3 p y = size."""
    f, slope = y * (y * y + 3.0 * p) - size, 3.0 * (y * y + p)
    bend = slope * slope - 3.0 * y * f
    return y - f * bend / (slope * (bend - 3.0 * y * f) + f * f + 1e-300)


@_inline
def _real_root(a2, a1, a0):
    """The real root of x^3 + a2 x^2 + a1 x + a0 that is farthest from the other two.

    Its distance y from the point of inflection is the one positive root of y^3 + 3 p y = size. The first guess is
    y^2 = size^(2/3) - 3 p or, for p > 0, y^-2 = size^(-2/3) + 9 p^2/size^2, with powers approximated by integer
    arithmetic on the bits of the numbers. It is within 16 %, which two steps of fourth order reduce to rounding.
    """
    middle = -1.0 / 3.0 * a2
    p = 1.0 / 3.0 * (a1 + a2 * middle)
    value = ((middle + a2) * middle + a1) * middle + a0
    size = abs(value)
    third = (np.float64(size).view(np.int64) >> 32) * 0x55555556 >> 32
    k = np.int64((0x553EF0FF - third) << 32).view(np.float64)  # size^(-1/3)
    k *= k
    y2 = k * (1.0 + 9.0 * p * p * k * k) if p > 0.0 else size * k * size * k - 3.0 * p
    bits = np.float64(y2).view(np.int64) >> 1
    y = np.int64(0x5FE62FD000000000 - bits if p > 0.0 else 0x1FF6C8FE00000000 + bits).view(np.float64)
    y = _closer(_closer(y, p, size), p, size)
    return middle - y if value > 0.0 else middle + y


@_inline
def _monic(c3, c2, c1, c0, b0, b1):
    """The other coefficients, b0 and b1 divided by c3; and the third eigenvalue, which is real."""
    inverse = 1.0 / c3
    a2, a1, a0 = c2 * inverse, c1 * inverse, c0 * inverse
    return a2, a1, a0, b0 * inverse, b1 * inverse, _real_root(a2, a1, a0)


@_inline
def _pair(a2, a1, a0, b0, b1, third):
    """Half the trace, modulus^2 - 1, modulus^2 and discriminant of the pair beside the third eigenvalue.

    The pair's quadratic is the cubic divided by lambda - third. For a pair near 1 its value P at 1 and Q = 1 - det
    follow from b0 and b1 with all digits. For other pairs trace and determinant follow from polynomial division, which
    begins at the lowest coefficient if the third eigenvalue is larger than the pair, else at the highest.
    """
    m = 1.0 - third
    divisor, safe_m = third if third != 0.0 else 1.0, m if m != 0.0 else 1.0
    both = 1.0 / (divisor * safe_m)
    over_m, over_third = both * divisor, both * safe_m
    P = b0 * over_m
    T = (b1 - P) * over_m
    Q = T - P
    det, last = a1 + third * (a2 + third), -a0 * over_third
    backward = third * third > abs(det)
    det = last if backward else det
    half = 0.5 * ((a1 - last) * over_third if backward else -(a2 + third))
    beside = P < 0.5 and P < 0.5 * m * m and T * T < m * m  # the pair is nearer to 1 than third is
    half = 1.0 - 0.5 * T if beside else half
    discriminant = P - 0.25 * T * T if beside else det - half * half
    less = -Q if beside and Q < 0.5 else det - 1.0
    return half, less, 1.0 - Q if beside and Q < 0.5 else det, discriminant


@_inline
def _modulus(half, modulus2, discriminant, third):
    """The largest modulus of the three eigenvalues."""
    real = 0.0 if discriminant > 0.0 else abs(half)
    modulus = real + math.sqrt(abs(modulus2 if discriminant > 0.0 else discriminant))  # one root, never of a negative
    return modulus if modulus > abs(third) else abs(third)


@_inner
def _prepare(n, rows, found):
    """Store the coefficients over the highest one, and the real root."""
    for i in range(n):
        a2, a1, a0, b0, b1, third = _monic(
            rows[BLOCK + i], rows[2 * BLOCK + i], rows[3 * BLOCK + i], rows[4 * BLOCK + i], rows[5 * BLOCK + i],
            rows[6 * BLOCK + i],
        )
        found[i], found[BLOCK + i], found[2 * BLOCK + i] = a2, a1, a0
        found[3 * BLOCK + i], found[4 * BLOCK + i], found[5 * BLOCK + i] = b0, b1, third


def radii(n, points, rows, found, radius):
    """Store the spectral radius at n points of a block, from what the scheme's `polynomial` has stored."""
    _prepare(n, rows, found)
    for i in range(n):
        third = found[5 * BLOCK + i]
        half, _, modulus2, discriminant = _pair(
            found[i], found[BLOCK + i], found[2 * BLOCK + i], found[3 * BLOCK + i], found[4 * BLOCK + i], third
        )
        radius[i] = _modulus(half, modulus2, discriminant, third)


def eigenvalues(n, points, rows, found, radius):
    """Store the radius, and in found half the trace, modulus^2 - 1, modulus^2 and imaginary part of the largest pair.

    The imaginary part is -1 where no pair is complex. Below are real and imaginary part of each other eigenvalue.
    """
    _prepare(n, rows, found)
    for i in range(n):
        third = found[5 * BLOCK + i]
        half, less, modulus2, discriminant = _pair(
            found[i], found[BLOCK + i], found[2 * BLOCK + i], found[3 * BLOCK + i], found[4 * BLOCK + i], third
        )
        largest = _modulus(half, modulus2, discriminant, third)
        on_circle = rows[i] != 0.0
        found[i] = half
        found[BLOCK + i], found[2 * BLOCK + i] = 0.0 if on_circle else less, 1.0 if on_circle else modulus2
        found[3 * BLOCK + i] = math.sqrt(abs(discriminant)) if discriminant > 0.0 else -1.0
        found[4 * BLOCK + i], found[5 * BLOCK + i] = third, 0.0
        radius[i] = largest
'''
