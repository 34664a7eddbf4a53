"""Records in the formats that people have: each comes back as it was written, and is refused where it is unclear."""

import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from typer.testing import CliRunner

import substep as ss
from substep import read_record
from substep.cli.commands import app
from substep.core.units import STANDARD_GRAVITY

DT = 0.005
VALUES = [0.0, 0.1, -0.25, 3e-4, 0.02, 0.5, -0.125]
PEER = """PEER NGA STRONG MOTION DATABASE RECORD
Made-up Valley, 1/1/2000, Nowhere Array #1, 180
ACCELERATION TIME SERIES IN UNITS OF G
NPTS= {n}, DT= {dt} SEC,
"""
ESM = """EVENT_NAME: MADE_UP_VALLEY
STATION_CODE: NWH
VS30_M/S: 670
SAMPLING_INTERVAL_S: {dt}
NDATA: {n}
STREAM: HNE
UNITS: cm/s^2
FULL_SCALE_G:
PGA_CM/S^2: 0.5
DATABASE_VERSION: 0.5
HEADER_FORMAT: DYNA 1.2
DATA_TYPE: ACCELERATION
PROCESSING: manual (by hand, 2000)
"""
KNET = """Origin Time       2000/01/01 00:00:00
Dir.              E-W
Scale Factor      2000(gal)/8388608
Max. Acc. (gal)   25.0
Memo.
    1000    1010     990
"""


def write(folder: Path, text: str | bytes, name: str = "motion.txt") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def two_columns(values: Sequence[float], separator: str, comma: bool = False) -> str:
    rows = [f"{DT * k:.3f}{separator}{value!r}" for k, value in enumerate(values)]
    return "\n".join(row.replace(".", ",") if comma else row for row in rows)


def in_rows(values: Sequence[float], width: int) -> str:
    texts = [repr(value) for value in values]
    return "\n".join("  ".join(texts[k : k + width]) for k in range(0, len(texts), width))


# the text of values, and whether dt is to be given
FORMATS: dict[str, tuple[Callable[[Sequence[float]], str], bool]] = {
    "blanks": (lambda x: two_columns(x, "  "), False),
    "tabs": (lambda x: two_columns(x, "\t"), False),
    "commas": (lambda x: two_columns(x, ", "), False),
    "semicolons": (lambda x: two_columns(x, ";"), False),
    "semicolons, decimal commas": (lambda x: two_columns(x, ";", comma=True), False),
    "tabs, decimal commas": (lambda x: two_columns(x, "\t", comma=True), False),
    "a semicolon at the end": (lambda x: two_columns(x, ";").replace("\n", ";\n") + ";", False),
    "columns with dt": (lambda x: two_columns(x, "  "), True),
    "one column": (lambda x: in_rows(x, 1), True),
    "one column, decimal commas": (lambda x: in_rows(x, 1).replace("\n", ";\n").replace(".", ",") + ";", True),
    "OpenSees": (lambda x: in_rows(x, 5), True),
    "PEER": (lambda x: PEER.format(n=len(x), dt=DT) + in_rows(x, 5), False),
    "ESM": (lambda x: ESM.format(n=len(x), dt=DT) + in_rows(x, 1), False),
}
FACTORS = {"PEER": STANDARD_GRAVITY, "ESM": 0.01}


@given(st.lists(st.floats(-30.0, 30.0), min_size=2, max_size=40))
@example(VALUES)
@example([0.0, 0.0, 0.0, 1e-300, -1e-5, 12345.678, 0.0])
@example([-10.0, 0.0, 0.0, 0.0, 0.0, -5.0, 0.0, 0.0, 0.0, 0.0, 0.0])  # as times in rows of five
def test_a_record_comes_back_from_every_format(tmp_path_factory: pytest.TempPathFactory, values: list[float]) -> None:
    assume(values[0] != DT and (values[0] != len(values) - 1 or len(values) < 12))  # not refused as no sample
    folder = tmp_path_factory.mktemp("records")
    steps = np.diff(values[::5])
    whole_rows_of_times = len(values) % 5 == 0 and len(steps) > 1 and np.allclose(steps, abs(steps[0]))
    for name, (text, alone) in FORMATS.items():
        if name == "OpenSees" and whole_rows_of_times:  # refused, since it may be five columns
            continue
        path = write(folder, text(values))
        found = read_record(path, DT if alone else None, unit=None if name in FACTORS else "m/s^2")
        assert np.array_equal(found.samples, FACTORS.get(name, 1.0) * np.array(values)), name
        assert (found.dt, found.source) == (DT, str(path)), name


