"""A scheme with its parameters, as far as the functions know it that call its generated module."""

from types import ModuleType
from typing import Protocol

from .arrays import Array
from .entries import SchemeInfo


class Parametrized(Protocol):
    """What the handle of a scheme offers them."""

    @property
    def info(self) -> SchemeInfo:
        """What the index says about the scheme."""
        ...

    @property
    def kernels(self) -> ModuleType:
        """The generated module."""
        ...

    @property
    def kernel_parameters(self) -> tuple[Array, ...]:
        """Values of the module's PARAMETERS."""
        ...

    @property
    def one_point(self) -> tuple[Array, ...]:
        """`kernel_parameters` of one point, (1,) each."""
        ...

    def stencil(self) -> Array:
        """Instants at which a step takes the load, in steps after t_n: (..., K)."""
        ...
