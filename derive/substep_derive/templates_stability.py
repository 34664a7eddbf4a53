"""The fixed text of generated stability functions; every {field} is filled by `emit`."""

PAIR = '''

@_inline
def _measured(Omega, xi, half, less, modulus2, root):
    """Numerical damping and period error of the pair half +- i*root, less = modulus2 - 1; root < 0 for none."""
    angle, square = _angle(root, half), abs(1.0 - xi * xi)
    cosine = math.sqrt(square)
    inverse = 1.0 / (angle * cosine)
    damping = 0.0 - (0.5 * _log1p(less, modulus2) * cosine + xi * angle) * inverse
    period = Omega * square * inverse - 1.0
    moving = root > 0.0 and xi < 1.0
    return damping if moving else math.nan, period if moving else math.nan


@_inline
def _compared(Omega, xi, w, gain, x, y, root):
    """Numerical damping and period error of a pair from its distance to the exact one, e^s = x +- i sqrt(1 - xi^2) y.

    Of the pair's lambda^2 - t lambda + d, w = Re(e^s + d e^-s - t) and gain = d/|e^s|^2 - 1 are small and known to all
    digits: 1 + gain is the squared modulus over the exact one, and half the angle's error is that triangle's below.
    """
    cosine = math.sqrt(abs(1.0 - xi * xi))
    grown = math.sqrt(abs(1.0 + gain))
    mean = (1.0 + grown) * (1.0 + grown)
    opposite = 0.5 * (w * mean - x * gain * gain)
    shift = 2.0 * _angle(abs(opposite), mean * (root + grown * cosine * y))
    shift = shift if opposite > 0.0 else -shift
    inverse = 1.0 / (cosine * (cosine * Omega + shift))
    damping = 0.0 - (0.5 * _log1p(gain, 1.0 + gain) * cosine + xi * shift) * inverse
    period = 0.0 - shift * cosine * inverse
    nothing = math.nan if xi >= 1.0 or (Omega > 0.0 and not root > 0.0) else 0.0
    moving = Omega > 0.0 and root > 0.0 and xi < 1.0
    return damping if moving else nothing, period if moving else nothing


@_inline
def _in_s(y, z, constants):
    """u, v with u + v s the polynomial in s of these constants, highest first, where s^2 = -y s - z."""
    u, v = 0.0, 0.0
    for constant in constants:
        u, v = constant - z * v, u - y * v
    return u, v


@_inline
def _residual(Omega, xi, {outputs}):
    """p0, p1, x, y: the polynomial at e^s is Omega^3 (p0 + i r p1), and e^s = x + i r y, r = sqrt(1 - xi^2).

    s = Omega zeta, zeta^2 = -2 xi zeta - 1; a_jn + b_jn zeta are the powers of (e^s - 1)^j from s^n on, over Omega^n.
    """
{lines}
'''

NEAR = '''

@_inline
def _distance({point}):
    """w and gain of `_compared` from what the exact eigenvalue e^s = x + i r y leaves over in the polynomial; x, y."""
    p0, p1, x, y, leading = _residual(Omega, xi, *_defect({arguments}))
    square = 1.0 - xi * xi
    # the polynomial at e^s is leading (g0 + i sqrt(square) g1) (w - i sqrt(square) y gain): g, of all other roots
{others}
    scale = Omega * Omega * Omega / (leading * (g0 * g0 + square * g1 * g1) * y)
    w = scale * y * (p0 * g0 + square * p1 * g1)
    gain = 0.0 if _is_conservative({arguments}) else scale * (p0 * g1 - p1 * g0)
    return w, gain, x, y


@_compile
def _near({arguments}, {kept}, damping, period):
    """Numerical damping and period error of points near Omega = 0; in two loops, whose iterations overlap."""
    s = np.empty((4, root.size))
    for i in range(root.size):
        s[0, i], s[1, i], s[2, i], s[3, i] = _distance({point_i})
    for i in range(root.size):
        damping[i], period[i] = _compared(Omega[i], xi[i], s[0, i], s[1, i], s[2, i], s[3, i], root[i])
'''

BLOCK = '''

@_compile
def _block({arguments}, radius, damping, period):
    """Of all points, but anew, or alone, of those near Omega = 0, where the difference from the exact decides."""
    n, count = radius.size, 0
    s = np.empty(({size_kept}, n))
    for i in range(n):
        radius[i], {found_i} = _eigenvalues({arguments_i})
    for i in range(n):
        count += {chosen}
    if count == n:
        _near({arguments}, {kept}, damping, period)
        return
    for i in range(n):  # a loop of its own, so that iterations overlap
        damping[i], period[i] = _measured(Omega[i], xi[i], s[0, i], s[1, i], s[2, i], s[3, i])
    if count == 0:
        return
    where, count = np.empty(n + 8, np.int64), 0
    for i in range(n):
        where[count] = i
        count += {chosen}  # no branch
    while count % 8:  # vectors are whole: points one by one take as long each
        where[count] = where[0]
        count += 1
    x, y = np.empty(({size}, count)), np.empty((2, count))
    for k in range(count):
        i = where[k]
        {gathered} = {arguments_i}, {kept_i}
    _near({rows}, y[0], y[1])
    for k in range(count):
        damping[where[k]], period[where[k]] = y[0, k], y[1, k]
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
'''
