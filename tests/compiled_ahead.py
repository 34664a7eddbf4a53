"""Kernels that many tests call, compiled before the tests of a whole run, in processes that end when it is done.

Otherwise each of pytest's workers compiles what the other is compiling at the same time. These processes import neither
SymPy nor the catalogue's declarations, which take longer than all that they do where numba's cache has the kernels.
"""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import substep as ss
from substep.core.threads import cores


def compile_kernels(name: str, on_pendulum: bool) -> None:
    """Call what most tests call of this scheme; its march on the elastic pendulum where that is committed."""
    s = ss.scheme(name)
    s.spectral_radius(1.0)
    s.stability(1.0)
    ss.march(ss.scene("linear_oscillator", omega=1.0), s, 1e-4, 2e-4)
    if on_pendulum:
        ss.march(ss.scene("elastic_pendulum", EA=1e4), s, 1e-4, 2e-4)


def compile_shared() -> None:
    """Compile what schemes share, with one scheme for each way to find eigenvalues, and the committed marches."""
    from plain_kernels import kinds
    from substep_derive.package import COMMITTED

    own = {shared: name for name, (shared, *_) in reversed(kinds().items()) if kinds()[name][2]}
    names = dict.fromkeys([*own.values(), *(scheme for scheme, _ in COMMITTED)])
    on_pendulum = [(name, "elastic_pendulum") in COMMITTED for name in names]
    with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
        list(pool.map(compile_kernels, names, on_pendulum))
