"""The fixed text of stability functions; every {field} is filled by `emit`."""

# of each scheme's module
POLYNOMIALS = """
# points of a block: a row is one variable at all its points; the module that finds the eigenvalues
BLOCK, EIGENVALUES = {block}, "{eigenvalues}"
"""

BLOCK_KERNEL = '''

def {name}(n, points, rows):
    """Rows {outputs} at n points of a block. {operations} operations.

{docstring}
    points: a row each of {inputs}.
    """
    {rows} = {points}
    for i in range(n):
{body}
'''

ERRORS = '''"""Numerical damping and period error of the largest complex pair."""
{compile}{log1p}{angle}

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


@_inner
def _distances(n, others, conjugates, points, rows, found, exact):
    """Store in the last rows of exact the distance of the pair from the exact one, of half of which tanh is taken.

    In tau = 2 (lambda - 1)/(lambda + 1) the pair is (less/2 +- i root)/scale. At the exact tau = x + i r y, where r^2 =
    1 - xi^2, the polynomial is `leading` times the product of the distances from all its roots. Over those from the
    conjugate (f) and from the other roots, it is the distance from the pair in tau, which divided by h is the tanh of
    half the distance in s. Each loop is over all points, so that the processor does several of them at a time.
    """
    Omegas, xis = points[0], points[1]
    for i in range(n):
        half, less, modulus2, root = found[i], 0.5 * found[BLOCK + i], found[2 * BLOCK + i], found[3 * BLOCK + i]
        xi, x = xis[i], exact[2 * BLOCK + i]
        r, scale = math.sqrt(abs(1.0 - xi * xi)), 0.25 * (1.0 + 2.0 * half + modulus2)
        y = r * exact[3 * BLOCK + i]
        f0, f1 = scale * x - less, scale * y + root  # scale times the distance in tau from the conjugate
        h0, h1 = scale - 0.25 * (less * x - root * y), -0.25 * (less * y + root * x)
        exact[BLOCK + i] *= r
        exact[5 * BLOCK + i], exact[6 * BLOCK + i] = f0 * h0 - f1 * h1, f0 * h1 + f1 * h0
    for k in range(others):  # their product is (1 - tau/2)^n times that of e^s - lambda
        for i in range(n):
            real, imaginary = found[(4 + 2 * k) * BLOCK + i], found[(5 + 2 * k) * BLOCK + i]
            xi, x, g0, g1 = xis[i], exact[2 * BLOCK + i], exact[5 * BLOCK + i], exact[6 * BLOCK + i]
            y = math.sqrt(abs(1.0 - xi * xi)) * exact[3 * BLOCK + i]
            e0, e1, d0, d1 = 1.0 + 0.5 * x, 0.5 * y, 1.0 - 0.5 * x, -0.5 * y  # e^s = e/d
            j0, j1 = e0 - real * d0 + imaginary * d1, e1 - real * d1 - imaginary * d0
            g0, g1 = g0 * j0 - g1 * j1, g0 * j1 + g1 * j0
            j0, j1 = e0 - real * d0 - imaginary * d1, e1 - real * d1 + imaginary * d0
            h0, h1 = g0 * j0 - g1 * j1, g0 * j1 + g1 * j0
            exact[5 * BLOCK + i], exact[6 * BLOCK + i] = h0 if conjugates else g0, h1 if conjugates else g1
    for i in range(n):
        Omega, half, modulus2 = Omegas[i], found[i], found[2 * BLOCK + i]
        p0, p1, leading = exact[i], exact[BLOCK + i], exact[4 * BLOCK + i]
        g0, g1, scale = exact[5 * BLOCK + i], exact[6 * BLOCK + i], 0.25 * (1.0 + 2.0 * half + modulus2)
        scale *= -0.5 * Omega * Omega * Omega / (leading * (g0 * g0 + g1 * g1))
        exact[5 * BLOCK + i] = 0.0 if rows[i] != 0.0 else scale * (p0 * g0 + p1 * g1)
        exact[6 * BLOCK + i] = scale * (p1 * g0 - p0 * g1)


@_inner
def _near_zero(n, points, found, exact, damping, period):
    """Replace the errors at points near Omega = 0 whose pair is close to the exact one; return how many there are."""
    Omegas, xis, count = points[0], points[1], 0
    for i in range(n):
        better, near_damping, near_period = _errors_of_distance(
            Omegas[i], xis[i], found[3 * BLOCK + i], exact[5 * BLOCK + i], exact[6 * BLOCK + i]
        )
        better = better and Omegas[i] < {small_Omega}
        damping[i], period[i] = near_damping if better else damping[i], near_period if better else period[i]
        count += better
    return count


def errors(n, near, others, conjugates, points, rows, found, exact, damping, period):
    """Numerical damping and period error at n points of a block.

    near: how many points have Omega < {small_Omega}: there they follow from the distance of the pair from the exact
    one, if that is small. points: rows Omega, xi; rows: its first is not 0 where a pair is on the unit circle; found:
    rows half the trace, modulus^2 - 1, modulus^2 and imaginary part of the pair (-1 if real), then real and imaginary
    part of each of the other eigenvalues, `others` in number; conjugates: whether each stands for its conjugate too;
    exact: what `defect` of the scheme's module has stored, and two rows of scratch. NaN where all eigenvalues are real.
    """
    Omegas, xis = points[0], points[1]
    if near > 0:
        _distances(n, others, conjugates, points, rows, found, exact)
    if near == n and _near_zero(n, points, found, exact, damping, period) == n:
        return
    for i in range(n):
        damping[i], period[i] = _errors_of_pair(
            Omegas[i], xis[i], found[i], found[BLOCK + i], found[2 * BLOCK + i], found[3 * BLOCK + i]
        )
    if near > 0:
        _near_zero(n, points, found, exact, damping, period)
'''
