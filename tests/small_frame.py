"""A frame of three degrees of freedom, which tests ask for things and give bad input."""

from typing import Any

import numpy as np

import substep as ss

M = np.diag([2.0, 1.0, 3.0])
K = np.array([[6.0, -2.0, 0.0], [-2.0, 5.0, -3.0], [0.0, -3.0, 3.0]])
NAMES = ("first", "second", "roof")
RECORD = ss.Record(0.1, np.sin(np.arange(60)))
PUSH = ([0.0, 0.0, 1.0], ss.Step(1.0))


def frame(**more: Any) -> ss.Structure:
    return ss.structure(M, K, **{"names": NAMES, "u0": [0.1, 0.0, 0.2], **more})
