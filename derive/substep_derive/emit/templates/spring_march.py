"""Fixed text of the module that marches small structures with springs of laws, whatever the scheme and the laws."""

SPRING_MARCH = '''"""Steps of any scheme on a small structure with springs of laws: M a + C v + K u + B^T q = f.

What a step computes stands in arrays, and laws are called by their addresses, so that one loop serves all schemes and
all laws. It computes what the systems of `substep.structures.march` do step by step, and leaves a step that fails in
any way to these, with what there was before it as it was.

Structures that differ in numbers alone go side by side, in lanes: what there is n times stands as (n, LANES), in a row.
Vectors of a step, X (V, m): the state (S, m), then the unknowns of the I systems; m is n LANES up to a multiple of
WIDTH, beyond are zeros. Of all matrices each WIDTH numbers of such a vector have blocks of as many entries, `values`,
which multiply a number of another vector, at `places`, or with lanes one of each lane; `first` (matrices, m/WIDTH + 1)
of the blocks. B is the same in all lanes, in compressed rows.
"""

import numpy as np
{imports}from numba.extending import models, register_model

# they allocate nothing and count no references to arrays
_compile = njit(
    cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={{"contract"}}, _nrt=False
)
# called by kernels alone: not from Python, and so without the code for that. What takes many arrays is put in line:
# each is passed as seven numbers
_inner = njit(
    nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, fastmath={{"contract"}},
    _nrt=False,
)
_inline = njit(
    nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, fastmath={{"contract"}},
    _nrt=False, forceinline=True,
)
_rounded = njit(
    nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, _nrt=False, forceinline=True
)

REGULAR = 1e-13  # of the largest pivot so far: what the next one must be more than
LANES = {lanes}  # structures side by side
WIDTH = max(LANES, 4)  # numbers that are taken at once
{call}

@intrinsic
def _pointer(typing, array, place):
    """Where the number at a place of a contiguous array is."""

    def lower(context, builder, signature, values):
        return builder.gep(context.make_array(array)(context, builder, values[0]).data, [values[1]])

    return types.CPointer(array.dtype)(array, types.int64), lower


def _part(array, place):
    """A contiguous array from a place on: in compiled code its address, which takes less time than a part of it."""
    return array.reshape(-1)[place:]


@overload(_part)
def _part_compiled(array, place):
    return lambda array, place: _pointer(array, place)
{products}

@_inline
def _answer(laws, e, rates, memory, since, found, new):
    """Force, its slopes by e and by its rate, stored energy (4, s) of springs at e, and what a commit there remembers.

    memory: that committed `since` (1,) before.
    """
    functions, first, given, kept, parameters = laws
    size = e.size
    for g in range(len(functions)):
        a, d = first[g], kept[g]
        _call(
            functions[g], first[g + 1] - a, _part(parameters, given[g]), _part(e, a), _part(rates, a), _part(memory, d),
            since, _part(found, a), _part(found, size + a), _part(found, 2 * size + a), _part(new, d),
            _part(found, 3 * size + a),
        )


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
def _iterated(X, i, place, known, rest, shown, velocity, own, matrices, stiff, forces, slopes, springs, memories, kept,
              rules, largest, counts, shorter, alive, work, rooms):  # fmt: skip
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
        _sum(X[0], -1.0, u, trial)
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


@_inline
def _committed(c, X, commits, since, answered, springs, memory, found, new, out, part, e, rates):
    """What a commit remembers after that memory, of the answer that was taken where it is, if there is one."""
    B, laws, of_rate = springs
    if answered[c] >= 0:
        _scaled(1.0, new[answered[c]], out)
    else:
        _combine(commits[0, c], X, len(X), part)
        _elongations(B, part, e)
        _zero(rates)
        if of_rate:
            _combine(commits[1, c], X, len(X), part)
            _elongations(B, part, rates)
        _answer(laws, e, rates, memory, since[c : c + 1], found[0], out)


@_compile
def march(state, memory, loads, alive, rules, plan, out, report, structure, springs, room, results):
    """As many steps as there are factors of loads (I, steps, J LANES), from the state (S, m) and a memory (k,).

    alive (LANES,): which lanes count; those that fail are struck out. rules: of Newton's iteration, as
    `substep.structures.march.newton` has them. plan: of each system four rows (4, V), of what M, C, K at the start and
    the linear part of the internal force multiply, and which of them are not 0 before the unknown; whether it is
    iterated; the row of the displacement that is looked at, and that of the velocity; its first force; of the F forces
    weights, rows, places of memories, times since, and whether the unknown moves them not; how their slopes by
    elongations and by rates count (2, F); its first commit; rows of u and v (2, C, V) and times of commits, the last of
    which ends the step, and of each the force that is taken there, or -1; which row of the report is each row of the
    new state, or -1. out (S, V): the new state; report (R, V). structure: the four matrices, and of each system their
    sum for the unknown; the largest stiffness (LANES,); the J loads (J, m). springs: B; of each law its address, first
    spring, parameter and number remembered, and all parameters; whether some read rates. room: what it writes in.
    results: reports (rows, R, m), memories (rows, k), elongations, forces and stored energies of springs (rows, 3, s)
    after the last steps, iterations (rows, I, LANES), largest displacements and shortened corrections (I, LANES) so
    far; and where peaks are asked for, which are raised, rows of displacements that are looked at, in the form of B,
    their moduli in the first reports, and those of elongations and forces.

    Returns how many steps are done before one that fails in any lane; state and memory are those after the last.
    """
    (rows, used, iterated, shown, velocity, first, forces, slopes, first_commit, commits, since_commit, answered,
     same) = plan  # fmt: skip
    weights, at, levels, since, fixed = forces
    matrices, stiff, shapes = structure
    B, laws, of_rate = springs
    (X, next_state, memories), (known, rest, part), newton, work, kept, (shorter, largest_before, at_once) = room
    found, before, rates_before, moved, e, rates, total, new = work
    reports, remembered, answers, counts, largest, shortened, chosen, peaks, strained = results
    (I, steps, _), (S, V), done = loads.shape, out.shape, 0
    for r in range(S):
        _scaled(1.0, state[r], X[r])
    _scaled(1.0, memory, memories[0])
    for step in range(steps):
        level, good, row = 0, True, step % len(reports)
        for i in range(I):
            for lane in range(LANES):
                largest_before[i, lane] = largest[i, lane]
        for i in range(I):
            place, a, b = S + i, first[i], first[i + 1]
            _zero(known)
            for j in range(len(shapes)):
                _loaded(loads[i, step], j * LANES, shapes[j], known)
            for m in range(3):
                if used[i, m]:
                    _combine(rows[i, m], X, place, part)
                    _add_product(matrices, m, 1.0, part, known)
            _scaled(1.0, known, rest)
            if used[i, 3]:
                _combine(rows[i, 3], X, place, part)
                _add_product(matrices, 3, 1.0, part, rest)
            _zero(rates_before)
            _zero(rates)
            if of_rate and a < b:
                _combine(velocity[i], X, place, part)
                _elongations(B, part, rates_before)
            for f in range(a, b):
                _combine(at[f], X, place, part)
                _elongations(B, part, before[f])
                if fixed[f]:
                    _answer(laws, before[f], rates_before, memories[levels[f]], since[f : f + 1], found[f], new[f])
                    _zero(total)
                    _sum(total, weights[f], found[f, 0], total)
                    _spread(B, total, rest)
            if iterated[i]:
                mine = weights[a:b], at[a:b], levels[a:b], since[a:b], fixed[a:b]
                own_work = found[a:b], before[a:b], rates_before, moved, e, rates, total, new[a:b]
                good = _iterated(
                    X, i, place, known, rest, shown[i], velocity[i], rows[i, :, place], matrices, stiff, mine,
                    slopes[:, a:b], springs, memories, kept, rules, largest[i], counts[row, i], shorter[i], alive,
                    own_work, newton,
                )  # fmt: skip
            else:
                counts[row, i] = 0
                _zero(total)
                _scaled(-1.0, rest, X[place])
                good = _solved(i, matrices, 4 + i, total, B, kept, alive, X[place])
            if not good:
                break
            for c in range(first_commit[i], first_commit[i + 1] - (1 if i == I - 1 else 0)):
                _committed(c, X, commits, since_commit, answered, springs, memories[level], found, new,
                           memories[level + 1], part, e, rates)  # fmt: skip
                level += 1
        size = newton[1][0]
        _largest(X[V - 1], size)
        for lane in range(LANES):
            if good and alive[lane] and not np.isfinite(size[lane]):
                alive[lane], good = False, False
        if not good:
            for i in range(I):
                for lane in range(LANES):
                    largest[i, lane] = largest_before[i, lane]
            break
        c = len(answered) - 1
        _committed(c, X, commits, since_commit, answered, springs, memories[level], found, new, memories[level + 1],
                   part, e, rates)  # fmt: skip
        _scaled(1.0, memories[level + 1], memories[0])
        _scaled(1.0, memories[0], remembered[row])
        for r in range(len(report)):
            _combine(report[r], X, V, reports[row, r])
        for r in range(S):
            if same[r] < 0:
                _combine(out[r], X, V, next_state[r])
        for r in range(S):
            _scaled(1.0, next_state[r] if same[r] < 0 else reports[row, same[r]], X[r])
        _elongations(B, reports[row, 0], answers[row, 0])
        _zero(rates)
        if of_rate:
            _elongations(B, reports[row, 1], rates)
        _answer(laws, answers[row, 0], rates, memories[0], at_once, found[0], new[0])
        _scaled(1.0, found[0, 0], answers[row, 1])
        _scaled(1.0, found[0, 3], answers[row, 2])
        for r in range(len(peaks)):
            _raised(chosen, reports[row, r], peaks[r])
        for r in range(len(strained)):
            for k in range(0, strained[r].size, WIDTH):
                _raise(strained[r], k, _several(answers[row, r], k))
        for i in range(I):
            for lane in range(LANES):
                shortened[i, lane] += shorter[i, lane]
        done += 1
    for r in range(S):
        _scaled(1.0, X[r], state[r])
    _scaled(1.0, memories[0], memory)
    return done
'''
