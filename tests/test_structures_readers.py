"""Matrices written by SciPy, by hand and by pyyeti are read as they were."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scipy import io, sparse

from substep.structures import readers
from substep.structures.examples import frame
from substep.structures.readers import read_matrix


@pytest.mark.parametrize("ending", [".mtx", ".mtx.gz", ".hb"])
def test_what_scipy_writes_is_read(ending: str, tmp_path: Path) -> None:
    K = frame(1, 1).K
    path = tmp_path / f"stiffness{ending}"
    if ending == ".hb":
        io.hb_write(path, sparse.csc_array(K))
    elif ending.endswith(".gz"):
        import gzip

        io.mmwrite(tmp_path / "plain.mtx", K, precision=17)
        path.write_bytes(gzip.compress((tmp_path / "plain.mtx").read_bytes()))
    else:
        io.mmwrite(path, K, precision=17)
    assert abs(read_matrix(path) - K).max() <= 1e-15 * abs(K).max()


@pytest.mark.parametrize("code", ["RSA", "rsa"])
def test_a_symmetric_harwell_boeing_matrix_is_read(code: str, tmp_path: Path) -> None:
    """Of which the lower triangle is stored; other kinds are refused by their code."""
    K, path = frame(1, 1).K, tmp_path / "stiffness.rsa"
    io.hb_write(path, sparse.csc_array(sparse.tril(K)))
    text = path.read_text(encoding="ascii")
    assert text.count("RUA") == 1
    path.write_text(text.replace("RUA", code), encoding="ascii")
    assert abs(read_matrix(path) - K).max() <= 1e-15 * abs(K).max()
    path.write_text(text.replace("RUA", "RZA"), encoding="ascii")
    with pytest.raises(
        ValueError,
        match="real assembled Harwell-Boeing matrix in stiffness.rsa, got: a matrix of kind RZA with .*Matrix Market",
    ):
        read_matrix(path)


@pytest.mark.parametrize("sides", [0, 1])
@pytest.mark.parametrize(
    ("form", "power"),
    [("(3E20.13)", "E"), ("(3D20.13)", "D"), ("(1P,3D20.13)", "D"), ("(1p3e20.13)", "e"), ("(3E20.13E2)", "E")],
)
def test_what_ansys_writes_is_read(form: str, power: str, sides: int, tmp_path: Path) -> None:
    """By HBMAT: fields without blanks between them, a right-hand side, a name that says nothing."""
    values = "".join(f"{x:20.13E}".replace("E", power) for x in (-4.0, -1.0, -3.0))
    assert " " not in values
    counts = (3 + sides, 1, 1, 1, sides)
    lines = [
        "stiffness".ljust(72) + "key".ljust(8), "".join(f"{x:14d}" for x in counts),
        "RSA".ljust(14) + "".join(f"{x:14d}" for x in (2, 2, 3, 0)),
        "(3I1)".ljust(16) + "(3I8)".ljust(16) + form.ljust(20) + form.ljust(20),
        *["F".ljust(14) + f"{1:14d}{0:14d}"] * sides, "134", f"{1:8d}{2:8d}{2:8d}", values,
        *[f"{1.0:20.13E}{2.0:20.13E}"] * sides,
    ]  # fmt: skip
    for name in ("job.matrix", "job.rsa"):
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
        assert read_matrix(path).toarray().tolist() == [[-4.0, -1.0], [-1.0, -3.0]]
    for place, text, message in (
        (3, "(3I1)".ljust(16) + "(3I8)".ljust(16) + "(3X20)".ljust(20), r"the format \(3X20\)"),
        (3, "(3I1)".ljust(16) + "(3I8)".ljust(16) + "(1P3F20.13)".ljust(20), r"the format \(1P3F20.13\)"),
        (-1 - sides, "1.0", "1 numbers in place of 3"),
        (-3 - sides, "149", "starts of columns that do not ascend from 1 to 4"),
        (-3 - sides, "914", "starts"),
        (-2 - sides, f"{1:8d}{2:8d}{3:8d}", "rows that are not from 1 to 2"),
        (-2 - sides, f"{1:8d}{0:8d}{2:8d}", "rows that are not from 1 to 2"),
        (2, "RSA".ljust(14) + "".join(f"{x:14d}" for x in (3, 2, 3, 0)), "kind RSA with 3 rows and 2 columns"),
        (1, "", ""),
    ):
        path.write_text(
            "\n".join(text if i == place % len(lines) else x for i, x in enumerate(lines)), encoding="ascii"
        )
        with pytest.raises(ValueError, match=f"Harwell-Boeing matrix in job.rsa, got: .*{message}"):
            read_matrix(path)


@pytest.mark.parametrize("number", ["-1.5000000000000-101", " 0.1500000000000+102", "1.5000000000000D-101"])
def test_powers_of_three_digits_are_read(number: str, tmp_path: Path) -> None:
    """For which Fortran's fields have no letter left; the format may begin with a blank."""
    path = tmp_path / "job.matrix"
    head = ["title".ljust(72) + "key".ljust(8), f"{3:14d}{1:14d}{1:14d}{1:14d}"]
    kind = "RUA".ljust(14) + f"{1:14d}{1:14d}{1:14d}{0:14d}"
    lines = [
        *head,
        kind,
        " (2I8)".ljust(16) + "(1I8)".ljust(16) + "(1G20.13)".ljust(20),
        f"{1:8d}{2:8d}",
        f"{1:8d}",
        number,
    ]
    path.write_text("\n".join(lines), encoding="ascii")
    expected = {"-": -1.5e-101, " ": 1.5e101, "1": 1.5e-101}[number[0]]
    assert read_matrix(path).toarray().tolist() == [[pytest.approx(expected, rel=1e-14)]]


