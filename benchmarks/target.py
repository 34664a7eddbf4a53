"""The CPU that the kernels of a run are compiled for, by numba and by the C compiler alike."""

import os
import subprocess
import sys
from collections.abc import Sequence
from typing import Literal, get_args

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
