"""The fixed text of generated stability functions; every {field} is filled by `emit`."""

# numba knows no vector log1p, atan2 or expm1: polynomials of least maximal error, and no branch but selects
ELEMENTARY = '''
# no fastmath: contraction is 12 % faster, but then the last bit depends on a point's place in its array
_inline = njit(nogil=True, error_model="numpy", forceinline=True)


@_inline
def _log1p(u, m):
    """ln(1 + u), where m = 1 + u > 0; for u < -1/2 from m alone."""
    bits = np.float64(m).view(np.int64)
    k = (bits - 0x3FE6A09E667F3BCD) >> 52  # m = 2^k (1 + f), 1 + f from sqrt(1/2) to sqrt(2)
    rest = u - (m - 1.0) if u > -0.5 else 0.0  # what rounding took from m
    rest *= np.int64((1023 - k) << 52).view(np.float64)
    f = np.int64(bits - (k << 52)).view(np.float64) - 1.0
    s = f / (2.0 + f)
    z = s * s
    p = 0.1818356432645545 + z * (0.15314050542042326 + z * 0.14795949810482026)
    p = 0.39999999999414676 + z * (0.28571428742387633 + z * (0.22222198573179955 + z * p))
    half = 0.5 * f * f
    log = f - (half - (s * (half + z * (0.6666666666666734 + z * p)) + (rest + k * 1.9082149292705877e-10)))
    return k * 0.6931471803691238 + log  # ln 2 in two parts


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


@_inline
def _expm1(x):
    """exp(x) - 1."""
    x = -40.0 if x < -40.0 else (710.0 if x > 710.0 else x)
    shifted = 1.4426950408889634 * x + 6755399441055744.0  # its last bits are those of the integer k
    k = np.float64(shifted).view(np.int64) - 0x4338000000000000
    turns = shifted - 6755399441055744.0
    r = x - turns * 0.6931471803691238 - turns * 1.9082149292705877e-10
    p = 1.0 / 3628800.0 + r * (1.0 / 39916800.0 + r * (1.0 / 479001600.0 + r * (1.0 / 6227020800.0)))
    p = 1.0 / 5040.0 + r * (1.0 / 40320.0 + r * (1.0 / 362880.0 + r * p))
    p = 0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * p))))
    half = np.int64((k + 1022) << 52).view(np.float64)  # 2^(k - 1), which does not overflow
    return 2.0 * (half * (r + r * r * p) + (half - 0.5))
'''

TWO_EIGENVALUES = '''

@_inline
def _pair(c2, b0, q, trace, det):
    """(radius, half trace, squared modulus less 1, that modulus, root of discriminant, complex) of the live pair.

    P = b0/c2 = det(I - A) and Q = q/c2 = 1 - det A keep the digits of what is near 1; far from it
    trace and determinant do.
    """
    inverse = 1.0 / c2
    P, Q, half, modulus2 = b0 * inverse, q * inverse, 0.5 * trace * inverse, det * inverse
    discriminant = P - 0.25 * (P + Q) * (P + Q) if P < 0.5 else modulus2 - half * half
    modulus2 = 1.0 - Q if Q < 0.5 else modulus2
    root = math.sqrt(abs(discriminant))  # abs: a root that cannot fail is one instruction
    radius = math.sqrt(abs(modulus2)) if discriminant > 0.0 else abs(half) + root
    return radius, half, -Q, modulus2, root, discriminant > 0.0


@_inline
def _radius({arguments}):
    """Spectral radius at one point."""
    return _pair(*_quadratic({arguments}))[0]


@_inline
def _far({arguments}):
    """Spectral radius, numerical damping and period error from the eigenvalues themselves."""
    radius, half, less, modulus2, root, is_complex = _pair(*_quadratic({arguments}))
    angle, square = _angle(root, half), abs(1.0 - xi * xi)
    cosine = math.sqrt(square)
    inverse = 1.0 / (angle * cosine)
    damping = 0.0 - (0.5 * _log1p(less, modulus2) * cosine + xi * angle) * inverse
    period = Omega * square * inverse - 1.0
    return radius, damping if is_complex and xi < 1.0 else math.nan, period if is_complex and xi < 1.0 else math.nan


@_inline
def _near({arguments}):
    """Numerical damping and period error from what the exact eigenvalue e^s leaves over in the polynomial.

    With w = Re(c2 e^s + det e^-s - trace) and g = det e^(2 xi Omega) - c2, which are small and known to
    all digits: 1 + g/c2 is the squared modulus over the exact one, and half the angle's error has the tangent below.
    """
    quadratic = _quadratic({arguments})
    tails = _tails(Omega, xi)
    w, g = _defect({arguments}, *tails)
    c2 = quadratic[0]
    radius, _, _, _, root, is_complex = _pair(*quadratic)
    cosine = math.sqrt(abs(1.0 - xi * xi))
    exact = cosine * Omega
    z = exact * exact
    sine = -1.0 / 6.0 + z * (1.0 / 120.0 + z * (-1.0 / 5040.0 + z * (1.0 / 362880.0 - z / 39916800.0)))
    sine = exact + exact * z * sine
    gain = g / c2
    grown = 1.0 + math.sqrt(abs(1.0 + gain))
    decay = 1.0 + Omega * (tails[0] + Omega * tails[1])  # Re(e^s)
    tangent = 0.5 * (w - decay * g * gain / (grown * grown)) / (c2 * (root + radius * sine))
    shift = 2.0 * _angle(abs(tangent), 1.0)
    shift = shift if tangent > 0.0 else -shift
    inverse = 1.0 / (exact + shift)
    damping = 0.0 - (0.5 * _log1p(gain, 1.0 + gain) + xi * shift / cosine) * inverse
    period = 0.0 - shift * inverse
    nothing = math.nan if xi >= 1.0 or (Omega > 0.0 and not is_complex) else 0.0
    moving = Omega > 0.0 and is_complex and xi < 1.0
    return damping if moving else nothing, period if moving else nothing
'''

