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
{newton}

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
    iterated; the rows of the displacement that is looked at, of that from which it is iterated, and of the velocity;
    its first force; of the F forces weights, rows, places of memories, times since, and whether the unknown moves them
    not; how their slopes by elongations and by rates count (2, F); its first commit; rows of u and v (2, C, V) and
    times of commits, the last of which ends the step, and of each the force that is taken there, or -1; which row of
    the report is each row of the new state, or -1. out (S, V): the new state; report (R, V). structure: the four
    matrices, and of each system their sum for the unknown; the largest stiffness (LANES,); the J loads (J, m). springs:
    B; of each law its address, first spring, parameter and number remembered, and all parameters; whether some read
    rates. room: what it writes in.
    results: reports (rows, R, m), memories (rows, k), elongations, forces and stored energies of springs (rows, 3, s)
    after the last steps, iterations (rows, I, LANES), largest displacements and shortened corrections (I, LANES) so
    far; and where peaks are asked for, which are raised, rows of displacements that are looked at, in the form of B,
    their moduli in the first reports, and those of elongations and forces.

    Returns how many steps are done before one that fails in any lane; state and memory are those after the last.
    """
    (rows, used, iterated, shown, begins, velocity, first, forces, slopes, first_commit, commits, since_commit,
     answered, same) = plan  # fmt: skip
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
                    X, i, place, known, rest, shown[i], begins[i], velocity[i], rows[i, :, place], matrices, stiff,
                    mine, slopes[:, a:b], springs, memories, kept, rules, largest[i], counts[row, i], shorter[i], alive,
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
