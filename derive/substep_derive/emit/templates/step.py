"""The fixed text of what a step calls, and of iterations; every {field} is filled."""

# Newton's iteration where a function marches one lane; and what follows if it does not converge, in steps of one length
# and in chosen steps
NEWTON = """
        for taken_{balance} in range(1, 51):
{iteration}
            if largest <= {near}:
                break
        else:
{failed}"""

NEWTON_FAILED = "status, done = NEWTON_FAILED, i\nbreak"

NOT_CONVERGED = """counts[FAILED] += 1
counts[REJECTED] += 1
proposed, before = 0.25 * h, -1.0
continue"""

# the same for lanes side by side; the correction is taken times go: 0 for those that have converged and wait for others
NEWTON_SIDE_BY_SIDE = """
        for passes_{balance} in range(1, 51):
            if 0 < left < end - begin:
                waited = True
                for j in range(begin, end):
                    go_{balance}[j] = 0.0 if size[j] <= {near} else 1.0
                    idle_{balance}[j] += 1.0 - go_{balance}[j]
            left = 0
            for j in range(begin, end):
{iteration}
                size[j] = largest
                left += 0 if largest <= {near} else 1
            if left == 0:
                break
        if left > 0:
            for j in range(begin, end):
                if not size[j] <= {near}:
                    leaves[j], lane = 1.0, of_lane[j]
                    n_done[lane], status[lane] = i, NEWTON_FAILED
            continue  # the others begin the step again
"""

SINC = '''

@_inner
def _sinc(x):
    """sin(x)/x."""
    return np.sin(x) / x if x != 0.0 else 1.0
'''

SINC_SLOPE = '''

@_inner
def _sinc_slope(x):
    """Derivative of sin(x)/x; near 0, where (cos(x) - sin(x)/x)/x loses its digits, by its series."""
    if abs(x) < 0.3:
        y = x * x
        return x * (-1.0 / 3.0 + y * (1.0 / 30.0 + y * (-1.0 / 840.0 + y * (1.0 / 45360.0 - y / 3991680.0))))
    return (np.cos(x) - np.sin(x) / x) / x
'''

DIFFERENCE = '''

@_inner
def _{g}_difference(old, new):
    """({g}(new) - {g}(old))/(new - old), by Taylor's series where the difference would cancel."""
    d, m = new - old, 0.5 * (old + new)
    if abs(d) <= {near}:
{series}
        if abs(last) <= 1e-15 * abs(difference):
            return difference
    return ({at_new} - {at_old}) / d


@_inner
def _{g}_difference_slope(old, new):
    """Derivative of `_{g}_difference` with respect to new."""
    d, m = new - old, 0.5 * (old + new)
    if abs(d) <= {near}:
{slope_series}
        if abs(last) <= 1e-15 * abs(difference):
            return slope
    return ({slope_at_new} - _{g}_difference(old, new)) / d
'''

FIRST_OF = '''

@_inner
def _first_of(system, n):
    """The first unknown of a system, whose second matrix then ends with all: by elimination with partial pivoting."""
    width = n + 1
    A = system[n * width :]
    for p in range(n * width):
        A[p] = system[p]
    for k in range(n):
        at, most = k, abs(A[k * width + k])
        for i in range(k + 1, n):
            size = abs(A[i * width + k])
            if size > most:
                at, most = i, size
        top, other = A[k * width + k : (k + 1) * width], A[at * width + k : (at + 1) * width]
        for j in range(width - k if at > k else 0):
            top[j], other[j] = other[j], top[j]
        for i in range(k + 1, n):
            row = A[i * width + k : (i + 1) * width]
            times = row[0] / top[0]
            for j in range(width - k if times != 0.0 else 0):
                row[j] -= times * top[j]
    for k in range(n - 1, -1, -1):
        known = A[k * width + n]
        for j in range(k + 1, n):
            known -= A[k * width + j] * A[j * width + n]
        A[k * width + n] = known / A[k * width + k]
    return A[n]
'''
