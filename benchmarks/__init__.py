"""Speed and error of substep, of kernels in C near the machine's limit, and of other libraries, on the same work."""
