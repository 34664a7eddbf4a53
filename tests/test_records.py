"""Records from files: two columns, .AT2 in its variants, and errors that name file and line."""

import re
from pathlib import Path

import numpy as np
import pytest

import substep as ss
from substep import read_record
from substep.core.units import LEAST, STANDARD_GRAVITY, UNITS, unit_named

VALUES = np.array([0.0, 0.1, -0.25, 3e-4, 0.02, 0.5, -0.125])
AT2 = """PEER NGA STRONG MOTION DATABASE RECORD
Made-up Valley, 1/1/2000, Nowhere Array #1, 180
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=      7, DT=   .0050 SEC,
  0.0000000E+00  1.0000000E-01 -2.5000000E-01  3.0000000E-04  2.0000000E-02
  5.0000000E-01 -1.2500000E-01
"""


def write(folder: Path, text: str, name: str = "motion.txt") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "sizes",
    [
        "NPTS=      7, DT=   .0050 SEC,", "NPTS=7, DT=.0050 SEC", "NPTS= 7, DT= 0.005", "   7   0.0050   NPTS, DT",
        "NPTS = 7 , DT = 5.0E-03 SEC",
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    "units",
    ["ACCELERATION TIME SERIES IN UNITS OF G", "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.1 LP=40"],
)
@pytest.mark.parametrize("name", ["motion.AT2", "motion.at2"])
def test_peer_files(tmp_path: Path, sizes: str, units: str, name: str) -> None:
    text = AT2.replace("NPTS=      7, DT=   .0050 SEC,", sizes)
    text = text.replace("ACCELERATION TIME SERIES IN UNITS OF G", units)
    path = write(tmp_path, text, name)
    found = read_record(path)
    assert (found.dt, found.unit, found.source) == (0.005, "g", str(path))
    assert np.array_equal(found.samples, STANDARD_GRAVITY * VALUES)


@pytest.mark.parametrize("form", ["{:.4f} {:.17g}", "{:.4f},{:.17g}", "  {:.4f}\t{:.17g}   # g"])
def test_two_columns(tmp_path: Path, form: str) -> None:
    rows = [form.format(0.5 + 0.005 * i, x) for i, x in enumerate(VALUES)]
    found = read_record(write(tmp_path, "\n".join(["# time, acceleration", "", *rows])))
    assert (found.dt, found.unit) == (0.005, "m/s^2")
    assert np.array_equal(found.samples, VALUES)


def test_times_of_few_digits_and_the_step_that_is_known_better(tmp_path: Path) -> None:
    t = np.arange(1000) / 128
    path = write(tmp_path, "\n".join(f"{time:.4f} {i % 7}" for i, time in enumerate(t)))
    assert abs(read_record(path).dt * 128 - 1) < 1e-5
    assert read_record(path, 1 / 128).dt == 1 / 128
    with pytest.raises(ValueError, match=r"motion.txt, line \d+: expected steps of the given dt = 0.0079"):
        read_record(path, 0.0079)


