"""How wide the registers are that compiled code uses."""

from typing import Any

from . import limits


def wide_registers() -> dict[str, int]:
    """How often code for the target of this process names a 64-byte register (zmm): numba's, and the C compiler's.

    The code is that of the march of many oscillators, which both fill with the widest vectors of their target.
    """
    from numba import float64, int64, njit, types  # noqa: PLC0415 (after the target is known)
    from substep_kernels.marches.linear_march_2_01y import _final_2  # noqa: PLC0415

    kernel: Any = _final_2
    loads = types.Array(float64, 1, "C", readonly=True)
    options = {name: value for name, value in kernel.targetoptions.items() if name not in ("cache", "nopython")}
    compiled = njit(**options)(kernel.py_func)
    compiled.compile((float64[::1], loads, loads, int64, int64))
    (own,) = compiled.inspect_asm().values()
    return {"numba": own.count("%zmm"), "C": limits.assembly("spectrum.c").count("%zmm")}
