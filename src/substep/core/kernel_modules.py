"""Generated modules, imported on first use, and with them numba."""

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType


@cache
def committed(name: str) -> ModuleType | None:
    """The committed module of that name; None for one that is printed on first use."""
    full = f"substep_kernels.{name}"
    return import_module(full) if find_spec(full) else None


def loaded(module: str | ModuleType) -> ModuleType:
    """The module that an entry of the index names; one of the user's own is in the entry itself."""
    found = module if isinstance(module, ModuleType) else committed(module)
    assert found is not None  # the index names only what is committed
    return found