TAILS = '''

@_inline
def _tails(Omega, xi):
    """Tails of exponentials whose first terms a scheme cancels.

    e_k = Re(s^k/k! + s^(k+2)/(k+2)! + ...)/Omega^k, and f_k = 1/k! + y/(k+1)! + ... at y = 2 xi Omega.
    """
    x, y, z = 2.0 * xi, 2.0 * xi * Omega, Omega * Omega
    t2 = 0.5 * x * x - 1.0  # t_k = Re(s^k)/Omega^k
    t3, t4 = -x * t2 + xi, 2.0 * t2 * t2 - 1.0
    t5, t6 = 2.0 * t2 * t3 + xi, 2.0 * t3 * t3 - 1.0
    t7, t8, t9 = 2.0 * t3 * t4 + xi, 2.0 * t4 * t4 - 1.0, 2.0 * t4 * t5 + xi
    turn, z2 = 2.0 * t2 * z, z * z  # s^4 = turn*s^2 - z^2
    c = 1.0 / 3628800.0 + turn * (1.0 / 479001600.0)
    b = 1.0 / 40320.0 + turn * c - z2 * (1.0 / 479001600.0)
    e6 = t6 * (1.0 / 720.0 - z2 * c) + z * t8 * b
    c = 1.0 / 39916800.0 + turn * (1.0 / 6227020800.0)
    b = 1.0 / 362880.0 + turn * c - z2 * (1.0 / 6227020800.0)
    e7 = t7 * (1.0 / 5040.0 - z2 * c) + z * t9 * b
    e5 = t5 * (1.0 / 120.0) + z * e7
    e4, e3 = t4 * (1.0 / 24.0) + z * e6, t3 * (1.0 / 6.0) + z * e5
    e2, e1 = t2 * 0.5 + z * e4, -xi + z * e3
    f = 1.0 / 3628800.0 + y * (1.0 / 39916800.0 + y * (1.0 / 479001600.0 + y * (1.0 / 6227020800.0)))
    f6 = 1.0 / 720.0 + y * (1.0 / 5040.0 + y * (1.0 / 40320.0 + y * (1.0 / 362880.0 + y * f)))
    f5 = 1.0 / 120.0 + y * f6
    f4 = 1.0 / 24.0 + y * f5
    f3 = 1.0 / 6.0 + y * f4
    f2 = 0.5 + y * f3
    return e1, e2, e3, e4, e5, e6, e7, 1.0 + y * f2, f2, f3, f4, f5, f6
'''

BLOCK = '''

@_compile
def _block({arguments}, radius, damping, period):
    """Of all points, then anew of those near Omega = 0, where the difference from the exact decides."""
    count = 0
    for i in range(radius.size):
        radius[i], damping[i], period[i] = _far({arguments_i})
        count += Omega[i] < {small_Omega}
    if count > 0:
        where, x, y = np.empty(count, np.int64), np.empty(({size}, count)), np.empty((2, count))
        k = 0
        for i in range(radius.size):
            if Omega[i] < {small_Omega}:
                where[k], {gathered} = i, {arguments_i}
                k += 1
        for k in range(count):
            y[0, k], y[1, k] = _near({gathered})
        for k in range(count):
            damping[where[k]], period[where[k]] = y[0, k], y[1, k]
'''

