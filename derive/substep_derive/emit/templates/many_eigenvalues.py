"""The fixed text of the modules that find more live eigenvalues: see `eigenvalues`, whose functions they have too."""

MORE_EIGENVALUES = '''"""Eigenvalues of schemes that have {live} that are not always 0{of}."""
{compile}
_exact = njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True)
{sizes}{call}{angle}

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
    return y if abs(y) * math.sqrt(slope * slope + slope_i * slope_i) > 1.84e-15 * size else 0.0


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
'''

FIRST_GUESS = '''

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
'''

EIGENVALUE_OF_ROOT = '''

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
'''

ROOTS_OF_A_BLOCK = '''

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
def _roots(n, rows, found):
    """Store real and imaginary part of each root in the rows of found.

    By Aberth's iteration in blocks of {width} points side by side, until no root of a block's points moves. Large
    coefficients are scaled, so that no square of them overflows.
    """
    s = np.ones({scratch_rows} * {width})
    for first in range(0, n, {width}):
        size = min({width}, n - first)
        for j in range(size):
            largest = 0.0
            for r in range({coefficients}):
                largest = max(largest, abs(rows[(1 + r) * BLOCK + first + j]))
            scale = 2.0**-600 if largest > 2.0**400 else 1.0
            for r in range({coefficients}):
                s[({first_coefficient} + r) * {width} + j] = scale * rows[(1 + r) * BLOCK + first + j]
        _start_roots(s)
        for _ in range(200):
            if _closer_roots(s) == 0:
                break
        _end_roots(s)
        for r in range({root_rows}):
            for j in range(size):
                found[r * BLOCK + first + j] = s[r * {width} + j]
'''

PLACED = '''

@_inline
def _placed(Omega, xi, on_circle, {prepared}):
    """Spectral radius; half the trace, modulus^2 - 1, modulus^2, imaginary part of the largest complex pair; others.

    The imaginary part is -1 where there is no complex pair. A pair that can only be on the unit circle has modulus 1
    exactly. The others are real and imaginary part of the other eigenvalues, but for their conjugates where roots are
    those of the stability polynomial.
    """
    near = _is_near(Omega, xi)
{placed}
    root = abs(y0) if {is_complex} else -1.0
    less, modulus2 = (0.0, 1.0) if abs(l0) < 1e-6 and on_circle else (l0, m0)
    return math.sqrt(square), h0, less, modulus2, root, {others}


def radii(n, points, rows, found, radius):
    """Store the spectral radius at n points of a block, from what `find` has stored."""
    Omegas, xis = points[0], points[1]
    for i in range(n):
        radius[i] = _placed(Omegas[i], xis[i], rows[i] != 0.0, {prepared_i})[0]


def eigenvalues(n, points, rows, found, radius):
    """Store the radius, and in found half the trace, modulus^2 - 1, modulus^2 and imaginary part of the largest pair.

    The imaginary part is -1 where no pair is complex. Below are real and imaginary part of each other eigenvalue.
    """
    Omegas, xis = points[0], points[1]
    for i in range(n):
        largest, {found_i} = _placed(
            Omegas[i], xis[i], rows[i] != 0.0, {prepared_i}
        )
        radius[i] = largest
'''

FIND_ROOTS = '''

def find(polynomial, n, k, points, rows, found):
    """Store the roots of the polynomial at n points of a block, k the number of rows of points."""
    _call(polynomial, n, points, rows)
    _roots(n, rows, found)
'''

FIND_BOTH_ROOTS = '''

@_inner
def _set_root(n, k, points, second):
    """Store the first or second root of s^2 + 2 xi Omega s + Omega^2, real and imaginary part, in the last two rows."""
    Omegas, xis, real, imaginary = points[0], points[1], points[k], points[k + 1]
    for i in range(n):
        Omega, xi = Omegas[i], xis[i]
        cosine = math.sqrt(abs(1.0 - xi * xi))
        rest = xi + cosine
        real[i] = -Omega * (xi if xi < 1.0 else rest if second else 1.0 / rest)
        imaginary[i] = Omega * cosine if xi < 1.0 else 0.0


def find(polynomial, n, k, points, rows, found):
    """Store the roots of the polynomial in a root of s^2 + 2 xi Omega s + Omega^2, at n points of a block.

    points has k rows, and below them two for the root. In the row below those of the roots is the largest modulus^2 of
    eigenvalues that are not their conjugates, 0 where all are: of those at the second root, where the oscillator is
    damped critically or more.
    """
    Omegas, xis, largest = points[0], points[1], 0.0
    for i in range(n):
        found[{root_rows} * BLOCK + i] = 0.0
        largest = max(largest, xis[i])
    for second in range(1 if largest >= 1.0 else 0, -1, -1):
        _set_root(n, k, points, second == 1)
        _call(polynomial, n, points, rows)
        _roots(n, rows, found)
        for i in range(n if second else 0):
            xi = xis[i]
            for r in range(0, {root_rows} if xi >= 1.0 else 0, 2):
                square = _eigenvalue(found[r * BLOCK + i], found[(r + 1) * BLOCK + i], _is_near(Omegas[i], xi))[2]
                found[{root_rows} * BLOCK + i] = max(found[{root_rows} * BLOCK + i], square)
'''
