"""The fixed text of eigenvalues in generated stability functions: more than three."""

MORE_EIGENVALUES = '''

@_compile
def _find_roots(c, roots):
    """All roots of c[0] + ... + c[d] z^d by Aberth's simultaneous iteration, until values are below rounding."""
    d = roots.size
    radius = (abs(c[0] / c[d])) ** (1.0 / d) if c[0] != 0.0 else 1.0
    for k in range(d):
        roots[k] = radius * cmath.exp(complex(0.0, 2.0 * math.pi * k / d + 0.4))
    for _ in range(200):
        left = 0
        for k in range(d):
            x, y = roots[k].real, roots[k].imag
            modulus, size = math.sqrt(x * x + y * y), abs(c[d])
            value, value_i, slope, slope_i = c[d], 0.0, 0.0, 0.0
            for j in range(d - 1, -1, -1):
                slope, slope_i = slope * x - slope_i * y + value, slope * y + slope_i * x + value_i
                value, value_i = value * x - value_i * y + c[j], value * y + value_i * x
                size = size * modulus + abs(c[j])
            if abs(value) + abs(value_i) <= 2.3e-16 * size:
                continue
            left += 1
            away, away_i = 0.0, 0.0  # the sum of 1/(z - other) over the other roots
            for j in range(d):
                g, g_i = x - roots[j].real, y - roots[j].imag
                square = g * g + g_i * g_i
                inverse = 1.0 / square if square > 0.0 else 0.0  # 0 for the root itself, or an equal one
                away, away_i = away + g * inverse, away_i - g_i * inverse
            # value / (slope - value * away)
            g = slope - value * away + value_i * away_i
            g_i = slope_i - value * away_i - value_i * away
            square = g * g + g_i * g_i
            if square > 0.0:
                x -= (value * g + value_i * g_i) / square
                y -= (value_i * g - value * g_i) / square
            roots[k] = complex(x, y)
        if left == 0:
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
def _divide(c, b0, b1, e, others):
    """P = p(1) and T = p'(1) of the monic quadratic p whose roots are next to the exact eigenvalue e and its conjugate.

    Stores in others the coefficients, lowest first, of the quotient c/p, but for a factor. The quotient follows from p
    by division, and p from the quotient and the value b0 and slope b1 of c at 1: this is iterated, and each iteration
    gains a factor of the order of Omega.
    """
    d = c.size - 1
    T = 2.0 * (1.0 - e.real)
    P, moved = T - 1.0 + abs(e) ** 2, math.inf
    for _ in range(60):
        trace, det = 2.0 - T, 1.0 - T + P
        value, slope = 0.0, 0.0  # of the quotient at 1
        for j in range(d - 1):
            below = others[j - 1] if j > 0 else 0.0
            below2 = others[j - 2] if j > 1 else 0.0
            others[j] = (c[j] + trace * below - below2) / det
            value, slope = value + others[j], slope + j * others[j]
        last, moved, P = moved, P, b0 / value
        moved = abs(moved - P) + abs(T - (b1 - P * slope) / value)
        T = (b1 - P * slope) / value
        if moved >= last or moved == 0.0:
            break
    return P, T


@_compile
def _spectrum(Omega, xi, polynomial):
    """Spectral radius; half the trace, modulus^2 - 1, modulus^2, imaginary part of the largest complex pair; and more.

    That is, for `_distance_from_exact`, the imaginary part of the pair next to the exact one and the monic polynomial
    of the other eigenvalues. An imaginary part is -1 where there is no complex pair; that of the pair next to the exact
    one also where another pair is larger.
    """
    c, b0, b1 = np.array(polynomial[:-2]), polynomial[-2], polynomial[-1]
    others, radius, modulus, half, root, less, modulus2 = np.zeros(c.size - 2), 0.0, 0.0, 0.0, -1.0, 0.0, 0.0
    if Omega * max(1.0, xi) < {small_Omega}:
        e = cmath.exp(Omega * complex(-xi, math.sqrt(abs(1.0 - xi * xi))))
        P, T = _divide(c, b0, b1, e, others)
        half, less, modulus2 = 1.0 - 0.5 * T, P - T, 1.0 + P - T
        discriminant = P - 0.25 * T * T
        root = math.sqrt(discriminant) if discriminant > 0.0 else -1.0
        modulus = math.sqrt(abs(modulus2)) if discriminant > 0.0 else 0.0
        radius = modulus if discriminant > 0.0 else abs(half) + math.sqrt(-discriminant)
        c = others
    roots, kept = np.empty(c.size - 1, dtype=np.complex128), root
    _find_roots(c, roots)
    for z in roots:
        size = abs(z)
        radius = max(radius, size)
        # near a double root rounding makes a real pair complex: such a pair is not taken
        if size > modulus * (1.0 + 1e-12) and z.imag > 8.0 * _rounding(c, z) and Omega > 0.0:
            modulus, half, root, less, modulus2, kept = size, z.real, z.imag, size * size - 1.0, size * size, -1.0
    return radius, half, less, modulus2, root, kept, {others}


@_inline
def _is_conservative({arguments}):
    """Whether the polynomial, or it over lambda, reads the same backwards: complex pairs may be on the unit circle."""
    opposite = np.abs(np.array(_asymmetry({arguments_no_xi})))
    return xi == 0.0 and (opposite[:{half}].sum() == 0.0 or opposite[{half}:].sum() == 0.0)


@_compile
def _eigenvalues({arguments}):
    """As `_spectrum`, but a pair that can only be on the unit circle has modulus 1 exactly."""
    found = _spectrum(Omega, xi, _polynomial({arguments}))
    if abs(found[2]) < 1e-6 and _is_conservative({arguments}):
        return found[:2] + (0.0, 1.0) + found[4:]
    return found


@_compile
def _spectral_radii({arguments}, radius):
    """Store the spectral radius at each point; return the largest `_larger_bits`."""
    bits = np.uint64(0)
    for i in range(radius.size):
        radius[i] = _eigenvalues({arguments_i})[0]
        bits = max(bits, _larger_bits(Omega[i], xi[i]))
    return bits
'''
