"""For programs that print while they are imported: their words go to standard error, not among the answers."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def printing_aside() -> Iterator[None]:
    """Standard output is standard error inside, also for what is printed from C."""
    sys.stdout.flush()
    answers = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(answers, 1)
        os.close(answers)
