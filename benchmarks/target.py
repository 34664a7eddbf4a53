"""The CPU that the kernels of a run are compiled for, by numba and by the C compiler alike."""

import os
import subprocess
import sys
from collections.abc import Sequence
from typing import Any, Literal, get_args

Cpu = Literal["native", "avx2"]
CPUS = get_args(Cpu)
AVX2 = "znver3"  # a CPU with AVX2 and without AVX-512, as numba's LLVM and the C compilers name it


def march() -> str:
    """What the C compiler's -march is to be: what numba's target is, or this machine."""
    return os.environ.get("NUMBA_CPU_NAME") or "native"


def run_for_avx2(arguments: Sequence[str]) -> int:
    """Run the benchmarks with these arguments in a process whose kernels are compiled for AVX2; its exit status.

    numba reads its target when it is imported. Its features are set to none, since left alone they are those of this
    machine, AVX-512 among them.
    """
    target = {"NUMBA_CPU_NAME": AVX2, "NUMBA_CPU_FEATURES": ""}
    command = [sys.executable, "-m", "benchmarks", *arguments]
    return subprocess.run(command, env={**os.environ, **target}, check=False).returncode


def wide_registers() -> dict[str, int]:
    """How often code for the target of this process names a 64-byte register (zmm): numba's, and the C compiler's.

    The code is that of the march of many oscillators, which both fill with the widest vectors of their target.
    """
    from numba import float64, int64, njit, types  # noqa: PLC0415 (after the target is known)
    from substep_kernels.marches.linear_march_2_01y import _final_2  # noqa: PLC0415

    from . import limits  # noqa: PLC0415

    kernel: Any = _final_2
    loads = types.Array(float64, 1, "C", readonly=True)
    options = {name: value for name, value in kernel.targetoptions.items() if name not in ("cache", "nopython")}
    compiled = njit(**options)(kernel.py_func)
    compiled.compile((float64[::1], loads, loads, int64, int64))
    (own,) = compiled.inspect_asm().values()
    return {"numba": own.count("%zmm"), "C": limits.assembly("spectrum.c").count("%zmm")}
