"""Chunks run by the workers of a dask.distributed cluster; if a worker dies, another runs its chunks again."""

from collections.abc import Generator, Sequence
from itertools import islice
from typing import Any

from ..core import single
from ..core.device import on
from ..core.threads import at_most
from .sweep_plan import Chunk, Results, SweepPlan

AHEAD = 4  # chunks submitted for each thread of the workers: few, so that results do not pile up


def run_on(client: Any, plan: SweepPlan, chunks: Sequence[Chunk]) -> Generator[tuple[Chunk, Results]]:
    """Each chunk with its results, as they arrive.

    Raises ValueError for anything but a synchronous client.
    """
    from distributed import Client, as_completed  # noqa: PLC0415 (the optional extra [scale])

    if not isinstance(client, Client) or client.asynchronous:
        raise ValueError(f"expected client to be a synchronous dask.distributed.Client, got {client!r}")
    waiting, ahead = iter(chunks), AHEAD * max(1, sum(client.nthreads().values()))
    running: dict[str, tuple[Any, Chunk]] = {}

    def submit(some: list[Chunk]) -> list[Any]:
        # map sends the plan, which may hold a long record, once; submit would send it with each chunk
        futures = client.map(_run, some, plan=plan, pure=False)
        running.update({future.key: (future, c) for future, c in zip(futures, some, strict=True)})
        return futures

    try:
        arriving = as_completed(submit(list(islice(waiting, ahead))), with_results=True)
        for future, results in arriving:
            yield running.pop(future.key)[1], results
            arriving.update(submit(list(islice(waiting, 1))))
    finally:
        client.cancel([future for future, _ in running.values()])


def _run(chunk: Chunk, plan: SweepPlan) -> Results:
    """Results of a chunk on one core, in a worker whose other cores run other chunks, or on the worker's device."""
    with at_most(1), on(plan.device), single.on(plan.dtype):
        return plan.run(chunk.first, chunk.last, {})
