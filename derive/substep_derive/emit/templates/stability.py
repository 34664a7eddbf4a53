"""The fixed text of generated stability functions; every {field} is filled by `emit`."""

PAIR = '''

@_inline
def _refused(Omega, xi, radius):
    """A negative integer if Omega or xi is negative or -0, or their sum is not finite: bits beyond the largest one."""
    a, b, largest = np.float64(Omega).view(np.int64), np.float64(xi).view(np.int64), np.int64(0x7FEFFFFFFFFFFFFF)
    return a | b | (largest - np.float64(abs(Omega + xi + radius)).view(np.int64))


@_inline
def _errors_of_pair(Omega, xi, half, less, modulus2, root):
    """Numerical damping and period error of the pair half +- i*root; less = modulus2 - 1; NaN where root < 0."""
    angle, square = _angle(root, half), abs(1.0 - xi * xi)
    cosine = math.sqrt(square)
    inverse = 1.0 / (angle * cosine)
    damping = 0.0 - (0.5 * _log1p(less, modulus2) * cosine + xi * angle) * inverse
    period = Omega * square * inverse - 1.0
    moving = root > 0.0 and xi < 1.0
    return damping if moving else math.nan, period if moving else math.nan


@_inline
def _errors_of_distance(Omega, xi, root, re, im):
    """Whether re + i im of `_distance_from_exact` is small; if so, numerical damping and period error."""
    cosine = math.sqrt(abs(1.0 - xi * xi))
    x, y = re * re - im * im, 2.0 * re * im
    u, v = 1.0 / 3.0 + 1.0 / 5.0 * x, 1.0 / 5.0 * y  # 1 + q^2/3 + q^4/5
    u, v = 1.0 + x * u - y * v, x * v + y * u
    growth, shift = 2.0 * (re * u - im * v), 2.0 * (re * v + im * u)
    inverse = 1.0 / (cosine * (cosine * Omega + shift))
    still = Omega < 1e-150  # whose square, and what is divided by it, may lose digits
    damping = 0.0 if still else 0.0 - (growth * cosine + xi * shift) * inverse
    period = 0.0 if still else 0.0 - shift * cosine * inverse
    close = root > 0.0 and re * re + im * im < 1.52587890625e-05  # the next term of the series is below 6e-16
    return xi < 1.0 and (still or close), damping, period


@_inline
def _in_square(y, z, constants):
    """u and v, where u + v s^2 is the polynomial in s^2 with these constants, highest first, and s^4 = -y s^2 - z."""
    u, v = constants[1], constants[0]
    for constant in constants[2:]:
        u, v = constant - z * v, u - y * v
    return u, v


@_inline
def _polynomial_at_exact(Omega, xi, {outputs}):
    """p0, p1, x, y, leading: the polynomial in tau has the value Omega^3 (p0 + i r p1) at the exact eigenvalue e^s.

    There tau = 2 (lambda - 1)/(lambda + 1) is x + i r y, with r = sqrt(1 - xi^2); s = Omega zeta, where
    zeta^2 = -2 xi zeta - 1. aj_n + bj_n zeta is the power series of tau^j from s^n on, divided by Omega^n.
    """
{lines}
'''

MONIC = """
    for i in range(n):
        {monic} = _monic(*_cubic({arguments_i}))"""

NEAR = '''

@_inline
def _distance_from_exact({arguments}, half, less, modulus2, root{more}):
    """tanh of half the distance in s between the eigenvalue half + i root and the exact one e^s; real, imaginary part.

    In tau = 2 (lambda - 1)/(lambda + 1) the pair is (less/2 +- i root)/scale. At the exact tau = x + i r y the
    polynomial is `leading` times the product of the distances from all its roots. Over those from the conjugate (f) and
    from the other roots, it is the distance from the pair in tau, which divided by h is the tanh.
    """
    p0, p1, x, y, leading = _polynomial_at_exact(Omega, xi, *_defect({arguments}))
    cosine, scale = math.sqrt(abs(1.0 - xi * xi)), 0.25 * (1.0 + 2.0 * half + modulus2)
    p1, y, less = cosine * p1, cosine * y, 0.5 * less
    f0, f1 = scale * x - less, scale * y + root  # scale times the distance in tau from the conjugate
    h0, h1 = scale - 0.25 * (less * x - root * y), -0.25 * (less * y + root * x)
    g0, g1 = f0 * h0 - f1 * h1, f0 * h1 + f1 * h0
{others}
    scale *= -0.5 * Omega * Omega * Omega / (leading * (g0 * g0 + g1 * g1))
    growth = 0.0 if _is_conservative({arguments}) else scale * (p0 * g0 + p1 * g1)
    return growth, scale * (p1 * g0 - p0 * g1)


@_inner
def _errors_near_zero({arguments}, s, damping, period):
    """Replace the errors at points near Omega = 0 whose pair is close to the exact one; return how many there are.

    There are two loops, so that the processor overlaps their iterations.
    """
    count = 0
    for i in range(period.size):
        s[{re}, i], s[{im}, i] = _distance_from_exact({arguments_i}, s[0, i], s[1, i], s[2, i], {kept_i})
    for i in range(period.size):
        better, near_damping, near_period = _errors_of_distance(Omega[i], xi[i], s[3, i], s[{re}, i], s[{im}, i])
        better = better and Omega[i] < {small_Omega}
        damping[i], period[i] = near_damping if better else damping[i], near_period if better else period[i]
        count += better
    return count


@_inner
def _stability_of_block({arguments}, radius, damping, period):
    """`stability` of a block of points; returns all `_refused`.

    Near Omega = 0, damping and period error follow from the distance of the pair from the exact one, if that is small.
    """
    n, count, refused = radius.size, 0, np.int64(0)
    s = np.empty(({size}, n)){before}
    for i in range(n):
        radius[i], {found_i} = _eigenvalues({arguments_i}{prepared_i})
        refused |= _refused(Omega[i], xi[i], radius[i])
    for i in range(n):
        count += Omega[i] < {small_Omega}
    if count == n and _errors_near_zero({arguments}, s, damping, period) == n:
        return refused
    for i in range(n):
        damping[i], period[i] = _errors_of_pair(Omega[i], xi[i], s[0, i], s[1, i], s[2, i], s[3, i])
    if count > 0:
        _errors_near_zero({arguments}, s, damping, period)
    return refused
'''

STABILITY = '''

@_fused
def spectral_radius({arguments}, out):
    """Spectral radius; 1-D arrays of one length. Returns whether any Omega, xi or radius is negative or not finite."""
    return _spectral_radii({arguments}, out) < 0


@_fused
def stability({arguments}, radius, damping, period):
    """Spectral radius, numerical damping ratio and period error in one pass; 1-D arrays of one length.

    damping: that of the complex pair of largest modulus, less the physical one; period: the numerical
    period over the exact one, less 1; both are NaN where all eigenvalues are real. Returns whether
    any Omega, xi or radius is negative or not finite.
    """
    refused = np.int64(0)
    for i in range(0, radius.size, {block}):
        k = min(i + {block}, radius.size)
        refused |= _stability_of_block({arguments_slice}, radius[i:k], damping[i:k], period[i:k])
    return refused < 0
'''
