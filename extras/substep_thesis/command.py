"""The commands `substep reproduce` and `substep claims`: the thesis's results, in files and on one screen."""

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from substep.cli.command import Command
from substep.cli.lines import labelled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .claims.judgement import Judgement
    from .reproduce import Results

console = Console()


def reproduce(
    folder: Annotated[Path, typer.Option(help="where the results go")] = Path("results"),
    full: Annotated[
        bool, typer.Option("--full", help="also the catalogue's charts and maps, times, the 1000 s runs")
    ] = False,
) -> None:
    """Draw the thesis's figures, judge its claims, and write both on one page with what was found.

    The page, index.html, grows as figures come. --full runs all schemes besides, and says first how long that takes.
    """
    from substep.core.threads import cores  # noqa: PLC0415

    from . import reproduce as job  # noqa: PLC0415 (Matplotlib only when asked for)

    stages = job.stages(full)
    work = sum(stage.jobs * stage.seconds for stage in stages)
    alone = sum(stage.jobs * stage.seconds for stage in stages if stage.alone)
    wall = alone + (work - alone) / cores()
    print(f"about {_minutes(wall)} min, {_minutes(work)} min of CPU, the first time; compiled kernels are kept")
    print(f"{folder / 'index.html'} is there to look at from the first figure on", flush=True)
    with Progress(console=console, transient=True) as progress:
        bars = {stage.name: progress.add_task(stage.name, total=stage.jobs) for stage in stages if stage.jobs}
        seconds = {stage.name: stage.seconds for stage in stages}
        all_of_it = progress.add_task("in all", total=work)

        def step(stage: str) -> None:
            progress.advance(bars[stage])
            progress.advance(all_of_it, seconds[stage])
            done = progress.tasks[bars[stage]]
            if done.finished:
                progress.console.print(f"{stage}: done after {done.elapsed:.0f} s")

        results = job.reproduce(folder, step, full=full)
    _print_summary(results, folder)
    if not full:
        print(labelled("more", "substep reproduce --full: all schemes on four scenes, all maps, times"))


def _minutes(seconds: float) -> str:
    """Minutes for a reader: halves of a few, else whole ones."""
    return f"{round(seconds / 30) / 2:g}" if seconds < 150 else f"{seconds / 60:.0f}"


def _print_summary(results: "Results", folder: Path) -> None:
    """What was drawn, what was judged, what differs from the thesis, what was found and where it is: one screenful."""
    from . import page  # noqa: PLC0415

    drawn = Counter(picture.section for picture in page.pictures(folder))
    verdicts = Counter(j.verdict for j in results.claims)
    counts = (f"{number} {verdict}" for verdict, number in verdicts.most_common())
    lines = {
        "drawn": f"{drawn.total()} figures: " + ", ".join(f"{name} {number}" for name, number in drawn.items()),
        "judged": f"{len(results.claims)} claims of the thesis: {', '.join(counts)}",
        **{word: " ".join(j.id for j in results.claims if j.verdict == word) for word in ("partly", "false")},
    }
    if results.failures:
        words = ", ".join(f"{n} {word}" for word, n in Counter(row.word for row in results.failures).most_common())
        lines["failures"] = f"{len(results.failures)} runs: {words}"
    print(*(labelled(label, text) for label, text in lines.items()), "found:", sep="\n")
    print(*(labelled(f"{k:2}", one.text, 3) for k, one in enumerate(results.found, start=1)), sep="\n")
    print(labelled("page", f"{folder / 'index.html'}"))


def claims() -> None:
    """Judge what the thesis claims and print, line by line, verdict and evidence."""
    from . import claims as ledger  # noqa: PLC0415

    found: list[Judgement] = []
    try:
        with Progress(console=console) as progress:
            for judgement in progress.track(ledger.judge(), len(ledger.CLAIMS), description="claims"):
                found.append(judgement)
    finally:  # what was judged before Ctrl-C is printed too
        _print_claims(found, len(ledger.CLAIMS))


def _print_claims(found: "Sequence[Judgement]", of: int) -> None:
    print("The thesis's claims" if len(found) == of else f"The thesis's claims: the first {len(found)} of {of}")
    for j in found:
        print(labelled(f"{j.id:<6}{j.verdict}", j.claim, 14))
        print(labelled("      found:", j.evidence, 14), flush=True)  # before what is said of an interruption


REPRODUCE = Command("Programs and results", "substep reproduce --folder results", reproduce)
CLAIMS = Command("Programs and results", "substep claims", claims)
