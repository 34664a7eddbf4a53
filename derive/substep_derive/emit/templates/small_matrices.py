"""Fixed text of functions on small vectors and matrices, which the march of small structures is made of."""

SMALL_MATRICES = '''

@_inline
def _scaled(factor, x, out):
    """factor x. What is done to four numbers at a time, by their addresses, needs no look whether arrays overlap."""
    for i in range(0, out.size, 4):
        y, to = _part(x, i), _part(out, i)
        a, b, c, d = factor * y[0], factor * y[1], factor * y[2], factor * y[3]
        to[0], to[1], to[2], to[3] = a, b, c, d


@_inline
def _sum(x, factor, y, out):
    """x + factor y."""
    for i in range(0, out.size, 4):
        v, w, to = _part(x, i), _part(y, i), _part(out, i)
        a, b, c, d = v[0] + factor * w[0], v[1] + factor * w[1], v[2] + factor * w[2], v[3] + factor * w[3]
        to[0], to[1], to[2], to[3] = a, b, c, d


@_inline
def _divided(x, by):
    """Divide x."""
    for i in range(0, x.size, 4):
        y = _part(x, i)
        a, b, c, d = y[0] / by, y[1] / by, y[2] / by, y[3] / by
        y[0], y[1], y[2], y[3] = a, b, c, d


@_inline
def _zero(out):
    """0."""
    for i in range(0, out.size, 4):
        to = _part(out, i)
        to[0], to[1], to[2], to[3] = 0.0, 0.0, 0.0, 0.0


@_inline
def _loaded(factors, first, x, out):
    """Subtract of each lane its factor, the first of which has this number, times x."""
    for i in range(0, out.size, 4):
        f, v, to = _part(factors, first + i % LANES), _part(x, i), _part(out, i)
        a, b, c, d = to[0] - f[0] * v[0], to[1] - f[APART] * v[1], to[2] - f[2 * APART] * v[2], to[3]
        to[0], to[1], to[2], to[3] = a, b, c, d - f[3 * APART] * v[3]


@_inner
def _combine(row, X, count, out):
    """The sum of row[v] X[v] over v < count."""
    begun, factors = False, _part(row, 0)
    for v in range(count):
        if factors[v] != 0.0:
            if begun:
                _sum(out, factors[v], X[v], out)
            else:
                _scaled(factors[v], X[v], out)
            begun = True
    if not begun:
        _zero(out)


@_inner
def _add_product(matrices, q, factor, x, out):
    """Add factor times the product of the matrix q with x."""
    (every, places_of, values), rows = matrices, matrices[0].shape[1]
    first, places = _part(every, q * rows), _part(places_of, 0)
    for r in range(rows - 1):
        row = _part(out, 4 * r)
        a, b, c, d = row[0], row[1], row[2], row[3]
        for p in range(first[r], first[r + 1]):
            entry, y = _part(values, 4 * p), _part(x, places[p])
            a += factor * y[0] * entry[0]
            b += factor * y[APART] * entry[1]
            c += factor * y[2 * APART] * entry[2]
            d += factor * y[3 * APART] * entry[3]
        row[0], row[1], row[2], row[3] = a, b, c, d


@_rounded
def _elongations(B, u, out):
    """B u, to the bit as SciPy has it."""
    first, columns, entries = _part(B[0], 0), _part(B[1], 0), _part(B[2], 0)
    for s in range(B[0].size - 1):
        row = _part(out, s * LANES)
        for lane in range(0, LANES, WIDE):
            a = b = c = d = 0.0
            for k in range(first[s], first[s + 1]):
                entry, y = entries[k], _part(u, columns[k] * LANES + lane)
                a += entry * y[0]
                if LANES > 1:
                    b += entry * y[1]
                    c += entry * y[2]
                    d += entry * y[3]
            row[lane] = a
            if LANES > 1:
                row[lane + 1], row[lane + 2], row[lane + 3] = b, c, d


@_inline
def _spread(B, q, out):
    """Add the forces B^T q."""
    first, columns, entries = _part(B[0], 0), _part(B[1], 0), _part(B[2], 0)
    for s in range(B[0].size - 1):
        for k in range(first[s], first[s + 1]):
            entry, x, y = entries[k], _part(q, s * LANES), _part(out, columns[k] * LANES)
            for lane in range(0, LANES, WIDE):
                if LANES > 1:
                    a, b, c = y[lane + 1] + entry * x[lane + 1], y[lane + 2] + entry * x[lane + 2], y[lane + 3]
                    y[lane], y[lane + 1], y[lane + 2] = y[lane] + entry * x[lane], a, b
                    y[lane + 3] = c + entry * x[lane + 3]
                else:
                    y[0] += entry * x[0]


@_inline
def _largest(x, out):
    """The largest moduli (LANES,); NaN where a number is not finite."""
    for lane in range(0, ROW, 4):
        a = b = c = d = lost_a = lost_b = lost_c = lost_d = 0.0
        for i in range(lane, x.size, ROW):
            y = _part(x, i)
            a, b, c, d = max(a, abs(y[0])), max(b, abs(y[1])), max(c, abs(y[2])), max(d, abs(y[3]))
            lost_a, lost_b, lost_c, lost_d = (
                lost_a + 0.0 * y[0], lost_b + 0.0 * y[1], lost_c + 0.0 * y[2], lost_d + 0.0 * y[3]
            )
        a, b, c, d = a + lost_a, b + lost_b, c + lost_c, d + lost_d
        if LANES > 1:
            out[lane], out[lane + 1], out[lane + 2], out[lane + 3] = a, b, c, d
        else:
            out[0] = max(max(a, b), max(c, d)) + 0.0 * (a + b + c + d)


@_inline
def _dot(x, y, out):
    """The inner products (LANES,)."""
    for lane in range(0, ROW, 4):
        a = b = c = d = 0.0
        for i in range(lane, x.size, ROW):
            v, w = _part(x, i), _part(y, i)
            a += v[0] * w[0]
            b += v[1] * w[1]
            c += v[2] * w[2]
            d += v[3] * w[3]
        if LANES > 1:
            out[lane], out[lane + 1], out[lane + 2], out[lane + 3] = a, b, c, d
        else:
            out[0] = (a + b) + (c + d)


@_inner
def _factorized(A, order, spans):
    """A (n, n), by columns, becomes L and U with the reciprocals of pivots; returns whether it is regular.

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


@_inline
def _less(A, at, x, k, low, high):
    """Subtract from the rows low to high of x (n LANES,) the column of A, from its number `at` on, times the row k."""
    for lane in range(0, LANES, WIDE):
        row = _part(x, k * LANES + lane)
        f = row[0]
        if LANES > 1:
            g, p, q = row[1], row[2], row[3]
            for i in range(low * LANES + lane, high * LANES, LANES):
                y, e = _part(x, i), _part(A, at + i)
                a, b, c, d = y[0] - f * e[0], y[1] - g * e[1], y[2] - p * e[2], y[3] - q * e[3]
                y[0], y[1], y[2], y[3] = a, b, c, d
        else:
            y, e = _part(x, 0), _part(A, at)
            for i in range(low, high):
                y[i] -= f * e[i]


@_inner
def _substituted(A, order, spans, exchanged, x):
    """Put the solutions in place of the right sides x; exchanged: whether rows of any lane were."""
    n = len(A)
    for k in range(n if exchanged else 0):
        for lane in range(LANES):
            here, there = k * LANES + lane, order[k, lane] * LANES + lane
            x[here], x[there] = x[there], x[here]
    ends, width = _part(spans, 0), n * LANES
    for k in range(n):
        _less(A, k * width, x, k, k + 1, ends[2 * k + 1])
    for back in range(n):
        k = n - 1 - back
        row, pivot = _part(x, k * LANES), _part(A, k * (width + LANES))
        for lane in range(0, LANES, WIDE):
            a = row[lane] * pivot[lane]
            if LANES > 1:
                b, c, d = row[lane + 1] * pivot[lane + 1], row[lane + 2] * pivot[lane + 2], row[lane + 3]
                row[lane + 1], row[lane + 2], row[lane + 3] = b, c, d * pivot[lane + 3]
            row[lane] = a
        _less(A, k * width, x, k, ends[2 * k], k)


@_inner
def _renewed(matrices, q, d, lane, B, kept, used):
    """Put into `used` the factors of a lane of the matrix q + B^T diag(d) B; returns whether it is regular.

    kept: of the lane, the factors for the last few d.
    """
    (keys, factors, orders, spans, places), (A, order, of_columns, now, exchanged) = kept, used
    n, count, slot = len(A), places[0], -1
    for back in range(count):
        other = places[1] - back
        other = other if other >= 0 else other + count
        same = True
        for s in range(keys.shape[1]):
            same = same and keys[other, s] == d[s * LANES + lane]
        if same:
            slot = other
            break
    if slot < 0:
        slot = count if count < len(keys) else (places[1] + 1) % len(keys)
        new, (first, columns, entries), (firsts, places_of, values) = factors[slot], B, matrices
        new[:] = 0.0
        for r in range(firsts.shape[1] - 1):
            for p in range(firsts[q, r], firsts[q, r + 1]):
                for j in range(4):
                    row = 4 * r + j
                    if row % LANES == lane and row // LANES < n:
                        new[places_of[p] // LANES, row // LANES] = values[4 * p + j]
        for s in range(first.size - 1):
            for k in range(first[s], first[s + 1]):
                share = d[s * LANES + lane] * entries[k]
                for j in range(first[s], first[s + 1]):
                    new[columns[k], columns[j]] += share * entries[j]
        places[0] = max(count, slot + 1)
        keys[slot, 0] = np.nan
        if not _factorized(new, orders[slot], spans[slot]):
            return False
        for s in range(keys.shape[1]):
            keys[slot, s] = d[s * LANES + lane]
    places[1] = slot
    for k in range(n):
        order[k, lane] = orders[slot, k]
        exchanged[0] = exchanged[0] or orders[slot, k] != k
        of_columns[k, 0] = min(of_columns[k, 0], spans[slot, k, 0])
        of_columns[k, 1] = max(of_columns[k, 1], spans[slot, k, 1])
        for i in range(of_columns[k, 0], of_columns[k, 1]):
            A[k, i * LANES + lane] = factors[slot, k, i]
    for s in range(lane, now.size, LANES):
        now[s] = d[s]
    return True


@_inline
def _differ(d, now):
    """Whether any slopes are other ones."""
    many = 0
    for i in range(0, d.size, 4):
        x, y = _part(d, i), _part(now, i)
        many += (x[0] != y[0]) + (x[1] != y[1]) + (x[2] != y[2]) + (x[3] != y[3])
    return many > 0


@_inline
def _other(d, now, lane):
    """Whether slopes of a lane are other ones."""
    one, other = _part(d, 0), _part(now, 0)
    for s in range(lane, d.size, LANES):
        if one[s] != other[s]:
            return True
    return False
'''
