"""Every measurement of a GPU, in one table: python -m benchmarks.device FOLDER [--seconds 220] [--small].

It needs numba with CUDA, NumPy, SciPy, SymPy and xarray, and takes CuPy and JAX where they are installed. What fails is
noted in the table, and the rest goes on; what no time is left for is skipped, and what needs a GPU where there is none
is "not measured". The folder gets device.md and device.json, written anew after every measurement. --small: sizes for
numba's simulator, whose times mean nothing.
"""

import os
import tempfile

os.environ.setdefault("SUBSTEP_CACHE", tempfile.mkdtemp(prefix="substep_device_"))
os.environ.setdefault("NUMBA_CACHE_DIR", tempfile.mkdtemp(prefix="numba_device_"))
os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")
os.environ.setdefault("JAX_ENABLE_X64", "1")
os.environ.setdefault("NUMBA_CUDA_LOW_OCCUPANCY_WARNINGS", "0")
