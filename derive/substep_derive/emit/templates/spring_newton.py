"""Fixed text of Newton's iteration of a balance of a small structure with springs of laws, in lanes."""

SPRING_NEWTON = '''

@_inline
def _residual(z, rest, matrices, q, place, forces, velocity, springs, memories, work, out):
    """What the balance of a system leaves (m,) at its unknown z (m,): rest is what z does not move.

    work: the springs' answers (F, 4, s) to each of the forces, their elongations and rates where z is 0, and room.
    """
    weights, at, levels, since, fixed = forces
    B, laws, of_rate = springs
    found, before, rates_before, moved, e, rates, total, new = work
    _scaled(1.0, rest, out)
    _add_product(matrices, q, 1.0, z, out)
    _elongations(B, z, moved)
    _zero(total)
    if of_rate:
        _sum(rates_before, velocity[place], moved, rates)
    for f in range(weights.size):
        if not fixed[f]:
            _sum(before[f], at[f, place], moved, e)
            _answer(laws, e, rates, memories[levels[f]], since[f : f + 1], found[f], new[f])
            _sum(total, weights[f], found[f, 0], total)
    _spread(B, total, out)


@_inline
def _slopes(found, by_e, by_rate, released, d):
    """The derivative (s,) of a residual by its unknown that springs give; released: lanes without that by rates."""
    _zero(d)
    for f in range(by_e.size):
        if by_e[f] != 0.0 or by_rate[f] != 0.0:
            _sum(d, by_e[f], found[f, 1], d)
        if by_rate[f] != 0.0:
            for s in range(d.size):
                if not released[s % LANES]:
                    d[s] += by_rate[f] * found[f, 2, s]


@_inline
def _solved(i, matrices, q, d, B, kept, alive, x):
    """Solve with the matrix q of the system i + B^T diag(d) B, whose factors for the last few d (s,) are kept.

    Lanes are factorized together, anew for each d, as long as all matrices are symmetric and positive definite.
    Puts the solutions in place of the right sides x; returns whether the matrices are regular, and strikes lanes out of
    those that are alive whose one is not.
    """
    keys, factors, orders, spans, places, used, order, of_columns, now, exchanged, definite = kept
    if LANES > 1 and definite[i] and _differ(d, now[i]):
        if _factorized_together(matrices, q, d, B, of_columns[i], alive, used[i]):
            _scaled(1.0, d, now[i])
        else:  # by pivots, which lanes find each for itself, from now on
            definite[i], used[i], now[i] = False, 0.0, np.nan
    for lane in range(LANES if _differ(d, now[i]) else 0):
        if alive[lane] and _other(d, now[i], lane):
            mine = keys[i, lane], factors[i, lane], orders[i, lane], spans[i, lane], places[i, lane]
            in_use = used[i], order[i], of_columns[i], now[i], exchanged[i : i + 1]
            if not _renewed(matrices, q, d, lane, B, mine, in_use):
                alive[lane] = False
                return False
    _substituted(used[i], order[i], of_columns[i], exchanged[i], x)
    return True


@_inline
def _iterated(X, i, place, known, rest, shown, start, velocity, own, matrices, stiff, forces, slopes, springs,
              memories, kept, rules, largest, counts, shorter, alive, work, rooms):  # fmt: skip
    """Put the unknown of the system i in its place by Newton's iteration, with its memories (1 + commits, ..).

    Counts the iterations of each lane, and the corrections that were shortened. Returns whether all lanes that are
    alive have converged, and strikes out those that fail. All lanes wait for those that seek a part of a change.
    """
    tolerance, exact, rounding, too_far, little, balanced, iterations, search, line = rules
    (z, old, residual, change, trial, u, other), numbers, flags = rooms
    (here, size, begin, left, before, farthest, gone, turned, previous, part, low, high, at_low, at_high,
     allowed) = numbers  # fmt: skip
    tries, active, released, near, ends = flags
    found, total, of_rate, reach = work[0], work[6], springs[2], abs(shown[place])
    _combine(shown, X, place, u)
    _zero(trial)
    if reach != 0.0:
        _combine(start, X, place, trial)
        _sum(trial, -1.0, u, trial)
        _divided(trial, shown[place])
    for n in range(LANES):
        counts[n], shorter[n], tries[n], active[n], released[n], previous[n] = 0, 0, 0, alive[n], 0, 0.0
    begun, unit = False, reach if reach != 0.0 else 1.0
    while True:
        _residual(trial, rest, matrices, 4 + i, place, forces, velocity, springs, memories, work, residual)
        _largest(residual, left)
        if begun:
            straight = True
            for n in range(LANES):
                straight = straight and (left[n] <= line * before[n] or not active[n])
            if straight:
                _slopes(found, slopes[0], slopes[1], released, total)
                if not _differ(total, kept[8][i]):  # all lanes were on lines, which most steps are
                    _sum(u, shown[place], trial, other)
                    _largest(other, farthest)
                    for n in range(LANES):
                        largest[n] = max(largest[n], farthest[n]) if active[n] else largest[n]
                    break
            _dot(change, residual, here)
            _largest(change, size)
            _dot(change, old, begin)
            sought, seeking = False, False
            for n in range(LANES):
                if active[n] and tries[n] == 0 and reach * size[n] > (exact if of_rate else rounding) * largest[n]:
                    if begin[n] < 0.0 and here[n] > -too_far * begin[n]:  # a part of the change is sought
                        shorter[n] += 1
                        low[n], high[n], at_low[n], at_high[n], tries[n] = 0.0, 1.0, begin[n], here[n], 1
                elif 0 < tries[n] <= search and not abs(here[n]) <= little * abs(begin[n]):
                    tries[n] += 1
                    if here[n] < 0.0:
                        low[n], at_low[n], at_high[n] = part[n], here[n], 0.5 * at_high[n]
                    else:
                        high[n], at_high[n], at_low[n] = part[n], here[n], 0.5 * at_low[n]
                elif tries[n] > 0:
                    tries[n] = search + 1
                sought = sought or tries[n] > 0
                if 0 < tries[n] <= search:
                    part[n] = low[n] - at_low[n] * (high[n] - low[n]) / (at_high[n] - at_low[n])
                    for k in range(n, z.size, LANES):
                        trial[k] = z[k] + part[n] * change[k]
                    seeking = True
            if seeking:
                continue
            if sought:
                for n in range(LANES):
                    for k in range(n, z.size if tries[n] > 0 else 0, LANES):
                        change[k] *= part[n]
                _largest(change, size)
            _sum(u, shown[place], trial, other)
            _largest(other, farthest)
            on_lines, doubtful, moving, lost = False, False, False, False
            for n in range(LANES):
                size[n] *= unit
                near[n] = active[n] and left[n] <= line * before[n]
                if active[n] and not np.isfinite(size[n] + left[n]):
                    alive[n], lost = False, True
                else:
                    largest[n] = max(largest[n], farthest[n]) if active[n] else largest[n]
                on_lines = on_lines or near[n]
            if lost:
                return False
            if on_lines:
                _slopes(found, slopes[0], slopes[1], released, total)
                others = _differ(total, kept[8][i])
                for n in range(LANES):
                    if near[n] and not (others and _other(total, kept[8][i], n)):
                        active[n] = False
                    moving = moving or active[n]
                if not moving:
                    break
                moving = False
            _sum(other, -1.0, X[0], other)
            _largest(other, gone)
            _sum(trial, -1.0, change, other)
            _sum(trial, -1.0, other, other)
            _largest(other, turned)
            for n in range(LANES):
                rate = size[n] / previous[n] if previous[n] != 0.0 else 1.0
                rest_of = size[n] * min(1.0, rate / (1.0 - rate)) if rate < 1.0 else size[n]
                near[n] = rest_of <= max(tolerance * gone[n], exact * largest[n]) or turned[n] == 0.0
                ends[n] = near[n] or (previous[n] != 0.0 and rate >= 0.5 and size[n] <= rounding * largest[n])
                doubtful = doubtful or (of_rate and active[n] and ends[n])
            if doubtful:
                _largest(known, allowed)
                for m in range(3):
                    if own[m] != 0.0:
                        _zero(other)
                        _add_product(matrices, m, own[m], trial, other)
                        _largest(other, farthest)
                        for n in range(LANES):
                            allowed[n] += farthest[n]
            for n in range(LANES):
                if active[n]:
                    far = doubtful and left[n] > balanced * allowed[n] + 16.0 * exact * largest[n] * stiff[n]
                    released[n] = ends[n] and far
                    if ends[n] and not far:
                        active[n] = False
                    released[n], previous[n] = released[n] and near[n], size[n]
                    if active[n] and counts[n] == iterations:
                        alive[n], lost = False, True
                moving = moving or active[n]
            if lost:
                return False
            if not moving:
                break
        begun = True
        for n in range(LANES):
            counts[n], tries[n], before[n] = counts[n] + (1 if active[n] else 0), 0, left[n]
        _slopes(found, slopes[0], slopes[1], released, total)
        _scaled(1.0, trial, z)
        _scaled(1.0, residual, old)
        _scaled(-1.0, residual, change)
        if not _solved(i, matrices, 4 + i, total, springs[0], kept, alive, change):
            return False
        for n in range(LANES):
            if not active[n]:
                for k in range(n, z.size, LANES):
                    change[k] = 0.0
        _sum(z, 1.0, change, trial)
    _scaled(1.0, trial, X[place])
    return True
'''
