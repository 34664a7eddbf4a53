"""Fixed text of the module that marches small structures with springs of laws, whatever the scheme and the laws."""

SPRING_MARCH = '''"""Steps of any scheme on a small structure with springs of laws: M a + C v + K u + B^T q = f.

What a step computes stands in arrays, and laws are called by their addresses, so that one loop serves all schemes and
all laws. It computes what the systems of `substep.structures.march` do step by step, and leaves a step that fails in
any way to these, with what there was before it as it was.

Structures that differ in numbers alone go side by side, in lanes: what there is n times stands as (n, LANES), in a row.
Vectors of a step, X (V, m): the state (S, m), then the unknowns of the I systems; m is n LANES up to a multiple of
WIDTH, beyond are zeros. Of all matrices each WIDTH numbers of such a vector have blocks of as many entries, `values`,
which multiply a number of another vector, at `places`, or with lanes one of each lane; `first` (matrices, m/WIDTH + 1)
of the blocks. So B, and B^T, of springs stand, whose vectors have w numbers; functions take where arrays begin.
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
{products}

@_inline
def _row(array, k):
    """A row of an array of two axes, the first number of it."""
    return _part(array, k * array.shape[1])


@_inline
def _blocks(matrices):
    """Matrices as functions take them, with how many rows of blocks each has."""
    first, places, values = matrices
    return _part(first, 0), _part(places, 0), _part(values, 0), first.shape[1] - 1


@_inline
def _answer(laws, w, e, rates, memory, since, found, new):
    """Force, its slopes by e and by its rate, stored energy (4, w) of springs at e, and what a commit there remembers.

    memory: that committed `since` (1,) before.
    """
    functions, first, given, kept, parameters, count = laws
    for g in range(count):
        a, d = first[g], kept[g]
        _call(
            functions[g], first[g + 1] - a, _part(parameters, given[g]), _part(e, a), _part(rates, a), _part(memory, d),
            since, _part(found, a), _part(found, w + a), _part(found, 2 * w + a), _part(new, d),
            _part(found, 3 * w + a),
        )
{newton}

@_inline
def _committed(c, X, m, V, commits, since, springs, memory, answers, out, part):
    """What a commit that no force answers remembers after that memory."""
    (B, _, _), laws, of_rate, w, _ = springs
    rows, count = commits
    e, rates = answers[4], answers[5]
    _combine(_part(rows, c * V), X, m, V, part)
    _elongations(B, part, e)
    _zero(rates, w)
    if of_rate:
        _combine(_part(rows, (count + c) * V), X, m, V, part)
        _elongations(B, part, rates)
    _answer(laws, w, e, rates, memory, _part(since, c), answers[0], out)


@_compile
def march(state, memory, loads, alive, rules, plan, out, report, structure, springs, room, results):
    """As many steps as there are factors of loads (I, steps, J LANES), from the state (S, m) and a memory (k,).

    alive (LANES,): which lanes count; those that fail are struck out. rules: of Newton's iteration, as
    `substep.structures.march.newton` has them. plan: of each system four rows (4, V), of what M, C, K at the start and
    the linear part of the internal force multiply, and which of them count before the unknown; whether it is iterated;
    the rows of the displacement that is looked at, of the unknown from which it is iterated, and of the velocity; its
    first force; of the F forces weights, rows, places of memories, times since, and whether the unknown moves them not;
    how their slopes by elongations and by rates count (2, F); its first commit; rows of u and v (2, C, V) and times of
    commits, the last of which ends the step, and of each the force that is taken there, or -1; which row of the report
    is each row of the new state, or -1. out (S, V): the new state; report (R, V). structure: the four matrices, and of
    each system their sum for the unknown; the largest stiffness (LANES,); the J loads (J, m). springs: B, and B^T, as
    blocks and B in compressed rows; of each law its address, first spring, parameter and number remembered, and all
    parameters; whether some read rates. room: what it writes in.
    results: reports (rows, R, m), memories (rows, k), elongations, forces and stored energies of springs (rows, 3, w)
    after the last steps, iterations (rows, I, LANES), largest displacements and shortened corrections (I, LANES) so
    far; and where peaks are asked for, which are raised, rows of displacements that are looked at, in compressed rows,
    their moduli in the first reports, and those of elongations and forces.

    Returns how many steps are done before one that fails in any lane; state and memory are those after the last.
    """
    (rows, used, iterated, shown, guess, velocity, first, forces, slopes, first_commit, commits, since_commit,
     answered, same) = plan  # fmt: skip
    (weights, at, levels, since, fixed), (of_vectors, of_spring_rows, of_lanes, flags) = forces, room[1]
    of_matrices, stiff, shapes = structure
    (B, transposed, compressed), of_laws, of_rate = springs
    (of_state, next_state, of_memories), _, (found, before, new), kept, (shorter, largest_before, at_once) = room
    reports, remembered, strains, counts, largest, shortened, chosen, peaks, strained = results
    (I, steps, _), (S, V), m, k, w = loads.shape, out.shape, of_state.shape[1], len(memory), before.shape[1]
    F, C, J, last, done = len(weights), commits.shape[1], len(shapes), len(answered) - 1, 0
    X, memories = _part(of_state, 0), _part(of_memories, 0)
    known, rest, part = _row(of_vectors, 0), _row(of_vectors, 1), _row(of_vectors, 2)
    newton = (
        _row(of_vectors, 3), _row(of_vectors, 4), _row(of_vectors, 5), _row(of_vectors, 6), _row(of_vectors, 7),
        _row(of_vectors, 8),
    ), (
        _row(of_lanes, 0), _row(of_lanes, 1), _row(of_lanes, 2), _row(of_lanes, 3), _row(of_lanes, 4),
        _row(of_lanes, 5), _row(of_lanes, 6), _row(of_lanes, 7), _row(of_lanes, 8), _row(of_lanes, 9),
        _row(of_lanes, 10), _row(of_lanes, 11), _row(of_lanes, 12), _row(of_lanes, 13), _row(of_lanes, 14),
    ), flags  # fmt: skip
    functions, of_first, of_given, of_kept, parameters = of_laws
    laws = (_part(functions, 0), _part(of_first, 0), _part(of_given, 0), _part(of_kept, 0), _part(parameters, 0),
            len(functions))  # fmt: skip
    matrices, B, transposed = _blocks(of_matrices), _blocks(B), _blocks(transposed)
    entries = _part(compressed[0], 0), _part(compressed[1], 0), _part(compressed[2], 0), len(compressed[0]) - 1
    of_springs = (B, transposed, entries), laws, of_rate, w, k
    rates_before, moved, e, rates, total = (
        _row(of_spring_rows, 0), _row(of_spring_rows, 1), _row(of_spring_rows, 2), _row(of_spring_rows, 3),
        _row(of_spring_rows, 4),
    )  # fmt: skip
    found, before, new = _part(found, 0), _part(before, 0), _part(new, 0)
    work = found, before, rates_before, moved, e, rates, total, new
    every, levels, since = _part(weights, 0), _part(levels, 0), _part(since, 0)
    by_slopes, of_commits = (_row(slopes, 0), _row(slopes, 1)), (_part(commits, 0), C)
    _copied(_part(state, 0), S * m, X)
    _copied(_part(memory, 0), k, memories)
    for step in range(steps):
        level, good, row = 0, True, step % len(reports)
        for i in range(I):
            for lane in range(LANES):
                largest_before[i, lane] = largest[i, lane]
        for i in range(I):
            place, a, b, mine = S + i, first[i], first[i + 1], _part(rows, 4 * V * i)
            _zero(rest, m)
            for j in range(J):
                _loaded(_part(loads, (i * steps + step) * J * LANES), j * LANES, _row(shapes, j), m, rest)
            for p in range(4):
                if p == 3 and of_rate:
                    _copied(rest, m, known)
                if used[i, p]:
                    _combine(_part(mine, p * V), X, m, place, part)
                    _add_product(matrices, p, 1.0, part, rest)
            if of_rate and a < b:
                _combine(_row(velocity, i), X, m, place, part)
                _elongations(B, part, rates_before)
            for f in range(a, b):
                _combine(_row(at, f), X, m, place, part)
                _elongations(B, part, _part(before, w * f))
                if fixed[f]:
                    force = _part(found, 4 * w * f)
                    _answer(laws, w, _part(before, w * f), rates_before, _part(memories, k * levels[f]),
                            _part(since, f), force, _part(new, k * f))  # fmt: skip
                    _scaled(every[f], force, w, total)
                    _add_product(transposed, 0, 1.0, total, rest)
            if iterated[i]:
                of_forces = every, _part(at, 0), levels, since, fixed, a, b, V
                good = _iterated(
                    X, m, i, place, known, rest, _row(shown, i), _row(guess, i), _row(velocity, i),
                    _part(mine, place), matrices, stiff, of_forces, by_slopes, of_springs, memories, kept, rules,
                    largest[i], counts[row, i], shorter[i], alive, work, newton,
                )  # fmt: skip
            else:
                counts[row, i] = 0
                _zero(total, w)
                _scaled(-1.0, rest, m, _part(X, m * place))
                good = _solved(i, w, matrices, 4 + i, total, entries, kept, alive, _part(X, m * place))
            if not good:
                break
            for c in range(first_commit[i], first_commit[i + 1] - (1 if i == I - 1 else 0)):
                to = _part(memories, k * (level + 1))
                if answered[c] >= 0:
                    _copied(_part(new, k * answered[c]), k, to)
                else:
                    _committed(c, X, m, V, of_commits, since_commit, of_springs, _part(memories, k * level), work, to,
                               part)  # fmt: skip
                level += 1
        size = newton[1][0]
        _largest(_part(X, m * (V - 1)), m, size)
        for lane in range(LANES):
            if good and alive[lane] and not np.isfinite(size[lane]):
                alive[lane], good = False, False
        if not good:
            for i in range(I):
                for lane in range(LANES):
                    largest[i, lane] = largest_before[i, lane]
            break
        f, to = answered[last], _part(remembered, k * row)
        if f >= 0:
            _copied(_part(new, k * f), k, to)
        else:
            _committed(last, X, m, V, of_commits, since_commit, of_springs, _part(memories, k * level), work, to, part)
        _copied(to, k, memories)
        for r in range(len(report)):
            _combine(_row(report, r), X, m, V, _part(reports, m * (len(report) * row + r)))
        for r in range(S):
            if same[r] < 0:
                _combine(_row(out, r), X, m, V, _row(next_state, r))
        for r in range(S):
            if same[r] < 0:
                _copied(_row(next_state, r), m, _part(X, m * r))
            else:
                _copied(_part(reports, m * (len(report) * row + same[r])), m, _part(X, m * r))
        strain = _part(strains, 3 * w * row)
        _elongations(B, _part(reports, m * len(report) * row), strain)
        _zero(rates, w)
        if of_rate:
            _elongations(B, _part(reports, m * (len(report) * row + 1)), rates)
        _answer(laws, w, strain, rates, memories, _part(at_once, 0), found, new)  # as where a march goes on, to the bit
        _copied(found, w, _part(strain, w))
        _copied(_part(found, 3 * w), w, _part(strain, 2 * w))
        for r in range(len(peaks)):
            _raised(chosen, _part(reports, m * (len(report) * row + r)), _row(peaks, r))
        for r in range(len(strained)):
            for p in range(0, w, WIDTH):
                _raise(_row(strained, r), p, _several(strain, w * r + p))
        for i in range(I):
            for lane in range(LANES):
                shortened[i, lane] += shorter[i, lane]
        done += 1
    _copied(X, S * m, _part(state, 0))
    _copied(memories, k, _part(memory, 0))
    return done
'''
