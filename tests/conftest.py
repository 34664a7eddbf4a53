"""What several test files use: fixtures, and the settings with which hypothesis draws examples."""

import os
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

# every run of the gate draws the same examples; `make verify` searches for new ones. The first draw of a process looks
# for constants in all modules of the project, and so takes long on a busy machine
COMMON = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("gate", derandomize=True, **COMMON)
settings.register_profile("search", print_blob=True, **COMMON)
settings.load_profile("search" if os.environ.get("SUBSTEP_VERIFY") else "gate")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the committed kernels before the workers of a whole run begin, once for all of them."""
    config = session.config
    whole = config.args_source is pytest.Config.ArgsSource.TESTPATHS and not config.option.keyword
    if whole and not (hasattr(config, "workerinput") or config.option.collectonly):
        from compiled_ahead import compile_catalogue

        config.get_terminal_writer().line("kernels of every scheme are compiled, or read from numba's cache")
        compile_catalogue()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run long tests first: one begun last would keep a worker busy while the others are idle."""
    items.sort(key=lambda item: item.get_closest_marker("long") is None)


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """`march` and `march_lanes` take kernels as plain Python; an overflow there is a status, not a warning."""
    from plain_kernels import plain

    from substep.core import threads
    from substep.marching import scene_lanes

    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: plain(scheme.name, scene.name))
    monkeypatch.setattr(threads, "cores", lambda: 1)  # threads do not inherit np.errstate
    with np.errstate(all="ignore"):
        yield


@pytest.fixture
def plain_pairs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Pairs of a declared scheme and any scene as plain Python functions."""
    from declared import BY_NAME
    from plain_kernels import SCENE_BY_NAME
    from plain_kernels import uncompiled as plain
    from substep_derive.motion.equations import EquationsOfMotion
    from substep_derive.package import catalogue_pair

    from substep.core import threads
    from substep.marching import scene_lanes

    def pair(scene: Any, scheme: Any) -> SimpleNamespace:
        theirs = scene.info.declaration or SCENE_BY_NAME[scene.name]
        mine = scheme.info.declaration or BY_NAME[scheme.name]
        return plain(catalogue_pair(mine, EquationsOfMotion(theirs)))

    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(scene_lanes, "pair_kernels", pair)
    monkeypatch.setattr(threads, "cores", lambda: 1)
