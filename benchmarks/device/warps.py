"""How long the 32 threads of a warp wait for each other, counted on the CPU, whose runs take the same iterations."""

from dataclasses import replace

import numpy as np

import substep as ss
from substep.marching.scene_lanes import march_lanes

from .table import Report

WARP = 32


def waiting(work: np.ndarray) -> float:
    """How many times the mean work of its lanes a warp does: it waits in each loop for the lane that takes longest.

    work (lanes, ...): iterations of a lane in each loop, or the steps that it takes; lanes of a multiple of 32.
    """
    longest = work.reshape(-1, WARP, *work.shape[1:]).max(axis=1)
    return float(WARP * longest.sum() / work.sum())


def divergence(report: Report) -> None:
    """Newton's iterations of pendulums, and the steps that they choose, of neighbours in a warp and of any."""
    P, n = (64, 5) if report.small else (2048, 1000)
    rows, order = np.linspace(0.0, 1.0, P), np.random.default_rng(0).permutation(P)
    v0 = np.stack([np.zeros(P), 7.0 + rows], axis=1)

    def add(name: str, work: np.ndarray, note: str) -> None:
        value = waiting(work)
        report.add(
            f"{name}: work of a warp / of its lanes", value, "", f"{note}; {waiting(work[order]):.4g} in any order"
        )

    cases = {
        "flexible": (1e4, (0.0, 0.0)), "stiff": (1e10, (-19.6, 0.0)),
        "EA from 1e3 to 1e10": (10 ** (3 + 7 * rows), (0.0, 0.0)),
    }  # fmt: skip
    for scheme in ("bathe", "newmark_bdf2"):
        for case, (EA, a0) in cases.items():
            scene = ss.scene("elastic_pendulum", EA=1e4, a0=a0)
            scene = replace(scene, parameters={**scene.parameters, "EA": EA})
            start = np.broadcast_to(scene.u0, (P, 2)), v0, np.broadcast_to(scene.a0, (P, 2))
            lanes = march_lanes(scene, ss.scheme(scheme), np.full(P, 0.01), np.full(P, n), start=start, counts=True)
            add(f"pendulum, {scheme}, {case}", lanes.iterations, "Newton's iterations")
    for scheme in ("bathe", "generalized_alpha"):
        t_end = 0.1 if report.small else 5.0
        for case, axes in (
            ("flexible", {"EA": 1e4, "v0": 6.0 + 2.0 * rows}),
            ("EA from 1e3 to 1e6", {"EA": 10 ** (3 + 3 * rows)}),
        ):
            ds = ss.sweep("elastic_pendulum", scheme, tol=1e-5, t_end=t_end, progress=False, **axes)
            add(f"chosen steps, {scheme}, {case}", (ds.accepted + ds.rejected).to_numpy(), "steps")
