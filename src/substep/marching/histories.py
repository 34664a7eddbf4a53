"""Histories of the linear march, a block of rows at a time, for runs whose whole histories nobody needs in memory."""

from collections.abc import Iterator

import numpy as np

from ..core.arrays import Array, read_only
from ..core.loads import Load
from ..core.schemes import Scheme
from ..run.clock import AT_ZERO, Begin
from .linear import LOADED, pieces, prepared
from .oscillators import Oscillators

NEAR = 1 << 17  # doubles of a block: a megabyte stays in a core's second cache


def histories(
    scheme: Scheme,
    o: Oscillators,
    n: int,
    load: Load | None = None,
    *,
    stride: int = 1,
    begin: Begin = AT_ZERO,
    last: Array | None = None,
) -> Iterator[tuple[int, Array]]:
    """Pairs of a row's number and a block (rows, 3, P) from that row on: u, v, a of every stride-th of n steps.

    begin: as for `march_linear`. last (m, P): takes what is marched, after the last step.

    Together they are the history of `march_linear`, row 0 included. A block is overwritten by the next one. A lane that
    overflows goes on with infinities or NaN.
    """
    P = len(o.omega)
    yield 0, np.array(o.start)[None]
    if not n or not P:
        return
    r = prepared(scheme, o, n, load, begin=begin)
    if r.head is not None and len(kept := r.head.out[stride::stride]):
        yield 1, kept
    most = max(4, NEAR // (3 * P))
    if r.loads.shared:
        loads, shared, room = r.loads, r.loads.of_all(0, n), np.empty((r.loads.K, 0, 1))
    else:
        most = min(most, LOADED)
        loads, shared, room = (
            r.loads.beforehand(n),
            (read_only(np.empty(0)),) * r.loads.K,
            np.zeros((r.loads.K, most, P)),
        )
    block, nothing = np.empty((most + 1, 3, P)), [np.empty(0)] * 3
    C, x, start = r.of(slice(0, P))
    if r.first >= n and last is not None:  # the starter has made all steps
        last[:] = x
    for done, end, base, pace in pieces(r.first, n, stride, most):
        if room.size:
            loads.of_each(base, end, slice(0, P), room)
        r.march_lanes(
            C, x, start, *(f[base:end] for f in shared), room, done - base, end - base, pace, block, *nothing, 0
        )  # fmt: skip
        if end == n and last is not None:
            last[:] = x
        if count := end // stride - done // stride:
            yield done // stride + 1, block[1 : 1 + count]
