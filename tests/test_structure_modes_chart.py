"""The spectrum of a structure on the spectrum of a scheme: what is said of each mode, and what is drawn."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from PIL import Image
from plane_elements import shear_building

import substep as ss
from substep.figures.structure_modes import KINDS, chart, kinds_of_modes, modes_figure


def modes(xi: float = 0.0) -> ss.Modes:
    """Storeys from soft to very stiff, so that omega reaches over four decades."""
    M, K = shear_building([1.0] * 6, [1e1, 1e3, 1e4, 1e5, 1e6, 1e7])
    return ss.structure(M, K).modes(6).damped(xi)


def test_kinds_follow_from_long_free_vibrations() -> None:
    """Amplitude and zero crossings of the march itself, from rest at u = 1, without any stability function."""
    dt, found = 0.02, modes()
    seen = set()
    for name in ("average_acceleration", "bathe", "central_difference"):
        scheme = ss.scheme(name)
        for omega, kind in zip(found.omega, kinds_of_modes(found, scheme, dt), strict=True):
            scene = ss.scene("linear_oscillator", omega=omega, xi=0.0, u0=1.0)
            n = max(2000, 20 * round(2 * np.pi / omega / dt))  # twenty periods or more
            r = ss.march(scene, scheme, dt, n * dt)
            size = np.hypot(r.u, r.v / omega)
            seen.add(kind)
            if kind == "unstable":
                assert r.status == "non_finite" or size[-1] > 1e3
            elif kind == "damped":
                assert size[44] <= 0.02
            else:
                periods = n * dt * omega / (2 * np.pi)
                upward = np.flatnonzero((r.u[:-1] < 0.0) & (r.u[1:] >= 0.0))
                elongation = (upward[-1] - upward[0]) * dt * omega / (2 * np.pi * (len(upward) - 1)) - 1.0
                decay = -np.log(size[-1]) / (2 * np.pi * periods)
                worst = max(abs(elongation), abs(decay))
                bounds = {"resolved": (0.0, 0.011), "inaccurate": (0.009, 0.11), "spurious": (0.09, np.inf)}[kind]
                assert bounds[0] <= worst <= bounds[1], (name, omega, kind)
    assert seen == set(KINDS)


def test_each_mode_is_drawn_in_each_panel_at_its_place_and_size() -> None:
    found, dt = modes(0.01), 0.004
    scheme = ss.scheme("generalized_alpha", rho_inf=0.8)
    figure = modes_figure(found, scheme, dt, direction=1.0, largest=1e4)
    share = found.participation(1.0).share
    values = scheme.stability(found.omega * dt, found.xi)
    for i, (axes, value, factor) in enumerate(zip(figure.axes, values, (1, 100, 100), strict=True)):
        drawn: list[tuple[float, float, float]] = []
        for marks in axes.collections:
            assert isinstance(marks, PathCollection)
            drawn += [(x, y, s) for (x, y), s in zip(np.asarray(marks.get_offsets()), marks.get_sizes(), strict=True)]
        expected = sorted(zip(found.omega * dt, factor * value, 16.0 + 500.0 * share, strict=True))
        assert np.allclose(sorted(drawn), expected, rtol=1e-12)
        assert any(np.allclose(line.get_xdata(), 1e4 * dt) for line in axes.lines)
        curve = max(axes.lines, key=lambda line: len(line.get_xdata()))
        x, y = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
        assert np.allclose(y, factor * scheme.stability(x, 0.01)[i], equal_nan=True)


def test_the_chart_is_saved_with_a_caption_that_counts(tmp_path: Path) -> None:
    chart(modes(), "bathe", 0.02, tmp_path / "modes")
    kinds = kinds_of_modes(modes(), ss.scheme("bathe"), 0.02)
    with Image.open(tmp_path / "modes.png") as picture:
        caption = picture.info["Description"]
    assert all(f"{kinds.count(kind)} {kind}" in caption for kind in set(kinds))
    assert (tmp_path / "modes.svg").exists()


def test_what_cannot_be_drawn_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="expected dt > 0"):
        modes_figure(modes(), "bathe", 0.0)
    free = ss.structure(np.eye(2), [[1.0, -1.0], [-1.0, 1.0]]).modes(1)
    with pytest.raises(ValueError, match="elastic modes, got 1 rigid"):
        modes_figure(free, "bathe", 0.1)
    damped = ss.structure(np.eye(2), np.diag([1.0, 4.0]), C=ss.Rayleigh(0.1, 0.0)).modes(2)
    for drawn in (modes_figure, lambda *a: kinds_of_modes(a[0], ss.scheme(a[1]), a[2])):
        with pytest.raises(ValueError, match="rkn43 is a scheme for .* without damping: expected xi = 0"):
            drawn(damped, "rkn43", 0.1)
