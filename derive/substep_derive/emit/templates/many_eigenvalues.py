"""The fixed text of eigenvalues in generated stability functions: more than three."""

MORE_EIGENVALUES = '''

_exact = njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True)


@_inline
def _value_and_slope(x, y, c):
    """Value and slope of the polynomial at x + iy, and what bounds the rounding of the value, a multiple of eps.

    c: real and imaginary part of its coefficients, highest first.
    """
    modulus, (value, value_i), slope, slope_i = math.sqrt(x * x + y * y), c[0], 0.0, 0.0
    size = abs(value) + abs(value_i)
    for real, imaginary in c[1:]:
        slope, slope_i = slope * x - slope_i * y + value, slope * y + slope_i * x + value_i
        value, value_i = value * x - value_i * y + real, value * y + value_i * x + imaginary
        size = size * modulus + (abs(real) + abs(imaginary))
    return value, value_i, slope, slope_i, size


@_inline
def _closer(x, y, others, c):
    """The root x + iy after a step of Aberth's iteration, and whether its value was above rounding; if not, as it was.

    The step is that of Newton for the polynomial divided by the distances from the other roots.
    """
    value, value_i, slope, slope_i, size = _value_and_slope(x, y, c)
    moved, away, away_i = abs(value) + abs(value_i) > 4.5e-16 * size, 0.0, 0.0
    for u, v in others:
        g, g_i = x - u, y - v
        inverse = 1.0 / (g * g + g_i * g_i + 1e-300)
        away, away_i = away + g * inverse, away_i - g_i * inverse
    g = slope - value * away + value_i * away_i
    g_i = slope_i - value * away_i - value_i * away
    inverse = 1.0 / (g * g + g_i * g_i + 1e-300)
    new, new_i = x - (value * g + value_i * g_i) * inverse, y - (value_i * g - value * g_i) * inverse
    return new if moved else x, new_i if moved else y, moved


@_inline
def _surely_complex(x, y, c):
    """The imaginary part y of a root, or 0 if rounding of the coefficients may move the root as far."""
    _, _, slope, slope_i, size = _value_and_slope(x, y, c)
    far = 1.84e-15 * size
    return y if y * y * (slope * slope + slope_i * slope_i) > far * far else 0.0


@_inline
def _power(square, exponent):
    """sqrt(square) to the power 2^-31 * exponent, within 10 %, by integer arithmetic on the bits of the number."""
    bits = (np.float64(square).view(np.int64) >> 32) * exponent >> 32
    return np.int64((bits + 0x3FF00000 - (0x3FF00000 * exponent >> 32)) << 32).view(np.float64)


@_inline
def _square(z):
    """Squared modulus."""
    return z.real * z.real + z.imag * z.imag


@_inline
def _scaled(z, factor):
    """A complex number times a real one."""
    return complex(z.real * factor, z.imag * factor)


@_inline
def _root(w):
    """An {n}th root of w, within 1 %, turned by 0.01 rad so that no two starts are conjugates of each other."""
    square = _square(w)
    modulus, over = _power(square, {exponent}), square
    inverse = 1.0 / (modulus * modulus)
    for _ in range({n}):
        over *= inverse
    modulus *= ({low}.0 + {high}.0 * over) / ({high}.0 + {low}.0 * over)  # Halley's step
    angle = math.copysign(1.0 / {n}.0 * _angle(abs(w.imag) + 1e-300, w.real), w.imag) + 0.01
    z = angle * angle
    cosine = 1.0 - z * (1.0 / 2.0 - z * (1.0 / 24.0 - z * (1.0 / 720.0)))
    sine = angle * (1.0 - z * (1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0))))
    return complex(modulus * cosine, modulus * sine)


@_inline
def _around(c):
    """z, p, q, for roots near z + (p + q)/2 e + (p - q)/2 / e, e^{n} = 1; they are those of a Chebyshev polynomial.

    It has the polynomial's three highest coefficients and its value at the centroid z of the roots: in z + u + v/u it
    is u^{n} + (v/u)^{n} but for a constant, so that u^{n} is a root of a quadratic. Lengths are divided by `radius`.
    """
    (a, a_i), (b, b_i), (d, d_i) = c[:3]
    inverse = 1.0 / (a * a + a_i * a_i)
    over = complex(a * inverse, -a_i * inverse)
    second, third = complex(b, b_i) * over, complex(d, d_i) * over
    z = _scaled(second, -1.0 / {n}.0)
    value, value_i, _, _, _ = _value_and_slope(z.real, z.imag, c)
    value, v = complex(value, value_i) * over, _scaled(_scaled(second * second, {low_of_square}) - third, 1.0 / {n}.0)
    radius = _power(_square(value), {exponent}) + _power(_square(v), 1 << 30)
    inverse = 1.0 / radius
    v, power, middle = _scaled(v, inverse * inverse), complex(1.0, 0.0), complex(0.0, 0.0)
    for k in range({n}):
        value, power = _scaled(value, inverse), power * v
        if 2 * k + 2 == {n}:
            middle = _scaled(power, {middle})
    half = _scaled(middle - value, 0.5)
    g = half * half - power
    size = math.sqrt(_square(g))
    root = complex(math.sqrt(0.5 * abs(size + g.real)), math.copysign(math.sqrt(0.5 * abs(size - g.real)), g.imag))
    u = _root(half + root if half.real * root.real + half.imag * root.imag > 0.0 else half - root)
    v = _scaled(v * u.conjugate(), 1.0 / _square(u))
    return z, _scaled(u + v, radius), _scaled(u - v, radius)


@_inline
def _is_near(Omega, xi):
    """Whether roots are found as lambda - 1, which keeps the digits of those near 1; else as lambda."""
    return Omega * (xi if xi > 1.0 else 1.0) < {small_Omega}


@_inline
def _eigenvalue(x, y, near):
    """Real part, modulus^2 - 1 and modulus^2 of the eigenvalue that a root stands for."""
    square = x * x + y * y
    less = square + 2.0 * x if near else square - 1.0
    return x + 1.0 if near else x, less, 1.0 + less if near else square
{coefficients}

@_inner
def _start_roots(s):
    """Store approximate roots of the polynomials in all lanes; coefficients are in the rows below the roots."""
    for j in range({width}):
        c = ({c_j})
        z, p, q = _around(c)
{starts}


@_inner
def _closer_roots(s):
    """One step for each root in each lane; returns how many roots had not converged."""
    count = 0
    for j in range({width}):
        c = ({c_j})
        {z} = {z_j}
{steps}
        {z_j} = {uv}
    return count


@_inner
def _end_roots(s):
    """Set the imaginary part of a root to 0 where rounding alone may have made it: see `_surely_complex`."""
    for j in range({width}):
        c = ({c_j})
        {z} = {z_j}
{ends}


@_exact
def _find_roots({arguments}, found{second_argument}):
    """Store real and imaginary part of each root in the rows of found.

    By Aberth's iteration in blocks of {width} points side by side, until no root of a block's points moves.
    """
    s = np.ones({scratch_rows} * {width})
    for first in range(0, Omega.size, {width}):
        size = min({width}, Omega.size - first)
        for j in range(size):
            {coefficients_j} = _coefficients_at({arguments_first}{second})
        _start_roots(s)
        for _ in range(200):
            if _closer_roots(s) == 0:
                break
        _end_roots(s)
        for r in range({rows}):
            for j in range(size):
                found[r, first + j] = s[r * {width} + j]
{both}

@_inline
def _is_conservative({arguments}):
    """Whether the polynomial, or it over lambda, reads the same backwards: complex pairs may be on the unit circle."""
    {asymmetry} = _asymmetry({arguments_no_xi})
    return xi == 0.0 and ({whole} == 0.0 or {divided} == 0.0)


@_inline
def _eigenvalues({arguments}, {prepared}):
    """Spectral radius; half the trace, modulus^2 - 1, modulus^2, imaginary part of the largest complex pair; others.

    The imaginary part is -1 where there is no complex pair. A pair that can only be on the unit circle has modulus 1
    exactly. The others are real and imaginary part of the other eigenvalues, but for their conjugates where roots are
    those of the stability polynomial.
    """
    near = _is_near(Omega, xi)
{placed}
    root = abs(y0) if {is_complex} else -1.0
    less, modulus2 = (0.0, 1.0) if abs(l0) < 1e-6 and _is_conservative({arguments}) else (l0, m0)
    return math.sqrt(square), h0, less, modulus2, root, {others}


@_inner
def _spectral_radii_of_block({arguments}, radius, s):
    """`_spectral_radii` of a block of points."""
    refused = np.int64(0)
    {find}({arguments}, s)
    for i in range(radius.size):
        radius[i] = _eigenvalues({arguments_i}, {prepared_i})[0]
        refused |= _refused(Omega[i], xi[i], radius[i])
    return refused


@_inner
def _spectral_radii({arguments}, radius):
    """Store the spectral radius at each point; return all `_refused`, negative if one is."""
    refused, s = np.int64(0), np.empty(({prepared_rows}, {block}))
    for i in range(0, radius.size, {block}):
        k = min(i + {block}, radius.size)
        refused |= _spectral_radii_of_block({arguments_slice}, radius[i:k], s)
    return refused
'''

