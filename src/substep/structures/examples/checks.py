"""What dimensions and numbers of elements have to be."""

import numpy as np

from ...core.errors import real_number


def positive(**values: float) -> None:
    """Raises ValueError for a value that is not a positive number."""
    for name, value in values.items():
        real_number(name, value, positive=True)


def counts(**values: int) -> None:
    """Raises ValueError for a value that is not a whole number from 1 on."""
    for name, value in values.items():
        if not isinstance(value, int | np.integer) or value < 1:
            raise ValueError(f"expected {name} to be a whole number >= 1, got {value!r}")
