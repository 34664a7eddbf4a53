"""The fixed text of stability functions for more than three live eigenvalues."""

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
