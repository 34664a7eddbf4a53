"""The fixed text of a march over blocks of lanes; every {field} is filled."""

LOOK = """# steps after which it is looked at whether lanes fail: of steps in which one does each is taken once more
LOOK = 32
"""

BLOCK = '''

# most lanes of a block. A row holds one variable of all its lanes; the rows of a step stay in the first-level cache
WIDTH = {width}
{look}

@_inner
def _leave({leaving}):
    """Hand over the results of lanes that leave, and put a copy of one that stays in their place; whether one does."""
    other = -1
    for j in range(begin, end):
        if runs[j] and leaves[j] == 0.0:
            other = j
        elif runs[j]:
            runs[j], lane = False, j - place
{results}
            for number in range(extremes.shape[1]):
                extremes[lane, number] = rows[{extreme} + number, j]
    if other >= 0:
        for j in range(begin, end):
            if leaves[j] > 0.0:
                of_lane[j] = of_lane[other]
                for number in range(rows.shape[0]):
                    rows[number, j] = rows[number, other]
    return other >= 0


@_inner
def _block(lane0, lane1, {arguments}):
    """March lanes lane0 to lane1, at most WIDTH, in vector registers.

    Every column of the rows is marched: behind the last lane, and where a lane has left, stand copies of others.
    """
    widest()
    rows = np.empty(({rows}, WIDTH + 16))
    begin = -(rows.ctypes.data // 8) & 7  # at a cache line
    end = begin + 8 * ((lane1 - lane0 + 7) // 8)
    place = begin - lane0  # a lane stands in column place + lane
    of_lane = np.empty(WIDTH + 16, dtype=np.int64)  # whose numbers a column has
    runs = np.empty(WIDTH + 16, dtype=np.bool_)  # whether they are its own lane's
{counts}{allocate}
    for j in range(begin, end):
        lane = of_lane[j] = min(j - place, lane1 - 1)
        runs[j] = j - place == lane
        n_done[lane], status[lane] = n[lane], COMPLETED
{read}
        for number in range(extremes.shape[1]):
            rows[{extreme} + number, j] = extremes[lane, number]
{constants}{loop}

@_compile
def march_block({arguments}):
    """The same results as march, WIDTH lanes at a time."""
    for lane in range(0, h.size, WIDTH):
        _block(lane, min(lane + WIDTH, h.size), {arguments})
'''

# where balances iterate: each step is looked at, and a lane that is not good keeps what it had by selection
BLOCK_ITERATES = """    i, ends, left = first, first, 0
    while True:
        if i == ends or left > 0:
            ends = 1 << 62  # farther than any lane goes
            for j in range(begin, end):
                if n[of_lane[j]] > i:
                    ends = min(ends, n[of_lane[j]])
                else:
                    leaves[j] = 1.0
{all_go}            if not {leave}:
                return
            left = 0
        waited = False
{steps}        bad = 0
        for j in range(begin, end):
{reported}
            now = energy + 0.0 * ({sum})  # NaN unless all are finite
            seen[j] = now
            good = now <= bound_row[j]
            bad = bad if good else 1
            top = peak_row[j] + 0.0  # a sum: a selection of what stands there is stored with a mask, which can be slow
{read_shift}
            peak_row[j] = now if good & (now > top) else top
{shift}
        if bad > 0:
            for j in range(begin, end):
                if not seen[j] <= bound_row[j]:
                    leaves[j], lane = 1.0, of_lane[j]
                    n_done[lane], status[lane] = i, ENERGY_BOUND if seen[j] > bound_row[j] else NON_FINITE
            if not {leave}:
                return
{count}        if (i + 1) % stride == 0:
            for number in range(extremes.shape[1]):  # the first rows are u, then v and a
                for j in range(begin, end):
                    rows[{extreme} + number, j] = max(rows[{extreme} + number, j], abs(rows[number, j])) + 0.0
            if (i + 1) // stride < out.shape[1]:
                for j in range(begin, end):
                    if runs[j]:
                        row = out[j - place, (i + 1) // stride]
{store}
        i += 1
"""

# where no balance iterates: what is marched on is kept LOOK steps ago, and looked at no more often
BLOCK_LOOKS = """    every = LOOK if out.shape[1] == 0 else 1  # a history ends where its lane does
    i, since, looks, ends, again = first, first, first, first, first
    while True:
        if i == looks:  # where all is good so far
            if i == ends:
                ends = 1 << 62  # farther than any lane goes
                for j in range(begin, end):
                    if n[of_lane[j]] > i:
                        ends = min(ends, n[of_lane[j]])
                    else:
                        leaves[j] = 1.0
                if not {leave}:
                    return
            for number in range({kept}):
                for j in range(begin, end):
                    rows[{kept} + number, j] = rows[number, j]
            since, looks = i, min(ends, i + (LOOK if i >= again else 1))
{steps}        for j in range(begin, end):
{reported}
            peak_row[j] = max(peak_row[j], energy) + 0.0 * ({sum})  # NaN from a number on that is not finite
{shift}
        i += 1
        if i == looks:
            bad = 0
            for j in range(begin, end):
                bad = bad if peak_row[j] <= bound_row[j] else 1
            if bad > 0 and i > since + 1:  # the same steps again, one by one
                for number in range({kept}):
                    for j in range(begin, end):
                        rows[number, j] = rows[{kept} + number, j]
                i, looks, again = since, since + 1, i
                continue
            if bad > 0:
                for j in range(begin, end):
                    if not peak_row[j] <= bound_row[j]:
                        leaves[j], lane = 1.0, of_lane[j]
                        n_done[lane], status[lane] = since, ENERGY_BOUND if peak_row[j] > bound_row[j] else NON_FINITE
                        for number in range({kept}):
                            rows[number, j] = rows[{kept} + number, j]
                        for number in range(since // stride + 1, min(again // stride + 1, out.shape[1])):
                            if runs[j]:  # its history ends here
                                out[j - place, number] = 0.0
                if not {leave}:
                    return
        if i % stride == 0:
            for number in range(extremes.shape[1]):  # the first rows are u, then v and a
                for j in range(begin, end):
                    rows[{extreme} + number, j] = max(rows[{extreme} + number, j], abs(rows[number, j])) + 0.0
            if i // stride < out.shape[1]:
                for j in range(begin, end):
                    if runs[j]:
                        row = out[j - place, i // stride]
{store}
"""

BLOCK_COUNTS = """    # Newton's iterations of steps in which all lanes took the same number: their sum, and the most
    common = np.empty((2, {balances}), dtype=np.int64)
    common[:] = 0
"""

BLOCK_COUNT = """        if i < iterations.shape[1]:
            for j in range(begin, end):
                if runs[j]:
{store}
        if waited:
            for j in range(begin, end):
{own}
        else:
{common}
"""
