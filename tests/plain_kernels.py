"""Kernels of scheme x scene as plain Python functions: nothing is compiled."""

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from declared import BY_NAME
from substep_derive.declare.digest import scene_digest, scheme_digest
from substep_derive.declare.scenes import ALL
from substep_derive.emit.first_use import adaptive_pair, catalogue_pair
from substep_derive.emit.stamp import generator_version
from substep_derive.motion.equations import EquationsOfMotion

import substep as ss

GENERATED = Path(__file__).parents[1] / "generated" / "substep_kernels"
PRINTED = Path(__file__).parents[1] / ".pytest_cache" / "pairs"
SCENE_BY_NAME = {scene.name: scene for scene in ALL}


@cache
def motion(name: str) -> EquationsOfMotion:
    return EquationsOfMotion(SCENE_BY_NAME[name])


def printed(make: Callable[[], str], *digests: str) -> str:
    """The text that make() prints, made once for all of pytest's workers; digests: of all that it depends on."""
    path = PRINTED / f"{hashlib.sha256(''.join([*digests, generator_version()]).encode()).hexdigest()}.py"
    if not path.exists():
        PRINTED.mkdir(parents=True, exist_ok=True)
        mine = path.with_suffix(f".{os.getpid()}")
        mine.write_text(make(), encoding="utf-8")
        mine.replace(path)
    return path.read_text(encoding="utf-8")


@cache
def kinds() -> dict[str, tuple[str, bool, bool]]:
    """Of each scheme of the catalogue: how its eigenvalues are found, whether it has sub-steps, and takes damping."""
    return {
        name: (ss.scheme(name).kernels.EIGENVALUES, len(scheme.balances) > 1, scheme.takes_damping)
        for name, scheme in BY_NAME.items()
    }


@cache
def gate_pairs() -> tuple[tuple[str, str], ...]:
    """The pairs that tests of pairs run in the gate: every scheme on the scene whose kernels are committed, on a linear
    scene and on another nonlinear one, which scenes of each kind are in turn.
    """
    others = [name for name in SCENE_BY_NAME if name != "elastic_pendulum"]
    linear, nonlinear = ([name for name in others if motion(name).linear == kind] for kind in (True, False))
    found = []
    for i, scheme in enumerate(BY_NAME):
        fit = [name for name in linear if name != "linear_oscillator" or BY_NAME[scheme].takes_damping]
        found += [(scheme, x) for x in ("elastic_pendulum", fit[i % len(fit)], nonlinear[i % len(nonlinear)])]
    return tuple(found)


@cache
def text(scheme: str, scene: str) -> str:
    """The text of a pair's module; that the committed ones are what is printed is tested in test_generated."""
    committed = GENERATED / "pairs" / f"{scheme}__{scene}.py"
    if committed.exists():
        return committed.read_text(encoding="utf-8")
    digests = scheme_digest(BY_NAME[scheme]), scene_digest(SCENE_BY_NAME[scene])
    return printed(lambda: catalogue_pair(BY_NAME[scheme], motion(scene)), *digests)


@cache
def plain(scheme: str, scene: str) -> SimpleNamespace:
    """The module with its kernels as Python functions."""
    return uncompiled(text(scheme, scene))


@cache
def plain_adaptive(scheme: Any, scene: Any, terms: Any, order: int, always: bool) -> SimpleNamespace:
    """The module that marches in chosen steps, with its kernels as Python functions: for `adaptive._kernels`."""
    mine = BY_NAME[scheme] if isinstance(scheme, str) else scheme
    on = motion(scene) if isinstance(scene, str) else EquationsOfMotion(scene)
    digests = scheme_digest(mine), scene_digest(on.scene), repr(terms), str(order), str(always)
    return uncompiled(printed(lambda: adaptive_pair(mine, on, terms, order, always), *digests))


@cache
def committed(name: str) -> SimpleNamespace:
    """A committed module with its kernels as Python functions: for `kernel_modules.committed`."""
    return uncompiled((GENERATED / f"{name.replace('.', '/')}.py").read_text(encoding="utf-8"))


def itself(kernel: Callable[..., None], whole: int = 1) -> Callable[..., None]:
    """A kernel in place of its address: for `eigenvalues.address`."""
    return kernel


def uncompiled(source: str) -> SimpleNamespace:
    """A module from its text, without numba."""
    space: dict[str, Any] = {}
    source = source.replace("from numba import njit", "njit = lambda **_: lambda function: function")
    exec(compile(source, "kernels", "exec"), space)
    return SimpleNamespace(**space)


def variant(name: str, **options: Any) -> ss.Scene:
    """The scene of that name, which for the elastic pendulum includes the strain measure."""
    if name == "elastic_pendulum_engineering":
        return ss.scene("elastic_pendulum", strain="engineering", **options)
    return ss.scene(name, **options)
