"""All measurements, within the seconds given; see the package."""

import argparse
import os
import sys
from pathlib import Path

from . import ours, peers, warps
from .table import Report, missing_device

MEASUREMENTS = (
    ours.machine, ours.multiply_adds, ours.spectrum, ours.pendulum, ours.stability_grid, ours.chosen_steps,
    warps.divergence, ours.inelastic, ours.energy, ours.march_of_a_shape, ours.spectrum_call, ours.sweeps,
    peers.by_cupy, peers.by_jax_on_the_device, peers.pendulum_by_jax, peers.by_jax_on_the_CPU,
)  # fmt: skip
WITHOUT_A_DEVICE = ours.machine, warps.divergence


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.device")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=220.0)
    parser.add_argument("--small", action="store_true")
    parser.add_argument("--only", default="", help="names of measurements, with commas between")
    given = parser.parse_args()
    report = Report(given.folder, given.seconds, given.small)
    only = given.only.split(",") if given.only else [measurement.__name__ for measurement in MEASUREMENTS]
    here = not missing_device()
    for measurement in MEASUREMENTS:
        if measurement.__name__ in only:
            report.measure(measurement, possible=here or measurement in WITHOUT_A_DEVICE)
    print((given.folder / "device.md").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # without waiting for what a library may still hold of the device
