"""Speed and error of substep, of kernels in C near the machine's limit, and of other libraries, on the same work."""

import os

# BLAS works on one thread: threads that wait for its next product would add to the time of the process.
for library in ("OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
