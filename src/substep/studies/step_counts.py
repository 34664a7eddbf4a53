"""How many steps a choice tries, and at how many times it looks at errors."""

from collections.abc import Iterator
from itertools import count

SAMPLES, PHASES = 50, 8  # errors are reported at least so often, and so often in a vibration
FINER = 100  # the reference is this many times more accurate than is wished of a run


def ladder(samples: int = SAMPLES) -> Iterator[int]:
    """Numbers of steps: 1, 2, 3, 4, 6, 8, 12, ... times the intervals on which errors are reported."""
    yield samples
    for k in count(1):
        yield samples << k
        yield 3 * samples << (k - 1)
