"""A progress bar for a sweep or a march that takes longer than a second."""

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress

AFTER = 1.0  # s that it takes before its bar is shown


@contextmanager
def shown(
    total: int, done: int, show: bool, what: str = "sweep", unit: str = "runs"
) -> Generator[Callable[[int], None]]:
    """Yields a function to call with the number of units just done; shows a bar on stderr if that is a terminal."""
    begin, bar = time.monotonic(), None

    def advance(more: int) -> None:
        nonlocal done, bar
        done += more
        if show and bar is None and done < total and time.monotonic() - begin > AFTER:
            bar = _bar(total, what)
        if bar is not None:
            bar.update(bar.task_ids[0], completed=done)

    try:
        yield advance
    except KeyboardInterrupt:
        if bar is not None and not bar.disable:
            bar.console.print(f"{what} interrupted: {done} of {total} {unit} are done")
        raise
    finally:
        if bar is not None:
            bar.stop()


def _bar(total: int, what: str) -> "Progress":
    from rich.console import Console  # noqa: PLC0415 (on first use)
    from rich.progress import Progress  # noqa: PLC0415

    console = Console(stderr=True)
    bar = Progress(console=console, transient=True, disable=not console.is_terminal)
    bar.add_task(what, total=total)
    bar.start()
    return bar
