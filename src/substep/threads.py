"""Kernels release the interpreter's lock: work is spread over the cores this process may use."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor


def cores() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def spread(part: Callable[[int, int], None], size: int, block: int, *, worth: bool) -> None:
    """Call part(first, last) until all of size is done: at once, or, if worth it, whole blocks by each core."""
    blocks = -(-size // block)
    workers = min(cores(), blocks) if worth else 1
    if workers == 1:
        part(0, size)
        return
    ends = [*(block * round(blocks * k / workers) for k in range(workers)), size]
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(part, ends[:-1], ends[1:]))
