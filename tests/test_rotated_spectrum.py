"""Spectra over all directions: records that are rotated before they are marched, closed forms, and wrong input."""

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import substep as ss
from substep.core.units import STANDARD_GRAVITY

Array = np.ndarray
DT = 0.02
T = np.array([0.08, 0.3, 1.0, 4.0])
VALUES = ("displacement", "pseudo_acceleration")


def motions(n: int = 300) -> tuple[Array, Array]:
    """Two components (n,) in m/s^2, noise in an envelope, one weaker; both start at 0."""
    noise = np.random.default_rng(2010).normal(size=(2, n))
    x, y = np.hanning(n) * noise
    return 3.0 * x, 2.0 * y


def rotated(x: Array, y: Array, degrees: float) -> tuple[Array, Array]:
    """Components of the same motion along axes that are turned by an angle."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return c * x + s * y, c * y - s * x


@pytest.mark.parametrize("offset", [0.0, 0.4], ids=["from 0", "from a jump"])
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "houbolt"])
def test_records_that_are_rotated_first(scheme: str, offset: float) -> None:
    """180 spectra by the filter, or by a march without histories; percentiles counted in the sorted peaks."""
    x, y = motions()
    x = x + offset
    alone = [
        ss.response_spectrum(rotated(x, y, angle)[0], DT, [0.0, *T], scheme=scheme, errors=False)
        for angle in range(180)
    ]
    found = ss.response_spectrum_rotated(x, y, DT, [0.0, *T], scheme=scheme)
    assert dict(found.sizes) == {"percentile": 3, "period": 5}
    for name in VALUES:
        peaks = np.sort([one[name].to_numpy() for one in alone], axis=0)
        expected = [peaks[0], (peaks[89] + peaks[90]) / 2, peaks[-1]]
        assert np.allclose(found[name], expected, rtol=1e-10, atol=0.0), name
    x_alone, y_alone = alone[0].pseudo_acceleration.to_numpy(), alone[90].pseudo_acceleration.to_numpy()
    assert np.allclose(found.larger, np.maximum(x_alone, y_alone), rtol=1e-10)
    assert np.allclose(found.geometric_mean, np.sqrt(x_alone * y_alone), rtol=1e-10)


def test_motion_along_one_line() -> None:
    """At an angle from it the peak is |cos| times that along it, and across it there is none."""
    f = motions()[0]
    peak = ss.response_spectrum(f, DT, T).pseudo_acceleration.to_numpy()
    share = np.sort(np.abs(np.cos(np.deg2rad(np.arange(180)))))
    for x, y in (rotated(f, 0.0 * f, -30.0), rotated(f, 0.0 * f, 45.0), (0.0 * f, f)):
        found = ss.response_spectrum_rotated(x, y, DT, T)
        low, median, high = found.pseudo_acceleration.to_numpy()
        assert (low < 1e-12 * high).all()
        assert np.allclose(median, share[89:91].mean() * peak, rtol=1e-10)
        assert np.allclose(high, peak, rtol=1e-10)
    alone = ss.response_spectrum_rotated(f, 0.0 * f, DT, T)
    assert (alone.geometric_mean == 0.0).all()
    assert (alone.displacement[0] == 0.0).all()


def test_motion_in_a_circle_has_no_direction() -> None:
    """Of an oscillator that is driven by a sine and a cosine, long after the start, in steps of many samples a turn."""
    dt, turns = 0.005, 60
    t = dt * np.arange(turns * 400)
    found = ss.response_spectrum_rotated(np.sin(np.pi * t), np.cos(np.pi * t), dt, [0.0, 0.1], 0.5)
    low, median, high = found.pseudo_acceleration.to_numpy()
    assert np.allclose([low[0], median[0], high[0]], 1.0, rtol=1e-4)
    assert high[1] / median[1] < 1.2  # but for the jump at the start


@pytest.mark.parametrize("change", [
    lambda x, y: rotated(x, y, 1.0), lambda x, y: rotated(x, y, 77.0), lambda x, y: rotated(x, y, -200.0),
    lambda x, y: (y, x), lambda x, y: (-x, y), lambda x, y: (-x, -y),
], ids=["1 degree", "77 degrees", "-200 degrees", "exchanged", "mirrored", "turned round"])  # fmt: skip
def test_axes_of_the_instrument_do_not_matter(change: Any) -> None:
    x, y = motions()
    found, other = (ss.response_spectrum_rotated(*pair, DT, T) for pair in ((x, y), change(x, y)))
    for name in VALUES:
        assert np.allclose(found[name], other[name], rtol=1e-10, atol=0.0)


def test_order_of_the_percentiles_and_scale() -> None:
    x, y = motions()
    found = ss.response_spectrum_rotated(x, y, DT, T, percentiles=[100.0, 0, 16, 50, 84])
    assert found.percentile.values.tolist() == [100.0, 0.0, 16.0, 50.0, 84.0]
    ordered = found.pseudo_acceleration.sortby("percentile")
    assert (ordered.diff("percentile") > 0.0).all()
    high = found.pseudo_acceleration.sel(percentile=100)
    assert (high >= found.larger).all()
    assert (found.larger >= found.geometric_mean).all()
    assert (high <= np.sqrt(2.0) * found.larger).all()
    assert np.allclose(found.pseudo_acceleration, found.displacement * (2 * np.pi / T) ** 2, rtol=1e-12)
    by_unit = ss.response_spectrum_rotated(x, y, DT, T, unit="g", percentiles=found.percentile)
    assert by_unit.attrs["unit"] == "g"
    for name in (*VALUES, "larger", "geometric_mean"):
        assert np.allclose(by_unit[name], STANDARD_GRAVITY * found[name], rtol=1e-12)


def test_the_dataset_tells_units_and_sources(tmp_path: Path) -> None:
    x, y = motions(50)
    paths = []
    for name, values, factor, unit in (("x.txt", x, 1.0, "m/s^2"), ("y.txt", y, STANDARD_GRAVITY, "g")):
        paths.append(tmp_path / name)
        rows = "\n".join(f"{DT * i:.2f} {a / factor:.17g}" for i, a in enumerate(values))
        paths[-1].write_text(f"# acceleration in {unit}\n{rows}\n", encoding="utf-8")
    found = ss.response_spectrum_rotated(*paths, periods=T)
    assert found.attrs == {
        "scheme": "average_acceleration", "parameters": "", "dt": DT, "samples": 50,
        "source": f"{paths[0]} and {paths[1]}", "unit": "m/s^2 and g", "unstable": 0,
    }  # fmt: skip
    assert {name: found[name].units for name in found.variables} == {
        "displacement": "m", "pseudo_acceleration": "m s-2", "larger": "m s-2", "geometric_mean": "m s-2",
        "percentile": "percent", "period": "s", "xi": "1",
    }  # fmt: skip
    assert all("long_name" in found[name].attrs for name in found.variables)
    same = ss.response_spectrum_rotated(ss.Record(DT, x), ss.Record(DT, y), periods=T)
    assert same.source == "array"
    assert np.allclose(same.displacement, found.displacement, rtol=1e-12)
    assert ss.response_spectrum_rotated(x, y, DT).sizes["period"] == 200


def test_where_the_scheme_is_unstable_values_are_infinite() -> None:
    periods = np.array([0.5, 0.9, 1.1, 2.0]) * np.pi * DT  # the limit is T = pi dt
    found = ss.response_spectrum_rotated(*motions(), DT, periods, 0.0, "central_difference")
    assert found.unstable == 2
    for name in (*VALUES, "larger", "geometric_mean"):
        assert np.isinf(found[name][..., :2]).all()
        assert np.isfinite(found[name][..., 2:]).all()
    alone = ss.response_spectrum_rotated(*motions(), DT, periods[:2], 0.0, "central_difference")
    assert alone.unstable == 2
    assert np.isinf(alone.displacement).all()


def test_histories_are_never_whole_in_memory() -> None:
    n, periods = 20_000, np.geomspace(0.1, 5.0, 50)
    x, y = motions(n)
    ss.response_spectrum_rotated(x[:50], y[:50], DT, periods, unit="m/s^2")  # kernels are loaded
    tracemalloc.start()
    try:
        ss.response_spectrum_rotated(x, y, DT, periods)
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert most < 0.1 * 2 * 3 * 8 * n * len(periods)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"y": ss.Record(0.03, [0.0, 1.0])}, "two components of one step, got dt = 0.02 s and 0.03 s; resample one"),
        ({"y": ss.Record(DT, [0.0, 1.0])}, "one length, got 3 and 2 samples; cut the longer one, or append zeros"),
        ({"percentiles": [50, 101]}, r"expected percentiles from 0 to 100 in one row, got \[50.0, 101.0\]; give \(0"),
        ({"percentiles": [-1]}, "expected percentiles from 0 to 100"),
        ({"percentiles": []}, "expected percentiles from 0 to 100"),
        ({"percentiles": 50}, "in one row, got 50.0"),
        ({"xi": [0.02, 0.05]}, "expected one number for xi"),
        ({"xi": -0.1}, "expected xi >= 0"),
        ({"periods": -1.0}, "expected periods in one row"),
        ({"dt": 0.03}, "the record's own dt = 0.02 s, got 0.03 s"),
        ({"scheme": ss.scheme("newmark", beta=[0.25, 0.3])}, "expected one value for beta of newmark"),
    ],
)
def test_what_is_refused(change: dict[str, Any], message: str) -> None:
    record = ss.Record(DT, [0.0, 1.0, 2.0])
    with pytest.raises(ValueError, match=message):
        ss.response_spectrum_rotated(**{"x": record, "y": record, **change})


def test_a_call_that_does_not_fit_is_answered_with_one_that_does() -> None:
    with pytest.raises(TypeError, match=r"a call such as response_spectrum_rotated\(x, y, dt=0.01, xi=0.05\).*'y'"):
        ss.response_spectrum_rotated([0.0, 1.0])  # pyright: ignore
