"""A scheme at its parameters: the numbers and kernels from which its functions are computed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType

import numpy as np

from .arrays import Array, read_only
from .entries import SchemeInfo
from .kernel_modules import loaded


@dataclass(frozen=True, eq=False, repr=False)
class SchemeRecord:
    """What stability functions and marches read of a `Scheme`."""

    info: SchemeInfo
    parameters: Mapping[str, Array]
    given: Mapping[str, Array] = field(default_factory=dict[str, Array])  # those that were not left to their default

    @property
    def name(self) -> str:
        """The scheme's name."""
        return self.info.name

    @cached_property
    def kernels(self) -> ModuleType:
        """The generated module, imported (and compiled or read from numba's cache) on first use."""
        return loaded(self.info.module)

    @cached_property
    def kernel_parameters(self) -> tuple[Array, ...]:
        """Values of the module's PARAMETERS, also of those that a member fixes: it shares its parent's module."""
        fixed = {name: np.float64(value) for name, value in self.info.fixed.items()}
        values = {**self.parameters, **fixed}
        return tuple(np.asarray(values[name]) for name in self.kernels.PARAMETERS)

    @cached_property
    def one_point(self) -> tuple[Array, ...]:
        """`kernel_parameters` of one point as kernels take them, (1,) each; for parameters that are numbers."""
        return tuple(read_only(x.reshape(1)) for x in self.kernel_parameters)
