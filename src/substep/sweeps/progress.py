"""A bar on anything over a second."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

AFTER = 1.0  # s


@contextmanager
def shown(total: int, done: int, show: bool) -> Iterator[Callable[[int], None]]:
    """Gives what is called with each number of points done; on a terminal's stderr, once it has taken a second."""
    from rich.console import Console  # noqa: PLC0415 (on first use)
    from rich.progress import Progress  # noqa: PLC0415

    console = Console(stderr=True)
    bar = Progress(console=console, transient=True, disable=not (show and console.is_terminal))
    task = bar.add_task("sweep", total=total, completed=done)
    begin = time.monotonic()

    def advance(points: int) -> None:
        bar.advance(task, points)
        if not bar.live.is_started and not bar.finished and time.monotonic() - begin > AFTER:
            bar.start()

    try:
        yield advance
    except KeyboardInterrupt:
        bar.stop()
        if not bar.disable:
            console.print(f"sweep interrupted: {bar.tasks[0].completed:.0f} of {total} runs are done")
        raise
    finally:
        bar.stop()
