"""Fixtures that several files use."""

from collections.abc import Iterator

import numpy as np
import pytest


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """`march` and `march_lanes` take kernels as plain Python; an overflow there is a status, not a warning."""
    from plain_kernels import plain

    from substep import lanes, threads

    monkeypatch.setattr(lanes, "pair_module", lambda scene, scheme: plain(scheme.name, scene.name))
    monkeypatch.setattr(threads, "cores", lambda: 1)  # threads do not inherit np.errstate
    with np.errstate(all="ignore"):
        yield