def test_the_mark_of_utf_8_is_no_header(tmp_path: Path) -> None:
    assert np.array_equal(read_record(write(tmp_path, two_columns(VALUES, ";").encode("utf-8-sig"))).samples, VALUES)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize(
    ("header", "lines"),
    [("Zeit (s);Beschl. (cm/s²)", "line 1"), ("Nowhere Array, 180°\n# of 2000\n\nt;a; cm/s²", "lines 1 to 4")],
)
def test_a_header_is_skipped_with_a_warning_and_its_unit_believed(
    tmp_path: Path, encoding: str, header: str, lines: str
) -> None:
    path = write(tmp_path, f"{header}\n{two_columns(VALUES, ';', comma=True)}\n".encode(encoding), "motion.csv")
    with pytest.warns(UserWarning, match=rf"motion\.csv: skipped as a header: {lines}; put '#' before"):
        found = read_record(path)
    assert found.unit == "cm/s^2"
    np.testing.assert_allclose(found.samples, 0.01 * np.array(VALUES), rtol=1e-15)
    for wrong, cure in (("nan", "expected finite numbers"), ("", "expected two columns"), ("end", "expected numbers")):
        write(tmp_path, f"{header}\n0;0\n0,01;{wrong}\n".encode(encoding), "motion.csv")
        with pytest.raises(ValueError, match=rf"line \d: {cure}.*; skipped as a header: {lines}$"):
            read_record(path)


@pytest.mark.parametrize(
    ("text", "dt", "message"),
    [
        # lines that are no data
        ("t a\n0 1\nt a\n0.01 2\n", None, r"line 3: expected numbers, got 't a'; correct it, or put '#'"),
        ("0 1\n0.01 2\nend of the record\n", None, "line 3: expected numbers, got 'end of the record'"),
        ("0 x\n0.01 1\n0.02 2\n", None, "line 1: expected numbers, got '0 x'"),
        ("t a\nm s\n", None, "line 1: expected numbers below a header, got none below 't a'"),
        ("", None, "expected at least two lines of time and acceleration, got 0"),
        # gaps
        ("0;1\n0,01;\n0,02;3\n", None, "line 2: expected two columns.* got 1: '0,01;'"),
        ("0;1\n0,01;;\n0,02;3\n", None, "line 2: expected numbers, got '0,01;;'"),
        ("0,1\n0.01,,2\n", None, "line 2: expected numbers, got '0.01,,2'"),
        ("0 1\n0.01 nan\n0.02 2\n", None, "line 2: expected finite numbers"),
        ("0.1\n\n0.2\n", 0.01, "line 2: expected a number, got an empty line; fill it, or delete it"),
        ("0.1\nNaN\n0.2\n", 0.01, "line 2: expected finite numbers, got 'NaN'"),
        # decimal commas
        ("0.01;1,234\n", None, "line 1: expected numbers below a header"),
        ("0,01 0,1\n0,02 0,2\n", None, "line 1: expected two columns.* got 4.*separate decimal commas by ';'"),
        ("0.01\t0,1\n0.02\t0,2\n", None, r"line 1: expected two columns.* got 3: '0.01\t0,1'"),
        ("0,12\n0,05\n0,31\n", 0.01, "line 1: expected one acceleration a line.* 2 columns: '0,12'.* decimal points"),
        # times
        ("0 1\n0.01 2\n0.01 3\n", None, "line 3: expected equal steps.*got t = 0.01 s after 0.01 s; .*delete the line"),
        ("0 1\n0.02 2\n0.01 3\n0.03 1\n", None, "line 3: expected equal steps.*got t = 0.01 s after 0.02 s"),
        ("0 1\n0.01 2\n0.04 3\n", None, r"in the mean 0.02 s.*interpolate by resample=, a step"),
        ("0 1\n0.01 2\n0.04 3\n0.05 1\n", 0.01, "line 3: expected steps of the given dt = 0.01 s"),
        ("0 1\n0.01 2\n0.02\n", 0.01, "line 3: expected two columns.* got 1: '0.02'"),
        # accelerations alone
        ("0.1\n0.2\n", None, "line 1: expected two columns.* got 1: '0.1'; .* give dt for accelerations alone"),
        ("0.1 0.3 0.2\n", None, "line 1: expected two columns.* got 3.* give dt for accelerations alone"),
        ("0.1 0.3 0.2\n0.1\n0.1 0.2 0.3\n", 0.01, "line 2: expected 3 a line as above, got 1: '0.1'"),
        ("0.1 0.3\n0.1 0.2 0.3\n", 0.01, "line 2: expected 2 a line as above, got 3"),
        ("0.1\n", 0.01, "expected at least two numbers, got 1"),
        ("# g\n0.01\n0.1\n0.2\n", 0.01, "line 2: expected accelerations, got 0.01 first, which is dt; put '#' before"),
        ("12\n" + 6 * "0.1\n0.2\n", 0.01, "line 1: .* got 12 first, which is the number of those that follow; put"),
        ("0.1\n-999\n0.2\n", 0.01, "expected accelerations, got -999 as number 2 of them, which is likely"),
        # missing lines
        ("0 1\n1 1\n2 1\n3 1\n4 1\n7 1\n8 1\n", None, "line 6: expected steps of 1 s, .* got t = 7 s after 4 s"),
        # components
        ("0,1,2\n0.01,3,4\n0.02,0,1\n", 0.01, "line 1: expected two columns.* got 3: '0,1,2'.* choose two"),
        ("0.1,0.2,0.3\n-0.1,0.3,0.4\n0.2,0.1,0.1\n", 0.01, "line 1: expected one acceleration a line.* 3 columns"),
    ],
)  # fmt: skip
def test_text_that_is_unclear(tmp_path: Path, text: str, dt: float | None, message: str) -> None:
    with pytest.raises(ValueError, match=rf"motion\.txt.*{message}"):
        read_record(write(tmp_path, text), dt, unit="m/s^2")


