"""The fixed text of functions that laws are written with; every {field} is filled."""

PHI_1 = '''

{decorator}def _phi_1(x):
    """(1 - exp(-x))/x, 1 at 0."""
    return -np.expm1(-x) / x if x != 0.0 else 1.0
'''

PHI_2 = '''

{decorator}def _phi_2(x):
    """(1 - phi_1(x))/x, 1/2 at 0; where the difference loses its digits, by its series."""
    if abs(x) > 0.5:
        return (x + np.expm1(-x)) / (x * x)
    term = total = 0.5
    for k in range(3, 16):
        term *= -x / k
        total += term
    return total
'''

# A Bouc-Wen law is integrated along a path by two motions of y = sign(dx) z >= 0, both with dy/dx = A - c y^n: to 0,
# where y was negative, c = gamma - beta, and then up, c = beta + gamma. For n = 1 and 2 they are elementary.
BOUC_WEN = '''

{decorator}def _slowness(w, A, c, n, top):
    """dx/dw of the motion up, at y = top (1 - exp(-w)) where it approaches top, else at y = w."""
    if top == 0.0:
        return 1.0 / (A - c * w**n)
    left = np.exp(-w)
    share = n if left < 1e-12 else -np.expm1(n * np.log1p(-left)) / left if left < 1.0 else 1.0
    return top / (A * share)


{decorator}def _near_zero(y, A, c, n, power):
    """The integral of y^power dx of a motion dy/dx = A - c y^n from 0 to y, as far as c y^n is small beside A."""
    ratio, total, term = c * y**n / A, 0.0, y ** (1 + power) / A
    for j in range(40):
        total += term / (n * j + 1 + power)
        term *= ratio
        if abs(term) <= 1e-18 * abs(total):
            break
    return total


{decorator}def _between(w0, w1, A, c, n, top, power):
    """The integral of y^power dx from w0 to w1: near 0, where y^n is not smooth, by its series, else Gauss's rule."""
    y0, y1 = (w0, w1) if top == 0.0 else (-top * np.expm1(-w0), -top * np.expm1(-w1))
    bound = (0.25 * A / abs(c)) ** (1.0 / n)
    total = _near_zero(min(y1, bound), A, c, n, power) - _near_zero(min(y0, bound), A, c, n, power)
    least = bound if top == 0.0 else -np.log1p(-bound / top)
    w0, w1 = max(w0, least), max(w1, least)
    parts = max(1, int(np.ceil(2.0 * abs(w1 - w0))))
    half = 0.5 * (w1 - w0) / parts
    for part in range(parts):
        middle = w0 + (2 * part + 1) * half
        for k in range(5):
            for side in (-1.0, 1.0):
                w = middle + side * half * _POINTS[k]
                y = w if top == 0.0 else -top * np.expm1(-w)
                total += half * _WEIGHTS[k] * _slowness(w, A, c, n, top) * (y if power == 1 else 1.0)
    return total


{decorator}def _moved(y, x, A, c, n):
    """y after dy/dx = A - c y^n over x, and the integral of y; x may be negative, as far as y stays above 0."""
    if x == 0.0:
        return y, 0.0
    if c == 0.0:
        return y + A * x, (y + 0.5 * A * x) * x
    if n == 1.0:
        new = A / c + (y - A / c) * np.exp(-c * x)
        return new, (A * x - (new - y)) / c
    if n == 2.0:
        rate = np.sqrt(A * abs(c))
        top, b = np.sqrt(A / abs(c)), rate * x
        if c > 0.0:
            t, share = np.tanh(b), np.sign(b) * y / top
            grown = abs(b) + np.log(0.5 * (1.0 + share + (1.0 - share) * np.exp(-2.0 * abs(b))))
            return (y + top * t) / (1.0 + y * t / top), grown / c
        t = np.tan(b)
        return (y + top * t) / (1.0 - y * t / top), np.log(np.cos(b) - np.sin(b) * y / top) / c
    top = (A / c) ** (1.0 / n) if c > 0.0 and x > 0.0 else 0.0
    w0 = y if top == 0.0 else -np.log1p(-min(y / top, 1.0 - 1e-16))
    w = w0
    for _ in range(50):
        slowness = _slowness(w, A, c, n, top)
        change = (_between(w0, w, A, c, n, top, 0) - x) / slowness
        w = max(w - change, 0.0)
        if abs(change) <= 1e-14 * (1.0 + abs(w)):
            break
    return (w if top == 0.0 else -top * np.expm1(-w)), _between(w0, w, A, c, n, top, 1)


{decorator}def _to_zero(y, A, c, n):
    """The x over which a motion with dy/dx = A - c y^n has risen from 0 to y."""
    if c == 0.0:
        return y / A
    if n == 1.0:
        return -np.log1p(-c * y / A) / c
    if n == 2.0:
        rate = np.sqrt(A * abs(c))
        return (np.arctanh(y * rate / A) if c > 0.0 else np.arctan(y * rate / A)) / rate
    return _between(0.0, y, A, c, n, 0.0, 0)


{decorator}def _along(x, z, A, beta, gamma, n):
    """z after a change x of the elongation, both over the yield elongation, and the integral of z over it."""
    sign = 1.0 if x >= 0.0 else -1.0
    y, left, work = sign * z, abs(x), 0.0
    if y < 0.0:
        back = _to_zero(-y, A, gamma - beta, n)
        if left <= back:
            new, work = _moved(-y, -left, A, gamma - beta, n)
            return -sign * new, work
        work = _moved(-y, -back, A, gamma - beta, n)[1]
        y, left = 0.0, left - back
    new, more = _moved(y, left, A, beta + gamma, n)
    return sign * new, work + more


{decorator}def _bouc_wen(x, z, A, beta, gamma, n):
    """z after a change x of the elongation, both over the yield elongation."""
    return _along(x, z, A, beta, gamma, n)[0]


{decorator}def _bouc_wen_work(x, z, A, beta, gamma, n):
    """The integral of z over that change."""
    return _along(x, z, A, beta, gamma, n)[1]


{decorator}def _bouc_wen_slope(z, x, A, beta, gamma, n):
    """dz/dx at z, in the direction of x."""
    return A - (gamma + (beta if (z >= 0.0) == (x >= 0.0) else -beta)) * abs(z) ** n
'''

# Gauss's rule of ten points on (-1, 1): the positive half
GAUSS = """
_POINTS = (
    0.14887433898163122, 0.4333953941292472, 0.6794095682990244,
    0.8650633666889845, 0.9739065285171717,
)
_WEIGHTS = (
    0.2955242247147528, 0.2692667193099965, 0.219086362515982,
    0.1494513491505804, 0.06667134430868814,
)
"""
