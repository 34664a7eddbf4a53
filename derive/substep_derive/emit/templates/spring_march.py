"""Fixed text of the module that marches small structures with springs of laws, whatever the scheme and the laws."""

SPRING_MARCH = '''"""Steps of any scheme on a small structure with springs of laws: M a + C v + K u + B^T q = f.

What a step computes stands in arrays, and laws are called by their addresses, so that one loop serves all schemes and
all laws. It computes what the systems of `substep.structures.march` do step by step, and leaves a step that fails in
any way to these, with what there was before it as it was.

Vectors of a step, X (V, m): the state (S, m), then the unknowns of the I systems; m is a multiple of 4, beyond the n
degrees of freedom are zeros. Matrices (n, m) stand by columns, with `spans` (m/4, 2) of columns (first, last + 1) in
which each four rows have entries; B in compressed rows.
"""

import numpy as np
{imports}
_compile = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={{"contract"}})
# called by kernels alone: not from Python, and so without the code for that; they allocate nothing and count no
# references to arrays. What takes many arrays is put in line: each is passed as seven numbers
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

KEPT = 8  # sets of slopes of which the factors are kept, of each system
REGULAR = 1e-13  # of the largest pivot so far: what the next one must be more than
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
def _residual(z, rest, linear, spans, place, forces, velocity, springs, memories, work, out):
    """What the balance of a system leaves (n,) at its unknown z (m,): rest is what z does not move.

    work: the springs' answers (F, 4, s) to each of the forces, their elongations and rates where z is 0, and room.
    """
    weights, at, levels, since, fixed = forces
    B, laws, _ = springs
    found, before, rates_before, moved, e, rates, total, new = work
    _copy(rest, out)
    _add_product(linear, spans, 1.0, z, out)
    _elongations(B, z, moved)
    total[:] = 0.0
    for s in range(moved.size):
        rates[s] = rates_before[s] + velocity[place] * moved[s]
    for f in range(weights.size):
        if not fixed[f]:
            for s in range(moved.size):
                e[s] = before[f, s] + at[f, place] * moved[s]
            _answer(laws, e, rates, memories[levels[f]], since[f : f + 1], found[f], new[f])
            for s in range(moved.size):
                total[s] += weights[f] * found[f, 0, s]
    _spread(B, total, out)


@_inline
def _slopes(found, by_e, by_rate, released, d):
    """The derivative (s,) of a residual by its unknown that springs give; released: without that by rates."""
    d[:] = 0.0
    for f in range(by_e.size):
        if by_e[f] != 0.0 or by_rate[f] != 0.0:
            for s in range(d.size):
                d[s] += by_e[f] * found[f, 1, s]
                if not released:
                    d[s] += by_rate[f] * found[f, 2, s]


@_inline
def _iterated(X, i, place, known, rest, shown, velocity, own, linear, spans, structure, forces, slopes, springs,
              memories, kept, rules, largest, work, room):  # fmt: skip
    """Put the unknown of the system i in its place by Newton's iteration, with its memories (1 + commits, ..).

    Returns the iterations, 0 where it fails, and the corrections that were shortened.
    """
    tolerance, exact, rounding, too_far, little, balanced, iterations, search, line = rules
    matrices, matrix_spans, stiff = structure
    z, old, residual, change, trial, u, d = room
    found, total, of_rate, reach = work[0], work[6], springs[2], abs(shown[place])
    _combine(shown, X, place, u)
    for k in range(z.size):
        trial[k] = (X[0, k] - u[k]) / shown[place] if reach != 0.0 else 0.0
    _copy(trial, z)
    count, tries, released, previous, shorter = 0, 0, False, 0.0, 0
    part = low = high = begin = at_low = at_high = 0.0
    while True:
        _residual(trial, rest, linear, spans, place, forces, velocity, springs, memories, work, residual)
        if count > 0:
            here = _dot(change, residual)
            if tries == 0 and reach * _largest(change) > (exact if of_rate else rounding) * largest[i]:
                begin = _dot(change, old)
                if begin < 0.0 and here > -too_far * begin:  # a part of the change is sought
                    shorter += 1
                    low, high, at_low, at_high, tries = 0.0, 1.0, begin, here, 1
            elif 0 < tries and not abs(here) <= little * abs(begin):
                tries += 1
                if here < 0.0:
                    low, at_low, at_high = part, here, 0.5 * at_high
                else:
                    high, at_high, at_low = part, here, 0.5 * at_low
            elif tries > 0:
                tries = search + 1
            if 0 < tries <= search:
                part = low - at_low * (high - low) / (at_high - at_low)
                for k in range(z.size):
                    trial[k] = z[k] + part * change[k]
                continue
            if tries > 0:
                for k in range(z.size):
                    change[k] *= part
            size, farthest, gone, stays = (reach if reach != 0.0 else 1.0) * _largest(change), 0.0, 0.0, True
            for k in range(z.size):
                z[k] = trial[k]
                stays = stays and z[k] == z[k] - change[k]
                displaced = u[k] + shown[place] * z[k]
                farthest, gone = max(farthest, abs(displaced)), max(gone, abs(displaced - X[0, k]))
            largest[i] = max(largest[i], farthest)
            if not np.isfinite(size + _largest(residual)):
                return 0, shorter
            if _largest(residual) <= line * _largest(old):
                _slopes(found, slopes[0], slopes[1], released, total)
                on_lines = True
                for s in range(d.size):
                    on_lines = on_lines and total[s] == d[s]
                if on_lines:
                    _copy(z, X[place])
                    return count, shorter
            rate = size / previous if previous != 0.0 else 1.0
            left = size * min(1.0, rate / (1.0 - rate)) if rate < 1.0 else size
            small = left <= max(tolerance * gone, exact * largest[i]) or stays
            slow, released = previous != 0.0 and rate >= 0.5 and size <= rounding * largest[i], False
            if (small or slow) and of_rate:
                allowed = _largest(known)
                for m in range(3):
                    if own[m] != 0.0:
                        old[:] = 0.0
                        _add_product(matrices[m], matrix_spans[m], own[m], z, old)
                        allowed += _largest(old)
                released = _largest(residual) > balanced * allowed + 16.0 * exact * largest[i] * stiff
            if (small or slow) and not released:
                _copy(z, X[place])
                return count, shorter
            released, previous = released and small, size
            if count == iterations:
                return 0, shorter
        count, tries = count + 1, 0
        _slopes(found, slopes[0], slopes[1], released, d)
        for k in range(z.size):
            old[k], change[k] = residual[k], -residual[k]
        if not _solved(i, linear, d, springs[0], kept, change):
            return 0, shorter
        for k in range(z.size):
            trial[k] = z[k] + change[k]


@_inline
def _committed(X, u, v, since, answered, springs, memories, level, work, room):
    """Put behind the memories so far that committed at rows u, v (V,), since (1,) after the last.

    answered: the force that was the last to ask the springs there, -1 for none.
    """
    B, laws, of_rate = springs
    found, _, _, _, e, rates, _, new = work
    if answered >= 0:
        _copy(new[answered], memories[level + 1])
        return
    _combine(u, X, len(X), room)
    _elongations(B, room, e)
    rates[:] = 0.0
    if of_rate:
        _combine(v, X, len(X), room)
        _elongations(B, room, rates)
    _answer(laws, e, rates, memories[level], since, found[0], memories[level + 1])


@_inline
def _step(X, loads, n, rules, plan, structure, springs, memories, kept, counts, largest, shorter, work, rooms):
    """The unknowns of a step that has begun, under loads[:, n] (I, m); returns the commits made, -1 where it fails."""
    (rows, used, linear, spans, iterated, shown, velocity, first, forces, slopes, first_commit, commits, since_commit,
     answered) = plan  # fmt: skip
    weights, at, levels, since, fixed = forces
    matrices, matrix_spans, _ = structure
    B, laws, of_rate = springs
    found, before, rates_before, _, _, _, total, new = work
    known, rest, part, d, room = rooms
    S, level = len(X) - len(rows), 0
    for i in range(len(rows)):
        place, a, b = S + i, first[i], first[i + 1]
        for k in range(known.size):
            known[k] = -loads[i, n, k]
        for m in range(3):
            if used[i, m]:
                _combine(rows[i, m], X, place, part)
                _add_product(matrices[m], matrix_spans[m], 1.0, part, known)
        _copy(known, rest)
        if used[i, 3]:
            _combine(rows[i, 3], X, place, part)
            _add_product(matrices[3], matrix_spans[3], 1.0, part, rest)
        rates_before[:] = 0.0
        if of_rate and a < b:
            _combine(velocity[i], X, place, part)
            _elongations(B, part, rates_before)
        for f in range(a, b):
            _combine(at[f], X, place, part)
            _elongations(B, part, before[f])
            if fixed[f]:
                _answer(laws, before[f], rates_before, memories[levels[f]], since[f : f + 1], found[f], new[f])
                for s in range(total.size):
                    total[s] = weights[f] * found[f, 0, s]
                _spread(B, total, rest)
        counts[i] = 0
        if iterated[i]:
            mine = weights[a:b], at[a:b], levels[a:b], since[a:b], fixed[a:b]
            own_work = found[a:b], before[a:b], rates_before, work[3], work[4], work[5], total, new[a:b]
            counts[i], shorter[i] = _iterated(
                X, i, place, known, rest, shown[i], velocity[i], rows[i, :, place], linear[i], spans[i], structure,
                mine, slopes[:, a:b], springs, memories, kept, rules, largest, own_work, room,
            )
            if counts[i] == 0:
                return -1
        else:
            d[:] = 0.0
            for k in range(rest.size):
                X[place, k] = -rest[k]
            if not _solved(i, linear[i], d, B, kept, X[place]):
                return -1
        for c in range(first_commit[i], first_commit[i + 1]):
            u, v, when = commits[0, c], commits[1, c], since_commit[c : c + 1]
            _committed(X, u, v, when, answered[c], springs, memories, level, work, part)
            level += 1
    c = len(since_commit) - 1  # at the end of the step
    u, v, when = commits[0, c], commits[1, c], since_commit[c : c + 1]
    _committed(X, u, v, when, answered[c], springs, memories, level, work, part)
    return level + 1


@_compile
def march(state, memory, loads, rules, plan, out, report, structure, springs, results):
    """As many steps as there are loads (I, steps, m), from the state (S, m) and what is remembered (k,).

    rules: of Newton's iteration, as `substep.structures.march.newton` has them. plan: of each system four rows (4, V),
    of what M, C, K at the start and the linear part of the internal force multiply, and which of them are not 0 before
    the unknown; their sum for the unknown, and its spans; whether it is iterated; the row of the displacement that is
    looked at, and that of the velocity; its first force; of the F forces weights, rows, places of memories, times
    since, and whether the unknown moves them not; how their slopes by elongations and by rates count (2, F); its first
    commit; rows of u and v (2, C, V) and times of commits, the last of which ends the step, and of each the force that
    is taken there, or -1. out (S, V): the next state; report (R, V). structure: the four matrices, their spans, and the
    largest stiffness. springs: B; of each law its address, first spring, parameter and number remembered, and all
    parameters; whether some read rates. results: reports (steps, R, m), memories (steps, k), elongations, forces and
    stored energies of springs (steps, 4, s) after each step, with a row of room, iterations (steps, I), largest
    displacements and shortened corrections (I,) so far.
    What is made here is known to overlap with nothing else, so that loops over it are faster than over what is given.

    Returns how many steps are done before one that fails; state and memory are then those after the last of them.
    """
    reports, remembered, answers, counts, largest, shortened = results
    B, laws, of_rate = springs
    (I, steps, m), (S, V), n, s, k = loads.shape, out.shape, structure[0].shape[1], answers.shape[2], memory.size
    F = max(len(plan[8][0]), 1)
    X, next_state, memories = np.zeros((V, m)), np.empty((S, m)), np.empty((len(plan[12]) + 1, k))
    shorter, done, at_once = np.zeros(I, np.int64), 0, np.zeros(1)
    kept = (
        np.empty((I, KEPT, s)), np.empty((I, KEPT, n, m)), np.empty((I, KEPT, n), np.int64),
        np.empty((I, KEPT, n, 2), np.int64), np.zeros(I, np.int64), np.zeros(I, np.int64),
    )
    found, new, rates = np.empty((F, 4, s)), np.empty((F, k)), np.empty(s)
    work = found, np.empty((F, s)), rates, np.empty(s), np.empty(s), np.empty(s), np.empty(s), new
    room = np.empty(m), np.empty(m), np.empty(m), np.empty(m), np.empty(m), np.empty(m), np.empty(s)
    rooms = np.empty(m), np.empty(m), np.empty(m), np.empty(s), room
    for r in range(S):
        _copy(state[r], X[r])
    _copy(memory, memories[0])
    for step in range(steps):
        for i in range(shorter.size):
            shorter[i] = 0
        level = _step(
            X, loads, step, rules, plan, structure, springs, memories, kept, counts[step], largest, shorter, work, rooms
        )
        if level < 0 or not np.isfinite(_largest(X[V - 1])):
            break
        for r in range(len(report)):
            _combine(report[r], X, V, reports[step, r])
        for r in range(S):
            _combine(out[r], X, V, next_state[r])
        for r in range(S):
            _copy(next_state[r], X[r])
        _copy(memories[level], memories[0])
        _copy(memories[0], remembered[step])
        _elongations(B, reports[step, 0], answers[step, 0])
        rates[:] = 0.0
        if of_rate:
            _elongations(B, reports[step, 1], rates)
        _answer(laws, answers[step, 0], rates, memories[0], at_once, found[0], new[0])
        _copy(found[0, 0], answers[step, 1])
        _copy(found[0, 3], answers[step, 2])
        for i in range(shorter.size):
            shortened[i] += shorter[i]
        done += 1
    for r in range(S):
        _copy(X[r], state[r])
    _copy(memories[0], memory)
    return done
'''