COEFFICIENTS = '''

@_inline
def _coefficients_at({arguments}):
    """Real and imaginary part of the coefficients of the polynomial in a root, highest first."""
    {outputs} = _polynomial({arguments})
    near = _is_near(Omega, xi)
    return {chosen}
'''

COEFFICIENTS_OF_FACTOR = '''

@_inline
def _coefficients_at({arguments}, second):
    """Real and imaginary part of the coefficients of the polynomial in a root, highest first.

    It is the stability polynomial at s = s0 + i s1, the first or second root of s^2 + 2 xi Omega s + Omega^2.
    """
    cosine = math.sqrt(abs(1.0 - xi * xi))
    rest = xi + cosine
    s0 = -Omega * (xi if xi < 1.0 else rest if second else 1.0 / rest)
    s1 = Omega * cosine if xi < 1.0 else 0.0
    {outputs} = _polynomial(s0, s1{parameters})
    near = _is_near(Omega, xi)
    return {chosen}
'''

BOTH_FACTORS = '''

@_exact
def _find_both_roots({arguments}, found):
    """As `_find_roots`; in the row below, the largest modulus^2 of eigenvalues that are not their conjugates.

    Those are the eigenvalues at the second root s, where the oscillator is damped critically or more.
    """
    _find_roots({arguments}, found, False)
    largest = 0.0
    for i in range(Omega.size):
        found[{rows}, i] = 0.0
        largest = max(largest, xi[i])
    if largest >= 1.0:
        other = np.empty(({rows}, Omega.size))
        _find_roots({arguments}, other, True)
        for i in range(Omega.size):
            if xi[i] >= 1.0:
                for k in range(0, {rows}, 2):
                    square = _eigenvalue(other[k, i], other[k + 1, i], _is_near(Omega[i], xi[i]))[2]
                    found[{rows}, i] = max(found[{rows}, i], square)
'''
