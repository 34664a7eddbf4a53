"""Memory that programs can still take, and the refusal of what does not fit into it."""

import math
from collections.abc import Iterable
from pathlib import Path

SMALL = 1e7  # bytes that are taken without a look at what is free, which costs a short march a fifth of its time


def available_memory() -> int | None:
    """Bytes of memory that programs can still take; None where the system does not tell."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return None
    free = [line.split()[1] for line in lines if line.startswith("MemAvailable:")]
    return 1024 * int(free[0]) if free else None


def require_memory(shape: Iterable[int], cure: str) -> None:
    """Raises MemoryError for an array of doubles of this shape that does not fit in memory."""
    sizes = tuple(shape)
    need, have = 8 * math.prod(sizes), available_memory()
    if have is not None and need > have:
        raise MemoryError(
            f"expected the histories to fit in memory, got {' x '.join(map(str, sizes))} numbers, {need / 1e9:.3g} GB, "
            f"of {have / 1e9:.3g} GB free; {cure}"
        )


def require_histories(steps: int, stride: int, row: int, step: int) -> None:
    """Raises MemoryError for a run whose histories do not fit in memory.

    row: numbers that are kept every stride-th step; step: those that are kept of each step.
    """
    need = 8 * ((steps // stride + 1) * row + steps * step)
    have = None if need <= SMALL else available_memory()
    if have is None or need <= have:
        return
    cure = "take a longer dt or an earlier t_end"
    if (rest := have // 2 - 8 * steps * step) > 0:
        cure = f"{cure}, or keep fewer rows with stride={math.ceil(8 * steps * row / rest)}"
    raise MemoryError(
        f"expected the histories to fit in memory, got {steps:.6g} steps, which take {need / 1e9:.3g} GB, of "
        f"{have / 1e9:.3g} GB free; {cure}"
    )


def require_factors(unknowns: int, need: float) -> None:
    """Raises MemoryError for factors of at least `need` bytes that do not fit in memory."""
    have = available_memory()
    if have is not None and need > have:
        raise MemoryError(
            f"expected the factors of {unknowns} unknowns to fit in memory, got at least {need / 1e9:.1f} GB needed of "
            f"{have / 1e9:.1f} GB free; march modes, take an explicit scheme, or a solver out of core"
        )
