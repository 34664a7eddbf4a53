"""CALFEM's step2 loses the last step where the quotient of total time and step is just below a whole number.

Manual: docstring of calfem.core.step2, 3.6.16, "ip: Array [dt, tottime, alpha, delta] where dt is the size of the time
increment, tottime is the total time".
Source, calfem/core.py:6108: ns = int(tottime/dt) cuts off, so 0.3/0.1, which is 2.9999999999999996, becomes 2. A load
that was given for all the steps is cut likewise (lines 6109-6110).
"""

import numpy as np
from calfem.core import step2

one = np.eye(1)
start = np.ones((1, 1))
for dt, total in ((0.1, 0.3), (0.1, 0.7), (0.05, 0.15), (0.25, 0.75)):
    steps = round(total / dt)
    load = np.zeros((1, steps + 1))
    load[0, 0] = 1e-300  # not all zero, so its columns are counted
    history, _ = step2(one, 0 * one, one, load, start, 0 * start, [], [dt, total, 0.25, 0.5], [], np.array([]))
    columns = history["a"].shape[1]
    print(f"dt = {dt}, tottime = {total}: {columns} columns, expected {steps + 1}; tottime/dt = {total / dt!r}")
