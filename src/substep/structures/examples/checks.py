"""What dimensions and numbers of elements have to be."""

from ...core.errors import real_number, whole


def positive(**values: float) -> None:
    """Raises ValueError for a value that is not a positive number."""
    for name, value in values.items():
        real_number(name, value, positive=True)


def counts(**values: int) -> None:
    """Raises ValueError for a value that is not a whole number from 1 on."""
    for name, value in values.items():
        whole(name, value, 1, "", "give a count")
