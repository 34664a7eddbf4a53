"""Fixed text of Newton's iteration of a balance of a small structure with springs of laws, in lanes."""

SPRING_NEWTON = '''

@_inline
def _residual(z, rest, matrices, q, place, forces, velocity, springs, memories, answers, out, left):
    """What the balance of a system leaves (m,) at its unknown z (m,), and its moduli: rest is what z does not move.

    answers: of the springs to each of the forces (F, 4, w), their elongations and rates where z is 0, and room.
    """
    weights, at, levels, since, fixed, a, b, V = forces
    (B, transposed, _), laws, of_rate, w, k = springs
    found, before, rates_before, moved, e, rates, total, new = answers
    _elongations(B, z, moved)
    if of_rate:
        _sum(rates_before, velocity[place], moved, w, rates)
    for f in range(a, b):
        force = _part(found, 4 * w * f)
        if not fixed[f]:
            _sum(_part(before, w * f), at[f * V + place], moved, w, e)
            _answer(laws, w, e, rates, _part(memories, k * levels[f]), _part(since, f), force, _part(new, k * f))
        share = 0.0 if fixed[f] else weights[f]
        if f == a:
            _scaled(share, force, w, total)
        elif share != 0.0:
            _sum(total, share, force, w, total)
    _balance(matrices, q, z, transposed, total, rest, out, left)


@_inline
def _displaced(shown, X, m, place, z, out):
    """The displacement (m,) that is looked at, for an unknown z."""
    _combine(shown, X, m, place, out)
    _sum(out, shown[place], z, m, out)


@_inline
def _slopes(found, w, a, b, by_e, by_rate, released, d):
    """The derivative (w,) of a residual by its unknown that springs give; released: lanes without that by rates."""
    begun = False
    for f in range(a, b):
        if by_e[f] != 0.0:
            slopes = _part(found, w * (4 * f + 1))
            if begun:
                _sum(d, by_e[f], slopes, w, d)
            else:
                _scaled(by_e[f], slopes, w, d)
            begun = True
    if not begun:
        _zero(d, w)
    for f in range(a, b):
        if by_rate[f] != 0.0:
            slopes = _part(found, w * (4 * f + 2))
            for s in range(w):
                if not released[s % LANES]:
                    d[s] += by_rate[f] * slopes[s]


@_inline
def _solved(i, w, matrices, q, d, B, kept, alive, x):
    """Solve with the matrix q of the system i + B^T diag(d) B, whose factors for the last few d (w,) are kept.

    Lanes are factorized together, anew for each d, as long as all matrices are symmetric and positive definite.
    Puts the solutions in place of the right sides x; returns whether the matrices are regular, and strikes lanes out of
    those that are alive whose one is not.
    """
    keys, factors, orders, spans, places, used, order, of_columns, now, exchanged, definite = kept
    n = used.shape[1]
    current, mine = _part(now, i * w), _part(used, i * n * n * LANES)
    if LANES > 1 and definite[i] and _differ(d, w, current):
        if _factorized_together(n, matrices, q, d, B, _part(of_columns, 2 * n * i), alive, mine):
            _copied(d, w, current)
        else:  # by pivots, which lanes find each for itself, from now on
            definite[i], used[i], now[i] = False, 0.0, np.nan
    for lane in range(LANES if _differ(d, w, current) else 0):
        if alive[lane] and _other(d, w, current, lane):
            of_lane = keys[i, lane], factors[i, lane], orders[i, lane], spans[i, lane], places[i, lane]
            in_use = used[i], order[i], of_columns[i], now[i], exchanged[i : i + 1]
            if not _renewed(matrices, q, d, lane, B, of_lane, in_use):
                alive[lane] = False
                return False
    _substituted(n, mine, _part(order, i * n * LANES), _part(of_columns, 2 * n * i), exchanged[i], x)
    return True


@_inline
def _iterated(X, m, i, place, known, rest, shown, guess, velocity, own, matrices, stiff, forces, slopes, springs,
              memories, kept, rules, largest, counts, shorter, alive, answers, rooms):  # fmt: skip
    """Put the unknown of the system i in its place by Newton's iteration, with its memories (1 + commits, ..).

    Counts the iterations of each lane, and the corrections that were shortened. Returns whether all lanes that are
    alive have converged, and strikes out those that fail. All lanes wait for those that seek a part of a change.
    """
    tolerance, exact, rounding, too_far, little, balanced, iterations, search, line = rules
    (z, old, residual, change, trial, other), numbers, flags = rooms
    (here, size, begin, left, before, farthest, gone, turned, previous, part, low, high, at_low, at_high,
     allowed) = numbers  # fmt: skip
    tries, active, released, near, ends = flags
    a, b, V, rows, of_rate, w = forces[5], forces[6], forces[7], springs[0][2], springs[2], springs[3]
    found, total, reach, current = answers[0], answers[6], abs(shown[place]), _part(kept[8], i * w)
    _combine(guess, X, m, place, trial)
    for n in range(LANES):
        counts[n], shorter[n], tries[n], active[n], released[n], previous[n] = 0, 0, 0, alive[n], 0, 0.0
    begun, unit = False, reach if reach != 0.0 else 1.0
    while True:
        _residual(trial, rest, matrices, 4 + i, place, forces, velocity, springs, memories, answers, residual, left)
        if begun:
            straight = True
            for n in range(LANES):
                straight = straight and (left[n] <= line * before[n] or not active[n])
            if straight:
                _slopes(found, w, a, b, slopes[0], slopes[1], released, total)
                if not _differ(total, w, current):  # all lanes were on lines, which most steps are
                    break
            _dot(change, residual, m, here)
            _largest(change, m, size)
            _dot(change, old, m, begin)
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
                    for k in range(n, m, LANES):
                        trial[k] = z[k] + part[n] * change[k]
                    seeking = True
            if seeking:
                continue
            if sought:
                for n in range(LANES):
                    for k in range(n, m if tries[n] > 0 else 0, LANES):
                        change[k] *= part[n]
                _largest(change, m, size)
            _displaced(shown, X, m, place, trial, other)
            _largest(other, m, farthest)
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
                _slopes(found, w, a, b, slopes[0], slopes[1], released, total)
                others = _differ(total, w, current)
                for n in range(LANES):
                    if near[n] and not (others and _other(total, w, current, n)):
                        active[n] = False
                    moving = moving or active[n]
                if not moving:
                    break
                moving = False
            _sum(other, -1.0, X, m, other)
            _largest(other, m, gone)
            _sum(trial, -1.0, change, m, other)
            _sum(trial, -1.0, other, m, other)
            _largest(other, m, turned)
            for n in range(LANES):
                rate = size[n] / previous[n] if previous[n] != 0.0 else 1.0
                rest_of = size[n] * min(1.0, rate / (1.0 - rate)) if rate < 1.0 else size[n]
                near[n] = rest_of <= max(tolerance * gone[n], exact * largest[n]) or turned[n] == 0.0
                ends[n] = near[n] or (previous[n] != 0.0 and rate >= 0.5 and size[n] <= rounding * largest[n])
                doubtful = doubtful or (of_rate and active[n] and ends[n])
            if doubtful:
                _largest(known, m, allowed)
                for p in range(3):
                    if own[V * p] != 0.0:
                        _zero(other, m)
                        _add_product(matrices, p, own[V * p], trial, other)
                        _largest(other, m, farthest)
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
        _slopes(found, w, a, b, slopes[0], slopes[1], released, total)
        _scaled(-1.0, residual, m, change)
        if not _solved(i, w, matrices, 4 + i, total, rows, kept, alive, change):
            return False
        for n in range(LANES):
            if not active[n]:
                for k in range(n, m, LANES):
                    change[k] = 0.0
        z, trial, old, residual = trial, z, residual, old
        _sum(z, 1.0, change, m, trial)
    _displaced(shown, X, m, place, trial, other)
    _largest(other, m, farthest)
    for n in range(LANES):
        largest[n] = max(largest[n], farthest[n]) if alive[n] else largest[n]
    _copied(trial, m, _part(X, m * place))
    return True
'''