TAILS_OF_MANY = '''

@_compile
def _tails(Omega, xi, columns):
    """What powers of Omega from {terms} on add to the residual of `_defect`."""
    c = np.array(columns).reshape({rows}, {powers})
    term = np.empty({terms} + 20, dtype=np.complex128)
    residual = 0j
    for j in range({rows}):
        w = j * complex(-xi * Omega, math.sqrt(1.0 - xi * xi) * Omega)
        term[0] = 1.0
        for k in range(1, term.size):
            term[k] = term[k - 1] * w / k
        for k in range(term.size - 2, -1, -1):  # from here term[k] holds the exponential's tail from w^k on
            term[k] += term[k + 1]
        for i in range({powers}):
            residual += c[j, i] * Omega**i * term[max({terms} - i, 0)]
    return residual
'''

MORE_EIGENVALUES = '''

@_compile
def _find_roots(c, roots):
    """All roots of c[0] + ... + c[d] z^d by Aberth's simultaneous iteration."""
    d = roots.size
    radius = (abs(c[0] / c[d])) ** (1.0 / d) if c[0] != 0.0 else 1.0
    for k in range(d):
        roots[k] = radius * cmath.exp(complex(0.0, 2.0 * math.pi * k / d + 0.4))
    moved = math.inf
    for _ in range(500):
        last, moved = moved, 0.0
        for k in range(d):
            z = roots[k]
            value, slope = complex(c[d], 0.0), 0j
            for j in range(d - 1, -1, -1):
                slope = slope * z + value
                value = value * z + c[j]
            if value == 0j or slope == 0j:
                continue
            newton, repulsion = value / slope, 0j
            for j in range(d):
                if j != k and roots[j] != z:
                    repulsion += 1.0 / (z - roots[j])
            slower = 1.0 - newton * repulsion
            step = newton / slower if slower != 0j else newton
            roots[k] = z - step
            moved = max(moved, abs(step) / abs(z))
        if moved < 1e-16 or (moved < 1e-13 and moved >= last):  # from here on it is rounding that moves them
            break


@_compile
def _rounding(c, z):
    """How far rounding of the coefficients may move the root z; 1e300 for a multiple root."""
    size, slope = 0.0, 0j
    for j in range(c.size - 1, 0, -1):
        slope = slope * z + j * c[j]
        size = (size + abs(c[j])) * abs(z)
    size += abs(c[0])
    return 2.3e-16 * size / abs(slope) if slope != 0j else 1e300


@_compile
def _principal(Omega, xi, c, b1, residual):
    """ratio with e^z (1 + ratio) the eigenvalue next to the exact e^z, from the residual of e^z."""
    d = c.size - 1
    root = math.sqrt(1.0 - xi * xi)
    e = cmath.exp(complex(-xi * Omega, root * Omega))
    x, y = -xi * Omega, root * Omega
    expm1 = complex(math.expm1(x) * math.cos(y) - 2.0 * math.sin(0.5 * y) ** 2, math.exp(x) * math.sin(y))
    taylor = np.zeros(d + 1, dtype=np.complex128)  # of the polynomial at e, in the ratio
    slope1 = complex(b1, 0.0)  # at e, from the one at 1, which is small and exact
    for j in range(d + 1):
        term, at_1 = c[j] * e**j, 1.0 * j
        for i in range(j + 1):
            taylor[i] += term
            term *= (j - i) / (i + 1.0)
            if i > 0:
                at_1 *= (j - i) / i
                slope1 += c[j] * at_1 * expm1**i
    taylor[0], taylor[1] = residual, e * slope1
    ratio = -taylor[0] / taylor[1]
    for _ in range(8):
        value, slope = taylor[d], 0j
        for j in range(d - 1, -1, -1):
            slope = slope * ratio + value
            value = value * ratio + taylor[j]
        ratio -= value / slope
    return ratio


@_compile
def _spectrum(Omega, xi, polynomial, defect, columns):
    """(radius, modulus of the largest complex pair, its angle, shift, log-modulus gain); NaN without a pair.

    shift and gain are what the pair adds to the exact angle and to the exact log-modulus, which keep
    their digits where the pair is the one next to the exact eigenvalues.
    """
    c, b1 = np.array(polynomial[:-1]), polynomial[-1]
    d = c.size - 1
    near = Omega == 0.0 or (Omega < {small_Omega} and xi < 1.0)
    radius, modulus, angle, shift, gain = 0.0, 0.0, math.nan, math.nan, math.nan
    rest = c
    if near:
        root, ratio = math.sqrt(abs(1.0 - xi * xi)), 0j
        if Omega > 0.0:
            residual = complex(defect[0] - defect[1] * xi, defect[1] * root) + _tails(Omega, xi, columns)
            ratio = _principal(Omega, xi, c, b1, residual)
        gain = 0.5 * math.log1p(2.0 * ratio.real + ratio.real**2 + ratio.imag**2)
        shift = math.atan2(ratio.imag, 1.0 + ratio.real)
        angle = root * Omega + shift
        modulus = math.exp(gain - xi * Omega)
        radius = modulus
        trace, det = 2.0 * modulus * math.cos(angle), modulus * modulus
        rest = np.empty(d - 1)  # the other eigenvalues' polynomial: c over z^2 - trace z + det
        for j in range(d - 1):  # from below, which keeps the smaller roots' digits
            below = rest[j - 1] if j > 0 else 0.0
            below2 = rest[j - 2] if j > 1 else 0.0
            rest[j] = (c[j] + trace * below - below2) / det
    roots = np.empty(rest.size - 1, dtype=np.complex128)
    _find_roots(rest, roots)
    for k in range(roots.size):
        size = abs(roots[k])
        radius = max(radius, size)
        # beside a double root real and complex are not told apart
        if size > modulus * (1.0 + 1e-12) and roots[k].imag > 8.0 * _rounding(rest, roots[k]):
            modulus, angle, near = size, cmath.phase(roots[k]), False
    if not near and xi < 1.0:
        shift = angle - math.sqrt(1.0 - xi * xi) * Omega
        gain = math.log(modulus) + xi * Omega if modulus > 0.0 else math.nan
    return radius, angle, shift, gain


@_compile
def _radius({arguments}):
    """Spectral radius at one point."""
    columns = _columns({arguments_no_Omega})
    return _spectrum(Omega, xi, _polynomial({arguments}), _defect({arguments}), columns)[0]


@_compile
def _point({arguments}):
    """Spectral radius, numerical damping and period error at one point; NaN where the eigenvalues are real."""
    columns = _columns({arguments_no_Omega})
    radius, angle, shift, gain = _spectrum(Omega, xi, _polynomial({arguments}), _defect({arguments}), columns)
    if not xi < 1.0:
        return radius, math.nan, math.nan
    if Omega == 0.0:
        return radius, 0.0, 0.0
    if xi == 0.0:  # a polynomial that reads the same backwards has its complex pairs on the circle
        opposite = np.abs(np.array(_asymmetry({arguments})))
        if opposite[:{half}].sum() == 0.0 or (_polynomial({arguments})[0] == 0.0 and opposite[{half}:].sum() == 0.0):
            gain = 0.0
    return radius, 0.0 - (gain + xi * shift / math.sqrt(1.0 - xi * xi)) / angle, 0.0 - shift / angle


@_compile
def _block({arguments}, radius, damping, period):
    """Of all points."""
    for i in range(radius.size):
        radius[i], damping[i], period[i] = _point({arguments_i})
'''

