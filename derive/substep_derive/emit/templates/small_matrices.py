"""Fixed text of functions on small vectors and matrices, which the march of small structures is made of."""

SMALL_MATRICES = '''

@_inline
def _scaled(factor, x, m, out):
    """factor x (m,)."""
    f = _each(factor)
    for i in range(0, m, WIDTH):
        _put(out, i, _times(f, _several(x, i)))


@_inline
def _copied(x, m, out):
    """x (m,)."""
    for i in range(0, m, WIDTH):
        _put(out, i, _several(x, i))


@_inline
def _sum(x, factor, y, m, out):
    """x + factor y (m,)."""
    f = _each(factor)
    for i in range(0, m, WIDTH):
        _put(out, i, _fused(_several(x, i), f, _several(y, i)))


@_inline
def _zero(out, m):
    """0 (m,)."""
    zero = _each(0.0)
    for i in range(0, m, WIDTH):
        _put(out, i, zero)


@_inline
def _beside(x, place):
    """The number there WIDTH times, or with lanes that of each lane."""
    if LANES > 1:
        found = _several(x, place)
    else:
        found = _each(x[place])
    return found


@_inline
def _loaded(factors, first, x, m, out):
    """Subtract of each lane its factor, the first of which has this number, times x (m,)."""
    f = _times(_each(-1.0), _beside(factors, first))
    for i in range(0, m, WIDTH):
        _put(out, i, _fused(_several(out, i), f, _several(x, i)))


@_inline
def _next(factors, v, count):
    """The number of the first factor from v on that is not 0, or count."""
    while v < count and factors[v] == 0.0:
        v += 1
    return v


@_inner
def _combine(factors, X, m, count, out):
    """The sum of factors[v] X[v] (m,) over v < count: two terms at a time."""
    first = _next(factors, 0, count)
    second = _next(factors, first + 1, count)
    if first >= count:
        _zero(out, m)
    elif second >= count:
        _scaled(factors[first], _part(X, first * m), m, out)
    else:
        x, y, f, g = _part(X, first * m), _part(X, second * m), _each(factors[first]), _each(factors[second])
        for i in range(0, m, WIDTH):
            _put(out, i, _fused(_times(f, _several(x, i)), g, _several(y, i)))
    first = _next(factors, second + 1, count)
    while first < count:
        second = _next(factors, first + 1, count)
        if second < count:
            x, y, f, g = _part(X, first * m), _part(X, second * m), _each(factors[first]), _each(factors[second])
            for i in range(0, m, WIDTH):
                _put(out, i, _fused(_fused(_several(out, i), f, _several(x, i)), g, _several(y, i)))
        else:
            _sum(out, factors[first], _part(X, first * m), m, out)
        first = _next(factors, second + 1, count)


@_inner
def _add_product(matrices, q, factor, x, out):
    """Add factor times the product of the matrix q with x."""
    every, places, values, rows = matrices
    first, f = _part(every, q * (rows + 1)), _each(factor)
    for r in range(rows):
        total = _several(out, WIDTH * r)
        for p in range(first[r], first[r + 1]):
            total = _fused(total, _times(f, _beside(x, places[p])), _several(values, WIDTH * p))
        _put(out, WIDTH * r, total)


@_inner
def _balance(matrices, q, z, B, forces, rest, out, left):
    """rest + the product of the matrix q with z + B^T forces, where B is that matrix; left (LANES,): its moduli."""
    (every, places, values, rows), (every_of, places_of, entries, _) = matrices, B
    first, first_of = _part(every, q * (rows + 1)), every_of
    zero = _each(0.0)
    most, lost = zero, zero
    for r in range(rows):
        total = _several(rest, WIDTH * r)
        for p in range(first[r], first[r + 1]):
            total = _fused(total, _beside(z, places[p]), _several(values, WIDTH * p))
        for p in range(first_of[r], first_of[r + 1]):
            total = _fused(total, _beside(forces, places_of[p]), _several(entries, WIDTH * p))
        _put(out, WIDTH * r, total)
        most, lost = _larger(most, total), _fused(lost, zero, total)
    _of_all(most, lost, left)


@_rounded
def _elongations(B, u, out):
    """B u, to the bit as SciPy has it."""
    first, places, values, rows = B
    for r in range(rows):
        total = _each(0.0)
        for p in range(first[r], first[r + 1]):
            total = _unfused(total, _several(values, WIDTH * p), _beside(u, places[p]))
        _put(out, WIDTH * r, total)


@_inline
def _raise(out, place, several):
    """Put their moduli there where they are larger than what there is.

    The sum with 0 changes nothing; without it this would be compiled to a store of some numbers, which is slow.
    """
    _put(out, place, _larger(_unfused(_several(out, place), _each(0.0), _each(0.0)), several))


@_rounded
def _raised(B, u, out):
    """The moduli of B u where they are larger than what there is; with lanes."""
    first, columns, entries = B
    for s in range(first.size - 1):
        total = _each(0.0)
        for k in range(first[s], first[s + 1]):
            total = _unfused(total, _each(entries[k]), _several(u, columns[k] * LANES))
        _raise(out, s * LANES, total)


@_inline
def _of_all(most, lost, out):
    """The largest moduli (LANES,) of several numbers; NaN where `lost`, 0 times all, is not 0."""
    most = _fused(most, _each(1.0), lost)
    if LANES > 1:
        _put(out, 0, most)
    else:
        a, b, c, d = _number(most, 0), _number(most, 1), _number(most, 2), _number(most, 3)
        out[0] = max(max(a, b), max(c, d)) + 0.0 * (a + b + c + d)


@_inline
def _largest(x, m, out):
    """The largest moduli (LANES,) of x (m,); NaN where a number is not finite."""
    zero = _each(0.0)
    most, lost = zero, zero
    for i in range(0, m, WIDTH):
        most, lost = _larger(most, _several(x, i)), _fused(lost, zero, _several(x, i))
    _of_all(most, lost, out)


@_inline
def _dot(x, y, m, out):
    """The inner products (LANES,)."""
    total = _each(0.0)
    for i in range(0, m, WIDTH):
        total = _fused(total, _several(x, i), _several(y, i))
    if LANES > 1:
        _put(out, 0, total)
    else:
        out[0] = (_number(total, 0) + _number(total, 1)) + (_number(total, 2) + _number(total, 3))


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
    if LANES > 1:
        f = _times(_each(-1.0), _several(x, k * LANES))
        for i in range(low * LANES, high * LANES, LANES):
            _put(x, i, _fused(_several(x, i), f, _several(A, at + i)))
    else:
        e, f = _part(A, at), x[k]
        for i in range(low, high):
            x[i] -= f * e[i]


@_inner
def _factorized_together(n, matrices, q, d, B, ends, alive, A):
    """A (n, n LANES), by columns, becomes L and U of the matrix q + B^T diag(d) B of every lane, rows not exchanged.

    ends (n, 2): where the columns begin and end, as far as any entry is not 0; with reciprocals of pivots. Returns
    whether all pivots are positive in lanes that are alive, so that symmetric matrices are positive definite.
    """
    (every, places_of, values, rows), (first, columns, entries, size), width = matrices, B, n * LANES
    firsts = _part(every, q * (rows + 1))
    for k in range(n):
        for i in range(ends[2 * k] * LANES, ends[2 * k + 1] * LANES, LANES):
            _put(A, k * width + i, _each(0.0))
    for r in range(n):
        for p in range(firsts[r], firsts[r + 1]):
            _put(A, places_of[p] * n + r * LANES, _several(values, WIDTH * p))
    for s in range(size):
        slope = _several(d, s * LANES)
        for k in range(first[s], first[s + 1]):
            share = _times(slope, _each(entries[k]))
            for j in range(first[s], first[s + 1]):
                at = columns[k] * width + columns[j] * LANES
                _put(A, at, _fused(_several(A, at), share, _each(entries[j])))
    one, regular, largest, lost = _each(1.0), _each(REGULAR), _each(0.0), _each(0.0)
    for k in range(n):
        here, end = k * width, ends[2 * k + 1] * LANES
        pivot = _several(A, here + k * LANES)
        largest = _larger(largest, pivot)
        lost = _unless_more(lost, pivot, _times(regular, largest))
        reciprocal = _over(one, pivot)
        _put(A, here + k * LANES, reciprocal)
        for i in range((k + 1) * LANES, end, LANES):
            _put(A, here + i, _times(_several(A, here + i), reciprocal))
        for j in range(k + 1, ends[2 * k + 1]):
            there = j * width
            factor = _times(_each(-1.0), _several(A, there + k * LANES))
            for i in range((k + 1) * LANES, end, LANES):
                _put(A, there + i, _fused(_several(A, there + i), factor, _several(A, here + i)))
    good = True
    for lane in range(LANES):
        good = good and not (alive[lane] and _number(lost, lane) != 0.0)
    return good


@_inner
def _substituted(n, A, order, ends, exchanged, x):
    """Put the solutions in place of the right sides x; exchanged: whether rows of any lane were."""
    for k in range(n if exchanged else 0):
        for lane in range(LANES):
            here, there = k * LANES + lane, order[k * LANES + lane] * LANES + lane
            x[here], x[there] = x[there], x[here]
    width = n * LANES
    for k in range(n):
        _less(A, k * width, x, k, k + 1, ends[2 * k + 1])
    for back in range(n):
        k = n - 1 - back
        if LANES > 1:
            here = k * LANES
            _put(x, here, _times(_several(x, here), _several(A, k * width + here)))
        else:
            x[k] *= A[k * (width + 1)]
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
        new, (first, columns, entries, size), (every, places_of, values, rows) = factors[slot], B, matrices
        firsts = _part(every, q * (rows + 1))
        new[:] = 0.0
        for r in range(rows):
            for p in range(firsts[r], firsts[r + 1]):
                for j in range(WIDTH):
                    row = WIDTH * r + j
                    if row % LANES == lane and row // LANES < n:
                        new[places_of[p] // LANES, row // LANES] = values[WIDTH * p + j]
        for s in range(size):
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
def _differ(d, w, now):
    """Whether any slopes (w,) are other ones."""
    apart = _each(0.0)
    for i in range(0, w, WIDTH):
        apart = _unlike(apart, _several(d, i), _several(now, i))
    return _some(apart)


@_inline
def _other(d, w, now, lane):
    """Whether slopes of a lane are other ones."""
    for s in range(lane, w, LANES):
        if d[s] != now[s]:
            return True
    return False
'''
