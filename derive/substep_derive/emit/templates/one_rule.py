"""The fixed text of modules whose step is written by R and S, with numbers alpha + beta*L in pairs of doubles."""

ONE_RULE = '''

# alpha + beta*L is a, b: the matrix [[alpha, beta], [w0*beta, alpha + w1*beta]], L^2 = w0 + w1*L; tails end in _
@_exact
def _horner(a, a_, b, b_, w0, w0_, w1, w1_, c, c_):
    """(a + b*L) L + c."""
    x, x_ = _times_two(w0, w0_, b, b_)
    y, y_ = _times_two(w1, w1_, b, b_)
    x, x_ = _plus_two(x, x_, c, c_)
    y, y_ = _plus_two(y, y_, a, a_)
    return x, x_, y, y_


@_exact
def _conjugate(a, a_, b, b_, w0, w0_, w1, w1_):
    """The c + d*L whose product with a + b*L is a number, and that number."""
    c, c_ = _times_two(w1, w1_, b, b_)
    c, c_ = _plus_two(c, c_, a, a_)
    x, x_ = _times_two(a, a_, c, c_)
    y, y_ = _times_two(b, b_, b, b_)
    y, y_ = _times_two(-w0, -w0_, y, y_)
    x, x_ = _plus_two(x, x_, y, y_)
    return c, c_, -b, -b_, x, x_


@_exact
def _product(a, a_, b, b_, c, c_, d, d_, w0, w0_, w1, w1_):
    """(a + b*L) (c + d*L)."""
    x, x_ = _times_two(a, a_, d, d_)
    y, y_ = _times_two(b, b_, d, d_)
    x, x_, y, y_ = _horner(x, x_, y, y_, w0, w0_, w1, w1_, 0.0, 0.0)
    s, s_ = _times_two(a, a_, c, c_)
    x, x_ = _plus_two(x, x_, s, s_)
    s, s_ = _times_two(b, b_, c, c_)
    y, y_ = _plus_two(y, y_, s, s_)
    return x, x_, y, y_


@_exact
def _difference(a, a_, b, b_, c, c_, d, d_):
    """a*b - c*d."""
    x, x_ = _times_two(a, a_, b, b_)
    y, y_ = _times_two(-c, -c_, d, d_)
    return _plus_two(x, x_, y, y_)
'''

INCREMENT = '''

@_exact
def _increment({arguments}):
    """Entries of A - I, each rounded once."""
{lines}
    return {names}
'''
