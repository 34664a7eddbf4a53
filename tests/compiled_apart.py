"""Compilation in forked processes, which take what LLVM has allocated with them when they end: some 5 MB a kernel.

A worker of pytest loads the kernels from numba's cache, which leaves a tenth of that.
"""

import os
import warnings
from collections.abc import Callable
from typing import Any

from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher


def compile_apart() -> None:
    """From now on compile what numba's cache lacks in a process of its own, where the system can fork."""
    compile_here = Dispatcher.compile
    apart = False  # whether this is such a process

    def ends_well(compiles: Callable[[], Any]) -> bool:
        """Whether a forked process did it; if not, it is done here, and raises what it raised there."""
        nonlocal apart
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a process with threads, from Python 3.12 on
            child = os.fork()
        if child:
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        apart = True
        try:
            compiles()
        except BaseException:
            os._exit(1)
        os._exit(0)

    def compiled(dispatcher: Any, signature: Any) -> Any:
        cache = dispatcher._cache

        def load(sig: Any, context: Any) -> Any:
            found = FunctionCache.load_overload(cache, sig, context)
            if found is None and not apart and ends_well(lambda: compile_here(dispatcher, signature)):
                return FunctionCache.load_overload(cache, sig, context)
            return found

        if isinstance(cache, FunctionCache):
            cache.load_overload = load
        return compile_here(dispatcher, signature)

    if hasattr(os, "fork"):
        Dispatcher.compile = compiled