@pytest.mark.parametrize("width", [2, 3])
def test_rows_that_may_be_components_are_read_with_a_warning(tmp_path: Path, width: int) -> None:
    path = write(tmp_path, in_rows(VALUES, width))
    with pytest.warns(UserWarning, match=f"read 7 accelerations row by row, {width} a line; if these are components"):
        assert np.array_equal(read_record(path, DT).samples, VALUES)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("NDATA: 7", "NDATA: 8", "line 5: expected NDATA = 8 samples to follow, got 7"),
        ("NDATA: 7", "NDATA: many", "line 5: expected NDATA in the header of ESM, got many"),
        ("NDATA: 7\n", "", "expected NDATA in the header of ESM, got none"),
        ("DATA_TYPE: ACCELERATION", "DATA_TYPE: VELOCITY", "line 12: .*ACCELERATION, got VELOCITY; take ESM's"),
        ("UNITS: cm/s^2", "UNITS: cm/s", "line 7: expected UNITS in the header of ESM, got cm/s"),
        ("_S: 0.005", "_S: 0", r"line 4: expected two samples or more and SAMPLING_INTERVAL_S > 0, got 7 and 0"),
        ("-0.25", "-0.25x", "line 16: expected numbers, got '-0.25x'"),
        ("-0.25", "nan", "line 16: expected finite numbers"),
    ],
)  # fmt: skip
def test_a_file_of_esm_that_is_none(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = ESM.format(n=7, dt=DT) + in_rows(VALUES, 1)
    assert old in text
    with pytest.raises(ValueError, match=rf"motion\.asc.*{message}"):
        read_record(write(tmp_path, text.replace(old, new), "motion.asc"))


def test_a_header_is_believed_rather_than_what_is_given(tmp_path: Path) -> None:
    esm = write(tmp_path, ESM.format(n=7, dt=DT) + in_rows(VALUES, 1), "motion.asc")
    peer = write(tmp_path, PEER.format(n=7, dt=DT) + in_rows(VALUES, 5), "motion.txt")
    for path, key, unit in ((esm, "SAMPLING_INTERVAL_S", "cm/s^2"), (peer, "DT", "g")):
        assert read_record(path, DT, unit).unit == unit
        with pytest.raises(ValueError, match=rf"line 4: expected the given dt = 0.01 s, got {key} = 0.005 s; leave"):
            read_record(path, 0.01)
        with pytest.raises(ValueError, match=f"expected unit='{re.escape(unit)}', as the file says, got 'in/s"):
            read_record(path, unit="in/s^2")


@pytest.mark.filterwarnings("ignore:.*bridged linearly")
@given(
    st.lists(st.floats(0.001, 0.1), min_size=1, max_size=20), st.floats(-5.0, 5.0), st.floats(0.001, 0.05),
)  # fmt: skip
def test_resampled_records(
    tmp_path_factory: pytest.TempPathFactory, steps: list[float], start: float, step: float
) -> None:
    """What is linear in time comes back exactly, from unequal steps and wherever the times start."""
    t = start + np.cumsum([0.0, *steps])
    path = write(tmp_path_factory.mktemp("records"), "\n".join(f"{x!r} {2.0 * (x - start)!r}" for x in t.tolist()))
    duration = float(t[-1] - t[0])
    assume(abs(duration - step) > 1e-6 * step)
    if duration < step:
        with pytest.raises(ValueError, match="expected resample of at most the record's"):
            read_record(path, unit="m/s^2", resample=step)
        return
    found = read_record(path, unit="m/s^2", resample=step)
    assert found.dt == step
    assert -1e-6 * step <= duration - step * (len(found.samples) - 1) < step
    np.testing.assert_allclose(found.samples, 2.0 * step * np.arange(len(found.samples)), rtol=1e-8, atol=1e-12)


def test_every_format_is_resampled_within_the_error_of_interpolation(tmp_path: Path) -> None:
    t = DT * np.arange(401)
    values = np.sin(2.0 * np.pi * t)
    for name, (text, alone) in FORMATS.items():
        path = write(tmp_path, text(values.tolist()))
        unit, factor = None if name in FACTORS else "m/s^2", FACTORS.get(name, 1.0)
        found = read_record(path, DT if alone else None, unit, resample=0.002)
        assert (found.dt, len(found.samples)) == (0.002, 1001), name
        error = np.abs(found.samples / factor - np.sin(2.0 * np.pi * 0.002 * np.arange(1001))).max()
        assert 0.5 < error / (DT**2 * (2.0 * np.pi) ** 2 / 8.0) <= 1.0, name
        assert found.source == f"{path}, resampled with an error of {error:.1%} of the peak", name
        coarser = read_record(path, DT if alone else None, unit, resample=0.01)
        assert coarser.source.endswith("with an error of 0.0% of the peak"), name
        np.testing.assert_allclose(coarser.samples, factor * values[::2], atol=1e-12)
    path = write(tmp_path, "0 1\n0.01 2\n0.02 3\n0.02 4\n")
    with pytest.raises(
        ValueError, match=r"line 4: expected equal steps, or with resample= ascending times, got t = 0.02"
    ):
        read_record(path, resample=0.01)
    path = write(tmp_path, "".join(f"{0.01 * k:.2f} {k}\n" for k in range(12) if k not in (5, 6, 9)))
    with pytest.warns(UserWarning, match=r"line 6: .* 0.01 s, .* got t = 0.07 s after 0.04 s; gaps in all: 2, bridged"):
        assert np.allclose(read_record(path, resample=0.01).samples, np.arange(12.0))
    path = write(tmp_path, "0 1\n0.01 2\n0.04 3\n")
    assert read_record(path, resample=0.01).samples.tolist() == pytest.approx([1.0, 2.0, 7 / 3, 8 / 3, 3.0])
    with pytest.raises(ValueError, match=r"line 3: expected steps of the given dt = 0.01 s"):
        read_record(path, 0.01, resample=0.01)
    with pytest.raises(ValueError, match="expected resample > 0"):
        read_record(path, resample=0.0)


def trace(name: str, data: Sequence[float], form: str, calib: float = 1.0) -> SimpleNamespace:
    stats = SimpleNamespace(delta=0.01, calib=calib, _format=form)
    return SimpleNamespace(id=name, stats=stats, data=np.array(data))


@pytest.fixture
def traces(monkeypatch: pytest.MonkeyPatch) -> list[SimpleNamespace]:
    """What a stand-in of ObsPy reads, whatever the file."""
    found: list[SimpleNamespace] = []

    class StandIn(ModuleType):
        @staticmethod
        def read(path: str) -> list[SimpleNamespace]:
            if not found:
                raise TypeError(f"Unknown format for file {path}")
            return found

    monkeypatch.setitem(sys.modules, "obspy", StandIn("obspy"))
    return found


@pytest.mark.parametrize("name", ["NWH.EW", "NWH.ns1", "NWH.UD2", "motion.txt"])
def test_knet_by_obspy(tmp_path: Path, traces: list[SimpleNamespace], name: str) -> None:
    path = write(tmp_path, KNET, name)
    traces.append(trace("BO.NWH..EW", [1000, 1010, 990], "KNET", 0.01 * 2000 / 8388608))
    found = read_record(path)
    assert (found.dt, found.unit, found.source) == (0.01, "m/s^2", str(path))
    np.testing.assert_allclose(found.samples, np.array([1000, 1010, 990]) * 20.0 / 8388608, rtol=1e-15)
    with pytest.raises(ValueError, match=r"expected unit='m/s\^2', as the file says, got 'gal'"):
        read_record(path, unit="gal")


@pytest.mark.parametrize("suffix", [".sac", ".mseed", ".GSE"])
def test_samples_by_obspy_need_a_unit(tmp_path: Path, traces: list[SimpleNamespace], suffix: str) -> None:
    path = write(tmp_path, b"\x00\xe4@\xc6\x00", f"motion{suffix}")
    with pytest.raises(
        ValueError, match="expected a format that ObsPy reads, got: Unknown format .*convert it to text"
    ):
        read_record(path)
    traces.append(trace("XX.A..HNE", VALUES, "SAC", 3.0))
    with pytest.raises(ValueError, match=r"expected the unit of its samples.* give unit="):
        read_record(path)
    found = read_record(path, unit="g", resample=0.005)
    assert (found.dt, found.unit) == (0.005, "g")
    np.testing.assert_allclose(found.samples[::2], STANDARD_GRAVITY * np.array(VALUES), rtol=1e-14)
    with pytest.raises(ValueError, match=r"expected the given dt = 0.02 s, got delta = 0.01 s; leave dt out"):
        read_record(path, 0.02, "g")
    traces.append(trace("XX.A..HNN", VALUES, "SAC"))
    with pytest.raises(
        ValueError, match=r"expected one trace, got 2: XX.A..HNE, XX.A..HNN; choose one, as substep.Record"
    ):
        read_record(path, unit="g")


@pytest.mark.parametrize("name", ["CHAN001.V2", "motion.v1"])
def test_what_obspy_does_not_read_either(tmp_path: Path, name: str) -> None:
    path = write(tmp_path, "CORRECTED ACCELEROGRAM\n  1  2\n", name)
    with pytest.raises(ValueError, match=rf"{name}: expected a format that is read, got CSMIP's .*; write its accel"):
        read_record(path)


def test_obspy_is_needed_for_seismic_formats_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "obspy", None)
    with pytest.raises(ImportError, match=r"expected obspy for .*NWH.EW.*pip install 'substep\[seismic\]'"):
        read_record(write(tmp_path, KNET, "NWH.EW"))
    assert ss.response_spectrum(write(tmp_path, in_rows(VALUES, 5), "x.ns"), DT, [0.1]).attrs["samples"] == 7


def test_the_command_takes_accelerations_alone_and_says_that_obspy_is_needed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "obspy", None)
    alone, seismic = write(tmp_path, in_rows(VALUES, 5)), write(tmp_path, KNET, "NWH.EW")
    done = CliRunner().invoke(app, ["spectrum", str(alone), "--dt", "0.005", "--periods", "0.1"])
    assert (done.exit_code, "7 samples, dt = 0.005 s" in done.output) == (0, True)
    for path, cure in ((alone, "give dt for accelerations alone"), (seismic, "pip install 'substep[seismic]'")):
        result = CliRunner().invoke(app, ["spectrum", str(path)], env={"COLUMNS": "400"})
        assert (result.exit_code, cure in result.output) == (2, True)