def test_the_size_may_be_said_of_text_that_does_not_say_it(tmp_path: Path) -> None:
    """The last degree of freedom has no mass."""
    path = tmp_path / "job_MASS1.mtx"
    path.write_text("1 1 2.0\n2 2 3.0\n", encoding="utf-8")
    assert read_matrix(path).shape == (2, 2)
    assert read_matrix(path, size=3).toarray().tolist() == np.diag([2.0, 3.0, 0.0]).tolist()
    with pytest.raises(ValueError, match=r"a matrix of 1 x 1 in job_MASS1.mtx, got shape \(2, 2\)"):
        read_matrix(path, size=1)


@pytest.mark.parametrize("part", ["whole", "lower", "upper"])
def test_coordinate_text_is_read(part: str, tmp_path: Path) -> None:
    """As Abaqus writes it: whole matrices as they are, triangles as half of a symmetric matrix."""
    K = frame(1, 1).K
    if part == "whole":
        K = sparse.csr_array(K + sparse.csr_array(([1.0], ([0], [1])), shape=K.shape) * K.max())
    half = {"whole": K, "lower": sparse.tril(K), "upper": sparse.triu(K)}[part].tocoo()
    lines = [f"{i + 1} {j + 1}  {x:.16e}" for i, j, x in zip(*half.coords, half.data, strict=True)]
    path = tmp_path / "job_STIF1.mtx"
    path.write_text("\n".join(["** written by hand", *lines, ""]), encoding="utf-8")
    assert abs(read_matrix(path) - K).max() == 0.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 1 2.0\n1 2\n", "line 2"),
        ("0 1 2.0\n", "counted from 1"),
        ("1 1 x\n", "line 1"),
        ("** nothing\n", "got none"),
    ],
)
def test_other_text_is_refused_with_its_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "matrix.txt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_matrix(path)


def test_op4_needs_pyyeti(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(readers, "find_spec", lambda _: None)
    with pytest.raises(ValueError, match="pip install pyyeti"):
        read_matrix(tmp_path / "model.op4")


@pytest.mark.skipif(not find_spec("pyyeti"), reason="pyyeti, of the extra bench, is not installed")
def test_op4_is_read(tmp_path: Path) -> None:
    printed = np.get_printoptions()
    with np.printoptions():  # which pyyeti changes when it is imported
        from pyyeti.nastran import op4  # pyright: ignore[reportMissingImports]
    model, path = frame(1, 1), tmp_path / "model.op4"
    op4.write(str(path), {"mgg": model.M.toarray(), "kgg": model.K.toarray()})
    assert abs(read_matrix(path, name="KGG") - model.K).max() <= 1e-15 * abs(model.K).max()
    with pytest.raises(ValueError, match="mgg, kgg"):
        read_matrix(path)
    assert np.get_printoptions() == printed


def test_reading_op4_leaves_the_print_options_alone(tmp_path: Path) -> None:
    """In a process of its own, where the reader is the first to import pyyeti."""
    script = """
import numpy as np
from substep.structures.readers import read_matrix
before = np.get_printoptions()
try:
    read_matrix("none.op4")
except OSError:
    pass
assert np.get_printoptions() == before
"""
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
