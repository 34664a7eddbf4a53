"""Kernels of the catalogue, compiled before the tests of a whole run, in processes that end when it is done.

Otherwise each of pytest's workers compiles what the other is compiling at the same time.
"""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import substep as ss
from substep.core.threads import cores
from substep.thesis.reproduce import sharing

SCENES = {"linear_oscillator": {"omega": 1.0}, "elastic_pendulum": {"EA": 1e4}}  # whose kernels are committed


def compile_kernels(names: Sequence[str]) -> None:
    """Call what most tests call of these schemes."""
    for name in names:
        s = ss.scheme(name)
        s.spectral_radius(1.0)
        s.stability(1.0)
        for scene, parameters in SCENES.items():
            ss.march(ss.scene(scene, **parameters), s, 1e-4, 2e-4)


def compile_catalogue() -> None:
    """Compile the committed kernels of every scheme into numba's cache, on all cores."""
    with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
        list(pool.map(compile_kernels, sharing(ss.schemes())))
