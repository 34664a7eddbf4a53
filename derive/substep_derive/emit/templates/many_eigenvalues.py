"""The fixed text of eigenvalues in generated stability functions: more than three."""

MORE_EIGENVALUES = '''

@_compile
def _find_roots(c, roots):
    """All roots of c[0] + ... + c[d] z^d by Aberth's simultaneous iteration, until values are rounding."""
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
            away, away_i = 0.0, 0.0  # from the others, the sum of 1/(z - other)
            for j in range(d):
                g, g_i = x - roots[j].real, y - roots[j].imag
                square = g * g + g_i * g_i
                inverse = 1.0 / square if square > 0.0 else 0.0  # itself, or one not told from it
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
    """P = p(1) and T = p'(1) of the monic quadratic p next to the exact eigenvalue e, and the rest of c over it.

    The rest, lowest first and times c[d]/others[-1], follows from p by division, p from b0 and b1, which are those of
    c, and the rest: each turn gains a factor of the order of Omega.
    """
    d = c.size - 1
    T = 2.0 * (1.0 - e.real)
    P, moved = T - 1.0 + abs(e) ** 2, math.inf
    for _ in range(60):
        trace, det = 2.0 - T, 1.0 - T + P
        value, slope = 0.0, 0.0  # of the rest at 1
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
    """(radius; of the largest pair half the trace, modulus^2 - 1, modulus^2, imaginary part; what `_apart` wants).

    That is the imaginary part of the pair next to the exact one and the rest's polynomial. An imaginary part is -1
    where there is no pair; that of the pair next to the exact one also where another pair is the largest.
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
        # beside a double root real and complex are not told apart
        if size > modulus * (1.0 + 1e-12) and z.imag > 8.0 * _rounding(c, z) and Omega > 0.0:
            modulus, half, root, less, modulus2, kept = size, z.real, z.imag, size * size - 1.0, size * size, -1.0
    return radius, half, less, modulus2, root, kept, {others}


@_inline
def _is_conservative({arguments}):
    """Whether the polynomial reads the same backwards, itself or without a root at 0: pairs may be on the circle."""
    opposite = np.abs(np.array(_asymmetry({arguments_no_xi})))
    return xi == 0.0 and (opposite[:{half}].sum() == 0.0 or opposite[{half}:].sum() == 0.0)


@_compile
def _eigenvalues({arguments}):
    """Spectral radius, `_measured`'s half, less, modulus2 and root, and what `_apart` wants."""
    found = _spectrum(Omega, xi, _polynomial({arguments}))
    if abs(found[2]) < 1e-6 and _is_conservative({arguments}):
        return found[:2] + (0.0, 1.0) + found[4:]
    return found


@_compile
def _radii({arguments}, radius):
    """Spectral radii; the largest bits."""
    bits = np.uint64(0)
    for i in range(radius.size):
        radius[i] = _eigenvalues({arguments_i})[0]
        bits = max(bits, _bits(Omega[i], xi[i]))
    return bits
'''
