"""What several files use: fixtures, and how examples are drawn."""

import os
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import settings

# the same examples in each run of the gate; `make verify` searches on
settings.register_profile("gate", derandomize=True, deadline=None)
settings.register_profile("search", deadline=None, print_blob=True)
settings.load_profile("search" if os.environ.get("SUBSTEP_VERIFY") else "gate")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long tests first: begun last, one would keep a worker busy while the others have nothing left."""
    items.sort(key=lambda item: item.get_closest_marker("long") is None)


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """`march` and `march_lanes` take kernels as plain Python; an overflow there is a status, not a warning."""
    from plain_kernels import plain

    from substep.core import threads
    from substep.marching import scene_lanes

    monkeypatch.setattr(scene_lanes, "march_kernels", lambda scene, scheme: plain(scheme.name, scene.name))
    monkeypatch.setattr(threads, "cores", lambda: 1)  # threads do not inherit np.errstate
    with np.errstate(all="ignore"):
        yield
