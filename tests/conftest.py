"""Fixtures that several files use."""

from collections.abc import Iterator

import numpy as np
import pytest


class Serial:
    """In place of threads, which do not inherit np.errstate."""

    def __init__(self, workers: int | None) -> None:
        self.map = map

    def __enter__(self) -> "Serial":
        return self

    def __exit__(self, *_: object) -> None: ...


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """`march` and `march_lanes` take kernels as plain Python; an overflow there is a status, not a warning."""
    from plain_kernels import plain

    from substep import lanes

    monkeypatch.setattr(lanes, "pair_module", lambda scene, scheme: plain(scheme.name, scene.name))
    monkeypatch.setattr(lanes, "ThreadPoolExecutor", Serial)
    with np.errstate(all="ignore"):
        yield
