"""`python -m benchmarks`: run the jobs, print them, write results/bench.json and results/bench.md."""

import argparse
import sys
import time
from pathlib import Path

from rich.console import Console

from . import (
    jobs_accuracy,
    jobs_adaptive,
    jobs_calls,
    jobs_choice,
    jobs_commands,
    jobs_compiling,
    jobs_constraints,
    jobs_cores,
    jobs_laws,
    jobs_modes,
    jobs_pendulum,
    jobs_schemes,
    jobs_single,
    jobs_spectrum,
    jobs_stability,
    jobs_startup,
    jobs_structures,
    jobs_sweeps,
    report,
    target,
)
from .job import Job

JOBS = (
    jobs_stability,
    jobs_spectrum,
    jobs_single,
    jobs_pendulum,
    jobs_adaptive,
    jobs_calls,
    jobs_cores,
    jobs_accuracy,
    jobs_schemes,
    jobs_startup,
    jobs_compiling,
    jobs_commands,
    jobs_structures,
    jobs_sweeps,
    jobs_modes,
    jobs_choice,
    jobs_laws,
    jobs_constraints,
)
NAMES = tuple(module.NAME for module in JOBS)


def main() -> None:
    """Parse the options and run."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer schemes, rounds and steps: some minutes")
    parser.add_argument(
        "--full", action="store_true", help="also compile every scheme, and run the two commands in a fresh clone"
    )
    parser.add_argument("--only", action="append", choices=NAMES, metavar="NAME", help=f"one of {', '.join(NAMES)}")
    parser.add_argument(
        "--cpu", choices=target.CPUS, default="native", help="compile for this machine (default), or for one with AVX2"
    )
    parser.add_argument("--out", type=Path, default=Path("results"), help="folder of the page (default: results)")
    options = parser.parse_args()
    if options.cpu == "avx2" and target.march() != target.AVX2:
        sys.exit(target.run_for_avx2(sys.argv[1:]))
    console, facts = Console(), report.machine()
    jobs: list[Job] = []
    for module in JOBS:
        if options.only and module.NAME not in options.only:
            continue
        began = time.perf_counter()
        full = {"full": options.full} if module in (jobs_compiling, jobs_commands) else {}
        found = module.job(options.quick, **full)
        jobs.append(found)
        report.show(found, console)
        console.print(f"{module.NAME}: {time.perf_counter() - began:.0f} s", style="dim")
    report.show_goals(jobs, console)
    for path in report.write(jobs, facts, options.out):
        console.print(f"written: {path}", markup=False)


if __name__ == "__main__":
    main()
