"""A scheme at its parameters: the numbers and kernels from which its functions are computed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType

import numpy as np

from ..derived import modules
from .arrays import Array
from .entries import SchemeInfo
from .kernel_modules import committed


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
        """The generated module, imported (and compiled or read from numba's cache) on first use; see `module_of`."""
        return module_of(self.info)

    @cached_property
    def kernel_parameters(self) -> tuple[Array, ...]:
        """Values of the module's PARAMETERS, also of those that a member fixes: it shares its parent's module."""
        fixed = {name: np.float64(value) for name, value in self.info.fixed.items()}
        values = {**self.parameters, **fixed}
        return tuple(np.asarray(values[name]) for name in self.kernels.PARAMETERS)


def module_of(info: SchemeInfo) -> ModuleType:
    """A scheme's module: of the user's own, or of the catalogue, committed or printed to the user's cache now."""
    if isinstance(info.module, ModuleType):
        return info.module
    return committed(info.module) or modules.scheme_module(info.module.rpartition(".")[2])
