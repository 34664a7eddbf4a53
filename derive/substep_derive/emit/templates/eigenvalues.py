"""The fixed text of eigenvalues in generated stability functions: a pair, or a pair and a real one."""

TWO_EIGENVALUES = '''

@_inline
def _radius(c2, b0, q, half, det):
    """Spectral radius; c2 times the pair's squared modulus; c2^2 times the square of half the pair's difference.

    Near lambda = 1, b0/c2 = det(I - A) and q/c2 = 1 - det A keep all digits; elsewhere trace and determinant do. There
    is only one division, the last, so that a pair on the unit circle has radius 1 exactly.
    """
    size, total = {size}, 0.5 * (b0 + q)
    split = total * total - b0 * c2 if abs(b0) < 0.5 * size else half * half - det * c2  # < 0: complex
    product = c2 - q if abs(q) < 0.5 * size else det
    real = 0.0 if split < 0.0 else abs(half)
    return (real + math.sqrt(product * c2 if split < 0.0 else split)) / size, product, split


@_inline
def _is_conservative({arguments}):
    """Whether the polynomial reads the same backwards, so that a complex pair is on the unit circle."""
    return xi == 0.0 and _asymmetry({arguments_no_xi}) == 0.0


@_inline
def _eigenvalues({arguments}):
    """Spectral radius; of the pair half +- i*root: half, less = modulus2 - 1, modulus2, root (-1 if real)."""
    c2, b0, q, half, det = _quadratic({arguments})
    radius, product, split = _radius(c2, b0, q, half, det)
    inverse = 1.0 / c2
    root = math.sqrt(abs(split)) * abs(inverse) if split < 0.0 else -1.0
    return radius, half * inverse, -q * inverse, product * inverse, root


@_inner
def _spectral_radii({arguments}, radius):
    """Store the spectral radius at each point; return all `_refused`, negative if one is."""
    refused = np.int64(0)
    for i in range(radius.size):
        radius[i], _, _ = _radius(*_quadratic({arguments_i}))
        refused |= _refused(Omega[i], xi[i], radius[i])
    return refused
'''

THREE_EIGENVALUES = '''

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


@_inline
def _is_conservative({arguments}):
    """Whether the polynomial, or it over lambda, reads the same backwards: a complex pair is on the unit circle."""
    w0, w1, y0, y1 = _asymmetry({arguments_no_xi})
    return xi == 0.0 and (abs(w0) + abs(w1) == 0.0 or abs(y0) + abs(y1) == 0.0)


@_inline
def _eigenvalues({arguments}, a2, a1, a0, b0, b1, third):
    """Spectral radius; of the pair half +- i*root: half, less = modulus2 - 1, modulus2, root (-1 if real); third."""
    half, less, modulus2, discriminant = _pair(a2, a1, a0, b0, b1, third)
    root = math.sqrt(abs(discriminant)) if discriminant > 0.0 else -1.0
    less, modulus2 = (0.0, 1.0) if _is_conservative({arguments}) else (less, modulus2)
    return _modulus(half, modulus2, discriminant, third), half, less, modulus2, root, third


@_inner
def _spectral_radii_of_block({arguments}, radius, s):
    """`_spectral_radii` of a block of points; in two loops, so that the processor overlaps their iterations."""
    refused = np.int64(0)
    for i in range(radius.size):
        s[0, i], s[1, i], s[2, i], s[3, i], s[4, i], s[5, i] = _monic(*_cubic({arguments_i}))
    for i in range(radius.size):
        half, _, modulus2, discriminant = _pair(s[0, i], s[1, i], s[2, i], s[3, i], s[4, i], s[5, i])
        radius[i] = _modulus(half, modulus2, discriminant, s[5, i])
        refused |= _refused(Omega[i], xi[i], radius[i])
    return refused


@_inner
def _spectral_radii({arguments}, radius):
    """Store the spectral radius at each point; return all `_refused`, negative if one is."""
    refused, s = np.int64(0), np.empty((6, {block}))
    for i in range(0, radius.size, {block}):
        k = min(i + {block}, radius.size)
        refused |= _spectral_radii_of_block({arguments_slice}, radius[i:k], s)
    return refused
'''
