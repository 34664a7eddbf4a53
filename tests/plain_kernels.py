"""Kernels of scheme x scene as plain Python functions: nothing is compiled."""

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from substep_derive.motion import Motion
from substep_derive.package import catalogue_pair
from substep_derive.scenes import ALL

import substep as ss

SCENE_BY_NAME = {scene.name: scene for scene in ALL}


@cache
def motion(name: str) -> Motion:
    return Motion(SCENE_BY_NAME[name])


@cache
def text(scheme: str, scene: str) -> str:
    return catalogue_pair(BY_NAME[scheme], motion(scene))


@cache
def plain(scheme: str, scene: str) -> SimpleNamespace:
    """The module with its kernels as Python functions."""
    source = text(scheme, scene).replace("from numba import njit", "njit = lambda **_: lambda function: function")
    space: dict[str, Any] = {}
    exec(compile(source, f"{scheme}__{scene}", "exec"), space)
    return SimpleNamespace(**space)


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch):
    """`march` and `march_lanes` take the plain modules; a kernel's overflow is a status, not a warning."""
    from substep import lanes

    monkeypatch.setattr(lanes, "pair_module", lambda scene, scheme: plain(scheme.name, scene.name))
    with np.errstate(all="ignore"):
        yield


def variant(name: str, **options: Any) -> ss.Scene:
    """The scene, its strain measure told from its name."""
    if name == "elastic_pendulum_engineering":
        return ss.scene("elastic_pendulum", strain="engineering", **options)
    return ss.scene(name, **options)