STABILITY = '''

@_compile
def spectral_radius({arguments}, out):
    """Spectral radius; 1-D arrays of one length."""
    for i in range(out.size):
        out[i] = _radius({arguments_i})


@_compile
def stability({arguments}, radius, damping, period):
    """Spectral radius, numerical damping ratio and period error in one pass; 1-D arrays of one length.

    Damping is that of the complex pair of largest modulus, less the physical one; period is the
    numerical over the exact one, less 1; both are NaN where the eigenvalues are real.
    """
    for i in range(0, radius.size, {block}):
        k = min(i + {block}, radius.size)
        _block({arguments_slice}, radius[i:k], damping[i:k], period[i:k])


@_compile
def numerical_damping({arguments}, out):
    """Numerical damping ratio of the complex pair of largest modulus, less the physical one."""
    rest = np.empty((2, min(out.size, {block})))
    for i in range(0, out.size, {block}):
        k = min(i + {block}, out.size)
        _block({arguments_slice}, rest[0, : k - i], out[i:k], rest[1, : k - i])


@_compile
def amplitude_error({arguments}, out):
    """1 - exp(-2 pi numerical damping): decay over one period."""
    numerical_damping({arguments}, out)
    for i in range(out.size):
        out[i] = 0.0 - {expm1}(-2.0 * math.pi * out[i])


@_compile
def period_error({arguments}, out):
    """Numerical over exact period, less 1."""
    rest = np.empty((2, min(out.size, {block})))
    for i in range(0, out.size, {block}):
        k = min(i + {block}, out.size)
        _block({arguments_slice}, rest[0, : k - i], rest[1, : k - i], out[i:k])
'''
