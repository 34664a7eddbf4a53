"""Records from files: two columns, .AT2 in its variants, and errors that name file and line."""

from pathlib import Path

import numpy as np
import pytest

import substep as ss
from substep.ground_motion.records import STANDARD_GRAVITY, read_record

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
    dt, values = read_record(write(tmp_path, text, name))
    assert dt == 0.005
    assert np.array_equal(values, STANDARD_GRAVITY * VALUES)


@pytest.mark.parametrize("form", ["{:.4f} {:.17g}", "{:.4f},{:.17g}", "  {:.4f}\t{:.17g}   # g"])
def test_two_columns(tmp_path: Path, form: str) -> None:
    rows = [form.format(0.5 + 0.005 * i, x) for i, x in enumerate(VALUES)]
    dt, values = read_record(write(tmp_path, "\n".join(["# time, acceleration", "", *rows])))
    assert dt == 0.005
    assert np.array_equal(values, VALUES)


def test_times_of_few_digits_and_the_step_that_is_known_better(tmp_path: Path) -> None:
    t = np.arange(1000) / 128
    path = write(tmp_path, "\n".join(f"{time:.4f} {i}" for i, time in enumerate(t)))
    assert abs(read_record(path)[0] * 128 - 1) < 1e-5
    assert read_record(path, 1 / 128)[0] == 1 / 128
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
    assert read_record(path, 0.005)[0] == 0.005
    with pytest.raises(ValueError, match=r"expected the given dt = 0.01 s, got DT = 0.005 s"):
        read_record(path, 0.01)
    with pytest.raises(ValueError, match="expected dt > 0"):
        read_record(path, -0.01)
    with pytest.raises(OSError, match="nowhere"):
        read_record(tmp_path / "nowhere.txt")