def test_a_spectrum_of_a_file(tmp_path: Path) -> None:
    path = write(tmp_path, AT2, "motion.AT2")
    found = ss.response_spectrum(path, periods=[0.1, 1.0])
    assert found.attrs["source"] == str(path)
    assert found.attrs["dt"] == 0.005
    same = ss.response_spectrum(str(path), 0.005, [0.1, 1.0])
    array = ss.response_spectrum(STANDARD_GRAVITY * VALUES, 0.005, [0.1, 1.0])
    assert same.equals(found)
    assert array.equals(found)
    assert (found.attrs["unit"], array.attrs["unit"]) == ("g", "m/s^2")
    in_g = ss.response_spectrum(VALUES, 0.005, [0.1, 1.0], unit="g")
    record = ss.response_spectrum(ss.Record(0.005, VALUES), periods=[0.1, 1.0], unit=STANDARD_GRAVITY)
    assert in_g.equals(found)
    assert record.equals(found)
    assert in_g.attrs["unit"] == "g"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("NPTS=      7", "NPTS=      8", r"line 4: expected NPTS = 8 samples to follow, got 7"),
        ("NPTS=", "POINTS=", "expected NPTS and DT in the first 4 lines"),
        ("UNITS OF G", "UNITS OF CM/S/S", r"line 3: expected an acceleration in units of g, got '.*CM/S/S'"),
        ("UNITS OF G", "UNITS OF G/10", "line 3: expected an acceleration in units of g"),
        ("ACCELERATION", "VELOCITY", "line 3: expected an acceleration in units of g"),
        ("ACCELERATION TIME SERIES IN UNITS OF G", "", "got no line on units"),
        ("5.0000000E-01", "5.0000000X-01", "line 6: expected numbers, got '5.0000000X-01"),
        ("5.0000000E-01", "nan", "line 6: expected finite numbers"),
        ("DT=   .0050", "DT=   .0000", "expected two samples or more and DT > 0"),
    ],
)
def test_a_peer_file_that_is_none(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = write(tmp_path, AT2.replace(old, new), "motion.AT2")
    with pytest.raises(ValueError, match=rf"motion\.AT2.*{message}"):
        read_record(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 1\n0.01 2 3\n", r"line 2: expected two columns, time and acceleration, got 3: '0.01 2 3'"),
        ("# t a\n0 1\n0.01 x\n", r"line 3: expected numbers, got '0.01 x'"),
        ("0 1\n0.01 2\n0.03 3\n0.04 1\n", r"line 2: expected equal steps, in the mean 0.0133333 s"),
        ("0 1\n0 2\n", "expected equal steps"),
        ("0.1 1\n0 2\n", "expected equal steps"),
        ("# nothing\n0 1\n", "expected at least two lines of time and acceleration, got 1"),
    ],
)
def test_two_columns_that_are_none(tmp_path: Path, text: str, message: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(ValueError, match=rf"motion\.txt.*{message}"):
        read_record(path)


def test_a_given_step_that_is_not_the_files(tmp_path: Path) -> None:
    path = write(tmp_path, AT2, "motion.AT2")
    assert read_record(path, 0.005).dt == 0.005
    with pytest.raises(ValueError, match=r"expected the given dt = 0.01 s, got DT = 0.005 s"):
        read_record(path, 0.01)
    with pytest.raises(ValueError, match="expected dt > 0"):
        read_record(path, -0.01)
    with pytest.raises(OSError, match="nowhere"):
        read_record(tmp_path / "nowhere.txt")


HEADERS = {
    "# time (s), acc (g)": "g",
    "# t, a [ g ]": "g",
    "# acceleration in g, of a station": "g",
    "# units: g": "g",
    "# time (s)  acceleration (m/s2)": "m/s^2",
    "# m/s^2": "m/s^2",
    "# a, m/sec/sec": "m/s^2",
    "# a in m s^-2": "m/s^2",
    "# cm/s/s": "cm/s^2",
    "# CM/SEC**2": "cm/s^2",
    "# Gal": "gal",
    "# gal (cm/s2)": "cm/s^2",
    "# in/s^2": "in/s^2",
    "# time (s), acc (ft/s^2)": "ft/s^2",
    "# acc (mm/s^2)": "mm/s^2",
    "# acc (inches/sec2)": "in/s^2",
    "# t, acc_cm_s2": "cm/s^2",
    "# acceleration, m per second squared": "m/s^2",
    "# time, acc_mps2": "m/s^2",
    "# acc_gal": "gal",
    "# acc (%g)": "%g",
    "# acceleration in percent of g": "%g",
    "# t (s), acc (mg)": "mg",
    "# acc, milli-g": "mg",
    "# time, a/g": "g",
    "# Acc (G) (soil class C)": "g",
    "# time acc (g's)": "g",
    "# t, Accel g": "g",
    "# velocity 300 m/s of the soil\n# time (s), acc (g)": "g",
}


@pytest.mark.parametrize("header", HEADERS)
def test_a_unit_above_the_data_is_believed_and_reported(tmp_path: Path, header: str) -> None:
    path = write(tmp_path, "\n".join([header, *(f"{0.01 * i:.2f} {x:.17g}" for i, x in enumerate(VALUES))]))
    found = read_record(path)
    unit = found.unit
    assert unit == HEADERS[header]
    np.testing.assert_allclose(found.samples, UNITS[unit] * VALUES, rtol=1e-15)
    assert read_record(path, unit=unit).unit == unit
    other = "in/s^2" if unit != "in/s^2" else "g"
    with pytest.raises(ValueError, match=rf"motion.txt: expected unit='{re.escape(unit)}', as the file says, got"):
        read_record(path, unit=other)
    with pytest.warns(UserWarning, match=rf"taken in 5 m/s\^2, as unit=5.0 says, though .* names {re.escape(unit)}$"):
        assert np.array_equal(read_record(path, unit=5.0).samples, 5.0 * VALUES)


@pytest.mark.parametrize(
    ("header", "named"),
    [
        ("# acc (counts)", "counts"), ("# t (s), ch1 (V)", "V"), ("# acc (10^-3 g)", "10^-3 g"), ("# km/s^2", "km/s^2"),
        ("# acc (µm/s2)", "µm/s2"), ("# units: volts", "volts"), ("# t, acc_g", "acc_g"), ("# time, a_g", "a_g"),
    ],
)  # fmt: skip
def test_a_unit_that_is_not_known_is_asked_for(tmp_path: Path, header: str, named: str) -> None:
    path = write(tmp_path, f"{header}\n0 0.1\n0.01 0.2\n")
    with pytest.raises(ValueError, match=rf"expected a unit of accel.*, got '{re.escape(named)}'; give unit=, one of"):
        read_record(path)
    assert read_record(path, unit="g").unit == "g"
    assert read_record(path, unit=0.5).samples.tolist() == [0.05, 0.1]


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("# time (s), displacement (m)", "expected accelerations, got '# time"),
        ("# t, vel (cm/s)", "expected accelerations, got '# t"),
        ("time (s);Velocity", "expected accelerations, got 'time"),
        ("# time (ms), acc (g)", "expected times in s, got '# time"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*skipped as a header")
def test_columns_of_something_else_are_refused(tmp_path: Path, header: str, message: str) -> None:
    path = write(tmp_path, f"{header}\n0;0.1\n0.01;0.2\n")
    for unit in (None, "m/s^2"):
        with pytest.raises(ValueError, match=rf"motion\.txt: {message}"):
            read_record(path, unit=unit)
    assert read_record(path, unit=1.0).samples.tolist() == [0.1, 0.2]


@pytest.mark.parametrize(
    "text", ["# time, acceleration", "# g-force of a gale", "# file of m/s", "# soil class (G)", "# 10 g/10", ""]
)
def test_what_names_no_unit(text: str) -> None:
    assert unit_named(text) is None


def test_a_unit_is_never_guessed(tmp_path: Path) -> None:
    """Accelerations in cm/s^2, or in g of a small tremor, were read as m/s^2 without a word."""
    rows = [f"{0.01 * i:.2f} {{:.6g}}" for i in range(7)]
    for scale in (300.0, 0.1 * LEAST):
        path = write(tmp_path, "\n".join(row.format(scale * x) for row, x in zip(rows, VALUES, strict=True)))
        with pytest.raises(
            ValueError, match=r"motion.txt: expected the unit .* g in m/s\^2, .* g in g, .* g in cm/s\^2"
        ):
            read_record(path)
        found = read_record(path, unit="cm/s2")
        assert found.unit == "cm/s^2"
        np.testing.assert_allclose(found.samples, 0.01 * scale * VALUES, rtol=1e-5)
        np.testing.assert_allclose(read_record(path, unit=0.0254).samples, 0.0254 * scale * VALUES, rtol=1e-5)
    two = write(tmp_path, "# g: cm/s2 (g)\n0 1\n0.01 2\n")
    with pytest.raises(ValueError, match=r"motion.txt: expected one unit of acceleration, got cm/s\^2 and g"):
        read_record(two)
    for wrong in ("yd/s2", "", -1.0):
        with pytest.raises(ValueError, match="unit"):
            read_record(path, unit=wrong)
    assert not read_record(write(tmp_path, "0 0\n0.01 0\n")).samples.any()


def test_a_record_has_its_unit_and_source(tmp_path: Path) -> None:
    """Values are converted once, whoever takes the record; another unit than its own is refused."""
    t = 0.01 * np.arange(400)
    a = np.sin(7.0 * t) * np.exp(-t)
    given = ss.Record(0.01, a, unit="cm/s2", source="by hand")
    assert repr(given) == "Record(dt=0.01, 400 samples, unit='cm/s^2', source='by hand')"
    assert np.array_equal(given.samples, a * UNITS["cm/s^2"])
    assert given == ss.Record(0.01, given.samples) == ss.Record(0.01, a, unit=0.01)
    expected = ss.response_spectrum(given.samples, dt=0.01, periods=[0.5])
    for found in (
        ss.response_spectrum(given, periods=[0.5]),
        ss.response_spectrum(given, periods=[0.5], unit="gal"),
        ss.response_spectrum(a, dt=0.01, periods=[0.5], unit="cm/s^2"),
        ss.response_spectrum(ss.Record(0.01, a), periods=[0.5], unit="cm/s^2"),
    ):
        assert found.displacement.item() == expected.displacement.item()
    assert ss.response_spectrum(given, periods=[0.5]).attrs["source"] == "by hand"
    with pytest.raises(ValueError, match=r"expected unit='cm/s\^2', as the record says, got 'g'; leave it out"):
        ss.response_spectrum(given, periods=[0.5], unit="g")
    path = write(tmp_path, "# t, a in g\n0 0\n0.01 0.1\n")
    assert ss.read_record(path) == ss.Record(0.01, [0.0, 0.1 * STANDARD_GRAVITY])
    for wrong in ("yd/s2", -1.0):
        with pytest.raises(ValueError, match="expected unit"):
            ss.Record(0.01, a, unit=wrong)


def test_the_ground_of_a_structure_is_checked_as_that_of_a_spectrum() -> None:
    """981 for 1 g moved the ground by metres, and a step of 10 ms was one of 10 s."""
    s = ss.structure([[1.0]], [[100.0]])
    for dt, scale, message in ((0.01, 300.0, "expected the unit of accelerations, got none"), (10.0, 1.0, "10 ms are")):
        with pytest.raises(ValueError, match=message):
            s.ground_motion(ss.Record(dt, scale * VALUES), 1.0)
        with pytest.raises(ValueError, match=message):
            ss.response_spectrum(ss.Record(dt, scale * VALUES))
        assert len(s.ground_motion(ss.Record(dt, scale * VALUES, unit="m/s^2"), 1.0).motions) == 1
