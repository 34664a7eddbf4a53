"""Kernels of scheme x scene as plain Python functions: nothing is compiled."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from declared import BY_NAME
from substep_derive.declare.scenes import constrained, declared, impact, lagrange, mechanisms
from substep_derive.motion.equations import EquationsOfMotion
from substep_derive.package import COMMITTED

import substep as ss
from substep.core import kernel_modules
from substep.derived.modules import adaptive_pair, uncommitted_pair

GENERATED = Path(__file__).parents[1] / "generated" / "substep_kernels"
# those of Lagrange's equations in full and of constraints have tests of their own, which step every scheme on them
OTHERS = (*lagrange.ALL, *constrained.ALL, *mechanisms.ALL, *impact.ALL)
SCENE_BY_NAME = {scene.name: scene for scene in declared() if not scene.laws and scene not in OTHERS}
WITH_LAWS = {scene.name: scene for scene in declared() if scene.laws}  # tests of laws step every scheme on them


@cache
def motion(name: str) -> EquationsOfMotion:
    return EquationsOfMotion(SCENE_BY_NAME[name])


def text_of(module: ModuleType) -> str:
    """The text that a module was printed as: its file in the cache, but for the first line, a digest."""
    assert module.__file__
    return Path(module.__file__).read_text(encoding="utf-8").partition("\n")[2]


@cache
def kinds() -> dict[str, tuple[str, bool, bool]]:
    """Of each scheme of the catalogue: how its eigenvalues are found, whether it has sub-steps, and takes damping."""
    return {
        name: (ss.scheme(name).kernels.EIGENVALUES, len(scheme.balances) > 1, scheme.takes_damping)
        for name, scheme in BY_NAME.items()
    }


@cache
def gate_pairs() -> tuple[tuple[str, str], ...]:
    """The pairs that tests of pairs run in the gate: every scheme on one scene, in turn; and the committed ones."""
    found = list(COMMITTED)
    for i, (name, scheme) in enumerate(BY_NAME.items()):
        fit = [scene for scene in SCENE_BY_NAME if scene != "linear_oscillator" or scheme.takes_damping]
        found.append((name, fit[i % len(fit)]))
    return tuple(dict.fromkeys(found))


@cache
def text(scheme: Any, scene: Any) -> str:
    """The text of a pair's module; that the committed ones are what is printed is tested in test_generated.

    Both are names of the catalogue, or declarations.
    """
    if (scheme, scene) in COMMITTED:
        return (GENERATED / "pairs" / f"{scheme}__{scene}.py").read_text(encoding="utf-8")
    return text_of(uncommitted_pair(scheme, scene))


@cache
def plain(scheme: Any, scene: Any) -> ModuleType:
    """The module with its kernels as Python functions."""
    return uncompiled(text(scheme, scene))


@cache
def plain_adaptive(scheme: Any, scene: Any, terms: Any, order: int, always: bool) -> ModuleType:
    """The module that marches in chosen steps, with its kernels as Python functions: for `adaptive._kernels`."""
    return uncompiled(text_of(adaptive_pair(scheme, scene, terms, order, always)))


@cache
def committed(name: str) -> ModuleType | None:
    """A committed module with its kernels as Python functions, None for another: for `kernel_modules.committed`."""
    path = GENERATED / f"{name.replace('.', '/')}.py"
    return uncompiled(path.read_text(encoding="utf-8")) if path.exists() else None


def itself(kernel: Callable[..., None], whole: int = 1) -> Callable[..., None]:
    """A kernel in place of its address: for `eigenvalues.address`."""
    return kernel


def uncompiled(source: str) -> ModuleType:
    """A module from its text, without numba."""
    module = ModuleType("kernels")
    source = source.replace("from numba import njit", "njit = lambda **_: lambda function: function")
    exec(compile(source, "kernels", "exec"), vars(module))
    return module


def _address(kernel: Callable[..., None], whole: int = 1) -> int | Callable[..., None]:
    """Of a kernel; that of an uncompiled module itself."""
    return kernel if kernel.__code__.co_filename == "kernels" else ADDRESS(kernel, whole)


# laws are called from Python, too, by their addresses
ADDRESS, kernel_modules.address = kernel_modules.address, _address


def variant(name: str, **options: Any) -> ss.Scene:
    """The scene of that name, which for the elastic pendulum includes the strain measure."""
    if name == "elastic_pendulum_engineering":
        return ss.scene("elastic_pendulum", strain="engineering", **options)
    return ss.scene(name, **options)
