"""Kernels that many tests call, compiled before the tests of a whole run, in processes that end when it is done.

Otherwise each of pytest's workers compiles what the other is compiling at the same time.
"""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from plain_kernels import kinds
from substep_derive.package import COMMITTED

import substep as ss
from substep.core.threads import cores


def compile_kernels(names: Sequence[str]) -> None:
    """Call what most tests call of these schemes; on the elastic pendulum those whose march there is committed."""
    for name in names:
        s = ss.scheme(name)
        s.spectral_radius(1.0)
        s.stability(1.0)
        ss.march(ss.scene("linear_oscillator", omega=1.0), s, 1e-4, 2e-4)
        if (name, "elastic_pendulum") in COMMITTED:
            ss.march(ss.scene("elastic_pendulum", EA=1e4), s, 1e-4, 2e-4)


def compile_shared() -> None:
    """Compile what schemes share, with one scheme for each way to find eigenvalues, and the committed marches."""
    own = {shared: name for name, (shared, *_) in reversed(kinds().items()) if kinds()[name][2]}
    more = [scheme for scheme, _ in COMMITTED if scheme not in own.values()]
    with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
        list(pool.map(compile_kernels, [[name] for name in (*own.values(), *more)]))
