"""Work spread over the cores this process may use, by threads: kernels release the interpreter's lock."""

import os
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache

_most: ContextVar[int | None] = ContextVar("most", default=None)
WORTH_THREADS = 1e6  # ns of work; less than this is done faster by one thread
PIECES = 8  # into which the work of each core is split: others take over the pieces of a thread that is late or slow


def cores() -> int:
    """How many cores this process may use, or fewer for what runs inside `at_most`."""
    most = _most.get()
    return _there() if most is None else min(_there(), most)


def _there() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def at_most(workers: int | None) -> Generator[None]:
    """Kernels called inside use no more cores than that; None: as many as there are."""
    token = _most.set(workers)
    try:
        yield
    finally:
        _most.reset(token)


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads)  # kept, since starting threads takes as long as a small piece of work


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # a forked process has the pool, but not its threads


def ranges(first: int, last: int, size: int) -> Iterator[slice]:
    """Ranges of that size, the last of which may be shorter, that together cover first to last."""
    return (slice(begin, min(begin + size, last)) for begin in range(first, last, size))


def spread(part: Callable[[int, int], None], size: int, block: int, *, nanoseconds: float) -> None:
    """Call part(first, last) for ranges that together cover 0 to size: one range, or many on all cores for long work.

    A range is a whole number of blocks, except the last. nanoseconds: about how long all the work takes on one core.
    """
    blocks = -(-size // block)
    workers = max(1, min(cores(), blocks)) if nanoseconds >= WORTH_THREADS else 1
    if workers == 1:
        part(0, size)
        return
    step = block * -(-blocks // (PIECES * workers))
    todo = iter(range(0, size, step))

    def work() -> None:
        for first in todo:
            part(first, min(size, first + step))

    helping = [_pool(workers - 1).submit(work) for _ in range(workers - 1)]
    work()
    for one in helping:
        one.result()
