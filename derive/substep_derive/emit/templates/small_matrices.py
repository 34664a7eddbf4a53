"""Fixed text of functions on small vectors and matrices, which the march of small structures is made of."""

SMALL_MATRICES = '''

@_inline
def _copy(x, out):
    """As it is."""
    for i in range(out.size):
        out[i] = x[i]


@_inner
def _combine(row, X, count, out):
    """The sum of row[v] X[v] over v < count."""
    for i in range(0, out.size, 4):
        a = b = c = d = 0.0
        for v in range(count):
            factor = row[v]
            if factor != 0.0:
                x = X[v]
                a += factor * x[i]
                b += factor * x[i + 1]
                c += factor * x[i + 2]
                d += factor * x[i + 3]
        out[i], out[i + 1], out[i + 2], out[i + 3] = a, b, c, d


@_inner
def _add_product(columns, spans, factor, x, out):
    """Add factor times the product of a matrix with x."""
    for i in range(0, out.size, 4):
        a, b, c, d = out[i], out[i + 1], out[i + 2], out[i + 3]
        for k in range(spans[i >> 2, 0], spans[i >> 2, 1]):
            share, column = factor * x[k], columns[k]
            a += share * column[i]
            b += share * column[i + 1]
            c += share * column[i + 2]
            d += share * column[i + 3]
        out[i], out[i + 1], out[i + 2], out[i + 3] = a, b, c, d


@_rounded
def _elongations(B, u, out):
    """B u (s,), to the bit as SciPy has it."""
    first, columns, entries = B
    for s in range(out.size):
        total = 0.0
        for k in range(first[s], first[s + 1]):
            total += entries[k] * u[columns[k]]
        out[s] = total


@_inline
def _spread(B, q, out):
    """Add the forces B^T q."""
    first, columns, entries = B
    for s in range(q.size):
        for k in range(first[s], first[s + 1]):
            out[columns[k]] += entries[k] * q[s]


@_inline
def _largest(x):
    """The largest modulus; NaN where a number is not finite."""
    a = b = c = d = lost = 0.0
    for i in range(0, x.size, 4):
        a, b = max(a, abs(x[i])), max(b, abs(x[i + 1]))
        c, d = max(c, abs(x[i + 2])), max(d, abs(x[i + 3]))
        lost += 0.0 * (x[i] + x[i + 1] + x[i + 2] + x[i + 3])
    return max(max(a, b), max(c, d)) + lost


@_inline
def _dot(x, y):
    """The inner product."""
    a = b = c = d = 0.0
    for i in range(0, x.size, 4):
        a += x[i] * y[i]
        b += x[i + 1] * y[i + 1]
        c += x[i + 2] * y[i + 2]
        d += x[i + 3] * y[i + 3]
    return (a + b) + (c + d)


@_inner
def _factorized(A, order, spans):
    """A (n, m), by columns, becomes L and U with the reciprocals of pivots; returns whether it is regular.

    order (n,): the row with which each was exchanged; spans (n, 2): of the columns.
    """
    n, largest = len(A), 0.0
    for k in range(n):
        column = A[k]
        place, size = k, abs(column[k])
        for i in range(k + 1, n):
            if abs(column[i]) > size:
                place, size = i, abs(column[i])
        largest = max(largest, size)
        if not size > REGULAR * largest:
            return False
        order[k] = place
        if place != k:
            for j in range(n):
                A[j, k], A[j, place] = A[j, place], A[j, k]
        column[k] = 1.0 / column[k]
        for i in range(k + 1, n):
            column[i] *= column[k]
        for j in range(k + 1, n):
            other = A[j]
            factor = other[k]
            if factor != 0.0:
                for i in range(k + 1, n):
                    other[i] -= factor * column[i]
    for k in range(n):
        low, high = 0, n
        while A[k, low] == 0.0:
            low += 1
        while A[k, high - 1] == 0.0:
            high -= 1
        spans[k, 0], spans[k, 1] = low, high
    return True


@_inner
def _substituted(A, order, spans, x):
    """Put the solution in place of the right side x."""
    n = len(A)
    for k in range(n):
        place = order[k]
        if place != k:
            x[k], x[place] = x[place], x[k]
    for k in range(n):
        factor, column = x[k], A[k]
        for i in range(k + 1, spans[k, 1]):
            x[i] -= factor * column[i]
    for k in range(n - 1, -1, -1):
        column = A[k]
        factor = x[k] * column[k]
        x[k] = factor
        for i in range(spans[k, 0], k):
            x[i] -= factor * column[i]


@_inline
def _solved(i, linear, d, B, kept, x):
    """Solve with linear + B^T diag(d) B of the system i, of which the factors for the last few d (s,) are kept.

    Puts the solution in place of the right side x; returns whether the matrix is regular.
    """
    keys, factors, orders, spans, filled, recent = kept
    count, slot = filled[i], -1
    for back in range(count):
        other = recent[i] - back
        other = other if other >= 0 else other + count
        same = True
        for s in range(d.size):
            same = same and keys[i, other, s] == d[s]
        if same:
            slot = other
            break
    if slot < 0:
        slot = count if count < KEPT else (recent[i] + 1) % KEPT
        A, (first, columns, entries) = factors[i, slot], B
        for k in range(len(A)):
            _copy(linear[k], A[k])
        for s in range(d.size):
            for k in range(first[s], first[s + 1]):
                share = d[s] * entries[k]
                for j in range(first[s], first[s + 1]):
                    A[columns[k], columns[j]] += share * entries[j]
        filled[i] = max(count, slot + 1)
        keys[i, slot, 0] = np.nan
        if not _factorized(A, orders[i, slot], spans[i, slot]):
            return False
        _copy(d, keys[i, slot])
    recent[i] = slot
    _substituted(factors[i, slot], orders[i, slot], spans[i, slot], x)
    return True
'''
